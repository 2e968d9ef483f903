//! The equations of a spline through given points, and the step that would solve them in flat space.
//!
//! A leg of length `h` that starts with `(h v_j, x', x'')` must reach the next knot with the velocity `h v_{j+1}`; at a
//! knot, the covariant accelerations of both legs must agree. If space is flat along a leg, and `r, w` are its point
//! and velocity defects carried back to its start, then `p = -r - h dv_j` and `q = -w + h (dv_{j+1} - dv_j)` give
//!
//! ```math
//! dx' = 6 p - 2 q,\qquad dx'' = 6 q - 12 p
//! ```
//!
//! and the tridiagonal system of cubic splines remains for the changes of the velocities:
//!
//! ```math
//! \frac{2}{h_-} dv_{j-1} + \Bigl(\frac{4}{h_-} + \frac{4}{h_+}\Bigr) dv_j + \frac{2}{h_+} dv_{j+1}
//!     = -[x'] - \frac{6 r_- - 4 w_-}{h_-^2} - \frac{6 r_+ - 2 w_+}{h_+^2}
//! ```
//!
//! with vectors carried from knot to knot along the quasi-geodesics, and `[x']` the acceleration before the knot minus
//! the acceleration after it.

use super::chain::{Carrying, Chain, LegEnds, square};
use super::motion::Motion;
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::work::Work;
use crate::error::Result;
use crate::legs::Knots;
use crate::linalg::field::add;
use crate::solve::direction::Direction;
use crate::solve::tridiagonal::Tridiagonal;
use crate::spline::ends::Ends;

/// Vectors computed per leg: point defect, velocity defect, acceleration.
pub(crate) const VECTORS: usize = 3;

/// The equations of one chain.
pub(crate) struct Interpolation<'c, C> {
    pub(crate) chain: &'c C,
    pub(crate) knots: Knots<'c>,
    system: Tridiagonal<1>,
}

/// Residuals of the equations.
pub(crate) struct ChainResidual {
    pub(crate) leg_ends: LegEnds,
    /// Jumps of the covariant acceleration at the knots, per unit of time squared: before minus after; at an end, minus
    /// the given one.
    pub(crate) jumps: Vec<f64>,
    /// The largest defect of a leg or jump at a knot, in the time of the shorter leg there.
    pub(crate) size: f64,
}

impl<'c, C: Chain> Interpolation<'c, C> {
    pub(crate) fn new(chain: &'c C, ends: &'c Ends) -> Result<Self> {
        let knots = Knots::of_points(chain.lengths(), ends);
        Ok(Interpolation {
            chain,
            system: knots.flat_system()?,
            knots,
        })
    }

    /// The spline of flat space.
    ///
    /// # Errors
    /// The errors of carrying.
    pub(crate) fn start(&self) -> Result<Motion> {
        let knots = self.chain.lengths().len() + 1;
        let mut motion = Motion::zeros(self.chain.size(), knots);
        if let Ends::Open(ends) = self.knots.ends {
            for (knot, end) in [(0, &ends[0]), (knots - 1, &ends[1])] {
                if let Some(v) = end.velocity() {
                    motion.velocity_mut(knot).copy_from_slice(v);
                }
            }
        }
        let leg_ends = LegEnds::flat(self.chain, &motion, VECTORS)?;
        let step = self.flat_step(&self.residual_of(&motion, leg_ends))?;
        motion.add(1.0, &step);
        Ok(motion)
    }

    /// # Errors
    /// An error if a leg cannot be integrated; `Interrupted`.
    pub(crate) fn residual(
        &self,
        motion: &Motion,
        accuracy: Accuracy,
        work: &Work,
    ) -> Result<ChainResidual> {
        let leg_ends = LegEnds::of(self.chain, motion, VECTORS, accuracy, work)?;
        Ok(self.residual_of(motion, leg_ends))
    }

    fn residual_of(&self, motion: &Motion, leg_ends: LegEnds) -> ChainResidual {
        let d = self.chain.size();
        let accelerations = |leg: usize| [&motion.derivatives(leg)[..d], leg_ends.vector(leg, 2)];
        let jumps = self.knots.jumps::<f64>(d, accelerations);
        let mut size = leg_ends.defect;
        for (knot, jump) in jumps.chunks_exact(d).enumerate() {
            let jump = self.knots.shortest(knot).powi(2) * square(jump).sqrt();
            // NaN is propagated.
            size = if jump <= size { size } else { jump };
        }
        ChainResidual {
            leg_ends,
            jumps,
            size,
        }
    }

    /// Square root of the sum of squares of all residuals, in the time of the legs.
    pub(crate) fn total(&self, found: &ChainResidual) -> f64 {
        let d = self.chain.size();
        let legs = (0..self.chain.lengths().len()).map(|leg| {
            square(found.leg_ends.vector(leg, 0)) + square(found.leg_ends.vector(leg, 1))
        });
        let jumps = found.jumps.chunks_exact(d).enumerate();
        let jumps = jumps.map(|(knot, jump)| self.knots.shortest(knot).powi(4) * square(jump));
        (legs.sum::<f64>() + jumps.sum::<f64>()).sqrt()
    }

    /// The right-hand sides of a step, one vector per knot: minus the jumps, and what `add` contributes at free knots for the
    /// legs before and after them.
    pub(crate) fn right_sides(
        &self,
        found: &ChainResidual,
        mut add: impl FnMut([Option<usize>; 2], &mut [f64]),
    ) -> Vec<f64> {
        let mut right: Vec<f64> = found.jumps.iter().map(|jump| -jump).collect();
        for (knot, right) in right.chunks_exact_mut(self.chain.size()).enumerate() {
            if !self.knots.is_fixed(knot) {
                add(self.knots.legs_at(knot), right);
            }
        }
        right
    }

    /// The change of all unknowns that would solve the equations in flat space.
    ///
    /// # Errors
    /// The errors of carrying.
    pub(crate) fn flat_step(&self, found: &ChainResidual) -> Result<Vec<f64>> {
        let (d, lengths) = (self.chain.size(), self.chain.lengths());
        let mut worker = self.chain.worker();
        let mut right = self.right_sides(found, |[before, after], right| {
            if let Some(leg) = before {
                let (r, w) = (found.leg_ends.vector(leg, 0), found.leg_ends.vector(leg, 1));
                add(right, -6.0 * lengths[leg].powi(-2), r);
                add(right, 4.0 * lengths[leg].powi(-2), w);
            }
            if let Some(leg) = after {
                add(
                    right,
                    -6.0 * lengths[leg].powi(-2),
                    found.leg_ends.point_defect_back(leg),
                );
                add(
                    right,
                    2.0 * lengths[leg].powi(-2),
                    found.leg_ends.velocity_defect_back(leg),
                );
            }
        });
        let mut carried = Carrying {
            chain: self.chain,
            worker: &mut worker,
        };
        self.system.solve(&mut carried, &mut right)?;
        if matches!(self.knots.ends, Ends::Periodic) {
            right.extend_from_within(..d);
        }
        let mut step = Motion::zeros(d, lengths.len() + 1);
        step.entries[..right.len()].copy_from_slice(&right);
        let mut carried = vec![0.0; d];
        for (leg, &h) in lengths.iter().enumerate() {
            let next = &right[d * (leg + 1)..][..d];
            self.chain
                .carry_into(&mut worker, leg, Direction::Backward, next, &mut carried)?;
            let (r, w) = (
                found.leg_ends.point_defect_back(leg),
                found.leg_ends.velocity_defect_back(leg),
            );
            let (first, second) = step.derivatives_mut(leg).split_at_mut(d);
            for i in 0..d {
                let from = h * right[d * leg + i];
                let p = -r[i] - from;
                let q = -w[i] + h * carried[i] - from;
                first[i] = 6.0 * p - 2.0 * q;
                second[i] = 6.0 * q - 12.0 * p;
            }
        }
        Ok(step.entries)
    }
}
