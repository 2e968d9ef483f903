//! The spline of Riemannian cubics: twice continuously differentiable, with stationary cost among curves through its points.

use std::sync::Arc;

use faer::MatRef;

use super::bases::joined;
use super::chains::ambient::Ambient;
use super::chains::chain::{Chain, SpannedSpace, pieces};
use super::chains::framed::{Framed, coordinates, frames};
use super::chains::iteration::SOLVER;
use super::chains::solution::{ChainSolution, piece};
use super::chains::solve;
use super::chains::uneven::advised;
use super::ends::{EndConditions, Ends, check_ends};
use super::knots;
use super::options::SplineOptions;
use super::piecewise::Piecewise;
use super::reduced_knots::ReducedKnots;
use crate::cubic::RiemannianCubic;
use crate::cubic::tension::check_leg_tension;
use crate::curve::Curve;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::legs::Curves;
use crate::linalg::product::entries;
use crate::manifold::only_bases::{advised_knots, appearance};
use crate::report::{SolverReport, StopReason, Strategy};
use crate::space::ScalarField;

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
    if solution.legs.is_none() {
        check_complex(options.field, &pieces)?;
    }
    let first = problem.knots.first_turn();
    let pieces = joined(options.quotient, first, pieces, solution.turns())?;
    let curves = solution.legs.and_then(|legs| legs.polynomials);
    Ok((Piecewise::new(t.to_vec(), pieces), solution.report, curves))
}

/// Returns an error if integrated pieces between complex points have left the complex frames, which real unknowns permit.
///
/// # Errors
/// `NotComplex`, wrapped in `AtKnot`; the errors of evaluating the pieces.
pub(super) fn check_complex(field: ScalarField, pieces: &[RiemannianCubic]) -> Result<()> {
    if field == ScalarField::Real {
        return Ok(());
    }
    for (knot, piece) in pieces.iter().enumerate() {
        for order in [0, 1] {
            let middle = piece.derivative(0.5, order)?;
            let checked = field.check([middle.as_ref()]);
            checked.map_err(|error| error.at_knot(knot))?;
        }
    }
    Ok(())
}

/// Knots and ends in the coordinates of their span.
struct SplineProblem<'e> {
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
        match self.knots.is_small() {
            true => self.solve_in_frames(options, interrupt),
            false => self.solve_in_ambient(options, interrupt),
        }
    }

    fn solve_in_frames(
        &self,
        options: &SplineOptions,
        interrupt: Interrupt<'_>,
    ) -> Result<SolvedPieces> {
        let (kind, (_, columns)) = (options.kind(), self.knots.shape());
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
        let chain = Ambient::new(options.kind(), points, lengths, interrupt)?;
        let chain = chain.in_tension(self.tension);
        let seem = appearance(self.knots.quotient(), &self.knots.points);
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

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::cubic::IntegrationOptions;
    use crate::linalg::complex_embedding::embed;

    /// The curve on complex St(2, 1) with a given velocity at the first unit vector, embedded; and one that leaves
    /// these frames.
    #[test]
    fn pieces_that_leave_the_complex_frames_are_refused() {
        let complex =
            |entries: [faer::c64; 2]| embed(Mat::from_fn(2, 1, |i, _| entries[i]).as_ref());
        let number = faer::c64::new;
        let s = complex([number(1.0, 0.0), number(0.0, 0.0)]);
        let inside = complex([number(0.0, 0.3), number(0.5, -0.7)]);
        let mut outside = inside.clone();
        // Tangent, but the second column is no longer `i` times the first.
        outside[(1, 1)] += 0.1;
        let curve = |v: &Mat<f64>| {
            let (zero, options) = (Mat::zeros(4, 2), IntegrationOptions::default());
            let [s, v, zero] = [&s, v, &zero].map(|x| x.as_ref());
            RiemannianCubic::from_initial(s, v, zero, zero, &options, Interrupt::NEVER).unwrap()
        };
        let pieces = [curve(&inside), curve(&outside)];
        assert!(check_complex(ScalarField::Complex, &pieces[..1]).is_ok());
        let error = check_complex(ScalarField::Complex, &pieces).unwrap_err();
        assert!(matches!(&error, Error::AtKnot { knot: 1, .. }), "{error}");
        assert!(matches!(error.cause(), Error::NotComplex { .. }), "{error}");
        assert!(check_complex(ScalarField::Real, &pieces).is_ok());
    }
}
