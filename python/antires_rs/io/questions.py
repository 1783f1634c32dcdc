"""What an assessment against a baseline was asked, as plain data, and made again from it."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from ..damage.prior import DamagePrior
from ..damage.question import Question
from ._store import Store
from .models import describe_model, made_model
from .problems import describe_measured, made_measured

__all__ = ["describe_question", "made_question"]


def describe_question(asked: Question, store: Store) -> dict[str, Any]:
    """The model before it was corrected, both states, and what was assumed."""
    return {
        "model": describe_model(asked.model, store),
        "baseline": [describe_measured(each, store) for each in asked.baseline],
        "measured": [describe_measured(each, store) for each in asked.measured],
        "elements": list(asked.elements),
        "prior": asdict(asked.prior),
        "std_common": asked.std_common,
    }


def made_question(data: dict[str, Any], name: str, *, reduced: bool = False) -> Question:
    """The question of a description; ``name`` is the file's, for messages."""
    states: list[Any] = [
        tuple(made_measured(each, name) for each in data[state]) for state in ("baseline", "measured")
    ]
    return Question(
        made_model(data["model"], name),
        states[0],
        states[1],
        tuple(data["elements"]),
        DamagePrior(**data["prior"]),
        data["std_common"],
        reduced=reduced,
    )
