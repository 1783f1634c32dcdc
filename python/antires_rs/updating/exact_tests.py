"""What a test of the structure with parameters x would measure exactly, and how that changes with them.

For questions that are asked before the test, or all over the bounds: the measured values are those of the
model itself, at the same responses and in the same band, with more forces or sensors if asked for.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..support.validation import FloatArray, reject
from .box_residuals import BoxResiduals
from .model_dofs import model_dof
from .problem import UpdatingProblem
from .steady_roots import roots_of

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["sensitivities"]

#: Below this share of the lowest measured frequency a root on its way to zero would count without bound.
_LOWEST = 0.5
#: Error of an entry of a shape over that of omega squared: ten times that of the frequency.
_SHAPES = 5.0
#: Roots are followed by their numbers to this multiple of the highest measured frequency.
_BEYOND = 2.0
#: A value that the model at x itself does not meet is paired with another.
_MET = 1e-6


def sensitivities(
    problem: UpdatingProblem, x: FloatArray, forces: tuple[int, ...] = (), sensors: tuple[int, ...] = ()
) -> FloatArray:
    """Change of what would be measured at ``x`` over the bounds' distances, (m, n), for the free parameters.

    Rows are of omega squared, relative, and of entries of shapes at unit length, a fifth of them for their
    error is larger. ``forces`` and ``sensors`` are dofs that the test would have beside its own.
    """
    model = problem.model_at(x)
    sets: list[ModalSet] | list[AntiresonanceSet] = (
        _modes(problem, model, sensors)
        if problem.noun == "mode"
        else _antiresonances(problem, model, forces, sensors)
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # on bounds far from nominal: said when the problem was made
        exact = UpdatingProblem(problem.model, problem.parameters, sets)
    residuals = BoxResiduals(exact, x)
    u = residuals.place(x)
    met = np.abs(residuals.at(u)) < _MET
    weight = np.where(residuals.kind == 1, 1.0 / _SHAPES, 1.0)
    return (weight[:, None] * residuals.jacobian(u))[met]


def _antiresonances(
    problem: UpdatingProblem, model: StructuralModel, forces: tuple[int, ...], sensors: tuple[int, ...]
) -> list[AntiresonanceSet]:
    """The roots of the model that have the numbers of the measured ones in the nominal model."""
    high, low = float(problem.measured_hz.max()), _LOWEST * float(problem.measured_hz.min())
    tests: list[tuple[int, dict[int, FloatArray] | None, list[int]]] = []
    for each in problem.measured:
        values = {model_dof(model, "measured dof", dof): each[dof] for dof in each}
        force = model_dof(model, "excitation", each.excitation)
        tests.append((force, values, [*values, *(dof for dof in sensors if dof not in values)]))
    tests += [(force, None, tests[0][2]) for force in forces]
    sees = problem.measured[0].sees
    sets = []
    for force, measured, dofs in tests:
        before = roots_of(problem.model, dofs, force, _BEYOND * high, sees != "frf")
        there = roots_of(model, dofs, force, _BEYOND * high, sees != "frf")
        found = {}
        for dof, was, now in zip(dofs, before, there, strict=True):
            was, now = (np.empty(0) if freq is None else freq for freq in (was, now))
            if measured is not None and dof in measured and was.size:
                number = np.unique([np.argmin(np.abs(was - value)) for value in measured[dof]]).astype(int)
            else:
                number = np.flatnonzero((was >= low) & (was <= high))
            freq = now[number[number < now.size]]
            found[dof] = freq[freq >= low]
        sets.append(AntiresonanceSet(force, found, sees=sees, channels=dofs))
    if not any(freq.size for each in sets for freq in each.values()):
        reject(
            "problem",
            f"no antiresonance up to {high:.4g} Hz at some parameters within the bounds",
            "antiresonances in the band",
            "Narrow the bounds, or take a wider band.",
        )
    return sets


def _modes(problem: UpdatingProblem, model: StructuralModel, sensors: tuple[int, ...]) -> list[ModalSet]:
    """The modes that have the numbers of those in the band of the nominal model."""
    high, low = 1.001 * float(problem.measured_hz.max()), _LOWEST * float(problem.measured_hz.min())
    nominal, modes = problem.model.modes().freq_hz, model.modes()
    flexible = np.flatnonzero((nominal > low) & (nominal < high))
    sets = []
    for each in problem.measured:
        dofs = [int(dof) for dof in each.dofs]
        dofs += [dof for dof in sensors if dof not in dofs]
        sets.append(ModalSet(modes.freq_hz[flexible], modes.shapes[flexible][:, dofs], dofs))
    return sets
