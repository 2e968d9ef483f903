"""What a Riemannian cubic keeps: energy and momentum, along discrete trajectories."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from .._core import ChartTrajectory, CubicTrajectory, RiemannianCubic
from ..errors import InvalidInputError
from ..figure_style import GRID
from ._axes import cycled, drawn, flat, line_style, time_label
from ._samples import Array, Trajectory, trajectory_times


def _checked(trajectory: Trajectory) -> None:
    if not isinstance(trajectory, CubicTrajectory | ChartTrajectory):
        raise InvalidInputError(
            f"trajectory: a CubicTrajectory or ChartTrajectory expected, found {type(trajectory).__name__}"
        )


def _draw(ax: Any, times: tuple[Array, bool], values: Array, label: str, style: dict[str, Any]) -> Axes:
    style, axes, (t, timed) = line_style(style), flat(ax), times
    # The first is the start itself: zero, which has no logarithm. So have exact returns to it.
    axes.plot(t[1:], np.where(values[1:] > 0, values[1:], np.nan), **(cycled(drawn(axes)) | style))
    axes.set(yscale="log", xlabel=time_label(timed), ylabel=label)
    axes.grid(**GRID)
    return axes


def energy(trajectory: Trajectory, *, ax: Axes | None = None, t: ArrayLike | None = None, **style: Any) -> Axes:
    """Draw how far the energy is from its start, ``|H(t) - H(0)|``, on a logarithmic axis.

    Parameters
    ----------
    trajectory : CubicTrajectory or ChartTrajectory
        Of `integrate_cubic`, `Chart.integrate_across` or `Chart.reference_across`.
    ax : Axes, optional
        Axes to draw into; new ones by default.
    t : array_like, shape (steps + 1,), optional
        Times. A `ChartTrajectory` has none of its own: without them it is drawn against the number of the step.
    **style
        For the line.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInputError
        No trajectory, times that do not match, axes that are not flat, or a style that is not that of a line.
    """
    _checked(trajectory)
    deviation = np.abs(trajectory.energy - trajectory.energy[0])
    return _draw(ax, trajectory_times(trajectory, t), deviation, "energy error |H(t) − H(0)|", style)  # noqa: RUF001


def _momenta(trajectory: Trajectory) -> Array:
    """Spatial momenta, shape ``(T, 3)`` or ``(T, n, n)``, scaled so that the Frobenius norm is the momentum's."""
    if isinstance(trajectory, ChartTrajectory):
        return trajectory.momentum
    state = zip(trajectory.point, trajectory.velocity, trajectory.acceleration, trajectory.jerk, strict=True)
    # The momentum at a state is that of the cubic which starts there.
    duration = float(np.abs(trajectory.t[-1])) / (len(trajectory.t) - 1)
    momenta = [RiemannianCubic.from_initial(S, V, A, J, duration).momentum for S, V, A, J in state]
    return np.asarray(np.stack(momenta) / np.sqrt(2.0))


def momentum(trajectory: Trajectory, *, ax: Axes | None = None, t: ArrayLike | None = None, **style: Any) -> Axes:
    """Draw how far the momentum of rotations of space is from its start, on a logarithmic axis.

    The momentum is a skew matrix, of norm ``|A|^2 = tr(A^T A) / 2``; for n = 3 that is the length of the vector of
    the momenta about the three axes.

    Parameters are those of `energy`.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInputError
        No trajectory, times that do not match, axes that are not flat, or a style that is not that of a line.
    """
    _checked(trajectory)
    at = trajectory_times(trajectory, t)
    momenta = _momenta(trajectory).reshape(len(at[0]), -1)
    return _draw(ax, at, np.linalg.norm(momenta - momenta[0], axis=1), "change of the momentum", style)
