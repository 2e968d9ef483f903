//! The manifold for arrays, with batches.

use numpy::PyArrayDyn;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::call::Call;
use super::convert::{Batch, map_batch, matrices, to_array, write};
use super::error::{invalid_input, to_exception};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::manifold::{Metric, Stiefel};

/// Operations that the time of the smallest problem is worth, a few microseconds of set-up.
const SMALLEST: f64 = 1e4;

pub(super) type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// The Stiefel manifold St(n, k) of n x k matrices with orthonormal columns.
///
/// Points and tangent vectors are arrays of shape ``(..., n, k)``; leading axes are batches and broadcast.
///
/// Parameters
/// ----------
/// n, k : int
///     ``1 <= k <= n``.
/// metric : "canonical", "euclidean" or float, default "canonical"
///     A float is the parameter ``alpha > -1`` of the family of Hueper, Markina, Silva Leite (2021), in which
///     ``|V|^2 = |K|^2 + |Omega|^2 / (2 (alpha + 1))`` for ``V = S Omega + K``: canonical 0, Euclidean -1/2.
///
/// Raises
/// ------
/// InvalidInputError
///     Unless ``1 <= k <= n`` and the metric is one of these.
///
/// Examples
/// --------
/// >>> from stiefel_rs import Stiefel
/// >>> M = Stiefel(5, 2)
/// >>> M.dim
/// 7
/// >>> S = M.random_point(rng=0)
/// >>> V = M.random_tangent(S, rng=1)
/// >>> bool(abs(M.inverse_retract(S, M.retract(S, 0.1 * V)) - 0.1 * V).max() < 1e-14)
/// True
#[pyclass(name = "Stiefel", module = "stiefel_rs", frozen, eq, hash)]
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct PyStiefel(pub(super) Stiefel);

impl PyStiefel {
    pub(super) fn core_shape(&self, batch: &Batch, name: &str, py: Python<'_>) -> PyResult<()> {
        expect_shape(py, name, batch, (self.0.n(), self.0.k()))
    }

    /// Checks shapes, maps every member, and gives the result the trailing shape `core`.
    pub(super) fn map<'py, const N: usize>(
        &self,
        py: Python<'py>,
        objects: [(&Bound<'py, PyAny>, &'static str); N],
        core: &[usize],
        member: impl Fn(&Self, [&Batch; N], usize, &mut [f64]) -> Result<()> + Sync + Send + 'static,
    ) -> PyResult<Array<'py>> {
        self.map_weighted(py, objects, core, |_| 1.0, member)
    }

    /// As [`PyStiefel::map`] where a member takes `weight` times the usual work, by the data.
    pub(super) fn map_weighted<'py, const N: usize>(
        &self,
        py: Python<'py>,
        objects: [(&Bound<'py, PyAny>, &'static str); N],
        core: &[usize],
        weight: impl FnOnce(&[Batch; N]) -> f64,
        member: impl Fn(&Self, [&Batch; N], usize, &mut [f64]) -> Result<()> + Sync + Send + 'static,
    ) -> PyResult<Array<'py>> {
        let batches = matrices(objects)?;
        for (batch, (_, name)) in batches.iter().zip(objects) {
            self.core_shape(batch, name, py)?;
        }
        let (n, k) = (self.0.n() as f64, self.0.k() as f64);
        let call = Call::new(
            py,
            None,
            batches[0].len() as f64 * (SMALLEST + 30.0 * n * k * k) * weight(&batches),
        )?;
        let shape: Vec<usize> = batches[0].shape.iter().chain(core).copied().collect();
        let this = self.clone();
        let wrapped = move |b: [&Batch; N], i: usize, out: &mut [f64], _: Interrupt<'_>| {
            member(&this, b, i, out)
        };
        let entries = map_batch(py, &call, batches, core.iter().product(), wrapped)?;
        to_array(py, entries, &shape)
    }

    pub(super) fn check(&self, s: faer::MatRef<'_, f64>) -> Result<()> {
        self.0.check_point("S", s, POINT_TOLERANCE)
    }

    pub(super) fn check_vector(
        &self,
        name: &'static str,
        s: faer::MatRef<'_, f64>,
        v: faer::MatRef<'_, f64>,
    ) -> Result<()> {
        self.0.check_tangent(name, s, v, TANGENT_TOLERANCE)
    }

    fn tolerance(py: Python<'_>, atol: f64) -> PyResult<f64> {
        if atol >= 0.0 {
            Ok(atol)
        } else {
            Err(invalid_input(
                py,
                format!("atol: must be at least 0, found {atol}"),
            ))
        }
    }

    /// Standard normal numbers of shape `size + (n, k)` from a generator.
    fn normal<'py>(
        &self,
        generator: &Bound<'py, PyAny>,
        size: &[usize],
    ) -> PyResult<Bound<'py, PyAny>> {
        let shape: Vec<usize> = size
            .iter()
            .chain(&[self.0.n(), self.0.k()])
            .copied()
            .collect();
        let shape = PyTuple::new(generator.py(), shape)?;
        generator.call_method1("standard_normal", (shape,))
    }
}

/// What sets the streams of tangent vectors apart from others that the same numbers are the seed of: a number of its own.
const TANGENT_STREAM: u32 = 0x7461_6e67;

/// The generator of `numpy.random.default_rng`.
fn generator<'py>(py: Python<'py>, rng: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
    py.import("numpy.random")?
        .call_method1("default_rng", (rng,))
}

/// A stream that 128 random bits of a generator start. Points are made of the numbers that follow in the generator itself, so
/// that a seed, or a generator in the same state, gives tangent vectors that know nothing of the points.
fn tangent_stream<'py>(generator: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let py = generator.py();
    let random = py.import("numpy.random")?;
    let words = PyDict::new(py);
    words.set_item("dtype", "uint32")?;
    let bits = generator.call_method("integers", (0, 1_u64 << 32, 4), Some(&words))?;
    let key = PyDict::new(py);
    key.set_item("spawn_key", (TANGENT_STREAM,))?;
    let seed = random.call_method("SeedSequence", (bits,), Some(&key))?;
    random.call_method1("default_rng", (seed,))
}

/// "canonical", "euclidean", or the parameter of the family.
pub(super) fn read_metric(object: &Bound<'_, PyAny>) -> PyResult<Metric> {
    if let Ok(name) = object.extract::<String>() {
        return match name.as_str() {
            "canonical" => Ok(Metric::CANONICAL),
            "euclidean" => Ok(Metric::EUCLIDEAN),
            _ => Err(invalid_input(
                object.py(),
                format!("metric: expected 'canonical', 'euclidean' or a number, found {name:?}"),
            )),
        };
    }
    let alpha: f64 = object.extract().map_err(|_| {
        let kind = object.get_type();
        PyTypeError::new_err(format!(
            "metric: expected 'canonical', 'euclidean' or a number, found {kind}"
        ))
    })?;
    Metric::new(alpha).map_err(|error| to_exception(object.py(), &error, ""))
}

/// `InvalidInputError` unless the members of a batch have the given shape, also where there are none.
fn expect_shape(py: Python<'_>, name: &str, batch: &Batch, (n, k): (usize, usize)) -> PyResult<()> {
    let (rows, cols) = (batch.rows, batch.cols);
    if (rows, cols) == (n, k) {
        return Ok(());
    }
    let message = format!("{name}: expected shape (..., {n}, {k}), found (..., {rows}, {cols})");
    Err(invalid_input(py, message))
}

#[pymethods]
#[allow(non_snake_case)]
impl PyStiefel {
    #[new]
    #[pyo3(signature = (n, k, *, metric=None))]
    fn new(py: Python<'_>, n: i64, k: i64, metric: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let invalid = || {
            invalid_input(
                py,
                format!("St(n, k): expected 1 <= k <= n, found n = {n}, k = {k}"),
            )
        };
        let (Ok(rows), Ok(cols)) = (usize::try_from(n), usize::try_from(k)) else {
            return Err(invalid());
        };
        let metric = metric.map_or(Ok(Metric::CANONICAL), read_metric)?;
        let manifold = Stiefel::new(rows, cols).map_err(|_| invalid())?;
        Ok(PyStiefel(manifold.with_metric(metric)))
    }

    /// Rows of a point.
    #[getter]
    fn n(&self) -> usize {
        self.0.n()
    }

    /// Columns of a point.
    #[getter]
    fn k(&self) -> usize {
        self.0.k()
    }

    /// Parameter of the metric: 0 for the canonical, -1/2 for the Euclidean one.
    #[getter]
    fn alpha(&self) -> f64 {
        self.0.metric().alpha()
    }

    /// Dimension of the manifold, ``n k - k (k + 1) / 2``.
    #[getter]
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn __repr__(&self) -> String {
        let (n, k) = (self.0.n(), self.0.k());
        match self.0.metric() {
            Metric::CANONICAL => format!("Stiefel({n}, {k})"),
            Metric::EUCLIDEAN => format!("Stiefel({n}, {k}, metric='euclidean')"),
            metric => format!("Stiefel({n}, {k}, metric={:?})", metric.alpha()),
        }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, manifold) = (slf.py(), slf.get().0);
        let metric = PyDict::new(py);
        metric.set_item("metric", manifold.metric().alpha())?;
        // `functools.partial` carries the keyword through pickling.
        let partial = py.import("functools")?.getattr("partial")?;
        let build = partial.call((slf.get_type(),), Some(&metric))?;
        (build, (manifold.n(), manifold.k())).into_pyobject(py)
    }

    /// Raise unless every member of ``S`` is a point: ``|S^T S - I| <= atol`` (Frobenius), by default 1e-9.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     With the measured defect.
    #[pyo3(signature = (S, atol=POINT_TOLERANCE), text_signature = "($self, S, atol=1e-9)")]
    fn check_point<'py>(&self, py: Python<'py>, S: &Bound<'py, PyAny>, atol: f64) -> PyResult<()> {
        let atol = Self::tolerance(py, atol)?;
        self.map(py, [(S, "S")], &[0], move |m, [s], i, _| {
            m.0.check_point("S", s.get(i), atol)
        })
        .map(|_| ())
    }

    /// Raise unless every member of ``V`` is tangent at ``S``: ``|S^T V + V^T S| / 2 <= atol max(1, |V|)``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     With the measured defect.
    #[pyo3(signature = (S, V, atol=TANGENT_TOLERANCE), text_signature = "($self, S, V, atol=1e-9)")]
    fn check_tangent<'py>(
        &self,
        py: Python<'py>,
        S: &Bound<'py, PyAny>,
        V: &Bound<'py, PyAny>,
        atol: f64,
    ) -> PyResult<()> {
        let atol = Self::tolerance(py, atol)?;
        let member = move |m: &Self, [s, v]: [&Batch; 2], i: usize, _: &mut [f64]| {
            m.check(s.get(i))?;
            m.0.check_tangent("V", s.get(i), v.get(i), atol)
        };
        self.map(py, [(S, "S"), (V, "V")], &[0], member).map(|_| ())
    }

    /// Uniformly distributed points (Haar measure), shape ``size + (n, k)``.
    ///
    /// Parameters
    /// ----------
    /// rng : numpy.random.Generator or seed, optional
    ///     What `numpy.random.default_rng` takes.
    /// size : int or tuple of int, optional
    ///     Leading axes; a single point by default.
    #[pyo3(signature = (rng=None, size=None))]
    fn random_point<'py>(
        &self,
        py: Python<'py>,
        rng: Option<&Bound<'py, PyAny>>,
        size: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let size: Vec<usize> = match size {
            None => Vec::new(),
            Some(size) => {
                let axes: Vec<i64> = size
                    .extract()
                    .map(|one| vec![one])
                    .or_else(|_| size.extract())?;
                let invalid =
                    || invalid_input(py, format!("size: axes must be at least 0, found {size}"));
                axes.into_iter()
                    .map(|axis| usize::try_from(axis).map_err(|_| invalid()))
                    .collect::<PyResult<_>>()?
            }
        };
        let normal = self.normal(&generator(py, rng)?, &size)?;
        self.project(py, &normal)
    }

    /// Normally distributed tangent vectors at ``S``: standard normal matrices, projected. Shape of ``S``.
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// rng : numpy.random.Generator or seed, optional
    ///     What `numpy.random.default_rng` takes. The vectors are independent of ``S``, also where ``S`` is made with the same
    ///     seed, or by a generator in the same state.
    #[pyo3(signature = (S, rng=None))]
    fn random_tangent<'py>(
        &self,
        py: Python<'py>,
        S: &Bound<'py, PyAny>,
        rng: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let [points] = matrices([(S, "S")])?;
        self.core_shape(&points, "S", py)?;
        let stream = tangent_stream(&generator(py, rng)?)?;
        let normal = self.normal(&stream, &points.shape)?;
        self.project_tangent(py, S, &normal)
    }

    /// Nearest point in the Frobenius norm: the polar factor of ``Y``, shape (..., n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``Y`` has no full column rank (with its smallest singular value), or is not finite.
    fn project<'py>(&self, py: Python<'py>, Y: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        self.map(
            py,
            [(Y, "Y")],
            &[self.0.n(), self.0.k()],
            move |m, [y], i, out| {
                write(m.0.project(y.get(i))?.as_ref(), out);
                Ok(())
            },
        )
    }

    /// Orthogonal projection ``Z - S sym(S^T Z)`` on the tangent space at ``S``, shape (..., n, k).
    fn project_tangent<'py>(
        &self,
        py: Python<'py>,
        S: &Bound<'py, PyAny>,
        Z: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        self.map(
            py,
            [(S, "S"), (Z, "Z")],
            &[self.0.n(), self.0.k()],
            move |m, [s, z], i, out| {
                m.check(s.get(i))?;
                crate::linalg::structure::check_finite("Z", z.get(i))?;
                write(m.0.project_tangent(s.get(i), z.get(i))?.as_ref(), out);
                Ok(())
            },
        )
    }

    /// Inner product of tangent vectors at ``S`` in the manifold's metric, shape (...); canonical:
    /// ``tr V^T (I - S S^T / 2) W``.
    fn inner<'py>(
        &self,
        py: Python<'py>,
        S: &Bound<'py, PyAny>,
        V: &Bound<'py, PyAny>,
        W: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let values = self.map(
            py,
            [(S, "S"), (V, "V"), (W, "W")],
            &[1],
            move |m, [s, v, w], i, out| {
                m.check(s.get(i))?;
                m.check_vector("V", s.get(i), v.get(i))?;
                m.check_vector("W", s.get(i), w.get(i))?;
                out[0] = m.0.inner(s.get(i), v.get(i), w.get(i))?;
                Ok(())
            },
        )?;
        values.get_item((pyo3::types::PyEllipsis::get(py), 0))
    }

    /// Norm of a tangent vector at ``S`` in the manifold's metric, shape (...).
    fn norm<'py>(
        &self,
        py: Python<'py>,
        S: &Bound<'py, PyAny>,
        V: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let values = self.map(py, [(S, "S"), (V, "V")], &[1], move |m, [s, v], i, out| {
            m.check(s.get(i))?;
            m.check_vector("V", s.get(i), v.get(i))?;
            out[0] = m.0.norm(s.get(i), v.get(i))?;
            Ok(())
        })?;
        values.get_item((pyo3::types::PyEllipsis::get(py), 0))
    }

    /// The paper's pair ``(X, Omega)`` of a tangent vector, ``V = X S + S Omega``.
    ///
    /// Returns
    /// -------
    /// X : ndarray, shape (..., n, n)
    ///     ``V S^T - S V^T + 2 S V^T S S^T``, skew-symmetric.
    /// Omega : ndarray, shape (..., k, k)
    ///     ``S^T V``, skew-symmetric.
    fn decompose<'py>(
        &self,
        py: Python<'py>,
        S: &Bound<'py, PyAny>,
        V: &Bound<'py, PyAny>,
    ) -> PyResult<(Array<'py>, Array<'py>)> {
        let (n, k) = (self.0.n(), self.0.k());
        let pair = |m: &Self, [s, v]: [&Batch; 2], i: usize| {
            m.check(s.get(i))?;
            m.check_vector("V", s.get(i), v.get(i))?;
            m.0.decompose(s.get(i), v.get(i))
        };
        let x = self.map(py, [(S, "S"), (V, "V")], &[n, n], move |m, b, i, out| {
            write(pair(m, b, i)?.0.as_ref(), out);
            Ok(())
        })?;
        let omega = self.map(py, [(S, "S"), (V, "V")], &[k, k], move |m, b, i, out| {
            write(pair(m, b, i)?.1.as_ref(), out);
            Ok(())
        })?;
        Ok((x, omega))
    }

    /// The tangent vector ``V = X S + S Omega`` of the paper's pair, shape (..., n, k).
    fn compose<'py>(
        &self,
        py: Python<'py>,
        S: &Bound<'py, PyAny>,
        X: &Bound<'py, PyAny>,
        Omega: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let [s, x, omega] = matrices([(S, "S"), (X, "X"), (Omega, "Omega")])?;
        self.core_shape(&s, "S", py)?;
        let (n, k) = (self.0.n(), self.0.k());
        expect_shape(py, "X", &x, (n, n))?;
        expect_shape(py, "Omega", &omega, (k, k))?;
        let shape: Vec<usize> = s.shape.iter().chain(&[n, k]).copied().collect();
        let call = Call::new(py, None, s.len() as f64 * (n * n * k) as f64)?;
        let this = self.clone();
        let member =
            move |[s, x, omega]: [&Batch; 3], i: usize, out: &mut [f64], _: Interrupt<'_>| {
                this.check(s.get(i))?;
                crate::linalg::structure::check_finite("X", x.get(i))?;
                crate::linalg::structure::check_finite("Omega", omega.get(i))?;
                let v = this.0.compose(s.get(i), x.get(i), omega.get(i))?;
                write(v.as_ref(), out);
                Ok(())
            };
        to_array(
            py,
            map_batch(py, &call, [s, x, omega], n * k, member)?,
            &shape,
        )
    }
}
