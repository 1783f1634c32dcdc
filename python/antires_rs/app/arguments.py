"""The model of a job, and the dofs of its channels."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import MISSING, fields
from functools import partial
from typing import Any

from .. import io
from ..damage.assess import DamageResult, assess_damage
from ..damage.measured_states import measured_states
from ..damage.options import TWO_STATES, DamagePrior, SearchOptions
from ..measured.antiresonance_set import AntiresonanceSet
from ..models import parameters
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.frame_parts import Rectangle, Section, Tube
from ..models.parameters import Parameter, stiffness_reduction
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import IslandGA, seed_of, thread_count
from ..updating.problem import UpdatingProblem
from ..updating.result import UpdateResult
from .job import Job, Path_lines as Keys, nearest
from .keys import CHAIN, ELEMENTS, FRAME, LUMPED, MATRICES, RESULT, SECTIONED, SUPPORT, shown

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
    """Build the model."""
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


# -- The parameters and the search of a job


#: By kind: the function, and the key that says on what it acts.
_KINDS: dict[str, tuple[Any, str]] = {
    **{kind: (getattr(parameters, kind), "elements") for kind in ELEMENTS[:2]},
    "mass_factor": (parameters.mass_factor, "terms"),
    **{kind: (getattr(parameters, kind), "sections") for kind in SECTIONED},
    **{kind: (getattr(parameters, kind), "masses") for kind in LUMPED},
    **{kind: (getattr(parameters, kind), "springs") for kind in SUPPORT},
    "angle": (parameters.angle, "elements"),
    "length": (parameters.length, "elements"),
    "position": (parameters.position, "nodes"),
}
#: Names of bounds that have a unit, and what some kinds cannot do without.
_BOUNDS = {"angle": "bounds_deg", "position": "bounds_m"}
_NEEDED = {"angle": "pivot", "length": "pivot", "position": "direction"}
#: Keys of [search] that are not options of the optimizer.
_OURS = {"seed", "workers", "max_seconds", "checkpoint"}


def parameters_of(job: Job, model: StructuralModel) -> tuple[list[Parameter], list[Keys]]:
    """All parameters, in the order of the job, and where each of them stands."""
    found: list[Parameter] = []
    places: list[Keys] = []
    for i, table in enumerate(job.parameters):
        place = ("parameters", i)
        kind = table["kind"]
        if kind not in _KINDS:
            job.reject(
                (*place, "kind"),
                shown(kind),
                "one of " + ", ".join(_KINDS),
                nearest(kind, _KINDS) or "Those of sections, masses and supports need a frame.",
            )
        make, on = _KINDS[kind]
        job.only(place, table, kind)
        if on not in table:
            job.missing(place, on)
        options: dict[str, Any] = {
            key: table[key] for key in ("together", "relative", "axis") if key in table
        }
        options[_BOUNDS.get(kind, "bounds")] = table["bounds"]
        if (needed := _NEEDED.get(kind)) is not None:
            if needed not in table:
                job.missing(place, needed)
            options[needed] = table[needed]
        chosen = _everything(model, on) if table[on] == "all" else table[on]
        if chosen == []:
            job.reject(
                (*place, on), f'"all" of a model without {on}', f"a model with {on}", "Remove this entry."
            )
        with job.blame(place):
            made = make(chosen, **options)
        several = [made] if isinstance(made, Parameter) else made
        found += several
        places += [(*place, on)] * len(several)
    return found, places


def elements_of(job: Job) -> Any:
    """Candidates for damage; None for all."""
    chosen = job.section("damage").get("elements", "all")
    return None if chosen == "all" else chosen


def search_of(job: Job, workers: int | None = None) -> tuple[IslandGA, int, int]:
    """Optimizer, seed and number of threads."""
    table = job.section("search")
    options = {name: value for name, value in table.items() if name not in _OURS}
    with job.blame(("search",), {"rng": ("search", "seed")}):
        return (
            IslandGA(max_seconds=table.get("max_seconds"), **options),
            seed_of(table.get("seed", 0)),
            thread_count(workers or table.get("workers")),
        )


def _everything(model: StructuralModel, on: str) -> list[Any]:
    if on == "elements":
        return list(model.default_elements)
    if on == "terms":
        return list(range(model._core.n_mass_terms))
    if not isinstance(model, FrameModel):
        return []
    if on == "nodes":
        return list(range(len(model.nodes_m)))
    return list(
        model.sections
        if on == "sections"
        else range(len(model.point_masses if on == "masses" else model.ground_springs))
    )


# -- From [damage] of a job to a call of ``assess_damage``, its options found valid


def damage_search(
    job: Job, model: StructuralModel, measured: Any, baseline: list[AntiresonanceSet]
) -> Callable[..., DamageResult]:
    """The assessment of a job, to be called with what every search takes."""
    table = job.section("damage")
    options = SearchOptions(**{key: table[key] for key in SearchOptions.declared() if key in table})
    elements = elements_of(job)
    chosen = (
        model.default_elements if elements is None else [elements] if isinstance(elements, int) else elements
    )
    places: list[Keys] = [("damage", "elements", i) for i in range(len(chosen))]
    with job.blame(("damage",), {"measured": ("data",), "parameters": places}):
        UpdatingProblem(
            model, stiffness_reduction(chosen), measured, penalty=options.prices, weights=options.weights
        )
    if not baseline:
        return partial(assess_damage, model, measured, elements=elements, search=options)
    prior = _prior(job)
    with job.blame(("damage",), {"measured": ("data",)}):  # known before anything is written
        options.of(TWO_STATES)
        measured_states(model, baseline, measured if isinstance(measured, list) else [measured])

    def judged(*, optimizer: Any, checkpoint: Any, **how: Any) -> DamageResult:
        """Nothing is searched, so that there is nothing to keep."""
        return assess_damage(
            model, measured, baseline=baseline, elements=elements, prior=prior, search=options, **how
        )

    return judged


def _prior(job: Job) -> DamagePrior | None:
    given = job.section("damage").get("prior")
    if given is None:
        return None
    at: Keys = ("damage", "prior")
    known = [field.name for field in fields(DamagePrior)]
    for name in given:
        if name not in known:
            remedy = nearest(name, known) or "What belongs to none of them is unknown."
            job.reject((*at, name), repr(name), "one of " + ", ".join(known), remedy)
    with job.blame(at, {"prior": at}):
        return DamagePrior(**given)
