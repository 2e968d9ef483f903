"""Sweeps of splines: many curves, each through many points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiefel_rs
from stiefel_rs.errors import InvalidInputError

from . import _blocks, _manifold_option, _records
from ._blocks import Batch
from ._boundary import Kind, member
from ._manifold import Description
from ._manifold_option import AnyManifold
from ._records import OnError
from ._sweep import Sweep, checked_times

Velocities = Literal["catmull-rom", "akima", "natural"]
Ends = Literal["natural", "clamped", "periodic"]

DEFAULT_CHUNK = {"riemannian": 50, "geometric": 50}
_FIELDS = ("velocities", "cost", *_records.SOLVER, *_records.FAILURE)


def splines(
    t: Batch,
    S: Batch,
    V: Batch | Velocities | None = None,
    *,
    bc_type: Ends = "natural",
    kind: Kind = "riemannian",
    at: ArrayLike | None = None,
    fields: Sequence[str] | None = None,
    on_error: OnError = "raise",
    chunk: int | None = None,
    tol: float | None = None,
    max_iterations: int | None = None,
    manifold: AnyManifold | None = None,
) -> Sweep:
    """Interpolate the points of each member of a batch by a spline. Evaluation is lazy.

    Parameters
    ----------
    t : dask array or array_like, shape (..., N)
        Increasing times of the knots; leading axes broadcast against those of `S`.
    S : dask array or array_like, shape (..., N, n, k)
        Points.
    V : dask array or array_like, shape (..., N, n, k), or str, optional
        Velocities at the points, or the name of an estimate, for a ``CubicHermite``. By default a ``CubicSpline``.
    bc_type : "natural", "clamped" or "periodic", default "natural"
        As for ``CubicSpline``; only without `V`.
    kind : "riemannian" or "geometric", default "riemannian"
        Kind of the pieces.
    at : array_like, shape T, optional
        Times of the field ``points``, the same for all members, between the knots.
    fields, on_error, chunk
        As for :func:`solve_boundary`; by default 50 splines per task.
    tol, max_iterations
        As for ``CubicSpline``; only without `V`.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points, as for :func:`solve_boundary`.

    Returns
    -------
    Sweep
        ``velocities`` : shape (..., N, n, k), at the knots; ``splines(t, S, velocities)`` gives the same curves up to
        the tolerance, without solving again. On a :class:`Grassmann` they are vectors at the given bases `S`, which
        differ from the bases of the curve. ``points`` : shape (...) + T + (n, k), only with `at`.
        ``cost``, ``converged``, ``iterations``, ``residual``, ``code``, ``message`` : as for :func:`solve_boundary`;
        with `V` the pieces are independent, and the fields of the solver are True, 0 and 0.

    Raises
    ------
    InvalidInputError
        Mismatched shapes, a non-finite entry of an array in memory, an option out of range.
    TypeError
        The numbers are neither real nor complex, or complex on a real manifold; or times are complex.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import Stiefel
    >>> from stiefel_rs.dask import splines
    >>> S = Stiefel(3, 1).random_point(rng=1, size=(10, 4))
    >>> splines([0.0, 1.0, 2.0, 3.0], S, at=[0.5, 2.5])["points"].compute().shape
    (10, 2, 3, 1)
    """
    member("kind", kind, Kind)
    member("on_error", on_error, OnError)
    member("bc_type", bc_type, Ends)
    knots = _blocks.load("t", t, 1)
    given = {} if V is None or isinstance(V, str) else {"V": V}
    of = _manifold_option.described(manifold)
    frames, number = _blocks.frames(3, _manifold_option.number(of), S=S, **given)
    count, n, k = (int(size) for size in frames["S"].shape[-3:])
    _blocks.require_core("t", knots, (count,))
    method, options = _method(V, bc_type, tol, max_iterations)
    same = np.broadcast_to(np.eye(n, k, dtype=number), (min(count, 4), n, k))
    _try_options(kind, method, {**options, **_manifold_option.keyword(of)}, same)
    for name, array in frames.items():
        _blocks.require_core(name, array, (count, n, k))
    loaded = {"t": (knots, 1), **{name: (array, 3) for name, array in frames.items()}}
    when = None if at is None else checked_times(at)
    if when is not None and isinstance(knots, np.ndarray):
        _require_inside(when, knots)
    known = _FIELDS if when is None else (*_FIELDS, "points")
    shapes = {"velocities": (count, n, k), "points": () if when is None else (*when.shape, n, k)}
    default = known if kind == "riemannian" else tuple(name for name in known if name != "cost")
    dtype = _records.record(_records.choose(fields, known, default), shapes, number)
    chunks = _blocks.leading_chunks(loaded, chunk, DEFAULT_CHUNK[kind])
    arrays = [_blocks.align(array, core, chunks) for array, core in loaded.values()]
    settings: dict[str, Any] = {"kind": kind, "at": when, "on_error": on_error, "method": method, "options": options}
    settings |= {"manifold": of, "version": stiefel_rs.__version__}
    return Sweep(_blocks.Work(spline_block, arrays, [core for _, core in loaded.values()], dtype, settings))


def _method(
    V: Batch | Velocities | None, bc_type: Ends, tol: float | None, max_iterations: int | None
) -> tuple[str, dict[str, Any]]:
    """Return the method and its options: a spline, or velocities that are given or estimated."""
    options: dict[str, Any] = {
        name: value for name, value in (("tol", tol), ("max_iterations", max_iterations)) if value is not None
    }
    if V is None:
        return "spline", {**options, "bc_type": bc_type}
    if isinstance(V, str):
        member("V", V, Velocities)
    if options or bc_type != "natural":
        raise InvalidInputError("V: with velocities, bc_type, tol and max_iterations are not available")
    return V if isinstance(V, str) else "hermite", {}


def _require_inside(at: NDArray[np.float64], knots: NDArray[np.float64]) -> None:
    """Raise unless all times are between the knots of every member."""
    if not at.size or not knots.size:
        return
    first, last = knots[..., 0].max(), knots[..., -1].min()
    outside = at[(at < first) | (at > last)]
    if outside.size:
        raise InvalidInputError(f"at: {outside[0]} is outside the knots, which range from {first} to {last}")


def _try_options(kind: Kind, method: str, options: dict[str, Any], S: NDArray[Any]) -> None:
    """Make a spline through equal points, which raises if an option is invalid."""
    data = [np.arange(float(len(S))), S]
    _curve([*data, 0 * S] if method == "hermite" else data, kind, method, options)


def spline_block(
    *data: NDArray[np.float64],
    origin: tuple[int, ...],
    dtype: np.dtype[Any],
    kind: Kind,
    at: NDArray[np.float64] | None,
    on_error: OnError,
    method: str,
    options: dict[str, Any],
    manifold: Description | None,
    version: str,
) -> NDArray[Any]:
    """Solve for the splines of one block, one after the other."""
    _records.require_version(version)
    records = np.zeros(data[0].shape[:-1], dtype)
    keywords = {**options, **_manifold_option.keyword(manifold)}

    def solve(index: tuple[int, ...]) -> None:
        _fill(records, index, _curve([array[index] for array in data], kind, method, keywords), at)

    _records.each(records, origin, on_error, solve)
    return records


def _curve(data: list[NDArray[np.float64]], kind: Kind, method: Any, options: dict[str, Any]) -> Any:
    t, S, *rest = data
    if method == "spline":
        return stiefel_rs.CubicSpline(t, S, kind=kind, num_threads=1, **options)
    return stiefel_rs.CubicHermite(t, S, rest[0] if rest else method, kind, num_threads=1, **options)


def _fill(records: NDArray[Any], index: tuple[int, ...], curve: Any, at: NDArray[np.float64] | None) -> None:
    wanted = records.dtype.names or ()
    if "velocities" in wanted:
        records["velocities"][index] = _velocities(curve)
    if "cost" in wanted:
        records["cost"][index] = curve.cost()
    if "points" in wanted:
        records["points"][index] = curve(at, num_threads=1)
    _records.store_report(records, index, curve.report)


def _velocities(curve: Any) -> NDArray[Any]:
    """Return the velocities at the knots, for subspaces as tangent vectors at the given bases."""
    V: NDArray[Any] = curve.velocity(curve.t, num_threads=1)
    if not isinstance(curve.manifold, stiefel_rs.Grassmann):
        return V
    # Orthogonal or unitary matrices, from the bases of the curve to the given ones.
    Q: NDArray[Any] = curve(curve.t, num_threads=1).conj().swapaxes(-1, -2) @ curve.points
    at_given: NDArray[Any] = V @ Q
    return at_given
