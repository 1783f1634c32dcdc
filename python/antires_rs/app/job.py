"""A job file, read and checked; every message names file, line and key."""

from __future__ import annotations

import os
import re
import tomllib
from ast import literal_eval
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any, NoReturn

from ..exceptions import Argument, InvalidInputError
from ..identification.options import FitOptions
from ..io.registry import CONVERT
from .command import existing
from .keys import FORMATS, HEADINGS, KINDS, SECTIONS, TASKS, UNSET, Key, Section, shown
from .parser import nearest

# -- From a TOML text to its tables, and where their keys stand, which tomllib does not tell

KeyPath = tuple[str | int, ...]  # names of tables and keys, and indices into arrays, from the top


#: A text without its end goes to that of the line, or of the file, which keeps the search linear.
_TOKEN = re.compile(
    r"""
    (?P<between> \s+ | \#[^\n]* )
    | "{3} (?: \\. | [^\\] )*? (?: "{3,5} | \Z )  |  '{3} .*? (?: '{3,5} | \Z )
    | " (?: \\[^\n] | [^"\\\n] )* "?  |  ' [^'\n]* '?
    | [][{},.=]
    | [^][{},.=\s"'#]+
    """,
    re.DOTALL | re.VERBOSE,
)
_DEEPEST = 40  # keys and lists of a job are three or four deep


def _statements(name: str, text: str) -> list[int]:
    """The lines on which statements begin; nesting that no job has is refused."""
    starts: list[int] = []
    line, at, depth, dots, before = 1, 0, 0, 0, ("", 0)
    for found in _TOKEN.finditer(text):
        line, at = line + text.count("\n", at, found.start()), found.start()
        if found["between"] is not None:
            continue
        token = found[0]
        if depth == 0 and line > before[1]:
            starts.append(line)
        depth = max(depth + {"[": 1, "{": 1, "]": -1, "}": -1}.get(token, 0), 0)
        dots = dots + 1 if token == "." else dots if before[0] == "." else 0
        if dots >= _DEEPEST or depth > _DEEPEST:
            what = "a key of many parts" if dots >= _DEEPEST else "brackets in brackets"
            raise _no_job(name, line, f"{what}, more than {_DEEPEST} deep", "Correct that line.")
        before = token, line
    return starts


def _no_job(name: str, line: int, got: str, remedy: str) -> InvalidInputError:
    wanted = "lines such as key = value under a [section]"
    return InvalidInputError(Place(f"{name}, line {line}"), got, wanted, remedy)


def parsed(name: str, text: str) -> tuple[dict[str, Any], dict[KeyPath, int]]:
    """The tables of a job file called ``name``, and the line, from 1, of every table and key."""
    starts, rows = _statements(name, text), text.split("\n")
    try:
        tables = tomllib.loads(text)
    except ValueError as exc:  # of TOML, or of Python for numbers of thousands of digits
        known = re.search(r"at line (\d+)", str(exc))
        number = max((line for line in starts if not known or line <= int(known[1])), default=1)
        line = rows[number - 1].strip()
        got = f"{line if len(line) <= 60 else line[:57] + '...'!r}, which is no TOML ({exc})"
        remedy = "Text stands in quotes, lists in [ ], and each key once; of several tables each is headed "
        remedy += "[[name]]. A path is written with / or in single quotes."
        raise _no_job(name, number, got, remedy) from exc
    lines: dict[KeyPath, int] = {}
    counts: dict[KeyPath, int] = {}  # of tables in each array of tables so far
    table: KeyPath = ()
    for first, after in pairwise([*starts, len(rows) + 1]):
        one = tomllib.loads("\n".join(rows[first - 1 : after - 1]))  # the names in it, without quotes
        if not rows[first - 1].lstrip().startswith("["):
            for path in _keys(one, table):
                lines.setdefault(path, first)
            continue
        table = ()
        while one:
            ((key, inner),) = one.items()
            table = (*table, key)
            lines.setdefault(table, first)
            if isinstance(inner, list):
                counts[table] = counts.get(table, -1) + 1
            if table in counts:
                table = (*table, counts[table])
                lines.setdefault(table, first)
            one = inner[0] if isinstance(inner, list) else inner
    return tables, lines


def _keys(value: Any, path: KeyPath) -> Iterator[KeyPath]:
    """Every key of tables in tables."""
    for name, inner in value.items() if isinstance(value, dict) else ():
        yield (*path, name)
        yield from _keys(inner, (*path, name))


# -- Places in a job file: how errors name them, and the key that explains them


class Place(Argument):
    """What is wrong, by file, line, section and key: an argument of who writes jobs."""


def key_at(place: KeyPath) -> Key | None:
    """The key at a place, or above it."""
    section = SECTIONS.get(str(place[0])) if place else None
    names = [part for part in place[1:] if isinstance(part, str)]
    return section.key(names[0]) if section and names else None


def _label(place: KeyPath) -> str:
    """``[search] seed`` of ("search", "seed"); arrays of tables by their number."""
    name, rest = str(place[0]), list(place[1:])
    label = f"[{name}]"
    if rest and isinstance(rest[0], int) and name in SECTIONS and SECTIONS[name].several:
        label = f"[[{name}]] {rest.pop(0)}"
    for i, part in enumerate(rest):
        label += f"[{part}]" if isinstance(part, int) else f"{'.' if i else ' '}{part}"
    return label


#: How a channel is left out in a job and on the command line.
_OWN_SECTION: Any = {"model": ("model",), "measured": ("data",)}  # arguments that are a section of a job
LEAVE_OUT = "Give it a dof, or leave it out: false in a job, CHANNEL= on the command line"
#: How an argument is written, alone or with the value to be passed.
Spell = Callable[[str, Any], str]
#: As texts have it for who calls from Python: ``fs_hz=``, ``first='time'``; a channel left out; an attribute.
_PASSED = re.compile(r"""\b(\w+)=(?:('[^']*'|"[^"]*"|\d+|True|\[\d+(?:, \d+)*\])|(?![\w{([]))""")
_LEFT_OUT = re.compile(r"Map a \w+ to None to leave it out")
_ATTRIBUTE = re.compile(r",? (?:or )?see \.\w+")
_KEYS = {key.name for section in SECTIONS.values() for key in section.keys}


def spelled(text: str, spell: Spell) -> str:
    """A text for who calls from Python, as the user of a job or of a command would write it."""

    def respelled(found: re.Match[str]) -> str:
        name, value = found.groups()
        return spell(name, value and literal_eval(value)) if name in _KEYS else found[0]

    return _LEFT_OUT.sub(LEAVE_OUT, _PASSED.sub(respelled, _ATTRIBUTE.sub("", text)))


class Job:
    """A valid job: the tables [data] and [[parameters]], its other sections, and where everything stands."""

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        raw, self._lines = parsed(path.name, text)
        known = ", ".join(f"[{one}]" for one in SECTIONS)
        for name in raw:
            remedy = self._owner(name) or "'antires init' writes a job with all of them."
            wanted = f"one of the sections {known}"
            self.one_of((name,), name, SECTIONS, remedy, f"the unknown name {name!r}", wanted)
        tables = {name: self._tables(SECTIONS[name], value) for name, value in raw.items()}
        for name, rows in tables.items():
            for place, row in rows.items():
                self._check(SECTIONS[name], place, row)
        for name in ("data",) if "series" in raw else ("data", "model"):
            modal = name == "data" and "modes" in raw.get("measured", ())
            if name not in tables and not modal:
                self.reject((), f"no section [{name}]", f"one [{name}]", SECTIONS[name].help)
        self.data = list(tables.get("data", {}).values())
        self.parameters = list(tables.get("parameters", {}).values())
        self.sections = {name: next(iter(tables.get(name, {}).values()), {}) for name in SECTIONS}
        self.task = self._task(raw)
        #: Place of each [data]: with one table ("data",), else ("data", i).
        self.data_places = list(tables.get("data", {}))

    def _owner(self, name: str) -> str:
        """Where a key belongs, if there is one of that name."""
        return next((f"It belongs under [{one.name}]." for one in SECTIONS.values() if one.key(name)), "")

    def _tables(self, section: Section, value: Any) -> dict[KeyPath, dict[str, Any]]:
        """The tables of a section by their places."""
        name = section.name
        if isinstance(value, dict) and section.several != "must":
            return {(name,): value}
        several = isinstance(value, list) and bool(value) and all(isinstance(v, dict) for v in value)
        if several and section.several:
            return {(name, i): row for i, row in enumerate(value)}
        heading = f"[[{name}]]" if section.several == "must" else f"[{name}]"
        got = "several tables" if several else "a single table" if isinstance(value, dict) else shown(value)
        wanted = f"a heading {heading} on a line of its own, and keys below it"
        self.reject((name,), got, wanted, section.help)

    def _check(self, section: Section, place: KeyPath, table: Mapping[str, Any]) -> None:
        keys = {key.name: key for key in section.keys}
        for name, value in list(table.items()):
            if section.name == "identification" and name in FitOptions.left:  # the call warns
                continue
            remedy = self._owner(name) or "Remove it."
            self.one_of((*place, name), name, keys, remedy, f"the unknown key {name!r}")
            key = keys[name]
            items = value.values() if isinstance(value, dict) else value
            given = list(items) if isinstance(value, dict | list) else [value]
            if key.kind in ("dof", "dofs", "places") and UNSET in given:  # as ``antires init`` left it
                wanted = 'a dof of the model in place of each "?", as in 4, "node 2 u" of a frame, or "12:Z"'
                self.reject((*place, name), shown(value), wanted, f"Fill them in. {key.explanation}")
            kind = KINDS[key.kind]
            if not kind.fits(value):
                self.reject((*place, name), shown(value), kind.wanted, f"{kind.remedy} {key.explanation}")
        for key in section.keys:
            if key.required and not key.of and key.name not in table:
                self.missing(place, key.name)

    def _task(self, raw: Mapping[str, Any]) -> str:
        """Which of the TASKS this is, by the section that it alone has."""
        found = [task for task, one in HEADINGS.items() if one.strip("[]") in raw]
        if len(found) != 1:
            got = " and ".join(HEADINGS[task] for task in found) or "a job without a task"
            remedy = "A job does one thing; damage can start from the result of an updating, which is named "
            remedy += 'by kind = "result" under [model].'
            place: KeyPath = (HEADINGS[found[0]].strip("[]"),) if found else ()
            self.reject(place, got, f"one of {', '.join(HEADINGS.values())}", remedy)
        (task,) = found
        for name in raw:
            wanted = f"for 'antires {task}' {', '.join(f'[{one}]' for one in TASKS[task])}"
            if name not in TASKS[task]:
                self.reject((name,), f"[{name}] beside {HEADINGS[task]}", wanted, "Remove it.")
        if task == "series" and len(self.data) > 1:
            wanted = "one [data], whose file is a folder or a pattern"
            self.reject(("data",), "several [[data]]", wanted, "Write a job for each force.")
        return task

    def only(self, place: KeyPath, table: Mapping[str, Any], kind: str) -> None:
        """Refuse keys of another kind of model or parameter, or format, and miss those that it needs."""
        section = SECTIONS[str(place[0])]
        for name in table:
            key = section.key(name)
            if key and key.of and kind not in key.of:
                own = ", ".join(one.name for one in section.keys if not one.of or kind in one.of)
                got, wanted = f"{name!r}, which belongs to {' or '.join(key.of)}", f"a key of {kind!r}: {own}"
                self.reject((*place, name), got, wanted, "Remove it, or change the kind.")
        for key in section.keys:
            if key.required and kind in key.of and key.name not in table:
                self.missing(place, key.name)

    def file(self, name: str) -> Path:
        """A path of the job: relative to the folder of the job file."""
        return self.path.parent / os.path.expanduser(name)

    def existing(self, place: KeyPath, name: str, wanted: str = "a file that exists") -> Path:
        """A file of the job that is there."""
        remedy = "Paths are relative to the folder of the job file."
        return existing(self.where(place), self.file(name), remedy, wanted, name)

    def files(self, place: KeyPath, name: str, *, folders: bool = False, order: Any = None) -> list[Path]:
        """The files that a name stands for: one, or all of a pattern, in the order of their names."""
        pattern = self.file(name)
        if "*" not in pattern.name:
            return [pattern if folders and pattern.is_dir() else self.existing(place, name)]
        files = sorted(pattern.parent.glob(pattern.name), key=order)
        if not files:
            remedy = "Paths are relative to the folder of the job file."
            self.reject(place, shown(name), "files that exist", remedy)
        return files

    def reject(self, place: KeyPath, got: str, wanted: str, remedy: str) -> NoReturn:
        """Refuse what stands at a place."""
        raise InvalidInputError(self.where(place), got, wanted, remedy)

    def one_of(
        self, place: KeyPath, given: Any, known: Iterable[str], remedy: str, got: str = "", wanted: str = ""
    ) -> None:
        """Refuse what is none of the known names, with the nearest of them where one is near."""
        if given not in list(known):
            near = nearest(given, known, 0.7) if isinstance(given, str) else ""
            self.reject(place, got or shown(given), wanted or f"one of {', '.join(known)}", near or remedy)

    def missing(self, place: KeyPath, key: str) -> NoReturn:
        """Refuse a section for a key that is not there."""
        declared: Any = key_at((*place, key))
        wanted = f"{key} = {KINDS[declared.kind].wanted}"
        self.reject(place, f"no {key!r}", wanted, f"Add it. {declared.explanation}")

    def unknown_format(self, place: KeyPath, table: Mapping[str, Any], file: Path) -> NoReturn:
        """Refuse a file whose format is not known."""
        at = "format" if "format" in table else "file"
        remedy = f'Say which by format = "uff" or another, where the ending does not tell; {CONVERT}'
        self.reject((*place, at), shown(table[at]), f"a format out of {', '.join(FORMATS)}", remedy)

    def check_data(self, place: KeyPath, table: Mapping[str, Any], signal: Any = None) -> None:
        """Refuse what cannot be identified as the job says: asked before a signal is read, and with it."""
        for key in ("excitation", "band_hz"):
            if key not in table:
                self.missing(place, key)

    def where(self, place: KeyPath) -> Place:
        """The place as errors name it; what is not in the file has the line of what is above it."""
        there = place
        while there and there not in self._lines:
            there = there[:-1]
        line = f", line {self._lines[there]}" if there else ""
        return Place(f"{self.path.name}{line}{f', {_label(place)}' if place else ''}", place)

    @staticmethod
    def spelled(name: str, value: Any) -> str:
        """An argument of a reader as its user writes it, alone or with the value to be passed."""
        return name if value is None else f"{name} = {shown(value)}"

    def belongs(self, place: KeyPath) -> str:
        """What belongs to a place."""
        key = key_at(place)
        return "" if key is None else key.help

    @contextmanager
    def blame(
        self, place: KeyPath, elsewhere: Mapping[str, KeyPath | list[KeyPath]] | None = None
    ) -> Iterator[None]:
        """Errors about an argument become errors about its key, at ``place``, or ``elsewhere`` (by item)."""
        try:
            yield
        except InvalidInputError as exc:
            if isinstance(exc.argument, Place):  # blamed already
                raise
            name, *steps = exc.path
            at = {**_OWN_SECTION, **(elsewhere or {})}.get(name, (*place, name))
            if isinstance(at, list):
                at, steps = (at[steps[0]], steps[1:]) if steps else (place, steps)
            wanted, remedy = (spelled(text, self.spelled) for text in (exc.wanted, exc.remedy))
            about = self.belongs(at)
            if about not in remedy:
                remedy += f" What belongs here: {about}"
            raise type(exc)(self.where((*at, *steps)), exc.got, wanted, remedy) from exc


def read_job(path: str | os.PathLike[str]) -> Job:
    """Read and check a job file."""
    file = existing("JOB", Path(path), "'antires init job.toml' writes one to be filled in.", "a job file")
    content = file.read_bytes()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as exc:
        place = Place(f"{file.name}, line {content[: exc.start].count(10) + 1}")
        wanted = "a job file in TOML"
        raise InvalidInputError(place, "bytes that are no UTF-8 text", wanted, "Save it as UTF-8.") from exc
    return Job(file, text)
