"""`Stiefel` as a manifold of pymanopt, whose solvers then run on it. Needs the extra `pymanopt`.

Works for the whole alpha family of metrics, canonical and Euclidean among them. With `w = 1 / (2 (alpha + 1))` (1/2
for the canonical metric, 1 for the Euclidean one) and `V = S Omega + K`, `S^T K = 0`, the metric is
`<K_V, K_W> + w <Omega_V, Omega_W>`. pymanopt's own `Stiefel` has the Euclidean metric only, and neither logarithm nor
distance.

Sources: Edelman, Arias, Smith (1998), section 2.4 (canonical metric); Hueper, Markina, Silva Leite (2021) (the family).
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pymanopt.manifolds.manifold import Manifold

from ._core import Stiefel, skew_exp

__all__ = ["StiefelManifold"]

_Array = NDArray[np.float64]

_RETRACT_HAS_KINDS = "kind" in inspect.signature(Stiefel.retract).parameters

Retraction = Literal["quasi_geodesic", "polar", "qr", "cayley"]


class StiefelManifold(Manifold):
    """The manifold `St(n, k)` for pymanopt's optimisers.

    Parameters
    ----------
    n, k : int
        Rows and columns, `1 <= k <= n`.
    metric : str or float or None
        As for `Stiefel`: ``"canonical"`` (default), ``"euclidean"``, or a value of alpha above -1.
    retraction : {"quasi_geodesic", "polar", "qr", "cayley"}
        What the solvers step with.
    rng : numpy.random.Generator or int or None
        Source of random points and tangent vectors.

    Attributes
    ----------
    stiefel : Stiefel
        The manifold that does the work.

    Examples
    --------
    >>> import numpy as np, pymanopt
    >>> from pymanopt.optimizers import TrustRegions
    >>> from stiefel_rs.pymanopt import StiefelManifold
    >>> A, M = np.diag([3.0, 2.0, 1.0]), StiefelManifold(3, 1, rng=1)
    >>> cost = pymanopt.function.numpy(M)(lambda S: -np.sum(S * (A @ S)))
    >>> gradient = pymanopt.function.numpy(M)(lambda S: -2 * A @ S)
    >>> hessian = pymanopt.function.numpy(M)(lambda S, V: -2 * A @ V)
    >>> problem = pymanopt.Problem(M, cost, euclidean_gradient=gradient, euclidean_hessian=hessian)
    >>> round(float(TrustRegions(verbosity=0).run(problem).cost), 12)
    -3.0
    """

    def __init__(
        self,
        n: int,
        k: int,
        *,
        metric: str | float | None = None,
        retraction: Retraction = "quasi_geodesic",
        rng: np.random.Generator | int | None = None,
    ) -> None:
        self.stiefel = Stiefel(n, k, metric=metric)
        if retraction not in _RETRACTIONS:
            raise ValueError(f"retraction: must be one of {sorted(_RETRACTIONS)}, found {retraction!r}")
        self._retraction = retraction
        self._rng = np.random.default_rng(rng)
        self._weight = 0.5 / (self.stiefel.alpha + 1.0)
        super().__init__(f"Stiefel manifold St({n},{k}), alpha = {self.stiefel.alpha:g}", self.stiefel.dim)

    @property
    def typical_dist(self) -> float:
        """Length scale of the manifold, the norm of a point: trust regions take their radii from it."""
        return float(np.sqrt(self.stiefel.k))

    def inner_product(self, point: _Array, tangent_vector_a: _Array, tangent_vector_b: _Array) -> float:
        """Inner product of two tangent vectors."""
        return float(self.stiefel.inner(point, tangent_vector_a, tangent_vector_b))

    def norm(self, point: _Array, tangent_vector: _Array) -> float:
        """Length of a tangent vector."""
        return float(self.stiefel.norm(point, tangent_vector))

    def projection(self, point: _Array, vector: _Array) -> _Array:
        """Orthogonal projection of a matrix on the tangent space, the same one for every metric of the family."""
        return self.stiefel.project_tangent(point, vector)

    to_tangent_space = projection

    def euclidean_to_riemannian_gradient(self, point: _Array, euclidean_gradient: _Array) -> _Array:
        """Riemannian gradient, `S skew(S^T G) / w + (I - S S^T) G`: for the canonical metric `G - S G^T S`."""
        if (native := getattr(self.stiefel, "euclidean_to_riemannian_gradient", None)) is not None:
            return np.asarray(native(point, euclidean_gradient))
        normal, omega = _split(point, euclidean_gradient)
        return np.asarray(normal + point @ (_skew(omega) / self._weight))

    def euclidean_to_riemannian_hessian(
        self, point: _Array, euclidean_gradient: _Array, euclidean_hessian: _Array, tangent_vector: _Array
    ) -> _Array:
        """Covariant derivative of the Riemannian gradient along a tangent vector.

        The derivative in `R^{n x k}` of the gradient's formula, plus the Christoffel term of the metric.
        """
        S, G, V, H = point, euclidean_gradient, tangent_vector, euclidean_hessian
        if (native := getattr(self.stiefel, "euclidean_to_riemannian_hessian", None)) is not None:
            return np.asarray(native(S, G, H, V))
        A = S.T @ G
        gradient = self.euclidean_to_riemannian_gradient(S, G)
        change = V @ (_skew(A) / self._weight) + S @ (_skew(V.T @ G + S.T @ H) / self._weight)
        change += H - V @ A - S @ (V.T @ G + S.T @ H)
        return self.projection(S, change + self._christoffel(S, V, gradient))

    def _christoffel(self, S: _Array, V: _Array, W: _Array) -> _Array:
        """Christoffel term `Gamma(V, W)` of the covariant derivative `D_V W = W'[V] + Gamma(V, W)`.

        ``Gamma(V, V) = S K^T K - S Omega^2 - 2 (1 - w) K Omega``, and the symmetric bilinear form that this is of.
        """
        (K, omega), (L, psi) = _split(S, V), _split(S, W)
        normal = K.T @ L - omega @ psi
        mixed = K @ psi + L @ omega
        return np.asarray(S @ ((normal + normal.T) / 2) - (1 - self._weight) * mixed)

    def retraction(self, point: _Array, tangent_vector: _Array) -> _Array:
        """Step along a tangent vector, by the retraction chosen at construction."""
        if _RETRACT_HAS_KINDS:
            return np.asarray(self._needs("retract")(point, tangent_vector, kind=self._retraction))
        return _RETRACTIONS[self._retraction](self.stiefel, point, tangent_vector)

    def exp(self, point: _Array, tangent_vector: _Array) -> _Array:
        """End point of the geodesic with a given initial velocity."""
        if (exp := getattr(self.stiefel, "exp", None)) is not None:
            return np.asarray(exp(point, tangent_vector))
        normal, omega = _split(point, tangent_vector)
        omega = _skew(omega)
        # Not a QR form: where the normal part has less than full rank, its Q need not be normal to the point.
        Q, sigma, Wt = np.linalg.svd(normal, full_matrices=False)
        R = sigma[:, None] * Wt
        generator = np.block([[2 * self._weight * omega, -R.T], [R, np.zeros((len(R), len(R)))]])
        turned = np.hstack([point, Q]) @ skew_exp(generator)[:, : self.stiefel.k]
        return np.asarray(turned @ skew_exp((1 - 2 * self._weight) * omega))

    def log(self, point_a: _Array, point_b: _Array) -> _Array:
        """Velocity at the start of the shortest geodesic from one point to another."""
        return np.asarray(self._needs("log")(point_a, point_b))

    def dist(self, point_a: _Array, point_b: _Array) -> float:
        """Length of the shortest geodesic between two points."""
        return float(self._needs("dist")(point_a, point_b))

    def pair_mean(self, point_a: _Array, point_b: _Array) -> _Array:
        """Middle of the shortest geodesic between two points."""
        return self.exp(point_a, self.log(point_a, point_b) / 2)

    def transport(self, point_a: _Array, point_b: _Array, tangent_vector_a: _Array) -> _Array:
        """Vector transport by projection on the tangent space at `point_b`; conjugate gradients need no more."""
        return self.projection(point_b, tangent_vector_a)

    def random_point(self) -> _Array:
        """Uniformly distributed point."""
        return self.stiefel.random_point(self._rng)

    def random_tangent_vector(self, point: _Array) -> _Array:
        """Random tangent vector of length 1."""
        V = self.stiefel.random_tangent(point, self._rng)
        return np.asarray(V / self.norm(point, V))

    def zero_vector(self, point: _Array) -> _Array:
        """Origin of the tangent space."""
        return np.zeros((self.stiefel.n, self.stiefel.k))

    def _needs(self, name: str) -> Callable[..., Any]:
        method: Callable[..., Any] | None = getattr(self.stiefel, name, None)
        if method is None:
            raise NotImplementedError(f"this build of stiefel_rs has no Stiefel.{name}")
        return method


def _skew(A: _Array) -> _Array:
    return np.asarray((A - A.T) / 2)


def _split(S: _Array, Z: _Array) -> tuple[_Array, _Array]:
    """Parts of a matrix normal to the columns of a point and along them: `(Z - S A, A)`, `A = S^T Z`."""
    A = S.T @ Z
    normal = Z - S @ A
    return normal, A


def _quasi_geodesic(M: Stiefel, S: _Array, V: _Array) -> _Array:
    """`e^X S e^Omega`."""
    return M.retract(S, V)


def _polar(M: Stiefel, S: _Array, V: _Array) -> _Array:
    """Nearest point to `S + V`; of second order for the Euclidean metric."""
    return M.project(S + V)


def _qr(_: Stiefel, S: _Array, V: _Array) -> _Array:
    """Q of the QR form of `S + V`, with the signs that make R's diagonal positive."""
    Q, R = np.linalg.qr(S + V)
    return np.asarray(Q * np.where(np.diagonal(R) < 0, -1.0, 1.0))


def _cayley(_: Stiefel, S: _Array, V: _Array) -> _Array:
    """`(I - W/2)^{-1} (I + W/2) S` with the skew W of rank 2k for which `W S = V`.

    Of second order for the canonical metric.
    Wen, Yin (2013), "A feasible method for optimization with orthogonality constraints", eq. (20) in product form.
    """
    PV = V - S @ (S.T @ V) / 2
    left, right = np.hstack([PV, S]), np.hstack([S, -PV])
    capacitance = np.eye(left.shape[1]) - right.T @ left / 2
    return np.asarray(S + left @ np.linalg.solve(capacitance, right.T @ S))


_RETRACTIONS: dict[str, Callable[[Stiefel, _Array, _Array], _Array]] = {
    "cayley": _cayley,
    "polar": _polar,
    "qr": _qr,
    "quasi_geodesic": _quasi_geodesic,
}
