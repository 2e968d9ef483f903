//! Riemannian cubics from boundary data.

use std::sync::Arc;

use faer::MatRef;

use super::problem::BoundaryProblem;
use super::solver::{Reported, Solver};
use crate::cubic::boundary_options::BoundaryOptions;
use crate::cubic::riemannian_cubic::RiemannianCubic;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::manifold::only_bases::advised;

impl RiemannianCubic {
    /// The Riemannian cubic on `[0, 1]` with end points `s0, s1` and end velocities `v0, v1`, all of shape `(n, k)`,
    /// and the [tension](BoundaryOptions::tension) of the options.
    ///
    /// Cubics with given ends are stationary, but not unique. Up to displacement and speeds of 2, Newton's method
    /// starts from the cubic of flat space, at Gauss nodes or, in up to three dimensions, for a Taylor series; from a guess
    /// it starts at any distance. If it fails, and for other data, a chain of cubics descends to a local minimum of the
    /// cost from several starts: a curve that rolls from one velocity to the other; for end speeds up to 16 also the
    /// cubic of flat space; and the de Casteljau curve if more than one quasi-geodesic joins the points. Newton's method
    /// at Gauss nodes, or else on the chain, takes the one of least cost to the tolerance. If descents would exceed the
    /// work limit (dimensions from 57 on, such as St(15,5), SO(12) and complex St(10,4)), the solution from the cubic of
    /// flat space is preferred; it need not be the one of least cost. `docs/boundary_cost.md` compares the costs of solutions.
    /// [`report`](Self::report) says how the solution was found, [`cost`](crate::Curve::cost) gives its cost, and
    /// [`all_from_boundary`](Self::all_from_boundary) looks for others.
    ///
    /// Points and velocities that are orthonormal and tangent only to 1e-9, such as rounded decimals, are replaced by
    /// the nearest exact ones.
    ///
    /// # Accuracy
    /// The end conditions are satisfied to the tolerance. Between opposite points with slow ends solutions nearly form a
    /// continuous family: some are refused with end speeds below 1e-5 on St(6,3), below 1e-3 on St(10,3), and none on
    /// spheres. For distance and speeds up to
    /// 2 the first start is enough; for distance up to 3 and speeds up to 6 more than 99 in 100 random problems are
    /// solved. Both are asserted in `tests/boundary/`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `InvalidArgument`, `DifferentComponents`, `NoConvergence`
    /// (also if velocities are so large that no curve can be integrated; the residual is then infinite), in `OnlyBases` if
    /// the points look like mere bases; `Interrupted`.
    pub fn from_boundary(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &BoundaryOptions<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let found = Self::between_frames([s0, v0, s1, v1], options, interrupt);
        found.map_err(|error| advised(error, s0, s1))
    }

    /// As [`RiemannianCubic::from_boundary`], without the hint that the points may be mere bases.
    ///
    /// # Errors
    /// As [`RiemannianCubic::from_boundary`].
    pub(crate) fn between_frames(
        data: [MatRef<'_, f64>; 4],
        options: &BoundaryOptions<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        options.check()?;
        let problem = BoundaryProblem::new(data, options)?;
        let (solution, report) = solve(&problem, data[0], options, interrupt)?;
        let taylor = solution.into_taylor(&problem, interrupt)?;
        Ok(Self::of_taylor(
            problem.n,
            problem.k,
            problem.frame.map(Arc::new),
            taylor,
            Some(report),
        ))
    }
}

/// The solution of a problem with initial point `s0`, and the report on it.
///
/// # Errors
/// `DifferentComponents`, `NoConvergence`, `Interrupted`, and the errors of a guess.
pub(crate) fn solve(
    problem: &BoundaryProblem,
    s0: MatRef<'_, f64>,
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<Reported> {
    let mut solver = Solver::new(problem, options, interrupt);
    let found = match options.guess {
        Some((a, j)) => solver.near(&problem.start_from(s0, a, j)?)?,
        None => solver.of_low_cost()?,
    };
    found.ok_or_else(|| solver.failure())
}
