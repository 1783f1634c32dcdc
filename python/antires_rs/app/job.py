"""A job file, read and checked; every message names file, line and key."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn

from ..exceptions import Argument, InvalidInputError
from .keys import KINDS, SECTIONS, Key, Section, shown, unset_in

# -- Where the keys of a TOML text stand, which tomllib does not tell
#
# A reader of positions, not of values: it walks over a text that tomllib has already found valid.


#: Names of tables and keys, and indices into arrays, from the top.
Path_lines = tuple[str | int, ...]

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


def lines_of(text: str) -> dict[Path_lines, int]:
    """Line, from 1, of every table, key and array element."""
    return _Scanner(text.replace("\r\n", "\n")).scan()


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text, self.at, self.line = text, 0, 1
        self.lines: dict[Path_lines, int] = {}
        #: Number of tables in each array of tables so far.
        self.counts: dict[Path_lines, int] = {}

    def scan(self) -> dict[Path_lines, int]:
        table: Path_lines = ()
        while self._blank():
            if self.text.startswith("[[", self.at):
                table = self._header(2)
            elif self._peek() == "[":
                table = self._header(1)
            else:
                self._pair(table)
        return self.lines

    def _header(self, brackets: int) -> Path_lines:
        line = self.line
        self._forward(brackets)
        path: Path_lines = ()
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

    def _pair(self, table: Path_lines) -> None:
        line, path = self.line, table
        for name in self._key():
            path += (name,)
            self.lines.setdefault(path, line)
        self._forward(1)  # the equals sign
        self._value(path)

    def _value(self, path: Path_lines) -> None:
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

    def _array(self, path: Path_lines) -> None:
        self._forward(1)
        index = 0
        while self._blank() and self._peek() != "]":
            self._value((*path, index))
            index += 1
            self._blank()
            if self._peek() == ",":
                self._forward(1)
        self._forward(1)

    def _inline_table(self, path: Path_lines) -> None:
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


# -- Places in a job file: how errors name them, and the key that explains them


class Place(Argument):
    """What is wrong, by file, line, section and key: an argument of who writes jobs."""


class Places:
    """The places of a job file.

    Parameters
    ----------
    name : str
        Of the file.
    lines : mapping of tuple to int
        As :func:`~antires_rs.app.job.lines_of` has them.

    Examples
    --------
    >>> places = Places("job.toml", {("search",): 4, ("search", "seed"): 5})
    >>> print(places.of(("search", "seed")), places.of(("search", "rng")), sep="; ")
    job.toml, line 5, [search] seed; job.toml, line 4, [search] rng
    """

    def __init__(self, name: str, lines: Mapping[Path_lines, int]) -> None:
        self._name, self._lines = name, lines

    def of(self, place: Path_lines) -> Place:
        """A place; what is not in the file has the line of its nearest neighbour above."""
        there = place
        while there and there not in self._lines:
            there = there[:-1]
        line = f", line {self._lines[there]}" if there else ""
        return Place(f"{self._name}{line}{',' if place else ''}{_label(place)}", place)


def key_at(place: Path_lines) -> Key | None:
    """The key at a place, or above it."""
    section = SECTIONS.get(str(place[0])) if place else None
    names = [part for part in place[1:] if isinstance(part, str)]
    return section.key(names[0]) if section and names else None


def _label(place: Path_lines) -> str:
    """``[search] seed`` of ("search", "seed"); arrays of tables by their number."""
    if not place:
        return ""
    name, rest = str(place[0]), list(place[1:])
    label = f" [{name}]"
    if rest and isinstance(rest[0], int) and name in SECTIONS and SECTIONS[name].several != "no":
        label = f" [[{name}]] {rest[0]}"
        rest = rest[1:]
    for i, part in enumerate(rest):
        label += f"[{part}]" if isinstance(part, int) else f"{'.' if i else ' '}{part}"
    return label


# -- From the text of a job file to its tables; where it is no TOML, the line on which that begins


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
    """The tables of a job file called ``name``."""
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


class Job:
    """A valid job: its sections, and where everything stands.

    Attributes
    ----------
    path : pathlib.Path
    data : list of dict
        The sections [data] or [[data]].
    parameters : list of dict
    sections : dict of str to dict
        The others; empty where the job is silent.
    task : {"update", "damage", "series"}
    """

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        raw = parsed(path.name, text)
        self._where = Places(path.name, lines_of(text))
        self._unknown_sections(raw)
        tables = {name: self._tables(SECTIONS[name], value) for name, value in raw.items()}
        for name, rows in tables.items():
            for place, row in rows:
                self._check(SECTIONS[name], place, row)
        for name in ("data",) if "series" in raw else ("data", "model"):
            if name not in tables:
                self.reject((), f"no section [{name}]", f"one [{name}]", SECTIONS[name].help)
        self.data = [row for _, row in tables["data"]]
        self.parameters = [row for _, row in tables.get("parameters", [])]
        self.sections = {
            name: tables[name][0][1] if name in tables else {}
            for name in SECTIONS
            if name not in ("data", "parameters")
        }
        self.task = self._task(raw)
        #: Place of each [data]: with one table ("data",), else ("data", i).
        self.data_places = [place for place, _ in tables["data"]]

    def _unknown_sections(self, raw: Mapping[str, Any]) -> None:
        for name in raw:
            if name not in SECTIONS:
                owner = next((s.name for s in SECTIONS.values() if s.key(name)), None)
                known = ", ".join(f"[{n}]" for n in SECTIONS)
                self.reject(
                    (name,),
                    f"the unknown name {name!r}",
                    f"one of the sections {known}",
                    f"It belongs under [{owner}]."
                    if owner
                    else nearest(name, SECTIONS) or "'antires init' writes a job with all of them.",
                )

    def _tables(self, section: Section, value: Any) -> list[tuple[Path_lines, dict[str, Any]]]:
        name = section.name
        if isinstance(value, dict) and section.several != "must":
            return [((name,), value)]
        several = isinstance(value, list) and bool(value) and all(isinstance(v, dict) for v in value)
        if several and section.several != "no":
            return [((name, i), row) for i, row in enumerate(value)]
        heading = f"[[{name}]]" if section.several == "must" else f"[{name}]"
        got = "several tables" if several else "a single table" if isinstance(value, dict) else shown(value)
        self.reject(
            (name,), got, f"a heading {heading} on a line of its own, and keys below it", section.help
        )

    def _check(self, section: Section, place: Path_lines, table: Mapping[str, Any]) -> None:
        for name, value in table.items():
            key = section.key(name)
            if key is None:
                owner = next((s.name for s in SECTIONS.values() if s.key(name)), None)
                remedy = nearest(name, [k.name for k in section.keys]) or (
                    f"It belongs under [{owner}]." if owner else "Remove it."
                )
                self.reject(
                    (*place, name),
                    f"the unknown key {name!r}",
                    "one of " + ", ".join(k.name for k in section.keys),
                    remedy,
                )
            kind = KINDS[key.kind]
            unset = unset_in(value) if key.kind in ("dof", "dofs") else []
            if unset:
                of = f" for {', '.join(map(repr, unset[:5]))}" if any(unset) else ""
                more = f" and {len(unset) - 5} more" if len(unset) > 5 else ""
                self.reject(
                    (*place, name),
                    f"'?'{of}{more}, where the dof is not given yet",
                    'the dof of the model, as in 4, or "2 u" of a frame',
                    f"Put it in place of the '?'. {key.explanation}",
                )
            if not kind.fits(value):
                self.reject((*place, name), shown(value), kind.wanted, f"{kind.remedy} {key.explanation}")
        for key in section.keys:
            if key.required and key.name not in table:
                self.missing(place, key.name)

    def _task(self, raw: Mapping[str, Any]) -> str:
        if "series" in raw:
            return self._series(raw)
        if ("damage" in raw) == ("parameters" in raw):
            both = "damage" in raw
            self.reject(
                ("damage",) if both else (),
                f"{'both' if both else 'neither'} [damage] {'and' if both else 'nor'} [[parameters]]",
                "one of them",
                "A job updates a model or looks for damage; the second can start from "
                'the result of the first, kind = "result" under [model].',
            )
        if "damage" in raw and "updating" in raw:
            self.reject(
                ("updating",),
                "[updating] beside [damage]",
                "[damage] alone",
                "Its keys belong to a job with [[parameters]].",
            )
        return "damage" if "damage" in raw else "update"

    def _series(self, raw: Mapping[str, Any]) -> str:
        known = ("data", "series", "identification", "output")
        for name in raw:
            if name not in known:
                self.reject(
                    (name,),
                    f"[{name}] beside [series]",
                    "one of " + ", ".join(f"[{one}]" for one in known),
                    "A series has no model: remove it, or write another job for one of its tests.",
                )
        if len(self.data) > 1:
            wanted = "one [data], whose file is a folder or a pattern"
            self.reject(("data",), "several [[data]]", wanted, "Write a job for each force.")
        return "series"

    def only(self, place: Path_lines, table: Mapping[str, Any], kind: str) -> None:
        """Refuse keys that belong to another kind of model or parameter, or to another format."""
        section = SECTIONS[str(place[0])]
        for name in table:
            key = section.key(name)
            if key and key.of and kind not in key.of:
                own = ", ".join(k.name for k in section.keys if not k.of or kind in k.of)
                self.reject(
                    (*place, name),
                    f"{name!r}, which belongs to {' or '.join(key.of)}",
                    f"a key of {kind!r}: {own}",
                    "Remove it, or change the kind.",
                )

    def section(self, name: str) -> dict[str, Any]:
        """A section that there is once; empty where the job is silent."""
        return self.sections[name]

    def given(self, name: str, keys: Sequence[str]) -> dict[str, Any]:
        """Those of the keys that the section has."""
        return {key: self.sections[name][key] for key in keys if key in self.sections[name]}

    def file(self, name: str) -> Path:
        """A path of the job: relative to the folder of the job file."""
        return self.path.parent / os.path.expanduser(name)

    def existing(self, place: Path_lines, name: str, wanted: str = "a file that exists") -> Path:
        """A file of the job that is there."""
        file = self.file(name)
        if not file.is_file():
            got = f"{name!r}, which is a folder" if file.is_dir() else f"{name!r}, which does not exist"
            self.reject(place, got, wanted, "Paths are relative to the folder of the job file.")
        return file

    def reject(self, place: Path_lines, got: str, wanted: str, remedy: str) -> NoReturn:
        """Refuse what stands at a place."""
        raise InvalidInputError(self.where(place), got, wanted, remedy)

    def missing(self, place: Path_lines, key: str) -> NoReturn:
        """Refuse a section for a key that is not there."""
        known = key_at((*place, key))
        wanted = f"{key} = {KINDS[known.kind].wanted}" if known else key
        self.reject(place, f"no {key!r}", wanted, f"Add it. {known.explanation}" if known else "Add it.")

    def where(self, place: Path_lines) -> Place:
        """The place as errors name it."""
        return self._where.of(place)

    @contextmanager
    def blame(
        self, place: Path_lines, elsewhere: Mapping[str, Path_lines | list[Path_lines]] | None = None
    ) -> Iterator[None]:
        """Errors about an argument become errors about its key, at ``place`` or ``elsewhere``.

        A list has the places of an argument's items.
        """
        try:
            yield
        except InvalidInputError as exc:
            if isinstance(exc.argument, Place):  # blamed already
                raise
            name, *steps = exc.path
            at = (elsewhere or {}).get(name, (*place, name))
            if isinstance(at, list):
                at, steps = (at[steps[0]], steps[1:]) if steps else (place, steps)
            remedy, key = exc.remedy, key_at(at)
            if key is not None and key.help not in remedy:
                remedy += f" What belongs here: {key.help}"
            raise type(exc)(self.where((*at, *steps)), exc.got, exc.wanted, remedy) from exc


def read_job(path: str | os.PathLike[str]) -> Job:
    """Read and check a job file."""
    file = Path(path)
    if not file.is_file():
        what = "is a folder" if file.is_dir() else "does not exist"
        raise InvalidInputError(
            "JOB",
            f"{str(path)!r}, which {what}",
            "a job file",
            "'antires init job.toml' writes one to be filled in.",
        )
    try:
        text = file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as exc:
        line = file.read_bytes()[: exc.start].count(b"\n") + 1
        raise InvalidInputError(
            Place(f"{file.name}, line {line}"),
            "bytes that are no UTF-8 text",
            "a job file in TOML",
            "Save it as UTF-8.",
        ) from exc
    return Job(file, text)


def nearest(name: str, known: Any) -> str:
    """A hint at the known name nearest to an unknown one; '' where none is near."""
    near = get_close_matches(name, list(known), 1, 0.7)
    return f"Did you mean {near[0]!r}?" if near else ""
