"""The page while it is open: in this thread until it is closed, or in one of its own beside a notebook."""

from __future__ import annotations

import asyncio
import hmac
import json
import secrets
import sys
import threading
from collections.abc import Awaitable, Callable
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from threading import Lock, Thread
from typing import TYPE_CHECKING, Any

from ..exceptions import AntiresError, InvalidInputError
from .live_canvas import require_bokeh, script_files
from .page_session import TAKEN

if TYPE_CHECKING:
    from .page_session import View


# -- Who is answered: this computer's own browser, on the page that was opened for it


#: Where the page is served; no other computer reaches it.
ADDRESS = "127.0.0.1"
#: Of the token.
BYTES = 24
#: A page of this computer may frame ours: notebooks do.
FRAMED_BY = "http://127.0.0.1:* http://localhost:* vscode-webview:"


@dataclass(frozen=True)
class Guard:
    """The checks of every request.

    Attributes
    ----------
    port : int
        Of the server.
    token : str
        Known to who was given the address; other programs and pages of this computer do not know it.
    """

    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(BYTES), repr=False)

    @property
    def hosts(self) -> tuple[str, str]:
        """Names by which a browser may call this server; a name that was bent to 127.0.0.1 is none."""
        return f"{ADDRESS}:{self.port}", f"localhost:{self.port}"

    @property
    def address(self) -> str:
        """What is opened in the browser."""
        return f"http://{ADDRESS}:{self.port}/?token={self.token}"

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


# -- The server of the page: every request is checked, nothing is read from disk but the page's own files


ASSETS = Path(__file__).with_name("assets")
KINDS = {".js": "text/javascript", ".css": "text/css", ".html": "text/html"}
#: Of what a page may send.
MOST_BYTES = 100_000
Work = Callable[[], dict[str, Any]]
Viewed = Callable[[], Awaitable["View"]]


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
    if name != "bokeh.js":
        return (ASSETS / name).read_bytes()
    # Where it is can be told without importing bokeh, which takes longer than a browser to begin.
    found = find_spec("bokeh")
    guessed = Path(str(found.origin if found else "")).parent / "server/static/js/bokeh.min.js"
    return (guessed if guessed.is_file() else script_files()[0]).read_bytes()


def application(viewed: Viewed, guard: Guard, presence: Presence) -> Any:
    """The ``tornado.web.Application`` that shows a view, which may have to be waited for."""
    from tornado.web import Application

    base = _guarded(guard)
    page, asset_of, missing = _files(base, guard)
    state, figure, download = _views(base, viewed)
    return Application(
        [
            (r"/", page),
            (r"/(bokeh\.js|page\.js|tables\.js|page\.css)", asset_of),
            (r"/state", state),
            (r"/figure", figure),
            (r"/do/(\w+)", _commands(base, viewed)),
            (r"/download", download),
            (r"/alive", _alive(base, guard, presence)),
        ],
        default_handler_class=missing,
        log_function=lambda handler: None,
        websocket_ping_interval=5,
    )


def _guarded(guard: Guard) -> Any:
    """What all handlers begin with: who is asking?"""
    from tornado.web import HTTPError, RequestHandler

    class Guarded(RequestHandler):  # type: ignore[misc]
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
            text = self.get_query_argument("shown", "0")
            if not text.isascii() or not text.isdecimal() or len(text) > 9:
                raise HTTPError(400, log_message="shown is a number")
            return int(text)

    return Guarded


def _files(base: Any, guard: Guard) -> tuple[Any, Any, Any]:
    """The page, its files, and what is not there."""
    from tornado.web import HTTPError

    class Page(base):  # type: ignore[misc]
        def get(self) -> None:
            self.finish(asset("page.html").decode().replace("{{token}}", guard.token))

    class Asset(base):  # type: ignore[misc]
        def get(self, name: str) -> None:
            self.set_header("Content-Type", f"{KINDS[Path(name).suffix]}; charset=utf-8")
            self.finish(asset(name))

    class Missing(base):  # type: ignore[misc]
        """Guarded too: who has no token does not learn what there is."""

        def get(self) -> None:
            raise HTTPError(404)

    return Page, Asset, Missing


def _views(base: Any, viewed: Viewed) -> tuple[Any, Any, Any]:
    """What is shown: state, figures, and the file."""
    from tornado.web import HTTPError

    class State(base):  # type: ignore[misc]
        async def get(self) -> None:
            shown, view = self.shown(), await viewed()
            self.plain({"title": view.title, **_kindly(lambda: view.state(shown))})

    class Figure(base):  # type: ignore[misc]
        async def get(self) -> None:
            shown, view = self.shown(), await viewed()
            # In a thread: the first figure waits for imports, and the socket must go on being answered.
            self.plain(await _aside(lambda: view.figure(shown)))

    class Download(base):  # type: ignore[misc]
        async def get(self) -> None:
            found = (await viewed()).file()
            if found is None:
                raise HTTPError(404, log_message="nothing to download")
            name = "".join(c if c.isascii() and (c.isalnum() or c in "._- ") else "_" for c in found[0])
            self.set_header("Content-Type", "application/json; charset=utf-8")
            self.set_header("Content-Disposition", f'attachment; filename="{name}"')
            self.finish(found[1])

    return State, Figure, Download


def _commands(base: Any, viewed: Viewed) -> Any:
    """What is done."""
    from tornado.web import HTTPError

    turn = Lock()  # of what takes long

    class Do(base):  # type: ignore[misc]
        async def post(self, command: str) -> None:
            shown, view = self.shown(), await viewed()
            try:
                sent = json.loads(self.request.body or b"{}")
            except (ValueError, RecursionError):
                sent = None
            if not isinstance(sent, dict):
                raise HTTPError(400, log_message="that is no JSON object")

            def done() -> dict[str, Any]:
                return {"said": view.do(command, sent), **view.state(shown)}

            self.plain(await _aside(done, turn) if command in view.slow else _kindly(done))

    return Do


def _alive(base: Any, guard: Guard, presence: Presence) -> Any:
    """The socket of a page that is open."""
    from tornado.websocket import WebSocketHandler

    class Alive(base, WebSocketHandler):  # type: ignore[misc]
        def check_origin(self, origin: str) -> bool:
            return guard.refuses(self.request.headers.get("Host"), origin, guard.token) is None

        def open(self, *args: str, **kwargs: str) -> None:
            presence.came(self)

        def on_message(self, message: str | bytes) -> None:
            """Pages send nothing; what comes is not answered."""

        def on_close(self) -> None:
            presence.went(self)

    return Alive


async def _aside(work: Work, turn: Lock | None = None) -> dict[str, Any]:
    """Work in a thread that the end of the server does not wait for; one at a time if they share a turn."""
    loop = asyncio.get_running_loop()
    answer: asyncio.Future[dict[str, Any]] = loop.create_future()

    def run() -> None:
        try:
            with turn or nullcontext():
                tell, made = answer.set_result, _kindly(work)
        except BaseException as exc:  # told as an answer that failed
            tell, made = answer.set_exception, exc  # type: ignore[assignment]
        with suppress(RuntimeError):  # the server has ended meanwhile
            loop.call_soon_threadsafe(tell, made)

    Thread(target=run, daemon=True, name="antires-look").start()
    return await answer


def _kindly(work: Work) -> dict[str, Any]:
    """What came of it, or why it was refused."""
    try:
        return work()
    except AntiresError as exc:
        return {"error": refusal(exc), "taken": isinstance(exc, InvalidInputError) and exc.path == (TAKEN,)}


def refusal(exc: AntiresError) -> str:
    """An error for the page: the sentence, without the name of an argument that its user never typed."""
    if isinstance(exc, InvalidInputError):
        return f"Got {exc.got}; wanted {exc.wanted}. {exc.remedy}"
    return str(exc)
