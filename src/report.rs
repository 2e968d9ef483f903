//! The report of an iterative solver.
//!
//! The reason for stopping is data: a solver may stop without having converged.

use std::fmt;

/// Why an iteration stopped.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::BoundaryOptions;
/// use stiefel_rs::{Error, Interrupt, RiemannianCubic, StopReason};
/// let (s0, v0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (s1, v1) = (mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [2.0]]);
/// let options = BoundaryOptions { max_iterations: 1, ..Default::default() };
/// let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
/// match RiemannianCubic::from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER) {
///     Err(Error::NoConvergence { report, .. }) => assert_eq!(report.reason, StopReason::MaxIterations),
///     _ => panic!("one Newton step is not enough"),
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum StopReason {
    /// The residual is at most the tolerance.
    Converged,
    /// The iteration limit was reached first.
    MaxIterations,
    /// No step reduces the residual any more, or no start leads to a solution.
    Stagnated,
    /// The corrections grow instead of shrinking.
    Diverged,
    /// The Jacobian has no usable inverse.
    SingularJacobian,
    /// The equations are satisfied, but the curve is not a minimum: a better one exists.
    NotMinimal,
    /// The work limit was reached first. It is about a second from the first start, and two from all together, and is
    /// raised in proportion when more iterations are allowed than by default.
    WorkLimit,
}

impl StopReason {
    /// All reasons. Append new ones: stored curves identify a reason by its position.
    pub(crate) const ALL: [StopReason; 7] = [
        StopReason::Converged,
        StopReason::MaxIterations,
        StopReason::Stagnated,
        StopReason::Diverged,
        StopReason::SingularJacobian,
        StopReason::NotMinimal,
        StopReason::WorkLimit,
    ];

    /// The reason with a given name, the inverse of [`StopReason::as_str`].
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|reason| reason.as_str() == word)
    }

    /// The name of the reason, the same in Rust and Python.
    pub fn as_str(self) -> &'static str {
        match self {
            StopReason::Converged => "converged",
            StopReason::MaxIterations => "max_iterations",
            StopReason::Stagnated => "stagnated",
            StopReason::Diverged => "diverged",
            StopReason::SingularJacobian => "singular_jacobian",
            StopReason::NotMinimal => "not_minimal",
            StopReason::WorkLimit => "work_limit",
        }
    }
}

/// How a curve between given ends, or through given points, was found.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::BoundaryOptions;
/// use stiefel_rs::{Interrupt, RiemannianCubic, Strategy};
/// // Ends so near that Newton's method needs no help, and nearly opposite ones with speed across the way.
/// let (s0, near, far) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]], mat![[-0.96], [0.28], [0.0]]);
/// let v = mat![[0.0], [0.0], [4.0]];
/// let strategy = |s1: &faer::Mat<f64>, v: &faer::Mat<f64>| {
///     let [s0, v, s1] = [&s0, v, s1].map(|a| a.as_ref());
///     let curve = RiemannianCubic::from_boundary(s0, v, s1, v, &BoundaryOptions::default(), Interrupt::NEVER)?;
///     Ok::<_, stiefel_rs::Error>(curve.report().and_then(|report| report.strategy))
/// };
/// assert_eq!(strategy(&near, &(0.5 * &v))?, Some(Strategy::Direct));
/// assert_eq!(strategy(&far, &v)?, Some(Strategy::Descent));
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Strategy {
    /// Newton's method from the curve of flat space, from a guess, or, among several solutions of subspaces, from random
    /// data.
    Direct,
    /// A descent to a curve of least cost, which goes on to the tolerance or is followed by Newton's method.
    Descent,
    /// Continuation from a curve with other end data: a cubic of flat space with an extra full turn, or one with random
    /// initial data.
    Continuation,
}

impl Strategy {
    /// All strategies. Append new ones: stored curves identify a strategy by its position.
    pub(crate) const ALL: [Strategy; 3] =
        [Strategy::Direct, Strategy::Descent, Strategy::Continuation];

    /// The strategy with a given name, the inverse of [`Strategy::as_str`].
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|strategy| strategy.as_str() == word)
    }

    /// The name of the strategy, the same in Rust and Python.
    pub fn as_str(self) -> &'static str {
        match self {
            Strategy::Direct => "direct",
            Strategy::Descent => "descent",
            Strategy::Continuation => "continuation",
        }
    }
}

/// How an iteration ended.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::BoundaryOptions;
/// use stiefel_rs::{Interrupt, RiemannianCubic, StopReason};
/// let (s0, v0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (s1, v1) = (mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [2.0]]);
/// let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
/// let curve = RiemannianCubic::from_boundary(s0, v0, s1, v1, &BoundaryOptions::default(), Interrupt::NEVER)?;
/// let report = curve.report().expect("it comes from a boundary value problem");
/// assert!(report.converged && report.reason == StopReason::Converged);
/// assert!(report.residual <= report.tolerance && report.iterations < 10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverReport {
    /// Whether `residual <= tolerance`.
    pub converged: bool,
    /// Newton steps taken, from all starts together.
    pub iterations: usize,
    /// Norm of the residual at the returned iterate.
    pub residual: f64,
    /// The tolerance that was asked for.
    pub tolerance: f64,
    /// Why it stopped.
    pub reason: StopReason,
    /// What found the solution, for boundary value problems and splines of Riemannian cubics; `None` if nothing did, and
    /// for other solvers.
    pub strategy: Option<Strategy>,
}

impl SolverReport {
    pub(crate) fn new(
        reason: StopReason,
        iterations: usize,
        residual: f64,
        tolerance: f64,
    ) -> Self {
        SolverReport {
            converged: reason == StopReason::Converged,
            iterations,
            residual,
            tolerance,
            reason,
            strategy: None,
        }
    }

    /// The same with what found the solution, if there is one.
    pub(crate) fn found_by(self, strategy: Strategy) -> Self {
        SolverReport {
            strategy: self.converged.then_some(strategy),
            ..self
        }
    }
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
