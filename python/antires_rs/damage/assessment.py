"""What an assessment came to: hypotheses, how well the best explains the values, how wrong the model is."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..support.values import Value
from ..updating.model_check import few_alone, mostly_paired
from .hypotheses import Hypotheses, Hypothesis

#: Below this probability of so large a chi-square, the best explanation does not explain.
_HARDLY = 1e-3
#: A model that needs factors which scatter more is of another structure: that of the exhaust, never updated,
#: 0.22; chains and frames with every term up to 20 % off 0.16; a wrong support or dof 0.3 and more.
_FAR_OFF = 0.3
#: Nor is one that misses frequencies by so much whatever its factors: the frame of the exhaust, never updated
#: and up to 39 % off, 0.04; models with a wrong dof, force or unit 0.08 to 0.15.
_MISSED = 0.06


@dataclass(frozen=True, eq=False)
class Assessment(Value):
    """The answer to a baseline assessment, without the model.

    Attributes
    ----------
    hypotheses : Hypotheses
    group : tuple of Hypothesis
        The most probable damage of candidates and what cannot be told from it.
    declared : tuple of int
        Elements declared damaged.
    chi_square : float
        Of the residuals of the most probable hypothesis, over the number of values less that of severities;
        NaN where no value has a partner.
    n_values, n_matched : int
        Values of now, and those with a partner among the model's roots there.
    kappa : float
        Share of a predicted change that counts as its error.
    factor_std, root_std : float
        Learned from the baseline: scatter of the model's stiffness and mass factors, and error of a
        frequency that no factor explains; both relative.
    threshold : float or None
        Log odds of damage from which on it is declared, where a rate of false alarms was asked for.
    detectable : tuple of float
        Severity of each candidate that nine of ten such tests would show.
    baseline : bool
        Whether there was one.
    n_intact, n_intact_matched : int
        Values of the baseline, and those with a partner in the model.
    n_baselines : int
        Tests of the intact structure.
    scatter : float
        Scatter between these over their standard deviations, by which all of them were multiplied; 1 where
        there is one test only.
    assumed_std : bool
        Whether some values had no standard deviation.
    odd_baselines : tuple of int
        Positions of the baseline sets that contradict the others, zero-based: one, or all that disagree where
        it cannot be told which is odd.
    baseline_gap, usual_gap : float
        Relative difference between these and the others, and between the others.
    interrupted : bool
        Whether Ctrl-C stopped the search.
    moved_alike : float
        Relative change of all values alike, where that is what has happened; else 0.
    n_risen, n_moved : int
        Values that have risen, of those that have moved since the intact state, where these are most of them
        and no hypothesis explains them; else 0.
    n_intact_roots : int
        Roots of the model between the lowest and the highest value of each response; 0 where not counted.
    hint : str
        A mistake of units that would account for a model that does not explain the intact structure, or for
        two states that have nothing in common.
    """

    hypotheses: Hypotheses
    group: tuple[Hypothesis, ...]
    declared: tuple[int, ...]
    chi_square: float
    n_values: int
    n_matched: int
    kappa: float
    factor_std: float
    root_std: float
    threshold: float | None
    detectable: tuple[float, ...]
    baseline: bool
    assumed_std: bool
    n_intact: int
    n_intact_matched: int
    n_baselines: int
    scatter: float
    notes: tuple[str, ...] = field(default=())
    odd_baselines: tuple[int, ...] = ()
    baseline_gap: float = 0.0
    usual_gap: float = 0.0
    interrupted: bool = False
    moved_alike: float = 0.0
    n_risen: int = 0
    n_moved: int = 0
    n_intact_roots: int = 0
    hint: str = ""

    @property
    def best(self) -> Hypothesis:
        """The most probable hypothesis."""
        best: Hypothesis = self.hypotheses[0]
        return best

    @property
    def probability_of_nothing(self) -> float:
        """That nothing has changed."""
        return sum(one.probability for one in self.hypotheses if not one.elements)

    @property
    def probability_elsewhere(self) -> float:
        """That something has changed which none of the candidates explains."""
        return sum(one.probability for one in self.hypotheses if not one.candidate)

    @property
    def model_fits(self) -> bool:
        """Whether the model, its factors adjusted, explains the intact structure."""
        matched = few_alone(self.n_intact_matched, self.n_intact)
        paired = mostly_paired(self.n_intact_matched, self.n_intact, self.n_intact_roots or self.n_intact)
        return not self.baseline or bool(matched and paired and self.near)

    @property
    def near(self) -> bool:
        """Whether the model's own errors are such as a model of the structure may have."""
        return self.factor_std <= _FAR_OFF and self.root_std <= _MISSED

    @property
    def states_fit(self) -> bool:
        """Whether both states can be of one structure: half of the values of now have a partner in the model,
        or something has changed that no element explains and no mistake of units either."""
        few = 2 * self.n_matched < self.n_values
        return not (self.baseline and few) or bool(self.best.unknown and not self.hint)

    @property
    def explained(self) -> bool:
        """Whether the values are what the most probable hypothesis leads to expect, errors considered.

        An element that was no candidate may explain them too; a change that no element explains never does.
        """
        from scipy.special import chdtrc

        spare = max(self.n_matched - len(self.best.severities), 1)
        fits = float(chdtrc(spare, self.chi_square * spare)) > _HARDLY
        return bool(fits and not self.best.unknown)

    def marginal(self, element: int) -> float:
        """Probability that a candidate is damaged."""
        return float(
            np.sum([h.probability for h in self.hypotheses if h.candidate and element in h.elements])
        )
