//! Work that a problem may take before it is given up: counted in products of numbers, so the same on every machine.

use std::cell::Cell;

use super::reduced::{Blocks, Sized};

/// About a second or two.
const MAX_WORK: f64 = 6e7;

/// Taylor steps of a curve from one end to the other, as a rule.
const STEPS: f64 = 10.0;

/// Trials that a large problem may take at least. With 100 a spline through bases of reduced models on St(200, 6) is lost.
const TRIALS: f64 = 120.0;

/// Products of numbers for one order of one Taylor step, about `r k (2 r + k)`: the unit in which work is counted.
pub(super) fn work_of_step(blocks: impl Blocks) -> f64 {
    let (m, k) = (blocks.normals() as f64, blocks.k() as f64);
    (m + k) * k * (2.0 * m + 3.0 * k)
}

/// The same for a curve.
pub(crate) fn work_of_curve(blocks: impl Blocks) -> f64 {
    STEPS * work_of_step(blocks)
}

/// What joining two points takes, and carrying vectors there: products, and the iteration for the curve. By times on St(3,1) to
/// St(10,3) and St(8,4).
pub(crate) fn work_of_join(blocks: Sized) -> f64 {
    let [r, k] = [blocks.m + blocks.k, blocks.k].map(|size| (size as f64).powi(3));
    100.0 + 0.15 * r + 14.0 * k
}

/// How many times the limit more iterations than by default may take: work in proportion.
pub(crate) fn allowance(max_iterations: usize, by_default: usize) -> f64 {
    (max_iterations as f64 / by_default as f64).max(1.0)
}

/// Work done, and how much of it there may be.
#[derive(Debug)]
pub(crate) struct Work {
    done: Cell<f64>,
    limit: Cell<f64>,
}

impl Work {
    /// None done yet, of a problem whose every trial takes the given work.
    pub(crate) fn of_trials(trial: f64) -> Self {
        Work {
            done: Cell::new(0.0),
            limit: Cell::new(MAX_WORK.max(TRIALS * trial)),
        }
    }

    pub(crate) fn count(&self, work: f64) {
        self.done.set(self.done.get() + work);
    }

    /// What may still be done.
    pub(crate) fn left(&self) -> f64 {
        self.limit.get() - self.done.get()
    }

    /// Whether no further step is begun.
    pub(crate) fn is_done(&self) -> bool {
        self.left() < 0.0
    }

    /// As many times the work may be done from now on.
    pub(crate) fn allow(&self, times: f64) {
        self.limit.set(times * self.limit.get());
    }
}
