"""Splines to draw, and the data of the artists that draw them."""

import numpy as np
import pytest

import stiefel_rs as st
from stiefel_rs import Stiefel

matplotlib = pytest.importorskip("matplotlib")
plotting = pytest.importorskip("stiefel_rs.plotting")
from matplotlib.figure import Figure  # noqa: E402
from mpl_toolkits.mplot3d import proj3d  # noqa: E402

from stiefel_rs.plotting import _sphere  # noqa: E402


def knots(n, k, count=5):
    M = Stiefel(n, k)
    S = [M.random_point(1)]
    for i in range(count - 1):
        V = M.random_tangent(S[-1], i)
        S.append(M.exp(S[-1], 0.5 * V / M.norm(S[-1], V)))
    return np.arange(count) ** 1.1, np.stack(S)


def spline(n, k):
    return st.CubicSpline(*knots(n, k))


def tagged(ax, gid):
    return [line for line in ax.lines if line.get_gid() == gid]


def xyz(line):
    return np.array(line.get_data_3d()).T


def paths(ax):
    """Data of the near halves, which the far halves repeat."""
    lines = tagged(ax, _sphere.PATH_ID)
    near, far = ([xyz(line) for line in lines if line.near is which] for which in (True, False))
    assert len(near) == len(far)
    assert all(np.array_equal(a, b) for a, b in zip(near, far, strict=True))
    return near


def marks(ax):
    """Data of the marked points; near and far halves are the same."""
    found = [(line.get_markerfacecolor(), xyz(line)) for line in tagged(ax, _sphere.KNOT_ID)]
    return found


def extent(text):
    """Position of a text in space, in pixels; matplotlib only knows it while the text is drawn."""
    x, y, _ = proj3d.proj_transform(*text.get_position_3d(), text.axes.get_proj())
    text.set_position((x, y))
    return text.get_window_extent()


def axes():
    return Figure().add_subplot()


def axes3d():
    return Figure().add_subplot(projection="3d")
