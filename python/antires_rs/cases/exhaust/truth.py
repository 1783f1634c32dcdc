"""What the exhaust's virtual test is made of, kept beside it: for comparison, never for a fit."""

from __future__ import annotations

from typing import Any

from ...support.validation import FloatArray
from . import experiment
from .unfollowed import Unfollowed

__all__ = ["true_antiresonances", "truth"]

#: Values are given up to here, one half beyond the damage band.
F_MAX_HZ = 390.0


def true_antiresonances(
    level: int, responses: list[int], f_max_hz: float, errors: Unfollowed
) -> dict[int, FloatArray]:
    """Undamped antiresonances of the tested structure up to ``f_max_hz``, by dof."""
    tested = experiment.TestedStructure(level, errors)
    found = tested.model.antiresonances(responses, tested.excitation, f_max_hz=f_max_hz)
    return dict(zip(responses, found, strict=True))


def truth(level: int, responses: list[int], errors: Unfollowed) -> dict[str, Any]:
    """Properties of the tested structure, and its frequencies.

    Returns
    -------
    dict
        ``thickness``, ``youngs_modulus`` (factors by section), ``point_mass`` (factors by mass), ``angle``
        (degrees by bend); ``inertia`` and ``hanger`` (factors) and ``unfollowed``, which no updating
        parameter follows;
        ``crack_share``, ``crack_compliance`` (rad/(N m)), ``equivalent_loss`` (stiffness loss of the
        whole cracked element with the same rotation under a moment), ``severity`` {30: that loss};
        ``freq_hz`` by dof and ``resonances_hz``, both up to 390 Hz, ``damping_ratio`` of these modes.
    """
    tested = experiment.TestedStructure(level, errors)
    low = tested.freq_hz <= F_MAX_HZ
    loss = experiment.equivalent_loss(level, errors)
    return {
        "thickness": dict(experiment.THICKNESS),
        "youngs_modulus": dict(experiment.MODULUS),
        "point_mass": dict(experiment.MASS),
        "angle": dict(experiment.ANGLE_DEG),
        "inertia": dict(experiment.INERTIA),
        "hanger": experiment.HANGER,
        "unfollowed": errors,
        "crack_share": (0.0, *experiment.SHARES)[level],
        "crack_compliance": experiment.compliance(level, errors),
        "equivalent_loss": loss,
        "severity": {experiment.CRACKED_ELEMENT: loss},
        "freq_hz": true_antiresonances(level, responses, F_MAX_HZ, errors),
        "resonances_hz": tested.freq_hz[low],
        "damping_ratio": tested.damping_ratio[low],
    }
