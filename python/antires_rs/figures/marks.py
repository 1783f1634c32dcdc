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

from ..support.checks import FloatArray, IntArray

#: Okabe and Ito's palette (2008), told apart by all common kinds of colour vision; yellow, too pale for lines
#: on white, is left out.
COLOURS = {"blue": "#0072B2", "vermillion": "#D55E00", "green": "#009E73", "purple": "#CC79A7"}
COLOURS |= {"orange": "#E69F00", "sky": "#56B4E9", "black": "#000000"}
INKS = COLOURS | {"grey": "#8C8C8C", "pale": "#BFBFBF"}  # names by which marks may say a colour
#: Dash patterns to go with the colours: by name, or points drawn and left out.
DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (5, 1, 1, 1, 1, 1), (1, 3), (8, 3))
#: From nothing, which is to be quiet, to much; lightness falls evenly, so that it reads in grey as well.
NOTHING = "#F1F1F1"  # paler than the first of the scale: what has no value
#: Colours of parts side by side, as far apart in grey as they can be; those of arrows are left out.
PARTS, MOST_NAMED = ("sky", "blue", "orange", "green", "purple"), 8
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
    halo: bool = False  # so that they are read on any colour


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
    halo: bool = False  # so that they are seen on any colour


@dataclass(frozen=True)
class Faces(Mark):
    """Polygons (n, 4, 2), far ones first, each with its colour (n, 3), 0 to 1, and the width of its outline.

    An outline wider than 1 point is that of a line, in its colour; none at all is not drawn. ``values``, of
    parts, are those of the scale.
    """

    corners: FloatArray
    colours: Any
    widths: Any
    values: FloatArray | None = None
    scale: str = ""


@dataclass(frozen=True)
class Scene:
    """A structure in space, to be seen from any side.

    ``cells`` (f, 4) are rows of ``points`` (n, 3): a triangle has its last one twice, a line three times.
    ``part`` (f,) says of which part each is, -1 of none; ``texts`` are of parts, to be read when pointed at,
    and so are ``values``, NaN where there is none, which colour them; without values parts differ. ``arrows``
    are in space, ``words`` texts with their places, ``moves`` translations of the points by name.
    """

    points: FloatArray
    cells: IntArray
    part: IntArray
    texts: Sequence[str]
    values: FloatArray | None = None
    scale: str = ""
    arrows: Sequence[Arrows] = ()
    words: Sequence[tuple[str, FloatArray]] = ()
    moves: Mapping[str, FloatArray] = field(default_factory=dict)

    @property
    def span(self) -> tuple[float, float]:
        """Values at the ends of the scale."""
        known = np.append(np.nan_to_num(self.values), 0.0) if self.values is not None else np.zeros(1)
        low, high = float(known.min()), float(known.max())
        return low, high if high > low else low + 1.0

    @property
    def colours(self) -> list[str]:
        """Of each part, and last that of what belongs to none."""
        if self.values is None:
            shades = [COLOURS[name] for name in PARTS]
            return [*(shades[i % len(shades)] for i in range(len(self.texts))), NOTHING]
        stops = np.array([[int(one[i : i + 2], 16) for i in (1, 3, 5)] for one in SCALE], dtype=np.float64)
        low, high = self.span
        share = np.clip((np.nan_to_num(self.values) - low) / (high - low), 0.0, 1.0) * (len(SCALE) - 1)
        mixed = [np.interp(share, np.arange(len(SCALE)), stops[:, k]).round().astype(int) for k in range(3)]
        known = np.isfinite(self.values)
        named = (f"#{r:02X}{g:02X}{b:02X}" for r, g, b in zip(*mixed, strict=True))
        return [*(one if there else NOTHING for one, there in zip(named, known, strict=True)), NOTHING]

    def named(self, points: FloatArray) -> list[tuple[str, FloatArray]]:
        """Texts in the picture with their places: words, and those of the largest values or of few parts."""
        if self.values is None:
            few = 1 < len(self.texts) <= MOST_NAMED and not self.words
            shown = list(range(len(self.texts))) if few else []
        else:
            large = np.argsort(-np.nan_to_num(self.values), kind="stable")[:MOST_NAMED]
            shown = [i for i in large.tolist() if self.values[i] > 0.0]
        there = [i for i in shown if np.any(self.part == i)]
        middles = (points[self.cells[self.part == i]].mean(axis=(0, 1)) for i in there)
        return [*zip((self.texts[i] for i in there), middles, strict=True), *self.words]


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
