//! Many boundary value problems of subspaces.

use faer::MatRef;

use crate::cubic::{BoundaryOptions, BoundarySolution, RiemannianCubic};
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::threads::{self, ALWAYS};

/// Solve for Riemannian cubics of subspaces on `[0, 1]` with given bases and horizontal vectors `[Y0, V0, Y1, V1]` at
/// their ends, all of shape `(n, k)`.
///
/// Each solution is bit-identical to that of [`RiemannianCubic::between_subspaces`]; acceleration and jerk are
/// horizontal at `Y0`. Problems are solved one by one, in parallel; results depend neither on the number of threads nor
/// on the other problems.
///
/// # Errors
/// `InvalidArgument` and `Interrupted` for the whole call; the errors of `between_subspaces` for single problems.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::cubic::BoundaryOptions;
/// use stiefel_rs::spline::solve_subspace_boundary;
/// // From rest to rest between lines of the plane, whichever way their bases point.
/// let (y0, rest) = (mat![[1.0], [0.0]], mat![[0.0], [0.0]]);
/// let y1 = [0.5_f64, 1.0].map(|a| mat![[-a.cos()], [-a.sin()]]);
/// let problems = y1.each_ref().map(|y1| [&y0, &rest, y1, &rest].map(|a| a.as_ref()));
/// let found = solve_subspace_boundary(&problems, &BoundaryOptions::default(), Interrupt::NEVER)?;
/// let costs = found.iter().map(|found| found.as_ref().map_or(f64::NAN, |found| found.cost));
/// for (cost, expected) in costs.zip([3.0, 12.0]) {
///     assert!((cost - expected).abs() < 1e-10);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub fn solve_subspace_boundary(
    problems: &[[MatRef<'_, f64>; 4]],
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<Vec<Result<BoundarySolution>>> {
    options.check()?;
    let solved = |(): &mut (), i: usize| match one(problems[i], options, interrupt) {
        Err(error) if error.is_interrupted() => Err(error),
        found => Ok(found),
    };
    threads::map(problems.len(), ALWAYS, || (), solved)
}

fn one(
    [y0, v0, y1, v1]: [MatRef<'_, f64>; 4],
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<BoundarySolution> {
    interrupt.check("boundary problems")?;
    let curve = RiemannianCubic::between_subspaces(y0, v0, y1, v1, options, interrupt)?;
    let [_, _, acceleration, jerk] = curve.initial()?;
    Ok(BoundarySolution {
        acceleration,
        jerk,
        cost: curve.cost(interrupt)?,
        residual: curve.report().map_or(0.0, |report| report.residual),
    })
}
