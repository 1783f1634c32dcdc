"""All tests of a time record."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..exceptions import InvalidInputError, UnsuitableDataError
from ..signals.recording import Recording
from ..signals.segment_length import LEAST_SAMPLES, SEGMENTS, _power_of_two, choose_nperseg
from ..signals.spectra import CrossSpectra, cross_spectra, window_values
from ..signals.transient import is_transient, transient_spectra
from ..support.validation import ComplexArray, FloatArray
from . import channels, force_location, one_force, phase, resolution
from .evidence import Evidence, of_spectra
from .findings import Finding, NotTested, Said

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
    nperseg: int | None,
    noverlap: int | None,
    window: Any,
    method: str,
) -> tuple[Said, Evidence | None]:
    """What the tests say, and the evidence of those by line, if there is any."""
    hits = method == "transient" or (method == "auto" and is_transient(rec))
    said, live = _in_time(rec, hits)
    if live is None:
        return said + _none_by_line("no channel moves"), None
    if hits:
        try:
            spectra = transient_spectra(live, include_force=live.force is not None)
        except UnsuitableDataError as exc:
            advice = f"{exc.got[0].upper()}{exc.got[1:]}. {exc.remedy}"
            finding = Finding(MISSED_HIT, "fatal", (), 0.0, 0.0, "No whole hit is in the record.", advice)
            return [*said, finding, *_none_by_line("no whole hit is in the record")], None
        length, taper = None, None
        said += _single_hit(spectra.n_averages)
    else:
        try:
            length = choose_nperseg(live, band) if nperseg is None else nperseg
        except InvalidInputError:
            return said + [_hopeless(live)] + _none_by_line("the record is too short for a spectrum"), None
        taper = window_values(window, length)
        spectra = cross_spectra(
            live, nperseg=length, noverlap=noverlap, window=window, include_force=live.force is not None
        )
        said += resolution.averages(spectra.n_effective, live.duration_s, length)
    inside = (spectra.freq_hz >= band[0]) & (spectra.freq_hz <= band[1]) & (spectra.freq_hz > 0.0)
    if inside.sum() < resolution.LEAST_LINES:
        return said + [resolution.too_few_lines(int(inside.sum()), band)] + _none_by_line(
            "too few lines in the band"
        ), None
    spectra, frfs = _without_force(spectra, inside, live)
    said += _resolution(live, spectra, inside, band, length, chosen=nperseg is None)
    seen = of_spectra(spectra, inside, live.dofs, nperseg=length, fs_hz=live.fs_hz, taper=taper)
    dead = channels.unrelated(seen)
    lost = {dof for one in dead if isinstance(one, Finding) for dof in one.where}
    rows = [p for p, dof in enumerate(live.dofs) if dof not in lost]
    if 0 < len(rows) < len(live.dofs):
        # What holds only noise must not speak in the other tests.
        spectra, frfs = _some(spectra, rows), None if frfs is None else frfs[rows]
        seen = of_spectra(
            spectra, inside, tuple(live.dofs[p] for p in rows), nperseg=length, fs_hz=live.fs_hz, taper=taper
        )
    return [
        *said,
        *dead,
        *phase.in_phase(seen),
        *channels.buried(seen, lost),
        *one_force.one_force(seen),
        *force_location.force_location(seen, excitation, frfs),
    ], seen


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
    moving, names = data[rows], tuple(labels[p] for p in rows)
    if force is None:
        said += channels.clipped(moving, names)
    else:
        said += channels.clipped(np.vstack([moving, force]), (*names, FORCE))
    if hits:
        why = "in a record of hits, rest and blows look like dropouts and spikes"
        said += [NotTested(channels.DROPOUTS, why), NotTested(channels.SPIKES, why)]
    else:
        said += channels.interrupted(moving, names, rec.fs_hz)
    twice, extra = channels.duplicated(moving, names)
    said += twice
    keep = [p for p in range(len(rows)) if p not in extra]
    if len(keep) == rec.n_channels and force is rec.force:
        return said, rec
    return said, Recording(moving[keep], rec.fs_hz, [names[p] for p in keep], force)


def _without_force(
    spectra: CrossSpectra, inside: Any, rec: Recording
) -> tuple[CrossSpectra, ComplexArray | None]:
    """Spectra of the responses alone, and their FRFs where the force was recorded and is believed."""
    if rec.force is None:
        return spectra, None
    matrix = spectra.matrix[inside]
    auto = np.einsum("fii->if", matrix).real
    to_force = matrix[:, -1, :-1].T
    power = np.maximum(auto[-1], 1e-300)
    coherence = np.abs(to_force) ** 2 / np.maximum(power * auto[:-1], 1e-300)
    # Where the force does not explain the response, no sign: zero.
    frfs = np.where(coherence >= LEAST_COHERENCE, to_force / power, 0.0)
    return _some(spectra, list(range(rec.n_channels))), frfs


def _some(spectra: CrossSpectra, rows: list[int]) -> CrossSpectra:
    """Spectra of some of the channels."""
    return replace(
        spectra,
        matrix=spectra.matrix[:, rows][:, :, rows],
        segments=None,
        noise=None if spectra.noise is None else spectra.noise[rows],
    )


def _resolution(
    rec: Recording,
    spectra: CrossSpectra,
    inside: Any,
    band: tuple[float, float],
    length: int | None,
    *,
    chosen: bool,
) -> Said:
    """Lines per bandwidth, the bandwidth being measured with the longest segments if need be."""
    spacing = float(spectra.freq_hz[1] - spectra.freq_hz[0])
    lines = resolution.sharpest_lines(_power(spectra, inside), leakage=length is not None)
    if length is None:
        # An exponential window has widened the resonances by a known amount.
        widened = spectra.added_decay_per_s / np.pi
        return resolution.without_leakage(
            None if lines is None else max(lines * spacing - widened, 0.0), spacing, hit=True
        )
    longest, bandwidth = _power_of_two(rec.n_samples / SEGMENTS), None
    if lines is not None:
        bandwidth = lines * spacing
    if longest > length and (lines is None or lines < resolution.TRUSTED):
        long = cross_spectra(rec, nperseg=longest)
        finer = resolution.sharpest_lines(_power(long, (long.freq_hz >= band[0]) & (long.freq_hz <= band[1])))
        if finer is not None:
            lines, bandwidth = finer, finer * float(long.freq_hz[1])
    return resolution.of_segments(
        bandwidth,
        spacing,
        rec.duration_s,
        longer=longest > length,
        chosen=chosen,
        known=lines is not None and lines >= 1.0,
    )


def _power(spectra: CrossSpectra, inside: Any) -> FloatArray:
    """All channels at equal weight, by line."""
    auto = np.einsum("fii->if", spectra.matrix[inside]).real
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
            "A single hit: no averages. Coherence, the noise by line and whether one force is enough "
            "cannot be told.",
            "Hit the same point several times and record all hits together.",
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
