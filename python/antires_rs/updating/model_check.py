"""Whether a model explains what was measured at all: values and roots paired one to one in each response.

Where there are many roots each value has a near one even in a wrong model, so what counts is how many of
both, values and roots between them, have a partner.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from .. import _core
from ..models.structural_model import StructuralModel
from ..support.checks import FloatArray, IntArray
from .problem import UpdatingProblem
from .targets import AntiresonanceTargets, Targets

# -- A mistake of units that would account for a model which does not explain the values: one ratio for all
# frequencies; exchanged matrices turn each root into its inverse

Pairs = tuple[IntArray, FloatArray]  # response of each value, and ln f, ascending within each

#: Measured over model, and which mistakes make it so.
_RATIOS: tuple[tuple[float, str], ...] = (
    (math.tau, "are the frequencies in rad/s in place of Hz?"),
    (1.0 / math.tau, "were the frequencies divided by 2 pi once too often?"),
    (60.0, "are the frequencies in revolutions per minute in place of Hz?"),
    (1.0 / 60.0, "are the frequencies in Hz, and not in revolutions per minute?"),
    (1e-3, "are the frequencies in kHz in place of Hz? Or is the stiffness 1e6 times too large?"),
    (1e3, "is the stiffness 1e6 times too small (modulus in MPa for Pa, N/mm and tonnes), or lengths in mm?"),
    (math.sqrt(1e3), "is the stiffness 1000 times too small (N/mm for N/m, kPa for Pa), or the mass in g?"),
    (math.sqrt(1e-3), "is the mass 1000 times too small (tonnes for kg), or the stiffness 1000 too large?"),
    (math.sqrt(9806.65), "are the springs in kgf/mm in place of N/m?"),
    (math.sqrt(9.80665), "are forces in kgf in place of N, or weights given for masses?"),
    (1.0 / math.sqrt(9.80665), "were masses divided by 9.81 that were in kg already?"),
    (math.sqrt(180.0 / math.pi), "are rotational springs in N m per degree in place of radian?"),
    (math.sqrt(math.pi / 180.0), "are rotational springs in N m per radian, and were taken per degree?"),
    (math.sqrt(175.1268), "are the springs in lbf/in in place of N/m?"),
    (2.0, "is the sampling rate given twice the true one?"),
    (0.5, "is the sampling rate given half the true one?"),
)
#: What values of one of two tests may be in, over what they should be.
_UNITS = (
    (1e-3, "in kHz in place of Hz"),
    (math.tau, "in rad/s in place of Hz"),
    (60.0, "in revolutions per minute in place of Hz"),
)
#: Now over intact, and which mistakes with one of two tests make it so.
_BETWEEN: tuple[tuple[float, str], ...] = (
    *((ratio, f"are they {unit}?") for ratio, unit in _UNITS),
    *((1.0 / ratio, f"are those of the intact structure {unit}?") for ratio, unit in _UNITS),
    (2.0, "is their sampling rate given twice the true one?"),
    (0.5, "is their sampling rate given half the true one?"),
)
_SHARE, _BETTER = 0.7, 1.3  # so many of values and roots have a partner, so many more than without
_ORDINARY = 0.1  # nearer to 1, in ln f, a ratio is an error of the model as any has, and what updating is for
_MOST_DOFS = 600  # larger models take too long to be asked for all their roots


def hint_of(model: StructuralModel, targets: Targets) -> str:
    """A mistake that would account for values that the model does not explain; '' if none is known."""
    if model.n_dof > _MOST_DOFS:
        return ""
    if isinstance(targets, AntiresonanceTargets):
        values = _values(targets)
        found = [np.empty(0)] * len(targets.parts)
        for force in set(targets.forces):
            own = [nth for nth, part in enumerate(targets.parts) if part[1] == force and part[2].size]
            zeros = model.antiresonances([targets.parts[nth][0] for nth in own], force) if own else []
            for nth, freq in zip(own, zeros, strict=True):
                found[nth] = freq
    else:
        values, found = _listed([targets.hz]), [model.modes().freq_hz]
    roots = _listed(found)
    both = [number for number in np.unique(values[0]) if (roots[0] == number).any()]
    first = [values[1][values[0] == n].min() - roots[1][roots[0] == n].min() for n in both]
    free = float(np.median(first)) if first else 0.0
    guesses = [*_RATIOS, *([(math.exp(free), "")] if abs(free) >= _ORDINARY else [])]
    shares = [_share(values, roots, math.log(ratio)) for ratio, _ in guesses]
    best, plain = int(np.argmax(shares)), _share(values, roots, 0.0)
    order = len(roots[0]) - 1 - np.argsort(roots[0][::-1], kind="stable")
    turned = roots[0][order], -roots[1][order] - 2.0 * math.log(math.tau)
    if _share(values, turned, 0.0) >= max(_SHARE, shares[best], _BETTER * plain):
        return "Each root of the model is the inverse of a measured one: are K and M swapped?"
    if shares[best] < max(_SHARE, _BETTER * plain):
        return ""
    ratio, why = guesses[best]
    what = f"All measured values are about {_said(ratio)} times those of the model: "
    return what + (why or "is a stiffness, a mass or a length wrong throughout?")


def hint_between_states(intact: Pairs, now: Pairs) -> str:
    """A sentence, or '' where no ratio of the table makes the values of two tests agree."""
    shares = [_share(now, intact, math.log(ratio)) for ratio, _ in _BETWEEN]
    best = int(np.argmax(shares))
    if shares[best] < max(_SHARE, _BETTER * _share(now, intact, 0.0)):
        return ""
    ratio, why = _BETWEEN[best]
    return f"The values of now are about {_said(ratio)} times those of the intact structure: {why}"


def _said(ratio: float) -> str:
    """A ratio with three digits, without an exponent."""
    return f"{ratio:,.0f}" if ratio >= 100.0 else f"{ratio:.3g}"


def _share(values: Pairs, roots: Pairs, shift: float) -> float:
    """Share of values, and of roots between them, that have a partner one to one."""
    found = _paired(values, (roots[0], roots[1] + shift))
    return 2.0 * found.n_paired / max(found.n_values + found.n_roots, 1)


NEAR = 0.06  # largest difference in ln f of partners: right models after their search leave less (3 %)
#: Least share of values and roots with a partner. Right models: above 0.95; sets without a fifth of the
#: values: 0.89; models with a wrong unit, dof or force: below 0.7.
LEAST_SHARE = 0.75
LEAST_PAIRED = 0.85  # of the values: two sensors of ten exchanged leave 0.83, a tenth false 0.9
NOT_EXPLAINED = "The model does not explain the measurement: {}. {}Check {}."  # why, hint, what to check
_SAME_SHAPE = 0.5  # shapes of one mode agree so well at least


@dataclass(frozen=True)
class Explained:
    """How much of a measurement a model explains."""

    n_values: int
    n_roots: int  # of the model, between the lowest and the highest value of each response
    n_paired: int
    hint: str = ""  # a mistake that would account for it, in words
    common_loss: float = 0.0  # of all stiffnesses alike, where it explains more than losses of single ones
    left: float = 0.0  # largest difference of a frequency, where losses do not explain what is beyond errors

    @property
    def enough(self) -> bool:
        """Whether the model can be that of the tested structure."""
        paired = mostly_paired(self.n_paired, self.n_values, self.n_roots)
        return paired and few_alone(self.n_paired, self.n_values) and not self.common_loss

    @property
    def sentence(self) -> str:
        """That it cannot, why, and what to look at."""
        if not few_alone(self.n_paired, self.n_values):
            have = "has" if self.n_paired == 1 else "have"
            why = f"only {self.n_paired} of {self.n_values} values {have} a partner in it within"
            why += f" {100 * NEAR:.0f} %"
        elif not mostly_paired(self.n_paired, self.n_values, self.n_roots):
            why = f"it has {self.n_roots} roots where {self.n_values} values were measured"
        elif self.common_loss:
            why = f"every stiffness would have to be multiplied by {1.0 - self.common_loss:.2g}, as a "
            why += "modulus, section or unit that is wrong throughout would have it"
        else:
            why = "it takes the stiffness of most elements to come near the values"
        hint = f"{self.hint} " if self.hint else ""
        return NOT_EXPLAINED.format(why, hint, "its units, dofs, force and supports")


def few_alone(n_paired: int, n_values: int) -> bool:
    """Whether hardly a value is without a partner: one, or the share that may be false."""
    return n_values - n_paired <= max(1.0, (1.0 - LEAST_PAIRED) * n_values)


def mostly_paired(n_paired: int, n_values: int, n_roots: int) -> bool:
    """Whether so many pairs are enough; of a few values and roots one without a partner tells nothing."""
    return 2.0 * n_paired >= LEAST_SHARE * (n_values + n_roots - 1)


def explained(problem: UpdatingProblem, x: FloatArray, *, doubted: bool = False) -> Explained:
    """What the model at ``x`` explains; a hint is sought where that is too little, or ``doubted``."""
    targets = problem._targets
    if isinstance(targets, AntiresonanceTargets):
        target, hz, shown, _ = problem._core.states(np.ascontiguousarray(x)[None], False, 1)[0]
        seen = (shown >= 0.5) & (hz > 0.0)
        found = _paired(_values(targets), (target[seen].astype(np.intp), np.log(hz[seen])))
    else:
        near = np.abs(np.log(problem.paired_hz(x) / problem.measured_hz)) <= NEAR  # NaN without a partner
        alike = near & (problem.paired_mac(x) >= _SAME_SHAPE)
        found = Explained(near.size, near.size, int(alike.sum()))
    if found.enough and not doubted:
        return found
    return replace(found, hint=hint_of(problem.model, targets))


def _listed(frequencies: Iterable[FloatArray]) -> Pairs:
    logs = [np.sort(np.log(freq[freq > 0.0])) for freq in frequencies]
    number = np.repeat(np.arange(len(logs)), [each.size for each in logs]).astype(np.intp)
    return number, np.concatenate([np.empty(0), *logs])


def _values(targets: AntiresonanceTargets) -> Pairs:
    return _listed(part[2] for part in targets.parts)


def _paired(values: Pairs, roots: Pairs) -> Explained:
    """Values and roots aligned at least cost within each response."""
    # A pair further apart than NEAR costs more than both alone.
    std, alone, none = np.full(values[1].size, 0.5 * NEAR), 2.0, np.zeros(roots[1].size)
    partner = _core.associate(*values, std, *roots, none, alone, none)
    return Explained(values[1].size, roots_between(*values, *roots), int((partner >= 0).sum()))


def roots_between(response: IntArray, values: FloatArray, of_root: IntArray, roots: FloatArray) -> int:
    """How many roots there are from the lowest to the highest value of each response, in ln f."""
    between = 0
    for number in np.unique(response):
        own, there = values[response == number], roots[of_root == number]
        between += int(((there >= own.min() - NEAR) & (there <= own.max() + NEAR)).sum())
    return between
