"""Which antiresonance of a test is which of the baseline, one list of places for all; and sensors that fail.

Every test is matched to the places of the baseline, so that a lost value does not drift. What moves all
values alike (temperature) is taken off first: the median of the shifts that a first match finds.
"""

from __future__ import annotations

from bisect import insort
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.matching import KNOWN, paired
from ..measured.response_table import ResponseTable, label_array, rows_with
from ..signals.channel_checks import CLIPPED, DEAD, DROPOUTS, DUPLICATED, QUADRATURE, SPIKES, TIME_SHIFT
from ..signals.one_force import NOISE
from ..support.checks import FloatArray

#: A value that so large a part of the baseline's tests has is followed; the others are told as clutter.
REGULAR = 0.5
RARE = 0.1  # what a smaller part has is no place: it is strange wherever it appears
_PRUNE = 50
FEWEST = 3  # a common shift is that of so many values at least


@dataclass(frozen=True)
class Places:
    """Where the m antiresonances of the baseline are, ascending by response; ``rate`` of tests have each.

    ``followed``: all tests were followed from values there, so that nothing is to be matched.
    """

    excitation: Any
    dofs: tuple[Any, ...]
    dof: NDArray[Any]
    freq_hz: FloatArray
    rate: FloatArray
    followed: bool = False

    @property
    def regular(self) -> NDArray[np.bool_]:
        """Those that are followed, (m,)."""
        return self.rate >= REGULAR

    def of(self, dof: Any) -> NDArray[np.intp]:
        """Indices of a response's places."""
        return np.flatnonzero(rows_with(self.dof, dof))


@dataclass(frozen=True)
class Values:
    """The values of n tests at the m places, and ``std`` of their logarithms, NaN where not known.

    ``looked``: whether the test has the response at all; ``strange``: (dof, Hz) of what no place takes.
    """

    log_hz: FloatArray
    std: FloatArray
    looked: NDArray[np.bool_]
    strange: tuple[tuple[tuple[Any, float], ...], ...]

    def without(self, faults: Mapping[int, Sequence[Any]], places: Places) -> Values:
        """Without the responses at fault, by test."""
        log_hz, looked, strange = self.log_hz.copy(), self.looked.copy(), list(self.strange)
        for test, here in faults.items():
            dofs = [fault.dof for fault in here]
            gone = rows_with(places.dof, *dofs)
            log_hz[test, gone], looked[test, gone] = np.nan, False
            strange[test] = tuple(one for one in strange[test] if one[0] not in dofs)
        return Values(log_hz, self.std, looked, tuple(strange))

    def take(self, chosen: Any) -> Values:
        """Those of some tests."""
        at = np.arange(len(self.strange))[chosen]
        strange = tuple(self.strange[i] for i in at.tolist())
        return Values(self.log_hz[at], self.std[at], self.looked[at], strange)


def places_of(sets: Sequence[AntiresonanceSet], max_shift: float) -> Places:
    """The places of a baseline: what at least a tenth of its tests have, or what was followed in all."""
    known = [{(dof, f) for dof in one for f in places_in(one, dof).tolist()} for one in sets if one.followed]
    if len(known) == len(sets) and all(one == known[0] for one in known):
        dofs = tuple(sets[0])
        every = sorted(known[0], key=lambda place: (dofs.index(place[0]), place[1]))
        origin = [(dof, f) for one in sets for dof in one for f in one.tables[dof].scores[KNOWN].tolist()]
        times = Counter(origin)
        freq, rate = np.array([(place[1], times[place] / len(sets)) for place in every]).T.copy()
        return Places(sets[0].excitation, dofs, label_array([dof for dof, _ in every]), freq, rate, True)
    counts = [sum(map(len, one.tables.values())) for one in sets]
    typical = float(np.median(counts))  # Begin with a test that is as rich as most.
    first, *others = sorted(range(len(sets)), key=lambda i: abs(counts[i] - typical))
    dofs = tuple(dict.fromkeys(dof for one in sets for dof in one))
    groups: dict[Any, list[list[float]]] = {dof: [[f] for f in sets[first].get(dof, ())] for dof in dofs}
    for count, i in enumerate(others, start=1):
        if count % _PRUNE == 0:
            groups = {dof: [one for one in groups[dof] if len(one) >= RARE * count] for dof in dofs}
        where = {dof: np.array([_median(group) for group in groups[dof]]) for dof in dofs}
        matches, shift = _matched(where, sets[i], max_shift)
        for dof, (pairs, new) in matches.items():
            values = sets[i][dof] / np.exp(shift)
            for place, row in pairs:
                insort(groups[dof][place], values[row])
            groups[dof] += [[values[row]] for row in new]
    columns: list[tuple[Any, float, float]] = []
    for dof in dofs:
        tests = sum(dof in one for one in sets)
        seen = [one for one in groups[dof] if len(one) >= max(2.0, RARE * tests)]
        columns += sorted((dof, float(_median(one)), len(one) / tests) for one in seen)
    freq, rate = np.array([column[1:] for column in columns]).reshape(-1, 2).T.copy()
    return Places(sets[0].excitation, dofs, label_array([dof for dof, _, _ in columns]), freq, rate)


def places_in(one: AntiresonanceSet, dof: Any) -> FloatArray:
    """Places in Hz that were looked at in a set of values followed."""
    own = np.asarray(one.tables[dof].scores.get(KNOWN, ()), dtype=np.float64)
    return np.concatenate([own[~np.isnan(own)], one.not_seen.get(dof, ())])


def _median(ascending: Sequence[float]) -> float:
    count = len(ascending)
    return 0.5 * (ascending[(count - 1) // 2] + ascending[count // 2])


def values_of(sets: Sequence[AntiresonanceSet | None], places: Places, max_shift: float) -> Values:
    """Values of tests at the places; a row of NaN for a test without a set."""
    shape = len(sets), places.freq_hz.size
    log_hz, std, looked = np.full(shape, np.nan), np.full(shape, np.nan), np.zeros(shape, dtype=bool)
    strange: list[tuple[tuple[Any, float], ...]] = []
    at = {dof: places.of(dof) for dof in places.dofs}
    where = {dof: places.freq_hz[rows] for dof, rows in at.items()}
    for i, one in enumerate(sets):
        left: list[tuple[Any, float]] = []
        if one is not None:
            for dof, (pairs, new) in _matched(where, one, max_shift, places)[0].items():
                table = one.tables[dof]
                looked[i, at[dof]] = True
                place, row = np.array(pairs, dtype=int).reshape(-1, 2).T
                log_hz[i, at[dof][place]] = np.log(table.freq_hz[row])
                std[i, at[dof][place]] = table.std_hz[row] / table.freq_hz[row]
                left += [(dof, freq) for freq in table.freq_hz[new].tolist()]
        strange.append(tuple(left))
    return Values(log_hz, std, looked, tuple(strange))


#: By response: (place, row) of what is at a place, and rows of what is not.
Matches = dict[Any, tuple[list[tuple[int, int]], list[int]]]


def _matched(
    where: dict[Any, FloatArray], one: AntiresonanceSet, max_shift: float, places: Places | None = None
) -> tuple[Matches, float]:
    """What of a test is where, and the logarithm of the shift that all values have in common."""
    tables = {dof: table for dof, table in one.tables.items() if dof in where}
    if places is not None and places.followed and one.followed:
        found: Matches = {}
        for dof, table in tables.items():
            at = {f: k for k, f in enumerate(where[dof].tolist())}
            known = list(enumerate(table.scores[KNOWN].tolist()))
            found[dof] = [(at[f], r) for r, f in known if f in at], [r for r, f in known if f not in at]
        return found, 0.0
    pairs = {dof: _pairs(where[dof], table, max_shift) for dof, table in tables.items()}
    moved = [
        np.log(tables[dof].freq_hz[row] / where[dof][place])
        for dof, own in pairs.items()
        for place, row in own
        if places is None or places.regular[places.of(dof)[place]]
    ]
    shift = float(np.median(moved)) if len(moved) >= FEWEST else 0.0
    if len(moved) >= FEWEST:
        pairs = {dof: _pairs(where[dof] * np.exp(shift), table, max_shift) for dof, table in tables.items()}
    rest = {dof: set(range(len(tables[dof]))) - {row for _, row in own} for dof, own in pairs.items()}
    return {dof: (own, sorted(rest[dof])) for dof, own in pairs.items()}, shift


def _pairs(where_hz: FloatArray, table: ResponseTable, max_shift: float) -> list[tuple[int, int]]:
    """(place, row) of one response."""
    freq = table.freq_hz
    if where_hz.size == freq.size:
        # The cost is convex, so that of all matches without a value left alone the ascending one is best; any
        # other leaves two alone, at a cost of one.
        reach = max_shift * 0.5 * (freq + where_hz)
        if np.sum(((freq - where_hz) / reach) ** 2) < 1.0:
            return [(i, i) for i in range(freq.size)]
    variance = np.broadcast_to(2.0 * table.std_hz**2, (where_hz.size, freq.size))
    return paired(where_hz, freq, max_shift, variance)


# -- Sensors that fail, told from damage
#
# Damage may move the antiresonances of one response alone. A response is at fault if the test lacks it, if
# the data check names its channel where that of the baseline did not, or if it lost its antiresonances, and
# has not as many elsewhere, while those of all other responses are where they should be.

#: Findings of the data check that tell of a channel, not of the structure.
SENSOR = {DEAD, CLIPPED, DUPLICATED, DROPOUTS, SPIKES, TIME_SHIFT, QUADRATURE, NOISE}
_USUAL = 0.1  # a finding that so large a part of the baseline has as well says nothing new
#: A place that is nearly always there; a response has lost its antiresonances if fewer than so many remain.
_SURE, _LEFT = 0.8, 0.34
#: Of the antiresonances that are not in their places, so many may be new values of the response, at most.
_ELSEWHERE = 0.5
_OTHERS = 0.7  # the other responses are in place if so many of theirs are there


@dataclass(frozen=True)
class Fault:
    """A response that a test could not be judged by.

    Attributes
    ----------
    dof, text : int or str, str
        Which, and why.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.Fault(3, "not in this test").text)
    not in this test
    """

    dof: Any
    text: str


def obvious(
    sets: Sequence[AntiresonanceSet | None], values: Values, places: Places, baseline: Sequence[int]
) -> dict[int, list[Fault]]:
    """Faults that need no chart, by test."""
    findings = [
        {  # what the data check says of single channels
            (dof, finding.name): f"data check: {finding.name.replace('_', ' ')}"
            for finding in (() if check is None else check.findings)
            if finding.severity != "note" and finding.name in SENSOR
            for dof in finding.where
        }
        for check in [None if one is None else one.data_check for one in sets]
    ]
    usual = Counter(key for i in baseline for key in findings[i])
    found: dict[int, list[Fault]] = {}
    for i, one in enumerate(sets):
        if one is None:
            continue
        here: dict[Any, str] = {}
        for (dof, name), text in findings[i].items():
            if dof in places.dofs and usual[dof, name] <= _USUAL * len(baseline):
                here.setdefault(dof, text)
        for dof in places.dofs:
            sure, lost = _lost(values, places, i, dof, here)
            if dof in here or not sure:
                continue
            if dof not in one:
                here[dof] = "not in this test"
            elif lost == sure:
                here[dof] = f"none of its {sure} antiresonances, those of the others in place"
        if here:
            found[i] = [Fault(dof, text) for dof, text in here.items()]
    return found


def lost_alone(
    values: Values, places: Places, test: int, without: dict[Any, float], limit: float
) -> Fault | None:
    """A response that has lost its antiresonances, ``without`` which the statistic is below ``limit``."""
    for dof, statistic in sorted(without.items(), key=lambda item: item[1]):
        sure, lost = _lost(values, places, test, dof)
        if lost and (sure - lost) / sure <= _LEFT and statistic < limit:
            return Fault(dof, f"{lost} of its {sure} antiresonances lost, those of the others in place")
    return None


def _lost(
    values: Values, places: Places, test: int, dof: Any, faulty: Collection[Any] = ()
) -> tuple[int, int]:
    """How many sure antiresonances a response has, and how many of them a test has lost.

    None is lost where it has one only, as many are there elsewhere, or those of the others are gone too.
    """
    there, sure = ~np.isnan(values.log_hz[test]), places.rate >= _SURE
    own = sure & rows_with(places.dof, dof)
    others = sure & values.looked[test] & ~np.isin(places.dof, [dof, *faulty])
    count = int(own.sum())
    lost = count - int(there[own].sum())
    moved = sum(bool(one == dof) for one, _ in values.strange[test]) > _ELSEWHERE * lost
    in_place = others.any() and np.mean(there[others]) >= _OTHERS
    return count, lost if count >= 2 and in_place and not moved else 0
