//! From the crate's error to a Python exception. The classes live in `stiefel_rs.errors`.

use pyo3::call::PyCallArgs;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use super::projection::PROJECTED;
use super::record::record;
use crate::error::Error;
use crate::report::{SolverReport, StopReason, Strategy};

/// Outcome of an iterative solver.
#[pyclass(name = "SolverReport", module = "stiefel_rs", frozen, get_all)]
#[derive(Clone, Copy)]
pub struct PySolverReport {
    /// Whether ``residual <= tolerance``.
    converged: bool,
    /// Newton steps taken.
    iterations: usize,
    /// Euclidean norm of the residual at the final iterate.
    residual: f64,
    /// Requested tolerance.
    tolerance: f64,
    /// Reason for stopping.
    ///
    /// One of ``"converged"``, ``"max_iterations"``, ``"stagnated"``, ``"diverged"``, ``"singular_jacobian"``,
    /// ``"not_minimal"`` and ``"work_limit"``.
    reason: &'static str,
    /// What found the solution of a boundary value problem, or a spline of Riemannian cubics.
    ///
    /// ``"direct"`` (Newton's method from the curve of flat space or from a guess), ``"descent"`` (to a curve of least
    /// cost first) or ``"continuation"`` (from a curve with other ends); None if nothing did, and for other solvers.
    strategy: Option<&'static str>,
}

#[pymethods]
impl PySolverReport {
    #[new]
    #[pyo3(signature = (converged, iterations, residual, tolerance, reason, strategy=None))]
    fn new(
        converged: bool,
        iterations: usize,
        residual: f64,
        tolerance: f64,
        reason: &str,
        strategy: Option<&str>,
    ) -> PyResult<Self> {
        let Some(reason) = StopReason::from_word(reason) else {
            return Err(invalid!("reason: unknown reason '{reason}'"));
        };
        let known = |word: &str| match Strategy::from_word(word) {
            Some(strategy) => Ok(strategy.as_str()),
            None => Err(invalid!("strategy: unknown strategy '{word}'")),
        };
        Ok(PySolverReport {
            strategy: strategy.map(known).transpose()?,
            converged,
            iterations,
            residual,
            tolerance,
            reason: reason.as_str(),
        })
    }
}

record! { PySolverReport, converged, iterations, residual, tolerance, reason, strategy }

impl From<SolverReport> for PySolverReport {
    fn from(report: SolverReport) -> Self {
        PySolverReport {
            converged: report.converged,
            iterations: report.iterations,
            residual: report.residual,
            tolerance: report.tolerance,
            reason: report.reason.as_str(),
            strategy: report.strategy.map(Strategy::as_str),
        }
    }
}

/// Builds an exception of `stiefel_rs.errors`.
fn build<'py>(py: Python<'py>, class: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let classes = py.import("stiefel_rs.errors");
    let instance = classes.and_then(|classes| classes.getattr(class)?.call1(arguments));
    instance.map_or_else(|error| error, PyErr::from_value)
}

/// `InvalidInputError` with a message written in the binding.
pub fn invalid_input(message: String) -> PyErr {
    Python::attach(|py| build(py, "InvalidInputError", (message,)))
}

/// `InvalidInputError` with a formatted message: `invalid!("{name}: not finite")`.
macro_rules! invalid {
    ($($message:tt)*) => { $crate::python::error::invalid_input(format!($($message)*)) };
}
pub(super) use invalid;

/// Returns `InvalidInputError` unless a condition holds: `ensure!(atol >= 0.0, "atol: negative, {atol}")`.
macro_rules! ensure {
    ($holds:expr, $($message:tt)*) => {
        match $holds {
            true => {}
            false => return Err($crate::python::error::invalid!($($message)*)),
        }
    };
}
pub(super) use ensure;

/// Restates an error about the real embedding of complex data in terms of the complex matrices: their shapes, and
/// defects and distances divided by `sqrt(2)`.
pub fn of_complex(error: Error) -> Error {
    use std::f64::consts::FRAC_1_SQRT_2 as SCALE;
    let boxed = |source: Box<Error>| Box::new(of_complex(*source));
    match error {
        Error::Shape {
            name,
            expected,
            found,
        } => Error::Shape {
            name,
            expected: halved(&expected).unwrap_or(expected),
            found: halved(&found).unwrap_or(found),
        },
        Error::BeyondInjectivity {
            index,
            distance,
            bound,
        } => Error::BeyondInjectivity {
            index,
            distance: SCALE * distance,
            bound: SCALE * bound,
        },
        Error::NotOrthonormal {
            name,
            defect,
            tolerance,
        } => Error::NotOrthonormal {
            name,
            defect: SCALE * defect,
            tolerance: SCALE * tolerance,
        },
        Error::NotTangent {
            name,
            defect,
            tolerance,
        } => Error::NotTangent {
            name,
            defect: SCALE * defect,
            tolerance: SCALE * tolerance,
        },
        Error::NotHorizontal {
            name,
            defect,
            tolerance,
        } => Error::NotHorizontal {
            name,
            defect: SCALE * defect,
            tolerance: SCALE * tolerance,
        },
        Error::AtKnot { knot, source } => Error::AtKnot {
            knot,
            source: boxed(source),
        },
        Error::ControlPoints { source } => Error::ControlPoints {
            source: boxed(source),
        },
        error => error,
    }
}

/// The shape `(n, k)` of complex matrices for `(2n, 2k)`; `None` if the text is not a pair of even numbers.
fn halved(shape: &str) -> Option<String> {
    let (rows, cols) = shape
        .strip_prefix('(')?
        .strip_suffix(')')?
        .split_once(", ")?;
    let half = |size: &str| Some(size.parse::<usize>().ok()? / 2);
    Some(format!("({}, {})", half(rows)?, half(cols)?))
}

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        to_exception(&error, "")
    }
}

/// The exception for an error; `place` names the member of a batch, or is empty.
fn to_exception(error: &Error, place: &str) -> PyErr {
    let exception = Python::attach(|py| exception_of(py, error, place));
    match error {
        Error::AtKnot { knot, .. } => at_knot(exception, *knot),
        _ => exception,
    }
}

/// The exception for an error of the `i`-th member of a batch of the given shape.
pub fn at_member(error: &Error, i: usize, shape: &[usize]) -> PyErr {
    match shape {
        [] => to_exception(error, ""),
        _ => to_exception(error, &format!(" (batch member {i})")),
    }
}

/// Sets the attribute `knot` of an exception.
pub fn at_knot(exception: PyErr, knot: usize) -> PyErr {
    let set = Python::attach(|py| exception.value(py).setattr("knot", knot));
    set.map_or_else(|error| error, |()| exception)
}

/// Advice, in Python's terms, for a rejected point whose defect `project=True` accepts.
const POINT_ADVICE: &str = "curves take it with project=True; `project` of the manifold gives";

/// The same where it does not.
const PROJECTION: &str = "`project` of the manifold gives";

/// The same for the argument of a logarithm of rotations.
const SQUARE_ADVICE: &str = "`Stiefel(m, m).project` gives";

/// Advice for a time outside the knots.
const EXTRAPOLATION: &str = "extrapolate=True continues the curve";

/// Advice for a rejected vector.
const VECTOR_ADVICE: &str = "; `project_tangent` gives the tangent part";

/// Whether an error about two neighbours suggests another knot between them: not for mere bases.
fn is_cured_by_a_knot(error: &Error) -> bool {
    match error {
        Error::AtKnot { source, .. } => !matches!(**source, Error::OnlyBases { .. }),
        _ => false,
    }
}

fn exception_of(py: Python<'_>, error: &Error, place: &str) -> PyErr {
    let mut message = error.to_string();
    let name = "tolerance";
    if matches!(error, Error::InvalidArgument { name: found, .. } if *found == name) {
        // The option `tolerance` of the core is the argument `tol` in Python.
        message = message.replacen(name, "tol", 1);
    }
    // The exception class depends on the innermost cause, wherever it occurred.
    let cause = error.cause();
    match cause {
        Error::NotOrthonormal { name, defect, .. } => {
            let advice = match *defect <= PROJECTED {
                _ if *name == "Q" => SQUARE_ADVICE,
                true => POINT_ADVICE,
                false => PROJECTION,
            };
            message = message.replacen("`Stiefel::project` gives", advice, 1);
        }
        Error::InvalidArgument { name: "t", .. } => {
            message = message.replacen("or enable extrapolation", EXTRAPOLATION, 1);
        }
        Error::OutsideLogDomain { .. } | Error::UndecidedTurn { .. } | Error::RightAngle { .. }
            if is_cured_by_a_knot(error) =>
        {
            message.push_str("; add a knot between them");
        }
        Error::NotTangent { .. } | Error::NotHorizontal { .. } => message.push_str(VECTOR_ADVICE),
        _ => {}
    }
    message.push_str(place);
    match cause {
        Error::OutsideLogDomain { .. }
        | Error::UndecidedTurn { .. }
        | Error::NoJoiningCurve { .. }
        | Error::RightAngle { .. }
        | Error::BranchJump { .. }
        | Error::BeyondInjectivity { .. }
        | Error::DifferentComponents { .. }
        | Error::OutsideRetractionDomain { .. }
        | Error::ConjugateEnds { .. }
        | Error::LogNotDifferentiable { .. }
        | Error::NotComplex { .. }
        | Error::OutsideChart { .. } => build(py, "OutsideDomainError", (message, error.angle())),
        Error::NoConvergence { report, .. } | Error::TooManySteps { report, .. } => {
            let report = PySolverReport::from(*report);
            build(py, "ConvergenceError", (message, report))
        }
        Error::Decomposition { .. } => build(py, "ConvergenceError", (message,)),
        Error::Interrupted { .. } => PyKeyboardInterrupt::new_err(message),
        _ => invalid_input(message),
    }
}
