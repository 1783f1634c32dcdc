"""What a job hands over to the calls of the package: model, dofs, parameters, search."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import MISSING, fields
from functools import partial
from typing import Any

from .. import io
from ..damage.assess import DamageResult, assess_damage
from ..damage.measured_modes import measured_modes
from ..damage.measured_states import measured_states
from ..damage.options import TWO_STATES, DamagePrior, SearchOptions
from ..exceptions import InvalidInputError
from ..io.registry import natural
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models import parameters
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.frame_parts import Rectangle, Section, Tube
from ..models.matrix_model import MatrixModel
from ..models.parameters import Parameter, stiffness_reduction
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import IslandGA, seed_of, thread_count
from ..updating.problem import UpdatingProblem
from ..updating.result import UpdateResult
from .job import Job, KeyPath
from .keys import CHAIN, FRAME, MATRICES, PARAMETERS, RESULT, shown

_SHAPES = {"tube": Tube, "rectangle": Rectangle, "general": Section}
_NODE_AND_DIRECTION = re.compile(
    r"\s*(?:node\s*)?(\d+)(?:[\s.:_]+(?:direction\s+)?([A-Za-z]+)|(u|v|w|theta|rx|ry|rz))\s*"
)


def model_of(job: Job) -> StructuralModel:
    """Build the model."""
    table = dict(job.sections["model"])
    kind = table.pop("kind")
    makers: dict[str, Callable[..., StructuralModel]] = {
        CHAIN: lambda job, table: MassSpringChain(**table),
        FRAME: _frame,
        MATRICES: _matrices,
        RESULT: lambda job, table: UpdateResult.load(_model_file(job, table, "file")).model,
    }
    wanted, remedy = f"one of {_quoted(makers)}", "'antires init --model KIND' writes a job for each."
    job.one_of(("model", "kind"), kind, makers, remedy, wanted=wanted)
    job.only(("model",), table, kind)
    with job.blame(("model",), {"path": ("model", "file")}):
        return makers[kind](job, table)


def _model_file(job: Job, table: dict[str, Any], key: str) -> Any:
    """A file of the model, which cannot do without it."""
    if key not in table:
        job.missing(("model",), key)
    return job.existing(("model", key), table[key])


def _frame(job: Job, table: dict[str, Any]) -> StructuralModel:
    for i, row in enumerate(table["elements"]):
        if not isinstance(row, list):
            wanted = '[node, node] or [node, node, "section"]'
            remedy = "Each beam is a list of its own, inside the list of all."
            job.reject(("model", "elements", i), shown(row), wanted, remedy)
    sections = {name: _section(job, name, parts) for name, parts in table.pop("sections").items()}
    nodes, elements = table.pop("nodes_m"), table.pop("elements")
    # One section needs no name in each element.
    named = len(sections) > 1 or any(len(row) == 3 for row in elements)
    return FrameModel(nodes, elements, sections if named else next(iter(sections.values())), **table)


def _section(job: Job, name: str, parts: Any) -> Tube | Rectangle | Section:
    place: KeyPath = ("model", "sections", name)
    remedy = 'As in pipe = { shape = "tube", outer_diameter_m = 0.05, thickness_m = 0.002, ... }.'
    shape = parts.get("shape") if isinstance(parts, dict) else parts
    if not isinstance(parts, dict) or shape not in list(_SHAPES):
        job.reject(place, shown(shape), f"a table with shape = {_quoted(_SHAPES)}", remedy)
    sizes = {key: value for key, value in parts.items() if key != "shape"}
    known = {field.name: field for field in fields(_SHAPES[shape])}
    for key in sizes:
        job.one_of((*place, key), key, known, remedy, f"the unknown key {key!r}")
    for key, field in known.items():
        if key not in parts and field.default is MISSING:
            job.reject(place, f"no {key!r}", f"{key} = a number", remedy)
    section: Tube | Rectangle | Section = _SHAPES[shape](**sizes)
    return section


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)


def _matrices(job: Job, table: dict[str, Any]) -> StructuralModel:
    if "file" in table:
        return io.read_matrices(_model_file(job, table, "file"))
    matrices = [_model_file(job, table, key) for key in ("stiffness", "mass")]
    return io.read_matrices(*matrices, **term_files(job))


def term_files(job: Job) -> dict[str, list[Any]]:
    """The files of the terms of the model by key; those of a pattern by the numbers in their names."""
    files: dict[str, list[Any]] = {}
    for key in ("stiffness_terms", "mass_terms"):
        names = job.sections["model"].get(key, [])
        for i, name in enumerate([names] if isinstance(names, str) else names):
            files.setdefault(key, []).extend(job.files(("model", key, i), name, order=natural))
    return files


def dof_finder(job: Job, model: StructuralModel | None) -> Callable[[KeyPath, Any], Any]:
    """Function of a place and a name: the dof of the model, or the name itself where it is none."""
    rows: dict[str, int] = {}
    table = {} if model is None else job.sections["model"]
    if "dof_map" in table:
        file = job.existing(("model", "dof_map"), table["dof_map"])
        with job.blame(("model",), {"path": ("model", "dof_map")}):
            points = io.read_dof_map(file, first_row=table.get("first_row", 1))
        rows = {f"{node}{direction}": row for (node, direction), row in points.items()}

    def find(place: KeyPath, name: Any) -> Any:
        if not isinstance(name, str):
            return name
        parts = _NODE_AND_DIRECTION.fullmatch(name)
        if parts and isinstance(model, FrameModel):
            with job.blame(place, {"node": place, "direction": place}):
                return model.dof(int(parts[1]), parts[2] or parts[3])
        if isinstance(model, MatrixModel) and name not in rows:
            with suppress(InvalidInputError):  # no name of the model
                return model.dof(name)
        return rows.get(name, name)

    return find


# -- The parameters and the search of a job

_BOUNDS = {"angle": "bounds_deg", "position": "bounds_m"}  # names of bounds that have a unit
#: Kinds of parameter, and the key that says on what each acts, in the order in which a sentence names them.
_ON = {kind: key.name for key in PARAMETERS.keys if key.kind == "terms" for kind in key.of}
_ON = {kind: _ON[kind] for kind in sorted(_ON, key=PARAMETERS.keys[0].help.index)}
#: Keys of [search] that are not options of the optimizer.
_OURS = {"seed", "workers", "max_seconds", "checkpoint"}


def parameters_of(job: Job, model: StructuralModel) -> tuple[list[Parameter], list[KeyPath]]:
    """All parameters, in the order of the job, and where each of them stands."""
    found: list[Parameter] = []
    places: list[KeyPath] = []
    for i, table in enumerate(job.parameters):
        place = ("parameters", i)
        kind = table["kind"]
        job.one_of((*place, "kind"), kind, _ON, "Those of sections, masses and supports need a frame.")
        on = _ON[kind]
        job.only(place, table, kind)
        options = {key: value for key, value in table.items() if key not in ("kind", "bounds", on)}
        options[_BOUNDS.get(kind, "bounds")] = table["bounds"]
        chosen = _everything(model, on) if table[on] == "all" else table[on]
        if chosen == []:
            got, wanted = f'"all" of a model without {on}', f"a model with {on}"
            job.reject((*place, on), got, wanted, "Remove this entry.")
        with job.blame(place):
            made = getattr(parameters, kind)(chosen, **options)
        several = [made] if isinstance(made, Parameter) else made
        found += several
        places += [(*place, on)] * len(several)
    return found, places


def search_of(job: Job, workers: int | None = None) -> tuple[IslandGA, int, int]:
    """Optimizer, seed and number of threads."""
    table = job.sections["search"]
    options = {name: value for name, value in table.items() if name not in _OURS}
    with job.blame(("search",), {"rng": ("search", "seed")}):
        return (
            IslandGA(max_seconds=table.get("max_seconds"), **options),
            seed_of(table.get("seed", 0)),
            thread_count(workers or table.get("workers")),
        )


def _everything(model: StructuralModel, on: str) -> list[Any]:
    """All on which parameters of a kind may act."""
    if on == "elements":
        return list(model.default_elements)
    if on == "terms":
        return list(model._masses)
    if not isinstance(model, FrameModel):
        return []
    if on == "sections":
        return list(model.sections)
    counted = {"nodes": "nodes_m", "masses": "point_masses", "springs": "ground_springs"}
    return list(range(len(getattr(model, counted[on]))))


# -- From [damage] of a job to a call of ``assess_damage``, its options found valid


def damage_search(
    job: Job, model: StructuralModel, measured: Any, baseline: list[AntiresonanceSet] | list[ModalSet]
) -> Callable[..., DamageResult]:
    """The assessment of a job, to be called with what every search takes."""
    table = job.sections["damage"]
    options = SearchOptions(**{key: table[key] for key in SearchOptions.declared() if key in table})
    elements = None if table.get("elements") == "all" else table.get("elements")
    elements = [elements] if isinstance(elements, int | str) else elements
    chosen = elements or model.default_elements
    places: list[KeyPath] = [("damage", "elements", i) for i in range(len(chosen))]
    of = ("data",) if job.data else ("measured",)
    with job.blame(("damage",), {"measured": of, "parameters": places}):
        how = {"penalty": options.prices, "weights": options.weights}
        UpdatingProblem(model, stiffness_reduction(chosen), measured, **how)
    assess = partial(assess_damage, model, measured, elements=elements, search=options)
    if not baseline:
        return assess
    prior, at = table.get("prior"), ("damage", "prior")
    if prior is not None:
        for name in prior:
            known = [field.name for field in fields(DamagePrior)]
            remedy = "What belongs to none of them is unknown."
            job.one_of((*at, name), name, known, remedy, repr(name))
        with job.blame(at, {"prior": at}):
            prior = DamagePrior(**prior)
    with job.blame(("damage",), {"measured": of}):  # known before anything is written
        options.of(TWO_STATES)
        sides: Any = measured_modes if isinstance(baseline[0], ModalSet) else measured_states
        sides(model, baseline, measured if isinstance(measured, list) else [measured])

    def judged(*, optimizer: Any, checkpoint: Any, **how: Any) -> DamageResult:
        """Nothing is searched, so that there is nothing to keep."""
        return assess(baseline=baseline, prior=prior, **how)

    return judged
