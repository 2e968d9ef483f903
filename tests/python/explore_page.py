"""The page of `stiefel-rs explore` in a browser: what it shows, and what a hand does on it."""

from contextlib import contextmanager

import numpy as np
from beside import wait_for

OPTIONS = """--headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking
--disable-component-update --disable-sync --force-prefers-reduced-motion --window-size=1240,900""".split()


class Page:
    """The page in a browser of selenium."""

    def __init__(self, browser):
        self.browser = browser

    def run(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def wait(self):
        wait_for(lambda: self.run("return document.body && document.body.dataset.state") == "ready")

    @contextmanager
    def opened(self, url, kind=None):
        """Load the page; afterwards the browser must have said nothing."""
        self.browser.get_log("browser")
        self.browser.get(url)
        self.wait()
        if kind:
            self.choose(kind)
        yield
        entries = self.browser.get_log("browser")
        assert entries == [], entries

    def choose(self, kind):
        self.run("document.getElementById(arguments[0]).click()", f"kind-{kind}")
        self.wait()

    def click(self, name):
        self.browser.find_element("id", name).click()
        self.wait()

    def text(self, name):
        return self.run("return document.getElementById(arguments[0]).textContent", name)

    def cost(self, curve):
        return self.run("return document.getElementById(arguments[0]).firstChild.textContent", f"cost-{curve}")

    def state(self):
        return self.run("return Explore.app.scene().state")

    def curve(self, name):
        """Times and points of a curve as the page has them."""
        script = """const a = Explore.app.answer();
        return [Array.from(a.t), Explore.samples.paths(a.curves[arguments[0]], Explore.app.info().columns)]"""
        t, paths = map(np.array, self.run(script, name))
        return t, paths.transpose(1, 2, 0)

    def status(self):
        return self.run("const s = document.getElementById('status'); return [s.dataset.level, s.textContent]")

    def box(self, selector):
        script = "const b = document.querySelector(arguments[0]).getBoundingClientRect();"
        return np.array(self.run(f"{script} return [b.x, b.y, b.width, b.height]", selector))

    def centre(self, selector):
        x, y, width, height = self.box(selector)
        return np.array([x + width / 2, y + height / 2])

    def mouse(self, kind, place, buttons=1):
        x, y = map(float, place)
        event = {"type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1}
        self.browser.execute_cdp_cmd("Input.dispatchMouseEvent", event)

    @contextmanager
    def dragged(self, selector, by, steps=4, grip=(0, 0)):
        """Drag something; it is let go afterwards."""
        start = self.centre(selector) + grip
        self.mouse("mousePressed", start)
        for part in np.linspace(0, 1, steps + 1)[1:]:
            self.mouse("mouseMoved", start + part * np.array(by))
        yield
        self.mouse("mouseReleased", start + by, 0)
        self.wait()

    def drag(self, selector, by, **options):
        with self.dragged(selector, by, **options):
            pass

    def slide(self, name, value, *, wait=True):
        """As the keyboard does: to a value, and an input event."""
        set_to = "const e = document.getElementById(arguments[0]); e.value = arguments[1];"
        self.run(f"{set_to} e.dispatchEvent(new Event('input'))", name, value)
        if wait:
            self.wait()

    def press(self, selector, key):
        self.browser.find_element("css selector", selector).send_keys(key)
        self.wait()

    def emulate(self, **features):
        """Pretend a preference of the system."""
        wanted = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": wanted})

    def resize(self, width):
        screen = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)

    def resources(self):
        """Addresses of what the page has fetched."""
        names = self.run("return performance.getEntriesByType('resource').map(e => e.name)")
        return {name for name in names if not name.startswith("data:")}

    def pixels(self):
        """The picture as one text."""
        return self.run("return document.getElementById('view').toDataURL()")
