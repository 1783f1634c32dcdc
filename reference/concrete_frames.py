"""Concrete frames as structural programs export them: lumped masses, rotations without mass, rigid slabs.

The mass of all that hangs on a node is lumped in its three translations; the nodes of a floor move together
in its plane, by penalties; the terms are the stiffness of groups of members. Of what a frame consists is told
by a :class:`Skeleton`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from antires_rs import FrameModel, Rectangle

#: Concrete: Young's modulus (Pa) and density (kg/m3).
CONCRETE_PA, CONCRETE_KG_PER_M3 = 3.0e10, 2500.0
#: Stiffness of the penalties against the largest entry of the members.
RIGID = 30.0
DIRECTIONS = ("u", "v", "w", "rx", "ry", "rz")

Dofs = dict[tuple[int, str], int]


class Concrete(NamedTuple):
    """Matrices of the free dofs, terms of groups, the dof of (node, direction), heads and nodes by floor."""

    stiffness: Any
    mass: Any
    terms: list[Any]
    groups: list[str]
    dof: Dofs
    heads: np.ndarray
    floors: list[list[int]]


class Skeleton:
    """Nodes, elements with their groups, the nodes of each floor and the extra mass of each node, kg."""

    def __init__(self) -> None:
        self.nodes: list[np.ndarray] = []
        self.elements: list[tuple[int, int]] = []
        self.groups: list[str] = []
        self.floors: list[list[int]] = []
        self.held: set[int] = set()
        self.extra_kg: dict[int, float] = {}
        #: Column heads, a row for each floor, the lowest first.
        self.heads: np.ndarray = np.empty((0, 0), dtype=int)

    def size_of(self, group: str) -> tuple[float, float]:
        """Width and height of a member's section, m."""
        raise NotImplementedError

    def density(self, group: str) -> float:
        """What a member weighs, kg/m3."""
        return CONCRETE_KG_PER_M3

    def node(self, place: np.ndarray) -> int:
        """A new node, by its number."""
        self.nodes.append(place)
        return len(self.nodes) - 1

    def member(self, first: int, second: int, group: str, parts: int) -> list[int]:
        """A straight member of ``parts`` elements; the nodes between its ends."""
        ends = self.nodes[first], self.nodes[second]
        between = [self.node(ends[0] + (ends[1] - ends[0]) * i / parts) for i in range(1, parts)]
        chain = [int(first), *between, int(second)]
        self.elements += list(zip(chain[:-1], chain[1:], strict=True))
        self.groups += [group] * parts
        return between

    def frame(self, factors: dict[str, float]) -> FrameModel:
        """The bare frame, the modulus of some groups changed."""
        sections = {
            group: Rectangle(*self.size_of(group), CONCRETE_PA * factors.get(group, 1.0), CONCRETE_KG_PER_M3)
            for group in set(self.groups)
        }
        fixed = [(node, direction) for node in sorted(self.held) for direction in DIRECTIONS]
        return FrameModel(self.nodes, self.elements, [sections[g] for g in self.groups], fixed=fixed)


def assembled(skeleton: Skeleton) -> Concrete:
    """The matrices that a structural program would export."""
    nominal, groups = skeleton.frame({}), sorted(set(skeleton.groups))
    free = [node for node in range(len(skeleton.nodes)) if node not in skeleton.held]
    dof = {(node, direction): nominal.dof(node, direction) for node in free for direction in DIRECTIONS}
    stiffness = sp.csc_array(nominal.stiffness())
    terms = [sp.csc_array(skeleton.frame({group: 2.0}).stiffness()) - stiffness for group in groups]
    rigid = RIGID * abs(stiffness).max() * _slabs(skeleton, dof, stiffness.shape[0])
    mass = sp.diags_array(_lumped(skeleton, dof, stiffness.shape[0])).tocsc()
    return Concrete(
        sp.csc_array(stiffness + rigid), mass, terms, groups, dof, skeleton.heads, skeleton.floors
    )


def _lumped(skeleton: Skeleton, dof: Dofs, n: int) -> np.ndarray:
    """Mass of each dof, kg: half of every element and what else hangs on the node."""
    mass = np.zeros(n)
    own = {node: skeleton.extra_kg.get(node, 0.0) for node in range(len(skeleton.nodes))}
    for (first, second), group in zip(skeleton.elements, skeleton.groups, strict=True):
        length = float(np.linalg.norm(skeleton.nodes[first] - skeleton.nodes[second]))
        weight = skeleton.density(group) * float(np.prod(skeleton.size_of(group))) * length
        for node in (first, second):
            own[node] += 0.5 * weight
    for (node, direction), number in dof.items():
        if direction in ("u", "v", "w"):
            mass[number] = own[node]
    return mass


def _slabs(skeleton: Skeleton, dof: Dofs, n: int) -> Any:
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
