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

from ..exceptions import InvalidInputError
from .keys import SECTIONS, Key, Section
from .lines import Path as Keys
from .lines import lines_of
from .values import KINDS, shown

__all__ = ["Job", "has_remedy", "nearest", "read_job"]


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
    task : {"update", "damage"}
    """

    def __init__(self, path: Path, text: str) -> None:
        self.path, self._name = path, path.name
        try:
            raw = tomllib.loads(text)
        except tomllib.TOMLDecodeError as exc:
            self._syntax(text, str(exc))
        self._lines = lines_of(text)
        self._unknown_sections(raw)
        tables = {name: self._tables(SECTIONS[name], value) for name, value in raw.items()}
        for name, rows in tables.items():
            for place, row in rows:
                self._check(SECTIONS[name], place, row)
        for name in ("data", "model"):
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

    def _syntax(self, text: str, said: str) -> NoReturn:
        where = re.search(r"\(at (?:line (\d+), column \d+|end of document)\)", said)
        lines = text.splitlines()
        number = int(where[1]) if where and where[1] else max(1, len(lines))
        line = lines[number - 1].strip() if number <= len(lines) else ""
        reason = said[: where.start()].strip() if where else said
        twice = re.match(r"Cannot declare \('(\w+)',\) twice", reason)
        several = twice is not None and twice[1] in SECTIONS and SECTIONS[twice[1]].several != "no"
        remedy = (
            f"Where there are several, each is headed [[{twice[1]}]]."
            if twice and several
            else "Text stands in quotes, lists in [ ], and each key once."
        )
        remedy += r" A path is written with / or in single quotes: 'C:\tests\a.uff'." if "\\" in line else ""
        raise InvalidInputError(
            f"{self._name}, line {number}",
            f"{line!r}, which is no TOML ({reason})",
            "lines such as key = value under a [section]",
            remedy,
        )

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

    def _tables(self, section: Section, value: Any) -> list[tuple[Keys, dict[str, Any]]]:
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

    def _check(self, section: Section, place: Keys, table: Mapping[str, Any]) -> None:
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
            if not kind.fits(value):
                self.reject((*place, name), shown(value), kind.wanted, f"{kind.remedy} {key.explanation}")
        for key in section.keys:
            if key.required and key.name not in table:
                self.missing(place, key.name)

    def _task(self, raw: Mapping[str, Any]) -> str:
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

    def only(self, place: Keys, table: Mapping[str, Any], kind: str) -> None:
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

    def existing(self, place: Keys, name: str, wanted: str = "a file that exists") -> Path:
        """A file of the job that is there."""
        file = self.file(name)
        if not file.is_file():
            got = f"{name!r}, which is a folder" if file.is_dir() else f"{name!r}, which does not exist"
            self.reject(place, got, wanted, "Paths are relative to the folder of the job file.")
        return file

    def reject(self, place: Keys, got: str, wanted: str, remedy: str) -> NoReturn:
        """Refuse what stands at a place."""
        raise InvalidInputError(self.where(place), got, wanted, remedy)

    def missing(self, place: Keys, key: str) -> NoReturn:
        """Refuse a section for a key that is not there."""
        known = _key_at((*place, key))
        wanted = f"{key} = {KINDS[known.kind].wanted}" if known else key
        self.reject(place, f"no {key!r}", wanted, f"Add it. {known.explanation}" if known else "Add it.")

    def where(self, place: Keys) -> str:
        """File, line, section and key of a place; of its nearest neighbour above where it is not there."""
        there = place
        while there and there not in self._lines:
            there = there[:-1]
        line = f", line {self._lines[there]}" if there else ""
        return f"{self._name}{line}{',' if place else ''}{_label(place)}"

    @contextmanager
    def blame(self, place: Keys, elsewhere: Mapping[str, Keys | list[Keys]] | None = None) -> Iterator[None]:
        """Errors about an argument become errors about its key, at ``place`` or ``elsewhere``.

        A list has the places of an argument's items.
        """
        try:
            yield
        except InvalidInputError as exc:
            found = _ARGUMENT.match(str(exc))
            if found is None or str(exc).startswith(self._name):  # blamed already
                raise
            at = (elsewhere or {}).get(found[1], (*place, found[1]))
            indices = tuple(_index(part) for part in re.findall(r"\[([^\]]+)\]", found[2]))
            if isinstance(at, list):
                at, indices = (at[int(indices[0])], indices[1:]) if indices else (place, ())
            attribute = tuple(part for part in found[3].split(".") if part)
            said = str(exc)[found.end() :]
            if not has_remedy(said):
                key = _key_at(at)
                said += f" What belongs here: {key.help if key else SECTIONS[str(at[0])].help}"
            raise type(exc)(f"{self.where((*at, *indices, *attribute))}: {said}") from exc


_ARGUMENT = re.compile(r"([A-Za-z_]\w*)((?:\[[^\]]+\])*)((?:\.\w+)*): ")


def read_job(path: str | os.PathLike[str]) -> Job:
    """Read and check a job file.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    Job

    Raises
    ------
    InvalidInputError
        No such file, no TOML, an unknown section or key, a value of another kind. The message names file,
        line and key, what was got, what is wanted, and how to mend it.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from antires_rs.jobs import read_job, template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "job.toml")
    ...     _ = file.write_text(template("damage"), encoding="utf-8")
    ...     read_job(file).task
    'damage'
    """
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
            f"{file.name}, line {line}",
            "bytes that are no UTF-8 text",
            "a job file in TOML",
            "Save it as UTF-8.",
        ) from exc
    return Job(file, text)


def nearest(name: str, known: Any) -> str:
    """A hint at the known name nearest to an unknown one; '' where none is near."""
    near = get_close_matches(name, list(known), 1, 0.7)
    return f"Did you mean {near[0]!r}?" if near else ""


def _label(place: Keys) -> str:
    """``[search] seed`` of ("search", "seed"); arrays of tables by their number."""
    if not place:
        return ""
    name, rest = str(place[0]), list(place[1:])
    label = f" [{name}]"
    if rest and isinstance(rest[0], int) and name in SECTIONS and SECTIONS[name].several != "no":
        label = f" [[{name}]] no. {rest[0] + 1}"
        rest = rest[1:]
    for i, part in enumerate(rest):
        label += f"[{part}]" if isinstance(part, int) else f"{'.' if i else ' '}{part}"
    return label


def _key_at(place: Keys) -> Key | None:
    section = SECTIONS.get(str(place[0])) if place else None
    names = [part for part in place[1:] if isinstance(part, str)]
    return section.key(names[0]) if section and names else None


def _index(text: str) -> str | int:
    bare = text.strip("'\"")
    return int(bare) if bare.isdigit() else bare


def has_remedy(said: str) -> bool:
    """Whether a sentence follows the one that says what is wanted."""
    _, _, wanted = said.partition("; wanted ")
    return re.search(r"[.?] [A-Z']", wanted) is not None
