//! Knots and the legs between them: what a solver of splines needs to carry vectors and to integrate legs.

use std::sync::Arc;

use faer::Mat;

use super::motion::Motion;
use crate::cubic::RiemannianCubic;
use crate::cubic::taylor::lazy_taylor::LazyTaylor;
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::cubic::taylor::state::State;
use crate::cubic::taylor::work::Work;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::lanes::LANES;
use crate::solve::direction::Direction;
use crate::solve::tridiagonal::Isometries;
use crate::threads;

/// Number of legs that are integrated by one worker, together if that is faster.
pub(crate) const LEGS: usize = LANES;

/// Microseconds, for each coordinate, of a leg that is integrated among eight.
const LEG: f64 = 0.25;

/// Microseconds of a piece whose curve is computed later.
const PIECE: f64 = 0.2;

/// Cost of the logarithm of a datum plus joining a moved knot, in units of joining: the logarithm takes about five
/// times as long.
pub(crate) const JOINS: f64 = 6.0;

/// Integration accuracy of legs, their speeds at the ends, and the counter of work.
pub(crate) struct Means<'a> {
    pub(crate) accuracy: Accuracy,
    pub(crate) speed: f64,
    pub(crate) work: &'a Work,
}

/// Knots, and quasi-geodesics between neighbours along which vectors are carried from knot to knot.
///
/// A tangent vector at a knot is represented by [`size`](Chain::size) numbers, isometrically up to a constant factor.
pub(crate) trait Chain: Sync {
    /// Buffers that a thread needs to integrate a leg.
    type Worker;

    /// Number of coordinates of a tangent vector.
    fn size(&self) -> usize;

    /// Durations of the legs.
    fn lengths(&self) -> &[f64];

    fn worker(&self) -> Self::Worker;

    /// Writes the initial velocity of the quasi-geodesic of a leg, in the time of the leg.
    fn displacement_into(&self, leg: usize, out: &mut [f64]);

    /// Carries a vector from one end of a leg to the other.
    fn carry_into(
        &self,
        worker: &mut Self::Worker,
        leg: usize,
        way: Direction,
        v: &[f64],
        out: &mut [f64],
    ) -> Result<()>;

    /// Integrates the cubics of a few consecutive legs from velocity, acceleration and third vector, in the time of the
    /// leg. For each it writes the distance from the next knot as a tangent vector there, then velocity, acceleration
    /// and third vector as far as there is room; and `|S(1) - S_1|` into `distances`. Counts its work.
    ///
    /// # Errors
    /// If a cubic cannot be integrated, the error wrapped in `AtKnot`; `Interrupted`.
    fn ends_into(
        &self,
        worker: &mut Self::Worker,
        first: usize,
        starts: &[Vec<f64>],
        means: &Means<'_>,
        values: &mut [f64],
        distances: &mut [f64],
    ) -> Result<()>;

    /// Typical work of integrating a leg.
    fn work_of_leg(&self) -> f64;

    /// The state of a leg's cubic at its start: a basis of its span, unless the span is the whole space, and frame and
    /// vectors in that basis.
    fn state(&self, leg: usize, start: &[f64]) -> (Option<Mat<f64>>, State);

    /// The cubic of a leg on `[0, 1]`: a basis of its span, unless the span is the whole space, and the polynomials in
    /// that basis.
    ///
    /// # Errors
    /// An error if it cannot be integrated; `Interrupted`.
    fn integrated(
        &self,
        leg: usize,
        motion: &Motion,
        interrupt: Interrupt<'_>,
    ) -> Result<SpannedPiece> {
        let (basis, state) = self.state(leg, &motion.start(leg, self.lengths()[leg]));
        let mut taylor = PiecewiseTaylor::at(state, Accuracy::FULL);
        taylor.extend_to(1.0, interrupt)?;
        Ok((basis, taylor.into()))
    }
}

/// Carries vectors along a chain.
pub(crate) struct Carrying<'c, C: Chain> {
    pub(crate) chain: &'c C,
    pub(crate) worker: &'c mut C::Worker,
}

impl<C: Chain> Isometries for Carrying<'_, C> {
    fn size(&self) -> usize {
        self.chain.size()
    }

    fn carry_into(
        &mut self,
        leg: usize,
        way: Direction,
        from: &[f64],
        to: &mut [f64],
    ) -> Result<()> {
        self.chain.carry_into(self.worker, leg, way, from, to)
    }
}

/// A basis of a curve's span, unless the span is the whole space, and the polynomials in that basis.
pub(crate) type SpannedPiece = (Option<Mat<f64>>, LazyTaylor);

/// A chain whose knots are unknowns too.
pub(crate) trait Movable: Chain + Sized {
    /// Work of moving a knot, joining it to the next one, and computing the logarithm of a datum.
    fn work_of_knot(&self) -> f64;

    /// Moves every knot along its tangent vector by a retraction, and carries the vectors of a motion along.
    ///
    /// # Errors
    /// An error if neighbouring knots can no longer be joined.
    fn moved(&self, shifts: &[f64], motion: &mut Motion) -> Result<Self>;

    /// The initial velocity at a knot of the geodesic to another point.
    ///
    /// # Errors
    /// An error if there is no such geodesic.
    fn towards(&self, knot: usize, point: &Mat<f64>) -> Result<Vec<f64>>;

    /// The squared norm of a tangent vector.
    fn square(&self, knot: usize, v: &[f64]) -> f64;
}

/// The legs as curves, each on `[0, 1]`.
///
/// # Errors
/// The errors of the legs.
pub(crate) fn pieces(
    legs: usize,
    space: &SpannedSpace,
    piece: impl Fn(usize) -> Result<SpannedPiece> + Sync,
) -> Result<Vec<RiemannianCubic>> {
    let curve = |(): &mut (), leg: usize| {
        let (frame, taylor) = piece(leg)?;
        let frame = match (&space.basis, frame) {
            (Some(basis), Some(frame)) => Some(Arc::new(basis.as_ref() * frame)),
            (Some(basis), None) => Some(Arc::clone(basis)),
            (None, frame) => frame.map(Arc::new),
        };
        let span = (0.0, 1.0);
        Ok(RiemannianCubic::of_leg(
            space.n, space.k, frame, taylor, span,
        ))
    };
    threads::map(legs, PIECE, || (), curve)
}

/// The space of the points.
pub(crate) struct SpannedSpace {
    pub(crate) n: usize,
    pub(crate) k: usize,
    /// Orthonormal basis of the span of all points, if the span is smaller than `R^n`.
    pub(crate) basis: Option<Arc<Mat<f64>>>,
}

/// Values at the ends of the legs.
#[derive(Debug)]
pub(crate) struct LegEnds {
    /// Number of coordinates of a vector.
    size: usize,
    /// Vectors per leg: point defect, velocity defect, acceleration, and the third vector if requested.
    vectors: usize,
    values: Vec<f64>,
    /// Point defect of each leg, carried back to its start.
    back: Vec<f64>,
    /// The largest norm over all legs of both defects together.
    pub(crate) defect: f64,
}

impl LegEnds {
    /// Integrates every leg of a motion, in parallel; the results do not depend on the number of threads.
    ///
    /// # Errors
    /// The error of the first leg that cannot be integrated, wrapped in `AtKnot`. The other legs are integrated
    /// nevertheless, so that the counted work does not depend on the threads.
    pub(crate) fn of<C: Chain>(
        chain: &C,
        motion: &Motion,
        vectors: usize,
        accuracy: Accuracy,
        work: &Work,
    ) -> Result<Self> {
        let (size, lengths) = (chain.size(), chain.lengths());
        let mut values = vec![0.0; size * vectors * lengths.len()];
        let mut back = vec![0.0; size * lengths.len()];
        let some = |worker: &mut C::Worker, group: usize, (values, back): &mut GroupValues<'_>| {
            let first = group * LEGS;
            let count = back.len() / size;
            let starts: Vec<Vec<f64>> = (first..first + count)
                .map(|leg| motion.start(leg, lengths[leg]))
                .collect();
            let mut distances = [0.0; LEGS];
            let distances = &mut distances[..count];
            let means = Means {
                accuracy,
                speed: motion.speed(first..first + count + 1, lengths),
                work,
            };
            chain.ends_into(worker, first, &starts, &means, values, distances)?;
            let mut defect = 0.0_f64;
            let each = values
                .chunks_exact_mut(size * vectors)
                .zip(back.chunks_exact_mut(size));
            for (i, (values, back)) in each.enumerate() {
                let leg = first + i;
                let end = motion.velocity(leg + 1);
                for (w, v) in values[size..2 * size].iter_mut().zip(end) {
                    *w -= lengths[leg] * v;
                }
                chain.carry_into(worker, leg, Direction::Backward, &values[..size], back)?;
                defect = defect.max(distances[i].hypot(square(&values[size..2 * size]).sqrt()));
            }
            Ok(defect)
        };
        // All of them are computed even if one fails, so that the counted work does not depend on the threads.
        let groups = values
            .chunks_mut(size * vectors * LEGS)
            .zip(back.chunks_mut(size * LEGS));
        let each = LEGS as f64 * LEG * size as f64;
        let defects = threads::map_parts(
            groups,
            each,
            || chain.worker(),
            |worker, group, parts| Ok(some(worker, group, parts)),
        )?;
        let mut defect = 0.0_f64;
        for found in defects {
            defect = defect.max(found?);
        }
        Ok(LegEnds {
            size,
            vectors,
            values,
            back,
            defect,
        })
    }

    /// The values in flat space, for legs without velocity and acceleration.
    ///
    /// # Errors
    /// The errors of carrying.
    pub(crate) fn at_rest<C: Chain>(chain: &C, vectors: usize) -> Result<Self> {
        let (size, legs) = (chain.size(), chain.lengths().len());
        let mut worker = chain.worker();
        let mut values = vec![0.0; size * vectors * legs];
        let mut back = vec![0.0; size * legs];
        for (leg, back) in back.chunks_exact_mut(size).enumerate() {
            chain.displacement_into(leg, back);
            back.iter_mut().for_each(|x| *x = -*x);
            let defect = &mut values[size * vectors * leg..][..size];
            chain.carry_into(&mut worker, leg, Direction::Forward, back, defect)?;
        }
        Ok(LegEnds {
            size,
            vectors,
            values,
            back,
            defect: f64::INFINITY,
        })
    }

    /// One of the vectors at the end of a leg.
    pub(crate) fn vector(&self, leg: usize, which: usize) -> &[f64] {
        &self.values[self.size * (self.vectors * leg + which)..][..self.size]
    }

    /// The point defect, carried back to the start of the leg.
    pub(crate) fn point_defect_back(&self, leg: usize) -> &[f64] {
        &self.back[self.size * leg..][..self.size]
    }
}

/// The values of consecutive legs, and the vectors carried back.
type GroupValues<'a> = (&'a mut [f64], &'a mut [f64]);

pub(crate) fn square(a: &[f64]) -> f64 {
    a.iter().map(|a| a * a).sum()
}
