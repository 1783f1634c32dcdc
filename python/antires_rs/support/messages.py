"""Warnings, each with the name under which `explain` says more; errors renamed; names that have moved."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from difflib import get_close_matches
from functools import cache, wraps
from importlib import import_module
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from ..exceptions import AntiresWarning, reject

Given = ParamSpec("Given")
Result = TypeVar("Result")
_UNHEARD: ContextVar[bool] = ContextVar("_UNHEARD", default=False)


def some(names: Iterable[Any], most: int = 4) -> str:
    """The first of some names, and how many more there are."""
    every = [str(name) for name in names]
    return ", ".join(every[:most]) + (f" and {len(every) - most} more" if len(every) > most else "")


def warn(about: str | tuple[str, ...], text: str) -> None:
    """Warn at the line of the user's call; ``about`` names entries of ``troubleshooting.md``."""
    if not _UNHEARD.get():
        _warn(AntiresWarning(text, (about,) if isinstance(about, str) else about))


@contextmanager
def unheard() -> Iterator[None]:
    """No warnings of this package in this thread, whatever others do."""
    before = _UNHEARD.set(True)
    try:
        yield
    finally:
        _UNHEARD.reset(before)


def warn_of_change(text: str) -> None:
    """Warn at the line of the user's call that a name or a way of calling leaves with the next release."""
    _warn(FutureWarning(text))


def _warn(warning: Warning) -> None:
    level, frame = 3, sys._getframe(2)
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).startswith("antires_rs."):
        level, frame = level + 1, frame.f_back
    warnings.warn(warning, stacklevel=level)


# -- What is said of a symptom: its cause and what to do, from ``troubleshooting.md`` beside this file

_FILE = Path(__file__).with_name("troubleshooting.md")


def explain(*names: str) -> str:
    """Tell what a warning, a finding or a doubt means: what is seen, why, and what to do.

    Parameters
    ----------
    *names : str
        As warnings end with, ``warning.about``; names of findings of a data check; doubts in a table of
        antiresonances, ``"few orders"``. Without a name: all names, each with what is seen. One that is not
        known is an ``InvalidInputError``.

    Returns
    -------
    str
        Plain text in Markdown.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.explain("dead_channel").splitlines()[0])
    ### dead_channel
    >>> "dead_channel" in ar.explain()
    True
    """
    known = entries()
    if not names:
        return "\n".join(f"{name}: {_seen(text)}" for name, text in known.items())
    texts = []
    for name in map(str, names):
        key = name.strip().lower().replace(" ", "_").replace("-", "_")
        if key not in known:
            near = " or ".join(get_close_matches(key, known, n=3, cutoff=0.6))
            wanted = f"one of the names that warnings end with{', perhaps ' + near if near else ''}"
            reject("names", repr(name), wanted, "Ask without a name for all of them.")
        texts.append(known[key])
    return "\n\n".join(texts)


@cache
def entries() -> dict[str, str]:
    """Every entry by its names, which stand in its heading, in the order of the page."""
    blocks = [b.split("\n## ")[0].strip() for b in _FILE.read_text(encoding="utf-8").split("\n### ")[1:]]
    return {name: f"### {b}" for b in blocks for name in b.partition("\n")[0].split(", ")}


def _seen(text: str) -> str:
    """What is seen, in a line."""
    return " ".join(text.split("**Seen:**", 1)[1].split("\n- **Why", 1)[0].split())


#: How an edit by hand is written in a job and on the command line.
EDIT_WANTED = 'DOF=HZ, such as "3=31.9" or "3=31.9 mains hum"'


def edit_named(text: str) -> tuple[str, float, str] | None:
    """Dof, frequency in Hz and reason of ``DOF=HZ reason``; None for another text."""
    name, _, rest = text.partition("=")
    value, _, reason = rest.strip().partition(" ")
    try:
        freq_hz = float(value)
    except ValueError:
        return None
    return (name.strip(), freq_hz, reason.strip()) if name.strip() and 0.0 < freq_hz < float("inf") else None


def moved(old: str, new: str) -> Callable[[str], Any]:
    """The ``__getattr__`` of a module whose contents are in another one now."""

    def look_up(name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        value = getattr(import_module(new), name)
        warn_of_change(f"{old} is now {new}")
        return value

    return look_up


def names_left(module: str, instead: Mapping[str, str]) -> Callable[[str], Any]:
    """The ``__getattr__`` of a module from which names have left: what to use instead."""

    def look_up(name: str) -> Any:
        left = name in instead
        told = f"{module}.{name} has left: {instead[name]}" if left else f"{module} has no {name!r}"
        raise AttributeError(told, name=name, obj=sys.modules[module])

    return look_up


def keywords_left(**why: str) -> Callable[[Callable[Given, Result]], Callable[Given, Result]]:
    """Keywords of a call that have left warn until the next release, and have no effect."""

    def decorate(call: Callable[Given, Result]) -> Callable[Given, Result]:
        @wraps(call)
        def taken(*args: Given.args, **keywords: Given.kwargs) -> Result:
            for name in why.keys() & keywords.keys():
                del keywords[name]
                warn_of_change(f"{call.__qualname__}: {name} has left and has no effect: {why[name]}")
            return call(*args, **keywords)

        return taken

    return decorate
