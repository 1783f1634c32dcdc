"""What damage costs in the objective: the paper's numbers, or numbers that grow with the data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..support.validation import FloatArray, choice, finite_scalar, integer, real_array, reject, shape_of

__all__ = ["DamagePenalty", "Misfit", "penalty_of"]

Misfit = Literal["absolute", "squared", "largest"]

#: The paper's factors, and the number of antiresonances of its chain.
_PAPER, _PAPER_VALUES = 0.1, 28
#: Severities below it count as exactly 0.
_SNAP = 1e-3


@dataclass(frozen=True)
class DamagePenalty:
    """Preference for few damaged elements: ``gamma1 * sum(beta) + gamma2 * count(beta > 0)``.

    Attributes
    ----------
    gamma1, gamma2 : float
        Weights, at least 0; the paper's are 0.1 each, whatever was measured. For numbers that grow with the
        data see :meth:`scaled`.
    snap : float
        Severities below it count as exactly 0, and are evaluated as 0; within [0, 1e-3]. 0 is the
        algorithm as printed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.DamagePenalty(gamma1=0.05)
    DamagePenalty(gamma1=0.05, gamma2=0.1, snap=0.001)
    >>> ar.DamagePenalty.scaled(84)
    DamagePenalty(gamma1=0.3, gamma2=0.3, snap=0.001)
    """

    gamma1: float = _PAPER
    gamma2: float = _PAPER
    snap: float = _SNAP

    def __post_init__(self) -> None:
        finite_scalar("gamma1", self.gamma1, low=0.0)
        finite_scalar("gamma2", self.gamma2, low=0.0)
        finite_scalar("snap", self.snap, low=0.0, high=1e-3)

    @classmethod
    def scaled(
        cls,
        weights: Any,
        misfit: Misfit = "absolute",
        *,
        gamma1: float | None = None,
        gamma2: float | None = None,
        snap: float = _SNAP,
    ) -> DamagePenalty:
        """Penalties that grow with the number of measured values and with their weights.

        Both are the misfit of a difference of 0.1 / 28 = 0.36 % in every omega**2, so that an element is
        named if it explains more than that on average:

        ==========  ====================================  ==============================
        misfit      gamma, with e = 0.1 / 28              28 values of weight one
        ==========  ====================================  ==============================
        absolute    sum(w) e                              0.1, the paper's on its chain
        squared     sum(w**2) e**2                        0.00036
        largest     max(w) e                              0.0036
        ==========  ====================================  ==============================

        The same data given three times, or all weights doubled, leave the located elements and their
        severities. ``weights="std"`` has a mean of one, so that the penalties go with the number of values
        however well these are known. A mode counts as two values, since it has two residuals.

        Parameters
        ----------
        weights : int or array_like (m,)
            Number of values, or their weights.
        misfit : {'absolute', 'squared', 'largest'}
        gamma1, gamma2 : float, optional
            Numbers that are not to be scaled.
        snap : float

        Raises
        ------
        InvalidInputError
            No value, a weight below 0, or a penalty out of range.

        Examples
        --------
        >>> import antires_rs as ar
        >>> ar.DamagePenalty.scaled([2.0, 0.5, 0.5, 1.0] * 7, gamma2=0.2)
        DamagePenalty(gamma1=0.1, gamma2=0.2, snap=0.001)
        """
        unit = _unit_misfit(_checked(weights), choice("misfit", misfit, ("absolute", "squared", "largest")))
        return cls(unit if gamma1 is None else gamma1, unit if gamma2 is None else gamma2, snap)


def penalty_of(given: Any, weights: FloatArray, misfit: Misfit) -> DamagePenalty | None:
    """The penalty in force of what an UpdatingProblem was given; ``weights``, one for each residual."""
    if given is None or isinstance(given, DamagePenalty):
        return given
    if isinstance(given, str) and given == "scaled":
        given = (None, None)
    if shape_of(given) not in ((2,), (3,)):
        reject(
            "penalty",
            given,
            "a DamagePenalty, 'scaled', a pair (gamma1, gamma2) or None",
            "Write it as in penalty=(0.1, 0.1).",
        )
    gamma1, gamma2, snap = (*given, _SNAP)[:3]
    return DamagePenalty.scaled(weights, misfit, gamma1=gamma1, gamma2=gamma2, snap=snap)


def _unit_misfit(weights: FloatArray, misfit: str) -> float:
    """Misfit of a difference of 0.1 / 28 in every value."""
    if misfit == "absolute":
        return float(weights.sum() * _PAPER / _PAPER_VALUES)
    if misfit == "squared":
        return float(np.sum(weights**2) * (_PAPER / _PAPER_VALUES) ** 2)
    return float(weights.max() * _PAPER / _PAPER_VALUES)


def _checked(weights: Any) -> FloatArray:
    if shape_of(weights) == ():
        return np.ones(integer("weights", weights, low=1))
    given = real_array("weights", weights, ndim=1, wanted="a number of values, or the weight of each")
    if given.size == 0 or given.min() < 0.0 or not given.any():
        reject(
            "weights",
            f"{given.size} numbers" + (f" from {given.min():g} to {given.max():g}" if given.size else ""),
            "a number of values, or the weight of each, at least 0",
            "Pass how many values are compared.",
        )
    return given
