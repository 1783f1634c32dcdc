"""What the baseline says of a test: the values expected at its conditions, and how they scatter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..support.validation import FloatArray
from .basis import Basis
from .correlation import correlations
from .normal import scores, variances
from .regression import Regression, fitted

__all__ = ["Learned", "learned"]

#: A stated deviation above the usual by this factor is that of a poor test: the excess is added.
_POOR = 1.5
#: Beyond the baseline's range the slope of each value may differ from its line's by this share.
_CURVED = 0.01


@dataclass(frozen=True)
class Learned:
    """The baseline of m values.

    ``variance`` (m,) of the logarithm of each, ``usual`` (m,) its stated standard deviation, ``correlation``
    (m, m) of the normal scores with ``factors`` (m, k) in it, ``attenuation`` by condition: the share of a
    slope that errors of the condition hide.
    """

    basis: Basis
    regression: Regression
    variance: FloatArray
    usual: FloatArray
    degrees: float
    correlation: FloatArray
    factors: FloatArray
    attenuation: Mapping[str, float]

    def expected(self, conditions: Mapping[str, FloatArray], n: int) -> FloatArray:
        """Logarithms of the values at the conditions of n tests, (n, m)."""
        return self.regression.at(self.basis.rows(conditions, n))

    def deviation(self, std: FloatArray, conditions: Mapping[str, FloatArray]) -> FloatArray:
        """Standard deviations of tests about that, with what is not known of it, (n, m)."""
        n = len(std)
        excess = np.nan_to_num(np.maximum(std**2 - (_POOR * self.usual) ** 2, 0.0))
        unsure = 1.0 + self.regression.leverage(self.basis.rows(conditions, n))
        bent = self.beyond(conditions, n) ** 2
        return np.asarray(np.sqrt(self.variance * unsure[:, None] + excess + bent))

    def beyond(self, conditions: Mapping[str, FloatArray], n: int) -> FloatArray:
        """Standard deviation, (n, m), of what each value does by itself outside the baseline's range."""
        variance = np.zeros((n, self.variance.size))
        for one in self.basis.columns:
            value = np.where(np.isnan(conditions[one.name]), one.middle, conditions[one.name])
            away = np.maximum(np.maximum(one.low - value, value - one.high), 0.0)
            if away.any():
                ends = [
                    np.abs(self.basis.slopes(self.regression.coefficients, one.name, above))
                    for above in (True, False)
                ]
                variance += (_CURVED * away[:, None] * np.maximum(*ends)) ** 2
        return np.sqrt(variance)


def learned(
    y: FloatArray, std: FloatArray, conditions: Mapping[str, FloatArray], basis: Basis, degrees: float
) -> Learned:
    """Learn from tests (n, m); ``degrees`` of freedom of the tails as :func:`degrees_of` has it."""
    x = basis.rows(conditions, len(y))
    regression = fitted(y, x)
    rest = y - regression.at(x)
    known = ~np.isnan(std)
    usual = np.where(known.any(axis=0), np.nanmedian(np.where(known.any(axis=0), std, 0.0), axis=0), np.nan)
    variance = variances(rest, usual, degrees, float(basis.size))
    z = scores(rest / np.sqrt(variance), degrees)
    correlation, factors = correlations(z)
    attenuation = {
        one.name: _attenuation(
            rest, variance, basis.slopes(regression.coefficients, one.name, above=True), one.std
        )
        for one in basis.columns
    }
    return Learned(basis, regression, variance, usual, degrees, correlation, factors, attenuation)


def _attenuation(rest: FloatArray, variance: FloatArray, slope: FloatArray, std: float) -> float:
    """Share of a slope that is hidden by errors of the condition.

    The residuals tell along the slope how far a condition is from what the values say: with r the reliability
    of the condition, its variance is (1 - r) / r of that of the condition, beside what the values' own
    scatter makes.
    """
    weight = np.where(np.isnan(rest), 0.0, slope / variance)
    told = weight @ slope
    enough = told > 0.0
    if enough.sum() < 3:
        return 0.0
    away = np.sum(weight * np.nan_to_num(rest), axis=1)[enough] / told[enough]
    share = max(0.0, float(np.mean(away**2) - np.mean(1.0 / told[enough]))) / std**2
    return share / (1.0 + share)
