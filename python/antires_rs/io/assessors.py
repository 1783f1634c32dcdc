"""Assessors as files: model, baseline, tables, and what was learned.

A NumPy archive with a JSON text, version 1. No pickle; every part has a checksum.
"""

from __future__ import annotations

import os
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from ..assessor.assessor import Assessor
from ..assessor.plan import Learned, Plan
from ..assessor.tables import LEVELS, Tables
from ..support.validation import reject
from ._common import unsuitable
from ._store import Store, read_store, write_store
from .questions import describe_question, made_question

__all__ = ["load_assessor", "save_assessor"]

FORMAT, VERSION = "antires_rs.assessor", 1


def save_assessor(assessor: Assessor, path: str | os.PathLike[str]) -> Path:
    """Write an assessor, whole or not at all; see :meth:`Assessor.save`."""
    if isinstance(path, str | os.PathLike) and Path(path).suffix != ".npz":
        reject("path", str(path), "a file that ends in .npz", "Append .npz to the name.")
    store, plan = Store(), assessor._plan
    data = {
        "format": FORMAT,
        "version": VERSION,
        "question": describe_question(plan.question, store),
        "reduced": plan.question.reduced,
        "levels": store.put(LEVELS),
        "tables": {field.name: store.put(getattr(plan.tables, field.name)) for field in fields(Tables)},
        "learned": {
            field.name: _described(getattr(plan.learned, field.name), store) for field in fields(Learned)
        },
    }
    return write_store(path, data, store)


def load_assessor(path: str | os.PathLike[str]) -> Assessor:
    """Read what :func:`save_assessor` wrote; see :meth:`Assessor.load`."""
    wanted = f"a file written by Assessor.save, version {VERSION} or older"
    file, data = read_store(path, FORMAT, VERSION, wanted)
    try:
        question = made_question(data["question"], str(file), reduced=data["reduced"])
        tables = Tables(**{field.name: data["tables"][field.name] for field in fields(Tables)})
        learned = Learned(**{field.name: _made(data["learned"][field.name]) for field in fields(Learned)})
        same = np.array_equal(data["levels"], LEVELS)
    except (KeyError, TypeError, IndexError) as exc:
        unsuitable(
            file,
            f"which is damaged ({type(exc).__name__}: {exc})",
            wanted,
            "Make and save the assessor anew.",
        )
    if not same:
        unsuitable(file, "with tables of another version", wanted, "Make and save the assessor anew.")
    return Assessor._of(Plan(question, tables, learned))


def _described(value: Any, store: Store) -> Any:
    """Floats as arrays: no bit is lost, and infinity is allowed."""
    if isinstance(value, np.ndarray):
        return store.put(value)
    if isinstance(value, tuple):
        kind = "floats" if any(isinstance(each, float) for each in value) else "plain"
        return {kind: store.put(np.array(value)) if kind == "floats" else list(value)}
    return {"float": repr(value)} if isinstance(value, float) else value


def _made(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    ((kind, kept),) = value.items()
    if kind == "float":
        return float(kept)
    return tuple(kept.tolist()) if kind == "floats" else tuple(kept)
