//! A solution of a boundary value problem.

use super::path::Path;
use super::problem::Problem;
use crate::error::Result;
use crate::interrupt::Interrupt;

/// The solution of a boundary value problem.
pub(super) struct Solution {
    /// `(x', x'')` at the start.
    pub(super) start: Vec<f64>,
    /// The curve, if the method that found it provides it.
    path: Option<Path>,
}

impl Solution {
    /// A solution whose curve is integrated when it is needed.
    pub(super) fn of_start(start: Vec<f64>) -> Self {
        Solution { start, path: None }
    }

    pub(super) fn new(start: Vec<f64>, path: Path) -> Self {
        Solution {
            start,
            path: Some(path),
        }
    }

    /// The curve, in the coordinates of the span.
    ///
    /// # Errors
    /// As [`Problem::path`].
    pub(super) fn into_path(self, problem: &Problem, interrupt: Interrupt<'_>) -> Result<Path> {
        match self.path {
            Some(path) => Ok(path),
            None => problem.path(&self.start, interrupt),
        }
    }
}
