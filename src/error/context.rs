//! Where an error happened, and what it is about: wrapping, and questions to errors.

use super::Error;
use crate::report::{SolverReport, StopReason};

impl Error {
    /// `NoConvergence` with the report of a solver, whose tolerance, possibly raised for round-off, is replaced by the
    /// requested one.
    pub(crate) fn no_convergence(
        solver: &'static str,
        report: SolverReport,
        tolerance: f64,
    ) -> Self {
        let report = SolverReport {
            tolerance,
            ..report
        };
        Error::NoConvergence { solver, report }
    }

    /// The error, located at a knot.
    pub(crate) fn at_knot(self, knot: usize) -> Self {
        match self {
            error @ Error::Interrupted { .. } => error,
            error => Error::AtKnot {
                knot,
                source: Box::new(error),
            },
        }
    }

    /// The error, attributed to control points.
    pub(crate) fn of_control_points(self) -> Self {
        match self {
            error @ Error::Interrupted { .. } => error,
            error => Error::ControlPoints {
                source: Box::new(error),
            },
        }
    }

    /// Whether the points are too far apart, or no curve between them was found.
    pub(crate) fn is_about_distance(&self) -> bool {
        match self {
            Error::ControlPoints { source } => source.is_about_distance(),
            error => matches!(
                error,
                Error::OutsideLogDomain { .. }
                    | Error::NoJoiningCurve { .. }
                    | Error::DifferentComponents { .. }
                    | Error::OutsideRetractionDomain { .. }
                    | Error::BeyondInjectivity { .. }
                    | Error::BranchJump { .. }
                    | Error::TooManySteps { .. }
                    | Error::NoConvergence { .. }
            ),
        }
    }

    /// The error itself, without the knot, the control points or the hint around it.
    pub fn cause(&self) -> &Error {
        match self {
            Error::AtKnot { source, .. }
            | Error::ControlPoints { source }
            | Error::UnevenTimes { source, .. }
            | Error::OnlyBases { source, .. } => source.cause(),
            error => error,
        }
    }

    /// The report of the solver or integration that failed, if the error is about one.
    pub fn report(&self) -> Option<&SolverReport> {
        match self.cause() {
            Error::NoConvergence { report, .. } | Error::TooManySteps { report, .. } => {
                Some(report)
            }
            _ => None,
        }
    }

    /// The error after `steps` of at most `limit` steps with `left` time remaining, if the next step has the given
    /// length.
    pub(crate) fn too_many_steps(
        solver: &'static str,
        [steps, limit]: [usize; 2],
        left: f64,
        length: f64,
    ) -> Self {
        Error::TooManySteps {
            solver,
            limit,
            // A length of zero: more than can be counted.
            forecast: (left / length).min(f64::MAX).ceil(),
            report: SolverReport::new(StopReason::MaxIterations, steps, left, 0.0),
        }
    }

    pub(crate) fn is_interrupted(&self) -> bool {
        matches!(self, Error::Interrupted { .. })
    }

    /// The angle that is outside a domain, in radians, if the error is about an angle.
    pub fn angle(&self) -> Option<f64> {
        match self.cause() {
            Error::OutsideLogDomain { angle }
            | Error::UndecidedTurn { angle }
            | Error::LogNotDifferentiable { angle }
            | Error::NoJoiningCurve { angle }
            | Error::RightAngle { angle } => Some(*angle),
            Error::DifferentComponents { .. } | Error::BranchJump { .. } => {
                Some(std::f64::consts::PI)
            }
            Error::OutsideChart { value, .. } => Some(*value),
            Error::BeyondInjectivity { distance, .. } => Some(*distance),
            _ => None,
        }
    }
}
