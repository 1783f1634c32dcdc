"""What is believed of the damage before the test."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

from ..support.validation import finite_scalar, reject

__all__ = ["DamagePrior"]


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
