"""What a figure shows, whoever draws it: marks on a panel, those behind first.

:func:`~antires_rs.figures.canvas.draw` makes a picture of a panel with matplotlib,
:func:`~antires_rs.figures.live_canvas.explored` a figure to be explored with bokeh. Sizes are in points.
Kinds of things differ by marker, dash or hatch as well as by colour, so that they are told apart in grey.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..support.checks import FloatArray

#: Okabe and Ito's palette (2008), told apart by all common kinds of colour vision; yellow, too pale for lines
#: on white, is left out.
COLOURS = {"blue": "#0072B2", "vermillion": "#D55E00", "green": "#009E73", "purple": "#CC79A7"}
COLOURS |= {"orange": "#E69F00", "sky": "#56B4E9", "black": "#000000"}
INKS = COLOURS | {"grey": "#8C8C8C", "pale": "#BFBFBF"}  # names by which marks may say a colour
#: Dash patterns to go with the colours: by name, or points drawn and left out.
DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (5, 1, 1, 1, 1, 1), (1, 3), (8, 3))
#: From nothing, which is to be quiet, to much; lightness falls evenly, so that it reads in grey as well.
SCALE = ("#DADADA", "#A9BFD6", "#5F8DBD", "#1F5A94", "#0B2C57", "#050B16")


def xy(points: Any) -> tuple[FloatArray, FloatArray]:
    """x and y of points (n, 2)."""
    x, y = np.asarray(points, dtype=np.float64).reshape(-1, 2).T
    return x, y


def turn(number: int) -> dict[str, Any]:
    """Colour and dash of a curve among others."""
    return {"colour": list(COLOURS.values())[number % len(COLOURS)], "dash": DASHES[number % len(DASHES)]}


@dataclass(frozen=True, kw_only=True)
class Mark:
    """What all marks have.

    ``says`` is what hovering tells: texts with ``@x``, ``@y`` and columns of ``more``, numbers in a format
    in braces. ``only`` keeps a mark to the "picture" or to the "page".
    """

    label: str | None = None
    says: Mapping[str, str] = field(default_factory=dict)
    more: Mapping[str, Any] = field(default_factory=dict)
    only: str = ""

    def __post_init__(self) -> None:
        for name in ("colour", "face", "edge"):
            if getattr(self, name, None) in INKS:
                object.__setattr__(self, name, INKS[getattr(self, name)])


@dataclass(frozen=True)
class Points(Mark):
    """Markers, or none (""), with their ``error``; ``spill`` ones go over the edge."""

    x: Any
    y: Any
    marker: str = "o"
    size: float = 6.0
    colour: str = "black"
    face: str | None = None
    stroke: float = 1.2
    spill: bool = False
    error: Any = None
    link: Any = ""


@dataclass(frozen=True)
class Line(Mark):
    """A curve, or steps that change at each point."""

    x: Any
    y: Any
    colour: str = "black"
    dash: Any = "-"
    width: float = 1.2
    steps: bool = False


@dataclass(frozen=True)
class Bars(Mark):
    """From zero to a length, upright or sideways."""

    at: Any
    length: Any
    width: float = 0.62
    face: str = "blue"
    edge: str | None = "black"
    hatch: str = ""
    dash: Any = "-"
    sideways: bool = False


@dataclass(frozen=True)
class Rules(Mark):
    """Lines through the whole panel at each place, upright or across."""

    at: Any
    upright: bool = False
    colour: str = "black"
    dash: Any = "-"
    width: float = 0.8


@dataclass(frozen=True)
class Bands(Mark):
    """Upright bands from each ``low`` to its ``high`` behind everything."""

    low: Any
    high: Any
    face: str = "none"
    hatch: str = ""


BESIDE = {  #: Way from its place, and alignments, of a text beside it.
    "above": ((0, 1), "center", "bottom"),
    "below": ((0, -1), "center", "top"),
    "right": ((1, 0), "left", "center"),
    "centre": ((0, 0), "center", "center"),
}


@dataclass(frozen=True)
class Words(Mark):
    """Texts beside their places: ``above`` them, "below", "right" of them or "centre"."""

    x: Any
    y: Any
    texts: Sequence[str]
    where: str = "above"
    away: float = 3.0
    size: float = 8.33
    colour: str = "black"
    turned: bool = False
    slanted: bool = False


@dataclass(frozen=True)
class Heads(Mark):
    """Names of places across: over a picture, upright at the lower edge of a figure to be explored."""

    x: Any
    texts: Sequence[str]
    bold: Sequence[bool] = ()


@dataclass(frozen=True)
class Paths(Mark):
    """Lines (n, 2) of one colour, or each in that of its value; thin where it has none."""

    paths: Sequence[FloatArray]
    colour: str = "blue"
    values: FloatArray | None = None
    scale: str = ""
    dash: Any = "-"
    width: float = 3.2


@dataclass(frozen=True)
class Arrows(Mark):
    """From ``tails`` to ``heads``, (n, 2) both."""

    tails: FloatArray
    heads: FloatArray
    colour: str = "black"
    width: float = 1.6


@dataclass(frozen=True)
class Axis:
    """Label with its unit, limits, scale, places of ticks, and their names, by default at 0, 1, ..."""

    label: str
    limits: tuple[float, float] | None = None
    log: bool = False
    names: Sequence[str] | None = None
    at: Any = None
    upright: bool = False
    dated: bool = False

    @property
    def places(self) -> Any:
        """Where the names stand."""
        return np.arange(len(self.names or ())) if self.at is None else self.at


@dataclass(frozen=True)
class Panel:
    """A figure; ``behind`` is a curve on an axis of its own at the right, ``first`` leads the legend."""

    name: str
    x: Axis
    y: Axis
    marks: Sequence[Mark]
    title: str = ""
    grid: str = ""
    equal: bool = False
    first: Sequence[str] = ()
    behind: tuple[Axis, Line] | None = None
