"""What would make parameters identifiable: one fixed, two taken as one, another force, another sensor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..support.progress import step
from ..support.validation import FloatArray
from .exact_tests import sensitivities

if TYPE_CHECKING:
    from .problem import UpdatingProblem

__all__ = ["expected_covariance", "suggestions"]

#: Cosine from which two columns of sensitivities count as one, all over the box.
_ALIKE = 0.99
#: A suggestion must take away this share of what is left open.
_WORTH = 0.2
#: Points at which candidates for forces and sensors are tried.
_TRIED = 4
#: A smallest singular value below it is that of a combination that is not seen at all.
_SEEN = 1e-3
#: Share of its prior standard deviation below which a combination counts as told.
TOLD = 0.3


def expected_covariance(jacobians: Sequence[FloatArray], noise: float) -> FloatArray:
    """Mean over the points of the posterior's covariance, in prior standard deviations, (n, n).

    A uniform prior of width 1 counts as a Gaussian of the same variance, 1/12.
    """
    n = jacobians[0].shape[1]
    found = [np.linalg.inv(np.eye(n) + j.T @ j / (12.0 * noise**2)) for j in jacobians]
    return np.asarray(np.mean(found, axis=0))


def suggestions(
    problem: UpdatingProblem,
    names: Sequence[str],
    points: FloatArray,
    jacobians: Sequence[FloatArray],
    noise: float,
    forces: Sequence[int],
    sensors: Sequence[int],
) -> list[str]:
    """Sentences, the most useful of each kind; none where every combination is told."""
    covariance = expected_covariance(jacobians, noise)
    said = _alike(names, jacobians)
    if np.linalg.eigvalsh(covariance)[-1] < TOLD**2:
        return said
    said = [*_fixed(names, covariance), *said]
    few, own = points[:_TRIED], jacobians[:_TRIED]
    now = _open(own, noise)
    for kind, candidates in (("force", forces), ("sensor", sensors)):
        best: tuple[float, int, list[FloatArray]] | None = None
        for dof in candidates:
            label = problem.model.dof_label(dof)
            step(f"{kind} at {label}")
            more = {"forces": (dof,)} if kind == "force" else {"sensors": (dof,)}
            tried = [sensitivities(problem, x, **more) for x in few]
            left = _open(tried, noise)
            if best is None or left < best[0]:
                best = left, dof, tried
        if best is not None and best[0] < (1.0 - _WORTH) * now:
            before, after = _told(own, noise), _told(best[2], noise)
            least = [float(np.median([_least(j, noise) for j in each])) for each in (own, best[2])]
            gain = ""
            if least[0] >= _SEEN:
                gain = f", smallest singular value {least[1]:.2g} instead of {least[0]:.2g}"
            said.append(
                f"A {kind} at {problem.model.dof_label(best[1])} as well: {after} of {len(names)} "
                f"combinations are told instead of {before}{gain}."
            )
    return said


def _fixed(names: Sequence[str], covariance: FloatArray) -> list[str]:
    """The parameter that, once known, leaves the fewest combinations open."""
    before = _count_open(covariance)
    best = (before, float(np.trace(covariance)), 0)
    for j, column in enumerate(covariance):
        left = covariance - np.outer(column, column) / covariance[j, j]
        best = min(best, (_count_open(left), float(np.trace(left)), j))
    if best[0] == before:
        return []
    stay = "none stays" if best[0] == 0 else "1 stays" if best[0] == 1 else f"{best[0]} stay"
    return [f"Fix {names[best[2]]} if it is known otherwise: of {before} open combinations {stay} open."]


def _count_open(covariance: FloatArray) -> int:
    return int(np.sum(np.linalg.eigvalsh(covariance) >= TOLD**2))


def _alike(names: Sequence[str], jacobians: Sequence[FloatArray]) -> list[str]:
    """Pairs whose columns are all but one, at nine of ten points."""
    cosines = []
    for jacobian in jacobians:
        length = np.linalg.norm(jacobian, axis=0)
        unit = jacobian / np.where(length > 0.0, length, 1.0)
        cosines.append(unit.T @ unit)
    usual = np.quantile(np.abs(cosines), 0.1, axis=0)
    pairs = np.argwhere(np.triu(usual, 1) > _ALIKE)
    noun = "One parameter for"
    return [
        f"{noun} {names[a]} and {names[b]}: they move the measured values alike (cosine {usual[a, b]:.3f})."
        for a, b in pairs[:4]
    ]


def _open(jacobians: Sequence[FloatArray], noise: float) -> float:
    """Variance that is left of all combinations together."""
    return float(np.trace(expected_covariance(jacobians, noise)))


def _told(jacobians: Sequence[FloatArray], noise: float) -> int:
    covariance = expected_covariance(jacobians, noise)
    return len(covariance) - _count_open(covariance)


def _least(jacobian: FloatArray, noise: float) -> float:
    """Smallest singular value over the errors, with a prior standard deviation as the unit."""
    values = np.linalg.svd(jacobian, compute_uv=False) / (noise * np.sqrt(12.0))
    return float(values[-1]) if values.size == jacobian.shape[1] else 0.0
