"""What parameters are called in tables, and values far from those of the model."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol, cast

from ..support.validation import FloatArray
from ..support.warned import warn
from .parameter import OF_SECTIONS, QUANTITIES, Parameter

__all__ = ["parameter_name", "warn_far"]

#: A nominal value this factor outside the bounds is taken for a slip.
FAR = 5.0


class _Labelled(Protocol):
    """What a model calls its parts: with their numbers as arguments, from 0."""

    @property
    def default_elements(self) -> list[int]: ...
    def element_label(self, element: int) -> str: ...
    def mass_label(self, term: int) -> str: ...


class _LabelledFrame(_Labelled, Protocol):
    def section_index(self, name: str | int) -> int: ...
    def section_label(self, section: int) -> str: ...


def parameter_name(model: _Labelled, parameter: Parameter) -> str:
    """Name for tables, with the unit of the value."""
    quantity = parameter.quantity
    what, unit, *_ = QUANTITIES[quantity]
    if parameter.relative:
        what, unit = f"{what} factor", ""
    terms = parameter.terms
    about = {"angle": f" about node {parameter.pivot}", "length": f" from node {parameter.pivot}"}.get(
        quantity, ""
    )
    if quantity in OF_SECTIONS:
        frame = cast(_LabelledFrame, model)
        labels = [frame.section_label(frame.section_index(term)) for term in terms]
    elif quantity in ("mass_factor", "point_mass", "inertia"):
        # Point masses are the mass terms after those of the beams.
        first = 0 if quantity == "mass_factor" else len(model.default_elements)
        labels = [model.mass_label(first + term) for term in terms]
    elif quantity == "position":
        axis = ", ".join(f"{x:g}" for x in parameter.axis)
        labels = [f"node {term}" for term in terms]
        about = f" along ({axis})"
    else:
        # Springs to ground are the stiffness terms after the beams.
        first = len(model.default_elements) if quantity == "support_stiffness" else 0
        labels = [model.element_label(first + term) for term in terms]
    name = f"{what} of {', '.join(labels)}{about}".replace("mass of mass", "mass")
    return f"{name} ({unit})" if unit else name


def warn_far(parameters: Iterable[Parameter], names: Sequence[str], nominal: FloatArray) -> None:
    """Bounds in another unit than the model's value are a slip that no search can mend."""
    for parameter, name, value in zip(parameters, names, nominal, strict=True):
        low, high = parameter.bounds
        if value > 0.0 and not low / FAR <= value <= FAR * high:
            factors = parameter.nominal is None and high < 100.0
            hint = (
                "Bounds that are factors need relative=True." if factors else "Check the unit of the bounds."
            )
            warn(
                "far_outside_bounds",
                f"{name}: the model has {value:g}, far outside the bounds ({low:g}, {high:g}). " + hint,
            )
