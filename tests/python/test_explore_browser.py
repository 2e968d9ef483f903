"""The page of `stiefel-rs explore` in a real browser, against the library."""

import itertools
import re
import shutil

import numpy as np
import pytest
from beside import wait_for
from explore_page import OPTIONS, Page
from explore_problem import library, running, spline
from scipy.spatial.transform import Rotation

from stiefel_rs import cli
from stiefel_rs.explore import grid, keyframes, two_ends
from stiefel_rs.explore.kinds import KINDS

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
if CHROMIUM is None or DRIVER is None:
    pytest.skip("chromium or chromedriver is not installed", allow_module_level=True)

# Of 32-bit floats and of times that are rounded to them.
SINGLE = 2e-6


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for option in (*OPTIONS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    yield Page(driver)
    driver.quit()


@pytest.fixture(scope="module")
def served():
    with running() as made:
        yield made


@pytest.fixture(scope="module")
def static_page(tmp_path_factory):
    """The static page with fewer nodes: the whole one takes half a minute."""
    path = tmp_path_factory.mktemp("static") / "page.html"
    axes = {"sphere": (np.linspace(-3, 3, 4), np.linspace(-3, 3, 3))}
    axes["frame"] = (np.array([-1.5, 1.5]), np.array([0, 1.5]), np.array([-1.5, 1.5]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(grid, "AXES", axes)
        assert cli.main(["explore", "--static", "--kind", "sphere", "--out", str(path)]) == 0
    return path


def three(number):
    """Three digits, as the page writes numbers of this size."""
    return f"{number:#.3g}".rstrip(".") if abs(number) > 1e-9 else "0.00"


def assert_shows_cubics(page, kind, *, stored=False):
    """Curves and costs are what the library gives for the velocities of the page."""
    state = page.state()
    both, _ = library(kind, state["angle"], *state["velocities"])
    for name, curve in both.items():
        t, points = page.curve(name)
        wrong = np.abs(points - curve(t)).max(axis=(1, 2))
        if stored:
            # Samples of the grid, rounded in all entries, and what the page draws between them.
            every = (len(t) - 1) // (grid.SAMPLES[kind] - 1)
            assert wrong[::every].max() <= 1 / grid.UNIT and wrong.max() <= 3e-4
        else:
            assert wrong.max() <= SINGLE
        assert page.cost(name) == three(curve.cost())
    excess = 100 * (both["gcp"].cost() / both["cubic"].cost() - 1)
    assert page.text("excess").replace("\u2212", "-") == f"{'+' if excess >= 0 else ''}{three(excess)} %"


def assert_shows_spline(page, kind):
    state = page.state()
    curve = spline(kind, state["t"], state["values"], state["ends"])
    t, points = page.curve("spline")
    assert np.abs(points - curve(np.clip(t, *curve.t_span))).max() <= 10 * SINGLE
    assert page.cost("spline") == three(curve.cost())


# Two ends.


def test_velocities_are_dragged_and_typed(page, served):
    with page.opened(served.url, "sphere"):
        assert page.state()["velocities"] == [list(v) for v in two_ends.KINDS["sphere"].velocities]
        assert_shows_cubics(page, "sphere")
        place = page.centre(".handle.start")
        page.drag(".handle.start", (25, -35))
        # The tip of the arrow is where it was dragged to.
        assert np.allclose(page.centre(".handle.start") - place, (25, -35), atol=1.5)
        dragged = page.state()["velocities"]
        assert dragged[1] == [-1, -3] and np.abs(np.subtract(dragged[0], [-1, 3])).max() > 0.2
        assert_shows_cubics(page, "sphere")
        page.press("#end-1", "\ue014")
        assert page.state()["velocities"] == [dragged[0], [-1, -2.95]]
        page.press(".handle.end", "\ue012")
        assert page.state()["velocities"][1] != [-1, -2.95]
        page.slide("angle", 2.5)
        assert_shows_cubics(page, "sphere")
        assert re.fullmatch(r"drag to curve .* ms", page.text("took"))


def test_frames_are_dragged_by_their_columns(page, served):
    with page.opened(served.url, "frame"):
        first = page.state()["velocities"]
        assert_shows_cubics(page, "frame")
        page.drag('[data-key="end-1"]', (20, 30))
        dragged = page.state()["velocities"]
        # Dragging the second column does not turn the frame about it.
        assert dragged[0] == first[0] and dragged[1][1] == first[1][1] and dragged[1][0] != first[1][0]
        assert_shows_cubics(page, "frame")
        page.click("reset")
        assert page.state()["velocities"] == first


def test_a_limit_is_said_and_seen(page, served):
    with page.opened(served.url, "sphere"):
        stage = page.box("#stage")
        with page.dragged(".handle.start", (-40, -500)):
            page.wait()
            assert page.status() == ["limit", "Velocity at the start, across: at most 7.00 rad/s here."]
            assert "limit" in page.run("return document.querySelector('.handle.start').className")
            assert page.state()["velocities"][0][1] == 7
            assert np.array_equal(page.box("#stage"), stage)
        # The next touch takes it back.
        page.drag(".handle.start", (40, 200))
        assert page.status()[0] == "hint"


def test_a_missing_curve_is_said_in_words_and_nothing_moves(page, served):
    with page.opened(served.url, "sphere"):
        boxes = [page.box(name) for name in ("#stage", "#numbers", "#controls", "#charts")]
        page.slide("angle", 3.14)
        for name in ("start-0", "start-1", "end-0", "end-1"):
            page.slide(name, 0)
        level, text = page.status()
        assert level == "problem" and text.startswith("No geometric cubic: ")
        assert not re.search("Error|quasi|logarithm", text)
        assert page.cost("gcp") == "none"
        after = [page.box(name) for name in ("#stage", "#numbers", "#controls", "#charts")]
        assert np.array_equal(boxes, after)
        page.click("reset")
        assert page.status()[0] == "hint"
        page.run("window.fetch = () => Promise.reject(new TypeError('no connection'))")
        page.slide("start-0", 1)
        assert page.status() == ["problem", "The program that computes has ended. Start stiefel-rs explore again."]
        assert np.array_equal(page.box("#stage"), boxes[0])


def test_late_answers_are_not_shown(page, served):
    """Of two requests, the first is answered after the second."""
    with page.opened(served.url, "sphere"):
        page.run("""const real = window.fetch;
        window.fetch = (...request) => {
          window.fetch = real;
          return new Promise((done) => { window.release = () => real(...request).then(done); });
        };""")
        before = page.cost("cubic")
        for value in (2, 3):
            page.slide("start-0", value, wait=False)
        wait_for(lambda: page.cost("cubic") != before)
        assert page.run("return document.body.dataset.state") == "busy"
        page.run("window.release()")
        page.wait()
        assert page.state()["velocities"][0][0] == 3
        assert_shows_cubics(page, "sphere")


# Keyframes.


def test_points_are_dragged(page, served):
    with page.opened(served.url, "points"):
        assert_shows_spline(page, "points")
        before, place = page.state()["values"], page.centre('[data-key="keyframe-2"]')
        page.drag('[data-key="keyframe-2"]', (30, -50))
        values = page.state()["values"]
        assert np.allclose(page.centre('[data-key="keyframe-2"]') - place, (30, -50), atol=1.5)
        assert [value == old for value, old in zip(values, before, strict=True)] == [True, True, False, True, True]
        assert_shows_spline(page, "points")
        page.press('[data-key="keyframe-2"]', "\ue014")
        assert page.state()["values"][2] != values[2]
        page.slide("longitude", 1)
        x, y, _ = page.state()["values"][2]
        assert np.arctan2(y, x) == pytest.approx(1, abs=1e-12)
        with page.dragged('[data-key="keyframe-1"]', (0, -600)):
            assert page.status() == ["limit", "Keyframe 2 is at the rim. Turn the view to move it on."]


def test_rotations_are_dragged_as_bodies(page, served):
    with page.opened(served.url, "rotations"):
        assert_shows_spline(page, "rotations")
        first = page.state()["values"]
        # On the stage: the keyframe that is nearest in time.
        page.run("Explore.app.player.seek(2.7)")
        page.drag(".handle.body", (40, 25))
        turned = page.state()
        assert turned["selected"] == 2 and turned["values"][2] != first[2]
        # As a ball of the sphere's radius under the pointer.
        radius = page.run("return Explore.app.camera().radius")
        half = abs(np.dot(turned["values"][2], first[2]))
        assert 2 * np.arccos(half) == pytest.approx(np.hypot(40, 25) / radius, abs=2e-3)
        assert_shows_spline(page, "rotations")
        # In the row, by the tip of an axis, by keys and by buttons.
        page.drag(".body-key:nth-of-type(4)", (12, 5))
        assert page.state()["selected"] == 3 and page.state()["values"][3] != first[3]
        before = page.state()["values"][3]
        page.drag('[data-key="tip-2"]', (10, 10))
        assert page.state()["values"][3] != before
        before = page.state()["values"][3]
        page.press(".body-key:nth-of-type(4)", "\ue014")
        assert page.state()["values"][3] != before
        before = page.state()["values"][3]
        page.click("turn-x")
        assert 2 * np.arccos(np.dot(page.state()["values"][3], before)) == pytest.approx(0.1, abs=1e-9)
        assert_shows_spline(page, "rotations")


def test_times_are_dragged_up_to_the_neighbours(page, served):
    with page.opened(served.url, "points"):
        t = page.state()["t"]
        page.drag(".marker:nth-of-type(2)", (40, 0))
        moved = page.state()["t"]
        assert t[1] < moved[1] < t[2] and moved[2:] == t[2:]
        assert_shows_spline(page, "points")
        with page.dragged(".marker:nth-of-type(2)", (600, 0)):
            assert page.status() == ["limit", "Keyframe 2 stays 0.200 s before keyframe 3."]
            assert "limit" in page.run("return document.querySelectorAll('.marker')[1].className")
        assert page.state()["t"][1] == pytest.approx(t[2] - keyframes.GAP)
        page.press(".marker:nth-of-type(1)", "\ue012")
        assert page.status() == ["limit", "Times begin at 0 s."]


def test_keyframes_are_added_and_removed(page, served):
    with page.opened(served.url, "rotations"):
        cost = page.cost("spline")
        page.run("Explore.app.player.seek(2.1)")
        page.click("add")
        state = page.state()
        assert len(state["t"]) == 6 and state["t"][state["selected"]] == 2.1
        # It lies on the curve, which stays nearly the same.
        assert abs(float(page.cost("spline")) - float(cost)) < 0.05 * float(cost)
        assert_shows_spline(page, "rotations")
        for _ in range(2):
            page.click("add")
        page.click("add")
        assert page.status() == ["limit", "At most 8 keyframes here."]
        for _ in range(6):
            page.click("remove")
        assert len(page.state()["t"]) == 2
        page.click("remove")
        assert page.status() == ["limit", "A curve needs 2 keyframes."]
        assert_shows_spline(page, "rotations")
        page.click("reset")
        assert len(page.state()["t"]) == 5


def test_ends_of_the_spline_come_to_rest(page, served):
    with page.opened(served.url, "points"):
        choose = "const e = document.getElementById('end-conditions'); e.value = 'clamped';"
        page.run(f"{choose} e.dispatchEvent(new Event('change'))")
        page.wait()
        assert_shows_spline(page, "points")
        assert page.run("return Explore.app.answer().curves.spline.speed[0]") < 1e-9


# The film.


@pytest.mark.parametrize("kind", ["points", "rotations"])
def test_play_moves_the_frame(page, served, kind):
    with page.opened(served.url, kind):
        first, still = page.text("clock"), page.pixels()
        page.click("play")
        wait_for(lambda: page.run("return Explore.app.player.time()") > 0.02)
        page.click("play")
        assert page.run("return document.body.dataset.playing") == "false"
        assert page.text("clock") != first and page.pixels() != still
        moved = page.pixels()
        assert page.pixels() == moved
        page.press("#head", "\ue010")
        assert page.status()[0] == "hint"
        end = "return Explore.app.player.time() === Explore.app.scene().span()[1]"
        assert page.run(end)
        page.run("Explore.app.player.seek(2); Explore.app.repaint()")
        with page.dragged("#head", (600, 0)):
            assert page.status()[1].startswith("The curve ends at")
        assert page.run(end)


def test_the_film_begins_by_itself_unless_less_motion_is_wanted(page, served):
    try:
        with page.opened(served.url):
            assert page.run("return document.body.dataset.playing") == "false"
        page.emulate(prefers_reduced_motion="no-preference")
        with page.opened(served.url):
            wait_for(lambda: page.run("return document.body.dataset.playing") == "true")
    finally:
        page.emulate()


def test_the_moving_frame_of_a_point_is_carried_without_turning(page, served):
    """Its tangent axes have no angular velocity about the normal."""
    with page.opened(served.url, "points"):
        script = """const a = Explore.app.answer();
        return arguments[0].map((t) => Explore.samples.axes(a.curves.spline, 1, a.t, t))"""
        state = page.state()
        times = np.linspace(0.1, 5.3, 201)
        frames = np.array(page.run(script, times.tolist()))
        assert np.allclose(frames @ frames.transpose(0, 2, 1), np.eye(3), atol=1e-12)
        curve = spline("points", state["t"], state["values"])
        assert np.allclose(frames[:, 2], curve(times)[..., 0], atol=1e-3)
        turning = np.sum(np.diff(frames[:, 0], axis=0) * (frames[1:, 1] + frames[:-1, 1]) / 2, axis=1)
        assert abs(turning.sum()) < 0.01


# The page.


def test_dark_mode_follows_the_system_and_the_button(page, served):
    theme = "return document.documentElement.dataset.theme"
    ground = "return getComputedStyle(document.documentElement).backgroundColor"
    try:
        page.emulate(prefers_color_scheme="dark")
        with page.opened(served.url):
            dark, picture = page.run(ground), page.pixels()
            assert page.run(theme) == "dark"
            page.click("theme")
            assert page.run(theme) == "light"
            assert page.run(ground) != dark and page.pixels() != picture
            page.emulate(prefers_color_scheme="light")
            wait_for(lambda: not page.run("return matchMedia('(prefers-color-scheme: dark)').matches"))
            page.emulate(prefers_color_scheme="dark")
            wait_for(lambda: page.run(theme) == "dark")
    finally:
        page.emulate()


def test_turning_the_view_changes_nothing_else_and_has_a_limit(page, served):
    with page.opened(served.url, "points"):
        first, cost, picture = page.state(), page.cost("spline"), page.pixels()
        page.drag("#view", (50, 0), grip=(0, 120))
        assert page.state() == first and page.cost("spline") == cost
        assert page.pixels() != picture
        with page.dragged("#view", (0, 700), grip=(-60, 0)):
            assert page.status() == ["limit", "The view is straight above a pole and turns no further."]


def test_curves_are_hidden(page, served):
    with page.opened(served.url, "rotations"):
        picture = page.pixels()
        page.click("show-slerp")
        assert page.pixels() != picture
        page.click("show-slerp")
        assert page.pixels() == picture


def test_a_quick_curve_is_drawn_without_kinks_and_gaps(page, served):
    """Chords are short, and at the rim the pieces of both halves meet."""
    with page.opened(served.url, "sphere"):
        page.slide("angle", 3.14)
        for name in ("start-0", "start-1", "end-0", "end-1"):
            page.slide(name, 7)
        script = """const path = Explore.samples.paths(Explore.app.answer().curves.cubic, 1);
        return [true, false].map((near) => Explore.paths.half(path, Explore.app.camera(), near))"""
        halves = [[np.array(piece) for piece in pieces] for pieces in page.run(script)]
        chords = [np.linalg.norm(np.diff(piece, axis=0), axis=1) for pieces in halves for piece in pieces]
        assert max(chord.max() for chord in chords if len(chord)) <= 0.05
        ends = [np.array([end for piece in pieces for end in (piece[0], piece[-1])]) for pieces in halves]
        for one, other in (ends, ends[::-1]):
            gap = np.linalg.norm(one[:, None] - other, axis=2).min(axis=1)
            # The curve's own ends alone are loose.
            assert len(one) >= 4 and np.sum(gap > 0) <= 2
            assert np.allclose(np.linalg.norm(one[gap == 0], axis=1), 1, atol=1e-12)


def test_rotations_of_the_page_are_those_of_scipy(page, served):
    """Quaternions to axes and back, half turns among them, products, and the least rotation between vectors."""
    rng = np.random.default_rng(4)
    quaternions = np.concatenate([rng.normal(size=(20, 4)), np.eye(4), [[1, 1, 0, 0], [0, 1, -1, 0]]])
    rotations = Rotation.from_quat(quaternions)
    a, b = rng.normal(size=(2, 3, 3))
    b[0] = -a[0]
    a, b = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (a, b))
    script = """const v = Explore.vectors;
    const [q, p] = [arguments[0], arguments[0].toReversed()];
    return [q.map(v.axesOf), q.map((x) => v.ofAxes(v.axesOf(x))), q.map((x, i) => v.composed(x, p[i])),
      arguments[1].map((x, i) => v.rotated(v.between(x, arguments[2][i]), x))]"""
    with page.opened(served.url):
        unit = rotations.as_quat().tolist()
        axes, back, products, images = map(np.array, page.run(script, unit, a.tolist(), b.tolist()))
    # Each axis is a column.
    assert np.allclose(axes.transpose(0, 2, 1), rotations.as_matrix(), atol=1e-14)
    assert (Rotation.from_quat(back).inv() * rotations).magnitude().max() < 1e-7
    assert ((rotations * rotations[::-1]).inv() * Rotation.from_quat(products)).magnitude().max() < 1e-7
    assert np.allclose(images, b, atol=1e-14)


def test_numbers_have_three_digits(page, served):
    with page.opened(served.url):
        cases = {0: "0.00", 1: "1.00", -2.5: "\u22122.50", 0.123456: "0.123", 9.999: "10.0", 99.96: "100"}
        cases |= {1234.5: "1230", 123456: "1.23 \u00d7 10⁵", 1.5e-5: "1.50 \u00d7 10⁻⁵", 0.001: "0.00100"}
        assert page.run("return arguments[0].map(Explore.numbers.three)", list(cases)) == list(cases.values())


def test_screens_of_any_width(page, served):
    try:
        with page.opened(served.url):
            for width, kind in itertools.product([320, 400, 640, 865], KINDS):
                page.resize(width)
                page.choose(kind)
                wide = "e => e.getBoundingClientRect().right > innerWidth + 0.5"
                script = f"return Array.from(document.querySelectorAll('body *')).filter({wide}).map(e => e.outerHTML)"
                assert page.run(script) == []
                assert page.run("return document.documentElement.scrollWidth") <= width
                sliders = page.run("return [...document.querySelectorAll('.row input')].map((e) => e.clientWidth)")
                assert min(sliders) >= 100
                assert min(page.box("#stage")[2:]) >= 280
    finally:
        page.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_the_page_asks_nobody_else(page, served):
    with page.opened(served.url, "points"):
        page.drag('[data-key="keyframe-2"]', (10, 10))
        assert page.resources() == {f"http://127.0.0.1:{served.server_port}/curves"}


def test_the_static_page(page, static_page):
    with page.opened(static_page.as_uri()):
        nodes = (-3, -1, 0, 1, 3)
        assert_shows_cubics(page, "sphere", stored=True)
        page.drag(".handle.start", (80, 60))
        dragged = page.state()["velocities"]
        assert dragged[0] != [-1, 3] and all(value in nodes for velocity in dragged for value in velocity)
        assert_shows_cubics(page, "sphere", stored=True)
        assert page.status() == ["note", "Without a server, velocities snap to a grid of computed curves."]
        assert "along: -3 to 3 in steps of 2" in page.text("spacing")
        page.choose("frame")
        assert_shows_cubics(page, "frame", stored=True)
        page.choose("rotations")
        assert_shows_spline(page, "rotations")
        assert page.status()[1].startswith("Without a server, keyframes cannot be moved.")
        assert page.browser.find_elements("css selector", ".handle, #controls input") == []
        assert page.resources() == set()
