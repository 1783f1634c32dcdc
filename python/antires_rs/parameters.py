"""Updating parameters: what may change in a model, and within which bounds.

Each function returns one :class:`Parameter` for a single element, or a list with one parameter for
each element of a sequence; add the lists to mix kinds. With ``together=True`` a sequence forms one
parameter that acts on all its elements. Several parameters on one element multiply.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ._validation import choice, finite_scalar, integer, reject, shape_of

__all__ = ["Parameter", "mass_factor", "stiffness_factor", "stiffness_reduction"]

Quantity = Literal["stiffness_reduction", "stiffness_factor", "mass_factor"]

_QUANTITIES: tuple[Quantity, ...] = ("stiffness_reduction", "stiffness_factor", "mass_factor")

#: Largest stiffness loss by default: a lost element would leave the structure in two parts.
LARGEST_REDUCTION = 0.99


@dataclass(frozen=True)
class Parameter:
    """One scalar unknown of a model.

    Attributes
    ----------
    quantity : str
        ``'stiffness_reduction'`` (K_i scaled by 1 - beta), ``'stiffness_factor'`` or ``'mass_factor'``.
    terms : tuple of int
        Stiffness or mass terms of the model that it scales, zero-based.
    bounds : (float, float)
        Lower and upper bound of the value.
    """

    quantity: Quantity
    terms: tuple[int, ...]
    bounds: tuple[float, float]

    def __post_init__(self) -> None:
        choice("quantity", self.quantity, _QUANTITIES)
        if not isinstance(self.terms, tuple) or not self.terms:
            reject("terms", self.terms, "a tuple of at least one zero-based term")
        for i, term in enumerate(self.terms):
            integer(f"terms[{i}]", term, low=0)
        _bounds(self.bounds, self.quantity)

    @property
    def nominal(self) -> float:
        """Value at which the model is as it was given: 0 for a reduction, 1 for a factor."""
        return 0.0 if self.quantity == "stiffness_reduction" else 1.0


def stiffness_reduction(elements: Any, *, bounds: tuple[float, float] = (0.0, LARGEST_REDUCTION),
                        together: bool = False) -> Any:
    """Damage: loss ``beta`` of an element's stiffness, ``K = sum (1 - beta_i) K_i``.

    Parameters
    ----------
    elements : int or sequence of int
        Zero-based stiffness terms.
    bounds : (float, float)
        Within [0, 1].
    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or outside [0, 1], an element listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.stiffness_reduction(4)
    Parameter(quantity='stiffness_reduction', terms=(4,), bounds=(0.0, 0.99))
    >>> len(ar.stiffness_reduction(range(7)))
    7
    """
    return _build("stiffness_reduction", elements, bounds, together)


def stiffness_factor(elements: Any, *, bounds: tuple[float, float], together: bool = False) -> Any:
    """Factor on the stiffness of elements; 1 leaves them as they are.

    Parameters
    ----------
    elements : int or sequence of int
        Zero-based stiffness terms.
    bounds : (float, float)
        Positive, for example ``(0.9, 1.1)``.
    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, an element listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.stiffness_factor([0, 1], bounds=(0.8, 1.2), together=True)
    Parameter(quantity='stiffness_factor', terms=(0, 1), bounds=(0.8, 1.2))
    """
    return _build("stiffness_factor", elements, bounds, together)


def mass_factor(terms: Any, *, bounds: tuple[float, float], together: bool = False) -> Any:
    """Factor on mass terms; for a :class:`MassSpringChain`, term i is mass i.

    Parameters
    ----------
    terms : int or sequence of int
        Zero-based mass terms.
    bounds : (float, float)
        Positive, for example ``(0.9, 1.1)``.
    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a term listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.mass_factor(0, bounds=(0.9, 1.1))
    Parameter(quantity='mass_factor', terms=(0,), bounds=(0.9, 1.1))
    """
    return _build("mass_factor", terms, bounds, together)


def _build(quantity: Quantity, terms: Any, bounds: Any, together: bool) -> Any:
    limits = _bounds(bounds, quantity)
    if shape_of(terms) == ():
        return Parameter(quantity, (integer("elements", terms, low=0),), limits)
    indices = [integer(f"elements[{i}]", t, low=0) for i, t in enumerate(terms)]
    if not indices:
        reject("elements", "an empty sequence", "at least one element")
    twice = sorted({t for t in indices if indices.count(t) > 1})
    if twice:
        reject("elements", f"element(s) {twice} more than once", "each element once")
    groups: Iterable[tuple[int, ...]] = [tuple(indices)] if together else [(t,) for t in indices]
    built = [Parameter(quantity, group, limits) for group in groups]
    return built[0] if together else built


def _bounds(bounds: Any, quantity: Quantity) -> tuple[float, float]:
    factor = quantity != "stiffness_reduction"
    wanted = ("a pair (lower, upper) with 0 < lower <= upper" if factor
              else "a pair (lower, upper) with 0 <= lower <= upper <= 1")
    if shape_of(bounds) != (2,):
        reject("bounds", bounds, wanted)
    lower, upper = (finite_scalar(f"bounds[{i}]", b, low=0.0,
                                  high=np.inf if factor else 1.0, low_open=factor)
                    for i, b in enumerate(bounds))
    if lower > upper:
        reject("bounds", (lower, upper), wanted, "Swap them.")
    return lower, upper
