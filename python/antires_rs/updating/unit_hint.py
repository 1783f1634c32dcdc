"""A mistake of units that would account for a model which does not explain the values: one ratio for all.

A wrong unit multiplies every frequency of the model, or every measured one, by the same number; exchanged
matrices turn each root into its inverse.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import FloatArray

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["Lists", "hint_between_states", "unit_hint"]

#: Values by response.
Lists = dict[tuple[Any, Any] | None, FloatArray]

#: Measured over model, and which mistakes make it so.
_RATIOS: tuple[tuple[float, str], ...] = (
    (math.tau, "are the frequencies in rad/s in place of Hz?"),
    (1.0 / math.tau, "were the frequencies divided by 2 pi once too often?"),
    (60.0, "are the frequencies in revolutions per minute in place of Hz?"),
    (1.0 / 60.0, "are the frequencies in Hz, and not in revolutions per minute?"),
    (1e-3, "are the frequencies in kHz in place of Hz? Or is the stiffness 1e6 times too large?"),
    (
        1e3,
        "is the stiffness 1e6 times too small (modulus in MPa for Pa, or N/mm together with tonnes), or are "
        "lengths in mm?",
    ),
    (
        math.sqrt(1e3),
        "is the stiffness 1000 times too small (N/mm for N/m, kPa for Pa), or the mass 1000 times too large "
        "(g for kg)?",
    ),
    (
        math.sqrt(1e-3),
        "is the mass 1000 times too small (tonnes for kg), or the stiffness 1000 times too large?",
    ),
    (math.sqrt(9806.65), "are the springs in kgf/mm in place of N/m?"),
    (math.sqrt(9.80665), "are forces in kgf in place of N, or weights given for masses?"),
    (1.0 / math.sqrt(9.80665), "were masses divided by 9.81 that were in kg already?"),
    (math.sqrt(180.0 / math.pi), "are rotational springs in N m per degree in place of radian?"),
    (math.sqrt(math.pi / 180.0), "are rotational springs in N m per radian, and were taken per degree?"),
    (math.sqrt(175.1268), "are the springs in lbf/in in place of N/m?"),
    (2.0, "is the sampling rate given twice the true one?"),
    (0.5, "is the sampling rate given half the true one?"),
)
#: Now over intact, and which mistakes with one of two tests make it so.
_BETWEEN: tuple[tuple[float, str], ...] = (
    (1e-3, "are they in kHz in place of Hz?"),
    (1e3, "are those of the intact structure in kHz in place of Hz?"),
    (math.tau, "are they in rad/s in place of Hz?"),
    (1.0 / math.tau, "are those of the intact structure in rad/s in place of Hz?"),
    (60.0, "are they in revolutions per minute in place of Hz?"),
    (1.0 / 60.0, "are those of the intact structure in revolutions per minute in place of Hz?"),
    (2.0, "is their sampling rate given twice the true one?"),
    (0.5, "is their sampling rate given half the true one?"),
)
#: Under a ratio values and roots agree so well, in ln f, and so many more of both have a partner.
_NEAR, _SHARE, _BETTER = 0.06, 0.7, 1.3
#: Nearer to 1, in ln f, a ratio is an error of the model as any has, and what updating is for.
_ORDINARY = 0.1
#: Larger models take too long to be asked for all their roots.
_MOST_DOFS = 600


def unit_hint(model: StructuralModel, measured: Lists) -> str:
    """A sentence, or '' where no ratio makes the model fit."""
    if model.n_dof > _MOST_DOFS or not measured:
        return ""
    roots = {key: np.log(freq[freq > 0.0]) for key, freq in _roots(model, measured).items()}
    values = {key: np.log(freq[freq > 0.0]) for key, freq in measured.items()}
    plain = _share(values, roots, 0.0)
    first = [values[key][0] - roots[key][0] for key in values if values[key].size and roots[key].size]
    guesses = [(ratio, why) for ratio, why in _RATIOS]
    free = float(np.median(first)) if first else 0.0
    if abs(free) >= _ORDINARY:
        guesses.append((math.exp(free), ""))
    shares = [_share(values, roots, math.log(ratio)) for ratio, _ in guesses]
    best = int(np.argmax(shares))
    turned = {key: np.sort(-each - 2.0 * math.log(math.tau)) for key, each in roots.items()}
    if _share(values, turned, 0.0) >= max(_SHARE, shares[best], _BETTER * plain):
        return "Each root of the model is the inverse of a measured one: are K and M swapped?"
    if shares[best] < max(_SHARE, _BETTER * plain):
        return ""
    ratio, why = guesses[best]
    what = f"All measured values are about {_said(ratio)} times those of the model: "
    return what + (why or "is a stiffness, a mass or a length wrong throughout?")


def hint_between_states(intact: Lists, now: Lists) -> str:
    """A sentence, or '' where no ratio of the table makes the values of two tests agree."""
    before, after = ({key: np.log(freq) for key, freq in each.items() if freq.size} for each in (intact, now))
    before = {key: before.get(key, np.empty(0)) for key in after}
    shares = [_share(after, before, math.log(ratio)) for ratio, _ in _BETWEEN]
    best = int(np.argmax(shares))
    if shares[best] < max(_SHARE, _BETTER * _share(after, before, 0.0)):
        return ""
    ratio, why = _BETWEEN[best]
    return f"The values of now are about {_said(ratio)} times those of the intact structure: {why}"


def _said(ratio: float) -> str:
    """A ratio with three digits, without an exponent."""
    return f"{ratio:,.0f}" if ratio >= 100.0 else f"{ratio:.3g}"


def _roots(model: StructuralModel, measured: Lists) -> Lists:
    if None in measured:
        return {None: model.modes().freq_hz}
    found: Lists = {}
    for force in {key[1] for key in measured if key is not None}:
        dofs = [key[0] for key in measured if key is not None and key[1] == force]
        for dof, freq in zip(dofs, model.antiresonances(dofs, force), strict=True):
            found[dof, force] = np.sort(freq)
    return found


def _share(values: Lists, roots: Lists, shift: float) -> float:
    """Share of values, and of roots between them, that have a partner one to one."""
    pairs = both = 0
    for key, own in values.items():
        if not own.size:
            continue
        there = roots[key] + shift
        there = there[(there >= own[0] - _NEAR) & (there <= own[-1] + _NEAR)]
        both += own.size + there.size
        left = list(there)
        for value in own:  # ascending, so the first that is near enough leaves most to the others
            near = next((r for r in left if abs(r - value) <= _NEAR), None)
            if near is not None:
                left.remove(near)
                pairs += 2
    return pairs / both if both else 0.0
