"""Setups of one test, with sensors or hammer at other places each, joined to one set of antiresonances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..exceptions import UnsuitableDataError
from ..order_sweep.table import ResponseTable
from ..support.validation import choice, finite_scalar, reject
from ..support.warned import warn
from .antiresonance_set import AntiresonanceSet
from .joined import disagreements, joined
from .matching import MAX_SHIFT, check_sets, check_shift
from .sight import sight_of_all
from .tables import label

__all__ = ["merge_setups"]


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

    Roving sensors: the force stays, a reference sensor stays, the others move. Every setup is identified by
    itself, and the values of the reference, which all of them have, tell whether they agree.

    Roving hammer: the sensors stay and the force moves. H_ik = H_ki, so that the response at a sensor under a
    force at k has the antiresonances of the response at k under a force at that sensor: name the sensor by
    ``excitation``.

    Parameters
    ----------
    sets : list of AntiresonanceSet
        One for each setup, two or more, without edits by hand.
    excitation : int or str, optional
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
        those that fewer than half of these setups show; the standard deviations grow where the values scatter
        more than they say. Diagrams and data checks stay with the setups.

    Raises
    ------
    InvalidInputError
        Fewer than two sets, forces at several places without ``excitation``, or a setup with neither that
        force nor that response.
    UnsuitableDataError
        Setups that disagree, or the same numbers twice, under ``check="raise"``.

    Warns
    -----
    AntiresWarning
        Setups that disagree, or nothing in common that could tell; the same numbers twice, which count once.

    Examples
    --------
    >>> import antires_rs as ar
    >>> std = {0: [0.02], 1: [0.02]}
    >>> one = ar.AntiresonanceSet(0, {0: [8.70], 1: [14.40]}, std_hz=std)
    >>> two = ar.AntiresonanceSet(0, {0: [8.72], 2: [16.70]}, std_hz={0: [0.02], 2: [0.03]})
    >>> {dof: f.round(2).tolist() for dof, f in ar.merge_setups([one, two]).items()}
    {0: [8.71], 1: [14.4], 2: [16.7]}
    >>> roving = [ar.AntiresonanceSet(k, {"tip": [f]}) for k, f in ((3, 20.1), (4, 25.3))]
    >>> {dof: f.tolist() for dof, f in ar.merge_setups(roving, excitation="tip", check="off").items()}
    {3: [20.1], 4: [25.3]}
    """
    given = check_sets("sets", sets, 2)
    shift = check_shift(max_shift)
    between = finite_scalar("std_between", std_between, low=0.0, high=0.5)
    rate = finite_scalar("alpha", alpha, low=0.0, high=1.0, low_open=True, high_open=True)
    choice("check", check, ("warn", "raise", "off"))
    force = given[0].excitation if excitation is None else label("excitation", excitation)
    shared: dict[Any, dict[int, ResponseTable]] = {}
    for number, one in enumerate(given):
        for dof, table in _tables(number, one, force, stated=excitation is not None).items():
            shared.setdefault(dof, {})[number] = table
    copies = _counted_once(shared)
    if copies and check != "off":
        _warn_of_copies(copies, check)
    if check != "off" and not (copies and all(len(tables) == 1 for tables in shared.values())):
        _agree(shared, len(given), shift, between, rate, check)
    return AntiresonanceSet.from_tables(
        force,
        {
            dof: joined(list(tables.values()), shift, between)
            if len(tables) > 1
            else next(iter(tables.values()))
            for dof, tables in shared.items()
        },
        **sight_of_all(given, force),
    )


def _tables(number: int, one: AntiresonanceSet, force: Any, *, stated: bool) -> dict[Any, ResponseTable]:
    """What a setup tells of the responses to the force."""
    if one.excitation == force:
        return dict(one.tables)
    if not stated:
        reject(
            f"sets[{number}]",
            f"a setup with its force at {one.excitation!r}",
            f"the force of the first, {force!r}",
            "If the hammer roved, name a sensor that stayed: excitation=DOF.",
        )
    if force not in one:
        reject(
            f"sets[{number}]",
            f"a setup of force at {one.excitation!r} and responses at {tuple(one)}",
            f"its force or a response at {force!r}",
            "Name a place that every setup has.",
        )
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


def _warn_of_copies(copies: dict[tuple[int, int], int], check: str) -> None:
    """Say which setups are one measurement."""
    text = "; ".join(f"setups {a} and {b} have {n} values in common" for (a, b), n in copies.items())
    if check == "raise":
        raise UnsuitableDataError(
            "sets",
            f"the same numbers to the last bit: {text}",
            "measurements of their own, whose errors are independent",
            "Give each setup once.",
        )
    warn("copied_setups", f"merge_setups: {text} to the last bit: one measurement, which counts once.")


def _agree(
    shared: dict[Any, dict[int, ResponseTable]],
    count: int,
    shift: float,
    between: float,
    rate: float,
    check: str,
) -> None:
    """Say which setups differ from the others in what they have in common."""
    common = {dof: tables for dof, tables in shared.items() if len(tables) > 1}
    if not common:
        warn(
            "nothing_in_common",
            f"merge_setups: the {count} setups have no response in common, so that nothing tells whether "
            "they agree.",
        )
        return
    found = disagreements(common, count, shift, between, rate)
    if not found:
        return
    text = " ".join(one.text for one in found)
    if check == "raise":
        raise UnsuitableDataError(
            "sets",
            f"setups that disagree: {text.rstrip('.')}",
            f"values that agree within their errors (false alarms {100 * rate:g} %)",
            "Test that setup again, or give std_between= for what moving the sensors changes.",
        )
    warn("setups_disagree", f"merge_setups: {text}")
