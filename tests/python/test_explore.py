"""`stiefel-rs explore`: its curves, its grid, its page, its command."""

import base64
import itertools
import json
import os
import re
import signal
import stat
import subprocess
import sys

import numpy as np
import pytest
from beside import HANGS
from explore_problem import library, running

from stiefel_rs import InvalidInputError, OutsideDomainError, Stiefel, cli
from stiefel_rs.explore import curves, grid, page
from stiefel_rs.explore.curves import KINDS, Sampled

pytest.importorskip("plotly")


# The problem.


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("angle", [0.1, 1.2, np.pi])
def test_ends_are_points_with_bases_of_their_tangent_spaces(kind, angle):
    M = Stiefel(3, KINDS[kind].k)
    both = curves.ends(KINDS[kind], angle)
    for end in both:
        M.check_point(end.point, atol=1e-15)
        for V in end.basis:
            M.check_tangent(end.point, V, atol=1e-15)
        gram = np.array([[M.inner(end.point, V, W) for W in end.basis] for V in end.basis])
        assert np.linalg.matrix_rank(gram) == M.dim
    relative = both[1].point @ both[0].point.T
    if kind == "sphere":
        assert np.trace(relative) == pytest.approx(np.cos(angle), abs=1e-15)


def test_ends_of_frames_are_turned_by_the_angle():
    a, b = (np.column_stack([e.point, np.cross(*e.point.T)]) for e in curves.ends(KINDS["frame"], 0.7))
    assert np.arccos((np.trace(b @ a.T) - 1) / 2) == pytest.approx(0.7, abs=1e-14)


def test_velocities_of_frames_are_angular_velocities_of_the_body():
    start, _ = curves.ends(KINDS["frame"], 1.0)
    first, second = start.point.T
    third = np.cross(first, second)
    V = np.tensordot([0.3, -0.4, 0.5], start.basis, 1)
    w = 0.3 * first - 0.4 * second + 0.5 * third
    assert np.allclose(V, np.cross(w, start.point.T).T, atol=1e-15)


@pytest.mark.parametrize("kind", KINDS)
def test_compute_gives_what_the_library_gives(kind):
    t, rng = np.linspace(0, 1, 7), np.random.default_rng(3)
    v0, v1 = rng.uniform(-2, 2, (2, len(KINDS[kind].parameters)))
    found = curves.compute(KINDS[kind], 1.1, v0, v1, t)
    *both, M = library(kind, 1.1, v0, v1)
    for name, curve in zip(("gcp", "cubic"), both, strict=True):
        assert np.array_equal(found[name].points, curve(t))
        assert np.array_equal(found[name].speed, M.norm(curve(t), curve.velocity(t)))
        assert np.array_equal(found[name].acceleration, M.norm(curve(t), curve.acceleration(t)))
        assert found[name].cost == curve.cost()
    assert np.array_equal(curves.distance(found), np.linalg.norm(both[0](t) - both[1](t), axis=(1, 2)))


CORNERS = {kind: list(itertools.product((-k.limit, k.limit), repeat=2)) for kind, k in KINDS.items()}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("angle", [0.1, 1.2, np.pi])
def test_samples_are_close_wherever_the_sliders_are(kind, angle):
    """No chord is longer than 0.05 in any column: exact cubics on the sphere have speeds up to 67."""
    parameters = len(KINDS[kind].parameters)
    for v0, v1 in CORNERS[kind]:
        found = curves.find(KINDS[kind], angle, [v0] * parameters, [v1] * parameters)
        t = curves.times(found)
        assert len(t) <= curves.MAX_SAMPLES
        for sampled in curves.sample(found, t).values():
            if isinstance(sampled, Sampled):
                assert np.linalg.norm(np.diff(sampled.points, axis=0), axis=1).max() <= 0.05


def test_quick_curves_have_more_samples_up_to_a_bound():
    kind = KINDS["sphere"]
    slow = curves.find(kind, 1.0, [0, 0], [0, 0])
    assert len(curves.times(slow)) == curves.MIN_SAMPLES
    for distance, V0, V1 in [(np.pi, [7, 7], [7, 7]), (1.0, [curves.MAX_VELOCITY] * 2, [curves.MAX_VELOCITY, 0])]:
        quick = curves.find(kind, distance, V0, V1)
        speed = curves.sample(quick, np.linspace(0, 1, 2001))["cubic"].speed.max()
        assert curves.MIN_SAMPLES < len(curves.times(quick)) <= curves.MAX_SAMPLES
        assert len(curves.times(quick)) == min(curves.MAX_SAMPLES, np.ceil(speed / curves.CHORD) + 1)
    assert len(curves.times({"gcp": InvalidInputError("none")})) == curves.MIN_SAMPLES


def test_a_missing_curve_is_its_error():
    found = curves.compute(KINDS["sphere"], np.pi, [0, 0], [0, 0], np.linspace(0, 1, 3))
    assert isinstance(found["gcp"], OutsideDomainError)
    assert found["gcp"].angle == pytest.approx(np.pi)
    assert isinstance(found["cubic"], Sampled)
    fast = curves.compute(KINDS["sphere"], 1.0, [15, 15], [0, 0], np.linspace(0, 1, 3))
    assert isinstance(fast["gcp"], InvalidInputError)
    assert curves.distance(fast) is None


@pytest.mark.parametrize(
    ("angle", "v0", "message"),
    [
        (0.0, [0, 0], "angle: from 0"),
        (3.2, [0, 0], "angle: from 0"),
        (np.nan, [0, 0], "angle: from 0"),
        (1.0, [0, 0, 0], "v0: 2 numbers expected"),
        (1.0, [0, np.inf], "v0: not finite"),
        (1.0, [0, 21], "v0: at most 20 expected, found 21"),
        (1.0, ["x", 0], "v0: numbers expected"),
        (1.0, [[1], 0], "v0: numbers expected"),
    ],
)
def test_bad_velocities(angle, v0, message):
    with pytest.raises(InvalidInputError, match=re.escape(message)):
        curves.compute(KINDS["sphere"], angle, v0, [0, 0], np.linspace(0, 1, 3))


# The grid.


@pytest.fixture
def small(monkeypatch):
    """Grids with a few nodes: the full ones take tens of seconds."""
    axes = {"sphere": (np.array([-2.0, 1.0]), np.array([-3.0, 0.0, 3.0]))}
    axes["frame"] = (np.array([0.0, 1.0]), np.array([0.5, 1.5]), np.array([-1.0, 1.0]))
    monkeypatch.setattr(grid, "AXES", axes)
    monkeypatch.setattr(page, "AXES", axes)


def decoded(text, dtype, shape):
    return np.frombuffer(base64.b64decode(text), dtype).reshape(shape)


@pytest.mark.parametrize("kind", KINDS)
def test_grid_holds_what_the_library_gives(small, kind):
    done = []
    made = grid.build(kind, lambda: done.append(1))
    count, m, size = grid.size(KINDS[kind]), made["samples"], 3 * KINDS[kind].k
    assert len(done) == count == {"sphere": 36, "frame": 64}[kind]
    json.dumps(made, allow_nan=False)
    points = decoded(made["points"], "<i2", (count, 2, m, size)) / grid.UNIT
    scales = decoded(made["scales"], "<f8", (count, 5))
    profiles = decoded(made["profiles"], "<i2", (count, 5, m)) / grid.UNIT * scales[:, :, None]
    costs = decoded(made["costs"], "<f8", (count, 2))
    t = np.linspace(0, 1, m)
    for node, (v0, v1) in enumerate(grid.nodes(KINDS[kind])):
        *both, M = library(kind, KINDS[kind].angle, v0, v1)
        # Half a unit, and the round-off of the division.
        half = 0.5000001 / grid.UNIT
        for i, curve in enumerate(both):
            S = curve(t)
            assert np.abs(points[node, i] - S.reshape(m, size)).max() <= half
            lengths = M.norm(S, curve.velocity(t)), M.norm(S, curve.acceleration(t))
            for j, values in enumerate(lengths):
                assert np.abs(profiles[node, 2 * i + j] - values).max() <= half * values.max()
            assert costs[node, i] == curve.cost()
        apart = np.linalg.norm(both[0](t) - both[1](t), axis=(1, 2))
        assert np.abs(profiles[node, 4] - apart).max() <= half * apart.max()
    assert made["errors"] == {}


def test_grid_keeps_errors(monkeypatch):
    monkeypatch.setattr(grid, "AXES", {"sphere": (np.array([0.0, 15.0]), np.array([0.0]))})
    made = grid.build("sphere", lambda: None)
    assert set(made["errors"]) == {1, 2, 3}
    assert made["errors"][2]["gcp"].startswith("InvalidInputError: ")


@pytest.mark.parametrize("kind", KINDS)
def test_static_pages_stay_below_eight_megabytes(kind):
    count, m, size = grid.size(KINDS[kind]), grid.SAMPLES[kind], 3 * KINDS[kind].k
    bytes_of_grid = 4 / 3 * count * (2 * 2 * m * size + 2 * 5 * m + 8 * 5 + 8 * 2)
    assert len(page.served(kind)) + bytes_of_grid < 8_000_000


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_velocities_are_nodes(kind):
    for v in KINDS[kind].velocities:
        for value, axis in zip(v, grid.AXES[kind], strict=True):
            assert value in axis


# The page.


@pytest.fixture(params=["served", "static"])
def text(request, small):
    return page.served("sphere") if request.param == "served" else page.static("sphere", lambda: None)


def test_the_page_names_no_other_address(text):
    own = text.replace(page._script(page.plotly_js()), "")
    assert len(own) < len(text)
    assert not re.findall(r"(?:https?|wss?):?//[\w.]|\bsrc\s*=|@import|url\(|import\(", own)
    assert re.findall(r'href="([^"]*)"', own) == ["data:,"]


def test_the_browser_is_told_to_fetch_nothing(text):
    found = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)[1]
    rules = dict(rule.split(" ", 1) for rule in found.split("; "))
    assert rules["default-src"] == "'none'"
    assert rules["connect-src"] == ("'none'" if '"mode":"static"' in text else "'self'")
    programs = re.findall(r"<script>(.*?)</script>", text, flags=re.DOTALL)
    assert rules["script-src"].split() == [page._hash(program) for program in programs]


def test_the_static_page_says_its_spacing(small):
    assert "-3 to 3 in steps of 3" in page.static("sphere", lambda: None)


def test_data_cannot_end_its_element():
    assert "<" not in page._data("</script><!--")
    assert "</script" not in page._script("a</script>b<!--c")


# The command.


def test_ctrl_c_ends_the_server(spawn):
    process = spawn("-m", "stiefel_rs", "explore", "--no-browser", stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    url = process.stdout.readline().strip()
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{32,}", url)
    process.stdout.readline()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=HANGS)
    assert (process.returncode, out, err) == (0, "stopped\n", "")


def test_static_writes_a_page(small, tmp_path, capsys, monkeypatch):
    assert cli.main(["explore", "--kind", "frame", "--out", str(tmp_path / "page.html")]) == 0
    assert capsys.readouterr().out == f"page: {tmp_path / 'page.html'}\n"
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == page.static("frame", lambda: None)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["explore", "--static"]) == 0
    assert (tmp_path / "explore.html").stat().st_size > 3_000_000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--static", "--port", "0"], "go with a server"),
        (["--out", "x.html", "--no-browser"], "go with a server"),
        (["--port", "70000"], "not a port"),
        (["--port", "-1"], "not a port"),
        (["--kind", "torus"], "invalid choice"),
    ],
)
def test_usage(arguments, message, capsys):
    with pytest.raises(SystemExit) as left:
        cli.main(["explore", *arguments])
    assert left.value.code == 2
    assert message in capsys.readouterr().err


@pytest.fixture
def served():
    with running() as made:
        yield made


def test_what_cannot_be_done_is_said(small, served, tmp_path, capsys):
    assert cli.main(["explore", "--out", str(tmp_path / "none" / "page.html")]) == 1
    assert "page.html: No such file" in capsys.readouterr().err
    assert cli.main(["explore", "--no-browser", "--port", str(served.server_port)]) == 1
    assert re.fullmatch(rf"stiefel-rs: port {served.server_port}: .* in use\n", capsys.readouterr().err)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a file of Linux")
def test_a_full_device_is_named_and_stays(small, capsys):
    assert cli.main(["explore", "--out", "/dev/full"]) == 1
    assert capsys.readouterr().err == "stiefel-rs: /dev/full: No space left on device\n"
    assert stat.S_ISCHR(os.stat("/dev/full").st_mode)


@pytest.mark.parametrize("old", [None, "the page of before"])
def test_a_page_that_is_interrupted_leaves_what_was_there(small, tmp_path, monkeypatch, capsys, old):
    path, seen = tmp_path / "page.html", []
    if old:
        path.write_text(old)

    def interrupted(*_):
        seen.append(len(list(tmp_path.iterdir())))
        raise KeyboardInterrupt

    monkeypatch.setattr(page, "build", interrupted)
    assert cli.main(["explore", "--out", str(path)]) == 130
    assert capsys.readouterr().err == "stiefel-rs: interrupted\n"
    # The file that would have become the page existed next to it, and has been removed.
    assert seen == [2 if old else 1]
    assert [entry.read_text() for entry in tmp_path.iterdir()] == ([old] if old else [])


def test_a_folder_is_no_page(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(page, "build", lambda *_: pytest.fail("worked in vain"))
    assert cli.main(["explore", "--out", str(tmp_path)]) == 1
    assert f"stiefel-rs: {tmp_path}: " in capsys.readouterr().err


def test_without_plotly():
    code = "import sys; sys.modules['plotly'] = None; from stiefel_rs.cli import main; sys.exit(main())"
    for options in (["--no-browser"], ["--out", "/dev/null"]):
        command = [sys.executable, "-c", code, "explore", *options]
        done = subprocess.run(command, capture_output=True, text=True, timeout=HANGS, check=False)
        assert done.returncode == 1
        assert "pip install 'stiefel-rs[explore]'" in done.stderr
