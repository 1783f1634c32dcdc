"""From the [data] of a job to antiresonances at dofs of its model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..identification.identify import identify_antiresonances
from ..io.other_programs import conversion
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.structural_model import StructuralModel
from ..signals.repeats import one_source
from .by_hand import edited
from .formats import FOLDER, FORMATS, format_of
from .job import Job
from .keys_data import IDENTIFICATION
from .lines import Path as Keys
from .model import dof_finder
from .reading import Signal, read_signal, relabelled
from .values import shown

__all__ = ["Measured", "files_of", "measured_of", "one_measured"]

Finder = Callable[[Keys, Any], Any]
#: What identify_antiresonances calls otherwise than the job.
_OPTIONS = {key.name: ("identification", key.name) for key in IDENTIFICATION.keys}


@dataclass(frozen=True)
class Measured:
    """One [data] of a job, or its intact counterpart.

    Attributes
    ----------
    file : pathlib.Path
    found : AntiresonanceSet
        At dofs of the model.
    signal : Recording or FrequencyResponse or None
        What it was identified from; None where the file held antiresonances.
    repeats : tuple of pathlib.Path
        Further files of the same test.
    table : mapping of str to Any
        The keys by which it was read.
    """

    file: Path
    found: AntiresonanceSet
    signal: Signal | None = None
    repeats: tuple[Path, ...] = ()
    table: Mapping[str, Any] = field(default_factory=dict)


def measured_of(job: Job, model: StructuralModel | None, say: Callable[[str], Any]) -> list[Measured]:
    """Read and identify every [data] of a job.

    Parameters
    ----------
    job : Job
    model : StructuralModel, optional
        Names of dofs are looked up in it; without one they stay as they are.
    say : callable
        Receives a line before each stage.
    """
    find: Finder = (lambda place, name: name) if model is None else dof_finder(job, model)
    measured = []
    for place, table in zip(job.data_places, job.data, strict=True):
        file = job.file(table["file"])
        if not file.is_dir():
            kind_of(job, place, table, file)  # an unknown ending is told before a file that is not there
            job.existing((*place, "file"), table["file"])
        further = _further(job, place, table, file)
        one = one_measured(job, place, table, model, find, say, ((*place, "file"), file), further)
        measured.append(replace(one, found=edited(job, place, table, one.found, find)))
    if job.section("identification") and all(each.signal is None for each in measured):
        job.reject(
            ("identification",),
            "options beside files that hold antiresonances already",
            "a measurement to be identified",
            "Remove the section, or name the measurement.",
        )
    return measured


def kind_of(job: Job, place: Keys, table: dict[str, Any], file: Path) -> str:
    """Format of a measurement."""
    kind = FOLDER if file.is_dir() else format_of(file.name, table.get("format"))
    if kind is None:
        at = "format" if "format" in table else "file"
        job.reject(
            (*place, at),
            shown(table[at]),
            f"a format out of {', '.join(FORMATS)}",
            'Say which by format = "uff" or another, where the ending does not tell.'
            + conversion(file.name) * ("format" not in table),
        )
    return kind


def one_measured(
    job: Job,
    place: Keys,
    table: dict[str, Any],
    model: StructuralModel | None,
    find: Finder,
    say: Callable[[str], Any],
    first: tuple[Keys, Path],
    further: list[tuple[Keys, Path]],
) -> Measured:
    """Read and identify a file, and those that repeat it, as the keys of a [data] say.

    ``first`` and ``further`` are files that exist, each with its place in the job.
    """
    file_at, file = first
    kind = kind_of(job, place, table, file)
    job.only(place, table, kind)
    say(f"reading {file.name}" + (f" and {len(further)} more" if further else ""))
    names = _dofs(table.get("dofs"), place, find)
    if kind == "antiresonances":
        with job.blame(place, {"path": file_at}):
            found = AntiresonanceSet.load(file)
        return Measured(file, _renamed(job, place, found, names, find, model), table=table)
    for key in ("excitation", "band_hz"):
        if key not in table:
            job.missing(place, key)
    options = table if names is None else {**table, "dofs": names}
    signals = []
    places: list[Keys] = [file_at, *(at for at, _ in further)]
    for own, each in zip(places, [file, *(path for _, path in further)], strict=True):
        with job.blame(place, {"path": own, "files": own, "signal": own}):
            signal = read_signal(each, kind, options)
        signals.append(_at_dofs(job, place, signal, find, model))
    with job.blame(place, {"source": places}):
        signal = one_source(signals)
    say(f"identifying the antiresonances of {len(signal.dofs)} responses")
    force = table["excitation"]
    if isinstance(names, dict) and force in names:
        if names[force] is False:
            job.reject(
                (*place, "excitation"),
                f"{shown(force)}, which dofs leaves out",
                "a dof of the model",
                "Write the dof at which the force acts; its channel may still be left out.",
            )
        force = names[force]  # the name of a channel stands for its dof
    force = _checked(job, (*place, "excitation"), find((*place, "excitation"), force), model)
    chosen = dict(job.section("identification"))
    if "dofs" in chosen:
        chosen["dofs"] = [find(("identification", "dofs"), dof) for dof in chosen["dofs"]]
    with job.blame(place, {"source": file_at, **_OPTIONS}):
        found = identify_antiresonances(signal, excitation=force, band_hz=table["band_hz"], **chosen)
    return Measured(file, found, signal, tuple(path for _, path in further), table)


def files_of(job: Job, at: Keys, name: str, *, folders: bool = False) -> list[Path]:
    """The files that a name stands for: one, or all of a pattern, in the order of their names."""
    pattern = job.file(name)
    if "*" not in pattern.name:
        return [pattern if folders and pattern.is_dir() else job.existing(at, name)]
    files = sorted(pattern.parent.glob(pattern.name))
    if not files:
        job.reject(at, shown(name), "files that exist", "Paths are relative to the folder of the job file.")
    return files


def _further(job: Job, place: Keys, table: dict[str, Any], first: Path) -> list[tuple[Keys, Path]]:
    """The other files of a test, each with its place in the job; the first is not read twice."""
    found: list[tuple[Keys, Path]] = []
    given = table.get("repeats", [])
    for i, name in enumerate([given] if isinstance(given, str) else given):
        at: Keys = (*place, "repeats", i)
        files = files_of(job, at, name)
        known = {first.resolve(), *(path.resolve() for _, path in found)}
        found += [(at, path) for path in files if path.resolve() not in known]
    return found


def _dofs(dofs: Any, place: Keys, find: Finder) -> Any:
    """The dofs of the job with names looked up in the model."""
    if isinstance(dofs, dict):
        return {name: find((*place, "dofs", name), dof) for name, dof in dofs.items()}
    return dofs if dofs is None else [find((*place, "dofs", i), dof) for i, dof in enumerate(dofs)]


def _at_dofs(job: Job, place: Keys, signal: Signal, find: Finder, model: StructuralModel | None) -> Signal:
    """The signal with every channel at a dof of the model."""
    if model is None:
        return signal
    at = (*place, "dofs")
    dofs = [_checked(job, at, find(at, name), model, name) for name in signal.dofs]
    if dofs == list(signal.dofs):
        return signal
    with job.blame(place):
        return relabelled(signal, list(range(len(dofs))), dofs)


def _renamed(
    job: Job, place: Keys, found: AntiresonanceSet, names: Any, find: Finder, model: StructuralModel | None
) -> AntiresonanceSet:
    """A set of a file at dofs of the model; the same object where nothing changes."""
    if isinstance(names, list):
        if len(names) != len(found):
            job.reject(
                (*place, "dofs"),
                f"{len(names)} dofs",
                f"{len(found)}, one for each of {list(found)}",
                "Or a table name = dof.",
            )
        names = dict(zip(found, names, strict=True))
    at = (*place, "dofs")
    table = {dof: (names or {}).get(str(dof), (names or {}).get(dof, dof)) for dof in found}
    table = {
        dof: new if new is False else _checked(job, at, find(at, new), model, dof)
        for dof, new in table.items()
    }
    force = find(at, (names or {}).get(str(found.excitation), found.excitation))
    if force == found.excitation and all(new == dof for dof, new in table.items()):
        return found
    kept = {dof: new for dof, new in table.items() if new is not False}
    with job.blame(place, {"freq_hz": at, "dofs": at}):
        return found.relabelled(_checked(job, at, force, model), kept)


def _checked(job: Job, place: Keys, dof: Any, model: StructuralModel | None, name: Any = None) -> Any:
    """A dof of the model."""
    if model is None or (isinstance(dof, int) and 0 <= dof < model.n_dof):
        return dof
    got = f"{dof!r}" if name is None or name == dof else f"{dof!r} for {name!r}"
    remedy = (
        f'Say which dof it is: dofs = {{ "{dof}" = 0, ... }}.'
        if isinstance(dof, str)
        else "Dofs count from 0; correct it, or the model."
    )
    return job.reject(place, got, f"a dof of the model, 0 to {model.n_dof - 1}", remedy)
