"""Errors of the measured values and of the model, as the posterior of the parameters knows them.

A residual e of omega squared has the variance ``s**2 + (tau g)**2``: s = 2 std_hz / freq_hz is what the
measurement states, tau what the model leaves unexplained, learned from the residuals, and g the relative size
of the term. Where errors are stated, tau is 0 with a prior probability of one half, else log-uniform; where
none are, tau stands for both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .weights import MODEL_ERROR

__all__ = ["FLOOR", "ErrorModel", "drawn", "normalized"]

#: No test and no model agrees better than this in omega squared: exact data must not give intervals of width
#: 0.
FLOOR = 1e-5
#: Largest error of the model that is considered, in omega squared, and the step of its grid in ln(tau).
_MOST, _STEP = 0.3, 0.05
#: Errors of the model below this share of the stated ones make no difference.
_LEAST = 0.2
#: Factor below the estimate at which the grid begins, and above it at which the grid ends: with few values to
#: spare the tail falls as ``tau**-spare``, and one percent of it is left out.
_BELOW, _ABOVE, _TAIL = 6.0, 4.0, 100.0


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """Grid of model errors tau (G,), prior weights in logarithms, and variances of the residuals (G, m).

    ``stated`` says whether standard deviations were measured, ``learned`` whether the residuals tell tau.
    """

    tau: FloatArray
    log_prior: FloatArray
    variance: FloatArray
    stated: bool
    learned: bool

    @classmethod
    def around(cls, stated: FloatArray | None, size: FloatArray, guess: float, spare: int) -> ErrorModel:
        """Grid around the error that the residuals suggest.

        ``stated`` (m,) are standard deviations of the residuals or None, ``size`` (m,) the g of each;
        ``spare`` is the number of residuals that the parameters leave over.
        """
        s = np.zeros(size.size) if stated is None else np.maximum(stated, FLOOR)
        if spare <= 0:  # as many parameters as values: nothing is left to learn from
            tau = np.array([0.0 if stated is not None else MODEL_ERROR])
            return cls(tau, np.zeros(1), s**2 + (tau[:, None] * size) ** 2, stated is not None, False)
        usual = FLOOR if stated is None else float(np.median(s))
        low = min(max(FLOOR, _LEAST * usual), 0.1 * _MOST)
        first = min(max(low, guess / _BELOW), 0.5 * _MOST)
        last = min(_MOST, max(guess, usual, 2.0 * first) * _ABOVE * _TAIL ** (1.0 / spare))
        tau = np.exp(np.arange(np.log(first), np.log(last), _STEP))
        log_prior = np.full(tau.size, np.log(_STEP / np.log(_MOST / low)))
        if stated is not None:
            tau = np.append(0.0, tau)
            log_prior = np.append(0.0, log_prior)  # half and half: the factor cancels
        return cls(tau, log_prior, s**2 + (tau[:, None] * size) ** 2, stated is not None, True)

    def log_density(self, squares: FloatArray) -> FloatArray:
        """Logarithm of likelihood times prior, (k, G), of residuals whose squares (k, m) are given."""
        constant = self.log_prior - 0.5 * np.log(self.variance).sum(axis=1)
        return np.asarray(constant - 0.5 * squares @ (1.0 / self.variance).T)

    def marginal(self, residuals: FloatArray, jacobian: FloatArray) -> FloatArray:
        """Probability of each tau, (G,), with the parameters integrated out as if nothing bounded them."""
        found = np.empty(self.tau.size)
        for nth, variance in enumerate(self.variance):
            root = np.sqrt(variance)
            rows, singular, _ = np.linalg.svd(jacobian / root[:, None], full_matrices=False)
            seen = singular > 1e-9 * max(singular.max(initial=0.0), 1.0)
            z = residuals / root
            left = z @ z - np.sum((rows[:, seen].T @ z) ** 2)
            found[nth] = -np.log(root).sum() - np.log(singular[seen]).sum() - 0.5 * left
        return normalized(found + self.log_prior)


def normalized(log_weights: FloatArray) -> FloatArray:
    """Probabilities from logarithms, along the last axis."""
    p = np.exp(log_weights - log_weights.max(axis=-1, keepdims=True))
    return np.asarray(p / p.sum(axis=-1, keepdims=True))


def drawn(probabilities: FloatArray, uniform: FloatArray) -> NDArray[np.intp]:
    """Index of one outcome for each row of ``probabilities`` (k, G) or (G,), by uniform numbers (k,)."""
    cumulative = np.cumsum(np.atleast_2d(probabilities), axis=1)
    return np.asarray(np.minimum((uniform[:, None] > cumulative).sum(axis=1), cumulative.shape[1] - 1))
