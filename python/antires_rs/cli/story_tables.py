"""The tables and the numbers of ``antires demo``: what was found beside what is true."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import fill
from typing import Any

import numpy as np

from .._core import __version__
from ..cases.chain8 import DURATION_S, FS_HZ
from ..damage.result import DamageResult
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import FloatArray
from ..updating.results import UpdateResult
from .story import PERTURBATION, Story

__all__ = ["compare", "summary", "text"]

#: A found value this close to a true one is that one.
MATCH = 0.02


@dataclass(frozen=True)
class Match:
    """Found against true antiresonances of one response."""

    dof: int
    true: int
    found: int
    false: int
    largest_percent: float | None


def compare(found: AntiresonanceSet, truth: dict[int, FloatArray]) -> list[Match]:
    """Pair found with true values one to one, nearest first, within 2 %."""
    matches = []
    for dof, true_hz in truth.items():
        error = np.abs(found[dof][:, None] / true_hz - 1.0)
        pairs = []
        while error.size and error.min() <= MATCH:
            i, k = divmod(int(np.argmin(error)), error.shape[1])
            pairs.append(100.0 * float(error[i, k]))
            error[i, :], error[:, k] = np.inf, np.inf
        matches.append(
            Match(dof, len(true_hz), len(pairs), len(found[dof]) - len(pairs), max(pairs, default=None))
        )
    return matches


def text(story: Story) -> str:
    """The story's tables."""
    severity = story.case.truth(1)["severity"]
    label = story.case.model.element_label
    updated = story.updated
    lines = [
        f"An eight-mass chain, masses and springs up to {100 * PERTURBATION:g} % off the model "
        f"(seed {story.seed})",
        "numbers count from 0: dof 0 is mass 0, spring 4 (the paper's fifth) joins masses 4 and 5.",
        "",
        "1. Undamaged: antiresonances from the responses alone",
        f"   {DURATION_S:g} s at {FS_HZ:g} Hz, eight accelerometers, {100 * story.noise:g} % sensor noise; "
        "the force at dof 0 is not used.",
        _matches(story.undamaged, story.case.truth(0)["freq_hz"]),
        "",
        "2. Updating: eight masses and seven springs within +-10 %",
        f"   {updated.nfev:,} evaluations in {story.seconds['updating']:.1f} s, J = {updated.fun:.4f}, "
        f"status {updated.status!r}",
        "   (a short budget, for the demo; the default of 200,000 comes closer).",
        *(fill(note, 100, initial_indent="   note: ", subsequent_indent=9 * " ") for note in updated.notes),
        "",
        str(updated.table),
        "",
        "3. Damaged: recorded and identified again, searched with the updated model",
        _matches(story.damaged, story.case.truth(1)["freq_hz"]),
        "",
        "   stiffness loss in %     found    truth    smallest    found without    against the undamaged",
        "                                              visible     the updating    record, no updating",
    ]
    lines += [
        f"   {label(e):<20} {_percent(story.damage.severity[e]):>8} {_percent(severity[e]):>8}"
        f" {_percent(story.damage.detectable[e]):>11} {_percent(story.damage_nominal.severity[e]):>16}"
        f" {_percent(story.damage_baseline.severity[e]):>22}"
        for e in story.damage.elements
    ]
    lines += ["", "   Against the undamaged record:"]
    lines += [fill(story.damage_baseline.headline, 100, initial_indent="   ", subsequent_indent="   ")]
    return "\n".join(lines)


def _matches(found: AntiresonanceSet, truth: dict[int, FloatArray]) -> str:
    rows = ["   response   true  found  false   largest error"]
    matches = compare(found, truth)
    for m in matches:
        error = "-" if m.largest_percent is None else f"{m.largest_percent:.2f} %"
        rows.append(f"   dof {m.dof:<6} {m.true:5d} {m.found:6d} {m.false:6d} {error:>15}")
    largest = max((m.largest_percent for m in matches if m.largest_percent is not None), default=float("nan"))
    rows.append(
        f"   in all     {sum(m.true for m in matches):5d} {sum(m.found for m in matches):6d} "
        f"{sum(m.false for m in matches):6d} {largest:13.2f} %"
    )
    return "\n".join(rows)


def _percent(value: float) -> str:
    return "0" if value == 0.0 else f"{100 * value:.1f}" if np.isfinite(value) else "none"


def summary(story: Story) -> dict[str, Any]:
    """The story's numbers, ready for JSON; null where there is none."""
    severity = story.case.truth(1)["severity"]
    label = story.case.model.element_label

    def number(value: float) -> float | None:
        return value if np.isfinite(value) else None

    def identified(found: AntiresonanceSet, level: int) -> list[dict[str, Any]]:
        truth = story.case.truth(level)["freq_hz"]
        return [
            {
                "dof": m.dof,
                "true": m.true,
                "found": m.found,
                "false": m.false,
                "largest_error_percent": m.largest_percent,
                "freq_hz": found[m.dof].tolist(),
                "true_freq_hz": truth[m.dof].tolist(),
            }
            for m in compare(found, truth)
        ]

    def searched(result: UpdateResult) -> dict[str, Any]:
        return {
            "status": result.status,
            "evaluations": result.nfev,
            "generations": result.nit,
            "J": result.fun,
            "largest_before_percent": number(result.table.largest_before_percent),
            "largest_after_percent": number(result.table.largest_after_percent),
            "notes": result.notes,
        }

    def losses(result: DamageResult) -> dict[str, float]:
        return {label(e): beta for e, beta in result.severity.items()}

    return {
        "antires_rs": __version__,
        "seed": story.seed,
        "noise": story.noise,
        "seconds": story.seconds,
        "identification": identified(story.undamaged, 0),
        "updating": searched(story.updated)
        | {"parameters": dict(zip(story.updated.problem.names, story.updated.x.tolist(), strict=True))},
        "identification_damaged": identified(story.damaged, 1),
        "damage": searched(story.damage)
        | {
            "severity": losses(story.damage),
            "truth": {label(e): beta for e, beta in severity.items()},
            "smallest_visible": {label(e): number(beta) for e, beta in story.damage.detectable.items()},
            "severity_without_updating": losses(story.damage_nominal),
            "against_baseline": {
                "headline": story.damage_baseline.headline,
                "severity": losses(story.damage_baseline),
                "probability": {label(e): p for e, p in story.damage_baseline.probability.items()},
                "probability_of_damage": story.damage_baseline.probability_of_damage,
            },
        },
    }
