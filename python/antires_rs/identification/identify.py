r"""From what was measured to antiresonances.

Under one force at k the responses are X_p = N_pk F / D: their numerators N_pk have the antiresonances for
zeros, and every transmissibility T_pj = N_pk / N_jk has lost the resonances and the force. Four ways start
from one complex vector of responses a line, known up to a factor that cancels:

- "numerators": all N_pk at once from the whole spectral matrix
  (:mod:`~antires_rs.identification.numerators`). For averaged records and repeated impacts, whose segments
  tell the noise and the errors.
- "windows": the same over many overlapping windows, and what most of them agree on. For given curves, and
  single impacts as clean as curves.
- "directions": local fits of the direction of the responses, and what perturbed fits see again
  (:mod:`~antires_rs.identification.stability`). For records that one fit over the band does not predict to
  the noise (:func:`~antires_rs.identification.numerators.misfit_ahead`): most that somebody measured.
- "joint": for every j all T_pj over p with a common denominator, whose poles are the antiresonances of j
  (:mod:`~antires_rs.identification.paper`). For averages by other estimators.

Source: V. Meruane, J. Sound Vib. 332 (2013) 807-820.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .._core import __version__
from ..exceptions import InvalidInputError, NumericalError, UnsuitableDataError, reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.matching import check_set
from ..measured.merge import merge_setups
from ..measured.response_table import ResponseTable, key_of
from ..signals.averaging import Averages, average, drifts
from ..signals.data_check import judged, judged_together
from ..signals.findings import DataCheck
from ..signals.frequency_response import FrequencyResponse, band_of
from ..signals.recording import Recording, without_force
from ..signals.repeats import AveragedResponse, one_source
from ..signals.spectra import dominant
from ..support.checks import Dofs, FloatArray, force_label
from ..support.directions import refuse_point
from ..support.messages import warn
from ..support.options import gathered
from ..support.progress import one_blas_thread, patient, step
from ..support.values import frozen
from .following import look_of, tables_of, with_search
from .lines import FORCE, Lines, lines_of
from .local_fits import LEAST_LINES
from .minors import MinorResponse, MinorsOfRecord, minors_of_curves
from .numerators import (
    CLEAN,
    LARGEST_AHEAD,
    LEAST_SEGMENTS,
    Likeliest,
    freedom,
    independent_averages,
    misfit_ahead,
)
from .options import (
    OF_BOTH,
    OF_DIRECTIONS,
    OF_FOLLOWING,
    OF_SWEEP,
    OF_WINDOWS,
    CallOptions,
    FitOptions,
    IdentificationOptions,
    options_of,
    sorted_out,
)
from .paper import sweep_of
from .scores import graded, of_blind_lines, of_lost_channels, scored, unexplained, with_second, without_common
from .selection import likeliest_of, select
from .stability import Directions, Look, direction_diagrams, looks_of
from .stabilization import PoleSweep, StabilizationDiagram, ZeroSweep, add_persistent, diagram, join, windows
from .windows import HIGHEST_ORDER, LINES_PER_ORDER, SCALES, local_diagrams

# -- From lines to stabilization diagrams, window by window, by either formulation


def diagrams_of(
    dofs: tuple[Any, ...],
    lines_for: Callable[[int], Lines],
    band: tuple[float, float],
    options: IdentificationOptions,
    looks: Sequence[Look] = (),
    fits: Sequence[Likeliest] = (),
) -> dict[Any, StabilizationDiagram]:
    """A diagram for each dof, by a formulation not "auto"; ``fits``: likeliest numerators of windows."""
    first = lines_for(FORCE if options.use_force else 0)
    if options.formulation == "directions":
        found = dict(zip(dofs, direction_diagrams(looks, first, len(dofs), band, options), strict=True))
    elif options.formulation == "windows":
        curves = first if first.order == 1 else replace(first, segments=None)  # which are not of minors
        found = dict(zip(dofs, local_diagrams(curves, len(dofs), band, options), strict=True))
    elif options.formulation == "numerators":
        cut = windows(first.freq_hz, band)
        lines = [first.part(w.first, w.last) for w in cut]
        fits = fits or [likeliest_of(part, options) for part in lines]
        each = zip(lines, fits, cut, strict=True)
        parts = [select(part, best, len(dofs), w, options) for part, best, w in each]
        joined = [join(list(rows), cut, band, options.rule.freq_tol) for rows in zip(*parts, strict=True)]
        found = dict(zip(dofs, joined, strict=True))
    else:
        found = _one_by_one(dofs, lines_for, band, options)
    if not options.rule.keep_common and options.formulation != "directions":
        found = without_common(found)
    if first.least_snr > 0.0:
        found = of_blind_lines(found, first.freq_hz, first.snr >= first.least_snr)
    for row, (dof, one) in enumerate(found.items()):
        known = np.concatenate([one.identified, one.left_out.freq_hz])
        peaks = unexplained(one.background_freq_hz, one.background, known, first.channel_snr(row))
        found[dof] = replace(one, unexplained_hz=frozen(peaks))
    return found


def _one_by_one(
    dofs: tuple[Any, ...],
    lines_for: Callable[[int], Lines],
    band: tuple[float, float],
    options: IdentificationOptions,
) -> dict[Any, StabilizationDiagram]:
    """Every dof from its own joint fit of all T_pj; with a force, from one joint fit of all H_jk."""
    rule, use_force = options.rule, options.use_force
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
                orders = rule.min_order, options.max_order
                shared[window.first] = sweep_of(part, below, *orders, rule, options.formulation)
            parent, swept, background = shared[window.first]
            sweep: PoleSweep = parent
            if use_force:
                background = 1.0 / np.maximum(np.abs(parent.nested.values[row]), 1e-300)
                sweep = ZeroSweep(parent, row)
            one = diagram(
                sweep, swept, window.report_hz, rule, part.freq_hz, background, part.added_decay_per_s
            )
            if rule.persistent:
                one = add_persistent(one, sweep, rule, part.channel_snr(row), part.added_decay_per_s)
            curves = sweep.curves(swept[len(swept) // 2])
            parts.append(replace(one, accepted=scored(one.accepted, part.freq_hz, background, *curves)))
        found[dof] = join(parts, cut, band, rule.freq_tol)
    return found


# -- Which fit suits the lines, and which options count for it: what has no effect is said, not refused, since
# curves and records may be identified by one job

#: With fewer lines there is no window of the narrow scale, and no fit that others could confirm.
FEW_LINES = SCALES[-1][1]
#: Of the samples of a channel this share is below the level that tells how strongly a record shook; told from
#: so many of them.
LEVEL_QUANTILE, LEVEL_SAMPLES = 0.999, 8192


def settled(
    options: IdentificationOptions,
    lines: Lines,
    band: tuple[float, float],
    *,
    of_curves: bool,
    drifting: bool = False,
) -> tuple[IdentificationOptions, list[Likeliest], float | None]:
    """The options with the formulation that "auto" means here, the fits that judged it, and their misfit."""
    formulation, misfit = options.formulation, None
    fits: list[Likeliest] = []
    if formulation == "auto" and options.call.estimator != "rank1":
        formulation = "windows" if lines.segments is None else "joint"
    elif formulation == "auto" and (of_curves or options.use_force):
        formulation = "windows" if lines.segments is None else "numerators"
    elif formulation == "auto" and (lines.segments is None or lines.segments.count < LEAST_SEGMENTS):
        # Drift is no noise, and looks like signal.
        clean = not drifting and float(np.median(lines.snr)) >= CLEAN
        formulation = "directions" if not clean else "windows" if lines.segments is None else "numerators"
    elif formulation == "auto":
        # What holds over the whole band is the better estimate; options of the sweep ask for it.
        asked = options.given & {*OF_SWEEP, "max_order"}
        cut = [] if asked else [lines.part(w.first, w.last) for w in windows(lines.freq_hz, band)]
        formulation = "numerators"
        try:
            fits = [likeliest_of(part, options) for part in cut]
            # Local fits take what a strong mode leaks into the other directions of minors for zeros.
            if fits and lines.order == 1:
                misfit = misfit_ahead(list(zip(cut, fits, strict=True)))
                formulation = "numerators" if misfit <= LARGEST_AHEAD else "directions"
        except (NumericalError, InvalidInputError):
            formulation = "directions"
    if formulation == "directions":
        idle = options.given - {*OF_DIRECTIONS, "formulation"}
        _say_idle(idle, "local fits (what one fit over the band does not predict)", OF_DIRECTIONS)
    elif formulation == "windows":
        high = {"max_order": options.max_order, "min_order": options.rule.min_order}
        beyond = [name for name in high if name in options.given and high[name] > HIGHEST_ORDER]
        idle = (options.given & {*OF_SWEEP}) | {f"{name} above {HIGHEST_ORDER}" for name in beyond}
        counts = [*OF_BOTH, *OF_WINDOWS, f"orders up to {HIGHEST_ORDER}"]
        _say_idle(idle, "fits over windows (given curves and clean single impacts)", counts)
    else:
        options.rule.check_span(options.rule.min_order, options.max_order)
        counts = [*OF_BOTH, *OF_SWEEP, "min_order", "max_order"]
        _say_idle(
            options.given & {*OF_WINDOWS}, f"the sweep over orders (formulation {formulation!r})", counts
        )
    count, width = lines.freq_hz.size, float(lines.freq_hz[-1] - lines.freq_hz[0])
    if formulation == "windows" and count < FEW_LINES:
        warn(
            "few_lines",
            f"identify_antiresonances: the band holds {count} lines, which carry {count // LINES_PER_ORDER} "
            f"orders; fits over windows want {FEW_LINES} lines or more, else antiresonances are missed or "
            f"misplaced. Measure with lines {width / FEW_LINES:.2g} Hz apart or finer; if the band holds one "
            "mode alone, widen it.",
        )
    return replace(options, formulation=formulation), fits, misfit


def _say_idle(idle: Iterable[str], fit: str, counts: Sequence[str]) -> None:
    """Warn of options that were given and have no effect."""
    if idle := sorted(idle):
        verb = "has" if len(idle) == 1 else "have"
        said = f"{' and '.join(idle)} {verb} no effect on {fit}; what counts there is {', '.join(counts)}."
        warn("no_effect", f"identify_antiresonances: {said}")


@patient("identifying antiresonances")
@one_blas_thread
def identify_antiresonances(
    source: Recording | FrequencyResponse | Sequence[Recording] | Sequence[FrequencyResponse],
    *,
    excitation: Any,
    band_hz: Sequence[float],
    dofs: Iterable[Any] | None = None,
    route: str = "transmissibility",
    nperseg: int | None = None,
    estimator: str = "rank1",
    preset: str | None = None,
    max_order: int | None = None,
    check: str = "warn",
    near: AntiresonanceSet | None = None,
    fit: FitOptions | None = None,
    progress: bool | None = None,
    **older: Any,
) -> AntiresonanceSet:
    """Identify the antiresonances of every response, automatically.

    Parameters
    ----------
    source : Recording or FrequencyResponse, or a list of either
        Time records, FRFs of one excitation, or transmissibilities to one reference. A list holds repeats of
        one test, see Notes.
    excitation : int or str, or a list of them
        The dof of the single force. It need not be among the channels. Several dofs of unknown forces that
        act at once, not all in proportion, see Notes.
    band_hz : (low, high)
        Lines that are fitted and values that are kept.
    dofs : iterable, optional
        Dofs whose antiresonances are wanted; all channels are used in any case. Default: all. Of r forces
        sets of r dofs.
    route : {"transmissibility", "frf"}
        Poles of the transmissibilities (the force is never read), or zeros of the jointly fitted FRFs.
    nperseg : int, optional
        Samples per Welch segment. Default: 16 over the narrow half-power bandwidth, at most a tenth of the
        record, rounded to a power of two.
    estimator : {"rank1", "h1", "h2", "hv"}
        "rank1" for the dominant eigenvector of all channels scaled to equal noise; the others as in
        :func:`~antires_rs.transmissibility` and :func:`~antires_rs.frf`.
    preset : {None, "paper", "strict", "sensitive"}
        A named set of the options of ``fit`` and of ``max_order``, see
        :mod:`~antires_rs.identification.options`. What is given beside it wins.
    max_order : int, optional
        Highest order of the sweep, 2 to 200; by default as the preset says, else 60, and 36 beyond the
        likeliest for the fit of all numerators; at most two thirds of the number of lines.
    check : {"warn", "raise", "off"}
        What to do with :func:`~antires_rs.check_data`: warn of what it finds, refuse data in which it finds
        something fatal, or leave it out. The answer is ``.data_check`` of the set.
    near : AntiresonanceSet, optional
        Values that are known, each looked for near its place (:mod:`~antires_rs.identification.following`):
        quicker than a search, and surer in a single test. ``.followed`` says of which value each is,
        ``.not_seen`` which are not there; ``fit=FitOptions(new_values=True)`` also searches for new ones.
    fit : FitOptions, optional
        How curves are fitted and what is accepted: what few calls change.
    progress : bool, optional
        A line on standard error after a second; by default on a terminal and in a notebook.
    **older
        Options of ``fit`` by name, as until 0.1; with a warning.

    Returns
    -------
    AntiresonanceSet
        Frequencies ``abs(s) / 2 pi`` and damping ratios by dof, ``.std_hz`` with their standard deviations
        (not with "joint" and "eq10"), ``.scores`` with what speaks for each, ``.diagrams`` with the
        evidence. A dof without any antiresonance in the band has an empty array. ``.sees`` is
        "transmissibility" where the values are what transmissibilities see: a peak also where the sensor
        sits on a node of a mode, a root that cancels in its FRF. It is "frf" on that route, and for FRFs,
        where such roots are told by the response itself and left out.

    Raises
    ------
    InvalidInputError
        A malformed argument, a band outside the data, or too few lines in it.
    UnsuitableDataError
        A fatal finding under ``check="raise"``; a single channel on the transmissibility route; no force on
        the FRF route; an impact that the record missed.

    Warns
    -----
    AntiresWarning
        What the data check finds; options that have no effect on the fit that suits the source.

    Notes
    -----
    Repeats of one test in a list, of the same dofs and sampling rate, give one set: segments, impacts or
    curves are averaged together (:mod:`~antires_rs.signals.repeats`), and the standard deviations hold what
    differs between them; those of a single test do not (:func:`~antires_rs.track`). Setups with other places
    of the sensors are identified apart and joined by :func:`~antires_rs.merge_setups`.

    ``.scores[dof]["how"]`` says how a value was accepted (:mod:`~antires_rs.identification.scores`). What
    fits see and do not accept is ``.left_out`` with the reason; peaks of the curve behind a diagram that
    nothing explains are ``.unexplained_hz``.

    Of r unknown forces the antiresonances of order r are identified, by sets of r responses
    (``identification/minors.py``): from records of all forces at once; from a list of records or hits of one
    force each, of about one level; or from a list of r FRFs or transmissibilities, one measured with each
    force. ``options["silent"]`` names sets whose minor is not above noise;
    values where fewer than r forces stand above noise are left out. A number of forces that the data check
    finds to be another leaves no value above "weak".

    An antiresonance that *all* of three or more channels share is not one of the responses: it is the zero
    beside the pole of a mode that the force hardly excites (a force near a node, a local or sideways mode),
    and is left out.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> f = np.linspace(2.0, 30.0, 600)
    >>> mode = lambda fn: -f**2 / (fn**2 - f**2 + 0.02j * fn * f)
    >>> h = np.array([mode(8.0) + mode(20.0), mode(8.0) - 0.5 * mode(20.0)])  # driving point, and another
    >>> h = h + 1e-4 * np.random.default_rng(0).standard_normal(h.shape)
    >>> found = ar.identify_antiresonances(ar.FrequencyResponse(f, h), excitation=0, band_hz=(3, 25))
    >>> found[0].round(1).tolist(), found[1].tolist()
    ([15.2], [])
    """
    fit = gathered("identify_antiresonances", "fit", FitOptions, fit, older)
    call = CallOptions(
        preset=preset, route=route, estimator=estimator, nperseg=nperseg, max_order=max_order, check=check
    )
    options = options_of(call, fit)
    excitation = force_label("excitation", excitation)
    one: Recording | FrequencyResponse = _source_of(source, excitation, options)
    band = band_of(one, band_hz)
    if not options.use_force and len(one.dofs) < 2:
        needed = "two or more for the route 'transmissibility', whose poles are the antiresonances"
        remedy = "Add a channel, or measure the force and take the route 'frf'."
        raise UnsuitableDataError("source", "a single channel", needed, remedy)
    if options.use_force and isinstance(one, Recording) and one.force is None:
        remedy = "Take the route 'transmissibility': it needs none."
        raise UnsuitableDataError("route", "'frf' for a Recording without force", "a measured force", remedy)
    step("spectra")
    averages = None
    if isinstance(one, Recording):
        averages = average(one, band, options.averaging, include_force=options.use_force)
    parts = _parts(one, averages, excitation, band, options)
    known = tuple(dict.fromkeys(dof for part in parts for dof in part.dofs))
    channels = one.columns[0].dofs if isinstance(one, MinorResponse) else one.dofs  # all that were measured
    wanted = _wanted_dofs(dofs, known, excitation, channels)
    lines_for = parts[0].lines_for
    if near is not None:
        check_set("near", near)
        of_same_force(near, excitation)
        _require_known(near, () if dofs is None or options.rule.new_values else wanted)
        searched = None
        # What holds over the whole band is the better estimate, where it was for these values.
        many = averages is not None and averages.spectra.n_averages >= LEAST_SEGMENTS
        over_band = near.options.get("fitted") == "numerators" and many
        if options.rule.new_values or over_band:
            of_fit = {name: getattr(options.rule, name) for name in options.rule.given - {"new_values"}}
            of_call = options.call.values() | {"check": "off"}
            again = {"excitation": excitation, "band_hz": band, "fit": FitOptions(**of_fit)}
            searched = identify_antiresonances(one, **again, **of_call)
        else:  # options by which the values were found may be given again
            held = options.values()
            others = sorted(options.given - {*OF_FOLLOWING})
            idle = [name for name in others if near.options.get(name) != held[name]]
            _say_idle(idle, "values that are followed (near=) without a search for new ones", OF_FOLLOWING)
        return _followed(near, searched, one, averages, parts, excitation, channels, wanted, band, options)
    drifting = averages is not None and averages.nperseg is None and drifts(averages.rec, band)
    options, fits, misfit = settled(
        options, lines_for(0), band, of_curves=averages is None, drifting=drifting
    )
    step("checking the data")
    checked = _checked(one, excitation, band, averages, options)
    step("fit")
    asked = "formulation" in fit.given
    diagrams, options = _fitted(one, averages, band, options, parts, fits, wanted, asked=asked)
    diagrams = of_lost_channels(diagrams, checked)
    found = {dof: diagrams[dof] for dof in wanted}
    of_numerators = options.formulation == "numerators"
    lost = checked is not None and checked.fatal
    if (lost or options.formulation == "directions") and not any(len(d.accepted) for d in found.values()):
        why = Counter(str(one) for d in found.values() for one in d.left_out.scores.get("why", ()))
        said = "; ".join(f"{count} {reason}" for reason, count in why.most_common())
        warn(
            "nothing_found",
            f"identify_antiresonances: no antiresonance in {band[0]:g} to {band[1]:g} Hz. What fits see: "
            f"{said or 'no zero that comes back'}.",
        )
    tables = {dof: graded(d.accepted) if of_numerators else d.accepted for dof, d in found.items()}
    tables = {dof: with_second(table, checked) for dof, table in tables.items()}
    behind = None  # what the standard deviations rest on
    if isinstance(one, AveragedResponse):
        behind = freedom(len(one.runs))
    elif averages is not None and of_numerators:
        behind = independent_averages(averages.spectra)
    if behind is not None:
        tables = {dof: t.with_scores(averages=np.full(len(t), behind)) for dof, t in tables.items()}
    held_back: dict[str, Any] = {}
    if misfit is not None and np.isfinite(misfit):
        held_back["held_back_misfit"] = float(f"{misfit:.3g}")
    if parts[0].silent:
        held_back["silent"] = [list(dof) for dof in parts[0].silent]
    of_size = options.formulation == "windows" and lines_for(0).size is not None
    return AntiresonanceSet.from_tables(
        excitation,
        tables,
        diagrams=found,
        data_check=checked,
        sees="frf" if options.use_force or of_size else "transmissibility",
        channels=channels,
        options={**_made_of(one, band), **options.values(), **held_back},
    )


def _fitted(
    source: Recording | FrequencyResponse,
    averages: Averages | None,
    band: tuple[float, float],
    options: IdentificationOptions,
    parts: Sequence[_Part],
    fits: list[Likeliest],
    wanted: tuple[Any, ...],
    *,
    asked: bool,
) -> tuple[dict[Any, StabilizationDiagram], IdentificationOptions]:
    """Diagrams of the parts in which something is wanted; ``fits`` are of the first."""
    diagrams: dict[Any, StabilizationDiagram] = {}
    for part in parts:
        if part is not parts[0] and not {*part.dofs} & {*wanted}:
            continue
        looks: list[Look] = []
        if options.formulation == "directions":
            looks, options = _looks(source, averages, band, options, part, asked=asked)
        own = fits if part is parts[0] else []
        diagrams = diagrams_of(part.dofs, part.lines_for, band, options, looks, own) | diagrams
    return diagrams, options


def _made_of(source: Recording | FrequencyResponse, band: tuple[float, float]) -> dict[str, Any]:
    """What a set remembers beside the options; of a record how strongly it shook, in its unit."""
    made: dict[str, Any] = {"antires_rs": __version__, "band_hz": list(band)}
    if isinstance(source, Recording):
        x = source.responses[:, :: max(1, source.n_samples // LEVEL_SAMPLES)]
        highest = np.quantile(np.abs(x - x.mean(axis=1, keepdims=True)), LEVEL_QUANTILE, axis=1)
        made["fs_hz"] = source.fs_hz
        made["response_level"] = float(f"{np.sqrt(np.mean(highest**2)):.6g}")
    return made


def _looks(
    source: Recording | FrequencyResponse,
    averages: Averages | None,
    band: tuple[float, float],
    options: IdentificationOptions,
    part: _Part,
    *,
    asked: bool,
) -> tuple[list[Look], IdentificationOptions]:
    """What perturbed local fits look at; the other fits serve where lines are too few, unless asked for."""
    if not isinstance(source, Recording) or averages is None or options.use_force:
        strange = "'directions' for curves or the route 'frf'"
        needed = "a Recording, and the route 'transmissibility'"
        reject("formulation", strange, needed, "Take 'windows' for curves, 'numerators' for the route 'frf'.")
    looks = looks_of(averages, band, part.directions)
    if looks:
        return looks, options
    if asked:
        needed = f"a band with at least {2 * LEAST_LINES} lines for local fits"
        reject("band_hz", f"({band[0]:g}, {band[1]:g}) Hz", needed, "Widen the band, or record for longer.")
    return [], replace(options, formulation="numerators" if averages.spectra.n_averages > 1 else "windows")


def _followed(
    near: AntiresonanceSet,
    searched: AntiresonanceSet | None,
    source: Recording | FrequencyResponse,
    averages: Averages | None,
    parts: Sequence[_Part],
    excitation: Any,
    channels: tuple[Any, ...],
    wanted: tuple[Any, ...],
    band: tuple[float, float],
    options: IdentificationOptions,
) -> AntiresonanceSet:
    """The values of ``near`` as this test has them, with new ones if it was searched."""
    step("checking the data")
    checked = _checked(source, excitation, band, averages, options)
    step("following")
    tables: dict[Any, ResponseTable] = {}
    gone: dict[Any, ResponseTable] = {}
    several = len(parts) > 1
    for part in parts:
        if several and not any(dof in near and dof not in tables for dof in part.dofs):
            continue
        looks: list[Look] = []
        if isinstance(source, Recording) and averages is not None and not options.use_force:
            looks = looks_of(averages, band, part.directions, one=True)
        look = looks[0] if looks else look_of(part.lines_for(FORCE if options.use_force else 0))
        seen, unseen = tables_of(look, part.dofs, near, band, options.rule.min_share)
        tables, gone = seen | tables, unseen | gone
    if searched is not None:
        better = searched.options["fitted"] == "numerators"
        tables = with_search(tables, searched, better=better, new=options.rule.new_values)
    of_size = (  # Curves of FRFs tell the roots of the FRF, but what is followed may be others.
        isinstance(source, FrequencyResponse) and source.kind == "frf" and near.sees != "transmissibility"
    )
    return AntiresonanceSet.from_tables(
        excitation,
        {dof: tables[dof] for dof in wanted if dof in tables},
        left_out={dof: gone.get(dof, ResponseTable(np.empty(0))) for dof in wanted if dof in tables},
        data_check=checked,
        sees="frf" if options.use_force or of_size else "transmissibility",
        channels=channels,
        options={**_made_of(source, band), **options.values(), "fitted": "followed"},
    )


@dataclass(frozen=True)
class _Part:
    """Responses that are fitted together: their names, their lines, and their directions in other spectra."""

    dofs: tuple[Any, ...]
    lines_for: Callable[[int], Lines]
    directions: Directions = dominant
    silent: tuple[Any, ...] = ()  # minors of the source that are nothing but noise


def _parts(
    source: Recording | FrequencyResponse,
    averages: Averages | None,
    excitation: Any,
    band: tuple[float, float],
    options: IdentificationOptions,
) -> list[_Part]:
    """All responses to one force; the minors of several in as many parts as one fit can hold."""
    if not isinstance(excitation, Dofs):
        return [_Part(source.dofs, lines_of(source, averages, band, options))]
    if isinstance(source, MinorResponse):
        some = [source.rows(rows) for rows in source.groups]
        return [_Part(each.dofs, lines_of(each, averages, band, options)) for each in some]
    assert isinstance(source, Recording)
    assert averages is not None
    minors = MinorsOfRecord(source, averages, len(excitation))
    return [_Part(minors.dofs, lambda _: minors.lines, minors.directions, minors.silent)]


def _source_of(source: Any, excitation: Any, options: IdentificationOptions) -> Any:
    """One source of what was given: repeats joined, of several forces the curves of each."""
    if not isinstance(excitation, Dofs):
        return one_source(source)
    first = source[0] if isinstance(source, list | tuple) and source else source
    refuse_point(excitation, getattr(first, "dofs", ()))
    if options.call.estimator != "rank1":
        got = f"{options.call.estimator!r} for several forces"
        remedy = "Leave it out: two-channel estimators hold one force alone."
        reject("estimator", got, "'rank1', the dominant subspace of all channels", remedy)
    if options.max_order < len(excitation):
        remedy = "Minors of r forces have r orders more with each degree. Raise it."
        reject("max_order", options.max_order, f"at least {len(excitation)}, as many as forces", remedy)
    if options.use_force:
        got, needed = "'frf' for several forces", "'transmissibility', which needs none of them"
        remedy = "Give FRFs measured one force after the other as a list; their minors are compared."
        reject("route", got, needed, remedy)
    curves = isinstance(first, FrequencyResponse)
    return minors_of_curves(source, len(excitation)) if curves else one_source(source)


def of_same_force(near: AntiresonanceSet, excitation: Any) -> None:
    """Refuse values of another excitation."""
    if near.excitation != excitation:
        got, needed = f"a set of force at {near.excitation!r}", f"one of force at {excitation!r}"
        reject("near", got, needed, "Follow values of the same excitation.")


def _require_known(near: AntiresonanceSet, wanted: tuple[Any, ...]) -> None:
    """Refuse dofs of which nothing is known."""
    missing = [dof for dof in wanted if dof not in near]
    if missing:
        remedy = "Leave those out, or search for new values: fit=FitOptions(new_values=True)."
        got, needed = f"{missing}, of which near has no values", f"dofs of near, {tuple(near)}"
        reject("dofs", got, needed, remedy)


def _checked(
    source: Recording | FrequencyResponse,
    excitation: Any,
    band: tuple[float, float],
    averages: Averages | None,
    options: IdentificationOptions,
) -> DataCheck | None:
    """The data check of the averages that are fitted, with a warning or an error if there is cause."""
    if options.call.check == "off":
        return None
    if not options.use_force and isinstance(source, Recording):
        source = without_force(source)
    if isinstance(source, MinorResponse):
        checked = judged_together(source.columns, band, options.averaging)
    else:
        checked = judged(source, excitation, band, options.averaging, averages)
    if options.call.check == "raise" and checked.fatal:
        fatal = [f for f in checked.findings if f.severity == "fatal"]
        got = "data in which the check finds: " + " ".join(f.text for f in fatal).rstrip(".")
        wanted = "data without fatal findings, as check='raise' asks for"
        raise UnsuitableDataError("source", got, wanted, " ".join(f.advice for f in fatal))
    if not checked.ok:
        said = "\n".join(f"data check: {line}" for line in checked.warnings)
        warn(tuple(dict.fromkeys(f.name for f in checked.findings if f.severity != "note")), said)
    return checked


def _wanted_dofs(
    dofs: Iterable[Any] | None, known: tuple[Any, ...], excitation: Any, channels: tuple[Any, ...]
) -> tuple[Any, ...]:
    """The dofs asked for, all of them channels of the source, or sets of them."""
    if dofs is None:
        return known
    wanted = f"dofs out of {known}"
    if isinstance(dofs, str | bytes) or not isinstance(dofs, Iterable):
        reject("dofs", dofs, f"a list of {wanted}", "Put the dofs in a list, such as dofs=[0, 1].")
    named = list(dofs)
    if isinstance(excitation, Dofs):
        named = [key_of(excitation, (), channels)("dofs", dof) for dof in named]
    strange = [dof for dof in named if dof not in known]
    if strange or not named:
        remedy = "Name dofs of the source, or leave dofs out for all."
        reject("dofs", strange or "an empty list", wanted, remedy)
    return tuple(known[known.index(dof)] for i, dof in enumerate(named) if dof not in named[:i])


# -- A hammer that roved: each hit is identified by itself, all are joined at the sensor that stayed


@dataclass(frozen=True)
class Hit:
    """One of the measurements: what it is called, and where its force acted."""

    name: str
    signal: Recording | FrequencyResponse
    force: Any


def identify_roving(
    hits: Sequence[Hit],
    sensor: Any,
    band_hz: Sequence[float],
    *,
    say: Callable[[str], Any] | None = None,
    **options: Any,
) -> AntiresonanceSet:
    """The antiresonances of all places that were hit, to a force at the sensor (H_ik = H_ki)."""
    sets = []
    for hit in hits:
        if say is not None:
            say(f"identifying the antiresonances of {hit.name}, force at {hit.force}")
        sets.append(
            identify_antiresonances(hit.signal, excitation=hit.force, band_hz=band_hz, **sorted_out(options))
        )
    joined = merge_setups(sets, excitation=sensor)
    diagrams = {}
    for dof in joined:
        seen = [one.diagrams[dof] for one in sets if one.excitation == sensor and dof in one.diagrams]
        seen += [one.diagrams[sensor] for one in sets if dof == one.excitation != sensor]
        if len(seen) == 1:
            diagrams[dof] = seen[0]
    return AntiresonanceSet.from_tables(
        sensor,
        joined.tables,
        diagrams=diagrams,
        sees=joined.sees,
        channels=joined.channels or None,
        options=joined.options,
    )
