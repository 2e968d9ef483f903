"""The page of ``stiefel-rs explore`` in Chromium: times from drag to curve, and the picture of the documentation.

``python -m benchmarks.explore`` drags one handle of each scene and prints the times that the page measures, from the
event of the pointer to the drawn curve, in ms. ``--picture FILE`` takes the picture instead. Needs selenium, chromium
and chromedriver.
"""

from __future__ import annotations

import argparse
import base64
import shutil
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
from tabulate import tabulate  # type: ignore[import-untyped]

from stiefel_rs.explore.server import Server

HANDLES: Final = {
    "points": '[data-key="keyframe-2"]',
    "rotations": '[data-key="body"]',
    "sphere": '[data-key="start-0"]',
    "frame": '[data-key="end-1"]',
}
MOVES: Final = 120
# Seconds between two moves: a little less than those of a screen of 60 Hz.
PAUSE: Final = 0.015
WIDTH, HEIGHT = 1280, 800
OPTIONS: Final = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--force-prefers-reduced-motion")


@contextmanager
def page(kind: str) -> Iterator[Any]:
    """Open the page with a server of its own."""
    from selenium import webdriver  # noqa: PLC0415

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    for option in (*OPTIONS, f"--window-size={WIDTH},{HEIGHT}"):
        options.add_argument(option)
    with Server(kind) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
        try:
            screen = {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False}
            browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
            browser.get(server.url)
            _wait(browser)
            yield browser
        finally:
            browser.quit()
            server.shutdown()


def _wait(browser: Any) -> None:
    while browser.execute_script("return document.body.dataset.state") != "ready":
        time.sleep(0.01)


def latency(kind: str) -> list[float]:
    """Return the times from moves of the pointer to curves, in ms."""
    with page(kind) as browser:
        box = "const b = document.querySelector(arguments[0]).getBoundingClientRect();"
        x, y = browser.execute_script(f"{box} return [b.x + b.width / 2, b.y + b.height / 2]", HANDLES[kind])

        def mouse(event: str, dx: float, dy: float) -> None:
            values = {"type": event, "x": x + dx, "y": y + dy, "button": "left", "buttons": 1, "clickCount": 1}
            browser.execute_cdp_cmd("Input.dispatchMouseEvent", values)

        mouse("mousePressed", 0, 0)
        for i in range(MOVES):
            angle = 4 * np.pi * i / MOVES
            mouse("mouseMoved", 30 * np.sin(angle), 18 * (1 - np.cos(angle)))
            time.sleep(PAUSE)
        mouse("mouseReleased", 0, 0)
        _wait(browser)
        return list(browser.execute_script("return Explore.app.latency"))


def picture(path: Path) -> None:
    """Take the picture of the documentation."""
    with page("rotations") as browser:
        browser.execute_script("Explore.app.scene().select(1); Explore.app.player.seek(2.5); Explore.app.repaint()")
        options = {"format": "webp", "quality": 90}
        path.write_bytes(base64.b64decode(browser.execute_cdp_cmd("Page.captureScreenshot", options)["data"]))


def main() -> None:
    """Print the table of times, or take the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--picture", type=Path, metavar="FILE")
    arguments = parser.parse_args()
    if arguments.picture:
        picture(arguments.picture)
        return
    rows = [(kind, *np.percentile(latency(kind), [50, 95, 100])) for kind in HANDLES]
    print(tabulate(rows, ("scene", "median ms", "95 % ms", "largest ms"), floatfmt=".1f"))


if __name__ == "__main__":
    main()
