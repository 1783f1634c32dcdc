"""From the text of a job file to its tables; where it is no TOML, the line on which that begins."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from ..exceptions import InvalidInputError
from .keys import SECTIONS
from .places import Place

__all__ = ["parsed"]

#: Keys and lists of a job are three or four deep.
_DEEPEST = 40
_PART = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')"""
#: A key begins a line, or stands in braces: no bracket is where one may begin, which keeps the search linear.
_DOTTED = re.compile(rf"(?:^|[{{,])[ \t\[]*(?:{_PART}[ \t]*\.[ \t]*){{{_DEEPEST}}}", re.MULTILINE)
#: Where tomllib says what it came to; at the end of the document it says no line.
_AT_LINE = re.compile(r"at line (\d+)")
#: Brackets; and what may hold some that do not count: texts and comments.
_BRACKETS = re.compile(r"""[\[\]{}]|"[^"\n]*"|'[^'\n]*'|#[^\n]*""")


def parsed(name: str, text: str) -> dict[str, Any]:
    """The tables of a job file called ``name``.

    Raises
    ------
    InvalidInputError
        The text is no TOML.

    Examples
    --------
    >>> parsed("job.toml", "[search]\\nseed = 3")
    {'search': {'seed': 3}}
    """
    _plain(name, text)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as exc:  # of TOML, or of Python for numbers of thousands of digits
        lines = text.split("\n")
        at = _AT_LINE.search(str(exc))
        number = min(_sound(lines, int(at[1]) if at else len(lines)) + 1, len(lines))
        line = lines[number - 1].strip()
        remedy = (
            _again(lines[: number - 1], line) or "Text stands in quotes, lists in [ ], and each key once."
        )
        if "\\" in line:
            remedy += r" A path is written with / or in single quotes: 'C:\tests\a.uff'."
        raise InvalidInputError(
            Place(f"{name}, line {number}"),
            f"{line if len(line) <= 60 else line[:57] + '...'!r}, which is no TOML ({exc})",
            "lines such as key = value under a [section]",
            remedy,
        ) from exc


def _plain(name: str, text: str) -> None:
    """Refuse nesting that no job has, before it is parsed: time and depth grow with it without bound."""
    for found, what in ((_DOTTED.search(text), "a key of many parts"), (_deep(text), "brackets in brackets")):
        if found is not None:
            at = found if isinstance(found, int) else found.start()
            raise InvalidInputError(
                Place(f"{name}, line {1 + text.count(chr(10), 0, at + 1)}"),
                f"{what}, more than {_DEEPEST} deep",
                "lines such as key = value under a [section]",
                "Correct that line.",
            )


def _deep(text: str) -> int | None:
    """Where brackets outside of texts are deeper than allowed; None if nowhere."""
    depth = 0
    for found in _BRACKETS.finditer(text):
        sign = found[0]
        depth = depth + 1 if sign in ("[", "{") else max(depth - 1, 0) if sign in ("]", "}") else depth
        if depth > _DEEPEST:
            return found.start()
    return None


def _sound(lines: list[str], last: int) -> int:
    """Number of lines before the statement that is no TOML.

    An error stays where it is when lines behind it are cut off, so that the longest beginning without one
    ends just before it. What is on the line ``last`` is part of it: a file that is no job at all may have
    thousands of lines behind. (tomllib gives the line as a number only from Python 3.14 on.)
    """
    for n in range(min(last, len(lines)) - 1, 0, -1):
        try:
            tomllib.loads("\n".join(lines[:n]))
        except (ValueError, RecursionError):
            continue
        return n
    return 0


def _again(before: list[str], line: str) -> str:
    """What to do about a heading that was there before, where there may be several."""
    name = line.strip("[] ")
    if line != f"[{name}]" or name not in SECTIONS or SECTIONS[name].several == "no":
        return ""
    return f"Where there are several, each is headed [[{name}]]." if line in map(str.strip, before) else ""
