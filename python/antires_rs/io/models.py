"""Descriptions of models as plain data, and models made again from it, bit-identical."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, astuple
from typing import Any

import numpy as np

from ..models.chain import MassSpringChain
from ..models.description import AppliedParameters, ModelDescription, Recipe
from ..models.entries import Entries
from ..models.frame import FrameModel
from ..models.frame_parts import GroundSpring, NodeSpring, PointMass
from ..models.matrix_model import MatrixModel
from ..models.parameter import Parameter
from ..models.recipes import ChainRecipe, FrameRecipe, MatrixRecipe
from ..models.sections import Rectangle, Section, Tube
from ..models.structural_model import StructuralModel
from ..support.validation import FloatArray, reject
from ._store import Store

__all__ = ["describe_model", "describe_parameters", "made_model", "made_parameters"]

_SECTIONS = {"Tube": Tube, "Rectangle": Rectangle, "Section": Section}
_MODELS: dict[type[Recipe], type[StructuralModel]] = {
    ChainRecipe: MassSpringChain,
    MatrixRecipe: MatrixModel,
    FrameRecipe: FrameModel,
}


def describe_model(model: StructuralModel, store: Store) -> dict[str, Any]:
    """Recipe and applied parameters of a model."""
    description = model.description
    if type(model) is not _MODELS[type(description.recipe)]:
        reject(
            "model",
            type(model).__name__,
            "a MassSpringChain, FrameModel or MatrixModel",
            "Build the model as one of these first.",
        )
    return {
        **_describe_recipe(description.recipe, store),
        "applied": [
            {"parameters": describe_parameters(one.parameters), "values": store.put(one.values)}
            for one in description.applied
        ],
    }


def made_model(data: dict[str, Any], name: str) -> StructuralModel:
    """The model of a description; ``name`` is the file's, for messages."""
    if data["kind"] == "updated":
        return _made_by_version_1(data, name)
    recipe = _made_recipe(data, name)
    applied = tuple(
        AppliedParameters(made_parameters(one["parameters"]), one["values"])
        for one in data.get("applied", ())  # version 1 has none
    )
    return _MODELS[type(recipe)].from_description(ModelDescription(recipe, applied))


def describe_parameters(parameters: Iterable[Parameter]) -> list[dict[str, Any]]:
    """Parameters as plain data."""
    return [asdict(p) for p in parameters]


def made_parameters(rows: list[dict[str, Any]]) -> tuple[Parameter, ...]:
    """Parameters of plain data."""
    made: list[dict[str, Any]] = [
        {key: tuple(v) if isinstance(v, list) else v for key, v in row.items()} for row in rows
    ]
    return tuple(Parameter(**row) for row in made)


def _made_by_version_1(data: dict[str, Any], name: str) -> StructuralModel:
    """A model that came out of an updating was kept as that problem and its x."""
    problem, values = data["problem"], data["x"]
    parameters = made_parameters(problem["parameters"])
    if problem["penalty"] is not None:
        values = _snapped(parameters, values, problem["penalty"]["snap"])
    return made_model(problem["model"], name).with_parameters(parameters, values)


def _snapped(parameters: tuple[Parameter, ...], values: FloatArray, snap: float) -> FloatArray:
    """The problem set severities below ``snap`` to zero before it made its model."""
    reductions = np.array([p.quantity == "stiffness_reduction" for p in parameters])
    return np.where(reductions & (np.abs(values) < snap), 0.0, values)


def _describe_recipe(recipe: Recipe, store: Store) -> dict[str, Any]:
    if isinstance(recipe, ChainRecipe):
        return {
            "kind": "chain",
            "masses_kg": store.put(recipe.masses_kg),
            "springs_n_per_m": store.put(recipe.springs_n_per_m),
            "ground_first_n_per_m": recipe.ground_first_n_per_m,
            "ground_last_n_per_m": recipe.ground_last_n_per_m,
        }
    if isinstance(recipe, MatrixRecipe):
        return {
            "kind": "matrices",
            "n_dof": recipe.n_dof,
            "stiffness": [store.put(part) for part in recipe.stiffness],
            "mass": [store.put(part) for part in recipe.mass],
            "terms": [
                [[store.put(part) for part in term] for term in terms]
                for terms in (recipe.stiffness_terms, recipe.mass_terms)
            ],
            "names": list(recipe.names),
            "constraints": None
            if recipe.constraints is None
            else [store.put(part) for part in recipe.constraints],
            "keep": list(recipe.keep),
        }
    return {
        "kind": "frame",
        "nodes_m": store.put(recipe.nodes_m),
        "elements": [list(beam) for beam in recipe.beams],
        "section_names": list(recipe.section_names),
        "sections": [{"type": type(s).__name__, **asdict(s)} for s in recipe.sections],
        "orientation": None if recipe.orientation is None else store.put(recipe.orientation),
        "point_masses": [astuple(m) for m in recipe.point_masses],
        "ground_springs": [astuple(s) for s in recipe.ground_springs],
        "node_springs": [[s.node, s.other, s.direction, s.stiffness_n_per_m] for s in recipe.node_springs],
        "fixed": recipe.fixed,
    }


def _made_recipe(data: dict[str, Any], name: str) -> Recipe:
    if data["kind"] == "chain":
        return ChainRecipe(
            data["masses_kg"],
            data["springs_n_per_m"],
            data["ground_first_n_per_m"],
            data["ground_last_n_per_m"],
        )
    if data["kind"] == "matrices":
        stiffness_terms, mass_terms = (tuple(map(_entries, terms)) for terms in data["terms"])
        constraints = data.get("constraints")  # not in files of versions before
        return MatrixRecipe(
            data["n_dof"],
            _entries(data["stiffness"]),
            _entries(data["mass"]),
            stiffness_terms,
            mass_terms,
            tuple(data.get("names", ())),
            None if constraints is None else _entries(constraints),
            tuple(data.get("keep", ())),
        )
    if data["kind"] == "frame":
        return _made_frame(data)
    reject(
        "path",
        f"{name!r} with a model of kind {data['kind']!r}",
        "a kind that this version knows",
        "Update antires_rs.",
    )


def _entries(parts: list[Any]) -> Entries:
    rows, columns, values = parts
    return Entries(np.asarray(rows, dtype=np.uint32), np.asarray(columns, dtype=np.uint32), values)


def _made_frame(data: dict[str, Any]) -> FrameRecipe:
    return FrameRecipe(
        nodes_m=data["nodes_m"],
        beams=tuple((a, b, section) for a, b, section in data["elements"]),
        section_names=tuple(data["section_names"]),
        sections=tuple(
            _SECTIONS[s["type"]](**{key: value for key, value in s.items() if key != "type"})
            for s in data["sections"]
        ),
        orientation=data["orientation"],
        point_masses=tuple(
            PointMass(node, mass, tuple(inertia)) for node, mass, inertia in data["point_masses"]
        ),
        ground_springs=tuple(GroundSpring(*row) for row in data["ground_springs"]),
        node_springs=tuple(
            NodeSpring(node, other, k, direction) for node, other, direction, k in data["node_springs"]
        ),
        fixed=tuple((node, direction) for node, direction in data["fixed"]),
    )
