"""The intact structure of a job: ``baseline`` of [damage], read and identified as [data] is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from ..models.structural_model import StructuralModel
from .formats import FOLDER, FORMATS, format_of
from .job import Job
from .lines import Path as Keys
from .measured import Measured, files_of, one_measured
from .model import dof_finder
from .values import shown

__all__ = ["baseline_of", "check_options"]

_KEY: Keys = ("damage", "baseline")
#: Keys of [damage] without a baseline, and with one; and those of [search] that count with one.
_ALONE, _TOGETHER, _SEARCH = (
    ("gamma1", "gamma2", "snap", "weights"),
    ("prior", "false_alarm_rate", "std_common"),
    ("seed", "workers"),
)


def check_options(job: Job) -> None:
    """Refuse keys that would have no effect, with a baseline or without one."""
    damage = job.section("damage")
    if "baseline" not in damage:
        for name in _TOGETHER:
            if name in damage:
                job.reject(
                    ("damage", name),
                    f"{name!r} without a baseline",
                    "it beside baseline",
                    "Name the measurement of the intact structure, or remove it.",
                )
        return
    for name in _ALONE:
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
