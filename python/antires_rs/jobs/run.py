"""Carry out a job: measurement, model, search, files."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .._core import __version__
from ..exceptions import UnsuitableDataError
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.structural_model import StructuralModel
from ..report.facts import of_set
from ..updating.problem import UpdatingProblem
from ..updating.results import UpdateResult
from ..updating.search import update
from .baseline import baseline_of, check_options
from .damage import damage_search
from .evidence import evidence_of, heard, measurement_of
from .files import RunFolder, sha256_of
from .job import Job
from .measured import Measured, measured_of
from .model import model_of, term_files
from .summary import summary_of
from .unknowns import parameters_of, search_of

__all__ = ["Outcome", "out_of_time", "run"]

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
    """Carry out a job and write its files.

    Parameters
    ----------
    job : Job
    resume : bool
        Go on from the checkpoint of a run that was interrupted, bit-identical; from the beginning where
        it had none yet.
    fresh : bool
        Begin anew though there is such a checkpoint.
    workers : int, optional
        In place of the job's.
    say : callable
        Receives a line before each stage.
    progress : bool, optional
        Show the line of the search; by default on a terminal.

    Returns
    -------
    Outcome
        Also after Ctrl-C during the search: the best so far, with a checkpoint to go on from.

    Raises
    ------
    InvalidInputError
        The job or its data cannot be used; the message names the line.
    """
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
    from .drawing import draw

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
