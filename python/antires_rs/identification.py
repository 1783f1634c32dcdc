r"""From what was measured to antiresonances.

Under one force at k the transmissibility T_pj = X_p / X_j = N_pk / N_jk has the zeros of H_jk as its
poles, whatever p: the resonances cancel, and the force is not needed. So for every dof j all T_pj are fitted
jointly with a common denominator, the order is swept, and the poles that stay are the antiresonances of
j. Everything starts from one complex vector of responses a line, known up to a factor that cancels: the
dominant eigenvector of a record's spectral matrix, a column of FRFs, or transmissibilities to any one
reference (T_pq = T_pj / T_qj). Hence one set of transmissibilities serves all dofs.

Lines are weighted by SNR / (1 + SNR / 1e4) / (1 + sum_p abs(T_pj)^2): by what they are worth, but never so
much that leakage rules.

Source: V. Meruane, J. Sound Vib. 332 (2013) 807-820.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ._validation import FloatArray, choice, frequency_band, integer, reject
from .antiresonance_set import AntiresonanceSet
from .bands import join, windows
from .exceptions import UnsuitableDataError
from .persistence import add_persistent
from .rational import NestedFit
from .response_lines import FORCE, Lines, lines_of_recording, lines_of_response
from .signals import FrequencyResponse, Recording
from .stabilization import PoleSweep, Rule, StabilizationDiagram, ZeroSweep, diagram, without_common

__all__ = ["identify_antiresonances"]

SNR_CAP = 1e4
# Real numbers of data (two a line) an order needs: with fewer, poles follow the noise of single lines.
LINES_PER_ORDER = 3


def identify_antiresonances(
        source: Recording | FrequencyResponse, *, excitation: Any, band_hz: Sequence[float],
        dofs: Iterable[Any] | None = None, route: str = "transmissibility", nperseg: int | None = None,
        noverlap: int | None = None, window: Any = "hann", method: str = "auto", estimator: str = "rank1",
        max_order: int = 60, min_order: int = 2, freq_tol: float = 0.01, damping_tol: float = 0.10,
        min_rows: int = 10, max_damping: float = 0.10, min_dominance: float = 0.05,
        keep_common: bool = False) -> AntiresonanceSet:
    """Identify the antiresonances of every response, automatically.

    Parameters
    ----------
    source : Recording or FrequencyResponse
        Time records, FRFs of one excitation, or transmissibilities to one reference.
    excitation : int or str
        The dof of the single force. It need not be among the channels.
    band_hz : (low, high)
        Lines that are fitted and values that are kept.
    dofs : iterable, optional
        Dofs whose antiresonances are wanted; all channels are used in any case. Default: all.
    route : {"transmissibility", "frf"}
        Poles of the transmissibilities (the force is never read), or zeros of the jointly fitted FRFs.
    nperseg : int, optional
        Samples per Welch segment. Default: 8 over the narrow half-power bandwidth, at most the record over
        7.5, rounded to a power of two.
    noverlap, window
        As for :func:`~antires_rs.spectra.cross_spectra`; for hits ``window`` may be "rectangular" or
        "exponential" ("hann" there means: rectangular if the response dies, else exponential).
    method : {"auto", "welch", "transient"}
        How a record is averaged; "auto" looks at its energy profile.
    estimator : {"rank1", "h1", "h2", "hv"}
        "rank1" for the dominant eigenvector of all channels scaled to equal noise; the others as in
        :func:`~antires_rs.spectra.transmissibility` and :func:`~antires_rs.spectra.frf`.
    max_order, min_order, freq_tol, damping_tol, min_rows, max_damping, min_dominance
        As for :func:`~antires_rs.stabilization.stabilization`. With few lines in the band the highest order
        is lowered to two thirds of their number.

    keep_common : bool
        Keep values that all of three or more channels share, see Notes.

    Returns
    -------
    AntiresonanceSet
        Frequencies ``abs(s) / 2 pi`` and damping ratios by dof, ``.diagrams`` with the evidence. A dof
        without any antiresonance in the band has an empty array.

    Raises
    ------
    InvalidInputError
        A malformed argument, a band outside the data, or too few lines in it.
    UnsuitableDataError
        A single channel on the transmissibility route; no force on the FRF route; a hit that the record
        missed.

    Notes
    -----
    Near their noise, responses have antiresonances that are there in most orders but do not stand still;
    they are accepted by a second rule (module ``persistence``) and marked in ``.diagrams[dof].persistent``.
    An antiresonance that *all* channels share, when there are three or more, is not one of the responses: it
    is the zero beside the pole of a mode that the force hardly excites (a force near a node, a local or
    sideways mode). A model without that mode does not have it, and one with it has it cancelled; so it is
    left out.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.signals import FrequencyResponse
    >>> from antires_rs.identification import identify_antiresonances
    >>> f = np.linspace(2.0, 30.0, 600)
    >>> mode = lambda fn: -f**2 / (fn**2 - f**2 + 0.02j * fn * f)
    >>> h = np.array([mode(8.0) + mode(20.0), mode(8.0) - 0.5 * mode(20.0)])  # driving point, and another
    >>> h = h + 1e-4 * np.random.default_rng(0).standard_normal(h.shape)
    >>> found = identify_antiresonances(FrequencyResponse(f, h), excitation=0, band_hz=(3, 25))
    >>> found[0].round(1).tolist(), found[1].tolist()
    ([15.2], [])
    """
    choice("route", route, ("transmissibility", "frf"))
    choice("method", method, ("auto", "welch", "transient"))
    choice("estimator", estimator, ("rank1", "h1", "h2", "hv"))
    rule = Rule(freq_tol, damping_tol, min_rows, max_damping, min_dominance).checked()
    if isinstance(source, Recording):
        band = frequency_band("band_hz", band_hz, low_hz=0.0, high_hz=source.fs_hz / 2)
    elif isinstance(source, FrequencyResponse):
        band = frequency_band(
            "band_hz", band_hz, low_hz=float(source.freq_hz[0]), high_hz=float(source.freq_hz[-1])
        )
    else:
        reject("source", type(source).__name__, "a Recording or a FrequencyResponse")
    wanted = _wanted_dofs(dofs, source.dofs)
    max_order = integer("max_order", max_order, low=2)
    min_order = integer("min_order", min_order, low=1, high=max_order)
    if max_order - min_order < min_rows:
        reject("max_order", max_order, f"at least min_order + min_rows = {min_order + min_rows}",
               "A value is accepted only when more than min_rows consecutive orders agree.")
    use_force = route == "frf"
    _can_answer(source, use_force)
    if isinstance(source, Recording):
        lines_for = lines_of_recording(source, band, use_force=use_force, nperseg=nperseg, noverlap=noverlap,
                                       window=window, method=method, estimator=estimator)
    else:
        same = lines_of_response(source, band, use_force=use_force)

        def lines_for(row: int) -> Lines:
            return same

    found: dict[Any, StabilizationDiagram] = {}
    shared: dict[int, tuple[PoleSweep, range, FloatArray]] = {}
    # Dofs not asked for are looked at too: what all channels share is told only from all.
    for row, dof in enumerate(source.dofs):
        below = FORCE if use_force else row
        lines = lines_for(below)
        cut = windows(lines.freq_hz, band)
        parts = []
        for window_lines in cut:
            part = lines.part(window_lines.first, window_lines.last)
            if not use_force or window_lines.first not in shared:
                shared[window_lines.first] = _sweep(part, below, min_order, max_order, rule)
            sweep, orders, background = shared[window_lines.first]
            if use_force:
                background = 1.0 / np.maximum(np.abs(sweep.nested.values[row]), 1e-300)
                sweep = ZeroSweep(sweep, row)
            one = diagram(sweep, orders, window_lines.report_hz, rule, part.freq_hz, background,
                          part.added_decay_per_s)
            if part.snr_known:
                one = add_persistent(one, sweep, rule, part.channel_snr(row), part.added_decay_per_s)
            parts.append(one)
        found[dof] = join(parts, cut, band, rule.freq_tol)
    if not keep_common:
        found = without_common(found, rule.freq_tol)
    found = {dof: found[dof] for dof in wanted}
    return AntiresonanceSet(excitation, {dof: d.identified for dof, d in found.items()},
                            {dof: d.identified_damping for dof, d in found.items()}, diagrams=found)


def _can_answer(source: Recording | FrequencyResponse, use_force: bool) -> None:
    """Refuse sources that lack what the route needs."""
    if not use_force and len(source.dofs) < 2:
        raise UnsuitableDataError(
            "source: got a single channel; wanted two or more for route='transmissibility', whose poles are "
            "the antiresonances. Add a channel, or measure the force and use route='frf'.")
    if use_force and isinstance(source, Recording) and source.force is None:
        raise UnsuitableDataError(
            "route: got 'frf' for a Recording without force; wanted a measured force. Use "
            "route='transmissibility': it needs none.")


def _wanted_dofs(dofs: Iterable[Any] | None, known: tuple[Any, ...]) -> tuple[Any, ...]:
    """The dofs asked for, all of them channels of the source."""
    if dofs is None:
        return known
    if isinstance(dofs, str | bytes) or not isinstance(dofs, Iterable):
        reject("dofs", dofs, f"a list of dofs out of {known}")
    wanted = tuple(dict.fromkeys(dofs))
    strange = [dof for dof in wanted if dof not in known]
    if strange or not wanted:
        reject("dofs", strange or "an empty list", f"dofs out of {known}")
    return tuple(known[known.index(dof)] for dof in wanted)


def _sweep(lines: Lines, row: int, min_order: int, max_order: int, rule: Rule,
           ) -> tuple[PoleSweep, range, FloatArray]:
    """Joint fit of all rows over one row; the orders that the number of lines can bear; abs of their sum."""
    quotients, power = lines.quotients(row)
    weights = lines.snr / (1.0 + lines.snr / SNR_CAP) / (1.0 + power)
    highest = min(max_order, 2 * lines.freq_hz.size // LINES_PER_ORDER)
    if highest - min_order < rule.min_rows:
        reject("band_hz", f"a band with {lines.freq_hz.size} lines for orders {min_order} to {highest}",
               f"orders that span more than min_rows = {rule.min_rows}",
               "Widen the band, or use longer segments.")
    nested = NestedFit(lines.freq_hz, quotients, weights, highest)
    return PoleSweep(nested), range(min_order, highest + 1), np.abs(quotients.sum(axis=0))
