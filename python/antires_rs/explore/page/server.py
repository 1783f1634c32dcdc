"""The server of the page: every request is checked, nothing is read from disk but the page's own files."""

from __future__ import annotations

import asyncio
import json
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

from ...exceptions import AntiresError
from ..canvas import script_files
from .commands import View, refusal
from .guard import Guard

__all__ = ["Presence", "application"]

ASSETS = Path(__file__).with_name("assets")
KINDS = {".js": "text/javascript", ".css": "text/css", ".html": "text/html"}
#: Of what a page may send.
MOST_BYTES = 100_000


class Presence:
    """Which pages are open: each holds a socket, which goes with it.

    ``alone`` is called when the last page has been gone for ``grace_s``, in which it may have been reloaded.
    """

    def __init__(self, alone: Any, grace_s: float) -> None:
        self._alone, self._grace_s = alone, grace_s
        self._open: set[Any] = set()
        self._waiting: asyncio.TimerHandle | None = None

    def came(self, page: Any) -> None:
        """A page was opened."""
        self._open.add(page)
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None

    def went(self, page: Any) -> None:
        """A page was closed, or lost."""
        self._open.discard(page)
        if not self._open and self._waiting is None:
            self._waiting = asyncio.get_running_loop().call_later(self._grace_s, self._alone)

    def close(self) -> None:
        """Close the sockets of all pages, which say that the server has ended."""
        for page in tuple(self._open):
            page.close()


@cache
def asset(name: str) -> bytes:
    """A file of the page, or BokehJS."""
    file = script_files()[0] if name == "bokeh.js" else ASSETS / name
    return file.read_bytes()


def application(view: View, guard: Guard, presence: Presence) -> Any:
    """The ``tornado.web.Application`` that shows a view."""
    from tornado.web import Application, HTTPError, RequestHandler
    from tornado.websocket import WebSocketHandler

    # One at a time, in order, beside the thread that answers.
    worker = ThreadPoolExecutor(1, thread_name_prefix="antires-look")

    class Guarded(RequestHandler):
        def prepare(self) -> None:
            asked = self.request
            token = self.get_query_argument("token", None)
            why = guard.refuses(asked.headers.get("Host"), asked.headers.get("Origin"), token)
            if why is not None:
                raise HTTPError(403, log_message=why)

        def set_default_headers(self) -> None:
            self.clear_header("Server")
            for name, value in guard.headers().items():
                self.set_header(name, value)

        def write_error(self, status_code: int, **kwargs: Any) -> None:
            exc = kwargs.get("exc_info", (None, None))[1]
            self.set_header("Content-Type", "text/plain; charset=utf-8")
            self.finish(f"{status_code}: {getattr(exc, 'log_message', None) or 'not done'}\n")

        def log_exception(self, *what: Any) -> None:
            if not isinstance(what[1], HTTPError):
                super().log_exception(*what)

        def plain(self, data: Any) -> None:
            self.set_header("Content-Type", "application/json; charset=utf-8")
            self.finish(json.dumps(data, allow_nan=False))

        def shown(self) -> int:
            try:
                return int(self.get_query_argument("shown", "0"))
            except ValueError:
                raise HTTPError(400, log_message="shown is a number") from None

    class Page(Guarded):
        def get(self) -> None:
            text = asset("page.html").decode()
            self.finish(text.replace("{{token}}", guard.token))

    class Asset(Guarded):
        def get(self, name: str) -> None:
            self.set_header("Content-Type", f"{KINDS[Path(name).suffix]}; charset=utf-8")
            self.finish(asset(name))

    class State(Guarded):
        def get(self) -> None:
            self.plain({"title": view.title, **_kindly(lambda: view.state(self.shown()))})

    class Figure(Guarded):
        async def get(self) -> None:
            shown = self.shown()
            loop = asyncio.get_running_loop()
            # In a thread: the first figure waits for imports, and the socket must go on being answered.
            self.plain(await loop.run_in_executor(None, lambda: _kindly(lambda: view.figure(shown))))

    class Do(Guarded):
        async def post(self, command: str) -> None:
            shown = self.shown()
            try:
                sent = json.loads(self.request.body or b"{}")
            except ValueError:
                raise HTTPError(400, log_message="that is not JSON") from None
            if not isinstance(sent, dict):
                raise HTTPError(400, log_message="that is no JSON object")

            def done() -> dict[str, Any]:
                return {"said": view.do(command, sent), **view.state(shown)}

            if command in view.slow:
                loop = asyncio.get_running_loop()
                self.plain(await loop.run_in_executor(worker, lambda: _kindly(done)))
            else:
                self.plain(_kindly(done))

    class Download(Guarded):
        def get(self) -> None:
            found = view.file()
            if found is None:
                raise HTTPError(404)
            self.set_header("Content-Type", "application/json; charset=utf-8")
            name = "".join(c if c.isascii() and (c.isalnum() or c in "._- ") else "_" for c in found[0])
            self.set_header("Content-Disposition", f'attachment; filename="{name}"')
            self.finish(found[1])

    class Alive(Guarded, WebSocketHandler):
        def check_origin(self, origin: str) -> bool:
            return guard.refuses(self.request.headers.get("Host"), origin, guard.token) is None

        def open(self, *args: str, **kwargs: str) -> None:
            presence.came(self)

        def on_message(self, message: str | bytes) -> None:
            """Pages send nothing; what comes is not answered."""

        def on_close(self) -> None:
            presence.went(self)

    return Application(
        [
            (r"/", Page),
            (r"/(bokeh\.js|page\.js|page\.css)", Asset),
            (r"/state", State),
            (r"/figure", Figure),
            (r"/do/(\w+)", Do),
            (r"/download", Download),
            (r"/alive", Alive),
        ],
        default_handler_class=_not_found(Guarded),
        log_function=lambda handler: None,
        websocket_ping_interval=5,
    )


def _not_found(base: Any) -> Any:
    from tornado.web import HTTPError

    class NotFound(base):  # type: ignore[misc]
        """Guarded too: who has no token does not learn what there is."""

        def get(self) -> None:
            raise HTTPError(404)

    return NotFound


def _kindly(work: Any) -> dict[str, Any]:
    """What came of it, or why it was refused."""
    try:
        made: dict[str, Any] = work()
        return made
    except AntiresError as exc:
        return refusal(exc)
