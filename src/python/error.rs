//! From the crate's error to a Python exception. The classes live in `stiefel_rs.errors`.

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use super::record::{Reduced, reduce, repr};
use crate::error::Error;
use crate::report::{SolverReport, StopReason};

/// How an iteration ended.
///
/// Attributes
/// ----------
/// converged : bool
///     Whether ``residual <= tolerance``.
/// iterations : int
///     Newton steps taken.
/// residual : float
///     Euclidean norm of the residual at the returned iterate.
/// tolerance : float
///     The tolerance that was asked for.
/// reason : str
///     ``"converged"``, ``"max_iterations"``, ``"stagnated"``, ``"diverged"``, ``"singular_jacobian"``, ``"not_minimal"``
///     or ``"work_limit"``.
#[pyclass(name = "SolverReport", module = "stiefel_rs", frozen)]
#[derive(Clone, Copy)]
pub struct PySolverReport(pub SolverReport);

#[pymethods]
impl PySolverReport {
    #[new]
    fn new(
        converged: bool,
        iterations: usize,
        residual: f64,
        tolerance: f64,
        reason: &str,
    ) -> PyResult<Self> {
        let Some(reason) = StopReason::from_word(reason) else {
            return Err(invalid_input(format!("reason: '{reason}' is not one")));
        };
        Ok(PySolverReport(SolverReport {
            converged,
            iterations,
            residual,
            tolerance,
            reason,
        }))
    }
    #[getter]
    fn converged(&self) -> bool {
        self.0.converged
    }
    #[getter]
    fn iterations(&self) -> usize {
        self.0.iterations
    }
    #[getter]
    fn residual(&self) -> f64 {
        self.0.residual
    }
    #[getter]
    fn tolerance(&self) -> f64 {
        self.0.tolerance
    }
    #[getter]
    fn reason(&self) -> &'static str {
        self.0.reason.as_str()
    }
    /// For pickle and copy.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduce(slf, &FIELDS)
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        repr(slf, &FIELDS)
    }
}

const FIELDS: [&str; 5] = ["converged", "iterations", "residual", "tolerance", "reason"];

static INVALID_INPUT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static OUTSIDE_DOMAIN: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static CONVERGENCE: PyOnceLock<Py<PyType>> = PyOnceLock::new();

fn build<'py, A>(py: Python<'py>, cell: &PyOnceLock<Py<PyType>>, class: &str, arguments: A) -> PyErr
where
    A: pyo3::call::PyCallArgs<'py>,
{
    let instance = cell
        .import(py, "stiefel_rs.errors", class)
        .and_then(|class| class.call1(arguments));
    match instance {
        Ok(instance) => PyErr::from_value(instance),
        Err(error) => error,
    }
}

/// `InvalidInputError` with a message of the binding's own.
pub fn invalid_input(message: String) -> PyErr {
    Python::attach(|py| build(py, &INVALID_INPUT, "InvalidInputError", (message,)))
}

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        to_exception(&error, "")
    }
}

/// The exception for an error; `place` says which member of a batch it was, or is empty.
pub fn to_exception(error: &Error, place: &str) -> PyErr {
    let exception = Python::attach(|py| exception_of(py, error, place));
    match error {
        Error::AtKnot { knot, .. } => at_knot(exception, *knot),
        _ => exception,
    }
}

/// The exception with the knot that it is about.
pub fn at_knot(exception: PyErr, knot: usize) -> PyErr {
    let set = Python::attach(|py| exception.value(py).setattr("knot", knot));
    set.map_or_else(|error| error, |()| exception)
}

fn exception_of(py: Python<'_>, error: &Error, place: &str) -> PyErr {
    let mut message = format!("{error}{place}");
    if let Error::InvalidArgument {
        name: name @ "tolerance",
        ..
    } = error
    {
        // What the options of the core call a tolerance is an argument `tol` in Python.
        message = message.replacen(name, "tol", 1);
    }
    // The class is that of what is wrong, wherever it is.
    let mut cause = error;
    while let Error::AtKnot { source, .. } | Error::ControlPoints { source } = cause {
        cause = source;
    }
    match cause {
        Error::OutsideLogDomain { .. }
        | Error::NoJoiningCurve { .. }
        | Error::BranchJump { .. }
        | Error::BeyondInjectivity { .. }
        | Error::DifferentComponents { .. }
        | Error::OutsideRetractionDomain { .. }
        | Error::ConjugateEnds { .. }
        | Error::OutsideChart { .. } => build(
            py,
            &OUTSIDE_DOMAIN,
            "OutsideDomainError",
            (message, error.angle()),
        ),
        Error::NoConvergence { report, .. } | Error::TooManySteps { report, .. } => build(
            py,
            &CONVERGENCE,
            "ConvergenceError",
            (message, PySolverReport(*report)),
        ),
        Error::Decomposition { .. } => build(py, &CONVERGENCE, "ConvergenceError", (message,)),
        Error::Interrupted { .. } => PyKeyboardInterrupt::new_err(message),
        _ => invalid_input(message),
    }
}
