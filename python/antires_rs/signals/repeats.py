r"""Several measurements of one test as one source: records are pooled, curves averaged.

The mean of R curves scatters by std^2 = sum_r abs(H_r - mean)^2 / (2 R (R - 1)) in its real and imaginary
part alike; with few curves that is averaged over so many neighbouring lines that it has some twenty degrees
of freedom. FRFs are averaged as they are. A mean of transmissibilities follows the worst of them at their
poles: the average is the dominant eigenvector of all response vectors instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b
from typing import Any

import numpy as np

from ..exceptions import Argument, reject
from ..support.checks import ComplexArray, FloatArray
from ..support.messages import some
from ..support.values import frozen
from .findings import CheckResults, Finding, rounded
from .frequency_response import FrequencyResponse
from .recording import PooledRecording, Recording, check_recording
from .spectra import CrossSpectra, response_vectors, running_mean

FREEDOM = 20.0  # degrees of freedom that the scatter of a mean should have, a line of one curve giving two


class AveragedResponse(FrequencyResponse):
    """The average of several curves of one test, which it holds too."""

    runs: ComplexArray  #: (R, n, n_freq) in the order given, rows as those of ``values``.

    def __init__(self, runs: ComplexArray, *parts: Any, **named: Any) -> None:
        super().__init__(*parts, **named)
        object.__setattr__(self, "runs", frozen(runs))


def one_source(source: Any, name: str = "source") -> Any:
    """A list of records or of responses as one of them; anything else as it is."""
    if not isinstance(source, list | tuple):
        if isinstance(source, Recording):
            check_recording(source)
        return source
    if not source:
        reject(name, "an empty list", "one measurement or more", "Name the records of the test.")
    kind = type(source[0]) if isinstance(source[0], FrequencyResponse) else Recording
    for i, one in enumerate(source):
        if not isinstance(one, kind):
            wanted = "records, or responses, of one test: all of one kind"
            reject(Argument(name).item(i), type(one).__name__, wanted, "Identify them apart.")
    return pooled(source, name) if kind is Recording else averaged(source, name)


def averaged(responses: Sequence[FrequencyResponse], name: str = "source") -> FrequencyResponse:
    """The average of repeated FRFs or transmissibilities, with the scatter of that average as ``std``.

    Of two or more it holds the runs too: the scatter by line does not hold what moves the whole curve of a
    test.
    """
    first = responses[0]
    if len(responses) == 1:
        return first
    values = np.stack([as_first(first, one, Argument(name).item(i)) for i, one in enumerate(responses)])
    _each_once(values, name)
    if first.reference is None:
        mean = np.asarray(values.mean(axis=0), dtype=np.complex128)
    else:
        # Dominant vector of all records' vectors by line, over its entry at the reference.
        vectors = (values / np.linalg.norm(values, axis=1, keepdims=True)).transpose(2, 1, 0)
        left = np.linalg.svd(vectors, full_matrices=False)[0][:, :, 0].T
        own = left[first.dofs.index(first.reference)]
        mean = np.asarray(left / np.where(np.abs(own) < 1e-12, 1e-12, own), dtype=np.complex128)
    size = 1.0 if first.reference is None else np.sum(np.abs(mean) ** 2, axis=0)
    count = len(values)
    # Variance of the mean in its real part, averaged over the lines that few curves need.
    variance = np.sum(np.abs(values - mean) ** 2, axis=0) / (2.0 * count * (count - 1.0)) / size
    width = min(int(np.ceil(FREEDOM / (2.0 * (count - 1.0)))), first.n_freq)
    std = np.sqrt(size * np.array([running_mean(row, width) for row in variance]))
    of_all = first.freq_hz, mean, first.dofs, first.kind, first.reference
    return AveragedResponse(values, *of_all, n_averages=float(len(responses)), std=std)


def pooled(records: Sequence[Recording], name: str = "source") -> Recording:
    """Records of one test as one; the force is kept where all have it."""
    first, same = records[0], []
    for i, rec in enumerate(records):
        check_recording(rec)
        if rec.fs_hz != first.fs_hz:
            got = f"a sampling rate of {rec.fs_hz:g} Hz"
            wanted = f"that of the first record, {first.fs_hz:g} Hz"
            reject(Argument(name).item(i), got, wanted, "Resample one of them, or identify them apart.")
        rows = _rows(first, rec, Argument(name).item(i), "a record of", "record")
        if rec.dofs != first.dofs:
            rec = Recording(rec.responses[rows], rec.fs_hz, first.dofs, rec.force)
        same.append(rec)
    _each_once([rec.responses for rec in same], name)
    return PooledRecording(same) if len(same) > 1 else first


def _each_once(several: Any, name: str) -> None:
    """Refuse a measurement that is there twice: what is known would look more exact than it is."""
    first: dict[bytes, int] = {}
    for i, one in enumerate(several):
        k = first.setdefault(blake2b(np.ascontiguousarray(one).data).digest(), i)
        if k < i:
            got, wanted = f"the numbers of measurement {k}, counted from 0", "another measurement of the test"
            reject(Argument(name).item(i), got, wanted, "Was one file given twice? Leave it out.")


def _rows(first: Any, one: Any, name: Argument, got: str, kind: str) -> list[int]:
    """Rows of one measurement in the order of the first one's."""
    if set(one.dofs) != set(first.dofs):
        remedy = "Identify setups with sensors at other places apart, and join the sets by merge_setups."
        reject(name, f"{got} dofs {one.dofs}", f"the dofs of the first {kind}, {first.dofs}", remedy)
    return [one.dofs.index(dof) for dof in first.dofs]


def as_first(first: FrequencyResponse, one: FrequencyResponse, name: Argument) -> ComplexArray:
    """Values with their rows in the order of the first response's."""
    if not isinstance(one, FrequencyResponse):
        reject(name, type(one).__name__, "a FrequencyResponse, as the first", "Identify them apart.")
    for what in ("kind", "reference"):
        if getattr(one, what) != getattr(first, what):
            got = f"{what} {getattr(one, what)!r}"
            wanted = f"that of the first response, {getattr(first, what)!r}"
            reject(name, got, wanted, "Average responses of one kind, to one reference.")
    if one.freq_hz.shape != first.freq_hz.shape or not np.allclose(one.freq_hz, first.freq_hz, rtol=1e-9):
        own, lines = (f"from {each.freq_hz[0]:g} to {each.freq_hz[-1]:g} Hz" for each in (one, first))
        wanted = f"the lines of the first response, {first.n_freq} {lines}"
        reject(name, f"{one.n_freq} lines {own}", wanted, "Estimate all with the same segments.")
    return one.values[_rows(first, one, name, "responses at", "response")]


# -- Do the records of one test agree?
#
# One force at one place gives the responses one direction at each line, whatever the force's spectrum. The
# mean sin^2 of the angle between the directions of two records, over lines that are strong in both, was 0.01
# at most between repeats with up to 20 % of noise, 0.1 at the median where a spring lost half, and 0.11 to
# 0.22 between two places of the force. Channels that were exchanged or turned round leave nothing of it once
# changed back. Limits were set on chains and portal frames; on others no repeat of 80 is named, 136 of 160
# changed channels are, and few of other places, which show between resonances only
# (benchmarks/unlike_records.py).

DIFFER = "records_differ"
STRONG, LEAST_LINES, MOST_LINES = 100.0, 8, 400  # signal-to-noise power of a line; how many are compared
DISAGREE = 0.15  # mean sin^2 above which two records do not show one force
CHANGED, LEFT = 0.05, 0.02  # mean sin^2 of channels that were exchanged, at least, and of these changed back


def disagreement(
    spectra: CrossSpectra, noise: FloatArray, rows: list[int], dofs: Sequence[Any]
) -> CheckResults:
    """Whether records that were averaged together show one force at one place, by the channels ``rows``."""
    segments, records = spectra.segments, spectra.records
    if segments is None or records is None or records.max() == 0:
        return []
    each = segments.at(slice(None, None, max(1, spectra.freq_hz.size // MOST_LINES)))[:, rows]
    own = [each[:, :, records == number] for number in range(records.max() + 1)]
    pairs = [response_vectors(one.conj() @ one.transpose(0, 2, 1) / one.shape[2], noise) for one in own]
    vectors = np.array([one * np.sqrt(size) for one, size in pairs])  # of each record, (R, n, n_freq)
    power = np.abs(vectors) ** 2
    share = np.median(np.mean(power / power.sum(axis=1, keepdims=True).clip(1e-300), axis=2), axis=0)
    floor = np.median(noise / power.sum(axis=1).mean(axis=1)[:, None], axis=0)
    # Channels at equal weight, but for those that hold noise above all.
    weight = 1.0 / np.maximum(share, STRONG * floor).clip(1e-300)
    ratio = np.einsum("p,rpf->rf", weight, power) / max(float(weight @ noise), 1e-300)
    left = [int(i) for i in np.argsort(-np.median(ratio, axis=1), kind="stable")]
    # The noise is that of most segments. Of a louder record it may have grown as the responses have.
    level = ratio.mean(axis=1)
    ratio /= np.maximum(level / np.median(level[records]), 1.0)[:, None]
    groups: list[list[int]] = []
    angles: dict[tuple[int, int], tuple[float, float, str]] = {}
    while left:  # the strongest record that is left, and those that agree with it
        first, *others = left
        group, left = [first], []
        for other in others:
            strong = (ratio[first] > STRONG) & (ratio[other] > STRONG)
            if strong.sum() >= LEAST_LINES:
                angle = _angle(vectors[first][:, strong], vectors[other][:, strong], weight, dofs)
                angles[first, other] = angles[other, first] = angle
                (left if angle[2] or angle[0] > DISAGREE else group).append(other)
        groups.append(sorted(group, key=lambda one: one != first))
    groups.sort(key=lambda group: (-len(group), min(group)))
    said: CheckResults = []
    for group in groups[1:]:
        before, after, change = angles[groups[0][0], group[0]]
        these, those = (f"ecord{'s' * (len(g) > 1)} {some(sorted(g), 12)}" for g in (group, groups[0]))
        seen = f"(counted from 0; mean sin^2 of the angle between their responses {rounded(before)}"
        if change:
            which = f"R{these}" if len(group) < len(groups[0]) else f"R{these} or r{those}"
            text = f"{which}: {change} {seen}, {rounded(after)} if changed back)."
            advice = (
                "Correct that, or leave the record out. If the structure is symmetric, the force may have "
                "acted at the mirrored place."
            )
        else:
            text = f"R{those} and r{these} do not share one force place {seen}, limit {DISAGREE:g})."
            advice = (
                "Identify the hits of each place apart. If it was one place, the order of the channels, or "
                "the structure, has changed."
            )
        limit = CHANGED if change else DISAGREE
        said.append(Finding(DIFFER, "fatal", (), before, limit, text, advice))
    return said


def _angle(
    first: ComplexArray, other: ComplexArray, weight: FloatArray, dofs: Sequence[Any]
) -> tuple[float, float, str]:
    """Mean sin^2 of the angle between vectors (n, n_freq), the same with channels changed, and how."""
    own = first.conj() * weight[:, None]
    size = np.einsum("pf,pf->f", own, first).real
    a, b = np.triu_indices(len(dofs))

    def mean(inner: ComplexArray, power: FloatArray) -> FloatArray:
        return np.asarray(1.0 - np.mean(np.abs(inner) ** 2 / np.maximum(size * power, 1e-300), axis=-1))

    now: ComplexArray = other.copy()
    changes: list[tuple[int, int]] = []
    inner, total = np.einsum("pf,pf->f", own, now), weight @ np.abs(now) ** 2
    before = after = float(mean(inner, total))
    while before > CHANGED and after > LEFT and len(changes) < 2:
        # What each exchange, or channel turned round, changes.
        power = np.abs(now) ** 2
        gain = np.where((a == b)[:, None], -2.0 * own[a] * now[a], (own[a] - own[b]) * (now[b] - now[a]))
        means = mean(inner + gain, total + (weight[a] - weight[b])[:, None] * (power[b] - power[a]))
        best = int(np.argmin(means))
        if means[best] >= after:
            break
        i, j = int(a[best]), int(b[best])
        after, inner = float(means[best]), inner + gain[best]
        total = total + (weight[i] - weight[j]) * (power[j] - power[i])
        if i == j:
            now[i] *= -1.0
        else:
            now[[i, j]] = now[[j, i]]
        changes.append((i, j))
    names = [repr(dofs[p]) for p in sorted({p for change in changes for p in change})]
    if not 0 < len(names) <= 3 or after > LEFT:
        return before, before, ""
    if len(names) == 1:
        return before, after, f"channel {names[0]} looks turned round"
    how = "swapped" if len(changes) == 1 else "exchanged or turned round"
    return before, after, f"channels {', '.join(names[:-1])} and {names[-1]} look {how}"
