//! Newton's method for a chain, with linear equations that are kept as long as convergence is fast.

use super::chain::{GroupProgress, SeriesChain};
use crate::error::Result;
use crate::legs::{Options, Progress};
use crate::linalg::field::Field;
use crate::report::StopReason;
use crate::shooting::taylor::orders::Orders;
use crate::space::Homogeneous;

/// The linear equations of a group of legs are kept as long as a step leaves at most this fraction of the group's
/// residual. With 0.1, splines through 50 to 400 points take 1.1 times as long, with 0.003 1.5 times.
const FAST: f64 = 0.03;

/// In three rows, no equations are kept after a step from a larger residual of the chain, which most flat starts have.
/// If they are, splines through 10, 50, 200 and 2000 rotations up to 1.2 rad apart take 1.0, 1.09, 1.0 and 1.1 times
/// as long.
const FAR_IN_THREE_ROWS: f64 = 0.5;

/// A step that leaves a larger fraction of the residual is rejected. Shorter steps do not help: with up to six
/// halvings, splines through 400 rotations and their costs are the same.
const SLOW: f64 = 0.9;

/// Legs that move by less than this fraction of the goal are not evaluated again.
const STILL: f64 = 0.01;

impl<T: Field, S: Homogeneous> SeriesChain<'_, T, S> {
    /// Iterates to the tolerance, with series whose number of terms grows as the residual falls.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn newton(
        &mut self,
        progress: &mut Progress,
        options: &Options<'_>,
    ) -> Result<StopReason> {
        let (mut is_last, mut has_all_terms) = (false, false);
        self.evaluate(0.0, is_last);
        loop {
            let goal = progress.set(self.size, self.largest_derivative(), options.tolerance);
            if self.size <= goal {
                if is_last && self.tail() <= Orders::last().accuracy {
                    return Ok(StopReason::Converged);
                }
                if is_last && self.is_longest() {
                    return Ok(StopReason::Stagnated);
                }
                is_last = true;
                self.evaluate(STILL * goal, is_last);
                continue;
            }
            is_last = has_all_terms;
            let products = self.products_of_series() + self.products_of_derivative();
            if let Some(reason) = progress.step(products, options)? {
                return Ok(reason);
            }
            if !self.linearise() {
                return Ok(StopReason::SingularJacobian);
            }
            if !self.set_step() {
                return Ok(StopReason::Stagnated);
            }
            if self.follow_down(goal, is_last) {
                continue;
            }
            if has_all_terms {
                return Ok(StopReason::Stagnated);
            }
            // The residual may be dominated by truncation.
            has_all_terms = true;
            self.evaluate(0.0, has_all_terms);
            for group in &mut self.groups {
                group.progress.is_stale = true;
            }
        }
    }

    /// Takes the step if it reduces the residual; otherwise returns `false`.
    fn follow_down(&mut self, goal: f64, is_last: bool) -> bool {
        let before = self.size;
        for group in &mut self.groups {
            group.progress.before = group.progress.size;
        }
        self.follow_step(1.0);
        self.evaluate(STILL * goal, is_last);
        if self.size < SLOW * before || self.size <= goal {
            let kept = match self.space.size() {
                3 if before > FAR_IN_THREE_ROWS => 0.0,
                _ => FAST,
            };
            for group in &mut self.groups {
                let GroupProgress { size, before, .. } = group.progress;
                group.progress.is_stale = size > goal && size > kept * before;
            }
            return true;
        }
        self.follow_step(-1.0);
        for group in &mut self.groups {
            group.progress.moved = f64::INFINITY;
        }
        false
    }

    /// Takes one more step without evaluating afterwards: since a step leaves a hundredth of the residual, it reduces
    /// the tolerance to round-off.
    pub(crate) fn step_blindly(&mut self) {
        if self.factors.is_some() && self.set_step() {
            self.follow_step(1.0);
        }
    }
}
