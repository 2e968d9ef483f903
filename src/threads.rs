//! Distribution of independent items among the threads of the pool, if they take long enough.
//!
//! The pool sees one function, whatever the items are: with an instance of rayon's iterators for each caller, the code
//! handed to the compiler for the Python module is an eighth longer.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// Microseconds of work that are not worth waking the pool, which takes 20 to 40 of them.
const ALONE: f64 = 80.0;

/// Most items that are kept together in one task.
const TOGETHER: usize = 8;

/// Microseconds of items that are always worth a task of their own.
pub(crate) const LONG: f64 = f64::INFINITY;

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

/// Computes one value per item of about so many microseconds. The error is that of the first item which fails, for any
/// number of threads; items after it may be left out.
///
/// # Errors
/// The errors of the items.
pub(crate) fn map<W, T: Send, E: Send>(
    count: usize,
    each: f64,
    worker: impl Fn() -> W + Sync,
    one: impl Fn(&mut W, usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    if is_alone(count, each) {
        let mut worker = worker();
        return (0..count).map(|i| one(&mut worker, i)).collect();
    }
    let together = ((0.5 * ALONE / each) as usize).clamp(1, TOGETHER);
    gathered(count, together, &|range, failed| {
        let mut worker = worker();
        let wanted = range.take_while(|i| *i <= failed.load(Ordering::Relaxed));
        let value = |i| {
            let value = one(&mut worker, i);
            value.inspect_err(|_| _ = failed.fetch_min(i, Ordering::Relaxed))
        };
        wanted.map(value).collect()
    })
}

/// [`map`] for items that change a part of the data each.
///
/// # Errors
/// The errors of the items.
pub(crate) fn map_parts<P: Send, W, T: Send, E: Send>(
    parts: impl Iterator<Item = P>,
    each: f64,
    worker: impl Fn() -> W + Sync,
    one: impl Fn(&mut W, usize, &mut P) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let parts: Vec<Mutex<P>> = parts.map(Mutex::new).collect();
    map(parts.len(), each, worker, |worker, i| {
        one(worker, i, &mut lock(&parts[i]))
    })
}

/// The values of a range of items, given the first item known to have failed.
type Run<'a, T, E> = &'a (dyn Fn(Range<usize>, &AtomicUsize) -> Result<Vec<T>, E> + Sync);

/// The values of ranges that make up `0..count`, in order, or the error of the first item which fails.
fn gathered<T: Send, E: Send>(count: usize, least: usize, run: Run<'_, T, E>) -> Result<Vec<T>, E> {
    let (runs, failed) = (Mutex::new(Vec::new()), AtomicUsize::new(usize::MAX));
    on_pool(count, least, &|range| {
        let values = (range.start, run(range, &failed));
        lock(&runs).push(values);
    });
    let mut runs = std::mem::take(&mut *lock(&runs));
    runs.sort_unstable_by_key(|(start, _)| *start);
    let mut all = Vec::with_capacity(count);
    for (_, values) in runs {
        // No item before the first that fails is left out.
        all.append(&mut values?);
    }
    Ok(all)
}

/// Runs a task on ranges that make up `0..count`, halved as long as threads are idle and both halves have so many indices.
fn on_pool(count: usize, least: usize, task: &(dyn Fn(Range<usize>) + Sync)) {
    let halved = |range: Range<usize>| {
        let middle = range.start + range.len() / 2;
        match range.len() / 2 >= least {
            true => (range.start..middle, Some(middle..range.end)),
            false => (range, None),
        }
    };
    rayon::iter::split(0..count, halved).for_each(task);
}

/// Access to data of a task that no other task uses at the same time for long; a panic of another task ends this one too.
fn lock<T>(data: &Mutex<T>) -> MutexGuard<'_, T> {
    data.lock().unwrap_or_else(PoisonError::into_inner)
}
