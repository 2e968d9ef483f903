//! Riemannian exponential, logarithm and distance for arrays, and geodesics as curves.

use std::sync::Arc;

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyTuple};

use super::call::Call;
use super::convert::{Batch, map_batch, matrices, matrix, to_array, write};
use super::curve::{AnyCurve, Operations, PyCurve, cube};
use super::error::to_exception;
use super::stiefel::{PyStiefel, read_metric};
use super::stored::{Form, form};
use crate::curve::Quantity;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::manifold::{Geodesic, LogReport, Metric, Stiefel};
use crate::stored::Stored;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Numbers of a report in a row of results.
const REPORT: usize = 4;

/// How a Riemannian logarithm was found, and what is known of it.
///
/// The fields are numbers for a single pair of points, arrays of the batch's shape for a batch.
///
/// Attributes
/// ----------
/// converged : bool or ndarray of bool
///     Whether the residual is at the level of round-off. A logarithm that is returned always has converged.
/// iterations : int or ndarray of int
///     Newton steps that led to it: the first attempt from a close start, and those from the start that found it.
/// residual : float or ndarray
///     ``|exp(S0, V) - S1|``, Frobenius norm.
/// length : float or ndarray
///     Length of the geodesic in the manifold's metric.
/// certainly_shortest : bool or ndarray of bool
///     Whether the geodesic is certainly the shortest: it is shorter than the known bound of the injectivity radius
///     (canonical ``sqrt(4/5) pi``, Euclidean ``pi``; of the metrics between none is known), or the case is closed
///     (``k = 1``, ``k = n``, canonical also ``k = n - 1``). Otherwise it may be or not.
#[pyclass(name = "LogReport", module = "stiefel_rs", frozen)]
pub struct PyLogReport {
    fields: [Py<PyAny>; 5],
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
            fields: [converged, iterations, residual, length, certainly_shortest],
        }
    }

    /// For pickle and copy.
    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let fields = slf.get().fields.iter().map(|field| field.bind(slf.py()));
        Ok((slf.get_type().into_any(), PyTuple::new(slf.py(), fields)?))
    }

    #[getter]
    fn converged(&self, py: Python<'_>) -> Py<PyAny> {
        self.fields[0].clone_ref(py)
    }

    #[getter]
    fn iterations(&self, py: Python<'_>) -> Py<PyAny> {
        self.fields[1].clone_ref(py)
    }

    #[getter]
    fn residual(&self, py: Python<'_>) -> Py<PyAny> {
        self.fields[2].clone_ref(py)
    }

    #[getter]
    fn length(&self, py: Python<'_>) -> Py<PyAny> {
        self.fields[3].clone_ref(py)
    }

    #[getter]
    fn certainly_shortest(&self, py: Python<'_>) -> Py<PyAny> {
        self.fields[4].clone_ref(py)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let [converged, iterations, residual, length, certain] = &self.fields;
        let word = |field: &Py<PyAny>| -> PyResult<String> {
            Ok(field.bind(py).repr()?.to_str()?.to_owned())
        };
        Ok(format!(
            "LogReport(converged={}, iterations={}, residual={}, length={}, certainly_shortest={})",
            word(converged)?,
            word(iterations)?,
            word(residual)?,
            word(length)?,
            word(certain)?
        ))
    }
}

impl PyLogReport {
    /// From the rows of numbers behind the velocities.
    fn from_rows(py: Python<'_>, rows: &[[f64; REPORT]], shape: &[usize]) -> PyResult<Self> {
        if let ([[iterations, residual, length, certain]], []) = (rows, shape) {
            return Ok(PyLogReport {
                fields: [
                    PyBool::new(py, true).to_owned().into_any().unbind(),
                    PyInt::new(py, *iterations as u64).into_any().unbind(),
                    PyFloat::new(py, *residual).into_any().unbind(),
                    PyFloat::new(py, *length).into_any().unbind(),
                    PyBool::new(py, *certain == 1.0)
                        .to_owned()
                        .into_any()
                        .unbind(),
                ],
            });
        }
        let column = |index: usize, dtype: &str| -> PyResult<Py<PyAny>> {
            let values = rows.iter().map(|row| row[index]).collect();
            let array = to_array(py, values, shape)?;
            Ok(array.call_method1("astype", (dtype,))?.unbind())
        };
        let converged = to_array(py, vec![1.0; rows.len()], shape)?;
        Ok(PyLogReport {
            fields: [
                converged.call_method1("astype", ("bool",))?.unbind(),
                column(0, "int64")?,
                column(1, "float64")?,
                column(2, "float64")?,
                column(3, "bool")?,
            ],
        })
    }
}

fn numbers(report: &LogReport) -> [f64; REPORT] {
    let certain = f64::from(u8::from(report.certainly_shortest));
    [
        report.iterations as f64,
        report.residual,
        report.length,
        certain,
    ]
}

/// Rough operations of an exponential or a logarithm, in units of what other calls count: a pair of St(1000, 50), five
/// milliseconds, still runs in place.
fn one_geodesic((n, k): (usize, usize)) -> f64 {
    let (n, k) = (n as f64, k as f64);
    let m = (2.0 * k).min(n);
    1e5 + n * k * k + 7.0 * m * m * m
}

impl PyStiefel {
    /// Checks shapes and maps every pair of members to `size` numbers; also the shape of the batch.
    fn map_pairs(
        &self,
        py: Python<'_>,
        objects: [(&Bound<'_, PyAny>, &'static str); 2],
        size: usize,
        member: impl Fn(&Stiefel, [&Batch; 2], usize, &mut [f64], Interrupt<'_>) -> Result<()>
        + Sync
        + Send
        + 'static,
    ) -> PyResult<(Vec<f64>, Vec<usize>)> {
        let batches = matrices(objects)?;
        for (batch, (_, name)) in batches.iter().zip(objects) {
            self.core_shape(batch, name, py)?;
        }
        let each = one_geodesic((self.0.n(), self.0.k()));
        let call = Call::new(py, None, batches[0].len() as f64 * each)?;
        let shape = batches[0].shape.clone();
        let manifold = self.0;
        let wrapped = move |b: [&Batch; 2], i: usize, out: &mut [f64], interrupt: Interrupt<'_>| {
            member(&manifold, b, i, out, interrupt)
        };
        Ok((map_batch(py, &call, batches, size, wrapped)?, shape))
    }
}

#[pymethods]
#[allow(non_snake_case)]
impl PyStiefel {
    /// The Riemannian exponential of tangent vectors ``V`` at ``S``, shape (..., n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), or too long for a number.
    fn exp<'py>(
        &self,
        py: Python<'py>,
        S: &Bound<'py, PyAny>,
        V: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let (n, k) = (self.0.n(), self.0.k());
        let (entries, mut shape) =
            self.map_pairs(py, [(S, "S"), (V, "V")], n * k, |m, [s, v], i, out, _| {
                // Rows are far apart in a batch; the core reads columns.
                let (s, v) = (s.get(i).to_owned(), v.get(i).to_owned());
                write(m.exp(s.as_ref(), v.as_ref())?.as_ref(), out);
                Ok(())
            })?;
        shape.extend([n, k]);
        to_array(py, entries, &shape)
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
    fn log<'py>(
        &self,
        py: Python<'py>,
        S0: &Bound<'py, PyAny>,
        S1: &Bound<'py, PyAny>,
        full_output: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (n, k) = (self.0.n(), self.0.k());
        let size = n * k + if full_output { REPORT } else { 0 };
        let objects = [(S0, "S0"), (S1, "S1")];
        let (mut entries, shape) =
            self.map_pairs(py, objects, size, move |m, [s0, s1], i, out, interrupt| {
                let (s0, s1) = (s0.get(i).to_owned(), s1.get(i).to_owned());
                let (v, report) = m.log_interruptible(s0.as_ref(), s1.as_ref(), interrupt)?;
                let (velocity, rest) = out.split_at_mut(n * k);
                write(v.as_ref(), velocity);
                if full_output {
                    rest.copy_from_slice(&numbers(&report));
                }
                Ok(())
            })?;
        let full: Vec<usize> = shape.iter().chain(&[n, k]).copied().collect();
        if !full_output {
            return Ok(to_array(py, entries, &full)?.into_any());
        }
        let mut rows = Vec::with_capacity(entries.len() / size);
        for (i, row) in (0..entries.len() / size).map(|i| (i, i * size)) {
            rows.push(std::array::from_fn(|j| entries[row + n * k + j]));
            entries.copy_within(row..row + n * k, i * n * k);
        }
        entries.truncate(rows.len() * n * k);
        let report = PyLogReport::from_rows(py, &rows, &shape)?;
        let velocity = to_array(py, entries, &full)?;
        Ok((velocity, Py::new(py, report)?)
            .into_pyobject(py)?
            .into_any())
    }

    /// The Riemannian distance of points, shape (...): the length of the geodesic of :meth:`log`.
    ///
    /// Raises
    /// ------
    /// InvalidInputError, OutsideDomainError, ConvergenceError
    ///     As :meth:`log`.
    fn dist<'py>(
        &self,
        py: Python<'py>,
        S0: &Bound<'py, PyAny>,
        S1: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let objects = [(S0, "S0"), (S1, "S1")];
        let (entries, mut shape) =
            self.map_pairs(py, objects, 1, |m, [s0, s1], i, out, interrupt| {
                let (s0, s1) = (s0.get(i).to_owned(), s1.get(i).to_owned());
                let (_, report) = m.log_interruptible(s0.as_ref(), s1.as_ref(), interrupt)?;
                out[0] = report.length;
                Ok(())
            })?;
        shape.push(1);
        to_array(py, entries, &shape)?.get_item((pyo3::types::PyEllipsis::get(py), 0))
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
pub struct PyGeodesic(Arc<Geodesic>);

#[pymethods]
#[allow(non_snake_case)]
impl PyGeodesic {
    #[new]
    #[pyo3(signature = (S0, S1, *, metric=None))]
    fn new(
        py: Python<'_>,
        S0: &Bound<'_, PyAny>,
        S1: &Bound<'_, PyAny>,
        metric: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let metric = metric.map_or(Ok(Metric::CANONICAL), read_metric)?;
        let (s0, s1) = (matrix(S0, "S0")?, matrix(S1, "S1")?);
        let call = Call::new(py, None, one_geodesic(s0.shape()))?;
        let curve = call.run_any(py, move |_| {
            let manifold = Stiefel::of("S0", s0.as_ref())?.with_metric(metric);
            manifold.geodesic_between(s0.as_ref(), s1.as_ref())
        })?;
        Self::wrap(py, curve)
    }

    /// The geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), or too long for a number.
    #[staticmethod]
    #[pyo3(signature = (S, V, *, metric=None))]
    fn from_velocity(
        py: Python<'_>,
        S: &Bound<'_, PyAny>,
        V: &Bound<'_, PyAny>,
        metric: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<Self>> {
        let metric = metric.map_or(Ok(Metric::CANONICAL), read_metric)?;
        let (s, v) = (matrix(S, "S")?, matrix(V, "V")?);
        let call = Call::new(py, None, one_geodesic(s.shape()))?;
        let curve = call.run_any(py, move |_| {
            let manifold = Stiefel::of("S", s.as_ref())?.with_metric(metric);
            manifold.geodesic(s.as_ref(), v.as_ref())
        })?;
        Py::new(py, Self::wrap(py, curve)?)
    }

    /// Length over ``[0, 1]`` in the metric of the geodesic.
    #[getter]
    fn length(&self) -> f64 {
        self.0.length()
    }

    /// For files and pickles: all numbers of the curve.
    fn _stored<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        form(py, Geodesic::KIND, &*self.0)
    }
}

impl Operations for Geodesic {
    fn operations(&self, _: Quantity) -> f64 {
        200.0 + 160.0 * cube(self.k())
    }
}

impl PyGeodesic {
    pub(super) fn restored(py: Python<'_>, form: Form) -> PyResult<Py<PyAny>> {
        let curve = Self::wrap(py, Ok(form.curve(py)?))?;
        Ok(Py::new(py, curve)?.into_any())
    }

    fn wrap(py: Python<'_>, curve: Result<Geodesic>) -> PyResult<PyClassInitializer<Self>> {
        let curve = curve.map_err(|error| to_exception(py, &error, ""))?;
        let curve = Arc::new(curve);
        let base = PyCurve::of(Arc::clone(&curve) as Arc<dyn AnyCurve>);
        Ok(PyClassInitializer::from(base).add_subclass(PyGeodesic(curve)))
    }
}
