"""One picture of whatever is given."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from ._samples import Drawable
from ._time import path


def plot(curve: Drawable, *, ax: Axes | Axes3D | None = None, num: int = 200, **style: Any) -> Axes | Axes3D:
    """Draw a curve in the way that suits its shape; ``curve.plot()`` is the same.

    On St(3,1) that is `sphere`, on St(3,2) and St(3,3) `frame`, on St(2,1) and St(2,2) the columns on circles, else,
    and for complex points, `entries` up to 60 real numbers, beyond that `overview`. The knots of a spline are marked.

    Parameters
    ----------
    curve : Curve, CubicTrajectory, ChartTrajectory, or array_like of shape (T, n, k)
        What is drawn.
    ax : Axes or Axes3D, optional
        Axes to draw into, with ``projection="3d"`` where n = 3; new ones by default.
    num : int, default 200
        Equidistant times at which a curve is evaluated.
    **style
        For the lines: ``label``, ``color``, ``linewidth`` and so on. A legend comes with new axes.

    Returns
    -------
    Axes or Axes3D
        Of `overview` the first, with the angles; in axes of the caller these are all that is drawn.

    Raises
    ------
    InvalidInputError
        `curve` has no points, `num` is not a number from 2, `ax` has not the dimension that the picture needs,
        `style` is not that of a line.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import GeometricCubic, plotting
    >>> S0, V0, S1 = np.eye(3)[:, :1], np.eye(3)[:, 1:2], np.eye(3)[:, 1:2]
    >>> ax = plotting.plot(GeometricCubic(S0, V0, S1, -S0))
    >>> plotting.save(ax, "curve.svg")  # doctest: +SKIP
    """
    drawn: Axes | Axes3D = path(curve, ax, num, style)
    return drawn
