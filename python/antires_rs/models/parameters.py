"""Updating parameters of any model: they act on the terms of its stiffness and mass.

Each function returns one :class:`Parameter` for a single element, or a list with one parameter for
each element of a sequence; add the lists to mix kinds. With ``together=True`` a sequence forms one
parameter that acts on all its elements. Several parameters on one element multiply. Those of frames are in
:mod:`antires_rs.models.frame_parameters`.
"""

from __future__ import annotations

from typing import Any

from .parameter import Parameter, build

__all__ = ["Parameter", "mass_factor", "stiffness_factor", "stiffness_reduction"]

#: Largest stiffness loss by default: a lost element would leave the structure in two parts.
LARGEST_REDUCTION = 0.99


def stiffness_reduction(
    elements: Any, *, bounds: tuple[float, float] = (0.0, LARGEST_REDUCTION), together: bool = False
) -> Any:
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
    return build("stiffness_reduction", elements, bounds, together)


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
    return build("stiffness_factor", elements, bounds, together)


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
    return build("mass_factor", terms, bounds, together)
