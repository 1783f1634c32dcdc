"""A headless browser for tests of pages; they are skipped, saying so, where there is none."""

import shutil
from contextlib import contextmanager
from urllib.parse import urlsplit

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")


class Watched:
    """A page of a browser whose requests are counted; what is not this computer is not reached."""

    def __init__(self, page):
        self.page, self.elsewhere, self.wrong = page, [], []
        page.route("**/*", self._routed)
        page.on("pageerror", lambda error: self.wrong.append(str(error)))
        page.on("console", lambda said: self.wrong.append(said.text) if said.type == "error" else None)

    def _routed(self, route):
        address = urlsplit(route.request.url)
        if address.hostname in ("127.0.0.1", None):
            route.continue_()
        else:
            self.elsewhere.append(route.request.url)
            route.abort()


@contextmanager
def browser():
    """A Chromium under the control of playwright."""
    control = pytest.importorskip("playwright.sync_api", reason="clicks in a browser need playwright")
    found = next((path for path in map(shutil.which, NAMES) if path), None)
    if found is None:
        pytest.skip("clicks in a browser need Chromium")
    with control.sync_playwright() as play:
        started = play.chromium.launch(executable_path=found, args=["--no-sandbox"])
        try:
            yield started
        finally:
            started.close()
