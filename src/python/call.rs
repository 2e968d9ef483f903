//! Calls into the core without the GIL, on a chosen number of threads, stoppable by Ctrl-C.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use faer::{Mat, MatRef};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::error::{ensure, of_complex};
use super::field::Field;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::threads::without_pool;

/// Batches from this amount of work on, some tenths of a millisecond, are distributed among threads, and all work in a
/// pool runs while the calling thread watches for Ctrl-C.
const LONG: f64 = 3e3;

/// Work from which on a call that is not distributed runs on another thread, some milliseconds. Starting a thread takes
/// 40 us, waking a parked one 30. With [`LONG`] instead, retractions on `St(200, 20)` take 107 us instead of 48,
/// boundary problems on `St(4, 2)` 234 instead of 177, splines through 10 rotations 121 instead of 87.
const WATCHED: f64 = 3e4;

/// Members of a batch share buffers in blocks of about this much work, roughly a tenth of a millisecond.
const BLOCK: f64 = 500.0;

/// Work to solve for a curve, relative to an exponential.
pub const SOLVES: f64 = 100.0;

/// Interval between two checks for Ctrl-C.
const POLL: Duration = Duration::from_millis(50);

/// Bounds on data that other threads use.
pub trait Shared: Send + Sync + 'static {}

impl<T: Send + Sync + 'static> Shared for T {}

/// A call into the core.
#[derive(Clone, Copy)]
pub struct Call<'py> {
    pub py: Python<'py>,
    num_threads: Option<usize>,
    /// Estimated work, from the amount of data read and written. It decides whether the call runs on another thread and
    /// how a batch is divided; results do not depend on it.
    numbers: f64,
    /// Whether its work is distributed among threads. The calling thread then waits for them, and would not see Ctrl-C,
    /// as in a pool.
    is_distributed: bool,
    /// Whether it may take far longer than estimated, as iterations do.
    is_uncertain: bool,
    /// Field of the matrices, for error messages.
    field: Field,
}

impl<'py> Call<'py> {
    /// `num_threads = None` selects the global pool of rayon.
    pub fn new(py: Python<'py>, num_threads: Option<i64>, numbers: f64) -> PyResult<Self> {
        if let Some(found) = num_threads {
            let expected = "num_threads: must be between 1 and 4096";
            ensure!((1..=4096).contains(&found), "{expected}, found {found}");
        }
        let num_threads = num_threads.map(|threads| threads as usize);
        Ok(Call {
            py,
            num_threads,
            numbers,
            is_distributed: false,
            is_uncertain: false,
            field: Field::Real,
        })
    }

    /// The same call for matrices of a field.
    pub fn over(self, field: Field) -> Self {
        Call { field, ..self }
    }

    /// The same call, whose work may be distributed among threads. Splines of Riemannian cubics through few points
    /// ([`ON_ONE_THREAD`](crate::linalg::simd::ON_ONE_THREAD), for rotations
    /// [`ROTATIONS_ON_ONE_THREAD`](crate::shooting::ROTATIONS_ON_ONE_THREAD)) use other threads only in methods of last
    /// resort, between whose steps the calling thread polls: they do not count.
    pub fn distributed(self, is_distributed: bool) -> Self {
        Call {
            is_distributed,
            ..self
        }
    }

    /// The same call, whose work may take far longer than estimated: it is watched wherever it leaves this thread.
    pub fn uncertain(self) -> Self {
        Call {
            is_uncertain: true,
            ..self
        }
    }

    /// Restates an error in the shapes and numbers of the user's matrices.
    pub fn explained(&self, error: Error) -> Error {
        match self.field {
            Field::Real => error,
            Field::Complex => of_complex(error),
        }
    }

    /// Whether the call is worth distributing.
    pub fn is_long(&self) -> bool {
        self.numbers >= LONG
    }

    /// Whether this thread only watches for Ctrl-C while another one works.
    fn is_watched(&self) -> bool {
        let is_elsewhere = match self.num_threads {
            None => self.is_distributed,
            Some(threads) => threads > 1,
        };
        let least = match is_elsewhere {
            true if self.is_uncertain => 0.0,
            true => LONG,
            false => WATCHED,
        };
        self.numbers >= least
    }

    /// Number of batch members per block: depends on the work alone, not on the number of threads.
    pub fn block(&self, len: usize) -> usize {
        let one = self.numbers / len.max(1) as f64;
        ((BLOCK / one.max(1.0)) as usize).clamp(1, 1024)
    }

    /// Runs `work` without the GIL and converts an error of the core to an exception.
    pub fn run<T: Send + 'static>(
        &self,
        work: impl FnOnce(Interrupt<'_>) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        Ok(self.run_any(work)?.map_err(|error| self.explained(error))?)
    }

    /// Runs work of a fraction of a second in place, without the GIL; it may borrow.
    pub fn run_here<T: Send>(&self, work: impl FnOnce() -> T + Send) -> PyResult<T> {
        let threads = self.num_threads.map_or(Ok(Threads::Any), Threads::of)?;
        let (mut work, mut result) = (Some(work), None);
        let mut job = || result = work.take().map(|work| work());
        self.py.detach(|| threads.run(&mut job));
        result.ok_or_else(died)
    }

    /// Runs `work` without the GIL and returns its result.
    pub fn run_any<T: Send + 'static>(
        &self,
        work: impl FnOnce(Interrupt<'_>) -> T + Send + 'static,
    ) -> PyResult<T> {
        let threads = self.num_threads.map_or(Ok(Threads::Any), Threads::of)?;
        if self.is_watched() {
            let result = Arc::new(Mutex::new(None));
            let out = Arc::clone(&result);
            let job = Box::new(move |interrupt: Interrupt<'_>| {
                let value = work(interrupt);
                *unpoisoned(&out) = Some(value);
            });
            self.py.detach(|| run_watched(threads, job))?;
            let result = unpoisoned(&result).take();
            return result.ok_or_else(died);
        }
        let (mut work, mut result) = (Some(work), None);
        let mut job = |interrupt: Interrupt<'_>| result = work.take().map(|work| work(interrupt));
        self.py.detach(|| run_in_place(&threads, &mut job))?;
        result.ok_or_else(died)
    }
}

fn unpoisoned<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn died() -> PyErr {
    failed(&"a call ended without a result")
}

/// [`Call::run`] on rayon's global pool.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    field: Field,
    numbers: f64,
    work: impl FnOnce(Interrupt<'_>) -> Result<T> + Send + 'static,
) -> PyResult<T> {
    Call::new(py, None, numbers)?.over(field).run(work)
}

/// [`run`] on matrices; each entry costs `weight` times the work of an exponential.
pub fn run_on<T: Send + 'static, const N: usize>(
    py: Python<'_>,
    field: Field,
    data: [Mat<f64>; N],
    weight: f64,
    work: impl FnOnce([MatRef<'_, f64>; N], Interrupt<'_>) -> Result<T> + Send + 'static,
) -> PyResult<T> {
    let numbers: usize = data.iter().map(|x| x.nrows() * x.ncols()).sum();
    run(py, field, weight * numbers as f64, move |interrupt| {
        work(data.each_ref().map(|x| x.as_ref()), interrupt)
    })
}

/// Most polls that pass without a look at the clock, which costs as much as a short piece of work. Problems on `St(16,4)`
/// poll every 20 ms: with 16 polls, Ctrl-C takes 0.3 s.
const UNSEEN: u32 = 8;

/// Polls that pass before the first look. With none, curves from initial values on the sphere, which make two or three,
/// take 1.03 times as long.
const FIRST: u32 = 3;

/// More of them pass as long as polls follow one another this quickly, and none after a slower one.
const QUICK: Duration = Duration::from_millis(1);

/// Runs a job in place that occasionally polls for Ctrl-C, in case it takes longer than estimated. Jobs of all types
/// are run by the same code: compiled for each of them, the module would have 4 MB more.
fn run_in_place(threads: &Threads, job: &mut (dyn FnMut(Interrupt<'_>) + Send)) -> PyResult<()> {
    let (caller, unseen) = (std::thread::current().id(), AtomicU32::new(FIRST));
    let start = Instant::now();
    let clock = Mutex::new(Clock {
        read: start,
        checked: start,
        unseen: 0,
        signal: None,
    });
    let question = || {
        let left = unseen.load(Ordering::Relaxed);
        if left > 0 {
            unseen.store(left - 1, Ordering::Relaxed);
            return false;
        }
        // Only the calling thread can receive a signal.
        if std::thread::current().id() != caller {
            return false;
        }
        let mut clock = unpoisoned(&clock);
        unseen.store(clock.look(), Ordering::Relaxed);
        clock.signal.is_some()
    };
    threads.run(&mut || job(Interrupt::new(&question)));
    let clock = clock.into_inner().unwrap_or_else(PoisonError::into_inner);
    clock.signal.map_or(Ok(()), Err)
}

/// When the clock was last read and a signal last checked for, how many polls pass unseen, and the signal that was
/// found.
struct Clock {
    read: Instant,
    checked: Instant,
    unseen: u32,
    signal: Option<PyErr>,
}

impl Clock {
    /// Reads the clock, and checks for a signal unless the last check is recent; returns how many polls may pass
    /// unseen.
    fn look(&mut self) -> u32 {
        let before = std::mem::replace(&mut self.read, Instant::now());
        if self.signal.is_none() && self.read - self.checked >= POLL {
            self.signal = Python::attach(|py| py.check_signals()).err();
            self.checked = self.read;
        }
        let is_quick = self.read - before < QUICK * (1 + self.unseen);
        self.unseen = match is_quick && self.signal.is_none() {
            true => (2 * self.unseen).clamp(1, UNSEEN),
            false => 0,
        };
        self.unseen
    }
}

/// The threads on which a call works.
enum Threads {
    /// The calling one, helped by those of rayon's global pool.
    Any,
    /// The calling one alone.
    One,
    /// Those of a pool, created once for each size, so that calls do not pay for starting threads.
    Pool(Arc<ThreadPool>),
}

impl Threads {
    fn of(count: usize) -> PyResult<Self> {
        static POOLS: Mutex<BTreeMap<usize, Arc<ThreadPool>>> = Mutex::new(BTreeMap::new());
        if count == 1 {
            return Ok(Threads::One);
        }
        let mut pools = unpoisoned(&POOLS);
        if let Some(pool) = pools.get(&count) {
            return Ok(Threads::Pool(Arc::clone(pool)));
        }
        let pool = ThreadPoolBuilder::new().num_threads(count).build();
        let pool = Arc::new(pool.map_err(|error| failed(&error))?);
        pools.insert(count, Arc::clone(&pool));
        Ok(Threads::Pool(pool))
    }

    fn run(&self, job: &mut (dyn FnMut() + Send)) {
        match self {
            Threads::Any => job(),
            Threads::One => without_pool(job),
            Threads::Pool(pool) => pool.install(job),
        }
    }
}

fn failed(error: &dyn std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

/// Runs a job on another thread while this one, which may be the main thread, checks for signals.
///
/// The worker owns its data: after Ctrl-C this call returns at once, while the worker stops at its next check, or after
/// the current factorisation, and drops its result.
fn run_watched(threads: Threads, job: Box<dyn FnOnce(Interrupt<'_>) + Send>) -> PyResult<()> {
    let stop = Arc::new(AtomicBool::new(false));
    let (sender, receiver) = channel();
    let asked = Arc::clone(&stop);
    let worker = move || {
        let question = || asked.load(Ordering::Relaxed);
        let mut job = Some(job);
        threads.run(&mut || {
            if let Some(job) = job.take() {
                job(Interrupt::new(&question));
            }
        });
        // The receiver is gone if the call was interrupted.
        let _ = sender.send(());
    };
    std::thread::Builder::new()
        .spawn(worker)
        .map_err(|error| failed(&error))?;
    loop {
        match receiver.recv_timeout(POLL) {
            Ok(()) => return Ok(()),
            Err(RecvTimeoutError::Disconnected) => return Err(died()),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(signal) = Python::attach(|py| py.check_signals()) {
                    stop.store(true, Ordering::Relaxed);
                    return Err(signal);
                }
            }
        }
    }
}

/// Return the number of threads of the global pool.
#[pyfunction]
pub fn num_threads() -> usize {
    rayon::current_num_threads()
}

/// Return the SIMD instruction sets that this processor offers and that the library may use.
#[pyfunction]
pub fn simd_features() -> Vec<&'static str> {
    crate::linalg::simd::features()
}
