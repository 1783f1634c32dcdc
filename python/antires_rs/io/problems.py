"""Models and updating problems as plain data, and made again from it.

A model is kept as it was made: masses and springs, nodes and sections, or matrices and terms. One that came
out of an updating is kept as that problem and its x, so that the same bits come back.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.frame_parts import GroundSpring, NodeSpring, PointMass
from ..models.matrix_model import MatrixModel
from ..models.parameters import Parameter
from ..models.sections import Rectangle, Section, Tube
from ..models.structural_model import StructuralModel
from ..support.validation import reject
from ..updating.problem import DamagePenalty, UpdatingProblem
from ._store import Store, square

__all__ = ["describe_problem", "made_problem"]

_SECTIONS = {"Tube": Tube, "Rectangle": Rectangle, "Section": Section}


def describe_problem(problem: UpdatingProblem, store: Store) -> dict[str, Any]:
    """All that the constructor takes."""
    return {
        "model": _describe_model(problem.model, store),
        "parameters": [asdict(p) for p in problem.parameters],
        "measured": [_describe_measured(each, store) for each in problem.measured],
        "misfit": problem.misfit,
        "penalty": None if problem.penalty is None else asdict(problem.penalty),
        "weights": None if problem.weights is None else store.put(problem.weights),
    }


def made_problem(data: dict[str, Any], name: str) -> UpdatingProblem:
    """The problem of a description; ``name`` is the file's, for messages."""
    rows: list[dict[str, Any]] = [
        {key: tuple(v) if isinstance(v, list) else v for key, v in row.items()} for row in data["parameters"]
    ]
    parameters = [Parameter(**row) for row in rows]
    measured: list[Any] = [_made_measured(each, name) for each in data["measured"]]
    penalty = None if data["penalty"] is None else DamagePenalty(**data["penalty"])
    sets = measured[0] if len(measured) == 1 else measured
    return UpdatingProblem(
        _made_model(data["model"], name),
        parameters,
        sets,
        misfit=data["misfit"],
        penalty=penalty,
        weights=data["weights"],
    )


def _describe_measured(measured: AntiresonanceSet | ModalSet, store: Store) -> dict[str, Any]:
    if isinstance(measured, AntiresonanceSet):
        return {"kind": "antiresonances", "set": json.loads(measured.to_json())}
    return {
        "kind": "modes",
        "freq_hz": store.put(measured.freq_hz),
        "shapes": store.put(measured.shapes),
        "dofs": list(measured.dofs),
        "damping_ratio": None if measured.damping_ratio is None else store.put(measured.damping_ratio),
    }


def _made_measured(data: dict[str, Any], name: str) -> AntiresonanceSet | ModalSet:
    if data["kind"] == "antiresonances":
        return AntiresonanceSet.from_json(json.dumps(data["set"]), name)
    return ModalSet(data["freq_hz"], data["shapes"], data["dofs"], data["damping_ratio"])


def _describe_model(model: StructuralModel, store: Store) -> dict[str, Any]:
    if model._origin is not None:
        problem, x = model._origin
        return {"kind": "updated", "problem": describe_problem(problem, store), "x": store.put(x)}
    if isinstance(model, MassSpringChain):
        masses, springs, first, last = model._made
        return {
            "kind": "chain",
            "masses_kg": store.put(masses),
            "springs_n_per_m": store.put(springs),
            "ground_first_n_per_m": first,
            "ground_last_n_per_m": last,
        }
    if isinstance(model, MatrixModel):
        return {
            "kind": "matrices",
            "n_dof": model.n_dof,
            "stiffness": store.put_matrix(model._core.stiffness()),
            "mass": store.put_matrix(model._core.mass()),
            "terms": [[[store.put(part) for part in term] for term in terms] for terms in model._made],
        }
    if isinstance(model, FrameModel):
        return _describe_frame(model, store)
    reject(
        "model",
        type(model).__name__,
        "a MassSpringChain, FrameModel or MatrixModel",
        "Build the model as one of these first.",
    )


def _made_model(data: dict[str, Any], name: str) -> StructuralModel:
    if data["kind"] == "updated":
        return made_problem(data["problem"], name).model_at(data["x"])
    if data["kind"] == "chain":
        return MassSpringChain(
            data["masses_kg"],
            data["springs_n_per_m"],
            ground_first_n_per_m=data["ground_first_n_per_m"],
            ground_last_n_per_m=data["ground_last_n_per_m"],
        )
    if data["kind"] == "matrices":
        n = data["n_dof"]
        stiffness, mass = ([square(term, n) for term in terms] for terms in data["terms"])
        return MatrixModel(
            square(data["stiffness"], n), square(data["mass"], n), stiffness_terms=stiffness, mass_terms=mass
        )
    if data["kind"] == "frame":
        return _made_frame(data)
    reject(
        "path",
        f"{name!r} with a model of kind {data['kind']!r}",
        "a kind that this version knows",
        "Update antires_rs.",
    )


def _describe_frame(model: FrameModel, store: Store) -> dict[str, Any]:
    nodes, sections, orientation, masses, ground_springs, node_springs = model._made
    return {
        "kind": "frame",
        "nodes_m": store.put(nodes),
        "elements": [list(beam) for beam in model._beams],
        "section_names": list(model._names),
        "sections": [{"type": type(s).__name__, **asdict(s)} for s in sections],
        "orientation": None if orientation is None else store.put(orientation),
        "point_masses": masses,
        "ground_springs": ground_springs,
        "node_springs": node_springs,
        "fixed": model.fixed,
    }


def _made_frame(data: dict[str, Any]) -> FrameModel:
    listed = [
        _SECTIONS[s["type"]](**{key: value for key, value in s.items() if key != "type"})
        for s in data["sections"]
    ]
    names = data["section_names"]
    named = any(isinstance(name, str) for name in names)
    return FrameModel(
        data["nodes_m"],
        [(a, b, names[section]) for a, b, section in data["elements"]],
        dict(zip(names, listed, strict=True)) if named else listed,
        point_masses=[PointMass(node, mass, tuple(inertia)) for node, mass, inertia in data["point_masses"]],
        ground_springs=[GroundSpring(*row) for row in data["ground_springs"]],
        node_springs=[
            NodeSpring(node, other, k, direction) for node, other, direction, k in data["node_springs"]
        ],
        fixed=[tuple(row) for row in data["fixed"]],
        orientation=data["orientation"],
    )
