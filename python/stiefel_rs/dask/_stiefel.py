"""Maps of Stiefel manifolds for dask arrays."""

from __future__ import annotations

from typing import Literal

import dask.array as da

import stiefel_rs

from ._blocks import Batch
from ._boundary import member
from ._manifold import Manifold
from ._maps import REPORT, Layout

Retraction = Literal["quasi_geodesic", "qr", "polar", "cayley"]


class Stiefel(Manifold):
    """Stiefel manifold `St(n, k)` with the methods of :class:`stiefel_rs.Stiefel`, for dask arrays.

    Every method accepts dask arrays or array-likes of shape (..., n, k), broadcasts their leading axes, and returns
    dask arrays. Computing these raises the same errors as the method of :class:`stiefel_rs.Stiefel`, with the index of
    the member in the attribute ``problem``. Blocks along the leading axes are those of the first argument that has all
    of them in more than one block, or else have 10000 members; the last two axes form one block.

    Parameters
    ----------
    n, k : int
        Numbers of rows and columns, ``1 <= k <= n``.
    metric : "canonical", "euclidean" or float, default "canonical"
        As for :class:`stiefel_rs.Stiefel`.
    field : "real" or "complex", default "real"
        As for :class:`stiefel_rs.Stiefel`.

    Examples
    --------
    >>> import dask.array as da
    >>> from stiefel_rs.dask import Stiefel
    >>> M = Stiefel(5, 2)
    >>> S = M.project(da.random.default_rng(1).standard_normal((1000, 5, 2), chunks=(250, 5, 2)))
    >>> bool(M.dist(S[1:], S[:-1]).mean().compute() > 1)
    True
    """

    def __init__(
        self, n: int, k: int, *, metric: str | float | None = None, field: Literal["real", "complex"] = "real"
    ) -> None:
        manifold = stiefel_rs.Stiefel(n, k, metric=metric, field=field)
        super().__init__(manifold, X=(n, n), Omega=(k, k))
        self.alpha = manifold.alpha

    def __repr__(self) -> str:
        field = "" if self.field == "real" else f", field={self.field!r}"
        return f"stiefel_rs.dask.Stiefel({self.n}, {self.k}, metric={self.alpha}{field})"

    def project(self, Y: Batch) -> da.Array:
        """Return the nearest points, shape (..., n, k)."""
        return self._vectors("project", Y=Y)

    def project_tangent(self, S: Batch, Z: Batch) -> da.Array:
        """Return the tangent vectors at `S` nearest to `Z`, shape (..., n, k)."""
        return self._vectors("project_tangent", S=S, Z=Z)

    def inner(self, S: Batch, V: Batch, W: Batch) -> da.Array:
        """Return inner products of tangent vectors, shape (...)."""
        return self._numbers("inner", S=S, V=V, W=W)

    def norm(self, S: Batch, V: Batch) -> da.Array:
        """Return norms of tangent vectors, shape (...)."""
        return self._numbers("norm", S=S, V=V)

    def decompose(self, S: Batch, V: Batch) -> tuple[da.Array, da.Array]:
        """Return the pairs ``(X, Omega)`` with ``V = X S + S Omega``, shapes (..., n, n) and (..., k, k)."""
        found = self._records("decompose", [("X", (self.n, self.n)), ("Omega", (self.k, self.k))], {}, S=S, V=V)
        return found["X"], found["Omega"]

    def compose(self, S: Batch, X: Batch, Omega: Batch) -> da.Array:
        """Return the tangent vectors ``X S + S Omega``, shape (..., n, k)."""
        return self._vectors("compose", S=S, X=X, Omega=Omega)

    def exp(self, S: Batch, V: Batch) -> da.Array:
        """Return the end points of geodesics, shape (..., n, k)."""
        return self._vectors("exp", S=S, V=V)

    def log(self, S0: Batch, S1: Batch) -> da.Array:
        """Return the initial velocities of geodesics from `S0` to `S1`, shape (..., n, k)."""
        return self._vectors("log", S0=S0, S1=S1)

    def log_report(self, S0: Batch, S1: Batch) -> tuple[da.Array, dict[str, da.Array]]:
        """Return logarithms, and the report of ``log(..., full_output=True)`` as a dictionary of arrays."""
        layout: Layout = [("V", (self.n, self.k)), *((name, ()) for name in REPORT)]
        found = self._records("log", layout, {"full_output": True}, S0=S0, S1=S1)
        return found["V"], {name: found[name] for name in REPORT}

    def dist(self, S0: Batch, S1: Batch) -> da.Array:
        """Return distances, shape (...)."""
        return self._numbers("dist", S0=S0, S1=S1)

    def retract(self, S: Batch, V: Batch, kind: Retraction = "quasi_geodesic") -> da.Array:
        """Return retractions of tangent vectors, shape (..., n, k)."""
        member("kind", kind, Retraction)
        return self._vectors("retract", {"kind": kind}, S=S, V=V)

    def inverse_retract(self, S0: Batch, S1: Batch, kind: Retraction = "quasi_geodesic") -> da.Array:
        """Return the tangent vectors at `S0` whose retractions are `S1`, shape (..., n, k)."""
        member("kind", kind, Retraction)
        return self._vectors("inverse_retract", {"kind": kind}, S0=S0, S1=S1)

    def transport(self, S: Batch, V: Batch, W: Batch) -> da.Array:
        """Transport `W` in parallel along the geodesics with initial velocities `V`, shape (..., n, k)."""
        return self._vectors("transport", S=S, V=V, W=W)

    def curvature(self, S: Batch, U: Batch, V: Batch, W: Batch) -> da.Array:
        """Apply the curvature tensor to tangent vectors, shape (..., n, k)."""
        return self._vectors("curvature", S=S, U=U, V=V, W=W)

    def sectional_curvature(self, S: Batch, U: Batch, V: Batch) -> da.Array:
        """Return the sectional curvatures of planes, shape (...)."""
        return self._numbers("sectional_curvature", S=S, U=U, V=V)

    def euclidean_to_riemannian_gradient(self, S: Batch, G: Batch) -> da.Array:
        """Return Riemannian gradients, shape (..., n, k)."""
        return self._vectors("euclidean_to_riemannian_gradient", S=S, G=G)

    def euclidean_to_riemannian_hessian(self, S: Batch, G: Batch, H: Batch, V: Batch) -> da.Array:
        """Apply Riemannian Hessians to tangent vectors, shape (..., n, k)."""
        return self._vectors("euclidean_to_riemannian_hessian", S=S, G=G, H=H, V=V)
