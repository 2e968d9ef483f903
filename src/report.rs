//! What an iterative solver says when it stops.
//!
//! The reason for stopping is data, and stopping is not the same as converging.

use std::fmt;

/// Why an iteration stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum StopReason {
    /// The residual is at most the tolerance.
    Converged,
    /// The iteration limit was reached first.
    MaxIterations,
    /// No step along the Newton direction lowers the residual any more.
    Stagnated,
    /// The corrections grow instead of shrinking.
    Diverged,
    /// The Jacobian has no usable inverse.
    SingularJacobian,
}

impl StopReason {
    /// All reasons; new ones are added at the end, since stored curves count them.
    pub(crate) const ALL: [StopReason; 5] = [
        StopReason::Converged,
        StopReason::MaxIterations,
        StopReason::Stagnated,
        StopReason::Diverged,
        StopReason::SingularJacobian,
    ];

    /// The reason of a word, the inverse of [`StopReason::as_str`].
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|reason| reason.as_str() == word)
    }

    /// The reason as a word, the same in Rust and Python.
    pub fn as_str(self) -> &'static str {
        match self {
            StopReason::Converged => "converged",
            StopReason::MaxIterations => "max_iterations",
            StopReason::Stagnated => "stagnated",
            StopReason::Diverged => "diverged",
            StopReason::SingularJacobian => "singular_jacobian",
        }
    }
}

/// How an iteration ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverReport {
    /// Whether `residual <= tolerance`.
    pub converged: bool,
    /// Newton steps taken.
    pub iterations: usize,
    /// Norm of the residual at the returned iterate.
    pub residual: f64,
    /// The tolerance that was asked for.
    pub tolerance: f64,
    /// Why it stopped.
    pub reason: StopReason,
}

impl fmt::Display for SolverReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "stopped ({}) after {} iterations with residual {:.3e} (tolerance {:.3e})",
            self.reason.as_str(),
            self.iterations,
            self.residual,
            self.tolerance
        )
    }
}
