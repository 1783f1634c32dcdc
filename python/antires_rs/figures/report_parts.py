"""What a report says in words: the signals, how they were identified, the model, the search."""

from __future__ import annotations

from base64 import b64encode
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from io import BytesIO
from typing import Any, NamedTuple, cast

import numpy as np

from ..damage.assess import DamageResult
from ..damage.hypotheses import Assessment, loss, percent, span
from ..identification.stabilization import StabilizationDiagram
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.frame_parts import PARTS
from ..models.structural_model import StructuralModel
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording, parts_of
from ..support.checks import FloatArray
from ..updating.result import UpdateResult
from ..updating.targets import FrequencyTable, ModalTable, signed
from . import responses
from .canvas import picture
from .damage import WORTH_A_ROW, losses, plot_damage, plot_hypotheses, probabilities, worth_a_row
from .identification import stabilization_figure
from .live_canvas import explored
from .marks import Line, Scene
from .mesh import MOST_MODES, has_mesh, page_data, plot_mesh, scene, shapes_of
from .packing import library, packed, packed_text
from .responses import dof_name
from .structure import chain, frame, plot_chain, plot_frame, seen_points
from .updating import convergence, differences, plot_convergence, plot_differences

Facts = dict[str, list[str]]


def named_diagrams(
    tables: Sequence[Mapping[Any, Any]], forces: Sequence[Any], model: StructuralModel
) -> dict[str, Any]:
    """Diagrams by the name of their response, with that of the force where there are several."""
    named: dict[str, Any] = {}
    for force, table in zip(forces, tables, strict=True):
        at = f", force at {dof_name(model, force)}" if len(tables) > 1 else ""
        named |= {f"{dof_name(model, dof)}{at}": diagram for dof, diagram in table.items()}
    return named


def of_signal(signal: Recording | FrequencyResponse) -> Facts:
    """Channels, and how long or fine they were measured."""
    facts = {"Channels": [f"{len(signal.dofs)} responses: {_names(signal.dofs)}"]}
    if isinstance(signal, Recording):
        parts = len(parts_of(signal))
        several = f"{parts} records of one test, together " if parts > 1 else ""
        length = f"{signal.duration_s:g} s at {signal.fs_hz:g} Hz, {signal.n_samples:,} samples a channel"
        force = f"force {'not ' if signal.force is None else ''}recorded"
        return facts | {"Record": [f"{several}{length}", force]}
    low, high = signal.freq_hz[[0, -1]]
    kind = "frequency responses" if signal.kind == "frf" else "transmissibilities"
    over = "" if signal.reference is None else f" over dof {signal.reference}"
    facts["Curves"] = [f"{kind}{over}, {signal.freq_hz.size:,} lines from {low:g} to {high:g} Hz"]
    return facts | ({} if signal.n_averages is None else {"Averages": [f"{signal.n_averages:.1f}"]})


_HOW = {  #: How values were accepted, in words.
    "chain": "stable over consecutive orders",
    "persistent": "in most orders without standing still",
    "likeliest order": "from the likeliest order alone",
    "double root": "two roots that are not told apart, as one",
    "windows": "seen by most fits over windows",
    "directions": "seen by most perturbed local fits",
    "followed": "followed from known values",
}


def of_set(found: AntiresonanceSet | ModalSet, model: StructuralModel) -> Facts:
    """What a measured set knows of itself."""
    if not isinstance(found, AntiresonanceSet):
        return {"Modes": [f"{len(found)} with shapes at {len(found.dofs)} dofs: {_names(found.dofs)}"]}
    counts = ", ".join(f"{len(found[dof])} at {dof_name(model, dof)}" for dof in found)
    facts = {"Force": [dof_name(model, found.excitation)], "Antiresonances": [counts]}
    if found.sees is not None:
        facts["Identified from"] = ["FRFs" if found.sees == "frf" else "transmissibilities"]
    how = Counter(way for scores in found.scores.values() for way in scores.get("how", ()))
    if accepted := [f"{how[name]} {said}" for name, said in _HOW.items() if how[name]]:
        shares = np.concatenate([*found.share.values()])
        if not np.isnan(shares).all():
            least, most = np.nanmin(shares), np.nanmax(shares)
            accepted.append(f"the share of fits that see a value is {least:.0%} to {most:.0%}")
        if found.expected_false is not None:
            accepted.append(f"at most {found.expected_false:.2g} of them false, on average")
        facts["Accepted"] = [", ".join(accepted)]
    if found.edits:
        facts["Edited by hand"] = [str(edit) for edit in found.edits]
    return facts | of_evidence(found)


def of_evidence(found: AntiresonanceSet) -> Facts:
    """Options, what was not accepted, unexplained peaks, and what a set knows as long as it is not saved."""
    facts: Facts = {}
    used = {name: value for name, value in found.options.items() if name != "held_back_misfit"}
    if given := [f"{name} {value}" for name, value in used.items() if value is not None]:
        facts["Identified with"] = [", ".join(given)]
    if (misfit := found.options.get("held_back_misfit")) is not None:
        said = "of held-back segments to one fit of the others, in the worst eighth of the band"
        facts["Held-back misfit"] = [f"{misfit:g} times what noise makes, {said}"]
    left = []
    for dof, table in found.left_out.items():
        why = np.asarray(table.scores.get("why", np.full(len(table), "")))
        for reason in dict.fromkeys(why.tolist()):
            freq = ", ".join(f"{f:.2f}" for f in table.freq_hz[why == reason])
            left.append(f"dof {dof}: {freq} Hz{f', {reason}' if reason else ''}")
    peaks = {dof: ", ".join(f"{f:.2f}" for f in freq) for dof, freq in found.unexplained_hz.items()}
    unexplained = [f"dof {dof}: {freq} Hz" for dof, freq in peaks.items() if freq]
    facts |= {"Left out": left} if left else {}
    facts |= {"Unexplained peaks": unexplained} if unexplained else {}
    for one in list(found.diagrams.values())[:1]:
        low, high = one.band_hz
        facts["Diagrams"] = [f"orders {one.orders[0]:.0f} to {one.orders[-1]:.0f}, {low:g} to {high:g} Hz"]
    if found.data_check is not None:
        length, averages = found.data_check.nperseg, found.data_check.n_averages
        if length is not None and averages is not None:
            facts["Spectra"] = [f"segments of {length:,} samples, {averages:.1f} independent averages"]
        facts["Data check"] = [str(finding) for finding in found.data_check.findings] or ["nothing found"]
    return facts


def of_model(model: StructuralModel) -> Facts:
    """What the nominal model is made of."""
    facts = {"Model": [repr(model)]}
    if isinstance(model, MassSpringChain):
        stiffness, mass = model.stiffness(), model.mass()
        springs = -np.diag(stiffness, 1)
        facts["Masses"] = [f"{_span(np.diag(mass), 'kg')}, {mass.sum():.4g} kg in all"]
        facts["Springs"] = [_span(springs, "N/m")] if springs.size else ["none"]
        held = zip(("first", "last"), stiffness.sum(axis=1)[[0, -1]], strict=True)
        ends = [f"{name} mass {k:.4g} N/m" for name, k in held if k > 1e-9 * stiffness.max()]
        facts["To ground"] = ends or ["none, free at both ends"]
    elif isinstance(model, FrameModel):
        facts["Sections"] = []
        for i, section in enumerate(model.sections.values()):
            values = {name: value for name, value in asdict(section).items() if value is not None}
            said = [f"{name} {f'{v:.6g}' if isinstance(v, float) else v}" for name, v in values.items()]
            facts["Sections"].append(f"{model.section_label(i)}: {type(section).__name__}, {', '.join(said)}")
        carried = {kind.replace("_", " "): len(model._parts(kind)) for kind in PARTS}
        facts["Carried"] = [f"{kind}: {n or 'none'}" for kind, n in carried.items()]
        facts["Fixed nodes"] = [_names(sorted({node for node, _ in model.fixed})) or "none"]
    return facts | {"Numbers": ["all from 0, as in Python and in job files"]}


def of_search(result: UpdateResult) -> Facts:
    """The objective, the options of the search and where it ended; or how hypotheses were judged."""
    ended, seed = {"Ended": [f"{result.status}: {result.message}"]}, {"Seed": [f"{result.seed}"]}
    if isinstance(result, DamageResult) and result.has_baseline:
        found, rule = result.assessment, "where it is more probable than none"
        if found.threshold is not None:
            rule = f"from log odds of {found.threshold:.2f} on, for the rate of false alarms"
        learned = (
            f"learned from the baseline: stiffnesses and masses off by {100 * found.factor_std:.2g} %, "
            f"{100 * found.root_std:.2g} % of a frequency beyond them, {100 * found.kappa:.2g} % of a change"
        )
        values = f"{found.n_matched} of {found.n_values} compared, reduced chi-square {found.chi_square:.2f}"
        judged = {"Model errors": [learned], "Values": [values], "Rule": [f"damage is declared {rule}"]}
        return ended | judged | seed
    problem, penalty = result.problem, result.problem.penalty
    price = "" if penalty is None else f", {penalty.text}, snap {penalty.snap:g}"
    weights = "none" if problem.weights is None else _span(problem.weights, "").strip()
    objective = f"J = {result.fun:.6g}; misfit {problem.misfit}{price}, weights {weights}"
    given = {name: value for name, value in result.search.options.items() if value is not None}
    options = [f"{name} {', '.join(v) if isinstance(v, list) else v}" for name, v in given.items()]
    search = [f"{result.search.effort}, {result.history.cost.shape[1]} islands", "; ".join(options)]
    return ended | {"Objective": [objective], "Search": search} | seed


def _names(dofs: Iterable[Any], most: int = 40) -> str:
    names = [str(dof) for dof in dofs]
    return ", ".join(names if len(names) <= most else [*names[: most - 1], f"… {names[-1]}"])


def _span(values: Any, unit: str) -> str:
    low, high = float(np.min(values)), float(np.max(values))
    return f"{len(values)} of {low:.6g}{'' if low == high else f' to {high:.6g}'} {unit}"


# -- The figures of a result, each made once, with the sentences that stand under it and in place of it

COLOURS_KEPT = 128  # of a picture: lines and their soft edges need no more, and a third of the bytes is left
MOST_BYTES = 2_750_000  # pictures and figures: a report stays below 3 MB, diagrams beyond are left out
#: Of a figure to be explored: elements from which on names stand upright, masses that are numbered, width in
#: points, roughly, and lines of a curve, more than a screen has pixels.
UPRIGHT, MOST_NUMBERS, WIDE_PT, MOST_LINES = 7, 24, 600.0, 2500


@dataclass(frozen=True)
class Figure:
    """One figure, made when first asked for; what stands under it, and what is read out in its place."""

    draw: Callable[..., Any]
    size_in: tuple[float, float]
    caption: str
    alt: str
    explore: Callable[[], Any]
    scene: Callable[[], Scene] | None = None  # what is turned instead

    @cached_property
    def live(self) -> str:
        """To be explored, packed; empty where nothing makes it."""
        return packed(self.explore) if self.scene is None else packed_text(page_data(self.scene()), 6)

    @cached_property
    def png(self) -> bytes:
        """As a file of its own."""
        return picture(lambda ax: self.draw(ax=ax), self.size_in)

    @cached_property
    def uri(self) -> str:
        """As it stands in a page, in few colours."""
        from PIL import Image  # matplotlib writes PNG with it, so it is there

        few = Image.open(BytesIO(self.png)).convert("RGB").quantize(COLOURS_KEPT, dither=Image.Dither.NONE)
        file = BytesIO()
        few.save(file, "PNG", optimize=True)
        return "data:image/png;base64," + b64encode(file.getvalue()).decode("ascii")


@dataclass(frozen=True)
class Drawings:
    """All figures of a result: by name, and the stabilization diagrams by that of their response."""

    figures: Mapping[str, Figure]
    diagrams: Mapping[Any, Figure]
    beside: ModalTable | None = None  # measured modes that were not fitted


def drawings_of(
    result: UpdateResult,
    response: FrequencyResponse | None = None,
    truth: Mapping[int, float] | None = None,
    diagrams: Mapping[Any, StabilizationDiagram] | None = None,
    beside: ModalTable | None = None,
) -> Drawings:
    """Figures of a result; ``diagrams`` are by default those that its measured sets carry."""
    problem, names, table, history = result.problem, states(result), result.table, result.history
    modal, sets = problem.objective == "modal", problem.measured
    what = "resonance" if modal else "antiresonance"
    figures = _damage(result, truth) if isinstance(result, DamageResult) else {}
    figures |= _model(result)
    figures["differences"] = _differences(table, names, what)
    if beside is not None:
        figures["modes"] = _differences(beside, names, "resonance")
    if response is not None:
        figures["response"] = _response(result, response, names)
    if history.cost.size:  # nothing is searched against a baseline
        best = f"from {history.cost[0].min():.4g} to {history.cost[-1].min():.4g}"
        figures["convergence"] = Figure(
            partial(plot_convergence, result),
            (9.0, 4.2),
            "The search: best objective of each island.",
            f"Curves by evaluations of the best objective of {history.cost.shape[1]} islands, {best}",
            lambda: explored(convergence(result), height=340),
        )
    if diagrams is None and modal:
        diagrams = {i: each.diagram for i, each in enumerate(sets) if each.diagram is not None}
    elif diagrams is None:
        forces = [each.excitation for each in sets]
        diagrams = named_diagrams([each.diagrams for each in sets], forces, problem.model)
    return Drawings(figures, {name: _diagram(name, one, modal) for name, one in diagrams.items()}, beside)


def _differences(table: FrequencyTable | ModalTable, names: tuple[str, str], what: str) -> Figure:
    most = " and ".join(map(" ".join, zip(largest(table), names, strict=True)))
    return Figure(
        partial(plot_differences, table, names=names),
        (9.5, 4.6),
        f"Difference of each {what} to the measured one, {names[0]} and {names[1]}.",
        f"Bar chart of {table.measured_hz.size} differences, given in the table above: the largest is {most}",
        lambda: explored(differences(table, names), height=360, side_by_side=1),  # entries are long
    )


def fitting(drawn: Drawings, room: int = MOST_BYTES) -> tuple[list[tuple[Figure, str]], int]:
    """Diagrams for which a page has room, each with its packed figure if that fits; how many are left out."""
    room -= len(library()) + sum(len(one.uri) + len(one.live) for one in drawn.figures.values())
    kept: list[Figure] = []
    for one in drawn.diagrams.values():
        room -= len(one.uri)
        if room < 0:
            break
        kept.append(one)
    shown = []
    for one in kept:
        live = one.live if 0 < room >= len(one.live) else ""
        room -= len(live)
        shown.append((one, live))
    return shown, len(drawn.diagrams) - len(kept)


def _damage(result: DamageResult, truth: Mapping[int, float] | None) -> dict[str, Figure]:
    """Losses by element, and where they were judged the hypotheses."""
    label, judged = result.problem.model.element_label, result.has_baseline
    more = ", with 90 % intervals; above, the probability of each; empty bars, what may have it instead"
    found = ", ".join(f"{label(e)} {100 * result.severity[e]:.1f} %" for e in result.damaged)
    upright = len(result.elements) > UPRIGHT
    figures = {
        "damage": Figure(
            partial(plot_damage, result, truth=truth),
            (max(7.0, 0.32 * len(result.x) + 1.5), 4.7 if judged else 4.4),
            f"Stiffness loss by element{more * judged}. Ticks: the {_smallest(result)}.",
            f"Bar chart: {found or 'no damage in any element'}",
            lambda: explored(losses(result, truth, upright), height=400 if upright else 360),
        )
    }
    if judged:
        hypotheses = result.hypotheses
        figures["hypotheses"] = Figure(
            partial(plot_hypotheses, hypotheses),
            (8.0, 1.3 + 0.5 * min(len(hypotheses), 9)),
            "Probabilities of what may explain the measurement, with losses and their 90 % intervals.",
            "Bar chart of the table above",
            lambda: explored(probabilities(hypotheses), height=110 + 40 * min(len(hypotheses), 12)),
        )
    return figures


def _model(result: UpdateResult) -> dict[str, Figure]:
    """The model with its losses, sensors and force; none of matrices without a mesh, which have no shape."""
    model, seen = result.problem.model, result.problem.measured[0]
    loss, caption = None, "The model"
    if isinstance(result, DamageResult):
        loss = {e: 100.0 * beta for e, beta in result.severity.items()}
        caption = "The model with the stiffness losses found"
    at: dict[str, Any] = {"sensors": [], "excitation": None, "label": "Stiffness loss (%)"}
    if isinstance(seen, AntiresonanceSet):
        dofs = dict.fromkeys(dof for key in seen for dof in (key if isinstance(key, tuple) else [key]))
        at |= {"sensors": list(dofs), "excitation": seen.excitation}
        caption += "; sensors as arrows, the force as a heavier one"
    if isinstance(model, MassSpringChain):
        size, height, alt = (9.0, 2.9), 260, f"Drawing of a chain of {model.n_dof} masses"
        draw, every = partial(plot_chain, model, loss, **at), -(-model.n_dof // MOST_NUMBERS)
        panel = partial(chain, model, loss, **at, wide_pt=WIDE_PT, every=every)
    elif isinstance(model, FrameModel):
        loss = loss and {e: beta for e, beta in loss.items() if e < len(model.elements)}
        extent, (wide, high) = np.ptp(model.nodes_m, axis=0), np.ptp(seen_points(model), axis=0)
        size = (9.0, 6.5 if extent[1:].max() > 0.6 * extent[0] else 4.6)
        height = int(np.clip(700.0 * high / max(wide, 1e-300), 320, 620))
        caption += ". Numbers upright are of elements, slanted ones of nodes"
        alt = f"Drawing of a frame of {len(model.elements)} elements"
        draw = partial(plot_frame, model, loss, **at)
        panel = partial(frame, model, loss, **at, room_pt=np.array([WIDE_PT, 0.7 * height]))
    elif has_mesh(model):
        size, height, alt = (9.0, 6.0), 0, "Drawing of the mesh"
        draw = panel = partial(plot_mesh, cast("Any", model), loss, **at)
    else:
        return {}
    turned = partial(_turned, result, loss, at) if has_mesh(model) else None
    return {"model": Figure(draw, size, f"{caption}.", alt, lambda: explored(panel(), height=height), turned)}


def _turned(result: UpdateResult, loss: Mapping[int, float] | None, at: dict[str, Any]) -> Scene:
    """The updated model to be turned, with its modes up to the highest measured value."""
    says: dict[int, str] = {}
    if isinstance(result, DamageResult):
        chance, limits = (result.probability, result.interval) if result.has_baseline else ({}, {})
        for e, beta in result.severity.items():
            says[e] = f"{100 * beta:.1f} %"
            if e in chance:
                within = f" ({_interval(*limits[e])})" if beta else ""
                says[e] += f"{within}, probability {percent(chance[e])}"
    # As many as are shown, beside six rigid bodies.
    modes = result.model.modes(n_modes=min(MOST_MODES + 6, result.model.n_dof))
    return scene(result.model, loss, at["sensors"], at["excitation"], at["label"], shapes_of(modes), says)


def _diagram(name: Any, diagram: StabilizationDiagram, modal: bool) -> Figure:
    of = "all responses" if modal or name is None else f"dof {name}" if isinstance(name, int) else str(name)
    found = ", ".join(f"{f:.2f}" for f in diagram.identified)
    accepted = f"accepted at {found} Hz" if found else "no antiresonance accepted"
    return Figure(
        diagram.plot,
        (9.0, 5.0),
        f"Stabilization diagram of {of}: poles of rational fits of rising order; those that stay are "
        f"{'the resonances' if modal else 'its antiresonances'}.",
        f"Stabilization diagram of {of}, {diagram.band_hz[0]:g} to {diagram.band_hz[1]:g} Hz: {accepted}",
        partial(stabilization_figure, diagram, dof=name),
    )


def _response(result: UpdateResult, response: FrequencyResponse, names: tuple[str, str]) -> Figure:
    model, own = result.problem.model, result.problem.measured[0]
    given: dict[str, Any] = {"excitation": own.excitation, "names": names}
    counts = np.max  # of lines that share a pixel: peaks, or dips
    if response.kind == "frf":
        dofs = [dof for dof in response.dofs if dof in own] or list(response.dofs)
        given["dofs"] = shown = dofs[: responses.MOST_RESPONSES]
        counts = np.min
        size = (9.0, 2.0 + 1.2 * len(shown))
        some = "" if len(shown) == len(response.dofs) else f"The first {len(shown)}. "
        caption = f"FRFs of the responses; the dips are their antiresonances. {some}The depth of dips"
        what = f"{len(shown)} FRFs"
    else:
        size, what = (9.0, 4.4), f"the transmissibilities over {dof_name(model, response.reference)}"
        caption = f"T{what[5:]}, summed; the peaks are the antiresonances of that dof. Their height"
    drawn = partial(responses.plot_responses, response, model, result.model, **given)
    caption += " in the models follows from an assumed damping of 1 %."
    alt = f"Curves by frequency of {what}: measured, and of the model {names[0]} and {names[1]}"

    def explore() -> Any:
        panel = responses.responses(response, (model, result.model), **given)
        lines = [_thinned(mark, counts) if isinstance(mark, Line) else mark for mark in panel.marks]
        return explored(replace(panel, marks=lines), height=int(66 * size[1]))

    return Figure(drawn, size, caption, alt, explore)


def _thinned(line: Any, how: Any) -> Any:
    """A line of no more points than can be seen, the one that counts of those that share a pixel."""
    step = max(1, -(-len(line.x) // MOST_LINES))

    def few(values: FloatArray, how: Any) -> FloatArray:
        return np.asarray(how(values[: len(values) // step * step].reshape(-1, step), axis=1))

    more = {name: few(column, how) for name, column in line.more.items()}
    return replace(line, x=few(line.x, np.mean), y=few(line.y, how), more=more)


def states(result: UpdateResult) -> tuple[str, str]:
    """What the model is called before and after."""
    damage = isinstance(result, DamageResult)
    return ("without damage", "with the damage found") if damage else ("before updating", "after updating")


def largest(table: FrequencyTable | ModalTable) -> list[str]:
    """The largest differences before and after in words."""
    both = (table.largest_before_percent, table.largest_after_percent)
    return [f"{percent:.2f} %" if np.isfinite(percent) else "no partner at all" for percent in both]


def answer_of(result: UpdateResult) -> list[str]:
    """What came out, the first sentence alone."""
    if isinstance(result, DamageResult):
        return list(result._headline())
    what = "resonance" if result.problem.objective == "modal" else "antiresonance"
    return ["Largest {} difference: {} before, {} after.".format(what, *largest(result.table))]


# -- The tables of a report, cell by cell


class Table(NamedTuple):
    """Heads by column, those of numbers with their unit in brackets; rows with a ``mark`` stand out."""

    title: str
    heads: dict[str, str]
    rows: list[dict[str, Any]]
    mark: str
    note: str = ""


def tables_of(
    result: UpdateResult, truth: Mapping[int, float] | None = None, beside: ModalTable | None = None
) -> dict[str, Table]:
    """Hypotheses, where they were judged, values found, frequencies, modes beside them."""
    tables: dict[str, Table] = {}
    judged = isinstance(result, DamageResult) and result.has_baseline
    if isinstance(result, DamageResult):
        if judged:
            rows, others = hypothesis_rows(result.assessment)
            heads = {"probability": "probability (%)", "name": "explanation"}
            heads |= {"losses": "stiffness loss (%), 90 % interval"}
            tables["hypotheses"] = Table("Hypotheses", heads, rows, "hit", others)
        heads = {"name": "element"}
        if judged:
            heads |= {"probability": "probability of damage (%)", "value": "found (%)"}
            heads |= {"interval": "90 % interval (%)"}
        else:
            heads |= {"value": "found (%)", "std": "standard deviation (%)"}
        heads |= {} if truth is None else {"truth": "truth (%)"}
        heads |= {"visible": f"{_smallest(result)} (%)"} | ({} if judged else {"bounds": "bounds (%)"})
        tables["found"] = Table("Stiffness loss by element", heads, damage_rows(result, truth), "damaged")
    else:
        heads = {"name": "parameter", "nominal": "before", "value": "found", "std": "standard deviation"}
        heads |= {"change": "change (%)", "bounds": "bounds"}
        problem, rows = result.problem, []
        spreads = [text.removeprefix("\u00b1 ") for text in result.identifiability.spreads]
        columns = zip(problem.names, result.x, spreads, problem.nominal, problem.bounds, strict=True)
        for name, value, std, nominal, (low, high) in columns:
            change = f"{100 * (value / nominal - 1):+.2f}" if nominal else ""
            numbers = (f"{nominal:.5g}", f"{value:#.5g}", std.replace("nan", ""), change)
            cells = (name, *numbers, f"{low:g} to {high:g}")
            rows.append(dict(zip(heads, cells, strict=True)) | {"on_bound": name in result.at_bound})
        tables["found"] = Table("Parameters", heads, rows, "on_bound")
    corrected = ", corrected by the baseline" * judged
    tables["frequencies"] = _frequencies(result.table, states(result), corrected)
    return tables | ({} if beside is None else {"modes": _frequencies(beside, states(result))})


def _frequencies(table: FrequencyTable | ModalTable, names: tuple[str, str], corrected: str = "") -> Table:
    """Measured values with those of the model before and after."""
    modal = isinstance(table, ModalTable)
    heads = {"mode": "mode"} if modal else {"dof": "response dof", "force": "force dof"}
    heads["measured"] = f"measured{corrected} (Hz)"
    for state, name in zip(("before", "after"), names, strict=True):
        heads |= {f"{state}_mode": "paired with mode"} if modal else {}
        heads |= {state: f"{name} (Hz)", f"{state}_percent": "difference (%)"}
        heads |= {f"{state}_mac": "MAC"} if modal else {}
    title = "Resonances" if modal else "Antiresonances"
    return Table(title, heads, _frequency_rows(table, list(heads)), "group")


def _smallest(result: DamageResult) -> str:
    """What the smallest losses are: one intact test does not tell how values scatter from test to test."""
    alone = result.has_baseline and result.assessment.n_baselines == 1
    return "smallest by stated errors" if alone else "smallest that would be seen"


def damage_rows(result: DamageResult, truth: Mapping[int, float] | None) -> list[dict[str, Any]]:
    """Loss, standard deviation, truth, smallest visible and bounds of each candidate, in percent."""

    def percent(value: float | None) -> str:
        if value is None or value == 0.0:
            return "" if value is None else "0"
        return f"{100 * value:.{1 if value >= 9.5e-4 else 2}f}" if np.isfinite(value) else "none"

    label, judged, truth = result.problem.model.element_label, result.has_baseline, truth or {}
    on_bound = set() if judged else set(result.at_bound)
    chance, limits = (result.probability, result.interval) if judged else ({}, {})
    found, instead = (result.assessment, {}) if judged else (None, {})
    # Single elements that the values cannot tell from the one declared damaged.
    if found is not None and found.declared in [one.elements for one in found.group]:
        alike = [one for one in found.group if len(one.elements) == 1 == len(found.declared)]
        instead = {one.elements[0]: one for one in alike if one.elements != found.declared}
    rows: list[dict[str, Any]] = []
    columns = zip(result.elements, result.problem.names, result.std, result.problem.bounds, strict=True)
    for e, name, std, (low, high) in columns:
        lost, other = result.severity[e], instead.get(e)
        interval = limits.get(e, (0.0, 0.0)) if other is None else (other.low[0], other.high[0])
        row: dict[str, Any] = {"name": label(e), "value": percent(lost)}
        row["std"] = _deviation(100.0 * std) if lost > 0.0 else ""
        row |= {} if other is None else {"value": f"or {percent(other.severities[0])}"}
        row |= {"bounds": f"{100 * low:g} to {100 * high:g}", "visible": percent(result.detectable[e])}
        row |= {"interval": _interval(*interval), "probability": _probability(chance.get(e, 0.0))}
        row |= {"truth": percent(truth.get(e)), "damaged": lost > 0.0 or other is not None}
        rows.append(row | {"on_bound": name in on_bound})
    # Elements that were no candidates, and would explain the change.
    for one in result.hypotheses if judged else ():
        if not one.candidate and one.elements and not one.unknown and one.probability >= WORTH_A_ROW:
            e = one.elements[0]
            row = {"name": f"{label(e)}, no candidate", "value": percent(one.severities[0]), "std": ""}
            row |= {"interval": _interval(one.low[0], one.high[0]), "truth": percent(truth.get(e))}
            row |= {"probability": _probability(one.probability), "damaged": one is result.hypotheses[0]}
            rows.append(row | {"visible": "", "bounds": "", "on_bound": False})
    return rows


def hypothesis_rows(found: Assessment) -> tuple[list[dict[str, Any]], str]:
    """Rows of the hypotheses worth one, the answer and its like as hits, and a sentence on the others."""
    hypotheses, alike = found.hypotheses, found.group
    answer = alike if hypotheses[0] in alike else hypotheses[:1]
    rows = []
    for one in worth_a_row(hypotheses):
        losses = ", ".join(loss(*each) for each in zip(one.severities, one.low, one.high, strict=True))
        row = {"name": hypotheses.called(one), "probability": _probability(one.probability), "losses": losses}
        rows.append(row | {"hit": one in answer})
    others = len(hypotheses) - len(rows)
    rest = float(np.sum(hypotheses.probability[len(rows) :]))
    return rows, f"{others} others, together {_probability(rest)} %." if others else ""


def _frequency_rows(table: Any, names: list[str]) -> list[dict[str, Any]]:
    """Each measured value with the model's before and after; the response is named once."""

    def cell(name: str, value: float) -> str:
        if not np.isfinite(value):
            return "no partner"
        if name.endswith("mode"):
            return f"{value:.0f}"
        return signed(value) if name.endswith("percent") else f"{value:.3f}"

    own = {name: name if "_" in name else f"{name}_hz" for name in names}
    shown = [name for name in names if name not in ("mode", "dof", "force")]
    cells = {name: [cell(name, one) for one in getattr(table, own[name])] for name in shown}
    every = zip(*cells.values(), strict=True)
    rows: list[dict[str, Any]] = [dict(zip(cells, row, strict=True)) for row in every]
    if isinstance(table, ModalTable):
        for row, mode in zip(rows, table.mode, strict=True):
            row.update(mode=mode, group=mode == table.mode[0])
        return rows
    last = None
    for row, dof, force in zip(rows, table.dof.tolist(), table.excitation.tolist(), strict=True):
        row.update(group=(dof, force) != last, dof=table.named(dof), force=table.named(force))
        last = (dof, force)
    return rows


def _interval(low: float, high: float) -> str:
    return span(low, high) if high > 0.0 else ""


def _probability(p: float) -> str:
    """In percent; what is nearly 0 or 100 is not rounded to it."""
    return "< 0.1" if p < 0.001 else "> 99.9" if p > 0.999 else f"{100 * p:.1f}"


def _deviation(value: float) -> str:
    return f"{value:.2g}" if np.isfinite(value) else "not determined" if np.isinf(value) else ""
