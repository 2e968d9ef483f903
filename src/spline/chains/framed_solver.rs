//! Splines through knots with frames from that of flat space: by legs in the embedding or by series, whichever is quicker.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::chain::Chain;
use super::embedded::InEmbedding;
use super::flat_spline::flat_spline;
use super::framed::{Framed, coordinates};
use super::motion::Motion;
use super::solution::{ChainSolution, Effort, SolvedLegs};
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::lazy_taylor::LazyTaylor;
use crate::cubic::taylor::leg_curve::leg_curve;
use crate::error::Result;
use crate::legs::{Curves, Knots};
use crate::linalg::lanes::Lanes;
use crate::shooting;
use crate::space::{Homogeneous, Kind, ScalarField, in_space};
use crate::spline::ends::{Ends, gives_velocity};

/// Largest rotation of a leg, in radians, for which series are used, if velocities at the ends are
/// given and if they are not; faster starts are left to descents. With 6 for given end
/// velocities, of 128 splines with end velocities of 10 and more 15 cost two to four times as much and 5 are not
/// solved. With 5 for both, three of eight splines through 400 rotations up to 1.2 rad apart at uneven times take
/// thirty times as long; values of 7 to 20 are alike.
const FAST: f64 = 3.0;
const FAST_WITH_FREE_ENDS: f64 = 12.0;

/// Legs in the embedding come before series where `d^3` is more than this multiple of `r k^2`, the ratio of the work of
/// both, for `d` coordinates and points of shape `(r, k)`; complex points count as real ones of twice the size.
/// Relative to series, splines through 60 points 0.3 apart, with five points on each leg, take 12 times as long on
/// St(3,2), with a ratio of 2, 1.7 times on St(7,6) (37), 1.2 on St(8,2) (69), 1.1 on St(8,3) (81), 0.8 on St(9,3)
/// (114), 0.5 on St(12,1) and St(12,2) (111 and 193), 0.8 on Gr(10,2) (102).
const EMBEDDED: f64 = 100.0;

/// The same for complex points: legs in the embedding take 2.6 times as long on St(3,2) (5), 1.5 on St(4,3) (12), 1.4
/// on St(4,2) (14), 0.7 on St(5,2) (26).
const EMBEDDED_COMPLEX: f64 = 20.0;

/// Largest number of dimensions in which series are tried where legs in the embedding fail, and frames and descents for points
/// with more rows: that of rotations in twelve dimensions. Of 60 splines through 6 to 21 points 0.5 to 2.3 apart on St(20,1)
/// and St(20,2), two thirds of them at uneven times, descents find 12 of 45 that legs in the embedding do not; a refusal then
/// takes one to two seconds instead of 0.05.
pub(crate) const MANY: usize = 66;

/// If tension lets velocities grow along a leg by more than `e` to this power, series are used in any dimension: a
/// sweep takes the tension from the previous curve, which converges as `tau h^2 / 40` if the velocities at the ends are
/// given.
const STIFF: f64 = 2.5;

impl Framed<'_> {
    /// Solves the equations of a spline from that of flat space.
    ///
    /// # Errors
    /// `Interrupted`, and the errors of that start.
    pub(crate) fn solve(&self, ends: &Ends, effort: Effort<'_>) -> Result<ChainSolution> {
        let may_embed = self.is_even(ends) || self.size() > MANY;
        if !self.prefers_series() && may_embed {
            let found = self.in_embedding(ends, effort)?;
            if found.report.converged || effort.work.is_done() || self.size() > MANY {
                return Ok(found);
            }
        }
        let start = flat_spline(self, ends)?;
        match self.start_speed(ends, &start) <= fastest(ends) {
            true => self.by_series(ends, start, effort),
            false => Ok(ChainSolution::unsolved(effort)),
        }
    }
}

/// Largest rotation of a leg for which series are used.
pub(crate) fn fastest(ends: &Ends) -> f64 {
    match gives_velocity(ends) {
        true => FAST,
        false => FAST_WITH_FREE_ENDS,
    }
}

impl Framed<'_> {
    /// Whether series are quicker than legs in the embedding, or the tension is large.
    fn prefers_series(&self) -> bool {
        let longest = self.lengths().iter().fold(0.0_f64, |most, h| most.max(*h));
        let [d, r, k] =
            [self.size(), self.frames()[0].nrows(), self.columns()].map(|size| size as f64);
        let embedded = match self.blocks().kind().field {
            ScalarField::Real => EMBEDDED,
            ScalarField::Complex => EMBEDDED_COMPLEX,
        };
        d.powi(3) <= embedded * r * k * k || longest * self.tension().sqrt() > STIFF
    }

    /// The largest rotation of a leg, from a motion's velocities or from the distance between knots.
    fn start_speed(&self, ends: &Ends, motion: &Motion) -> f64 {
        let velocities = &motion.entries[..self.size() * (self.lengths().len() + 1)];
        in_space!(self.shape(), |space| self
            .knots(ends)
            .speed(space, velocities))
    }

    /// Solves by series.
    fn by_series(&self, ends: &Ends, start: Motion, effort: Effort<'_>) -> Result<ChainSolution> {
        in_space!(self.shape(), |space| self
            .in_space(space, ends, start, effort))
    }

    fn knots<'a>(&'a self, ends: &'a Ends) -> Knots<'a> {
        Knots {
            lengths: self.lengths(),
            targets: self.targets().collect(),
            ends,
            tension: self.tension(),
        }
    }

    fn in_space(
        &self,
        space: impl Homogeneous + 'static,
        ends: &Ends,
        mut motion: Motion,
        effort: Effort<'_>,
    ) -> Result<ChainSolution> {
        let knots = self.knots(ends);
        let may_go_on = |products| effort.work.may_go_on(products);
        let options = effort.options(&may_go_on);
        let knot = space.dim() * (self.lengths().len() + 1);
        let (velocities, derivatives) = motion.entries.split_at_mut(knot);
        let (report, curves) =
            shooting::solve::<Lanes, _>(space, &knots, velocities, derivatives, &options)?;
        Ok(ChainSolution {
            motion,
            report,
            legs: curves.map(|curves| self.legs(curves)),
        })
    }

    /// The curves of the legs.
    fn legs(&self, curves: Box<dyn Curves>) -> SolvedLegs {
        let curves: Arc<dyn Curves> = curves.into();
        let of_leg = polynomials_of_legs(
            Arc::clone(&curves),
            self.frames(),
            (self.blocks(), self.columns()),
            (self.tension(), self.lengths().to_vec()),
        );
        SolvedLegs {
            polynomials: Some(curves),
            turns: None,
            piece: Arc::new(move |leg| Some((None, of_leg(leg)))),
        }
    }
}

/// The polynomials of the legs between frames, computed on demand, for blocks of the space that is solved and columns
/// of the points, and for a tension and the lengths of the legs.
pub(crate) fn polynomials_of_legs(
    curves: Arc<dyn Curves>,
    frames: Arc<[Mat<f64>]>,
    (blocks, columns): (Sizes, usize),
    (tension, lengths): (f64, Vec<f64>),
) -> impl Fn(usize) -> LazyTaylor + Send + Sync {
    let curve_of = Arc::new(move |leg: usize| {
        let (polynomials, which) = curves.of_leg(leg);
        let tension = tension * lengths[leg].powi(2);
        let frame = Some(&frames[leg]);
        leg_curve(polynomials, which, frame, blocks, columns, tension)
    });
    move |leg| {
        let curve_of = Arc::clone(&curve_of);
        LazyTaylor::of(move || curve_of(leg))
    }
}

impl InEmbedding for Framed<'_> {
    fn points(&self) -> Vec<Mat<f64>> {
        let (frames, columns) = (self.frames(), self.columns());
        let points = frames
            .iter()
            .map(|frame| frame.as_ref().subcols(0, columns));
        points.map(|point| point.to_owned()).collect()
    }

    fn matrix_of(&self, knot: usize, v: &[f64]) -> Mat<f64> {
        self.tangent(knot, v)
    }

    fn vector_of(&self, knot: usize, v: MatRef<'_, f64>) -> Vec<f64> {
        coordinates(self.blocks().kind(), self.frames()[knot].as_ref(), v)
    }

    fn frames_of_space(&self) -> Option<Arc<[Mat<f64>]>> {
        Some(self.frames())
    }

    fn kind(&self) -> Kind {
        self.blocks().kind()
    }

    fn space(&self) -> (Sizes, usize) {
        (self.blocks(), self.columns())
    }

    fn tension(&self) -> f64 {
        Framed::tension(self)
    }
}
