//! Riemannian exponential, logarithm and distance for arrays, and geodesics as curves.

use super::batch::Value;
use super::points::Points;
use super::prelude::*;
use super::record::record;
use super::space::Space;
use super::stiefel::{PyStiefel, read_metric};
use crate::manifold::{Geodesic, Grassmann, LogReport, Metric, Stiefel};
use crate::space::Quotient;

/// Report on a Riemannian logarithm.
///
/// Fields are numbers for a single pair of points, and arrays of the shape of the batch for a batch.
#[pyclass(name = "LogReport", module = "stiefel_rs", frozen, get_all)]
pub struct PyLogReport {
    /// Whether the residual is at the level of round-off; always True for a logarithm that is returned.
    converged: Py<PyAny>,
    /// Newton steps of the successful solve, including the first attempt at close points.
    iterations: Py<PyAny>,
    /// Frobenius norm ``|exp(S0, V) - S1|``.
    residual: Py<PyAny>,
    /// Length of the geodesic in the manifold's metric.
    length: Py<PyAny>,
    /// Whether the geodesic is known to be the shortest.
    ///
    /// True if it is shorter than the known bound of the injectivity radius (canonical ``sqrt(4/5) pi``, Euclidean
    /// ``pi``; no bound is known for the metrics between), or has a closed form (``k = 1``, ``k = n``, canonical also
    /// ``k = n - 1``). If False, the geodesic may still be the shortest.
    certainly_shortest: Py<PyAny>,
}

#[pymethods]
impl PyLogReport {
    #[new]
    fn new(
        converged: Py<PyAny>,
        iterations: Py<PyAny>,
        residual: Py<PyAny>,
        length: Py<PyAny>,
        certainly_shortest: Py<PyAny>,
    ) -> Self {
        PyLogReport {
            converged,
            iterations,
            residual,
            length,
            certainly_shortest,
        }
    }
}

record! { PyLogReport, converged, iterations, residual, length, certainly_shortest }

/// Numbers of a report in a row of results.
const REPORT: usize = 4;

impl PyLogReport {
    /// Builds a report from one row of numbers per member; plain Python numbers for a single pair of points.
    fn from_rows(py: Python<'_>, field: Field, rows: &[&[f64]], shape: &[usize]) -> PyResult<Self> {
        let array = |values: Vec<f64>, dtype: &str| {
            let array = to_array(py, values, shape)?.call_method1("astype", (dtype,))?;
            let number = shape.is_empty().then(|| array.call_method0("item"));
            PyResult::Ok(number.transpose()?.unwrap_or(array).unbind())
        };
        let column = |i: usize, dtype| array(rows.iter().map(|row| row[i]).collect(), dtype);
        let lengths = |i: usize| {
            let lengths = rows.iter().map(|row| field.length(row[i]));
            array(lengths.collect(), "float64")
        };
        Ok(PyLogReport {
            converged: array(vec![1.0; rows.len()], "bool")?,
            iterations: column(0, "int64")?,
            residual: lengths(1)?,
            length: lengths(2)?,
            certainly_shortest: column(3, "bool")?,
        })
    }
}

/// A logarithm and the numbers of its report.
impl Value for (Mat<f64>, LogReport) {
    fn put(&self, out: &mut [f64]) {
        let (velocity, report) = self;
        let (vector, numbers) = out.split_at_mut(out.len() - REPORT);
        velocity.put(vector);
        let certain = f64::from(u8::from(report.certainly_shortest));
        let iterations = report.iterations as f64;
        numbers.copy_from_slice(&[iterations, report.residual, report.length, certain]);
    }
}

impl PyStiefel {
    /// Apply `value` to the logarithm of every pair of points.
    fn map_logarithms<T: Value>(
        &self,
        objects: [Named<'_, '_>; 2],
        core: &[usize],
        value: impl Fn((Mat<f64>, LogReport)) -> T + Shared,
    ) -> PyResult<Array> {
        self.map(objects, core, move |m, points, interrupt| {
            // Rows are far apart in a batch; the core reads columns.
            let [s0, s1] = points.map(|point| point.to_owned());
            let found = m.log_with_report(s0.as_ref(), s1.as_ref(), interrupt)?;
            Ok(value(found))
        })
    }
}

#[pymethods]
impl PyStiefel {
    /// Return the Riemannian exponential of tangent vectors ``V`` at ``S``, shape (..., n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), or
    ///     a vector so long that the result overflows.
    fn exp(&self, S: &Any, V: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![S, V], |m, [s, v]| m.exp(s, v))
    }

    /// Return the Riemannian logarithm: the ``V`` at ``S0`` with ``exp(S0, V) = S1``, shape (..., n, k).
    ///
    /// Parameters
    /// ----------
    /// S0, S1 : array_like, shape (..., n, k)
    ///     Points.
    /// full_output : bool, default False
    ///     If True, also return a report.
    ///
    /// Returns
    /// -------
    /// V : ndarray, shape (..., n, k)
    ///     Initial velocities of the geodesics.
    /// report : LogReport
    ///     Iterations, residual, length, and whether the geodesic is known to be the shortest; only with
    ///     ``full_output=True``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
    /// OutsideDomainError
    ///     Antipodal points, a relative rotation by pi, or different components of O(n); carries ``angle``.
    /// ConvergenceError
    ///     No geodesic was found, far beyond the injectivity radius; carries ``report``.
    ///
    /// Notes
    /// -----
    /// Newton's method on the exponential, with the exact inverse derivative. For distant points, Newton's method for
    /// the shortest rotation over the fibre (formulation of Zimmermann, Hueper 2022). Below a distance of ``0.89 pi``
    /// the result is the shortest geodesic (canonical metric).
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(5, 2)
    /// >>> S = M.random_point(rng=0)
    /// >>> V = 0.5 * M.random_tangent(S, rng=1)
    /// >>> W, report = M.log(S, M.exp(S, V), full_output=True)
    /// >>> bool(abs(W - V).max() < 1e-13), report.certainly_shortest
    /// (True, True)
    #[pyo3(signature = (S0, S1, *, full_output=false))]
    fn log<'py>(&self, S0: &Any<'py>, S1: &Any<'py>, full_output: bool) -> PyResult<Any<'py>> {
        let (py, points, (n, k)) = (S0.py(), named![S0, S1], self.shape());
        let [n, k] = [n, k].map(|size| self.field.embedded(size));
        if !full_output {
            let velocities = self.map_logarithms(points, &[n, k], |(velocity, _)| velocity)?;
            return self
                .field
                .numbers(velocities)?
                .like(points)?
                .into_bound_py_any(py);
        }
        let size = n * k;
        let found = self.map_logarithms(points, &[size + REPORT], |found| found)?;
        let shape = &found.shape[..found.shape.len() - 1];
        let rows = found.entries.chunks(size + REPORT);
        let (vectors, reports): (Vec<_>, Vec<_>) = rows.map(|row| row.split_at(size)).unzip();
        let velocities = self.field.numbers(Array {
            shape: [shape, &[n, k]].concat(),
            entries: vectors.concat(),
        })?;
        let velocities = velocities.like(points)?;
        let report = PyLogReport::from_rows(py, self.field, &reports, shape)?;
        (velocities, report).into_bound_py_any(py)
    }

    /// Return the Riemannian distance between points, the length of the geodesic of :meth:`log`, shape (...).
    ///
    /// Raises
    /// ------
    /// InvalidInputError, OutsideDomainError, ConvergenceError
    ///     As for :meth:`log`.
    fn dist(&self, S0: &Any, S1: &Any) -> PyResult<Numbers> {
        let field = self.field;
        let points = named![S0, S1];
        let lengths =
            self.map_logarithms(points, &[], move |(_, report)| field.length(report.length))?;
        Numbers::from(lengths).like(points)
    }
}

/// Riemannian geodesic between two points.
///
/// Parameters
/// ----------
/// S0, S1 : array_like, shape (n, k)
///     Points with orthonormal columns; ``gamma(0) = S0``, ``gamma(1) = S1``. The geodesic is that of ``Stiefel.log``,
///     the shortest up to a distance of ``0.89 pi`` (canonical metric).
/// metric : "canonical", "euclidean" or float, default "canonical"
///     Metric of the geodesic, as for ``Stiefel``. The covariant ``acceleration`` and ``jerk`` and the ``cost`` use the
///     canonical metric for every curve, so they vanish for canonical geodesics only.
/// manifold : Stiefel or Grassmann, optional
///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
///     are arbitrary bases of subspaces, and the curve consists of bases that start at the first given one and turn as
///     little as possible, ``Y^T Y' = 0``.
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
/// ConvergenceError
///     No geodesic was found; carries ``report``.
///
/// Notes
/// -----
/// Edelman, Arias, Smith (1998); Hueper, Markina, Silva Leite (2021) for the family of metrics.
///
/// Examples
/// --------
/// >>> from stiefel_rs import Geodesic
/// >>> curve = Geodesic([[1.0], [0.0]], [[0.0], [1.0]])
/// >>> curve(0.5).round(6).ravel().tolist()
/// [0.707107, 0.707107]
#[pyclass(name = "Geodesic", module = "stiefel_rs", extends = PyCurve, frozen)]
pub struct PyGeodesic {
    curve: Arc<Geodesic>,
    field: Field,
}

#[pymethods]
impl PyGeodesic {
    #[new]
    #[pyo3(signature = (S0, S1, *, metric=None, manifold=None, project=false))]
    fn new(
        S0: &Any,
        S1: &Any,
        metric: Option<&Any>,
        manifold: Option<&Any>,
        project: bool,
    ) -> PyResult<PyClassInitializer<Self>> {
        let points = Points::read(manifold, project)?;
        let makes = (
            Stiefel::geodesic_between as _,
            Grassmann::geodesic_between as _,
        );
        Self::made(named![S0, S1], metric, &points, LOGARITHM, makes)
    }

    /// Return the geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k).
    ///
    /// Other arguments are the same as for the class.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), or
    ///     a vector so long that the result overflows.
    #[staticmethod]
    #[pyo3(signature = (S, V, *, metric=None, manifold=None, project=false))]
    fn from_velocity(
        S: &Any,
        V: &Any,
        metric: Option<&Any>,
        manifold: Option<&Any>,
        project: bool,
    ) -> PyResult<Py<Self>> {
        let points = Points::read(manifold, project)?;
        let makes = (Stiefel::geodesic as _, Grassmann::geodesic as _);
        Py::new(
            S.py(),
            Self::made(named![S, V], metric, &points, 1.0, makes)?,
        )
    }

    /// Length over ``[0, 1]`` in the metric of the geodesic.
    #[getter]
    fn length(&self) -> f64 {
        self.field.length(self.curve.length())
    }
}

/// Work of a logarithm, which is not polled for Ctrl-C, relative to an exponential.
const LOGARITHM: f64 = 10.0;

/// Makes a geodesic from two points, or from a point and a vector.
type Make<M> = fn(&M, MatRef<'_, f64>, MatRef<'_, f64>) -> Result<Geodesic>;

impl PyGeodesic {
    fn made(
        arguments: [Named<'_, '_>; 2],
        metric: Option<&Any>,
        points: &Points,
        weight: f64,
        (of_frames, of_subspaces): (Make<Stiefel>, Make<Grassmann>),
    ) -> PyResult<PyClassInitializer<Self>> {
        if metric.is_some() {
            points.only_frames("metric")?;
        }
        let metric = metric.map_or(Ok(Metric::CANONICAL), read_metric)?;
        let [(first, name), (second, _)] = arguments;
        let (py, field) = (first.py(), points.field([first, second])?);
        let (data, quotient) = (points.matrices(field, arguments)?, points.quotient);
        let curve = run_on(
            py,
            field,
            data,
            weight,
            move |[point, other], _| match quotient {
                Quotient::Frames => {
                    let manifold = Stiefel::of(name, point)?.with_metric(metric);
                    of_frames(&manifold, point, other)
                }
                Quotient::Subspaces => of_subspaces(&Grassmann::of(name, point)?, point, other),
            },
        )?;
        Self::wrap(py, curve, field)
    }

    pub(super) fn wrap(
        py: Python<'_>,
        curve: Geodesic,
        field: Field,
    ) -> PyResult<PyClassInitializer<Self>> {
        let curve = Arc::new(curve);
        let inner = Arc::clone(&curve) as _;
        wrap_checked(py, inner, field, PyGeodesic { curve, field })
    }
}
