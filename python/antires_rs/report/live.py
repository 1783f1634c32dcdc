"""Figures to be explored inside a page: packed, unpacked by the browser when they come into sight.

Each is a block of base64 of gzip, and so is the library that draws them, so that a page of many figures
stays small, holds no address, and nothing in it can be taken for markup. Where the library is not
installed, scripts are switched off or the page is printed, the pictures stand there instead.
"""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from importlib.resources import files
from importlib.util import find_spec
from typing import Any

from ..explore.canvas import item, script_files

__all__ = ["library", "packed", "policy", "script", "there"]

#: Where the data of a figure name one of its parts.
_NAMES = ("id", "root_id")


def there() -> bool:
    """Whether figures can be made."""
    return find_spec("bokeh") is not None


def packed(figure: Callable[[], Any]) -> str:
    """A figure as it stands in a page; empty where there is none, or nothing that makes it."""
    made = figure() if there() else None
    return "" if made is None else _packed(_with_own_names(item(made)))


def _with_own_names(figure: dict[str, Any]) -> str:
    """A figure whose parts are named by their order and what it shows, not by how many were made before.

    So the same report is the same bytes, and no two figures of a page share a name.
    """
    names: dict[str, str] = {}
    counted = _renamed(figure, lambda name: names.setdefault(name, f"p{len(names)}"))
    mark = sha256(_text(counted).encode("utf-8")).hexdigest()[:8]
    return _text(_renamed(counted, lambda name: f"{mark}{name}"))


def _renamed(part: Any, name: Callable[[str], str]) -> Any:
    if isinstance(part, list | tuple):
        return [_renamed(each, name) for each in part]
    if not isinstance(part, dict):
        return part
    return {
        key: name(value) if key in _NAMES and isinstance(value, str) else _renamed(value, name)
        for key, value in part.items()
    }


def _text(figure: Any) -> str:
    return json.dumps(figure, separators=(",", ":"))


@cache
def library() -> str:
    """What draws the figures; empty where it is not installed."""
    return _packed(_drawer()) if there() else ""


def policy() -> str:
    """What a browser lets the page do: run these two scripts, and load nothing."""
    own = "'none'"
    if there():
        digests = [sha256(text.encode("utf-8")).digest() for text in (script(), _drawer())]
        own = " ".join(f"'sha256-{b64encode(each).decode('ascii')}'" for each in digests)
    return (
        f"default-src 'none'; script-src {own}; style-src 'unsafe-inline'; "
        "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'"
    )


def _drawer() -> str:
    return "\n".join(file.read_text(encoding="utf-8") for file in script_files())


@cache
def script() -> str:
    """What unpacks the figures."""
    return files(__package__).joinpath("live.js").read_text(encoding="utf-8")


def _packed(text: str) -> str:
    # Without a time the same figure is the same bytes.
    return b64encode(gzip.compress(text.encode("utf-8"), 9, mtime=0)).decode("ascii")
