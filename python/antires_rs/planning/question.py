"""What is asked before a test, checked: of which unknowns, with which sensors and forces, in which band."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from .. import _core
from ..damage.candidates import elements_of
from ..damage.evidence import HIGHEST
from ..models.parameter import Parameter, parameter_tuple
from ..models.parameter_names import parameter_name
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..support.validation import FloatArray, frequency_band, reject, shape_of

__all__ = ["Sees", "Unknowns", "band_of", "dofs_of", "unknowns_of"]

Sees = Literal["transmissibility", "frf"]
#: By default the band ends above so many elastic resonances, by this factor.
_RESONANCES, _HEADROOM = 12, 1.13
#: Below this share of the highest frequency a mode is a rigid motion.
_RIGID = 1e-4
#: Standard deviation of what is uniform between 0 and 1.
UNIFORM = 1.0 / float(np.sqrt(12.0))


@dataclass(frozen=True)
class Unknowns:
    """Severities of elements, or parameters of an updating.

    ``spread`` (p,) are their standard deviations before the test. Severities come from the difference of two
    tests, ``tests`` is 2; parameters from one.
    """

    parameters: tuple[Parameter, ...]
    names: tuple[str, ...]
    nominal: FloatArray
    spread: FloatArray
    #: Of severities, the elements.
    elements: tuple[int, ...] | None
    tests: int


def unknowns_of(model: StructuralModel, elements: Any) -> Unknowns:
    """Elements by number, or parameters."""
    given = [elements] if isinstance(elements, Parameter) else elements
    some = isinstance(given, Sequence) and any(isinstance(p, Parameter) for p in given)
    numbers = None if some else tuple(elements_of(model, elements))
    if numbers is not None and len(set(numbers)) < len(numbers):
        reject("elements", "an element twice", "each element once", "Drop the second one.")
    parameters = parameter_tuple(given) if numbers is None else tuple(stiffness_reduction(list(numbers)))
    parts = model.description.core_parameters(parameters)
    nominal = np.asarray(_core.nominal_values(model._core, parts), dtype=np.float64)
    width = np.array([p.bounds[1] - p.bounds[0] for p in parameters])
    names = (
        tuple(parameter_name(model, p) for p in parameters)
        if numbers is None
        else tuple(model.element_label(e) for e in numbers)
    )
    spread = width * UNIFORM if numbers is None else np.full(len(numbers), HIGHEST * UNIFORM)
    return Unknowns(parameters, names, nominal, spread, numbers, 1 if numbers is None else 2)


def dofs_of(name: str, model: StructuralModel, dofs: Any, default: list[int] | None = None) -> list[int]:
    """Dofs of the model, each once; by default all but rotations, where names tell them."""
    if dofs is None:
        return model._sensor_dofs if default is None else default
    listed = [dofs] if shape_of(dofs) == () else list(dofs)
    chosen = [model._dof(name, dof) for dof in listed]
    if not chosen or len(set(chosen)) < len(chosen):
        reject(
            name, dofs, "dofs of the model, at least one and each once", "Look them up by model.dof_label."
        )
    return chosen


def band_of(model: StructuralModel, band_hz: Any) -> tuple[float, float]:
    """The band of the identification; by default up to above the twelfth elastic resonance."""
    if band_hz is not None:
        return frequency_band("band_hz", band_hz, low_hz=0.0, high_hz=np.inf)
    count = min(model.n_dof, _RESONANCES + 6)
    freq = model.modes(count).freq_hz
    elastic = freq[freq > _RIGID * freq[-1]]
    return 0.0, float(_HEADROOM * elastic[:_RESONANCES][-1])
