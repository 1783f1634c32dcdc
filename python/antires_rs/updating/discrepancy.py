r"""How what a model lacks would move its antiresonances: springs, masses, and shapes of its elements.

A spring or mass that acts along v moves the zero lambda = omega**2 of the response H_sf by

.. math:: \delta\lambda = (k - \lambda m) \frac{(v^T H_s)(v^T H_f)}{dH_{sf}/d\lambda}, \qquad
   H(\lambda) = (K - \lambda M)^{-1}.

These changes are what an error of the model looks like, whatever it is: it pulls many values one way.
Reference: M. C. Kennedy & A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425-464 (model discrepancy).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..models.structural_model import StructuralModel
from ..support.checks import BoolArray, FloatArray
from .problem import MOST_DOFS, UpdatingProblem

_NONE = 1e-9  # a share of the largest below which there is nothing


def likely_errors(problem: UpdatingProblem, x: FloatArray, kept: BoolArray) -> FloatArray | None:
    """Correlation (m, m) that errors of omega squared of the ``kept`` values have from what a model lacks:
    masses, springs, shapes of its elements, a factor on all; its diagonal has the mean 1. None of modes,
    of large models, and where dofs have no mass."""
    measured = problem.measured_dofs, problem.measured_excitations
    if measured[0] is None or measured[1] is None or problem.model.n_dof > MOST_DOFS:
        return None
    from scipy.linalg import eigh

    model = problem.model_at(x)
    try:
        square, shapes = eigh(*map(_dense, (model.stiffness(), model.mass())))
    except np.linalg.LinAlgError:  # dofs without mass
        return None
    zero = (2.0 * np.pi * problem.paired_hz(x)[kept]) ** 2
    read, drive = shapes[measured[0][kept]], shapes[measured[1][kept]]
    resonant = 1.0 / (square - zero[:, None])
    slope = zero * np.sum(read * drive * resonant**2, axis=1)
    both = (read * resonant) @ shapes.T, (drive * resonant) @ shapes.T
    springs = both[0] * both[1] / slope[:, None]
    families = [springs * zero[:, None], springs]
    if inner := list(_shapes_of(problem.model)):
        ways = np.array(inner).T
        families.append((both[0] @ ways) * (both[1] @ ways) / slope[:, None])
    found = [np.ones((zero.size, zero.size))]
    for columns in families:
        size = np.sqrt(np.mean(columns**2, axis=0))
        unit = columns[:, size > _NONE * size.max()] / size[size > _NONE * size.max()]
        found.append(unit @ unit.T / unit.shape[1])
    return np.asarray(np.mean(found, axis=0))


def _shapes_of(model: StructuralModel) -> Iterator[FloatArray]:
    """Ways in which elements deform, (n,), of those that have several."""
    terms = model._core.stiffness_terms()
    for rows, columns, values in (terms[element] for element in model._springs):
        at, places = np.unique(np.concatenate([rows, columns]), return_inverse=True)
        own = np.zeros((at.size, at.size))
        np.add.at(own, tuple(places.reshape(2, -1)), values)
        size, ways = np.linalg.eigh(own)
        some = size > _NONE * size.max(initial=0.0)
        if some.sum() > 1:
            for way in ways[:, some].T:
                shape = np.zeros(model.n_dof)
                shape[at] = way
                yield shape


def _dense(matrix: Any) -> FloatArray:
    return np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix)
