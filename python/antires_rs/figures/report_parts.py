"""What a report says in words: the signals, how they were identified, the model, the search."""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache, cached_property, partial
from hashlib import sha256
from importlib.resources import files
from importlib.util import find_spec
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.assess import DamageResult
from ..damage.hypotheses import Assessment, loss, span
from ..damage.words import without_idle
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.structural_model import StructuralModel
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording, parts_of
from ..updating.result import UpdateResult
from ..updating.tables import ModalTable, signed
from .canvas import picture
from .damage import plot_damage, plot_hypotheses
from .live_canvas import item, script_files
from .live_identification import stabilization_figure
from .live_results import result_figures
from .responses import MOST_RESPONSES, plot_responses, plot_transmissibility
from .structure import plot_chain, plot_frame
from .updating import plot_convergence, plot_differences

if TYPE_CHECKING:
    from ..identification.stabilization import StabilizationDiagram
    from ..measured.modal_set import ModalSet
    from ..signals.frequency_response import FrequencyResponse
    from ..updating.result import UpdateResult

Facts = dict[str, list[str]]

#: More names than this are shortened.
MOST_NAMES = 40


def dof_name(model: StructuralModel, dof: Any) -> str:
    """A dof as the model calls it."""
    return str(model.dof_name(dof)) if isinstance(model, FrameModel) else f"dof {dof}"


def named_diagrams(
    tables: Sequence[Mapping[Any, Any]], forces: Sequence[Any], model: StructuralModel
) -> dict[str, Any]:
    """Diagrams by the name of their response, with that of the force where there are several."""
    several = len(tables) > 1
    return {
        dof_name(model, dof) + (f", force at {dof_name(model, force)}" if several else ""): diagram
        for force, table in zip(forces, tables, strict=True)
        for dof, diagram in table.items()
    }


def of_signal(signal: Recording | FrequencyResponse) -> Facts:
    """Channels, and how long or fine they were measured."""
    count = len(signal.dofs)
    facts = {"Channels": [f"{count} responses: {_names(signal.dofs)}"]}
    if isinstance(signal, Recording):
        parts = len(parts_of(signal))
        several = f"{parts} records of one test, together " if parts > 1 else ""
        facts["Record"] = [
            f"{several}{signal.duration_s:g} s at {signal.fs_hz:g} Hz, "
            f"{signal.n_samples:,} samples a channel",
            "force recorded" if signal.force is not None else "force not recorded",
        ]
        return facts
    low, high = signal.freq_hz[[0, -1]]
    over = "" if signal.reference is None else f" over dof {signal.reference}"
    kinds = {"frf": "frequency responses", "transmissibility": "transmissibilities"}
    facts["Curves"] = [
        f"{kinds[signal.kind]}{over}, {signal.freq_hz.size:,} lines from {low:g} to {high:g} Hz"
    ]
    if signal.n_averages is not None:
        facts["Averages"] = [f"{signal.n_averages:.1f}"]
    return facts


def of_identification(signal: Recording | FrequencyResponse, found: AntiresonanceSet) -> Facts:
    """Every choice of an identification, defaults among them, as the set keeps them."""
    from ..identification.options import OF_SWEEP, OF_WINDOWS, FitOptions
    from ..identification.windows import HIGHEST_ORDER

    used = found.options
    if not used:
        return {}
    formulation, fitted, max_order = used["formulation"], used["fitted"], used["max_order"]
    if formulation == "auto":
        formulation = f"auto, here {fitted}"
    if fitted == "windows":
        max_order = min(max_order, HIGHEST_ORDER)
    elif found.diagrams:
        max_order = int(max(one.orders[-1] for one in found.diagrams.values()))
    others = OF_SWEEP if fitted == "windows" else OF_WINDOWS
    thresholds = [
        f"{name} {used[name]}"
        for name, one in FitOptions.declared().items()
        if one.kind in ("number", "whole", "switch") and name not in (*others, "min_order")
    ]
    preset = [] if used["preset"] is None else [f"preset {used['preset']}"]
    low, high = used["band_hz"]
    facts = {
        "Band": [f"{low:g} to {high:g} Hz"],
        "Method": [f"route {used['route']}, formulation {formulation}, estimator {used['estimator']}"],
    }
    if isinstance(signal, Recording):
        facts["Spectra"] = [_spectra(signal, found, used)]
    facts["Orders"] = [f"{used['min_order']} to {max_order}"]
    facts["Thresholds"] = [", ".join([*preset, *thresholds])]
    return facts


def _spectra(signal: Recording, found: AntiresonanceSet, used: Mapping[str, Any]) -> str:
    checked = found.data_check
    length = used["nperseg"] or (None if checked is None else checked.nperseg)
    if length is None:
        return f"method {used['method']}"
    overlap = "half" if used["noverlap"] is None else f"{used['noverlap']:,} samples"
    averages = (
        ""
        if checked is None or checked.n_averages is None
        else (f", {checked.n_averages:.1f} independent averages")
    )
    return (
        f"segments of {length:,} samples ({length / signal.fs_hz:g} s), overlap {overlap}, window "
        f"{used['window']}{averages}"
    )


def of_set(found: AntiresonanceSet | ModalSet, model: StructuralModel) -> Facts:
    """What a measured set knows of itself."""
    if not isinstance(found, AntiresonanceSet):
        return {"Modes": [f"{len(found)} with shapes at {len(found.dofs)} dofs: {_names(found.dofs)}"]}
    force = found.excitation
    facts = {
        "Force": [dof_name(model, force)],
        "Antiresonances": [", ".join(f"{len(found[dof])} at {dof_name(model, dof)}" for dof in found)],
    }
    if found.sees is not None:
        facts["Identified from"] = ["FRFs" if found.sees == "frf" else "transmissibilities"]
    how = np.concatenate(
        [np.empty(0, dtype=str), *(np.asarray(s["how"]) for s in found.scores.values() if "how" in s)]
    )
    if how.size:
        facts["Accepted"] = [
            f"{np.sum(how == 'windows')} seen by most fits over windows"
            if (how == "windows").any()
            else f"{np.sum(how == 'chain')} stable over consecutive orders, "
            f"{np.sum(how == 'persistent')} in most orders without standing still, "
            f"{np.sum(how == 'likeliest order')} from the likeliest order alone"
        ]
    if found.edits:
        facts["Edited by hand"] = [str(edit) for edit in found.edits]
    return facts | of_evidence(found)


def _not_accepted(found: AntiresonanceSet) -> Facts:
    """What was seen and left out, and peaks that nothing explains."""
    facts: Facts = {}
    for name, values in (
        ("Left out", {dof: table.freq_hz for dof, table in found.left_out.items()}),
        ("Unexplained peaks", found.unexplained_hz),
    ):
        said = [
            f"dof {dof}: " + ", ".join(f"{f:.2f}" for f in freq) + " Hz"
            for dof, freq in values.items()
            if len(freq)
        ]
        if said:
            facts[name] = said
    return facts


def of_evidence(found: AntiresonanceSet) -> Facts:
    """What was not accepted, and what a set knows only as long as it is not saved."""
    facts = _not_accepted(found)
    if found.diagrams:
        some = next(iter(found.diagrams.values()))
        facts["Diagrams"] = [
            f"orders {some.orders[0]:.0f} to {some.orders[-1]:.0f}, {some.band_hz[0]:g} to "
            f"{some.band_hz[1]:g} Hz"
        ]
    if found.data_check is not None:
        facts["Data check"] = [str(finding) for finding in found.data_check.findings] or ["nothing found"]
    if found.cross_check is not None:
        facts["Cross-check"] = [repr(found.cross_check)]
    return facts


def of_model(model: StructuralModel) -> Facts:
    """What the nominal model is made of."""
    facts = {"Model": [repr(model)]}
    if isinstance(model, MassSpringChain):
        stiffness = model.stiffness()
        springs = -np.diag(stiffness, 1)
        facts["Masses"] = [f"{_span(np.diag(model.mass()), 'kg')}, {model.mass().sum():.4g} kg in all"]
        facts["Springs"] = [_span(springs, "N/m")] if springs.size else ["none"]
        held = stiffness.sum(axis=1)[[0, -1]]
        ends = [
            f"{name} mass {k:.4g} N/m"
            for name, k in zip(("first", "last"), held, strict=True)
            if k > 1e-9 * stiffness.max()
        ]
        facts["To ground"] = ends or ["none, free at both ends"]
    elif isinstance(model, FrameModel):
        facts["Sections"] = [
            f"{model.section_label(i)}: {_section(section)}"
            for i, section in enumerate(model.sections.values())
        ]
        facts["Carried"] = [
            _count(len(model.point_masses), "point mass", "point masses"),
            _count(len(model.ground_springs), "spring to ground", "springs to ground"),
            _count(len(model.node_springs), "spring between nodes", "springs between nodes"),
        ]
        held = sorted({node for node, _ in model.fixed})
        facts["Fixed nodes"] = [_names(held) if held else "none"]
    facts["Numbers"] = ["all from 0, as in Python and in job files"]
    return facts


def of_search(result: UpdateResult) -> Facts:
    """The objective, the options of the search and where it ended."""
    problem, history = result.problem, result.history
    if isinstance(result, DamageResult) and result.has_baseline:
        return _of_assessment(result)
    penalty = problem.penalty
    price = "" if penalty is None else (f", {penalty.text}, snap {penalty.snap:g}")
    options = [
        f"{name} {', '.join(value) if isinstance(value, list) else value}"
        for name, value in result.search.options.items()
        if value is not None
    ]
    weights = "none" if problem.weights is None else _span(problem.weights, "").strip()
    count = history.cost.shape[1]
    return {
        "Ended": [f"{result.status}: {result.message}"],
        "Objective": [f"J = {result.fun:.6g}; misfit {problem.misfit}{price}, weights {weights}"],
        "Search": [f"{result.search.effort}, {count} islands", "; ".join(options)],
        "Seed": [f"{result.seed}"],
    }


def _of_assessment(result: DamageResult) -> Facts:
    """How hypotheses were judged against a baseline."""
    found = result.assessment
    threshold = (
        "damage is declared where it is more probable than none"
        if found.threshold is None
        else f"damage is declared from log odds of {found.threshold:.2f} on, for the rate of false alarms"
    )
    return {
        "Ended": [f"{result.status}: {result.message}"],
        "Model errors": [
            f"learned from the baseline: stiffnesses and masses off by {100 * found.factor_std:.2g} %, "
            f"{100 * found.root_std:.2g} % of a frequency beyond them, {100 * found.kappa:.2g} % of a change"
        ],
        "Values": [
            f"{found.n_matched} of {found.n_values} compared, reduced chi-square {found.chi_square:.2f}"
        ],
        "Rule": [threshold],
        "Seed": [f"{result.seed}"],
    }


def _names(dofs: Any) -> str:
    names = [str(dof) for dof in dofs]
    if len(names) > MOST_NAMES:
        names = [*names[: MOST_NAMES - 1], f"… {names[-1]}"]
    return ", ".join(names)


def _span(values: Any, unit: str) -> str:
    low, high = float(np.min(values)), float(np.max(values))
    return f"{len(values)} of {low:.6g}{'' if low == high else f' to {high:.6g}'} {unit}"


def _section(section: Any) -> str:
    values = ", ".join(
        f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in asdict(section).items()
        if value is not None
    )
    return f"{type(section).__name__}, {values}"


def _count(number: int, one: str, many: str) -> str:
    return f"{number or 'no'} {one if number == 1 else many}"


# -- Figures to be explored inside a page: packed, unpacked by the browser when they come into sight
#
# Each is a block of base64 of gzip, and so is the library that draws them, so that a page of many figures
# stays small, holds no address, and nothing in it can be taken for markup. Where the library is not
# installed, scripts are switched off or the page is printed, the pictures stand there instead.


#: Where the data of a figure name one of its parts.
_NAMES = ("id", "root_id")


def there() -> bool:
    """Whether figures can be made."""
    return find_spec("bokeh") is not None


def packed(figure: Callable[[], Any]) -> str:
    """A figure as it stands in a page; empty where there is none, or nothing that makes it."""
    made = figure() if there() else None
    return "" if made is None else _packed(_with_own_names(item(made)))


def _with_own_names(figure: dict[str, Any]) -> str:
    """A figure whose parts are named by their order and what it shows, not by how many were made before.

    So the same report is the same bytes, and no two figures of a page share a name.
    """
    names: dict[str, str] = {}
    counted = _renamed(figure, lambda name: names.setdefault(name, f"p{len(names)}"))
    mark = sha256(_text(counted).encode("utf-8")).hexdigest()[:8]
    return _text(_renamed(counted, lambda name: f"{mark}{name}"))


def _renamed(part: Any, name: Callable[[str], str]) -> Any:
    if isinstance(part, list | tuple):
        return [_renamed(each, name) for each in part]
    if not isinstance(part, dict):
        return part
    return {
        key: name(value) if key in _NAMES and isinstance(value, str) else _renamed(value, name)
        for key, value in part.items()
    }


def _text(figure: Any) -> str:
    return json.dumps(figure, separators=(",", ":"))


@cache
def library() -> str:
    """What draws the figures; empty where it is not installed."""
    return _packed(_drawer()) if there() else ""


def policy() -> str:
    """What a browser lets the page do: run these two scripts, and load nothing."""
    own = "'none'"
    if there():
        digests = [sha256(text.encode("utf-8")).digest() for text in (script(), _drawer())]
        own = " ".join(f"'sha256-{b64encode(each).decode('ascii')}'" for each in digests)
    return (
        f"default-src 'none'; script-src {own}; style-src 'unsafe-inline'; "
        "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'"
    )


def _drawer() -> str:
    return "\n".join(file.read_text(encoding="utf-8") for file in script_files())


@cache
def script() -> str:
    """What unpacks the figures."""
    return files(__package__).joinpath("assets", "live.js").read_text(encoding="utf-8")


def _packed(text: str) -> str:
    # Without a time the same figure is the same bytes.
    return b64encode(gzip.compress(text.encode("utf-8"), 9, mtime=0)).decode("ascii")


# -- The pictures of a result, each drawn once, with the sentences that stand under it and in place of it


#: Colours kept: lines and their soft edges need no more, and a third of the bytes is left.
COLOURS_KEPT = 128
#: Pictures and figures together, so that a report stays below 3 MB: diagrams beyond are left out.
MOST_BYTES = 2_750_000

Draw = Callable[..., Any]


@dataclass(frozen=True)
class Figure:
    """One picture, drawn when first asked for; what stands under it, and what is read out in its place."""

    draw: Draw
    size_in: tuple[float, float]
    caption: str
    alt: str
    explore: Callable[[], Any] | None = None

    @cached_property
    def live(self) -> str:
        """As a figure to be explored, packed; empty where there is none, or nothing that makes it."""
        return packed(self.explore) if self.explore is not None else ""

    @cached_property
    def png(self) -> bytes:
        """As a file of its own."""
        return picture(lambda ax: self.draw(ax=ax), self.size_in)

    @cached_property
    def uri(self) -> str:
        """As it stands in a page, in few colours."""
        return "data:image/png;base64," + b64encode(_small(self.png)).decode("ascii")


@dataclass(frozen=True)
class Drawings:
    """All pictures of a result: by name, and the stabilization diagrams by that of their response."""

    figures: Mapping[str, Figure]
    diagrams: Mapping[Any, Figure]


def drawings_of(
    result: UpdateResult,
    response: FrequencyResponse | None = None,
    truth: Mapping[int, float] | None = None,
    diagrams: Mapping[Any, StabilizationDiagram] | None = None,
) -> Drawings:
    """Pictures of a result; ``diagrams`` are by default those that its measured sets carry."""
    modal = result.problem.objective == "modal"
    shown = _carried(result) if diagrams is None else diagrams
    live = cache(partial(result_figures, result, response, truth))
    figures = _figures(result, response, truth)
    return Drawings(
        {name: replace(one, explore=partial(_one_of, live, name)) for name, one in figures.items()},
        {name: _diagram(name, diagram, modal) for name, diagram in shown.items()},
    )


def _one_of(live: Callable[[], dict[str, Any]], name: str) -> Any:
    return live().get(name)


def fitting(drawn: Drawings, room: int = MOST_BYTES) -> tuple[list[tuple[Figure, str]], int]:
    """Diagrams for which a page has room, each with its packed figure, and how many were left out.

    What is no diagram comes first; pictures of all come before figures to be explored.
    """
    room -= len(library()) + sum(len(one.uri) + len(one.live) for one in drawn.figures.values())
    kept: list[Figure] = []
    for one in drawn.diagrams.values():
        room -= len(one.uri)
        if room < 0:
            break
        kept.append(one)
    shown = []
    for one in kept:
        fits = room > 0 and len(one.live) <= room
        room -= len(one.live) if fits else 0
        shown.append((one, one.live if fits else ""))
    return shown, len(drawn.diagrams) - len(kept)


def _carried(result: UpdateResult) -> dict[Any, StabilizationDiagram]:
    """Diagrams that the measured sets carry, by the name of the response."""
    problem = result.problem
    sets = problem.measured
    if problem.objective == "modal":
        return {i: each.diagram for i, each in enumerate(sets) if each.diagram is not None}
    return named_diagrams([each.diagrams for each in sets], [each.excitation for each in sets], problem.model)


def _figures(
    result: UpdateResult, response: FrequencyResponse | None, truth: Mapping[int, float] | None
) -> dict[str, Figure]:
    """All pictures but the diagrams, by name."""
    problem, names = result.problem, states(result)
    what = "resonance" if problem.objective == "modal" else "antiresonance"
    figures: dict[str, Figure] = {}
    if isinstance(result, DamageResult):
        figures |= _damage(result, truth)
    drawn = _model_picture(result)
    if drawn is not None:
        figures["model"] = Figure(*drawn)
    table = result.table
    figures["differences"] = Figure(
        lambda ax: plot_differences(table, ax=ax, names=names),
        (9.5, 4.6),
        f"Difference of each {what} to the measured one, {names[0]} and {names[1]}.",
        f"Bar chart of {table.measured_hz.size} differences, given in the table above: the largest is "
        f"{largest(table.largest_before_percent)} {names[0]} and {largest(table.largest_after_percent)} "
        f"{names[1]}",
    )
    if response is not None:
        figures["response"] = _response(result, response, names)
    history = result.history
    if history.cost.size:  # nothing is searched against a baseline
        figures["convergence"] = Figure(
            partial(plot_convergence, result),
            (9.0, 4.2),
            "The search: best objective of each island.",
            f"Curves by evaluations of the best objective of {history.cost.shape[1]} islands, from "
            f"{history.cost[0].min():.4g} to {history.cost[-1].min():.4g}",
        )
    return figures


def _response(result: UpdateResult, response: FrequencyResponse, names: tuple[str, str]) -> Figure:
    """Measured curves beside those of the models."""
    model, force = result.problem.model, result.problem.measured[0].excitation
    if response.kind == "frf":
        dofs = [dof for dof in response.dofs if dof in result.problem.measured[0]] or list(response.dofs)
        shown = dofs[:MOST_RESPONSES]
        some = "" if len(shown) == len(response.dofs) else f"The first {len(shown)}. "
        return Figure(
            lambda ax: plot_responses(
                response, model, result.model, excitation=force, dofs=shown, ax=ax, names=names
            ),
            (9.0, 2.0 + 1.2 * len(shown)),
            f"FRFs of the responses; the dips are their antiresonances. {some}The depth of the dips in the "
            "models follows from an assumed damping of 1 %.",
            f"Curves by frequency of {len(shown)} FRFs: measured, and of the model {names[0]} and {names[1]}",
        )
    over = dof_name(model, response.reference)
    return Figure(
        lambda ax: plot_transmissibility(
            response, model, result.model, dof=None, excitation=force, ax=ax, names=names
        ),
        (9.0, 4.4),
        f"Transmissibilities over {over}, summed; the peaks are the antiresonances of that dof. Their "
        "height in the models follows from an assumed damping of 1 %.",
        f"Curves by frequency of the transmissibilities over {over}: measured, and of the model "
        f"{names[0]} and {names[1]}",
    )


def _damage(result: DamageResult, truth: Mapping[int, float] | None) -> dict[str, Figure]:
    """Losses by element, and where they were judged the hypotheses."""
    label, judged = result.problem.model.element_label, result.has_baseline
    width = max(7.0, 0.32 * len(result.x) + 1.5)
    more = ", with 90 % intervals; above, the probability of each; empty bars, what may have it instead"
    losses = ", ".join(f"{label(e)} {100 * result.severity[e]:.1f} %" for e in result.damaged)
    figures = {
        "damage": Figure(
            partial(plot_damage, result, truth=truth),
            (width, 4.7 if judged else 4.4),
            f"Stiffness loss by element{more if judged else ''}. Ticks: the smallest that would be seen.",
            "Bar chart: " + (losses or "no damage in any element"),
        )
    }
    if judged:
        hypotheses = without_idle(result.assessment).hypotheses
        rows = min(len(hypotheses), 9)
        figures["hypotheses"] = Figure(
            partial(plot_hypotheses, hypotheses),
            (8.0, 1.3 + 0.5 * rows),
            "Probabilities of what may explain the measurement, with losses and their 90 % intervals.",
            "Bar chart of the table above",
        )
    return figures


def _diagram(name: Any, diagram: StabilizationDiagram, modal: bool) -> Figure:
    of = "all responses" if modal or name is None else f"dof {name}" if isinstance(name, int) else str(name)
    found = ", ".join(f"{f:.2f}" for f in diagram.identified)
    return Figure(
        diagram.plot,
        (9.0, 5.0),
        f"Stabilization diagram of {of}: poles of rational fits of rising order; those that stay are "
        f"{'the resonances' if modal else 'its antiresonances'}.",
        f"Stabilization diagram of {of}, {diagram.band_hz[0]:g} to {diagram.band_hz[1]:g} Hz: "
        + (f"accepted at {found} Hz" if found else "no antiresonance accepted"),
        partial(stabilization_figure, diagram, dof=name),
    )


def _model_picture(result: UpdateResult) -> tuple[Draw, tuple[float, float], str, str] | None:
    """How to draw the model, its size, caption and alternative; None for matrices, which have no shape."""
    problem, model = result.problem, result.problem.model
    first = problem.measured[0]
    at: dict[str, Any] = {}
    if isinstance(first, AntiresonanceSet):
        at = {"sensors": list(first), "excitation": first.excitation}
    loss = None
    said = "sensors as arrows, the force as a heavier one"
    caption = f"The model; {said}." if at else "The model."
    if isinstance(result, DamageResult):
        loss = {e: 100.0 * beta for e, beta in result.severity.items()}
        at |= {"label": "Stiffness loss (%)"}
        caption = "The model with the stiffness losses found" + (f"; {said}." if "sensors" in at else ".")
    if isinstance(model, MassSpringChain):
        return (
            partial(_drawn, plot_chain, model, loss, at),
            (9.0, 2.9),
            caption,
            f"Drawing of a chain of {model.n_dof} masses",
        )
    if isinstance(model, FrameModel):
        beams = None if loss is None else {e: v for e, v in loss.items() if e < len(model.elements)}
        points = np.ptp(model.nodes_m, axis=0)
        height = 6.5 if points[1:].max() > 0.6 * points[0] else 4.6
        return (
            partial(_drawn, plot_frame, model, beams, at),
            (9.0, height),
            f"{caption} Numbers upright are of elements, slanted ones of nodes.",
            f"Drawing of a frame of {len(model.elements)} elements",
        )
    return None


def _drawn(plot: Any, model: Any, loss: Any, at: dict[str, Any], ax: Any) -> Any:
    return plot(model, loss, ax, **at)


def states(result: UpdateResult) -> tuple[str, str]:
    """What the model is called before and after."""
    return (
        ("without damage", "with the damage found")
        if isinstance(result, DamageResult)
        else ("before updating", "after updating")
    )


def largest(percent: float) -> str:
    """The largest difference in words."""
    return f"{percent:.2f} %" if np.isfinite(percent) else "no partner at all"


def _small(png: bytes) -> bytes:
    """The same picture in few colours."""
    from PIL import Image  # matplotlib writes PNG with it, so it is there

    few = Image.open(BytesIO(png)).convert("RGB").quantize(COLOURS_KEPT, dither=Image.Dither.NONE)
    file = BytesIO()
    few.save(file, "PNG", optimize=True)
    return file.getvalue()


# -- The tables of a report, cell by cell


#: Hypotheses that have a row in any case, those above this probability, and how many at most.
_LEAST_ROWS, _WORTH_A_ROW, _MOST_ROWS = 3, 0.005, 12


def parameter_rows(result: UpdateResult) -> list[dict[str, Any]]:
    """Value, standard deviation, change and bounds of each parameter."""
    on_bound = set(result.at_bound)
    columns = zip(
        result.problem.names, result.x, result.std, result.problem.nominal, result.problem.bounds, strict=True
    )
    return [
        {
            "name": name,
            "value": f"{value:#.5g}",
            "std": _deviation(std),
            "change": f"{100 * (value / nominal - 1):+.2f}" if nominal else "",
            "nominal": f"{nominal:.5g}",
            "bounds": f"{low:g} to {high:g}",
            "on_bound": name in on_bound,
        }
        for name, value, std, nominal, (low, high) in columns
    ]


def damage_rows(result: DamageResult, truth: Mapping[int, float] | None) -> list[dict[str, Any]]:
    """Loss, standard deviation, truth, smallest visible and bounds of each candidate, in percent."""

    def percent(value: float | None) -> str:
        if value is None:
            return ""
        return (
            "none"
            if not np.isfinite(value)
            else "0"
            if value == 0.0
            else f"{100 * value:.{1 if value >= 9.5e-4 else 2}f}"
        )

    label, judged = result.problem.model.element_label, result.has_baseline
    on_bound = set() if judged else set(result.at_bound)
    chance, limits = (result.probability, result.interval) if judged else ({}, {})
    instead = _instead(result) if judged else {}
    columns = zip(result.elements, result.problem.names, result.std, result.problem.bounds, strict=True)
    rows = [
        {
            "name": label(e),
            "value": f"or {percent(instead[e][0])}" if e in instead else percent(result.severity[e]),
            "std": _deviation(100.0 * std) if result.severity[e] > 0.0 else "",
            "interval": _interval(*instead[e][1:] if e in instead else limits.get(e, (0.0, 0.0))),
            "probability": _probability(chance.get(e, 0.0)),
            "visible": percent(result.detectable[e]),
            "truth": percent((truth or {}).get(e)),
            "bounds": f"{100 * low:g} to {100 * high:g}",
            "damaged": result.severity[e] > 0.0 or e in instead,
            "on_bound": name in on_bound,
        }
        for e, name, std, (low, high) in columns
    ]
    # Elements that were no candidates, and would explain the change.
    others = [one for one in result.hypotheses if one.elements and not one.candidate] if judged else []
    return rows + [
        {
            "name": f"{label(one.elements[0])}, no candidate",
            "value": percent(one.severities[0]),
            "std": "",
            "interval": _interval(one.low[0], one.high[0]),
            "probability": _probability(one.probability),
            "visible": "",
            "truth": percent((truth or {}).get(one.elements[0])),
            "bounds": "",
            "damaged": one is result.hypotheses[0],
            "on_bound": False,
        }
        for one in others
        if not one.unknown and one.probability >= _WORTH_A_ROW
    ]


def _instead(result: DamageResult) -> dict[int, tuple[float, float, float]]:
    """Loss and interval of single elements that the values cannot tell from the one declared damaged."""
    found = result.assessment
    alike = found.group if found.declared in [one.elements for one in found.group] else ()
    return {
        one.elements[0]: (one.severities[0], one.low[0], one.high[0])
        for one in alike
        if len(one.elements) == 1 == len(found.declared) and one.elements != found.declared
    }


def hypothesis_rows(found: Assessment) -> tuple[list[dict[str, Any]], str]:
    """Probability, name and losses of the hypotheses worth a row, and a sentence on the others.

    The first is the answer, and so are those of its group, which the values cannot tell from it.
    """
    hypotheses, alike = found.hypotheses, found.group
    answer = alike if hypotheses[0] in alike else hypotheses[:1]
    rows = [
        {
            "name": hypotheses.called(one),
            "probability": _probability(one.probability),
            "hit": one in answer,
            "losses": ", ".join(
                loss(s, low, high) for s, low, high in zip(one.severities, one.low, one.high, strict=True)
            ),
        }
        for nth, one in enumerate(hypotheses)
        if nth < _LEAST_ROWS or (one.probability >= _WORTH_A_ROW and nth < _MOST_ROWS)
    ]
    others = len(hypotheses) - len(rows)
    rest = float(np.sum(hypotheses.probability[len(rows) :]))
    return rows, f"{others} others, together {_probability(rest)} %." if others else ""


def frequency_rows(result: UpdateResult) -> list[dict[str, Any]]:
    """Each measured value with the model's before and after; the response is named once."""
    table: Any = result.table

    def number(value: float, form: str) -> str:
        if not np.isfinite(value):
            return "no partner"
        return format(value, form) if form else signed(value)

    rows: list[dict[str, Any]] = [
        {
            "group": False,
            "measured": f"{measured:.3f}",
            "before": number(before, ".3f"),
            "before_percent": number(db, ""),
            "after": number(after, ".3f"),
            "after_percent": number(da, ""),
        }
        for measured, before, db, after, da in zip(
            table.measured_hz,
            table.before_hz,
            table.before_percent,
            table.after_hz,
            table.after_percent,
            strict=True,
        )
    ]
    if isinstance(table, ModalTable):
        columns = zip(table.mode, table.before_mac, table.after_mac, strict=True)
        for row, (mode, before, after) in zip(rows, columns, strict=True):
            row.update(
                mode=mode,
                group=mode == table.mode[0],
                before_mac=number(before, ".3f"),
                after_mac=number(after, ".3f"),
            )
        return rows
    last = None
    for row, dof, force in zip(rows, table.dof.tolist(), table.excitation.tolist(), strict=True):
        row.update(
            group=(dof, force) != last,
            dof=table.dof_names.get(dof, dof),
            force=table.dof_names.get(force, force),
        )
        last = (dof, force)
    return rows


def _interval(low: float, high: float) -> str:
    return span(low, high) if high > 0.0 else ""


def _probability(p: float) -> str:
    """In percent; what is nearly 0 or 100 is not rounded to it."""
    return "< 0.1" if p < 0.001 else "> 99.9" if p > 0.999 else f"{100 * p:.1f}"


def _deviation(value: float) -> str:
    return f"{value:.2g}" if np.isfinite(value) else "not determined" if np.isinf(value) else ""
