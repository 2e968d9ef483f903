"""`stiefel_rs.plotting`: the data of the drawn artists."""

import io
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from beside import HANGS
from drawn import axes, axes3d, extent, knots, marks, paths, spline, tagged, xyz

import stiefel_rs as st
from stiefel_rs import InvalidInputError, Stiefel, palette

matplotlib = pytest.importorskip("matplotlib")
plotting = pytest.importorskip("stiefel_rs.plotting")
from matplotlib.colors import to_hex  # noqa: E402
from mpl_toolkits.mplot3d import proj3d  # noqa: E402

from stiefel_rs.plotting import _sphere  # noqa: E402

GUIDE = Path(__file__).parents[2] / "docs" / "plotting.md"


@pytest.fixture
def pair():
    """The exact cubic and the de Casteljau curve with the same ends."""
    M = Stiefel(3, 1)
    S0 = M.random_point(1)
    V0 = M.random_tangent(S0, 2)
    S1 = M.exp(S0, V0)
    ends = S0, V0, S1, M.random_tangent(S1, 3)
    return st.RiemannianCubic.from_boundary(*ends), st.GeometricCubic(*ends)


@pytest.fixture
def trajectory(pair):
    return st.integrate_cubic(*pair[0].initial, 12, order=4)


def test_sphere_draws_the_curve(pair):
    ax = plotting.sphere(pair[0], num=31, label="exact", color="red")
    (path,) = paths(ax)
    assert np.array_equal(path, pair[0](np.linspace(0, 1, 31))[:, :, 0])
    (start, end) = marks(ax)
    assert start[0] == "red"
    assert end[0] == palette.BACKGROUND
    assert np.array_equal(start[1], path[:1])
    assert np.array_equal(end[1], path[-1:])
    handles, labels = ax.get_legend_handles_labels()
    assert labels == ["exact"]
    assert to_hex(handles[0].get_color()) == "#ff0000"


def test_a_second_curve_shares_the_sphere(pair):
    ax = plotting.sphere(pair[0], num=11)
    grid, view = len(tagged(ax, _sphere.GRID_ID)), (ax.elev, ax.azim)
    assert grid > 20
    assert plotting.sphere(pair[1], ax=ax, num=11) is ax
    assert len(tagged(ax, _sphere.GRID_ID)) == grid
    assert (ax.elev, ax.azim) == view
    first, second = paths(ax)
    assert np.array_equal(second, pair[1](np.linspace(0, 1, 11))[:, :, 0])
    assert not np.array_equal(first, second)
    colours = {line.get_color() for line in tagged(ax, _sphere.PATH_ID)}
    assert len(colours) == 2, f"two curves in the colours {colours}"


def test_the_sphere_is_round_and_its_lines_are_on_it():
    ax = plotting.sphere(knots(3, 1)[1])
    for line in tagged(ax, _sphere.GRID_ID):
        if isinstance(line, _sphere.HalfLine):
            assert np.allclose(np.linalg.norm(xyz(line), axis=1), 1, atol=1e-15)
    assert ax.get_xlim() == ax.get_ylim() == ax.get_zlim()


@pytest.mark.parametrize("view", [[1, 0, 0], [0, 0, -2], [1, -2, 3]])
def test_view(pair, view):
    ax = plotting.sphere(pair[0], view=view)
    assert np.allclose(_sphere.viewpoint(ax), view / np.linalg.norm(view), atol=1e-15)


def test_only_the_near_half_is_dark(monkeypatch):
    """The renderer gets either the near or the far half of a great circle, also after the sphere was rotated."""
    t = np.linspace(0, 2 * np.pi, 401)
    ax = plotting.sphere(np.stack([np.cos(t), np.sin(t), 0 * t], axis=1), view=[1, 0, 0.5])
    near, far = (next(x for x in tagged(ax, _sphere.PATH_ID) if x.near is which) for which in (True, False))
    shown = {}
    monkeypatch.setattr(_sphere.Line3D, "draw", lambda line, _: shown.update({line: np.array(line.get_data_3d())}))
    for azimuth in (0.0, 130.0):
        ax.view_init(elev=ax.elev, azim=azimuth)
        ax.figure.canvas.draw()
        towards = _sphere.viewpoint(ax)
        for line, sign in ((near, 1), (far, -1)):
            visible = shown[line][:, ~np.isnan(shown[line][0])]
            assert (sign * (towards @ visible) >= 0).all()
            assert abs(visible.shape[1] - 200) < 5, f"{visible.shape[1]} of 401 points"
        assert not np.isnan(xyz(near)).any()


def test_frame_draws_each_column_and_the_knots():
    curve = spline(3, 2)
    ax = plotting.frame(curve, num=21, label="spline")
    t = np.union1d(np.linspace(*curve.t_span, 21), curve.t)
    found = paths(ax)
    assert len(found) == 2
    for column, path in enumerate(found):
        assert np.array_equal(path, curve(t)[:, :, column])
    for i, (face, data) in enumerate(marks(ax)):
        assert face == palette.BACKGROUND
        assert np.array_equal(data, curve.points[:, :, i // 2])
    assert ax.get_legend_handles_labels()[1] == ["spline, column 1", "spline, column 2"]


def test_frame_of_rotations_has_three_paths():
    assert len(paths(plotting.frame(spline(3, 3)))) == 3


def test_body_frame_draws_right_handed_triads():
    curve = spline(3, 2)
    ax = plotting.body_frame(curve, num=6)
    S = curve(np.linspace(*curve.t_span, 6))
    axes_of_body = np.concatenate([S, np.cross(S[:, :, 0], S[:, :, 1])[:, :, None]], axis=2)
    assert len(ax.collections) == 3
    for column, lines in enumerate(ax.collections):
        segments = np.array(lines._segments3d)
        assert segments.shape == (6, 2, 3)
        assert np.array_equal(segments[:, 0], np.column_stack([np.arange(6), np.zeros(6), np.zeros(6)]))
        assert np.allclose(segments[:, 1] - segments[:, 0], 0.45 * axes_of_body[:, :, column], atol=1e-15)
    said = [text.get_text() for text in ax.texts]
    assert said[0] == "time t = 0"
    assert said[-1] == f"time t = {curve.t_span[1]:.3g}"


def test_body_frame_at_positions():
    S = spline(3, 3)(np.linspace(0, 1, 4))
    places = np.arange(12.0).reshape(4, 3)
    ax = plotting.body_frame(S, positions=places, size=0.5)
    segments = np.array(ax.collections[1]._segments3d)
    assert np.array_equal(segments[:, 0], places)
    assert np.allclose(segments[:, 1], places + 0.5 * S[:, :, 1])


def test_body_frame_of_points_takes_some_of_them():
    S = spline(3, 3)(np.linspace(0, 1, 101))
    segments = np.array(plotting.body_frame(S, num=11, size=1.0).collections[0]._segments3d)
    assert np.allclose(segments[:, 1] - segments[:, 0], S[::10, :, 0])


@pytest.mark.parametrize(("num", "size"), [(2, None), (3, None), (5, None), (30, None), (4, 2.0)])
def test_a_row_of_triads_is_inside_of_its_figure(num, size):
    ax = plotting.body_frame(spline(3, 2), num=num, size=size)
    figure = ax.figure
    figure.canvas.draw()
    assert ax.get_window_extent().width == pytest.approx(ax.get_window_extent().height), "axes that shrink move the row"
    ends = np.concatenate([np.array(lines._segments3d).reshape(-1, 3) for lines in ax.collections])
    x, y, _ = proj3d.proj_transform(*ends.T, ax.get_proj())
    inside = figure.bbox.padded(-5)
    assert all(inside.contains(*point) for point in ax.transData.transform(np.column_stack([x, y])))
    for box in [ax.get_legend().get_window_extent(), *map(extent, ax.texts)]:
        assert all(figure.bbox.contains(*corner) for corner in box.get_points()), f"{box} in {figure.bbox}"


def test_fitted_order_of_powers():
    N = np.array([10, 20, 40, 80])
    assert plotting.fitted_order(N, 3.0 / N**4) == pytest.approx(4, abs=1e-12)
    # The last error is round-off: including it would lower the order.
    assert plotting.fitted_order(N, [1e-12, 1e-13, 1e-14, 0.0]) == pytest.approx(np.log2(10), abs=1e-12)
    assert plotting.fitted_order(N, [1e-5, 1e-6, 0, 0], floor=1e-6) is None


def test_convergence_draws_errors_and_names_orders(pair):
    N, end = [40, 5, 10, 20], pair[0](1.0)
    errors = {
        f"order {p}": [np.linalg.norm(st.integrate_cubic(*pair[0].initial, n, order=p).point[-1] - end) for n in N]
        for p in (2, 4)
    }
    ax = plotting.convergence(N, errors)
    for line, (name, values) in zip(ax.lines, errors.items(), strict=True):
        assert list(line.get_xdata()) == sorted(N)
        assert list(line.get_ydata()) == sorted(values, reverse=True)
        fitted = plotting.fitted_order(N, values)
        assert abs(fitted - int(name[-1])) < 0.2, f"{name}: {fitted}"
        assert line.get_label() == f"{name}, order {fitted:.2f}"
    assert ax.get_xscale() == ax.get_yscale() == "log"
    assert len(ax.get_legend().get_texts()) == 2


def test_convergence_of_one_method_and_a_second_in_the_same_axes():
    ax = plotting.convergence([1, 2, 4], [1, 0.5, 0])
    assert ax.lines[0].get_label() == "order 1.00"
    assert np.isnan(ax.lines[0].get_ydata()[2])
    plotting.convergence([1, 2, 4], {"second": [1, 0.25, 0.0625]}, ax=ax)
    assert ax.lines[1].get_label() == "second, order 2.00"
    assert ax.lines[0].get_color() != ax.lines[1].get_color()


def test_errors_that_are_all_zero_are_drawn():
    ax = plotting.convergence([1, 2], [0, 0], label="exact")
    ax.figure.savefig(io.BytesIO())
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["exact, no order"]
    plotting.convergence([1, 2], [1e-3, 1e-4], ax=ax)
    assert ax.get_ylim()[1] < 1e-2, "limits do not follow"


def test_error_is_the_distance(pair):
    exact, geometric = pair
    (line,) = plotting.error(geometric, exact, num=51, color="k").lines
    t = np.linspace(0, 1, 51)
    distance = np.linalg.norm(geometric(t) - exact(t), axis=(1, 2))
    assert np.array_equal(line.get_xdata(), t)
    assert np.array_equal(line.get_ydata()[1:-1], distance[1:-1])
    assert distance.max() > 1e-4


def test_energy_of_a_trajectory(trajectory):
    (line,) = plotting.energy(trajectory).lines
    expected = np.abs(trajectory.energy - trajectory.energy[0])[1:]
    assert np.array_equal(line.get_xdata(), trajectory.t[1:])
    assert np.array_equal(np.nan_to_num(line.get_ydata()), expected)
    assert expected.max() > 1e-12


def test_momentum_of_a_trajectory_is_kept(trajectory):
    (line,) = plotting.momentum(trajectory).lines
    found = np.nan_to_num(line.get_ydata())
    # The integrator's drift is measured with its own frames, this one from the points: both are round-off.
    size = np.linalg.norm(trajectory.jerk[0]) + np.linalg.norm(trajectory.acceleration[0])
    assert found.max() < 100 * np.finfo(float).eps * (1 + size), f"{found.max()}"


def test_energy_and_momentum_in_a_chart(pair):
    found = st.Chart.sphere().integrate_across(*pair[0].initial, 10)
    ax = plotting.momentum(found)
    expected = np.linalg.norm(found.momentum - found.momentum[0], axis=1)[1:]
    assert np.array_equal(np.nan_to_num(ax.lines[0].get_ydata()), expected)
    assert expected.max() > 1e-8
    assert ax.get_xlabel() == "step"
    t = np.linspace(0, 1, 11)
    plotting.energy(found, ax=ax, t=t)
    assert np.array_equal(ax.lines[1].get_xdata(), t[1:])


def test_momentum_is_that_of_the_chart():
    """The same trajectory in two forms: momenta about the axes, and skew matrices computed from the states."""
    M = Stiefel(3, 2)
    S = M.random_point(0)
    state = S, *(M.random_tangent(S, i) for i in (1, 2, 3))
    from stiefel_rs.plotting import _conserved  # noqa: PLC0415

    cubic = _conserved._momenta(st.integrate_cubic(*state, 10))
    chart = _conserved._momenta(st.Chart.frame().integrate_across(*state, 10))
    assert np.linalg.norm(cubic[0]) == pytest.approx(np.linalg.norm(chart[0]), rel=1e-12)


def test_entries_of_any_shape():
    curve = spline(4, 2)
    ax = plotting.entries(curve, num=17)
    t = np.union1d(np.linspace(*curve.t_span, 17), curve.t)
    lines = [line for line in ax.lines if line.get_gid() is None]
    circles = tagged(ax, "stiefel_rs knots")
    assert len(lines) == len(circles) == 8
    for i, (line, circle) in enumerate(zip(lines, circles, strict=True)):
        column, row = divmod(i, 4)
        assert line.get_label() == f"S[{row}, {column}]"
        assert np.array_equal(line.get_xdata(), t)
        assert np.array_equal(line.get_ydata(), curve(t)[:, row, column])
        assert np.array_equal(circle.get_xdata(), curve.t)
        assert np.array_equal(circle.get_ydata(), curve.points[:, row, column])


def test_entries_of_many_rows_are_named_by_column():
    t, S = knots(20, 2)
    ax = plotting.entries(S, t=t)
    assert ax.get_legend_handles_labels()[1] == ["column 1", "column 2"]
    assert len(ax.lines) == 40
    assert np.array_equal(ax.lines[21].get_ydata(), S[:, 1, 1])


def test_norms_are_those_of_the_canonical_metric():
    curve = spline(5, 3)
    ax = plotting.norms(curve, num=9)
    t, M = np.union1d(np.linspace(*curve.t_span, 9), curve.t), Stiefel(5, 3)
    speed, acceleration, bars = ax.lines
    assert np.array_equal(speed.get_ydata(), M.norm(curve(t), curve.velocity(t)))
    assert np.array_equal(acceleration.get_ydata(), M.norm(curve(t), curve.acceleration(t)))
    assert np.array_equal(bars.get_xdata(), curve.t)
    (alone,) = plotting.norms(curve.pieces[0], order=1, num=9).lines
    assert len(alone.get_xdata()) == 9


@pytest.mark.parametrize("shape", [(3, 2), (3, 1), (6, 2), (2, 2)])
def test_spline_has_path_and_lengths(shape):
    if shape == (2, 2):
        angle = np.linspace(0, 2, 5)
        S = np.moveaxis(np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]), -1, 0)
        curve = st.CubicSpline(angle, S)
    else:
        curve = spline(*shape)
    made = plotting.spline(curve, num=20)
    assert len({ax.figure for ax in made}) == 1
    assert hasattr(made[0], "get_zlim") == (shape[0] == 3)
    assert [ax.get_ylabel() for ax in made[1:]] == ["velocity", "acceleration"]
    t, M = np.union1d(np.linspace(*curve.t_span, 20), curve.t), Stiefel(*shape)
    assert np.array_equal(made[1].lines[0].get_ydata(), M.norm(curve(t), curve.velocity(t)))
    assert np.array_equal(made[2].lines[0].get_ydata(), M.norm(curve(t), curve.acceleration(t)))
    made[0].figure.canvas.draw()
    again = plotting.spline(curve, ax=made, num=20)
    assert all(a is b for a, b in zip(again, made, strict=True))


def test_plot_of_the_plane_puts_columns_on_circles():
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    curve = st.QuasiGeodesic(np.eye(2), turn)
    ax = plotting.plot(curve, num=5)
    lines = tagged(ax, None)
    assert len(lines) == 2
    for column, line in enumerate(lines):
        points = (1 + 0.08 * column) * curve(np.linspace(0, 1, 5))[:, :, column]
        assert np.array_equal(line.get_xydata(), points)
        start, end = tagged(ax, _sphere.KNOT_ID)[2 * column : 2 * column + 2]
        assert np.array_equal(start.get_xydata(), points[:1])
        assert np.array_equal(end.get_xydata(), points[-1:])
        assert (start.get_markerfacecolor(), end.get_markerfacecolor()) == (line.get_color(), palette.BACKGROUND)
    assert [circle.radius for circle in ax.patches] == [1, 1.08]
    plotting.plot(curve, ax=ax)
    assert len(ax.patches) == 2


def test_a_short_arc_is_seen_on_its_circle():
    angle = np.linspace(0, 0.1, 3)
    ax = plotting.plot(np.stack([np.cos(angle), np.sin(angle)], axis=1)[:, :, None])
    assert min(ax.get_xlim()[0], ax.get_ylim()[0]) < -1
    assert ax.get_legend() is None


@pytest.mark.parametrize(("shape", "spherical"), [((3, 1), 1), ((3, 2), 2), ((3, 3), 3), ((4, 2), 0)])
def test_plot_chooses_by_shape(shape, spherical):
    curve = spline(*shape)
    for drawn in (curve, curve(np.linspace(0, 1, 7))):
        ax = plotting.plot(drawn, num=7)
        assert hasattr(ax, "get_zlim") == bool(spherical)
        if spherical:
            assert len(paths(ax)) == spherical
        else:
            assert len([line for line in ax.lines if line.get_gid() is None]) == 8
            assert ax.get_legend() is not None


def test_plot_of_trajectories(trajectory):
    assert np.array_equal(paths(plotting.plot(trajectory))[0], trajectory.point[:, :, 0])


def test_nothing_global_is_touched(pair, trajectory, monkeypatch):
    before = dict(matplotlib.rcParams)
    for name in [name for name in sys.modules if name == "matplotlib.pyplot"]:
        monkeypatch.delitem(sys.modules, name)
    plotting.plot(pair[0]).figure.canvas.draw()
    plotting.spline(spline(3, 2))[0].figure.canvas.draw()
    plotting.body_frame(spline(3, 2)).figure.canvas.draw()
    for ax in (plotting.energy(trajectory), plotting.convergence([1, 2], [1, 0.5]), plotting.error(*pair)):
        ax.figure.canvas.draw()
    assert dict(matplotlib.rcParams) == before
    assert "matplotlib.pyplot" not in sys.modules


FLAT, DEEP = "axes of two dimensions", 'projection="3d"'
BAD = {
    "num 1": (lambda c, t: plotting.plot(c, num=1), "num: a whole number"),
    "num 2.5": (lambda c, t: plotting.sphere(c, num=2.5), "num: a whole number"),
    "num True": (lambda c, t: plotting.entries(c, num=True), "num: a whole number"),
    "text": (lambda c, t: plotting.plot("curve"), "curve: real numbers"),
    "objects": (lambda c, t: plotting.plot(np.array([None])), "curve: real numbers"),
    "complex nan": (lambda c, t: plotting.plot(np.full((2, 3, 1), 1j * np.nan)), "entries are not finite"),
    "dimensions": (lambda c, t: plotting.plot(np.ones((2, 3))), "3 dimensions"),
    "empty": (lambda c, t: plotting.plot(np.ones((0, 3, 1))), "at least one entry"),
    "nan": (lambda c, t: plotting.plot(np.full((2, 3, 1), np.nan)), "6 entries are not finite"),
    "sphere of frames": (lambda c, t: plotting.sphere(spline(3, 2)), r"St\(3,1\) expected, found St\(3,2\)"),
    "frame of a sphere": (lambda c, t: plotting.frame(c), r"St\(3,2\) or St\(3,3\) expected, found St\(3,1\)"),
    "body of a sphere": (lambda c, t: plotting.body_frame(c), r"found St\(3,1\)"),
    "flat axes": (lambda c, t: plotting.sphere(c, ax=axes()), DEEP),
    "deep axes": (lambda c, t: plotting.entries(c, ax=axes3d()), FLAT),
    "no axes": (lambda c, t: plotting.norms(c, ax=3), FLAT),
    "view": (lambda c, t: plotting.sphere(c, view=[0, 0, 0]), "view: a direction"),
    "view of four": (lambda c, t: plotting.sphere(c, view=[1, 0, 0, 0]), "view: a direction"),
    "positions": (lambda c, t: plotting.body_frame(spline(3, 2), positions=np.ones((3, 3))), "positions: shape"),
    "size": (lambda c, t: plotting.body_frame(spline(3, 2), size=0), "size: a positive number"),
    "size of text": (lambda c, t: plotting.body_frame(spline(3, 2), size="a"), "size: a positive number .* 'a'"),
    "two sizes": (lambda c, t: plotting.body_frame(spline(3, 2), size=[1, 2]), r"size: a positive number .* \[1, 2\]"),
    "size nan": (lambda c, t: plotting.body_frame(spline(3, 2), size=np.nan), "size: a positive number"),
    "size out of range": (lambda c, t: plotting.body_frame(spline(3, 2), size=10**400), "size: a positive number"),
    "no floor": (lambda c, t: plotting.fitted_order([1, 2], [1, 1], floor=None), "floor: a number .* None"),
    "orders": (lambda c, t: plotting.norms(c, order=np.array([1, 2])), "order: 1, 2 or None"),
    "energy": (
        lambda c, t: plotting.energy(c),
        "trajectory: a CubicTrajectory or ChartTrajectory expected, found Riem",
    ),
    "times": (lambda c, t: plotting.momentum(t, t=[1, 2]), "t: 13 times expected, found 2"),
    "times of a curve": (lambda c, t: plotting.entries(c, t=[1, 2]), "a curve has its own times"),
    "steps": (lambda c, t: plotting.convergence([1, 1], [1, 1]), "distinct positive"),
    "zero steps": (lambda c, t: plotting.fitted_order([0, 1], [1, 1]), "distinct positive"),
    "errors": (lambda c, t: plotting.convergence([1, 2], {"GCP": [1]}), "errors of GCP: 2 errors expected"),
    "negative": (lambda c, t: plotting.convergence([1, 2], [1, -1]), "no negative error"),
    "infinite": (lambda c, t: plotting.fitted_order([1, 2], [1, np.inf]), "not finite"),
    "floor": (lambda c, t: plotting.fitted_order([1, 2], [1, 1], floor=-1), "floor"),
    "no errors": (lambda c, t: plotting.convergence([1, 2], {}), "at least one method"),
    "error of points": (lambda c, t: plotting.error(np.ones((2, 3, 1)), c), "curve: a Curve expected"),
    "error elsewhere": (lambda c, t: plotting.error(c, spline(3, 1)), "the same manifold and times"),
    "order": (lambda c, t: plotting.norms(c, order=3), "order: 1, 2 or None"),
    "norms": (lambda c, t: plotting.norms(t), "curve: a Curve expected, found CubicTrajectory"),
    "spline": (lambda c, t: plotting.spline(t), "curve: a Curve expected"),
    "two axes": (lambda c, t: plotting.spline(c, ax=[axes3d(), axes()]), "three axes expected, found 2"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_arguments(pair, trajectory, name):
    call, message = BAD[name]
    with pytest.raises(InvalidInputError, match=message):
        call(pair[0], trajectory)


def test_bad_arguments_leave_the_axes_alone(pair):
    ax = axes3d()
    for call in (lambda: plotting.sphere(pair[0], ax=ax, view=[0, 0, 0]), lambda: plotting.frame(pair[0], ax=ax)):
        with pytest.raises(InvalidInputError):
            call()
    assert not ax.lines


def test_without_matplotlib():
    code = "import sys; sys.modules['matplotlib'] = None\nimport stiefel_rs\nimport stiefel_rs.plotting"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=HANGS, check=False)
    assert done.returncode == 1
    assert "ImportError: stiefel_rs.plotting needs matplotlib" in done.stderr
    assert "pip install 'stiefel-rs[plot]'" in done.stderr


def test_example_of_plot_runs(tmp_path, monkeypatch):
    import doctest  # noqa: PLC0415

    monkeypatch.chdir(tmp_path)
    test = doctest.DocTestParser().get_doctest(plotting.plot.__doc__, {}, "plot", None, 0)
    results = doctest.DocTestRunner().run(test)
    assert (results.failed, results.attempted > 3) == (0, True)


def test_the_guide_makes_its_figure(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), flags=re.DOTALL)
    exec(compile(block, str(GUIDE), "exec"), {})
    for name in ("plotting.svg", "overview.svg"):
        assert ElementTree.parse(tmp_path / name).getroot().get("viewBox")
    named = set(re.findall(r"^\| (`.*?`) \|", GUIDE.read_text(encoding="utf-8"), flags=re.MULTILINE))
    found = {name for row in named for name in re.findall(r"`(\w+)`", row)} | {"fitted_order"}
    assert found == set(plotting.__all__)
