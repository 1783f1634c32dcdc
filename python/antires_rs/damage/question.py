"""Two states of a structure and what is assumed of them: all that decides how probable the values are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import comb
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.parameters import Parameter, stiffness_reduction
from ..support.checks import FloatArray, finite_scalar
from ..support.progress import step
from ..updating.model_check import Lists, hint_between_states, hint_of
from ..updating.targets import targets_of
from .likelihood import Likelihood
from .measured_modes import ModeResponses, measured_modes
from .measured_states import Contradiction, Responses, Values, contradiction, measured_states, scatter_between
from .model_error import ModelError, factors_of, learned
from .reduced_roots import ReducedRoots, Terms

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel


# -- What is believed of the damage before the test


@dataclass(frozen=True)
class DamagePrior:
    """Probabilities, before the test, of how many elements are damaged; they add up to one.

    Within each number all sets of candidates are equally probable, and every severity from 0 to 0.99 is.

    Attributes
    ----------
    nothing : float
        No damage.
    one, two, three : float
        One, two or three of the candidates.
    elsewhere : float
        One stiffness of the model that is no candidate; counts as ``unknown`` where there is none.
    unknown : float
        A change that no stiffness of the model explains.

    Raises
    ------
    InvalidInputError
        A probability outside [0, 1], or a sum that is not one.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.DamagePrior(nothing=0.9, one=0.07, two=0.01, three=0.0, elsewhere=0.01, unknown=0.01).nothing
    0.9
    """

    nothing: float = 0.50
    one: float = 0.36
    two: float = 0.06
    three: float = 0.01
    elsewhere: float = 0.05
    unknown: float = 0.02

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            finite_scalar(name, value, low=0.0, high=1.0)
        if not np.isclose(sum(vars(self).values()), 1.0, rtol=0.0, atol=1e-9):
            reject(
                "prior",
                f"probabilities with the sum {sum(vars(self).values()):g}",
                "probabilities that add up to one",
                "Give all six, or leave the prior out.",
            )

    def log_of(self, n_damaged: int, n_candidates: int) -> float:
        """Log probability of each set of so many candidates."""
        share = (self.nothing, self.one, self.two, self.three)[n_damaged]
        with np.errstate(divide="ignore"):
            return float(np.log(share) - np.log(comb(n_candidates, n_damaged)))

    def log_elsewhere(self, n_others: int) -> float:
        """Log probability of each element that is no candidate."""
        with np.errstate(divide="ignore"):
            return float(np.log(self.elsewhere) - np.log(n_others))

    def log_unknown(self, n_others: int) -> float:
        """Log probability of something else."""
        with np.errstate(divide="ignore"):
            return float(np.log(self.unknown + (0.0 if n_others else self.elsewhere)))


@dataclass(frozen=True)
class Prepared:
    """The likelihood after the baseline, and what it was made of.

    ``numbers`` are the elements in the order of the severities, candidates first; ``scatter`` that between
    tests of the intact state, over the stated errors; ``odd`` those that contradict each other.
    """

    likelihood: Likelihood
    numbers: tuple[int, ...]
    factors: tuple[Parameter, ...]
    responses: Responses | ModeResponses
    intact: Values
    now: Values
    error: ModelError
    scatter: float
    odd: Contradiction | None

    @property
    def n_baselines(self) -> int:
        """Tests of the intact structure that have values, the most with one force."""
        own = [self.responses.tests[nth] for nth in self.intact.tests.tolist()]
        return max(map(own.count, own), default=0)


@dataclass(frozen=True)
class Question:
    """What was asked; ``elements`` are the candidates, zero-based.

    ``model_error`` is the scatter of the model's factors where it is not to be learned; ``reduced`` whether
    antiresonances are sought on reduced models.
    """

    model: StructuralModel
    baseline: tuple[AntiresonanceSet, ...] | tuple[ModalSet, ...]
    measured: tuple[AntiresonanceSet, ...] | tuple[ModalSet, ...]
    elements: tuple[int, ...]
    prior: DamagePrior
    std_common: float
    model_error: float | None = None
    reduced: bool = False
    #: What the baseline taught (error, scatter, contradiction) once it was asked: intervals ask again.
    _taught: list[tuple[ModelError, float, Contradiction | None]] = field(
        default_factory=list, init=False, repr=False, compare=False
    )

    def prepared(self, threads: int) -> Prepared:
        """Learn the model's errors from the baseline."""
        model = self.model
        before: Any = self.baseline
        after: Any = self.measured
        both: tuple[Any, Any, Any] = (
            measured_modes(model, before, after)
            if isinstance(after[0], ModalSet)
            else measured_states(model, before, after)
        )
        responses, intact, now = both
        numbers = (*self.elements, *(e for e in model._springs if e not in self.elements))
        factors = factors_of(model)
        parts = model.description.core_parameters((*stiffness_reduction(numbers), *factors))
        core: Any = responses.source(model, parts)
        if self.reduced and isinstance(responses, Responses):
            core = ReducedRoots(Terms(model, responses.parts, parts, numbers, factors), core)
        if not self._taught:
            self._taught.append(self._teach(core, (len(numbers), len(factors)), responses, intact, threads))
        error, scatter, odd = self._taught[0]
        if scatter > 1.0:
            intact, now = intact.noisier(scatter), now.noisier(scatter)
        likelihood = Likelihood(core, len(numbers), error, intact, now, self.std_common, threads)
        return Prepared(likelihood, numbers, factors, responses, intact, now, error, scatter, odd)

    def _teach(
        self,
        core: Any,
        sizes: tuple[int, int],
        responses: Responses | ModeResponses,
        intact: Values,
        threads: int,
    ) -> tuple[ModelError, float, Contradiction | None]:
        """The model's errors, the scatter between intact tests, and which of them contradict each other."""
        step("learning the model's errors")
        error = learned(core, *sizes, intact, self.model_error, threads)
        if not error.intact.size or (intact.size and not (error.partner >= 0).any()):
            reject(
                "model",
                f"one that does not explain the measurement: no {responses.noun} near the measured ones",
                "a model of the tested structure",
                f"{self.hint()} Check units, dofs and supports of the model, and the band of the "
                "measurement.".lstrip(),
            )
        odd = contradiction(intact.plain, responses.tests)
        scatter = scatter_between(intact, error.place, error.partner)
        if scatter > 1.0:
            error = learned(core, *sizes, intact.noisier(scatter), self.model_error, threads)
        return error, scatter, odd

    def hint(self) -> str:
        """A mistake that would account for a model that does not explain the intact structure, if any."""
        return hint_of(self.model, targets_of(self.model, self.baseline or self.measured, None))

    def hint_between(self, measured: Sequence[Any]) -> str:
        """A mistake that would account for values of now that have nothing in common with the intact ones."""
        return hint_between_states(_lists(self.baseline), _lists(measured))


def _lists(sets: Sequence[Any]) -> Lists:
    """Frequencies by dof and force; those of modes together."""
    found: dict[Any, list[FloatArray]] = {}
    for each in sets:
        if isinstance(each, ModalSet):
            found.setdefault(None, []).append(each.freq_hz[each.freq_hz > 0.0])
        else:
            for dof, freq in each.items():
                found.setdefault((dof, each.excitation), []).append(freq)
    # Repeated tests of one response are as good as one.
    return {key: np.sort(max(parts, key=len)) for key, parts in found.items()}
