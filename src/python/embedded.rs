//! Riemannian cubics by the symplectic integrator in the embedding.

use super::cubic_trajectory::{PyCubicTrajectory, sampled};
use super::points::Points;
use super::prelude::*;
use super::projection::Projection;
use crate::cubic::integrate_embedded as integrate;

/// Integrate a Riemannian cubic by equal steps of a symplectic method in the embedding.
///
/// The phase space is that of arXiv 2404.19407, ``T*(TSt(n, k))``, as a submanifold of four copies of the ``n x k``
/// matrices; any n and k, without charts. The order is 2. ``S^T S = I``, ``S^T V + V^T S = 0``, the momentum
/// constraints and the spatial momentum hold to round-off, and the energy does not drift. :func:`integrate_cubic` does
/// not solve equations; it is faster and more accurate.
///
/// Parameters
/// ----------
/// S, V, A, J : array_like, shape (n, k)
///     Point, velocity, covariant acceleration and covariant jerk at ``t = 0``.
/// steps : int
///     Number of equal steps over ``[0, t_end]``, at least 1.
/// t_end : float, default 1.0
///     End time, not zero; negative to integrate backwards.
/// map : {"midpoint"}, default "midpoint"
///     Discretization map of the ambient space, ``R_d(q, v) = (q - v/2, q + v/2)``. Its cotangent lift preserves
///     quadratic constraints.
/// project : bool, default False
///     As for :func:`integrate_cubic`.
///
/// Returns
/// -------
/// CubicTrajectory
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent, ``steps < 1``, ``t_end`` zero,
///     unknown map, a result that overflows.
/// ConvergenceError
///     A step is too long for its implicit equations to be solved; carries ``report``.
///
/// Notes
/// -----
/// ``H = <p_S S^T + p_V V^T, X> + |p_V S^T - S p_V^T|^2 / 4`` with ``X = V S^T - S V^T - S (S^T V - V^T S) S^T / 2``,
/// Frobenius products. A step is the implicit midpoint rule of the ambient space; then multiples of the gradients of
/// the constraints are added to make ``S^T p_S`` and ``S^T p_V`` skew. arXiv 2404.19407 names such a method as future
/// work. Discretization maps: Barbero-Linan, Martin de Diego (2023); constraints: Jay (1996), Hairer, Lubich, Wanner
/// (2006), section VII.1.4.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import integrate_embedded
/// >>> S = np.array([[1.0], [0.0], [0.0]])
/// >>> V, A, J = np.array([[0.0], [1.0], [0.0]]), np.array([[0.0], [0.0], [1.0]]), np.zeros((3, 1))
/// >>> trajectory = integrate_embedded(S, V, A, J, 20)
/// >>> trajectory.point.shape
/// (21, 3, 1)
/// >>> bool(trajectory.constraint_drift < 1e-14)
/// True
#[pyfunction]
#[pyo3(signature = (S, V, A, J, steps, t_end=1.0, map="midpoint", *, project=false))]
pub fn integrate_embedded(
    S: &Any,
    V: &Any,
    A: &Any,
    J: &Any,
    #[pyo3(from_py_with = whole)] steps: i64,
    t_end: f64,
    map: &str,
    project: bool,
) -> PyResult<PyCubicTrajectory> {
    let py = S.py();
    let arguments = named![S, V, A, J];
    let field = Field::of_named(&arguments)?;
    let data = Points::frames(Projection::of(project)).matrices(field, arguments)?;
    ensure!(map == "midpoint", "map: must be 'midpoint', found '{map}'");
    let steps = count("steps", steps, 1)?;
    let weight = EVALUATIONS * (steps as f64 + 1.0);
    let (trajectory, samples) = run_on(py, field, data, weight, move |[s, v, a, j], interrupt| {
        let trajectory = integrate(s, v, a, j, steps, t_end, interrupt)?;
        interrupt.check("cubic in the embedding")?;
        sampled(trajectory)
    })?;
    PyCubicTrajectory::wrap(py, field, &trajectory, samples)
}

/// Approximate number of evaluations of the vector field per step.
const EVALUATIONS: f64 = 10.0;
