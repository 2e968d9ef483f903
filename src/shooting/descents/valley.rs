//! Steps along a valley of the cost, that is, along directions in which it hardly changes.
//!
//! Between opposite points solutions nearly form a continuous family: rotating one about the axis through the points
//! almost gives another one. The second derivative along the family is small, and the family is curved: a step without
//! damping ends high on the side of the valley, and a damped one makes no progress. A leap moves along the valley as
//! far as its reach allows; damped steps, which do not change the position along the valley, then lead back to its
//! floor, where costs are compared.
//!
//! Second derivatives along a valley are differences of large numbers, so they are computed more accurately from the
//! first leap on.
//!
//! # Source
//! Chamberlain, Powell, Lemarechal, Pedersen (1982), Mathematical Programming Studies 16, 1-17 (the watchdog technique).

use super::descent_state::{DAMPING, DescentState, DescentStep, FARTHEST, LOWER, MET, MOST, RAISE};
use super::free_chain::FreeChain;
use crate::error::Result;
use crate::legs::Options;
use crate::linalg::field::Field;
use crate::space::Homogeneous;

const SOLVER: &str = "leap along a valley of the cost of a chain";

/// A leap must promise at least this multiple of a damped step's decrease. With this value, none of 500 hard problems
/// has a leap; with 1000, four of ten problems between opposite points on St(3,1) with speeds of 1e-4 are not solved,
/// and the others take ten times as long.
const SOFT: f64 = 10.0;

/// Reaches of leaps, tried in turn, in radians: five of those ten problems are not solved with the first one alone.
const REACHES: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// The smallest damping of a leap, and the ratio below which dampings are not distinguished.
const FINEST: f64 = 1e-16;
const CLOSE: f64 = 0.95;

/// Maximal number of damped steps back to the floor; two to six are usual.
const RETURNS: usize = 8;

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// A leap that reduces the cost, with its predicted decrease; the first leap only switches to the more accurate
    /// second derivative. `None`, with the chain unchanged, if there is no such leap.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn leap(
        &mut self,
        before: &DescentState<T>,
        options: &Options<'_>,
    ) -> Result<Option<f64>> {
        let Some(damped) = damped_step(before) else {
            return Ok(None);
        };
        for reach in REACHES {
            options.interrupt.check(SOLVER)?;
            if !(options.may_go_on)(self.products_of_equations()) {
                break;
            }
            let Some(leap) = longest_step(before, &damped, reach) else {
                break;
            };
            if !self.is_fine() {
                self.refine();
                self.evaluate();
                // Nothing has moved, and the possible decrease is unknown.
                return Ok(Some(f64::INFINITY));
            }
            if self.lands(before, &leap, options)? {
                return Ok(Some(leap.decrease));
            }
        }
        Ok(None)
    }

    /// Whether damped steps from the end of a leap lead to a lower cost; if not, the chain is unchanged.
    ///
    /// # Errors
    /// `Interrupted`.
    fn lands(
        &mut self,
        before: &DescentState<T>,
        leap: &DescentStep,
        options: &Options<'_>,
    ) -> Result<bool> {
        self.follow(&leap.change);
        self.evaluate();
        for _ in 0..RETURNS {
            options.interrupt.check(SOLVER)?;
            if !(options.may_go_on)(self.products_of_equations()) {
                break;
            }
            self.linearise();
            self.meet_ends(MET);
            self.set_forces();
            if self.defect <= MET && self.is_lower(before, leap.decrease, DAMPING) {
                return Ok(true);
            }
            let Some(back) = self.descent_state().step(DAMPING, FARTHEST) else {
                break;
            };
            self.follow(&back.change);
            self.evaluate();
        }
        self.restore(before);
        // The linear equations belong to another state.
        self.linearise();
        self.set_forces();
        Ok(false)
    }
}

/// The step with the first damping that makes the second derivative positive definite, and that damping.
fn damped_step<T>(state: &DescentState<T>) -> Option<(DescentStep, f64)> {
    let mut damping = DAMPING;
    while damping <= MOST {
        if let Some(step) = state.step(damping, FARTHEST) {
            return Some((step, damping));
        }
        damping *= RAISE;
    }
    None
}

/// The longest step within a reach, if it promises much more than a damped one.
fn longest_step<T>(
    state: &DescentState<T>,
    damped: &(DescentStep, f64),
    reach: f64,
) -> Option<DescentStep> {
    let (damped, mut damping) = (&damped.0, damped.1);
    let (mut longest, mut ratio) = (None, LOWER);
    while damping > FINEST && ratio < CLOSE {
        match state.step(ratio * damping, reach) {
            Some(step) => {
                damping *= ratio;
                longest = Some(step);
            }
            None => ratio = ratio.sqrt(),
        }
    }
    longest.filter(|step: &DescentStep| step.decrease > SOFT * damped.decrease)
}
