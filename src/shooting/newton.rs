//! Newton's method for a chain, with linear equations that are kept as long as steps are fast.

use super::chain::Chain;
use super::orders::Orders;
use crate::error::Result;
use crate::legs::{Options, Progress};
use crate::linalg::field::Field;
use crate::report::StopReason;
use crate::space::Homogeneous;

/// The linear equations are kept as long as a step leaves no more than this share of the residual. With 0.1 splines through 50 to
/// 400 points take 1.1 times as long, with 0.003 1.5 times.
const FAST: f64 = 0.03;

/// A step that leaves more is the last one; with 0.5 the first step from rest may be.
const SLOW: f64 = 0.9;

impl<T: Field, S: Homogeneous> Chain<'_, T, S> {
    /// Iterates down to the tolerance, with series that have more terms as the residual falls.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(super) fn newton(
        &mut self,
        progress: &mut Progress,
        options: &Options<'_>,
    ) -> Result<StopReason> {
        let mut orders = Orders::first();
        let mut is_fast = false;
        self.evaluate(orders);
        loop {
            let goal = progress.set(self.size, self.largest_bend(), options.tolerance);
            if self.size <= goal {
                if orders.are_last() && self.tail() <= orders.accuracy {
                    return Ok(StopReason::Converged);
                }
                if orders.are_last() && self.is_longest() {
                    return Ok(StopReason::Stagnated);
                }
                orders = Orders::last();
                self.evaluate(orders);
                continue;
            }
            let mut products = self.products_of_series(orders);
            if !is_fast {
                products += self.products_of_derivative();
            }
            if let Some(reason) = progress.step(products, options)? {
                return Ok(reason);
            }
            if !is_fast && !self.linearise() {
                return Ok(StopReason::SingularJacobian);
            }
            let before = self.size;
            if !self.set_step() {
                return Ok(StopReason::Stagnated);
            }
            self.advance(orders);
            let leads_down = self.size <= SLOW * before || self.size <= goal;
            if !leads_down {
                return Ok(StopReason::Stagnated);
            }
            is_fast = self.size <= FAST * before;
            orders = Orders::after(self.size);
        }
    }

    /// One more step, after which nothing is evaluated any more: it takes what the tolerance leaves down to round-off, since
    /// steps leave a hundredth.
    pub(super) fn step_blindly(&mut self) {
        if self.factors.is_some() && self.set_step() {
            self.follow_step();
        }
    }
}
