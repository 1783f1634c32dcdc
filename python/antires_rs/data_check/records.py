"""All tests of a time record."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError
from ..signals.averaging import Averages, Averaging, average, holds_hits
from ..signals.bandwidth import SEGMENTS
from ..signals.pooled import parts_of
from ..signals.recording import Recording
from ..signals.segment_length import LEAST_SAMPLES, longest_segments
from ..signals.spectra import CrossSpectra
from ..support.validation import ComplexArray, FloatArray
from . import channels, force_location, one_force, phase, resolution
from .evidence import Evidence, of_spectra
from .findings import Finding, NotTested, Said
from .repeats import grouped, of_repeats

BY_LINE = (
    channels.DEAD,
    phase.TIME_SHIFT,
    phase.QUADRATURE,
    channels.NOISE,
    resolution.RESOLUTION,
    one_force.NAME,
    force_location.NAME,
)
SINGLE_HIT, MISSED_HIT = "single_hit", "missed_hit"
FORCE = "force"
# The force explains so much of a response at a resonance, or its FRF there is not believed.
LEAST_COHERENCE = 0.8


def of_recording(
    rec: Recording,
    excitation: Any,
    band: tuple[float, float],
    options: Averaging,
    averages: Averages | None = None,
) -> tuple[Said, Evidence | None]:
    """What the tests say, and the evidence of those by line, if there is any.

    ``averages`` of the record, where it was averaged already.
    """
    hits = averages.of_hits if averages is not None else holds_hits(rec, options)
    said, live = _in_parts(rec, hits)
    if live is None:
        return said + _none_by_line("no channel moves"), None
    if averages is None:
        try:
            averages = _averaged(rec, band, options, hits)
        except UnsuitableDataError as exc:
            advice = f"{exc.got[0].upper()}{exc.got[1:]}. {exc.remedy}"
            finding = Finding(MISSED_HIT, "fatal", (), 0.0, 0.0, "No whole impact is in the record.", advice)
            return [*said, finding, *_none_by_line("no whole impact is in the record")], None
    if averages is None:
        return said + [_hopeless(live)] + _none_by_line("the record is too short for a spectrum"), None
    spectra = averages.spectra
    if averages.nperseg is None:
        said += _single_hit(spectra.n_averages)
    else:
        said += resolution.averages(spectra.n_effective, rec.duration_s, averages.nperseg)
    if spectra.freq_hz.size < resolution.LEAST_LINES:
        return said + [resolution.too_few_lines(spectra.freq_hz.size, band)] + _none_by_line(
            "too few lines in the band"
        ), None
    moving = [rec.dofs.index(dof) for dof in live.dofs]
    frfs = _frfs(spectra, moving) if averages.has_force and live.force is not None else None
    spectra = spectra.rows(moving)
    said += _resolution(averages, spectra, band, rec)

    def evidence(some: CrossSpectra, dofs: tuple[Any, ...]) -> Evidence:
        return of_spectra(some, dofs, nperseg=averages.nperseg, fs_hz=rec.fs_hz, taper=averages.taper)

    seen = evidence(spectra, live.dofs)
    dead = channels.unrelated(seen)
    lost = {dof for one in dead if isinstance(one, Finding) for dof in one.where}
    rows = [p for p, dof in enumerate(live.dofs) if dof not in lost]
    if 0 < len(rows) < len(live.dofs):
        # What holds only noise must not speak in the other tests.
        frfs = None if frfs is None else frfs[rows]
        seen = evidence(spectra.rows(rows), tuple(live.dofs[p] for p in rows))
    return [
        *said,
        *dead,
        *phase.in_phase(seen),
        *channels.buried(seen, lost),
        *of_repeats(one_force.one_force(seen), spectra.draws is not None),
        *force_location.force_location(seen, excitation, frfs),
    ], seen


def _averaged(rec: Recording, band: tuple[float, float], options: Averaging, hits: bool) -> Averages | None:
    """Averages of the record, and of its force if it has one; None if it is too short for any segments."""
    if not hits and options.nperseg is None and longest_segments(rec, band) < LEAST_SAMPLES:
        return None
    return average(rec, band, options, include_force=rec.force is not None, hits=hits)


def _in_parts(rec: Recording, hits: bool) -> tuple[Said, Recording | None]:
    """The tests of the samples in every one of several records; and the channels that are well in all."""
    parts = parts_of(rec)
    if len(parts) == 1:
        return _in_time(rec, hits)
    each = [_in_time(part, hits) for part in parts]
    alive = [set(live.dofs) for _, live in each if live is not None]
    well = set.intersection(*alive) if len(alive) == len(parts) else set()
    rows = [p for p, dof in enumerate(rec.dofs) if dof in well]
    said = grouped([one for one, _ in each])
    if not rows or len(rows) == rec.n_channels:
        return said, rec if rows else None
    return said, Recording(rec.responses[rows], rec.fs_hz, [rec.dofs[p] for p in rows], rec.force)


def _in_time(rec: Recording, hits: bool) -> tuple[Said, Recording | None]:
    """Tests of the samples; and the record without channels that are still or twice there."""
    data, labels = rec.responses, rec.dofs
    found, still = channels.constant(data, labels)
    rows = [p for p in range(rec.n_channels) if p not in still]
    said: Said = list(found)
    force = rec.force
    if force is not None and force.max() == force.min():
        said.append(
            Finding(
                channels.DEAD,
                "warning",
                (FORCE,),
                0.0,
                0.0,
                "The force is recorded as a constant.",
                "Check its cable; antiresonances do not need it.",
            )
        )
        force = None
    if not rows:
        return said, None
    moving = data if not still else data[rows]
    names = tuple(labels[p] for p in rows)
    if force is None:
        said += channels.clipped(moving, names)
    else:
        said += channels.clipped([*moving, force], (*names, FORCE))
    if hits:
        why = "in a record of impacts, rest and blows look like dropouts and spikes"
        said += [NotTested(channels.DROPOUTS, why), NotTested(channels.SPIKES, why)]
    else:
        said += channels.interrupted(moving, names, rec.fs_hz)
    twice, extra = channels.duplicated(moving, names)
    said += twice
    keep = [p for p in range(len(rows)) if p not in extra]
    if len(keep) == rec.n_channels and force is rec.force:
        return said, rec
    return said, Recording(moving[keep], rec.fs_hz, [names[p] for p in keep], force)


def _frfs(spectra: CrossSpectra, rows: list[int]) -> ComplexArray:
    """FRFs of some channels to the force, which is the last; zero where it does not explain the response."""
    auto = np.einsum("fii->if", spectra.matrix).real
    to_force = spectra.matrix[:, -1, rows].T
    power = np.maximum(auto[-1], 1e-300)
    coherence = np.abs(to_force) ** 2 / np.maximum(power * auto[rows], 1e-300)
    return np.where(coherence >= LEAST_COHERENCE, to_force / power, 0.0)


def _resolution(averages: Averages, spectra: CrossSpectra, band: tuple[float, float], rec: Recording) -> Said:
    """Lines per bandwidth, the bandwidth being measured at the longest segments' resolution if need be."""
    length = averages.nperseg
    spacing = float(spectra.freq_hz[1] - spectra.freq_hz[0])
    lines = resolution.sharpest_lines(_power(spectra), leakage=length is not None)
    if length is None:
        # An exponential window has widened the resonances by a known amount.
        widened = spectra.added_decay_per_s / np.pi
        return resolution.without_leakage(
            None if lines is None else max(lines * spacing - widened, 0.0), spacing, hit=True
        )
    longest, bandwidth = averages.correlation.longest, None
    if lines is not None:
        bandwidth = lines * spacing
    if longest > length and (lines is None or lines < resolution.TRUSTED):
        finer = resolution.sharpest_lines(averages.correlation.power(longest, band))
        if finer is not None:
            lines, bandwidth = finer, finer * rec.fs_hz / longest
    return resolution.of_segments(
        bandwidth,
        spacing,
        rec.duration_s,
        longer=longest > length,
        chosen=averages.options.nperseg is None,
        known=lines is not None and lines >= 1.0,
    )


def _power(spectra: CrossSpectra) -> FloatArray:
    """All channels at equal weight, by line."""
    auto = np.einsum("fii->if", spectra.matrix).real
    mean = np.maximum(auto.mean(axis=1, keepdims=True), 1e-300)
    return np.asarray((auto / mean).sum(axis=0), dtype=np.float64)


def _single_hit(n_hits: int) -> Said:
    if n_hits > 1:
        return []
    return [
        Finding(
            SINGLE_HIT,
            "note",
            (),
            1.0,
            2.0,
            "A single impact: no averages. Coherence, the noise by line and whether one force is enough "
            "cannot be told.",
            "Hit the same point several times and record all impacts together.",
        )
    ]


def _hopeless(rec: Recording) -> Finding:
    least = LEAST_SAMPLES * SEGMENTS
    return Finding(
        resolution.LENGTH,
        "fatal",
        (),
        float(rec.n_samples),
        least,
        f"The record of {rec.n_samples} samples ({rec.duration_s:.3g} s) is too short for "
        f"averaged spectra, which need {least:.0f}.",
        "Record for longer, or give nperseg.",
    )


def _none_by_line(why: str) -> Said:
    return [NotTested(name, why) for name in BY_LINE]
