//! Loops compiled for the vector instructions detected at run time.

use rayon::prelude::*;

/// Number of groups per task of the thread pool, and total number up to which the pool is not used.
const TASK: usize = 8;

/// Largest number of items, in groups of eight, that [`each`] leaves to the calling thread.
#[cfg(feature = "python")]
pub(crate) const ON_ONE_THREAD: usize = TASK * super::lanes::LANES;

/// Runs `work` compiled for the widest vector instructions of this processor.
///
/// Only code inlined into `work` benefits. No fused multiply-add is formed, so results are bit-identical on every
/// processor.
#[inline(always)]
pub(crate) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Runs `work` on every item, compiled for the widest vector instructions, in tasks of the thread pool if there are
/// more than a few; results do not depend on the number of threads.
#[inline(always)]
pub(crate) fn each<A: Send, B: Clone + Send + Sync>(
    items: &mut [A],
    buffers: &mut B,
    work: impl Fn(&mut B, usize, &mut A) + Sync,
) {
    if items.len() <= TASK || rayon::current_num_threads() == 1 {
        return task(items, buffers, 0, &work);
    }
    let buffers = &*buffers;
    let tasks = items.par_chunks_mut(TASK).enumerate();
    tasks.for_each(|(i, items)| task(items, &mut buffers.clone(), TASK * i, &work));
}

/// Runs `work` on consecutive items, starting at index `first`. Not inlined, so that every kernel is compiled only once
/// for the caller's thread and the pool: the library's test program then has 55 MB instead of 64 MB.
#[inline(never)]
fn task<A, B>(
    items: &mut [A],
    buffers: &mut B,
    first: usize,
    work: &impl Fn(&mut B, usize, &mut A),
) {
    vectorised(
        #[inline(always)]
        || {
            for (i, item) in items.iter_mut().enumerate() {
                work(buffers, first + i, item);
            }
        },
    );
}

/// The vector instruction sets that this processor offers and the kernels can use.
#[cfg(feature = "python")]
pub(crate) fn features() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let found = [
        ("sse2", std::is_x86_feature_detected!("sse2")),
        ("avx", std::is_x86_feature_detected!("avx")),
        ("avx2", std::is_x86_feature_detected!("avx2")),
        ("fma", std::is_x86_feature_detected!("fma")),
        ("avx512f", std::is_x86_feature_detected!("avx512f")),
    ];
    #[cfg(not(target_arch = "x86_64"))]
    let found = [(std::env::consts::ARCH, true)];
    let found = found.into_iter().filter(|(_, has)| *has);
    found.map(|(name, _)| name).collect()
}
