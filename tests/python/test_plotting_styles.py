"""Styles, names and legends of `stiefel_rs.plotting`."""

import io

import numpy as np
import pytest
from drawn import axes, axes3d, extent, knots, spline

import stiefel_rs as st
from stiefel_rs import InvalidInputError, palette

matplotlib = pytest.importorskip("matplotlib")
plotting = pytest.importorskip("stiefel_rs.plotting")
from matplotlib.colors import to_hex  # noqa: E402

from stiefel_rs.plotting import _sphere  # noqa: E402

EVERY = {
    "sphere": (lambda **style: plotting.plot(spline(3, 1), **style)),
    "frame": (lambda **style: plotting.plot(spline(3, 2), **style)),
    "circle": (lambda **style: plotting.plot(np.stack([np.eye(2)] * 2), **style)),
    "entries": (lambda **style: plotting.plot(knots(4, 2)[1], **style)),
    "many entries": (lambda **style: plotting.plot(knots(10, 3)[1], **style)),
    "norms": (lambda **style: plotting.norms(spline(4, 1), **style)),
    "convergence": (lambda **style: plotting.convergence([1, 2], [1, 0.5], **style)),
    "error": (lambda **style: plotting.error(spline(3, 1), spline(3, 1), **style)),
    "energy": (lambda **style: plotting.energy(still(), **style)),
    "momentum": (lambda **style: plotting.momentum(still(), **style)),
}


def still():
    S = np.eye(3)[:, :1]
    return st.integrate_cubic(S, 0 * S, 0 * S, 0 * S, 3)


def of_curves(ax):
    """Lines other than knots and far halves."""
    own = [line for line in ax.lines if line.get_gid() not in (_sphere.GRID_ID, _sphere.KNOT_ID)]
    return [line for line in own if getattr(line, "near", True)]


@pytest.mark.parametrize("name", EVERY)
def test_styles_have_the_same_names_everywhere(name):
    ax = EVERY[name](c="r", lw=3, ls="--", zorder=7, gid="mine", alpha=None)
    assert of_curves(ax)
    for line in of_curves(ax):
        found = to_hex(line.get_color()), line.get_linewidth(), line.get_linestyle(), line.get_zorder(), line.get_gid()
        assert found == ("#ff0000", 3, "--", 7, "mine")
    assert all(line.get_zorder() < 4 for line in ax.lines if not getattr(line, "near", True))
    ax.figure.savefig(io.BytesIO())


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize(
    ("style", "message"),
    [
        ({"foo": 3}, "style: .*'foo'"),
        ({"lw": 1, "linewidth": 2}, "style: .*aliases"),
        ({"color": "no colour"}, "style: 'no colour'"),
    ],
)
def test_styles_that_no_line_has(name, style, message):
    with pytest.raises(InvalidInputError, match=message):
        EVERY[name](**style)


def test_points_on_a_sphere_have_no_times():
    with pytest.raises(InvalidInputError, match=r"style: .*'t'"):
        spline(3, 2).plot(t=[0, 1])


NAMES = {
    "frame": (plotting.frame, (3, 2), ["column 1", "column 2"]),
    "rotations": (plotting.plot, (3, 3), ["column 1", "column 2", "column 3"]),
    "entries": (plotting.entries, (2, 2), ["S[0, 0]", "S[1, 0]", "S[0, 1]", "S[1, 1]"]),
    "plane": (plotting.plot, (2, 2), ["column 1", "column 2"]),
    "many": (plotting.plot, (10, 3), ["column 1", "column 2", "column 3"]),
    "norms": (plotting.norms, (4, 2), ["velocity", "acceleration"]),
}


@pytest.mark.parametrize("name", NAMES)
def test_lines_say_which_they_are(name):
    """A legend in new axes; in the caller's axes labels, and differences between two curves and their colours."""
    draw, (n, k), names = NAMES[name]
    end = np.eye(n)[:, :k]
    end[:2, :2] = [[0, -1], [1, 0]]
    curve = st.Geodesic(np.eye(n)[:, :k], end)
    ax = draw(curve)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == names
    mine = axes3d() if n == 3 else axes()
    draw(curve, ax=mine, label="a")
    draw(curve, ax=mine, label="b")
    assert mine.get_legend() is None
    labels = [f"{curve}, {one}" for curve in "ab" for one in names]
    assert mine.get_legend_handles_labels()[1] == labels
    drawn = of_curves(mine)
    first, second = (
        {(str(line.get_color()), str(line._unscaled_dash_pattern)) for line in half}
        for half in (drawn[: len(drawn) // 2], drawn[len(drawn) // 2 :])
    )
    assert not first & second, f"two curves alike: {first & second}"


def test_axes_of_a_body_have_names():
    names = ["axis 1", "axis 2", "axis 3"]
    for made in (plotting.body_frame(spline(3, 2)), plotting.body_frame(np.eye(3)[None], positions=[[0, 0, 0]])):
        assert [text.get_text() for text in made.get_legend().get_texts()] == names
    ax = plotting.body_frame(spline(3, 2), ax=axes3d())
    assert (ax.get_legend(), ax.get_legend_handles_labels()[1]) == (None, names)


@pytest.mark.parametrize("k", [2, 3])
def test_the_legend_of_a_sphere_is_below_it(k):
    left = plotting.spline(spline(3, k))[0]
    left.figure.savefig(io.BytesIO())
    legend = left.get_legend().get_window_extent()
    assert legend.y0 > 0
    for text in left.texts:
        assert not legend.overlaps(extent(text)), text.get_text()
    outline = next(line for line in left.lines if isinstance(line, _sphere.Outline))
    assert legend.y1 < left.transData.transform(np.column_stack(outline.get_data()))[:, 1].min()


@pytest.mark.parametrize("name", ["entries", "plane", "many", "norms"])
def test_a_legend_covers_no_line(name):
    draw, (n, k), _ = NAMES[name]
    ax = draw(spline(n, k))
    ax.figure.savefig(io.BytesIO())
    legend = ax.get_legend().get_window_extent()
    assert ax.figure.bbox.contains(legend.x0, legend.y0) and ax.figure.bbox.contains(legend.x1, legend.y1)
    for line in ax.lines:
        vertices = ax.transData.transform(line.get_xydata())
        covered = (vertices > [legend.x0, legend.y0]) & (vertices < [legend.x1, legend.y1])
        assert not covered.all(axis=1).any(), line.get_label()


@pytest.mark.parametrize("k", [2, 3])
def test_axes_of_a_body_are_red_green_and_blue(k):
    row = plotting.body_frame(spline(3, k))
    assert [to_hex(lines.get_color()[0]).upper() for lines in row.collections] == list(palette.BODY_AXES)
    sphere = of_curves(plotting.frame(spline(3, k)))
    assert [line.get_color() for line in sphere] == list(palette.BODY_AXES[:k])
    left = plotting.spline(spline(3, k))[0]
    assert [line.get_color() for line in of_curves(left)] == list(palette.BODY_AXES[:k])
    # Red and green are one colour to some readers.
    marks = [line.get_marker() for line in left.lines if line.get_gid() == _sphere.KNOT_ID and line.near]
    assert len(set(marks)) == k


@pytest.mark.parametrize("view", [[2, 1.2, 1], [0, 0, 1], [1, 1, 1], [-1, 0.1, -0.2]])
def test_names_of_axes_are_beside_the_sphere(view):
    """They can cover no curve on it; an axis towards the reader has no name."""
    ax = plotting.sphere(spline(3, 1), view=view)
    ax.figure.savefig(io.BytesIO())
    names = [text for text in ax.texts if isinstance(text, _sphere.AxisName)]
    assert len(names) == 3
    outline = next(line for line in ax.lines if isinstance(line, _sphere.Outline))
    edge = ax.transData.transform(np.column_stack(outline.get_data()))
    centre = edge.mean(axis=0)
    radius = np.linalg.norm(edge - centre, axis=1).max()
    for text, axis in zip(names, np.eye(3), strict=True):
        seen = np.linalg.norm(np.cross(axis, view)) > _sphere.LEAST_SIDE * np.linalg.norm(view)
        assert (text.get_alpha() == 1) is bool(seen)
        box = extent(text)
        corners = np.array([[x, y] for x in (box.x0, box.x1) for y in (box.y0, box.y1)])
        assert not seen or np.linalg.norm(corners - centre, axis=1).min() > radius


ORDERS = {
    "falling": {f"splitting {p}": 1.0 / np.array([5.0, 10, 20, 40]) ** p for p in (2, 4, 6)},
    "level": {"one": [1e-3] * 4, "two": [1e-8] * 4},
    "one": [1e-3, 1e-4, 1e-5, 1e-6],
    "at round-off": {"a": [1e-16, 2e-16, 1e-16, 3e-16], "b": [1, 0.5, 0.25, 0.1]},
}


@pytest.mark.parametrize("name", ORDERS)
def test_the_legend_of_errors_covers_none(name):
    ax = plotting.convergence([5, 10, 20, 40], ORDERS[name])
    ax.figure.savefig(io.BytesIO())
    legend = ax.get_legend().get_window_extent()
    points = np.concatenate([ax.transData.transform(line.get_xydata()) for line in ax.lines])
    assert (points[:, 1] > legend.y1).all(), f"{points[:, 1].min()} under {legend.y1}"
    assert legend.y0 >= ax.get_window_extent().y0


def test_errors_in_a_part_of_a_figure():
    part = axes().figure.subfigures(1, 2)[0]
    assert plotting.convergence([1, 2], [1, 0.5], ax=part.add_subplot()).get_legend()


def test_new_axes_are_as_wide_as_a_column_or_a_page_in_print():
    makers = {
        3.4: (lambda: plotting.norms(spline(4, 1)), lambda: plotting.plot(spline(3, 2))),
        7.0: (lambda: plotting.body_frame(spline(3, 2)), lambda: plotting.spline(spline(4, 2))[0]),
    }
    for width, calls in makers.items():
        for call in calls:
            assert call().figure.get_size_inches()[0] == width
