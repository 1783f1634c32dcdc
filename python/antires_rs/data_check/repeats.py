"""Findings of several records of one test, each said once, with the records that show it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from .findings import SEVERITIES, Finding, NotTested, Said

__all__ = ["grouped", "of_repeats"]

CHANGED = (
    "If nothing else acted, the structure has changed from record to record: identify them one by one and "
    "compare the sets."
)


def grouped(each: Sequence[Said]) -> Said:
    """What the tests say of each record, joined: one finding for a test and a place, its worst example.

    Examples
    --------
    >>> from antires_rs.data_check.findings import Finding
    >>> from antires_rs.data_check.repeats import grouped
    >>> seen = Finding("dead_channel", "fatal", (3,), 0.0, 0.1, "Channel 3 is constant.", "Leave it out.")
    >>> [one.text for one in grouped([[], [seen], [seen]])]
    ['Channel 3 is constant. (In records 1 and 2 of 3, counted from 0.)']
    """
    found: dict[tuple[object, ...], list[tuple[int, Finding]]] = {}
    untested: dict[str, NotTested] = {}
    for number, said in enumerate(each):
        for one in said:
            if isinstance(one, NotTested):
                untested.setdefault(one.name, one)
            else:
                found.setdefault((one.name, one.where), []).append((number, one))
    joined: Said = []
    for shown in found.values():
        worst = min((one for _, one in shown), key=lambda one: SEVERITIES.index(one.severity))
        where = _listed([number for number, _ in shown], len(each))
        brief = f"{worst.brief} ({where[0].lower()}{where[1:-1]})" if worst.brief else ""
        joined.append(replace(worst, text=f"{worst.text} ({where})", brief=brief))
    return [*joined, *untested.values()]


def of_repeats(said: Said, repeats: bool) -> Said:
    """Findings of the one force: a structure that changes between repeats looks like a second one."""
    if not repeats:
        return said
    return [
        replace(one, advice=f"{one.advice} {CHANGED}") if isinstance(one, Finding) else one for one in said
    ]


def _listed(numbers: list[int], count: int) -> str:
    if len(numbers) == count:
        return f"In all {count} records."
    if len(numbers) == 1:
        return f"In record {numbers[0]} of {count}, counted from 0."
    return f"In records {', '.join(map(str, numbers[:-1]))} and {numbers[-1]} of {count}, counted from 0."
