"""Shape, sections, masses and hangers of the exhaust: the numbers of the model that is updated.

A surrogate of Fig. 10 of Meruane, J. Sound Vib. 332 (2013) 807-820, which gives the size (2.3 m x 0.45 m,
pipe 38 mm, 47 beams on 48 nodes, 5 lumped inertias, 144 dof) but not the coordinates. Ours is the exhaust of
a small car: front pipe with a catalyst, a link to the side, front muffler, a hump over the axle, a flange
with a weld behind it, the rear pipe into the rear muffler, and two tail pipes. 19 kg, of which 4 kg are pipe.
"""

from __future__ import annotations

import numpy as np

from ..models.frame import FrameModel
from ..models.frame_parts import GroundSpring, PointMass, Tube
from ..support.checks import FloatArray

DIAMETER_M = 0.038
#: Runs of pipe: section, corner nodes are where the previous run ends, (x, y) of its end in m, beams.
#: The last two runs are the second tail pipe, which leaves the rear muffler at node 34.
RUNS: tuple[tuple[str, tuple[float, float], int], ...] = (
    ("front", (0.46, 0.12), 8),  # elements 0 to 7: inlet flange, catalyst
    ("link", (0.70, 0.30), 5),  # 8 to 12: to the side, past the gearbox
    ("middle", (1.22, 0.30), 9),  # 13 to 21: front muffler
    ("axle", (1.34, 0.45), 3),  # 22 to 24: up ...
    ("axle", (1.66, 0.45), 5),  # 25 to 29: ... and over the axle; flange and weld at its end
    ("rear", (1.96, 0.18), 4),  # 30 to 33: into the rear muffler
    ("tail", (2.30, 0.18), 5),  # 34 to 38: first tail pipe
    ("tail", (2.05, 0.05), 3),  # 39 to 41: second tail pipe, from node 34
    ("tail", (2.30, 0.00), 5),  # 42 to 46
)
START_M = (0.0, 0.12)
BRANCH_RUN, BRANCH_NODE = 7, 34

#: Wall thickness in m, Young's modulus in Pa, density in kg/m3: stainless steel in front, aluminised behind.
SECTIONS: dict[str, tuple[float, float, float]] = {
    "front": (0.0015, 2.00e11, 7900.0),
    "link": (0.0015, 2.00e11, 7900.0),
    "middle": (0.0015, 2.00e11, 7900.0),
    "axle": (0.0015, 2.10e11, 7850.0),
    "rear": (0.0020, 2.10e11, 7850.0),
    "tail": (0.0012, 2.10e11, 7850.0),
}
#: Name, node, mass in kg, rotational inertia in kg m2. Bodies of 0.12 to 0.3 m, flanges of 90 mm.
MASSES: tuple[tuple[str, int, float, float], ...] = (
    ("inlet flange", 0, 1.2, 0.0010),
    ("catalyst", 6, 3.2, 0.0150),
    ("front muffler", 18, 4.0, 0.0300),
    ("flange", 30, 0.9, 0.0008),
    ("rear muffler", 34, 5.5, 0.0500),
)
#: Rubber cords: node, stiffness across (v) and along (u) in N/m. Rigid-body modes stay below 5 Hz.
HANGERS: tuple[tuple[int, float, float], ...] = ((2, 1500.0, 500.0), (20, 1500.0, 500.0), (36, 1500.0, 500.0))

#: Shaker at the mouth of the second tail pipe, along the car: every mode up to 300 Hz moves there.
SHAKER: tuple[int, str] = (47, "u")
SENSORS = tuple(  #: Accelerometers, each across its pipe as far as a frame's dofs allow.
    zip((0, 3, 6, 10, 12, 15, 18, 20, 24, 28, 30, 32, 35, 37, 41, 47), "vvvvuvvvuvvuvvuv", strict=True)
)
#: Bends whose angle is uncertain: the run after the pivot rotates, and all behind it.
BENDS: tuple[tuple[str, tuple[int, ...], int], ...] = (
    ("front to link", tuple(range(8, 13)), 8),
    ("middle to axle", tuple(range(22, 25)), 22),
    ("axle to rear", tuple(range(30, 34)), 30),
    ("second tail pipe", tuple(range(39, 42)), BRANCH_NODE),
)


def beams() -> list[tuple[int, int, str]]:
    """First node, second node and section of each beam."""
    found: list[tuple[int, int, str]] = []
    last, new = 0, 1
    for run, (section, _, count) in enumerate(RUNS):
        last = BRANCH_NODE if run == BRANCH_RUN else last
        for _ in range(count):
            found.append((last, new, section))
            last, new = new, new + 1
    return found


def nodes() -> FloatArray:
    """Coordinates, (48, 2), in m: the runs divided evenly."""
    found = [np.array(START_M)]
    last = found[0]
    for run, (_, end, count) in enumerate(RUNS):
        last = found[BRANCH_NODE] if run == BRANCH_RUN else last
        found += [last + (np.array(end) - last) * (i + 1) / count for i in range(count)]
        last = np.array(end)
    return np.array(found)


def hangers(factor: float = 1.0) -> list[GroundSpring]:
    """The rubber cords, their stiffness over the nominal one."""
    return [
        GroundSpring(node, direction, stiffness * factor)
        for node, across, along in HANGERS
        for direction, stiffness in (("v", across), ("u", along))
    ]


def nominal_model() -> FrameModel:
    """The model to be updated: 48 nodes, 144 dofs."""
    tubes = {name: Tube(DIAMETER_M, *wall_and_material) for name, wall_and_material in SECTIONS.items()}
    masses = [PointMass(node, mass, inertia) for _, node, mass, inertia in MASSES]
    return FrameModel(nodes(), beams(), tubes, ground_springs=hangers(), point_masses=masses)
