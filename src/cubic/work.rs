//! Work that a problem may take before it is given up: counted in products of numbers, so the same on every machine.

use std::sync::atomic::{AtomicU64, Ordering};

use super::reduced::{Blocks, Sized};

/// About a second.
const MAX_WORK: f64 = 5.5e7;

/// Trials that a large problem may take at least. With 100 a spline through bases of reduced models on St(200, 6) is lost.
pub(crate) const TRIALS: f64 = 120.0;

/// Taylor steps of a curve from one end to the other, as a rule.
const STEPS: f64 = 10.0;

/// Products of numbers for one order of one Taylor step, about `r k (2 r + k)`: the unit in which work is counted.
pub(super) fn work_of_step(blocks: impl Blocks) -> f64 {
    let (m, k) = (blocks.normals() as f64, blocks.k() as f64);
    (m + k) * k * (2.0 * m + 3.0 * k)
}

/// The same for a curve.
pub(crate) fn work_of_curve(blocks: impl Blocks) -> f64 {
    STEPS * work_of_step(blocks)
}

/// The same for some products: a step takes as many for each of about 25 orders.
pub(crate) fn of_products(products: f64) -> f64 {
    products / 25.0
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

/// Work done, and how much of it there may be: whole numbers, whose sum is the same in any order.
#[derive(Debug)]
pub(crate) struct Work {
    done: AtomicU64,
    limit: AtomicU64,
}

impl Work {
    /// None done yet, of a problem that may take so many trials at least.
    pub(crate) fn of_trials(trials: f64, trial: f64) -> Self {
        Work {
            done: AtomicU64::new(0),
            limit: AtomicU64::new(MAX_WORK.max(trials * trial) as u64),
        }
    }

    pub(crate) fn count(&self, work: f64) {
        self.done.fetch_add(work as u64, Ordering::Relaxed);
    }

    /// What may still be done.
    pub(crate) fn left(&self) -> f64 {
        let [limit, done] = [&self.limit, &self.done].map(|x| x.load(Ordering::Relaxed) as f64);
        limit - done
    }

    /// Whether no further step is begun.
    pub(crate) fn is_done(&self) -> bool {
        self.left() < 0.0
    }

    /// Nothing further is begun: what comes next would take more than is left.
    pub(crate) fn refuse(&self) {
        self.count(self.left() + 1.0);
    }

    /// As many times the work may be done from now on.
    pub(crate) fn allow(&self, times: f64) {
        let limit = self.limit.load(Ordering::Relaxed) as f64;
        self.limit.store((times * limit) as u64, Ordering::Relaxed);
    }
}
