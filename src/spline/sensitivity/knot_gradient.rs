//! Gradients with respect to displacements and velocities at the knots of a spline, and their conversion to gradients
//! with respect to its data.

use faer::{Mat, Scale};

use super::data_variation::SplineGradient;
use super::given::GivenEnd;
use super::knot_states::KnotStates;
use crate::cubic::sensitivity::linear_piece::PieceVariation;
use crate::cubic::turning::{by_data, lowered};
use crate::error::{Error, Result};
use crate::linalg::field::add;
use crate::linalg::structure::norm;

/// Gradient of a function of displacements `u` and velocities `w` at the knots, as tangent vectors by columns, one knot after
/// another, and of the times.
pub(crate) struct KnotGradient {
    pub(crate) u: Vec<f64>,
    pub(crate) w: Vec<f64>,
    t: Vec<f64>,
    /// Factor by which the values are to be multiplied.
    factor: f64,
}

impl KnotGradient {
    pub(crate) fn zeros(states: &KnotStates) -> Self {
        let count = states.count();
        KnotGradient {
            u: vec![0.0; count * states.size()],
            w: vec![0.0; count * states.size()],
            t: vec![0.0; count],
            factor: 1.0,
        }
    }

    /// The first variation of the cost, in units of the mean leg.
    pub(crate) fn of_cost(states: &KnotStates) -> Self {
        let mut gradient = KnotGradient {
            factor: states.unit.powi(-3),
            ..Self::zeros(states)
        };
        let size = states.size();
        for (piece, ends) in states.ends.iter().enumerate() {
            for (end, [_, v, a, x]) in ends.iter().enumerate() {
                let (knot, sign) = (piece + end, [-1.0, 1.0][end]);
                let rate = states.inner(knot, a, a) + states.tension * states.inner(knot, v, v);
                let u = &mut gradient.u[knot * size..][..size];
                add(u, -2.0 * sign, x);
                add(u, 2.0 * sign * states.tension, v);
                add(&mut gradient.w[knot * size..][..size], 2.0 * sign, a);
                gradient.t[knot] += sign * rate;
            }
        }
        gradient
    }

    /// Adds the gradient with respect to `(u_0, w_0, u_1, w_1)` of a piece, times one factor for displacements and one
    /// for velocities.
    pub(crate) fn add(&mut self, piece: usize, by_ends: &PieceVariation, [by_u, by_w]: [f64; 2]) {
        let size = by_ends[0].len();
        for (end, by_end) in by_ends.chunks_exact(2).enumerate() {
            let at = (piece + end) * size;
            add(&mut self.u[at..][..size], by_u, &by_end[0]);
            add(&mut self.w[at..][..size], by_w, &by_end[1]);
        }
    }

    /// Subtracts the contribution of moving knots for given multipliers of the velocities: the jumps of `x''` there.
    pub(crate) fn add_jumps(&mut self, states: &KnotStates, multipliers: &[f64]) {
        let size = states.size();
        for (piece, ends) in states.ends.iter().enumerate() {
            for (end, sign) in [1.0, -1.0].into_iter().enumerate() {
                let knot = piece + end;
                let multiplier = &multipliers[knot * size..][..size];
                self.t[knot] += sign * states.inner(knot, &ends[end][3], multiplier);
            }
        }
    }

    /// Converts to the gradient with respect to the data: the gradients with respect to free velocities are zero, or
    /// accounted for by multipliers.
    ///
    /// # Errors
    /// `Overflow`.
    pub(crate) fn by_data(
        self,
        states: &KnotStates,
        given: [GivenEnd; 2],
        multipliers: Option<&[f64]>,
    ) -> Result<SplineGradient> {
        let (count, size, factor) = (states.count(), states.size(), self.factor);
        let [u, w] = [&self.u, &self.w].map(|all| move |knot: usize| &all[knot * size..][..size]);
        let times = (0..count).map(|knot| {
            let [_, v, a, _] = states.at(knot);
            let moved = states.inner(knot, v, u(knot)) + states.inner(knot, a, w(knot));
            (self.t[knot] - moved) * factor / states.unit
        });
        let times: Vec<f64> = times.collect();
        let point = |knot: usize| {
            let mut point = lowered(states.point(knot), states.matrix(u(knot)));
            point *= Scale(factor);
            point
        };
        let mut points: Vec<Mat<f64>> = (0..count).map(point).collect();
        let ends = [(0, 0, -1.0), (1, count - 1, 1.0)].map(|(end, knot, sign)| {
            let order = given[end].order()?;
            let bar = match given[end] {
                GivenEnd::Velocity => states.matrix(w(knot)).to_owned(),
                _ => states.matrix(&multipliers?[knot * size..][..size]) * Scale(sign),
            };
            let (s, y) = (states.point(knot), states.matrix(&states.at(knot)[order]));
            let [point, vector] = by_data(s, [states.matrix(u(knot)), bar.as_ref()], y);
            points[knot] = point * Scale(factor);
            Some(vector * Scale(factor * states.unit.powi(order as i32)))
        });
        let matrices = points.iter().chain(ends.iter().flatten());
        let sizes = matrices
            .map(|x| norm(x.as_ref()))
            .chain(times.iter().copied());
        if !sizes.fold(0.0, |sum: f64, x| sum + x.abs()).is_finite() {
            return Err(Error::Overflow {
                quantity: "gradient of a spline",
            });
        }
        Ok(SplineGradient {
            points,
            times,
            ends,
        })
    }
}
