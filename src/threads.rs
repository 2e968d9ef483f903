//! Distribution of independent items among the threads of the pool, if they take long enough.

use rayon::prelude::*;

use crate::error::Result;

/// Microseconds of work that are not worth waking the pool, which takes 20 to 40 of them.
const ALONE: f64 = 80.0;

/// Most items that are kept together in one task.
const TOGETHER: usize = 8;

/// Whether items, of about so many microseconds each, are better computed by the calling thread.
pub(crate) fn is_alone(count: usize, each: f64) -> bool {
    count < 2 || count as f64 * each <= ALONE || rayon::current_num_threads() == 1
}

/// Microseconds of an item with matrices of shape `(n, k)`, if it takes so many of them for `(3, 3)`: in proportion to their
/// entries.
///
/// Items of the splines take, measured on St(3,3), (4,2), (10,3) and (20,5): joining neighbours 2.9, 2.8, 5.9, 18; an
/// integrated leg 0.7, 1.8, 17, 90; a boundary problem 45, 160, 870, 3200. The estimates, 3, 3, 10, 33 for the first, are
/// only compared with [`ALONE`]: items that take longer are worth the pool sooner than it is used, for a few of them.
pub(crate) fn scaled(each: f64, (n, k): (usize, usize)) -> f64 {
    each * ((n * k) as f64 / 9.0).max(1.0)
}

/// Computes one value per item of about so many microseconds. All of them are computed if the pool is used; the error is
/// that of the first item which fails, for any number of threads.
///
/// # Errors
/// The errors of the items.
pub(crate) fn map<W, T: Send>(
    count: usize,
    each: f64,
    worker: impl Fn() -> W + Sync + Send,
    one: impl Fn(&mut W, usize) -> Result<T> + Sync + Send,
) -> Result<Vec<T>> {
    if is_alone(count, each) {
        let mut worker = worker();
        return (0..count).map(|i| one(&mut worker, i)).collect();
    }
    let together = (0.5 * ALONE / each) as usize;
    let all: Vec<Result<T>> = (0..count)
        .into_par_iter()
        .with_min_len(together.clamp(1, TOGETHER))
        .map_init(worker, one)
        .collect();
    all.into_iter().collect()
}
