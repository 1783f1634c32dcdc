"""Rows of text that begin with an instant, or with a count before it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ._common import unsuitable

__all__ = ["without_count", "without_instants"]

#: Lines in which the first row of numbers is looked for.
_HEAD = 200

#: An instant, as ISO 8601 has it, or with slashes.
_INSTANT = re.compile(
    r"^\"?(\d{4})[-/](\d\d)[-/](\d\d)(?:[T ](\d\d):(\d\d)(?::(\d\d)(?:[.,](\d{1,9}))?)?)?"
    r"(Z|[+-]\d\d:?\d\d)?\"?$"
)


def without_count(body: list[str], between: str | None) -> list[str]:
    """Rows without the number of the row where that stands before an instant; others stay as they are."""
    start = next((i for i, line in enumerate(body[:_HEAD]) if _second_is_instant(line, between)), None)
    if start is None:
        return body
    split = [_first_field(line, between) for line in body]
    numbers = [field for field, _ in split[start:]]
    if not all(number.isdecimal() for number in numbers[:-1]):  # the last row may be cut
        return body
    steps = zip(numbers[:-1], numbers[1:-1], strict=False)
    if any(int(after) != int(before) + 1 for before, after in steps):
        return body
    width = body[start].count(between or " ")
    headed = [line.count(between or " ") == width for line in body[:start]]
    return [
        _bare(rest, between) if i >= start or headed[i] else line
        for i, (line, (_, rest)) in enumerate(zip(body, split, strict=True))
    ]


def _second_is_instant(line: str, between: str | None) -> bool:
    field, rest = _first_field(line, between)
    return field.isdecimal() and bool(_INSTANT.match(_first_field(_bare(rest, between), between)[0]))


def _bare(rest: str, between: str | None) -> str:
    """What follows a field, without its delimiter."""
    return rest.lstrip() if between is None else rest[len(between) :]


def without_instants(file: Path, body: list[str], between: str | None) -> tuple[list[str], str]:
    """Rows with an instant in front with the time since the first of them in its place, and the unit of that.

    The unit is as fine as the instants were written, so that their rounding is known.
    """
    rows = [(i, *_first_field(line, between)) for i, line in enumerate(body)]
    found = [(i, match, rest) for i, field, rest in rows if (match := _INSTANT.match(field))]
    if not found:
        return body, ""
    start = found[0][0]
    there = {i for i, _, _ in found}
    odd = next((i for i in range(start, len(body) - 1) if i not in there), None)
    if odd is not None:
        unsuitable(
            file,
            f"whose row {odd - start + 1} has {rows[odd][1][:40]!r} where others have an instant",
            "instants in the first column",
            "Correct or remove that row.",
        )
    digits = max(len(match[7] or "") for _, match, _ in found)
    unit, per_s = next((u, n) for u, n in (("s", 0), ("ms", 3), ("us", 6), ("ns", 9)) if digits <= n)
    made, first = list(body), None
    for i, match, rest in found:
        try:
            at = _instant(match)
        except ValueError:
            unsuitable(
                file, f"with the instant {match[0]!r}", "days and times that exist", "Correct that row."
            )
        first = at if first is None else first
        made[i] = f"{int((at - first) / np.timedelta64(1, 'ns')) // 10 ** (9 - per_s)}{rest}"
    return made, unit


def _first_field(line: str, between: str | None) -> tuple[str, str]:
    """The first field of a line, and what follows it with its delimiter."""
    if between is None:
        field, _, rest = line.strip().partition(" ")
        return field, f" {rest}"
    field, sign, rest = line.partition(between)
    return field.strip(), sign + rest


def _instant(match: re.Match[str]) -> np.datetime64:
    year, month, day, hour, minute, second, part, zone = match.groups()
    clock = f"{hour or '00'}:{minute or '00'}:{second or '00'}.{(part or '0').ljust(9, '0')}"
    at = np.datetime64(f"{year}-{month}-{day}T{clock}", "ns")
    if zone and zone != "Z":
        shift = np.timedelta64(int(zone[1:3]) * 60 + int(zone[-2:]), "m")
        at = at - shift if zone[0] == "+" else at + shift
    return at
