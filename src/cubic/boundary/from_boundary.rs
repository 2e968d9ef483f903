//! Riemannian cubics from boundary data.

use faer::MatRef;

use super::lines::{are_lines, of_vectors, to_both_vectors};
use super::problem::BoundaryProblem;
use super::solver::Solver;
use crate::cubic::boundary_options::BoundaryOptions;
use crate::cubic::riemannian_cubic::RiemannianCubic;
use crate::curve::Curve;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::manifold::only_bases::advised;
use crate::space::Quotient;

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
    /// Between [subspaces](BoundaryOptions::quotient), given by any orthonormal bases and horizontal vectors at them, the
    /// curve starts with the basis `s0`, and its bases rotate as little as possible; it ends with a basis `S1 Q` and the
    /// velocity `V1 Q`, for some orthogonal `Q`. Displacements up to 1.4, of complex subspaces 1.2, count as near. Between
    /// lines it is the cheaper of the two cubics on the sphere that end in opposite vectors.
    ///
    /// # Accuracy
    /// The end conditions are satisfied to the tolerance. Between opposite points with slow ends solutions nearly form a
    /// continuous family: some are refused with end speeds below 1e-5 on St(6,3), below 1e-3 on St(10,3), and none on
    /// spheres. For distance and speeds up to 2 the first start is enough; for distance up to 3 and speeds up to 6 more
    /// than 99 in 100 random problems are solved. Both are asserted in `tests/boundary/`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent` or `NotHorizontal`, `InvalidArgument`, `DifferentComponents`,
    /// `RightAngle` if a principal angle between subspaces is pi/2, `NoConvergence` (also if velocities are so large that no
    /// curve can be integrated; the residual is then infinite), in `OnlyBases` if the points look like mere bases;
    /// `Interrupted`.
    ///
    /// # Examples
    /// ```
    /// use faer::mat;
    /// use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic};
    /// use stiefel_rs::{Curve, Interrupt, Quotient};
    /// // From rest to rest between two lines in the plane, whichever way their bases point.
    /// let (y0, rest) = (mat![[1.0], [0.0]], mat![[0.0], [0.0]]);
    /// let y1 = mat![[-1.0_f64.cos()], [-1.0_f64.sin()]];
    /// let [y0, y1, rest] = [&y0, &y1, &rest].map(|a| a.as_ref());
    /// let options = BoundaryOptions { quotient: Quotient::Subspaces, ..Default::default() };
    /// let curve = RiemannianCubic::from_boundary(y0, rest, y1, rest, &options, Interrupt::NEVER)?;
    /// assert!((curve.point(1.0)? + y1).norm_l2() < 1e-12);
    /// assert!((curve.cost(Interrupt::NEVER)? - 12.0).abs() < 1e-10);
    /// # Ok::<(), stiefel_rs::Error>(())
    /// ```
    pub fn from_boundary(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &BoundaryOptions<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        options.check()?;
        let found = between([s0, v0, s1, v1], options, interrupt);
        match options.quotient {
            Quotient::Frames => found.map_err(|error| advised(error, s0, s1)),
            Quotient::Subspaces => found,
        }
    }
}

/// As [`RiemannianCubic::from_boundary`], for checked options.
///
/// # Errors
/// As there, without the hint that the points may be mere bases.
pub(crate) fn between(
    data: [MatRef<'_, f64>; 4],
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<RiemannianCubic> {
    let are_lines = are_lines(data, options);
    if are_lines && options.guess.is_none() {
        return between_lines(data, options, interrupt);
    }
    match BoundaryProblem::new(data, options) {
        // No geodesic is the unique shortest one between these lines, but on the sphere it exists.
        Err(Error::RightAngle { .. }) if are_lines => between_lines(data, options, interrupt),
        problem => solved(&problem?, data[0], options, interrupt),
    }
}

/// The cheaper of the cubics on the sphere to a unit vector of the last line and to its negative.
///
/// # Errors
/// As [`between`].
fn between_lines(
    data: [MatRef<'_, f64>; 4],
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<RiemannianCubic> {
    let options = of_vectors(options);
    let both = to_both_vectors(data, |data: [MatRef<'_, f64>; 4]| {
        between(data, &options, interrupt)
    });
    let cheapest = match both? {
        [Ok(there), Ok(back)] if back.cost(interrupt)? < there.cost(interrupt)? => back,
        [Err(error), _] | [_, Err(error)] if error.is_interrupted() => return Err(error),
        [Ok(there), _] => there,
        [Err(error), back] => back.map_err(|_| error)?,
    };
    Ok(cheapest.of_lines())
}

/// The curve that solves a problem with initial point `s0`.
///
/// # Errors
/// `DifferentComponents`, `NoConvergence`, `Interrupted`, and the errors of a guess.
pub(crate) fn solved(
    problem: &BoundaryProblem,
    s0: MatRef<'_, f64>,
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<RiemannianCubic> {
    let mut solver = Solver::new(problem, options, interrupt);
    let found = match options.guess {
        Some((a, j)) => solver.near(&problem.start_from(s0, a, j)?)?,
        None => solver.of_low_cost()?,
    };
    let (solution, report) = found.ok_or_else(|| solver.failure())?;
    Ok(problem.curve(solution.into_taylor(problem, interrupt)?, report))
}
