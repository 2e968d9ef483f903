//! The equations of a spline linearised, with exact derivatives of all legs at once.
//!
//! A Newton step solves every leg for its `(x', x'')` in terms of the two velocities. The remaining system is block
//! tridiagonal in the velocities, cyclic for a closed curve, so a step takes time linear in the number of knots. The
//! elimination is that of `src/shooting/chains/newton_step.rs`, for integrated legs.

use faer::{Mat, MatRef, Scale};

use super::chain::Chain;
use super::interpolation::{ChainResidual, Interpolation};
use super::motion::Motion;
use crate::cubic::taylor::march::Accuracy;
use crate::error::Result;
use crate::linalg::decomp::solve_matrix;
use crate::solve::block_tridiagonal::{BlockTridiagonal, Factors};
use crate::spline::ends::Ends;
use crate::threads;

/// Microseconds of the derivative of a leg, which takes as long as ten integrations: always worth the pool.
const DERIVATIVE: f64 = 100.0;

/// Integration accuracy of derivatives, relative to the residual.
const DERIVATIVE_SHARE: f64 = 1e-2;

/// The linearised equations, factored for any right-hand side.
pub(crate) struct LinearisedChain {
    legs: Vec<EliminatedLeg>,
    velocities: Factors,
}

/// The change of a leg's `(x', x'')` at its start is `before dv_j + after dv_{j+1}` minus `inverse` times the leg's
/// defects. `last_by_velocities` is the derivative of its last acceleration with respect to the two velocities,
/// `last_by_start` that with respect to `(x', x'')`.
struct EliminatedLeg {
    inverse: Mat<f64>,
    before: Mat<f64>,
    after: Mat<f64>,
    last_by_start: Mat<f64>,
    last_by_velocities: [Mat<f64>; 2],
}

impl<C: Chain> Interpolation<'_, C> {
    /// The linearisation at a motion; `None` if derivatives are not available or the linear equations are singular.
    ///
    /// # Errors
    /// As [`Chain::derivative`].
    pub(crate) fn linearised(
        &self,
        motion: &Motion,
        found: &ChainResidual,
    ) -> Result<Option<LinearisedChain>> {
        let accuracy = Accuracy::of_tolerance(DERIVATIVE_SHARE * found.size.min(1.0));
        let legs = threads::map(
            self.chain.lengths().len(),
            DERIVATIVE,
            || self.chain.worker(),
            |worker, leg| {
                let h = self.chain.lengths()[leg];
                let start = motion.start(leg, h);
                let derivative = self.chain.derivative(worker, leg, &start, accuracy)?;
                Ok(derivative.and_then(|derivative| EliminatedLeg::new(&derivative, h)))
            },
        );
        let legs: Option<Vec<EliminatedLeg>> = legs?.into_iter().collect();
        let Some(legs) = legs else {
            return Ok(None);
        };
        let rows = self.rows(&legs);
        let velocities = match self.knots.ends {
            Ends::Periodic => rows.factored_cyclic(),
            Ends::Open(_) => rows.factored(),
        };
        Ok(velocities.map(|velocities| LinearisedChain { legs, velocities }))
    }

    /// The system for the changes of the velocities.
    fn rows(&self, legs: &[EliminatedLeg]) -> BlockTridiagonal {
        let (d, count) = (self.chain.size(), self.knots.count());
        let mut rows = BlockTridiagonal::zeros(count, d);
        for knot in 0..count {
            let [before, after] = self.knots.legs_at(knot);
            let block = knot * d * d..(knot + 1) * d * d;
            if self.knots.is_fixed(knot) {
                for p in 0..d {
                    rows.diagonal[block.start + p * d + p] = 1.0;
                }
                continue;
            }
            if let Some(leg) = before {
                let [first, last] = &legs[leg].last_by_velocities;
                let Scale(rate) = self.rate(leg);
                add_rows(rate, first.as_ref(), &mut rows.below[block.clone()]);
                add_rows(rate, last.as_ref(), &mut rows.diagonal[block.clone()]);
            }
            if let Some(leg) = after {
                let Scale(rate) = self.rate(leg);
                let [here, next] = [&legs[leg].before, &legs[leg].after].map(|a| a.subrows(0, d));
                add_rows(-rate, here, &mut rows.diagonal[block.clone()]);
                add_rows(-rate, next, &mut rows.above[block]);
            }
        }
        rows
    }

    /// Factor from accelerations in the time of a leg to accelerations per unit of time squared.
    fn rate(&self, leg: usize) -> Scale<f64> {
        Scale(self.chain.lengths()[leg].powi(-2))
    }

    /// The change of all unknowns that solves the linear equations.
    pub(crate) fn linear_step(&self, linear: &LinearisedChain, found: &ChainResidual) -> Vec<f64> {
        let (d, legs) = (self.chain.size(), linear.legs.len());
        let mut step = Motion::zeros(d, legs + 1);
        for (i, leg) in linear.legs.iter().enumerate() {
            let (inverse, derivatives) = (leg.inverse.as_ref(), step.derivatives_mut(i));
            for (part, which) in [(0, 0), (d, 1)] {
                let columns = inverse.subcols(part, d).to_owned();
                add_product(-1.0, &columns, found.leg_ends.vector(i, which), derivatives);
            }
        }
        let mut right = self.right_sides(found, |[before, after], right| {
            if let Some(leg) = before {
                let Scale(rate) = self.rate(leg);
                add_product(
                    -rate,
                    &linear.legs[leg].last_by_start,
                    step.derivatives(leg),
                    right,
                );
            }
            if let Some(leg) = after {
                let Scale(rate) = self.rate(leg);
                for (right, first) in right.iter_mut().zip(step.derivatives(leg)) {
                    *right += rate * first;
                }
            }
        });
        linear.velocities.solve(&mut right);
        if matches!(self.knots.ends, Ends::Periodic) {
            right.extend_from_within(..d);
        }
        for (i, leg) in linear.legs.iter().enumerate() {
            let derivatives = step.derivatives_mut(i);
            add_product(1.0, &leg.before, &right[d * i..], derivatives);
            add_product(1.0, &leg.after, &right[d * (i + 1)..], derivatives);
        }
        step.entries[..right.len()].copy_from_slice(&right);
        step.entries
    }
}

impl EliminatedLeg {
    /// Built from the derivative of distance, velocity and acceleration with respect to the start; `None` if it is
    /// singular.
    fn new(derivative: &Mat<f64>, h: f64) -> Option<Self> {
        let d = derivative.nrows() / 3;
        let (ends, acceleration) = derivative.as_ref().split_at_row(2 * d);
        let identity: Mat<f64> = Mat::identity(2 * d, 2 * d);
        let inverse = solve_matrix(ends.subcols(d, 2 * d), identity.as_ref())?;
        let before = &inverse * ends.subcols(0, d) * Scale(-h);
        let after = inverse.as_ref().subcols(d, d) * Scale(h);
        let (by_velocity, last_by_start) = acceleration.split_at_col(d);
        Some(EliminatedLeg {
            last_by_velocities: [
                last_by_start * &before + by_velocity * Scale(h),
                last_by_start * &after,
            ],
            last_by_start: last_by_start.to_owned(),
            inverse,
            before,
            after,
        })
    }
}

/// `out += factor a`, in row-major order.
fn add_rows(factor: f64, a: MatRef<'_, f64>, out: &mut [f64]) {
    for (row, out) in a.row_iter().zip(out.chunks_exact_mut(a.ncols())) {
        for (out, a) in out.iter_mut().zip(row.iter()) {
            *out += factor * a;
        }
    }
}

/// `out += factor a x`.
fn add_product(factor: f64, a: &Mat<f64>, x: &[f64], out: &mut [f64]) {
    for (column, x) in a.col_iter().zip(x) {
        for (out, a) in out.iter_mut().zip(column.iter()) {
            *out += factor * a * x;
        }
    }
}
