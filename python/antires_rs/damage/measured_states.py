"""Two states of a structure, as values side by side: what was measured intact, and as it is now."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import chain, combinations, product
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.structural_model import End
from ..support.checks import FloatArray, label_text, members
from ..support.messages import some, warn
from ..updating.targets import AntiresonanceTargets, Part, antiresonance_objective

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

# -- The model's roots at one state, and which root of another state each has become

SHOWN = 0.5  # a root that is shown by less than this share is not seen by the test
#: Price of a root that appears or vanishes, in ln f: large damage moves roots by a fifth and more.
_BORN = 0.15


@dataclass(frozen=True)
class _Frequencies:
    """Frequencies of responses; modes have coordinates of their shapes among them."""

    response: NDArray[np.intp]
    log_f: FloatArray
    _has_shapes: ClassVar[bool] = False

    @property
    def size(self) -> int:
        """How many."""
        return int(self.log_f.size)

    @property
    def kind(self) -> NDArray[np.intp]:
        """0 of frequencies, 1 of shapes."""
        return ((self.response > 0) & self._has_shapes).astype(np.intp)


@dataclass(frozen=True)
class Roots(_Frequencies):
    """Roots that a test shows: response, ln f (n,) and, where asked for, d ln f / dp (n, parameters)."""

    slopes: FloatArray

    def between(self, low: float, high: float) -> NDArray[np.bool_]:
        """Which lie between two ln f."""
        return (self.log_f > low) & (self.log_f < high)

    def only(self, kept: NDArray[np.bool_]) -> Roots:
        """Some of them."""
        slopes = self.slopes[kept] if len(self.slopes) else self.slopes
        return replace(self, response=self.response[kept], log_f=self.log_f[kept], slopes=slopes)

    def since(self, before: Roots) -> tuple[Roots, NDArray[np.intp]]:
        """These, and which root of ``before`` each has been; -1 for a new one."""
        return self, _core.follow(before.response, before.log_f, self.response, self.log_f, _BORN)


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
    states = core.states(np.ascontiguousarray(candidates), slopes, threads, *band_hz)
    return [shown_roots(*state[:3], state[3] if slopes else None) for state in states]


def shown_roots(target: Any, hz: FloatArray, shown: FloatArray, slopes: FloatArray | None = None) -> Roots:
    """Those of all roots of a model that a test sees."""
    seen = (shown >= SHOWN) & (hz > 0.0)
    own = np.empty((0, 0)) if slopes is None else slopes[seen]
    return Roots(target[seen].astype(np.intp), np.log(hz[seen]), own)


# -- Which value belongs to which root: one to one within a response, in ascending order, with gaps
#
# Along a change of the model the roots of one response keep their order, but for pairs that merge, vanish or
# appear. So the best assignment is an alignment of two ascending lists: a pair costs its distance, what stays
# alone costs a price.

#: Probability that a root in the band is found, if the other state showed it and else; that a value is a
#: false one, anywhere in the band; and the least width of that in ln f.
FOUND, FOUND_ONCE, FALSE, _LEAST_BAND = 0.97, 0.5, 0.01, 0.1
#: In the scan: distance in ln f beyond which a value counts as unexplained, and of the responses on one line.
_FAR, _APART = 0.2, 100.0


def price_alone(low: float, high: float) -> float:
    """Price of a value without a root, anywhere between two ln f."""
    return -float(np.log(FALSE / max(high - low, _LEAST_BAND)))


@dataclass(frozen=True)
class Values(_Frequencies):
    """Measured values (m,) of one state, ascending within each response of each test."""

    std: FloatArray  # relative
    test: NDArray[np.intp]  # by number
    #: Response and test (k, 2) of all measured, with or without a value; None for those that have one.
    asked: NDArray[np.intp] | None = field(default=None, kw_only=True)

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
        """Root of each value (-1: none), the values as seen from there, and the price of those without."""
        found = np.full(self.size, -1)
        for test in self.tests:
            own = np.flatnonzero(self.test == test)
            value = (self.response[own], self.log_f[own], wider * self.std[own])
            found[own] = _core.associate(*value, roots.response, place, wider * sigma, alone, price)
        return found, self.log_f, alone * int(np.sum(found < 0))

    def unexplained(self, roots: Roots, place: FloatArray) -> float:
        """Sum of the distances of the values from the nearest roots of their responses."""
        place = np.sort(place + _APART * roots.response)
        place = np.concatenate([[-np.inf], place, [np.inf]])
        value = self.log_f + _APART * self.response
        after = np.searchsorted(place, value)
        return float(np.minimum(np.minimum(value - place[after - 1], place[after] - value), _FAR).sum())


# -- What was measured as values; one record given twice tells no more than once: sets that are equal bit by
# bit at all responses that they share are of one, and their scatter would make every error look too small

#: Relative standard deviation of a value that has none, and the least of one from a single curve: its noise
#: tells little of how another test would come out.
ASSUMED_STD = 5e-4
LEAST_STD = 2e-6  # no value is known better


class Column(NamedTuple):
    """Values of one response in one set and their standard deviations (Hz, NaN: none)."""

    freq: FloatArray
    std: FloatArray
    single: bool = False  # identified from one curve
    asked: bool = True  # looked for, with or without values


def same_data(name: str, sets: Sequence[Mapping[Any, Column]]) -> tuple[dict[int, int], list[str]]:
    """Which sets repeat an earlier one at every response with values that both have: later to earlier, and
    in words."""
    twice: dict[int, int] = {}
    for later, earlier in combinations(range(len(sets) - 1, -1, -1), 2):
        own, other = sets[later], sets[earlier]
        shared = [key for key in own if key in other and own[key].freq.size and other[key].freq.size]
        both = [pair for key in shared for pair in zip(own[key][:2], other[key][:2], strict=True)]
        if shared and all(np.array_equal(*pair, equal_nan=True) for pair in both):
            twice[later] = earlier  # the first of all
    why = "number for number, as no second test does: they are counted once."
    pairs = sorted(twice.items())
    return twice, [f"{name}[{late}] repeats the values of {name}[{early}] {why}" for late, early in pairs]


def repeated(before: Sequence[Any], now: Sequence[Any]) -> bool:
    """Whether what was identified intact is what was identified now; exact values of a model may be alike."""
    pairs = [
        [(one[key], other[key]) for key in one if key in other and (len(one[key]) or len(other[key]))]
        for one, other in product(before, now)
        if isinstance(one, AntiresonanceSet)
        and isinstance(other, AntiresonanceSet)
        and one.excitation == other.excitation
        and one.options
    ]
    return any(own and all(np.array_equal(*pair) for pair in own) for own in pairs)


def values_of(sets: Sequence[Mapping[int, Column]], twice: Mapping[int, int]) -> Values:
    """All values, by number of the response; of sets ``twice`` those of the earlier one only."""
    rows: list[tuple[Any, ...]] = []
    asked: list[tuple[int, int]] = []
    for nth, columns in enumerate(sets):
        earlier = sets[twice[nth]] if nth in twice else {}
        for number, (freq, std, single, was_asked) in columns.items():
            if number in earlier and earlier[number].freq.size:
                continue
            if was_asked:
                asked.append((number, nth))
            relative = np.where(np.isfinite(std), std / freq, ASSUMED_STD)
            relative = np.maximum(relative, ASSUMED_STD if single else LEAST_STD)
            rows += [(nth, number, np.log(f), s) for f, s in zip(freq, relative, strict=True)]
    test, response, log_f, relative = np.array(sorted(rows), dtype=np.float64).reshape(-1, 4).T.copy()
    looked_for = np.array(asked, dtype=np.intp).reshape(-1, 2)
    return Values(response.astype(np.intp), log_f, relative, test.astype(np.intp), asked=looked_for)


def unfit(before: Sequence[Any], now: Sequence[Any]) -> str:
    """The first that the data check of a test calls fatal, in words; '' where there is none."""
    for of, sets in (("of now", now), ("of the intact structure", before)):
        for each in sets:
            check = getattr(each, "data_check", None)
            for one in () if check is None else check.findings:
                # Channels that hold nothing have no values, which mislead nobody.
                left_out = one.where and all(dof in each and not len(each[dof]) for dof in one.where)
                if one.severity == "fatal" and not left_out:
                    return f"the data {of} are unfit. {one.text} {one.advice}"
    return ""


@dataclass(frozen=True)
class Responses:
    """The responses of all sets, as the core is asked for them."""

    parts: list[Part]
    labels: list[dict[Any, int]]  # numbers of the responses by label, of each set of now
    left_out: tuple[str, ...]  # sentences on values that are not compared
    assumed: bool  # whether standard deviations had to be
    measured: tuple[AntiresonanceSet, ...]
    tests: tuple[End, ...]  # force of each intact test
    noun = "antiresonances"

    def source(self, model: Any, parts: Any, *, silent: bool = False) -> _core.Objective:
        """The model's antiresonances, to be asked for; ``silent``: of responses without a value too."""
        asked = self.parts
        if silent:  # the core tells nothing of a response that has no value: any will do
            some = max(float(part[2].max(initial=0.0)) for part in asked)
            asked = [(*part[:2], part[2] if part[2].size else np.array([some]), *part[3:]) for part in asked]
        return antiresonance_objective(model, parts, asked, "squared", None, 0.0, None)

    def corrected(
        self, now: Values, roots: Roots, partner: NDArray[np.intp], beside: FloatArray
    ) -> list[AntiresonanceSet]:
        """The sets of now without what is wrong in both states."""
        sets = []
        for nth, (each, labels) in enumerate(zip(self.measured, self.labels, strict=True)):
            freq, std = {}, {}
            for label, number in labels.items():
                own = (now.test == nth) & (now.response == number)
                freq[label] = np.exp(now.log_f[own] - beside[own])
                std[label] = now.std[own] * freq[label]
            kept: Any = {"sees": each.sees, "channels": each.channels or None}
            sets.append(AntiresonanceSet(each.excitation, freq, std_hz=std, **kept))
        return sets


def measured_states(
    model: StructuralModel, baseline: Sequence[AntiresonanceSet], measured: Sequence[AntiresonanceSet]
) -> tuple[Responses, Values, Values]:
    """The responses of all sets, the intact values and those of now."""
    before, after = ([AntiresonanceTargets(model, (each,)) for each in sets] for sets in (baseline, measured))
    forces = [target.forces[0] for target in before]
    for target, each in zip(after, measured, strict=True):
        if forces and target.forces[0] not in forces:
            wanted = "sets of the intact structure with the same forces as measured"
            remedy = "Test the intact structure with the force there too, or leave that set out."
            reject("baseline", f"no set with the force at {each.excitation!r}", wanted, remedy)
    freq: dict[Response, list[FloatArray]] = {}
    sight: dict[End, set[str | None]] = {}
    for target in (*before, *after):
        for dof, force, values, sees, _ in target.parts:
            sight.setdefault(force, set()).add(sees)
            freq.setdefault((dof, force), []).append(values)
    if not any(values.size for several in freq.values() for values in several):
        reject("measured", "no antiresonance", "at least one", "Identify in a wider band, or at more dofs.")
    numbers = {response: nth for nth, response in enumerate(freq)}
    # What the sets of a force see is not known where they differ.
    common = {force: next(iter(sees)) if len(sees) == 1 else None for force, sees in sight.items()}
    together = {force: nth for nth, force in enumerate(sight)}
    columns = [[_columns(target, numbers) for target in targets] for targets in (before, after)]
    twice, repeats = zip(*map(same_data, ("baseline", "measured"), columns), strict=True)
    labels = [
        {label: numbers[dof, target.forces[0]] for label, dof in zip(each, target.dofs_of[0], strict=True)}
        for each, target in zip(measured, after, strict=True)
    ]
    notes = [
        *(note for target in (*before, *after) for note in target.left_out),
        *_not_in_both(model, before, after),
        *chain.from_iterable(repeats),
    ]
    parts = [(*each, np.concatenate(own), common[each[1]], together[each[1]]) for each, own in freq.items()]
    assumed = any(not np.isfinite(std).all() for target in (*before, *after) for std in target.stds)
    responses = Responses(parts, labels, tuple(notes), assumed, tuple(measured), tuple(forces))
    return responses, values_of(columns[0], twice[0]), values_of(columns[1], twice[1])


def _columns(target: AntiresonanceTargets, numbers: Mapping[Response, int]) -> dict[int, Column]:
    """Values by number of the response; behind the responses come channels that are none."""
    parts = zip(target.parts, target.stds, target.single, strict=True)
    n_asked = len(target.dofs_of[0])
    return {
        numbers[dof, force]: Column(freq, std, single, place < n_asked)
        for place, ((dof, force, freq, _, _), std, single) in enumerate(parts)
    }


# -- Which responses both states have, and what to say of the others

Response = tuple[End, End]  # dof and force, or dofs and forces


def warn_of_channels(
    model: StructuralModel, baseline: Sequence[AntiresonanceSet], measured: Sequence[AntiresonanceSet]
) -> None:
    """Warn of channels that one state has and the other has not under the same force, even without values."""
    intact, now = (
        {(dof, force) for dof, force, *_ in AntiresonanceTargets(model, tuple(sets)).parts}
        for sets in (baseline, measured)
    )
    forces = {force for _, force in intact} & {force for _, force in now}
    intact, now = ({one for one in every if one[1] in forces} for every in (intact, now))
    common = intact & now
    if common and intact != now:
        own = (("the intact structure", intact), ("now", now))
        counts = " and ".join(f"{len(every)} of {state}, at {_named(model, every)}" for state, every in own)
        said = f"baseline: other channels than measured: {counts}. Only {len(common)} are compared."
        warn("other_channels", said)


def _not_in_both(
    model: StructuralModel, before: Sequence[AntiresonanceTargets], after: Sequence[AntiresonanceTargets]
) -> list[str]:
    """Notes on responses with values in one state only."""
    counts: tuple[dict[Response, int], dict[Response, int]] = ({}, {})
    for targets, found in zip((before, after), counts, strict=True):
        for dof, force, freq, _, _ in (part for target in targets for part in target.parts):
            if freq.size:
                found[dof, force] = found.get((dof, force), 0) + freq.size
    intact, now = counts
    if not intact or not now:
        return []
    if not set(intact) & set(now):
        wanted = f"values at some of the dofs of measured: {_named(model, now)}"
        remedy = "Number the dofs of both tests alike, or test the intact structure at these dofs."
        reject("baseline", f"values at {_named(model, intact)}", wanted, remedy)
    notes = []
    for when, own, other, meaning in (
        ("now", now, intact, "Without an intact state they are compared with the model alone and count less"),
        ("intact", intact, now, "They tell of the model's errors, not of damage"),
    ):
        alone = [response for response in own if response not in other]
        if alone:
            total = sum(own[response] for response in alone)
            values = f"{total} value{'s' if total > 1 else ''}"
            notes.append(f"Measured {when} only: {_named(model, alone)} ({values}). {meaning}.")
    return notes


def _named(model: StructuralModel, responses: Collection[Response]) -> str:
    forces = {force for _, force in responses}
    labelled = partial(label_text, named=model.dof_label)
    at = {force: f" (force at {labelled(force)})" if len(forces) > 1 else "" for force in forces}
    ordered = sorted(responses, key=lambda one: (members(one[1]), members(one[0])))
    return some((labelled(dof, listed=True) + at[force] for dof, force in ordered), 6)


# -- How tests of the intact structure scatter, and which of them contradict each other, by how much: two are
# apart by the upper quartile of the differences of ln f, so that a few false values count for nothing

_LEAST_REPEATS = 5  # so many repeated values tell how much tests scatter
#: Difference of ln f up to which values are paired; what both tests have alone counts as so far apart.
_PAIRED = 0.1
#: An odd test differs by so many times what the others differ, and at least by this share and so many
#: standard deviations.
_TIMES, _ODD, _DEVIATIONS = 3.0, 0.002, 5.0
_CONTRADICTING = 0.01  # without a third test, or if no single one is odd, so much is more than tests scatter
_UPPER = 75.0
_WARMEST = 0.02  # what moves all values of a test by more is no temperature (ln f)


def scatter_between(values: Values, place: FloatArray, root: NDArray[np.intp]) -> float:
    """Scatter of several tests of one state over what their standard deviations say; at least 1."""
    total, spare = 0.0, 0
    for number in np.unique(root[root >= 0]):
        own = np.flatnonzero(root == number)
        weight = values.std[own] ** -2
        mean = np.sum(weight * place[own]) / weight.sum()
        total += float(np.sum(weight * (place[own] - mean) ** 2))
        spare += own.size - 1
    return float(max(np.sqrt(total / spare), 1.0)) if spare >= _LEAST_REPEATS else 1.0


#: The largest change of a test that is of its surroundings; by how much it must lower what is left, ln.
_FURTHEST, _SHOWS = 4.0, 3.0


def without_shifts(
    values: Values, place: FloatArray, root: NDArray[np.intp], ways: FloatArray
) -> tuple[Values, FloatArray]:
    """The values without what each test has of changes of all, by root (r, k) of standard deviation 1, and
    how these scatter, (k,): 0 where tests do not show them (by Schwarz's criterion)."""
    has, none = np.flatnonzero(root >= 0), np.zeros(ways.shape[1])
    weight, of_test = 1.0 / values.std[has], (values.test[has, None] == values.tests).astype(np.float64)
    each = np.einsum("it,ik->itk", of_test, ways[root[has]]).reshape(has.size, -1)
    sides = weight[:, None] * np.column_stack([place[has], each])
    for number in np.unique(root[has]):  # the mean of each root is free
        own = root[has] == number
        unit = weight[own] / np.linalg.norm(weight[own])
        sides[own] -= np.outer(unit, unit @ sides[own])
    change, _, rank, _ = np.linalg.lstsq(sides[:, 1:], sides[:, 0], rcond=1e-9)
    left = np.sum((sides[:, 0] - sides[:, 1:] @ change) ** 2)
    spare = has.size - np.unique(root[has]).size
    gained = 0.5 * spare * np.log(np.sum(sides[:, 0] ** 2) / max(left, 1e-300))
    shown = gained > 0.5 * rank * np.log(has.size) + _SHOWS
    change = change.reshape(values.tests.size, -1)
    if not rank or spare - rank < _LEAST_REPEATS or not shown or np.abs(change).max() > _FURTHEST:
        return values, none
    moved = np.einsum("it,tk,ik->i", of_test, change, ways[root[has]])
    log_f = values.log_f.copy()
    log_f[has] -= moved
    few = 1.0 + 1.0 / values.tests.size
    return replace(values, log_f=log_f), np.sqrt(few * np.sum(change**2, axis=0) / (values.tests.size - 1))


class Contradiction(NamedTuple):
    """Tests of the baseline that contradict the others, the odd one alone where it is known."""

    tests: tuple[int, ...] = ()  # positions among all sets
    apart: float = 0.0  # relative difference
    usual: float = 0.0  # that of the others, 0 where there are none


def contradiction(values: Values, forces: Sequence[End]) -> Contradiction:
    """The worst contradiction between tests with the same force; ``forces`` are those of the tests."""
    found = [Contradiction()]
    for force in sorted(set(forces), key=members):
        tests = [nth for nth, each in enumerate(forces) if each == force]
        known = {pair: one for pair in combinations(tests, 2) if (one := _apart(values, *pair)) is not None}
        for odd in tests:
            own = [known[pair] for pair in known if odd in pair]
            others = [known[pair][0] for pair in known if odd not in pair]
            if not own or not others:
                continue
            least, usual = min(apart for apart, _ in own), max(others)
            if least > max(_TIMES * usual, _ODD, _DEVIATIONS * max(std for _, std in own)):
                found.append(Contradiction((odd,), float(np.median([apart for apart, _ in own])), usual))
                break
        else:
            far = {p: gap for p, (gap, s) in known.items() if gap > max(_CONTRADICTING, _DEVIATIONS * s)}
            every = {nth for pair in far for nth in pair}
            found.append(Contradiction(tuple(sorted(every)), max(far.values(), default=0.0)))
    return max(found, key=lambda one: one.apart)


def _apart(values: Values, one: int, other: int) -> tuple[float, float] | None:
    """Difference of two tests, and its usual error; None with nothing in common."""
    change, error, alone = _between(values, one, other)
    apart = np.concatenate([np.abs(change), np.full(alone, _PAIRED)])
    if not apart.size:
        return None
    return float(np.percentile(apart, _UPPER)), float(np.median(error)) if error.size else 0.0


def moved_alike(values: Values, forces: Sequence[End]) -> FloatArray:
    """How far all values of a test lie above those of the first with its force, for each value (ln f), less
    the mean of these tests; 0 where they differ by no more than their errors, or far more."""
    found = np.zeros(values.size)
    for force in set(forces):
        tests = [nth for nth, each in enumerate(forces) if each == force]
        above = np.zeros(len(tests))
        for at, test in enumerate(tests[1:], 1):
            change, error, _ = _between(values, test, tests[0])
            own = float(np.median(change)) if change.size >= _LEAST_REPEATS else 0.0
            if own and _DEVIATIONS * np.median(error) < abs(own) < _WARMEST:
                above[at] = own
        for test, own in zip(tests, above - above.mean(), strict=True):
            found[values.test == test] = own
    return found


def _between(values: Values, one: int, other: int) -> tuple[FloatArray, FloatArray, int]:
    """How far the values of one test lie above those of another, errors of that, and how many have none."""
    changes, errors, alone = [np.empty(0)], [np.empty(0)], 0
    for number in np.unique(values.response[values.test == one]):
        a, b = (np.flatnonzero((values.test == test) & (values.response == number)) for test in (one, other))
        if b.size:
            change, error = _changes(values, a, values, b, _PAIRED)
            alone += min(a.size, b.size) - change.size
            changes.append(change)
            errors.append(error)
    return np.concatenate(changes), np.concatenate(errors), alone


def _changes(
    one: Values, a: NDArray[np.intp], other: Values, b: NDArray[np.intp], within: float
) -> tuple[FloatArray, FloatArray]:
    """How far values ``a`` lie above values ``b`` of the same response, paired in their order, and errors."""
    by = one.log_f[a][:, None] - other.log_f[b]
    alone = 0.5 * within
    partner = _core.align(np.abs(by), np.full(a.size, alone), np.full(b.size, alone))
    has = np.flatnonzero(partner >= 0)
    return by[has, partner[has]], np.hypot(one.std[a[has]], other.std[b[partner[has]]])


# -- Values that have risen since the intact state: lost stiffness lowers most of them

PAIRED_STATES = 0.3  # difference of ln f up to which values of both states are paired
#: A value has moved if it differs by so many standard deviations, and by this share at least.
_MOVED_DEVIATIONS, _MOVED = 4.0, 1e-3
_LEAST, _MOST = 3, 0.75  # so many values must have moved, and this share of them upwards


def mostly_risen(intact: Values, now: Values) -> tuple[int, int]:
    """How many values have risen, of how many that have moved; (0, 0) where these are not most of them."""
    up = moved = 0
    for number in np.unique(now.response):
        for test in np.unique(now.test):
            here = np.flatnonzero((now.response == number) & (now.test == test))
            for other in np.unique(intact.test):
                there = np.flatnonzero((intact.response == number) & (intact.test == other))
                if not here.size or not there.size:
                    continue
                change, error = _changes(now, here, intact, there, PAIRED_STATES)
                far = np.abs(change) > np.maximum(_MOVED_DEVIATIONS * error, _MOVED)
                moved += int(far.sum())
                up += int((far & (change > 0.0)).sum())
                break  # one intact test is enough
    return (up, moved) if moved >= _LEAST and up >= _MOST * moved else (0, 0)
