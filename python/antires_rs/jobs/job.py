"""A job file, read and checked; every message names file, line and key."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn

from ..exceptions import InvalidInputError
from .key import Section
from .keys import SECTIONS
from .lines import Path as Keys
from .lines import lines_of
from .places import Place, Places, key_at
from .syntax import parsed
from .values import KINDS, shown, unset_in

__all__ = ["Job", "nearest", "read_job"]


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
        known = key_at((*place, key))
        wanted = f"{key} = {KINDS[known.kind].wanted}" if known else key
        self.reject(place, f"no {key!r}", wanted, f"Add it. {known.explanation}" if known else "Add it.")

    def where(self, place: Keys) -> Place:
        """The place as errors name it."""
        return self._where.of(place)

    @contextmanager
    def blame(self, place: Keys, elsewhere: Mapping[str, Keys | list[Keys]] | None = None) -> Iterator[None]:
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
