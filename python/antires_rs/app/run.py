"""Carry out a job: measurement, model, search, files."""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
import re
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .._core import __version__
from ..damage.assess import DamageResult
from ..exceptions import MissingDependencyError, UnsuitableDataError
from ..figures.report_parts import (
    Drawings,
    drawings_of,
    named_diagrams,
    of_evidence,
    of_identification,
    of_set,
    of_signal,
)
from ..identification.stabilization import StabilizationDiagram
from ..io.archive import Store, read_store, write_store
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.response_table import ResponseTable
from ..models.structural_model import StructuralModel
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.files import write_atomically
from ..support.messages import warn
from ..updating.problem import UpdatingProblem
from ..updating.result import UpdateResult
from ..updating.tables import FrequencyTable
from ..updating.update import update
from .arguments import damage_search, model_of, parameters_of, search_of, term_files
from .job import Job
from .reading import Measured, baseline_of, check_options, measured_of

# -- The folder of a run: what is in it, what was left by one that was killed


class RunFolder:
    """Names and places of everything that a run writes.

    Attributes
    ----------
    folder, result, summary, report, pictures, checkpoint, record, evidence : pathlib.Path
        ``record`` says which job runs here, from the beginning of the search on.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.result, self.summary = folder / "result.npz", folder / "summary.json"
        self.report, self.pictures = folder / "report.html", folder / "pictures"
        self.checkpoint, self.record = folder / "search.ckpt", folder / "run.json"
        self.evidence = folder / "evidence.npz"

    @classmethod
    def of(cls, job: Job) -> RunFolder:
        """The folder that a job names; ``<job>_results`` beside it by default."""
        name = job.section("output").get("folder")
        return cls(job.file(name) if name else job.path.with_name(f"{job.path.stem}_results"))

    def antiresonances(self, number: int) -> Path:
        """File of the identified set of one [data], numbered from 0."""
        return self.folder / (f"antiresonances_{number}.json" if number else "antiresonances.json")

    def baseline(self, number: int) -> Path:
        """File of a set of the intact structure, numbered from 0."""
        return self.folder / (f"baseline_{number}.json" if number else "baseline.json")

    def prepare(self) -> None:
        """Make the folder; remove what a process that was killed left half-written."""
        self.folder.mkdir(parents=True, exist_ok=True)
        for folder in (self.folder, self.pictures):
            if folder.is_dir():
                for file in folder.iterdir():
                    if _HALF_WRITTEN.fullmatch(file.name):
                        file.unlink(missing_ok=True)

    @property
    def unfinished(self) -> bool:
        """Whether a search waits here to be taken up again."""
        return self.checkpoint.exists() or self._previous.exists()

    @property
    def state(self) -> str | None:
        """How the last run ended, or "searching"; None where none has begun."""
        return (self.read_record() or {}).get("state")

    @property
    def _previous(self) -> Path:
        return self.checkpoint.with_name(self.checkpoint.name + ".previous")

    def forget_search(self) -> None:
        """Remove the checkpoint; the result holds all of it."""
        for file in (self._previous, self.checkpoint):  # a kill in between leaves the later one
            file.unlink(missing_ok=True)

    def forget_record(self) -> None:
        """Remove the record: another run begins, and until it has its own, nothing here speaks for it."""
        self.record.unlink(missing_ok=True)

    def forget_results(self) -> None:
        """Remove what an earlier run drew, so that nothing stale stands beside a new result."""
        pictures = [file for file in self.pictures.glob("*.png") if _PICTURE.fullmatch(file.name)]
        for file in (self.result, self.summary, self.report, *pictures):
            file.unlink(missing_ok=True)

    def write_json(self, file: Path, data: dict[str, Any]) -> None:
        """Write as JSON; numbers that JSON does not know must be null already."""
        write_atomically(file, (json.dumps(data, indent=1, allow_nan=False) + "\n").encode())

    def read_record(self) -> dict[str, Any] | None:
        """What runs or ran here; None where no job did."""
        try:
            data = json.loads(self.record.read_text(encoding="utf-8"))
        except (FileNotFoundError, NotADirectoryError):
            return None
        except ValueError:
            return {}
        return data if isinstance(data, dict) else {}

    def job_path(self, record: dict[str, Any]) -> Path:
        """The job file of a record: relative to the folder, so that both may be moved together."""
        return Path(os.path.normpath(self.folder / str(record.get("job", ""))))


#: As write_atomically and Checkpoint name what is not whole yet.
_HALF_WRITTEN = re.compile(
    r"\.((antiresonances|baseline)(_\d+)?\.json|(result|evidence)\.npz|(summary|run)\.json|"
    r"report\.html|\w+\.png)\.\d+\.tmp|search\.ckpt\.tmp"
)
_PICTURE = re.compile(r"(differences|convergence|damage|hypotheses|model|response|stabilization_.*)\.png")


def picture_name(name: str) -> str:
    """File of a picture; names of channels may hold what no file's may."""
    return re.sub(r"[^\w.+-]+", "_", name) + ".png"


def sha256_of(file: Path) -> str:
    """Checksum of a file's bytes."""
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
_CURVES = ("orders", "background_freq_hz", "background")
_TABLES = ("accepted", "left_out")


@dataclass(frozen=True)
class Evidence:
    """Pictures' numbers of a run.

    Attributes
    ----------
    diagrams : tuple of mapping of dof to StabilizationDiagram
        One mapping for each [data].
    response : FrequencyResponse or None
        Transmissibilities over the first response that has antiresonances; of measured FRFs themselves.
    """

    diagrams: tuple[Mapping[Any, StabilizationDiagram], ...] = ()
    response: FrequencyResponse | None = field(default=None)

    def __bool__(self) -> bool:
        return self.response is not None or any(self.diagrams)

    def save(self, path: Path) -> None:
        """Write it, whole or not at all."""
        store = Store()
        data = {
            "format": FORMAT,
            "version": VERSION,
            "diagrams": [
                [[dof, _described(diagram, store)] for dof, diagram in table.items()]
                for table in self.diagrams
            ],
            "response": None,
        }
        if self.response is not None:
            r = self.response
            # Drawn in decibels: half the digits are more than the eye can see.
            data["response"] = {
                "freq_hz": store.put(r.freq_hz),
                "dofs": list(r.dofs),
                "values": store.put(r.values.astype(np.complex64)),
                "kind": r.kind,
                "reference": r.reference,
            }
        write_store(path, data, store)

    @classmethod
    def load(cls, path: Path) -> Evidence:
        """Read it."""
        _, data = read_store(path, FORMAT, VERSION, "the evidence.npz of a run")
        tables = tuple({dof: _made(diagram) for dof, diagram in table} for table in data["diagrams"])
        r = data["response"]
        return cls(
            tables,
            None
            if r is None
            else FrequencyResponse(
                r["freq_hz"], r["values"], r["dofs"], r.get("kind", "transmissibility"), r["reference"]
            ),
        )


def evidence_of(job: Job, measured: list[Measured]) -> Evidence:
    """What the sets of a run carry."""
    return Evidence(tuple(m.found.diagrams for m in measured), _response(job, measured))


def measurement_of(job: Job, measured: list[Measured]) -> list[dict[str, list[str]]]:
    """What was measured and how it was identified, in words, for each measurement."""
    facts = []
    for each in measured:
        table = each.table
        own = {"File": [path.name for path in (each.file, *each.repeats)]}
        if isinstance(table.get("dofs"), dict):
            own["Dofs"] = [
                f"{name} = {'left out' if dof is False else dof}" for name, dof in table["dofs"].items()
            ]
        if each.signal is not None:
            own |= of_signal(each.signal)
            own["Unit"] = [
                f"{table['unit']} in the file, here SI"
                if table.get("unit")
                else "SI (m/s2 for accelerations); what the file names otherwise was converted"
            ]
            own |= of_identification(each.signal, each.found)
        facts.append(own | of_evidence(each.found))
    return facts


@contextmanager
def heard() -> Iterator[list[str]]:
    """Every warning that is raised inside, while it is shown as ever."""
    said: list[str] = []
    with warnings.catch_warnings():
        show = warnings.showwarning

        def keep(message: Warning | str, *rest: Any, **named: Any) -> None:
            if str(message) not in said:
                said.append(str(message))
            show(message, *rest, **named)

        warnings.showwarning = keep
        yield said


def _described(diagram: StabilizationDiagram, store: Store) -> dict[str, Any]:
    """A diagram as arrays: the rows of all orders in one."""
    return {
        "band_hz": list(diagram.band_hz),
        "counts": store.put(np.array([len(row) for row in diagram.freq_hz], dtype=np.int64)),
        **{name: store.put(np.concatenate([np.empty(0), *getattr(diagram, name)])) for name in _ROWS},
        **{name: store.put(getattr(diagram, name)) for name in _CURVES},
        **{
            table: {name: store.put(values) for name, values in _columns(getattr(diagram, table)).items()}
            for table in _TABLES
        },
        "unexplained_hz": store.put(diagram.unexplained_hz),
    }


def _columns(table: ResponseTable) -> dict[str, Any]:
    return {**{name: getattr(table, name) for name in _COLUMNS}, **table.scores}


def _made(data: dict[str, Any]) -> StabilizationDiagram:
    ends = np.cumsum(data["counts"])[:-1]
    freq, damping, stable = (tuple(np.split(data[name], ends)) for name in _ROWS)
    low, high = data["band_hz"]
    # Files of older versions do not have what was not accepted.
    accepted, left_out = (_table(data[name]) if name in data else ResponseTable([]) for name in _TABLES)
    return StabilizationDiagram(
        data["orders"],
        freq,
        damping,
        tuple(row.astype(bool) for row in stable),
        accepted,
        data["background_freq_hz"],
        data["background"],
        (low, high),
        left_out,
        data.get("unexplained_hz", np.empty(0)),
    )


def _table(columns: Mapping[str, Any]) -> ResponseTable:
    scores = dict(columns)
    hz, zeta, std = (scores.pop(name) for name in _COLUMNS)
    return ResponseTable(hz, zeta, std, scores)


def _response(job: Job, measured: list[Measured]) -> FrequencyResponse | None:
    """Transmissibilities over the first response that has antiresonances, where they can be had."""
    first = measured[0]
    if isinstance(first.signal, FrequencyResponse):
        return _inside(first.signal, *job.data[0]["band_hz"])
    dof = next((dof for dof, values in first.found.items() if values.size), None)
    if not isinstance(first.signal, Recording) or dof is None or first.signal.n_channels < 2:
        return None
    from ..signals.averaging import choose_nperseg
    from ..signals.transfer_functions import transmissibility

    try:
        length = job.section("identification").get("nperseg") or choose_nperseg(
            first.signal, job.data[0]["band_hz"]
        )
        whole = transmissibility(first.signal, dof, nperseg=length, estimator="rank1")
    except UnsuitableDataError:  # a single impact has no averages
        return None
    return _inside(whole, *job.data[0]["band_hz"])


def _inside(whole: FrequencyResponse, low: float, high: float) -> FrequencyResponse:
    """The band that was searched."""
    keep = (whole.freq_hz >= low) & (whole.freq_hz <= high)
    return FrequencyResponse(
        whole.freq_hz[keep], whole.values[:, keep], whole.dofs, whole.kind, whole.reference
    )


# -- A run in numbers, ready for JSON, and in words for the terminal


#: Hypotheses below this probability are left out.
_LEAST = 1e-6


def number(value: Any) -> float | None:
    """A number as JSON knows it; None where there is none."""
    plain = float(value)
    return plain if math.isfinite(plain) else None


def summary_of(
    job: Job, result: UpdateResult, record: dict[str, Any], measured: list[Measured], seconds: float
) -> dict[str, Any]:
    """All numbers of a run, and what repeats it.

    What the data cannot tell takes seconds on a large model, so it is left out, as null, after Ctrl-C.
    """
    table = result.table
    at_once = result.status == "interrupted" and not _judged(result)
    checks = [m.found.data_check for m in measured if m.found.data_check is not None]
    return {
        "antires_rs": record["versions"]["antires_rs"],
        "task": job.task,
        "job": job.path.name,
        "command": f"antires {job.task} {job.path.name}",
        "seed": result.seed,
        "inputs": record["inputs"],
        "versions": record["versions"],
        "seconds": seconds,
        "status": result.status,
        "message": result.message,
        "finished": result.success,
        "J": number(result.fun),
        "evaluations": result.nfev,
        "linearizations": result.njev,
        "generations": result.nit,
        "exchanges": result.migrations,
        **_values(result, at_once),
        # As in Python: "dof", "element" and the numbers in names count from 0.
        "counted_from": 0,
        "largest_before_percent": number(table.largest_before_percent),
        "largest_after_percent": number(table.largest_after_percent),
        "antiresonances": _rows(table) if isinstance(table, FrequencyTable) else [],
        # Those of the data check have been raised as one.
        "warnings": [
            *(said for check in checks for said in check.warnings),
            *(said for said in record["warnings"] if not said.startswith("data check: ")),
        ],
        "notes": [] if at_once else result.notes,
    }


def text_of(result: UpdateResult) -> str:
    """A run in words; after Ctrl-C without the notes that take time."""
    if result.status != "interrupted" or _judged(result):
        return result.summary()
    head = f"J = {result.fun:.6g} after {result.nfev:,} evaluations: interrupted, the best so far"
    width = max(map(len, result.problem.names))
    loss = isinstance(result, DamageResult)
    values = [
        f"{name:<{width}}  {f'{100 * value:6.2f} %' if loss else f'{value:#12.6g}'}"
        for name, value in zip(result.problem.names, result.x, strict=True)
        if value != 0.0 or not loss
    ]
    return "\n".join([head, "", *values, "", str(result.table)])


def _judged(result: UpdateResult) -> bool:
    """Whether hypotheses were judged against a baseline, so that nothing takes time any more."""
    return isinstance(result, DamageResult) and result.has_baseline


def _values(result: UpdateResult, at_once: bool) -> dict[str, Any]:
    std = [None] * len(result.x) if at_once else [number(value) for value in result.std]
    if isinstance(result, DamageResult):
        label = result.problem.model.element_label
        judged = result.has_baseline
        chance = result.probability if judged else {}
        limits = result.interval if judged else {}
        seen = {} if at_once else result.detectable
        return {
            **_hypotheses(result, judged),
            "damaged": result.damaged,
            "elements": [
                {
                    "element": e,
                    "name": label(e),
                    "stiffness_loss": number(beta),
                    "std": own,
                    "probability": chance.get(e),
                    "low_90": limits.get(e, (None, None))[0],
                    "high_90": limits.get(e, (None, None))[1],
                    "smallest_visible": number(seen.get(e, math.nan)),
                }
                for (e, beta), own in zip(result.severity.items(), std, strict=True)
            ],
        }
    on_bound = None if at_once else set(result.at_bound)
    columns = zip(
        result.problem.names, result.x, result.problem.nominal, std, result.problem.bounds, strict=True
    )
    return {
        "parameters": [
            {
                "name": name,
                "value": number(value),
                "nominal": number(nominal),
                "std": own,
                "low": number(low),
                "high": number(high),
                "on_bound": None if on_bound is None else name in on_bound,
            }
            for name, value, nominal, own, (low, high) in columns
        ]
    }


def _hypotheses(result: DamageResult, judged: bool) -> dict[str, Any]:
    """What was judged against a baseline; null without one."""
    found = result.hypotheses if judged else None
    return {
        "headline": result.headline if judged else None,
        "probability_of_damage": number(result.probability_of_damage) if judged else None,
        "probability_elsewhere": number(result.probability_elsewhere) if judged else None,
        "chi_square": number(result.chi_square) if judged else None,
        "hypotheses": None
        if found is None
        else [
            {
                "name": found.called(one),
                "elements": list(one.elements),
                "probability": one.probability,
                "stiffness_loss": list(one.severities),
                "low_90": list(one.low),
                "high_90": list(one.high),
                "candidate": one.candidate,
            }
            for one in found
            if one.probability >= _LEAST
        ],
    }


def _rows(table: FrequencyTable) -> list[dict[str, Any]]:
    columns = zip(
        table.excitation, table.dof, table.measured_hz, table.before_hz, table.after_hz, strict=True
    )
    return [
        {
            "excitation": int(force),
            "dof": int(dof),
            "measured_hz": number(measured),
            "before_hz": number(before),
            "after_hz": number(after),
        }
        for force, dof, measured, before, after in columns
    ]


Say = Callable[[str], Any]


@dataclass
class Outcome:
    """What a job came to.

    Attributes
    ----------
    result : UpdateResult
    folder : RunFolder
    summary : dict
    notes : list of str
        What was not written, and why.
    """

    result: UpdateResult
    folder: RunFolder
    summary: dict[str, Any]
    notes: list[str] = field(default_factory=list)

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the search."""
        return self.result.status == "interrupted"


def run(
    job: Job,
    *,
    resume: bool = False,
    fresh: bool = False,
    workers: int | None = None,
    say: Say = str,
    progress: bool | None = None,
) -> Outcome:
    """Carry out a job and write its files."""
    with heard() as said:
        return _carried_out(job, said, resume, fresh, workers, say, progress)


def _carried_out(
    job: Job, said: list[str], resume: bool, fresh: bool, workers: int | None, say: Say, progress: bool | None
) -> Outcome:
    import scipy  # slow to load

    begun = time.perf_counter()
    check_options(job)
    folder = _checked(job, resume, fresh)
    ga, seed, threads = search_of(job, workers)
    model = model_of(job)
    parameters, places = parameters_of(job, model)
    measured = measured_of(job, model, say)
    intact = baseline_of(job, model, say)
    inputs = {_named(job, file): sha256_of(file) for file in _inputs(job, [*measured, *intact])}
    sets, before = ([m.found for m in each] for each in (measured, intact))
    if resume:
        _same_inputs(job, folder, inputs)
        sets = _kept_sets(measured, folder.antiresonances)
        before = _kept_sets(intact, folder.baseline)
    search = _search(job, model, (parameters, places), sets[0] if len(sets) == 1 else sets, before)
    folder.prepare()  # not before: a job that cannot run leaves nothing behind
    if not resume:
        folder.forget_record()
    if fresh:
        folder.forget_search()
    _keep(sets, measured, folder.antiresonances)
    _keep(before, intact, folder.baseline)
    evidence = evidence_of(job, measured)
    if evidence:
        evidence.save(folder.evidence)
    else:
        folder.evidence.unlink(missing_ok=True)  # of another run
    record = {
        "job": _relative(job.path, folder.folder),
        "task": job.task,
        "seed": seed,
        "inputs": inputs,
        "state": "searching",
        "title": job.section("output").get("title"),
        "measurement": measurement_of(job, measured),
        "baseline": [
            facts | of_set(each, model)
            for facts, each in zip(measurement_of(job, intact), before, strict=True)
        ],
        "warnings": said,
        "versions": {
            "antires_rs": __version__,
            "numpy": np.__version__,
            "scipy": scipy.__version__,
            "python": platform.python_version(),
            "system": platform.platform(),
        },
    }
    folder.write_json(folder.record, record)
    say("judging hypotheses" if before else "searching")
    kept = folder.checkpoint if job.section("search").get("checkpoint", True) else None
    with job.blame(("search",), {"checkpoint": ("output", "folder"), "rng": ("search", "seed")}):
        result = search(optimizer=ga, rng=seed, workers=threads, checkpoint=kept, progress=progress)
    seconds = round(time.perf_counter() - begun, 3)
    summary = summary_of(job, result, record, measured, seconds)
    outcome = Outcome(result, folder, summary)
    folder.forget_results()
    result.save(folder.result)
    folder.write_json(folder.summary, summary)
    record["state"] = result.status
    folder.write_json(folder.record, record)
    if outcome.interrupted:
        return outcome

    outcome.notes = draw(job, result, folder, evidence, say)
    if not out_of_time(result):
        folder.forget_search()  # last: as long as it waits, resume makes up for whatever is missing
    return outcome


def _checked(job: Job, resume: bool, fresh: bool) -> RunFolder:
    """The folder, if this run may use it."""
    folder = RunFolder.of(job)
    place = ("output", "folder")
    if folder.folder.exists() and not folder.folder.is_dir():
        job.reject(place, f"{str(folder.folder)!r}, which is a file", "a folder", "Name another one.")
    if folder.folder.resolve() == Path(folder.folder.resolve().anchor):
        job.reject(place, repr(str(folder.folder)), "a folder of this job's own", "Name one below it.")
    record = folder.read_record()
    if record and folder.job_path(record).resolve() != job.path.resolve():
        job.reject(
            place,
            f"{folder.folder.name!r}, which holds the results of {record.get('job')}",
            "a folder of this job's own",
            'Name one under [output], folder = "...".',
        )
    if folder.unfinished and not (resume or fresh):
        job.reject(
            place,
            f"{folder.folder.name!r}, where a search of this job waits that did not finish",
            "a folder without one",
            f"Go on with 'antires resume {job.path.name}', or begin anew with --fresh.",
        )
    # Killed before the first checkpoint, a search begins again with the sets that it had.
    if resume and not (folder.unfinished or folder.state == "searching"):
        job.reject(
            place,
            f"{folder.folder.name!r}, where no search waits",
            "a search that did not finish",
            f"Begin with 'antires {job.task} {job.path.name}'.",
        )
    return folder


def _search(
    job: Job, model: StructuralModel, parameters: Any, measured: Any, baseline: list[AntiresonanceSet]
) -> Callable[..., UpdateResult]:
    """The search of the job, its problem found valid."""
    if job.task == "damage":
        return damage_search(job, model, measured, baseline)
    made, places = parameters
    with job.blame(("updating",), {"measured": ("data",), "parameters": places, "sections": ("parameters",)}):
        return partial(update, UpdatingProblem(model, made, measured, **job.section("updating")))


def _same_inputs(job: Job, folder: RunFolder, inputs: dict[str, str]) -> None:
    """Refuse to go on with files that are not what they were."""
    record = folder.read_record() or {}
    # What changed in the job itself the checkpoint finds, as far as it matters to the search.
    changed = [
        name
        for name, digest in record.get("inputs", {}).items()
        if name != job.path.name and inputs.get(name, digest) != digest
    ]
    if changed:
        raise UnsuitableDataError(
            "JOB",
            f"{', '.join(changed)}, changed since the search began",
            "the files as they were",
            f"Put them back, or begin anew with 'antires {job.task} {job.path.name} --fresh'.",
        )


def _kept_sets(measured: list[Measured], file_of: Callable[[int], Path]) -> list[AntiresonanceSet]:
    """The sets that the search began with, bit for bit, whatever libraries are here now."""
    sets = []
    for i, each in enumerate(measured):
        file = file_of(i)
        kept = AntiresonanceSet.load(file) if file.is_file() else each.found
        same = kept == each.found
        # The one just identified carries its diagrams, for the report.
        sets.append(each.found if same else kept)
    return sets


def _keep(sets: list[AntiresonanceSet], measured: list[Measured], file_of: Callable[[int], Path]) -> None:
    """Write the sets, unless they were read from there."""
    for i, each in enumerate(sets):
        if file_of(i).resolve() != measured[i].file.resolve():
            each.save(file_of(i))


def _inputs(job: Job, measured: list[Measured]) -> list[Path]:
    """Every file that the numbers depend on."""
    model = job.section("model")
    named = [job.file(model[key]) for key in ("file", "stiffness", "mass", "dof_map") if key in model]
    terms = [
        file
        for key in ("stiffness_terms", "mass_terms")
        if key in model
        for file in term_files(job, key, model[key])
    ]
    read = [path for m in measured for path in (m.file, *m.repeats)]
    signals = [
        p for path in read for p in ([path] if path.is_file() else sorted(path.iterdir())) if p.is_file()
    ]
    return [job.path, *signals, *named, *terms]


def _named(job: Job, file: Path) -> str:
    return _relative(file, job.path.parent)


def _relative(file: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(file.absolute(), folder.absolute())).as_posix()
    except ValueError:  # another drive
        return file.absolute().as_posix()


def out_of_time(result: UpdateResult) -> bool:
    """Whether max_seconds ended the search, so that it could go on."""
    return result.status == "callback" or (result.status == "budget" and "time" in result.message)


# -- Report and pictures of a run


def draw(
    job: Job, result: UpdateResult, folder: RunFolder, evidence: Evidence, say: Callable[[str], Any]
) -> list[str]:
    """Write what the job asks for; what is left out for want of a package is returned as a note."""
    output = job.section("output")
    try:
        drawn = drawings(result, evidence)
        if output.get("report", True):
            say("writing the report")
            report(result, folder.report, folder, drawn, output.get("title"))
        if output.get("pictures", True):
            say("drawing the pictures")
            folder.pictures.mkdir(exist_ok=True)
            pictures(drawn, folder.pictures)
    except MissingDependencyError as exc:
        return [str(exc)]
    return []


def drawings(result: UpdateResult, evidence: Evidence) -> Drawings:
    """Pictures for the report and the folder, each drawn once."""
    sets, model = result.problem.measured, result.problem.model
    shown = (
        named_diagrams(evidence.diagrams, [each.excitation for each in sets], model)
        if any(evidence.diagrams)
        else None
    )
    return drawings_of(result, evidence.response, diagrams=shown)


def report(result: UpdateResult, file: Path, folder: RunFolder, drawn: Drawings, title: str | None) -> None:
    """Write the report of a result with what its folder knows of the run."""
    from ..figures.report import write_report

    record = folder.read_record() or {}
    sets = result.problem.measured
    about = record.get("measurement")
    write_report(
        result,
        file,
        title=title or record.get("title"),
        origin=origin_of(folder),
        measurement=about if about and len(about) == len(sets) else None,
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


def origin_of(folder: RunFolder) -> dict[str, str | list[str]]:
    """What repeats the run of a folder, for its report; empty where no job ran."""
    record = folder.read_record() or {}
    if not {"job", "task", "inputs"} <= record.keys():
        return {}
    name = Path(record["job"]).name
    made = ", ".join(f"{what} {version}" for what, version in record.get("versions", {}).items())
    return {
        "Repeat with": [f"antires {record['task']} {name}", "in the folder of that file"],
        "Files, SHA-256": [f"{file}  {digest}" for file, digest in record["inputs"].items()],
        "Run with": made,
    }


def pictures(drawn: Drawings, folder: Path) -> list[Path]:
    """Write every picture as PNG; returns the files."""
    named = {**drawn.figures, **{f"stabilization_{name}": one for name, one in drawn.diagrams.items()}}
    return [write_atomically(folder / picture_name(name), one.png) for name, one in named.items()]
