"""Ask whether data are fit for identification: the one call, and the order of its tests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..signals.averaging import Averages, Averaging
from ..signals.band import band_of
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..signals.repeats import one_source
from ..support.pickling import frozen
from ..support.progress import patient
from ..support.validation import reject
from . import channels, force_location, one_force, phase, resolution
from .findings import DataCheck, Finding, NotTested, one_of_a_kind
from .records import of_recording
from .responses import of_response

__all__ = ["check_data"]

#: The order in which the tests that could not be made are listed.
TESTS = (
    channels.DEAD,
    channels.CLIPPED,
    channels.DUPLICATED,
    channels.DROPOUTS,
    channels.SPIKES,
    phase.TIME_SHIFT,
    phase.QUADRATURE,
    channels.NOISE,
    resolution.RESOLUTION,
    one_force.NAME,
    force_location.NAME,
)


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
    excitation : int or str, optional
        Dof at which the single force is said to act. Without it the location is not tested.
    band_hz : (low, high)
        Band in which antiresonances are wanted.
    nperseg, noverlap, window, method
        As for :func:`~antires_rs.identify_antiresonances`; give the same.
    progress : bool, optional
        A line on standard error after a second; by default on a terminal and in a notebook.

    Returns
    -------
    DataCheck
        ``.findings`` with numbers and advice, one of a kind over all its channels,
        ``.not_tested`` with reasons, ``.ok``, ``.fatal``; print it for
        a table, ``.plot()`` it for the eigenvalues.

    Raises
    ------
    InvalidInputError
        A malformed argument. Bad data never raise: they are what is reported.

    Notes
    -----
    The tests, by name:

    - ``dead_channel`` (fatal): constant, or nothing in common with any other channel in the band;
    - ``clipped_channel``, ``duplicated_channels``, ``dropouts``, ``spikes`` (warnings): in the time records;
    - ``time_shift``, ``quadrature`` (warnings): a channel late against the others, or of another kind, which
      brings it back into phase at several modes; a phase that is off without such a reason is none, and one
      or two modes do not prove any. Polarity cannot be seen in data: a sensor upside down looks like a mode
      shape with a node more, nor can two channels that are exchanged, unless the driving point is one of
      them (``force_location``);
    - ``signal_to_noise`` (note): a channel under its own noise in much of the band;
    - ``resolution``, ``record_length``, ``averages``: lines per half-power bandwidth, and what limits them;
    - ``one_force``: the second eigenvalue of the spectral matrix against the first, noise and leakage. Two
      forces that move in proportion are one force in this respect;
    - ``force_location``: zeros and poles of the stated driving point alternate. A dof whose mode shapes have
      the signs of the driving point's in all modes of the band cannot be told from it;
    - ``single_hit`` (note), ``missed_hit`` (fatal): of hammer records.

    Limits were set on simulated records of an 8-mass chain (0 to 10 % noise, 0.5 to 2 % damping, 60 to
    600 s), those of the phase on measured plates too. They stand, with their reasons, in the modules of this
    package.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.data_check import check_data
    >>> rec = ar.cases.chain8().experiment(noise=0.01, rng=1)
    >>> check_data(rec, excitation=0, band_hz=(3, 130)).ok
    True
    >>> (finding,) = check_data(rec, excitation=4, band_hz=(3, 130)).findings
    >>> print(finding.severity, finding.name, "|", finding.advice)
    fatal force_location | Dof 0 would fit: check which dof was excited, and the order of the channels.
    """
    if excitation is not None and (
        isinstance(excitation, bool) or not isinstance(excitation, int | np.integer | str)
    ):
        reject(
            "excitation",
            excitation,
            "a dof named by an integer or a string, or None",
            "Name the dof as the source does, or leave it out if it is not known.",
        )
    options = Averaging(nperseg, noverlap, window, method).checked()
    one: Recording | FrequencyResponse = one_source(source)
    return judged(one, excitation, band_of(one, band_hz), options)


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
    dofs = source.dofs
    found = one_of_a_kind(one for one in said if isinstance(one, Finding))
    # A test that found something was made, even if a part of it could not be.
    named = {finding.name for finding in found}
    why = {one.name: one.why for one in reversed(said) if isinstance(one, NotTested)}
    untested = {name: why[name] for name in TESTS if name in why and name not in named}
    if seen is None:
        return DataCheck(found, untested, dofs, excitation, band)
    if seen.eigenvalues is None:
        return DataCheck(
            found,
            untested,
            seen.dofs,
            excitation,
            band,
            frozen(seen.freq_hz),
            coherence=None if seen.coherence is None else frozen(seen.coherence),
        )
    expected = one_force.expected(seen) if len(seen.dofs) > 2 else None
    return DataCheck(
        found,
        untested,
        seen.dofs,
        excitation,
        band,
        frozen(seen.freq_hz),
        frozen(seen.eigenvalues),
        None if expected is None else frozen(expected),
        None if seen.coherence is None else frozen(seen.coherence),
        seen.n_averages,
        seen.nperseg,
    )
