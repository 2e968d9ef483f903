//! Descent of a chain with free knots to a local minimum of the cost, by damped Newton steps.
//!
//! Between the knots the legs are cubics, so the cost is a function of the knots alone. A step solves `(H + lambda D) s
//! = -g` with the gradient `g`, the second derivative `H` and its positive definite counterpart `D` in flat space;
//! `lambda` is increased until `H + lambda D` is positive definite too and the cost decreases. Flat cubics along any
//! curve with the given data can be the start.
//!
//! # Source
//! Nocedal, Wright (2006), "Numerical Optimization", 2nd ed., sec. 4.1, 10.3 (Levenberg-Marquardt steps).

use super::chain_knots::ChainKnots;
use super::descent_state::{DAMPING, DescentStep, FARTHEST, LOWER, MOST, RAISE};
use super::free_chain::FreeChain;
use crate::error::Result;
use crate::legs::{Options, Progress};
use crate::linalg::field::Field;
use crate::report::StopReason;
use crate::space::Homogeneous;

const SOLVER: &str = "descent of a chain of Riemannian cubics";

/// Smallest positive damping; smaller values become zero. With 0.05, and a first damping of 0.1, one of 80 problems
/// with slow ends is not solved.
const LEAST: f64 = 0.003;

/// The damping decreases if a step achieves at least this fraction of the decrease predicted by the second derivative.
const WELL: f64 = 0.5;

/// Steps up to this length do not leave the floor of a valley: the gradient changes by its square.
const SHORTEST: f64 = 1e-9;

/// After a step without damping, at most this many times its decrease can remain.
const LEFT: f64 = 4.0;

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// Takes steps until the gradient is below the tolerance, until the cost clearly stays above a bound, or until the
    /// knots are near known ones.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn descend(
        &mut self,
        progress: &mut Progress,
        (below, known): (f64, &[&ChainKnots]),
        options: &Options<'_>,
    ) -> Result<StopReason> {
        let mut damping = 0.0;
        self.evaluate();
        loop {
            let (space, knots) = (self.space, &self.state.knots);
            if known.iter().any(|known| known.is_near(space, knots)) {
                return Ok(StopReason::Stagnated);
            }
            // In the first pass there may be no linear equations yet, and the forces are those of the current legs.
            self.set_forces();
            if self.is_at_rest(progress, options) {
                self.step_to_round_off();
                return Ok(StopReason::Converged);
            }
            if let Some(reason) = progress.step(self.products_of_equations(), options)? {
                return Ok(reason);
            }
            self.linearise();
            self.meet_ends(self.met());
            self.set_forces();
            if self.is_at_rest(progress, options) {
                self.step_to_round_off();
                return Ok(StopReason::Converged);
            }
            match self.step_down(&mut damping, options)? {
                Some(decrease) if !self.ends_above(below, damping, decrease) => (),
                _ => return Ok(StopReason::Stagnated),
            }
        }
    }

    /// With the more accurate second derivative, takes a last short step if the gradient is smaller then. Without it, curves
    /// with speeds of 30, integrated from their start, miss the end by up to 4e-11.
    pub(crate) fn step_to_round_off(&mut self) {
        if !self.is_fine() {
            return;
        }
        let before = self.descent_state();
        let step = before.newton_step(f64::INFINITY);
        let is_short = |step: &DescentStep| self.layout.largest_change(&step.change) <= SHORTEST;
        if let Some(step) = step.filter(is_short) {
            let rest = self.rest();
            self.try_step(&step);
            self.set_forces();
            if self.rest().is_nan() || self.rest() > rest {
                self.restore(&before);
            }
        }
    }

    /// Whether gradient and defect are below the tolerance.
    pub(crate) fn is_at_rest(&self, progress: &mut Progress, options: &Options<'_>) -> bool {
        let rest = self.rest();
        rest <= progress.set(rest, self.largest_derivative(), options.tolerance)
    }

    /// Whether the cost will end above a bound, judged from a step without damping and its predicted decrease.
    fn ends_above(&self, bound: f64, damping: f64, decrease: f64) -> bool {
        damping == 0.0 && self.cost - LEFT * decrease > bound
    }

    /// Takes a step that reduces the cost, along a valley or with increasing damping, and returns its predicted
    /// decrease; `None` if there is no such step, or if the work limit is reached.
    ///
    /// # Errors
    /// `Interrupted`.
    fn step_down(&mut self, damping: &mut f64, options: &Options<'_>) -> Result<Option<f64>> {
        let (before, first) = (self.descent_state(), *damping);
        while *damping <= MOST {
            options.interrupt.check(SOLVER)?;
            if !(options.may_go_on)(self.products_of_trial()) {
                return Ok(None);
            }
            if let Some(step) = before.step(*damping, FARTHEST) {
                self.try_step(&step);
                if self.is_lower(&before, step.decrease, *damping) {
                    if self.share(&before, step.decrease) > WELL && *damping <= first {
                        *damping = lowered(*damping);
                    }
                    return Ok(Some(step.decrease));
                }
                self.restore(&before);
            }
            if *damping == 0.0 {
                let found = self.step_along_valley(&before, options)?;
                if found.is_some() {
                    return Ok(found);
                }
            }
            *damping = (RAISE * *damping).max(DAMPING);
        }
        Ok(None)
    }
}

fn lowered(damping: f64) -> f64 {
    match damping < LEAST {
        true => 0.0,
        false => LOWER * damping,
    }
}
