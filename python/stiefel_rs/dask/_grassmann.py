"""Maps of Grassmann manifolds for dask arrays."""

from __future__ import annotations

from typing import Literal

import dask.array as da

import stiefel_rs

from ._blocks import Batch
from ._manifold import Manifold


class Grassmann(Manifold):
    """Grassmann manifold `Gr(n, k)` with the methods of :class:`stiefel_rs.Grassmann`, for dask arrays.

    Points are orthonormal bases `Y` of subspaces, and tangent vectors at `Y` are horizontal, ``Y^T V = 0``. Every
    method accepts dask arrays or array-likes of shape (..., n, k), broadcasts their leading axes, and returns dask
    arrays. Errors and blocks are as for :class:`Stiefel`.

    Parameters
    ----------
    n, k : int
        Dimensions of the space and of the subspaces, ``1 <= k <= n``.
    field : "real" or "complex", default "real"
        As for :class:`stiefel_rs.Grassmann`.

    Examples
    --------
    >>> import dask.array as da
    >>> from stiefel_rs.dask import Grassmann
    >>> M = Grassmann(5, 2)
    >>> Y = M.project(da.random.default_rng(1).standard_normal((1000, 5, 2), chunks=(250, 5, 2)))
    >>> M.principal_angles(Y[1:], Y[:-1]).max(axis=0).compute().round(1).tolist()
    [1.6, 1.4]
    """

    def __init__(self, n: int, k: int, *, field: Literal["real", "complex"] = "real") -> None:
        super().__init__(stiefel_rs.Grassmann(n, k, field=field))

    def __repr__(self) -> str:
        return f"stiefel_rs.dask.{self._manifold!r}"

    def project(self, Y: Batch) -> da.Array:
        """Return the orthonormal bases of column spaces nearest to `Y`, shape (..., n, k)."""
        return self._vectors("project", Y=Y)

    def project_tangent(self, Y: Batch, Z: Batch) -> da.Array:
        """Return the tangent vectors at `Y` nearest to `Z`, shape (..., n, k)."""
        return self._vectors("project_tangent", Y=Y, Z=Z)

    def inner(self, Y: Batch, V: Batch, W: Batch) -> da.Array:
        """Return inner products of tangent vectors, shape (...)."""
        return self._numbers("inner", Y=Y, V=V, W=W)

    def norm(self, Y: Batch, V: Batch) -> da.Array:
        """Return norms of tangent vectors, shape (...)."""
        return self._numbers("norm", Y=Y, V=V)

    def principal_angles(self, Y0: Batch, Y1: Batch) -> da.Array:
        """Return principal angles between subspaces in decreasing order, shape (..., k)."""
        return self._records("principal_angles", [("angles", (self.k,))], {}, Y0=Y0, Y1=Y1)["angles"]

    def align(self, Y0: Batch, Y1: Batch) -> da.Array:
        """Return the bases of the subspaces of `Y1` nearest to `Y0`, shape (..., n, k)."""
        return self._vectors("align", Y0=Y0, Y1=Y1)

    def projector(self, Y: Batch) -> da.Array:
        """Return orthogonal projectors to subspaces, shape (..., n, n)."""
        return self._records("projector", [("value", (self.n, self.n))], {}, Y=Y)["value"]

    def exp(self, Y: Batch, V: Batch) -> da.Array:
        """Return bases at the end points of geodesics, shape (..., n, k)."""
        return self._vectors("exp", Y=Y, V=V)

    def log(self, Y0: Batch, Y1: Batch) -> da.Array:
        """Return the initial velocities at `Y0` of geodesics to the subspaces of `Y1`, shape (..., n, k)."""
        return self._vectors("log", Y0=Y0, Y1=Y1)

    def dist(self, Y0: Batch, Y1: Batch) -> da.Array:
        """Return distances of subspaces, shape (...)."""
        return self._numbers("dist", Y0=Y0, Y1=Y1)

    def transport(self, Y: Batch, V: Batch, W: Batch) -> da.Array:
        """Transport `W` in parallel along the geodesics with initial velocities `V`, shape (..., n, k)."""
        return self._vectors("transport", Y=Y, V=V, W=W)

    def curvature(self, Y: Batch, U: Batch, V: Batch, W: Batch) -> da.Array:
        """Apply the curvature tensor to tangent vectors, shape (..., n, k)."""
        return self._vectors("curvature", Y=Y, U=U, V=V, W=W)

    def sectional_curvature(self, Y: Batch, U: Batch, V: Batch) -> da.Array:
        """Return the sectional curvatures of planes, shape (...)."""
        return self._numbers("sectional_curvature", Y=Y, U=U, V=V)

    def euclidean_to_riemannian_gradient(self, Y: Batch, G: Batch) -> da.Array:
        """Return Riemannian gradients, shape (..., n, k)."""
        return self._vectors("euclidean_to_riemannian_gradient", Y=Y, G=G)

    def euclidean_to_riemannian_hessian(self, Y: Batch, G: Batch, H: Batch, V: Batch) -> da.Array:
        """Apply Riemannian Hessians to tangent vectors, shape (..., n, k)."""
        return self._vectors("euclidean_to_riemannian_hessian", Y=Y, G=G, H=H, V=V)
