"""Matrices as Nastran writes them into punch files and bulk data: the DMIG card.

The first card of a matrix tells its form (6 is symmetric, one triangle given) and type (1 and 2 are real);
each other card is a column: grid and component, then grid, component and value of its entries. Fields are 8
wide, 16 where the first ends in ``*``, or divided by commas.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from .._common import unsuitable
from .labelled import Labelled, Point, by_points

__all__ = ["read_dmig"]

_WANTED = "a punch file or bulk data with DMIG cards of real matrices"
_SHORT = re.compile(r"(?<=[\d.])([+-]\d+)$")


def read_dmig(file: Path) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    heads: set[str] = set()
    entries: dict[str, list[tuple[Point, Point, float]]] = {}
    columns: dict[str, list[Point]] = {}
    for line, fields in _cards(file.read_text(encoding="ascii", errors="replace").splitlines()):
        try:
            name = fields[1].upper()
            if fields[2] == "0" and name not in heads:
                if fields[4] not in ("1", "2"):
                    raise ValueError(f"matrix {name} of type {fields[4]}; 1 and 2 are real")
                heads.add(name)
                continue
            column = (int(fields[2]), int(fields[3] or 0))
            columns.setdefault(name, []).append(column)
            own = entries.setdefault(name, [])
            for i in range(5, len(fields) - 2, 4):
                if fields[i]:
                    own.append(((int(fields[i]), int(fields[i + 1] or 0)), column, _number(fields[i + 2])))
        except (ValueError, IndexError) as exc:
            unsuitable(
                file, f"with the card in line {line} that cannot be read ({exc})", _WANTED, "Correct it."
            )
    if not entries:
        unsuitable(file, "without a DMIG card", _WANTED, "Export with PARAM,EXTOUT,DMIGPCH.")
    return {name: by_points(file, own, columns[name]) for name, own in entries.items()}


def _number(text: str) -> float:
    """1.5, 1.5E+3, 1.5D+3 or 1.5+3."""
    plain = text.upper().replace("D", "E")
    return float(plain if "E" in plain else _SHORT.sub(r"E\1", plain))


def _cards(lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """DMIG cards: the number of their first line, and all fields without those of continuations."""
    card: list[str] | None = None
    begun = 0
    for number, raw in enumerate(lines, 1):
        line = raw.split("$")[0].rstrip()
        if not line:
            continue
        fields = _fields(line)
        if fields[0][:1] in ("", "*", "+"):
            if card is not None:
                card += fields[1:]
            continue
        if card is not None:
            yield begun, card
        is_dmig = fields[0].rstrip("*").upper() == "DMIG"
        card, begun = (fields if is_dmig else None), number
    if card is not None:
        yield begun, card


def _fields(line: str) -> list[str]:
    """The first field, and four of 16 or eight of 8 of the card itself."""
    if "," in line:
        parts = [part.strip() for part in line.split(",")]
        count = 4 if parts[0].endswith("*") else 8
        return [*parts[: count + 1], *[""] * (count + 1 - len(parts))]
    first = line[:8].strip()
    width, count = (16, 4) if first.startswith("*") or first.endswith("*") else (8, 8)
    return [first, *(line[8 + i * width : 8 + (i + 1) * width].strip() for i in range(count))]
