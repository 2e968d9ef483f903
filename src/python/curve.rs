//! Curves: one class with the protocol, one subclass per kind of curve.

use std::sync::Arc;

use faer::MatRef;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use super::call::Call;
use super::convert::{float_array, matrix, parameters, to_array, tuple, write};
use super::error::{invalid_input, to_exception};
use crate::curve::{Curve, GeometricCubic, Quantity, Samples};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::manifold::{Geodesic, QuasiGeodesic};

#[expect(clippy::large_enum_variant, reason = "always behind an Arc")]
pub(super) enum AnyCurve {
    QuasiGeodesic(QuasiGeodesic),
    Geodesic(Geodesic),
    GeometricCubic(GeometricCubic),
}

impl AnyCurve {
    fn shape(&self) -> (usize, usize) {
        match self {
            AnyCurve::QuasiGeodesic(curve) => (curve.n(), curve.k()),
            AnyCurve::Geodesic(curve) => (curve.n(), curve.k()),
            AnyCurve::GeometricCubic(curve) => (curve.n(), curve.k()),
        }
    }

    fn t_span(&self) -> (f64, f64) {
        match self {
            AnyCurve::QuasiGeodesic(curve) => curve.t_span(),
            AnyCurve::Geodesic(curve) => curve.t_span(),
            AnyCurve::GeometricCubic(curve) => curve.t_span(),
        }
    }

    fn sample(&self, t: &[f64], quantity: Quantity, interrupt: Interrupt<'_>) -> Result<Samples> {
        match self {
            AnyCurve::QuasiGeodesic(curve) => curve.sample(t, quantity, interrupt),
            AnyCurve::Geodesic(curve) => curve.sample(t, quantity, interrupt),
            AnyCurve::GeometricCubic(curve) => curve.sample(t, quantity, interrupt),
        }
    }

    fn cost(&self, interrupt: Interrupt<'_>) -> Result<f64> {
        match self {
            AnyCurve::QuasiGeodesic(curve) => curve.cost_interruptible(interrupt),
            AnyCurve::Geodesic(curve) => curve.cost_interruptible(interrupt),
            AnyCurve::GeometricCubic(curve) => curve.cost_interruptible(interrupt),
        }
    }

    /// Rough operations per parameter.
    fn operations(&self, quantity: Quantity) -> f64 {
        let (n, k) = self.shape();
        let cube = (k * k * k) as f64;
        let own = match (self, quantity) {
            (AnyCurve::QuasiGeodesic(_), _) => 100.0 + 20.0 * cube,
            (AnyCurve::Geodesic(_), _) => 200.0 + 160.0 * cube,
            (AnyCurve::GeometricCubic(_), Quantity::Derivative(0)) => 1e3 + 500.0 * cube,
            (AnyCurve::GeometricCubic(_), _) => 2e4 + 2e4 * cube,
        };
        own + 8.0 * (n * k * k) as f64
    }
}

/// A smooth curve on St(n, k).
///
/// All curves share this protocol. Calls with a scalar ``t`` return shape ``(n, k)``, with an array of shape ``T``
/// return ``T + (n, k)``. Many parameters are evaluated in parallel without the interpreter lock; results are
/// bit-identical for any number of threads.
#[pyclass(name = "Curve", module = "stiefel_rs", subclass, frozen)]
pub struct PyCurve {
    pub(super) inner: Arc<AnyCurve>,
}

impl PyCurve {
    pub(super) fn of(curve: AnyCurve) -> Self {
        PyCurve {
            inner: Arc::new(curve),
        }
    }

    fn sample<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        quantity: Quantity,
        num_threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (mut shape, t) = parameters(t, "t")?;
        let call = Call::new(
            py,
            num_threads,
            t.len() as f64 * self.inner.operations(quantity),
        )?;
        let curve = Arc::clone(&self.inner);
        let samples = call.run(py, move |interrupt| curve.sample(&t, quantity, interrupt))?;
        let (n, k) = self.inner.shape();
        // Stored column by column; the transposed view has the documented shape and copies nothing.
        shape.extend([k, n]);
        let stored = PyArray1::from_vec(py, samples.into_entries()).reshape(shape)?;
        stored.call_method1("swapaxes", (-1, -2))
    }
}

#[pymethods]
impl PyCurve {
    /// Rows of a point.
    #[getter]
    fn n(&self) -> usize {
        self.inner.shape().0
    }

    /// Columns of a point.
    #[getter]
    fn k(&self) -> usize {
        self.inner.shape().1
    }

    /// The interval that the curve is made for.
    #[getter]
    fn t_span(&self) -> (f64, f64) {
        self.inner.t_span()
    }

    /// Position, or the ambient derivative of order ``nu``, at ``t``.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters, any finite numbers; the curve is made for ``t_span``.
    /// nu : int, default 0
    ///     Order of the derivative, 0 to 3; exact, by differentiating the algorithm.
    /// num_threads : int, optional
    ///     Threads; by default those of the global pool.
    ///
    /// Returns
    /// -------
    /// ndarray, shape T + (n, k)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``t`` not finite, ``nu`` out of range.
    /// OutsideDomainError
    ///     Intermediate points that no unique quasi-geodesic joins: outside of ``t_span``, or for far or fast data.
    #[pyo3(signature = (t, nu=0, *, num_threads=None))]
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        nu: i64,
        num_threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let order = usize::try_from(nu).unwrap_or(usize::MAX);
        if order > 3 {
            return Err(invalid_input(
                py,
                format!("nu: must be 0, 1, 2 or 3, found {nu}"),
            ));
        }
        self.sample(py, t, Quantity::Derivative(order), num_threads)
    }

    /// Velocity ``S'`` at ``t``, shape ``T + (n, k)``.
    #[pyo3(signature = (t, *, num_threads=None))]
    fn velocity<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        num_threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.sample(py, t, Quantity::Derivative(1), num_threads)
    }

    /// Covariant acceleration ``D_t S'`` (canonical metric) at ``t``, shape ``T + (n, k)``.
    #[pyo3(signature = (t, *, num_threads=None))]
    fn acceleration<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        num_threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.sample(py, t, Quantity::Acceleration, num_threads)
    }

    /// Covariant jerk ``D_t D_t S'`` (canonical metric) at ``t``, shape ``T + (n, k)``.
    #[pyo3(signature = (t, *, num_threads=None))]
    fn jerk<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        num_threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.sample(py, t, Quantity::Jerk, num_threads)
    }

    /// The cost: integral of ``|D_t S'|^2`` over ``t_span``, canonical metric.
    ///
    /// Relative error 1e-12, or round-off of the acceleration where that is more.
    ///
    /// Raises
    /// ------
    /// ConvergenceError
    ///     The quadrature does not settle.
    fn cost(&self, py: Python<'_>) -> PyResult<f64> {
        let curve = Arc::clone(&self.inner);
        let quantity = Quantity::Acceleration;
        let call = Call::new(py, None, 1e3 * self.inner.operations(quantity))?;
        call.run(py, move |interrupt| curve.cost(interrupt))
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let (n, k) = slf.get().inner.shape();
        Ok(format!("<{} on St({n}, {k})>", slf.get_type().name()?))
    }
}

/// Quasi-geodesic ``beta(t) = e^{tX} S e^{t Omega}`` between two points.
///
/// Parameters
/// ----------
/// S0, S1 : array_like, shape (n, k)
///     Points with orthonormal columns; ``beta(0) = S0``, ``beta(1) = S1``. The principal, shortest branch; almost
///     every two points are joined.
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
#[allow(non_snake_case)]
impl PyQuasiGeodesic {
    #[new]
    fn new(
        py: Python<'_>,
        S0: &Bound<'_, PyAny>,
        S1: &Bound<'_, PyAny>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let (s0, s1) = (matrix(S0, "S0")?, matrix(S1, "S1")?);
        let curve = py.detach(|| QuasiGeodesic::between(s0.as_ref(), s1.as_ref()));
        Self::wrap(curve.map_err(|error| to_exception(py, &error, ""))?)
    }

    /// The quasi-geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect).
    #[staticmethod]
    fn from_velocity(
        py: Python<'_>,
        S: &Bound<'_, PyAny>,
        V: &Bound<'_, PyAny>,
    ) -> PyResult<Py<Self>> {
        let (s, v) = (matrix(S, "S")?, matrix(V, "V")?);
        let curve = py.detach(|| QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref()));
        Py::new(
            py,
            Self::wrap(curve.map_err(|error| to_exception(py, &error, ""))?)?,
        )
    }
}

impl PyQuasiGeodesic {
    fn wrap(curve: QuasiGeodesic) -> PyResult<PyClassInitializer<Self>> {
        let base = PyCurve {
            inner: Arc::new(AnyCurve::QuasiGeodesic(curve)),
        };
        Ok(PyClassInitializer::from(base).add_subclass(PyQuasiGeodesic))
    }
}

/// Geometric cubic polynomial by the adjusted de Casteljau algorithm, from boundary data.
///
/// Parameters
/// ----------
/// S0, V0 : array_like, shape (n, k)
///     Initial point and velocity.
/// S1, V1 : array_like, shape (n, k)
///     Final point and velocity, at ``t = 1``.
///
/// Raises
/// ------
/// InvalidInputError
///     Shape, not finite, not orthonormal, not tangent (with the measured defect); an end velocity too long to be
///     met.
/// OutsideDomainError
///     Inner control points that cannot be joined; carries ``angle``.
///
/// Notes
/// -----
/// Meets its boundary data to round-off and is close to the Riemannian cubic with the same data, not equal to it. A
/// third of each end velocity must be the velocity of the principal quasi-geodesic between its ends (on the sphere,
/// speeds below ``3 pi``); longer ones are refused. The curve is smooth where the relative rotations and principal
/// angles of all intermediate points stay below pi; for far or fast data one may cross pi inside of the interval, and
/// there the curve jumps to another branch. This is a limit of the algorithm.
///
/// arXiv 2404.19407 and Krakowski, Machado, Silva Leite, Batista (2017).
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import GeometricCubic
/// >>> S0, V0 = np.eye(3)[:, :1], np.eye(3)[:, 1:2]
/// >>> S1, V1 = np.eye(3)[:, 1:2], np.eye(3)[:, 2:]
/// >>> curve = GeometricCubic(S0, V0, S1, V1)
/// >>> curve(np.linspace(0, 1, 5)).shape
/// (5, 3, 1)
/// >>> bool(np.allclose(curve.velocity(1.0), V1))
/// True
#[pyclass(name = "GeometricCubic", module = "stiefel_rs", extends = PyCurve, frozen)]
pub struct PyGeometricCubic;

#[pymethods]
#[allow(non_snake_case)]
impl PyGeometricCubic {
    #[new]
    fn new(
        py: Python<'_>,
        S0: &Bound<'_, PyAny>,
        V0: &Bound<'_, PyAny>,
        S1: &Bound<'_, PyAny>,
        V1: &Bound<'_, PyAny>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let (s0, v0, s1, v1) = (
            matrix(S0, "S0")?,
            matrix(V0, "V0")?,
            matrix(S1, "S1")?,
            matrix(V1, "V1")?,
        );
        let curve = py.detach(|| {
            GeometricCubic::from_boundary(s0.as_ref(), v0.as_ref(), s1.as_ref(), v1.as_ref())
        });
        Self::wrap(curve.map_err(|error| to_exception(py, &error, ""))?)
    }

    /// The geometric cubic with control points ``P``, shape (4, n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal (with the measured defect).
    /// OutsideDomainError
    ///     Consecutive points that cannot be joined; carries ``angle``.
    #[staticmethod]
    fn from_control_points(py: Python<'_>, P: &Bound<'_, PyAny>) -> PyResult<Py<Self>> {
        let array = float_array(P, "P")?;
        let shape = array.as_array().shape().to_vec();
        let [4, n, k] = shape[..] else {
            return Err(invalid_input(
                py,
                format!("P: expected shape (4, n, k), found {}", tuple(&shape)),
            ));
        };
        let entries: Vec<f64> = array.as_array().iter().copied().collect();
        let point =
            |i: usize| MatRef::from_row_major_slice(&entries[i * n * k..(i + 1) * n * k], n, k);
        let curve = GeometricCubic::from_control_points([point(0), point(1), point(2), point(3)]);
        Py::new(
            py,
            Self::wrap(curve.map_err(|error| to_exception(py, &error, ""))?)?,
        )
    }

    /// The control points, shape (4, n, k).
    #[getter]
    fn control_points<'py>(
        slf: PyRef<'py, Self>,
        py: Python<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let base = slf.into_super();
        let AnyCurve::GeometricCubic(curve) = &*base.inner else {
            return Err(invalid_input(py, "not a geometric cubic".to_owned()));
        };
        let (n, k) = (curve.n(), curve.k());
        let mut entries = vec![0.0; 4 * n * k];
        for (point, target) in curve.control_points().iter().zip(entries.chunks_mut(n * k)) {
            write(point.as_ref(), target);
        }
        to_array(py, entries, &[4, n, k])
    }
}

impl PyGeometricCubic {
    fn wrap(curve: GeometricCubic) -> PyResult<PyClassInitializer<Self>> {
        let base = PyCurve {
            inner: Arc::new(AnyCurve::GeometricCubic(curve)),
        };
        Ok(PyClassInitializer::from(base).add_subclass(PyGeometricCubic))
    }
}
