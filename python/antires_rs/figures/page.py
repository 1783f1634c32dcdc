"""The page of a set: its life, and how it is opened, in a notebook too."""

from __future__ import annotations

import asyncio
import os
import sys
import tempfile
import threading
import time
import webbrowser
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..exceptions import AntiresError
from ..signals.repeats import one_source
from ..support.checks import forces_at
from .live_canvas import require_bokeh
from .page_session import Session, SetView, View

GRACE_S = 3.0  # a page that is loaded again is gone for less
MOST_BYTES = 100_000  # of what a page may send


class Page:
    """A page that is served at ``url``, its address with the token: whoever has that may use the page."""

    def __init__(self, view: View | None = None, *, ends_with_page: bool) -> None:
        require_bokeh()
        self._view: Future[View] = Future()
        if view is not None:
            self.show(view)
        self._ends_with_page = ends_with_page
        self._ready, self._over = threading.Event(), threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stopping: asyncio.Event | None = None
        self._failed: BaseException | None = None
        self.url = ""
        self._redirect: Path | None = None

    def show(self, view: View) -> None:
        """What is served, where it was not there when the page was opened: browsers are slow to begin too."""
        if not self._view.done():
            self._view.set_result(view)

    @property
    def _session(self) -> Session | None:
        return getattr(self._view.result(), "session", None) if self._view.done() else None

    @property
    def zeros(self) -> Any:
        """The set as it is now, with all edits."""
        return None if self._session is None else self._session.zeros

    @property
    def running(self) -> bool:
        """Whether the page is still answered."""
        return not self._over.is_set()

    def start(self) -> None:
        """Serve in a thread; returns when the page can be opened."""
        for work in (self._run, self._warm):
            threading.Thread(target=work, name="antires-look", daemon=True).start()
        self._ready.wait()
        if self._failed is not None:
            raise self._failed

    def in_browser(self) -> bool:
        """Open it, by a file that redirects: all users of a computer see the arguments of a browser."""
        home = Path.home()
        with suppress(OSError):
            # In the open: browsers in a sandbox see neither hidden folders nor those of other programs.
            place = home if os.access(home, os.W_OK) else None
            handle, name = tempfile.mkstemp(".html", "antires_look_", place)  # of mode 0600
            self._redirect = Path(name)
            with open(handle, "w", encoding="utf-8") as file:
                file.write(f'<!doctype html><meta http-equiv="refresh" content="0;url={self.url}">')
            return webbrowser.open(self._redirect.as_uri())
        return False

    def wait(self) -> None:
        """Return when the page was closed, or Ctrl-C."""
        try:
            while not self._over.wait(0.2):
                pass
        finally:
            self.stop()

    def stop(self) -> None:
        """End the server; pages that are open say so."""
        if self._loop is not None and self._stopping is not None:
            with suppress(RuntimeError):  # it has ended
                self._loop.call_soon_threadsafe(self._stopping.set)
        self._over.wait(2.0)

    def keep_unsaved(self) -> Path | None:
        """Write edits that were not saved beside where they belong, so that closing loses nothing."""
        return None if self._session is None else self._session.keep_unsaved()

    def _warm(self) -> None:
        """Make the first figure, with what has to be imported for it, while the browser begins."""
        with suppress(AntiresError):  # told when the page asks for it
            self._view.result().figure(0)

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as exc:  # raised in the thread that started this one
            self._failed = exc
        finally:
            if self._redirect is not None:
                self._redirect.unlink(missing_ok=True)
            self._over.set()
            self._ready.set()

    async def _serve(self) -> None:
        from tornado.httpserver import HTTPServer
        from tornado.netutil import bind_sockets

        from .page_handlers import ADDRESS, Guard, Presence, application

        self._loop, self._stopping = asyncio.get_running_loop(), asyncio.Event()
        presence = Presence(self._stopping.set if self._ends_with_page else (lambda: None), GRACE_S)
        sockets = bind_sockets(0, ADDRESS)
        guard = Guard(sockets[0].getsockname()[1])
        server = HTTPServer(application(self._view, guard, presence), max_body_size=MOST_BYTES)
        server.add_sockets(sockets)
        self.url = guard.address
        self._ready.set()
        await self._stopping.wait()
        server.stop()
        presence.close()
        await asyncio.sleep(0.05)  # for the sockets to say goodbye
        await server.close_all_connections()


# -- Opening it: in the browser of this computer, or inside a notebook

INLINE_PX = 820  # height of the page in a notebook, in pixels
LAST_WORD_S = 0.5  # for the page to say why there is nothing to see


def opened(
    make: Callable[[], View],
    title: str,
    *,
    wait: bool | None = None,
    browser: bool = True,
    say: Callable[[str], Any] = print,
) -> Page:
    """Serve a view and show it."""
    shell = "IPython" in sys.modules and sys.modules["IPython"].get_ipython()
    inline = "IPKernelApp" in getattr(shell, "config", {})  # the kernel of a notebook
    wait = not inline if wait is None else wait
    page = Page(ends_with_page=wait or not inline)
    page.start()
    try:
        if inline:
            from IPython.display import IFrame, display

            display(IFrame(page.url, width="100%", height=INLINE_PX))
        else:
            say(f"looking at {title}: {page.url}")
            if browser and not page.in_browser():
                say("No browser was found; open that address.")
        page.show(make())
    except BaseException as exc:
        if isinstance(exc, AntiresError):
            page.show(View(title, exc))
            time.sleep(LAST_WORD_S)
        page.stop()
        raise
    if wait:
        try:
            page.wait()
        except KeyboardInterrupt:
            print(file=sys.stderr)
        finally:
            kept = page.keep_unsaved()
            if kept is not None:
                say(f"Edits that were not saved are in {kept}")
    return page


def of_set(
    zeros: Any, source: Any, save_to: Any, options: Mapping[str, Any], *, wait: bool | None, browser: bool
) -> Page:
    """What :meth:`~antires_rs.AntiresonanceSet.look` does."""
    require_bokeh()
    given, signal = dict(options), None if source is None else one_source(source)
    own = {name: given.pop(name, None) for name in ("band_hz", "max_order")}
    session = Session(zeros, signal, **own, options=given, save_to=save_to)
    title = f"antiresonances, {forces_at(zeros.excitation)}"
    return opened(lambda: SetView(session, title), title, wait=wait, browser=browser)
