"""Figures of curves on Stiefel manifolds, with matplotlib (extra ``plot``).

Every function takes the axes to draw into (``ax=``) and returns them. Without ``ax`` it makes a figure of its own,
which is the ``figure`` of the axes that come back: ``plotting.save(plotting.plot(curve), "curve.svg")``. There is no
global state: no pyplot, no change of ``rcParams``. For a window, hand in axes made by pyplot; spheres and body frames
need three-dimensional ones, ``pyplot.figure().add_subplot(projection="3d")``.

=================== ==================================================================================
`plot`              whatever suits the shape; ``curve.plot()`` is the same
`sphere`            curves on St(3,1)
`frame`             the columns of curves on St(3,2) and St(3,3), as paths on one sphere
`body_frame`        the same as small triads that move in time
`entries`           all entries of a matrix against time, for any n and k
`angles`            angle of each column to its start against time, for any n and k
`overview`          for large frames: these angles, the entries as a picture, speed and acceleration
`norms`             lengths of velocity and covariant acceleration
`spline`            a curve through points, its knots, and both lengths beside it
`convergence`       errors against numbers of steps, with fitted orders
`error`             distance between two curves against time
`energy`            deviation of the energy along a trajectory
`momentum`          deviation of the momentum along a trajectory
`fitted_order`      slope of errors against steps
`BODY_AXES`         red, green and blue, the colours of the axes of a body
`STYLE`             settings of matplotlib for figures in print size, for ``matplotlib.rc_context``
`save`              a figure as SVG for light and dark pages, PNG at 200 dpi, or PDF
=================== ==================================================================================
"""

from __future__ import annotations

try:
    import matplotlib as _matplotlib  # noqa: F401
except ImportError as missing:
    raise ImportError(f"stiefel_rs.plotting needs matplotlib ({missing}): pip install 'stiefel-rs[plot]'") from missing

from ..figure_style import SETTINGS as STYLE
from ..palette import BODY_AXES
from ._body import body_frame
from ._conserved import energy, momentum
from ._errors import convergence, error, fitted_order
from ._norms import norms
from ._overview import angles, overview
from ._plot import plot
from ._save import save
from ._sphere import frame, sphere
from ._time import entries, spline

__all__ = [
    "BODY_AXES",
    "STYLE",
    "angles",
    "body_frame",
    "convergence",
    "energy",
    "entries",
    "error",
    "fitted_order",
    "frame",
    "momentum",
    "norms",
    "overview",
    "plot",
    "save",
    "sphere",
    "spline",
]
