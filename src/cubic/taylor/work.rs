//! Work limits of a problem: counted in multiplications, so that they are the same on every machine.

use std::sync::atomic::{AtomicU64, Ordering};

use super::blocks::{BlockSizes, Sizes};
use crate::manifold::only_bases::Appearance;

/// Work limit of a problem, about a second.
const MAX_WORK: f64 = 5.5e7;

/// Minimal number of trials allowed for a large problem. When every leg counted as ten steps, a spline through bases of
/// reduced models on St(200, 6) was not solved with 100.
pub(crate) const TRIALS: f64 = 120.0;

/// The part of a limit that is left if frames seem to be bases, for which the answer is wanted soon: splines and smoothing
/// splines through 5 to 20 of them, of shapes (20, 3) to (2000, 6) and turned at random, are refused after 0.2 to 1.1 s, with
/// the whole limit after up to 7 s. With the whole limit, 3 of 36 smoothing splines are found that are not found with this
/// part.
const OF_BASES: f64 = 0.3;

/// Typical number of Taylor steps of a curve from one end to the other.
const STEPS: f64 = 10.0;

/// Multiplications for one order of one Taylor step, about `r k (2 r + k)`: the unit of work.
pub(crate) fn work_of_step(blocks: impl BlockSizes) -> f64 {
    let (m, k) = (blocks.normals() as f64, blocks.k() as f64);
    (m + k) * k * (2.0 * m + 3.0 * k)
}

/// Work of integrating a curve.
pub(crate) fn work_of_curve(blocks: impl BlockSizes) -> f64 {
    STEPS * work_of_step(blocks)
}

/// Work of the given number of products: a step takes as many for each of about 25 orders.
pub(crate) fn of_products(products: f64) -> f64 {
    products / 25.0
}

/// Work of joining two points and carrying vectors along: products, and the iteration for the curve. Calibrated by
/// times on St(3,1) to St(10,3) and St(8,4).
pub(crate) fn work_of_join(blocks: Sizes) -> f64 {
    let [r, k] = [blocks.m + blocks.k, blocks.k].map(|size| (size as f64).powi(3));
    100.0 + 0.15 * r + 14.0 * k
}

/// Factor by which the limit is raised when more iterations are allowed than by default, in proportion.
pub(crate) fn allowance(max_iterations: usize, by_default: usize) -> f64 {
    (max_iterations as f64 / by_default as f64).max(1.0)
}

/// Work done, and its limit: integers, whose sum is the same in any order.
#[derive(Debug)]
pub(crate) struct Work {
    done: AtomicU64,
    limit: AtomicU64,
}

impl Work {
    /// No work done yet, for a problem that is allowed at least `trials` trials.
    pub(crate) fn of_trials(trials: f64, trial: f64, points: Appearance) -> Self {
        let share = match points {
            Appearance::Usual => 1.0,
            Appearance::Bases => OF_BASES,
        };
        Work {
            done: AtomicU64::new(0),
            limit: AtomicU64::new((share * MAX_WORK.max(trials * trial)) as u64),
        }
    }

    pub(crate) fn count(&self, work: f64) {
        self.done.fetch_add(work as u64, Ordering::Relaxed);
    }

    /// Counts the products of the next iteration; returns whether it may begin.
    pub(crate) fn may_go_on(&self, products: f64) -> bool {
        self.count(of_products(products));
        !self.is_done()
    }

    fn limit(&self) -> f64 {
        self.limit.load(Ordering::Relaxed) as f64
    }

    /// Remaining work.
    pub(crate) fn left(&self) -> f64 {
        self.limit() - self.done.load(Ordering::Relaxed) as f64
    }

    /// Whether the limit is reached, so that no further step may begin.
    pub(crate) fn is_done(&self) -> bool {
        self.left() < 0.0
    }

    /// Stops further work: the next step would exceed the limit.
    pub(crate) fn refuse(&self) {
        self.count(self.left() + 1.0);
    }

    /// Multiplies the limit by `times` from now on.
    pub(crate) fn allow(&self, times: f64) {
        self.limit
            .store((times * self.limit()) as u64, Ordering::Relaxed);
    }
}
