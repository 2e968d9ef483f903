//! A boundary value problem of subspaces: a chain with one leg in the span of its data.

use std::sync::Arc;

use faer::{Mat, MatRef};

use crate::cubic::taylor::work::Work;
use crate::cubic::{BoundaryOptions, RiemannianCubic};
use crate::curve::span::Span;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::manifold::Grassmann;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::report::{SolverReport, StopReason, Strategy};
use crate::space::{Kind, Quotient};
use crate::spline::bases::joined;
use crate::spline::chains::chain::{SpannedSpace, pieces};
use crate::spline::chains::descent;
use crate::spline::chains::framed::{Framed, coordinates, frames};
use crate::spline::chains::motion::Motion;
use crate::spline::chains::solution::{ChainSolution, Effort, piece};
use crate::spline::chains::solve;
use crate::spline::ends::{End, Ends};
use crate::spline::options::{MAX_ITERATIONS, SplineOptions};
use crate::spline::reduced_knots::ReducedKnots;

pub(crate) const SOLVER: &str = "boundary value problem of subspaces";

/// Bases and horizontal vectors `[Y0, V0, Y1, V1]`.
pub(crate) type SubspaceData<'a> = [MatRef<'a, f64>; 4];

/// Covariant acceleration and jerk at the first basis, shape `(n, k)`.
pub(crate) type Guess<'a> = (MatRef<'a, f64>, MatRef<'a, f64>);

/// Check that the data are points and horizontal vectors at them.
///
/// # Errors
/// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`.
pub(crate) fn check([y0, v0, y1, v1]: SubspaceData<'_>) -> Result<()> {
    let manifold = Grassmann::of("S0", y0)?;
    manifold.check_point("S0", y0, POINT_TOLERANCE)?;
    manifold.check_point("S1", y1, POINT_TOLERANCE)?;
    manifold.check_tangent("V0", y0, v0, TANGENT_TOLERANCE)?;
    manifold.check_tangent("V1", y1, v1, TANGENT_TOLERANCE)
}

/// The chain between two knots, with velocities given at both.
pub(crate) struct SubspaceProblem<'a> {
    y0: MatRef<'a, f64>,
    span: Span,
    knots: ReducedKnots,
    pub(crate) chain: Framed<'a>,
    pub(crate) ends: Ends,
    pub(crate) options: SplineOptions,
    pub(crate) interrupt: Interrupt<'a>,
}

impl<'a> SubspaceProblem<'a> {
    /// # Errors
    /// The errors of [`check`]; `RightAngle`, `Decomposition`.
    pub(crate) fn new(
        data: SubspaceData<'a>,
        options: &BoundaryOptions<'_>,
        interrupt: Interrupt<'a>,
    ) -> Result<Self> {
        check(data)?;
        options.field.check(data)?;
        let kind = Kind {
            quotient: Quotient::Subspaces,
            field: options.field,
        };
        let span = Span::over(options.field, &data);
        let [y0, v0, y1, v1] = data.map(|x| span.down(x));
        let [points, vectors] = [[&y0, &y1], [&v0, &v1]].map(|pair| pair.map(Mat::as_ref));
        let knots = ReducedKnots::new(kind, &[0.0, 1.0], &points, &vectors)?;
        let frames = frames(kind, &knots.points).map_err(of_leg)?;
        let velocity = |knot: usize| {
            let v = knots.down(knot, vectors[knot]);
            End::Velocity(coordinates(kind, frames[knot].as_ref(), v.as_ref()))
        };
        let ends = Ends::Open([velocity(0), velocity(1)]);
        let (columns, lengths) = (y0.ncols(), vec![1.0]);
        let chain = Framed::new(kind, frames.into(), columns, lengths, interrupt);
        let defaults = BoundaryOptions::default().max_iterations;
        Ok(SubspaceProblem {
            y0: data[0],
            span,
            knots,
            chain: chain.map_err(of_leg)?.in_tension(options.tension),
            ends,
            interrupt,
            options: SplineOptions {
                tolerance: options.tolerance,
                max_iterations: (options.max_iterations * MAX_ITERATIONS).div_ceil(defaults),
                tension: options.tension,
                quotient: kind.quotient,
                field: kind.field,
            },
        })
    }

    /// Whether the manifold is a single point, so that nothing can move.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.chain.blocks().dim() == 0
    }

    /// The cheapest solution found, from several starts if the ends are distant.
    ///
    /// # Errors
    /// `Interrupted`, and the errors of the chain.
    pub(crate) fn solve(&self) -> Result<ChainSolution> {
        if self.is_at_rest() {
            let report = SolverReport::new(StopReason::Converged, 0, 0.0, 0.0);
            return Ok(ChainSolution::none(report.found_by(Strategy::Direct)));
        }
        solve::in_frames(&self.chain, &self.ends, &self.options, self.interrupt)
    }

    /// The solution that Newton's method finds from given covariant acceleration and jerk at the first basis, shape
    /// `(n, k)`, or that of [`SubspaceProblem::solve`] if it finds none.
    ///
    /// # Errors
    /// As [`SubspaceProblem::derivatives_of`] and [`SubspaceProblem::solve`].
    pub(crate) fn near(&self, guess: Guess<'_>) -> Result<ChainSolution> {
        let derivatives = self.derivatives_of(guess)?;
        if self.is_at_rest() {
            return self.solve();
        }
        let start = self.motion_with(&derivatives);
        let work = self.work();
        let effort = Effort::new(&self.options, &work, self.interrupt);
        let found = descent::nearest_to(&self.chain, &self.ends, &start, effort)?;
        match found.report.converged || found.report.reason == StopReason::MaxIterations {
            true => Ok(found.found_by(Strategy::Direct)),
            // With the work limit renewed.
            false => self.solve(),
        }
    }

    /// The work limit of a solution.
    pub(crate) fn work(&self) -> Work {
        solve::work_in_frames(&self.chain, &self.options)
    }

    /// Acceleration and third vector, in coordinates, of given covariant acceleration and jerk at the first basis;
    /// components outside the span of the data are dropped, since no solution has any.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotHorizontal`.
    pub(crate) fn derivatives_of(&self, (a, j): Guess<'_>) -> Result<Vec<f64>> {
        let manifold = Grassmann::of("S0", self.y0)?;
        self.options.field.check([a, j])?;
        let mut derivatives = Vec::new();
        for (name, vector) in [("A", a), ("J", j)] {
            manifold.check_tangent(name, self.y0, vector, TANGENT_TOLERANCE)?;
            let low = self.knots.down(0, self.span.down(vector).as_ref());
            let frame = &self.chain.frames()[0];
            let kind = self.chain.blocks().kind();
            derivatives.extend(coordinates(kind, frame.as_ref(), low.as_ref()));
        }
        // The jerk is the third vector: brackets of horizontal vectors only rotate bases.
        Ok(derivatives)
    }

    /// The motion with given acceleration and third vector at its start, in coordinates.
    pub(crate) fn motion_with(&self, derivatives: &[f64]) -> Motion {
        let mut motion = descent::resting(&self.chain, &self.ends);
        motion.derivatives_mut(0).copy_from_slice(derivatives);
        motion
    }

    /// The curve of a solution, starting with the given first basis.
    ///
    /// # Errors
    /// `NoConvergence`, and the errors of evaluating the curve.
    pub(crate) fn curve(&self, solution: &ChainSolution) -> Result<RiemannianCubic> {
        let report = solution.report;
        if !report.converged {
            return Err(Error::no_convergence(
                SOLVER,
                report,
                self.options.tolerance,
            ));
        }
        let space = SpannedSpace {
            n: self.y0.nrows(),
            k: self.y0.ncols(),
            basis: self.span.basis().map(|basis| Arc::new(basis.to_owned())),
        };
        let piece = |leg: usize| piece(&self.chain, leg, solution, self.interrupt);
        let pieces = pieces(1, &space, piece)?;
        let mut pieces = joined(Quotient::Subspaces, self.knots.first_turn(), pieces, None)?;
        Ok(pieces.remove(0).with_report(report))
    }
}

/// Unwraps an error of the only leg.
fn of_leg(error: Error) -> Error {
    match error {
        Error::AtKnot { source, .. } => *source,
        other => other,
    }
}
