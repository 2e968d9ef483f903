//! Gradients with respect to displacements and velocities at the knots of a spline, and their conversion to gradients
//! with respect to its data.

use faer::{Mat, Scale};

use super::data_variation::SplineGradient;
use super::given::Given;
use super::knot_states::{KnotStates, State};
use crate::cubic::turning::{by_data, lowered};
use crate::error::{Error, Result};
use crate::linalg::structure::norm;

/// Gradient of a function of displacements `u` and velocities `w` at the knots, as tangent vectors, and of the times.
pub(super) struct KnotGradient {
    pub(super) u: Vec<Mat<f64>>,
    pub(super) w: Vec<Mat<f64>>,
    t: Vec<f64>,
    /// Factor by which the values are to be multiplied.
    factor: f64,
}

impl KnotGradient {
    pub(super) fn zeros(states: &KnotStates) -> Self {
        let (n, k) = states.point(0).shape();
        let count = states.count();
        KnotGradient {
            u: vec![Mat::zeros(n, k); count],
            w: vec![Mat::zeros(n, k); count],
            t: vec![0.0; count],
            factor: 1.0,
        }
    }

    /// The first variation of the cost, in units of the mean leg.
    pub(super) fn of_cost(states: &KnotStates) -> Self {
        let mut gradient = KnotGradient {
            factor: states.unit.powi(-3),
            ..Self::zeros(states)
        };
        for (piece, ends) in states.ends.iter().enumerate() {
            for (end, [_, v, a, x]) in ends.iter().enumerate() {
                let (knot, sign) = (piece + end, [-1.0, 1.0][end]);
                let pull = x - v * Scale(states.tension);
                let rate = states.inner(knot, a, a) + states.tension * states.inner(knot, v, v);
                gradient.u[knot] += pull * Scale(-2.0 * sign);
                gradient.w[knot] += a * Scale(2.0 * sign);
                gradient.t[knot] += sign * rate;
            }
        }
        gradient
    }

    /// Adds the gradient with respect to `(u_0, w_0, u_1, w_1)` of a piece, times one factor for displacements and one
    /// for velocities.
    pub(super) fn add(&mut self, piece: usize, [u0, w0, u1, w1]: State, factors: [f64; 2]) {
        let [by_u, by_w] = factors.map(Scale);
        self.u[piece] += u0 * by_u;
        self.w[piece] += w0 * by_w;
        self.u[piece + 1] += u1 * by_u;
        self.w[piece + 1] += w1 * by_w;
    }

    /// Subtracts the contribution of moving knots for given multipliers of the velocities: the jumps of `x''` there.
    pub(super) fn add_jumps(&mut self, states: &KnotStates, multipliers: &[Mat<f64>]) {
        for (piece, ends) in states.ends.iter().enumerate() {
            for (end, sign) in [1.0, -1.0].into_iter().enumerate() {
                let knot = piece + end;
                self.t[knot] += sign * states.inner(knot, &ends[end][3], &multipliers[knot]);
            }
        }
    }

    /// Converts to the gradient with respect to the data: the gradients with respect to free velocities are zero, or
    /// accounted for by multipliers.
    ///
    /// # Errors
    /// `Overflow`.
    pub(super) fn by_data(
        self,
        states: &KnotStates,
        given: [Given; 2],
        multipliers: Option<&[Mat<f64>]>,
    ) -> Result<SplineGradient> {
        let (count, factor) = (states.count(), self.factor);
        let times = (0..count).map(|knot| {
            let [_, v, a, _] = states.at(knot);
            let moved = states.inner(knot, v, &self.u[knot]) + states.inner(knot, a, &self.w[knot]);
            (self.t[knot] - moved) * factor / states.unit
        });
        let times: Vec<f64> = times.collect();
        let mut points: Vec<Mat<f64>> = (0..count)
            .map(|knot| lowered(states.point(knot), self.u[knot].as_ref()) * Scale(factor))
            .collect();
        let ends = [(0, 0, -1.0), (1, count - 1, 1.0)].map(|(end, knot, sign)| {
            let order = given[end].order()?;
            let bar = match given[end] {
                Given::Velocity => self.w[knot].clone(),
                _ => &multipliers?[knot] * Scale(sign),
            };
            let (s, y) = (states.point(knot), states.at(knot)[order].as_ref());
            let [point, vector] = by_data(s, [self.u[knot].as_ref(), bar.as_ref()], y);
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
