"""`stiefel-rs explore`: its curves between two ends, its grid, its page, its command."""

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

from stiefel_rs import InvalidInputError, OutsideDomainError, Stiefel, StiefelError, cli
from stiefel_rs.explore import grid, messages, page, sampling, two_ends
from stiefel_rs.explore.kinds import FIRST
from stiefel_rs.explore.kinds import KINDS as SCENES
from stiefel_rs.explore.sampling import Sampled
from stiefel_rs.explore.two_ends import KINDS

# Two ends.


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("angle", [0.1, 1.2, np.pi])
def test_ends_are_points_with_bases_of_their_tangent_spaces(kind, angle):
    M = Stiefel(3, KINDS[kind].k)
    both = two_ends.ends(KINDS[kind], angle)
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
    a, b = (np.column_stack([e.point, np.cross(*e.point.T)]) for e in two_ends.ends(KINDS["frame"], 0.7))
    assert np.arccos((np.trace(b @ a.T) - 1) / 2) == pytest.approx(0.7, abs=1e-14)


def test_velocities_of_frames_are_angular_velocities_of_the_body():
    start, _ = two_ends.ends(KINDS["frame"], 1.0)
    first, second = start.point.T
    third = np.cross(first, second)
    V = np.tensordot([0.3, -0.4, 0.5], start.basis, 1)
    w = 0.3 * first - 0.4 * second + 0.5 * third
    assert np.allclose(V, np.cross(w, start.point.T).T, atol=1e-15)


@pytest.mark.parametrize("kind", KINDS)
def test_sampled_curves_are_those_of_the_library(kind):
    path, profile, rng = np.linspace(0, 1, 7), np.linspace(0, 1, 401), np.random.default_rng(3)
    v0, v1 = rng.uniform(-2, 2, (2, len(KINDS[kind].parameters)))
    found = sampling.sample(two_ends.find(KINDS[kind], 1.1, v0, v1), path, profile)
    both, M = library(kind, 1.1, v0, v1)
    assert list(found) == list(both)
    for name, curve in both.items():
        S = curve(profile)
        assert np.array_equal(found[name].points, curve(path))
        assert np.array_equal(found[name].speed, M.norm(S, curve.velocity(profile)))
        assert np.array_equal(found[name].acceleration, M.norm(S, curve.acceleration(profile)))
        assert found[name].cost == curve.cost()
        assert found[name].length == pytest.approx(curve.arc_length(), rel=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_lengths_on_the_page_have_three_digits(kind):
    """Kinks of the speed among them, where it is zero."""
    rng = np.random.default_rng(5)
    profile = sampling.profile_times(two_ends.SPAN)
    zeros = np.zeros(len(KINDS[kind].parameters) - 1)
    back = [([v, *zeros], [w, *zeros]) for v, w in [(-2, 3), (-3, -1)]]
    for v0, v1 in [*back, *rng.uniform(-3, 3, (3, 2, len(KINDS[kind].parameters)))]:
        found = two_ends.find(KINDS[kind], 1.1, v0, v1)
        for name, curve in sampling.sample(found, profile, profile).items():
            assert curve.length == pytest.approx(found[name].curve.arc_length(), rel=5e-4)


def test_angle_between_the_curves():
    t = np.linspace(0, 1, 5)
    both, _ = library("sphere", 1.1, [-1, 3], [-1, -3])
    found = sampling.sample(two_ends.find(KINDS["sphere"], 1.1, [-1, 3], [-1, -3]), t, t)
    one, other = (curve(t)[..., 0] for curve in both.values())
    expected = np.arccos(np.clip(np.sum(one * other, axis=1), -1, 1))
    # The inverse cosine loses half of the digits near to zero.
    assert np.allclose(sampling.apart(found), expected, atol=1e-7)
    assert expected.max() > 0.05


def test_angle_between_frames_is_that_of_the_rotation():
    t = np.linspace(0, 1, 5)
    both, _ = library("frame", 1.2, [1, 2, 0], [0, -2, 1])
    found = sampling.sample(two_ends.find(KINDS["frame"], 1.2, [1, 2, 0], [0, -2, 1]), t, t)
    one, other = (
        np.concatenate([S, np.cross(S[..., 0], S[..., 1])[..., None]], axis=-1) for S in (c(t) for c in both.values())
    )
    trace = np.einsum("tij,tij->t", one, other)
    assert np.allclose(sampling.apart(found), np.arccos(np.clip((trace - 1) / 2, -1, 1)), atol=1e-7)


CORNERS = {kind: list(itertools.product((-k.limit, k.limit), repeat=2)) for kind, k in KINDS.items()}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("angle", [0.1, 1.2, np.pi])
def test_samples_are_close_wherever_the_sliders_are(kind, angle):
    """No chord is longer than 0.05 in any column: exact cubics on the sphere have speeds up to 67."""
    parameters = len(KINDS[kind].parameters)
    for v0, v1 in CORNERS[kind]:
        found = two_ends.find(KINDS[kind], angle, [v0] * parameters, [v1] * parameters)
        t = sampling.path_times(found, two_ends.SPAN)
        assert len(t) <= sampling.MAX_SAMPLES
        for curve in found.values():
            if not isinstance(curve, StiefelError):
                chords = np.linalg.norm(np.diff(curve.points(t), axis=0), axis=1)
                assert chords.max() <= 0.05


def test_quick_curves_have_more_samples_up_to_a_bound():
    kind = KINDS["sphere"]
    slow = two_ends.find(kind, 1.0, [0, 0], [0, 0])
    assert len(sampling.path_times(slow, two_ends.SPAN)) == sampling.MIN_SAMPLES
    quick = two_ends.find(kind, np.pi, [7, 7], [7, 7])
    assert sampling.MIN_SAMPLES < len(sampling.path_times(quick, two_ends.SPAN)) < sampling.MAX_SAMPLES
    none = {"gcp": InvalidInputError("none")}
    assert len(sampling.path_times(none, two_ends.SPAN)) == sampling.MIN_SAMPLES


def test_a_missing_curve_is_its_error():
    found = two_ends.find(KINDS["sphere"], np.pi, [0, 0], [0, 0])
    assert isinstance(found["gcp"], OutsideDomainError)
    assert found["gcp"].angle == pytest.approx(np.pi)
    t = np.linspace(0, 1, 3)
    assert isinstance(sampling.sample(found, t, t)["cubic"], Sampled)
    fast = two_ends.find(KINDS["sphere"], 1.0, [15, 15], [0, 0])
    assert isinstance(fast["gcp"], InvalidInputError)
    assert sampling.apart(sampling.sample(fast, t, t)) is None


def test_why_a_curve_is_missing_is_said_without_jargon():
    for angle, v0 in [(np.pi, [0, 0]), (1.0, [15, 15])]:
        error = two_ends.find(KINDS["sphere"], angle, v0, [0, 0])["gcp"]
        text = messages.plain("gcp", error)
        assert text.startswith("No geometric cubic: ") and text.endswith("arrow.")
        assert not re.search("Error|quasi|principal|logarithm|V0|[0-9]", text)


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
        two_ends.find(KINDS["sphere"], angle, v0, [0, 0])


# The grid.


@pytest.fixture
def empty(monkeypatch):
    """Grids without curves, in no time."""
    monkeypatch.setattr(page, "build", lambda name, progress: {"spacing": grid.spacing(name)})


@pytest.fixture
def small(monkeypatch):
    """Grids with a few nodes: the full ones take tens of seconds."""
    axes = {"sphere": (np.array([-2.0, 1.0]), np.array([-3.0, 0.0, 3.0]))}
    axes["frame"] = (np.array([0.0, 1.0]), np.array([1.5]), np.array([-1.0, 1.0]))
    monkeypatch.setattr(grid, "AXES", axes)
    monkeypatch.setattr(grid, "spacing", lambda kind: "few")


def decoded(text, dtype, shape):
    return np.frombuffer(base64.b64decode(text), dtype).reshape(shape)


@pytest.mark.parametrize("kind", KINDS)
def test_grid_holds_what_the_library_gives(small, kind):
    done = []
    made = grid.build(kind, lambda: done.append(1))
    count, m, size = grid.size(kind), made["samples"], 3 * KINDS[kind].k
    assert len(done) == count == {"sphere": 36, "frame": 16}[kind]
    json.dumps(made, allow_nan=False)
    points = decoded(made["points"], "<i2", (count, 2, m, size)) / grid.UNIT
    scales = decoded(made["scales"], "<f8", (count, 5))
    profiles = decoded(made["profiles"], "<i2", (count, 5, m)) / grid.UNIT * scales[:, :, None]
    numbers = decoded(made["numbers"], "<f8", (count, 2, 2))
    t = np.linspace(0, 1, m)
    for node, (v0, v1) in enumerate(grid.nodes(kind)):
        both, M = library(kind, KINDS[kind].angle, v0, v1)
        # Half of a unit, and the round-off of the division.
        half = 0.5000001 / grid.UNIT
        for i, curve in enumerate(both.values()):
            S = curve(t)
            assert np.abs(points[node, i] - S.reshape(m, size)).max() <= half
            lengths = M.norm(S, curve.velocity(t)), M.norm(S, curve.acceleration(t))
            for j, values in enumerate(lengths):
                assert np.abs(profiles[node, 2 * i + j] - values).max() <= half * values.max()
            assert numbers[node, i, 0] == curve.cost()
            assert numbers[node, i, 1] == pytest.approx(curve.arc_length(), rel=5e-4)
        found = two_ends.find(KINDS[kind], KINDS[kind].angle, v0, v1)
        apart = sampling.apart(sampling.sample(found, t, t))
        assert np.abs(profiles[node, 4] - apart).max() <= half * apart.max()
    assert made["errors"] == {}


def test_grid_keeps_errors(monkeypatch):
    monkeypatch.setattr(grid, "AXES", {"sphere": (np.array([0.0, 15.0]), np.array([0.0, 1.0]))})
    made = grid.build("sphere", lambda: None)
    fast = {node for node, velocities in enumerate(grid.nodes("sphere")) if any(15 in v for v in velocities)}
    assert set(made["errors"]) == fast and len(fast) == 12
    assert made["errors"][max(fast)]["gcp"].startswith("No geometric cubic: ")


def test_static_pages_stay_below_six_megabytes():
    def bytes_of_grid(kind):
        count, m, size = grid.size(kind), grid.SAMPLES[kind], 3 * KINDS[kind].k
        return 4 / 3 * count * (2 * 2 * m * size + 2 * 5 * m + 8 * 5 + 8 * 4)

    assert len(page.served("sphere")) + sum(map(bytes_of_grid, KINDS)) < 6_000_000


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_velocities_are_nodes(kind):
    for v in KINDS[kind].velocities:
        for value, axis in zip(v, grid.AXES[kind], strict=True):
            assert value in axis


# The page.


@pytest.fixture(params=["served", "static"])
def text(request, empty):
    return page.served("sphere") if request.param == "served" else page.static("sphere", lambda: None)


def test_the_page_names_no_other_address(text):
    assert not re.findall(r"(?:https?|wss?):?//[\w.]|\bsrc\s*=|@import|url\(|import\(", text)
    assert re.findall(r'href="([^"]*)"', text) == ["data:,"]


def test_the_browser_is_told_to_fetch_nothing(text):
    found = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)[1]
    rules = dict(rule.split(" ", 1) for rule in found.split("; "))
    assert rules["default-src"] == "'none'"
    assert rules["connect-src"] == ("'none'" if '"mode":"static"' in text else "'self'")
    programs = re.findall(r"<script>(.*?)</script>", text, flags=re.DOTALL)
    assert len(programs) == len(page.PROGRAMS) + 1
    assert rules["script-src"].split() == [page._hash(program) for program in programs]
    assert rules["style-src"] == page._hash(re.search(r"<style>(.*?)</style>", text, flags=re.DOTALL)[1])


def test_every_program_is_on_the_page():
    names = {entry.name.removesuffix(".js") for entry in page.PARTS.iterdir() if entry.name.endswith(".js")}
    assert names == {"theme", *page.PROGRAMS}


def test_the_static_page_has_all_scenes_and_says_its_spacing(empty):
    text = page.static("sphere", lambda: None)
    config = json.loads(re.search(r'id="config">(.*?)</script>', text)[1])
    assert set(config["kinds"]) == set(SCENES) == set(config["grids"]) | set(config["fixed"])
    assert "along: -3 to 3 in steps of 1" in config["grids"]["sphere"]["spacing"]


def colours(theme):
    """Custom properties of the style sheet that are colours, as numbers from 0 to 1."""
    style = page._part("page.css")
    light, dark = (
        dict(re.findall(r"--([\w-]+): (#\w+);", block))
        for block in re.findall(r":root[^{]*\{(.*?)\}", style, re.DOTALL)
    )
    found = light | (dark if theme == "dark" else {})
    whole = {name: text if len(text) == 7 else "#" + "".join(2 * c for c in text[1:]) for name, text in found.items()}
    return {name: np.array([int(text[i : i + 2], 16) for i in (1, 3, 5)]) / 255 for name, text in whole.items()}


def luminance(rgb):
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_has_the_contrast_that_wcag_wants(theme):
    found = colours(theme)
    on_cards = ("ink", "soft", "accent", "start", "end", "between", "axis-x", "axis-y", "axis-z")
    pairs = itertools.product(on_cards, ["card"])
    for ink, ground in [*pairs, ("ink", "page"), ("soft", "page"), ("warn", "warn-page"), ("soft", "note-page")]:
        one, other = sorted([luminance(found[ink]), luminance(found[ground])])
        assert (other + 0.05) / (one + 0.05) >= 4.5, (ink, ground)


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


def test_static_writes_a_page(empty, tmp_path, capsys, monkeypatch):
    assert cli.main(["explore", "--kind", "frame", "--out", str(tmp_path / "page.html")]) == 0
    assert capsys.readouterr().out == f"page: {tmp_path / 'page.html'}\n"
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == page.static("frame", lambda: None)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["explore", "--static"]) == 0
    assert (tmp_path / "explore.html").read_text(encoding="utf-8") == page.static(FIRST, lambda: None)


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


def test_what_cannot_be_done_is_said(empty, served, tmp_path, capsys):
    assert cli.main(["explore", "--out", str(tmp_path / "none" / "page.html")]) == 1
    assert "page.html: No such file" in capsys.readouterr().err
    assert cli.main(["explore", "--no-browser", "--port", str(served.server_port)]) == 1
    assert re.fullmatch(rf"stiefel-rs: port {served.server_port}: .* in use\n", capsys.readouterr().err)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a file of Linux")
def test_a_full_device_is_named_and_stays(empty, capsys):
    assert cli.main(["explore", "--out", "/dev/full"]) == 1
    assert capsys.readouterr().err == "stiefel-rs: /dev/full: No space left on device\n"
    assert stat.S_ISCHR(os.stat("/dev/full").st_mode)


@pytest.mark.parametrize("old", [None, "the page of before"])
def test_a_page_that_is_interrupted_leaves_what_was_there(tmp_path, monkeypatch, capsys, old):
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


def test_the_page_needs_no_other_package():
    """NumPy is what the curves need; the page draws by itself."""
    code = "import sys; from stiefel_rs.explore import page; page.served('sphere'); print('plotly' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=HANGS, check=True)
    assert done.stdout == "False\n"
