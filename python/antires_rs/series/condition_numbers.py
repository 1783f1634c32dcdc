"""Numbers of a condition: what stands for one that is not known, and what is none."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.validation import FloatArray, part, reject

__all__ = ["number", "refuse_infinite"]

#: What loggers and spreadsheets write where nothing was measured, in any case.
MISSING = ("", "na", "n/a", "#n/a", "nan", "nat", "null", "none", "-", "--", "---", "missing")


def number(value: Any) -> float:
    """A value as a float, NaN where it stands for one that is not known.

    Raises
    ------
    TypeError, ValueError
        It is no number.
    """
    if value is None or (isinstance(value, str) and value.strip().lower() in MISSING):
        return float("nan")
    try:
        return float(value)
    except TypeError:
        if type(value).__name__ in ("NAType", "NaTType"):  # of pandas
            return float("nan")
        raise


def refuse_infinite(name: str, column: FloatArray) -> None:
    """Refuse a condition that is infinite in one test."""
    at = np.flatnonzero(np.isinf(column))
    if at.size:
        got, wanted = f"{column[at[0]]:g}", "a finite number, NaN where it is not known"
        reject(part(name, int(at[0])), got, wanted, "Give NaN for what was not measured.")
