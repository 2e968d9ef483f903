//! Boundary problems of Riemannian cubics in batches, in Python.

use faer::MatRef;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use super::call::Call;
use super::chart::count;
use super::convert::{Batch, matrices, to_array, whole, write};
use super::error::{invalid_input, to_exception};
use super::riemannian_cubic::shooting_each;
use crate::cubic::problem::check_data;
use crate::cubic::{BoundaryOptions, BoundarySolution, solve_boundary as solved};
use crate::error::{Error, Result};
use crate::manifold::Stiefel;

static BATCH: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Solutions of a batch as arrays, matrix after matrix, row by row.
struct Solutions {
    size: usize,
    acceleration: Vec<f64>,
    jerk: Vec<f64>,
    cost: Vec<f64>,
    converged: Vec<bool>,
    residual: Vec<f64>,
}

impl Solutions {
    fn with_capacity(count: usize, size: usize) -> Self {
        Solutions {
            size,
            acceleration: Vec::with_capacity(count * size),
            jerk: Vec::with_capacity(count * size),
            cost: Vec::with_capacity(count),
            converged: Vec::with_capacity(count),
            residual: Vec::with_capacity(count),
        }
    }

    fn push(&mut self, solution: &BoundarySolution) {
        let vectors = [&solution.acceleration, &solution.jerk];
        for (vector, out) in vectors
            .into_iter()
            .zip([&mut self.acceleration, &mut self.jerk])
        {
            let start = out.len();
            out.resize(start + self.size, 0.0);
            write(vector.as_ref(), &mut out[start..]);
        }
        self.cost.push(solution.cost);
        self.converged.push(true);
        self.residual.push(solution.residual);
    }

    /// NaN, and what the nearest end was off.
    fn push_unsolved(&mut self, residual: f64) {
        for out in [&mut self.acceleration, &mut self.jerk] {
            out.resize(out.len() + self.size, f64::NAN);
        }
        self.cost.push(f64::NAN);
        self.converged.push(false);
        self.residual.push(residual);
    }
}

/// Riemannian cubics on ``[0, 1]`` with given end points and end velocities, for a batch of problems.
///
/// Each is that of :meth:`RiemannianCubic.from_boundary`, up to ``tol``. Points with up to three rows, and displacement and
/// speeds up to 2, are solved for eight abreast, where a solution depends, within ``tol``, on which problems stand beside
/// it; the others, and those that this does not solve, one by one.
///
/// Parameters
/// ----------
/// S0, V0 : array_like, shape (..., n, k)
///     Initial points and velocities; leading axes broadcast.
/// S1, V1 : array_like, shape (..., n, k)
///     Final points and velocities.
/// tol : float, default 1e-12
///     The largest distance of the end from ``S1`` and ``V1``, as in :meth:`RiemannianCubic.from_boundary`.
/// max_iterations : int, default 50
///     Newton steps for one problem, as there.
/// num_threads : int, optional
///     Threads; by default those of the global pool. Results are the same for any number.
///
/// Returns
/// -------
/// BoundaryBatch
///     Named tuple of ``acceleration`` and ``jerk``, covariant, at ``S0``, shape (..., n, k); ``cost``, the integral of the
///     squared covariant acceleration, ``converged`` and ``residual``, shape (...). Where a problem is not solved,
///     ``converged`` is False, ``residual`` what the nearest end was off, and the others NaN.
///
/// Raises
/// ------
/// InvalidInputError
///     Shape, not finite, not orthonormal, not tangent (with the measured defect and the member of the batch), ``tol`` not
///     between 1e-15 and 0.1, ``max_iterations`` less than 1.
/// OutsideDomainError
///     Points in different components of O(n).
///
/// See Also
/// --------
/// RiemannianCubic.from_initial : the curve from ``S0, V0, acceleration, jerk``.
/// stiefel_rs.dask.solve_boundary : batches that do not fit into memory, and more fields.
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
#[pyo3(signature = (S0, V0, S1, V1, *, tol=1e-12, max_iterations=50, num_threads=None))]
#[allow(non_snake_case, clippy::too_many_arguments)]
pub fn solve_boundary(
    py: Python<'_>,
    S0: &Bound<'_, PyAny>,
    V0: &Bound<'_, PyAny>,
    S1: &Bound<'_, PyAny>,
    V1: &Bound<'_, PyAny>,
    tol: f64,
    #[pyo3(from_py_with = whole)] max_iterations: i64,
    num_threads: Option<i64>,
) -> PyResult<Py<PyAny>> {
    let batches = matrices([(S0, "S0"), (V0, "V0"), (S1, "S1"), (V1, "V1")])?;
    let max_iterations = count(py, "max_iterations", max_iterations, 1)?;
    let (shape, n, k) = (batches[0].shape.clone(), batches[0].rows, batches[0].cols);
    check_shapes(py, &batches)?;
    let work = batches[0].len() as f64 * shooting_each((n, k));
    let call = Call::new(py, num_threads, work)?;
    let (found, failure) = call.run(py, move |interrupt| {
        let options = BoundaryOptions {
            tolerance: tol,
            max_iterations,
            interrupt,
            ..BoundaryOptions::default()
        };
        solutions(&batches, &options)
    })?;
    if let Some((member, error)) = failure {
        let place = match shape.is_empty() {
            true => String::new(),
            false => format!(" (batch member {member})"),
        };
        return Err(to_exception(py, &error, &place));
    }
    let matrices = [shape.as_slice(), &[n, k]].concat();
    let fields = (
        to_array(py, found.acceleration, &matrices)?,
        to_array(py, found.jerk, &matrices)?,
        to_array(py, found.cost, &shape)?,
        to_array(py, found.converged, &shape)?,
        to_array(py, found.residual, &shape)?,
    );
    let class = BATCH.import(py, "stiefel_rs.boundary", "BoundaryBatch")?;
    Ok(class.call1(fields)?.unbind())
}

/// Also where there is no problem.
fn check_shapes(py: Python<'_>, batches: &[Batch; 4]) -> PyResult<()> {
    let (n, k) = (batches[0].rows, batches[0].cols);
    Stiefel::new(n, k).map_err(|error| to_exception(py, &error, ""))?;
    for (batch, name) in batches.iter().zip(["S0", "V0", "S1", "V1"]) {
        if (batch.rows, batch.cols) != (n, k) {
            let (rows, cols) = (batch.rows, batch.cols);
            let message =
                format!("{name}: expected shape (..., {n}, {k}), found (..., {rows}, {cols})");
            return Err(invalid_input(py, message));
        }
    }
    Ok(())
}

/// The first invalid problem and what is wrong with it.
type Failure = Option<(usize, Error)>;

fn solutions(batches: &[Batch; 4], options: &BoundaryOptions<'_>) -> Result<(Solutions, Failure)> {
    let [count, size] = [batches[0].len(), batches[0].rows * batches[0].cols];
    let problem = |i: usize| -> [MatRef<'_, f64>; 4] { batches.each_ref().map(|b| b.get(i)) };
    let problems: Vec<_> = (0..count).map(problem).collect();
    let mut found = Solutions::with_capacity(count, size);
    for (i, problem) in problems.iter().enumerate() {
        options.interrupt.check("boundary problems")?;
        if let Err(error) = check_data(*problem) {
            return Ok((found, Some((i, error))));
        }
    }
    for (i, solution) in solved(&problems, options)?.into_iter().enumerate() {
        match solution {
            Ok(solution) => found.push(&solution),
            Err(error @ Error::DifferentComponents { .. }) => return Ok((found, Some((i, error)))),
            Err(Error::NoConvergence { report, .. } | Error::TooManySteps { report, .. }) => {
                found.push_unsolved(report.residual);
            }
            Err(_) => found.push_unsolved(f64::INFINITY),
        }
    }
    Ok((found, None))
}
