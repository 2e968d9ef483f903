//! Options of splines of the binding.

use pyo3::prelude::*;

use super::error::to_exception;
use crate::error::Error;
use crate::spline::Outside;

/// Error where a tolerance is out of its range.
pub(super) fn check_tolerance(py: Python<'_>, tol: f64) -> PyResult<()> {
    if (1e-15..=0.1).contains(&tol) {
        return Ok(());
    }
    let error = Error::InvalidArgument {
        name: "tol",
        requirement: "between 1e-15 and 0.1",
        found: tol,
    };
    Err(to_exception(py, &error, ""))
}

pub(super) fn outside(extrapolate: bool) -> Outside {
    if extrapolate {
        Outside::Continued
    } else {
        Outside::Refused
    }
}
