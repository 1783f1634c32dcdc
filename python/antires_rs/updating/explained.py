"""Whether a model explains what was measured at all: values and roots paired one to one in each response.

A wrong unit, exchanged matrices or dofs of another numbering leave roots that have nothing to do with the
values. Where there are many roots each value still has a near one, so what counts is how many of both, values
and roots between them, have a partner.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.validation import FloatArray
from .antiresonance_targets import AntiresonanceTargets
from .unit_hint import Lists, unit_hint

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel
    from .problem import UpdatingProblem
    from .targets import Targets

__all__ = [
    "NEAR",
    "Explained",
    "explained",
    "few_alone",
    "hint_of",
    "mostly_paired",
    "paired",
    "roots_between",
]

#: Largest difference in ln f of partners: right models after their search leave less (chains and frames
#: with every term up to 8 % off and one element up to 70 % weaker, whose values were all within 3 %).
NEAR = 0.06
#: Least share of values and roots with a partner. Right models of these: above 0.95; sets of which a fifth of
#: the values was not identified: 0.89; models with a wrong unit, dof or force: below 0.7.
LEAST_SHARE = 0.75
#: Least share of the values alone: two sensors of ten exchanged leave 0.83, a tenth of the values false 0.9.
LEAST_PAIRED = 0.85
#: Shapes of one mode agree so well at least.
_SAME_SHAPE = 0.5


@dataclass(frozen=True)
class Explained:
    """How much of a measurement a model explains.

    Attributes
    ----------
    n_values, n_roots, n_paired : int
        Values, the model's roots between the lowest and the highest of each response, and pairs.
    hint : str
        A mistake that would account for it, in words; '' if none is known.
    common_loss : float
        Loss of all stiffnesses alike that explains the values better than losses of single ones; else 0.
    """

    n_values: int
    n_roots: int
    n_paired: int
    hint: str = ""
    common_loss: float = 0.0

    @property
    def enough(self) -> bool:
        """Whether the model can be that of the tested structure."""
        paired = mostly_paired(self.n_paired, self.n_values, self.n_roots)
        return paired and few_alone(self.n_paired, self.n_values) and not self.common_loss

    @property
    def sentence(self) -> str:
        """That it cannot, why, and what to look at."""
        if not few_alone(self.n_paired, self.n_values):
            counted = (
                f"only {self.n_paired} of {self.n_values} values {'has' if self.n_paired == 1 else 'have'} a "
                f"partner in it within {100 * NEAR:.0f} %"
            )
        elif not mostly_paired(self.n_paired, self.n_values, self.n_roots):
            counted = f"it has {self.n_roots} roots where {self.n_values} values were measured"
        elif self.common_loss:
            counted = (
                f"every stiffness would have to be multiplied by {1.0 - self.common_loss:.2g}, as a modulus, "
                "section or unit that is wrong throughout would have it"
            )
        else:
            counted = "it takes the stiffness of most elements to come near the values"
        return (
            f"The model does not explain the measurement: {counted}. "
            f"{self.hint + ' ' if self.hint else ''}Check its units, dofs, force and supports."
        )


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
        found = _of_antiresonances(problem._core, targets, x)
    else:
        found = _of_modes(problem, x)
    if found.enough and not doubted:
        return found
    return Explained(found.n_values, found.n_roots, found.n_paired, hint_of(problem.model, targets))


def hint_of(model: StructuralModel, targets: Targets) -> str:
    """A mistake that would account for values that the model does not explain; '' if none is known."""
    if isinstance(targets, AntiresonanceTargets):
        parts = targets.parts
        measured: Lists = {(dof, force): np.sort(freq) for dof, force, freq, _, _ in parts if freq.size}
    else:
        measured = {None: np.sort(targets.hz)}
    return unit_hint(model, measured)


def _of_antiresonances(core: _core.Objective, targets: AntiresonanceTargets, x: FloatArray) -> Explained:
    target, hz, shown, _ = core.states(np.ascontiguousarray(x)[None], False, 1)[0]
    seen = (shown >= 0.5) & (hz > 0.0)
    response = np.repeat(np.arange(len(targets.parts)), [part[2].size for part in targets.parts])
    values = np.concatenate([np.empty(0), *(np.sort(np.log(part[2])) for part in targets.parts)])
    return paired(response.astype(np.intp), values, target[seen].astype(np.intp), np.log(hz[seen]))


def paired(
    response: NDArray[np.intp], values: FloatArray, of_root: NDArray[np.intp], roots: FloatArray
) -> Explained:
    """Values and roots in ln f, both ascending within each response, aligned at least cost."""
    sigma, alone = 0.5 * NEAR, 2.0  # a pair further apart than NEAR costs more than both alone
    partner = _core.associate(
        response,
        values,
        np.full(values.size, sigma),
        of_root,
        roots,
        np.zeros(roots.size),
        alone,
        np.zeros(roots.size),
    )
    return Explained(values.size, roots_between(response, values, of_root, roots), int((partner >= 0).sum()))


def roots_between(
    response: NDArray[np.intp], values: FloatArray, of_root: NDArray[np.intp], roots: FloatArray
) -> int:
    """How many roots there are from the lowest to the highest value of each response, in ln f."""
    between = 0
    for number in np.unique(response):
        own = values[response == number]
        there = roots[of_root == number]
        between += int(((there >= own.min() - NEAR) & (there <= own.max() + NEAR)).sum())
    return between


def _of_modes(problem: UpdatingProblem, x: FloatArray) -> Explained:
    table = problem._table(x)
    near = np.abs(np.log(table.after_hz / table.measured_hz)) <= NEAR  # NaN without a partner
    alike = near & (getattr(table, "after_mac", np.ones(near.size)) >= _SAME_SHAPE)
    return Explained(near.size, near.size, int(alike.sum()))
