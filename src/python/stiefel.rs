//! The manifold for arrays, with batches.

use super::prelude::*;
use super::space::{Space, sizes};
use crate::linalg::structure::check_finite;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::manifold::{Metric, Stiefel};

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
///     Unless ``1 <= k <= n`` and the metric is one of these. Methods raise it for arrays of another shape, numbers that are
///     not finite, points that are not orthonormal and vectors that are not tangent, with the measured defect and the
///     member of the batch.
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

impl Space for PyStiefel {
    type Core = Stiefel;

    fn core(&self) -> Stiefel {
        self.0
    }

    fn shape(&self) -> (usize, usize) {
        (self.0.n(), self.0.k())
    }

    fn nearest(&self, Y: &Any) -> PyResult<Array> {
        self.project(Y)
    }

    fn tangent_part(&self, S: &Any, Z: &Any) -> PyResult<Array> {
        self.project_tangent(S, Z)
    }
}

fn check(m: &Stiefel, s: MatRef<'_, f64>) -> Result<()> {
    m.check_point("S", s, POINT_TOLERANCE)
}

fn check_vector(m: &Stiefel, name: &'static str, [s, v]: [MatRef<'_, f64>; 2]) -> Result<()> {
    m.check_tangent(name, s, v, TANGENT_TOLERANCE)
}

/// "canonical", "euclidean", or the parameter of the family.
pub(super) fn read_metric(object: &Any) -> PyResult<Metric> {
    let expected = "metric: expected 'canonical', 'euclidean' or a number, found";
    if let Ok(name) = object.extract::<String>() {
        return match name.as_str() {
            "canonical" => Ok(Metric::CANONICAL),
            "euclidean" => Ok(Metric::EUCLIDEAN),
            _ => Err(invalid!("{expected} {name:?}")),
        };
    }
    let Ok(alpha) = object.extract() else {
        let kind = object.get_type();
        return Err(PyTypeError::new_err(format!("{expected} {kind}")));
    };
    Ok(Metric::new(alpha)?)
}

#[pymethods]
impl PyStiefel {
    #[new]
    #[pyo3(signature = (n, k, *, metric=None))]
    fn new(n: i64, k: i64, metric: Option<&Any>) -> PyResult<Self> {
        let manifold = sizes("St", (n, k), Stiefel::new)?;
        let metric = metric.map_or(Ok(Metric::CANONICAL), read_metric)?;
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
        let metric = [("metric", manifold.metric().alpha())].into_py_dict(py)?;
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
    fn check_point(&self, S: &Any, atol: f64) -> PyResult<()> {
        ensure!(atol >= 0.0, "atol: must be at least 0, found {atol}");
        self.map(named![S], &[], move |m, [s], _| m.check_point("S", s, atol))?;
        Ok(())
    }

    /// Raise unless every member of ``V`` is tangent at ``S``: ``|S^T V + V^T S| / 2 <= atol max(1, |V|)``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     With the measured defect.
    #[pyo3(signature = (S, V, atol=TANGENT_TOLERANCE), text_signature = "($self, S, V, atol=1e-9)")]
    fn check_tangent(&self, S: &Any, V: &Any, atol: f64) -> PyResult<()> {
        ensure!(atol >= 0.0, "atol: must be at least 0, found {atol}");
        self.map(named![S, V], &[], move |m, [s, v], _| {
            check(m, s)?;
            m.check_tangent("V", s, v, atol)
        })?;
        Ok(())
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
    fn random_point(
        &self,
        py: Python<'_>,
        rng: Option<&Any>,
        size: Option<&Any>,
    ) -> PyResult<Array> {
        self.random_points(py, rng, size)
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
    fn random_tangent(&self, S: &Any, rng: Option<&Any>) -> PyResult<Array> {
        self.random_tangents((S, "S"), rng)
    }

    /// Nearest point in the Frobenius norm: the polar factor of ``Y``, shape (..., n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``Y`` has no full column rank (with its smallest singular value), or is not finite.
    fn project(&self, Y: &Any) -> PyResult<Array> {
        self.map_matrices(named![Y], |m, [y]| m.project(y))
    }

    /// Orthogonal projection ``Z - S sym(S^T Z)`` on the tangent space at ``S``, shape (..., n, k).
    fn project_tangent(&self, S: &Any, Z: &Any) -> PyResult<Array> {
        self.map_matrices(named![S, Z], |m, [s, z]| {
            check(m, s)?;
            check_finite("Z", z)?;
            m.project_tangent(s, z)
        })
    }

    /// Inner product of tangent vectors at ``S`` in the manifold's metric, shape (...); canonical:
    /// ``tr V^T (I - S S^T / 2) W``.
    fn inner(&self, S: &Any, V: &Any, W: &Any) -> PyResult<Array> {
        self.map(named![S, V, W], &[], |m, [s, v, w], _| {
            check(m, s)?;
            check_vector(m, "V", [s, v])?;
            check_vector(m, "W", [s, w])?;
            m.inner(s, v, w)
        })
    }

    /// Norm of a tangent vector at ``S`` in the manifold's metric, shape (...).
    fn norm(&self, S: &Any, V: &Any) -> PyResult<Array> {
        self.map(named![S, V], &[], |m, [s, v], _| {
            check(m, s)?;
            check_vector(m, "V", [s, v])?;
            m.norm(s, v)
        })
    }

    /// The paper's pair ``(X, Omega)`` of a tangent vector, ``V = X S + S Omega``.
    ///
    /// Returns
    /// -------
    /// X : ndarray, shape (..., n, n)
    ///     ``V S^T - S V^T + 2 S V^T S S^T``, skew-symmetric.
    /// Omega : ndarray, shape (..., k, k)
    ///     ``S^T V``, skew-symmetric.
    fn decompose(&self, S: &Any, V: &Any) -> PyResult<(Array, Array)> {
        let (n, k) = self.shape();
        let pair = |m: &Stiefel, [s, v]: [MatRef<'_, f64>; 2]| {
            check(m, s)?;
            check_vector(m, "V", [s, v])?;
            m.decompose(s, v)
        };
        let x = self.map(named![S, V], &[n, n], move |m, b, _| Ok(pair(m, b)?.0))?;
        let omega = self.map(named![S, V], &[k, k], move |m, b, _| Ok(pair(m, b)?.1))?;
        Ok((x, omega))
    }

    /// The tangent vector ``V = X S + S Omega`` of the paper's pair, shape (..., n, k).
    fn compose(&self, S: &Any, X: &Any, Omega: &Any) -> PyResult<Array> {
        let (n, k) = self.shape();
        let (data, shapes) = (named![S, X, Omega], [(n, k), (n, n), (k, k)]);
        self.map_shapes(
            data,
            shapes,
            |_| 1.0,
            &[n, k],
            |m, [s, x, omega], _| {
                check(m, s)?;
                check_finite("X", x)?;
                check_finite("Omega", omega)?;
                m.compose(s, x, omega)
            },
        )
    }
}
