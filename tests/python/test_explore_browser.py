"""The page of `stiefel-rs explore` in a real browser, against the library."""

import json
import re
import shutil
from contextlib import contextmanager

import numpy as np
import pytest
from beside import wait_for
from explore_problem import library, running
from scipy.spatial import cKDTree

from stiefel_rs import cli
from stiefel_rs.explore import grid, page
from stiefel_rs.explore.curves import KINDS

pytest.importorskip("plotly")

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
OPTIONS = """--headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking
--disable-component-update --disable-sync --window-size=1240,1000""".split()


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    if CHROMIUM is None or DRIVER is None:
        pytest.skip("chromium or chromedriver is not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for option in (*OPTIONS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def served():
    with running() as made:
        yield made


@pytest.fixture(scope="module")
def static_page(tmp_path_factory):
    """The static page of the sphere with fewer nodes: the full one takes half a minute."""
    path = tmp_path_factory.mktemp("static") / "page.html"
    axes = {"sphere": (np.linspace(-3, 3, 4), np.linspace(-3, 3, 3))}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(grid, "AXES", axes)
        patch.setattr(page, "AXES", axes)
        assert cli.main(["explore", "--static", "--out", str(path)]) == 0
    return path


def wait(browser):
    state = "return document.body && document.body.dataset.state"
    wait_for(lambda: browser.execute_script(state) == "ready")


class Shown:
    """The state that the page shows."""

    def __init__(self, browser):
        wait(browser)
        self.velocities = json.loads(browser.execute_script("return document.body.dataset.velocities"))
        text = "return document.getElementById(arguments[0]).textContent"
        self.texts = {name: browser.execute_script(text, name) for name in ("cost-gcp", "cost-cubic", "distance-max")}
        data = "return document.getElementById(arguments[0]).data.map(d => [d.name, d.x, d.y])"
        self.charts = {
            chart: {
                name: (np.array(x, float), np.array(y, float)) for name, x, y in browser.execute_script(data, chart)
            }
            for chart in ("sphere", "speed", "acceleration", "distance")
        }

    def path(self, name, side):
        """Flat coordinates of the drawn part of a curve on one half, shape (T, 2), with gaps as NaN."""
        return np.stack(self.charts["sphere"][f"{name} {side}"], axis=1)

    def vertices(self, name):
        """Flat coordinates of the points of a curve, both halves together, without gaps."""
        whole = np.concatenate([self.path(name, side) for side in ("near", "far")])
        return whole[~np.isnan(whole[:, 0])]

    def agrees(self, kind, angle, tolerance):
        """Everything agrees with the library for the velocities that the page states."""
        *both, M = library(kind, angle, *self.velocities)
        t, dense = self.charts["speed"]["gcp"][0], np.linspace(0, 1, 20001)
        for name, curve in zip(("gcp", "cubic"), both, strict=True):
            assert float(self.texts[f"cost-{name}"]) == pytest.approx(curve.cost(), rel=1e-5)
            S = curve(t)
            points, depths = flat(S)
            for side, here in (("near", depths > tolerance), ("far", depths < -tolerance)):
                assert (gaps(points[here], self.path(name, side)) <= tolerance).all()
            # Nothing else is drawn; between samples of a grid, to the accuracy that the documentation promises.
            assert gaps(self.vertices(name), flat(curve(dense))[0]).max() < 3e-4
            for chart, vectors in (("speed", curve.velocity(t)), ("acceleration", curve.acceleration(t))):
                lengths = M.norm(S, vectors)
                assert np.allclose(self.charts[chart][name][1], lengths, atol=tolerance * lengths.max())
        apart = np.linalg.norm(both[0](t) - both[1](t), axis=(1, 2))
        assert np.allclose(self.charts["distance"]["distance"][1], apart, atol=tolerance * max(1, apart.max()))
        assert float(self.texts["distance-max"]) == pytest.approx(apart.max(), rel=1e-4)


def flat(S):
    """Flat coordinates of the columns of points in the first view, and their depths, positive on the near half."""
    a, e = 0.25, 0.35
    right = np.array([-np.sin(a), np.cos(a), 0])
    up = np.array([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)])
    front = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    return np.stack([(right @ S).ravel(), (up @ S).ravel()], axis=1), (front @ S).ravel()


def gaps(points, others):
    """Distance of each point to the nearest of others, which may contain NaN."""
    return cKDTree(others[~np.isnan(others[:, 0])]).query(points)[0]


def changed(one, other, name):
    """The distance of a curve from its previous drawing."""
    return gaps(one.vertices(name), other.vertices(name)).max()


def drag_handle(browser, end, column, x, y):
    from selenium.webdriver.common.action_chains import ActionChains  # noqa: PLC0415

    handle = browser.find_element("css selector", f'.handle[data-end="{end}"][data-column="{column}"]')
    ActionChains(browser).drag_and_drop_by_offset(handle, x, y).perform()


def move_slider(browser, name, value):
    """Set a value and send an input event, as the keyboard does."""
    script = (
        "const e = document.getElementById(arguments[0]); e.value = arguments[1]; e.dispatchEvent(new Event('input'))"
    )
    browser.execute_script(script, name, value)


def press(browser, name, key):
    from selenium.webdriver.common.keys import Keys  # noqa: PLC0415

    browser.find_element("id", name).send_keys(getattr(Keys, key))


def assert_quiet(browser, allowed=()):
    entries = [entry for entry in browser.get_log("browser") if not any(word in entry["message"] for word in allowed)]
    assert entries == [], entries


@contextmanager
def opened(browser, url):
    browser.get(url)
    browser.get_log("browser")
    browser.refresh()
    wait(browser)
    yield
    assert_quiet(browser)


def test_the_served_page_in_a_browser(browser, served):
    with opened(browser, served.url):
        kind = KINDS["sphere"]
        first = Shown(browser)
        assert first.velocities == [list(v) for v in kind.velocities]
        first.agrees("sphere", kind.angle, 1e-12)

        drag_handle(browser, 0, 0, 40, -30)
        dragged = Shown(browser)
        assert dragged.velocities[1] == first.velocities[1]
        assert np.abs(np.subtract(dragged.velocities[0], first.velocities[0])).min() > 0.2
        assert dragged.texts["cost-gcp"] != first.texts["cost-gcp"]
        assert dragged.texts["cost-cubic"] != first.texts["cost-cubic"]
        assert changed(dragged, first, "cubic") > 0.01
        dragged.agrees("sphere", kind.angle, 1e-12)

        press(browser, "end-1", "ARROW_RIGHT")
        slid = Shown(browser)
        assert slid.velocities == [dragged.velocities[0], [-1, -2.95]]
        slid.agrees("sphere", kind.angle, 1e-12)

        move_slider(browser, "angle", 2.5)
        far = Shown(browser)
        far.agrees("sphere", 2.5, 1e-12)
        assert far.texts != slid.texts


def test_the_handle_follows_the_pointer(browser, served):
    """The tip of the arrow ends at the point to which it was dragged: on the page's plane, within a pixel."""
    with opened(browser, served.url):
        box = "const b = document.querySelector('.handle').getBoundingClientRect();"
        where = f"{box} return [b.x + b.width / 2, b.y + b.height / 2]"
        before = np.array(browser.execute_script(where))
        drag_handle(browser, 0, 0, 25, 35)
        wait(browser)
        assert np.allclose(np.array(browser.execute_script(where)) - before, [25, 35], atol=1.5)


def test_frames_in_a_browser(browser, served):
    with opened(browser, served.url):
        browser.find_element("id", "kind-frame").click()
        first = Shown(browser)
        kind = KINDS["frame"]
        assert first.velocities == [list(v) for v in kind.velocities]
        first.agrees("frame", kind.angle, 1e-12)
        drag_handle(browser, 1, 1, 20, 30)
        dragged = Shown(browser)
        # Dragging the second column does not rotate the frame about it.
        assert dragged.velocities[0] == first.velocities[0]
        assert dragged.velocities[1][1] == first.velocities[1][1]
        assert dragged.velocities[1][0] != first.velocities[1][0]
        assert dragged.texts["cost-gcp"] != first.texts["cost-gcp"]
        dragged.agrees("frame", kind.angle, 1e-12)
        browser.find_element("id", "reset").click()
        assert Shown(browser).velocities == first.velocities


def longest_chord(shown, name):
    paths = [shown.path(name, side) for side in ("near", "far")]
    return np.nanmax([np.nanmax(np.linalg.norm(np.diff(path, axis=0), axis=1)) for path in paths if len(path) > 2])


def assert_halves_meet(shown, name):
    """At the rim, each piece of one half meets a piece of the other."""
    ends = {}
    for side in ("near", "far"):
        path = shown.path(name, side)
        gap = np.flatnonzero(np.isnan(path[:, 0]))
        pieces = [piece[~np.isnan(piece[:, 0])] for piece in np.split(path, gap)]
        ends[side] = np.array([end for piece in pieces if len(piece) for end in (piece[0], piece[-1])])
        assert len(ends[side]) > 2
    for side, other in (("near", "far"), ("far", "near")):
        loose = ends[side][gaps(ends[side], ends[other]) > 0]
        # Only the curve's own ends.
        assert len(loose) <= 2
        meeting = ends[side][gaps(ends[side], ends[other]) == 0]
        assert np.allclose(np.linalg.norm(meeting, axis=1), 1, atol=1e-12)


def test_a_quick_curve_is_drawn_without_kinks_and_gaps(browser, served):
    with opened(browser, served.url):
        move_slider(browser, "angle", 3.14)
        for name in ("start-0", "start-1", "end-0", "end-1"):
            move_slider(browser, name, 7)
        shown = Shown(browser)
        assert shown.velocities == [[7, 7], [7, 7]]
        # Steps of 1/100 of the time would exceed the allowed length eightfold.
        assert shown.charts["speed"]["cubic"][1].max() > 40
        assert longest_chord(shown, "cubic") <= 0.05
        assert_halves_meet(shown, "cubic")


@pytest.mark.parametrize("width", [320, 400, 640, 801, 900, 1240])
def test_sliders_can_be_moved_on_screens_of_any_width(browser, served, width):
    screen = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    try:
        with opened(browser, served.url):
            for kind in KINDS:
                browser.find_element("id", f"kind-{kind}").click()
                wait(browser)
                lengths = [slider.size["width"] for slider in browser.find_elements("css selector", "#controls input")]
                assert len(lengths) == 2 * len(KINDS[kind].parameters) + 1
                assert min(lengths) >= 100
                wide = "e => e.getBoundingClientRect().right > innerWidth + 0.5"
                script = f"return Array.from(document.querySelectorAll('body *')).filter({wide}).map(e => e.outerHTML)"
                assert browser.execute_script(script) == []
                assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_errors_are_shown_on_the_page(browser, served):
    with opened(browser, served.url):
        move_slider(browser, "angle", 3.14)
        for name in ("start-0", "start-1", "end-0", "end-1"):
            move_slider(browser, name, 0)
        wait(browser)
        message = browser.find_element("id", "message")
        assert message.is_displayed()
        assert re.search(r"No geometric cubic: \w+Error: ", message.text)
        assert browser.find_element("id", "cost-gcp").text == "none"
        browser.find_element("id", "reset").click()
        wait(browser)
        assert not message.is_displayed()


def test_turning_the_sphere_changes_the_view_alone(browser, served):
    from selenium.webdriver.common.action_chains import ActionChains  # noqa: PLC0415

    with opened(browser, served.url):
        first = Shown(browser)
        stage = browser.find_element("id", "overlay")
        ActionChains(browser).move_to_element_with_offset(stage, 0, 60).click_and_hold().move_by_offset(
            50, 0
        ).release().perform()
        turned = Shown(browser)
        assert turned.velocities == first.velocities
        assert turned.texts == first.texts
        assert changed(turned, first, "cubic") > 0.05


def test_the_static_page_in_a_browser(browser, static_page):
    with opened(browser, static_page.as_uri()):
        kind, nodes = KINDS["sphere"], (-3, -1, 0, 1, 3)
        # Half units of the precision in which the grid is stored.
        tolerance = 0.51 / grid.UNIT * 2
        first = Shown(browser)
        assert first.velocities == [list(v) for v in kind.velocities]
        first.agrees("sphere", kind.angle, tolerance)

        drag_handle(browser, 0, 0, 60, 45)
        dragged = Shown(browser)
        assert dragged.velocities != first.velocities
        assert all(value in nodes for velocity in dragged.velocities for value in velocity)
        assert dragged.texts["cost-gcp"] != first.texts["cost-gcp"]
        assert changed(dragged, first, "cubic") > 0.01
        dragged.agrees("sphere", kind.angle, tolerance)
        # Its samples are farther apart.
        assert len(dragged.charts["speed"]["cubic"][0]) == grid.SAMPLES["sphere"]
        assert dragged.charts["speed"]["cubic"][1].max() / (grid.SAMPLES["sphere"] - 1) > 0.09
        assert longest_chord(dragged, "cubic") <= 0.05

        press(browser, "end-0", "ARROW_RIGHT")
        slid = Shown(browser)
        assert slid.velocities == [dragged.velocities[0], [1, -3]]
        slid.agrees("sphere", kind.angle, tolerance)
        assert "along: -3 to 3 in steps of 2; across: -3 to 3 in steps of 3" in browser.find_element("id", "note").text
        fetched = browser.execute_script("return performance.getEntriesByType('resource').map(e => e.name)")
        assert [name for name in fetched if not name.startswith("data:")] == []


def test_the_browser_asks_nobody_else(browser, served):
    with opened(browser, served.url):
        drag_handle(browser, 1, 0, 10, 10)
        wait(browser)
        fetched = browser.execute_script("return performance.getEntriesByType('resource').map(e => e.name)")
        own = f"http://127.0.0.1:{served.server_port}/curves"
        assert {name for name in fetched if not name.startswith("data:")} == {own}
