//! Geodesics, transport, curvature and gradients of the Grassmann manifold for arrays.

use super::grassmann::PyGrassmann;
use super::prelude::*;
use super::space::Space;

/// Copies a view: rows are far apart in a batch, and the core reads columns.
fn columns<const N: usize>(data: [MatRef<'_, f64>; N]) -> [Mat<f64>; N] {
    data.map(|matrix| matrix.to_owned())
}

#[pymethods]
impl PyGrassmann {
    /// Return the Riemannian exponential of tangent vectors ``V`` at ``Y``, shape (..., n, k).
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///     ``(Y W cos(S) + Q sin(S)) W^T`` for ``V = Q S W^T``: the basis of the end point reached by the horizontal
    ///     lift of the geodesic.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not horizontal (with the measured defect),
    ///     or a vector so long that the result overflows.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Grassmann
    /// >>> M = Grassmann(3, 1)
    /// >>> M.exp([[1], [0], [0]], [[0], [np.pi / 3], [0]]).round(6).ravel().tolist()
    /// [0.5, 0.866025, 0.0]
    fn exp(&self, Y: &Any, V: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![Y, V], |m, data| {
            let [y, v] = columns(data);
            m.exp(y.as_ref(), v.as_ref())
        })
    }

    /// Return the Riemannian logarithm, the ``V`` at ``Y0`` such that ``exp(Y0, V)`` spans the subspace of ``Y1``.
    ///
    /// The result has shape (..., n, k) and a closed form, and does not depend on the choice of the basis ``Y1``.
    /// ``exp(Y0, log(Y0, Y1))`` is ``align(Y0, Y1)``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
    /// OutsideDomainError
    ///     The largest principal angle is ``pi / 2`` to working precision, so that several shortest geodesics join the
    ///     subspaces; carries ``angle``.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Grassmann
    /// >>> M = Grassmann(3, 1)
    /// >>> M.log([[1], [0], [0]], [[-0.6], [0.8], [0]]).round(6).ravel().tolist()
    /// [0.0, -0.927295, 0.0]
    fn log(&self, Y0: &Any, Y1: &Any) -> PyResult<Numbers> {
        self.map_matrices_into(named![Y0, Y1], |m, out, [y0, y1]| m.log_into(out, y0, y1))
    }

    /// Return the Riemannian distance of subspaces, ``sqrt(sum(principal_angles ** 2))``, shape (...).
    ///
    /// It is also defined if an angle is ``pi / 2``, where :meth:`log` raises. For different bases of the same subspace
    /// the result is round-off, not exactly 0.
    fn dist(&self, Y0: &Any, Y1: &Any) -> PyResult<Numbers> {
        self.map_numbers(named![Y0, Y1], Field::length, |m, [y0, y1], _| {
            m.dist(y0, y1)
        })
    }

    /// Transport ``W`` in parallel along the geodesic ``t -> exp(Y, t V)`` to ``exp(Y, V)``, shape (..., n, k).
    ///
    /// The transport preserves lengths and angles to round-off.
    ///
    /// Parameters
    /// ----------
    /// Y : array_like, shape (..., n, k)
    ///     Points.
    /// V, W : array_like, shape (..., n, k)
    ///     Tangent vectors at ``Y``: the initial velocity of the geodesic, and the vector to transport.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not horizontal (with the measured defect).
    ///
    /// References
    /// ----------
    /// Edelman, Arias, Smith (1998), theorem 2.4.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Grassmann
    /// >>> M = Grassmann(3, 1)
    /// >>> Y, V = [[1.0], [0.0], [0.0]], [[0.0], [np.pi / 2], [0.0]]
    /// >>> bool(abs(M.transport(Y, V, [[0.0], [1.0], [2.0]]) - [[-1.0], [0.0], [2.0]]).max() < 1e-15)
    /// True
    fn transport(&self, Y: &Any, V: &Any, W: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![Y, V, W], |m, data| {
            let [y, v, w] = columns(data);
            m.transport(y.as_ref(), v.as_ref(), w.as_ref())
        })
    }

    /// Evaluate the curvature tensor ``R(U, V) W = D_U D_V W - D_V D_U W - D_[U,V] W`` at ``Y``, shape (..., n, k).
    ///
    /// It is ``U V^T W - V U^T W + W (V^T U - U^T V)``; for lines (k = 1), ``<V, W> U - <U, W> V``. The sign agrees
    /// with :meth:`Stiefel.curvature`.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not horizontal (with the measured defect),
    ///     or a result that overflows.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Grassmann
    /// >>> M = Grassmann(3, 1)
    /// >>> Y, U, V = np.eye(3)[:, :, None]
    /// >>> M.curvature(Y, U, V, 2 * V).ravel()
    /// array([0., 2., 0.])
    fn curvature(&self, Y: &Any, U: &Any, V: &Any, W: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![Y, U, V, W], |m, [y, u, v, w]| {
            m.curvature(y, u, v, w)
        })
    }

    /// Return the sectional curvature of the planes spanned by ``U`` and ``V`` at ``Y``, shape (...).
    ///
    /// It is between 0 and 2, and 1 if ``k`` or ``n - k`` is 1.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``U`` and ``V`` are linearly dependent (the message states the area that their unit vectors span); wrong
    ///     shape, non-finite entries, points not orthonormal, vectors not horizontal.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Grassmann
    /// >>> M = Grassmann(4, 2)
    /// >>> Y, U = np.eye(4, 2), np.eye(4, 2, -2)
    /// >>> float(M.sectional_curvature(Y, U, U[:, ::-1] * [1, -1]).round(14))
    /// 2.0
    fn sectional_curvature(&self, Y: &Any, U: &Any, V: &Any) -> PyResult<Numbers> {
        // Scales inversely with squared lengths.
        let own = |field: Field, x: f64| x / field.squared(1.0);
        self.map_numbers(named![Y, U, V], own, |m, [y, u, v], _| {
            m.sectional_curvature(y, u, v)
        })
    }

    /// Return the Riemannian gradient ``G - Y Y^T G`` for the Euclidean gradient ``G``, shape (..., n, k).
    ///
    /// The function must depend on the subspace alone, ``f(Y Q) = f(Y)`` for orthogonal ``Q``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Grassmann
    /// >>> M, A = Grassmann(4, 2), np.diag([1.0, 2.0, 3.0, 4.0])
    /// >>> Y = M.random_point(rng=0)
    /// >>> bool(abs(M.euclidean_to_riemannian_gradient(Y, A @ Y) - (A @ Y - Y @ Y.T @ A @ Y)).max() < 1e-14)
    /// True
    fn euclidean_to_riemannian_gradient(&self, Y: &Any, G: &Any) -> PyResult<Numbers> {
        self.map_matrices(named![Y, G], |m, [y, g]| {
            m.euclidean_to_riemannian_gradient(y, g)
        })
    }

    /// Apply the Riemannian Hessian to the tangent vector ``V`` at ``Y``, shape (..., n, k).
    ///
    /// The result is ``(I - Y Y^T) H - V Y^T G``.
    ///
    /// Parameters
    /// ----------
    /// Y : array_like, shape (..., n, k)
    ///     Points.
    /// G, H : array_like, shape (..., n, k)
    ///     Euclidean gradient, and Euclidean Hessian applied to ``V``, of a function that depends on the subspace
    ///     alone.
    /// V : array_like, shape (..., n, k)
    ///     Tangent vectors at ``Y``.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///     Covariant derivative of the gradient along ``V``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not horizontal (with the measured defect).
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Grassmann
    /// >>> M, A = Grassmann(3, 1), np.diag([1.0, 2.0, 3.0])
    /// >>> Y, V, _ = np.eye(3)[:, :, None]
    /// >>> M.euclidean_to_riemannian_hessian(Y, A @ Y, A @ V, V).ravel()
    /// array([0., 1., 0.])
    fn euclidean_to_riemannian_hessian(
        &self,
        Y: &Any,
        G: &Any,
        H: &Any,
        V: &Any,
    ) -> PyResult<Numbers> {
        self.map_matrices(named![Y, G, H, V], |m, [y, g, h, v]| {
            m.euclidean_to_riemannian_hessian(y, g, h, v)
        })
    }
}
