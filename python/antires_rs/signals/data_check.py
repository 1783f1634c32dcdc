"""Ask whether data are fit for identification: the one call, and the order of its tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError
from ..support.checks import ComplexArray, force_label, members
from ..support.directions import refuse_point
from ..support.progress import patient
from ..support.values import frozen
from . import channel_checks as channels, one_force
from .averaging import (
    LEAST_SAMPLES,
    SEGMENTS,
    Averages,
    Averaging,
    average,
    holds_hits,
    is_level_but_for_a_rise,
    longest_segments,
    lowest_hz,
)
from .findings import SEVERITIES, CheckResults, DataCheck, Finding, NotTested, one_of_a_kind
from .frequency_response import FrequencyResponse, band_of
from .one_force import Evidence, of_curves, of_spectra
from .recording import Recording, parts_of
from .repeats import disagreement, one_source
from .spectra import CrossSpectra, roughness

# -- Findings of several records of one test, each said once, with the records that show it

CHANGED = (
    "If nothing else acted, the structure has changed from record to record: identify them one by one and "
    "compare the sets."
)


def grouped(each: Sequence[CheckResults]) -> CheckResults:
    """What the tests say of each record, joined: one finding for a test and a place, its worst example."""
    found: dict[tuple[object, ...], list[tuple[int, Finding]]] = {}
    untested: dict[str, NotTested] = {}
    for number, said in enumerate(each):
        for one in said:
            if isinstance(one, NotTested):
                untested.setdefault(one.name, one)
            else:
                found.setdefault((one.name, one.where), []).append((number, one))
    joined: CheckResults = []
    for shown in found.values():
        worst = min((one for _, one in shown), key=lambda one: SEVERITIES.index(one.severity))
        *numbers, last = (str(number) for number, _ in shown)
        where = f"In record {last} of {len(each)}, counted from 0."
        if len(shown) == len(each):
            where = f"In all {len(each)} records."
        elif numbers:
            where = f"In records {', '.join(numbers)} and {last} of {len(each)}, counted from 0."
        brief = f"{worst.brief} ({where[0].lower()}{where[1:-1]})" if worst.brief else ""
        joined.append(replace(worst, text=f"{worst.text} ({where})", brief=brief))
    return [*joined, *untested.values()]


# -- All tests of a time record

BY_LINE = (
    *(channels.DEAD, channels.TIME_SHIFT, channels.QUADRATURE, one_force.NOISE, channels.RESOLUTION),
    *(one_force.ONE_FORCE, one_force.FORCE_LOCATION),
)
SINGLE_HIT, MISSED_HIT = "single_hit", "missed_hit"
# The force explains so much of a response at a resonance, or its FRF there is not believed.
LEAST_COHERENCE = 0.8


def of_recording(
    rec: Recording,
    excitation: Any,
    band: tuple[float, float],
    options: Averaging,
    averages: Averages | None = None,
) -> tuple[CheckResults, Evidence | None]:
    """What the tests say of a record, averaged before or not, and their evidence by line, if there is any."""
    hits = averages.nperseg is None if averages is not None else holds_hits(rec, options, band)
    said, live = _in_parts(rec, hits)
    if live is None:
        return said + _none_by_line("no channel moves"), None
    if averages is None:
        try:
            if hits or options.nperseg is not None or longest_segments(rec, band) >= LEAST_SAMPLES:
                averages = average(rec, band, options, include_force=rec.force is not None, hits=hits)
        except UnsuitableDataError as exc:
            advice = f"{exc.got[0].upper()}{exc.got[1:]}. {exc.remedy}"
            finding = Finding(MISSED_HIT, "fatal", (), 0.0, 0.0, "No whole impact is in the record.", advice)
            return [*said, finding, *_none_by_line("no whole impact is in the record")], None
    if averages is None:
        least = LEAST_SAMPLES * SEGMENTS
        text = (
            f"The record of {live.n_samples} samples ({live.duration_s:.3g} s) is too short for "
            f"averaged spectra, which need {least:.0f}."
        )
        advice = "Record for longer, or give nperseg."
        said.append(Finding(channels.LENGTH, "fatal", (), float(live.n_samples), least, text, advice))
        return said + _none_by_line("the record is too short for a spectrum"), None
    spectra = averages.spectra
    said += channels.hum(averages.hum)
    if averages.nperseg is not None:
        said += channels.averages(spectra.n_effective, rec.duration_s, averages.nperseg)
        said += channels.drift(spectra)
    else:
        said += channels.double_hits(parts_of(live)[0], band)
    if averages.nperseg is None and spectra.n_averages == 1:
        text = (
            "A single impact: no averages. Coherence, the noise by line and whether one force is enough "
            "cannot be told."
        )
        advice = "Hit the same point several times and record all impacts together."
        said.append(Finding(SINGLE_HIT, "note", (), 1.0, 2.0, text, advice))
    if spectra.freq_hz.size < channels.LINES_OF_BAND:
        return said + [channels.too_few_lines(spectra.freq_hz.size, band)] + _none_by_line(
            "too few lines in the band"
        ), None
    moving = [rec.dofs.index(dof) for dof in live.dofs]
    frfs = _frfs(spectra, moving) if averages.has_force and live.force is not None else None
    spectra = spectra.rows(moving)
    said += _resolution(averages, spectra, band, rec)
    seen = of_spectra(spectra, live.dofs, averages)
    first = parts_of(live)[0]
    unlike: CheckResults = []
    if seen.spectra is not None and len(members(excitation)) < 2:
        unlike = disagreement(averages.spectra, seen.spectra[1], moving, live.dofs)
    dead = (averages.nperseg is None and channels.silent(first, band)) or (
        [] if unlike else channels.unrelated(seen)  # a channel turned round in one record is no noise
    )
    lost = {dof for one in dead if isinstance(one, Finding) for dof in one.where}
    rows = [p for p, dof in enumerate(live.dofs) if dof not in lost]
    if 0 < len(rows) < len(live.dofs):
        # What holds only noise must not speak in the other tests.
        frfs = None if frfs is None else frfs[rows]
        seen = of_spectra(spectra.rows(rows), tuple(live.dofs[p] for p in rows), averages)
    one = one_force.one_force(seen, len(members(excitation)))
    apart = channels.clocks(first, band) if one or lost else []
    if spectra.draws is not None:
        # a structure that changes between repeats looks like a second force.
        one = [replace(f, advice=f"{f.advice} {CHANGED}") if isinstance(f, Finding) else f for f in one]
    one = unlike or one
    hidden = [finding for finding in one if finding.name == one_force.NOISE]
    one = [finding for finding in one if finding not in hidden]
    if hidden:  # peaks of noise have no width, which a longer record would resolve
        said = [each for each in said if each.name not in (channels.LENGTH, channels.RESOLUTION)]
    return [
        *hidden,
        *said,
        *(apart or [*dead, *channels.in_phase(seen), *one]),  # without a common clock nothing is in common
        *channels.alike(seen),
        *channels.buried(seen, lost),
        *one_force.force_location(seen, excitation, frfs),
    ], seen


def _in_parts(rec: Recording, hits: bool) -> tuple[CheckResults, Recording | None]:
    """The tests of the samples in every one of several records; and the channels that are well in all."""
    parts = parts_of(rec)
    if len(parts) == 1:
        return channels.in_time(rec, hits)
    each = [channels.in_time(part, hits) for part in parts]
    alive = [set(live.dofs) for _, live in each if live is not None]
    well = set.intersection(*alive) if len(alive) == len(parts) else set()
    rows = [p for p, dof in enumerate(rec.dofs) if dof in well]
    said = grouped([one for one, _ in each])
    if not rows or len(rows) == rec.n_channels:
        return said, rec if rows else None
    return said, Recording(rec.responses[rows], rec.fs_hz, [rec.dofs[p] for p in rows], rec.force)


def _frfs(spectra: CrossSpectra, rows: list[int]) -> ComplexArray:
    """FRFs of some channels to the force, which is the last; zero where it does not explain the response."""
    auto = np.einsum("fii->if", spectra.matrix).real
    to_force = spectra.matrix[:, -1, rows].T
    power = np.maximum(auto[-1], 1e-300)
    coherence = np.abs(to_force) ** 2 / np.maximum(power * auto[rows], 1e-300)
    return np.where(coherence >= LEAST_COHERENCE, to_force / power, 0.0)


def _resolution(
    averages: Averages, spectra: CrossSpectra, band: tuple[float, float], rec: Recording
) -> CheckResults:
    """Lines per bandwidth, the bandwidth being measured at the longest segments' resolution if need be."""
    length = averages.nperseg
    spacing = float(spectra.freq_hz[1] - spectra.freq_hz[0])
    auto = np.einsum("fii->if", spectra.matrix).real
    mean = np.maximum(auto.mean(axis=1, keepdims=True), 1e-300)
    power = (auto / mean).sum(axis=0)  # all channels at equal weight
    lines = channels.sharpest_lines(power, leakage=length is not None)
    if length is None:
        # An exponential window has widened the resonances by a known amount.
        widened = spectra.added_decay_per_s / np.pi
        return channels.without_leakage(
            None if lines is None else max(lines * spacing - widened, 0.0), spacing, hit=True
        )
    longest, bandwidth = averages.correlation.longest, None
    if lines is not None:
        bandwidth = lines * spacing
    if longest > length and (lines is None or lines < channels.TRUSTED):
        finer = channels.sharpest_lines(averages.correlation.power(longest, band))
        if finer is not None:
            lines, bandwidth = finer, finer * rec.fs_hz / longest
    return channels.of_segments(
        bandwidth,
        spacing,
        rec.duration_s,
        longer=longest > length,
        chosen=averages.options.nperseg is None,
        known=lines is not None and lines >= 1.0,
        weak_hit=lambda: (
            averages.options.method == "auto" and is_level_but_for_a_rise(parts_of(rec)[0], lowest_hz(band))
        ),
    )


def _none_by_line(why: str) -> CheckResults:
    return [NotTested(name, why) for name in BY_LINE]


# -- The tests that measured frequency responses allow

# Roughness from line to line over the power of a curve above which it is noise, white noise having one; if
# another curve is smooth: lines too far apart make all of them rough.
ROUGH, SMOOTH = 0.5, 0.1


def of_response(
    resp: FrequencyResponse, excitation: Any, band: tuple[float, float]
) -> tuple[CheckResults, Evidence | None]:
    """What the tests say, and the evidence of those by line, if there is any."""
    why = "needs time records"
    said: CheckResults = [
        NotTested(name, why) for name in (channels.CLIPPED, channels.DROPOUTS, channels.SPIKES)
    ]
    inside = (resp.freq_hz >= band[0]) & (resp.freq_hz <= band[1]) & (resp.freq_hz > 0.0)
    if inside.sum() < channels.LINES_OF_BAND:
        said.append(channels.too_few_lines(int(inside.sum()), band))
        return said + _none_by_line("too few lines in the band")[1:], None
    values = resp.values[:, inside]
    rough = np.array([roughness(curve) for curve in values])
    live = []
    for p, dof in enumerate(resp.dofs):
        if not values[p].any():
            brief = "zero throughout the band"
            parts = (0.0, 0.0, f"Dof {dof!r} is {brief}.", channels.DEAD_ADVICE, brief)
            said.append(Finding(channels.DEAD, "fatal", (dof,), *parts))
        elif rough[p] > ROUGH and rough.min() < SMOOTH:
            text = (
                f"Dof {dof!r} holds only noise in the band: from line to line it changes as much as "
                f"white noise does ({rough[p]:.2f} of its power, limit {ROUGH:g})."
            )
            brief = f"only noise in the band ({rough[p]:.2f} of its power)"
            parts = (float(rough[p]), ROUGH, text, channels.DEAD_ADVICE, brief)
            said.append(Finding(channels.DEAD, "fatal", (dof,), *parts))
        else:
            live.append(p)
    if rough.min() >= SMOOTH and np.median(rough) > ROUGH:
        text = (
            f"The curves change from line to line as white noise does ({np.median(rough):.2f} of their "
            f"power, limit {ROUGH:g}): they are noise, or their lines too far apart."
        )
        advice = "Measure with a finer resolution, or force harder."
        said.append(Finding(channels.RESOLUTION, "fatal", (), float(np.median(rough)), ROUGH, text, advice))
    if not live:
        return said + _none_by_line("no channel holds a response")[1:], None
    dofs = tuple(resp.dofs[p] for p in live)
    coherence = None if resp.coherence is None else resp.coherence[live][:, inside]
    seen = of_curves(resp.freq_hz[inside], values[live], dofs, coherence)
    said += channels.duplicated(np.hstack([values[live].real, values[live].imag]), dofs)[0]
    said += [*channels.alike(seen), *channels.in_phase(seen)]
    said += [*channels.buried(seen, by_coherence=True), *one_force.one_force(seen)]
    if resp.kind == "transmissibility":
        why = (
            "peaks of transmissibilities are antiresonances of the reference, as sharp as noise lets them be"
        )
        said.append(NotTested(channels.RESOLUTION, why))
        said.append(NotTested(one_force.FORCE_LOCATION, "transmissibilities do not show the resonances"))
        return said, seen
    spacing = float(np.median(np.diff(seen.freq_hz)))
    power = np.abs(values[live]) ** 2
    lines = channels.sharpest_lines(np.sum(power / power.mean(axis=1, keepdims=True), axis=0), leakage=False)
    said += channels.without_leakage(None if lines is None else lines * spacing, spacing, hit=False)
    said += one_force.force_location(seen, excitation, values[live])
    return said, seen


#: The order in which the tests that could not be made are listed.
IN_TIME = (channels.CLIPPED, channels.DUPLICATED, channels.DROPOUTS, channels.SPIKES)
TESTS = (BY_LINE[0], *IN_TIME, *BY_LINE[1:])


@patient("checking the data")
def check_data(
    source: Recording | FrequencyResponse | Sequence[Recording] | Sequence[FrequencyResponse],
    *,
    excitation: Any = None,
    band_hz: Sequence[float],
    nperseg: int | None = None,
    noverlap: int | None = None,
    window: Any = "hann",
    method: str = "auto",
    progress: bool | None = None,
) -> DataCheck:
    """Ask whether data are fit for identification before anything is fitted to them.

    Parameters
    ----------
    source : Recording or FrequencyResponse, or a list of either
        Time records, or measured responses, for which fewer tests can be made. A list holds repeats of one
        test, whose samples are tested record by record and whose averages together.
    excitation : int or str, or a list of them, optional
        Dof at which the single force is said to act, or those of several, whose number is then tested.
        Without it the location is not tested.
    band_hz : (low, high)
        Band in which antiresonances are wanted.
    nperseg, noverlap, window, method
        As for :func:`~antires_rs.identify_antiresonances`; give the same.
    progress : bool, optional
        A line on standard error after a second; by default on a terminal and in a notebook.

    Returns
    -------
    DataCheck
        ``.findings`` with numbers and advice, one of a kind over all its channels, ``.not_tested`` with
        reasons, ``.ok``, ``.fatal``; print it for a table, ``.plot()`` it for the eigenvalues.

    Raises
    ------
    InvalidInputError
        A malformed argument. Bad data never raise: they are what is reported.

    Notes
    -----
    The tests, by name:

    - from ``dead_channel`` to ``spikes``, and ``signal_to_noise``: of single channels, each explained by
      :func:`~antires_rs.explain`;
    - ``time_shift``, ``quadrature``: a channel late against the others, or of another kind. In a
      single record polarity is not seen, nor two channels that are exchanged, unless one is driven;
    - ``drift``: a resonance that is elsewhere at the end than at the beginning;
    - ``mains_hum``: steady lines at multiples of 50 or 60 Hz, which are taken out;
    - ``resolution``, ``record_length``, ``averages``: lines per half-power bandwidth, and what limits them;
    - ``one_force``: the second eigenvalue of the spectral matrix against the first, noise and leakage; of r
      places named eigenvalues r and r + 1. Forces that move in proportion are one force in this respect;
    - ``records_differ``: of several records, whether one has channels exchanged or turned round, and whether
      all show one force place;
    - ``force_location``: zeros and poles of the stated driving point alternate. A dof whose mode shapes have
      the signs of the driving point's in all modes of the band cannot be told from it;
    - ``single_hit``, ``double_hit``, ``missed_hit``: of hammer records.

    Limits were set on simulated records of an 8-mass chain (0 to 10 % noise, 0.5 to 2 % damping, 60 to
    600 s), those of the phase on measured plates too.

    Examples
    --------
    >>> import antires_rs as ar
    >>> rec = ar.cases.chain8().experiment(noise=0.01, rng=1)
    >>> ar.check_data(rec, excitation=0, band_hz=(3, 130)).ok
    True
    >>> (finding,) = ar.check_data(rec, excitation=4, band_hz=(3, 130)).findings
    >>> print(finding.severity, finding.name, "|", finding.advice)
    fatal force_location | Dof 0 would fit: check which dof was excited, and the order of the channels.
    """
    excitation = None if excitation is None else force_label("excitation", excitation)
    options = Averaging(nperseg, noverlap, window, method).checked()
    one: Recording | FrequencyResponse = one_source(source)
    refuse_point(members(excitation), getattr(one, "dofs", ()))  # what is neither is refused by the check
    return judged(one, excitation, band_of(one, band_hz), options)


def judged_together(
    columns: Sequence[FrequencyResponse], band: tuple[float, float], options: Averaging
) -> DataCheck:
    """The check of responses to one force after the other."""
    each = [judged(one, None, band, options) for one in columns]
    found = one_of_a_kind(
        one for one in grouped([list(own.findings) for own in each]) if isinstance(one, Finding)
    )
    return replace(each[0], findings=found)


def judged(
    source: Recording | FrequencyResponse,
    excitation: Any,
    band: tuple[float, float],
    options: Averaging,
    averages: Averages | None = None,
) -> DataCheck:
    """The check with options that are checked, on ``averages`` of the record where they are there already."""
    if isinstance(source, Recording):
        said, seen = of_recording(source, excitation, band, options, averages)
    else:
        said, seen = of_response(source, excitation, band)
    found = one_of_a_kind(one for one in said if isinstance(one, Finding))
    # a test that found something was made, even if a part of it could not be.
    named = {finding.name for finding in found}
    why = {one.name: one.why for one in reversed(said) if isinstance(one, NotTested)}
    untested = {name: why[name] for name in TESTS if name in why and name not in named}
    if seen is None:
        return DataCheck(found, untested, source.dofs, excitation, band)
    averaged, second = seen.eigenvalues is not None, None
    if averaged and len(seen.dofs) > 2:
        # What one force gives with noise and leakage.
        order = min(len(members(excitation)), len(seen.dofs) - 2)
        second = np.maximum(one_force.noise_level(seen, order), seen.leakage(order))
    where = seen.dofs, excitation, band
    lines = frozen(seen.freq_hz), frozen(seen.eigenvalues), frozen(second), frozen(seen.coherence)
    count, nperseg = (seen.n_averages, seen.nperseg) if averaged else (None, None)
    return DataCheck(found, untested, *where, *lines, count, nperseg, one_force.forces_seen(seen))
