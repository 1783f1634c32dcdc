"""Figures and scenes inside a page: packed, unpacked by the browser when they come into sight.

Each is a block of base64 of gzip, and so is the library that draws the figures, so that a page of many stays
small, holds no address, and nothing in it can be taken for markup. Where the library is not installed,
scripts are switched off or the page is printed, the pictures stand there instead.
"""

from __future__ import annotations

import gzip
import json
import re
from base64 import b64encode
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from importlib.resources import files
from importlib.util import find_spec
from typing import Any

from .live_canvas import item, script_files

_NAMED = re.compile(r'("(?:root_)?id":")([^"]*)')  # where the data of a figure name one of its parts


def packed(figure: Callable[[], Any]) -> str:
    """A figure as it stands in a page; empty where there is none, or nothing that makes it."""
    made = figure() if find_spec("bokeh") else None
    if made is None:
        return ""
    names: dict[str, str] = {}  # Its parts are named by what it shows: the same report is the same bytes.
    text = json.dumps(item(made), separators=(",", ":"))
    counted = _NAMED.sub(lambda m: m[1] + names.setdefault(m[2], f"p{len(names)}"), text)
    mark = sha256(counted.encode("utf-8")).hexdigest()[:8]
    return packed_text(_NAMED.sub(rf"\g<1>{mark}\2", counted))


def packed_text(text: str, level: int = 9) -> str:
    """A text as base64 of gzip; without a time the same text is the same bytes."""
    return b64encode(gzip.compress(text.encode("utf-8"), level, mtime=0)).decode("ascii")


def _drawer() -> str:
    return "\n".join(file.read_text(encoding="utf-8") for file in script_files())


@cache
def library() -> str:
    """What draws the figures; empty where it is not installed."""
    return packed_text(_drawer()) if find_spec("bokeh") else ""


def asset(name: str) -> str:
    """A file beside this module, a text."""
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")


@cache
def script() -> str:
    """What draws scenes, and what unpacks them and the figures."""
    return "".join(map(asset, ("scene.js", "live.js")))


def policy() -> str:
    """What a browser lets the page do: run these two scripts, and load nothing."""
    texts = (script(), _drawer()) if find_spec("bokeh") else (script(),)
    digests = [b64encode(sha256(text.encode("utf-8")).digest()).decode("ascii") for text in texts]
    own = " ".join(f"'sha256-{digest}'" for digest in digests)
    return (
        f"default-src 'none'; script-src {own}; style-src 'unsafe-inline'; "
        "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'"
    )
