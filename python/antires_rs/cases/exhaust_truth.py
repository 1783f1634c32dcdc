"""The exhaust that is tested: not the model that is updated.

Its mesh is four times finer. Wall thicknesses, moduli, masses, bends, inertias and cords differ from
nominal; every mode has its own damping. Cracked, it has a rotational spring in the pipe 2 cm behind a weld.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..models.frame import FrameModel
from ..models.frame_parts import GroundSpring, PointMass, Section, Tube
from ..support.checks import ComplexArray, FloatArray, finite_scalar
from . import exhaust_geometry as geometry

# -- Errors of the exhaust's model that no updating parameter can follow

#: Nodes and stiffness (N/m, across) of cords that the model does not know: of a cable, a hose and a strap.
EXTRA_CORDS, CORD_N_PER_M = (10, 26, 43), 1500.0


@dataclass(frozen=True)
class Unfollowed:
    """How far the tested structure is from all that the model could become, as :func:`exhaust` takes it."""

    wall_scatter: float = 0.005
    joint_m: float = 0.0
    shear_coefficient: float | str | None = None
    cord_kg: float = 0.0

    def __post_init__(self) -> None:
        finite_scalar("wall_scatter", self.wall_scatter, low=0.0, high=0.1)
        finite_scalar("joint_m", self.joint_m, low=0.0, high=0.2, unit="m")
        finite_scalar("cord_kg", self.cord_kg, low=0.0, high=1.0, unit="kg")

    @property
    def masses(self) -> list[PointMass]:
        """What the added cords weigh."""
        return [PointMass(node, self.cord_kg) for node in EXTRA_CORDS] if self.cord_kg else []

    @property
    def springs(self) -> list[GroundSpring]:
        """The added cords."""
        return [GroundSpring(node, "v", CORD_N_PER_M) for node in EXTRA_CORDS] if self.cord_kg else []

    def joined(self, second: int) -> bool:
        """Whether an element that ends at this node ends in a flexible joint."""
        return self.joint_m > 0.0 and second in {node for _, node, *_ in geometry.MASSES}


# -- A circumferential through-crack in a thin tube as a rotational spring
#
# The energy that a crack of half-angle :math:`\theta` adds under a moment M is the integral of
# :math:`K_I^2 / E` over its area (two fronts, plane stress), and twice that over M squared its compliance:
#
# .. math:: C = \frac{4}{\pi E R^2 t} \int_0^\theta \vartheta F_b(\vartheta)^2 \, d\vartheta, \qquad
#           K_I = \frac{M}{\pi R^2 t} \sqrt{\pi R \vartheta} \, F_b(\vartheta)
#
# with R the mean radius and t the wall thickness. The factor is Zahoor's, a fit to finite elements for R/t of
# 5 to 20 and cracks up to some 55 % of the perimeter: A. Zahoor, J. Pressure Vessel Technol. 107 (1985)
# 203-205, and Ductile Fracture Handbook, EPRI NP-6301-D (1989); printed in T. L. Anderson, Fracture
# Mechanics, Table 12.29. Longer cracks are extrapolated. The crack is always open; that it also lets the pipe
# stretch is left out.


def bending_factor(share: float, radius_over_wall: float) -> float:
    """Geometry factor ``F_b`` of a crack over ``share`` of the perimeter (0 to 1), for R/t of 5 to 20."""
    ratio = finite_scalar("radius_over_wall", radius_over_wall, low=5.0, high=20.0)
    scale = (0.125 * ratio - 0.25 if ratio <= 10.0 else 0.4 * ratio - 3.0) ** 0.25
    return float(1.0 + scale * (4.5967 * share**1.5 + 2.6422 * share**4.24))


def crack_compliance(
    share: float, *, outer_diameter_m: float, thickness_m: float, youngs_modulus_pa: float
) -> float:
    """Rotation per moment, rad/(N m), that a crack over ``share`` of the perimeter adds to the tube."""
    length = finite_scalar("share", share, low=0.0, high=1.0, high_open=True)
    radius = 0.5 * (outer_diameter_m - thickness_m)
    # The integrand is smooth in the root of the share, where Gauss points reach rounding.
    points, weights = np.polynomial.legendre.leggauss(24)
    root = 0.5 * np.sqrt(length) * (points + 1.0)
    factor = np.array([bending_factor(float(share_), radius / thickness_m) for share_ in root**2])
    integral = np.sum(0.5 * np.sqrt(length) * weights * 2.0 * root**3 * np.pi**2 * factor**2)
    return float(4.0 * integral / (np.pi * youngs_modulus_pa * radius**2 * thickness_m))


PIECES = 4  # beams of the tested structure for each of the model
#: The crack: element of the model (the paper counts it as 31); the pipe sits in the flange's socket, from
#: node 30 on, and the crack runs around it behind the weld.
CRACKED_ELEMENT, SOCKET_M, BEHIND_WELD_M = 30, 0.02, 0.02
SHARES = (0.60, 0.70, 0.85)  # share of the perimeter at levels 1 to 3
CRACK_PIECE_M = 0.004  # length of the soft piece that stands for the spring

#: True value over nominal, by section and lumped mass, and degrees by bend.
THICKNESS = {"front": 1.12, "link": 0.87, "middle": 0.84, "axle": 0.86, "rear": 0.92, "tail": 0.90}
MODULUS = {"front": 0.96, "link": 1.05, "middle": 0.94, "axle": 1.06, "rear": 0.97, "tail": 1.05}
MASS = {"inlet flange": 1.15, "catalyst": 1.14, "front muffler": 1.13, "flange": 0.90, "rear muffler": 1.12}
ANGLE_DEG = {"front to link": -4.0, "middle to axle": -5.0, "axle to rear": 3.0, "second tail pipe": -5.0}
#: ... and what no updating parameter can follow.
INERTIA = dict(zip(MASS, (1.03, 0.96, 1.03, 1.03, 0.97), strict=True))
HANGER = 0.9
WALL_SEED = 332  # seed of the wall thickness from one coarse element's pipe to the next
USUAL = Unfollowed()  # what no updating parameter can follow, unless a case says otherwise

RIGID_DAMPING = 0.01  # modal damping on the rubber cords; of the elastic modes, in turn:
ELASTIC_DAMPING = (0.009, 0.006, 0.004, 0.008, 0.005, 0.003, 0.007, 0.010)
RIGID_MODES = 3
MODES = 36  # modes of the synthesis, to some 5 kHz; what the others add is quasi-static up to 512 Hz


def true_nodes() -> FloatArray:
    """Coarse nodes with the true bends: each run turned about its pivot, with all behind it."""
    found, ends = geometry.nodes(), geometry.beams()
    for name, group, pivot in geometry.BENDS:
        behind = {ends[group[0]][1]}
        for first, second, _ in ends:  # ordered away from the root, except at the branch
            if first in behind:
                behind.add(second)
        rows, turn = sorted(behind), np.deg2rad(ANGLE_DEG[name])
        matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        found[rows] = found[pivot] + (found[rows] - found[pivot]) @ matrix.T
    return found


def walls_m(errors: Unfollowed = USUAL) -> FloatArray:
    """True wall thickness of each coarse element's pipe, (47,)."""
    scatter = errors.wall_scatter * np.random.default_rng(WALL_SEED).standard_normal(len(geometry.beams()))
    nominal = [geometry.SECTIONS[section][0] * THICKNESS[section] for _, _, section in geometry.beams()]
    return np.array(nominal) * (1.0 + scatter)


def compliance(level: int, errors: Unfollowed = USUAL) -> float:
    """Rotation per moment of the crack, rad/(N m); 0 at level 0."""
    if level == 0:
        return 0.0
    pipe = {"outer_diameter_m": geometry.DIAMETER_M, "youngs_modulus_pa": _modulus()}
    return crack_compliance(SHARES[level - 1], thickness_m=float(walls_m(errors)[CRACKED_ELEMENT]), **pipe)


def equivalent_loss(level: int, errors: Unfollowed = USUAL) -> float:
    """Stiffness loss of the whole cracked element with the same rotation under a moment as with the crack."""
    (first, second, _), nodes = geometry.beams()[CRACKED_ELEMENT], true_nodes()
    added = compliance(level, errors) * _modulus() * _inertia(float(walls_m(errors)[CRACKED_ELEMENT]))
    return float(added / (added + np.linalg.norm(nodes[second] - nodes[first])))


def true_model(level: int, errors: Unfollowed = USUAL) -> FrameModel:
    """The tested structure; its first 48 nodes are those of the model."""
    coarse = true_nodes()
    nodes = list(coarse)
    beams: list[tuple[int, int, int]] = []
    sections: list[Tube | Section] = []
    walls = walls_m(errors)
    for element, ((first, second, name), wall) in enumerate(zip(geometry.beams(), walls, strict=True)):
        _, modulus, density = geometry.SECTIONS[name]
        material = modulus * MODULUS[name], density
        tube = Tube(geometry.DIAMETER_M, float(wall), *material, shear_coefficient=errors.shear_coefficient)
        span = coarse[second] - coarse[first]
        cuts, soft = _cuts(element, float(np.linalg.norm(span)))
        ends = [first, *range(len(nodes), len(nodes) + len(cuts)), second]
        nodes += [coarse[first] + cut * span for cut in cuts]
        sections.append(tube)
        tube_index = len(sections) - 1
        for piece, pair in enumerate(zip(ends[:-1], ends[1:], strict=True)):
            beams.append((*pair, tube_index))
            if level and piece == soft:
                beams[-1] = (*pair, len(sections))
                sections.append(_soft(tube, CRACK_PIECE_M, compliance(level, errors)))
        if errors.joined(second):
            length_m = float(np.linalg.norm(span)) / PIECES
            beams[-1] = (*beams[-1][:2], len(sections))
            turns = errors.joint_m / (tube.youngs_modulus_pa * _inertia(tube.thickness_m))
            sections.append(_soft(tube, length_m, turns))
    own = ((node, m * MASS[name], inertia * INERTIA[name]) for name, node, m, inertia in geometry.MASSES)
    masses = [*(PointMass(*each) for each in own), *errors.masses]
    springs = geometry.hangers(HANGER) + errors.springs
    return FrameModel(np.array(nodes), beams, sections, point_masses=masses, ground_springs=springs)


def _cuts(element: int, length_m: float) -> tuple[list[float], int | None]:
    """Where an element is divided, as shares of it, and which piece holds the crack."""
    even = [i / PIECES for i in range(1, PIECES)]
    if element != CRACKED_ELEMENT:
        return even, None
    half = 0.5 * CRACK_PIECE_M
    middle = SOCKET_M + BEHIND_WELD_M
    edges = [(middle - half) / length_m, (middle + half) / length_m]
    return edges + [edges[1] + (1.0 - edges[1]) * share for share in (0.25, 0.5, 0.75)], 1


def _soft(tube: Tube, length_m: float, extra: float) -> Section:
    """Section of a piece that turns by so much more than the pipe does, under a moment of one (rad/(N m))."""
    modulus = tube.youngs_modulus_pa
    bent = extra + length_m / (modulus * _inertia(tube.thickness_m))
    area = np.pi * tube.thickness_m * (tube.outer_diameter_m - tube.thickness_m)
    return Section(float(area), float(length_m / (modulus * bent)), modulus, tube.density_kg_per_m3)


def _inertia(wall: float) -> float:
    outer, inner = 0.5 * geometry.DIAMETER_M, 0.5 * geometry.DIAMETER_M - wall
    return float(0.25 * np.pi * (outer**4 - inner**4))


def _modulus() -> float:
    name = geometry.beams()[CRACKED_ELEMENT][2]
    return geometry.SECTIONS[name][1] * MODULUS[name]


class TestedStructure:
    """Modes of the tested structure, and its responses to the shaker.

    The modes come from a shift-invert solution, which keeps the soft suspension's digits on a fine mesh.
    """

    __test__ = False  # no test class, whatever its name

    def __init__(self, level: int, errors: Unfollowed = USUAL) -> None:
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import eigsh, splu

        self.model = true_model(level, errors)
        self.excitation = self.model.dof(*geometry.SHAKER)
        stiffness, mass = csc_array(self.model.stiffness()), csc_array(self.model.mass())
        shift = -((2 * np.pi * 5.0) ** 2)
        start = np.random.default_rng(0).standard_normal(self.model.n_dof)
        squares, shapes = eigsh(stiffness, MODES, mass, sigma=shift, v0=start)
        order = np.argsort(squares)
        self.freq_hz: FloatArray = np.sqrt(squares[order]) / (2 * np.pi)
        self.shapes: FloatArray = shapes[:, order].T
        elastic = np.resize(ELASTIC_DAMPING, MODES - RIGID_MODES)
        self.damping_ratio = np.append(np.full(RIGID_MODES, RIGID_DAMPING), elastic)
        unit = np.zeros(self.model.n_dof)
        unit[self.excitation] = 1.0
        # Receptance at the shift, less what the modes give: the quasi-static part of the modes left out.
        whole = splu(stiffness - shift * mass).solve(unit)
        modal = self.shapes.T @ (self.shapes[:, self.excitation] / (squares[order] - shift))
        self._residual = whole - modal

    def frf(self, response: Any, excitation: int, freq_hz: Any, *, damping_ratio: Any = None) -> ComplexArray:
        """Accelerance of one response dof to the shaker, (n_freq,)."""
        omega = 2 * np.pi * np.asarray(freq_hz, dtype=float)
        poles = 2 * np.pi * self.freq_hz
        total: ComplexArray = np.full(omega.size, complex(self._residual[response]))
        for pole, ratio, shape in zip(poles, self.damping_ratio, self.shapes, strict=True):
            total += shape[response] * shape[excitation] / (pole**2 - omega**2 + 2j * ratio * pole * omega)
        total *= -(omega**2)
        return total


# -- What the exhaust's virtual test is made of, kept beside it: for comparison, never for a fit

F_MAX_HZ = 390.0  # values are given up to here, one half beyond the damage band


def true_antiresonances(
    level: int, responses: list[int], f_max_hz: float, errors: Unfollowed
) -> dict[int, FloatArray]:
    """Undamped antiresonances of the tested structure up to ``f_max_hz``, by dof."""
    model = true_model(level, errors)
    found = model.antiresonances(responses, model.dof(*geometry.SHAKER), f_max_hz=f_max_hz)
    return dict(zip(responses, found, strict=True))


def truth(level: int, responses: list[int], errors: Unfollowed) -> dict[str, Any]:
    """Properties of the tested structure, and its frequencies."""
    tested = TestedStructure(level, errors)
    low = tested.freq_hz <= F_MAX_HZ
    loss = equivalent_loss(level, errors)
    return {
        "thickness": dict(THICKNESS),
        "youngs_modulus": dict(MODULUS),
        "point_mass": dict(MASS),
        "angle": dict(ANGLE_DEG),
        "inertia": dict(INERTIA),
        "hanger": HANGER,
        "unfollowed": errors,
        "crack_share": (0.0, *SHARES)[level],
        "crack_compliance": compliance(level, errors),
        "equivalent_loss": loss,
        "severity": {CRACKED_ELEMENT: loss},
        "freq_hz": true_antiresonances(level, responses, F_MAX_HZ, errors),
        "resonances_hz": tested.freq_hz[low],
        "damping_ratio": tested.damping_ratio[low],
    }
