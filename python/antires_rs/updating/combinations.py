"""Combinations of parameters that the data do not tell, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..support.validation import FloatArray

__all__ = ["combination_in_words", "combinations"]

#: Members of a combination have at least this share of its largest coefficient; so many are named.
_MEMBER, _NAMED = 0.3, 4
#: From this share of all parameters on, all of one sign, it is the common scale.
_COMMON = 0.7

#: Combinations with at least this share left are as good as not seen, and may be turned into simpler ones.
_UNSEEN = 0.95


def combinations(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What is left of orthonormal combinations, (n,), the least told first, and these, (n, n), by row.

    ``covariance`` is in prior standard deviations. Combinations of which nothing is told are any basis of a
    space; they are turned to have few members each.
    """
    values, vectors = np.linalg.eigh(covariance)
    left, rows = np.sqrt(np.clip(values[::-1], 0.0, 1.0)), vectors[:, ::-1].T.copy()
    unseen = int(np.sum(left >= _UNSEEN))
    if unseen > 1:
        rows[:unseen] = _varimax(rows[:unseen])
    return left, rows


def _varimax(rows: FloatArray) -> FloatArray:
    """The rows rotated among themselves so that their squares vary most (Kaiser, Psychometrika 23 (1958))."""
    turned = rows.copy()
    for _ in range(50):
        before = turned.copy()
        for a in range(len(rows)):
            for b in range(a + 1, len(rows)):
                u, v = turned[a] ** 2 - turned[b] ** 2, 2.0 * turned[a] * turned[b]
                n = rows.shape[1]
                angle = 0.25 * np.arctan2(
                    2.0 * (u @ v - u.sum() * v.sum() / n), u @ u - v @ v - (u.sum() ** 2 - v.sum() ** 2) / n
                )
                c, s = np.cos(angle), np.sin(angle)
                turned[[a, b]] = c * turned[a] + s * turned[b], c * turned[b] - s * turned[a]
        if np.allclose(before, turned, atol=1e-9):
            break
    return turned


def combination_in_words(names: Sequence[str], direction: FloatArray) -> str:
    """The end of "not told: ...", of a direction in which the data leave the parameters free, (n,)."""
    size = np.abs(direction)
    order = np.argsort(-size, kind="stable")
    members = [int(j) for j in order if size[j] >= _MEMBER * size[order[0]]]
    signs = np.sign(direction[members]) * np.sign(direction[members[0]])
    named = [names[j] for j in members]
    if len(members) == 1:
        return named[0]
    if len(members) >= max(3, _COMMON * len(names)) and np.all(signs > 0):
        return "a common scale of the parameters; their ratios are"
    if len(members) == 2:
        if signs[1] < 0:
            return f"{named[0]} against {named[1]}; both together are"
        return f"{named[0]} together with {named[1]}; their ratio is"
    up = [name for name, sign in zip(named, signs, strict=True) if sign > 0]
    down = [name for name, sign in zip(named, signs, strict=True) if sign < 0]
    if not down:
        return f"{_listed(up)} together"
    return f"{_listed(up)} against {_listed(down)}"


def _listed(names: Sequence[str]) -> str:
    if len(names) > _NAMED:
        return f"{', '.join(names[:_NAMED])} and {len(names) - _NAMED} more"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
