r"""Does the force act where it is said to?

At the driving point k every mode has a residue of one sign, phi_kr^2, and so resonances and antiresonances of
H_kk alternate: exactly one zero between neighbouring poles. Any other dof lacks one somewhere, unless its
mode shapes have the signs of those of k in all modes of the band.

No force is needed to see that, and no zero has to be found. The responses at one line are N_p(w) / D(w), with
D common to all, so the vector N(w), real but for damping, is known at each line up to a factor. It moves
steadily from line to line; followed through the lines between two resonances, the sign of its component k at
the next one, compared with the last, tells whether the number of zeros of H_kk between them is odd or even.
The signs are read at the resonances, where every response is far above its noise, and the direction in
between from all channels together; the zero itself may lie deep in noise.

With the force recorded the residues are seen directly: the imaginary parts of the accelerance H_kk at the
resonances have one sign.

References: D. K. Miu, ASME J. Dyn. Syst. Meas. Control 113 (1991) 419-424 (zeros of a driving point interlace
with the poles); D. J. Ewins, Modal Testing, 2nd ed., 2000, ch. 2 (antiresonances of point FRFs).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.checks import ComplexArray, FloatArray
from .findings import Finding, NotTested, Said
from .half_spectra import prominent_peaks
from .one_force import Evidence

NAME = "force_location"
# A resonance stands this much (dB) over the valleys beside it, in the power of all channels together,
PROMINENCE_DB = 8.0
# ... and its signal-to-noise power is at least that of a vector good to a few degrees.
PEAK_SNR = 100.0
# ... and lifts the median channel by this factor over its power this part of the frequency away, on both
# sides.
SHARED, PEAK_WIDTH = 2.0, 0.04
# The lines of a resonance are those above this share of its height.
PEAK_FOOT = 0.25
# The power is averaged over lines until so many averages stand behind it: ripples of few averages are no
# peaks. Measured responses and single impacts have none, and need none.
PEAK_AVERAGES = 40.0
# The direction of two channels passes through near-coincident zeros of both without a trace.
LEAST_CHANNELS = 3
# Between neighbouring lines the direction must not turn further than this (cosine) to be followed.
LEAST_OVERLAP = 0.7
# A component has a sign if it is this many standard deviations long, more at a resonance, where the test
# stands on it, and in phase with the others within 45 degrees.
SURE, SURE_AT_PEAK = 4.0, 10.0
IN_PHASE = 0.7
# A dip: the power on both sides, this part of the frequency or of the gap away, over that in the middle,
# averaged over a quarter of the distance on either side. The valley between two resonances without a zero
# rises by 1.5 over a fifth of its width.
DIP, DIP_WIDTH, DIP_GAP, DIP_SMOOTHING = 2.0, 0.05, 0.2, 4


def force_location(seen: Evidence, excitation: Any, frfs: ComplexArray | None = None) -> Said:
    """Is the stated dof the driving point, and if not, which recorded one is?

    ``frfs``, (n, n_freq), where the force was measured: residues are then seen, not inferred.
    """
    if excitation is None:
        return [NotTested(NAME, "no excitation was stated")]
    if excitation not in seen.dofs:
        return [NotTested(NAME, f"the response at dof {excitation!r} was not recorded, or holds no signal")]
    peaks = resonances(seen)
    if peaks.size < 2:
        return [NotTested(NAME, f"{peaks.size} resonance(s) stand out of the band; two are needed")]
    row = seen.dofs.index(excitation)
    if frfs is not None:
        pairs = _residues(_over_peaks(seen, frfs, peaks))
        found = _judge(
            seen,
            excitation,
            peaks,
            pairs,
            "its residues change their sign, as those of a driving point never do,",
        )
        if found or len(seen.dofs) < LEAST_CHANNELS:
            return found
    elif len(seen.dofs) < LEAST_CHANNELS:
        return [
            NotTested(
                NAME,
                f"without the force {LEAST_CHANNELS} channels are needed, of which "
                f"{len(seen.dofs)} are there",
            )
        ]
    pairs = followed(seen, peaks)
    if not pairs[row]:
        return [
            NotTested(
                NAME,
                f"the signs of dof {excitation!r} at the {peaks.size} resonances of the band "
                "could not be followed from one to the next: the lines are too far apart or "
                "too noisy",
            )
        ]
    return _judge(
        seen,
        excitation,
        peaks,
        pairs,
        "it lacks an antiresonance, of which a driving point has one between any two resonances,",
    )


def _judge(
    seen: Evidence, excitation: Any, peaks: Any, pairs: list[list[tuple[int, int, bool]]], lack: str
) -> Said:
    """The finding, if any pair of resonances speaks against the stated dof."""
    own = pairs[seen.dofs.index(excitation)]
    wrong = [pair for pair in own if not pair[2]]
    if not wrong:
        return []
    low, high = (float(seen.freq_hz[peaks[i]]) for i in wrong[0][:2])
    others = [
        dof
        for dof, of_dof in zip(seen.dofs, pairs, strict=True)
        if len(of_dof) >= max(1, (peaks.size - 1) // 2) and all(same for _, _, same in of_dof)
    ]
    text = (
        f"The force does not seem to act at dof {excitation!r}: {lack} in {len(wrong)} of {len(own)} "
        f"gaps, the first being {low:.4g}-{high:.4g} Hz."
    )
    if others:
        names = " or ".join(repr(dof) for dof in others)
        advice = f"Dof {names} would fit: check which dof was excited, and the order of the channels."
        return [Finding(NAME, "fatal", (excitation,), float(len(wrong)), 0.0, text, advice)]
    advice = "No recorded dof would fit: check where the force acted, and the order of the channels."
    return [Finding(NAME, "warning", (excitation,), float(len(wrong)), 0.0, text, advice)]


def _over_peaks(seen: Evidence, frfs: ComplexArray, peaks: Any) -> ComplexArray:
    """Sums of FRFs over the lines of each resonance, (n, n_peaks): what is odd about its middle cancels."""
    smooth = _smoothed(seen.power, _half_width(seen))
    sums = np.empty((frfs.shape[0], peaks.size), dtype=np.complex128)
    for i, peak in enumerate(peaks):
        under = np.flatnonzero(smooth < PEAK_FOOT * smooth[peak])
        at = int(np.searchsorted(under, peak))
        low = under[at - 1] + 1 if at > 0 else 0
        high = under[at] if at < under.size else smooth.size
        sums[:, i] = frfs[:, low:high].sum(axis=1)
    return sums


def _residues(over_peaks: ComplexArray) -> list[list[tuple[int, int, bool]]]:
    """For every dof: neighbouring resonances at which its FRF has residues of equal or opposite sign."""
    unit = over_peaks / np.maximum(np.abs(over_peaks), 1e-300)
    # Imaginary for accelerance and receptance, real for mobility: the axis along which they lie, common to
    # all.
    mean = np.sum(unit**2) / max(int(np.count_nonzero(unit)), 1)
    along = (unit * np.exp(-0.5j * np.angle(mean))).real
    pairs: list[list[tuple[int, int, bool]]] = [[] for _ in over_peaks]
    if np.abs(mean) >= IN_PHASE:
        for p, row in enumerate(along):
            sure = np.flatnonzero(np.abs(row) >= IN_PHASE)
            pairs[p] = [
                (int(a), int(b), bool(row[a] * row[b] > 0.0))
                for a, b in zip(sure[:-1], sure[1:], strict=True)
            ]
    return pairs


def resonances(seen: Evidence) -> Any:
    """Indices of the lines of the resonances, ascending."""

    half = _half_width(seen)
    smooth = _smoothed(seen.power, half)
    level = 10.0 * np.log10(np.maximum(smooth, 1e-12 * smooth.max()))
    peaks = prominent_peaks(level, PROMINENCE_DB)
    peaks = peaks[smooth[peaks] >= PEAK_SNR]
    # A mode moves most channels; what one of them alone has is its own affair.
    each = np.array([_smoothed(power, half) for power in (np.abs(seen.vectors) ** 2).T])
    distance = np.diff(peaks, prepend=-level.size, append=2 * level.size)
    shared = []
    for i, peak in enumerate(peaks):
        aside = min(
            PEAK_WIDTH * float(seen.freq_hz[peak]) / float(seen.freq_hz[1] - seen.freq_hz[0]),
            0.4 * min(distance[i], distance[i + 1]),
        )
        low, high = max(peak - max(round(aside), 1), 0), min(peak + max(round(aside), 1), level.size - 1)
        around = np.maximum(np.maximum(each[:, low], each[:, high]), 1e-300)
        shared.append(np.median(each[:, peak] / around) >= SHARED)
    return peaks[np.array(shared, dtype=bool)]


def _half_width(seen: Evidence) -> int:
    """Lines on either side over which powers are averaged."""
    half = 0 if seen.eigenvalues is None else int(np.ceil(0.5 * (PEAK_AVERAGES / seen.n_averages - 1.0)))
    return min(max(half, 1), seen.power.size // 4)


def _smoothed(power: FloatArray, half: int) -> FloatArray:
    kernel = np.ones(2 * half + 1) / (2 * half + 1)
    return np.asarray(np.convolve(np.pad(power, half, "edge"), kernel, "valid"), dtype=np.float64)


def _dips(power: FloatArray, freq_hz: FloatArray) -> bool:
    """Whether a power between two resonances has the sharp dip of a zero, not just the valley of the two."""
    width = min(DIP_WIDTH * float(freq_hz[0]), DIP_GAP * float(freq_hz[-1] - freq_hz[0]))
    lines = max(round(width / float(freq_hz[1] - freq_hz[0])), 1)
    if power.size <= 2 * lines:
        return True
    level = _smoothed(power, max(lines // DIP_SMOOTHING, 1))
    ratio = np.minimum(level[: -2 * lines], level[2 * lines :]) / np.maximum(level[lines:-lines], 1e-300)
    return bool(ratio.max() > DIP)


def followed(seen: Evidence, peaks: Any) -> list[list[tuple[int, int, bool]]]:
    """For every dof: neighbouring resonances that could be compared, and whether its zeros alternate.

    An even number of zeros counts against the dof only if it is none, the component keeping its sign at every
    line between: two may mean a resonance that was not seen, as of a mode with a node near the force. Nor may
    the component dip, as in an antiresonance that all channels share, through which no direction can be
    followed.
    """
    power = np.abs(seen.vectors) ** 2
    pairs: list[list[tuple[int, int, bool]]] = [[] for _ in seen.dofs]
    for i, (a, b) in enumerate(zip(peaks[:-1], peaks[1:], strict=True)):
        track = _track(seen, slice(a, b + 1))
        if track is None:
            continue
        for p, signs in enumerate(track.T):
            if signs[0] * signs[-1] < 0.0:
                pairs[p].append((i, i + 1, True))
            elif (
                signs[0] != 0.0
                and (signs == signs[0]).all()
                and not _dips(power[a : b + 1, p], seen.freq_hz[a : b + 1])
            ):
                pairs[p].append((i, i + 1, False))
    return pairs


def _track(seen: Evidence, gap: slice) -> FloatArray | None:
    """Sign of every component at the lines from one resonance to the next, 0 where not sure, (n_lines, n).

    None if the direction cannot be followed.
    """
    # An averaged eigenvector is good to the noise over the root of the averages.
    heard = np.abs(seen.vectors[gap]) * np.sqrt(seen.n_averages)
    level = np.median(heard, axis=0)
    loud = level >= SURE
    if loud.sum() < 2:
        return None
    # Components at equal weight, or a strong one would hide the others even in its own antiresonance, where
    # its turn is the very thing to be seen against them.
    balanced = np.where(loud, seen.vectors[gap] / np.maximum(level, 1e-300), 0.0)
    unit = balanced / np.maximum(np.linalg.norm(balanced, axis=1, keepdims=True), 1e-300)
    inner = np.einsum("fi,fi->f", unit[:-1].conj(), unit[1:])
    if np.abs(inner).min() < LEAST_OVERLAP:
        return None
    steady = unit * np.exp(-1j * np.concatenate([[0.0], np.cumsum(np.angle(inner))]))[:, None]
    # The line in the complex plane along which the components lie turns slowly, if at all.
    axis = 0.5 * np.unwrap(np.angle(np.sum(steady**2, axis=1)))
    along = (steady * np.exp(-1j * axis)[:, None]).real
    sure = (heard >= SURE) & (np.abs(along) >= IN_PHASE * np.abs(steady)) & loud
    sure[[0, -1]] &= heard[[0, -1]] >= SURE_AT_PEAK
    return np.where(sure, np.sign(along), 0.0)
