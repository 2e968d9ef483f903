//! Where a descent stands: the cost and its quadratic model there, the steps that the model gives, and whether one led down.

use super::free_chain::{FreeChain, State};
use super::layout::Layout;
use crate::linalg::field::Field;
use crate::solve::block_cholesky::SymmetricBlocks;
use crate::space::Homogeneous;

/// The first damping, its factors after a step that fails and one that succeeds at once, and the largest one. With a first one
/// of 0.1 one of 80 problems with slow ends is lost.
pub(super) const DAMPING: f64 = 0.01;
pub(super) const RAISE: f64 = 4.0;
pub(super) const LOWER: f64 = 0.25;
pub(super) const MOST: f64 = 1e6;

/// Longest displacement of a knot, in radians, and change of a velocity, in the time of a leg, by a step.
pub(super) const FARTHEST: f64 = 1.0;

/// A step counts as one that leads down from this share of the predicted decrease on.
const DOWN: f64 = 1e-2;

/// Shares of the cost below which a predicted decrease is not looked for in it: with a second derivative of few digits, which
/// predicts badly then, and with a fine one. With 1e-13 for both, two of 500 hard problems end at higher costs.
const UNSEEN: f64 = 1e-7;
const UNSEEN_FINELY: f64 = 1e-13;

/// Costs are compared where what is left of the equations of the legs is at most this, or its square at most this share of the
/// predicted decrease; corrections at most to get there, and what they start from at most.
pub(super) const MET: f64 = 1e-6;
const MET_SHARE: f64 = 1e-2;
const CORRECTIONS: usize = 4;
const HOPELESS: f64 = 1.0;

/// Knots, and the cost as a function of them up to the second order.
pub(super) struct Place<T> {
    state: State<T>,
    cost: f64,
    own_cost: f64,
    gradient: Vec<f64>,
    layout: Layout,
    /// The second derivative, and that of flat space.
    exact: SymmetricBlocks,
    flat: SymmetricBlocks,
}

/// A change of the knots, and how much it lowers the cost by the model.
pub(super) struct Step {
    pub(super) change: Vec<f64>,
    pub(super) decrease: f64,
}

impl<T> Place<T> {
    /// A damped step; `None` where the matrix is not positive definite or the step too long.
    pub(super) fn step(&self, damping: f64, farthest: f64) -> Option<Step> {
        let factor = self.exact.plus(damping, &self.flat).factored()?;
        let mut change: Vec<f64> = self.gradient.iter().map(|g| -g).collect();
        factor.solve(&mut change);
        let slope: f64 = self.gradient.iter().zip(&change).map(|(g, s)| g * s).sum();
        let decrease = -slope - 0.5 * self.exact.form(&change);
        let size = self.layout.largest_change(&change);
        (size <= farthest).then_some(Step { change, decrease })
    }
}

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// Of legs with linear equations and forces.
    pub(super) fn place(&self) -> Place<T> {
        let [exact, flat] = self.second_derivatives();
        Place {
            state: self.state.clone(),
            cost: self.cost,
            own_cost: self.own_cost,
            gradient: self.gradient(),
            layout: self.layout.clone(),
            exact,
            flat,
        }
    }

    /// Back to a place; the linear equations stay those of where the chain has been.
    pub(super) fn restore(&mut self, place: &Place<T>) {
        self.state = place.state.clone();
        self.set_knots();
        self.evaluate();
        self.set_forces();
    }

    /// The largest entry of gradient and defect.
    pub(super) fn rest(&self) -> f64 {
        self.layout.largest_gradient(&self.gradient(), self.defect)
    }

    /// Moves the knots; the legs meet them as nearly as comparing the costs needs.
    pub(super) fn try_step(&mut self, step: &Step) {
        self.follow(&step.change);
        self.evaluate();
        self.meet_ends((MET_SHARE * step.decrease).sqrt());
    }

    /// Corrects the legs until they meet the knots.
    pub(super) fn meet_ends(&mut self, defect: f64) {
        for _ in 0..CORRECTIONS {
            if !(defect..=HOPELESS).contains(&self.defect) {
                break;
            }
            self.correct();
            self.evaluate();
        }
    }

    /// The share of the predicted decrease that a step has brought.
    pub(super) fn share(&self, before: &Place<T>, decrease: f64) -> f64 {
        (before.cost - self.cost) / decrease
    }

    /// Whether a step has led down: the cost fell by a share of what was predicted. Where that is too little to be seen in the
    /// cost, a step without damping is trusted; with a fine second derivative the gradient is to be half as large.
    pub(super) fn is_lower(&mut self, before: &Place<T>, decrease: f64, damping: f64) -> bool {
        let (unseen, is_trusted) = match self.is_fine() {
            true => (UNSEEN_FINELY, true),
            false => (UNSEEN, damping == 0.0),
        };
        if self.defect.is_nan() || self.defect > HOPELESS {
            return false;
        }
        if decrease > unseen * before.own_cost || !is_trusted {
            return self.share(before, decrease) >= DOWN;
        }
        if !self.is_fine() {
            return true;
        }
        self.set_forces();
        self.rest() <= 0.5 * self.layout.largest_gradient(&before.gradient, 0.0)
    }
}
