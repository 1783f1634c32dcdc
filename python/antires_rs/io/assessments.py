"""Assessments of damage as plain data and arrays, and made again from it."""

from __future__ import annotations

from dataclasses import MISSING, fields
from itertools import chain
from typing import Any

import numpy as np

from ..damage.assessment import Assessment
from ..damage.hypotheses import Hypotheses, Hypothesis
from ._store import Store

__all__ = ["describe_assessment", "made_assessment"]

#: Columns of the hypotheses with a value for each of their elements.
_RAGGED = ("severities", "low", "high")


def describe_assessment(found: Assessment, store: Store) -> dict[str, Any]:
    """Every field; no bit of a float is lost."""
    rows = list(found.hypotheses)
    described: dict[str, Any] = {
        "hypotheses": {
            "names": [[e, name] for e, name in found.hypotheses.names.items()],
            "elements": [list(one.elements) for one in rows],
            "candidate": [one.candidate for one in rows],
            "probability": store.put(found.hypotheses.probability),
            **{
                name: store.put(np.array([*chain(*(getattr(one, name) for one in rows))])) for name in _RAGGED
            },
        },
        "group": [rows.index(one) for one in found.group],
    }
    for field in fields(found):
        if field.name not in described:
            described[field.name] = _described(getattr(found, field.name), store)
    return described


def made_assessment(data: dict[str, Any]) -> Assessment:
    """The assessment of a description."""
    table = data["hypotheses"]
    counts = [0 if elements == [-1] else len(elements) for elements in table["elements"]]
    ends = np.cumsum(counts)[:-1]
    ragged = [[tuple(part.tolist()) for part in np.split(table[name], ends)] for name in _RAGGED]
    rows = [
        Hypothesis(tuple(elements), probability, severities, low, high, candidate)
        for elements, probability, candidate, severities, low, high in zip(
            table["elements"], table["probability"].tolist(), table["candidate"], *ragged, strict=True
        )
    ]
    values: dict[str, Any] = {
        "hypotheses": Hypotheses(rows, {e: name for e, name in table["names"]}),
        "group": tuple(rows[nth] for nth in data["group"]),
    }
    for field in fields(Assessment):
        if field.name not in values and (field.name in data or field.default is MISSING):
            values[field.name] = _made(data[field.name])
    return Assessment(**values)


def _described(value: Any, store: Store) -> Any:
    if isinstance(value, float):
        return {"float": repr(value)}  # JSON has no infinity
    if isinstance(value, tuple):
        floats = any(isinstance(each, float) for each in value)
        return store.put(np.array(value, dtype=np.float64)) if floats else list(value)
    return value


def _made(value: Any) -> Any:
    if isinstance(value, dict):
        return float(value["float"])
    plain = value.tolist() if isinstance(value, np.ndarray) else value
    return tuple(plain) if isinstance(plain, list) else plain
