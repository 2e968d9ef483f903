//! Retractions, parallel transport, curvature, gradients and Hessians for arrays, with batches.

use super::prelude::*;
use super::space::Space;
use super::stiefel::PyStiefel;
use crate::linalg::complex_embedding::{paired_columns, unpaired_columns};
use crate::linalg::structure::norm;
use crate::manifold::{ParallelTransport, Retraction};

fn read_retraction(kind: &str) -> PyResult<Retraction> {
    Retraction::from_name(kind).ok_or_else(|| {
        let names = Retraction::ALL.map(|r| format!("'{}'", r.name()));
        invalid!("kind: expected {}, found '{kind}'", names.join(", "))
    })
}

/// A retraction or its inverse.
type Map = fn(Retraction, MatRef<'_, f64>, MatRef<'_, f64>) -> Result<Mat<f64>>;

impl PyStiefel {
    fn map_retraction(
        &self,
        objects: [Named<'_, '_>; 2],
        retraction: Retraction,
        map: Map,
    ) -> PyResult<Numbers> {
        // The triangular factor of a complex matrix is embedded as a triangular one in this order of the columns only; the
        // other retractions commute with all orthogonal transformations of the columns.
        let paired = self.field == Field::Complex && retraction == Retraction::Qr;
        self.map_matrices(objects, move |_, [s, other]| match paired {
            false => map(retraction, s, other),
            true => {
                let [s, other] = [s, other].map(paired_columns);
                let found = map(retraction, s.as_ref(), other.as_ref())?;
                Ok(unpaired_columns(found.as_ref()))
            }
        })
    }
}

#[pymethods]
impl PyStiefel {
    /// The point that a retraction maps a tangent vector at ``S`` to, shape (..., n, k).
    ///
    /// The order is that of ``|retract(S, t V) - exp(S, t V)| = O(t^p)``, canonical metric / Euclidean metric:
    ///
    /// ==================  ===================================================  =======
    /// kind                formula                                              order
    /// ==================  ===================================================  =======
    /// "quasi_geodesic"    ``e^X S e^Omega``, ``X = K S^T - S K^T``             2 / 2
    /// "qr"                orthonormal factor of ``S + V``, positive diagonal   2 / 2
    /// "polar"             ``(S + V) (I + V^T V)^(-1/2)``                       2 / 3
    /// "cayley"            ``(I - W/2)^-1 (I + W/2) S``, ``W S = V``            3 / 2
    /// ==================  ===================================================  =======
    ///
    /// On the sphere (k = 1) and on the rotations (k = n) quasi-geodesics are the geodesics, and all others but "qr" on the
    /// rotations are of order 3.
    ///
    /// Parameters
    /// ----------
    /// S, V : array_like, shape (..., n, k)
    ///     Points and tangent vectors.
    /// kind : str, default "quasi_geodesic"
    ///     One of the table.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), an unknown kind, or a vector so long
    ///     that ``S + V`` has lost ``S``.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(5, 2)
    /// >>> S = M.random_point(rng=0)
    /// >>> V = M.random_tangent(S, rng=1)
    /// >>> bool(abs(M.retract(S, V, kind="polar") - M.project(S + V)).max() < 1e-15)
    /// True
    #[pyo3(signature = (S, V, kind="quasi_geodesic"))]
    fn retract(&self, S: &Any, V: &Any, kind: &str) -> PyResult<Numbers> {
        let retraction = read_retraction(kind)?;
        self.map_retraction(named![S, V], retraction, Retraction::retract)
    }

    /// The tangent vector at ``S0`` that a retraction maps to ``S1``, shape (..., n, k).
    ///
    /// With ``M = S0^T S1``, "qr" has an inverse where the leading principal minors of ``M`` are positive, "polar" where its
    /// eigenvalues have positive real parts, "cayley" where -1 is none of them; it is unique, and it is checked before it is
    /// returned. "quasi_geodesic" has its principal branch at almost all pairs.
    ///
    /// Parameters
    /// ----------
    /// S0, S1 : array_like, shape (..., n, k)
    ///     Points.
    /// kind : str, default "quasi_geodesic"
    ///     "quasi_geodesic", "qr", "polar" or "cayley".
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///
    /// Raises
    /// ------
    /// OutsideDomainError
    ///     No unique tangent vector leads there, with the measured number; "quasi_geodesic" carries an ``angle``.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(5, 2)
    /// >>> S = M.random_point(rng=0)
    /// >>> V = 0.3 * M.random_tangent(S, rng=1)
    /// >>> S1 = M.retract(S, V, kind="cayley")
    /// >>> bool(abs(M.inverse_retract(S, S1, kind="cayley") - V).max() < 1e-14)
    /// True
    #[pyo3(signature = (S0, S1, kind="quasi_geodesic"))]
    fn inverse_retract(&self, S0: &Any, S1: &Any, kind: &str) -> PyResult<Numbers> {
        let retraction = read_retraction(kind)?;
        self.map_retraction(named![S0, S1], retraction, Retraction::inverse_retract)
    }

    /// Parallel transport of ``W`` along the geodesic ``t -> exp(S, t V)`` from ``S`` to ``exp(S, V)``, shape (..., n, k).
    ///
    /// The Levi-Civita transport of the manifold's metric, whichever that is. It keeps lengths and angles to round-off.
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// V, W : array_like, shape (..., n, k)
    ///     Tangent vectors at ``S``: the initial velocity of the geodesic, and what is transported.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///     Tangent vectors at ``exp(S, V)``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), or ``V`` longer than about 1e5.
    ///
    /// References
    /// ----------
    /// Nguyen, Sommer (2024), arXiv 2408.06054.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(3, 1)
    /// >>> S, V = [[1.0], [0.0], [0.0]], [[0.0], [np.pi / 2], [0.0]]
    /// >>> bool(abs(M.transport(S, V, [[0.0], [1.0], [2.0]]) - [[-1.0], [0.0], [2.0]]).max() < 1e-15)
    /// True
    fn transport(&self, S: &Any, V: &Any, W: &Any) -> PyResult<Numbers> {
        // The work grows with the way; what is not finite is an error at once.
        let way = |[_, v, _]: &[Batch; 3]| {
            let lengths = (0..v.len()).map(|i| norm(v.get(i)));
            1.0 + lengths.fold(0.0, f64::max)
        };
        let (shape, data) = (self.shape(), named![S, V, W]);
        let core = [shape.0, shape.1].map(|size| self.field.embedded(size));
        let found = self.map_shapes(data, [shape; 3], way, &core, |m, [s, v, w], _| {
            ParallelTransport::new(*m, s, v)?.transport(w)
        })?;
        self.field.numbers(found)?.like(data)
    }

    /// The curvature tensor ``R(U, V) W = D_U D_V W - D_V D_U W - D_[U,V] W`` at ``S``, shape (..., n, k).
    ///
    /// With this sign ``R(U, V) W = <V, W> U - <U, W> V`` on the unit sphere.
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// U, V, W : array_like, shape (..., n, k)
    ///     Tangent vectors at ``S``.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), or a result too large for a number.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(3, 1)
    /// >>> S, U, V = np.eye(3)[:, :, None]
    /// >>> M.curvature(S, U, V, 2 * V).ravel()
    /// array([0., 2., 0.])
    fn curvature(&self, S: &Any, U: &Any, V: &Any, W: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![S, U, V, W], |m, [s, u, v, w]| {
            m.curvature(s, u, v, w)
        })
    }

    /// The sectional curvature of the planes of ``U`` and ``V`` at ``S``, shape (...).
    ///
    /// 1 on the sphere (k = 1), between 0 and 5/4 for the canonical metric of real frames.
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// U, V : array_like, shape (..., n, k)
    ///     Tangent vectors at ``S``, not parallel.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (...)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``U`` and ``V`` are linearly dependent (with the area that unit vectors along them span); shape, not finite, not
    ///     orthonormal, not tangent.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(3, 1)
    /// >>> S, U, V = np.eye(3)[:, :, None]
    /// >>> float(M.sectional_curvature(S, U, V))
    /// 1.0
    fn sectional_curvature(&self, S: &Any, U: &Any, V: &Any) -> PyResult<Numbers> {
        // Inverse to squared lengths.
        let own = |field: Field, x: f64| x / field.squared(1.0);
        self.map_numbers(named![S, U, V], own, |m, [s, u, v], _| {
            m.sectional_curvature(s, u, v)
        })
    }

    /// The Riemannian gradient of a function with the Euclidean gradient ``G`` at ``S``, shape (..., n, k).
    ///
    /// It is the tangent vector with ``inner(S, gradient, V) = sum(G * V)`` for every tangent ``V``: ``G - S G^T S`` for the
    /// canonical metric, ``project_tangent(S, G)`` for the Euclidean one. For complex frames ``G`` is the matrix with
    /// ``df = Re sum(conj(G) * V)``: derivatives by the real parts, plus i times those by the imaginary parts.
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// G : array_like, shape (..., n, k)
    ///     Partial derivatives with respect to the entries; any matrix.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal (with the measured defect).
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(4, 2)
    /// >>> S = M.random_point(rng=0)
    /// >>> G = np.diag([1.0, 2.0, 3.0, 4.0]) @ S
    /// >>> bool(abs(M.euclidean_to_riemannian_gradient(S, G) - (G - S @ G.T @ S)).max() < 1e-14)
    /// True
    fn euclidean_to_riemannian_gradient(&self, S: &Any, G: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![S, G], |m, [s, g]| {
            m.euclidean_to_riemannian_gradient(s, g)
        })
    }

    /// The Riemannian Hessian applied to the tangent vector ``V`` at ``S``, shape (..., n, k).
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// G, H : array_like, shape (..., n, k)
    ///     The Euclidean gradient, and the Euclidean Hessian applied to ``V``; any matrices.
    /// V : array_like, shape (..., n, k)
    ///     Tangent vectors at ``S``.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///     The covariant derivative of the gradient along ``V``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect).
    ///
    /// Examples
    /// --------
    /// The Hessian of ``sum(A * S)``, linear in ``S``, comes from the curvature of the embedding alone:
    ///
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(3, 1)
    /// >>> S, V, A = np.eye(3)[:, :, None]
    /// >>> M.euclidean_to_riemannian_hessian(S, 2 * S, 0 * V, V).ravel()
    /// array([ 0., -2.,  0.])
    fn euclidean_to_riemannian_hessian(
        &self,
        S: &Any,
        G: &Any,
        H: &Any,
        V: &Any,
    ) -> PyResult<Numbers> {
        self.map_matrices(named![S, G, H, V], |m, [s, g, h, v]| {
            m.euclidean_to_riemannian_hessian(s, g, h, v)
        })
    }
}
