"""Structures that the package's models do not describe: what they lack is no stiffness or mass factor.

Truths are assembled by reference/timoshenko.py, models as a user would make them. Every stiffness and mass of
a truth is off by 1 to 3 % (standard deviation, drawn for each truth), supports and joints by 20 %. Beside it
the model lacks

- ``building``: sway and rocking of the base, with its dampers;
- ``portal``: its joints and feet turn;
- ``cantilever``: a support spring, and damage is a crack: a hinge anywhere along an element;
- ``grillage``: springs at the corners, lumps where beams cross; it is symmetric;
- ``elastic_beam``: shear and mesh only, but its springs do not follow when the beam warms;
- ``pipe``: its flange turns; cracks only;
- ``truss``: its bars' masses are lumped at the joints, which have gussets; the roller yields.

Limits in the package may be set on ``building``, ``grillage`` and ``elastic_beam``; ``portal``,
``cantilever``, ``truss`` and ``pipe`` judge, and nothing is tuned on them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

import antires_rs as ar
from reference.timoshenko import Assembly, Bar, ThinTube

#: Standard deviations of a truth's factors lie between these; of its supports and joints.
LEAST_OFF, MOST_OFF, CONNECTIONS_OFF = 0.01, 0.03, 0.2
#: Factors further off than so many standard deviations are drawn no further.
_FURTHEST = 2.5


@dataclass(frozen=True)
class Own:
    """Factors of one truth against the nominal structure."""

    stiffness: np.ndarray
    mass: np.ndarray
    connections: np.ndarray  # of supports, joints and whatever the model lacks


@dataclass(frozen=True)
class Crack:
    """A hinge at a share of an element's length, as flexible as this loss of the element's stiffness."""

    element: int
    share: float
    loss: float


@dataclass(frozen=True)
class State:
    """How a structure differs from its intact state; stiffness losses by element, support and joint."""

    losses: Mapping[int, float] = field(default_factory=dict)
    cracks: tuple[Crack, ...] = ()
    added_kg: Mapping[int, float] = field(default_factory=dict)  # by node
    supports: Mapping[int, float] = field(default_factory=dict)
    joints: Mapping[int, float] = field(default_factory=dict)
    moved: int | None = None  # position of the sensor that is half an element away
    warmer: tuple[float, float] = (0.0, 0.0)  # relative change of E: of all, and more at the far end


class Structure:
    """A truth, the model of it, and where it is measured; elements are numbered as in the model."""

    name: str
    sets_limits: bool
    band_hz: tuple[float, float]
    n_elements: int
    n_supports: int
    #: Dof of the force in the model, and those of the sensors.
    force: int
    dofs: tuple[int, ...]
    #: Nodes that may get a mass (at the driven one it moves no zero); elements that meet at each joint.
    nodes: tuple[int, ...]
    joints: tuple[frozenset[int], ...]
    #: Whether an element can have a crack, and nothing else that is looked at.
    beams, cracks_alone = True, False
    #: Number in the model of an element beside the candidates that is this support.
    support_elements: Mapping[int, int] = {}

    @cached_property
    def model(self) -> ar.MassSpringChain | ar.FrameModel | ar.MatrixModel:
        """As a user makes it, with nominal values."""
        raise NotImplementedError

    @property
    def elements(self) -> list[int]:
        """Candidates."""
        return list(range(self.n_elements))

    @property
    def along(self) -> np.ndarray:
        """Position of each element between -1 and 1, by which a gradient of temperature goes."""
        raise NotImplementedError

    def drawn(self, rng: np.random.Generator) -> Own:
        """Factors of a truth."""
        off = rng.uniform(LEAST_OFF, MOST_OFF, 2)
        parts = [
            1.0 + size * np.clip(rng.standard_normal(n), -_FURTHEST, _FURTHEST)
            for size, n in ((off[0], self.n_elements), (off[1], self.n_elements), (CONNECTIONS_OFF, 12))
        ]
        return Own(*parts)

    def assembled(self, own: Own, state: State) -> Any:
        """Matrices of the truth in a state."""
        raise NotImplementedError

    def sensor(self, position: int, moved: bool) -> Mapping[Any, float]:
        """What a sensor reads."""
        raise NotImplementedError

    @property
    def drive(self) -> Mapping[Any, float]:
        """Where the force acts."""
        return self.sensor(self.dofs.index(self.force), False)

    @property
    def total_kg(self) -> float:
        """Nominal mass."""
        raise NotImplementedError

    def beside(self, element: int, end: int) -> int | None:
        """The element that goes on where this one ends, 0 or 1."""
        return None

    def truth(self, own: Own, state: State | None = None) -> dict[int, np.ndarray]:
        """Exact antiresonances in band, by dof of the model."""
        state = state or State()
        sensors = [self.sensor(at, at == state.moved) for at in range(len(self.dofs))]
        found = self.assembled(own, state).antiresonances(sensors, self.drive, self.band_hz)
        return dict(zip(self.dofs, found, strict=True))

    @cached_property
    def telling(self) -> list[int]:
        """Positions of sensors that have two values or more: where one has none its place does not matter."""
        nominal = Own(np.ones(self.n_elements), np.ones(self.n_elements), np.ones(12))
        return [at for at, freq in enumerate(self.truth(nominal).values()) if freq.size > 1]

    def stiffness_now(self, own: Own, state: State) -> np.ndarray:
        """Factor of each element's stiffness, losses and temperature included."""
        losses = np.array([state.losses.get(e, 0.0) for e in range(self.n_elements)])
        uniform, gradient = state.warmer
        return own.stiffness * (1.0 - losses) * (1.0 + uniform + gradient * self.along)

    def _supports_now(self, own: Own, state: State, stiffnesses: tuple[float, ...]) -> np.ndarray:
        """Stiffness of each support, which no temperature changes."""
        losses = np.array([state.supports.get(i, 0.0) for i in range(len(stiffnesses))])
        return np.array(stiffnesses) * own.connections[: len(stiffnesses)] * (1.0 - losses)


def measured(structure: Structure, exact: Mapping[int, np.ndarray], std: float, rng) -> ar.AntiresonanceSet:
    """Exact values with relative Gaussian errors, stated as they are."""
    freq = {dof: np.sort(f * (1.0 + std * rng.standard_normal(f.size))) for dof, f in exact.items()}
    return ar.AntiresonanceSet(structure.force, freq, std_hz={dof: std * f for dof, f in freq.items()})


# -- The building: storeys that shear, on ground that yields; the model is a chain on rigid ground


class Building(Structure):
    """Floors sway and tilt with the base; element 9 of the model's chain is the lowest storey."""

    name, sets_limits, beams = "building", True, False
    band_hz = (0.3, 9.0)
    floors, storey_m, floor_kg = 10, 3.2, 4.0e4
    n_elements, n_supports = floors, 2
    force, dofs, nodes = 6, tuple(range(floors)), (0, 1, 2, 3, 4, 5, 7, 8, 9)
    storeys_n_per_m = (1.6e8,) * 3 + (1.2e8,) * 3 + (0.8e8,) * 4
    #: Mass, half width, springs and dashpots of the base; damping in proportion to mass and stiffness.
    base_kg, half_m = 6.0e4, 6.0
    base_n, base_c = (3.0e8, 1.5e11), (2.0e6, 6.0e8)
    of_mass, of_stiffness = 0.14, 3.5e-4

    @cached_property
    def model(self):
        return ar.MassSpringChain(
            [self.floor_kg] * self.floors,
            self.storeys_n_per_m[1:],
            ground_first_n_per_m=self.storeys_n_per_m[0],
        )

    @property
    def total_kg(self):
        return self.floors * self.floor_kg

    def _storey(self, element: int) -> int:
        return (element + 1) % self.floors

    @property
    def along(self):
        return np.array([2.0 * self._storey(e) / (self.floors - 1) - 1.0 for e in self.elements])

    @property
    def joints(self):
        """Floors: beams to columns of both storeys."""
        return tuple(frozenset(((s - 1) % self.floors, s)) for s in range(self.floors - 1))

    def assembled(self, own, state):
        one = Assembly()
        stiffness = self.stiffness_now(own, state)
        for floor, loss in state.joints.items():
            for element in self.joints[floor]:
                stiffness[element] *= 1.0 - 0.5 * loss
        ground = self._supports_now(own, state, self.base_n)
        for dof, k, c in zip(((-1, "u"), (-1, "tilt")), ground, self.base_c, strict=True):
            one.link(dof, k, c)
        self._floor(one, -1, self.base_kg)
        for element in self.elements:
            storey = self._storey(element)
            # What shears the storey: motion of its upper floor beyond the lower one, less the tilt of both.
            drift = np.array([[-1.0, 1.0, -self.storey_m]])
            k = self.storeys_n_per_m[storey] * stiffness[element] * drift.T @ drift
            one.add([(storey - 1, "u"), (storey, "u"), (-1, "tilt")], k=k, c=self.of_stiffness * k)
            self._floor(one, storey, self.floor_kg * own.mass[element] + state.added_kg.get(storey, 0.0))
        return one.free()

    def _floor(self, one, node, kg):
        for dof, inertia in (((node, "u"), kg), ((-1, "tilt"), kg * self.half_m**2 / 3.0)):
            one.add([dof], m=inertia, c=self.of_mass * inertia)

    def sensor(self, position, moved):
        if not moved:
            return {(position, "u"): 1.0}
        other = position + 1 if position + 1 < self.floors else position - 1
        return {(position, "u"): 0.5, (other, "u"): 0.5}


# -- Frames: every element in two of the truth, four where it has cracks


class Frame(Structure):
    """Beams of one section between nodes; the truth has nodes also in the middle of the elements."""

    places: tuple[tuple[float, float], ...]
    lines: tuple[tuple[int, int], ...]  # nodes of each element
    section: Bar
    #: Node and direction of each sensor in the model.
    sensors: tuple[tuple[int, str], ...]
    directions = ("u", "v", "theta")

    @property
    def n_elements(self):
        return len(self.lines)

    @cached_property
    def dofs(self):
        return tuple(self.model.dof(*each) for each in self.sensors)

    @property
    def total_kg(self):
        return self.section.rho * self.section.area_m2 * sum(map(self._length, range(self.n_elements)))

    @property
    def along(self):
        """From one end of the longer side to the other."""
        middles = np.array([np.mean([self.places[n] for n in line], axis=0) for line in self.lines])
        long = middles[:, int(np.argmax(np.ptp(middles, axis=0)))]
        return 2.0 * (long - long.min()) / np.ptp(long) - 1.0

    @cached_property
    def joints(self):
        """Nodes where one element goes on in the next: a splice."""
        return tuple(frozenset((e, on)) for e in self.elements if (on := self.beside(e, 1)) is not None)

    def beside(self, element, end):
        start, at = (np.array(self.places[self.lines[element][i]]) for i in (1 - end, end))
        for other, line in enumerate(self.lines):
            if other == element or self.lines[element][end] not in line:
                continue
            far = line[1] if line[0] == self.lines[element][end] else line[0]
            onward = np.array(self.places[far]) - at
            turned = np.cross(np.append(at - start, 0.0), np.append(onward, 0.0))[2]
            if abs(turned) < 1e-9 and onward @ (at - start) > 0.0:
                return other
        return None

    def _hinges(self, own, state):
        """Springs between an element and its node, by (element, end)."""
        found = {}
        for joint, loss in state.joints.items():
            element = min(self.joints[joint])
            found[element, 1] = self.section.hinge_n_m(self._length(element), loss)
        return found

    def _length(self, element):
        return float(np.hypot(*np.subtract(*(self.places[n] for n in self.lines[element]))))

    def _connect(self, one, own, state):
        """Supports and lumps."""
        raise NotImplementedError

    held: tuple[Any, ...] = ()

    def assembled(self, own, state):
        one = Assembly()
        stiffness, hinges = self.stiffness_now(own, state), self._hinges(own, state)
        beam = one.plane_beam if "u" in self.directions else one.grid_beam
        for element, line in enumerate(self.lines):
            section = self.section.off(stiffness[element], own.mass[element])
            ends = [np.array(self.places[node]) for node in line]
            length = self._length(element)
            cracks = {
                c.share: self.section.hinge_n_m(length, c.loss) for c in state.cracks if c.element == element
            }
            shares = sorted({0.0, 0.5, 1.0, *cracks})
            names = [line[0], *((element, s) for s in shares[1:-1]), line[1]]
            for nth, share in enumerate(shares[:-1]):
                turning = {0: cracks[share]} if share in cracks else {}
                for end, at in ((0, 0), (1, len(shares) - 2)):
                    if nth == at and (element, end) in hinges:
                        turning[end] = hinges[element, end]
                part = [ends[0] + s * (ends[1] - ends[0]) for s in shares[nth : nth + 2]]
                beam(tuple(names[nth : nth + 2]), part, section, turning)
        for node, kg in state.added_kg.items():
            self._lump(one, node, kg)
        self._connect(one, own, state)
        return one.free(self.held)

    def _lump(self, one, node, kg):
        for name in self.directions:
            if name in ("u", "v", "w"):
                one.add([(node, name)], m=kg)

    def sensor(self, position, moved):
        node, direction = self.sensors[position]
        if moved:
            element = next(e for e, line in enumerate(self.lines) if node in line)
            return {((element, 0.5), direction): 1.0}
        return {(node, direction): 1.0}

    @property
    def bar(self):
        """The model's section, without shear."""
        one = self.section
        return ar.Rectangle(one.width_m, one.height_m, one.e_pa, one.rho)


class Portal(Frame):
    """Columns of three elements, a beam of four; corners and feet are springs of the truth."""

    name, sets_limits = "portal", False
    band_hz = (5.0, 330.0)
    section = Bar(0.05, 0.02)
    height_m, span_m = 1.2, 1.6
    places = (
        *((0.0, 0.4 * i) for i in range(3)),
        *((0.4 * i, 1.2) for i in range(5)),
        *((1.6, 0.8 - 0.4 * i) for i in range(3)),
    )
    lines = tuple((i, i + 1) for i in range(10))
    nodes = (1, *range(3, 10))
    sensors = ((1, "u"), (2, "u"), (3, "u"), (4, "v"), (5, "v"), (6, "v"), (8, "u"), (9, "u"))
    #: Springs of corners and feet over EI / L of beam and column.
    corner, foot = 12.0, 20.0
    n_supports = 2

    @cached_property
    def model(self):
        return ar.FrameModel(self.places, self.lines, self.bar, fixed=[0, 10])

    @property
    def force(self):
        return self.model.dof(2, "u")

    @property
    def joints(self):
        """The corners."""
        return (frozenset((2, 3)), frozenset((6, 7)))

    held = ((0, "u"), (0, "v"), (10, "u"), (10, "v"))

    def _hinges(self, own, state):
        corner = self.corner * self.section.ei / self.span_m
        losses = [state.joints.get(i, 0.0) for i in range(2)]
        return {
            (3, 0): corner * own.connections[2] * (1.0 - losses[0]),
            (6, 1): corner * own.connections[3] * (1.0 - losses[1]),
        }

    def _connect(self, one, own, state):
        foot = self.foot * self.section.ei / self.height_m
        feet = self._supports_now(own, state, (foot, foot))
        for node, stiffness in zip((0, 10), feet, strict=True):
            one.link((node, "theta"), stiffness)


class Cantilever(Frame):
    """Ten elements; a spring that the model has not holds node 7. Damage is cracks."""

    name, sets_limits = "cantilever", False
    band_hz = (3.0, 600.0)
    section = Bar(0.04, 0.008)
    places = tuple((0.1 * i, 0.0) for i in range(11))
    lines = tuple((i, i + 1) for i in range(10))
    nodes = tuple(range(1, 10))
    sensors = tuple((n, "v") for n in (2, 3, 4, 5, 6, 8, 9, 10))
    #: The spring over 3 EI / L^3.
    spring_at, spring = 7, 1.0
    n_supports = 1
    held = tuple((0, name) for name in ("u", "v", "theta"))

    @cached_property
    def model(self):
        return ar.FrameModel(self.places, self.lines, self.bar, fixed=[0])

    @property
    def force(self):
        return self.model.dof(10, "v")

    def _connect(self, one, own, state):
        (stiffness,) = self._supports_now(own, state, (self.spring * 3.0 * self.section.ei,))
        one.link((self.spring_at, "v"), stiffness)


class ElasticBeam(Frame):
    """A beam of ten elements on four springs, which are in the model too."""

    name, sets_limits = "elastic_beam", True
    band_hz = (2.0, 230.0)
    section = Bar(0.06, 0.03)
    places = tuple((0.3 * i, 0.0) for i in range(11))
    lines = tuple((i, i + 1) for i in range(10))
    nodes = (0, *range(2, 11))
    sensors = tuple((n, "v") for n in (0, 1, 2, 4, 5, 6, 8, 10))
    supported, spring_n_per_m = (0, 3, 7, 10), 6.0e4
    n_supports = 4
    support_elements = {i: 10 + i for i in range(4)}
    held = tuple((n, "u") for n in range(11))

    @cached_property
    def model(self):
        springs = [ar.GroundSpring(node, "v", self.spring_n_per_m) for node in self.supported]
        return ar.FrameModel(self.places, self.lines, self.bar, ground_springs=springs, fixed=self.held)

    @property
    def force(self):
        return self.model.dof(1, "v")

    def _connect(self, one, own, state):
        found = self._supports_now(own, state, (self.spring_n_per_m,) * 4)
        for node, stiffness in zip(self.supported, found, strict=True):
            one.link((node, "v"), stiffness)


class Grillage(Frame):
    """Four beams across three, held at the corners; nodes are numbered along y, then x."""

    name, sets_limits = "grillage", True
    band_hz = (3.0, 150.0)
    section = Bar(0.04, 0.012)
    places = tuple((0.4 * i, 0.5 * j) for i in range(4) for j in range(3))
    lines = (
        *((3 * i + j, 3 * i + j + 3) for i in range(3) for j in range(3)),
        *((3 * i + j, 3 * i + j + 1) for i in range(4) for j in range(2)),
    )
    directions = ("w", "x", "y")
    corners = (0, 2, 9, 11)
    nodes = (1, 3, 5, 6, 7, 8, 10)
    sensors = tuple((n, "w") for n in (1, 3, 4, 5, 6, 7, 8))
    #: Springs of the truth at the corners, and the lump at every crossing.
    corner_n_per_m, crossing_kg = 2.0e6, 0.04
    n_supports = 4

    @cached_property
    def model(self):
        fixed = [(n, (*("u", "v", "rz"), *(("w",) if n in self.corners else ()))) for n in range(12)]
        places = [(*place, 0.0) for place in self.places]
        return ar.FrameModel(places, self.lines, self.bar, fixed=fixed)

    @property
    def force(self):
        return self.model.dof(4, "w")

    def _connect(self, one, own, state):
        for node in range(12):
            self._lump(one, node, self.crossing_kg)
        found = self._supports_now(own, state, (self.corner_n_per_m,) * 4)
        for node, stiffness in zip(self.corners, found, strict=True):
            one.link((node, "w"), stiffness)


# -- The truss: pin-jointed, so its model is one of matrices


class Truss(Structure):
    """Eight bays of a metre, 29 bars, pinned at joint 0, on a roller at joint 8; joints 9 to 15 on top."""

    name, sets_limits, beams = "truss", False, False
    band_hz = (5.0, 200.0)
    area_m2, e_pa, rho = 4.0e-4, 2.1e11, 7850.0
    places = (*((float(i), 0.0) for i in range(9)), *((float(i), 1.0) for i in range(1, 8)))
    lines = (
        *((i, i + 1) for i in range(8)),  # bottom
        *((i, i + 1) for i in range(9, 15)),  # top
        *((i, i + 8) for i in range(1, 8)),  # upright
        *((0, 9), (9, 2), (10, 3), (11, 4), (4, 13), (5, 14), (6, 15), (15, 8)),
    )
    #: Of every joint: known to the model; and not.
    carried_kg, gusset_kg = 8.0, 0.3
    roller_n_per_m = 4.0e8
    n_elements, n_supports = 29, 1
    fixed = ((0, "u"), (0, "v"), (8, "v"))
    sensors = (
        (1, "v"),
        (2, "v"),
        (3, "v"),
        (4, "v"),
        (5, "v"),
        (6, "v"),
        (7, "v"),
        (11, "u"),
        (12, "v"),
        (13, "v"),
    )
    nodes = (1, 2, *range(4, 8), *range(9, 16))

    @property
    def _free(self):
        every = [(node, name) for node in range(16) for name in ("u", "v")]
        return [each for each in every if each not in self.fixed]

    @cached_property
    def dofs(self):
        return tuple(self._free.index(each) for each in self.sensors)

    @property
    def force(self):
        return self._free.index((3, "v"))

    @property
    def total_kg(self):
        return 16 * self.carried_kg + self.rho * self.area_m2 * sum(self._unit(e)[1] for e in self.elements)

    @property
    def along(self):
        middle = np.array([np.mean([self.places[n][0] for n in line]) for line in self.lines])
        return middle / 4.0 - 1.0

    @cached_property
    def joints(self):
        """Joints whose bars all slip."""
        return tuple(frozenset(e for e, line in enumerate(self.lines) if node in line) for node in self.nodes)

    def _unit(self, element):
        along = np.subtract(*(self.places[n] for n in self.lines[element][::-1]))
        length = float(np.hypot(*along))
        return along / length, length

    @cached_property
    def model(self):
        free = {each: at for at, each in enumerate(self._free)}
        terms, mass = [], self.carried_kg * np.eye(len(free))
        for element, line in enumerate(self.lines):
            unit, length = self._unit(element)
            names = [(node, name) for node in line for name in ("u", "v")]
            stretch = np.array([*-unit, *unit])
            whole = self.e_pa * self.area_m2 / length * np.outer(stretch, stretch)
            own = self.rho * self.area_m2 * length / 6.0 * np.kron([[2.0, 1.0], [1.0, 2.0]], np.eye(2))
            kept = [i for i, name in enumerate(names) if name in free]
            rows = np.ix_(*([[free[names[i]] for i in kept]] * 2))
            term = np.zeros_like(mass)
            term[rows] = whole[np.ix_(kept, kept)]
            mass[rows] += own[np.ix_(kept, kept)]
            terms.append(term)
        return ar.MatrixModel(sum(terms), mass, stiffness_terms=terms)

    def assembled(self, own, state):
        one = Assembly()
        stiffness = self.stiffness_now(own, state)
        for joint, loss in state.joints.items():
            stiffness[list(self.joints[joint])] *= 1.0 - loss
        for element, line in enumerate(self.lines):
            unit, length = self._unit(element)
            names = [(node, name) for node in line for name in ("u", "v")]
            stretch = np.array([[*-unit, *unit]])
            one.add(names, k=stiffness[element] * self.e_pa * self.area_m2 / length * stretch.T @ stretch)
            half = own.mass[element] * self.rho * self.area_m2 * length / 2.0
            one.add(names, m=half * np.eye(4))
        for node in range(16):
            kg = self.carried_kg + self.gusset_kg + state.added_kg.get(node, 0.0)
            one.add([(node, "u"), (node, "v")], m=kg * np.eye(2))
        (roller,) = self._supports_now(own, state, (self.roller_n_per_m,))
        one.link((8, "v"), roller)
        return one.free(self.fixed[:2])

    def sensor(self, position, moved):
        node, name = self.sensors[position]
        if not moved:
            return {(node, name): 1.0}
        line = next(line for line in self.lines if node in line)
        return {(end, name): 0.5 for end in line if (end, name) not in self.fixed[:2]}

    @property
    def drive(self):
        return {(3, "v"): 1.0}


# -- A bent pipe, as of an exhaust: cracks alone


class Pipe(Frame):
    """A pipe with two bends in its plane, on hangers that the model has; its flange turns."""

    name, sets_limits, cracks_alone = "pipe", False, True
    band_hz = (4.0, 600.0)
    section = ThinTube(0.0015, 0.0485)
    places = (
        *((0.2 * i, 0.0) for i in range(4)),
        *((0.6 + 0.16 * i, 0.12 * i) for i in range(1, 3)),
        *((0.92 + 0.2 * i, 0.24) for i in range(1, 7)),
    )
    lines = tuple((i, i + 1) for i in range(11))
    nodes = tuple(range(1, 12))
    sensors = ((1, "v"), (2, "v"), (3, "v"), (4, "u"), (5, "v"), (6, "v"), (7, "v"), (9, "v"), (11, "v"))
    hung, hanger_n_per_m, flange = (3, 6, 10), 4.0e4, 25.0
    n_supports = 3
    held = ((0, "u"), (0, "v"))

    @cached_property
    def model(self):
        springs = [ar.GroundSpring(node, "v", self.hanger_n_per_m) for node in self.hung]
        return ar.FrameModel(self.places, self.lines, self.bar, ground_springs=springs, fixed=[0])

    @property
    def bar(self):
        one = self.section
        return ar.Tube(one.height_m + one.width_m, one.width_m, one.e_pa, one.rho)

    @property
    def force(self):
        return self.model.dof(11, "v")

    def _connect(self, one, own, state):
        found = self._supports_now(own, state, (self.hanger_n_per_m,) * 3)
        for node, stiffness in zip(self.hung, found, strict=True):
            one.link((node, "v"), stiffness)
        one.link((0, "theta"), self.flange * self.section.ei / 1.0 * own.connections[3])


#: By name.
STRUCTURES: dict[str, Structure] = {
    kind.name: kind() for kind in (Building, ElasticBeam, Grillage, Portal, Cantilever, Truss, Pipe)
}
