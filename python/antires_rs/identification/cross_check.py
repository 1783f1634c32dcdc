"""Do the antiresonances stand when found by another method?

The identification chooses values that stay while the order of a polynomial fit rises. Here one rational
function of fixed size is fitted to the same transmissibilities by a method that shares none of that: AAA
(supports chosen one after the other, no polynomial, no sweep) or vector fitting (poles moved from an even
grid, none of them taken from the identification). A value is *confirmed* if a pole of the other method that
owns a part of the curve lies within ``tol`` of it. Strong poles that the identification does not have are
*candidates*.

Both methods see the same averages of the same record: agreement tells that a value is no artefact of the
fit, not that the record is free of fault.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError
from ..order_sweep.flanks import flanked
from ..order_sweep.limits import (
    CANDIDATE_DOMINANCE,
    CANDIDATE_SNR,
    CONFIRMING_DOMINANCE,
    CROSS_CHECK_DAMPING,
    LEAST_POLES,
    MORE_POLES,
)
from ..order_sweep.shared import shared
from ..order_sweep.windows import Window, windows
from ..rational.aaa import set_valued_aaa
from ..rational.vector_fitting import vector_fitting
from ..signals.averaging import METHODS as AVERAGING_METHODS
from ..signals.averaging import Averaging, average
from ..signals.band import covered_hz
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.pickling import ReadOnly, frozen
from ..support.validation import (
    ComplexArray,
    FloatArray,
    choice,
    finite_scalar,
    frequency_band,
    integer,
    reject,
)
from .lines import Lines
from .response_lines import lines_of

__all__ = ["METHODS", "CrossCheck", "SecondOpinion", "cross_check", "judge", "second_opinion"]

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
        total = sum(f.size for f in self.freq_hz.values())
        more = sum(f.size for f in self.candidates_hz.values())
        return (
            f"CrossCheck(method={self.method!r}, {total - len(self.flagged)} of {total} values "
            f"confirmed, {more} candidates)"
        )

    def __str__(self) -> str:
        total = sum(f.size for f in self.freq_hz.values())
        name = {"aaa": "AAA", "vector_fitting": "vector fitting"}[self.method]
        lines = [
            f"cross-check by {name}: {total - len(self.flagged)} of {total} values confirmed "
            f"within {100 * self.tol:g} %"
        ]
        for dof, ok in self.confirmed.items():
            for i in np.flatnonzero(~ok):
                near = self.nearest_hz[dof][i]
                said = (
                    f"its nearest pole is {near:.3f} Hz, {100 * self.distance[dof][i]:.1f} % away"
                    if np.isfinite(near)
                    else "it has no pole in the band"
                )
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

    Parameters
    ----------
    source : Recording or FrequencyResponse
        What they were identified from.
    identified : AntiresonanceSet
        The values, or any mapping of dof to Hz; its dofs are channels of ``source``.
    band_hz : (low, high)
        As in the identification.
    method : {"aaa", "vector_fitting"}
        Set-valued AAA or relaxed vector fitting, see :mod:`~antires_rs.rational.aaa` and
        :mod:`~antires_rs.rational.vector_fitting`.
    tol : float
        Relative distance up to which a pole confirms a value.
    n_poles : int, optional
        Poles of the other fit. Default: 8 more than the dof with most values has, at least 12. Only that
        number is taken from ``identified``, nothing of where the values lie.
    nperseg, noverlap, window
        As for :func:`~antires_rs.identify_antiresonances`.
    averaging : {"auto", "welch", "transient"}
        As ``method`` there.

    Returns
    -------
    CrossCheck

    Raises
    ------
    InvalidInputError
        A malformed argument, or a dof that is no channel.
    UnsuitableDataError
        A single channel and no force: there is no quotient to fit.

    Notes
    -----
    Vector fitting is the default: near the noise it confirms more of what is true, AAA takes a fifth of its
    time (``benchmarks/cross_check_table.py`` on the eight-mass chain).
    Candidates are asked to rise out of the noise on both sides: the lowest antiresonances of a response,
    where it lies near its noise, are confirmed, but are not proposed.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> from antires_rs.identification.cross_check import cross_check
    >>> chain = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
    >>> f = np.linspace(0.5, 8.0, 400)
    >>> h = ar.FrequencyResponse(f, chain.frf([0, 1, 2], 0, f, damping_ratio=0.01), dofs=[0, 1, 2])
    >>> guess = {0: [2.2, 3.0, 5.76], 1: [3.56], 2: []}
    >>> print(cross_check(h, guess, band_hz=(0.5, 8.0)))
    cross-check by vector fitting: 3 of 4 values confirmed within 1 %
      dof 0: 3.000 Hz not confirmed: its nearest pole is 2.199 Hz, 26.7 % away
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
    nearest = {dof: _nearest(found[dof][0], f) for dof, f in values.items()}
    distance = {dof: np.abs(nearest[dof] / f - 1.0) for dof, f in values.items()}
    return CrossCheck(
        method,
        float(tol),
        {dof: frozen(f) for dof, f in values.items()},
        {dof: frozen(f) for dof, f in nearest.items()},
        {dof: frozen(d) for dof, d in distance.items()},
        {dof: frozen(d <= tol) for dof, d in distance.items()},
        {dof: frozen(np.asarray(strong[dof], dtype=np.float64)) for dof in values},
    )


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


def _near(freq: FloatArray, value: float, tol: float) -> bool:
    return bool(freq.size) and float(np.abs(freq / value - 1.0).min()) <= tol


def _nearest(freq: FloatArray, values: FloatArray) -> FloatArray:
    if not freq.size:
        return np.full(values.size, np.nan)
    return np.asarray(freq[np.argmin(np.abs(freq[None, :] / values[:, None] - 1.0), axis=1)])


def _apart(freq: FloatArray, values: FloatArray, tol: float) -> FloatArray:
    """Ascending, none near a value already there, of several near each other the first."""
    kept: list[float] = []
    for f in np.sort(freq):
        if not _near(values, f, 2.0 * tol) and not (kept and f <= kept[-1] * (1.0 + tol)):
            kept.append(float(f))
    return np.array(kept)


#: The names that these had before.
SecondOpinion = CrossCheck
second_opinion = cross_check
