"""The page while it is open: in this thread until it is closed, or in one of its own beside a notebook."""

from __future__ import annotations

import asyncio
import hmac
import secrets
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..exceptions import AntiresError
from .live_canvas import require_bokeh
from .page_session import View

# -- Who is answered: this computer's own browser, on the page that was opened for it


#: Where the page is served; no other computer reaches it.
ADDRESS = "127.0.0.1"
#: Of the token.
BYTES = 24
#: A page of this computer may frame ours: notebooks do.
FRAMED_BY = "http://127.0.0.1:* http://localhost:* vscode-webview:"


class Guard:
    """The checks of every request: its token is known to who was given the address, and to nobody else."""

    def __init__(self, port: int) -> None:
        self.token = secrets.token_urlsafe(BYTES)
        #: Names by which a browser may call this server; a name that was bent to 127.0.0.1 is none.
        self.hosts = f"{ADDRESS}:{port}", f"localhost:{port}"
        self.address = f"http://{ADDRESS}:{port}/?token={self.token}"

    def refuses(self, host: str | None, origin: str | None, token: str | None) -> str | None:
        """Why a request is refused; None if it is answered."""
        if host not in self.hosts:
            return "the address is not this server's own"
        if origin is not None and origin not in {f"http://{name}" for name in self.hosts}:
            return "a page of another origin asked"
        if token is None or not hmac.compare_digest(token.encode(), self.token.encode()):
            return "the token is missing or wrong: open the address that the command printed"
        return None

    def headers(self) -> dict[str, str]:
        """What every answer carries: a page that can load nothing from anywhere else."""
        own = " ".join(f"ws://{name}" for name in self.hosts)
        return {
            "Content-Security-Policy": "default-src 'none'; script-src 'self'; "
            "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
            f"connect-src 'self' {own}; base-uri 'none'; form-action 'none'; frame-ancestors {FRAMED_BY}",
            "Cache-Control": "no-store",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
        }


#: A page that is loaded again is gone for less.
GRACE_S = 3.0
#: Of what a page may send.
MOST_BYTES = 100_000


class Page:
    """A page that is served at ``url``, its address with the token: whoever has that may use the page."""

    def __init__(self, view: View | None = None, *, ends_with_page: bool) -> None:
        require_bokeh()
        self._view = view
        self._ends_with_page = ends_with_page
        self._ready, self._over = threading.Event(), threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stopping: asyncio.Event | None = None
        self._there: asyncio.Event | None = None
        self._failed: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="antires-look", daemon=True)
        self.url = ""

    @property
    def zeros(self) -> Any:
        """The set as it is now, with all edits; None for a page that shows a result."""
        session = getattr(self._view, "session", None)
        return None if session is None else session.zeros

    def show(self, view: View) -> None:
        """What is served, where it was not there when the page was opened: browsers are slow to begin too."""
        self._view = view
        self._warm()
        self._tell(self._there)

    def _warm(self) -> None:
        """Make the first figure, with what has to be imported for it, while the browser begins."""

        def make() -> None:
            with suppress(AntiresError):  # told when the page asks for it
                if self._view is not None:
                    self._view.figure(0)

        threading.Thread(target=make, daemon=True).start()

    async def _viewed(self) -> View:
        """The view, when it is there."""
        assert self._there is not None
        await self._there.wait()
        assert self._view is not None
        return self._view

    @property
    def running(self) -> bool:
        """Whether the page is still answered."""
        return not self._over.is_set()

    def start(self) -> None:
        """Serve in a thread; returns when the page can be opened."""
        self._thread.start()
        if self._view is not None:
            self._warm()
        self._ready.wait()
        if self._failed is not None:
            raise self._failed

    def wait(self) -> None:
        """Return when the page was closed, or Ctrl-C."""
        try:
            while not self._over.wait(0.2):
                pass
        finally:
            self.stop()

    def stop(self) -> None:
        """End the server; pages that are open say so."""
        self._tell(self._stopping)
        self._over.wait(2.0)

    def _tell(self, event: asyncio.Event | None) -> None:
        """Set an event in the thread of the server, unless that has ended."""
        if self._loop is not None and event is not None:
            with suppress(RuntimeError):  # it has
                self._loop.call_soon_threadsafe(event.set)

    def keep_unsaved(self) -> Path | None:
        """Write edits that were not saved beside where they belong, so that closing loses nothing."""
        session = getattr(self._view, "session", None)
        return None if session is None else session.keep_unsaved()

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as exc:  # raised in the thread that started this one
            self._failed = exc
        finally:
            self._over.set()
            self._ready.set()

    async def _serve(self) -> None:
        from tornado.httpserver import HTTPServer
        from tornado.netutil import bind_sockets

        from .page_handlers import Presence, application

        self._loop, self._stopping = asyncio.get_running_loop(), asyncio.Event()
        self._there = asyncio.Event()
        if self._view is not None:
            self._there.set()
        alone = self._stopping.set if self._ends_with_page else (lambda: None)
        presence = Presence(alone, GRACE_S)
        sockets = bind_sockets(0, ADDRESS)
        guard = Guard(sockets[0].getsockname()[1])
        server = HTTPServer(application(self._viewed, guard, presence), max_body_size=MOST_BYTES)
        server.add_sockets(sockets)
        self.url = guard.address
        self._ready.set()
        await self._stopping.wait()
        server.stop()
        presence.close()
        await asyncio.sleep(0.05)  # for the sockets to say goodbye
        await server.close_all_connections()


def in_notebook() -> bool:
    """Whether this is the kernel of a notebook."""
    shell = sys.modules.get("IPython")
    found = None if shell is None else shell.get_ipython()
    return found is not None and "IPKernelApp" in getattr(found, "config", {})
