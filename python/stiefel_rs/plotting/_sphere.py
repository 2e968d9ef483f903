"""Paths on the unit sphere."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.backend_bases import RendererBase
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from mpl_toolkits.mplot3d.art3d import Line3D, Text3D  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from ..errors import InvalidInputError
from ..figure_style import FONT_SIZE
from ..palette import BACKGROUND, GREY, NEAR_GREY
from ..palette import GRID_GREY as FAR_GREY
from ..sphere_lines import circle, grid_lines
from ._axes import GRID_ID, KNOT_ID, MARKS, column_style, cycled, legend, line_style, spatial
from ._samples import Array, Drawable, Samples, column_of, finite, samples

PATH_ID: Final = "stiefel_rs path"
FAR_ALPHA: Final = 0.3
# Names of axes are so far from the centre; an axis has a name where it is seen longer than this.
BESIDE: Final = 1.18
LEAST_SIDE: Final = 0.15
DEFAULT_VIEW: Final = np.array([2.0, 1.2, 1.0]) / np.linalg.norm([2.0, 1.2, 1.0])


def viewpoint(ax: Axes3D) -> Array:
    """Return the unit vector towards the reader, shape ``(3,)``, as the axes are turned now."""
    elevation, azimuth = np.radians([ax.elev, ax.azim])
    return np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], dtype=np.float64
    )


class HalfLine(Line3D):  # type: ignore[misc]
    """A line on the sphere of which only the near or the far half is drawn, whichever way the sphere is turned.

    Its data are the whole line.
    """

    def __init__(self, points: Array, *, near: bool, **style: Any) -> None:
        super().__init__(*points.T, **style)
        self.near = near

    def draw(self, renderer: RendererBase) -> None:
        """Draw the half that is wanted."""
        whole = np.array(self.get_data_3d(), dtype=np.float64)
        front = viewpoint(self.axes) @ whole >= 0
        self.set_data_3d(*np.where(front == self.near, whole, np.nan))
        super().draw(renderer)
        self.set_data_3d(*whole)


class Outline(Line3D):  # type: ignore[misc]
    """The edge of the sphere, as it is seen now."""

    def draw(self, renderer: RendererBase) -> None:
        """Draw the great circle that faces the reader."""
        view = viewpoint(self.axes)
        u = np.cross(view, np.eye(3)[np.abs(view).argmin()])
        u /= np.linalg.norm(u)
        self.set_data_3d(*circle(np.zeros(3), u, np.cross(view, u)).T)
        super().draw(renderer)


class AxisName(Text3D):  # type: ignore[misc]
    """The name of an axis of space, beside the sphere as it is seen now: nothing that is drawn on it can be covered."""

    def __init__(self, axis: Array, text: str, **style: Any) -> None:
        super().__init__(*(BESIDE * axis), text, zdir=None, clip_on=False, **style)
        self.axis = axis

    def draw(self, renderer: RendererBase) -> None:
        """Draw the name where the axis points to; an axis that points at the reader has no side."""
        view = viewpoint(self.axes)
        aside = self.axis - (self.axis @ view) * view
        length = float(np.linalg.norm(aside))
        self.set_alpha(1.0 if length > LEAST_SIDE else 0.0)
        self.set_position_3d(BESIDE * aside / max(length, LEAST_SIDE))
        super().draw(renderer)


def _set_view(ax: Axes3D, view: Array) -> None:
    elevation, azimuth = np.arcsin(np.clip(view[2], -1, 1)), np.arctan2(view[1], view[0])
    ax.view_init(elev=float(np.degrees(elevation)), azim=float(np.degrees(azimuth)))


def _unit(view: ArrayLike) -> Array:
    found = finite(view, "view", 1)
    length = np.linalg.norm(found)
    if len(found) != 3 or length == 0:
        raise InvalidInputError(f"view: a direction of three numbers expected, found {found}")
    return np.asarray(found / length)


def _facing(paths: Array) -> Array:
    """Direction from which paths of shape ``(T, 3, k)`` are seen best: from their middle, and a little above."""
    middle = paths.mean(axis=(0, 2))
    length = np.linalg.norm(middle)
    # Paths all around have no middle.
    return _unit(middle / length + [0.0, 0.0, 0.25]) if length > 0.2 else DEFAULT_VIEW


def _draw_grid(ax: Axes3D) -> None:
    for line in grid_lines():
        for near, colour in ((False, FAR_GREY), (True, NEAR_GREY)):
            ax.add_line(HalfLine(line, near=near, color=colour, linewidth=0.6, zorder=int(near), gid=GRID_ID))
    ax.add_line(Outline([], [], [], color=GREY, linewidth=0.9, zorder=2, gid=GRID_ID))
    for name, axis in zip("₁₂₃", np.eye(3), strict=True):
        ax.plot(*np.stack([axis, 1.1 * axis]).T, color=GREY, linewidth=0.9, zorder=2, gid=GRID_ID)
        where = {"ha": "center", "va": "center", "color": GREY, "fontsize": FONT_SIZE}
        ax.add_artist(AxisName(axis, f"x{name}", gid=GRID_ID, **where))
    ax.set_proj_type("ortho")
    ax.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    ax.set_box_aspect((1, 1, 1), zoom=1.35)
    ax.set_axis_off()
    ax.patch.set_visible(False)


def _with_sphere(ax: Any, paths: Array, view: ArrayLike | None) -> Axes3D:
    """Axes with a sphere on them; a sphere that is there already is not drawn twice, nor turned unasked."""
    direction = None if view is None else _unit(view)
    ax = spatial(ax)
    if not any(line.get_gid() == GRID_ID for line in ax.lines):
        _draw_grid(ax)
        direction = _facing(paths) if direction is None else direction
    if direction is not None:
        _set_view(ax, direction)
    return ax


def _draw_path(ax: Axes3D, path: Array, knots: Array, style: dict[str, Any], mark: str = "o") -> None:
    # The far half is behind all near ones, whatever the order of the caller; by its name paths are counted.
    far = style | {"alpha": FAR_ALPHA * style.get("alpha", 1.0), "label": None, "zorder": 2.5, "gid": PATH_ID}
    near: dict[str, Any] = {"zorder": 4, "gid": PATH_ID} | style
    ax.add_line(HalfLine(path, near=False, **far))
    ax.add_line(HalfLine(path, near=True, **near))
    marks = {
        "linestyle": "none",
        "marker": mark,
        "color": style["color"],
        "markerfacecolor": BACKGROUND,
        "markersize": 4.5,
    }
    above = near["zorder"] + 1
    if len(knots):
        ax.add_line(HalfLine(knots, near=False, zorder=3, gid=KNOT_ID, alpha=FAR_ALPHA, **marks))
        ax.add_line(HalfLine(knots, near=True, zorder=above, gid=KNOT_ID, **marks))
        return
    # Without knots the ends are marked: a full circle where the path starts, a ring where it ends.
    ax.plot(*path[:1].T, **(marks | {"markerfacecolor": style["color"]}), zorder=above, gid=KNOT_ID)
    ax.plot(*path[-1:].T, **marks, zorder=above, gid=KNOT_ID)


def _paths(ax: Axes3D) -> int:
    """Paths that are on a sphere already."""
    return sum(line.get_gid() == PATH_ID and not line.near for line in ax.lines)


def _spherical(curve: Drawable, num: int, columns: tuple[int, ...]) -> Samples:
    if not hasattr(curve, "t_span") and not hasattr(curve, "energy") and np.ndim(curve) == 2 and 1 in columns:
        curve = finite(curve, "curve", 2)[:, :, None]
    found = samples(curve, num)
    n, k = found.points.shape[1:]
    if n != 3 or k not in columns:
        wanted = " or ".join(f"St(3,{k})" for k in columns)
        raise InvalidInputError(f"curve: {wanted} expected, found {found.manifold}")
    return found


def sphere(
    curve: Drawable, *, ax: Axes3D | None = None, num: int = 200, view: ArrayLike | None = None, **style: Any
) -> Axes3D:
    """Draw a curve on St(3,1) on a unit sphere; more curves with the same axes.

    Parameters
    ----------
    curve : Curve, CubicTrajectory, ChartTrajectory, or array_like of shape (T, 3, 1) or (T, 3)
        What is drawn. The knots of a spline are marked; of others the start (full) and the end (ring).
    ax : Axes3D, optional
        Axes with ``projection="3d"``; new ones by default. A sphere is drawn where there is none yet.
    num : int, default 200
        Equidistant times at which a curve is evaluated.
    view : array_like, shape (3,), optional
        Direction from which the sphere is seen; by default that of the middle of the first curve. The far half is
        paler, also after the sphere was turned by hand.
    **style
        For the line: ``label``, ``color``, ``linestyle``, ``marker`` and so on.

    Returns
    -------
    Axes3D

    Raises
    ------
    InvalidInputError
        `curve` is not on St(3,1), `ax` is flat, `num` is not a number from 2, `view` is no direction, `style` is not
        that of a line.
    """
    found, style = _spherical(curve, num, (1,)), line_style(style)
    ax = _with_sphere(ax, found.points, view)
    _draw_path(ax, found.points[:, :, 0], column_of(found.knots, 0), cycled(_paths(ax)) | style)
    return ax


def frame(
    curve: Drawable, *, ax: Axes3D | None = None, num: int = 200, view: ArrayLike | None = None, **style: Any
) -> Axes3D:
    """Draw the columns of a curve on St(3,2) or St(3,3), each as a path on one sphere.

    Parameters are those of `sphere`, arrays have shape (T, 3, 2) or (T, 3, 3). Columns are red, green and blue, with
    circles, squares and triangles at knots or ends; a further curve in the same axes has other dashes. Labels name the
    column too: ``label="a"`` becomes "a, column 1". New axes have a legend, those of the caller do not.

    Returns
    -------
    Axes3D

    Raises
    ------
    InvalidInputError
        `curve` is not on St(3,2) or St(3,3), `ax` is flat, `num` is not a number from 2, `view` is no direction,
        `style` is not that of a line.
    """
    found, style, new = _spherical(curve, num, (2, 3)), line_style(style), ax is None
    ax = _with_sphere(ax, found.points, view)
    before = _paths(ax)
    columns = found.points.shape[2]
    for column in range(columns):
        own = column_style(column, columns, style, before)
        _draw_path(ax, found.points[:, :, column], column_of(found.knots, column), own, MARKS[column])
    if new:
        legend(ax)
    return ax
