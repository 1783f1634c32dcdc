"""The page of a result: what its report tells, to be explored."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..damage.result import DamageResult
from ..explore.page.result_view import Drawn, ResultView, Table
from ..jobs.drawing import drawings, evidence_in
from ..jobs.files import RunFolder
from ..report.figures import largest, states
from ..report.rows import damage_rows, frequency_rows, hypothesis_rows, parameter_rows
from ..updating.results import UpdateResult
from .measurement import NAMES
from .terminal import arguments

__all__ = ["result_view"]


def result_view(file: Path) -> ResultView:
    """The view of a saved result."""
    with arguments(NAMES):
        result = UpdateResult.load(file)
    drawn = drawings(result, evidence_in(RunFolder(file.parent), result))
    figures = [
        Drawn(one.explore, one.caption)
        for one in (*drawn.figures.values(), *drawn.diagrams.values())
        if one.explore is not None
    ]
    return ResultView(file.parent.resolve().name, _answer(result), figures, _tables(result))


def _answer(result: UpdateResult) -> list[str]:
    if isinstance(result, DamageResult):
        return list(result._headline())
    before, after = result.table.largest_before_percent, result.table.largest_after_percent
    return [f"Largest difference: {largest(before)} before, {largest(after)} after."]


def _tables(result: UpdateResult) -> list[Table]:
    tables = []
    if isinstance(result, DamageResult):
        judged = result.has_baseline
        columns = {"name": "Element", "value": "Loss, %"}
        columns |= (
            {"interval": "90 % interval, %", "probability": "Probability, %"}
            if judged
            else {"std": "Error, %"}
        )
        tables.append(
            _table("Stiffness losses", columns | {"visible": "Smallest seen, %"}, damage_rows(result, None))
        )
        found = result.assessment
        if found is not None:
            rows, others = hypothesis_rows(found)
            heads = {"name": "Hypothesis", "probability": "Probability, %", "losses": "Losses"}
            tables.append(_table(f"Hypotheses{f'; {others}' if others else ''}", heads, rows))
    else:
        heads = {"name": "Parameter", "value": "Value", "std": "Error", "change": "Change, %"}
        tables.append(_table("Parameters", heads, parameter_rows(result)))
    first, second = states(result)
    modal = "mode" in (frequency_rows(result) or [{}])[0]
    named = {"mode": "Mode"} if modal else {"dof": "Response", "force": "Force"}
    heads = named | {
        "measured": "Measured, Hz",
        "before": f"{first.capitalize()}, Hz",
        "before_percent": "Difference, %",
        "after": f"{second.capitalize()}, Hz",
        "after_percent": "Difference, %",
    }
    tables.append(_table("Resonances" if modal else "Antiresonances", heads, frequency_rows(result)))
    return tables


def _table(title: str, columns: dict[str, str], rows: list[dict[str, Any]]) -> Table:
    return Table(title, tuple(columns.values()), [[str(row.get(key, "")) for key in columns] for row in rows])
