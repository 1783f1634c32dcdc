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
#: Lines that a statement may take.
_LONGEST = 200
_BRACKET = re.compile(r"[\[\]{}]")
#: What may hold dots and brackets that do not count: texts of several lines, texts, comments. One without its
#: end goes to that of the line, or of the file, which keeps the search linear.
_SAID = re.compile(
    r""""{3}(?:\\.|[^\\])*?(?:"{3}|\Z)|'{3}.*?(?:'{3}|\Z)|"(?:\\[^\n]|[^"\\\n])*"?|'[^'\n]*'?|\#[^\n]*""",
    re.DOTALL,
)


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
        number = min(_sound(lines) + 1, len(lines))
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
    bare = _SAID.sub(_blank, text)
    for found, what in ((_DOTTED.search(bare), "a key of many parts"), (_deep(bare), "brackets in brackets")):
        if found is not None:
            at = found if isinstance(found, int) else found.start()
            raise InvalidInputError(
                Place(f"{name}, line {1 + text.count(chr(10), 0, at + 1)}"),
                f"{what}, more than {_DEEPEST} deep",
                "lines such as key = value under a [section]",
                "Correct that line.",
            )


def _blank(said: re.Match[str]) -> str:
    """As many letters on as many lines, so that places stay; quotes too: a text may be a part of a key."""
    text = said[0]
    if text[0] == "#" or "\n" in text:
        return "".join(c if c == "\n" else " " for c in text)
    return f"{text[0]}{'x' * (len(text) - 2)}{text[-1]}"


def _deep(text: str) -> int | None:
    """Where brackets are deeper than allowed; None if nowhere."""
    depth = 0
    for found in _BRACKET.finditer(text):
        sign = found[0]
        depth = depth + 1 if sign in ("[", "{") else max(depth - 1, 0) if sign in ("]", "}") else depth
        if depth > _DEEPEST:
            return found.start()
    return None


def _sound(lines: list[str]) -> int:
    """Number of lines before the statement that is no TOML.

    Beginnings without an error end before it, or within no statement of several lines. They are sought in
    steps that grow and, past the error, shrink, so that a file that is no job at all costs little however
    long it is. (tomllib gives the line as a number only from Python 3.14 on.)
    """
    sound, step = 0, 1
    while True:
        found = _next_sound(lines, sound + step)
        if found is not None:
            sound, step = found, 2 * step
        elif step == 1:
            return sound
        else:
            step //= 2


def _next_sound(lines: list[str], start: int) -> int | None:
    """The first beginning without an error of ``start`` lines or up to a statement more."""
    for n in range(start, min(start + _LONGEST, len(lines))):
        try:
            tomllib.loads("\n".join(lines[:n]))
        except (ValueError, RecursionError):
            continue
        return n
    return None


def _again(before: list[str], line: str) -> str:
    """What to do about a heading that was there before, where there may be several."""
    name = line.strip("[] ")
    if line != f"[{name}]" or name not in SECTIONS or SECTIONS[name].several == "no":
        return ""
    return f"Where there are several, each is headed [[{name}]]." if line in map(str.strip, before) else ""
