"""Averages of a record, made once: the options, and the value that check, fit and cross-check share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..support.validation import FloatArray, choice
from .bandwidth import Autocorrelation
from .pooled import shortest
from .recording import Recording
from .segment_length import choose_nperseg
from .spectra import CrossSpectra, cross_spectra, window_values
from .transient import is_transient, transient_spectra

__all__ = ["Averages", "Averaging", "average", "holds_hits"]

METHODS = ("auto", "welch", "transient")


@dataclass(frozen=True)
class Averaging:
    """How a record is averaged; the defaults are those of every call that averages records.

    Attributes
    ----------
    nperseg : int or None
        Samples per Welch segment; None: :func:`~antires_rs.signals.segment_length.choose_nperseg` does.
    noverlap : int or None
        Samples shared by neighbours; None: half a segment.
    window : str, tuple or array_like
        As for ``scipy.signal.get_window``; for impacts "rectangular" or "exponential", anything else meaning
        rectangular if the response dies, else exponential.
    method : {"auto", "welch", "transient"}
        "auto" looks at the record's energy profile.
    """

    nperseg: int | None = None
    noverlap: int | None = None
    window: Any = "hann"
    method: str = "auto"

    def checked(self) -> Averaging:
        """The same options, or an error that names the bad one; segments are checked with the record."""
        choice("method", self.method, METHODS)
        return self


@dataclass(frozen=True, eq=False)
class Averages:
    """Averaged spectra of a record on the lines of a band, and how they were made.

    Attributes
    ----------
    options : Averaging
        As they were given.
    spectra : CrossSpectra
        With the segments; the force, if it is there, is the last channel.
    nperseg : int or None
        Samples per segment; None for impacts.
    taper : (nperseg,) or None
    has_force : bool
    correlation : Autocorrelation
        Of the whole record, for what needs the longest segments.
    """

    options: Averaging
    spectra: CrossSpectra
    nperseg: int | None
    taper: FloatArray | None
    has_force: bool
    correlation: Autocorrelation

    @property
    def of_hits(self) -> bool:
        """Whole impacts instead of Welch's segments."""
        return self.nperseg is None


def holds_hits(rec: Recording, options: Averaging) -> bool:
    """Whether a record is to be transformed impact by impact."""
    return options.method == "transient" or (options.method == "auto" and is_transient(rec))


def average(
    rec: Recording,
    band_hz: tuple[float, float],
    options: Averaging,
    *,
    include_force: bool = False,
    lines_hz: tuple[float, float] | None = None,
    longer: int = 1,
    hits: bool | None = None,
) -> Averages:
    """The averages of a record: one transform of its segments, or of its impacts.

    ``band_hz`` decides on the length of the segments where that is left open, made ``longer`` by a factor;
    ``lines_hz`` are the lines kept, by default those of the band. ``hits`` where that is known already.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.signals.averaging import Averaging, average
    >>> from antires_rs.signals.recording import Recording
    >>> rec = Recording(np.random.default_rng(0).standard_normal((2, 8192)), 100.0)
    >>> made = average(rec, (10.0, 20.0), Averaging())
    >>> made.nperseg, made.spectra.matrix.shape
    (1024, (102, 2, 2))
    """
    lines = band_hz if lines_hz is None else lines_hz
    correlation = Autocorrelation(rec)
    if holds_hits(rec, options) if hits is None else hits:
        name = options.window
        window = name if isinstance(name, str) and name in ("rectangular", "exponential") else "auto"
        spectra = transient_spectra(rec, window=window, include_force=include_force, band_hz=lines)
        return Averages(options, spectra, None, None, include_force, correlation)
    nperseg = options.nperseg
    if nperseg is None:
        nperseg = min(longer * choose_nperseg(rec, band_hz, correlation), shortest(rec))
    spectra = cross_spectra(
        rec,
        nperseg=nperseg,
        noverlap=options.noverlap,
        window=options.window,
        include_force=include_force,
        band_hz=lines,
    )
    taper = window_values(options.window, nperseg)
    return Averages(options, spectra, nperseg, taper, include_force, correlation)
