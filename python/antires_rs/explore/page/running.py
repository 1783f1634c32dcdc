"""The page while it is open: in this thread until it is closed, or in one of its own beside a notebook."""

from __future__ import annotations

import asyncio
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...exceptions import AntiresError
from ..canvas import require_bokeh
from .guard import ADDRESS, Guard

if TYPE_CHECKING:
    from .view import View

__all__ = ["Page"]

#: A page that is loaded again is gone for less.
GRACE_S = 3.0


class Page:
    """A page that is served.

    Attributes
    ----------
    url : str
        Its address, with the token. Whoever has it may use the page.
    """

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

        from .server import MOST_BYTES, Presence, application

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
