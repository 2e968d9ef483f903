//! The manifold for arrays, with batches.

use super::membership::core_tolerance;
use super::prelude::*;
use super::space::{Space, sizes};
use crate::linalg::structure::check_finite;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::manifold::{Metric, Stiefel};
use crate::space::Quotient;

/// Stiefel manifold St(n, k) of n x k matrices with orthonormal columns, real or complex.
///
/// Points and tangent vectors are arrays of shape ``(..., n, k)``; leading axes are batches and broadcast.
///
/// Parameters
/// ----------
/// n, k : int
///     Numbers of rows and columns, ``1 <= k <= n``.
/// metric : "canonical", "euclidean" or float, default "canonical"
///     A float is the parameter ``alpha > -1`` of the family of metrics of Hueper, Markina, Silva Leite (2021), in
///     which ``|V|^2 = |K|^2 + |Omega|^2 / (2 (alpha + 1))`` for ``V = S Omega + K``: canonical 0, Euclidean -1/2.
/// field : "real" or "complex", default "real"
///     With ``"complex"``, frames satisfy ``S^H S = I`` (the unitary group for ``k = n``), and methods take and return
///     complex arrays. In all formulas the transpose is the conjugate transpose, and inner products are real parts.
///
/// Raises
/// ------
/// InvalidInputError
///     ``k`` outside ``1 <= k <= n``, or unknown metric or field. Methods raise it for arrays of a wrong shape,
///     non-finite entries, points that are not orthonormal and vectors that are not tangent; the message states the
///     measured defect and the member of the batch.
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
pub struct PyStiefel {
    /// The manifold on which the core computes; complex frames are embedded in real ones.
    embedded: Stiefel,
    pub(super) field: Field,
}

impl Space for PyStiefel {
    type Core = Stiefel;

    const NAME: &'static str = "Stiefel";

    const QUOTIENT: Quotient = Quotient::Frames;

    fn core(&self) -> Stiefel {
        self.embedded
    }

    fn core_shape(&self) -> (usize, usize) {
        (self.embedded.n(), self.embedded.k())
    }

    fn field(&self) -> Field {
        self.field
    }

    fn nearest(&self, Y: &Any) -> PyResult<Numbers> {
        self.project(Y)
    }

    fn tangent_part(&self, S: &Any, Z: &Any) -> PyResult<Numbers> {
        self.project_tangent(S, Z)
    }
}

fn check(m: &Stiefel, s: MatRef<'_, f64>) -> Result<()> {
    m.check_point("S", s, POINT_TOLERANCE)
}

fn check_vector(m: &Stiefel, name: &'static str, [s, v]: [MatRef<'_, f64>; 2]) -> Result<()> {
    m.check_tangent(name, s, v, TANGENT_TOLERANCE)
}

/// Reads "canonical", "euclidean", or the parameter of the family.
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

impl PyStiefel {
    /// Checks points against a tolerance.
    fn point_check(
        &self,
    ) -> impl Fn(&Stiefel, [MatRef<'_, f64>; 1], [f64; 2]) -> Result<()> + Shared + use<> {
        let unit = self.field.length(1.0);
        move |m, [s], [atol, _]| m.check_point("S", s, atol / unit)
    }

    /// Checks tangent vectors against a tolerance.
    fn vector_check(
        &self,
    ) -> impl Fn(&Stiefel, [MatRef<'_, f64>; 2], [f64; 2]) -> Result<()> + Shared + use<> {
        let unit = self.field.length(1.0);
        move |m, [s, v], [atol, of_points]| {
            m.check_point("S", s, of_points / unit)?;
            m.check_tangent("V", s, v, core_tolerance(atol, unit, v))
        }
    }

    /// The manifold, with the canonical metric, for points of the core.
    pub(super) fn of_core((rows, cols): (usize, usize), field: Field) -> PyResult<Self> {
        let embedded = Stiefel::new(rows, cols)?;
        Ok(PyStiefel { embedded, field })
    }
}

#[pymethods]
impl PyStiefel {
    #[new]
    #[pyo3(signature = (n, k, *, metric=None, field="real"))]
    fn new(n: i64, k: i64, metric: Option<&Any>, field: &str) -> PyResult<Self> {
        let field = Field::from_word(field)?;
        let manifold = sizes("St", (n, k), field, Stiefel::new)?;
        let metric = metric.map_or(Ok(Metric::CANONICAL), read_metric)?;
        Ok(PyStiefel {
            embedded: manifold.with_metric(metric),
            field,
        })
    }

    /// Number of rows of a point.
    #[getter]
    fn n(&self) -> usize {
        self.shape().0
    }

    /// Number of columns of a point.
    #[getter]
    fn k(&self) -> usize {
        self.shape().1
    }

    /// Field of the entries: "real" or "complex".
    #[getter]
    fn field(&self) -> &'static str {
        self.field.word()
    }

    /// Parameter of the metric: 0 for the canonical, -1/2 for the Euclidean metric.
    #[getter]
    fn alpha(&self) -> f64 {
        self.embedded.metric().alpha()
    }

    /// Real dimension of the manifold: ``n k - k (k + 1) / 2``, for complex frames ``2 n k - k^2``.
    #[getter]
    fn dim(&self) -> usize {
        let (n, k) = self.shape();
        match self.field {
            Field::Real => self.embedded.dim(),
            Field::Complex => k * (2 * n - k),
        }
    }

    fn __repr__(&self) -> String {
        let (n, k) = self.shape();
        let metric = match self.embedded.metric() {
            Metric::CANONICAL => String::new(),
            Metric::EUCLIDEAN => ", metric='euclidean'".to_owned(),
            metric => format!(", metric={:?}", metric.alpha()),
        };
        let field = match self.field {
            Field::Real => "",
            Field::Complex => ", field='complex'",
        };
        format!("Stiefel({n}, {k}{metric}{field})")
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, this) = (slf.py(), slf.get());
        let keywords = [("metric", this.alpha())].into_py_dict(py)?;
        if this.field == Field::Complex {
            keywords.set_item("field", this.field.word())?;
        }
        // `functools.partial` carries the keywords through pickling.
        let partial = py.import("functools")?.getattr("partial")?;
        let build = partial.call((slf.get_type(),), Some(&keywords))?;
        (build, this.shape()).into_pyobject(py)
    }

    /// Raise unless every member of ``S`` is a point: ``|S^T S - I| <= atol`` (Frobenius norm).
    ///
    /// The default of ``atol`` is 1e-9, for arrays in single precision 1e-5.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     A member is not a point; the message states the measured defect.
    #[pyo3(signature = (S, atol=None))]
    fn check_point(&self, S: &Any, atol: Option<f64>) -> PyResult<()> {
        self.check(named![S], atol, self.point_check())
    }

    /// Raise unless every member of ``V`` is tangent at ``S``: ``|S^T V + V^T S| / 2 <= atol max(1, |V|)``.
    ///
    /// The default of ``atol`` is 1e-9, for arrays in single precision 1e-5.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     A member is not tangent; the message states the measured defect.
    #[pyo3(signature = (S, V, atol=None))]
    fn check_tangent(&self, S: &Any, V: &Any, atol: Option<f64>) -> PyResult<()> {
        self.check(named![S, V], atol, self.vector_check())
    }

    /// Return whether ``S`` is a point, by the criterion of :meth:`check_point`; shape (...).
    ///
    /// Returns
    /// -------
    /// bool, or ndarray of bool
    ///     False for entries that are not finite.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(3, 2)
    /// >>> bool(M.is_point(np.eye(3, 2))), bool(M.is_point(np.ones((3, 2))))
    /// (True, False)
    #[pyo3(signature = (S, atol=None))]
    fn is_point(&self, S: &Any, atol: Option<f64>) -> PyResult<Numbers> {
        self.are(named![S], atol, self.point_check())
    }

    /// Return whether ``V`` is tangent at ``S``, by the criterion of :meth:`check_tangent`; shape (...).
    ///
    /// Returns
    /// -------
    /// bool, or ndarray of bool
    ///     False for entries that are not finite, and if ``S`` is not a point.
    #[pyo3(signature = (S, V, atol=None))]
    fn is_tangent(&self, S: &Any, V: &Any, atol: Option<f64>) -> PyResult<Numbers> {
        self.are(named![S, V], atol, self.vector_check())
    }

    /// Draw uniformly distributed points (Haar measure), shape ``size + (n, k)``.
    ///
    /// Parameters
    /// ----------
    /// rng : numpy.random.Generator or seed, optional
    ///     Generator, or seed for `numpy.random.default_rng`.
    /// size : int or tuple of int, optional
    ///     Leading axes; by default a single point.
    #[pyo3(signature = (rng=None, size=None))]
    fn random_point(
        &self,
        py: Python<'_>,
        rng: Option<&Any>,
        size: Option<&Any>,
    ) -> PyResult<Numbers> {
        self.random_points(py, rng, size)
    }

    /// Draw tangent vectors at ``S``, projections of standard normal matrices; shape of ``S``.
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// rng : numpy.random.Generator or seed, optional
    ///     Generator, or seed for `numpy.random.default_rng`. The vectors are independent of ``S`` even if ``S`` was
    ///     drawn with the same seed, or by a generator in the same state.
    #[pyo3(signature = (S, rng=None))]
    fn random_tangent(&self, S: &Any, rng: Option<&Any>) -> PyResult<Numbers> {
        self.random_tangents((S, "S"), rng)
    }

    /// Return the nearest point in the Frobenius norm, the polar factor of ``Y``, shape (..., n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``Y`` does not have full column rank (the message states its smallest singular value), or is not finite.
    fn project(&self, Y: &Any) -> PyResult<Numbers> {
        self.map_any(named![Y], |m, [y]| m.project(y))
    }

    /// Project ``Z`` orthogonally to the tangent space at ``S``: ``Z - S sym(S^T Z)``, shape (..., n, k).
    fn project_tangent(&self, S: &Any, Z: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![S, Z], |m, [s, z]| {
            check(m, s)?;
            check_finite("Z", z)?;
            m.project_tangent(s, z)
        })
    }

    /// Return the inner product of tangent vectors at ``S`` in the manifold's metric, shape (...).
    ///
    /// For the canonical metric, ``tr V^T (I - S S^T / 2) W``.
    fn inner(&self, S: &Any, V: &Any, W: &Any) -> PyResult<Numbers> {
        self.map_numbers(named![S, V, W], Field::squared, |m, [s, v, w], _| {
            check(m, s)?;
            check_vector(m, "V", [s, v])?;
            check_vector(m, "W", [s, w])?;
            m.inner(s, v, w)
        })
    }

    /// Return the norm of a tangent vector at ``S`` in the manifold's metric, shape (...).
    fn norm(&self, S: &Any, V: &Any) -> PyResult<Numbers> {
        self.map_numbers(named![S, V], Field::length, |m, [s, v], _| {
            check(m, s)?;
            check_vector(m, "V", [s, v])?;
            m.norm(s, v)
        })
    }

    /// Return the pair ``(X, Omega)`` that represents a tangent vector, ``V = X S + S Omega``.
    ///
    /// The parametrisation of arXiv 2404.19407.
    ///
    /// Returns
    /// -------
    /// X : ndarray, shape (..., n, n)
    ///     ``V S^T - S V^T + 2 S V^T S S^T``, skew-symmetric.
    /// Omega : ndarray, shape (..., k, k)
    ///     ``S^T V``, skew-symmetric.
    fn decompose(&self, S: &Any, V: &Any) -> PyResult<(Numbers, Numbers)> {
        let (n, k) = (self.embedded.n(), self.embedded.k());
        let pair = |m: &Stiefel, [s, v]: [MatRef<'_, f64>; 2]| {
            check(m, s)?;
            check_vector(m, "V", [s, v])?;
            m.decompose(s, v)
        };
        let x = self.map(named![S, V], &[n, n], move |m, b, _| Ok(pair(m, b)?.0))?;
        let omega = self.map(named![S, V], &[k, k], move |m, b, _| Ok(pair(m, b)?.1))?;
        let [x, omega] =
            collected([x, omega].map(|part| self.field.numbers(part)?.like(named![S, V])))?;
        Ok((x, omega))
    }

    /// Return the tangent vector ``V = X S + S Omega`` of a pair of :meth:`decompose`, shape (..., n, k).
    fn compose(&self, S: &Any, X: &Any, Omega: &Any) -> PyResult<Numbers> {
        let (n, k) = self.shape();
        let core = [self.embedded.n(), self.embedded.k()];
        let (data, shapes) = (named![S, X, Omega], [(n, k), (n, n), (k, k)]);
        let found = self.map_shapes(
            data,
            shapes,
            |_| 1.0,
            &core,
            |m, [s, x, omega], _| {
                check(m, s)?;
                check_finite("X", x)?;
                check_finite("Omega", omega)?;
                m.compose(s, x, omega)
            },
        )?;
        self.field.numbers(found)?.like(data)
    }
}
