"""The tables of a report, cell by cell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..damage.assessment import Assessment
from ..damage.percent import loss, span
from ..damage.result import DamageResult
from ..updating.results import UpdateResult
from ..updating.tables import ModalTable, signed

__all__ = ["damage_rows", "frequency_rows", "hypothesis_rows", "parameter_rows"]

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
