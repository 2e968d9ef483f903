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
        // Only with this order of columns is the triangular factor of a complex matrix embedded as a triangular matrix.
        // The other retractions commute with all orthogonal transformations of the columns.
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
    /// Apply a retraction to tangent vectors at ``S``, shape (..., n, k).
    ///
    /// The order is the ``p`` in ``|retract(S, t V) - exp(S, t V)| = O(t^p)``, canonical metric / Euclidean metric:
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
    /// On the sphere (k = 1) and on the rotations (k = n) quasi-geodesics are geodesics, and the other retractions have
    /// order 3, except "qr" on the rotations.
    ///
    /// Parameters
    /// ----------
    /// S, V : array_like, shape (..., n, k)
    ///     Points and tangent vectors.
    /// kind : str, default "quasi_geodesic"
    ///     A kind from the table.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), an
    ///     unknown kind, or a vector so long that ``S`` is lost in the rounding of ``S + V``.
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

    /// Return the tangent vector at ``S0`` that a retraction maps to ``S1``, shape (..., n, k).
    ///
    /// With ``M = S0^T S1``, "qr" has an inverse if the leading principal minors of ``M`` are positive, "polar" if its
    /// eigenvalues have positive real parts, "cayley" if -1 is not an eigenvalue; the inverse is then unique, and is
    /// verified before it is returned. "quasi_geodesic" has a principal branch for almost all pairs of points.
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
    ///     No unique tangent vector leads to ``S1``; the message states the measured quantity. "quasi_geodesic" carries
    ///     ``angle``.
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

    /// Transport ``W`` in parallel along the geodesic ``t -> exp(S, t V)`` to ``exp(S, V)``, shape (..., n, k).
    ///
    /// The Levi-Civita transport of the manifold's metric. It preserves lengths and angles to round-off.
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// V, W : array_like, shape (..., n, k)
    ///     Tangent vectors at ``S``: the initial velocity of the geodesic, and the vector to transport.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///     Tangent vectors at ``exp(S, V)``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), or
    ///     ``V`` longer than about 1e5.
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
        // The work grows with the length; non-finite input raises at once.
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

    /// Evaluate the curvature tensor ``R(U, V) W = D_U D_V W - D_V D_U W - D_[U,V] W`` at ``S``, shape (..., n, k).
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
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), or
    ///     a result that overflows.
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

    /// Return the sectional curvature of the planes spanned by ``U`` and ``V`` at ``S``, shape (...).
    ///
    /// It is 1 on the sphere (k = 1), and between 0 and 5/4 for the canonical metric of real frames.
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// U, V : array_like, shape (..., n, k)
    ///     Tangent vectors at ``S``, linearly independent.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (...)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``U`` and ``V`` are linearly dependent (the message states the area that their unit vectors span); wrong
    ///     shape, non-finite entries, points not orthonormal, vectors not tangent.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(3, 1)
    /// >>> S, U, V = np.eye(3)[:, :, None]
    /// >>> float(M.sectional_curvature(S, U, V))
    /// 1.0
    fn sectional_curvature(&self, S: &Any, U: &Any, V: &Any) -> PyResult<Numbers> {
        // Scales inversely with squared lengths.
        let own = |field: Field, x: f64| x / field.squared(1.0);
        self.map_numbers(named![S, U, V], own, |m, [s, u, v], _| {
            m.sectional_curvature(s, u, v)
        })
    }

    /// Return the Riemannian gradient of a function with the Euclidean gradient ``G`` at ``S``, shape (..., n, k).
    ///
    /// It is the tangent vector with ``inner(S, gradient, V) = sum(G * V)`` for every tangent ``V``: ``G - S G^T S``
    /// for the canonical metric, ``project_tangent(S, G)`` for the Euclidean one. For complex frames ``G`` is the
    /// matrix with ``df = Re sum(conj(G) * V)``: the derivatives by the real parts plus i times the derivatives by the
    /// imaginary parts.
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// G : array_like, shape (..., n, k)
    ///     Partial derivatives with respect to the entries; need not be tangent.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
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

    /// Apply the Riemannian Hessian to the tangent vector ``V`` at ``S``, shape (..., n, k).
    ///
    /// Parameters
    /// ----------
    /// S : array_like, shape (..., n, k)
    ///     Points.
    /// G, H : array_like, shape (..., n, k)
    ///     Euclidean gradient, and Euclidean Hessian applied to ``V``; need not be tangent.
    /// V : array_like, shape (..., n, k)
    ///     Tangent vectors at ``S``.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///     Covariant derivative of the gradient along ``V``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect).
    ///
    /// Examples
    /// --------
    /// The function ``sum(A * S)`` is linear in ``S``, so its Hessian comes from the curvature of the embedding alone:
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
