//! A solution of a boundary value problem.

use super::problem::BoundaryProblem;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::error::Result;
use crate::interrupt::Interrupt;

/// The solution of a boundary value problem.
pub(crate) struct SolvedStart {
    /// `(x', x'')` at the start.
    pub(crate) start: Vec<f64>,
    /// The curve, if the method that found it provides it.
    taylor: Option<PiecewiseTaylor>,
}

impl SolvedStart {
    /// A solution whose curve is integrated when it is needed.
    pub(crate) fn of_start(start: Vec<f64>) -> Self {
        SolvedStart {
            start,
            taylor: None,
        }
    }

    pub(crate) fn new(start: Vec<f64>, taylor: PiecewiseTaylor) -> Self {
        SolvedStart {
            start,
            taylor: Some(taylor),
        }
    }

    /// The curve, in the coordinates of the span.
    ///
    /// # Errors
    /// As [`BoundaryProblem::integrated`].
    pub(crate) fn into_taylor(
        self,
        problem: &BoundaryProblem,
        interrupt: Interrupt<'_>,
    ) -> Result<PiecewiseTaylor> {
        match self.taylor {
            Some(taylor) => Ok(taylor),
            None => problem.integrated(&self.start, interrupt),
        }
    }
}
