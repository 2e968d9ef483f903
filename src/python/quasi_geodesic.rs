//! Quasi-geodesics of the binding.

use super::membership::Projection;
use super::points::Points;
use super::prelude::*;
use crate::manifold::QuasiGeodesic;

/// Quasi-geodesic ``beta(t) = e^{tX} S e^{t Omega}`` between two points.
///
/// Parameters
/// ----------
/// S0, S1 : array_like, shape (n, k)
///     Points with orthonormal columns; ``beta(0) = S0``, ``beta(1) = S1``. The principal branch, whose normal part
///     ``|K|`` is the shortest; another branch may be shorter in all, by a smaller ``Omega``. Almost every two points are
///     joined.
/// project : bool, default False
///     Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
///     Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.
///
/// Raises
/// ------
/// InvalidInputError
///     Shape, not finite, not orthonormal (with the measured defect).
/// OutsideDomainError
///     Antipodal points, a relative rotation by pi, different components of O(n); carries ``angle``.
///
/// Notes
/// -----
/// arXiv 2404.19407, Proposition 1; evaluated in ``O(n k^2)`` by a thin factorisation.
///
/// Examples
/// --------
/// >>> from stiefel_rs import QuasiGeodesic
/// >>> curve = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]])
/// >>> curve(0.5).round(6).ravel().tolist()
/// [0.707107, 0.707107]
#[pyclass(name = "QuasiGeodesic", module = "stiefel_rs", extends = PyCurve, frozen)]
pub struct PyQuasiGeodesic;

#[pymethods]
impl PyQuasiGeodesic {
    #[new]
    #[pyo3(signature = (S0, S1, *, project=false))]
    fn new(S0: &Any, S1: &Any, project: bool) -> PyResult<PyClassInitializer<Self>> {
        Self::made(named![S0, S1], project, QuasiGeodesic::between)
    }

    /// The quasi-geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect).
    #[staticmethod]
    #[pyo3(signature = (S, V, *, project=false))]
    fn from_velocity(S: &Any, V: &Any, project: bool) -> PyResult<Py<Self>> {
        let made = Self::made(named![S, V], project, QuasiGeodesic::from_velocity)?;
        Py::new(S.py(), made)
    }
}

impl PyQuasiGeodesic {
    fn made(
        arguments: [Named<'_, '_>; 2],
        project: bool,
        make: fn(MatRef<'_, f64>, MatRef<'_, f64>) -> Result<QuasiGeodesic>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let (py, field) = (arguments[0].0.py(), Field::of_named(&arguments)?);
        let data = Points::frames(Projection::of(project)).matrices(field, arguments)?;
        let make = move |[point, other]: [MatRef<'_, f64>; 2], _: Interrupt<'_>| make(point, other);
        let curve = run_on(py, field, data, 1.0, make)?;
        wrap(py, Arc::new(curve), field, PyQuasiGeodesic)
    }
}
