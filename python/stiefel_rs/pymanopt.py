"""`Stiefel` and `Grassmann` as manifolds for the solvers of pymanopt. Needs the extra `pymanopt`.

`StiefelManifold` supports the alpha family of metrics, which includes the canonical and the Euclidean metric. With `w =
1 / (2 (alpha + 1))` (1/2 for the canonical metric, 1 for the Euclidean one) and `V = S Omega + K`, `S^T K = 0`, the
metric is `<K_V, K_W> + w <Omega_V, Omega_W>`. pymanopt's own `Stiefel` has only the Euclidean metric, and neither
logarithm nor distance. `GrassmannManifold` has the metric of pymanopt's `Grassmann`, with distances that are accurate
for small angles too.

Sources: Edelman, Arias, Smith (1998), section 2.4 (canonical metric); Hueper, Markina, Silva Leite (2021) (the family).
"""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pymanopt.manifolds.manifold import Manifold

from ._core import Grassmann, Stiefel
from .errors import InvalidInputError

__all__ = ["GrassmannManifold", "StiefelManifold"]

_Array = NDArray[Any]

Retraction = Literal["quasi_geodesic", "polar", "qr", "cayley"]


class StiefelManifold(Manifold):
    """Stiefel manifold `St(n, k)` for pymanopt's optimisers.

    Parameters
    ----------
    n, k : int
        Numbers of rows and columns, `1 <= k <= n`.
    metric : str or float or None
        As for `Stiefel`: ``"canonical"`` (default), ``"euclidean"``, or a value of alpha above -1.
    retraction : {"quasi_geodesic", "polar", "qr", "cayley"}
        Retraction for the steps of the solvers.
    rng : numpy.random.Generator or int or None
        Source of random points and tangent vectors.
    field : "real" or "complex"
        Field of the entries. Gradients for complex frames are matrices `G` with `df = Re tr G^H V`.
    determinant : {1, -1, None}
        For ``k = n``, where the manifold is O(n): determinant of random points. By default they lie in both components.

    Attributes
    ----------
    stiefel : Stiefel
        The underlying manifold.

    Notes
    -----
    `log`, `dist` and `pair_mean`, which particle swarms and the Nelder-Mead method call, search for a shortest
    geodesic. Between random points, which are mostly farther apart than the injectivity radius, the search fails with a
    `ConvergenceError` for about one pair in a hundred on St(4, 2) and St(5, 3) with the Euclidean metric, and for none
    of 300 with the canonical metric.

    For ``k = n`` the manifold is O(n), which has two components, of determinant 1 and -1; no curve joins them. Solvers
    that move along curves stay in the component of their first point. Random points lie in either with equal
    probability. Particle swarms and the Nelder-Mead method join many random points, which raises an
    `OutsideDomainError` unless all lie in one component: pass ``determinant=1`` (rotations) or ``determinant=-1``, and
    solve twice if the optimum may lie in either. For ``k < n`` the manifold is connected.

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
        determinant: Literal[1, -1] | None = None,
        field: Literal["real", "complex"] = "real",
    ) -> None:
        self.stiefel = Stiefel(n, k, metric=metric, field=field)
        if determinant not in (1, -1, None):
            raise InvalidInputError(f"determinant: must be 1, -1 or None, found {determinant!r}")
        if determinant is not None and n != k:
            raise InvalidInputError(f"determinant: points of St({n}, {k}) have none, found {determinant}")
        if determinant is not None and field == "complex":
            raise InvalidInputError(
                f"determinant: must be None for unitary matrices, which form a single component, found {determinant}"
            )
        self._determinant = determinant
        if retraction not in get_args(Retraction):
            raise InvalidInputError(f"retraction: must be one of {get_args(Retraction)}, found {retraction!r}")
        self._retraction: Retraction = retraction
        self._rng = np.random.default_rng(rng)
        name = f"St({n},{k})" if field == "real" else f"St({n},{k},C)"
        super().__init__(f"Stiefel manifold {name}, alpha = {self.stiefel.alpha:g}", self.stiefel.dim)

    @property
    def typical_dist(self) -> float:
        """Length scale of the manifold, the norm of a point; sets the radii of trust regions."""
        return float(np.sqrt(self.stiefel.k))

    def inner_product(self, point: _Array, tangent_vector_a: _Array, tangent_vector_b: _Array) -> float:
        """Return the inner product of two tangent vectors."""
        return float(self.stiefel.inner(point, tangent_vector_a, tangent_vector_b))

    def norm(self, point: _Array, tangent_vector: _Array) -> float:
        """Return the norm of a tangent vector."""
        return float(self.stiefel.norm(point, tangent_vector))

    def projection(self, point: _Array, vector: _Array) -> _Array:
        """Project a matrix orthogonally to the tangent space; the same for every metric of the family."""
        return self.stiefel.project_tangent(point, vector)

    to_tangent_space = projection

    def euclidean_to_riemannian_gradient(self, point: _Array, euclidean_gradient: _Array) -> _Array:
        """Return the Riemannian gradient `S skew(S^T G) / w + (I - S S^T) G`; canonical metric: `G - S G^T S`."""
        return self.stiefel.euclidean_to_riemannian_gradient(point, euclidean_gradient)

    def euclidean_to_riemannian_hessian(
        self, point: _Array, euclidean_gradient: _Array, euclidean_hessian: _Array, tangent_vector: _Array
    ) -> _Array:
        """Return the covariant derivative of the Riemannian gradient along a tangent vector."""
        return self.stiefel.euclidean_to_riemannian_hessian(
            point, euclidean_gradient, euclidean_hessian, tangent_vector
        )

    def retraction(self, point: _Array, tangent_vector: _Array) -> _Array:
        """Move a point along a tangent vector by the retraction chosen at construction."""
        return self.stiefel.retract(point, tangent_vector, kind=self._retraction)

    def exp(self, point: _Array, tangent_vector: _Array) -> _Array:
        """Return the end point of the geodesic with a given initial velocity."""
        return self.stiefel.exp(point, tangent_vector)

    def log(self, point_a: _Array, point_b: _Array) -> _Array:
        """Return the initial velocity of the shortest geodesic from one point to another."""
        return self.stiefel.log(point_a, point_b)

    def dist(self, point_a: _Array, point_b: _Array) -> float:
        """Return the length of the shortest geodesic between two points."""
        return float(self.stiefel.dist(point_a, point_b))

    def pair_mean(self, point_a: _Array, point_b: _Array) -> _Array:
        """Return the midpoint of the shortest geodesic between two points."""
        return self.exp(point_a, self.log(point_a, point_b) / 2)

    def transport(self, point_a: _Array, point_b: _Array, tangent_vector_a: _Array) -> _Array:
        """Transport a vector by projection to the tangent space at `point_b`, as conjugate gradients need."""
        return self.projection(point_b, tangent_vector_a)

    def random_point(self) -> _Array:
        """Draw a uniformly distributed point, with the given `determinant` if any."""
        S = self.stiefel.random_point(self._rng)
        if self._determinant is not None and np.linalg.det(S) * self._determinant < 0.0:
            S[:, -1] *= -1.0
        return S

    def random_tangent_vector(self, point: _Array) -> _Array:
        """Draw a tangent vector of norm 1; zero on St(1, 1), whose tangent spaces are trivial."""
        if not self.stiefel.dim:
            return self.zero_vector(point)
        V = self.stiefel.random_tangent(point, self._rng)
        return np.asarray(V / self.norm(point, V))

    def zero_vector(self, point: _Array) -> _Array:
        """Return the zero vector of the tangent space."""
        number = np.float64 if self.stiefel.field == "real" else np.complex128
        return np.zeros((self.stiefel.n, self.stiefel.k), dtype=number)


class GrassmannManifold(Manifold):
    """Grassmann manifold `Gr(n, k)` for pymanopt's optimisers. The retraction is the exponential.

    Parameters
    ----------
    n, k : int
        Numbers of rows and columns of bases, `1 <= k <= n`.
    field : "real" or "complex"
        Field of the entries. Gradients for complex bases are matrices `G` with `df = Re sum(conj(G) V)`.
    rng : numpy.random.Generator or int or None
        Source of random points and tangent vectors.

    Attributes
    ----------
    grassmann : Grassmann
        The underlying manifold.

    Notes
    -----
    Cost functions must depend on the subspace alone: `f(Y Q) = f(Y)` for orthogonal `Q`. `log` and `pair_mean` raise an
    `OutsideDomainError` if a principal angle is pi/2 to working precision, which does not happen for random points.

    Examples
    --------
    >>> import numpy as np, pymanopt
    >>> from pymanopt.optimizers import TrustRegions
    >>> from stiefel_rs.pymanopt import GrassmannManifold
    >>> A, M = np.diag([4.0, 3.0, 2.0, 1.0]), GrassmannManifold(4, 2, rng=1)
    >>> cost = pymanopt.function.numpy(M)(lambda Y: -np.sum(Y * (A @ Y)))
    >>> gradient = pymanopt.function.numpy(M)(lambda Y: -2 * A @ Y)
    >>> hessian = pymanopt.function.numpy(M)(lambda Y, V: -2 * A @ V)
    >>> problem = pymanopt.Problem(M, cost, euclidean_gradient=gradient, euclidean_hessian=hessian)
    >>> round(float(TrustRegions(verbosity=0).run(problem).cost), 12)
    -7.0
    """

    def __init__(
        self,
        n: int,
        k: int,
        *,
        field: Literal["real", "complex"] = "real",
        rng: np.random.Generator | int | None = None,
    ) -> None:
        self.grassmann = Grassmann(n, k, field=field)
        self._rng = np.random.default_rng(rng)
        numbers = "" if field == "real" else ",C"
        super().__init__(f"Grassmann manifold Gr({n},{k}{numbers})", self.grassmann.dim)

    @property
    def typical_dist(self) -> float:
        """Length scale of the manifold, the norm of a point; sets the radii of trust regions."""
        return float(np.sqrt(self.grassmann.k))

    def inner_product(self, point: _Array, tangent_vector_a: _Array, tangent_vector_b: _Array) -> float:
        """Return the inner product of two tangent vectors."""
        return float(self.grassmann.inner(point, tangent_vector_a, tangent_vector_b))

    def norm(self, point: _Array, tangent_vector: _Array) -> float:
        """Return the norm of a tangent vector."""
        return float(self.grassmann.norm(point, tangent_vector))

    def projection(self, point: _Array, vector: _Array) -> _Array:
        """Project a matrix orthogonally to the horizontal vectors."""
        return self.grassmann.project_tangent(point, vector)

    to_tangent_space = projection

    def euclidean_to_riemannian_gradient(self, point: _Array, euclidean_gradient: _Array) -> _Array:
        """Return the Riemannian gradient `(I - Y Y^T) G`."""
        return self.grassmann.euclidean_to_riemannian_gradient(point, euclidean_gradient)

    def euclidean_to_riemannian_hessian(
        self, point: _Array, euclidean_gradient: _Array, euclidean_hessian: _Array, tangent_vector: _Array
    ) -> _Array:
        """Return the covariant derivative of the Riemannian gradient along a tangent vector."""
        return self.grassmann.euclidean_to_riemannian_hessian(
            point, euclidean_gradient, euclidean_hessian, tangent_vector
        )

    def exp(self, point: _Array, tangent_vector: _Array) -> _Array:
        """Return the end point of the geodesic with a given initial velocity."""
        return self.grassmann.exp(point, tangent_vector)

    retraction = exp

    def log(self, point_a: _Array, point_b: _Array) -> _Array:
        """Return the initial velocity of the shortest geodesic from one point to another."""
        return self.grassmann.log(point_a, point_b)

    def dist(self, point_a: _Array, point_b: _Array) -> float:
        """Return the length of the shortest geodesic between two points."""
        return float(self.grassmann.dist(point_a, point_b))

    def pair_mean(self, point_a: _Array, point_b: _Array) -> _Array:
        """Return the midpoint of the shortest geodesic between two points."""
        return self.exp(point_a, self.log(point_a, point_b) / 2)

    def transport(self, point_a: _Array, point_b: _Array, tangent_vector_a: _Array) -> _Array:
        """Transport a vector by projection to the tangent space at `point_b`, as conjugate gradients need."""
        return self.projection(point_b, tangent_vector_a)

    def random_point(self) -> _Array:
        """Draw a uniformly distributed point."""
        return self.grassmann.random_point(self._rng)

    def random_tangent_vector(self, point: _Array) -> _Array:
        """Draw a tangent vector of norm 1; zero for `k = n`, where tangent spaces are trivial."""
        if not self.grassmann.dim:
            return self.zero_vector(point)
        V = self.grassmann.random_tangent(point, self._rng)
        return np.asarray(V / self.norm(point, V))

    def zero_vector(self, point: _Array) -> _Array:
        """Return the zero vector of the tangent space."""
        number = np.float64 if self.grassmann.field == "real" else np.complex128
        return np.zeros((self.grassmann.n, self.grassmann.k), dtype=number)
