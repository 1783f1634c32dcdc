"""A concrete building as structural programs export it: lumped masses, rotations without mass, rigid slabs.

Storeys of columns and beams, each in two elements; the nodes of a floor move together in its plane, by
penalties; the mass of all that hangs on a node is lumped in its three translations. The terms are the
stiffness of twelve groups: columns at corners, edges and inside, and beams, of the lower, middle and upper
storeys.
"""

from __future__ import annotations

from itertools import product
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from antires_rs import FrameModel, Rectangle

#: Concrete: Young's modulus (Pa) and density (kg/m3); mass of a floor beside its beams (kg/m2).
CONCRETE_PA, CONCRETE_KG_PER_M3, FLOOR_KG_PER_M2 = 3.0e10, 2500.0, 350.0
STOREY_M, BAY_M = 3.2, 5.5
COLUMN_M, BEAM_M = (0.4, 0.4), (0.3, 0.5)
#: Stiffness of the penalties against the largest entry of the members.
RIGID = 1e3
DIRECTIONS = ("u", "v", "w", "rx", "ry", "rz")

Dofs = dict[tuple[int, str], int]


class Building(NamedTuple):
    """Matrices of the free dofs, terms of groups, the dof of (node, direction), column heads by floor."""

    stiffness: Any
    mass: Any
    terms: list[Any]
    groups: list[str]
    dof: Dofs
    heads: np.ndarray


class _Skeleton:
    """Nodes, members in two elements each, and the nodes of each floor."""

    def __init__(self, bays: tuple[int, int], storeys: int) -> None:
        self.nodes: list[np.ndarray] = []
        self.elements: list[tuple[int, int]] = []
        self.groups: list[str] = []
        nx, ny = bays[0] + 1, bays[1] + 1
        # Bays of unlike lengths, so that no mode is repeated.
        x = BAY_M * np.concatenate([[0.0], np.cumsum(1.0 + 0.07 * np.arange(bays[0]))])
        y = 0.9 * BAY_M * np.concatenate([[0.0], np.cumsum(1.0 + 0.11 * np.arange(bays[1]))])
        self.floor_m2 = float(x[-1] * y[-1])
        places = product(range(storeys + 1), range(nx), range(ny))
        own = [self._node(np.array([x[i], y[j], STOREY_M * s])) for s, i, j in places]
        self.heads = np.array(own).reshape(storeys + 1, nx, ny)
        self.floors: list[list[int]] = []
        for s in range(1, storeys + 1):
            part = ("lower", "middle", "upper")[3 * (s - 1) // storeys]
            for i, j in product(range(nx), range(ny)):
                edges = (i in (0, nx - 1)) + (j in (0, ny - 1))
                kind = ("inside", "edge", "corner")[edges]
                self._member(self.heads[s - 1, i, j], self.heads[s, i, j], f"{kind} columns, {part}")
            floor = self.heads[s]
            pairs = [*zip(floor[:-1].ravel(), floor[1:].ravel(), strict=True)]
            pairs += zip(floor[:, :-1].ravel(), floor[:, 1:].ravel(), strict=True)
            middles = [self._member(first, second, f"beams, {part}") for first, second in pairs]
            self.floors.append([*map(int, floor.ravel()), *middles])

    def _node(self, place: np.ndarray) -> int:
        self.nodes.append(place)
        return len(self.nodes) - 1

    def _member(self, first: int, second: int, group: str) -> int:
        """Two elements; the node between them."""
        middle = self._node(0.5 * (self.nodes[first] + self.nodes[second]))
        self.elements += [(int(first), middle), (middle, int(second))]
        self.groups += [group, group]
        return middle

    def frame(self, factors: dict[str, float]) -> FrameModel:
        """The bare frame, the modulus of some groups changed."""
        sections = [
            Rectangle(*size_of(group), CONCRETE_PA * factors.get(group, 1.0), CONCRETE_KG_PER_M3)
            for group in self.groups
        ]
        fixed = [(int(node), direction) for node in self.heads[0].ravel() for direction in DIRECTIONS]
        return FrameModel(self.nodes, self.elements, sections, fixed=fixed)


def size_of(group: str) -> tuple[float, float]:
    """Width and height of a member's section, m."""
    return BEAM_M if "beams" in group else COLUMN_M


def building(bays: tuple[int, int] = (4, 3), storeys: int = 5) -> Building:
    """By default 2,130 dofs, half of them without mass."""
    skeleton = _Skeleton(bays, storeys)
    nominal, groups = skeleton.frame({}), sorted(set(skeleton.groups))
    held = set(skeleton.heads[0].ravel().tolist())
    free = [node for node in range(len(skeleton.nodes)) if node not in held]
    dof = {(node, direction): nominal.dof(node, direction) for node in free for direction in DIRECTIONS}
    stiffness = sp.csc_array(nominal.stiffness())
    terms = [sp.csc_array(skeleton.frame({group: 2.0}).stiffness()) - stiffness for group in groups]
    rigid = RIGID * abs(stiffness).max() * _slabs(skeleton, dof, stiffness.shape[0])
    mass = sp.diags_array(_lumped(skeleton, dof, stiffness.shape[0])).tocsc()
    heads = skeleton.heads[1:].reshape(storeys, -1)
    return Building(sp.csc_array(stiffness + rigid), mass, terms, groups, dof, heads)


def _lumped(skeleton: _Skeleton, dof: Dofs, n: int) -> np.ndarray:
    """Mass of each dof, kg: half of every element and an equal share of the floor."""
    mass = np.zeros(n)
    own = dict.fromkeys(range(len(skeleton.nodes)), 0.0)
    for (first, second), group in zip(skeleton.elements, skeleton.groups, strict=True):
        length = float(np.linalg.norm(skeleton.nodes[first] - skeleton.nodes[second]))
        for node in (first, second):
            own[node] += 0.5 * CONCRETE_KG_PER_M3 * float(np.prod(size_of(group))) * length
    for floor in skeleton.floors:
        for node in floor:
            own[node] += FLOOR_KG_PER_M2 * skeleton.floor_m2 / len(floor)
    for (node, direction), number in dof.items():
        if direction in ("u", "v", "w"):
            mass[number] = own[node]
    return mass


def _slabs(skeleton: _Skeleton, dof: Dofs, n: int) -> Any:
    """C'C of the equations that tie the nodes of a floor to its first one in the plane."""
    rows: list[dict[int, float]] = []
    for master, *others in skeleton.floors:
        for node in others:
            dx, dy, _ = skeleton.nodes[node] - skeleton.nodes[master]
            turned = dof[master, "rz"]
            rows.append({dof[node, "u"]: 1.0, dof[master, "u"]: -1.0, turned: float(dy)})
            rows.append({dof[node, "v"]: 1.0, dof[master, "v"]: -1.0, turned: -float(dx)})
    entries = [(i, number, value) for i, row in enumerate(rows) for number, value in row.items()]
    i, j, values = zip(*entries, strict=True)
    c = sp.csr_array(sp.coo_array((values, (i, j)), shape=(len(rows), n)))
    return c.T @ c
