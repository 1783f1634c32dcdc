"""FRFs of a hammer that roved while a sensor stayed, as those of a force at the sensor.

By reciprocity H_sk = H_ks: the response at the sensor s to a force at k is the response at k to a force at s.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from ..support.wording import Passed, Wording
from ._common import unsuitable
from .uff_names import as_point, label_of
from .uff_sets import Function

__all__ = ["roved"]


def roved(file: Path, functions: list[Function], sensor: Any) -> list[Function]:
    """FRFs and coherences of the sensor, response and reference exchanged."""
    point = as_point("roving", sensor)
    curves = [f for f in functions if f.what in ("frf", "coherence")]
    chosen = [f for f in curves if f.response == point]
    if not any(f.what == "frf" for f in chosen):
        there = ", ".join(dict.fromkeys(label_of(f.response) for f in curves if f.what == "frf")) or "none"
        unsuitable(
            file,
            f"with FRFs at the responses {there}",
            Wording("FRFs of {}", Passed("roving", label_of(point))),
            "Name the sensor that stayed while the hammer roved.",
        )
    return [
        replace(
            f,
            response=f.reference,
            reference=f.response,
            own={name: value for name, value in f.own.items() if name != "dof"},
        )
        for f in chosen
    ]
