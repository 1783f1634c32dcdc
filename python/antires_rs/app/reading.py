"""Signals of any format, by the options of a job or of the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn

from .. import io
from ..damage.options import ONE_STATE, TWO_STATES, options_with
from ..exceptions import InvalidInputError, reject
from ..identification.identify import identify_antiresonances
from ..identification.options import sorted_out
from ..io.channels import kept, renamed
from ..io.common import Signal
from ..io.own_format import relabelled
from ..io.registry import READERS, conversion
from ..io.uff import as_point
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.structural_model import StructuralModel
from ..signals.repeats import one_source
from ..support.messages import EDIT_WANTED, LeftOut, Part, edit_named, spelled
from .arguments import dof_finder
from .job import Job, Path_lines as Keys
from .keys import DATA, FOLDER, FORMATS, IDENTIFICATION, format_of, shown

_READERS: dict[str, Callable[..., Signal]] = {**READERS, FOLDER: io.read_frf_files}
#: How this is done in a job and on the command line.
LEAVE_OUT = "Give it a dof, or leave it out: false in a job, CHANNEL= on the command line"
#: Keys of [data] that are not a reader's.
_OURS = {"file", "repeats", "format", "excitation", "band_hz", "dofs", "drop", "add"}


def _in_a_job(part: Part) -> str:
    if isinstance(part, LeftOut):
        return LEAVE_OUT
    return part.name if part.value is None else f"{part.name} = {shown(part.value)}"


def read_signal(
    file: Path, kind: str, options: dict[str, Any], spell: Callable[[Part], str] = _in_a_job
) -> Signal:
    """Read a signal; ``options`` are keys of [data].

    ``spell`` writes an argument of the reader, or how a channel is left out, as this user would.
    """
    chosen = {name: value for name, value in options.items() if name not in _OURS}
    for name in chosen:
        key = DATA.key(name)
        if key and key.of and kind not in key.of:
            reject(name, f"it for a {kind} file", f"{name} with {' or '.join(key.of)} alone", "Leave it out.")
    if kind == FOLDER and "format" in options:
        chosen["format"] = options["format"]
    if chosen.get("force") is False:
        chosen["force"] = None
    dofs = (
        {name: _plain(dof) for name, dof in options["dofs"].items()}
        if isinstance(options.get("dofs"), dict)
        else [_plain(dof) for dof in options.get("dofs", [])]
    )
    # Universal files name points, whose sign may have to be turned: that is the reader's.
    by_point = kind == "uff" and isinstance(dofs, dict) and all(map(_is_point, dofs))
    left_out = {name for name, dof in dofs.items() if dof is None} if isinstance(dofs, dict) else set()
    if by_point:
        chosen["dofs"] = dofs
    elif left_out and kind != FOLDER:  # before the reader finds that they do not fit the rest
        chosen["dofs"] = lambda name: None if str(name) in left_out else name
    try:
        signal = _READERS[kind](file, **chosen)
    except InvalidInputError as exc:  # which speaks to one who calls from Python
        said = (spelled(text, spell) for text in (exc.got, exc.wanted, exc.remedy))
        raise type(exc)(exc.argument, *said) from exc
    return signal if by_point or not dofs else _named(signal, dofs)


def _named(signal: Signal, dofs: dict[Any, Any] | list[Any]) -> Signal:
    """The channels that have a dof, under its name."""
    names = [str(name) for name in signal.dofs] if isinstance(dofs, dict) else list(signal.dofs)
    if isinstance(dofs, dict):
        for name, dof in dofs.items():
            if name not in names and dof is not None:
                reject(
                    "dofs", f"{name!r}, which is no channel", f"names out of {names}", "Correct or remove it."
                )
        for name in names:
            if name not in dofs:
                reject("dofs", f"no dof for channel {name!r}", f"one for each of {names}", f"{LEAVE_OUT}.")
    labels = renamed("dofs", names, dofs)
    rows = kept(labels)
    return relabelled(signal, rows, [labels[i] for i in rows])


def _plain(dof: Any) -> Any:
    return None if dof is False else dof


def _is_point(name: str) -> bool:
    try:
        as_point("dofs", name)
    except InvalidInputError:
        return False
    return True


# -- Values that a job drops and adds by hand, under [data]


#: The keys, and what each does.
KEYS: dict[str, Callable[..., AntiresonanceSet]] = {
    "drop": AntiresonanceSet.drop,
    "add": AntiresonanceSet.add,
}


def edited(
    job: Job, place: Keys, table: dict[str, Any], found: AntiresonanceSet, find: Callable[[Keys, Any], Any]
) -> AntiresonanceSet:
    """The set with the edits of its [data], dropped values first; dofs as the model names them."""
    for key, change in KEYS.items():
        given = table.get(key, [])
        for i, text in enumerate([given] if isinstance(given, str) else given):
            at: Keys = (*place, key) if isinstance(given, str) else (*place, key, i)
            named = edit_named(text)
            if named is None:
                job.reject(at, shown(text), EDIT_WANTED, "Write the dof, =, the frequency, and why.")
            name, freq_hz, reason = named
            with job.blame(place, {"dof": at, "freq_hz": at}):
                dof = find(at, int(name) if name.isdecimal() else name)
                found = change(found, dof, freq_hz, reason=reason)
    return found


# -- From the [data] of a job to antiresonances at dofs of its model


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
    """Read and identify every [data] of a job."""
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
        found = identify_antiresonances(
            signal, excitation=force, band_hz=table["band_hz"], **sorted_out(chosen)
        )
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


# -- The intact structure of a job: ``baseline`` of [damage], read and identified as [data] is


_KEY: Keys = ("damage", "baseline")
#: Keys of [search] that count with a baseline.
_SEARCH = ("seed", "workers")


def check_options(job: Job) -> None:
    """Refuse keys that would have no effect, with a baseline or without one."""
    damage = job.section("damage")
    if "baseline" not in damage:
        for name in ("prior", *options_with(TWO_STATES)):
            if name in damage:
                job.reject(
                    ("damage", name),
                    f"{name!r} without a baseline",
                    "it beside baseline",
                    "Name the measurement of the intact structure, or remove it.",
                )
        return
    for name in options_with(ONE_STATE):
        if name in damage:
            job.reject(
                ("damage", name),
                f"{name!r} beside baseline",
                "it without a baseline",
                "Remove it: with a baseline the standard deviations count, and probabilities replace prices.",
            )
    for name in job.section("search"):
        if name not in _SEARCH:
            job.reject(
                ("search", name),
                f"{name!r} of a search, where [damage] has a baseline",
                f"{' and '.join(_SEARCH)} alone",
                "Remove it: hypotheses are judged in seconds, without a search that could be kept.",
            )


def baseline_of(job: Job, model: StructuralModel, say: Callable[[str], Any]) -> list[Measured]:
    """Read and identify the intact structure; empty where the job has no baseline.

    One file for each [data], in their order; or any number with a single [data].
    """
    given = job.section("damage").get("baseline", [])
    names = [given] if isinstance(given, str) else given
    if names and len(job.data) > 1 and len(names) != len(job.data):
        job.reject(
            _KEY,
            f"{len(names)} of them",
            f"{len(job.data)}, one for each [[data]] in their order",
            "A * in the name takes several records of one test.",
        )
    measured: list[Measured] = []
    for i, name in enumerate(names):
        at = _KEY if isinstance(given, str) else (*_KEY, i)
        number = i if len(job.data) > 1 else 0
        measured += _one(job, at, name, number, model, say)
    return measured


def _one(
    job: Job, at: Keys, name: str, number: int, model: StructuralModel, say: Callable[[str], Any]
) -> list[Measured]:
    place, table = job.data_places[number], job.data[number]
    files = files_of(job, at, name, folders=True)
    own = _format(job, at, table, files[0])
    held = _format(job, place, table, job.file(table["file"])) == "antiresonances"
    find = dof_finder(job, model)
    if own != "antiresonances":
        if held:
            _identified_first(job, at, name)
        known = {key: value for key, value in table.items() if key != "repeats"}
        known |= {} if own == FOLDER else {"format": own}
        further = [(at, path) for path in files[1:]]
        return [one_measured(job, place, known, model, find, say, (at, files[0]), further)]
    # Saved sets have dofs of the model already, or the names of channels; a list is of channels in a record.
    dofs = table.get("dofs")
    named = dofs is not None and (held or isinstance(dofs, dict))
    known = {"format": own} | ({"dofs": dofs} if named else {})
    return [one_measured(job, place, known, model, find, say, (at, file), []) for file in files]


def _format(job: Job, place: Keys, table: dict[str, Any], file: Path) -> str:
    """What a file is: by its ending, else what [data] says."""
    if file.is_dir():
        return FOLDER
    kind = format_of(file.name) or format_of(file.name, table.get("format"))
    if kind is None:
        job.reject(
            place,
            shown(file.name),
            f"a format out of {', '.join(FORMATS)}",
            "A file whose ending does not tell has the format of [data].",
        )
    return kind


def _identified_first(job: Job, at: Keys, name: str) -> NoReturn:
    job.reject(
        at,
        f"{shown(name)}, a measurement beside a [data] that holds antiresonances already",
        "antiresonances of the intact structure, a .json",
        "Identify it first with the same options: antires identify FILE --out intact.json.",
    )
