//! The Grassmann manifold for arrays, with batches.

use super::membership::core_tolerance;
use super::prelude::*;
use super::space::{Space, sizes};
use crate::manifold::Grassmann;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::space::Quotient;

/// Grassmann manifold Gr(n, k) of k-dimensional subspaces of R^n or C^n.
///
/// A point is represented by an orthonormal basis ``Y``, an array of shape ``(..., n, k)``; all bases of a subspace
/// represent the same point. Tangent vectors at ``Y`` are horizontal: matrices ``V`` of the same shape with
/// ``Y^T V = 0``, of length ``|V|`` (Frobenius norm). A tangent vector depends on the basis: ``V`` at ``Y`` is ``V Q``
/// at ``Y Q``. Leading axes are batches and broadcast.
///
/// Parameters
/// ----------
/// n, k : int
///     Dimensions of the space and of the subspaces, ``1 <= k <= n``.
/// field : "real" or "complex", default "real"
///     With ``"complex"``, subspaces of C^n; methods take and return complex arrays. In all formulas the transpose is
///     the conjugate transpose, and inner products are real parts. For ``k = 1`` the points are the states of quantum
///     mechanics: ``Grassmann(2, 1, field="complex")`` is the sphere of radius 1/2.
///
/// Raises
/// ------
/// InvalidInputError
///     ``k`` outside ``1 <= k <= n``, or unknown field. Methods raise it for arrays of a wrong shape, non-finite
///     entries, bases that are not orthonormal and vectors that are not horizontal; the message states the measured
///     defect and the member of the batch.
///
/// References
/// ----------
/// Edelman, Arias, Smith (1998), section 2.5; Bendokat, Zimmermann, Absil (2024), "A Grassmann manifold handbook".
///
/// Examples
/// --------
/// >>> from stiefel_rs import Grassmann
/// >>> M = Grassmann(5, 2)
/// >>> M.dim
/// 6
/// >>> Y = M.random_point(rng=0)
/// >>> V = 0.3 * M.random_tangent(Y, rng=1)
/// >>> bool(abs(M.log(Y, M.exp(Y, V)) - V).max() < 1e-13)
/// True
#[pyclass(name = "Grassmann", module = "stiefel_rs", frozen, eq, hash)]
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct PyGrassmann {
    /// The manifold on which the core computes; complex bases are embedded in real ones.
    embedded: Grassmann,
    field: Field,
}

impl Space for PyGrassmann {
    type Core = Grassmann;

    const NAME: &'static str = "Grassmann";

    const QUOTIENT: Quotient = Quotient::Subspaces;

    fn core(&self) -> Grassmann {
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
        self.map_matrices([(S, "Y"), (Z, "Z")], |m, [y, z]| {
            check(m, y)?;
            m.project_tangent(y, z)
        })
    }
}

fn check(m: &Grassmann, y: MatRef<'_, f64>) -> Result<()> {
    m.check_point("Y", y, POINT_TOLERANCE)
}

fn check_vector(m: &Grassmann, name: &'static str, [y, v]: [MatRef<'_, f64>; 2]) -> Result<()> {
    m.check_tangent(name, y, v, TANGENT_TOLERANCE)
}

/// The angles as one row.
fn row(angles: &[f64]) -> Mat<f64> {
    Mat::from_fn(1, angles.len(), |_, j| angles[j])
}

impl PyGrassmann {
    /// The manifold for points of the core.
    pub(super) fn of_core((rows, cols): (usize, usize), field: Field) -> PyResult<Self> {
        let embedded = Grassmann::new(rows, cols)?;
        Ok(PyGrassmann { embedded, field })
    }
}

impl PyGrassmann {
    /// Checks bases against a tolerance.
    fn basis_check(
        &self,
    ) -> impl Fn(&Grassmann, [MatRef<'_, f64>; 1], [f64; 2]) -> Result<()> + Shared + use<> {
        let unit = self.field.length(1.0);
        move |m, [y], [atol, _]| m.check_point("Y", y, atol / unit)
    }

    /// Checks horizontal vectors against a tolerance.
    fn horizontal_check(
        &self,
    ) -> impl Fn(&Grassmann, [MatRef<'_, f64>; 2], [f64; 2]) -> Result<()> + Shared + use<> {
        let unit = self.field.length(1.0);
        move |m, [y, v], [atol, of_points]| {
            m.check_point("Y", y, of_points / unit)?;
            m.check_tangent("V", y, v, core_tolerance(atol, unit, v))
        }
    }
}

#[pymethods]
impl PyGrassmann {
    #[new]
    #[pyo3(signature = (n, k, *, field="real"))]
    fn new(n: i64, k: i64, field: &str) -> PyResult<Self> {
        let field = Field::from_word(field)?;
        let embedded = sizes("Gr", (n, k), field, Grassmann::new)?;
        Ok(PyGrassmann { embedded, field })
    }

    /// Field of the entries: "real" or "complex".
    #[getter(field)]
    fn word(&self) -> &'static str {
        self.field.word()
    }

    /// Dimension of the ambient space: number of rows of a basis.
    #[getter]
    fn n(&self) -> usize {
        self.shape().0
    }

    /// Dimension of the subspaces: number of columns of a basis.
    #[getter]
    fn k(&self) -> usize {
        self.shape().1
    }

    /// Real dimension of the manifold: ``k (n - k)``, for complex subspaces ``2 k (n - k)``.
    #[getter]
    fn dim(&self) -> usize {
        let (n, k) = self.shape();
        self.field.embedded(k * (n - k))
    }

    fn __repr__(&self) -> String {
        let (n, k) = self.shape();
        match self.field {
            Field::Real => format!("Grassmann({n}, {k})"),
            Field::Complex => format!("Grassmann({n}, {k}, field='complex')"),
        }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, manifold) = (slf.py(), slf.get());
        let field = [("field", manifold.field.word())].into_py_dict(py)?;
        // `functools.partial` carries the keyword through pickling.
        let partial = py.import("functools")?.getattr("partial")?;
        let build = partial.call((slf.get_type(),), Some(&field))?;
        (build, manifold.shape()).into_pyobject(py)
    }

    /// Raise unless every member of ``Y`` is an orthonormal basis: ``|Y^T Y - I| <= atol`` (Frobenius norm).
    ///
    /// The default of ``atol`` is 1e-9, for arrays in single precision 1e-5.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     A member is not orthonormal; the message states the measured defect.
    #[pyo3(signature = (Y, atol=None))]
    fn check_point(&self, Y: &Any, atol: Option<f64>) -> PyResult<()> {
        self.check(named![Y], atol, self.basis_check())
    }

    /// Raise unless every member of ``V`` is horizontal at ``Y``: ``|Y^T V| <= atol max(1, |V|)``.
    ///
    /// The default of ``atol`` is 1e-9, for arrays in single precision 1e-5.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     A member is not horizontal; the message states the measured defect.
    #[pyo3(signature = (Y, V, atol=None))]
    fn check_tangent(&self, Y: &Any, V: &Any, atol: Option<f64>) -> PyResult<()> {
        self.check(named![Y, V], atol, self.horizontal_check())
    }

    /// Return whether ``Y`` is an orthonormal basis, by the criterion of :meth:`check_point`; shape (...).
    ///
    /// Returns
    /// -------
    /// bool, or ndarray of bool
    ///     False for entries that are not finite.
    #[pyo3(signature = (Y, atol=None))]
    fn is_point(&self, Y: &Any, atol: Option<f64>) -> PyResult<Numbers> {
        self.are(named![Y], atol, self.basis_check())
    }

    /// Return whether ``V`` is horizontal at ``Y``, by the criterion of :meth:`check_tangent`; shape (...).
    ///
    /// Returns
    /// -------
    /// bool, or ndarray of bool
    ///     False for entries that are not finite, and if ``Y`` is not an orthonormal basis.
    #[pyo3(signature = (Y, V, atol=None))]
    fn is_tangent(&self, Y: &Any, V: &Any, atol: Option<f64>) -> PyResult<Numbers> {
        self.are(named![Y, V], atol, self.horizontal_check())
    }

    /// Draw bases of uniformly distributed subspaces (Haar measure), shape ``size + (n, k)``.
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

    /// Draw tangent vectors at ``Y``, projections of standard normal matrices; shape of ``Y``.
    ///
    /// Parameters
    /// ----------
    /// Y : array_like, shape (..., n, k)
    ///     Points.
    /// rng : numpy.random.Generator or seed, optional
    ///     Generator, or seed for `numpy.random.default_rng`. The vectors are independent of ``Y`` even if ``Y`` was
    ///     drawn with the same seed, or by a generator in the same state.
    #[pyo3(signature = (Y, rng=None))]
    fn random_tangent(&self, Y: &Any, rng: Option<&Any>) -> PyResult<Numbers> {
        self.random_tangents((Y, "Y"), rng)
    }

    /// Return the orthonormal basis of the column space of ``Y`` nearest to ``Y``, shape (..., n, k).
    ///
    /// This is the polar factor of ``Y``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``Y`` does not have full column rank (the message states its smallest singular value), or is not finite.
    fn project(&self, Y: &Any) -> PyResult<Numbers> {
        self.map_any(named![Y], |m, [y]| m.project(y))
    }

    /// Project ``Z`` orthogonally to the tangent space at ``Y``: ``Z - Y Y^T Z``, shape (..., n, k).
    fn project_tangent(&self, Y: &Any, Z: &Any) -> PyResult<Numbers> {
        self.tangent_part(Y, Z)
    }

    /// Return the inner product ``Re tr V^H W`` of tangent vectors at ``Y``, shape (...).
    fn inner(&self, Y: &Any, V: &Any, W: &Any) -> PyResult<Numbers> {
        self.map_numbers(named![Y, V, W], Field::squared, |m, [y, v, w], _| {
            check(m, y)?;
            check_vector(m, "V", [y, v])?;
            check_vector(m, "W", [y, w])?;
            m.inner(y, v, w)
        })
    }

    /// Return the norm of a tangent vector at ``Y``: ``|V|`` (Frobenius norm), shape (...).
    fn norm(&self, Y: &Any, V: &Any) -> PyResult<Numbers> {
        self.map_numbers(named![Y, V], Field::length, |m, [y, v], _| {
            check(m, y)?;
            check_vector(m, "V", [y, v])?;
            m.norm(y, v)
        })
    }

    /// Return the principal angles between subspaces, shape (..., k), in ``[0, pi / 2]``, in decreasing order.
    ///
    /// The order is the same as in `scipy.linalg.subspace_angles`. Small angles are as accurate as large ones, because
    /// sines and cosines are used (Knyazev, Argentati 2002). At least ``2 k - n`` angles are exactly zero.
    ///
    /// Examples
    /// --------
    /// Two planes of R^3 that share the first axis:
    ///
    /// >>> from stiefel_rs import Grassmann
    /// >>> Y1 = [[1.0, 0.0], [0.0, np.cos(1e-20)], [0.0, np.sin(1e-20)]]
    /// >>> Grassmann(3, 2).principal_angles(np.eye(3, 2), Y1).tolist()
    /// [1e-20, 0.0]
    fn principal_angles(&self, Y0: &Any, Y1: &Any) -> PyResult<Numbers> {
        let (_, k) = self.shape();
        // Angles between embedded bases come in pairs.
        let each = self.field.embedded(1);
        let angles = self.map(named![Y0, Y1], &[k], move |m, [y0, y1], _| {
            let angles = m.principal_angles(y0, y1)?;
            Ok(row(&angles
                .iter()
                .step_by(each)
                .copied()
                .collect::<Vec<_>>()))
        })?;
        Numbers::from(angles).like(named![Y0, Y1])
    }

    /// Return the basis of the subspace of ``Y1`` nearest to ``Y0`` in the Frobenius norm, shape (..., n, k).
    ///
    /// This is ``Y1 Q`` with the orthogonal polar factor ``Q`` of ``Y1^T Y0``, which equals ``exp(Y0, log(Y0, Y1))``.
    ///
    /// Raises
    /// ------
    /// OutsideDomainError
    ///     A principal angle is ``pi / 2`` to working precision, so that the nearest basis is not unique; carries
    ///     ``angle``.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Grassmann
    /// >>> M = Grassmann(5, 2)
    /// >>> Y = M.random_point(rng=0)
    /// >>> bool(abs(M.align(Y, Y @ [[0, 1], [-1, 0]]) - Y).max() < 1e-15)
    /// True
    fn align(&self, Y0: &Any, Y1: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![Y0, Y1], |m, [y0, y1]| m.align(y0, y1))
    }

    /// Return the orthogonal projectors ``Y Y^T`` to the subspaces, shape (..., n, n); independent of the bases.
    fn projector(&self, Y: &Any) -> PyResult<Numbers> {
        let (n, _) = self.core_shape();
        let found = self.map(named![Y], &[n, n], |m, [y], _| {
            check(m, y)?;
            m.projector(y)
        })?;
        self.field.numbers(found)?.like(named![Y])
    }
}
