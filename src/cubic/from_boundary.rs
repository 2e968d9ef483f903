//! Riemannian cubics from boundary data.

use std::sync::Arc;

use faer::MatRef;

use super::boundary::{BoundaryOptions, BoundaryStrategy};
use super::problem::Problem;
use super::riemannian_cubic::RiemannianCubic;
use super::shooting::SOLVER;
use super::solver::{Solution, Solver};
use crate::error::{Error, Result};

impl RiemannianCubic {
    /// A Riemannian cubic on `[0, 1]` with end points `s0, s1` and end velocities `v0, v1`, all of shape `(n, k)`, with the
    /// [tension](BoundaryOptions::tension) of the options.
    ///
    /// Cubics with given ends are stationary, not unique. Newton's method starts from the cubic of flat space (or from the
    /// guess). If displacement and speeds are at most 2, its solution is returned. Otherwise, and without a guess, a chain of
    /// cubics descends to a curve of least cost: from a curve that rolls evenly from one velocity to the other, for end speeds
    /// up to 16 also from the cubic of flat space, and from the de Casteljau curve where more than one quasi-geodesic joins the
    /// points. The cheapest is returned. Where descents would take more work than a problem may (dimensions from 57 on, as of
    /// St(15,5), SO(12) and complex St(10,4)) the solution from the cubic of flat space is returned as well, and is not known to be
    /// the cheapest. What is known of its cost beside that of others is in the table of
    /// `docs/boundary_cost.md`. [`boundary_report`](Self::boundary_report) says how it was found, [`cost`](crate::Curve::cost)
    /// what it costs, and [`all_from_boundary`](Self::all_from_boundary) looks for others.
    ///
    /// Points and velocities that are only nearly orthonormal and tangent, as rounded decimals are (defects up to 1e-9), stand
    /// for the nearest exact ones.
    ///
    /// # Accuracy
    /// The end is met to the tolerance. Opposite points, or nearly so, with end speeds below 1e-5 may be refused: their
    /// solutions are nearly a whole family (seen on St(3,1), St(4,1) and most on St(6,3), not on St(3,2) and St(4,2)). For
    /// distance up to 2 and speeds up to 2 the first start is enough, for distance up to 3 and speeds up to 6 more than 99 in
    /// 100 random problems are solved; both are asserted in `tests/boundary/`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `InvalidArgument`, `DifferentComponents`, `NoConvergence` (also
    /// for velocities so large that no curve can be integrated: the residual is infinite then), `Interrupted`.
    pub fn from_boundary(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &BoundaryOptions<'_>,
    ) -> Result<Self> {
        options.check()?;
        let problem = Problem::new([s0, v0, s1, v1], options)?;
        let (y, report) = solve(&problem, s0, options)?;
        let path = problem.path(&y, options.interrupt)?;
        Ok(Self::of_path(
            problem.n,
            problem.k,
            problem.frame.map(Arc::new),
            path,
            Some(report),
        ))
    }
}

/// `(x', x'')` at the start of the solution of a problem with the initial point `s0`, and how it was found.
///
/// # Errors
/// `DifferentComponents`, `NoConvergence`, `Interrupted`; those of a guess.
pub(super) fn solve(
    problem: &Problem,
    s0: MatRef<'_, f64>,
    options: &BoundaryOptions<'_>,
) -> Result<Solution> {
    let mut solver = Solver::new(problem, options);
    let found = match options.guess {
        Some((a, j)) => solver.near(&problem.start_from(s0, a, j)?)?,
        None => solver.of_low_cost()?,
    };
    found.ok_or_else(|| Error::NoConvergence {
        solver: SOLVER,
        report: solver.report(BoundaryStrategy::Descent).solver,
    })
}
