"""Places in a job file: how errors name them, and the key that explains them."""

from __future__ import annotations

from collections.abc import Mapping

from ..exceptions import Argument
from .key import Key
from .keys import SECTIONS
from .lines import Path as Keys

__all__ = ["Place", "Places", "key_at"]


class Place(Argument):
    """What is wrong, by file, line, section and key: an argument of who writes jobs."""


class Places:
    """The places of a job file.

    Parameters
    ----------
    name : str
        Of the file.
    lines : mapping of tuple to int
        As :func:`~antires_rs.jobs.lines.lines_of` has them.

    Examples
    --------
    >>> places = Places("job.toml", {("search",): 4, ("search", "seed"): 5})
    >>> print(places.of(("search", "seed")), places.of(("search", "rng")), sep="; ")
    job.toml, line 5, [search] seed; job.toml, line 4, [search] rng
    """

    def __init__(self, name: str, lines: Mapping[Keys, int]) -> None:
        self._name, self._lines = name, lines

    def of(self, place: Keys) -> Place:
        """A place; what is not in the file has the line of its nearest neighbour above."""
        there = place
        while there and there not in self._lines:
            there = there[:-1]
        line = f", line {self._lines[there]}" if there else ""
        return Place(f"{self._name}{line}{',' if place else ''}{_label(place)}", place)


def key_at(place: Keys) -> Key | None:
    """The key at a place, or above it."""
    section = SECTIONS.get(str(place[0])) if place else None
    names = [part for part in place[1:] if isinstance(part, str)]
    return section.key(names[0]) if section and names else None


def _label(place: Keys) -> str:
    """``[search] seed`` of ("search", "seed"); arrays of tables by their number."""
    if not place:
        return ""
    name, rest = str(place[0]), list(place[1:])
    label = f" [{name}]"
    if rest and isinstance(rest[0], int) and name in SECTIONS and SECTIONS[name].several != "no":
        label = f" [[{name}]] {rest[0]}"
        rest = rest[1:]
    for i, part in enumerate(rest):
        label += f"[{part}]" if isinstance(part, int) else f"{'.' if i else ' '}{part}"
    return label
