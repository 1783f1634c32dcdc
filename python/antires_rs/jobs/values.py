"""Kinds of values in a job file."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

__all__ = ["KINDS", "UNSET", "Kind", "shown", "unset_in"]

#: Stands in a new job for a dof that only its user knows.
UNSET = "?"


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _text(value: Any) -> bool:
    return isinstance(value, str) and value != ""


def _dof(value: Any) -> bool:
    return _whole(value) or _text(value)


def _list(value: Any, item: Callable[[Any], bool], least: int = 1) -> bool:
    return isinstance(value, list) and len(value) >= least and all(map(item, value))


def _dofs(value: Any) -> bool:
    def one(dof: Any) -> bool:
        return dof is False or _dof(dof)

    return _list(value, one) or (isinstance(value, dict) and bool(value) and all(map(one, value.values())))


@dataclass(frozen=True)
class Kind:
    """What is wanted, whether a value is that, and how it is written."""

    wanted: str
    fits: Callable[[Any], bool]
    remedy: str


KINDS = {
    "text": Kind("text in quotes", _text, "Put it in quotes."),
    "texts": Kind(
        "text in quotes, or a list of such",
        lambda v: _text(v) or _list(v, _text),
        'Write "one" or ["one", "another"].',
    ),
    "number": Kind("a finite number", _number, "Write it without quotes, with a decimal point."),
    "numbers": Kind(
        "a list of finite numbers", lambda v: _list(v, _number, 0), "Write them as in [1.0, 2.5]."
    ),
    "whole": Kind("a whole number", _whole, "Write it without quotes and decimal point."),
    "switch": Kind(
        "true or false", lambda v: isinstance(v, bool), "Write it in small letters, without quotes."
    ),
    "pair": Kind(
        "two numbers, [low, high]",
        lambda v: _list(v, _number) and len(v) == 2,
        "Write them as in [3.0, 130.0].",
    ),
    "dof": Kind("a whole number, or a name in quotes", _dof, 'Write it as in 3 or "12+Z".'),
    "dofs": Kind(
        "a list of dofs, or a table name = dof", _dofs, 'Write it as in [0, 1, 2] or { "12+Z" = 0 }.'
    ),
    "force": Kind(
        "a channel's name in quotes, or false", lambda v: v is False or _dof(v), "Put it in quotes."
    ),
    "terms": Kind(
        '"all", a number or name, or a list of them',
        lambda v: _dof(v) or _list(v, _dof),
        'Write it as in "all" or [0, 1, 2].',
    ),
    "list": Kind("a list that is not empty", lambda v: _list(v, lambda item: True), "Put it in [ ]."),
    "shares": Kind(
        "a table name = number",
        lambda v: isinstance(v, dict) and bool(v) and all(map(_number, v.values())),
        "Write it as in { nothing = 0.9, one = 0.1 }.",
    ),
    "table": Kind("a table, name = { ... }", lambda v: isinstance(v, dict) and bool(v), "Put it in { }."),
}


def unset_in(value: Any) -> list[str]:
    """Channels, or places in a list, whose dof is not given yet; [''] for the value itself."""
    if isinstance(value, dict):
        return [name for name, dof in value.items() if dof == UNSET]
    if isinstance(value, list):
        return [f"number {i}" for i, dof in enumerate(value) if dof == UNSET]
    return [""] if value == UNSET else []


def shown(value: Any) -> str:
    """A value as it stands in a job file, cut where it is long."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 60 else text[:57] + "..."
