"""A page of the site in Chromium: its width, what scrolls in it, and its search."""

import time

# A page or an answer that is waited for longer hangs.
HANGS = 60

READY = """
const tables = document.querySelectorAll('.md-content table:not([class])');
return document.readyState === 'complete' && document.fonts.status === 'loaded'
  && Array.from(tables).every(table => table.closest('.md-typeset__scrollwrap'));
"""
SCROLLING = """
return Array.from(document.querySelectorAll(arguments[0]))
  .filter(each => each.scrollWidth > each.clientWidth + 1 && getComputedStyle(each).display !== 'inline')
  .map(each => `${each.scrollWidth} > ${each.clientWidth}: ${each.textContent.trim().slice(0, 60)}`);
"""
TABLES = ".md-content .md-typeset__scrollwrap, .md-content .md-typeset__table, .md-content table"
SIGNATURES = ".doc-signature, .doc-signature pre, .doc-signature code"
RESULTS = """
return Array.from(document.querySelectorAll('.md-search-result__item')).map(
  item => item.querySelector('a').getAttribute('href'));
"""


class Page:
    """What Chromium shows."""

    def __init__(self, browser, address):
        self.browser, self.address = browser, address

    def resize(self, width):
        """Show pages on a screen of that many pixels."""
        screen = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)

    def open(self, path):
        """Open a page of the site and wait until its tables are laid out."""
        self.browser.get(f"{self.address}/{path}")
        self.wait(READY)

    def wait(self, script, *arguments):
        """The result of a script, as soon as it is something."""
        start = time.monotonic()
        while not (found := self.browser.execute_script(script, *arguments)):
            if time.monotonic() > start + HANGS:
                raise TimeoutError(script)
            time.sleep(0.02)
        return found

    def scrolling(self, selector):
        """Elements that are wider inside than outside."""
        return self.browser.execute_script(SCROLLING, selector)

    def width(self):
        """Pixels that the page takes."""
        return self.browser.execute_script("return document.documentElement.scrollWidth")

    def prefer(self, scheme):
        """Show pages as on a system whose users prefer "light" or "dark", without an earlier choice on the page."""
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        self.open("index.html")
        self.browser.execute_script("localStorage.clear()")

    def search(self, word):
        """Addresses that the search box lists for a word, best first."""
        self.open("index.html")
        field = self.browser.find_element("css selector", ".md-search__input")
        # At once: letter by letter the first results would be those of a part of the word.
        script = (
            "arguments[0].focus(); arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('keyup'))"
        )
        self.browser.execute_script(script, field, word)
        return [address.split("?")[0].removeprefix(f"{self.address}/") for address in self.wait(RESULTS)]
