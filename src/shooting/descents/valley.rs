//! Steps along a valley of the cost, that is, along directions in which it hardly changes.
//!
//! Between opposite points solutions nearly form a continuous family: rotating one about the axis through the points
//! almost gives another one. The second derivative along the family is small, and the family is curved: a step without
//! damping ends high on the side of the valley, and a damped one makes no progress. A step along the valley goes as far
//! as its reach allows; damped steps, which do not change the position along the valley, then lead back to its floor,
//! where gradients or costs are compared.
//!
//! Where the cost hardly changes, every solution will do: Newton's step leads to the nearest one, the lowest or the
//! highest of the floor. Elsewhere a leap leads down.
//!
//! Second derivatives along a valley are differences of large numbers, so they are computed more accurately from the
//! first leap on. They are small only on its floor: even a step that lands near it is followed by damped ones.
//!
//! # Source
//! Chamberlain, Powell, Lemarechal, Pedersen (1982), Mathematical Programming Studies 16, 1-17 (the watchdog technique).

use super::descent_state::{DAMPING, DescentState, DescentStep, FARTHEST, LOWER, MET, MOST, RAISE};
use super::free_chain::FreeChain;
use crate::error::Result;
use crate::legs::Options;
use crate::linalg::field::Field;
use crate::space::Homogeneous;

const SOLVER: &str = "step along a valley of the cost of a chain";

/// A leap must promise at least this multiple of a damped step's decrease. With this value, none of 500 hard problems
/// has a leap; with 1000, four of ten problems between opposite points on St(3,1) with speeds of 1e-4 are not solved,
/// and the others take ten times as long.
const SOFT: f64 = 10.0;

/// Reaches of leaps, tried in turn, in radians: five of those ten problems are not solved with the first one alone.
const REACHES: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// The smallest damping of a leap, and the ratio below which dampings are not distinguished.
const FINEST: f64 = 1e-16;
const CLOSE: f64 = 0.95;

/// Maximal number of damped steps back to the floor; two to six are usual. The floor is reached when a step leaves more than
/// a share of the gradient: with 0.9, 18 of 20 problems between opposite points on St(6,3) with speeds of 1e-4 are not solved.
const RETURNS: usize = 8;
const FLOOR: f64 = 0.25;

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// Takes a step along the valley of a state, and returns its predicted change of the cost; `None`, with the chain
    /// unchanged, if none succeeds.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn step_along_valley(
        &mut self,
        before: &DescentState<T>,
        options: &Options<'_>,
    ) -> Result<Option<f64>> {
        match self.flatten(before, options)? {
            None => self.leap(before, options),
            found => Ok(found),
        }
    }

    /// Newton's step, up or down, if it hardly changes the cost and the floor at its end is flatter. Without it, 24 of 40
    /// problems between opposite points on St(3,1) with speeds of 1e-6 are not solved.
    fn flatten(&mut self, before: &DescentState<T>, options: &Options<'_>) -> Result<Option<f64>> {
        if !self.is_fine() {
            return Ok(None);
        }
        let step = before.newton_step(FARTHEST);
        let Some(step) = step.filter(|step| before.is_level(step)) else {
            return Ok(None);
        };
        let is_flatter = self.lands(before, &step, options, Self::is_flatter)?;
        Ok(is_flatter.then_some(step.decrease.abs()))
    }

    /// A leap that reduces the cost; the first leap only switches to the more accurate second derivative. Without leaps, 17
    /// of 40 problems between opposite points on St(3,1) with speeds of 1e-4 are not solved.
    fn leap(&mut self, before: &DescentState<T>, options: &Options<'_>) -> Result<Option<f64>> {
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
            let is_lower = self.lands(before, &leap, options, |chain, before| {
                chain.defect <= MET && chain.is_lower(before, leap.decrease, DAMPING)
            })?;
            if is_lower {
                return Ok(Some(leap.decrease));
            }
        }
        Ok(None)
    }

    /// Whether a step succeeds after the way back to the floor; if not, the chain is unchanged.
    ///
    /// # Errors
    /// `Interrupted`.
    fn lands(
        &mut self,
        before: &DescentState<T>,
        step: &DescentStep,
        options: &Options<'_>,
        succeeds: impl Fn(&mut Self, &DescentState<T>) -> bool,
    ) -> Result<bool> {
        self.follow(&step.change);
        self.evaluate();
        if self.returns(before, options)? && succeeds(self, before) {
            return Ok(true);
        }
        self.restore(before);
        // The linear equations belong to another state.
        self.linearise();
        self.set_forces();
        Ok(false)
    }

    /// Takes damped steps until the chain is on the floor of the valley, or flatter than it was; whether this succeeds.
    ///
    /// # Errors
    /// `Interrupted`.
    fn returns(&mut self, before: &DescentState<T>, options: &Options<'_>) -> Result<bool> {
        let mut last = f64::INFINITY;
        for _ in 0..RETURNS {
            options.interrupt.check(SOLVER)?;
            if !(options.may_go_on)(self.products_of_equations()) {
                break;
            }
            self.linearise();
            self.meet_ends(self.met());
            if self.is_flatter(before) || self.rest() > FLOOR * last {
                return Ok(true);
            }
            last = self.rest();
            let Some(back) = self.descent_state().step(DAMPING, FARTHEST) else {
                break;
            };
            self.follow(&back.change);
            self.evaluate();
        }
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
