//! Boundary problems of Riemannian cubics in batches, in Python.

use super::array_namespace::Namespace;
use super::batch::Failure;
use super::points::Points;
use super::prelude::*;
use crate::cubic::boundary::problem::check_data;
use crate::cubic::{BoundaryOptions, BoundarySolution, solve_boundary as solved};
use crate::linalg::complex_embedding::restrict;
use crate::manifold::Stiefel;

/// Solve for Riemannian cubics on ``[0, 1]`` with given end points and end velocities, for a batch of problems.
///
/// Each solution agrees with :meth:`RiemannianCubic.from_boundary` up to ``tol``. Problems with at most three rows, and
/// with displacement and speeds at most 2, are solved in groups of eight; within ``tol`` their solutions depend on the
/// problems beside them. The remaining problems, and those that this does not solve, are solved one by one. On a
/// :class:`Grassmann` all are solved one by one, with the same result to the last bit as
/// :meth:`RiemannianCubic.from_boundary`.
///
/// Parameters
/// ----------
/// S0, V0 : array_like, shape (..., n, k)
///     Initial points and velocities; leading axes broadcast.
/// S1, V1 : array_like, shape (..., n, k)
///     Final points and velocities.
/// tol : float, default 1e-12
///     Largest error of end point and end velocity, as in :meth:`RiemannianCubic.from_boundary`.
/// max_iterations : int, default 50
///     Largest number of Newton steps per problem, as in :meth:`RiemannianCubic.from_boundary`.
/// num_threads : int, optional
///     Number of threads; by default the size of the global pool. Results do not depend on it.
/// manifold : Stiefel or Grassmann, optional
///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
///     are arbitrary bases of subspaces; vectors and results are horizontal, ``Y^T V = 0``.
/// project : bool, default False
///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
///     their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
///     single precision are always projected.
///
/// Returns
/// -------
/// BoundaryBatch
///     Named tuple of ``acceleration`` and ``jerk``, covariant, at ``S0``, shape (..., n, k); ``cost``, the integral of
///     the squared covariant acceleration, ``converged`` and ``residual``, shape (...). For a problem that is not
///     solved, ``converged`` is False, ``residual`` is the smallest error at the end, and the other fields are NaN.
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect and the
///     member of the batch), ``tol`` not between 1e-15 and 0.1, ``max_iterations`` less than 1.
/// OutsideDomainError
///     Points in different components of O(n), or subspaces with a principal angle of pi/2 between them.
///
/// See Also
/// --------
/// RiemannianCubic.from_initial : curve from ``S0, V0, acceleration, jerk``.
/// stiefel_rs.dask.solve_boundary : batches larger than memory, with more fields.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import RiemannianCubic, solve_boundary
/// >>> angle = np.linspace(0.1, 1.5, 1000)
/// >>> S0, rest = np.eye(3)[:, :1], np.zeros((3, 1))
/// >>> S1 = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)[..., None]
/// >>> batch = solve_boundary(S0, rest, S1, rest)
/// >>> batch.jerk.shape, bool(batch.converged.all())
/// ((1000, 3, 1), True)
/// >>> bool(np.allclose(batch.cost, 12 * angle**2))
/// True
/// >>> curve = RiemannianCubic.from_initial(S0, rest, batch.acceleration[7], batch.jerk[7])
/// >>> bool(np.allclose(curve(1.0), S1[7]))
/// True
#[pyfunction]
#[pyo3(signature = (S0, V0, S1, V1, *, tol=1e-12, max_iterations=50, num_threads=None, manifold=None, project=false))]
pub fn solve_boundary<'py>(
    S0: &Any<'py>,
    V0: &Any,
    S1: &Any,
    V1: &Any,
    tol: f64,
    #[pyo3(from_py_with = whole)] max_iterations: i64,
    num_threads: Option<i64>,
    manifold: Option<&Any>,
    project: bool,
) -> PyResult<Any<'py>> {
    let (py, arguments) = (S0.py(), named![S0, V0, S1, V1]);
    let points = Points::read(manifold, project)?;
    let field = points.field(arguments.map(|(object, _)| object))?;
    let batches = points.batches(field, arguments)?;
    let max_iterations = count("max_iterations", max_iterations, 1)?;
    let (shape, n, k) = (batches[0].shape.clone(), batches[0].rows, batches[0].cols);
    let (rows, cols) = field.own((n, k));
    // Checked for an empty batch too.
    Stiefel::new(rows, cols)?;
    for (batch, (_, name)) in batches.iter().zip(arguments) {
        batch.check_shape(name, (rows, cols))?;
    }
    let quotient = points.quotient;
    let call = Call::new(py, num_threads, SOLVES * 4.0 * batches[0].numbers())?
        .over(field)
        .distributed(true);
    let lead = shape.clone();
    let fields = call.run(move |interrupt| {
        let options = BoundaryOptions {
            tolerance: tol,
            max_iterations,
            quotient,
            field,
            ..BoundaryOptions::default()
        };
        let found = solutions(&batches, field, &options, interrupt)?;
        Ok(found.map(|found| fields(&found, field, &lead, (n, k))))
    })?;
    let explained = |(member, error)| at_member(&call.explained(error), member, &shape);
    let fields = fields.map_err(explained)?;
    let (acceleration, jerk, cost, converged, residual) = fields;
    let [acceleration, jerk] = collected([acceleration, jerk].map(|part| field.numbers(part)))?;
    let [acceleration, jerk] = collected([acceleration, jerk].map(|part| part.like(arguments)))?;
    let [cost, residual] =
        collected([cost, residual].map(|part| Numbers::from(part).like(arguments)))?;
    let converged = to_array(py, converged, &shape)?.into_any();
    let converged = Namespace::of(arguments)?.array(converged)?;
    let class = py.import("stiefel_rs.boundary")?.getattr("BoundaryBatch")?;
    class.call1((acceleration, jerk, cost, converged, residual))
}

/// A solution, or the residual if the problem was not solved.
type FoundMember = std::result::Result<BoundarySolution, f64>;

/// Acceleration, jerk, cost, whether the problem is solved, and residual.
type BatchFields = (Array, Array, Array, Vec<bool>, Array);

/// The fields of all solutions; NaN for problems that were not solved.
fn fields(
    found: &[FoundMember],
    field: Field,
    lead: &[usize],
    (n, k): (usize, usize),
) -> BatchFields {
    let matrices = |part: fn(&BoundarySolution) -> &Mat<f64>| {
        let mut entries = vec![f64::NAN; found.len() * n * k];
        for (solution, out) in found.iter().zip(entries.chunks_mut(n * k)) {
            if let Ok(solution) = solution {
                write(part(solution).as_ref(), out);
            }
        }
        let shape = [lead, &[n, k]].concat();
        Array { shape, entries }
    };
    let numbers = |number: &dyn Fn(&FoundMember) -> f64| Array {
        shape: lead.to_vec(),
        entries: found.iter().map(number).collect(),
    };
    let cost = numbers(&|one| {
        let cost = |solution: &BoundarySolution| field.squared(solution.cost);
        one.as_ref().map_or(f64::NAN, cost)
    });
    let residual = numbers(&|one| {
        let residual = one.as_ref().map_or_else(|x| *x, |found| found.residual);
        field.length(residual)
    });
    let [acceleration, jerk] = [matrices(|one| &one.acceleration), matrices(|one| &one.jerk)];
    (
        acceleration,
        jerk,
        cost,
        found.iter().map(FoundMember::is_ok).collect(),
        residual,
    )
}

/// Whether the solution of an embedded problem is an embedded complex matrix.
fn is_complex(solution: &BoundarySolution) -> bool {
    let parts = [&solution.acceleration, &solution.jerk];
    parts.iter().all(|part| restrict(part.as_ref()).is_ok())
}

fn solutions(
    batches: &[Batch; 4],
    field: Field,
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<std::result::Result<Vec<FoundMember>, Failure>> {
    let problem = |i: usize| batches.each_ref().map(|batch| batch.get(i));
    let problems: Vec<_> = (0..batches[0].len()).map(problem).collect();
    for (i, problem) in problems.iter().enumerate() {
        interrupt.check("boundary problems")?;
        if let Err(error) = check_data(options.quotient, *problem) {
            return Ok(Err((i, error)));
        }
    }
    let mut found = Vec::with_capacity(problems.len());
    for (i, solution) in solved(&problems, options, interrupt)?
        .into_iter()
        .enumerate()
    {
        found.push(match solution {
            Ok(solution) if field == Field::Complex && !is_complex(&solution) => Err(f64::INFINITY),
            Ok(solution) => Ok(solution),
            Err(error @ (Error::DifferentComponents { .. } | Error::RightAngle { .. })) => {
                return Ok(Err((i, error)));
            }
            Err(error) => Err(error
                .report()
                .map_or(f64::INFINITY, |report| report.residual)),
        });
    }
    Ok(Ok(found))
}
