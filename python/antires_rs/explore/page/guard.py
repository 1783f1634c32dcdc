"""Who is answered: this computer's own browser, on the page that was opened for it."""

from __future__ import annotations

import hmac
import secrets
from dataclasses import dataclass, field

__all__ = ["ADDRESS", "Guard"]

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
        """Why a request is refused; None if it is answered.

        Parameters
        ----------
        host, origin : str or None
            Headers of the request. Browsers send an origin with what a page asks for, unless it is its own.
        token : str or None

        Examples
        --------
        >>> from antires_rs.explore.page.guard import Guard
        >>> guard = Guard(8000, "secret")
        >>> guard.refuses("127.0.0.1:8000", None, "secret")
        >>> guard.refuses("127.0.0.1:8000", "http://elsewhere.example", "secret")
        'a page of another origin asked'
        """
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
