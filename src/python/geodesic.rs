//! Riemannian exponential, logarithm and distance for arrays, and geodesics as curves.

use super::batch::Value;
use super::only_bases::advised;
use super::points::Points;
use super::prelude::*;
use super::record::record;
use super::space::Space;
use super::stiefel::{PyStiefel, read_metric};
use crate::manifold::{Geodesic, Grassmann, LogReport, Metric, Stiefel};
use crate::space::Quotient;

/// How a Riemannian logarithm was found, and what is known of it.
///
/// The fields are numbers for a single pair of points, arrays of the batch's shape for a batch.
#[pyclass(name = "LogReport", module = "stiefel_rs", frozen, get_all)]
pub struct PyLogReport {
    /// Whether the residual is at the level of round-off. A logarithm that is returned always has converged.
    converged: Py<PyAny>,
    /// Newton steps that led to it: the first attempt from a close start, and those from the start that found it.
    iterations: Py<PyAny>,
    /// ``|exp(S0, V) - S1|``, Frobenius norm.
    residual: Py<PyAny>,
    /// Length of the geodesic in the manifold's metric.
    length: Py<PyAny>,
    /// Whether the geodesic is certainly the shortest: it is shorter than the known bound of the injectivity radius
    /// (canonical ``sqrt(4/5) pi``, Euclidean ``pi``; of the metrics between none is known), or the case is closed (``k =
    /// 1``, ``k = n``, canonical also ``k = n - 1``). Otherwise it may be or not.
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
    /// From one row of numbers per member; plain Python numbers for a single pair of points.
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
            let found = m.log_interruptible(s0.as_ref(), s1.as_ref(), interrupt);
            let found = found.map_err(|error| advised(error, s0.as_ref(), s1.as_ref()))?;
            Ok(value(found))
        })
    }
}

#[pymethods]
impl PyStiefel {
    /// The Riemannian exponential of tangent vectors ``V`` at ``S``, shape (..., n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), or too long for a number.
    fn exp(&self, S: &Any, V: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![S, V], |m, data| {
            let [s, v] = data.map(|matrix| matrix.to_owned());
            m.exp(s.as_ref(), v.as_ref())
        })
    }

    /// The Riemannian logarithm: tangent vectors at ``S0`` with ``exp(S0, V) = S1``, shape (..., n, k).
    ///
    /// Parameters
    /// ----------
    /// S0, S1 : array_like, shape (..., n, k)
    ///     Points.
    /// full_output : bool, default False
    ///     Also return a report.
    ///
    /// Returns
    /// -------
    /// V : ndarray, shape (..., n, k)
    /// report : LogReport
    ///     Only with ``full_output``: iterations, residual, length, and whether the geodesic is certainly the shortest.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal (with the measured defect).
    /// OutsideDomainError
    ///     Antipodal points, a relative rotation by pi, different components of O(n); carries ``angle``.
    /// ConvergenceError
    ///     No geodesic was found, far beyond the injectivity radius; carries ``report``.
    ///
    /// Notes
    /// -----
    /// Newton's method on the exponential with the exact inverse derivative; far points by Newton's method for the
    /// shortest rotation over the fibre (see Zimmermann, Hueper 2022 for the formulation). Below ``0.89 pi`` the answer
    /// is the shortest geodesic (canonical metric).
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

    /// The Riemannian distance of points, shape (...): the length of the geodesic of :meth:`log`.
    ///
    /// Raises
    /// ------
    /// InvalidInputError, OutsideDomainError, ConvergenceError
    ///     As :meth:`log`.
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
///     Points with orthonormal columns; ``gamma(0) = S0``, ``gamma(1) = S1``. The geodesic of ``Stiefel.log``: the
///     shortest one up to ``0.89 pi`` (canonical metric).
/// metric : "canonical", "euclidean" or float, default "canonical"
///     The metric whose geodesic it is, as for ``Stiefel``. The covariant ``acceleration`` and ``jerk`` and the
///     ``cost`` are those of the canonical metric for every curve, so they vanish for canonical geodesics only.
/// manifold : Stiefel or Grassmann, optional
///     What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
///     whichever, and the bases of the curve turn as little as possible.
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
        Self::made(named![S0, S1], metric, &points, makes)
    }

    /// The geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k). All else as for the class.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), or too long for a number.
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
        Py::new(S.py(), Self::made(named![S, V], metric, &points, makes)?)
    }

    /// Length over ``[0, 1]`` in the metric of the geodesic.
    #[getter]
    fn length(&self) -> f64 {
        self.field.length(self.curve.length())
    }
}

/// Makes a geodesic from two points, or a point and a vector.
type Make<M> = fn(&M, MatRef<'_, f64>, MatRef<'_, f64>) -> Result<Geodesic>;

impl PyGeodesic {
    fn made(
        arguments: [Named<'_, '_>; 2],
        metric: Option<&Any>,
        points: &Points,
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
            1.0,
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
        wrap(py, inner, field, PyGeodesic { curve, field })
    }
}
