"""What a test could tell about the parameters, wherever they are within their bounds: asked before the test.

The result of an update says it at its solution only (``result.identifiability``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..exceptions import reject
from ..support.checks import FloatArray, finite_scalar, integer
from ..support.progress import one_blas_thread, patient, step
from ..support.values import Value
from ..views import Viewed
from .identifiability import (
    TOLD,
    combination_in_words,
    combinations,
    expected_covariance,
    sensitivities,
    suggestions,
)
from .problem import UpdatingProblem
from .residuals import BoxResiduals, error_rows
from .targets import model_dof

#: Relative error of a measured frequency where none is stated and none given.
_NOISE = 1e-3
#: Forces and sensors that are tried unless they are named.
_MOST_TRIED = 12


@dataclass(frozen=True, eq=False)
class BoxIdentifiability(Value, Viewed):
    """What a test tells about parameters all over their bounds. Print it.

    Attributes
    ----------
    names : tuple of str, (n,)
        Parameters that may move.
    noise : float
        Relative standard deviation of the measured frequencies that was taken.
    points : ndarray, (p, n)
        Values at which the sensitivities were formed.
    singular_values : ndarray, (p, n)
        Of the sensitivities over the errors, with a prior standard deviation as the unit of each parameter,
        falling: 1 is a combination that the test tells as well as the bounds do.
    left : ndarray, (n,)
        Standard deviation of each parameter after the test over that within the bounds, expected over the
        box: 1 where the test tells nothing.
    combinations : ndarray, (n, n)
        Orthonormal combinations of the parameters (in logarithms where these are positive), the least told
        first.
    combinations_left : ndarray, (n,)
        The same as ``left`` for these.
    words : tuple of str
        What is not told: one for each combination with more than 0.3 left.
    suggestions : tuple of str
        What would help: fix a parameter, take two as one, another force, another sensor.

    Examples
    --------
    >>> import antires_rs as ar
    >>> found = ar.identifiability(ar.cases.chain8().updating_problem(), points=4, forces=[], sensors=[])
    >>> found.told, len(found.names)
    (13, 15)
    """

    #: Share of a standard deviation below which a parameter or a combination counts as told.
    TOLD: ClassVar[float] = TOLD

    names: tuple[str, ...]
    noise: float
    points: FloatArray
    singular_values: FloatArray
    left: FloatArray
    combinations: FloatArray
    combinations_left: FloatArray
    words: tuple[str, ...]
    suggestions: tuple[str, ...]

    @property
    def told(self) -> int:
        """Number of combinations that the test tells: with at most 0.3 of their standard deviation left."""
        return int(np.sum(self.combinations_left < TOLD))

    def plot(self, ax: Any = None) -> Any:
        """What is left of each parameter; see :func:`antires_rs.figures.plot_identifiability`."""
        return self._view("plot")(self, ax=ax)

    def __str__(self) -> str:
        width = max(map(len, self.names))
        lines = [
            f"{self.told} of {len(self.names)} combinations told at {100 * self.noise:g} % error "
            f"of the frequencies, {len(self.points)} points within the bounds",
            "",
            f"{'':<{width}}  left of its standard deviation",
            *(f"{n:<{width}}  {100 * left:5.1f} %" for n, left in zip(self.names, self.left, strict=True)),
            "",
            *(f"not told: {words}" for words in self.words),
            *(f"would help: {words}" for words in self.suggestions),
        ]
        return "\n".join(lines).rstrip()


@patient("identifiability")
@one_blas_thread
def identifiability(
    problem: UpdatingProblem,
    *,
    noise: float | None = None,
    points: int = 32,
    forces: Sequence[int] | None = None,
    sensors: Sequence[int] | None = None,
    progress: bool | None = None,
) -> BoxIdentifiability:
    """What a test like this one tells about the parameters, wherever they are within the bounds.

    Before a test the measured set is a virtual one, made of the model itself; only its responses, forces and
    band are used. At each point of a Sobol sequence (always the same) the sensitivities are those of a
    test of the structure with these parameters.

    Parameters
    ----------
    problem : UpdatingProblem
    noise : float, optional
        Relative standard deviation of the measured frequencies. Default: the median of those stated, 0.1 %
        where none are. Entries of shapes at unit length are given ten times as much.
    points : int
        Points within the bounds, at least 4; a power of two covers them evenly.
    forces, sensors : sequence of int, optional
        Dofs to be tried beside those of the test. Default: up to twelve of the responses as forces, and up to
        twelve of the other dofs that move along an axis as sensors. Forces count for antiresonances only.
    progress : bool, optional
        Show progress on standard error; by default on a terminal, after one second.

    Returns
    -------
    BoxIdentifiability

    Raises
    ------
    InvalidInputError
        Something that is not an UpdatingProblem, a number out of range, a dof that the model does not have,
        no parameter that may move.

    Examples
    --------
    >>> import antires_rs as ar
    >>> chain = ar.MassSpringChain([2.0, 1.0, 1.0], [500.0, 500.0])
    >>> virtual = ar.AntiresonanceSet(0, dict(enumerate(chain.antiresonances([0, 1, 2], 0))))
    >>> unknowns = ar.mass_factor([0, 1], bounds=(0.8, 1.2)) + ar.stiffness_factor([0, 1], bounds=(0.8, 1.2))
    >>> before = ar.identifiability(ar.UpdatingProblem(chain, unknowns, virtual))
    >>> before.told, before.words[0]
    (3, 'mass 0')
    """
    if not isinstance(problem, UpdatingProblem):
        reject(
            "problem", problem, "an UpdatingProblem", "Join model, parameters and a measured or virtual set."
        )
    integer("points", points, low=4, high=4096)
    taken = _stated(problem) if noise is None else finite_scalar("noise", noise, low=1e-8, high=1.0)
    box = BoxResiduals(problem, problem.bounds.mean(axis=1))
    if box.free.size == 0:
        reject(
            "problem", "no parameter that may move", "bounds with a distance", "Give lower and upper bounds."
        )
    names = tuple(problem.names[j] for j in box.free)
    x = box.vector(_spread(points, box.free.size))
    jacobians = []
    for nth, row in enumerate(x):
        step(f"point {nth + 1} of {points}")
        jacobians.append(sensitivities(problem, row))
    # Of omega squared, hence twice the error of the frequency.
    covariance = expected_covariance(jacobians, 2.0 * taken)
    left, vectors = combinations(covariance)
    words = [combination_in_words(names, v) for v, share in zip(vectors, left, strict=True) if share >= TOLD]
    tried = _tried(problem, forces, sensors)
    said = suggestions(problem, names, x, jacobians, 2.0 * taken, *tried)
    singular = [np.linalg.svd(j, compute_uv=False) / (2.0 * taken * np.sqrt(12.0)) for j in jacobians]
    return BoxIdentifiability(
        names,
        float(taken),
        x[:, box.free],
        np.array([np.append(s, np.zeros(len(names)))[: len(names)] for s in singular]),
        np.sqrt(np.clip(np.diag(covariance), 0.0, 1.0)),
        vectors,
        left,
        tuple(words),
        tuple(said),
    )


def _stated(problem: UpdatingProblem) -> float:
    """Median relative error of the frequencies that the measured values state."""
    std = error_rows(problem._targets)[2]
    known = std[np.isfinite(std) & (std > 0.0)]
    return float(0.5 * np.median(known)) if known.size else _NOISE


def _spread(count: int, n: int) -> FloatArray:
    """Points of a Sobol sequence in the unit box, always the same, (count, n)."""
    from scipy.stats.qmc import Sobol

    exponent = int(np.ceil(np.log2(count)))
    return np.asarray(Sobol(n, seed=0).random_base2(exponent)[:count])


def _tried(
    problem: UpdatingProblem, forces: Sequence[int] | None, sensors: Sequence[int] | None
) -> tuple[list[int], list[int]]:
    """Dofs to be tried as forces and as sensors."""
    model = problem.model
    given = [
        None if dofs is None else [model_dof(model, name, dof) for dof in dofs]
        for name, dofs in (("forces", forces), ("sensors", sensors))
    ]
    of_modes = problem.noun == "mode"
    seen = {
        model_dof(model, "measured dof", dof)
        for each in problem.measured
        for dof in (each.dofs if of_modes else each)
    }
    pushed = (
        set() if of_modes else {model_dof(model, "excitation", each.excitation) for each in problem.measured}
    )
    if of_modes:
        given[0] = []
    free = [dof for dof in model._sensor_dofs if dof not in seen]
    return (
        _some(sorted(seen - pushed)) if given[0] is None else given[0],
        _some(free) if given[1] is None else given[1],
    )


def _some(dofs: list[int]) -> list[int]:
    if len(dofs) <= _MOST_TRIED:
        return dofs
    return [dofs[i] for i in np.linspace(0, len(dofs) - 1, _MOST_TRIED).round().astype(int)]
