"""Large frames: what `plot` draws for them, and that it is no line for each entry."""

import io

import numpy as np
import pytest
from drawn import axes, knots, spline

import stiefel_rs as st
from stiefel_rs import InvalidInputError, Stiefel

matplotlib = pytest.importorskip("matplotlib")
plotting = pytest.importorskip("stiefel_rs.plotting")
from stiefel_rs.plotting import _overview  # noqa: E402

N, K = 300, 6


@pytest.fixture(scope="module")
def large():
    """A spline through ten frames of St(300,6)."""
    return st.CubicSpline(*knots(N, K, 10))


def panels(figure):
    """Axes but for the bar of colours."""
    return [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]


def test_a_large_frame_is_an_overview_with_few_lines(large):
    first = large.plot()
    figure = first.figure
    figure.savefig(io.BytesIO())
    assert len(panels(figure)) == 4
    assert first is figure.axes[0]
    # A line for each of 1800 entries takes seconds and shows nothing.
    assert sum(len(ax.lines) for ax in figure.axes) < 25
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [f"column {i + 1}" for i in range(K)]


def test_angles_are_those_of_the_columns_to_their_start(large):
    ax = plotting.angles(large, num=31)
    t = np.union1d(np.linspace(*large.t_span, 31), large.t)
    S = large(t)
    cosines = np.einsum("tij,ij->tj", S, S[0])
    assert len(ax.lines) == K
    for column, line in enumerate(ax.lines):
        assert np.array_equal(line.get_xdata(), t)
        # The arc cosine loses half of the digits near zero.
        expected = np.degrees(np.arccos(np.clip(cosines[:, column], -1, 1)))
        assert np.abs(line.get_ydata() - expected).max() < 1e-5
        assert line.get_ydata().max() > 1


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1.0, 179.0, 180.0])
def test_angles_are_accurate_near_zero_and_near_180_degrees(angle):
    x = np.radians(angle)
    points = np.array([[[1.0], [0.0]], [[np.cos(x)], [np.sin(x)]]])
    (line,) = plotting.angles(points).lines
    # Half of the chord has an error of an eps; near 180 degrees the arc sine takes its root.
    assert line.get_ydata()[1] == pytest.approx(angle, rel=1e-12, abs=1e-18 if angle < 90 else 2e-6)


def test_the_picture_has_every_entry(large):
    figure = plotting.overview(large, num=50)[0].figure
    (picture,) = figure.axes[1].images
    t = np.union1d(np.linspace(*large.t_span, 50), large.t)
    S = large(t)
    shown = np.asarray(picture.get_array())
    assert shown.shape == (N * K, len(t))
    for column in range(K):
        rows = shown[column * N : (column + 1) * N]
        assert np.array_equal(rows[:, 0], S[0, :, column])
        assert np.array_equal(rows[:, -1], S[-1, :, column])
    low, high = picture.get_clim()
    assert low == -high
    assert np.mean(np.abs(S) <= high) > 0.98


def test_speed_and_acceleration_are_lengths_in_the_canonical_metric(large):
    _, _, speed, acceleration = plotting.overview(large, num=21)
    M = Stiefel(N, K)
    for ax, vectors in ((speed, large.velocity), (acceleration, large.acceleration)):
        t = ax.lines[0].get_xdata()
        assert np.array_equal(ax.lines[0].get_ydata(), M.norm(large(t), vectors(t)))


def test_the_palest_colour_is_transparent():
    assert _overview.SIGNED(0.5)[3] == 0
    assert _overview.SIGNED(0.0)[3] == _overview.SIGNED(1.0)[3] == 1


def test_in_the_callers_axes_only_the_angles(large):
    mine = axes()
    assert large.plot(ax=mine, label="a") is mine
    assert mine.get_legend() is None
    assert mine.get_legend_handles_labels()[1] == [f"a, column {i + 1}" for i in range(K)]
    assert not mine.images
    assert len(mine.figure.axes) == 1


@pytest.mark.parametrize(("shape", "large_enough"), [((30, 2), False), ((31, 2), True), ((8, 8), True)])
def test_from_61_entries_on_a_frame_is_large(shape, large_enough):
    figure = plotting.plot(knots(*shape)[1]).figure
    assert (len(panels(figure)) == 2) is large_enough


def test_points_have_neither_speed_nor_acceleration():
    S = knots(40, 3)[1]
    found = plotting.overview(S)
    assert found.shape == (2,)
    assert found[0].get_xlabel() == found[1].get_xlabel() == "step"
    assert np.array_equal(found[1].images[0].get_array(), S.transpose(2, 1, 0).reshape(120, 5))


def test_a_spline_of_large_frames_has_its_angles_beside_both_lengths():
    left, _, _ = plotting.spline(spline(40, 3))
    assert left.get_ylabel() == "angle to start\n(degrees)"


def test_many_columns_have_no_names():
    ax = plotting.angles(np.stack([np.eye(20)] * 3))
    assert (len(ax.lines), ax.get_legend()) == (20, None)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda S: plotting.overview(S, ax=[axes()]), "ax: 2 axes expected, found 1"),
        (lambda S: plotting.overview(spline(9, 8), ax=[axes(), axes()]), "ax: 4 axes expected, found 2"),
        (lambda S: plotting.overview(S, foo=1), "style: "),
        (lambda S: plotting.angles(S, num=1), "num: "),
        (lambda S: plotting.angles(S, t=[0, 1]), "t: 5 times expected, found 2"),
        (lambda S: plotting.angles(np.array([[["a"]]])), "curve: real numbers"),
    ],
)
def test_bad_arguments(call, message):
    with pytest.raises(InvalidInputError, match=message):
        call(knots(9, 8)[1])
