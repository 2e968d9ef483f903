"""Maps of the manifold and of rotations for dask arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, TypeAlias

import dask.array as da
import numpy as np
from numpy.typing import NDArray

import stiefel_rs
from stiefel_rs.errors import StiefelError

from . import _blocks
from ._blocks import Batch
from ._boundary import member
from ._errors import of_batch
from ._records import require_version

Retraction = Literal["quasi_geodesic", "qr", "polar", "cayley"]
Layout: TypeAlias = list[tuple[str, tuple[int, ...]]]
_DEFAULT_CHUNK = 10_000
_REPORT = ("converged", "iterations", "residual", "length", "certainly_shortest")


class Stiefel:
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
        self._manifold = stiefel_rs.Stiefel(n, k, metric=metric, field=field)
        self.n, self.k, self.dim, self.alpha = n, k, self._manifold.dim, self._manifold.alpha
        self.field = field

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
        layout: Layout = [("V", (self.n, self.k)), *((name, ()) for name in _REPORT)]
        found = self._records("log", layout, {"full_output": True}, S0=S0, S1=S1)
        return found["V"], {name: found[name] for name in _REPORT}

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

    def _vectors(self, method: str, keywords: dict[str, Any] | None = None, /, **arrays: Batch) -> da.Array:
        return self._records(method, [("value", (self.n, self.k))], keywords or {}, **arrays)["value"]

    def _numbers(self, method: str, /, **arrays: Batch) -> da.Array:
        return self._records(method, [("value", ())], {}, **arrays)["value"]

    def _records(self, method: str, layout: Layout, keywords: dict[str, Any], /, **arrays: Batch) -> da.Array:
        sizes = {"X": (self.n, self.n), "Omega": (self.k, self.k)}
        number: _blocks.Number = np.float64 if self.field == "real" else np.complex128
        loaded = {name: _blocks.load(name, array, 2, number) for name, array in arrays.items()}
        for name, array in loaded.items():
            _blocks.require_core(name, array, sizes.get(name, (self.n, self.k)))
        of = {"n": self.n, "k": self.k, "metric": self.alpha, "field": self.field}
        return _map(method_block, loaded, layout, {"name": method, "of": of, "keywords": keywords}, number)


def skew_exp(A: Batch) -> da.Array:
    """Return exponentials of skew-symmetric matrices, shape (..., m, m); see :func:`stiefel_rs.skew_exp`."""
    return _square("skew_exp", "A", A)


def orthogonal_log(Q: Batch) -> da.Array:
    """Return principal logarithms of rotations, shape (..., m, m); see :func:`stiefel_rs.orthogonal_log`."""
    return _square("orthogonal_log", "Q", Q)


def _square(function: str, name: str, array: Batch) -> da.Array:
    lazy = _blocks.load(name, array, 2)
    m = int(lazy.shape[-1])
    _blocks.require_core(name, lazy, (m, m))
    return _map(function_block, {name: lazy}, [("value", (m, m))], {"name": function})["value"]


def _map(
    task: Any,
    arrays: dict[str, _blocks.Loaded],
    layout: Layout,
    settings: dict[str, Any],
    number: _blocks.Number = np.float64,
) -> da.Array:
    chunks = _blocks.leading_chunks({name: (array, 2) for name, array in arrays.items()}, None, _DEFAULT_CHUNK)
    types = {"converged": np.bool_, "iterations": np.int64, "certainly_shortest": np.bool_}
    of_matrices = [types.get(field, number if shape else np.float64) for field, shape in layout]
    dtype = np.dtype([(field, of, shape) for of, (field, shape) in zip(of_matrices, layout, strict=True)])
    aligned = [_blocks.align(array, 2, chunks) for array in arrays.values()]
    settings = {**settings, "version": stiefel_rs.__version__}
    return _blocks.Work(task, aligned, [2] * len(aligned), dtype, settings).records()


def method_block(
    *blocks: NDArray[np.float64],
    origin: tuple[int, ...],
    dtype: np.dtype[Any],
    name: str,
    version: str,
    of: dict[str, Any],
    keywords: dict[str, Any],
) -> NDArray[Any]:
    """Run a method of the manifold on one block."""
    manifold = stiefel_rs.Stiefel(**of)
    return _filled(lambda: getattr(manifold, name)(*blocks, **keywords), blocks[0].shape[:-2], origin, dtype, version)


def function_block(
    block: NDArray[np.float64], *, origin: tuple[int, ...], dtype: np.dtype[Any], name: str, version: str
) -> NDArray[Any]:
    """Run a function of matrices on one block."""
    function = getattr(stiefel_rs, name)
    return _filled(lambda: function(block, num_threads=1), block.shape[:-2], origin, dtype, version)


def _filled(
    call: Callable[[], Any], shape: tuple[int, ...], origin: tuple[int, ...], dtype: np.dtype[Any], version: str
) -> NDArray[Any]:
    require_version(version)
    records = np.empty(shape, dtype)
    try:
        found = call()
    except StiefelError as error:
        raise of_batch(error, origin, shape) from None
    parts = found if isinstance(found, tuple) else (found,)
    for name in dtype.names or ():
        if name in _REPORT:
            records[name] = getattr(parts[-1], name)
    for name, part in zip((name for name in dtype.names or () if name not in _REPORT), parts, strict=False):
        records[name] = part
    return records
