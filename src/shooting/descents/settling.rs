//! The stationary chain near the end of a descent: by Newton's method, up or down the cost, to round-off.
//!
//! A spline need not be a minimum of the cost: with given accelerations at its ends, some are saddle points, which a
//! descent passes by.

use super::descent_state::FARTHEST;
use super::free_chain::FreeChain;
use crate::error::Result;
use crate::legs::{Options, Progress};
use crate::linalg::field::Field;
use crate::report::StopReason;
use crate::solve::line_search::backtracked;
use crate::space::Homogeneous;

/// Number of lengths of a step that are tried.
const LENGTHS: i32 = 4;

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// Takes Newton's steps, shortened until the gradient decreases, until it is below the tolerance, and a last one.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn settle(
        &mut self,
        progress: &mut Progress,
        options: &Options<'_>,
    ) -> Result<StopReason> {
        self.refine();
        self.evaluate();
        (options.may_go_on)(self.products_of_equations());
        loop {
            self.linearise();
            self.meet_ends(self.met());
            self.set_forces();
            if self.is_at_rest(progress, options) {
                self.step_to_round_off();
                self.is_at_rest(progress, options);
                return Ok(StopReason::Converged);
            }
            if let Some(reason) = progress.step(self.products_of_equations(), options)? {
                return Ok(reason);
            }
            if let Some(reason) = self.step_to_rest()? {
                return Ok(reason);
            }
        }
    }

    /// Takes Newton's step, or the first part of it that reduces the gradient; returns a reason if there is none.
    fn step_to_rest(&mut self) -> Result<Option<StopReason>> {
        let (before, rest) = (self.descent_state(), self.rest());
        let Some(step) = before.newton_step(FARTHEST) else {
            return Ok(Some(StopReason::SingularJacobian));
        };
        let found = backtracked(rest, LENGTHS, |share| {
            if share < 1.0 {
                self.restore(&before);
            }
            let change: Vec<f64> = step.change.iter().map(|x| share * x).collect();
            self.follow(&change);
            self.evaluate();
            self.meet_ends(self.met());
            self.set_forces();
            Ok(Some((self.rest(), ())))
        })?;
        Ok(found.is_none().then_some(StopReason::Stagnated))
    }
}
