"""Errors: against numbers of steps, and against time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator
from numpy.typing import ArrayLike

from .._core import Curve
from ..errors import InvalidInputError
from ..figure_style import GRID, SMALL_FONT
from ..palette import INK
from ._axes import TIME_LABEL, cycled, drawn, flat, label, line_style
from ._samples import Array, count, finite, number

MAX_TICKS: Final = 8
# Height of a row of a legend in inches.
ROW: Final = 0.17
MARKERS: Final = "osD^vP"
# Errors of this size are round-off: they say nothing about an order.
ROUND_OFF: Final = 1e-14


def _steps(steps: ArrayLike) -> Array:
    found = finite(steps, "steps", 1)
    if (found <= 0).any() or len(np.unique(found)) != len(found):
        raise InvalidInputError(f"steps: distinct positive numbers expected, found {found}")
    return found


def _errors(errors: ArrayLike, steps: Array, name: str) -> Array:
    found = finite(errors, name, 1)
    if len(found) != len(steps):
        raise InvalidInputError(
            f"{name}: {len(steps)} errors expected, one for each number of steps, found {len(found)}"
        )
    if (found < 0).any():
        raise InvalidInputError(f"{name}: no negative error expected, found {found.min()}")
    return found


def fitted_order(steps: ArrayLike, errors: ArrayLike, *, floor: float = ROUND_OFF) -> float | None:
    """Order ``p`` of errors that go like ``steps ** -p``: least squares of the logarithms.

    Parameters
    ----------
    steps : array_like, shape (m,)
        Numbers of steps, distinct.
    errors : array_like, shape (m,)
        Errors, not negative.
    floor : float, default 1e-14
        Errors up to here are round-off and do not count.

    Returns
    -------
    float or None
        None where fewer than two errors count.

    Raises
    ------
    InvalidInputError
        Shapes do not match, or numbers are not positive and finite.
    """
    N = _steps(steps)
    found = _errors(errors, N, "errors")
    used = found > number(floor, "floor", "a number of zero or more", lambda x: x >= 0)
    if np.count_nonzero(used) < 2:
        return None
    x, y = np.log(N[used]), np.log(found[used])
    x = x - x.mean()
    return float(-(x @ y) / (x @ x))


def convergence(
    steps: ArrayLike,
    errors: ArrayLike | Mapping[str, ArrayLike],
    *,
    ax: Axes | None = None,
    floor: float = ROUND_OFF,
    **style: Any,
) -> Axes:
    """Draw errors against numbers of steps, both logarithmic, with the fitted orders in the legend.

    Parameters
    ----------
    steps : array_like, shape (m,)
        Numbers of steps, distinct.
    errors : array_like of shape (m,), or mapping of names to such
        Errors of one method, or of several by name. An error of zero has no place on the axis and is left out.
    ax : Axes, optional
        Axes to draw into; new ones by default.
    floor : float, default 1e-14
        Errors up to here do not count for the order.
    **style
        For the lines; a ``label`` comes before the names.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInputError
        Shapes do not match, numbers are not positive and finite, `ax` is not flat, `style` is not that of a line.
    """
    N = _steps(steps)
    order = np.argsort(N)
    named = errors if isinstance(errors, Mapping) else {"": errors}
    if not named:
        raise InvalidInputError("errors: at least one method expected, found none")
    style, ax, rows = line_style(style), flat(ax), []
    for name, values in named.items():
        found = _errors(values, N, f"errors of {name}" if name else "errors")
        rows.append((name, found, fitted_order(N, found, floor=floor)))
    # Scales come first: limits that lines without any positive error got on linear axes are no logarithmic ones.
    ax.set(xscale="log", yscale="log", xlabel="number of steps", ylabel="error")
    for i, (name, found, p) in enumerate(rows, start=drawn(ax)):
        own = cycled(i) | {"marker": MARKERS[i % len(MARKERS)], "markerfacecolor": "white"}
        said = label(style, name, "no order" if p is None else f"order {p:.2f}")
        shown = np.where(found > 0, found, np.nan)[order]
        ax.plot(N[order], shown, **(own | style | {"label": said}))
    if len(N) <= MAX_TICKS:
        ax.set_xticks(N[order], [f"{x:g}" for x in N[order]])
        ax.xaxis.set_minor_locator(NullLocator())
    ax.grid(**GRID)
    legend = ax.legend(frameon=False, fontsize=SMALL_FONT, labelcolor=INK, loc="lower left")
    _leave_room(ax, len(legend.get_texts()))
    return ax


def _leave_room(ax: Axes, rows: int) -> None:
    """Let the axis of errors begin so far below them that a legend of so many rows covers none."""
    values = np.concatenate([np.asarray(line.get_ydata(), dtype=np.float64) for line in ax.lines])
    values = values[np.isfinite(values) & (values > 0)]
    height = ax.get_window_extent().height / ax.figure.dpi
    share = min((rows + 0.5) * ROW / height, 0.6)
    if len(values):
        low, high = np.log10(values.min()), np.log10(values.max())
        ax.update_datalim([(ax.dataLim.x0, 10 ** (low - share / (1 - share) * max(high - low, 0.1)))])
        ax.autoscale_view()


def error(curve: Curve, reference: Curve, *, ax: Axes | None = None, num: int = 200, **style: Any) -> Axes:
    """Draw the Frobenius distance of two curves against time, on a logarithmic axis.

    Parameters
    ----------
    curve, reference : Curve
        Curves on the same manifold, over the same times.
    ax : Axes, optional
        Axes to draw into; new ones by default.
    num : int, default 200
        Equidistant times. Where the curves meet exactly there is no logarithm, and a gap.
    **style
        For the line.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInputError
        No curves, or curves on different manifolds or over different times; `ax` is not flat, `style` is not that of
        a line.
    """
    for name, one in (("curve", curve), ("reference", reference)):
        if not isinstance(one, Curve):
            raise InvalidInputError(f"{name}: a Curve expected, found {type(one).__name__}")
    if (curve.n, curve.k, curve.t_span) != (reference.n, reference.k, reference.t_span):
        first, second = (f"St({c.n},{c.k}) over {c.t_span}" for c in (curve, reference))
        raise InvalidInputError(
            f"curve and reference: the same manifold and times expected, found {first} and {second}"
        )
    t = np.linspace(*curve.t_span, count(num))
    distance = np.linalg.norm(curve(t) - reference(t), axis=(1, 2))
    style, ax = line_style(style), flat(ax)
    ax.plot(t, np.where(distance > 0, distance, np.nan), **(cycled(drawn(ax)) | style))
    ax.set(yscale="log", xlabel=TIME_LABEL, ylabel="Frobenius distance")
    ax.grid(**GRID)
    return ax
