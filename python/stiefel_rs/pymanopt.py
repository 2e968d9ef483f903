"""`Stiefel` and `Grassmann` as manifolds of pymanopt, whose solvers then run on them. Needs the extra `pymanopt`.

`StiefelManifold` works for the whole alpha family of metrics, canonical and Euclidean among them. With
`w = 1 / (2 (alpha + 1))` (1/2 for the canonical metric, 1 for the Euclidean one) and `V = S Omega + K`, `S^T K = 0`,
the metric is `<K_V, K_W> + w <Omega_V, Omega_W>`. pymanopt's own `Stiefel` has the Euclidean metric only, and neither
logarithm nor distance. `GrassmannManifold` has the metric of pymanopt's `Grassmann`, and distances that keep their
digits for small angles.

Sources: Edelman, Arias, Smith (1998), section 2.4 (canonical metric); Hueper, Markina, Silva Leite (2021) (the family).
"""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pymanopt.manifolds.manifold import Manifold

from ._core import Grassmann, Stiefel

__all__ = ["GrassmannManifold", "StiefelManifold"]

_Array = NDArray[Any]

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
    field : "real" or "complex"
        Of what numbers points consist. Gradients of complex frames are matrices `G` with `df = Re tr G^H V`.
    determinant : {1, -1, None}
        For ``k = n``, where the manifold is O(n): the component that random points lie in, by its determinant. By
        default they lie in both.

    Attributes
    ----------
    stiefel : Stiefel
        The manifold that does the work.

    Notes
    -----
    `log`, `dist` and `pair_mean`, which particle swarms and the Nelder-Mead method call, look for a shortest geodesic.
    Between random points, mostly farther apart than the injectivity radius, that search fails with a `ConvergenceError`
    for about one pair in a hundred on St(4, 2) and St(5, 3) with the Euclidean metric, and for none of 300 with the
    canonical one.

    O(n), which is the manifold for ``k = n``, has two components, of determinant 1 and -1, that no curve joins. Solvers
    that go along curves stay in the component of their first point; random points lie in either with equal chance.
    Particle swarms and the Nelder-Mead method start from many random points and join them, which raises an
    `OutsideDomainError` unless all lie in one component: give ``determinant=1`` (rotations) or ``determinant=-1``, and
    solve twice where the best point may lie in either. For ``k < n`` the manifold is connected.

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
            raise ValueError(f"determinant: must be 1, -1 or None, found {determinant!r}")
        if determinant is not None and n != k:
            raise ValueError(f"determinant: points of St({n}, {k}) have none")
        if determinant is not None and field == "complex":
            raise ValueError("determinant: of unitary matrices it is any number of modulus 1")
        self._determinant = determinant
        if retraction not in get_args(Retraction):
            raise ValueError(f"retraction: must be one of {get_args(Retraction)}, found {retraction!r}")
        self._retraction: Retraction = retraction
        self._rng = np.random.default_rng(rng)
        name = f"St({n},{k})" if field == "real" else f"St({n},{k},C)"
        super().__init__(f"Stiefel manifold {name}, alpha = {self.stiefel.alpha:g}", self.stiefel.dim)

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
        return self.stiefel.euclidean_to_riemannian_gradient(point, euclidean_gradient)

    def euclidean_to_riemannian_hessian(
        self, point: _Array, euclidean_gradient: _Array, euclidean_hessian: _Array, tangent_vector: _Array
    ) -> _Array:
        """Covariant derivative of the Riemannian gradient along a tangent vector."""
        return self.stiefel.euclidean_to_riemannian_hessian(
            point, euclidean_gradient, euclidean_hessian, tangent_vector
        )

    def retraction(self, point: _Array, tangent_vector: _Array) -> _Array:
        """Step along a tangent vector, by the retraction chosen at construction."""
        return self.stiefel.retract(point, tangent_vector, kind=self._retraction)

    def exp(self, point: _Array, tangent_vector: _Array) -> _Array:
        """End point of the geodesic with a given initial velocity."""
        return self.stiefel.exp(point, tangent_vector)

    def log(self, point_a: _Array, point_b: _Array) -> _Array:
        """Velocity at the start of the shortest geodesic from one point to another."""
        return self.stiefel.log(point_a, point_b)

    def dist(self, point_a: _Array, point_b: _Array) -> float:
        """Length of the shortest geodesic between two points."""
        return float(self.stiefel.dist(point_a, point_b))

    def pair_mean(self, point_a: _Array, point_b: _Array) -> _Array:
        """Middle of the shortest geodesic between two points."""
        return self.exp(point_a, self.log(point_a, point_b) / 2)

    def transport(self, point_a: _Array, point_b: _Array, tangent_vector_a: _Array) -> _Array:
        """Vector transport by projection on the tangent space at `point_b`; conjugate gradients need no more."""
        return self.projection(point_b, tangent_vector_a)

    def random_point(self) -> _Array:
        """Uniformly distributed point, in the component of `determinant` where that was given."""
        S = self.stiefel.random_point(self._rng)
        if self._determinant is not None and np.linalg.det(S) * self._determinant < 0.0:
            S[:, -1] *= -1.0
        return S

    def random_tangent_vector(self, point: _Array) -> _Array:
        """Random tangent vector of length 1; zero where there is no other, on St(1, 1)."""
        if not self.stiefel.dim:
            return self.zero_vector(point)
        V = self.stiefel.random_tangent(point, self._rng)
        return np.asarray(V / self.norm(point, V))

    def zero_vector(self, point: _Array) -> _Array:
        """Origin of the tangent space."""
        number = np.float64 if self.stiefel.field == "real" else np.complex128
        return np.zeros((self.stiefel.n, self.stiefel.k), dtype=number)


class GrassmannManifold(Manifold):
    """The manifold `Gr(n, k)` of subspaces for pymanopt's optimisers. Solvers step along geodesics.

    Parameters
    ----------
    n, k : int
        Rows and columns of bases, `1 <= k <= n`.
    field : "real" or "complex"
        Of what numbers points are made; gradients of complex ones are those with `df = Re sum(conj(G) V)`.
    rng : numpy.random.Generator or int or None
        Source of random points and tangent vectors.

    Attributes
    ----------
    grassmann : Grassmann
        The manifold that does the work.

    Notes
    -----
    Costs have to depend on the subspace alone: `f(Y Q) = f(Y)` for orthogonal `Q`. `log` and `pair_mean` raise an
    `OutsideDomainError` where a principal angle is pi/2 to working precision; random points have no such angles.

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
        """Length scale of the manifold, the norm of a point: trust regions take their radii from it."""
        return float(np.sqrt(self.grassmann.k))

    def inner_product(self, point: _Array, tangent_vector_a: _Array, tangent_vector_b: _Array) -> float:
        """Inner product of two tangent vectors."""
        return float(self.grassmann.inner(point, tangent_vector_a, tangent_vector_b))

    def norm(self, point: _Array, tangent_vector: _Array) -> float:
        """Length of a tangent vector."""
        return float(self.grassmann.norm(point, tangent_vector))

    def projection(self, point: _Array, vector: _Array) -> _Array:
        """Orthogonal projection of a matrix on the horizontal vectors."""
        return self.grassmann.project_tangent(point, vector)

    to_tangent_space = projection

    def euclidean_to_riemannian_gradient(self, point: _Array, euclidean_gradient: _Array) -> _Array:
        """Riemannian gradient, `(I - Y Y^T) G`."""
        return self.grassmann.euclidean_to_riemannian_gradient(point, euclidean_gradient)

    def euclidean_to_riemannian_hessian(
        self, point: _Array, euclidean_gradient: _Array, euclidean_hessian: _Array, tangent_vector: _Array
    ) -> _Array:
        """Covariant derivative of the Riemannian gradient along a tangent vector."""
        return self.grassmann.euclidean_to_riemannian_hessian(
            point, euclidean_gradient, euclidean_hessian, tangent_vector
        )

    def exp(self, point: _Array, tangent_vector: _Array) -> _Array:
        """End point of the geodesic with a given initial velocity."""
        return self.grassmann.exp(point, tangent_vector)

    retraction = exp

    def log(self, point_a: _Array, point_b: _Array) -> _Array:
        """Velocity at the start of the shortest geodesic from one point to another."""
        return self.grassmann.log(point_a, point_b)

    def dist(self, point_a: _Array, point_b: _Array) -> float:
        """Length of the shortest geodesic between two points."""
        return float(self.grassmann.dist(point_a, point_b))

    def pair_mean(self, point_a: _Array, point_b: _Array) -> _Array:
        """Middle of the shortest geodesic between two points."""
        return self.exp(point_a, self.log(point_a, point_b) / 2)

    def transport(self, point_a: _Array, point_b: _Array, tangent_vector_a: _Array) -> _Array:
        """Vector transport by projection on the tangent space at `point_b`; conjugate gradients need no more."""
        return self.projection(point_b, tangent_vector_a)

    def random_point(self) -> _Array:
        """Uniformly distributed point."""
        return self.grassmann.random_point(self._rng)

    def random_tangent_vector(self, point: _Array) -> _Array:
        """Random tangent vector of length 1; zero where there is no other, for `k = n`."""
        if not self.grassmann.dim:
            return self.zero_vector(point)
        V = self.grassmann.random_tangent(point, self._rng)
        return np.asarray(V / self.norm(point, V))

    def zero_vector(self, point: _Array) -> _Array:
        """Origin of the tangent space."""
        number = np.float64 if self.grassmann.field == "real" else np.complex128
        return np.zeros((self.grassmann.n, self.grassmann.k), dtype=number)
