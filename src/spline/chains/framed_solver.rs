//! Splines through knots with frames: by legs in the embedding or by series, whichever is quicker; by integrated legs
//! if these find nothing.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::chain::Chain;
use super::embedded::InEmbedding;
use super::framed::{Framed, coordinates};
use super::interpolation::Interpolation;
use super::iteration::ChainIteration;
use super::motion::Motion;
use super::solution::{ChainSolution, ChainStart, Effort, SolvedLegs};
use crate::collocation::Near;
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::lazy_taylor::LazyTaylor;
use crate::cubic::taylor::leg_curve::leg_curve;
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::error::Result;
use crate::legs::{Curves, Knots, Options};
use crate::linalg::lanes::Lanes;
use crate::shooting;
use crate::space::{Homogeneous, Kind, ScalarField, in_space};
use crate::spline::ends::{Ends, gives_velocity};

/// Largest rotation of a leg, in radians, for which series are used, if velocities at the ends are
/// given and if they are not; for faster starts the legs are integrated from the beginning. With 6 for given end
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

/// Largest number of dimensions in which series are tried where legs in the embedding fail: that of rotations in twelve
/// dimensions. With integrated legs in their place, five splines through 20 points 2.8 apart on St(10,9) are not
/// solved.
const MANY: usize = 66;

/// If tension lets velocities grow along a leg by more than `e` to this power, series are used in any dimension: a
/// sweep takes the tension from the previous curve, which converges as `tau h^2 / 40` if the velocities at the ends are
/// given.
const STIFF: f64 = 2.5;

/// Integration accuracy of the derivatives of a start.
const START_ACCURACY: f64 = 1e-6;

impl Framed<'_> {
    /// Solves the equations of a spline.
    ///
    /// # Errors
    /// An error if the start cannot be integrated; `Interrupted`.
    pub(crate) fn solve(
        &self,
        ends: &Ends,
        start: ChainStart,
        effort: Effort<'_>,
    ) -> Result<ChainSolution> {
        if !self.prefers_series()
            && let Some(found) = self.by_embedding(ends, &start, effort)?
        {
            return Ok(found);
        }
        let problem = Interpolation::new(self, ends)?;
        let is_flat = matches!(start, ChainStart::Flat);
        let motion = match start {
            ChainStart::Flat => problem.start()?,
            ChainStart::Near(motion) => motion,
        };
        let takes_series = self.prefers_series() || self.size() <= MANY;
        if takes_series && self.start_speed(ends, &motion) <= fastest(ends) {
            let found = self.by_series(ends, &motion, is_flat, effort)?;
            if found.report.converged || effort.work.is_done() {
                return Ok(found);
            }
        }
        // Failed attempts count as work, not as iterations: closed chains on St(5, 3) need most of their iterations.
        match is_flat {
            true => ChainIteration::solve(&problem, motion, effort),
            false => ChainIteration::solve_near(&problem, motion, effort),
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

    /// Solves with legs in the embedding, from either start.
    fn by_embedding(
        &self,
        ends: &Ends,
        start: &ChainStart,
        effort: Effort<'_>,
    ) -> Result<Option<ChainSolution>> {
        let ChainStart::Near(motion) = start else {
            return self.in_embedding(ends, None, effort);
        };
        let near = Near {
            velocities: self.matrices_of(motion),
            leg: &|leg, times| self.near_leg(motion, leg, times),
        };
        self.in_embedding(ends, Some(&near), effort)
    }

    /// The fourth derivatives of a leg of a motion at some times, one matrix after another, and its end, by
    /// integration.
    fn near_leg(&self, motion: &Motion, leg: usize, times: &[f64]) -> Result<(Vec<f64>, Mat<f64>)> {
        const ORDERS: usize = 5;
        let taylor = self.integrated_roughly(motion, leg)?;
        let (rows, r, k) = (taylor.rows(), taylor.r(), self.columns());
        let mut series: [Vec<f64>; ORDERS] = std::array::from_fn(|_| vec![0.0; rows * k]);
        let mut values = Vec::with_capacity(times.len() * r * k);
        for t in times {
            taylor.points_into(*t, &mut series.each_mut().map(Vec::as_mut_slice));
            let fourth = series[ORDERS - 1]
                .chunks_exact(rows)
                .flat_map(|column| &column[..r]);
            values.extend(fourth.map(|c| 24.0 * c));
        }
        taylor.point_into(1.0, &mut series[0]);
        let end = MatRef::from_column_major_slice(&series[0], rows, k);
        Ok((values, end.subrows(0, r).to_owned()))
    }

    /// The largest rotation of a leg, from a motion's velocities or from the distance between knots.
    fn start_speed(&self, ends: &Ends, motion: &Motion) -> f64 {
        let velocities = &motion.entries[..self.size() * (self.lengths().len() + 1)];
        in_space!(self.shape(), |space| self
            .knots(ends)
            .speed(space, velocities))
    }

    /// Solves by series.
    fn by_series(
        &self,
        ends: &Ends,
        start: &Motion,
        is_flat: bool,
        effort: Effort<'_>,
    ) -> Result<ChainSolution> {
        in_space!(self.shape(), |space| self
            .in_space(space, ends, start, is_flat, effort))
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
        start: &Motion,
        is_flat: bool,
        effort: Effort<'_>,
    ) -> Result<ChainSolution> {
        let knots = self.knots(ends);
        let third_derivative = |leg: usize, times: &[f64]| self.third_derivative(start, leg, times);
        let may_go_on = |products| effort.work.may_go_on(products);
        let options = Options {
            third_derivative: (!is_flat).then_some(&third_derivative),
            ..effort.options(&may_go_on)
        };
        let knot = space.dim() * (self.lengths().len() + 1);
        let mut motion = start.clone();
        let (velocities, derivatives) = motion.entries.split_at_mut(knot);
        let (report, curves) =
            shooting::solve::<Lanes, _>(space, &knots, velocities, derivatives, &options)?;
        Ok(ChainSolution {
            motion,
            report,
            legs: curves.map(|curves| self.legs(curves)),
        })
    }

    /// `x'''` of a leg of a motion at some times, by integration.
    fn third_derivative(&self, motion: &Motion, leg: usize, times: &[f64]) -> Result<Vec<f64>> {
        let taylor = self.integrated_roughly(motion, leg)?;
        Ok(taylor.third_derivatives(times))
    }

    fn integrated_roughly(&self, motion: &Motion, leg: usize) -> Result<PiecewiseTaylor> {
        let (_, state) = self.state(leg, &motion.start(leg, self.lengths()[leg]));
        let mut taylor = PiecewiseTaylor::at(state, Accuracy::of_tolerance(START_ACCURACY));
        taylor
            .extend_to(1.0, self.interrupt())
            .map_err(|error| error.at_knot(leg))?;
        Ok(taylor)
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
