"""What a report says in words: the signals, how they were identified, the model, the search."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.result import DamageResult
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.structural_model import StructuralModel
from ..order_sweep.presets import rule_options
from ..signals.frequency_response import FrequencyResponse
from ..signals.pooled import parts_of
from ..signals.recording import Recording

if TYPE_CHECKING:
    from ..measured.modal_set import ModalSet
    from ..updating.results import UpdateResult

__all__ = [
    "Facts",
    "dof_name",
    "named_diagrams",
    "of_evidence",
    "of_identification",
    "of_model",
    "of_search",
    "of_set",
    "of_signal",
]

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


def of_identification(
    signal: Recording | FrequencyResponse, found: AntiresonanceSet, band_hz: Any, options: Mapping[str, Any]
) -> Facts:
    """Every choice of an identification, defaults among them; ``options`` are those that were given."""
    from ..identification.identify import identify_antiresonances
    from ..identification.local.fit import HIGHEST_ORDER
    from ..identification.scope import OF_SWEEP, OF_WINDOWS

    known = inspect.signature(identify_antiresonances).parameters
    used = {name: given.default for name, given in known.items() if given.default is not given.empty}
    used |= options
    rule = rule_options(
        used["preset"],
        **{
            name: used[name]
            for name in (
                "formulation",
                "max_order",
                "freq_tol",
                "damping_tol",
                "min_rows",
                "max_damping",
                "min_dominance",
                "min_share",
                "min_depth_db",
                "persistent",
            )
        },
    )
    formulation, max_order = rule.pop("formulation"), rule.pop("max_order")
    chosen = formulation
    if formulation == "auto":
        # Only two fits are graded, see order_sweep.scores; those over windows know shares.
        every = set().union(*(scores for scores in found.scores.values()))
        chosen = "windows" if "share" in every else "numerators" if "grade" in every else "joint"
        formulation = f"auto, here {chosen}"
    if chosen == "windows":
        max_order = min(max_order, HIGHEST_ORDER)
    elif found.diagrams:
        max_order = int(max(one.orders[-1] for one in found.diagrams.values()))
    for name in OF_SWEEP if chosen == "windows" else OF_WINDOWS:
        del rule[name]
    thresholds = [f"{name} {value}" for name, value in rule.items()]
    preset = [] if used["preset"] is None else [f"preset {used['preset']}"]
    low, high = band_hz
    facts = {
        "Band": [f"{low:g} to {high:g} Hz"],
        "Method": [f"route {used['route']}, formulation {formulation}, estimator {used['estimator']}"],
    }
    if isinstance(signal, Recording):
        facts["Spectra"] = [_spectra(signal, found, used)]
    facts["Orders"] = [f"{used['min_order']} to {max_order}"]
    facts["Thresholds"] = [", ".join([*preset, *thresholds, f"keep_common {used['keep_common']}"])]
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
    price = (
        ""
        if penalty is None
        else (f", gamma1 {penalty.gamma1:.3g}, gamma2 {penalty.gamma2:.3g}, snap {penalty.snap:g}")
    )
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
        else f"damage is declared from log odds of {found.threshold:.2f} on, for the false_alarm_rate given"
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
