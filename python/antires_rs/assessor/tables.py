"""The model's antiresonances over the severity of each element, computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..damage.likelihood import Likelihood
from ..damage.model_error import ModelError
from ..damage.question import Prepared
from ..damage.roots import Roots
from ..support.progress import step
from ..support.validation import FloatArray, reject

__all__ = ["Tables", "tables_of"]

#: Severities as u = -ln(1 - beta), from none to 0.99; 0.3 apart where most damage lies.
LEVELS = np.array(
    [0.0, 0.06, 0.15, 0.3, 0.5, 0.75, 1.0, 1.3, 1.6, 2.0, 2.4, 2.9, 3.5, 4.0, 4.6051701859880909]
)
#: Roots so far outside of the baseline's band (ln f) are not looked at.
_MARGIN = 0.35
#: Variance of ln f that the compressed errors of the model may miss, on average.
_DROPPED = 1e-13
#: Largest tables, bytes.
_MOST_BYTES = 2e9

Single = NDArray[np.float32]


@dataclass(frozen=True)
class Tables:
    """Roots (r,) at levels (l,) of u of each element (n,).

    Attributes
    ----------
    response, seen : (r,) of each root; whether the baseline shows it. Ascending by response.
    identity : (r,) its number among all roots of the undamaged model, -1 for one that only damage makes.
    all_response, all_log_f : of these.
    intact : (r,) ln f in the undamaged model.
    there : (n, l, r) whether the model has it.
    place : (n, l, r) ln f expected in the measured structure; ``beside`` how far that is from the model's.
    by_own : (n, l, r) slope of the place by u of the element.
    slopes : (n, l, r, n) slopes of ln f by all u.
    errors : (n, l, r, q) what multiplies q independent errors of the model, of variance 1.
    """

    response: NDArray[np.intp]
    seen: NDArray[np.bool_]
    identity: NDArray[np.intp]
    all_response: NDArray[np.intp]
    all_log_f: FloatArray
    intact: FloatArray
    there: NDArray[np.bool_]
    place: FloatArray
    beside: FloatArray
    by_own: FloatArray
    slopes: Single
    errors: Single

    @cached_property
    def old(self) -> NDArray[np.bool_]:
        """Which roots the undamaged model has."""
        return self.identity >= 0


def tables_of(prepared: Prepared) -> Tables:
    """The tables of a model after its baseline."""
    from scipy.interpolate import CubicSpline

    likelihood, error = prepared.likelihood, prepared.error
    n, intact = likelihood.n, error.intact
    at = _at_levels(likelihood, n)
    low, high = likelihood.band.low - _MARGIN, likelihood.band.high + _MARGIN
    inside = intact.between(low, high)
    new: dict[int, int] = {}
    for row in at:
        for roots, identity in row:
            near = roots.between(low, high)
            inside[identity[near & (identity >= 0)]] = True
            own, count = np.unique(roots.response[near & (identity < 0)], return_counts=True)
            for response, more in zip(own.tolist(), count.tolist(), strict=True):
                new[response] = max(new.get(response, 0), more)
    kept = np.flatnonzero(inside)
    response = np.concatenate([intact.response[kept], *(np.full(k, r) for r, k in new.items())]).astype(
        np.intp
    )
    identity_of = np.concatenate([kept, np.full(sum(new.values()), -1)]).astype(np.intp)
    order = np.argsort(response, kind="stable")
    response, identity_of = response[order], identity_of[order]
    factor = _factor(error)
    shape = (n, LEVELS.size, response.size)
    _check_size(shape, n, factor.shape[1])
    there, log_f = np.zeros(shape, dtype=bool), np.zeros(shape)
    slopes, rows = np.zeros((*shape, n), dtype=np.float32), np.zeros((*shape, factor.shape[1]))
    beside = np.zeros(shape)
    for e, row in enumerate(at):
        for level, (roots, identity) in enumerate(row):
            slot, root = _slots(identity_of, response, roots, identity, low, high)
            there[e, level, slot] = True
            log_f[e, level, slot] = roots.log_f[root]
            by_u = roots.slopes[root, :n].copy()
            by_u[:, e] *= np.exp(-LEVELS[level])
            slopes[e, level, slot] = by_u
            by_errors = np.zeros((slot.size, error.mean.size))
            by_errors[:, : error.theta.size] = roots.slopes[root, n:] * likelihood.factors
            is_old = identity[root] >= 0
            by_errors[is_old, error.theta.size + identity[root][is_old]] = 1.0
            beside[e, level, slot] = by_errors @ error.mean
            rows[e, level, slot] = by_errors @ factor
    by_own = slopes[np.arange(n), :, :, np.arange(n)].astype(np.float64)
    for e in range(n):
        whole = there[e].all(axis=0)
        if whole.any():
            by_own[e][:, whole] += CubicSpline(LEVELS, beside[e][:, whole])(LEVELS, 1)
    seen = (identity_of >= 0) & error.seen[identity_of]
    placed = np.where(identity_of >= 0, intact.log_f[identity_of], 0.0)
    errors = _compressed(rows.reshape(-1, factor.shape[1]))
    return Tables(
        response, seen, identity_of, intact.response, intact.log_f, placed, there, log_f + beside, beside,
        by_own, slopes, errors.reshape(*shape, -1),
    )  # fmt: skip


def _at_levels(likelihood: Likelihood, n: int) -> list[list[tuple[Roots, NDArray[np.intp]]]]:
    """Roots at every level of every element, and which of the intact ones they have been."""
    found = []
    for e in range(n):
        step(f"sensitivities of element {e + 1} of {n}")
        betas = np.zeros((LEVELS.size, n))
        betas[:, e] = -np.expm1(-LEVELS)
        found.append([roots.since(likelihood.error.intact) for roots in likelihood.roots(betas, slopes=True)])
    return found


def _slots(
    identity_of: NDArray[np.intp],
    response: NDArray[np.intp],
    roots: Roots,
    identity: NDArray[np.intp],
    low: float,
    high: float,
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where in the table roots stand: their places in it, and their numbers."""
    slot_of = {int(k): slot for slot, k in enumerate(identity_of) if k >= 0}
    free: dict[int, list[int]] = {}
    for slot in np.flatnonzero(identity_of < 0).tolist():
        free.setdefault(int(response[slot]), []).append(slot)
    slots, numbers = [], []
    for number, k in enumerate(identity.tolist()):
        if k in slot_of:
            slots.append(slot_of[k])
            numbers.append(number)
        elif k < 0 and low < roots.log_f[number] < high:
            slots.append(free[int(roots.response[number])].pop(0))
            numbers.append(number)
    return np.array(slots, dtype=np.intp), np.array(numbers, dtype=np.intp)


def _factor(error: ModelError) -> FloatArray:
    """L with L L' the covariance of the model's factors and the roots' own errors, after the baseline."""
    from scipy.linalg import cho_solve

    prior, rows = error.prior, error.rows
    covariance = np.diag(prior)
    if rows.size:
        cross = rows * prior
        covariance -= cross.T @ cho_solve(error.factor, cross)
    size, vectors = np.linalg.eigh(covariance)
    kept = size > 1e-14 * size[-1]
    return np.asarray(vectors[:, kept] * np.sqrt(size[kept]))


def _compressed(rows: FloatArray) -> Single:
    """The same products of rows in fewer columns."""
    size, vectors = np.linalg.eigh(rows.T @ rows)
    dropped = np.cumsum(np.maximum(size, 0.0)) / len(rows) < _DROPPED
    return np.asarray(rows @ vectors[:, ~dropped], dtype=np.float32)


def _check_size(shape: tuple[int, int, int], n: int, q: int) -> None:
    size = 8.0 * float(np.prod(shape)) * (q + 0.5 * n)
    if size > _MOST_BYTES:
        reject(
            "model",
            f"one with {n} stiffness terms, whose tables take {size / 1e9:.1f} GB",
            f"at most {_MOST_BYTES / 1e9:.0f} GB",
            "Use assess_damage, or a model with fewer terms.",
        )
