//! Loops compiled for the vector instructions that are found at run time.

use rayon::prelude::*;

/// Groups that one task of the pool takes, and so many in all are not worth it.
const TASK: usize = 8;

/// Runs `work` compiled for the widest vector instructions that this processor has.
///
/// Everything that is to profit must be inlined into `work`. No fused multiply-add is formed, so a loop gives the
/// same bits on every processor.
#[inline(always)]
pub(crate) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Work on every item, in tasks of the pool where there are more than a few, compiled for the widest vector instructions; the
/// same for any number of threads.
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

/// Work on items in a row, the first of which is `first`. Not inlined, so that every kernel is compiled once for the caller's
/// thread and the pool together: the test program of the library has 55 MB in place of 64.
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

/// The vector instruction sets that this processor offers and the kernels may use.
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
