"""Does one force explain the responses?

Under one force and independent noise the spectral matrix, scaled to equal noise, has one large eigenvalue.
A second, independent force lifts the second; so do the scatter of few averages, whose mean is known, and
leakage: within the width of the window the response changes its direction, and the first vectors, spread by
the window as the window spreads power, tell how much second eigenvalue that makes. A line counts when its
second eigenvalue stands above both, and above a share of the first.

References: K. Johansson, Commun. Math. Phys. 209 (2000) 437-476, and I. M. Johnstone, Ann. Stat. 29 (2001)
295-327 (largest eigenvalue of noise); C. Y. Shih et al., Mech. Syst. Signal Process. 2 (1988) 367-377
(singular values by line).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.checks import ComplexArray, FloatArray
from .averaging import Averages
from .findings import CheckResults, Finding, NotTested, Severity, rounded
from .spectra import CrossSpectra, pieces, prominent_peaks, running_mean, spectrum, typical_noise

# -- What the tests look at: spectra in the band, brought to equal noise, and their eigenvalues

# A line's power spreads at least as the Hann window lets it, whatever window is said to be used.
HANN_SPREAD = (1.0, 0.25)
# No channel is taken to be quieter than this part of its own power (-60 dB): exact data have no noise at all,
# and scaling by what rounding and leakage leave would weigh channels at random.
LEAST_NOISE = 1e-6
# Lines to which the window spreads less than this part of a tone's power see nothing of it.
LEAST_SPREAD = 1e-6


@dataclass(frozen=True)
class Evidence:
    """Responses as one vector a line, and, for records, how well one vector describes them."""

    dofs: tuple[Any, ...]
    freq_hz: FloatArray
    vectors: ComplexArray
    """(n_freq, n): each line with a free phase, in units in which all channels have equal noise."""
    power: FloatArray  # signal-to-noise power of all channels together, (n_freq,)
    eigenvalues: FloatArray | None = None
    """(n_freq, n): of the covariance of the channels in those units, largest first; None without averages."""
    n_averages: float = 1.0  # effective; 1 for measured responses and single impacts
    signal: FloatArray | None = None  # signal-to-noise power of each channel by line, (n, n_freq)
    coherence: FloatArray | None = None  # highest ordinary one of each channel with any other, (n, n_freq)
    explained: FloatArray | None = None  # share of its power in the band that its best partner explains, (n,)
    nperseg: int | None = None
    fs_hz: float | None = None
    spread: tuple[float, ...] = HANN_SPREAD  # power that the window puts 0, 1, ... lines beside a tone
    spectra: tuple[ComplexArray, FloatArray] | None = None  # averages of conj(A) B, and noise of the channels
    _leakage: dict[int, FloatArray] = field(default_factory=dict, init=False, repr=False, compare=False)

    def leakage(self, order: int = 1) -> FloatArray:
        """Eigenvalue that the window makes beside those of ``order`` forces, (n_freq,)."""
        if order in self._leakage:
            return self._leakage[order]
        vectors = self.vectors[:, None, :]
        if order > 1 and self.spectra is not None:
            matrix, noise = self.spectra
            root = 1.0 / np.sqrt(noise)
            values, own = np.linalg.eigh((matrix * (root[:, None] * root)).conj())
            size = np.sqrt(np.maximum(values[:, None, -order:], 0.0))
            vectors = (own[:, :, -order:] * size).transpose(0, 2, 1)
        # A line's matrix is then the sum of the neighbours' vectors, spread as the window spreads power; its
        # eigenvalues are those of the vectors' inner products, which are a smaller matrix.
        n, known = vectors.shape[:2]
        parts = [vectors]
        for shift, power in enumerate(self.spread[1:], start=1):
            if power > LEAST_SPREAD:
                for step in (shift, -shift):
                    moved = np.zeros_like(vectors)
                    moved[max(step, 0) : n + min(step, 0)] = vectors[max(-step, 0) : n - max(step, 0)]
                    parts.append(np.sqrt(power) * moved)
        stack = np.concatenate(parts, axis=1)
        found = np.zeros(n)
        if stack.shape[1] > known:
            inner = stack.conj() @ stack.transpose(0, 2, 1)
            found = np.maximum(np.linalg.eigvalsh(inner)[:, -1 - known], 0.0)
        self._leakage[order] = found
        return found


def of_spectra(spectra: CrossSpectra, dofs: tuple[Any, ...], averages: Averages) -> Evidence:
    """Evidence of a record's spectra of some channels, on the lines of the band."""
    matrix, freq, fs_hz = spectra.matrix, spectra.freq_hz, averages.rec.fs_hz
    if spectra.n_averages == 1:
        return _of_one_average(spectra, matrix, freq, dofs, fs_hz)
    noise = spectra.noise if spectra.noise is not None else spectra.noise_power
    auto = np.einsum("fii->if", matrix).real
    noise = np.maximum(noise, LEAST_NOISE * auto.mean(axis=1))
    values, vectors = spectrum(matrix, noise)
    first = np.maximum(values[:, 0], 0.0)
    coherence, explained = _best_partners(matrix, auto)
    lines = freq, vectors * np.sqrt(first)[:, None], first, np.maximum(values, 0.0)
    signal = np.maximum(auto / noise[:, None] - 1.0, 0.0)
    channels = spectra.n_effective, signal, coherence, explained
    segments = averages.nperseg, fs_hz, _spread(averages.taper)
    return Evidence(dofs, *lines, *channels, *segments, (matrix, noise))


def of_curves(
    freq_hz: FloatArray, values: ComplexArray, dofs: tuple[Any, ...], coherence: FloatArray | None = None
) -> Evidence:
    """Evidence of measured frequency responses, (n, n_freq): no averages, noise from roughness."""
    noise = typical_noise(values)
    noise[noise <= 0.0] = 1.0
    scaled = values / np.sqrt(noise)[:, None]
    size = np.abs(scaled) ** 2
    lines = freq_hz, np.ascontiguousarray(scaled.T), size.sum(axis=0)
    return Evidence(dofs, *lines, signal=size, coherence=coherence)


def _of_one_average(
    spectra: CrossSpectra, matrix: ComplexArray, freq: FloatArray, dofs: tuple[Any, ...], fs_hz: float
) -> Evidence:
    """A single impact: the matrix is exactly of rank one, and nothing else can be read from it."""
    auto = np.einsum("fii->if", matrix).real
    noise = spectra.noise if spectra.noise is not None else 1e-6 * auto.mean(axis=1)
    noise = np.where(noise > 0.0, noise, 1.0)
    row = int(np.argmax((auto / noise[:, None]).mean(axis=1)))
    # Column of the strongest channel over its root: the spectra themselves, up to a phase a line.
    size = np.sqrt(np.maximum(auto[row], 1e-300))
    vectors = (matrix[:, row, :] / size[:, None]) / np.sqrt(noise)
    power = np.sum(np.abs(vectors) ** 2, axis=1)
    return Evidence(dofs, freq, vectors, power, signal=np.abs(vectors.T) ** 2, fs_hz=fs_hz)


def _best_partners(matrix: ComplexArray, auto: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Highest coherence with another channel by line; best partner's share of the power in the band."""
    n = auto.shape[0]
    if n == 1:
        return np.zeros_like(auto), np.ones(1)
    coherence = np.empty((n, n, len(matrix)))
    for some in pieces(len(matrix), n * n):
        part = matrix[some].transpose(1, 2, 0)
        power = np.maximum(auto[:, None, some] * auto[None, :, some], 1e-300)
        coherence[:, :, some] = np.minimum((part.real**2 + part.imag**2) / power, 1.0)
    coherence[np.arange(n), np.arange(n)] = 0.0
    explained = np.einsum("pqf,pf->pq", coherence, auto) / np.maximum(auto.sum(axis=1), 1e-300)[:, None]
    return coherence.max(axis=1), np.asarray(explained.max(axis=1), dtype=np.float64)


def _spread(taper: FloatArray | None) -> tuple[float, ...]:
    """Power of the window's transform at 0, 1, ... 3 lines, over that at zero."""
    if taper is None:
        return HANN_SPREAD
    power = np.abs(np.fft.rfft(taper)[:4]) ** 2
    power = power / power[0]
    power[:2] = np.maximum(power[:2], HANN_SPREAD)
    return tuple(float(p) for p in power)


ONE_FORCE, NOISE = "one_force", "signal_to_noise"
LEAST_AVERAGES = 4.0  # fewer independent averages than this leave no scatter to compare with
OVER_NOISE = 2.0  # a line counts if the second eigenvalue is twice what noise makes it on average ...
OVER_LEAKAGE = 3.0  # ... three times what leakage makes it (measured: 0.5 to 1.0 times the prediction) ...
# ... and this part of the first; a second force of 0.1 of the first makes 4e-3 at the median line, and
# one of 0.03 is the least that harmed an identification.
LEAST_SHARE = 1e-3
# Share of the lines that must count. Of one force 2 % at most did in 240 records with up to 10 % of noise; of
# a second force of 0.1 of the first 20 to 90 % did.
LINES = 0.10
# Share of the lines, and second over first eigenvalue at their median, above which identified values are
# nonsense: a second force of 0.3 of the first.
FATAL_LINES, FATAL = 0.4, 0.025
SMOOTHING = 15  # noise level of a line is averaged over so many lines
# Second over first eigenvalue at the median line above which one force does not explain the responses at all.
UNEXPLAINED = 0.2
EXCITED = 0.05  # share of the lines that must then rise over the noise for the band to be excited at all


def one_force(seen: Evidence, order: int = 1) -> CheckResults:
    """Second eigenvalue against the first, the noise and the leakage; of ``order`` forces the next."""
    n = len(seen.dofs)
    why = ""
    if seen.eigenvalues is None:
        why = (
            "measured responses and single impacts hold one vector a line, which one force always explains; "
            "a record with several averages is needed"
        )
    elif seen.n_averages < LEAST_AVERAGES:
        count = f"{seen.n_averages:.1f} independent averages"
        why = f"{count}; {LEAST_AVERAGES:g} are needed to tell a second force from noise"
    elif n == 1:
        why = "a single channel has one eigenvalue"
    elif n == 2 and order == 1 and seen.coherence is not None:
        why = (
            "two channels cannot tell a second force from noise; their coherence is "
            f"{float(np.median(seen.coherence)):.3g} at the median line, and what lacks to one is either"
        )
    elif n <= order:
        why = f"{n} channels cannot tell {order} forces from noise; {order + 1} are needed"
    if why or seen.eigenvalues is None:
        return [NotTested(ONE_FORCE, why)]
    if order > 1:
        return _several(seen, order)
    first, second = seen.eigenvalues[:, 0], seen.eigenvalues[:, 1]
    counts = _stands_out(seen, 1)
    lines = float(counts.mean())
    if lines > LINES:
        middle = float(np.median((second - noise_level(seen))[counts] / first[counts]))
        text = (
            f"The responses need more than one force: at {100 * lines:.0f} % of the lines the second "
            "eigenvalue of the spectral matrix stands clear of noise and leakage, at "
            f"{rounded(100 * middle)} % of the first (median of these lines)."
        )
        advice = (
            "Stop the other source (a second shaker, machines, wind, people), or record while only the "
            "known force acts."
        )
        acting = forces_seen(seen)
        if acting is not None and 1 < acting < n - 1:
            advice += f" If {acting} uncorrelated forces act at known places, name all: excitation=[0, 4]."
        severity: Severity = "fatal" if lines > FATAL_LINES and middle > FATAL else "warning"
        return [Finding(ONE_FORCE, severity, (), lines, LINES, text, advice)]
    middle = float(np.median(second / np.maximum(first, 1e-300)))
    if middle > UNEXPLAINED:
        # The first eigenvalue of noise alone is some (1 + sqrt(n / K))^2 of the mean.
        above = first > OVER_NOISE * (1.0 + np.sqrt(n / seen.n_averages)) ** 2 * seen.eigenvalues.mean(axis=1)
        if above.mean() < EXCITED:
            at = f", at {seen.freq_hz[np.argmax(first)]:.4g} Hz above all" if above.any() else ""
            text = (
                "The channels hold noise: the responses rise over what channels do not share at "
                f"{100 * above.mean():.2g} % of the lines of the band{at}."
            )
            advice = "Hit or force harder, over the whole band; a sine excites one line. Check the sensors."
            return [Finding(NOISE, "fatal", (), float(above.mean()), EXCITED, text, advice)]
        text = (
            f"One force does not explain the responses: at the median line the second eigenvalue of the "
            f"spectral matrix is {100 * middle:.0f} % of the first, {100 * UNEXPLAINED:.0f} % being the "
            "limit. Noise and many forces at once look alike here."
        )
        advice = "Force harder, use quieter sensors, narrow the band, or stop other sources."
        return [Finding(ONE_FORCE, "warning", (), middle, UNEXPLAINED, text, advice)]
    return []


# -- How many forces act?
#
# The same question for every eigenvalue: the next one beyond r stands at so many lines above what r forces,
# noise and leakage make it that one more force acts. Forces in proportion (two shakers on one signal) are one
# force here: with r places named, fewer than r dimensions are seen.


def _several(seen: Evidence, order: int) -> CheckResults:
    """Whether ``order`` forces act: not fewer, nor more where a channel beyond them tells of noise."""
    assert seen.eigenvalues is not None
    acting = forces_seen(seen, order + 1)
    assert acting is not None
    if acting > order:
        counts = _stands_out(seen, order)
        share = float(counts.mean())
        middle = float(np.median((seen.eigenvalues[:, order] / seen.eigenvalues[:, order - 1])[counts]))
        text = (
            f"The responses need more than {order} forces: at {100 * share:.0f} % of the lines the next "
            "eigenvalue of the spectral matrix stands clear of noise and leakage, at "
            f"{rounded(100 * middle)} % of that before it (median of these lines)."
        )
        advice = "Name the places of all forces that act, or stop the others (machines, wind, people)."
        severity: Severity = "fatal" if share > FATAL_LINES and middle > FATAL else "warning"
        return [Finding(ONE_FORCE, severity, (), share, LINES, text, advice)]
    if acting == order:
        return []
    share = float(_stands_out(seen, order - 1).mean())
    text = (
        f"{order} places are named, {acting} uncorrelated force{'s are' if acting > 1 else ' is'} seen: "
        f"eigenvalue {order} of the spectral matrix stands clear of noise and leakage at {100 * share:.0f} % "
        "of the lines."
    )
    advice = (
        "Name only the places whose forces act. Two shakers on one signal move in proportion: drive them by "
        "signals of their own, or take turns."
    )
    return [Finding(ONE_FORCE, "fatal", (), share, LINES, text, advice)]


def forces_seen(seen: Evidence, most: int | None = None) -> int | None:
    """How many uncorrelated forces stand above noise and leakage, at most ``most``; None without averages.

    A force beyond the first counts if its eigenvalue does at more than 10 % of the lines. One, two and three
    forces, the last 20 dB below the first or not, were told apart in 120 of 120 records of a chain with 1 and
    5 % of noise (``benchmarks/several_forces.py``).
    """
    if seen.eigenvalues is None or seen.n_averages < LEAST_AVERAGES:
        return None
    most = min(len(seen.dofs) - 1, len(seen.dofs) if most is None else most)
    few = (count for count in range(1, most) if float(_stands_out(seen, count).mean()) <= LINES)
    return next(few, most)


def _stands_out(seen: Evidence, order: int) -> NDArray[np.bool_]:
    """Lines at which eigenvalue ``order``, counted from 0, is of one more force."""
    assert seen.eigenvalues is not None
    own = seen.eigenvalues[:, order]
    counts = (own > OVER_NOISE * noise_level(seen, order)) & (own > LEAST_SHARE * seen.eigenvalues[:, 0])
    if counts.any():
        counts &= own > OVER_LEAKAGE * seen.leakage(order)
    return np.asarray(counts)


def noise_level(seen: Evidence, order: int = 1) -> FloatArray:
    """Mean second eigenvalue under one force and noise, by line, from the lower ones; (n_freq,).

    Under ``order`` forces that of the next.
    """
    assert seen.eigenvalues is not None
    rest = running_mean(seen.eigenvalues[:, order + 1 :].mean(axis=1), SMOOTHING)
    before = order - 1
    return noise_ratio(len(seen.dofs) - before, seen.n_averages - before) * rest


def noise_ratio(n: int, n_averages: float) -> float:
    """Mean second eigenvalue over the mean of the lower ones, under one force and white noise.

    The n - 1 noise eigenvalues are those of a complex Wishart matrix; its largest one by Johnstone's limit
    (mean of the Tracy-Widom law -1.7711), the others by the trace.
    """
    p, m = n - 1.0, max(n_averages - 1.0, 1.0)
    a, b = np.sqrt(m), np.sqrt(p)
    largest = ((a + b) ** 2 - 1.7711 * (a + b) * (1.0 / a + 1.0 / b) ** (1.0 / 3.0)) / m
    largest = min(max(largest, 1.0), 0.95 * p)
    return float(largest * (p - 1.0) / (p - largest))


# -- Does the force act where it is said to?
#
# At the driving point k every mode has a residue of one sign, and so resonances and antiresonances of H_kk
# alternate. Any other dof lacks one somewhere, unless its mode shapes have the signs of those of k in all
# modes of the band. No force is needed to see that, and no zero has to be found: the vector of responses at a
# line, real but for damping, is known up to a factor and moves steadily; followed from one resonance to the
# next, the sign of its component k tells whether the number of zeros of H_kk between them is odd or even.
# With the force recorded the residues are seen directly.
#
# References: D. K. Miu, ASME J. Dyn. Syst. Meas. Control 113 (1991) 419-424 (zeros of a driving point
# interlace with the poles); D. J. Ewins, Modal Testing, 2nd ed., 2000, ch. 2.

FORCE_LOCATION = "force_location"
# A resonance stands this much (dB) over the valleys beside it, in the power of all channels together,
PROMINENCE_DB = 8.0
PEAK_SNR = 100.0  # ... and its signal-to-noise power is at least that of a vector good to a few degrees.
# ... and lifts the median channel by this factor over its power this part of the frequency away, on both
# sides.
SHARED, PEAK_WIDTH = 2.0, 0.04
PEAK_FOOT = 0.25  # the lines of a resonance are those above this share of its height
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


def force_location(seen: Evidence, excitation: Any, frfs: ComplexArray | None = None) -> CheckResults:
    """Is the stated dof driven, and if not, which is? ``frfs`` (n, n_freq) where the force was measured."""
    if excitation is None:
        return [NotTested(FORCE_LOCATION, "no excitation was stated")]
    if isinstance(excitation, tuple):
        return [NotTested(FORCE_LOCATION, "under several forces no response is that of a driving point")]
    if excitation not in seen.dofs:
        why = f"the response at dof {excitation!r} was not recorded, or holds no signal"
        return [NotTested(FORCE_LOCATION, why)]
    peaks = resonances(seen)
    if peaks.size < 2:
        return [NotTested(FORCE_LOCATION, f"{peaks.size} resonance(s) stand out of the band; two are needed")]
    if frfs is not None:
        lack = "its residues change their sign, as those of a driving point never do,"
        found = _judge(seen, excitation, peaks, _residues(_over_peaks(seen, frfs, peaks)), lack)
        if found or len(seen.dofs) < LEAST_CHANNELS:
            return found
    elif len(seen.dofs) < LEAST_CHANNELS:
        why = f"without the force {LEAST_CHANNELS} channels are needed, of which {len(seen.dofs)} are there"
        return [NotTested(FORCE_LOCATION, why)]
    pairs = followed(seen, peaks)
    if not pairs[seen.dofs.index(excitation)]:
        why = (
            f"the signs of dof {excitation!r} at the {peaks.size} resonances of the band could not be "
            "followed from one to the next: the lines are too far apart or too noisy"
        )
        return [NotTested(FORCE_LOCATION, why)]
    lack = "it lacks an antiresonance, of which a driving point has one between any two resonances,"
    return _judge(seen, excitation, peaks, pairs, lack)


def _judge(
    seen: Evidence, excitation: Any, peaks: Any, pairs: list[list[tuple[int, int, bool]]], lack: str
) -> CheckResults:
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
        return [Finding(FORCE_LOCATION, "fatal", (excitation,), float(len(wrong)), 0.0, text, advice)]
    advice = "No recorded dof would fit: check where the force acted, and the order of the channels."
    return [Finding(FORCE_LOCATION, "warning", (excitation,), float(len(wrong)), 0.0, text, advice)]


def _over_peaks(seen: Evidence, frfs: ComplexArray, peaks: Any) -> ComplexArray:
    """Sums of FRFs over the lines of each resonance, (n, n_peaks): what is odd about its middle cancels."""
    smooth = _smoothed_over(seen.power, _half_width(seen))
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
            pairs[p] = [(int(a), int(b), bool(row[a] * row[b] > 0.0)) for a, b in pairwise(sure)]
    return pairs


def resonances(seen: Evidence) -> Any:
    """Indices of the lines of the resonances, ascending."""

    half = _half_width(seen)
    smooth = _smoothed_over(seen.power, half)
    level = 10.0 * np.log10(np.maximum(smooth, 1e-12 * smooth.max()))
    peaks = prominent_peaks(level, PROMINENCE_DB)
    peaks = peaks[smooth[peaks] >= PEAK_SNR]
    # a mode moves most channels; what one of them alone has is its own affair.
    each = np.array([_smoothed_over(power, half) for power in (np.abs(seen.vectors) ** 2).T])
    distance = np.diff(peaks, prepend=-level.size, append=2 * level.size)
    shared = []
    for i, peak in enumerate(peaks):
        wide = PEAK_WIDTH * float(seen.freq_hz[peak]) / float(seen.freq_hz[1] - seen.freq_hz[0])
        aside = max(round(min(wide, 0.4 * min(distance[i], distance[i + 1]))), 1)
        low, high = max(peak - aside, 0), min(peak + aside, level.size - 1)
        around = np.maximum(np.maximum(each[:, low], each[:, high]), 1e-300)
        shared.append(np.median(each[:, peak] / around) >= SHARED)
    return peaks[np.array(shared, dtype=bool)]


def _half_width(seen: Evidence) -> int:
    """Lines on either side over which powers are averaged."""
    half = 0 if seen.eigenvalues is None else int(np.ceil(0.5 * (PEAK_AVERAGES / seen.n_averages - 1.0)))
    return min(max(half, 1), seen.power.size // 4)


def _smoothed_over(power: FloatArray, half: int) -> FloatArray:
    kernel = np.ones(2 * half + 1) / (2 * half + 1)
    return np.asarray(np.convolve(np.pad(power, half, "edge"), kernel, "valid"), dtype=np.float64)


def _dips(power: FloatArray, freq_hz: FloatArray) -> bool:
    """Whether a power between two resonances has the sharp dip of a zero, not just the valley of the two."""
    width = min(DIP_WIDTH * float(freq_hz[0]), DIP_GAP * float(freq_hz[-1] - freq_hz[0]))
    lines = max(round(width / float(freq_hz[1] - freq_hz[0])), 1)
    if power.size <= 2 * lines:
        return True
    level = _smoothed_over(power, max(lines // DIP_SMOOTHING, 1))
    ratio = np.minimum(level[: -2 * lines], level[2 * lines :]) / np.maximum(level[lines:-lines], 1e-300)
    return bool(ratio.max() > DIP)


def followed(seen: Evidence, peaks: Any) -> list[list[tuple[int, int, bool]]]:
    """For every dof: neighbouring resonances that could be compared, and whether its zeros alternate.

    An even number of zeros counts against the dof only if it is none, the component keeping its sign at every
    line between, without a dip: two may mean a resonance that was not seen.
    """
    power = np.abs(seen.vectors) ** 2
    pairs: list[list[tuple[int, int, bool]]] = [[] for _ in seen.dofs]
    for i, (a, b) in enumerate(pairwise(peaks)):
        gap = slice(a, b + 1)
        track = _track(seen, gap)
        for p, signs in enumerate(() if track is None else track.T):
            if signs[0] * signs[-1] < 0.0:
                pairs[p].append((i, i + 1, True))
            elif signs[0] and (signs == signs[0]).all() and not _dips(power[gap, p], seen.freq_hz[gap]):
                pairs[p].append((i, i + 1, False))
    return pairs


def _track(seen: Evidence, gap: slice) -> FloatArray | None:
    """Sign of each component between two resonances, (n_lines, n), 0 where not sure; None if not followed."""
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
