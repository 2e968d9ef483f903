"""Drawing of the unit sphere: parallels, meridians, outline and axes. Importing this module imports matplotlib."""

from __future__ import annotations

from typing import Final

import numpy as np
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from .palette import GREY, GRID_GREY, INK, NEAR_GREY
from .sphere_lines import Array, circle, grid_lines

SPHERE_COLOURS: Final = (NEAR_GREY, GRID_GREY)
# Names of axes are beside the sphere, so far from its centre; an axis has a name where it is seen longer than this.
BESIDE: Final = 1.16
LEAST_SIDE: Final = 0.5


def draw_sphere(view: Array, *, ax: Axes3D) -> None:
    """Draw the unit sphere seen from the unit direction `view`, shape ``(3,)``; the far half is lighter."""
    for line in grid_lines():
        front = (line @ view > 0)[:, None]
        for order, (mask, colour) in enumerate(zip((~front, front), SPHERE_COLOURS[::-1], strict=True)):
            ax.plot(*np.where(mask, line, np.nan).T, color=colour, linewidth=0.6, zorder=order)
    u = np.cross(view, [0.0, 0.0, 1.0])
    u /= np.linalg.norm(u)
    ax.plot(*circle(np.zeros(3), u, np.cross(view, u)).T, color=GREY, linewidth=0.9, zorder=2)
    for name, axis in zip("₁₂₃", np.eye(3), strict=True):
        side = axis if axis @ view > -0.05 else -axis
        aside = side - (side @ view) * view
        length = float(np.linalg.norm(aside))
        if length > LEAST_SIDE:  # An axis that points to the viewer has no side.
            ax.plot(*np.stack([side, 1.1 * side]).T, color=GREY, linewidth=0.9, zorder=2)
            label = f"x{name}" if side is axis else f"−x{name}"  # noqa: RUF001
            place = max(BESIDE, 1.1 * length + 0.16) * aside / length
            ax.text(*place, label, ha="center", va="center", color=INK)
    ax.set_proj_type("ortho")
    ax.view_init(elev=float(np.degrees(np.arcsin(view[2]))), azim=float(np.degrees(np.arctan2(view[1], view[0]))))
    ax.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    ax.set_box_aspect((1, 1, 1), zoom=1.42)
    ax.set_axis_off()
