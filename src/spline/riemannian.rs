//! The spline of Riemannian cubics: twice continuously differentiable, with stationary cost among curves through its points.

use std::sync::Arc;

use faer::MatRef;

use super::bases::joined;
use super::chains::ambient::Ambient;
use super::chains::chain::{Chain, SpannedSpace, pieces};
use super::chains::framed::{Framed, blocks, coordinates, frames};
use super::chains::framed_solver::MANY;
use super::chains::solution::{ChainSolution, piece};
use super::chains::solve::{self, SOLVER};
use super::chains::uneven::advised;
use super::ends::{EndConditions, Ends, check_ends};
use super::knots;
use super::options::SplineOptions;
use super::piecewise::Piecewise;
use super::reduced_knots::ReducedKnots;
use crate::cubic::RiemannianCubic;
use crate::cubic::tension::check_leg_tension;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::legs::Curves;
use crate::linalg::product::entries;
use crate::manifold::only_bases::{advised_knots, appearance};
use crate::report::{SolverReport, StopReason, Strategy};
use crate::space::Kind;

/// The spline of Riemannian cubics through points, with continuous velocity and covariant acceleration.
///
/// Among all curves through the points with the given end conditions it makes the cost `J` stationary. With natural
/// ends (`EndConditions::Natural`) it generalises the natural cubic spline of flat space.
///
/// # Arguments
/// * `t` - increasing times; `points` - one per time, shape `(n, k)`
/// # Errors
/// `Shape`, `NonFinite`, `InvalidArgument` (tolerance, tension, times, ends that do not close); `NoConvergence`, which
/// is at a knot in `OnlyBases` if most points look like mere bases, and in `UnevenTimes` if an interval is much longer
/// than a neighbour; `Interrupted`; wrapped in `AtKnot`:
/// `NotOrthonormal`, `NotTangent`, `NoJoiningCurve`, `OutsideLogDomain` and `DifferentComponents` (no curve leads to the
/// next point).
pub fn cubic_spline(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    ends: &EndConditions,
    options: &SplineOptions,
    interrupt: Interrupt<'_>,
) -> Result<(Piecewise<RiemannianCubic>, SolverReport)> {
    let (curve, report, _) = cubic_spline_of_legs(t, points, ends, options, interrupt)?;
    Ok((curve, report))
}

/// A spline, the report of its solver, and the curves of its legs if the solver provides them.
pub(crate) type SplineOfLegs = (
    Piecewise<RiemannianCubic>,
    SolverReport,
    Option<Arc<dyn Curves>>,
);

/// As [`cubic_spline`], with the curves of the legs.
///
/// # Errors
/// As [`cubic_spline`].
pub(crate) fn cubic_spline_of_legs(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    ends: &EndConditions,
    options: &SplineOptions,
    interrupt: Interrupt<'_>,
) -> Result<SplineOfLegs> {
    options.check()?;
    knots::check(t, points)?;
    check_ends(options.quotient, points, ends)?;
    options.field.check(points.iter().copied())?;
    options.field.check(ends.vectors())?;
    let problem = SplineProblem::new(t, points, ends, options)?;
    let solved = problem.solve(options, interrupt);
    let (pieces, solution) =
        solved.map_err(|error| advised_knots(error, options.quotient, points))?;
    let first = problem.knots.first_turn();
    let pieces = joined(options.quotient, first, pieces, solution.turns())?;
    let curves = solution.legs.and_then(|legs| legs.polynomials);
    Ok((Piecewise::new(t.to_vec(), pieces), solution.report, curves))
}

/// Knots and ends in the coordinates of their span.
struct SplineProblem<'e> {
    kind: Kind,
    knots: ReducedKnots,
    ends: &'e EndConditions,
    /// Tension in the time of the mean leg.
    tension: f64,
}

type SolvedPieces = (Vec<RiemannianCubic>, ChainSolution);

impl<'e> SplineProblem<'e> {
    fn new(
        t: &[f64],
        points: &[MatRef<'_, f64>],
        ends: &'e EndConditions,
        options: &SplineOptions,
    ) -> Result<Self> {
        let knots = ReducedKnots::of_spline(options.kind(), t, points, ends)?;
        // Multiply one factor at a time: the product of the factors may overflow.
        let tension = options.tension * knots.unit * knots.unit;
        let longest = knots.lengths.iter().fold(0.0_f64, |most, h| most.max(*h));
        check_leg_tension(tension * longest * longest, knots.is_small())?;
        Ok(SplineProblem {
            kind: options.kind(),
            knots,
            ends,
            tension,
        })
    }

    /// The pieces of the spline.
    ///
    /// # Errors
    /// As [`cubic_spline`].
    fn solve(&self, options: &SplineOptions, interrupt: Interrupt<'_>) -> Result<SolvedPieces> {
        if self.knots.is_small() {
            return self.solve_in_frames(options, interrupt);
        }
        let found = self.solve_in_ambient(options, interrupt);
        let reason = |error: &Error| error.report().map(|report| report.reason);
        let is_lost = found.as_ref().is_err_and(|error| {
            matches!(
                reason(error),
                Some(StopReason::Stagnated | StopReason::Diverged)
            )
        });
        match is_lost && self.has_few_dimensions() {
            true => self.solve_in_frames(options, interrupt),
            false => found,
        }
    }

    /// Whether descents may be tried for points with more rows.
    fn has_few_dimensions(&self) -> bool {
        let (r, k) = self.knots.shape();
        blocks(self.kind, [r, k]).dim() <= MANY
    }

    fn solve_in_frames(
        &self,
        options: &SplineOptions,
        interrupt: Interrupt<'_>,
    ) -> Result<SolvedPieces> {
        let (kind, (_, columns)) = (self.kind, self.knots.shape());
        let frames = frames(kind, &self.knots.points)?;
        let ends = self.knots.ends(self.ends, |knot, v| {
            coordinates(kind, frames[knot].as_ref(), v.as_ref())
        });
        let lengths = self.knots.lengths.clone();
        let chain = Framed::new(kind, frames.into(), columns, lengths, interrupt)?;
        let (chain, space) = (chain.in_tension(self.tension), self.knots.space());
        let solution = if chain.blocks().dim() == 0 {
            // A space of dimension zero.
            let report = SolverReport::new(StopReason::Converged, 0, 0.0, 0.0);
            ChainSolution::none(report.found_by(Strategy::Direct))
        } else {
            solve::in_frames(&chain, &ends, options, interrupt)?
        };
        finished((&chain, &ends), solution, &space, options, interrupt)
    }

    fn solve_in_ambient(
        &self,
        options: &SplineOptions,
        interrupt: Interrupt<'_>,
    ) -> Result<SolvedPieces> {
        let ends = self.knots.ends(self.ends, |_, v| entries(v));
        let (points, lengths) = (self.knots.points.clone(), self.knots.lengths.clone());
        let chain = Ambient::new(self.kind, points, lengths, interrupt)?;
        let chain = chain.in_tension(self.tension);
        let seem = appearance(self.kind.quotient, &self.knots.points);
        let solution = solve::in_ambient(&chain, &ends, seem, options, interrupt)?;
        finished(
            (&chain, &ends),
            solution,
            &self.knots.space(),
            options,
            interrupt,
        )
    }
}

/// The pieces of a solution.
///
/// # Errors
/// `NoConvergence`, at a knot in `UnevenTimes` if they explain it; the errors of integrating pieces.
fn finished(
    (chain, ends): (&impl Chain, &Ends),
    solution: ChainSolution,
    space: &SpannedSpace,
    options: &SplineOptions,
    interrupt: Interrupt<'_>,
) -> Result<SolvedPieces> {
    if !solution.report.converged {
        let error = Error::no_convergence(SOLVER, solution.report, options.tolerance);
        return Err(advised(error, chain, ends));
    }
    let piece = |leg: usize| piece(chain, leg, &solution, interrupt);
    let pieces = pieces(chain.lengths().len(), space, piece)?;
    Ok((pieces, solution))
}
