"""Two states of a structure and what is assumed of them: all that decides how probable the values are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.parameters import Parameter, stiffness_reduction
from ..support.checks import FloatArray
from ..support.progress import step
from ..updating.model_check import Lists, hint_between_states, hint_of
from ..updating.targets import targets_of
from .likelihood import Likelihood
from .measured_modes import ModeResponses, measured_modes
from .measured_states import Contradiction, Responses, Values, contradiction, measured_states, scatter_between
from .model_error import ModelError, factors_of, learned
from .options import DamagePrior, SearchOptions
from .reduced_roots import ReducedRoots, Terms

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel


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
    options: SearchOptions = field(default_factory=SearchOptions)
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
        likelihood = Likelihood(core, len(numbers), error, intact, now, self.options.std_common, threads)
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
