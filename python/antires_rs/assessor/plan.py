"""What is known before the test: the question, the tables, and what was learned from the baseline."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..damage.calibration import log_odds_threshold
from ..damage.factors import factors_of
from ..damage.inference import roots_beside
from ..damage.limits import intact_slopes, smallest_found
from ..damage.measured_states import Responses, measured_states
from ..damage.question import Question
from ..damage.roots import Roots, roots_at
from ..damage.view import ERRORS, Band
from ..models.parameters import stiffness_reduction
from ..support.one_thread import one_blas_thread
from ..support.validation import FloatArray
from .interpolated import Interpolated
from .new_values import Expected, expected_of
from .tables import Tables, tables_of

__all__ = ["Learned", "Plan", "plan_of"]


@dataclass(frozen=True)
class Learned:
    """What the baseline has told; see :class:`~antires_rs.damage.assessment.Assessment`.

    ``factors`` are those of the model, ``outside`` the share of a change that counts as its error, ``low``
    and ``high`` the band in ln f.
    """

    factors: FloatArray
    tau: float
    s: float
    outside: float
    low: float
    high: float
    threshold: float | None
    detectable: tuple[float, ...]
    assumed_std: bool
    n_intact: int
    n_intact_matched: int
    n_intact_roots: int
    hint: str
    n_baselines: int
    scatter: float
    notes: tuple[str, ...]
    odd_baselines: tuple[int, ...]
    baseline_gap: float
    usual_gap: float


@dataclass(frozen=True)
class Plan:
    """All that an assessment uses; ``question`` has the baseline in place of a test of now."""

    question: Question
    tables: Tables
    learned: Learned

    def __getstate__(self) -> dict[str, Any]:
        """Without what is made of the rest."""
        return {name: self.__dict__[name] for name in ("question", "tables", "learned")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    @cached_property
    def numbers(self) -> tuple[int, ...]:
        """Elements in the order of the tables, candidates first."""
        model, elements = self.question.model, self.question.elements
        return (*elements, *(e for e in model._springs if e not in elements))

    @cached_property
    def names(self) -> dict[int, str]:
        """What the elements are called."""
        return {e: self.question.model.element_label(e) for e in self.numbers}

    @cached_property
    def errors(self) -> tuple[tuple[float, float, float], ...]:
        """As the likelihood has them."""
        return tuple((self.learned.outside * kappa, times, p) for kappa, times, p in ERRORS)

    @cached_property
    def pairs(self) -> NDArray[np.intp]:
        """All pairs of candidates, (k, 2)."""
        found = list(combinations(range(len(self.question.elements)), 2))
        return np.array(found, dtype=np.intp).reshape(-1, 2)

    @cached_property
    def interpolated(self) -> Interpolated:
        """The tables between their levels."""
        return Interpolated(self.tables, self.learned.tau**2)

    @cached_property
    def responses(self) -> Responses:
        """The responses of the baseline."""
        sets: Any = self.question.baseline
        return measured_states(self.question.model, sets, self.question.measured)[0]  # type: ignore[arg-type]

    @cached_property
    def core(self) -> Any:
        """The model's antiresonances, computed."""
        model = self.question.model
        parts = (*stiffness_reduction(self.numbers), *factors_of(model))
        return self.responses.source(model, model.description.core_parameters(parts))

    @cached_property
    def expected(self) -> dict[Any, Expected]:
        """By force label: what a new set may hold."""
        return expected_of(self.question, self.responses)

    def exact(self, beta: FloatArray, band: Band, *, slopes: bool) -> tuple[FloatArray, FloatArray | None]:
        """ln f of the roots of the tables (r,), computed at severities (n,), NaN where the model has none;
        and their slopes by all u (r, n)."""
        x = np.concatenate([beta, self.learned.factors])
        limits = (float(np.exp(band.low - 0.6)), float(np.exp(band.high + 0.6)))
        roots = roots_at(self.core, x[None], slopes=slopes, threads=1, band_hz=limits)[0]
        t = self.tables
        _, identity = roots.since(Roots(t.all_response, t.all_log_f, np.empty((0, 0))))
        known = np.flatnonzero(identity >= 0)
        number = np.full(t.all_log_f.size, -1)
        number[identity[known]] = known
        at = np.where(t.old, number[t.identity], -1)
        log_f = np.where(at >= 0, roots.log_f[at], np.nan)
        if not slopes:
            return log_f, None
        return log_f, np.where((at >= 0)[:, None], roots.slopes[at, : beta.size] * (1.0 - beta), 0.0)


@one_blas_thread
def plan_of(
    question: Question, false_alarm_rate: float | None, rng: np.random.Generator, threads: int
) -> Plan:
    """Learn from the baseline and compute the tables."""
    prepared = question.prepared(threads)
    likelihood, error, odd = prepared.likelihood, prepared.error, prepared.odd
    slopes = intact_slopes(likelihood, len(question.elements))
    threshold = (
        None
        if false_alarm_rate is None
        else log_odds_threshold(slopes, question.prior, false_alarm_rate, rng)
    )
    learned = Learned(
        factors=np.exp(error.theta),
        tau=error.tau,
        s=error.s,
        outside=error.outside,
        low=likelihood.band.low,
        high=likelihood.band.high,
        threshold=threshold,
        detectable=tuple(smallest_found(slopes, question.prior).tolist()),
        assumed_std=prepared.responses.assumed,
        n_intact=prepared.intact.size,
        n_intact_matched=int((error.partner >= 0).sum()),
        n_intact_roots=roots_beside(prepared.intact, error.intact),
        hint=question.hint(),
        n_baselines=prepared.n_baselines,
        scatter=max(prepared.scatter, 1.0),
        notes=tuple(dict.fromkeys(prepared.responses.left_out)),
        odd_baselines=odd.tests if odd else (),
        baseline_gap=odd.apart if odd else 0.0,
        usual_gap=odd.usual if odd else 0.0,
    )
    return Plan(question, tables_of(prepared), learned)
