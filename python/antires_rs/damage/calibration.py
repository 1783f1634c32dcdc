"""The threshold at which damage is declared, for a wanted rate of false alarms.

Intact tests are simulated from what is known after the baseline: the values of the roots that it shows, with
noise and with the errors that are left. Each is judged as a real one is, by the sum of prior times evidence
of all single elements over that of no damage, with the linear model at no damage, where small evidence is
decided.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import FloatArray
from .box import log_between
from .evidence import HIGHEST
from .prior import DamagePrior

__all__ = ["log_odds_threshold"]

_DRAWS = 4000


def log_odds_threshold(
    slopes: FloatArray, prior: DamagePrior, rate: float, rng: np.random.Generator
) -> float:
    """Log odds of damage that this share of intact tests exceeds; ``slopes`` are ``intact_slopes``."""
    from scipy.special import logsumexp

    n = slopes.shape[1]
    size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-6)
    # Height of each severity's peak over its standard deviation, and the room that it has from 0 on.
    height = rng.standard_normal((_DRAWS, slopes.shape[0])) @ slopes / size
    room = size * HIGHEST
    evidence = 0.5 * height**2 + log_between(-height, room - height) + np.log(np.sqrt(2.0 * np.pi) / room)
    odds = logsumexp(evidence, axis=1)
    return float(np.quantile(odds, 1.0 - rate)) + prior.log_of(1, n) - prior.log_of(0, n)
