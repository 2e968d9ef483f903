//! Loops compiled for the vector instructions detected at run time.

use std::convert::Infallible;
use std::sync::Mutex;

use crate::threads::{self, is_alone, lock};

/// Number of groups per task of the thread pool, and total number up to which the pool is not used.
const TASK: usize = 8;

/// Largest number of items, in groups of eight, that [`each`] leaves to the calling thread however long they take.
#[cfg(feature = "python")]
pub(crate) const ON_ONE_THREAD: usize = TASK * super::lanes::LANES;

/// Vector instructions for which a kernel is compiled.
///
/// No fused multiply-add is formed, so results are bit-identical on every processor.
pub(crate) trait Width {
    /// Runs `work`; only code inlined into it benefits.
    fn run<R>(work: impl FnOnce() -> R) -> R;
}

/// Vectors of up to four numbers: for loops over entries of any number.
pub(crate) struct Four;

/// Vectors of up to eight numbers: for loops over [`Lanes`](super::lanes::Lanes) that keep them in registers.
///
/// On a processor that executes them at once, splines through 10 to 2000 rotations take 0.74 to 0.78 times as long as
/// with [`Four`], derivatives and accelerations of geometric cubics 0.5 to 0.9 times. Kernels for any number of
/// dimensions wait for the cache: splines on St(4,2) to St(8,3) take 0.95 to 1.1 times as long. The Python module is a
/// twelfth larger if all of them have eight.
pub(crate) struct Eight;

impl Width for Four {
    #[inline(always)]
    fn run<R>(work: impl FnOnce() -> R) -> R {
        #[cfg(target_arch = "x86_64")]
        return match pulp::x86::V3::try_new() {
            Some(simd) => simd.vectorize(work),
            None => work(),
        };
        #[cfg(not(target_arch = "x86_64"))]
        pulp::Arch::new().dispatch(work)
    }
}

impl Width for Eight {
    #[inline(always)]
    fn run<R>(work: impl FnOnce() -> R) -> R {
        pulp::Arch::new().dispatch(work)
    }
}

/// Runs `work`, compiled for vectors of up to [four](Four) numbers.
#[inline(always)]
pub(crate) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    Four::run(work)
}

/// Buffers for [`each`], one for every thread that works at the same time; they are kept for the next call.
pub(crate) struct Buffers<B> {
    /// Used by the calling thread if it works alone; threads of the pool get copies.
    pub(crate) own: B,
    spare: Mutex<Vec<B>>,
}

impl<B> Buffers<B> {
    pub(crate) fn new(own: B) -> Self {
        Buffers {
            own,
            spare: Mutex::new(Vec::new()),
        }
    }
}

/// Buffers that return when their thread has finished its items.
struct Taken<'a, B> {
    buffers: Option<B>,
    all: &'a Buffers<B>,
}

impl<B: Clone> Taken<'_, B> {
    fn get(&mut self) -> &mut B {
        let spare = || lock(&self.all.spare).pop();
        self.buffers
            .get_or_insert_with(|| spare().unwrap_or_else(|| self.all.own.clone()))
    }
}

impl<B> Drop for Taken<'_, B> {
    fn drop(&mut self) {
        lock(&self.all.spare).extend(self.buffers.take());
    }
}

/// Runs `work` on every item, of about so many microseconds, compiled for vectors of the given width, in tasks of the
/// thread pool if all of them take long enough; results do not depend on the number of threads.
#[inline(always)]
pub(crate) fn each<W: Width, A: Send, B: Clone + Send + Sync>(
    items: &mut [A],
    micros: f64,
    buffers: &mut Buffers<B>,
    work: impl Fn(&mut B, usize, &mut A) + Sync,
) {
    let of_task = TASK as f64 * micros;
    if is_alone(items.len().div_ceil(TASK), of_task) {
        return task::<W, A, B>(items, &mut buffers.own, 0, &work);
    }
    let all = &*buffers;
    let tasks = items.chunks_mut(TASK);
    let Ok(_) = threads::map_parts(
        tasks,
        of_task,
        || Taken { buffers: None, all },
        |taken, i, items| {
            task::<W, A, B>(items, taken.get(), TASK * i, &work);
            Ok::<_, Infallible>(())
        },
    );
}

/// Runs `work` on consecutive items, starting at index `first`. Not inlined, so that every kernel is compiled only once
/// for the caller's thread and the pool: the library's test program then has 55 MB instead of 64 MB.
#[inline(never)]
fn task<W: Width, A, B>(
    items: &mut [A],
    buffers: &mut B,
    first: usize,
    work: &impl Fn(&mut B, usize, &mut A),
) {
    W::run(
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
