"""A run in numbers, ready for JSON, and in words for the terminal."""

from __future__ import annotations

import math
from typing import Any

from ..damage.result import DamageResult
from ..updating.results import UpdateResult
from ..updating.tables import FrequencyTable
from .job import Job
from .measured import Measured

__all__ = ["summary_of", "text_of"]


#: Hypotheses below this probability are left out.
_LEAST = 1e-6


def number(value: Any) -> float | None:
    """A number as JSON knows it; None where there is none."""
    plain = float(value)
    return plain if math.isfinite(plain) else None


def summary_of(
    job: Job, result: UpdateResult, record: dict[str, Any], measured: list[Measured], seconds: float
) -> dict[str, Any]:
    """All numbers of a run, and what repeats it.

    What the data cannot tell takes seconds on a large model, so it is left out, as null, after Ctrl-C.
    """
    table = result.table
    at_once = result.status == "interrupted" and not _judged(result)
    checks = [m.found.data_check for m in measured if m.found.data_check is not None]
    return {
        "antires_rs": record["versions"]["antires_rs"],
        "task": job.task,
        "job": job.path.name,
        "command": f"antires {job.task} {job.path.name}",
        "seed": result.seed,
        "inputs": record["inputs"],
        "versions": record["versions"],
        "seconds": seconds,
        "status": result.status,
        "message": result.message,
        "finished": result.success,
        "J": number(result.fun),
        "evaluations": result.nfev,
        "linearizations": result.njev,
        "generations": result.nit,
        "exchanges": result.migrations,
        **_values(result, at_once),
        # As in Python: "dof", "element" and the numbers in names count from 0.
        "counted_from": 0,
        "largest_before_percent": number(table.largest_before_percent),
        "largest_after_percent": number(table.largest_after_percent),
        "antiresonances": _rows(table) if isinstance(table, FrequencyTable) else [],
        # Those of the data check have been raised as one.
        "warnings": [
            *(said for check in checks for said in check.warnings),
            *(said for said in record["warnings"] if not said.startswith("data check: ")),
        ],
        "notes": [] if at_once else result.notes,
    }


def text_of(result: UpdateResult) -> str:
    """A run in words; after Ctrl-C without the notes that take time."""
    if result.status != "interrupted" or _judged(result):
        return result.summary()
    head = f"J = {result.fun:.6g} after {result.nfev:,} evaluations: interrupted, the best so far"
    width = max(map(len, result.problem.names))
    loss = isinstance(result, DamageResult)
    values = [
        f"{name:<{width}}  {f'{100 * value:6.2f} %' if loss else f'{value:#12.6g}'}"
        for name, value in zip(result.problem.names, result.x, strict=True)
        if value != 0.0 or not loss
    ]
    return "\n".join([head, "", *values, "", str(result.table)])


def _judged(result: UpdateResult) -> bool:
    """Whether hypotheses were judged against a baseline, so that nothing takes time any more."""
    return isinstance(result, DamageResult) and result.has_baseline


def _values(result: UpdateResult, at_once: bool) -> dict[str, Any]:
    std = [None] * len(result.x) if at_once else [number(value) for value in result.std]
    if isinstance(result, DamageResult):
        label = result.problem.model.element_label
        judged = result.has_baseline
        chance = result.probability if judged else {}
        limits = result.interval if judged else {}
        seen = {} if at_once else result.detectable
        return {
            **_hypotheses(result, judged),
            "damaged": result.damaged,
            "elements": [
                {
                    "element": e,
                    "name": label(e),
                    "stiffness_loss": number(beta),
                    "std": own,
                    "probability": chance.get(e),
                    "low_90": limits.get(e, (None, None))[0],
                    "high_90": limits.get(e, (None, None))[1],
                    "smallest_visible": number(seen.get(e, math.nan)),
                }
                for (e, beta), own in zip(result.severity.items(), std, strict=True)
            ],
        }
    on_bound = None if at_once else set(result.at_bound)
    columns = zip(
        result.problem.names, result.x, result.problem.nominal, std, result.problem.bounds, strict=True
    )
    return {
        "parameters": [
            {
                "name": name,
                "value": number(value),
                "nominal": number(nominal),
                "std": own,
                "low": number(low),
                "high": number(high),
                "on_bound": None if on_bound is None else name in on_bound,
            }
            for name, value, nominal, own, (low, high) in columns
        ]
    }


def _hypotheses(result: DamageResult, judged: bool) -> dict[str, Any]:
    """What was judged against a baseline; null without one."""
    found = result.hypotheses if judged else None
    return {
        "headline": result.headline if judged else None,
        "probability_of_damage": number(result.probability_of_damage) if judged else None,
        "probability_elsewhere": number(result.probability_elsewhere) if judged else None,
        "chi_square": number(result.chi_square) if judged else None,
        "hypotheses": None
        if found is None
        else [
            {
                "name": found.called(one),
                "elements": list(one.elements),
                "probability": one.probability,
                "stiffness_loss": list(one.severities),
                "low_90": list(one.low),
                "high_90": list(one.high),
                "candidate": one.candidate,
            }
            for one in found
            if one.probability >= _LEAST
        ],
    }


def _rows(table: FrequencyTable) -> list[dict[str, Any]]:
    columns = zip(
        table.excitation, table.dof, table.measured_hz, table.before_hz, table.after_hz, strict=True
    )
    return [
        {
            "excitation": int(force),
            "dof": int(dof),
            "measured_hz": number(measured),
            "before_hz": number(before),
            "after_hz": number(after),
        }
        for force, dof, measured, before, after in columns
    ]
