r"""Resonances, damping ratios and mode shapes from FRFs, or from responses alone.

FRFs of one force are fitted jointly, the order is swept, and the poles of H that stay are the resonances;
residues at them give the shapes. Without the force the same is done with the positive half spectra of the
responses, on the assumption that the spectrum of the force is flat where the resonances are: a peak of the
force would come out as a mode. Modes just outside the band reach into it, and no smooth residual term can
stand for them: lines around the band are fitted too, and the poles found there enter the residues.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..exceptions import UnsuitableDataError, reject
from ..measured.modal_set import ModalSet
from ..signals.averaging import Averaging, average, choose_nperseg, holds_hits
from ..signals.frequency_response import FrequencyResponse, band_of, covered_hz
from ..signals.half_spectra import half_spectra
from ..signals.recording import Recording
from ..signals.spectra import two_channel
from ..support.checks import ComplexArray, FloatArray, choice, integer
from ..support.progress import one_blas_thread, patient
from .lines import FORCE, lines_of_response, require_live
from .options import FitOptions
from .rational_fit import NestedFit, residues
from .stabilization import PoleSweep, StabilizationDiagram, diagram, join, windows

# A joint fit needs resolution at its poles more than averages: segments longer by this than for
# antiresonances.
FRF_SEGMENT_FACTOR = 2
# Lines around the band that residues use: from a third of its lower limit to half as much again as its upper.
# On the exhaust, with a mode 4 % above the band, the least MAC rises from 0.42 to 0.9999; no lower limit at
# all, or twice the upper one, is no better.
BELOW, ABOVE = 3.0, 1.5


@dataclass(frozen=True)
class Curves:
    """``values`` (n_references, n_dofs, n_freq) at equal weight; ``scale`` (n_dofs,): to their units."""

    freq_hz: FloatArray
    values: ComplexArray
    weights: FloatArray
    scale: FloatArray
    added_decay_per_s: float

    @property
    def flat(self) -> ComplexArray:
        """All curves as outputs, (n_references * n_dofs, n_freq)."""
        return self.values.reshape(-1, self.freq_hz.size)


@patient("identifying modes")
@one_blas_thread
def identify_modes(
    source: Recording | FrequencyResponse,
    *,
    band_hz: Sequence[float],
    route: str = "auto",
    method: str = "auto",
    nperseg: int | None = None,
    estimator: str = "h1",
    max_order: int = 60,
    min_order: int = 2,
    freq_tol: float = 0.01,
    damping_tol: float = 0.10,
    min_rows: int = 10,
    max_damping: float = 0.10,
    min_dominance: float = 0.05,
    progress: bool | None = None,
) -> ModalSet:
    """Identify resonances, damping and mode shapes, automatically.

    Parameters
    ----------
    source : Recording or FrequencyResponse
        Time records under one force, or FRFs of one excitation.
    band_hz : (low, high)
        Resonances that are kept; rigid-body modes lie outside. Shapes are fitted on the lines around it too
        (from a third of ``low`` to 1.5 ``high``, as far as there are any).
    route : {"auto", "frf", "responses"}
        From FRFs, or from the responses alone (the force is then not read). "auto": FRFs where there is a
        force.
    method, nperseg
        As for :func:`~antires_rs.identify_antiresonances`; segments of FRFs are twice as long by default.
    estimator : {"h1", "h2", "hv"}
        Of the FRFs of a record.
    max_order, min_order, freq_tol, damping_tol, min_rows, max_damping, min_dominance
        As for :func:`~antires_rs.stabilization`. With few lines the highest order is lowered to
        two thirds of their number. Resonances closer than ``freq_tol`` count as one.
    progress : bool, optional
        A line on standard error after a second; by default on a terminal and in a notebook.

    Returns
    -------
    ModalSet
        ``freq_hz`` = ``abs(s) / 2 pi`` ascending, ``damping_ratio``, complex ``shapes`` whose largest
        component is one, ``diagram`` with the evidence. Empty if no pole in the band stays.

    Raises
    ------
    InvalidInputError
        A malformed argument, a band outside the data, or too few lines in it.
    UnsuitableDataError
        Transmissibilities, in which the resonances cancel; no force on the FRF route; a dead channel.

    Notes
    -----
    Measured on chain8 (7 resonances, 1 % damping and noise, 200 s; largest of three runs): from FRFs within
    0.001 % in frequency and 0.6 % in damping, from responses within 0.12 % and 12 % (1,200 s: 0.05 % and
    3.4 %). The scatter from responses is about twice that which no method can beat.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> f = np.linspace(2.0, 30.0, 600)
    >>> mode = lambda fn: -f**2 / (fn**2 - f**2 + 0.02j * fn * f)
    >>> h = np.array([mode(8.0) + mode(20.0), mode(8.0) - 0.5 * mode(20.0)])
    >>> h = h + 1e-4 * np.random.default_rng(0).standard_normal(h.shape)
    >>> modes = ar.identify_modes(ar.FrequencyResponse(f, h), band_hz=(3, 28))
    >>> modes.freq_hz.round(2).tolist(), modes.damping_ratio.round(3).tolist()
    ([8.0, 20.0], [0.01, 0.01])
    >>> modes.to_real().shapes.round(2).tolist()
    [[1.0, 1.0], [1.0, -0.5]]
    """
    choice("route", route, ("auto", "frf", "responses"))
    averaging = Averaging(nperseg, method=method).checked()
    choice("estimator", estimator, ("h1", "h2", "hv"))
    accepted = {"freq_tol": freq_tol, "damping_tol": damping_tol, "min_rows": min_rows}
    accepted |= {"max_damping": max_damping, "min_dominance": min_dominance}
    rule, orders = FitOptions.of_sweep(min_order, max_order, **accepted)
    available = covered_hz(source)
    band = band_of(source, band_hz)
    if isinstance(source, Recording):
        curves_in = _of_recording(source, band, route, averaging, estimator)
    else:
        if source.kind != "frf":
            remedy = (
                "The resonances cancel in a quotient of responses: transmissibilities hold the "
                "antiresonances only."
            )
            raise UnsuitableDataError("source", "transmissibilities", "FRFs or a Recording", remedy)
        if route == "responses":
            got = "'responses' with a source of FRFs"
            reject("route", got, "'auto' or 'frf'", "Leave route out: FRFs hold the measured force.")

        def curves_in(lines_hz: tuple[float, float]) -> Curves:
            return _of_frfs(source, lines_hz, 0.0)

    found = _stabilized(curves_in(band), band, orders, rule)
    around = (max(band[0] / BELOW, available[0]), min(band[1] * ABOVE, available[1]))
    shapes = np.empty((0, len(source.dofs)), dtype=np.complex128)
    if found.identified.size:
        curves = curves_in(around)
        wider = found if around == band else _stabilized(curves, around, (min_order, max_order), rule)
        shapes = _shapes(curves, found, wider, freq_tol)
    return ModalSet(found.identified, shapes, source.dofs, found.identified_damping, diagram=found)


def _of_recording(
    rec: Recording, band: tuple[float, float], route: str, options: Averaging, estimator: str
) -> Callable[[tuple[float, float]], Curves]:
    """Curves of a record by one of the routes; segments as the band wants them, lines as asked for."""
    if route == "frf" and rec.force is None:
        remedy = "Use route='responses', for a force that is broadband."
        raise UnsuitableDataError("route", "'frf' for a Recording without force", "a measured force", remedy)
    if options.nperseg is not None:
        integer("nperseg", options.nperseg, low=32, high=rec.n_samples)
    if route == "responses" or rec.force is None:
        if holds_hits(rec, options, band):
            return _of_responses(rec, None)
        return _of_responses(rec, options.nperseg or choose_nperseg(rec, band))
    every_line = (0.0, 0.5 * rec.fs_hz)
    spectra = average(
        rec, band, options, include_force=True, lines_hz=every_line, longer=FRF_SEGMENT_FACTOR
    ).spectra
    values = two_channel(spectra.matrix, rec.n_channels, estimator)[0][:-1]
    frfs = FrequencyResponse(spectra.freq_hz, values, rec.dofs)
    return lambda lines_hz: _of_frfs(frfs, lines_hz, spectra.added_decay_per_s)


def _of_frfs(resp: FrequencyResponse, band: tuple[float, float], added_decay_per_s: float) -> Curves:
    """FRFs scaled to equal noise; lines weighted by what they are worth.

    The linear residual N - H D is small at the poles. Weighted by the signal-to-noise ratio alone the leakage
    at the peaks rules; over 1 + sum abs(H)^2 the few lines of a sharp peak count for nothing. The root lies
    between.
    """
    lines = lines_of_response(resp, band, use_force=True)
    frfs, power = lines.quotients(FORCE)
    weights = lines.capped_snr / np.sqrt(1.0 + power)
    inside = np.isin(resp.freq_hz, lines.freq_hz)
    size = np.linalg.norm(frfs, axis=1)
    scale = np.linalg.norm(resp.values[:, inside], axis=1) / np.where(size > 0.0, size, 1.0)
    return Curves(lines.freq_hz, frfs[None], weights, scale, added_decay_per_s)


def _of_responses(rec: Recording, nperseg: int | None) -> Callable[[tuple[float, float]], Curves]:
    """Half spectra of channels at unit rms; their errors are relative to their own size, down to a floor."""
    scale = rec.responses.std(axis=1)
    require_live(scale, rec.dofs, "no signal at all from {}", "Recording")
    half = half_spectra(rec, nperseg=nperseg)
    units = scale[np.array(half.references)][:, None] * scale

    def curves(lines_hz: tuple[float, float]) -> Curves:
        inside = (half.freq_hz >= lines_hz[0]) & (half.freq_hz <= lines_hz[1]) & (half.freq_hz > 0.0)
        values = half.values[:, :, inside] / units[:, :, None]
        power = np.sum(np.abs(values) ** 2, axis=(0, 1))
        weights = 1.0 / (np.median(power) + power)
        return Curves(half.freq_hz[inside], values, weights, scale, half.added_decay_per_s)

    return curves


def _stabilized(
    curves: Curves, band: tuple[float, float], orders: tuple[int, int], rule: FitOptions
) -> StabilizationDiagram:
    """Poles of the joint fit that stay, window by window where the band has many lines."""
    parts = []
    cut = windows(curves.freq_hz, band)
    for window in cut:
        some = slice(window.first, window.last)
        freq, values = curves.freq_hz[some], curves.flat[:, some]
        within = rule.orders(orders, freq.size)
        sweep = PoleSweep(NestedFit(freq, values, curves.weights[some], within[-1]))
        background = np.sqrt(np.sum(np.abs(values) ** 2, axis=0))
        parts.append(
            diagram(sweep, within, window.report_hz, rule, freq, background, curves.added_decay_per_s)
        )
    return join(parts, cut, band, rule.freq_tol)


def _shapes(
    curves: Curves, found: StabilizationDiagram, wider: StabilizationDiagram, freq_tol: float
) -> ComplexArray:
    """Shapes at the accepted poles, largest component one; ``wider`` has further poles of the curves."""
    n_references, n_dofs, _ = curves.values.shape
    hz, zeta = found.identified, found.identified_damping
    new = [i for i, f in enumerate(wider.identified) if np.all(np.abs(hz / f - 1.0) > freq_tol)]
    hz = np.concatenate([hz, wider.identified[new]])
    zeta = np.concatenate([zeta, wider.identified_damping[new]])
    poles = 2 * np.pi * hz * (-zeta + 1j * np.sqrt(1.0 - zeta**2)) - curves.added_decay_per_s
    # One in the band, falling to nil at the last lines around it: there the next modes reach in.
    freq, (low, high) = curves.freq_hz, found.band_hz
    below, above = (low - freq) / max(low - freq[0], 1e-300), (freq - high) / max(freq[-1] - high, 1e-300)
    weights = curves.weights * np.cos(0.5 * np.pi * np.clip(np.maximum(below, above), 0.0, 1.0)) ** 2
    residue = residues(curves.freq_hz, curves.flat, weights, poles)[: found.identified.size]
    # The residues of one mode to several references have rank one; with one reference they are the shape.
    dominant = np.linalg.svd(residue.reshape(-1, n_references, n_dofs), full_matrices=False)[2][:, 0]
    shapes = dominant * curves.scale
    largest = np.take_along_axis(shapes, np.argmax(np.abs(shapes), axis=1)[:, None], axis=1)
    return np.asarray(shapes / largest, dtype=np.complex128)
