"""Two states of a structure, as values side by side: what was measured intact, and as it is now."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.checks import FloatArray
from ..updating.targets import AntiresonanceTargets, antiresonance_objective

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel
    from ..updating.targets import AntiresonanceTargets


# -- The model's roots at one state, and which root of another state each has become


#: A root that is shown by less than this share is not seen by the test.
SHOWN = 0.5
#: Price of a root that appears or vanishes, in ln f: large damage moves roots by a fifth and more.
_BORN = 0.15


@dataclass(frozen=True)
class Roots:
    """Roots that a test shows: response, ln f (n,) and, where asked for, d ln f / dp (n, parameters)."""

    response: NDArray[np.intp]
    log_f: FloatArray
    slopes: FloatArray

    @property
    def size(self) -> int:
        """How many."""
        return int(self.log_f.size)

    @property
    def kind(self) -> NDArray[np.intp]:
        """0: all are frequencies."""
        return np.zeros(self.size, dtype=np.intp)

    def between(self, low: float, high: float) -> NDArray[np.bool_]:
        """Which lie between two ln f."""
        return (self.log_f > low) & (self.log_f < high)

    def only(self, kept: NDArray[np.bool_]) -> Roots:
        """Some of them."""
        return Roots(
            self.response[kept], self.log_f[kept], self.slopes[kept] if len(self.slopes) else self.slopes
        )

    def since(self, before: Roots) -> tuple[Roots, NDArray[np.intp]]:
        """These, and which root of ``before`` each has been."""
        return self, follow(before, self)


class Source(Protocol):
    """What has roots of its own kind."""

    def roots(self, candidates: FloatArray, slopes: bool, threads: int) -> list[Roots]:
        """The roots at each row of ``candidates`` (m, n)."""


def roots_at(
    core: _core.Objective | Source,
    candidates: FloatArray,
    *,
    slopes: bool,
    threads: int,
    band_hz: tuple[float, float] = (0.0, np.inf),
) -> list[Roots]:
    """The roots at each row of ``candidates`` (m, n); slopes of those in the band, 0 for others."""
    if not isinstance(core, _core.Objective):
        return core.roots(candidates, slopes, threads)
    found = []
    states = core.states(np.ascontiguousarray(candidates), slopes, threads, *band_hz)
    for target, hz, shown, slope in states:
        seen = (shown >= SHOWN) & (hz > 0.0)
        found.append(Roots(target[seen].astype(np.intp), np.log(hz[seen]), slope[seen] if slopes else slope))
    return found


def follow(before: Roots, after: Roots) -> NDArray[np.intp]:
    """Number of the root of ``before`` that each root of ``after`` has been; -1 for a new one.

    Where a response has as many roots as before they keep their order; otherwise those that moved least are
    the same.
    """
    return _core.follow(before.response, before.log_f, after.response, after.log_f, _BORN)


# -- Which value belongs to which root: one to one within a response, in ascending order, with gaps
#
# Along a change of the model the roots of one response keep their order, but for pairs that merge, vanish or
# appear; and so do the values that were measured of them. So the assignment that explains a whole response
# best is an alignment of two ascending lists: a pair costs its distance, what stays alone costs a price.
#
# The prices are those of the likelihood: a root in the band is found with the probability ``FOUND`` (if the
# other state showed it; else with ``FOUND_ONCE``), and a value is a false one with ``FALSE``, anywhere in the
# band.


#: Index of what has no partner.
ALONE = -1
FOUND, FOUND_ONCE, FALSE = 0.97, 0.5, 0.01


def align(cost: FloatArray, alone_row: FloatArray, alone_column: FloatArray) -> NDArray[np.intp]:
    """Column of each row, ``ALONE`` without one: the order-preserving assignment of least cost.

    ``cost`` is (rows, columns); ``alone_row`` and ``alone_column`` are the prices of staying without partner.
    """
    return _core.align(cost, alone_row, alone_column)


def associate(
    value: tuple[NDArray[np.intp], FloatArray, FloatArray],
    root: tuple[NDArray[np.intp], FloatArray, FloatArray],
    alone: float,
    alone_root: FloatArray,
) -> NDArray[np.intp]:
    """Root of each value, ``ALONE`` without one: that of the greatest likelihood.

    ``value`` and ``root`` are group, place and standard deviation of each; both ascend within a group.
    ``alone`` is the price of a value, ``alone_root`` that of each root.
    """
    return _core.associate(*value, *root, alone, alone_root)


# -- Which responses both states have, and what to say of the others


#: So many are named.
_NAMED = 6

Response = tuple[int, int]


def not_in_both(
    model: StructuralModel, before: Sequence[AntiresonanceTargets], after: Sequence[AntiresonanceTargets]
) -> list[str]:
    """Notes on responses with values in one state only."""
    intact, now = _with_values(before), _with_values(after)
    if not before or not now:
        return []
    if not set(intact) & set(now):
        reject(
            "baseline",
            f"values at {_named(model, intact)}",
            f"values at some of the dofs of measured: {_named(model, now)}",
            "Number the dofs of both tests alike, or test the intact structure at these dofs.",
        )
    notes = []
    new, gone = [r for r in now if r not in intact], [r for r in intact if r not in now]
    if new:
        notes.append(
            f"Measured now only: {_named(model, new)} ({_listed_values(new, now)}). Without an intact state "
            "they are compared with the model alone and count less."
        )
    if gone:
        notes.append(
            f"Measured intact only: {_named(model, gone)} ({_listed_values(gone, intact)}). They tell of the "
            "model's errors, not of damage."
        )
    return notes


def _with_values(targets: Sequence[AntiresonanceTargets]) -> dict[Response, int]:
    """Responses (dof, force) and how many values they have."""
    found: dict[Response, int] = {}
    for target in targets:
        for dof, force, freq, _, _ in target.parts:
            if freq.size:
                found[dof, force] = found.get((dof, force), 0) + freq.size
    return found


def _listed_values(some: Sequence[Response], counts: dict[Response, int]) -> str:
    total = sum(counts[response] for response in some)
    return f"{total} value{'s' if total > 1 else ''}"


def _named(model: StructuralModel, responses: Sequence[Response] | dict[Response, int]) -> str:
    forces = {force for _, force in responses}
    names = [
        model.dof_label(dof) + (f" (force at {model.dof_label(force)})" if len(forces) > 1 else "")
        for dof, force in sorted(responses, key=lambda one: (one[1], one[0]))
    ]
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more


# -- Sets that hold the very same data: one record given twice tells no more than once
#
# Two tests at the same force are independent, and their scatter counts; no two of them come out with the
# same numbers at every response. Values and standard deviations that are equal bit by bit at all responses
# that two sets share are of one record, which would make every error look smaller than it is.


#: Of one set by response: values and their standard deviations (NaN: none).
Columns = Mapping[Hashable, tuple[FloatArray, FloatArray]]


def same_data(sets: Sequence[Columns]) -> dict[int, int]:
    """Which sets repeat an earlier one at every response with values that both have: later to earlier."""
    found: dict[int, int] = {}
    for later, own in enumerate(sets):
        for earlier in range(later):
            other = sets[earlier]
            shared = [key for key in own if key in other and own[key][0].size and other[key][0].size]
            if shared and all(_equal(own[key], other[key]) for key in shared):
                found[later] = earlier
                break
    return found


def _equal(one: tuple[FloatArray, FloatArray], other: tuple[FloatArray, FloatArray]) -> bool:
    return np.array_equal(one[0], other[0]) and np.array_equal(one[1], other[1], equal_nan=True)


def note_of_same_data(name: str, found: Mapping[int, int]) -> list[str]:
    """What was counted once, in words."""
    return [
        f"{name}[{later}] repeats the values of {name}[{earlier}] number for number, as no second test does: "
        "they are counted once."
        for later, earlier in found.items()
    ]


#: Relative standard deviation of a value that has none, and the least of one from a single curve: its noise
#: tells little of how another test would come out.
ASSUMED_STD = 5e-4
#: No value is known better.
LEAST_STD = 2e-6
#: So many repeated values tell how much tests scatter.
_LEAST_REPEATS = 5
#: In the scan: distance in ln f beyond which a value counts as unexplained; places of the responses on one
#: line, so that one search in it serves all.
_FAR, _APART = 0.2, 100.0

#: Response dof, force dof, frequencies (Hz), what they see, number of those measured together.
Part = tuple[int, int, FloatArray, str | None, int]


@dataclass(frozen=True)
class Values:
    """Measured values of one state, (m,) each: response by number, ln f, relative std, number of the test.

    They ascend within each response of each test. ``asked`` are response and test (k, 2) of all measured,
    with or without a value; None for those that have one.
    """

    response: NDArray[np.intp]
    log_f: FloatArray
    std: FloatArray
    test: NDArray[np.intp]
    asked: NDArray[np.intp] | None = field(default=None, kw_only=True)

    @property
    def size(self) -> int:
        """How many."""
        return int(self.log_f.size)

    @cached_property
    def tests(self) -> NDArray[np.intp]:
        """Numbers of the tests that have values."""
        return np.unique(self.test)

    @cached_property
    def _times_measured(self) -> FloatArray:
        """By response: in how many tests it was measured."""
        asked = np.stack([self.response, self.test], axis=1) if self.asked is None else self.asked
        return np.bincount(np.unique(asked, axis=0)[:, 0]).astype(np.float64)

    def times_measured(self, response: NDArray[np.intp]) -> FloatArray:
        """In how many tests each of some responses was measured."""
        times = np.zeros(max(int(response.max(initial=-1)) + 1, self._times_measured.size))
        times[: self._times_measured.size] = self._times_measured
        return times[response]

    def noisier(self, times: float) -> Values:
        """The same with larger standard deviations."""
        return replace(self, std=times * self.std)

    @property
    def frequencies(self) -> FloatArray:
        """ln f of all that have a frequency."""
        return self.log_f

    @property
    def plain(self) -> Values:
        """Frequencies alone."""
        return self

    def associated(
        self,
        roots: Roots,
        place: FloatArray,
        sigma: FloatArray,
        alone: float,
        price: FloatArray,
        wider: float = 1.0,
    ) -> tuple[NDArray[np.intp], FloatArray, float]:
        """Root of each value, test by test, the values as seen from there, and what those without one cost.

        The roots are expected at ``place`` with errors ``sigma``; ``alone`` is the price of a value without
        root, ``price`` that of each root without value; all errors count ``wider``.
        """
        found = np.full(self.size, ALONE)
        for test in self.tests:
            own = np.flatnonzero(self.test == test)
            value = (self.response[own], self.log_f[own], wider * self.std[own])
            found[own] = associate(value, (roots.response, place, wider * sigma), alone, price)
        return found, self.log_f, alone * int(np.sum(found < 0))

    def unexplained(self, roots: Roots, place: FloatArray) -> float:
        """Sum of the distances of the values from the nearest roots of their responses."""
        place = np.sort(place + _APART * roots.response)
        place = np.concatenate([[-np.inf], place, [np.inf]])
        value = self.log_f + _APART * self.response
        after = np.searchsorted(place, value)
        near = np.minimum(value - place[after - 1], place[after] - value)
        return float(np.minimum(near, _FAR).sum())


def scatter_between(values: Values, place: FloatArray, root: NDArray[np.intp]) -> float:
    """Scatter of several tests of one state over what their standard deviations say; at least 1.

    ``root`` tells which values are of one root, ``place`` the values as seen from there. 1 where fewer than
    ``_LEAST_REPEATS`` repeats tell.
    """
    total, spare = 0.0, 0
    for number in np.unique(root[root >= 0]):
        own = np.flatnonzero(root == number)
        weight = values.std[own] ** -2
        mean = np.sum(weight * place[own]) / weight.sum()
        total += float(np.sum(weight * (place[own] - mean) ** 2))
        spare += own.size - 1
    return float(max(np.sqrt(total / spare), 1.0)) if spare >= _LEAST_REPEATS else 1.0


@dataclass(frozen=True)
class Responses:
    """The responses of all sets, as the core is asked for them."""

    parts: list[Part]
    #: Of each set of now, its responses' numbers by label.
    labels: list[dict[Any, int]]
    #: Sentences on values that are not compared.
    left_out: tuple[str, ...]
    #: Whether standard deviations had to be assumed.
    assumed: bool
    measured: tuple[AntiresonanceSet, ...]
    #: Force of each test of the intact structure.
    tests: tuple[int, ...]
    noun = "antiresonances"

    def source(self, model: StructuralModel, parts: Any) -> _core.Objective:
        """The model's antiresonances, to be asked for."""
        return antiresonance_objective(model, parts, self.parts, "squared", None, 0.0, None)

    def corrected(
        self, now: Values, roots: Roots, partner: NDArray[np.intp], beside: FloatArray
    ) -> list[AntiresonanceSet]:
        """The sets of now without what is wrong in both states."""
        sets = []
        for nth, (each, labels) in enumerate(zip(self.measured, self.labels, strict=True)):
            freq, std = {}, {}
            for label, number in labels.items():
                own = (now.test == nth) & (now.response == number)
                corrected = np.exp(now.log_f[own] - beside[own])
                order = np.argsort(corrected, kind="stable")
                freq[label] = corrected[order]
                std[label] = now.std[own][order] * freq[label]
            channels = each.channels or None
            sets.append(
                AntiresonanceSet(each.excitation, freq, std_hz=std, sees=each.sees, channels=channels)
            )
        return sets


def measured_states(
    model: StructuralModel, baseline: Sequence[AntiresonanceSet], measured: Sequence[AntiresonanceSet]
) -> tuple[Responses, Values, Values]:
    """The responses of all sets, the intact values and those of now."""
    before = [AntiresonanceTargets(model, (each,)) for each in baseline]
    after = [AntiresonanceTargets(model, (each,)) for each in measured]
    _same_forces(before, after, measured)
    numbers: dict[tuple[int, int], int] = {}
    freq: list[list[FloatArray]] = []
    sight: dict[int, set[str | None]] = {}
    for target in (*before, *after):
        for dof, force, values, sees, _ in target.parts:
            sight.setdefault(force, set()).add(sees)
            if numbers.setdefault((dof, force), len(numbers)) == len(freq):
                freq.append([])
            freq[numbers[dof, force]].append(values)
    together = {force: nth for nth, force in enumerate(sight)}
    twice = [same_data([_columns(target) for target in targets]) for targets in (before, after)]
    parts: list[Part] = [
        (dof, force, np.concatenate(freq[nth]), _common(sight[force]), together[force])
        for (dof, force), nth in numbers.items()
    ]
    if not any(part[2].size for part in parts):
        reject("measured", "no antiresonance", "at least one", "Identify in a wider band, or at more dofs.")
    responses = Responses(
        parts,
        [
            {
                label: numbers[dof, target.forces[0]]
                for label, dof in zip(each, target.dofs_of[0], strict=True)
            }
            for each, target in zip(measured, after, strict=True)
        ],
        (
            *(note for target in (*before, *after) for note in target.left_out),
            *not_in_both(model, before, after),
            *note_of_same_data("baseline", twice[0]),
            *note_of_same_data("measured", twice[1]),
        ),
        any(not np.isfinite(std).all() for target in (*before, *after) for std in target.stds),
        tuple(measured),
        tuple(target.forces[0] for target in before),
    )
    return responses, _values(before, numbers, twice[0]), _values(after, numbers, twice[1])


def _columns(target: AntiresonanceTargets) -> dict[Hashable, tuple[FloatArray, FloatArray]]:
    """Values and their standard deviations by response."""
    parts = zip(target.parts, target.stds, strict=True)
    return {(dof, force): (freq, std) for (dof, force, freq, _, _), std in parts}


def _common(sees: set[str | None]) -> str | None:
    """What all sets of a force see; not known where they differ."""
    return next(iter(sees)) if len(sees) == 1 else None


def _same_forces(
    before: list[AntiresonanceTargets],
    after: list[AntiresonanceTargets],
    measured: Sequence[AntiresonanceSet],
) -> None:
    known = {target.forces[0] for target in before}
    for target, each in zip(after, measured, strict=True):
        if known and target.forces[0] not in known:
            reject(
                "baseline",
                f"no set with the force at {each.excitation!r}",
                "sets of the intact structure with the same forces as measured",
                "Test the intact structure with the force there too, or leave that set out.",
            )


def _values(
    targets: list[AntiresonanceTargets], numbers: dict[tuple[int, int], int], twice: dict[int, int]
) -> Values:
    """All values; of sets ``twice`` (later to earlier) those of the earlier one only."""
    rows: list[tuple[int, int, float, float]] = []
    asked: list[tuple[int, int]] = []
    for nth, target in enumerate(targets):
        known = _columns(targets[twice[nth]]) if nth in twice else {}
        parts = zip(target.parts, target.stds, target.single, strict=True)
        for place, ((dof, force, freq, _, _), std, single) in enumerate(parts):
            if (dof, force) in known and known[dof, force][0].size:
                continue
            if place < len(target.dofs_of[0]):  # behind them come channels that are no responses
                asked.append((numbers[dof, force], nth))
            least = ASSUMED_STD if single else LEAST_STD
            relative = np.where(np.isfinite(std), std / freq, ASSUMED_STD)
            rows += [
                (nth, numbers[dof, force], float(np.log(f)), max(float(s), least))
                for f, s in zip(freq, relative, strict=True)
            ]
    rows.sort()
    return Values(
        np.array([row[1] for row in rows], dtype=np.intp),
        np.array([row[2] for row in rows], dtype=np.float64),
        np.array([row[3] for row in rows], dtype=np.float64),
        np.array([row[0] for row in rows], dtype=np.intp),
        asked=np.array(asked, dtype=np.intp).reshape(-1, 2),
    )


# -- Tests of the intact structure that contradict each other: which one, and by how much
#
# Values of two tests of the same response are paired in their order; how far two tests are apart is the
# upper quartile of the differences of ln f, so that a few false values count for nothing. Ordinary scatter
# from test to test is no contradiction: one test must differ from all others by several times what these
# differ among themselves. Of two tests that are far apart none can be named.


#: Difference of ln f up to which values are paired; what both tests have alone counts as so far apart.
_PAIRED = 0.1
#: An odd test differs by so many times what the others differ, and at least by this share and so many
#: standard deviations.
_TIMES, _ODD, _DEVIATIONS = 3.0, 0.002, 5.0
#: Without a third test, or if no single one is odd, so much is more than tests scatter.
_APART_CONTRADICTION = 0.01
_UPPER = 75.0


@dataclass(frozen=True)
class Contradiction:
    """Positions of the tests among all baseline sets, the odd one alone where it is known.

    ``apart`` is their relative difference, ``usual`` that of the others (0 where there are none).
    """

    tests: tuple[int, ...]
    apart: float
    usual: float


def contradiction(values: Values, forces: Sequence[int]) -> Contradiction | None:
    """The worst contradiction between tests with the same force; ``forces`` are those of the tests."""
    found = []
    for force in sorted(set(forces)):
        tests = [nth for nth, each in enumerate(forces) if each == force]
        apart = {pair: _apart(values, *pair) for pair in combinations(tests, 2)}
        known = {pair: one for pair, one in apart.items() if one is not None}
        one = _worst(tests, known)
        if one is not None:
            found.append(one)
    return max(found, key=lambda one: one.apart, default=None)


def _worst(tests: list[int], known: dict[tuple[int, int], tuple[float, float]]) -> Contradiction | None:
    for odd in tests:
        own = [known[pair] for pair in known if odd in pair]
        others = [known[pair][0] for pair in known if odd not in pair]
        if not own or not others:
            continue
        least, usual = min(apart for apart, _ in own), max(others)
        if least > max(_TIMES * usual, _ODD, _DEVIATIONS * max(std for _, std in own)):
            return Contradiction((odd,), float(np.median([apart for apart, _ in own])), usual)
    far = {
        pair: apart
        for pair, (apart, std) in known.items()
        if apart > max(_APART_CONTRADICTION, _DEVIATIONS * std)
    }
    if not far:
        return None
    return Contradiction(tuple(sorted({nth for pair in far for nth in pair})), max(far.values()), 0.0)


def _apart(values: Values, one: int, other: int) -> tuple[float, float] | None:
    """Upper quartile of the differences between two tests, and their usual error; None with nothing in
    common."""
    differences: list[FloatArray] = []
    errors: list[FloatArray] = []
    for number in np.unique(values.response[values.test == one]):
        a = np.flatnonzero((values.test == one) & (values.response == number))
        b = np.flatnonzero((values.test == other) & (values.response == number))
        if not b.size:
            continue
        cost = np.abs(values.log_f[a][:, None] - values.log_f[b])
        partner = align(cost, np.full(a.size, 0.5 * _PAIRED), np.full(b.size, 0.5 * _PAIRED))
        has = np.flatnonzero(partner >= 0)
        moved = min(a.size, b.size) - has.size
        differences += [cost[has, partner[has]], np.full(moved, _PAIRED)]
        errors.append(np.hypot(values.std[a[has]], values.std[b[partner[has]]]))
    apart, std = (np.concatenate([np.empty(0), *parts]) for parts in (differences, errors))
    if not apart.size:
        return None
    return float(np.percentile(apart, _UPPER)), float(np.median(std)) if std.size else 0.0
