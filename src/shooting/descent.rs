//! Descent of a chain with free inner knots to a curve of least cost, by damped Newton steps.
//!
//! Between the knots the legs are cubics, so the cost is a function of the knots alone. A step solves `(H + lambda D) s = -g`
//! with the gradient `g`, the second derivative `H` and the one of flat space `D`, which is positive definite; `lambda` grows
//! until `H + lambda D` is positive definite too and the cost falls. Flat cubics along any curve with the data are a start.
//!
//! # Source
//! Nocedal, Wright (2006), "Numerical Optimization", 2nd ed., sec. 4.1, 10.3 (Levenberg-Marquardt steps).

use super::free_chain::{FreeChain, products_of_step};
use crate::error::Result;
use crate::legs::{Options, Progress};
use crate::linalg::field::{Field, larger};
use crate::report::StopReason;
use crate::solve::block_cholesky::SymmetricBlocks;
use crate::space::Homogeneous;

const SOLVER: &str = "descent of a chain of Riemannian cubics";

/// The first damping, its factors after a step that fails and one that succeeds at once, and the least and the largest one.
/// With a first one of 0.1 and a least one of 0.05 one of 80 problems with slow ends is lost: its minimum lies in a narrow
/// valley.
const DAMPING: f64 = 0.01;
const RAISE: f64 = 4.0;
const LOWER: f64 = 0.25;
const LEAST: f64 = 0.003;
const MOST: f64 = 1e6;

/// Longest displacement of a knot, in radians, and change of a velocity, in the time of a leg, by a step.
const FARTHEST: f64 = 1.0;

/// Shares of the decrease that the second derivative predicts: from the first one on a step counts as one that leads down, from
/// the second on the damping falls.
const DOWN: f64 = 1e-2;
const WELL: f64 = 0.5;

/// Where a step without damping lowers the cost by less than this share, the difference of costs says nothing, and the step is
/// taken.
const BELOW_ROUND_OFF: f64 = 1e-7;

/// After a step without damping no more than so many times its decrease is still to come.
const LEFT: f64 = 4.0;

/// Costs are compared where what is left of the equations of the legs is at most this, or its square at most this share of the
/// predicted decrease; corrections at most to get there, and what they start from at most.
const MET: f64 = 1e-6;
const MET_SHARE: f64 = 1e-2;
const CORRECTIONS: usize = 4;
const HOPELESS: f64 = 1.0;

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// Steps down to a gradient of the tolerance, or until it is clear that the cost of the curve on `[0, 1]` stays above a
    /// bound.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(super) fn descend(
        &mut self,
        progress: &mut Progress,
        below: f64,
        options: &Options<'_>,
    ) -> Result<StopReason> {
        let mut damping = 0.0;
        self.evaluate();
        loop {
            // In the first pass there are no linear equations yet, and the forces are those of the legs as they are.
            self.set_forces();
            if self.is_at_rest(progress, options) {
                return Ok(StopReason::Converged);
            }
            if let Some(reason) = progress.step(products_of_step(self.space, self.legs), options)? {
                return Ok(reason);
            }
            self.linearise();
            self.meet_ends(MET);
            self.set_forces();
            if self.is_at_rest(progress, options) {
                return Ok(StopReason::Converged);
            }
            match self.step_down(&mut damping, options)? {
                Some(decrease) if !self.ends_above(below, damping, decrease) => (),
                _ => return Ok(StopReason::Stagnated),
            }
        }
    }

    /// Whether gradient and defect are below the tolerance.
    fn is_at_rest(&self, progress: &mut Progress, options: &Options<'_>) -> bool {
        let size = size(&self.gradient(), self.defect);
        size <= progress.set(size, self.largest_bend(), options.tolerance)
    }

    /// Corrects the legs until they meet the knots.
    fn meet_ends(&mut self, defect: f64) {
        for _ in 0..CORRECTIONS {
            if !(defect..=HOPELESS).contains(&self.defect) {
                break;
            }
            self.correct();
            self.evaluate();
        }
    }

    /// Whether the cost ends above a bound, as far as a step without damping and the decrease that it promised tell.
    fn ends_above(&self, bound: f64, damping: f64, decrease: f64) -> bool {
        damping == 0.0 && self.whole_cost(self.cost - LEFT * decrease) > bound
    }

    /// Takes a step that lowers the cost, with more and more damping, and returns the decrease that it promised; `None` where
    /// there is no such step, or no more work may be done.
    ///
    /// # Errors
    /// `Interrupted`.
    fn step_down(&mut self, damping: &mut f64, options: &Options<'_>) -> Result<Option<f64>> {
        let gradient = self.gradient();
        let [exact, flat] = self.second_derivatives();
        let (before, cost, first) = (self.state.clone(), self.cost, *damping);
        while *damping <= MOST {
            options.interrupt.check(SOLVER)?;
            if !(options.may_go_on)(self.products_of_trial()) {
                return Ok(None);
            }
            if let Some((step, predicted)) = newton_step(&gradient, [&exact, &flat], *damping) {
                self.follow(&step);
                self.evaluate();
                self.meet_ends((MET_SHARE * predicted).sqrt());
                let share = (cost - self.cost) / predicted;
                let is_small = *damping == 0.0 && predicted <= BELOW_ROUND_OFF * cost;
                if self.defect <= HOPELESS && (is_small || share >= DOWN) {
                    if share > WELL && *damping <= first {
                        *damping = if *damping < LEAST {
                            0.0
                        } else {
                            LOWER * *damping
                        };
                    }
                    return Ok(Some(predicted));
                }
                self.state = before.clone();
                self.set_knots();
                self.evaluate();
            }
            *damping = (RAISE * *damping).max(DAMPING);
        }
        Ok(None)
    }
}

/// A damped step, and how much it lowers the cost; `None` where the matrix is not positive definite or the step too long.
fn newton_step(
    gradient: &[f64],
    [exact, flat]: [&SymmetricBlocks; 2],
    damping: f64,
) -> Option<(Vec<f64>, f64)> {
    let factor = exact.plus(damping, flat).factored()?;
    let mut step: Vec<f64> = gradient.iter().map(|g| -g).collect();
    factor.solve(&mut step);
    let slope: f64 = gradient.iter().zip(&step).map(|(g, s)| g * s).sum();
    let predicted = -slope - 0.5 * exact.form(&step);
    (size(&step, 0.0) <= FARTHEST).then_some((step, predicted))
}

/// The largest of all entries and another size.
fn size(entries: &[f64], other: f64) -> f64 {
    entries.iter().fold(other, |size, x| larger(size, x.abs()))
}
