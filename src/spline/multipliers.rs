//! From functions of displacements and velocities at the knots of a spline to gradients with respect to its data.

use faer::{Mat, Scale};

use super::data_variation::{Given, SplineGradient};
use super::knot_states::{KnotStates, State};
use super::knot_system::KnotSystem;
use crate::cubic::linear_piece::LinearPiece;
use crate::cubic::turning::{lowered, turned_transposed};
use crate::error::{Error, Result};
use crate::linalg::structure::norm;

/// Functions of displacements and velocities at the knots, and of times beside them: tangent vectors, and numbers.
pub(super) struct Bars {
    pub(super) u: Vec<Mat<f64>>,
    pub(super) w: Vec<Mat<f64>>,
    t: Vec<f64>,
}

impl Bars {
    pub(super) fn zeros(states: &KnotStates) -> Self {
        let (n, k) = states.point(0).shape();
        let count = states.count();
        Bars {
            u: vec![Mat::zeros(n, k); count],
            w: vec![Mat::zeros(n, k); count],
            t: vec![0.0; count],
        }
    }
}

/// The first variation of the cost in units of the mean leg.
pub(super) fn cost_bars(states: &KnotStates) -> Bars {
    let mut bars = Bars::zeros(states);
    for (piece, ends) in states.ends.iter().enumerate() {
        for (end, [_, v, a, x]) in ends.iter().enumerate() {
            let (knot, sign) = (piece + end, [-1.0, 1.0][end]);
            bars.u[knot] += x * Scale(-2.0 * sign);
            bars.w[knot] += a * Scale(2.0 * sign);
            bars.t[knot] += sign * states.inner(knot, a, a);
            if states.tension != 0.0 {
                bars.u[knot] += v * Scale(2.0 * sign * states.tension);
                bars.t[knot] += sign * states.tension * states.inner(knot, v, v);
            }
        }
    }
    bars
}

/// The cost in the time of the curve, for that in units of the mean leg.
pub(super) fn cost_factor(states: &KnotStates) -> f64 {
    states.unit.powi(-3)
}

/// The linear equations of a spline.
pub(super) struct Linear<'a> {
    pub(super) states: &'a KnotStates,
    pub(super) given: [Given; 2],
    pub(super) pieces: &'a [LinearPiece],
    pub(super) system: &'a KnotSystem,
}

impl Linear<'_> {
    /// The change of the gradient of half the cost of a piece, in units of the mean leg, for `z` in its own time.
    pub(super) fn stiffness(&self, piece: usize, z: &State) -> State {
        let h = self.states.lengths[piece];
        let mut part = 0;
        self.pieces[piece].stiffness(z).map(|x| {
            let factor = h.powi(if part % 2 == 0 { -3 } else { -2 });
            part += 1;
            x * Scale(factor)
        })
    }

    /// The solution of the system at all knots: zero where velocities are given, the same at both ends of a closed curve.
    pub(super) fn solve(&self, mut right: Vec<Mat<f64>>) -> Vec<Mat<f64>> {
        let last = right.len() - 1;
        for (knot, given) in [0, last].into_iter().zip(self.given) {
            if given == Given::Velocity {
                right[knot].fill(0.0);
            }
        }
        let closed = self.given[0] == Given::OtherEnd;
        if closed {
            let end = right.pop().expect("two knots");
            right[0] += end;
        }
        let mut solution = self.system.solve(&right);
        if closed {
            solution.push(solution[0].clone());
        }
        solution
    }

    /// Takes what multipliers of the velocities make of the data from functions of these.
    fn subtract(&self, multipliers: &[Mat<f64>], bars: &mut Bars) {
        let states = self.states;
        for piece in 0..self.pieces.len() {
            let h = Scale(states.lengths[piece]);
            let [first, last] = [piece, piece + 1].map(|knot| &multipliers[knot]);
            let zero = Mat::zeros(first.nrows(), first.ncols());
            let z = [zero.clone(), first * h, zero, last * h];
            let [u0, w0, u1, w1] = self.stiffness(piece, &z);
            bars.u[piece] -= u0;
            bars.w[piece] -= w0;
            bars.u[piece + 1] -= u1;
            bars.w[piece + 1] -= w1;
            let [start, end] = states.ends[piece].each_ref().map(|state| &state[3]);
            bars.t[piece] += states.inner(piece, start, first);
            bars.t[piece + 1] -= states.inner(piece + 1, end, last);
        }
    }
}

/// Gradients with respect to the data from those by displacements and velocities; without a system those by velocities that are
/// free are zero.
pub(super) fn finished(
    states: &KnotStates,
    given: [Given; 2],
    mut bars: Bars,
    with: Option<&Linear<'_>>,
    factor: f64,
) -> Result<SplineGradient> {
    let count = states.count();
    let mut ends: [Option<Mat<f64>>; 2] = [None, None];
    if let Some(linear) = with {
        let multipliers = linear.solve(bars.w.clone());
        linear.subtract(&multipliers, &mut bars);
        for (end, sign) in [-1.0, 1.0].into_iter().enumerate() {
            if given[end] == Given::Acceleration {
                ends[end] = Some(&multipliers[end * (count - 1)] * Scale(sign));
            }
        }
    }
    for (end, given) in given.into_iter().enumerate() {
        if given == Given::Velocity {
            ends[end] = Some(bars.w[end * (count - 1)].clone());
        }
    }
    let times = (0..count).map(|knot| {
        let [_, v, a, _] = states.at(knot);
        let (u, w) = (&bars.u[knot], &bars.w[knot]);
        let rate = bars.t[knot] - states.inner(knot, v, u) - states.inner(knot, a, w);
        rate * factor / states.unit
    });
    let times: Vec<f64> = times.collect();
    let mut points: Vec<Mat<f64>> = (0..count)
        .map(|knot| lowered(states.point(knot), bars.u[knot].as_ref()) * Scale(factor))
        .collect();
    for (end, bar) in ends.iter_mut().enumerate() {
        let (Some(bar), Some(order)) = (bar.as_mut(), given[end].order()) else {
            continue;
        };
        let knot = end * (count - 1);
        let (s, y) = (states.point(knot), states.at(knot)[order].as_ref());
        let low = lowered(s, bar.as_ref()) * Scale(factor);
        points[knot] -= turned_transposed(s, low.as_ref(), y);
        *bar = low * Scale(states.unit.powi(order as i32));
    }
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
