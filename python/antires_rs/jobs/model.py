"""The model of a job, and the dofs of its channels."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import Any

from .. import io
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.sections import Rectangle, Section, Tube
from ..models.structural_model import StructuralModel
from ..updating.results import UpdateResult
from .job import Job, nearest
from .keys_model import CHAIN, FRAME, MATRICES, RESULT
from .lines import Path as Keys
from .values import shown

__all__ = ["dof_finder", "model_of", "term_files"]

_SHAPES = {"tube": Tube, "rectangle": Rectangle, "general": Section}
_CHAIN = ("masses_kg", "springs_n_per_m", "ground_first_n_per_m", "ground_last_n_per_m")
_FRAME = (
    "nodes_m",
    "elements",
    "sections",
    "point_masses",
    "ground_springs",
    "node_springs",
    "fixed",
    "orientation",
)
_NODE_AND_DIRECTION = re.compile(r"\s*(?:node\s+)?(\d+)[\s.:]+([A-Za-z]+)\s*")


def model_of(job: Job) -> StructuralModel:
    """Build the model.

    Raises
    ------
    InvalidInputError
        What the model's constructor refuses, with the line.
    """
    table = job.section("model")
    kind = table["kind"]
    makers = {CHAIN: _chain, FRAME: _frame, MATRICES: _matrices, RESULT: _result}
    if kind not in makers:
        job.reject(
            ("model", "kind"),
            shown(kind),
            "one of " + ", ".join(f'"{k}"' for k in makers),
            nearest(kind, makers) or "'antires init --model KIND' writes a job for each.",
        )
    job.only(("model",), table, kind)
    with job.blame(("model",), {"path": ("model", "file")}):
        return makers[kind](job)


def _require(job: Job, *keys: str) -> None:
    for key in keys:
        if key not in job.section("model"):
            job.missing(("model",), key)


def _chain(job: Job) -> StructuralModel:
    _require(job, "masses_kg", "springs_n_per_m")
    return MassSpringChain(**job.given("model", _CHAIN))


def _frame(job: Job) -> StructuralModel:
    _require(job, "nodes_m", "elements", "sections")
    given = job.given("model", _FRAME)
    for i, row in enumerate(given["elements"]):
        if not isinstance(row, list):
            job.reject(
                ("model", "elements", i),
                shown(row),
                '[node, node] or [node, node, "section"]',
                "Each beam is a list of its own, inside the list of all.",
            )
    sections = {name: _section(job, name, parts) for name, parts in given.pop("sections").items()}
    # One section needs no name in each element.
    named = any(len(row) == 3 for row in given["elements"])
    chosen = sections if named or len(sections) > 1 else next(iter(sections.values()))
    return FrameModel(given.pop("nodes_m"), given.pop("elements"), chosen, **given)


def _section(job: Job, name: str, parts: Any) -> Tube | Rectangle | Section:
    place: Keys = ("model", "sections", name)
    remedy = (
        'As in pipe = { shape = "tube", outer_diameter_m = 0.05, thickness_m = 0.002, '
        "youngs_modulus_pa = 2.1e11, density_kg_per_m3 = 7850 }."
    )
    if not isinstance(parts, dict) or parts.get("shape") not in _SHAPES:
        got = shown(parts.get("shape")) if isinstance(parts, dict) else shown(parts)
        job.reject(place, got, "a table with shape = " + ", ".join(f'"{s}"' for s in _SHAPES), remedy)
    made = _SHAPES[parts["shape"]]
    known = {f.name: f for f in fields(made)}
    for key in parts:
        if key != "shape" and key not in known:
            job.reject(
                (*place, key),
                f"the unknown key {key!r}",
                "one of " + ", ".join(known),
                nearest(key, known) or remedy,
            )
    for key, field in known.items():
        if key not in parts and field.default is MISSING:
            job.reject(place, f"no {key!r}", f"{key} = a number", remedy)
    section: Tube | Rectangle | Section = made(**{k: v for k, v in parts.items() if k != "shape"})
    return section


def _matrices(job: Job) -> StructuralModel:
    table = job.section("model")
    if "file" in table:
        return io.read_matrices(job.existing(("model", "file"), table["file"]))
    _require(job, "stiffness", "mass")
    matrices = [job.existing(("model", key), table[key]) for key in ("stiffness", "mass")]
    terms = {
        key: term_files(job, key, names)
        for key, names in job.given("model", ("stiffness_terms", "mass_terms")).items()
    }
    return io.read_matrices(*matrices, **terms)


def term_files(job: Job, key: str, names: str | list[str]) -> list[Any]:
    """The files named; those of a pattern by the numbers in their names."""
    files = []
    for i, name in enumerate([names] if isinstance(names, str) else names):
        if "*" not in name:
            files.append(job.existing(("model", key, i), name))
            continue
        pattern = job.file(name)
        found = sorted(pattern.parent.glob(pattern.name), key=_by_number)
        if not found:
            job.reject(
                ("model", key, i),
                f"{name!r}, which fits no file",
                "files that exist",
                "Paths are relative to the folder of the job file.",
            )
        files += found
    return files


def _by_number(file: Any) -> list[tuple[int, str]]:
    """``K_2`` comes before ``K_10``."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", file.name)]


def _result(job: Job) -> StructuralModel:
    _require(job, "file")
    return UpdateResult.load(job.existing(("model", "file"), job.section("model")["file"])).model


def dof_finder(job: Job, model: StructuralModel) -> Callable[[Keys, Any], Any]:
    """Function of a place and a name: the dof of the model, or the name itself where it is none."""
    table = job.section("model")
    rows: dict[str, int] = {}
    if "dof_map" in table:
        file = job.existing(("model", "dof_map"), table["dof_map"])
        with job.blame(("model",), {"path": ("model", "dof_map")}):
            points = io.read_dof_map(file, first_row=table.get("first_row", 1))
        rows = {f"{node}{direction}": row for (node, direction), row in points.items()}

    def find(place: Keys, name: Any) -> Any:
        if not isinstance(name, str):
            return name
        parts = _NODE_AND_DIRECTION.fullmatch(name)
        if parts and isinstance(model, FrameModel):
            with job.blame(place, {"node": place, "direction": place}):
                return model.dof(int(parts[1]), parts[2])
        return rows.get(name, name)

    return find
