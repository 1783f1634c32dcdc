"""Setups of one test, with sensors or hammer at other places each, joined to one set of antiresonances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError, reject
from ..support.checks import FloatArray, choice, force_label
from ..support.messages import warn
from .antiresonance_set import AntiresonanceSet
from .matching import MAX_SHIFT, averages_of, check_sets, of_all, of_each, paired, variance_hz, within
from .response_table import ResponseTable

# -- One response seen by several setups: the mean of its values, and whether they agree
#
# Values with variances v_i have a weighted mean of variance 1 / sum(1 / v_i), times max(1, chi^2 / (n - 1))
# (R. T. Birge, Phys. Rev. 40 (1932) 207-227). Whether a setup agrees is asked of each against the others'
# means.


@dataclass(frozen=True)
class Disagreement:
    """A setup, counted from 0, that does not agree with the others, and what is said of it."""

    setup: int
    p: float
    text: str


def joined(tables: Sequence[ResponseTable], shift: float, between: float) -> ResponseTable:
    """The values that at least half of the tables have, each the mean of its own."""
    rows = []
    for group in _groups(tables, shift, between):
        if 2 * len(group) < len(tables):
            continue
        values = np.array([tables[i].freq_hz[row] for i, row in group])
        variances = np.array([variance_hz(tables[i], between)[row] for i, row in group])
        n = values.size
        if np.isnan(variances).any() or variances.min() <= 0.0:
            mean, deviation = values.mean(), values.std(ddof=1) / np.sqrt(n) if n > 1 else np.nan
        else:
            weight = 1.0 / variances
            mean = np.sum(weight * values) / weight.sum()
            birge = np.sum(weight * (values - mean) ** 2) / max(n - 1, 1)
            deviation = np.sqrt(max(1.0, birge) / weight.sum())
        table, row = group[int(np.argmin(np.where(np.isnan(variances), np.inf, variances)))]
        own = tables[table].take([row])
        rows.append(replace(own, freq_hz=np.array([mean]), std_hz=np.array([deviation])))
    if not rows:
        return tables[0].take([])
    names = sorted(set.intersection(*(set(one.scores) for one in rows)))
    kept = [{name: row.scores[name] for name in names} for row in rows]
    return ResponseTable.concatenated([replace(row, scores=s) for row, s in zip(rows, kept, strict=True)])


def disagreements(
    common: Mapping[Any, Mapping[int, ResponseTable]], count: int, shift: float, between: float, alpha: float
) -> list[Disagreement]:
    """Setups whose values differ from those of the others, worst first; empty if all agree."""
    tested = [one for i in range(count) if (one := _against_others(common, i, shift, between)) is not None]
    wrong = sorted((one for one in tested if one.p < alpha / len(tested)), key=lambda one: one.p)
    if not wrong:
        return []
    worst = wrong[0]
    if len(wrong) == len(tested) == 2:
        names = " and ".join(str(one.setup) for one in tested)
        return [replace(worst, text=f"Setups {names} disagree ({worst.text}).")]
    named = replace(worst, text=f"Setup {worst.setup} disagrees ({worst.text}).")
    if len(wrong) == 1:
        return [named]
    # The worst one spoils the means of the others: without it they are asked again.
    rest = {dof: {i: t for i, t in tables.items() if i != worst.setup} for dof, tables in common.items()}
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
                where = "the others" if len(tables) > 2 else "the other"
                worst = (value, f"{own.freq_hz[a[i]]:.3f} Hz at dof {dof}, {percent:+.2f} % from {where}")
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


def merge_setups(
    sets: Sequence[Any],
    *,
    excitation: Any = None,
    max_shift: float = MAX_SHIFT,
    std_between: float = 0.0,
    alpha: float = 0.01,
    check: str = "warn",
) -> AntiresonanceSet:
    """Join setups of one test to one set.

    Roving sensors: force and a reference sensor stay, and its values tell whether the setups agree. Roving
    hammer: the sensors stay, and as H_ik = H_ki a hit at k tells the response at k to a force at a sensor:
    name that by ``excitation``.

    Parameters
    ----------
    sets : list of AntiresonanceSet
        One for each setup, two or more, without edits by hand.
    excitation : int, str or list, optional
        Where the force is to be taken to act. Setups with that force are taken as they are, others by
        reciprocity. Default: the force of all setups, which then must be the same.
    max_shift : float
        Largest relative difference of two values that are taken for one.
    std_between : float
        Relative scatter from setup to setup that is not to be alarmed at, as for
        :func:`~antires_rs.compare`; moving sensors changes the mass of what is tested.
    alpha : float
        Rate of false alarms of the check.
    check : {"warn", "raise", "off"}
        What to do if setups disagree in what they have in common.

    Returns
    -------
    AntiresonanceSet
        A dof that several setups have gets the means of its values, weighted by their variances, without
        those that fewer than half of these setups show; the standard deviations grow with the scatter.
        ``.options`` are those that all setups were made with.

    Raises
    ------
    InvalidInputError
        Forces at several places without ``excitation``, or a setup with neither that force nor that response.
    UnsuitableDataError
        Under ``check="raise"``: setups that disagree, or the same numbers twice, which count once.

    Examples
    --------
    >>> import antires_rs as ar
    >>> std = {0: [0.02], 1: [0.02]}
    >>> one = ar.AntiresonanceSet(0, {0: [8.70], 1: [14.40]}, std_hz=std)
    >>> two = ar.AntiresonanceSet(0, {0: [8.72], 2: [16.70]}, std_hz={0: [0.02], 2: [0.03]})
    >>> {dof: f.round(2).tolist() for dof, f in ar.merge_setups([one, two]).items()}
    {0: [8.71], 1: [14.4], 2: [16.7]}
    """
    given = check_sets("sets", sets, 2)
    shift, rate = within("max_shift", max_shift), within("alpha", alpha)
    between = within("std_between", std_between)
    choice("check", check, ("warn", "raise", "off"))
    force = given[0].excitation if excitation is None else force_label("excitation", excitation)
    shared: dict[Any, dict[int, ResponseTable]] = {}
    for number, one in enumerate(given):
        for dof, table in _tables(f"sets[{number}]", one, force, stated=excitation is not None).items():
            shared.setdefault(dof, {})[number] = table

    def told(got: str, wanted: str, remedy: str) -> str:
        if check == "raise":
            raise UnsuitableDataError("sets", got, wanted, remedy)
        return f"merge_setups: {got}. {remedy}"

    copies = _counted_once(shared)
    if copies and check != "off":
        text = "; ".join(f"setups {a} and {b} have {n} values in common" for (a, b), n in copies.items())
        wanted = "measurements with errors of their own"
        warn("copied_setups", told(f"{text} to the last bit", wanted, "Give each setup once."))
    common = {dof: tables for dof, tables in shared.items() if len(tables) > 1}
    if common and check != "off":
        found = disagreements(common, len(given), shift, between, rate)
        if found:
            text = " ".join(one.text for one in found).rstrip(".")
            wanted = f"values that agree within their errors (false alarms {100 * rate:g} %)"
            remedy = "Test that setup again, or give std_between= for what moving the sensors changes."
            warn("setups_disagree", told(f"setups that disagree: {text}", wanted, remedy))
    elif not copies and check != "off":
        text = f"merge_setups: the {len(given)} setups have no response in common, so that nothing tells "
        warn("nothing_in_common", f"{text}whether they agree.")
    kinds = {one.sees for one in given}
    stayed = all(one.excitation == force and one.channels for one in given)
    channels = tuple(dict.fromkeys(dof for one in given for dof in one.channels)) if stayed else ()
    every = {dof: [*tables.values()] for dof, tables in shared.items()}
    means = {dof: joined(own, shift, between) if dof in common else own[0] for dof, own in every.items()}
    sees = kinds.pop() if len(kinds) == 1 else None
    first, *others = (one.options for one in given)
    options = {name: was for name, was in first.items() if all(one.get(name) == was for one in others)}
    return AntiresonanceSet.from_tables(force, means, sees=sees, channels=channels, options=options)


def _tables(name: str, one: AntiresonanceSet, force: Any, *, stated: bool) -> dict[Any, ResponseTable]:
    """What a setup tells of the responses to the force."""
    if one.excitation == force:
        return dict(one.tables)
    if not stated:
        got, wanted = f"a setup with its force at {one.excitation!r}", f"the force of the first, {force!r}"
        reject(name, got, wanted, "If the hammer roved, name a sensor that stayed: excitation=DOF.")
    if force not in one:
        got = f"a setup of force at {one.excitation!r} and responses at {tuple(one)}"
        wanted = f"its force or a response at {force!r}"
        reject(name, got, wanted, "Name a place that every setup has.")
    return {one.excitation: one.tables[force]}


def _counted_once(shared: dict[Any, dict[int, ResponseTable]]) -> dict[tuple[int, int], int]:
    """Take out tables that are those of an earlier setup to the last bit; values by pair of setups."""
    copies: dict[tuple[int, int], int] = {}
    for tables in shared.values():
        for number, table in list(tables.items()):
            first = next(i for i, one in tables.items() if one.same_as(table))
            if first != number and len(table):
                copies[first, number] = copies.get((first, number), 0) + len(table)
                del tables[number]
    return copies
