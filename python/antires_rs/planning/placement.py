"""What sensors could measure, their antiresonances with slopes and errors, and the best sets of sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, islice
from math import comb
from typing import Any

import numpy as np

from .. import _core
from ..damage.measured_states import LEAST_STD, SHOWN, Roots, roots_at
from ..damage.shapes import Joined
from ..measured.response_table import MOST_SETS
from ..models.parameters import Parameter
from ..models.structural_model import End, StructuralModel
from ..support.checks import BoolArray, ComplexArray, FloatArray, IntArray, finite_scalar, members
from ..updating.targets import antiresonance_objective

_MARGIN = 1.5  # the core looks so far beyond the highest measured value
#: A minor is zero if at these parts of the band it is less than such a share of the product of its rows.
_WHERE_ZERO, _ZERO = np.array([0.31, 0.57, 0.83, 0.97]), 1e-9


@dataclass(frozen=True)
class Layout:
    """Where a test measures and shakes a structure, in which band, and what is identified of it."""

    model: StructuralModel
    sensors: tuple[int, ...]
    force: End
    band_hz: tuple[float, float]
    sees: str
    #: The model with more than it was built with, where its roots are to be those of this.
    base: Joined | None = None

    @cached_property
    def responses(self) -> tuple[End, ...]:
        """What values belong to: the sensors; of r forces at once sets of r sensors, some of very many.

        Those whose minor is zero, as the forces reach them through fewer than r paths, show nothing, not even
        that they lack a root of all others.
        """
        if isinstance(self.force, int):
            return self.sensors
        every = list(combinations(range(len(self.sensors)), len(self.force)))
        some = np.array(every[:: max(-(-len(every) // MOST_SETS), 1)], dtype=np.intp)
        low, high = self.band_hz
        freq = low + (high - low) * _WHERE_ZERO
        h = [self.model.frf(self.sensors, k, freq, damping_ratio=0.0) for k in self.force]
        own = np.stack(h, axis=-1)[some].swapaxes(1, 2)  # (n_sets, n_freq, r, r)
        size = np.prod(np.linalg.norm(own, axis=3), axis=2)
        loud = (np.abs(np.linalg.det(own)) > _ZERO * size).any(axis=1)
        return tuple(
            tuple(self.sensors[at] for at in one) for one in some[loud if loud.any() else slice(None)]
        )

    def roots(self, parameters: Sequence[Parameter], high_hz: float, sees: Any = None) -> _core.Objective:
        """The core's objective of the responses, for its roots up to ``high_hz`` (and none of its values)."""
        parts = [(dof, self.force, np.array([high_hz / _MARGIN]), sees, 0) for dof in self.responses]
        core = self.model.description.core_parameters(parameters)
        built: Any = self.base or self.model
        return antiresonance_objective(built, core, parts, "squared", None, 0.0, None)

    def inside(self, roots: Roots) -> BoolArray:
        """Which roots lie in the band."""
        low, high = np.log(np.maximum(self.band_hz, 1e-300))
        return np.asarray((roots.log_f >= low) & (roots.log_f <= high))


# -- How well a test tells an antiresonance: the Cramer-Rao bound for one response under random excitation
#
# With a white force and white noise of the sensor, both over the band B, a record of the length T tells of
# the logarithms of the zeros of H
#
# .. math:: I_{mn} = 2 T \int_B \frac{\mathrm{Re}(g_m^* g_n)}{\nu^2 \overline{|H|^2}} \, df, \qquad
#           g_m = H \, \frac{2 \omega_m^2 + 2 j \zeta \omega \omega_m}
#                          {\omega_m^2 - \omega^2 + 2 j \zeta \omega \omega_m},
#
# nu being the noise as a fraction of the channel's rms, the bar a mean over the band. The complex gain of H
# is unknown too (L. Ljung, System Identification, 2nd ed. 1999, section 7.4).

#: The band is looked at from this share of its upper end on, with so many lines in a half-power bandwidth.
_LOWEST, _LINES, _FEWEST_LINES, _MOST_LINES = 1e-3, 4.0, 2000, 20_000


@dataclass(frozen=True)
class ExpectedErrors:
    """Noise, length and damping of a test; or the relative standard deviation of every value."""

    noise: float
    duration_s: float
    damping_ratio: float
    std: float | None

    def __post_init__(self) -> None:
        finite_scalar("noise", self.noise, low=0.0, high=10.0)
        finite_scalar("duration_s", self.duration_s, low=0.0, low_open=True, unit="s")
        finite_scalar("damping_ratio", self.damping_ratio, low=1e-4, high=0.5)
        if self.std is not None:
            finite_scalar("std", self.std, low=0.0, high=0.5, low_open=True)

    def __str__(self) -> str:
        if self.std is not None:
            return "std as given"
        bound = f"the Cramer-Rao bound for {100.0 * self.noise:g} % noise, {self.duration_s:g} s and "
        return f"{bound}{100.0 * self.damping_ratio:g} % damping; tests repeat less well, say so by std="

    def _curve(
        self, layout: Layout, response: End, freq: FloatArray, width: FloatArray
    ) -> tuple[ComplexArray, Any]:
        """The response, or the minor, and what its noise over that of the sensors is a share of."""
        rows, columns = members(response), members(layout.force)
        h = np.stack([layout.model.frf(rows, k, freq, damping_ratio=self.damping_ratio) for k in columns])
        if len(rows) == 1:
            return h[0, 0], float(width @ np.abs(h[0, 0]) ** 2) / float(width.sum())
        # To first order each sensor's noise enters the minor by the cofactors of its row.
        h = np.moveaxis(h, 2, 0)  # (n_freq, forces, responses)
        r = len(rows)
        kept = [[at for at in range(r) if at != gone] for gone in range(r)]
        cofactors = np.array(
            [[np.linalg.det(h[:, kept[k]][:, :, kept[i]]) for i in range(r)] for k in range(r)]
        )
        power = np.sum(width[:, None] * np.sum(np.abs(h) ** 2, axis=1), axis=0) / width.sum()
        return np.linalg.det(h), np.einsum("kif,i->f", np.abs(cofactors) ** 2, power)

    def of(self, layout: Layout, roots_hz: list[FloatArray]) -> list[FloatArray]:
        """Relative standard deviations of the roots of each sensor's response."""
        if self.std is not None:
            return [np.full(own.size, max(self.std, LEAST_STD)) for own in roots_hz]
        count = int(np.clip(-np.log(_LOWEST) * _LINES / self.damping_ratio, _FEWEST_LINES, _MOST_LINES))
        freq = np.geomspace(_LOWEST * layout.band_hz[1], layout.band_hz[1], count)
        width = np.gradient(freq)
        found = []
        for response, own in zip(layout.responses, roots_hz, strict=True):
            if not own.size:
                found.append(np.empty(0))
                continue
            curve, power = self._curve(layout, response, freq, width)
            damping = 2j * self.damping_ratio * freq * own[:, None]
            along = curve * (2.0 * own[:, None] ** 2 + damping) / (own[:, None] ** 2 - freq**2 + damping)
            rows = np.vstack([along, curve, 1j * curve]) * np.sqrt(2.0 * self.duration_s * width / power)
            parts = np.hstack([rows.real, rows.imag])
            # The inverse of parts parts', by its triangle: near roots make it nearly singular.
            size = np.linalg.norm(parts, axis=1)
            triangle = np.linalg.qr((parts / size[:, None]).T, mode="r")
            std = self.noise * np.linalg.norm(np.linalg.pinv(triangle), axis=1)[: own.size] / size[: own.size]
            found.append(np.maximum(std, LEAST_STD))
        return found


#: Relative distance up to which roots of two responses are one, and from which on transmissibilities show
#: both in full, as in the core (update/objective.rs).
ONE, APART = 1e-6, 1e-3
_STEEPEST = 3.0  # roots that move more, relatively to the change, are about to merge


@dataclass(frozen=True)
class VirtualRoots:
    """Roots (n,) in the band for one force."""

    sensor: IntArray  # number of the candidate
    slopes: FloatArray  # d ln f / dp, (n, p)
    std: FloatArray  # relative, of a value
    common: dict[int, FloatArray]  # of roots that some share: whether each candidate shows it, 0 or 1


def virtual_roots(
    layout: Layout, parameters: Sequence[Parameter], nominal: FloatArray, errors: ExpectedErrors, threads: int
) -> VirtualRoots:
    """The roots of every candidate in the band, less those that are about to merge or vanish."""
    frf = layout.sees == "frf"
    core = layout.roots(parameters, layout.band_hz[1], "frf" if frf else None)
    found = roots_at(core, nominal[None], slopes=True, threads=threads)[0]
    relative = found.slopes * np.where(nominal == 0.0, 1.0, nominal)
    found = found.only(layout.inside(found) & (np.abs(relative).max(axis=1, initial=0.0) < _STEEPEST))
    own = [found.log_f[found.response == nth] for nth in range(len(layout.responses))]
    std = errors.of(layout, [np.exp(each) for each in own])
    common = {} if frf else _common(own)
    return VirtualRoots(found.response, found.slopes, np.concatenate([np.empty(0), *std]), common)


def _common(log_f: list[FloatArray]) -> dict[int, FloatArray]:
    """Whether each candidate shows the roots that not all others show in full."""
    starts = np.concatenate([[0], np.cumsum([own.size for own in log_f])])
    found: dict[int, FloatArray] = {}
    for nth, own in enumerate(log_f):
        for other, theirs in enumerate(log_f):
            if other == nth or not own.size or not theirs.size:
                continue
            apart = np.abs(own[:, None] - theirs)
            if apart.min() >= APART:
                continue
            # Each root has one counterpart at most.
            partner = _core.align(apart, np.full(own.size, 0.5 * APART), np.full(theirs.size, 0.5 * APART))
            for root in np.flatnonzero(partner >= 0):
                share = (apart[root, partner[root]] - ONE) / (APART - ONE) >= SHOWN
                row = found.setdefault(int(starts[nth] + root), np.ones(len(log_f)))
                row[other] = float(share)
    return found


# -- The Fisher information of a set of sensors, and what it is worth
#
# With parameters in units of their spread before the test: ln det (1 + I(S)) / 2 nats ("determinant"), or the
# least ln (1 + I_ee(S)) / 2 of any parameter ("worst"), to which a hundredth of the mean is added to decide
# between equals. Reference: K. Chaloner and I. Verdinelli, Statistical Science 10 (1995) 273-304.

CRITERIA = ("determinant", "worst")
_MEAN = 0.01  # share of the mean in the criterion of the worst
_AT_ONCE = 2_000_000  # numbers of the sets that are judged together


@dataclass(frozen=True)
class Information:
    """Information of every response, (c, p, p), and of roots (s,) that some of them share.

    A response is that of a candidate; of r forces at once each is of a set of r candidates, ``sets``.
    """

    own: FloatArray
    owner: IntArray  # response of such a root, (s,)
    rows: FloatArray  # its slopes over its error, (s, p)
    share: FloatArray  # whether each other response shows it, (s, c) of 0 or 1
    n_candidates: int
    sets: IntArray | None = None  # candidates of each response, (c, r)

    def responses(self, chosen: Sequence[int]) -> IntArray:
        """Numbers of the responses that a set of candidates has."""
        return np.flatnonzero(self._members(np.array([chosen], dtype=np.intp))[0])

    @cached_property
    def _full(self) -> FloatArray:
        """Information of every candidate, all of its roots seen, (c, p, p)."""
        full = self.own.copy()
        for nth in np.unique(self.owner):
            rows = self.rows[self.owner == nth]
            full[nth] += rows.T @ rows
        return full

    def of(self, chosen: Sequence[int]) -> FloatArray:
        """Information of a set of candidates, (p, p)."""
        at = np.array(chosen, dtype=np.intp) if self.sets is None else self.responses(chosen)
        members_of = self._members(np.array([chosen], dtype=np.intp))
        rows = self.rows[np.isin(self.owner, at) & ~self._hidden(members_of)[0]]
        return np.asarray(self.own[at].sum(axis=0) + rows.T @ rows)

    def _members(self, sets: IntArray) -> FloatArray:
        """Whether each response is of candidates in each set, 0 or 1, (sets, c)."""
        member = np.zeros((len(sets), self.n_candidates))
        np.put_along_axis(member, sets, 1.0, axis=1)
        return member if self.sets is None else member[:, self.sets].min(axis=2)

    def _hidden(self, member: FloatArray) -> BoolArray:
        """Roots of members that all other members share, (sets, s): these do not show them."""
        alone = member.sum(axis=1, keepdims=True) < 2.0  # there is nothing to share with
        shown = member @ (self.share > 0.0).T.astype(np.float64) > 0.0
        return np.asarray((member[:, self.owner] > 0.0) & ~(shown | alone))

    def n_hidden(self, chosen: Sequence[int]) -> int:
        """How many roots of a set of candidates all of these share."""
        return int(self._hidden(self._members(np.array([chosen], dtype=np.intp))).sum())

    def worths(self, sets: IntArray, criterion: str, all_shown: bool = False) -> FloatArray:
        """Worth of each of several sets (sets, n) of candidates, the larger the better; ``all_shown``: no
        root is hidden."""
        size = self.own.shape[1]
        each = size**2 if criterion == "determinant" else size
        step = max(_AT_ONCE // max(each, self.owner.size, self.own.shape[0], 1), 1)
        parts = [self._worths(sets[at : at + step], criterion, all_shown) for at in range(0, len(sets), step)]
        return np.concatenate([np.empty(0), *parts])

    def _worths(self, sets: IntArray, criterion: str, all_shown: bool) -> FloatArray:
        member = self._members(sets)
        hidden = self._hidden(member) & (not all_shown)
        some = np.flatnonzero(hidden.any(axis=1))
        if criterion == "determinant":
            found = np.tensordot(member, self._full, 1)
            for nth in some.tolist():
                rows = self.rows[hidden[nth]]
                found[nth] -= rows.T @ rows
            found += np.eye(self.own.shape[1])
            return np.asarray(0.5 * np.linalg.slogdet(found)[1])
        diagonal = member @ np.diagonal(self._full, axis1=1, axis2=2)
        diagonal[some] -= hidden[some] @ self.rows**2
        each = 0.5 * np.log1p(np.maximum(diagonal, 0.0))
        return np.asarray(each.min(axis=1) + _MEAN * each.mean(axis=1))


@dataclass(frozen=True)
class Worth:
    """What sets are worth: their mean over some structures that the model may stand for."""

    each: tuple[Information, ...]
    criterion: str

    def of(self, sets: Sequence[Sequence[int]], all_shown: bool = False) -> FloatArray:
        """Worth of each of several sets, as of :class:`Information`."""
        some = np.array(sets, dtype=np.intp)
        return np.asarray(
            np.mean([each.worths(some, self.criterion, all_shown) for each in self.each], axis=0)
        )


def information(roots: VirtualRoots, layout: Layout, spread: FloatArray, tests: int) -> Information:
    """Of one force; ``spread`` (p,) are the units, ``tests`` the number of values in each difference."""
    responses = layout.responses
    rows = roots.slopes * spread / (np.sqrt(tests) * roots.std[:, None])
    common = np.array(sorted(roots.common), dtype=np.intp)
    alone = np.setdiff1d(np.arange(rows.shape[0]), common)
    own = np.zeros((len(responses), rows.shape[1], rows.shape[1]))
    for nth in range(len(responses)):
        mine = rows[alone[roots.sensor[alone] == nth]]
        own[nth] = mine.T @ mine
    share = np.array([roots.common[root] for root in common.tolist()]).reshape(common.size, len(responses))
    # A root's own response shows nothing beyond itself.
    share[np.arange(common.size), roots.sensor[common]] = 0.0
    sets = None
    if not isinstance(layout.force, int):
        sets = np.array([[layout.sensors.index(dof) for dof in members(one)] for one in responses])
    return Information(own, roots.sensor[common], rows[common], share, len(layout.sensors), sets)


# -- The best sets of sensors: greedy forwards and backwards, then exchange of one or two; or all sets
#
# References: V. V. Fedorov, Theory of Optimal Experiments, 1972 (exchange); D. C. Kammer, Sensor placement
# for on-orbit modal identification, J. Guidance 14 (1991) 251-259 (backwards).

_LEAST = 1e-10  # an exchange must add at least this share
_MOST_EXCHANGES = 20_000  # so many exchanges or sets are tried at once
_MOST_BACKWARDS = 150  # above so many candidates the search goes forwards only


@dataclass(frozen=True)
class Round:
    """One step of the search.

    Attributes
    ----------
    added, removed : int or None
        Dof of the sensor that joined, and of the one that went.
    worth : float
        Of the set after it.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.plan_test(ar.cases.chain8().model, n_sensors=2, excitations=0).rounds[0].added
    0
    """

    added: int | None
    removed: int | None
    worth: float


@dataclass(frozen=True)
class Placed:
    """The best set found for one force: numbers of the candidates, its worth, how it was found."""

    chosen: tuple[int, ...]
    worth: float
    rounds: tuple[Round, ...]


def greedy(worth: Worth, n: int) -> Placed:
    """Greedy with exchange."""
    directions = (False, True) if worth.each[0].n_candidates <= _MOST_BACKWARDS else (False,)
    ends = [_exchanged(worth, _one_by_one(worth, n, backwards)) for backwards in directions]
    return max(ends, key=lambda one: one.worth)


def exhaustive(worth: Worth, n: int) -> Placed:
    """Of all sets of n candidates the best."""
    every = combinations(range(worth.each[0].n_candidates), n)
    best = -np.inf, tuple(range(n))
    while some := list(islice(every, _MOST_EXCHANGES)):
        worths = worth.of(some)
        at = int(np.argmax(worths))
        best = max(best, (float(worths[at]), some[at]), key=lambda one: one[0])
    return Placed(best[1], best[0], ())


def _one_by_one(worth: Worth, n: int, backwards: bool) -> Placed:
    """The sensor that adds most joins; or, backwards, from all candidates, the one missed least goes."""
    every = list(range(worth.each[0].n_candidates))
    chosen, rounds = every if backwards else [], []
    while len(chosen) != n:
        moves = chosen if backwards else [c for c in every if c not in chosen]
        sets = [[o for o in chosen if o != c] if backwards else [*chosen, c] for c in moves]
        worths = worth.of(sets)
        best = int(np.argmax(worths))
        chosen = sets[best]
        added, removed = (None, moves[best]) if backwards else (moves[best], None)
        rounds.append(Round(added, removed, float(worths[best])))
    return Placed(tuple(chosen), float(worth.of([chosen])[0]), tuple(rounds))


def _exchanged(worth: Worth, start: Placed) -> Placed:
    chosen, now, rounds = list(start.chosen), start.worth, list(start.rounds)
    while better := _better(worth, chosen, now):
        now, joins, goes = better
        for new, old in zip(joins, goes, strict=True):
            chosen[chosen.index(old)] = new
            rounds.append(Round(new, old, now))
    return Placed(tuple(chosen), now, tuple(rounds))


def _better(
    worth: Worth, chosen: list[int], now: float
) -> tuple[float, tuple[int, ...], tuple[int, ...]] | None:
    """The best exchange of one sensor or, if none helps and there are not too many, of two."""
    outside = [c for c in range(worth.each[0].n_candidates) if c not in chosen]
    for size in (1, 2):
        if comb(len(chosen), size) * comb(len(outside), size) > _MOST_EXCHANGES:
            return None
        least = now + _LEAST * abs(now)
        tried, sets = [], []
        for goes in combinations(chosen, size):
            kept = [c for c in chosen if c not in goes]
            joining = _promising(worth, kept, outside, size, least)
            tried += [(goes, joins) for joins in joining]
            sets += [[*kept, *joins] for joins in joining]
        if not tried:
            continue
        worths = worth.of(sets)
        best = int(np.argmax(worths))
        if worths[best] > least:
            goes, joins = tried[best]
            return float(worths[best]), joins, goes
    return None


def _promising(
    worth: Worth, kept: list[int], outside: list[int], size: int, least: float
) -> list[tuple[int, ...]]:
    """What may join the kept ones and be worth more than ``least``: one or two, these by what each adds."""
    if size == 1 or worth.each[0].sets is not None or worth.criterion != "determinant" or not kept:
        return list(combinations(outside, size))
    alone = worth.of([kept], all_shown=True)[0]
    gain = worth.of([[*kept, c] for c in outside], all_shown=True) - alone
    a, b = np.triu_indices(len(outside), 1)
    enough = alone + gain[a] + gain[b] > least
    return [(outside[i], outside[j]) for i, j in zip(a[enough].tolist(), b[enough].tolist(), strict=True)]
