"""Do the antiresonances stand when found by another method?

One rational function of fixed size is fitted to the same transmissibilities by a method that shares nothing
with the sweep over orders: AAA (supports chosen one after the other, no polynomial) or vector fitting (poles
moved from an even grid, none of them taken from the identification). A value is *confirmed* if a pole of the
other method that owns a part of the curve lies within ``tol`` of it; strong poles that the identification
does not have are *candidates*. Both see the same averages of the same record: agreement tells that a value is
no artefact of the fit, not that the record is free of fault.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError, reject
from ..signals.averaging import METHODS as AVERAGING_METHODS, Averaging, average
from ..signals.frequency_response import FrequencyResponse, covered_hz
from ..signals.recording import Recording
from ..support.checks import ComplexArray, FloatArray, choice, finite_scalar, frequency_band, integer
from ..support.values import ReadOnly, frozen
from .lines import Lines, lines_of
from .rational_fit import scaled_lstsq, share_of_curve, stacked
from .scores import shared
from .stabilization import Window, flanked, windows

# -- AAA for many curves at once: barycentric rational functions with common poles
#
# r_o(z) = sum_k w_k Y_o(z_k) / (z - z_k)  /  sum_k w_k / (z - z_k), lines z_k as supports. The next support
# is the line of largest misfit, with the weights of the fit, so that noise attracts none; then w is the right
# singular vector, for the smallest singular value, of the Loewner matrices of all outputs one under the
# other. The poles are those of an arrowhead pencil.
#
# References: Y. Nakatsukasa, O. Sete and L. N. Trefethen, SIAM J. Sci. Comput. 40 (2018) A1494-A1522;
# P. Lietaert, K. Meerbergen, J. Perez and B. Vandereycken, IMA J. Numer. Anal. 42 (2022) 1087-1115
# (set-valued).

#: Weighted misfit over the weighted norm of the data at which exact data are exhausted.
EXHAUSTED = 1e-12


def set_valued_aaa(
    freq_hz: FloatArray, values: ComplexArray, weights: FloatArray, n_poles: int
) -> tuple[ComplexArray, FloatArray]:
    """Poles of the outputs and how much of the curves each owns."""
    z = 1j * freq_hz / freq_hz[-1]
    root = np.sqrt(weights / weights.sum())
    size = float(np.linalg.norm(root * values))
    rest = np.ones(z.size, dtype=bool)
    fitted = np.repeat(values.mean(axis=1, keepdims=True), z.size, axis=1)
    supports: list[int] = []
    w = np.empty(0, dtype=np.complex128)
    for _ in range(n_poles + 1):
        misfit = np.where(rest, root * np.linalg.norm(values - fitted, axis=0), 0.0)
        if np.linalg.norm(misfit) <= EXHAUSTED * size:
            break
        supports.append(int(np.argmax(misfit)))
        rest[supports[-1]] = False
        cauchy = 1.0 / (z[rest, None] - z[supports])
        weighed = root[rest, None] * cauchy
        loewner = np.concatenate([weighed * (y[rest, None] - y[supports]) for y in values])
        w = np.linalg.svd(np.linalg.qr(loewner, mode="r"))[2][-1].conj()
        fitted = values.copy()
        fitted[:, rest] = ((cauchy @ (w[:, None] * values[:, supports].T)) / (cauchy @ w)[:, None]).T
    at, above = z[supports], w[:, None] * values[:, supports].T
    poles = _poles_of_pencil(at, w)
    # Residue = numerator over the slope of the denominator.
    cauchy, beside = _cauchy(poles, at), _cauchy(np.asarray(1j * poles.imag), at)
    residue = np.linalg.norm(cauchy @ above, axis=1) / np.maximum(np.abs(cauchy**2 @ w), 1e-300)
    curve = np.linalg.norm(beside @ above, axis=1) / np.maximum(np.abs(beside @ w), 1e-300)
    return poles * (2 * np.pi * freq_hz[-1]), share_of_curve(residue, poles.real, curve)


def _poles_of_pencil(supports: ComplexArray, w: ComplexArray) -> ComplexArray:
    """Finite eigenvalues of the arrowhead pencil that lie above the real axis."""
    from scipy.linalg import eigvals  # slow to import

    m = supports.size
    if m < 2:
        return np.empty(0, dtype=np.complex128)
    arrow, unit = np.zeros((m + 1, m + 1), dtype=np.complex128), np.eye(m + 1)
    unit[0, 0] = 0.0
    arrow[0, 1:], arrow[1:, 0] = w, 1.0
    arrow[1:, 1:] = np.diag(supports)
    with np.errstate(divide="ignore", invalid="ignore"):  # two eigenvalues are infinite by construction
        found = eigvals(arrow, unit)
    found = found[np.isfinite(found)]
    return np.asarray(found[found.imag > 0.0], dtype=np.complex128)


def _cauchy(z: ComplexArray, supports: ComplexArray) -> ComplexArray:
    gap = z[:, None] - supports
    # A point on a support itself: the limit is reached to rounding a hair beside it.
    return np.asarray(1.0 / np.where(gap == 0.0, 1e-15, gap))


# -- Vector fitting with common poles: rational functions found by moving their poles
#
# Y_o(s) = sum_k c_ok / (s - a_k) + d_o + s e_o. With poles a_k given, sigma(s) = sum_k c_k / (s - a_k) + d is
# sought for which all sigma Y_o have these same poles; the zeros of sigma are better poles. The unknowns of
# the outputs are projected out, and of sigma only Re sum_n sigma(s_n) = n_freq is asked ("relaxed"). Poles
# that wander into the right half plane stay there: mirrored, spurious ones would come back as sharp peaks.
#
# References: B. Gustavsen and A. Semlyen, IEEE Trans. Power Delivery 14 (1999) 1052-1061; B. Gustavsen, ibid.
# 21 (2006) 1587-1592 (relaxed); D. Deschrijver, M. Mrozowski, T. Dhaene and D. De Zutter, IEEE Microw. Wirel.
# Compon. Lett. 18 (2008) 383-385 (projection).

ITERATIONS = 12
#: Damping ratio of the starting poles, which lie evenly over the band.
START_DAMPING = 0.01
#: The constant of sigma is kept from vanishing: its poles would go to infinity.
LEAST_CONSTANT = 1e-8


def vector_fitting(
    freq_hz: FloatArray, values: ComplexArray, weights: FloatArray, n_poles: int
) -> tuple[ComplexArray, FloatArray]:
    """Poles of the outputs and how much of the curves each owns."""
    s = 1j * freq_hz / freq_hz[-1]
    root = np.sqrt(weights / weights.sum())[:, None]
    low = freq_hz[0] / freq_hz[-1]
    start = low + (np.arange(n_poles) + 0.5) * (1.0 - low) / n_poles
    poles = start * (-START_DAMPING + 1j)
    size = float(np.linalg.norm(root.T * values))
    for _ in range(ITERATIONS):
        phi = _fractions(s, poles)
        q = np.linalg.qr(stacked(root * _with_line(phi, s)))[0]
        one = root * np.hstack([phi, np.ones((s.size, 1))])
        blocks = []
        for value in values:
            rest = stacked(one * value[:, None])
            blocks.append(np.linalg.qr(rest - q @ (q.T @ rest), mode="r"))
        relaxed = np.append(phi.real.mean(axis=0), 1.0) * size
        rows = np.concatenate([*blocks, relaxed[None, :]])
        target = np.zeros(rows.shape[0])
        target[-1] = size
        solution = scaled_lstsq(rows, target[:, None])[:, 0]
        poles = _zeros(poles, solution[:-1], float(solution[-1]))
    x = scaled_lstsq(stacked(root * _with_line(_fractions(s, poles), s)), stacked(root * values.T))
    residue = np.linalg.norm(x[0 : 2 * poles.size : 2] + 1j * x[1 : 2 * poles.size : 2], axis=1)
    at = np.asarray(1j * poles.imag)
    curve = np.linalg.norm(_with_line(_fractions(at, poles), at) @ x, axis=1)
    return poles * (2 * np.pi * freq_hz[-1]), share_of_curve(residue, poles.real, curve)


def _fractions(s: ComplexArray, poles: ComplexArray) -> ComplexArray:
    """Partial fractions with real coefficients: u + v and i (u - v) for each pair."""
    u, v = 1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())
    out = np.empty((s.size, 2 * poles.size), dtype=np.complex128)
    out[:, 0::2], out[:, 1::2] = u + v, 1j * (u - v)
    return out


def _with_line(phi: ComplexArray, s: ComplexArray) -> ComplexArray:
    """The constant and the term in s, which stand for all poles far outside the band."""
    return np.hstack([phi, np.ones((s.size, 1)), s[:, None]])


def _zeros(poles: ComplexArray, c: FloatArray, d: float) -> ComplexArray:
    """Zeros of sigma, one of each pair: eigenvalues of A - b c' / d."""
    d = float(np.copysign(max(abs(d), LEAST_CONSTANT), d))
    a = np.zeros((2 * poles.size, 2 * poles.size))
    even = np.arange(0, 2 * poles.size, 2)
    a[even, even] = a[even + 1, even + 1] = poles.real
    a[even, even + 1], a[even + 1, even] = poles.imag, -poles.imag
    b = np.zeros(2 * poles.size)
    b[even] = 2.0
    z = np.linalg.eigvals(a - np.outer(b, c) / d)
    upper, real = z[z.imag > 0.0], np.sort(z[z.imag == 0.0].real)
    # Two real poles become a pair with the same sum; they belong to no antiresonance anyway.
    pairs = 0.5 * (real[0::2] + real[1::2]) + 1j * np.maximum(0.5 * (real[1::2] - real[0::2]), 1e-3)
    return np.concatenate([upper, pairs])


# Poles: this many more than the dof with most values has, and never fewer than the second number.
MORE_POLES, LEAST_POLES = 8, 12
# A pole that owns less of the curve confirms nothing, one that owns less than the second is no candidate;
# a candidate has this signal-to-noise power beside it (3 dB).
CONFIRMING_DOMINANCE, CANDIDATE_DOMINANCE = 0.3, 0.7
CANDIDATE_SNR = 2.0
CROSS_CHECK_DAMPING = 0.10

METHODS: dict[str, Callable[..., tuple[ComplexArray, FloatArray]]] = {
    "aaa": set_valued_aaa,
    "vector_fitting": vector_fitting,
}


@dataclass(frozen=True, repr=False)
class CrossCheck(ReadOnly):
    """What another method says of identified values.

    Attributes
    ----------
    method : {"aaa", "vector_fitting"}
    tol : float
        Relative distance up to which a pole confirms.
    freq_hz : dict
        By dof: the values judged, (n,).
    nearest_hz, distance : dict
        By dof: the nearest pole of the other method and its relative distance; NaN where it has none.
    confirmed : dict
        By dof: (n,) bool.
    candidates_hz : dict
        By dof: strong poles of the other method that are not among the values, (m,).
    """

    method: str
    tol: float
    freq_hz: Mapping[Any, FloatArray]
    nearest_hz: Mapping[Any, FloatArray]
    distance: Mapping[Any, FloatArray]
    confirmed: Mapping[Any, Any]
    candidates_hz: Mapping[Any, FloatArray]

    @property
    def flagged(self) -> list[tuple[Any, float]]:
        """(dof, frequency in Hz) of every value that is not confirmed."""
        return [(dof, float(f)) for dof, ok in self.confirmed.items() for f in self.freq_hz[dof][~ok]]

    def is_confirmed(self, dof: Any, freq_hz: float) -> bool | None:
        """Whether this very value is confirmed; None if it was not judged."""
        at = np.flatnonzero(self.freq_hz.get(dof, np.empty(0)) == freq_hz)
        return bool(self.confirmed[dof][at[0]]) if at.size else None

    def __repr__(self) -> str:
        more = sum(f.size for f in self.candidates_hz.values())
        return f"CrossCheck(method={self.method!r}, {self._counted} confirmed, {more} candidates)"

    @property
    def _counted(self) -> str:
        total = sum(f.size for f in self.freq_hz.values())
        return f"{total - len(self.flagged)} of {total} values"

    def __str__(self) -> str:
        name = {"aaa": "AAA", "vector_fitting": "vector fitting"}[self.method]
        lines = [f"cross-check by {name}: {self._counted} confirmed within {100 * self.tol:g} %"]
        for dof, ok in self.confirmed.items():
            for i in np.flatnonzero(~ok):
                near, off = self.nearest_hz[dof][i], self.distance[dof][i]
                said = f"its nearest pole is {near:.3f} Hz, {100 * off:.1f} % away"
                said = said if np.isfinite(near) else "it has no pole in the band"
                lines.append(f"  dof {dof}: {self.freq_hz[dof][i]:.3f} Hz not confirmed: {said}")
        for dof, more in self.candidates_hz.items():
            if more.size:
                lines.append(f"  dof {dof}: candidates " + ", ".join(f"{f:.3f}" for f in more) + " Hz")
        return "\n".join(lines)


def cross_check(
    source: Recording | FrequencyResponse,
    identified: Mapping[Any, FloatArray],
    *,
    band_hz: Sequence[float],
    method: str = "vector_fitting",
    tol: float = 0.01,
    n_poles: int | None = None,
    nperseg: int | None = None,
    noverlap: int | None = None,
    window: Any = "hann",
    averaging: str = "auto",
) -> CrossCheck:
    """Judge identified antiresonances by a method that had no part in finding them.

    Vector fitting is the default: near the noise it confirms more of what is true, AAA takes a fifth of its
    time (``benchmarks/cross_check_table.py``). Candidates are asked to rise out of the noise on both sides:
    the lowest antiresonances of a response are confirmed, but not proposed.
    """
    choice("method", method, tuple(METHODS))
    choice("averaging", averaging, AVERAGING_METHODS)
    finite_scalar("tol", tol, low=0.0, high=0.5, low_open=True)
    if not isinstance(identified, Mapping):
        reject(
            "identified",
            type(identified).__name__,
            "an AntiresonanceSet, or a mapping of dof to Hz",
            "Pass what identify_antiresonances returned, or {dof: frequencies in Hz}.",
        )
    low_hz, high_hz = covered_hz(source)
    strange = [dof for dof in identified if dof not in source.dofs]
    if strange:
        reject(
            "identified",
            f"dofs {strange}",
            f"dofs of the source, {source.dofs}",
            "Leave out the dofs that the source lacks, or name them as it does.",
        )
    force = len(source.dofs) < 2
    band = frequency_band("band_hz", band_hz, low_hz=low_hz, high_hz=high_hz)
    if force and isinstance(source, Recording) and source.force is None:
        raise UnsuitableDataError(
            "source",
            "a single channel and no force",
            "two or more channels, or a force, so that there is a quotient to fit",
            "Add a channel.",
        )
    averages = None
    if isinstance(source, Recording):
        options = Averaging(nperseg, noverlap, window, averaging)
        averages = average(source, band, options, include_force=force)
    lines_for = lines_of(source, averages, band, use_force=force, estimator="rank1")
    values = {dof: np.sort(np.atleast_1d(np.asarray(f, dtype=np.float64))) for dof, f in identified.items()}
    return judge(lines_for, source.dofs, values, band, method, tol, n_poles)


def judge(
    lines_for: Callable[[int], Lines],
    dofs: Sequence[Any],
    values: Mapping[Any, FloatArray],
    band_hz: tuple[float, float],
    method: str,
    tol: float = 0.01,
    n_poles: int | None = None,
) -> CrossCheck:
    """The cross-check on lines that are there already; ``dofs`` name their rows in order."""
    if n_poles is None:
        n_poles = max([LEAST_POLES, *(f.size + MORE_POLES for f in values.values())])
    n_poles = integer("n_poles", n_poles, low=1)
    found = {}
    for row, dof in enumerate(dofs):
        if dof in values:
            lines = lines_for(row)
            parts = [
                _poles(lines.part(w.first, w.last), row, w, method, n_poles)
                for w in windows(lines.freq_hz, band_hz)
            ]
            found[dof] = [np.concatenate(column) for column in zip(*parts, strict=True)]
    strong = {dof: _apart(freq[candidate], values[dof], tol) for dof, (freq, candidate) in found.items()}
    if 3 <= len(dofs) == len(found):
        # What all channels share is the zero beside a mode that the force hardly excites.
        everywhere = [np.concatenate([found[dof][0], values[dof]]) for dof in found]
        strong = {dof: freq[~shared(freq, everywhere, tol)] for dof, freq in strong.items()}
    nearest = {}
    for dof, f in values.items():
        poles = found[dof][0] if found[dof][0].size else np.array([np.nan])
        nearest[dof] = poles[np.argmin(np.abs(poles / f[:, None] - 1.0), axis=1)]
    distance = {dof: np.abs(nearest[dof] / f - 1.0) for dof, f in values.items()}
    confirmed = {dof: d <= tol for dof, d in distance.items()}
    strong = {dof: np.asarray(strong[dof], dtype=np.float64) for dof in values}
    columns = (values, nearest, distance, confirmed, strong)
    by_dof: list[Any] = [{dof: frozen(column[dof]) for dof in values} for column in columns]
    return CrossCheck(method, float(tol), *by_dof)


def _poles(lines: Lines, row: int, window: Window, method: str, n_poles: int) -> tuple[FloatArray, Any]:
    """Frequencies of the poles that own a part of the curve, and which of them are candidates."""
    quotients, power = lines.quotients(row)
    weights = lines.capped_snr / (1.0 + power)
    most = max(min(n_poles, lines.freq_hz.size // 4), 1)
    s, dominance = METHODS[method](lines.freq_hz, quotients, weights, most)
    decay = -(s.real + lines.added_decay_per_s)
    freq = np.abs(s + lines.added_decay_per_s) / (2 * np.pi)
    damping = decay / np.maximum(2 * np.pi * freq, 1e-300)
    low, high = window.report_hz
    # Near the noise a true pole may come out with slightly negative damping.
    keep = (
        (dominance >= CONFIRMING_DOMINANCE)
        & (np.abs(damping) <= CROSS_CHECK_DAMPING)
        & (freq >= low)
        & (freq <= high)
    )
    strong = (dominance >= CANDIDATE_DOMINANCE) & (decay > 0.0)
    # A peak narrower than the distance of two lines is the noise of one of them.
    strong &= -s.real / np.pi >= float(np.median(np.diff(lines.freq_hz)))
    strong &= flanked(lines.freq_hz, lines.channel_snr(row), freq, CANDIDATE_SNR)
    return freq[keep], strong[keep]


def _apart(freq: FloatArray, values: FloatArray, tol: float) -> FloatArray:
    """Ascending, none near a value already there, of several near each other the first."""
    kept: list[float] = []
    for f in np.sort(freq).tolist():
        if not np.any(np.abs(values / f - 1.0) <= 2.0 * tol) and not (kept and f <= kept[-1] * (1.0 + tol)):
            kept.append(f)
    return np.array(kept)
