//! The Grassmann manifold for arrays, with batches.

use super::membership::core_tolerance;
use super::prelude::*;
use super::space::{Space, sizes};
use crate::manifold::Grassmann;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::space::Quotient;

/// The Grassmann manifold Gr(n, k) of k-dimensional subspaces of R^n, or of C^n.
///
/// A point is an orthonormal basis ``Y`` of a subspace, an array of shape ``(..., n, k)``; all bases of a subspace are the same
/// point. Tangent vectors at ``Y`` are matrices ``V`` of that shape with ``Y^T V = 0``; their length is ``|V|`` (Frobenius). Results
/// belong to the given basis: a tangent vector ``V`` at ``Y`` is ``V Q`` at ``Y Q``. Leading axes are batches and broadcast.
///
/// Parameters
/// ----------
/// n, k : int
///     ``1 <= k <= n``.
/// field : "real" or "complex", default "real"
///     With ``"complex"``, subspaces of C^n. Arrays of complex numbers are taken and returned; in all formulas the transpose is
///     the conjugate transpose, and inner products are real parts. Lines, ``k = 1``, are the states of quantum mechanics:
///     ``Grassmann(2, 1, field="complex")`` is the sphere of radius 1/2.
///
/// Raises
/// ------
/// InvalidInputError
///     Unless ``1 <= k <= n``. Methods raise it for arrays of another shape, numbers that are not finite, points that are not
///     orthonormal and vectors that are not horizontal, with the measured defect and the member of the batch.
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
    /// The manifold that the core computes on: of embedded bases, where they are complex.
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
    /// The manifold of points of the core.
    pub(super) fn of_core((rows, cols): (usize, usize), field: Field) -> PyResult<Self> {
        let embedded = Grassmann::new(rows, cols)?;
        Ok(PyGrassmann { embedded, field })
    }
}

impl PyGrassmann {
    /// Checks bases to a tolerance.
    fn basis_check(
        &self,
    ) -> impl Fn(&Grassmann, [MatRef<'_, f64>; 1], [f64; 2]) -> Result<()> + Shared + use<> {
        let unit = self.field.length(1.0);
        move |m, [y], [atol, _]| m.check_point("Y", y, atol / unit)
    }

    /// Checks horizontal vectors to a tolerance.
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

    /// "real" or "complex".
    #[getter(field)]
    fn word(&self) -> &'static str {
        self.field.word()
    }

    /// Rows of a basis.
    #[getter]
    fn n(&self) -> usize {
        self.shape().0
    }

    /// Dimension of the subspaces, columns of a basis.
    #[getter]
    fn k(&self) -> usize {
        self.shape().1
    }

    /// Dimension of the manifold, ``k (n - k)``, twice that for a complex one.
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

    /// Raise unless every member of ``Y`` is a point: ``|Y^T Y - I| <= atol`` (Frobenius), by default 1e-9, for arrays in
    /// single precision 1e-5.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     With the measured defect.
    #[pyo3(signature = (Y, atol=None))]
    fn check_point(&self, Y: &Any, atol: Option<f64>) -> PyResult<()> {
        self.check(named![Y], atol, self.basis_check())
    }

    /// Raise unless every member of ``V`` is horizontal at ``Y``: ``|Y^T V| <= atol max(1, |V|)``, by default 1e-9, in
    /// single precision 1e-5.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     With the measured defect.
    #[pyo3(signature = (Y, V, atol=None))]
    fn check_tangent(&self, Y: &Any, V: &Any, atol: Option<f64>) -> PyResult<()> {
        self.check(named![Y, V], atol, self.horizontal_check())
    }

    /// Whether ``Y`` is an orthonormal basis, as :meth:`check_point` measures it; shape (...).
    ///
    /// Returns
    /// -------
    /// bool, or ndarray of bool
    ///     False for numbers that are not finite.
    #[pyo3(signature = (Y, atol=None))]
    fn is_point(&self, Y: &Any, atol: Option<f64>) -> PyResult<Numbers> {
        self.are(named![Y], atol, self.basis_check())
    }

    /// Whether ``V`` is horizontal at ``Y``, as :meth:`check_tangent` measures it; shape (...).
    ///
    /// Returns
    /// -------
    /// bool, or ndarray of bool
    ///     False for numbers that are not finite, and where ``Y`` is no orthonormal basis.
    #[pyo3(signature = (Y, V, atol=None))]
    fn is_tangent(&self, Y: &Any, V: &Any, atol: Option<f64>) -> PyResult<Numbers> {
        self.are(named![Y, V], atol, self.horizontal_check())
    }

    /// Bases of uniformly distributed subspaces (Haar measure), shape ``size + (n, k)``.
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
    ) -> PyResult<Numbers> {
        self.random_points(py, rng, size)
    }

    /// Normally distributed tangent vectors at ``Y``: standard normal matrices, projected. Shape of ``Y``.
    ///
    /// Parameters
    /// ----------
    /// Y : array_like, shape (..., n, k)
    ///     Points.
    /// rng : numpy.random.Generator or seed, optional
    ///     What `numpy.random.default_rng` takes. The vectors are independent of ``Y``, also where ``Y`` is made with the same
    ///     seed, or by a generator in the same state.
    #[pyo3(signature = (Y, rng=None))]
    fn random_tangent(&self, Y: &Any, rng: Option<&Any>) -> PyResult<Numbers> {
        self.random_tangents((Y, "Y"), rng)
    }

    /// Orthonormal basis of the column space of ``Y`` nearest to ``Y``: its polar factor, shape (..., n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``Y`` has no full column rank (with its smallest singular value), or is not finite.
    fn project(&self, Y: &Any) -> PyResult<Numbers> {
        self.map_any(named![Y], |m, [y]| m.project(y))
    }

    /// Orthogonal projection ``Z - Y Y^T Z`` on the tangent space at ``Y``, shape (..., n, k).
    fn project_tangent(&self, Y: &Any, Z: &Any) -> PyResult<Numbers> {
        self.tangent_part(Y, Z)
    }

    /// Inner product of tangent vectors at ``Y``, ``tr V^T W``, of complex ones its real part, shape (...).
    fn inner(&self, Y: &Any, V: &Any, W: &Any) -> PyResult<Numbers> {
        self.map_numbers(named![Y, V, W], Field::squared, |m, [y, v, w], _| {
            check(m, y)?;
            check_vector(m, "V", [y, v])?;
            check_vector(m, "W", [y, w])?;
            m.inner(y, v, w)
        })
    }

    /// Norm of a tangent vector at ``Y``, ``|V|`` (Frobenius), shape (...).
    fn norm(&self, Y: &Any, V: &Any) -> PyResult<Numbers> {
        self.map_numbers(named![Y, V], Field::length, |m, [y, v], _| {
            check(m, y)?;
            check_vector(m, "V", [y, v])?;
            m.norm(y, v)
        })
    }

    /// Principal angles between subspaces, shape (..., k), in ``[0, pi / 2]``, decreasing as those of
    /// `scipy.linalg.subspace_angles`.
    ///
    /// Small angles are as accurate as large ones: from sines and cosines (Knyazev, Argentati 2002). At least ``2 k - n`` of them
    /// are exactly zero.
    ///
    /// Examples
    /// --------
    /// Two planes of R^3 that meet in the first axis:
    ///
    /// >>> from stiefel_rs import Grassmann
    /// >>> Y1 = [[1.0, 0.0], [0.0, np.cos(1e-20)], [0.0, np.sin(1e-20)]]
    /// >>> Grassmann(3, 2).principal_angles(np.eye(3, 2), Y1).tolist()
    /// [1e-20, 0.0]
    fn principal_angles(&self, Y0: &Any, Y1: &Any) -> PyResult<Numbers> {
        let (_, k) = self.shape();
        // Those of embedded bases come in pairs.
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

    /// The basis of the subspace of ``Y1`` that is nearest to ``Y0`` (Frobenius), shape (..., n, k).
    ///
    /// ``Y1 Q`` with the orthogonal polar factor ``Q`` of ``Y1^T Y0``; also ``exp(Y0, log(Y0, Y1))``.
    ///
    /// Raises
    /// ------
    /// OutsideDomainError
    ///     A principal angle is ``pi / 2`` to working precision, and the nearest basis is not unique; carries ``angle``.
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

    /// Orthogonal projectors ``Y Y^T`` on the subspaces, shape (..., n, n): the same for all bases of a subspace.
    fn projector(&self, Y: &Any) -> PyResult<Numbers> {
        let (n, _) = self.core_shape();
        let found = self.map(named![Y], &[n, n], |m, [y], _| {
            check(m, y)?;
            m.projector(y)
        })?;
        self.field.numbers(found)?.like(named![Y])
    }
}
