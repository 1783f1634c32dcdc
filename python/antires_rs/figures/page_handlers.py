"""The server of a page: every request is checked, nothing is read from disk but the page's own files."""

from __future__ import annotations

import asyncio
import hmac
import json
import secrets
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import nullcontext, suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from threading import Lock, Thread
from typing import Any

from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketHandler

from ..exceptions import AntiresError, InvalidInputError
from .live_canvas import script_files
from .page_session import TAKEN, View

#: Files of the page, and their kinds.
FILES = dict.fromkeys(("bokeh.js", "page.js", "tables.js"), "text/javascript") | {"page.css": "text/css"}
Work = Callable[[], dict[str, Any]]


# -- Who is answered: this computer's own browser, on the page that was opened for it

ADDRESS = "127.0.0.1"  # where the page is served; no other computer reaches it
BYTES = 24  # of the token
FRAMED_BY = "http://127.0.0.1:* http://localhost:* vscode-webview:"  # notebooks of this computer do


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


# -- Who is there


class Presence:
    """Which pages are open; ``alone`` is called when the last has been gone for ``grace_s``, not reloaded."""

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


def application(view: Future[View], guard: Guard, presence: Presence) -> Application:
    """What shows a view, which may have to be waited for."""
    own = {"view": view, "guard": guard, "presence": presence, "turn": Lock()}  # the turn of what takes long
    quiet = {"log_function": lambda handler: None, "websocket_ping_interval": 5}
    return Application([(r"/alive", _Alive), (r"/(.*)", _Page)], **quiet, **own)


class _Guarded(RequestHandler):  # type: ignore[misc]
    """What both handlers begin with: who is asking? Who has no token does not learn what there is."""

    def prepare(self) -> None:
        asked = self.request
        token = self.get_query_argument("token", None)
        why = self.settings["guard"].refuses(asked.headers.get("Host"), asked.headers.get("Origin"), token)
        if why is not None:
            raise HTTPError(403, log_message=why)

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        for name, value in self.settings["guard"].headers().items():
            self.set_header(name, value)

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        exc = kwargs.get("exc_info", (None, None))[1]
        self.send(f"{status_code}: {getattr(exc, 'log_message', None) or 'not done'}\n", "text/plain")

    def log_exception(self, *what: Any) -> None:
        if not isinstance(what[1], HTTPError):
            super().log_exception(*what)

    def send(self, data: Any, kind: str = "application/json") -> None:
        self.set_header("Content-Type", f"{kind}; charset=utf-8")
        self.finish(data if isinstance(data, str | bytes) else json.dumps(data, allow_nan=False))


class _Page(_Guarded):
    """The page, its files, and what it asks: the view's state, a figure, a command."""

    async def get(self, path: str) -> None:
        if not path:
            html = asset("page.html").decode()
            self.send(html.replace("{{token}}", self.settings["guard"].token), "text/html")
        elif path in FILES:
            self.send(asset(path), FILES[path])
        elif path == "state":
            shown, view = await self.shown()
            self.send({"title": view.title, **kindly(lambda: view.state(shown))})
        elif path == "figure":
            shown, view = await self.shown()
            # In a thread: the first figure waits for imports, and the socket must go on being answered.
            await self.aside(lambda: view.figure(shown))
        elif path == "download" and (found := (await self.shown())[1].file()) is not None:
            name = "".join(c if c.isascii() and (c.isalnum() or c in "._- ") else "_" for c in found[0])
            self.set_header("Content-Disposition", f'attachment; filename="{name}"')
            self.send(found[1])
        else:
            raise HTTPError(404)

    async def post(self, path: str) -> None:
        place, _, command = path.partition("/")
        if place != "do" or not command.isidentifier():
            raise HTTPError(404)
        shown, view = await self.shown()
        sent = None
        with suppress(ValueError, RecursionError):
            sent = json.loads(self.request.body or b"{}")
        if not isinstance(sent, dict):
            raise HTTPError(400, log_message="that is no JSON object")

        def done() -> dict[str, Any]:
            return {"said": view.do(command, sent), **view.state(shown)}

        if command in view.slow:
            await self.aside(done, self.settings["turn"])
        else:
            self.send(kindly(done))

    async def shown(self) -> tuple[int, View]:
        """What the page shows, when it is there: its number among all, and the view."""
        text = self.get_query_argument("shown", "0")
        if not text.isascii() or not text.isdecimal() or len(text) > 9:
            raise HTTPError(400, log_message="shown is a number")
        return int(text), await asyncio.shield(asyncio.wrap_future(self.settings["view"]))

    async def aside(self, work: Work, turn: Lock | None = None) -> None:
        """Answer from a thread that the end of the server does not wait for; one at a time in a turn."""
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[dict[str, Any]] = loop.create_future()

        def run() -> None:
            try:
                with turn or nullcontext():
                    tell, made = answer.set_result, kindly(work)
            except BaseException as exc:  # told as an answer that failed
                tell, made = answer.set_exception, exc  # type: ignore[assignment]
            with suppress(RuntimeError):  # the server has ended meanwhile
                loop.call_soon_threadsafe(tell, made)

        Thread(target=run, daemon=True, name="antires-look").start()
        self.send(await answer)


class _Alive(_Guarded, WebSocketHandler):  # type: ignore[misc]
    """The socket of a page that is open."""

    def check_origin(self, origin: str) -> bool:
        guard = self.settings["guard"]
        return guard.refuses(self.request.headers.get("Host"), origin, guard.token) is None

    def open(self, *args: str, **kwargs: str) -> None:
        self.settings["presence"].came(self)

    def on_message(self, message: str | bytes) -> None:
        """Pages send nothing; what comes is not answered."""

    def on_close(self) -> None:
        self.settings["presence"].went(self)


@cache
def asset(name: str) -> bytes:
    """A file of the page, or BokehJS."""
    if name != "bokeh.js":
        return Path(__file__).with_name("assets").joinpath(name).read_bytes()
    # Where it is can be told without importing bokeh, which takes longer than a browser to begin.
    found = find_spec("bokeh")
    guessed = Path(str(found.origin if found else "")).parent / "server/static/js/bokeh.min.js"
    return (guessed if guessed.is_file() else script_files()[0]).read_bytes()


def kindly(work: Work) -> dict[str, Any]:
    """What came of it, or why it was refused, without the name of an argument that nobody typed."""
    try:
        return work()
    except InvalidInputError as exc:
        return {"error": f"Got {exc.got}; wanted {exc.wanted}. {exc.remedy}", "taken": exc.path == (TAKEN,)}
    except AntiresError as exc:
        return {"error": str(exc), "taken": False}
