r"""From what was measured to antiresonances.

Under one force at k the responses are X_p = N_pk F / D: their numerators N_pk have the antiresonances for
zeros, and every transmissibility T_pj = N_pk / N_jk has lost the resonances and the force. Two formulations:

- "numerators": all N_pk at once from the whole spectral matrix of the responses
  (:mod:`~antires_rs.identification.numerators`). For averaged records, whose segments tell the noise and the
  errors.
- "joint": for every j all T_pj over p with a common denominator, whose poles are the antiresonances of j. For
  single hits and given curves, where nothing tells the noise.

Either way the order is swept and what stays is kept. Everything starts from one complex vector of
responses a line, known up to a factor that cancels: so transmissibilities to any one reference serve all
dofs (T_pq = T_pj / T_qj). On the "joint" way lines are weighted by
SNR / (1 + SNR / 1e4) / (1 + sum_p abs(T_pj)^2): by what they are worth, but never so much that leakage rules.

Source: V. Meruane, J. Sound Vib. 332 (2013) 807-820.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..data_check import DataCheck, check_data
from ..exceptions import AntiresWarning, UnsuitableDataError
from ..measured.antiresonance_set import AntiresonanceSet
from ..order_sweep.diagram import PoleSweep, StabilizationDiagram, ZeroSweep, diagram, without_common
from ..order_sweep.persistence import add_persistent
from ..order_sweep.presets import rule_options
from ..order_sweep.rule import Rule
from ..order_sweep.scores import graded, scored
from ..order_sweep.windows import join, windows
from ..signals.band import band_of
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording, without_force
from ..support.progress import patient, step
from ..support.validation import FloatArray, choice, integer, reject
from .formulations import FORMULATIONS, sweep_of, warn_of_formulation
from .response_lines import FORCE, Lines, lines_of
from .selection import select

__all__ = ["identify_antiresonances"]

# Beyond, a narrower band or windows serve better than more orders.
HIGHEST_ORDER = 200
CHOICES = ("auto", "numerators", *FORMULATIONS)


@patient("identifying antiresonances")
def identify_antiresonances(
    source: Recording | FrequencyResponse,
    *,
    excitation: Any,
    band_hz: Sequence[float],
    dofs: Iterable[Any] | None = None,
    route: str = "transmissibility",
    nperseg: int | None = None,
    noverlap: int | None = None,
    window: Any = "hann",
    method: str = "auto",
    estimator: str = "rank1",
    preset: str | None = None,
    formulation: str | None = None,
    max_order: int = 60,
    min_order: int = 2,
    freq_tol: float | None = None,
    damping_tol: float | None = None,
    min_rows: int | None = None,
    max_damping: float | None = None,
    min_dominance: float | None = None,
    persistent: bool | None = None,
    keep_common: bool = False,
    second_opinion: str | None = None,
    check: str = "warn",
    progress: bool | None = None,
) -> AntiresonanceSet:
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
        Samples per Welch segment. Default: 16 over the narrow half-power bandwidth, at most a tenth of the
        record, rounded to a power of two.
    noverlap, window
        As for :func:`~antires_rs.signals.spectra.cross_spectra`; for hits ``window`` may be "rectangular" or
        "exponential" ("hann" there means: rectangular if the response dies, else exponential).
    method : {"auto", "welch", "transient"}
        How a record is averaged; "auto" looks at its energy profile.
    estimator : {"rank1", "h1", "h2", "hv"}
        "rank1" for the dominant eigenvector of all channels scaled to equal noise; the others as in
        :func:`~antires_rs.signals.transfer_functions.transmissibility` and
        :func:`~antires_rs.signals.transfer_functions.frf`.
    formulation : {"auto", "numerators", "joint", "sum", "power", "eq10"}, optional
        See the module, and :mod:`~antires_rs.identification.formulations` for the last three. "auto"
        (default) takes "numerators" for averaged records with ``estimator="rank1"``, else "joint".
    preset : {None, "paper", "strict", "sensitive"}
        A named set of the options formulation, freq_tol to min_dominance and persistent, see
        :mod:`~antires_rs.order_sweep.presets`. What is given beside it wins.
    max_order, min_order, freq_tol, damping_tol, min_rows, max_damping, min_dominance
        As for :func:`~antires_rs.stabilization`. With few lines in the band the highest order
        is lowered to two thirds of their number.
    persistent : bool, optional
        Accept also what is there in most orders without standing still. Default: True, or as the preset says.
    second_opinion : {None, "aaa", "vector_fitting"}
        Ask another method about every value; the answer is ``.second_opinion`` of the set, see
        :func:`~antires_rs.identification.cross_check.second_opinion`. It changes no value.
    keep_common : bool
        Keep values that all of three or more channels share, see Notes.
    check : {"warn", "raise", "off"}
        What to do with :func:`~antires_rs.check_data`: warn of what it finds, refuse data in which it finds
        something fatal, or leave it out. The answer is ``.data_check`` of the set.
    progress : bool, optional
        A line on standard error after a second; by default on a terminal and in a notebook.

    Returns
    -------
    AntiresonanceSet
        Frequencies ``abs(s) / 2 pi`` and damping ratios by dof, ``.std_hz`` with their standard deviations
        ("numerators" only), ``.scores`` with what speaks for each, ``.diagrams`` with the evidence. A dof
        without any antiresonance in the band has an empty array.

    Raises
    ------
    InvalidInputError
        A malformed argument, a band outside the data, or too few lines in it.
    UnsuitableDataError
        A fatal finding under ``check="raise"``; a single channel on the transmissibility route; no force on
        the FRF route; a hit that the record missed.

    Notes
    -----
    Near their noise, responses have antiresonances that are there in most orders but do not stand still;
    they are accepted by a second rule (modules ``persistence``, ``numerator_selection``) and marked
    "persistent" in ``.scores[dof]["how"]``.
    An antiresonance that *all* channels share, when there are three or more, is not one of the responses: it
    is the zero beside the pole of a mode that the force hardly excites (a force near a node, a local or
    sideways mode). A model without that mode does not have it, and one with it has it cancelled; so it is
    left out.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.signals.recording import FrequencyResponse
    >>> from antires_rs.identification.identify import identify_antiresonances
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
    choice("check", check, ("warn", "raise", "off"))
    choice("keep_common", keep_common, (True, False))
    choice("persistent", persistent, (None, True, False))
    choice("second_opinion", second_opinion, (None, "aaa", "vector_fitting"))
    options = rule_options(
        preset,
        formulation=formulation,
        freq_tol=freq_tol,
        damping_tol=damping_tol,
        min_rows=min_rows,
        max_damping=max_damping,
        min_dominance=min_dominance,
        persistent=persistent,
    )
    formulation = choice("formulation", options.pop("formulation"), CHOICES)
    if formulation == "numerators" and estimator != "rank1":
        reject(
            "estimator",
            estimator,
            "'rank1' with formulation='numerators'",
            "That fit uses the whole spectral matrix; formulation='joint' takes any estimator.",
        )
    if route == "frf" and formulation in ("sum", "power", "eq10"):
        reject(
            "formulation",
            formulation,
            "'numerators' or 'joint' with route='frf'",
            "Sums and magnitudes are those of transmissibilities.",
        )
    warn_of_formulation(formulation)
    rule = Rule(**options).checked()
    band = band_of(source, band_hz)
    wanted = _wanted_dofs(dofs, source.dofs)
    max_order = integer("max_order", max_order, low=2, high=HIGHEST_ORDER)
    min_order = integer("min_order", min_order, low=1, high=max_order)
    rule.check_span(min_order, max_order)
    use_force = route == "frf"
    _can_answer(source, use_force)
    step("spectra")
    lines_for = lines_of(
        source,
        band,
        use_force=use_force,
        nperseg=nperseg,
        noverlap=noverlap,
        window=window,
        method=method,
        estimator=estimator,
    )
    orders = (min_order, max_order)
    first = lines_for(FORCE if use_force else 0)
    checked = (
        None
        if check == "off"
        else _checked(
            source if use_force or isinstance(source, FrequencyResponse) else without_force(source),
            excitation,
            band,
            nperseg,
            noverlap,
            window,
            method,
            strict=check == "raise",
        )
    )
    if formulation == "auto":
        formulation = "numerators" if first.segments is not None and estimator == "rank1" else "joint"
    step("fit")
    if formulation == "numerators":
        found = _from_numerators(source.dofs, first, band, orders, rule, keep_common)
    else:
        found = _one_by_one(source.dofs, lines_for, band, orders, rule, use_force, formulation)
    if not keep_common:
        found = without_common(found)
    found = {dof: found[dof] for dof in wanted}
    opinion = None
    if second_opinion is not None:
        # Of the lines that are there already; imported here, since few calls ask for it.
        from .cross_check import judge

        step("second opinion")
        values = {dof: d.identified for dof, d in found.items()}
        opinion = judge(lines_for, source.dofs, values, band, second_opinion)
    return AntiresonanceSet.from_tables(
        excitation,
        {dof: graded(d.accepted) if formulation == "numerators" else d.accepted for dof, d in found.items()},
        diagrams=found,
        data_check=checked,
        cross_check=opinion,
    )


def _from_numerators(
    dofs: tuple[Any, ...],
    lines: Lines,
    band: tuple[float, float],
    orders: tuple[int, int],
    rule: Rule,
    keep_common: bool,
) -> dict[Any, StabilizationDiagram]:
    """All dofs from one fit a window."""
    cut = windows(lines.freq_hz, band)
    parts = [lines.part(w.first, w.last) for w in cut]
    found = [
        select(part, len(dofs), w, rule.orders(orders, part.freq_hz.size), rule, keep_common)
        for part, w in zip(parts, cut, strict=True)
    ]
    return {dof: join([d[row] for d in found], cut, band, rule.freq_tol) for row, dof in enumerate(dofs)}


def _one_by_one(
    dofs: tuple[Any, ...],
    lines_for: Callable[[int], Lines],
    band: tuple[float, float],
    orders: tuple[int, int],
    rule: Rule,
    use_force: bool,
    formulation: str,
) -> dict[Any, StabilizationDiagram]:
    """Every dof from its own joint fit of all T_pj; with a force, from one joint fit of all H_jk."""
    found: dict[Any, StabilizationDiagram] = {}
    shared: dict[int, tuple[PoleSweep, range, FloatArray]] = {}
    # Dofs not asked for are looked at too: what all channels share is told only from all.
    for row, dof in enumerate(dofs):
        step(f"response {row + 1} of {len(dofs)}")
        below = FORCE if use_force else row
        lines = lines_for(below)
        cut = windows(lines.freq_hz, band)
        parts = []
        for window in cut:
            part = lines.part(window.first, window.last)
            if not use_force or window.first not in shared:
                shared[window.first] = sweep_of(part, below, *orders, rule, formulation)
            parent, swept, background = shared[window.first]
            sweep: PoleSweep = parent
            if use_force:
                background = 1.0 / np.maximum(np.abs(parent.nested.values[row]), 1e-300)
                sweep = ZeroSweep(parent, row)
            one = diagram(
                sweep, swept, window.report_hz, rule, part.freq_hz, background, part.added_decay_per_s
            )
            if part.snr_known and rule.persistent:
                one = add_persistent(one, sweep, rule, part.channel_snr(row), part.added_decay_per_s)
            curves = sweep.curves(swept[len(swept) // 2])
            parts.append(replace(one, accepted=scored(one.accepted, part.freq_hz, background, *curves)))
        found[dof] = join(parts, cut, band, rule.freq_tol)
    return found


def _checked(
    source: Recording | FrequencyResponse,
    excitation: Any,
    band: tuple[float, float],
    nperseg: int | None,
    noverlap: int | None,
    window: Any,
    method: str,
    *,
    strict: bool,
) -> DataCheck:
    """The data check, with a warning or an error if there is cause."""
    checked = check_data(
        source,
        excitation=excitation,
        band_hz=band,
        nperseg=nperseg,
        noverlap=noverlap,
        window=window,
        method=method,
    )
    if strict and checked.fatal:
        fatal = [f for f in checked.findings if f.severity == "fatal"]
        raise UnsuitableDataError(
            "source",
            "data in which the check finds: " + " ".join(f.text for f in fatal).rstrip("."),
            "data without fatal findings, as strict=True asks for",
            " ".join(f.advice for f in fatal),
        )
    if not checked.ok:
        warnings.warn("data check: " + " ".join(checked.warnings), AntiresWarning, stacklevel=4)
    return checked


def _can_answer(source: Recording | FrequencyResponse, use_force: bool) -> None:
    """Refuse sources that lack what the route needs."""
    if not use_force and len(source.dofs) < 2:
        raise UnsuitableDataError(
            "source",
            "a single channel",
            "two or more for route='transmissibility', whose poles are the antiresonances",
            "Add a channel, or measure the force and use route='frf'.",
        )
    if use_force and isinstance(source, Recording) and source.force is None:
        raise UnsuitableDataError(
            "route",
            "'frf' for a Recording without force",
            "a measured force",
            "Use route='transmissibility': it needs none.",
        )


def _wanted_dofs(dofs: Iterable[Any] | None, known: tuple[Any, ...]) -> tuple[Any, ...]:
    """The dofs asked for, all of them channels of the source."""
    if dofs is None:
        return known
    if isinstance(dofs, str | bytes) or not isinstance(dofs, Iterable):
        reject("dofs", dofs, f"a list of dofs out of {known}", "Put the dofs in a list, such as dofs=[0, 1].")
    wanted = tuple(dict.fromkeys(dofs))
    strange = [dof for dof in wanted if dof not in known]
    if strange or not wanted:
        reject(
            "dofs",
            strange or "an empty list",
            f"dofs out of {known}",
            "Name dofs of the source, or leave dofs out for all.",
        )
    return tuple(known[known.index(dof)] for dof in wanted)
