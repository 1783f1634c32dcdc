"""Profile likelihood of one severity, after an assessment against a baseline.

The severity is held at points of u = -ln(1 - beta), the others of the set declared damaged are fitted again,
and the likelihood is that of the assessment, with the errors of values and model in it.

Reference: A. Raue et al., Bioinformatics 25 (2009) 1923-1929.
"""

from __future__ import annotations

import numpy as np

from ..optimize.arguments import thread_count
from ..support.one_thread import one_blas_thread
from ..support.progress import patient, step
from ..support.validation import FloatArray, finite_scalar, integer, reject
from ..updating.profile import ProfileLikelihood
from ..updating.sides import kind_of, threshold
from .assessment import Assessment
from .evidence import FURTHEST
from .likelihood import Likelihood
from .question import Question

__all__ = ["severity_profile"]

#: Standard deviations within which the points lie, and Newton steps of the other severities at each.
_REACH, _STEPS = 4.0, 4
#: Largest step of u.
_LONGEST = 0.3


@patient("profile")
@one_blas_thread
def severity_profile(
    question: Question,
    found: Assessment,
    names: list[str],
    name: str,
    *,
    level: float,
    points: int,
    progress: bool | None = None,
) -> ProfileLikelihood:
    """Profile of the severity called ``name``; see ``DamageResult.profile``."""
    finite_scalar("level", level, low=0.5, high=0.999)
    integer("points", points, low=5, high=1001)
    if name not in names:
        reject("name", repr(name), "a severity of the result", f"One of {', '.join(names)}.")
    element = question.elements[names.index(name)]
    one = next((h for h in found.hypotheses if h.elements == tuple(found.declared)), None)
    if one is None or element not in one.elements:
        reject(
            "name",
            repr(name),
            "a severity of an element declared damaged",
            "The others are 0: result.probability tells how probable their damage is.",
        )
    prepared = question.prepared(thread_count(None))
    held = one.elements.index(element)
    at = np.array([prepared.numbers.index(e) for e in one.elements])
    best = _settled(prepared.likelihood, at, -np.log1p(-np.minimum(one.severities, 0.99))[None], None)
    u, curvature = best[1][0], best[2]
    std = float(np.sqrt(np.linalg.inv(curvature)[held, held]))
    places = _places(float(u[held]), std, points)
    step(f"{name} held at {places.size} points")
    start = np.repeat(u[None], places.size, axis=0)
    start[:, held] = places
    logs, others, _ = _settled(prepared.likelihood, at, start, held)
    rise = 2.0 * (max(float(logs.max()), float(best[0][0])) - logs)
    limit = threshold(level)
    low, low_open = _end(places, rise, limit, -1)
    high, high_open = _end(places, rise, limit, 1)
    on_bound = [
        tuple(
            names[question.elements.index(e)]
            for nth, e in enumerate(one.elements)
            if nth != held and row[nth] <= 0.0
        )
        for row in others
    ]
    return ProfileLikelihood(
        name,
        -np.expm1(-places),
        rise,
        limit,
        level,
        -float(np.expm1(-low)),
        -float(np.expm1(-high)),
        kind_of(low_open, high_open),
        tuple(on_bound),
    )


def _settled(
    likelihood: Likelihood, at: FloatArray, start: FloatArray, held: int | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Log-likelihood at rows of u and the rows, all but the one held fitted; curvature at the first."""
    u = np.clip(start, 0.0, FURTHEST)
    free = np.array([nth for nth in range(at.size) if nth != held], dtype=np.intp)
    for nth in range(_STEPS + 1):
        betas = np.zeros((len(u), likelihood.n))
        betas[:, at] = -np.expm1(-u)
        views = likelihood.views(betas)
        if nth == _STEPS or not free.size:
            break
        for row, view in zip(u, views, strict=True):
            room = np.exp(-row[free])
            matrix = view.curvature[np.ix_(at[free], at[free])] * np.outer(room, room)
            ahead = np.linalg.solve(matrix + 1e-6 * np.eye(free.size), view.gain[at[free]] * room)
            row[free] = np.clip(row[free] + np.clip(ahead, -_LONGEST, _LONGEST), 0.0, FURTHEST)
    room = np.exp(-u[0])
    curvature = views[0].curvature[np.ix_(at, at)] * np.outer(room, room) + 1e-6 * np.eye(at.size)
    return np.array([view.log_likelihood for view in views]), u, curvature


def _places(center: float, std: float, points: int) -> FloatArray:
    """Values of u, most within a few standard deviations, and the bounds."""
    near = center + std * _REACH * np.linspace(-1.0, 1.0, points)
    return np.unique(np.concatenate([[0.0], near[(near > 0.0) & (near < FURTHEST)], [FURTHEST]]))


def _end(places: FloatArray, rise: FloatArray, limit: float, side: int) -> tuple[float, bool]:
    """Where the rise passes the limit on one side of its least, and whether it never does."""
    best = int(np.argmin(rise))
    own = range(best, places.size) if side > 0 else range(best, -1, -1)
    for before, here in zip(own, list(own)[1:], strict=False):
        if rise[here] > limit:
            first, second = np.sqrt(rise[[before, here]])  # a parabola's root is a line
            share = (np.sqrt(limit) - first) / (second - first)
            return float(places[before] + share * (places[here] - places[before])), False
    return float(places[0 if side < 0 else -1]), True
