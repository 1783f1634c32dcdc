"""CalculiX: its input with values of groups scaled, and the matrices that it stores.

``*FREQUENCY, SOLVER=MATRIXSTORAGE`` writes the stiffness (.sti) and the mass (.mas) of the free dofs, one
triangle, and node.direction of each row (.dof); constraints and ties are taken out. Shells and beams are
expanded to solids: a row stands for a layer of them. A force of zero at a node makes CalculiX keep the dof of
the node itself, so that names mean the middle surface. Reference: G. Dhondt, CalculiX CrunchiX User's Manual
2.20, sections 6.2 and 7.60.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import reject
from ..models.term_groups import Mesh
from ..support.directions import DIRECTIONS
from .common import unsuitable
from .matrix_files import completed

WANTED = "an input file of CalculiX, with elements, sections and materials"
_PER_LINE = 12  # numbers in a line of a set

# -- An input file as its cards


@dataclass
class Card:
    """``*KEYWORD, NAME=value`` with the lines below it."""

    keyword: str
    parameters: dict[str, str]
    lines: list[str]

    def text(self, changed: Mapping[str, str] | None = None, lines: Iterable[str] | None = None) -> str:
        """As it stands in a file, with some parameters and lines exchanged."""
        shown = self.parameters | dict(changed or {})
        head = ", ".join([self.keyword, *(f"{k}={v}" if v else k for k, v in shown.items())])
        return "\n".join([f"*{head}", *(self.lines if lines is None else lines)]) + "\n"

    def named(self, parameter: str) -> str:
        """A name among its parameters, in capitals: CalculiX makes no difference."""
        return self.parameters.get(parameter, "").upper()

    def numbers(self, line: int) -> list[str]:
        """The fields of a line, without the empty ones at its end."""
        return [field.strip() for field in self.lines[line].rstrip().rstrip(",").split(",")]


def cards_of(file: Path, depth: int = 0) -> list[Card]:
    """All cards of an input file and of those it includes."""
    cards: list[Card] = []
    head = ""
    for raw in file.read_text(encoding="utf-8", errors="replace").splitlines():
        line = raw.strip()
        if not line or line.startswith("**"):
            continue
        if head.endswith(",") or line.startswith("*"):
            head += line
            if head.endswith(","):
                continue
            keyword, *options = (each.strip() for each in head[1:].split(","))
            pairs = (option.partition("=") for option in options if option)
            named = {key.strip().upper(): value.strip() for key, _, value in pairs}
            card, head = Card(" ".join(keyword.upper().split()), named, []), ""
            if card.keyword == "INCLUDE":
                more = file.parent / card.parameters.get("INPUT", "").strip('"')
                if depth > 9 or not more.is_file():
                    got = f"which includes {str(more)!r}"
                    unsuitable(file, got, "files that are there", "Copy it there.")
                cards += cards_of(more, depth + 1)
            else:
                cards.append(card)
        elif cards:
            cards[-1].lines.append(line)
    return cards


#: Nodes of an element by its type; a shell or beam that is expanded has its number first.
_TYPES = re.compile(
    r"(?:DC3D|C3D|CPS|CPE|CAX|M3D|DS|S)(\d+)|(?:B3|T3D|T2D|B2)(\d)|(?:SPRING|DASHPOT|GAP)(A|1|2)"
)
_EXPANDED = re.compile(r"S\d|B3|B2|T3D")


def _n_nodes(kind: str) -> int:
    found = _TYPES.match(kind)
    if found is None:
        return 1 if kind.startswith(("MASS", "DCOUP")) else 0
    solid, line, spring = found.groups()
    if spring:
        return 1 if spring == "1" else 2
    return int(solid) if solid else int(line) + (1 if kind[0] == "B" else 0)


# -- The model in them: nodes, elements, sets, and which section each element has

#: Cards that belong to the material above them.
_OF_MATERIALS = (
    ("ELASTIC", "DENSITY", "EXPANSION", "CONDUCTIVITY", "SPECIFIC HEAT", "PLASTIC", "CYCLIC HARDENING")
    + ("CREEP", "HYPERELASTIC", "HYPERFOAM", "DEFORMATION PLASTICITY", "DAMPING", "DEPVAR", "USER MATERIAL")
)  # fmt: skip
_THICK = ("SHELL SECTION", "BEAM SECTION")
_SECTIONS = (*_THICK, "SOLID SECTION", "MEMBRANE SECTION")
#: How many constants and a temperature a type of material has, and which are moduli: isotropic, with
#: engineering constants, orthotropic, anisotropic.
_MODULI = {
    "": (3, (0,)),
    "ISO": (3, (0,)),
    "ENG": (10, (0, 1, 2, 6, 7, 8)),
    "ORT": (10, range(9)),
    "ANI": (22, range(21)),
}


Groups = Mapping[str, tuple[str, list[int]]]  # quantity and elements, by name


class Deck:
    """An input file that can be written again with values of groups times factors."""

    def __init__(self, file: Path) -> None:
        self.file, self.cards = file, cards_of(file)
        self.materials: dict[str, list[Card]] = {}
        self.sets: defaultdict[str, list[int]] = defaultdict(list)
        self._nodes: dict[int, list[float]] = {}
        self._elements: dict[int, tuple[str, list[int]]] = {}
        try:
            for card in self.cards:
                if card.keyword == "STEP":
                    break
                self._take(card)
        except (ValueError, IndexError) as exc:
            unsuitable(file, f"whose *{card.keyword} card cannot be read ({exc})", WANTED)
        #: Section card of each element: the last one that names it.
        self.section_of = {
            element: i
            for i, card in enumerate(self.cards)
            if card.keyword in _SECTIONS
            for element in self.sets[card.named("ELSET")]
        }
        if not self.section_of:
            unsuitable(file, "without a section that has elements", WANTED)

    def _take(self, card: Card) -> None:
        if card.keyword == "NODE":
            for i in range(len(card.lines)):
                number, *place = card.numbers(i)
                self._nodes[int(number)] = [float(x or 0.0) for x in (*place, "0", "0", "0")[:3]]
        elif card.keyword == "ELEMENT":
            kind, fields = card.named("TYPE"), ",".join(card.lines).split(",")
            own = [int(field) for field in fields if field.strip()]
            size = 1 + (_n_nodes(kind) or len(card.numbers(0)) - 1)
            for at in range(0, len(own), size):
                self._elements[own[at]] = (kind, own[at + 1 : at + size])
                self.sets[card.named("ELSET")].append(own[at])
        elif card.keyword == "ELSET":
            self.sets[card.named("ELSET")] += self._members(card)
        elif card.keyword == "MATERIAL":
            self._material = self.materials.setdefault(card.named("NAME"), [])
        elif card.keyword in _OF_MATERIALS and self.materials:
            self._material.append(card)

    def _members(self, card: Card) -> Iterator[int]:
        for i in range(len(card.lines)):
            fields = [field for field in card.numbers(i) if field]
            if "GENERATE" in card.parameters:
                first, last, *step = map(int, fields)
                yield from range(first, last + 1, *step)
                continue
            for field in fields:
                yield from [int(field)] if field.isdigit() else self.sets[field.upper()]

    def mesh(self) -> Mesh:
        """Nodes and elements."""
        kinds = tuple(dict.fromkeys(kind for kind, _ in self._elements.values()))
        most = max((len(nodes) for _, nodes in self._elements.values()), default=1)
        rows = [[*nodes, *[-1] * (most - len(nodes))] for _, nodes in self._elements.values()]
        of = [kinds.index(kind) for kind, _ in self._elements.values()]
        nodes, elements, kind = (np.array(list(own), np.intp) for own in (self._nodes, self._elements, of))
        places = np.array(list(self._nodes.values())).reshape(-1, 3)
        return Mesh(nodes, places, elements, np.array(rows, np.intp).reshape(-1, most), kinds, kind)

    def names(self, kind: str) -> list[str]:
        """Of all element sets, or materials, that sections name."""
        key = "ELSET" if kind == "elset" else "MATERIAL"
        sections = (self.cards[i] for i in sorted({*self.section_of.values()}))
        return list(dict.fromkeys(section.parameters.get(key, "") for section in sections))

    def elements_of(self, name: str) -> list[int]:
        """Of an element set, or of all sections of a material, by name."""
        of_material = {i for i, card in enumerate(self.cards) if card.named("MATERIAL") == name.upper()}
        own = self.sets.get(name.upper()) or [e for e, i in self.section_of.items() if i in of_material]
        if not own:
            known = [*(each for each in self.sets if self.sets[each]), *self.materials]
            remedy = "Name a set that *ELSET or *ELEMENT makes, or a material."
            reject(("groups", name), f"no element of {name!r}", f"one of {', '.join(known[:30])}", remedy)
        return own

    # -- Written again: sections in pieces, each with a material of its own

    def value(self, quantity: str, elements: list[int]) -> float | None:
        """What a quantity of elements is in the file; None where they differ, an error where it has none."""
        found = set()
        for i in sorted({self.section_of[e] for e in elements if e in self.section_of}):
            section = self.cards[i]
            if quantity == "thickness":
                if section.keyword not in _THICK or "COMPOSITE" in section.parameters:
                    got = f"thickness of a *{section.keyword}"
                    reject("groups", got, "shells that are no composites, or beams", _OTHERWISE)
                found.add(float(section.numbers(0)[0]))
                continue
            kind = "DENSITY" if quantity == "density" else "ELASTIC"
            own = [c for c in self.materials.get(section.named("MATERIAL"), ()) if c.keyword == kind]
            if not own or (quantity != "density" and own[0].named("TYPE")[:3] not in _MODULI):
                got = f"{quantity} of the material {section.parameters.get('MATERIAL', '(none)')!r}"
                reject("groups", got, f"a material with *{kind}", _OTHERWISE)
            found.add(float(own[0].numbers(0)[0]))
        return found.pop() if len(found) == 1 else None

    def scaled(self, groups: Groups, factors: Mapping[str, float], end: int | None = None) -> Iterator[str]:
        """The cards up to one, or all, with the value of each group (quantity, elements) times its factor.

        Sections are written in the same pieces whatever the factors are, so that the code does the same.
        """
        of: defaultdict[int, list[str]] = defaultdict(list)
        for name, (_, elements) in groups.items():
            for element in elements:
                of[element].append(name)
        pieces: defaultdict[int, defaultdict[tuple[str, ...], list[int]]]
        pieces = defaultdict(lambda: defaultdict(list))
        for element, i in self.section_of.items():
            pieces[i][tuple(of[element])].append(element)
        for i, card in enumerate(self.cards[:end]):
            if i in pieces and any(pieces[i]):
                for nth, (names, elements) in enumerate(pieces[i].items()):
                    scales = {groups[name][0]: factors.get(name, 1.0) for name in names}
                    yield from self._piece(card, f"ANTIRES-{i}-{nth}", elements, scales)
            else:
                yield card.text()

    def text(self, groups: Groups, factors: Mapping[str, float]) -> str:
        """The input that stores the matrices of the model with scaled values."""
        chosen, procedure = self._step()
        written = [*self.scaled(groups, factors, chosen)]
        written.append("*STEP\n" if chosen is None or not procedure else self.cards[chosen].text())
        if chosen is not None:
            for card in self.cards[chosen + 1 :]:
                if card.keyword == "END STEP":
                    break
                if card.keyword == "BOUNDARY":  # loads do not count, nor what is written
                    written.append(card.text())
        written.append("*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n")
        shells = (nodes for kind, nodes in self._elements.values() if _EXPANDED.match(kind))
        expanded = {node for nodes in shells for node in nodes}
        if expanded:
            written.append("*CLOAD\n")
            written += (f"{node},{axis},0.\n" for node in sorted(expanded) for axis in (1, 2, 3))
        return "".join((*written, "*END STEP\n"))

    def _step(self) -> tuple[int | None, bool]:
        """The step of the frequencies, or else the first: its supports count; and whether it is of these."""
        steps = [i for i, card in enumerate(self.cards) if card.keyword == "STEP"]
        for i, end in zip(steps, [*steps, len(self.cards)][1:], strict=True):
            if any(card.keyword == "FREQUENCY" for card in self.cards[i:end]):
                return i, True
        return (steps[0] if steps else None), False

    def _piece(
        self, section: Card, name: str, elements: list[int], scales: dict[str, float]
    ) -> Iterator[str]:
        rows = (elements[at : at + _PER_LINE] for at in range(0, len(elements), _PER_LINE))
        yield f"*ELSET, ELSET={name}\n" + "".join(", ".join(map(str, row)) + "\n" for row in rows)
        changed, lines = {"ELSET": name}, list(section.lines)
        if "youngs_modulus" in scales or "density" in scales:
            changed["MATERIAL"] = name
            yield f"*MATERIAL, NAME={name}\n"
            for card in self.materials[section.named("MATERIAL")]:
                yield card.text(lines=_scaled(card, scales))
        if "thickness" in scales:
            first, *rest = section.numbers(0)
            count = 2 if section.keyword == "BEAM SECTION" else 1
            fields = [_times(each, scales["thickness"]) for each in [first, *rest][:count]]
            lines[0] = ", ".join([*fields, *rest[count - 1 :]])
        yield section.text(changed, lines)


_OTHERWISE = "Give a group of other elements, or of another quantity: 'NAME:density'."


def _times(field: str, factor: float) -> str:
    """A number times a factor, in the 20 columns that CalculiX reads of a field."""
    value = float(field) * factor
    return field if factor == 1.0 else repr(value) if len(repr(value)) <= 18 else f"{value:.12e}"


def _scaled(card: Card, scales: Mapping[str, float]) -> list[str]:
    """The lines of a card of a material with moduli or densities times factors."""
    density = card.keyword == "DENSITY"
    if card.keyword != "ELASTIC" and not density:
        return card.lines
    factor = scales.get("density" if density else "youngs_modulus", 1.0)
    size, moduli = (2, (0,)) if density else _MODULI[card.named("TYPE")[:3]]
    rows, first = [], 0
    for i in range(len(card.lines)):
        row = card.numbers(i)
        rows.append([_times(x, factor) if (first + at) % size in moduli else x for at, x in enumerate(row)])
        first += len(row) if size > 8 else 0  # those of few constants have a line for each temperature
    return [", ".join(row) for row in rows]


# -- What it stores


def stored(folder: Path, stem: str, nodes: frozenset[int]) -> tuple[Any, Any, tuple[str, ...]]:
    """Stiffness, mass and names of the rows; of a row of a layer or a knot a name that is no node's."""
    labels: list[str] = []
    seen: defaultdict[str, int] = defaultdict(int)
    for line in (folder / f"{stem}.dof").read_text().split():
        node, _, code = line.partition(".")
        label = f"{node}:{DIRECTIONS[int(code)].removeprefix('+')}"
        if int(node) not in nodes:
            label = f"knot {node} {code}"
        seen[label] += 1
        labels.append(label if seen[label] == 1 else f"{label}, layer {seen[label]}")
    matrices = []
    for ending in (".sti", ".mas"):
        rows = np.loadtxt(folder / f"{stem}{ending}", ndmin=2)
        if rows.shape[1:] != (3,) or rows[:, :2].max(initial=1) > len(labels):
            raise ValueError(f"{ending} does not fit the {len(labels)} rows of .dof")
        i, k = (rows[:, axis].astype(np.int64) - 1 for axis in (0, 1))
        matrices.append(completed(i, k, rows[:, 2], len(labels)))
    return matrices[0], matrices[1], tuple(labels)


def errors_in(said: str) -> str:
    """What CalculiX calls an error in its output, in one line."""
    at = said.find("*ERROR")
    return " ".join(said[at : at + 300].split()) if at >= 0 else "it wrote no matrices"
