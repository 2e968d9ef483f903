//! The cubic spline of positions.

use nalgebra::Vector3;

use crate::error::{Error, Result};
use crate::solve::block_tridiagonal::BlockTridiagonal;

/// The condition at an end, per unit of time.
#[derive(Debug, Clone, Copy)]
pub(super) enum PositionEnd {
    Velocity(Vector3<f64>),
    Acceleration(Vector3<f64>),
}

/// Positions at knots, and the velocities of the cubic spline there.
///
/// ```math
/// \frac{2 v_{i-1} + 4 v_i}{h_-} + \frac{4 v_i + 2 v_{i+1}}{h_+}
///     = 6 \Bigl( \frac{\Delta_-}{h_-^2} + \frac{\Delta_+}{h_+^2} \Bigr)
/// ```
#[derive(Debug)]
pub(super) struct PositionSpline {
    positions: Vec<Vector3<f64>>,
    velocities: Vec<Vector3<f64>>,
}

impl PositionSpline {
    /// The spline through positions at times already checked; `ends` is `None` for a closed curve.
    ///
    /// # Errors
    /// `Overflow`.
    pub(super) fn new(
        knots: &[f64],
        positions: &[Vector3<f64>],
        ends: Option<[PositionEnd; 2]>,
    ) -> Result<Self> {
        let legs = knots.len() - 1;
        let count = legs + usize::from(ends.is_some());
        let mut system = BlockTridiagonal::zeros(count, 1);
        let mut right = vec![Vector3::zeros(); count];
        for leg in 0..legs {
            let h = knots[leg + 1] - knots[leg];
            let next = (leg + 1) % count;
            // Multiply one factor at a time: the square of a length may overflow.
            let share = (positions[leg + 1] - positions[leg]) / h * (6.0 / h);
            system.diagonal[leg] += 4.0 / h;
            system.diagonal[next] += 4.0 / h;
            system.above[leg] += 2.0 / h;
            system.below[next] += 2.0 / h;
            right[leg] += share;
            right[next] += share;
        }
        for (end, knot, sign) in [(0, 0, -1.0), (1, legs, 1.0)] {
            match ends.map(|ends| ends[end]) {
                None => {}
                Some(PositionEnd::Acceleration(a)) => right[knot] += a * sign,
                Some(PositionEnd::Velocity(v)) => {
                    system.diagonal[knot] = 1.0;
                    (system.above[knot], system.below[knot]) = (0.0, 0.0);
                    right[knot] = v;
                }
            }
        }
        let factors = match ends {
            Some(_) => system.factored(),
            None => system.factored_cyclic(),
        };
        let overflow = Error::Overflow {
            quantity: "spline of positions",
        };
        let Some(factors) = factors else {
            return Err(overflow);
        };
        let mut velocities = vec![Vector3::zeros(); count];
        for axis in 0..3 {
            let mut column: Vec<f64> = right.iter().map(|vector| vector[axis]).collect();
            factors.solve(&mut column);
            for (velocity, x) in velocities.iter_mut().zip(column) {
                velocity[axis] = x;
            }
        }
        if ends.is_none() {
            velocities.push(velocities[0]);
        }
        if velocities.iter().any(|v| !v.iter().all(|x| x.is_finite())) {
            return Err(overflow);
        }
        Ok(PositionSpline {
            positions: positions.to_vec(),
            velocities,
        })
    }

    /// The position or a derivative of order up to 3, at time `s` of a leg of duration `h`; on the first and the last
    /// leg `s` may lie outside `[0, 1]`.
    pub(super) fn derivative(&self, leg: usize, s: f64, h: f64, order: usize) -> Vector3<f64> {
        let step = self.positions[leg + 1] - self.positions[leg];
        let [v, w] = [leg, leg + 1].map(|knot| self.velocities[knot] * h);
        // p + v s + b s^2 + c s^3.
        let (b, c) = (step * 3.0 - v * 2.0 - w, v + w - step * 2.0);
        let value = match order {
            0 => self.positions[leg] + (v + (b + c * s) * s) * s,
            1 => v + (b * 2.0 + c * (3.0 * s)) * s,
            2 => b * 2.0 + c * (6.0 * s),
            _ => c * 6.0,
        };
        (0..order).fold(value, |value, _| value / h)
    }
}
