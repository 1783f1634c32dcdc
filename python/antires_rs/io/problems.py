"""Updating problems as plain data, and made again from it."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..updating.penalty import DamagePenalty
from ..updating.problem import UpdatingProblem
from ._store import Store
from .models import describe_model, describe_parameters, made_model, made_parameters

__all__ = ["describe_measured", "describe_problem", "made_measured", "made_problem"]

#: What a set of modes may tell of each.
_BY_MODE = ("damping_ratio", "std_hz", "std_shapes")


def describe_problem(problem: UpdatingProblem, store: Store) -> dict[str, Any]:
    """All that the constructor takes."""
    return {
        "model": describe_model(problem.model, store),
        "parameters": describe_parameters(problem.parameters),
        "measured": [describe_measured(each, store) for each in problem.measured],
        "misfit": problem.misfit,
        "penalty": None if problem.penalty is None else asdict(problem.penalty),
        "weights": None if problem.weights is None else store.put(problem.weights),
    }


def made_problem(data: dict[str, Any], name: str) -> UpdatingProblem:
    """The problem of a description; ``name`` is the file's, for messages."""
    measured: list[Any] = [made_measured(each, name) for each in data["measured"]]
    penalty = None if data["penalty"] is None else DamagePenalty(**data["penalty"])
    sets = measured[0] if len(measured) == 1 else measured
    return UpdatingProblem(
        made_model(data["model"], name),
        made_parameters(data["parameters"]),
        sets,
        misfit=data["misfit"],
        penalty=penalty,
        weights=data["weights"],
    )


def describe_measured(measured: AntiresonanceSet | ModalSet, store: Store) -> dict[str, Any]:
    """A set of either kind."""
    if isinstance(measured, AntiresonanceSet):
        return {"kind": "antiresonances", "set": json.loads(measured.to_json())}
    return {
        "kind": "modes",
        "freq_hz": store.put(measured.freq_hz),
        "shapes": store.put(measured.shapes),
        "dofs": list(measured.dofs),
        **{name: None if (own := getattr(measured, name)) is None else store.put(own) for name in _BY_MODE},
    }


def made_measured(data: dict[str, Any], name: str) -> AntiresonanceSet | ModalSet:
    """The set of a description."""
    if data["kind"] == "antiresonances":
        return AntiresonanceSet.from_json(json.dumps(data["set"]), name)
    by_mode = {name: data.get(name) for name in _BY_MODE}  # older files have no standard deviations
    return ModalSet(data["freq_hz"], data["shapes"], data["dofs"], **by_mode)
