//! Short legs of a chain at rest, integrated from their first knots and put together to one curve.

use faer::{Mat, MatRef};

use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::cubic::taylor::state::State;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::larger;
use crate::manifold::grassmann::alignment::alignment;
use crate::shooting::LeastCost;
use crate::space::Quotient;

/// Consecutive legs of equal durations.
pub(crate) struct ShortLegs<'a> {
    pub(crate) chain: &'a LeastCost,
    /// The knots where the curve starts and ends.
    pub(crate) between: [usize; 2],
    /// Duration of the curve, in the unit of time of the chain.
    pub(crate) h: f64,
    /// The state with a frame of the chain and the coordinates of `x, x', x''`, in the time of the curve.
    pub(crate) state: &'a (dyn Fn(&Mat<f64>, &[f64]) -> State + Sync),
}

impl ShortLegs<'_> {
    /// The curve on `[0, 1]`, and the largest differences of points, velocities and accelerations between a leg and the next
    /// one; at the last knot, of points and velocities. In the time of a leg, and relative to sizes above 1.
    ///
    /// # Errors
    /// An error if a leg cannot be integrated; `Interrupted`.
    pub(crate) fn together(&self, interrupt: Interrupt<'_>) -> Result<(PiecewiseTaylor, [f64; 3])> {
        let (mut curve, mut gaps) = (self.leg(0, interrupt)?, [0.0; 3]);
        let step = 1.0 / self.legs() as f64;
        let mut compare = |curve: &PiecewiseTaylor, next: &State, orders| {
            let all = differences(&curve.last, next, step);
            for (gap, found) in gaps.iter_mut().zip(all).take(orders) {
                *gap = larger(*gap, found);
            }
        };
        for leg in 1..self.legs() {
            let next = in_reached_basis(&curve, self.leg(leg, interrupt)?)?;
            compare(&curve, &next.first, 3);
            curve = curve.followed_by(next);
        }
        let last = PiecewiseTaylor::at(self.knot(self.between[1]), Accuracy::FULL);
        compare(&curve, &in_reached_basis(&curve, last)?.first, 2);
        Ok((curve, gaps))
    }

    fn legs(&self) -> usize {
        self.between[1] - self.between[0]
    }

    fn leg(&self, leg: usize, interrupt: Interrupt<'_>) -> Result<PiecewiseTaylor> {
        let mut state = self.knot(self.between[0] + leg);
        let step = 1.0 / self.legs() as f64;
        state.time = step * leg as f64;
        let mut taylor = PiecewiseTaylor::at(state, Accuracy::FULL);
        let end = match leg + 1 == self.legs() {
            true => 1.0,
            false => step * (leg + 1) as f64,
        };
        taylor.extend_to(end, interrupt)?;
        Ok(taylor)
    }

    fn knot(&self, knot: usize) -> State {
        let frames = &self.chain.knots.frames;
        let d = self.chain.dim();
        let knots = self.chain.knots.velocities.len() / d;
        let square = frames.len() / knots;
        let r = square.isqrt();
        let frame = MatRef::from_row_major_slice(&frames[knot * square..][..square], r, r);
        (self.state)(&frame.to_owned(), &self.chain.vectors(knot, self.h))
    }
}

/// The next part of a curve, for subspaces in the basis that the curve has reached.
fn in_reached_basis(curve: &PiecewiseTaylor, next: PiecewiseTaylor) -> Result<PiecewiseTaylor> {
    if curve.last.blocks.quotient == Quotient::Frames {
        return Ok(next);
    }
    let turn = alignment(point(&curve.last), point(&next.first))?;
    Ok(next.in_terms_of(turn.as_ref()))
}

/// The point of a state, shape `(r, k)`.
fn point(state: &State) -> MatRef<'_, f64> {
    state.frame().subcols(0, state.blocks.k)
}

/// Differences of point, velocity and acceleration of two states in a unit of time, relative to sizes above 1.
fn differences(reached: &State, next: &State, unit: f64) -> [f64; 3] {
    let [a, b] = [reached, next].map(|state| (state.frame(), state.vectors()));
    let points = (point(reached) - point(next)).norm_l2();
    let [velocities, accelerations] = [0, 1].map(|i| {
        let [a, b] = [&a, &b].map(|(frame, vectors)| frame * vectors[i].tangent());
        let unit = unit.powi(1 + i as i32);
        unit * (&a - b).norm_l2() / (unit * a.norm_l2()).max(1.0)
    });
    [points, velocities, accelerations]
}
