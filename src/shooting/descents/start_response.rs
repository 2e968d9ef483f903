//! The response of the start of a curve of least cost to a change of its end.

use super::free_chain::FreeChain;
use super::second_derivative::{isometry, turn};
use crate::linalg::field::{Field, accumulate};
use crate::solve::block_cholesky::CholeskyFactor;
use crate::space::Homogeneous;

/// The derivative of `(x', x'')` at the start with respect to point and velocity at the end, for a fixed start: the
/// inner knots of a chain at rest follow the last one according to its second derivative.
pub(crate) struct StartResponse {
    factor: CholeskyFactor,
    /// The derivatives of the gradient at the last inner knot with respect to the end, and of the gradient at the start
    /// with respect to the first inner knot, shape `(2 d, 2 d)`.
    by_last: Vec<f64>,
    by_first: Vec<f64>,
    /// The map from coordinates in the frame carried along the curve to coordinates in the last knot's frame, in
    /// row-major order.
    turn: Vec<Vec<f64>>,
    legs: usize,
}

impl StartResponse {
    /// Built from a chain with linear equations; `None` if the second derivative is not positive definite.
    pub(crate) fn of<T: Field, S: Homogeneous>(chain: &FreeChain<'_, T, S>) -> Option<Self> {
        let d = chain.space.dim();
        let legs = chain.layout.legs();
        let [exact, _] = chain.second_derivatives();
        let block = |leg: usize| {
            let matrix = &chain.groups[leg / T::COUNT].stiffness.matrix;
            let rows = matrix.chunks_exact(4 * d).take(2 * d);
            let entries = rows.flat_map(|row| &row[2 * d..]);
            entries.map(|x| x.lane(leg % T::COUNT)).collect()
        };
        Some(StartResponse {
            factor: exact.factored()?,
            by_last: block(legs - 1),
            by_first: block(0),
            turn: turn(chain.space, &carried(chain)),
            legs,
        })
    }

    /// The change of `(x', x'')` for a change of the end: a displacement and a velocity in coordinates of the frame
    /// carried along the curve.
    pub(crate) fn change(&self, end: &[f64]) -> Vec<f64> {
        let d = self.turn.len();
        let (width, rate) = (2 * d, self.legs as f64);
        let (point, velocity) = end.split_at(d);
        let mut last = vec![0.0; width];
        for (p, row) in self.turn.iter().enumerate() {
            for (entry, (x, v)) in row.iter().zip(point.iter().zip(velocity)) {
                last[p] += entry * x;
                last[d + p] += entry * v / rate;
            }
        }
        let mut knots = vec![0.0; (self.legs - 1) * width];
        let at = knots.len() - width;
        accumulate(&self.by_last, width, &last, 1, &mut knots[at..]);
        for x in &mut knots {
            *x = -*x;
        }
        self.factor.solve(&mut knots);
        // The gradient at the start is `(x'', -x')`.
        let mut start = vec![0.0; width];
        accumulate(&self.by_first, width, &knots[..width], 1, &mut start);
        let (second, first) = start.split_at(d);
        let first = first.iter().map(|x| -x * rate.powi(2));
        first
            .chain(second.iter().map(|x| x * rate.powi(3)))
            .collect()
    }
}

/// The isometry between the frame carried along the curve, at its end, and the last knot's frame.
fn carried<T: Field, S: Homogeneous>(chain: &FreeChain<'_, T, S>) -> Vec<f64> {
    let r = chain.space.size();
    let mut all = isometry(&chain.groups[0], 0);
    for leg in 1..chain.layout.legs() {
        let next = isometry(&chain.groups[leg / T::COUNT], leg % T::COUNT);
        let mut product = vec![0.0; r * r];
        accumulate(&next, r, &all, r, &mut product);
        all = product;
    }
    all
}
