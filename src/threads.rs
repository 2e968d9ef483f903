//! Distribution of independent items among the threads of the pool, if they take long enough.
//!
//! The pool sees one function, whatever the items are: with an instance of rayon's iterators for each caller, the code
//! handed to the compiler for the Python module is an eighth longer.

use std::cell::Cell;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// Microseconds of work that are not worth waking the pool, which takes 20 to 40 of them.
pub(crate) const ALONE: f64 = 80.0;

/// Most items that are kept together in one task.
const TOGETHER: usize = 8;

/// Microseconds of items that are always worth a task of their own.
pub(crate) const ALWAYS: f64 = f64::INFINITY;

thread_local! {
    /// Whether this thread works without the pool.
    static WITHOUT_POOL: Cell<bool> = const { Cell::new(false) };
}

/// Whether items, of about so many microseconds each, are better computed by the calling thread.
pub(crate) fn is_alone(count: usize, each: f64) -> bool {
    count < 2 || count as f64 * each <= ALONE || is_only_one()
}

/// Whether the calling thread has no others to help it.
fn is_only_one() -> bool {
    WITHOUT_POOL.get() || rayon::current_num_threads() == 1
}

/// Runs both, on two threads unless the calling one has no others to help it.
pub(crate) fn join(one: impl FnOnce() + Send, other: impl FnOnce() + Send) {
    if is_only_one() {
        one();
        return other();
    }
    rayon::join(one, other);
}

/// Runs `work` on the calling thread alone, which need not wait for a pool of one thread.
#[cfg(any(feature = "python", test))]
pub(crate) fn without_pool(work: impl FnOnce()) {
    struct Before(bool);
    impl Drop for Before {
        fn drop(&mut self) {
            WITHOUT_POOL.set(self.0);
        }
    }
    let _before = Before(WITHOUT_POOL.replace(true));
    work();
}

/// Microseconds of an item with matrices of shape `(n, k)`, if it takes so many of them for `(3, 3)`: in proportion to
/// their entries.
///
/// Items of the splines take, measured on St(3,3), (4,2), (10,3) and (20,5): joining neighbours 2.9, 2.8, 5.9, 18; an
/// integrated leg 0.7, 1.8, 17, 90; a boundary problem 45, 160, 870, 3200. The estimates, 3, 3, 10, 33 for the first,
/// are only compared with [`ALONE`]: items that take longer are worth the pool sooner than it is used, for a few of
/// them.
pub(crate) fn scaled(each: f64, (n, k): (usize, usize)) -> f64 {
    each * ((n * k) as f64 / 9.0).max(1.0)
}

/// Computes one value per item of about so many microseconds, with a worker for each range of items that a thread
/// computes. The error is that of the first item which fails, for any number of threads; items after it may be left
/// out.
///
/// # Errors
/// The errors of the items.
pub(crate) fn map<W, T: Send, E: Send>(
    count: usize,
    each: f64,
    worker: impl Fn() -> W + Sync,
    one: impl Fn(&mut W, usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let run = |range: Range<usize>, failed: &AtomicUsize| {
        let mut worker = worker();
        let wanted = range.take_while(|i| *i <= failed.load(Ordering::Relaxed));
        let value = |i| {
            let value = one(&mut worker, i);
            value.inspect_err(|_| _ = failed.fetch_min(i, Ordering::Relaxed))
        };
        wanted.map(value).collect()
    };
    match is_alone(count, each) {
        true => run(0..count, &AtomicUsize::new(usize::MAX)),
        false => {
            let together = (0.5 * ALONE / each) as usize;
            gathered(count, together.clamp(1, TOGETHER), &run)
        }
    }
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

/// Runs a task on ranges that make up `0..count`, which are halved for idle threads if both halves have so many
/// indices.
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

/// Locks a part, which only one task uses, or a list of values or buffers, to which a task appends. A panic in a task
/// reaches the caller through the pool, so it is not looked for here.
pub(crate) fn lock<T>(data: &Mutex<T>) -> MutexGuard<'_, T> {
    data.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_pools(test: impl Fn() + Sync) {
        for threads in [1, 2, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(&test);
        }
    }

    #[test]
    fn values_are_in_order() {
        in_pools(|| {
            for count in [0, 1, 2, 7, 1000] {
                for each in [0.0, 1.0, ALONE, ALWAYS] {
                    let found = map(count, each, || (), |(), i| Ok::<_, ()>(3 * i));
                    let expected: Vec<usize> = (0..count).map(|i| 3 * i).collect();
                    assert_eq!(found, Ok(expected));
                }
            }
        });
    }

    #[test]
    fn the_first_failure_is_returned_and_nothing_before_it_is_left_out() {
        in_pools(|| {
            let visits: Vec<AtomicUsize> = (0..1000).map(|_| AtomicUsize::new(0)).collect();
            let found = map(
                1000,
                ALWAYS,
                || (),
                |(), i| {
                    visits[i].fetch_add(1, Ordering::Relaxed);
                    if i % 100 == 57 { Err(i) } else { Ok(()) }
                },
            );
            assert_eq!(found, Err(57));
            let visits = visits.iter().map(|visits| visits.load(Ordering::Relaxed));
            assert!(visits.take(58).all(|visits| visits == 1));
        });
    }

    #[test]
    fn parts_are_changed_also_within_parts() {
        in_pools(|| {
            let mut data = vec![1; 100];
            let square = |(): &mut (), row: usize, part: &mut &mut [usize]| {
                let sums = map_parts(
                    part.iter_mut(),
                    ALWAYS,
                    || (),
                    |(), column, x| {
                        **x += 10 * row + column;
                        Ok::<_, ()>(**x)
                    },
                );
                sums.map(|sums| sums.iter().sum::<usize>())
            };
            let sums = map_parts(data.chunks_mut(10), ALWAYS, || (), square);
            assert!(data.iter().enumerate().all(|(i, x)| *x == i + 1));
            let rows = data.chunks(10).map(|row| row.iter().sum());
            assert_eq!(sums, Ok(rows.collect()));
        });
    }

    #[test]
    fn a_thread_works_alone_until_its_work_ends() {
        let two = rayon::ThreadPoolBuilder::new().num_threads(2);
        two.build().unwrap().install(|| {
            let here = std::thread::current().id();
            without_pool(|| {
                assert!(is_alone(100, ALWAYS));
                let is_here = || assert_eq!(std::thread::current().id(), here);
                join(is_here, is_here);
                without_pool(|| {});
                assert!(is_alone(100, ALWAYS));
            });
            assert!(!is_alone(100, ALWAYS));
            let work = || without_pool(|| panic!("not caught"));
            assert!(std::panic::catch_unwind(work).is_err());
            assert!(!is_alone(100, ALWAYS));
        });
    }

    #[test]
    #[should_panic(expected = "item 57")]
    fn a_panic_reaches_the_caller() {
        in_pools(|| {
            let item = |(): &mut (), i: usize| match i {
                57 => panic!("item 57"),
                _ => Ok::<_, ()>(i),
            };
            _ = map(100, ALWAYS, || (), item);
        });
    }
}
