//! A state of a descent: the cost and its quadratic model, the steps of the model, and whether a step succeeded.

use super::free_chain::{FreeChain, FreeChainState};
use super::layout::ChainLayout;
use crate::linalg::field::Field;
use crate::solve::block_cholesky::SymmetricBlocks;
use crate::space::Homogeneous;

/// The first damping, its factors after a failed step and after one that succeeds at once, and the largest damping.
/// With a first damping of 0.1, one of 80 problems with slow ends is not solved.
pub(crate) const DAMPING: f64 = 0.01;
pub(crate) const RAISE: f64 = 4.0;
pub(crate) const LOWER: f64 = 0.25;
pub(crate) const MOST: f64 = 1e6;

/// Maximal displacement of a knot, in radians, and maximal change of a velocity, in the time of a leg, in one step.
pub(crate) const FARTHEST: f64 = 1.0;

/// A step succeeds if it achieves this fraction of the predicted decrease.
const DOWN: f64 = 1e-2;

/// Fractions of the cost below which a predicted decrease is not measured in the cost: for the usual second derivative,
/// whose predictions are then inaccurate, and for the more accurate one. With 1e-13 for both, two of 500 hard problems
/// end at higher costs. Below the first one, all solutions along a valley count as equally cheap.
const UNSEEN: f64 = 1e-7;
const UNSEEN_FINELY: f64 = 1e-13;

/// A gradient is clearly smaller from this fraction on.
const FLATTER: f64 = 0.5;

/// Costs are compared once the residual of the legs is at most this, or its square at most this fraction of the
/// predicted decrease; the maximal number of corrections to get there, and the largest residual from which they start.
/// The residual enters the gradient, so gradients near round-off need a smaller one: with 1e-6, 9 of 1000 hard problems on
/// St(3,2) do not come to rest at round-off.
pub(crate) const MET: f64 = 1e-6;
const MET_FINELY: f64 = 3e-14;
const MET_SHARE: f64 = 1e-2;
const CORRECTIONS: usize = 4;
const HOPELESS: f64 = 1.0;

/// The knots, and the quadratic model of the cost as a function of them.
pub(crate) struct DescentState<T> {
    state: FreeChainState<T>,
    cost: f64,
    own_cost: f64,
    gradient: Vec<f64>,
    layout: ChainLayout,
    /// The second derivative, and the one of flat space.
    exact: SymmetricBlocks,
    flat: SymmetricBlocks,
}

/// A change of the knots, and the predicted decrease of the cost.
pub(crate) struct DescentStep {
    pub(crate) change: Vec<f64>,
    pub(crate) decrease: f64,
}

impl<T> DescentState<T> {
    /// Newton's step, to where the gradient vanishes, shortened to at most the given length; it may lead up. `None` if
    /// the second derivative is singular.
    pub(crate) fn newton_step(&self, farthest: f64) -> Option<DescentStep> {
        let mut change: Vec<f64> = self.gradient.iter().map(|g| -g).collect();
        self.exact.eliminated()?.solve(&mut change);
        let size = self.layout.largest_change(&change);
        if !size.is_finite() {
            return None;
        }
        let share = (farthest / size).min(1.0);
        change.iter_mut().for_each(|x| *x *= share);
        Some(self.predicted(change))
    }

    /// A damped step; `None` if the matrix is not positive definite or the step is too long.
    pub(crate) fn step(&self, damping: f64, farthest: f64) -> Option<DescentStep> {
        let factor = self.exact.plus(damping, &self.flat).factored()?;
        let mut change: Vec<f64> = self.gradient.iter().map(|g| -g).collect();
        factor.solve(&mut change);
        let size = self.layout.largest_change(&change);
        (size <= farthest).then(|| self.predicted(change))
    }

    fn predicted(&self, change: Vec<f64>) -> DescentStep {
        let slope: f64 = self.gradient.iter().zip(&change).map(|(g, s)| g * s).sum();
        let decrease = -slope - 0.5 * self.exact.form(&change);
        DescentStep { change, decrease }
    }

    /// Whether a step hardly changes the cost.
    pub(crate) fn is_level(&self, step: &DescentStep) -> bool {
        step.decrease.abs() <= UNSEEN * self.own_cost
    }
}

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// The current state, for legs with linear equations and forces.
    pub(crate) fn descent_state(&self) -> DescentState<T> {
        let [exact, flat] = self.second_derivatives();
        DescentState {
            state: self.state.clone(),
            cost: self.cost,
            own_cost: self.own_cost,
            gradient: self.gradient(),
            layout: self.layout.clone(),
            exact,
            flat,
        }
    }

    /// Returns to a state; the linear equations are not restored.
    pub(crate) fn restore(&mut self, before: &DescentState<T>) {
        self.state = before.state.clone();
        self.set_knots();
        self.evaluate();
        self.set_forces();
    }

    /// The larger of the largest entries of gradient and defect.
    pub(crate) fn rest(&self) -> f64 {
        self.layout.largest_gradient(&self.gradient(), self.defect)
    }

    /// The residual of the legs from which gradients are computed.
    pub(crate) fn met(&self) -> f64 {
        match self.is_fine() {
            true => MET_FINELY,
            false => MET,
        }
    }

    /// Moves the knots, and corrects the legs as accurately as the comparison of costs, or of gradients, requires.
    pub(crate) fn try_step(&mut self, step: &DescentStep) {
        self.follow(&step.change);
        self.evaluate();
        let compared = (MET_SHARE * step.decrease).sqrt();
        self.meet_ends(match self.is_fine() {
            true => compared.min(MET_FINELY),
            false => compared,
        });
    }

    /// Solves the equations of the legs for the given knots.
    pub(crate) fn meet_knots(&mut self) {
        self.evaluate();
        self.linearise();
        self.meet_ends(MET);
    }

    /// Corrects the legs until they meet the knots.
    pub(crate) fn meet_ends(&mut self, defect: f64) {
        for _ in 0..CORRECTIONS {
            if !(defect..=HOPELESS).contains(&self.defect) {
                break;
            }
            self.correct();
            self.evaluate();
        }
    }

    /// The fraction of the predicted decrease that a step has achieved.
    pub(crate) fn share(&self, before: &DescentState<T>, decrease: f64) -> f64 {
        (before.cost - self.cost) / decrease
    }

    /// Whether a step succeeded: the cost decreased by a fraction of the predicted decrease. If that is too small to be
    /// measured in the cost, a step without damping is trusted; with the more accurate second derivative, the gradient
    /// must be smaller.
    pub(crate) fn is_lower(
        &mut self,
        before: &DescentState<T>,
        decrease: f64,
        damping: f64,
    ) -> bool {
        if self.defect.is_nan() || self.defect > HOPELESS {
            return false;
        }
        let (unseen, is_trusted) = match self.is_fine() {
            true => (UNSEEN_FINELY, true),
            false => (UNSEEN, damping == 0.0),
        };
        if decrease > unseen * before.own_cost || !is_trusted {
            return self.share(before, decrease) >= DOWN;
        }
        !self.is_fine() || self.is_flatter(before)
    }

    /// Whether a step has reduced the gradient clearly.
    pub(crate) fn is_flatter(&mut self, before: &DescentState<T>) -> bool {
        self.set_forces();
        self.rest() <= FLATTER * self.layout.largest_gradient(&before.gradient, 0.0)
    }
}
