//! The stationary chain near the end of a descent: by Newton's method, up or down the cost, to round-off.
//!
//! A spline need not be a minimum of the cost: with given accelerations at its ends, some are saddle points, which a
//! descent passes by.

use super::free_chain::FreeChain;
use crate::error::Result;
use crate::legs::{Options, Progress};
use crate::linalg::field::Field;
use crate::report::StopReason;
use crate::space::Homogeneous;

use super::descent_state::FARTHEST;

/// Steps that leave more than this fraction of the gradient do not converge.
const SLOW: f64 = 0.5;

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// Takes Newton's steps until the gradient is below the tolerance and no longer decreases.
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
        let mut last = f64::INFINITY;
        loop {
            if let Some(reason) = progress.step(self.products_of_equations(), options)? {
                return Ok(reason);
            }
            self.linearise();
            self.meet_ends(self.met());
            self.set_forces();
            if self.is_at_rest(progress, options) {
                self.step_to_round_off();
                self.is_at_rest(progress, options);
                return Ok(StopReason::Converged);
            }
            let rest = self.rest();
            if rest.is_nan() || rest > SLOW * last {
                return Ok(StopReason::Stagnated);
            }
            last = rest;
            let Some(step) = self.descent_state().newton_step(FARTHEST) else {
                return Ok(StopReason::SingularJacobian);
            };
            self.follow(&step.change);
            self.evaluate();
        }
    }
}
