"""Kinds of values in a job file."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

__all__ = ["KINDS", "shown"]


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


#: By name: what is wanted, and whether a value is that.
KINDS: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "text": ("text in quotes", _text),
    "texts": ("text in quotes, or a list of such", lambda v: _text(v) or _list(v, _text)),
    "number": ("a finite number", _number),
    "numbers": ("a list of finite numbers", lambda v: _list(v, _number, 0)),
    "whole": ("a whole number", _whole),
    "switch": ("true or false", lambda v: isinstance(v, bool)),
    "pair": ("two numbers, [low, high]", lambda v: _list(v, _number) and len(v) == 2),
    "dof": ("a whole number, or a name in quotes", _dof),
    "dofs": ("a list of dofs, or a table name = dof", _dofs),
    "force": ("a channel's name in quotes, or false", lambda v: v is False or _dof(v)),
    "terms": ("\"all\", a number or name, or a list of them", lambda v: _dof(v) or _list(v, _dof)),
    "list": ("a list", lambda v: _list(v, lambda item: True)),
    "table": ("a table, name = { ... }", lambda v: isinstance(v, dict) and bool(v)),
}


def shown(value: Any) -> str:
    """A value as it stands in a job file, cut where it is long."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 60 else text[:57] + "..."
