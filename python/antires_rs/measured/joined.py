r"""One response seen by several setups: the mean of its values, and whether they agree.

Values f_i with variances v_i are joined to sum(f_i / v_i) / sum(1 / v_i), of variance 1 / sum(1 / v_i) times
max(1, chi^2 / (n - 1)) with chi^2 = sum (f_i - mean)^2 / v_i (R. T. Birge, Phys. Rev. 40 (1932) 207-227).

Whether a setup agrees is asked of each in turn, its values against the means of the others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..order_sweep.table import ResponseTable
from ..support.validation import FloatArray
from .matching import paired, variance_hz
from .significance import averages_of, of_all, of_each

__all__ = ["Disagreement", "disagreements", "joined"]


@dataclass(frozen=True)
class Disagreement:
    """A setup, counted from 0, that does not agree with the others, and what is said of it."""

    setup: int
    p: float
    text: str


def joined(tables: Sequence[ResponseTable], shift: float, between: float) -> ResponseTable:
    """The values that at least half of the tables have, each the mean of its own."""
    groups = _groups(tables, shift, between)
    kept = [group for group in groups if 2 * len(group) >= len(tables)]
    rows, freq, std = [], [], []
    for group in kept:
        values = np.array([tables[i].freq_hz[row] for i, row in group])
        variances = np.array([variance_hz(tables[i], between)[row] for i, row in group])
        mean, deviation = _mean(values, variances)
        best = int(np.argmin(np.where(np.isnan(variances), np.inf, variances)))
        table, row = group[best]
        rows.append(tables[table].take([row]))
        freq.append(mean)
        std.append(deviation)
    if not rows:
        return tables[0].take([])
    names = set.intersection(*(set(one.scores) for one in rows))
    one = ResponseTable.concatenated(
        [replace(row, scores={name: row.scores[name] for name in sorted(names)}) for row in rows]
    )
    # Concatenation sorts by the single values; the means may stand in another order.
    order = np.argsort([float(row.freq_hz[0]) for row in rows], kind="stable")
    return replace(one, freq_hz=np.array(freq)[order], std_hz=np.array(std)[order])


def disagreements(
    common: Mapping[Any, Mapping[int, ResponseTable]], count: int, shift: float, between: float, alpha: float
) -> list[Disagreement]:
    """Setups whose values differ from those of the others, worst first; empty if all agree."""
    tested = {i: one for i in range(count) if (one := _against_others(common, i, shift, between)) is not None}
    wrong = sorted((one for one in tested.values() if one.p < alpha / len(tested)), key=lambda one: one.p)
    if len(wrong) == 2 and len(tested) == 2:
        names = " and ".join(str(i) for i in tested)
        text = f"Setups {names} disagree ({wrong[0].text})."
        return [replace(wrong[0], text=text)]
    if len(wrong) <= 1:
        return [replace(one, text=f"Setup {one.setup} disagrees ({one.text}).") for one in wrong]
    # The worst one spoils the means of the others: without it they are asked again.
    worst = wrong[0]
    rest = {
        dof: {i: table for i, table in tables.items() if i != worst.setup} for dof, tables in common.items()
    }
    rest = {dof: tables for dof, tables in rest.items() if len(tables) > 1}
    named = replace(worst, text=f"Setup {worst.setup} disagrees ({worst.text}).")
    return [named, *disagreements(rest, count, shift, between, alpha)]


def _against_others(
    common: Mapping[Any, Mapping[int, ResponseTable]], setup: int, shift: float, between: float
) -> Disagreement | None:
    """One setup against the means of the others; None if nothing can be compared."""
    p: list[FloatArray] = []
    worst = (1.0, "")
    for dof, tables in common.items():
        if setup not in tables or len(tables) < 2:
            continue
        own, others = tables[setup], joined([t for i, t in tables.items() if i != setup], shift, between)
        pairs = paired(own.freq_hz, others.freq_hz, shift)
        a, b = [i for i, _ in pairs], [k for _, k in pairs]
        difference = own.freq_hz[a] - others.freq_hz[b]
        std = np.sqrt(variance_hz(own, between)[a] + others.std_hz[b] ** 2)
        here = of_each(difference, np.where(std > 0.0, std, np.nan), averages_of(own)[a])
        p.append(here)
        for i, value in enumerate(here.tolist()):
            if value < worst[0]:
                percent = 100.0 * difference[i] / others.freq_hz[b[i]]
                worst = (
                    value,
                    f"{own.freq_hz[a[i]]:.3f} Hz at dof {dof}, {percent:+.2f} % from "
                    f"{'the others' if len(tables) > 2 else 'the other'}",
                )
    _, freedom, all_p = of_all(np.concatenate([np.empty(0), *p]))
    if not freedom:
        return None
    return Disagreement(setup, all_p, f"p = {all_p:.2g}; most at {worst[1]}")


def _groups(tables: Sequence[ResponseTable], shift: float, between: float) -> list[list[tuple[int, int]]]:
    """(table, row) of what is one value, table by table."""
    groups = [[(0, row)] for row in range(len(tables[0]))]
    for i, table in enumerate(tables[1:], start=1):
        where = np.array([np.mean([tables[k].freq_hz[row] for k, row in group]) for group in groups])
        variance = np.broadcast_to(2.0 * variance_hz(table, between), (where.size, len(table)))
        pairs = dict(paired(where, table.freq_hz, shift, variance))
        for group, row in pairs.items():
            groups[group].append((i, row))
        groups += [[(i, row)] for row in range(len(table)) if row not in pairs.values()]
    return groups


def _mean(values: FloatArray, variances: FloatArray) -> tuple[float, float]:
    """Weighted mean and its standard deviation; a plain mean where a variance is not known."""
    if np.isnan(variances).any() or variances.min() <= 0.0:
        n = values.size
        return float(values.mean()), float(values.std(ddof=1) / np.sqrt(n)) if n > 1 else float("nan")
    weight = 1.0 / variances
    mean = float(np.sum(weight * values) / weight.sum())
    birge = np.sum(weight * (values - mean) ** 2) / max(values.size - 1, 1)
    return mean, float(np.sqrt(max(1.0, birge) / weight.sum()))
