"""The built site behind a server, and Chromium: `make check-docs`. Without one of them the tests are skipped."""

import functools
import http.server
import shutil
import threading
from pathlib import Path

import pytest
from page import Page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
OPTIONS = "--headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking --disable-sync".split()
SITE = Path(__file__).parents[2] / "site"


def pytest_addoption(parser):
    parser.addoption("--site", type=Path, default=SITE, help="folder of the built site")


def pytest_generate_tests(metafunc):
    """A test with `path` runs for every page of the site."""
    if "path" in metafunc.fixturenames:
        site = metafunc.config.getoption("--site")
        pages = sorted(path.relative_to(site).as_posix() for path in site.rglob("*.html") if path.name != "404.html")
        metafunc.parametrize("path", pages)


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Files, without a line for each of them."""

    def log_message(self, *_):
        pass


@pytest.fixture(scope="session")
def address(request):
    """Where the site is served; its search needs a server."""
    folder = request.config.getoption("--site")
    if not (folder / "index.html").exists():
        pytest.skip(f"{folder} has no site: make docs")
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    webdriver = pytest.importorskip("selenium.webdriver")
    if CHROMIUM is None or DRIVER is None:
        pytest.skip("chromium or chromedriver is not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for option in (*OPTIONS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(option)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    yield driver
    driver.quit()


@pytest.fixture
def page(browser, address):
    return Page(browser, address)
