"""Evaluation of many cubics at the same times."""

from __future__ import annotations

from typing import Any, Literal

import dask.array as da
import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiefel_rs
from stiefel_rs.errors import InvalidInputError

from . import _blocks, _manifold_option, _records
from ._blocks import Batch
from ._boundary import Kind, member
from ._manifold import Description
from ._manifold_option import AnyManifold
from ._sweep import checked_times

What = Literal["point", "velocity", "acceleration", "jerk"]
_DEFAULT_CHUNK = 2500


def evaluate(
    t: ArrayLike,
    S: Batch,
    V: Batch,
    A: Batch,
    J: Batch,
    *,
    what: What = "point",
    kind: Kind = "riemannian",
    t_end: float = 1.0,
    chunk: int | None = None,
    manifold: AnyManifold | None = None,
) -> da.Array:
    """Evaluate a cubic for each member of a batch. Evaluation is lazy.

    Parameters
    ----------
    t : array_like, shape T
        Times, the same for all members.
    S, V, A, J : dask array or array_like, shape (..., n, k)
        For Riemannian cubics: point, velocity, covariant acceleration and covariant jerk at ``t = 0``, as in the fields
        of :func:`solve_boundary`. For geometric cubics: the ends ``S0, V0, S1, V1``.
    what : "point", "velocity", "acceleration" or "jerk", default "point"
        Quantity to evaluate; acceleration and jerk are covariant.
    kind : "riemannian" or "geometric", default "riemannian"
        ``RiemannianCubic.from_initial`` or ``GeometricCubic``.
    t_end : float, default 1.0
        End of the interval of Riemannian cubics.
    chunk : int, optional
        Largest number of members per task, as for :func:`solve_boundary`; by default 2500.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points, as for :func:`solve_boundary`.

    Returns
    -------
    dask array, shape (...) + T + (n, k)

    Raises
    ------
    InvalidInputError
        Mismatched shapes, a non-finite entry of an array in memory, an option out of range.
    TypeError
        The numbers are neither real nor complex, or complex on a real manifold.

    Examples
    --------
    >>> from stiefel_rs import Stiefel
    >>> from stiefel_rs.dask import evaluate
    >>> M = Stiefel(3, 1)
    >>> S = M.random_point(rng=1, size=100)
    >>> V, A, J = (M.random_tangent(S, rng=i) for i in (2, 3, 4))
    >>> evaluate([0.0, 0.5, 1.0], S, V, A, J, chunk=50)
    dask.array<getitem, shape=(100, 3, 3, 1), dtype=float64, chunksize=(50, 3, 3, 1), chunktype=numpy.ndarray>
    """
    member("what", what, What)
    member("kind", kind, Kind)
    if kind == "geometric" and t_end != 1:
        raise InvalidInputError(f"t_end: geometric cubics end at 1, found {t_end}")
    at = checked_times(t)
    of = _manifold_option.described(manifold)
    data, number = _blocks.frames(2, _manifold_option.number(of), S=S, V=V, A=A, J=J)
    n, k = (int(size) for size in data["S"].shape[-2:])
    _try_options(kind, t_end, _manifold_option.keyword(of), np.eye(n, k, dtype=number))
    for name, array in data.items():
        _blocks.require_core(name, array, (n, k))
    dtype = np.dtype([("value", number, (*at.shape, n, k))])
    chunks = _blocks.leading_chunks({name: (array, 2) for name, array in data.items()}, chunk, _DEFAULT_CHUNK)
    arrays = [_blocks.align(array, 2, chunks) for array in data.values()]
    settings: dict[str, Any] = {"t": at, "what": what, "kind": kind, "t_end": float(t_end)}
    settings |= {"manifold": of, "version": stiefel_rs.__version__}
    return _blocks.Work(evaluate_block, arrays, [2] * 4, dtype, settings).records()["value"]


def _try_options(kind: Kind, t_end: float, keywords: dict[str, Any], S: NDArray[Any]) -> None:
    """Make a constant curve, which raises if an option is invalid."""
    rest, last = 0 * S, S if kind == "geometric" else 0 * S
    _curve([S, rest, last, rest], kind, t_end, keywords)


def evaluate_block(
    *data: NDArray[np.float64],
    origin: tuple[int, ...],
    dtype: np.dtype[Any],
    t: NDArray[np.float64],
    what: What,
    kind: Kind,
    t_end: float,
    manifold: Description | None,
    version: str,
) -> NDArray[Any]:
    """Evaluate the cubics of one block."""
    _records.require_version(version)
    records = np.zeros(data[0].shape[:-2], dtype)
    keywords = _manifold_option.keyword(manifold)

    def solve(index: tuple[int, ...]) -> None:
        curve = _curve([array[index] for array in data], kind, t_end, keywords)
        records["value"][index] = (curve if what == "point" else getattr(curve, what))(t, num_threads=1)

    _records.each(records, origin, "raise", solve)
    return records


def _curve(data: list[NDArray[Any]], kind: Kind, t_end: float, keywords: dict[str, Any]) -> Any:
    if kind == "geometric":
        return stiefel_rs.GeometricCubic(*data, **keywords)
    # Type checkers find no static methods in a class whose constructor never returns.
    cubics: Any = stiefel_rs.RiemannianCubic
    return cubics.from_initial(*data, t_end, **keywords)
