//! Parallel transport, curvature, gradients and Hessians for arrays, with batches.

use super::prelude::*;
use super::stiefel::PyStiefel;
use crate::linalg::structure::norm;
use crate::manifold::ParallelTransport;

#[pymethods]
impl PyStiefel {
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
    fn transport(&self, S: &Any, V: &Any, W: &Any) -> PyResult<Array> {
        // The work grows with the way; what is not finite is an error at once.
        let way = |[_, v, _]: &[Batch; 3]| {
            let lengths = (0..v.len()).map(|i| norm(v.get(i)));
            1.0 + lengths.fold(0.0, f64::max)
        };
        let ((n, k), data) = (self.shape(), named![S, V, W]);
        self.map_shapes(data, [(n, k); 3], way, &[n, k], |m, [s, v, w], _| {
            ParallelTransport::new(*m, s, v)?.transport(w)
        })
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
    fn curvature(&self, S: &Any, U: &Any, V: &Any, W: &Any) -> PyResult<Array> {
        self.map_matrices(named![S, U, V, W], |m, [s, u, v, w]| {
            m.curvature(s, u, v, w)
        })
    }

    /// The sectional curvature of the planes of ``U`` and ``V`` at ``S``, shape (...).
    ///
    /// 1 on the sphere (k = 1), between 0 and 5/4 for the canonical metric.
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
    fn sectional_curvature(&self, S: &Any, U: &Any, V: &Any) -> PyResult<Array> {
        self.map(named![S, U, V], &[], |m, [s, u, v], _| {
            m.sectional_curvature(s, u, v)
        })
    }

    /// The Riemannian gradient of a function with the Euclidean gradient ``G`` at ``S``, shape (..., n, k).
    ///
    /// It is the tangent vector with ``inner(S, gradient, V) = sum(G * V)`` for every tangent ``V``: ``G - S G^T S`` for the
    /// canonical metric, ``project_tangent(S, G)`` for the Euclidean one.
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
    fn euclidean_to_riemannian_gradient(&self, S: &Any, G: &Any) -> PyResult<Array> {
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
    ) -> PyResult<Array> {
        self.map_matrices(named![S, G, H, V], |m, [s, g, h, v]| {
            m.euclidean_to_riemannian_hessian(s, g, h, v)
        })
    }
}
