//! Newton's method for a chain, with linear equations that are kept as long as steps are fast.

use super::chain::{Chain, GroupProgress};
use super::orders::Orders;
use crate::error::Result;
use crate::legs::{Options, Progress};
use crate::linalg::field::Field;
use crate::report::StopReason;
use crate::space::Homogeneous;

const SOLVER: &str = "chain of Riemannian cubics";

/// The linear equations of a group of legs are kept as long as a step leaves no more than this share of what is left there. With
/// 0.1 splines through 50 to 400 points take 1.1 times as long, with 0.003 1.5 times.
const FAST: f64 = 0.03;

/// A whole step that leaves more is shortened; with 0.5 the first step from rest may be.
const SLOW: f64 = 0.9;

/// Halvings of a step before it is given up.
const MAX_HALVINGS: i32 = 6;

/// Legs that move by less than this share of the goal are not evaluated again.
const STILL: f64 = 0.01;

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
        let (mut is_last, mut has_all_terms) = (false, false);
        self.evaluate(0.0, is_last);
        loop {
            let goal = progress.set(self.size, self.largest_bend(), options.tolerance);
            if self.size <= goal {
                if is_last && self.tail() <= Orders::last().accuracy {
                    return Ok(StopReason::Converged);
                }
                if is_last && self.is_longest() {
                    return Ok(StopReason::Stagnated);
                }
                is_last = true;
                self.evaluate(0.0, is_last);
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
            if self.descend(goal, is_last, options)? {
                continue;
            }
            if has_all_terms {
                return Ok(StopReason::Stagnated);
            }
            // What is left may be what the series leave out.
            has_all_terms = true;
            self.evaluate(0.0, has_all_terms);
            for group in &mut self.groups {
                group.progress.is_stale = true;
            }
        }
    }

    /// Follows the step as far as it leads down; `false` where it does not.
    ///
    /// # Errors
    /// `Interrupted`.
    fn descend(&mut self, goal: f64, is_last: bool, options: &Options<'_>) -> Result<bool> {
        let before = self.size;
        for group in &mut self.groups {
            group.progress.before = group.progress.size;
        }
        let mut share = 1.0;
        self.follow_step(share);
        for halving in 0..MAX_HALVINGS {
            self.evaluate(STILL * goal, is_last);
            let enough = if halving == 0 { SLOW } else { 1.0 };
            if self.size < enough * before || self.size <= goal {
                let is_whole = halving == 0;
                for group in &mut self.groups {
                    let GroupProgress { size, before, .. } = group.progress;
                    group.progress.is_stale = size > goal && (!is_whole || size > FAST * before);
                }
                return Ok(true);
            }
            options.interrupt.check(SOLVER)?;
            share *= 0.5;
            self.follow_step(-share);
            for group in &mut self.groups {
                group.progress.moved = f64::INFINITY;
            }
        }
        Ok(false)
    }

    /// One more step, after which nothing is evaluated any more: it takes what the tolerance leaves down to round-off, since
    /// steps leave a hundredth.
    pub(super) fn step_blindly(&mut self) {
        if self.factors.is_some() && self.set_step() {
            self.follow_step(1.0);
        }
    }
}
