"""Where the keys of a TOML text stand, which tomllib does not tell.

A reader of positions, not of values: it walks over a text that tomllib has already found valid.
"""

from __future__ import annotations

import re
from typing import NoReturn

__all__ = ["Path", "lines_of"]

#: Names of tables and keys, and indices into arrays, from the top.
Path = tuple[str | int, ...]

_BARE = re.compile(r"[A-Za-z0-9_-]+")
#: The longest delimiters first; literal strings know no escapes.
_STRINGS = tuple(
    (quotes, re.compile(pattern, re.DOTALL))
    for quotes, pattern in (
        ('"""', r'"""(?:\\.|(?!""").)*"{3,5}'),
        ("'''", r"'''(?:(?!''').)*'{3,5}"),
        ('"', r'"(?:\\.|[^"\\])*"'),
        ("'", r"'[^']*'"),
    )
)
_SCALAR = re.compile(r"[^,\]}#\n]+")
_ESCAPES = {"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r", '"': '"', "\\": "\\"}


def lines_of(text: str) -> dict[Path, int]:
    """Line, from 1, of every table, key and array element.

    Parameters
    ----------
    text : str
        Valid TOML.

    Returns
    -------
    dict of tuple to int
        By names and indices: ``("search", "seed")``, ``("parameters", 1, "bounds", 0)``.

    Examples
    --------
    >>> lines = lines_of("[search]\\nseed = 3\\n[[data]]\\nband_hz = [\\n 1,\\n 2]")
    >>> lines["search", "seed"], lines["data", 0, "band_hz", 1]
    (2, 6)
    """
    return _Scanner(text.replace("\r\n", "\n")).scan()


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text, self.at, self.line = text, 0, 1
        self.lines: dict[Path, int] = {}
        #: Number of tables in each array of tables so far.
        self.counts: dict[Path, int] = {}

    def scan(self) -> dict[Path, int]:
        table: Path = ()
        while self._blank():
            if self.text.startswith("[[", self.at):
                table = self._header(2)
            elif self._peek() == "[":
                table = self._header(1)
            else:
                self._pair(table)
        return self.lines

    def _header(self, brackets: int) -> Path:
        line = self.line
        self._forward(brackets)
        path: Path = ()
        names = self._key()
        for i, name in enumerate(names):
            path += (name,)
            self.lines.setdefault(path, line)
            if brackets == 2 and i == len(names) - 1:
                self.counts[path] = self.counts.get(path, 0) + 1
            if path in self.counts:
                path += (self.counts[path] - 1,)
                self.lines.setdefault(path, line)
        self._forward(brackets)
        return path

    def _pair(self, table: Path) -> None:
        line, path = self.line, table
        for name in self._key():
            path += (name,)
            self.lines.setdefault(path, line)
        self._forward(1)  # the equals sign
        self._value(path)

    def _value(self, path: Path) -> None:
        self._blank()
        self.lines.setdefault(path, self.line)
        first = self._peek()
        if first == "[":
            self._array(path)
        elif first == "{":
            self._inline_table(path)
        elif first in "\"'":
            self._string()
        else:
            self._take(_SCALAR)

    def _array(self, path: Path) -> None:
        self._forward(1)
        index = 0
        while self._blank() and self._peek() != "]":
            self._value((*path, index))
            index += 1
            self._blank()
            if self._peek() == ",":
                self._forward(1)
        self._forward(1)

    def _inline_table(self, path: Path) -> None:
        self._forward(1)
        while self._blank() and self._peek() != "}":
            self._pair(path)
            self._blank()
            if self._peek() == ",":
                self._forward(1)
        self._forward(1)

    def _key(self) -> list[str]:
        """Parts of a dotted key; stands on what follows it."""
        parts = []
        while True:
            self._blank()
            if self._peek() in "\"'":
                literal = self._peek() == "'"
                body = self._string()[1:-1]
                parts.append(body if literal else _unescaped(body))
            else:
                parts.append(self._take(_BARE))
            self._blank()
            if self._peek() != ".":
                return parts
            self._forward(1)

    def _string(self) -> str:
        for quotes, pattern in _STRINGS:
            if self.text.startswith(quotes, self.at):
                # An empty string is two quotes, not the beginning of three.
                return self._take(pattern)
        self._lost()

    def _take(self, pattern: re.Pattern[str]) -> str:
        found = pattern.match(self.text, self.at)
        if found is None:
            self._lost()
        self._forward(len(found[0]))
        return found[0]

    def _blank(self) -> bool:
        """Skip space, line ends and comments; whether anything is left."""
        while self.at < len(self.text):
            if self.text[self.at] == "#":
                end = self.text.find("\n", self.at)
                self._forward((end if end >= 0 else len(self.text)) - self.at)
            elif self.text[self.at].isspace():
                self._forward(1)
            else:
                return True
        return False

    def _peek(self) -> str:
        return self.text[self.at : self.at + 1] or self._lost()

    def _forward(self, count: int) -> None:
        self.line += self.text.count("\n", self.at, self.at + count)
        self.at += count

    def _lost(self) -> NoReturn:
        raise ValueError(f"line {self.line} is no TOML")


def _unescaped(body: str) -> str:
    def character(match: re.Match[str]) -> str:
        code = match[1]
        return chr(int(code[1:], 16)) if code[0] in "uU" else _ESCAPES[code]

    return re.sub(r"\\(u[0-9a-fA-F]{4}|U[0-9a-fA-F]{8}|.)", character, body)
