//! Running the core without the interpreter lock, on a chosen number of threads, stoppable by Ctrl-C.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::error::{invalid_input, to_exception};
use crate::error::Result;
use crate::interrupt::Interrupt;

/// Calls estimated below this many operations (a few milliseconds) run in place: a thread costs more than it brings.
const SHORT: f64 = 1e7;

/// Members of a batch share buffers in blocks of about this many operations, a tenth of a millisecond or so.
const BLOCK: f64 = 3e5;

/// How often a waiting call looks for Ctrl-C.
const POLL: Duration = Duration::from_millis(50);

/// A call into the core.
pub struct Call {
    num_threads: Option<usize>,
    /// Estimated floating-point operations.
    operations: f64,
}

impl Call {
    /// `num_threads = None` takes rayon's global pool.
    pub fn new(py: Python<'_>, num_threads: Option<i64>, operations: f64) -> PyResult<Self> {
        let num_threads = match num_threads {
            None => None,
            Some(threads @ 1..=4096) => Some(threads as usize),
            Some(found) => {
                return Err(invalid_input(
                    py,
                    format!("num_threads: must be between 1 and 4096, found {found}"),
                ));
            }
        };
        Ok(Call {
            num_threads,
            operations,
        })
    }

    /// Whether the call is worth sharing out.
    pub fn is_long(&self) -> bool {
        self.operations > SHORT
    }

    /// How many of the `len` members of a batch are a block: by the work alone, not by the number of threads.
    pub fn block(&self, len: usize) -> usize {
        let one = self.operations / len.max(1) as f64;
        ((BLOCK / one.max(1.0)) as usize).clamp(1, 1024)
    }

    /// Runs `work` detached from the interpreter; an error of the core becomes the exception.
    pub fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(Interrupt<'_>) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        self.run_any(py, work)?
            .map_err(|error| to_exception(py, &error, ""))
    }

    /// Runs work of a fraction of a second where it stands, detached from the interpreter: it may borrow.
    pub fn run_here<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce() -> T + Send,
    ) -> PyResult<T> {
        let pool = self.num_threads.map(pool_of).transpose()?;
        Ok(py.detach(|| run_in(pool.as_deref(), work)))
    }

    /// Runs `work` detached from the interpreter and returns what it returns.
    pub fn run_any<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(Interrupt<'_>) -> T + Send + 'static,
    ) -> PyResult<T> {
        let pool = self.num_threads.map(pool_of).transpose()?;
        if self.is_long() {
            return py.detach(|| run_watched(pool, work));
        }
        let watch = Watch::new();
        let question = || watch.stops();
        let result = py.detach(|| run_in(pool.as_deref(), || work(Interrupt::new(&question))));
        match watch.signal.into_inner() {
            Ok(Some(signal)) => Err(signal),
            _ => Ok(result),
        }
    }
}

/// Looks for Ctrl-C now and then from inside of a call that runs where it stands, should it take longer than estimated.
struct Watch {
    caller: ThreadId,
    start: Instant,
    questions: AtomicU32,
    /// Milliseconds after the start at which to look next.
    next: AtomicU64,
    signal: Mutex<Option<PyErr>>,
}

/// Questions between two looks at the clock, which would cost as much as a short piece of work.
const QUESTIONS: u32 = 64;

impl Watch {
    fn new() -> Self {
        Watch {
            caller: std::thread::current().id(),
            start: Instant::now(),
            questions: AtomicU32::new(1),
            next: AtomicU64::new(POLL.as_millis() as u64),
            signal: Mutex::new(None),
        }
    }

    /// Whether a signal was raised. Only the thread that called can find one.
    fn stops(&self) -> bool {
        let asked = self.questions.fetch_add(1, Ordering::Relaxed);
        if !asked.is_multiple_of(QUESTIONS) || std::thread::current().id() != self.caller {
            return false;
        }
        let now = self.start.elapsed().as_millis() as u64;
        if now < self.next.load(Ordering::Relaxed) {
            return false;
        }
        let period = POLL.as_millis() as u64;
        self.next.store(now + period, Ordering::Relaxed);
        match Python::attach(|py| py.check_signals()) {
            Ok(()) => false,
            Err(signal) => {
                *self.signal.lock().unwrap_or_else(PoisonError::into_inner) = Some(signal);
                true
            }
        }
    }
}

/// Runs `work` in a pool, or where it stands: then rayon's global pool serves it.
fn run_in<T: Send>(pool: Option<&ThreadPool>, work: impl FnOnce() -> T + Send) -> T {
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// The pool of a given size, made once: a call must not pay for its threads.
fn pool_of(threads: usize) -> PyResult<Arc<ThreadPool>> {
    static POOLS: Mutex<BTreeMap<usize, Arc<ThreadPool>>> = Mutex::new(BTreeMap::new());
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = pools.get(&threads) {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = Arc::new(pool.map_err(|error| failed(&error))?);
    pools.insert(threads, Arc::clone(&pool));
    Ok(pool)
}

fn failed(error: &dyn std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

/// Works on another thread while this one, which may be the main thread, keeps an eye on signals.
///
/// The worker owns what it works on: after Ctrl-C this call returns at once, and the worker stops at its next
/// question, or at the end of the factorisation it is in, and drops its result.
fn run_watched<T: Send + 'static>(
    pool: Option<Arc<ThreadPool>>,
    work: impl FnOnce(Interrupt<'_>) -> T + Send + 'static,
) -> PyResult<T> {
    let stop = Arc::new(AtomicBool::new(false));
    let (sender, receiver) = channel();
    let asked = Arc::clone(&stop);
    let worker = move || {
        let question = || asked.load(Ordering::Relaxed);
        let result = run_in(pool.as_deref(), || work(Interrupt::new(&question)));
        // The receiver is gone if the call was interrupted.
        let _ = sender.send(result);
    };
    std::thread::Builder::new()
        .spawn(worker)
        .map_err(|error| failed(&error))?;
    loop {
        match receiver.recv_timeout(POLL) {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Disconnected) => return Err(failed(&"a worker thread died")),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(signal) = Python::attach(|py| py.check_signals()) {
                    stop.store(true, Ordering::Relaxed);
                    return Err(signal);
                }
            }
        }
    }
}

/// Number of threads of the global pool.
#[pyfunction]
pub fn num_threads() -> usize {
    rayon::current_num_threads()
}

/// The vector instruction sets that this processor offers and the kernels may use.
#[pyfunction]
pub fn simd_features() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    {
        let found = [
            ("sse2", std::is_x86_feature_detected!("sse2")),
            ("avx", std::is_x86_feature_detected!("avx")),
            ("avx2", std::is_x86_feature_detected!("avx2")),
            ("fma", std::is_x86_feature_detected!("fma")),
            ("avx512f", std::is_x86_feature_detected!("avx512f")),
        ];
        found
            .into_iter()
            .filter(|(_, has)| *has)
            .map(|(name, _)| name)
            .collect()
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        vec![std::env::consts::ARCH]
    }
}
