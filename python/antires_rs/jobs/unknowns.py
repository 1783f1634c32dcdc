"""The parameters and the search of a job."""

from __future__ import annotations

from typing import Any

from ..models import frame_parameters as frames
from ..models import geometry_parameters as geometry
from ..models import parameters as terms
from ..models.frame import FrameModel
from ..models.parameters import Parameter
from ..models.structural_model import StructuralModel
from ..optimize.arguments import seed_of, thread_count
from ..optimize.island_ga import IslandGA
from .job import Job, nearest
from .keys_model import ELEMENTS, LUMPED, SECTIONED, SUPPORT
from .lines import Path as Keys
from .values import shown

__all__ = ["elements_of", "parameters_of", "search_of"]

#: By kind: the function, and the key that says on what it acts.
_KINDS: dict[str, tuple[Any, str]] = {
    **{kind: (getattr(terms, kind), "elements") for kind in ELEMENTS[:2]},
    "mass_factor": (terms.mass_factor, "terms"),
    **{kind: (getattr(frames, kind), "sections") for kind in SECTIONED},
    **{kind: (getattr(frames, kind), "masses") for kind in LUMPED},
    **{kind: (getattr(frames, kind), "springs") for kind in SUPPORT},
    "angle": (geometry.angle, "elements"),
    "length": (geometry.length, "elements"),
    "position": (geometry.position, "nodes"),
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
