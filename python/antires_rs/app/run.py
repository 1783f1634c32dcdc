"""Carry out a job: measurement, model, search, files."""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import re
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..damage.assess import DamageResult
from ..exceptions import MissingDependencyError, UnsuitableDataError
from ..figures import report_parts as parts
from ..identification.stabilization import StabilizationDiagram
from ..io.archive import Store, read_store, versions, write_store
from ..io.common import parts_of
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..measured.response_table import ResponseTable
from ..signals.averaging import choose_nperseg
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..signals.transfer_functions import transmissibility
from ..support.checks import Dofs
from ..support.files import write_atomically
from ..support.messages import warn
from ..updating.problem import UpdatingProblem
from ..updating.result import UpdateResult
from ..updating.targets import FrequencyTable, ModalTable
from ..updating.update import update
from .arguments import damage_search, model_of, parameters_of, search_of, term_files
from .command import hint, say, show
from .job import Job
from .reading import Measurement, baseline_of, check_options, measured_of, modal_files, modes_of

# -- The folder of a run: what is in it, what was left by one that was killed


class RunFolder:
    """Names and places of everything that a run writes; ``record`` says which job runs here."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.result, self.summary = folder / "result.npz", folder / "summary.json"
        self.report, self.pictures = folder / "report.html", folder / "pictures"
        self.checkpoint, self.record = folder / "search.ckpt", folder / "run.json"
        self.evidence = folder / "evidence.npz"

    @classmethod
    def of(cls, job: Job) -> RunFolder:
        """The folder that a job names; ``<job>_results`` beside it by default. One of others is refused."""
        name = job.sections["output"].get("folder")
        made = cls(job.file(name) if name else job.path.with_name(f"{job.path.stem}_results"))
        path, name, got = made.folder, made.folder.name, ""
        record, whole = made.read_record(), path.resolve()
        if (path.exists() and not path.is_dir()) or whole == Path(whole.anchor):
            got = f"{str(path)!r}, no folder for results"
        elif record and made.job_path().resolve() != job.path.resolve():
            got = f"{name!r}, which holds the results of {near(made.job_path())}"
        elif not record and not whole.is_relative_to(job.path.resolve().parent):
            # Elsewhere it may be anyone's, and a job may be a stranger's.
            begun = job.task == "series" and (path / "series.parquet").exists()
            there = [file.name for file in (made.result, made.summary, made.report) if file.exists()]
            got = f"{name!r}, which holds {there[0]} of no job" if there and not begun else ""
        if got:
            remedy = 'Name one under [output], folder = "...".'
            job.reject(("output", "folder"), got, "a folder of this job's own", remedy)
        return made

    def numbered(self, what: str, number: int) -> Path:
        """File of the set of one [data], or of its intact counterpart, numbered from 0."""
        return self.folder / (f"{what}_{number}.json" if number else f"{what}.json")

    @property
    def contents(self) -> str:
        """The names of what is there."""
        return ", ".join(sorted(path.name for path in self.folder.iterdir()))

    @property
    def unfinished(self) -> bool:
        """Whether a search waits here to be taken up again."""
        return self.checkpoint.exists()

    def forget_results(self) -> None:
        """Remove what an earlier run drew, so that nothing stale stands beside a new result."""
        pictures = [file for file in self.pictures.glob("*.png") if _PICTURE.fullmatch(file.name)]
        for file in (self.result, self.summary, self.report, *pictures):
            file.unlink(missing_ok=True)

    def read_record(self) -> dict[str, Any]:
        """What runs or ran here; empty where no job did."""
        try:
            data = json.loads(self.record.read_text(encoding="utf-8"))
        except (FileNotFoundError, NotADirectoryError, ValueError):
            return {}
        return data if isinstance(data, dict) else {}

    def job_path(self) -> Path:
        """The job file of the record: relative to the folder, so that both may be moved together."""
        return Path(os.path.normpath(self.folder / str(self.read_record().get("job", ""))))


_DRAWN = "differences modes convergence damage hypotheses model response stabilization_.*"
_PICTURE = re.compile(rf"({_DRAWN.replace(' ', '|')})\.png")


def picture_name(name: str) -> str:
    """File of a picture; names of channels may hold what no file's may."""
    return re.sub(r"[^\w.+-]+", "_", name) + ".png"


def write_json(file: Path, data: dict[str, Any]) -> None:
    """Write as JSON; numbers that JSON does not know must be null already."""
    write_atomically(file, (json.dumps(data, indent=1, allow_nan=False) + "\n").encode())


def _sha256(file: Path) -> str:
    with open(file, "rb") as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest()


# -- What an identification leaves beside its values: diagrams and curves, so that a report can be drawn again
#
# ``evidence.npz`` of a run's folder, version 1: the stabilization diagrams of each [data] by dof, and the
# transmissibilities that the report draws. Nothing is computed from it; without it a report has fewer
# pictures.

FORMAT, VERSION = "antires_rs.evidence", 1
_ROWS = ("freq_hz", "damping_ratio", "stable")
_COLUMNS = ("freq_hz", "damping_ratio", "std_hz")
_CURVES = ("orders", "background_freq_hz", "background", "unexplained_hz")
_TABLES = ("accepted", "left_out")


@dataclass(frozen=True)
class Evidence:
    """Diagrams by dof of each [data], and the response that the report draws."""

    diagrams: tuple[Mapping[Any, StabilizationDiagram], ...] = ()
    response: FrequencyResponse | None = None

    def __bool__(self) -> bool:
        return self.response is not None or any(self.diagrams)

    def save(self, path: Path) -> None:
        """Write it, whole or not at all."""
        store, r = Store(), self.response
        diagrams = [[[dof, _described(one, store)] for dof, one in each.items()] for each in self.diagrams]
        data: dict[str, Any] = {"format": FORMAT, "version": VERSION, "diagrams": diagrams, "response": None}
        if r is not None:  # drawn in decibels: half the digits are more than the eye can see
            values = store.put(r.values.astype(np.complex64))
            data["response"] = {"freq_hz": store.put(r.freq_hz), "dofs": list(r.dofs), "values": values}
            data["response"] |= {"kind": r.kind, "reference": r.reference}
        write_store(path, data, store)

    @classmethod
    def load(cls, path: Path) -> Evidence:
        """Read it."""
        wanted = "the evidence.npz of a run"
        file, data = read_store(path, FORMAT, VERSION, wanted)
        with parts_of(file, wanted):
            tables = tuple(
                {Dofs.of_file(dof): _made(diagram) for dof, diagram in table} for table in data["diagrams"]
            )
            kept = data["response"]
            # Files of older versions do not say what kind it is.
            return cls(tables, kept and FrequencyResponse(**({"kind": "transmissibility"} | kept)))


def _described(diagram: StabilizationDiagram, store: Store) -> dict[str, Any]:
    """A diagram as arrays: the rows of all orders in one."""
    data: dict[str, Any] = {"band_hz": list(diagram.band_hz)}
    data["counts"] = store.put(np.array([len(row) for row in diagram.freq_hz], dtype=np.int64))
    data |= {name: store.put(np.concatenate([np.empty(0), *getattr(diagram, name)])) for name in _ROWS}
    data |= {name: store.put(getattr(diagram, name)) for name in _CURVES}
    for name in _TABLES:
        table = getattr(diagram, name)
        columns = {column: getattr(table, column) for column in _COLUMNS} | dict(table.scores)
        data[name] = {column: store.put(values) for column, values in columns.items()}
    return data


def _made(data: dict[str, Any]) -> StabilizationDiagram:
    ends = np.cumsum(data["counts"])[:-1]
    rows = {name: tuple(np.split(data[name], ends)) for name in _ROWS}
    rows["stable"] = tuple(row.astype(bool) for row in rows["stable"])
    tables = {}  # Files of older versions do not have what was not accepted.
    for name in (name for name in _TABLES if name in data):
        hz, damping, std = map(data[name].pop, _COLUMNS)
        tables[name] = ResponseTable(hz, damping, std, data[name])
    curves = {name: data[name] for name in _CURVES if name in data}
    made: dict[str, Any] = {**rows, **tables, **curves, "band_hz": tuple(data["band_hz"])}
    return StabilizationDiagram(**made)


def _response(job: Job, measured: list[Measurement]) -> FrequencyResponse | None:
    """Transmissibilities over the first response that has antiresonances; measured FRFs themselves."""
    if not measured:
        return None
    signal, found = measured[0].signal, measured[0].found
    if found.order > 1:  # no curve of a single response is free of several forces
        return None
    if isinstance(signal, Recording):
        dof = next((dof for dof, values in found.items() if values.size), None)
        if dof is None or signal.n_channels < 2:
            return None
        try:
            length = job.sections["identification"].get("nperseg")
            length = length or choose_nperseg(signal, job.data[0]["band_hz"])
            signal = transmissibility(signal, dof, nperseg=length, estimator="rank1")
        except UnsuitableDataError:  # a single impact has no averages
            return None
    if signal is None:
        return None
    (low, high), freq = job.data[0]["band_hz"], signal.freq_hz
    keep = (freq >= low) & (freq <= high)
    return FrequencyResponse(freq[keep], signal.values[:, keep], signal.dofs, signal.kind, signal.reference)


def measurement_of(measured: list[Measurement]) -> list[dict[str, list[str]]]:
    """What was measured and how it was identified, in words, for each measurement."""
    facts = []
    for each in measured:
        dofs, unit = each.table.get("dofs"), each.table.get("unit")
        own = {"File": [path.name for path in (each.file, *each.repeats)]}
        if isinstance(dofs, dict):
            own["Dofs"] = [f"{name} = {'left out' if dof is False else dof}" for name, dof in dofs.items()]
        if each.signal is not None:
            si = "SI (m/s2 for accelerations); what the file names otherwise was converted"
            own |= parts.of_signal(each.signal)
            own["Unit"] = [f"{unit} in the file, here SI" if unit else si]
        facts.append(own | parts.of_evidence(each.found))
    return facts


@contextmanager
def heard() -> Iterator[list[str]]:
    """Every warning that is raised inside, while it is shown as ever."""
    texts: list[str] = []
    with warnings.catch_warnings():
        show = warnings.showwarning

        def keep(message: Warning | str, *rest: Any, **named: Any) -> None:
            if str(message) not in texts:
                texts.append(str(message))
            show(message, *rest, **named)

        warnings.showwarning = keep
        yield texts


# -- A run in numbers, ready for JSON, and in words for the terminal

_LEAST = 1e-6  # hypotheses below this probability are left out


def number(value: Any) -> float | None:
    """A number as JSON knows it; None where there is none."""
    return None if value is None or not math.isfinite(value) else float(value)


def rows_of(**columns: Any) -> list[dict[str, Any]]:
    """A table as JSON has it, a row each."""
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def summary_of(
    job: Job,
    result: UpdateResult,
    record: dict[str, Any],
    measured: list[Measurement],
    beside: ModalTable | None,
    seconds: float,
) -> dict[str, Any]:
    """All numbers of a run, and what repeats it; after Ctrl-C null for those that take seconds."""
    table = result.table
    at_once = result.status == "interrupted" and not _judged(result)
    checks = [each.found.data_check for each in measured if each.found.data_check is not None]
    frequencies = []
    if isinstance(table, FrequencyTable):
        columns = {name: getattr(table, name).tolist() for name in ("excitation", "dof")}
        hz = (f"{name}_hz" for name in ("measured", "before", "after"))
        frequencies = rows_of(**columns, **{name: map(number, getattr(table, name)) for name in hz})
    modes, names = (table if isinstance(table, ModalTable) else beside), ("measured", "before", "after")
    of_modes = {f"{state}_hz": getattr(modes, f"{state}_hz") for state in names} if modes else {}
    for state, partner in zip(names[1:], modes.partners, strict=True) if modes else ():
        of_modes |= {f"{state}_mac": getattr(modes, f"{state}_mac"), f"{state}_mode": partner}
    how = {"status": "status", "message": "message", "finished": "success", "evaluations": "nfev"}
    how |= {"linearizations": "njev", "generations": "nit", "exchanges": "migrations", "seed": "seed"}
    return {
        "antires_rs": record["versions"]["antires_rs"],
        "job": job.path.name,
        "command": f"antires {job.task} {job.path.name}",
        **{name: record[name] for name in ("task", "inputs", "versions")},
        "seconds": seconds,
        "J": number(result.fun),
        **{name: getattr(result, own) for name, own in how.items()},
        **(_losses(result, at_once) if isinstance(result, DamageResult) else _parameters(result, at_once)),
        "counted_from": 0,  # As in Python: "dof", "element" and the numbers in names count from 0.
        "largest_before_percent": number(table.largest_before_percent),
        "largest_after_percent": number(table.largest_after_percent),
        "antiresonances": frequencies,
        "modes": rows_of(**{name: map(number, column) for name, column in of_modes.items()}),
        "warnings": [  # Those of the data check have been raised as one.
            *(text for check in checks for text in check.warnings),
            *(text for text in record["warnings"] if not text.startswith("data check: ")),
        ],
        "notes": [] if at_once else result.notes,
    }


def text_of(result: UpdateResult) -> str:
    """A run in words; after Ctrl-C without the notes that take time."""
    if result.status != "interrupted" or _judged(result):
        return result.summary()
    lines = [f"J = {result.fun:.6g} after {result.nfev:,} evaluations: interrupted, the best so far", ""]
    width = max(map(len, result.problem.names))
    loss = isinstance(result, DamageResult)
    for name, value in zip(result.problem.names, result.x, strict=True):
        if value != 0.0 or not loss:
            lines.append(f"{name:<{width}}  {f'{100 * value:6.2f} %' if loss else f'{value:#12.6g}'}")
    return "\n".join([*lines, "", str(result.table)])


def _judged(result: UpdateResult) -> bool:
    """Whether hypotheses were judged against a baseline, so that nothing takes time any more."""
    return isinstance(result, DamageResult) and result.has_baseline


def _parameters(result: UpdateResult, at_once: bool) -> dict[str, Any]:
    problem = result.problem
    columns: dict[str, Any] = dict(zip(("low", "high"), zip(*problem.bounds, strict=True), strict=True))
    columns |= {"value": result.x, "nominal": problem.nominal}
    columns |= {"std": [None] * len(result.x) if at_once else result.std}
    bound = [None if at_once else name in result.at_bound for name in problem.names]
    numbers = {name: map(number, column) for name, column in columns.items()}
    return {"parameters": rows_of(name=problem.names, **numbers, on_bound=bound)}


def _losses(result: DamageResult, at_once: bool) -> dict[str, Any]:
    """The losses of all candidates, and what was judged against a baseline; null without one."""
    judged = result.has_baseline
    limits = result.interval if judged else {}
    chance = result.probability if judged else {}
    seen = {} if at_once else result.detectable
    elements = result.severity.keys()
    probable = [one for one in (result.hypotheses if judged else ()) if one.probability >= _LEAST]
    figures = ("probability_of_damage", "probability_elsewhere", "chi_square")
    own = {"elements": "elements", "probability": "probability", "stiffness_loss": "severities"}
    own |= {"low_90": "low", "high_90": "high", "candidate": "candidate"}
    columns = {key: [getattr(one, name) for one in probable] for key, name in own.items()}
    rows = rows_of(name=[result.hypotheses.called(one) for one in probable], **columns) if judged else None
    return {
        "headline": result.headline if judged else None,
        **{name: number(getattr(result, name)) if judged else None for name in figures},
        "hypotheses": rows,
        "damaged": result.damaged,
        "elements": rows_of(
            element=elements,
            name=map(result.problem.model.element_label, elements),
            stiffness_loss=map(number, result.severity.values()),
            std=map(number, [None] * len(elements) if at_once else result.std),
            probability=[chance.get(e) for e in elements],
            low_90=[limits.get(e, (None, None))[0] for e in elements],
            high_90=[limits.get(e, (None, None))[1] for e in elements],
            smallest_visible=[number(seen.get(e)) for e in elements],
        ),
    }


# -- A job from its beginning to its files


def run(job: Job, args: argparse.Namespace, *, resume: bool = False, fresh: bool = False) -> int:
    """Carry out a job, write its files, and say what came out."""
    begun = time.perf_counter()
    folder = RunFolder.of(job)
    with heard() as texts:
        result, record, measured, evidence = _searched(job, folder, args.workers, resume, fresh, texts)
        beside = beside_of(folder, result, record)
        seconds = round(time.perf_counter() - begun, 3)
        summary = summary_of(job, result, record, measured, beside, seconds)
        folder.forget_results()
        result.save(folder.result)
        write_json(folder.summary, summary)
        write_json(folder.record, record | {"state": result.status})
        note = None
        if result.status != "interrupted":
            note = draw(job, result, folder, evidence, beside)
            if not out_of_time(result):
                # The last step: as long as it waits, resume makes up for whatever is missing.
                folder.checkpoint.unlink(missing_ok=True)
    also = "" if beside is None else f"\n\nMeasured modes, which were not fitted:\n{beside}"
    show(args.json, summary, f"{text_of(result)}{also}\n\nIn {near(folder.folder)}: {folder.contents}")
    if note is not None:
        hint(f"warning: {note}")
    if result.status == "interrupted":
        then = f"go on with: antires resume {near(job.path)}"
        anew = f"without a checkpoint; begin anew with: antires {job.task} {near(job.path)}"
        hint(f"interrupted, the best so far is kept; {then if folder.unfinished else anew}")
        return 130
    if folder.unfinished:
        hint(f"out of time; go on with: antires resume {near(job.path)}")
    return 0


def _searched(
    job: Job, folder: RunFolder, workers: int | None, resume: bool, fresh: bool, texts: list[str]
) -> tuple[UpdateResult, dict[str, Any], list[Measurement], Evidence]:
    """The result of the search, what is recorded of the run, and what was measured."""
    check_options(job)
    _check_folder(job, folder, resume, fresh)
    ga, seed, threads = search_of(job, workers)
    model = model_of(job)
    changing = parameters_of(job, model)
    measured = measured_of(job, model)
    intact = baseline_of(job, model)
    modes = modes_of(job, model)
    inputs = {_relative(file, job.path.parent): _sha256(file) for file in _inputs(job, measured + intact)}
    if resume:
        _check_inputs(job, folder, inputs)
    sets: list[Any] = _sets(measured, folder, "antiresonances", resume) or modes
    before: list[Any] = _sets(intact, folder, "baseline", resume)
    before = before or modes_of(job, model, ("damage", "baseline"))
    found: Any = sets[0] if len(sets) == 1 else sets
    search: Callable[..., UpdateResult]
    if job.task == "damage":
        search = damage_search(job, model, found, before)
    else:
        parameters, places = changing
        of = ("data",) if job.data else ("measured",)
        elsewhere: dict[str, Any] = {"measured": of, "parameters": places, "sections": ("parameters",)}
        with job.blame(("updating",), elsewhere):
            problem = UpdatingProblem(model, parameters, found, **job.sections["updating"])
        search = partial(update, problem)
    folder.folder.mkdir(parents=True, exist_ok=True)  # a job that cannot run leaves nothing behind
    if not resume:  # until another run has its own record nothing here speaks for it
        folder.record.unlink(missing_ok=True)
    if fresh:
        folder.checkpoint.unlink(missing_ok=True)
    read = {file.resolve() for file in _inputs(job, measured + intact)}
    fitted = [("antiresonances", sets)] if job.data else []
    for what, each in (*fitted, ("baseline", before), ("modes", modes)):
        for i, one in enumerate(each):
            if (file := folder.numbered(what, i)).resolve() not in read:
                one.save(file)
    evidence = Evidence(tuple(each.found.diagrams for each in measured), _response(job, measured))
    if evidence:
        evidence.save(folder.evidence)
    else:
        folder.evidence.unlink(missing_ok=True)  # of another run
    facts = {key: [{"File": [name]} for _, name in files] for key, files in modal_files(job).items()}
    known: list[Any] = measurement_of(intact) or facts.get(("damage", "baseline"), [])
    record = {
        "job": _relative(job.path, folder.folder),
        "task": job.task,
        "seed": seed,
        "inputs": inputs,
        "state": "searching",
        "title": job.sections["output"].get("title"),
        "measurement": measurement_of(measured) or facts[("measured", "modes")],
        "modes": [folder.numbered("modes", i).name for i in range(len(modes))],
        "baseline": [f | parts.of_set(b, model) for f, b in zip(known, before, strict=True)],
        "warnings": texts,
        "versions": versions(),
    }
    write_json(folder.record, record)
    say("judging hypotheses" if before else "searching")
    kept = folder.checkpoint if job.sections["search"].get("checkpoint", True) else None
    at = {"checkpoint": ("output", "folder"), "rng": ("search", "seed"), "baseline": ("damage", "baseline")}
    with job.blame(("search",), at):
        result = search(optimizer=ga, rng=seed, workers=threads, checkpoint=kept)
    return result, record, measured, evidence


def _check_folder(job: Job, folder: RunFolder, resume: bool, fresh: bool) -> None:
    """Refuse a folder that this run may not use."""
    name, place = folder.folder.name, ("output", "folder")
    if folder.unfinished and not (resume or fresh):
        got = f"{name!r}, where a search of this job waits that did not finish"
        remedy = f"Go on with 'antires resume {job.path.name}', or begin anew with --fresh."
        job.reject(place, got, "a folder without one", remedy)
    # Killed before the first checkpoint, a search begins again with the sets that it had.
    if resume and not (folder.unfinished or folder.read_record().get("state") == "searching"):
        remedy = f"Begin with 'antires {job.task} {job.path.name}'."
        job.reject(place, f"{name!r}, where no search waits", "a search that did not finish", remedy)


def _check_inputs(job: Job, folder: RunFolder, inputs: dict[str, str]) -> None:
    """Refuse to go on with files that are not what they were."""
    # What changed in the job itself the checkpoint finds, as far as it matters to the search.
    before = folder.read_record().get("inputs", {}).items()
    changed = [name for name, digest in before if inputs.get(name, digest) != digest]
    if changed := [name for name in changed if name != job.path.name]:
        got = f"{', '.join(changed)}, changed since the search began"
        remedy = f"Put them back, or begin anew with 'antires {job.task} {job.path.name} --fresh'."
        raise UnsuitableDataError("JOB", got, "the files as they were", remedy)


def _sets(measured: list[Measurement], folder: RunFolder, what: str, resume: bool) -> list[AntiresonanceSet]:
    """The sets of a search: those that it began with, bit for bit, whatever libraries are here now."""
    sets = [each.found for each in measured]
    for i, found in enumerate(sets):
        file = folder.numbered(what, i)
        # The one just identified carries its diagrams, for the report.
        if resume and file.is_file() and (kept := AntiresonanceSet.load(file)) != found:
            sets[i] = kept
    return sets


def _inputs(job: Job, measured: list[Measurement]) -> list[Path]:
    """Every file that the numbers depend on."""
    model = job.sections["model"]
    named = [job.file(model[key]) for key in ("file", "stiffness", "mass", "dof_map") if key in model]
    terms = [file for files in term_files(job).values() for file in files]
    signals: list[Path] = []
    for path in (path for each in measured for path in (each.file, *each.repeats)):
        signals += filter(Path.is_file, [path] if path.is_file() else sorted(path.iterdir()))
    modal = [name for files in modal_files(job).values() for _, name in files]
    return [job.path, *signals, *named, *terms, *map(job.file, modal)]


def beside_of(folder: RunFolder, result: UpdateResult, record: dict[str, Any]) -> ModalTable | None:
    """The modes that a run kept, beside those of the model, where they were not fitted."""
    files = [folder.folder / Path(name).name for name in record.get("modes", ())]
    if result.problem.objective == "modal" or not files:
        return None
    return result.modes_beside([ModalSet.load(file) for file in files])


def _relative(file: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(file.absolute(), folder.absolute())).as_posix()
    except ValueError:  # another drive
        return file.absolute().as_posix()


def near(path: Path) -> str:
    """A path as the user would write it."""
    relative = os.path.relpath(path)
    return relative if not relative.startswith("..") else str(path)


def out_of_time(result: UpdateResult) -> bool:
    """Whether max_seconds ended the search, so that it could go on."""
    return result.status == "callback" or (result.status == "budget" and "time" in result.message)


# -- Report and pictures of a run


def draw(
    job: Job, result: UpdateResult, folder: RunFolder, evidence: Evidence, beside: ModalTable | None
) -> str | None:
    """Write what the job asks for; what is left out for want of a package is returned as a note."""
    output = job.sections["output"]
    try:
        drawn = drawings(result, evidence, beside)
        if output.get("report", True):
            say("writing the report")
            report(result, folder.report, folder, drawn, output.get("title"))
        if output.get("pictures", True):
            say("drawing the pictures")
            folder.pictures.mkdir(exist_ok=True)
            pictures(drawn, folder.pictures)
    except MissingDependencyError as exc:
        return str(exc)
    return None


def drawings(result: UpdateResult, evidence: Evidence, beside: ModalTable | None) -> parts.Drawings:
    """Pictures for the report and the folder, each drawn once."""
    shown = None
    if any(evidence.diagrams):
        forces = [each.excitation for each in result.problem.measured]
        shown = parts.named_diagrams(evidence.diagrams, forces, result.problem.model)
    return parts.drawings_of(result, evidence.response, diagrams=shown, beside=beside)


def report(
    result: UpdateResult, file: Path, folder: RunFolder, drawn: parts.Drawings, title: str | None
) -> None:
    """Write the report of a result with what its folder knows of the run, and what repeats it."""
    from ..figures.report import write_report

    record = folder.read_record()
    about = record.get("measurement")
    origin: dict[str, str | list[str]] = {}
    if {"job", "task", "inputs"} <= record.keys():
        command = f"antires {record['task']} {Path(record['job']).name}"
        origin["Repeat with"] = [command, "in the folder of that file"]
        origin["Files, SHA-256"] = [f"{name}  {digest}" for name, digest in record["inputs"].items()]
        origin["Run with"] = ", ".join(f"{what} {one}" for what, one in record.get("versions", {}).items())
    write_report(
        result,
        file,
        title=title or record.get("title"),
        origin=origin,
        measurement=about if about and len(about) == len(result.problem.measured) else None,
        warnings=record.get("warnings"),
        baseline=record.get("baseline"),
        drawn=drawn,
    )


def evidence_in(folder: RunFolder, result: UpdateResult) -> Evidence:
    """What the run of a folder kept beside its result; nothing where no job ran or the file is damaged."""
    if not folder.evidence.is_file():
        return Evidence()
    try:
        kept = Evidence.load(folder.evidence)
    except UnsuitableDataError as exc:
        warn("report_without_diagrams", f"the report has no diagrams: {exc}")
        return Evidence()
    return kept if len(kept.diagrams) == len(result.problem.measured) else Evidence()


def pictures(drawn: parts.Drawings, folder: Path) -> list[Path]:
    """Write every picture as PNG; returns the files."""
    named = {**drawn.figures, **{f"stabilization_{name}": one for name, one in drawn.diagrams.items()}}
    return [write_atomically(folder / picture_name(name), one.png) for name, one in named.items()]
