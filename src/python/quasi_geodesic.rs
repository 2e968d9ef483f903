//! Quasi-geodesics of the binding.

use super::points::Points;
use super::prelude::*;
use super::projection::Projection;
use crate::manifold::QuasiGeodesic;

/// Quasi-geodesic ``beta(t) = e^{tX} S e^{t Omega}`` between two points.
///
/// Parameters
/// ----------
/// S0, S1 : array_like, shape (n, k)
///     Points with orthonormal columns; ``beta(0) = S0``, ``beta(1) = S1``. The curve is the principal branch, whose
///     normal part ``|K|`` is minimal; another branch may be shorter in total because its ``Omega`` is smaller. Almost
///     all pairs of points are joined.
/// project : bool, default False
///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
///     their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
///     single precision are always projected.
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
/// OutsideDomainError
///     Antipodal points, a relative rotation by pi, or different components of O(n); carries ``angle``.
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

    /// Return the quasi-geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect).
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
        wrap_checked(py, Arc::new(curve), field, PyQuasiGeodesic)
    }
}
