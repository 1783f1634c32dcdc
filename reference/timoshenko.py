"""Structures of beams with shear and rotary inertia, bars and springs, and the zeros of their responses.

Nothing here is taken from the package's models: matrices come from quadrature of shape functions, and zeros
from the inverse of K with the response held, by SciPy.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

#: Complex zeros with more damping than this are no dips; real ones have at most this imaginary part.
MOST_DAMPING, REAL = 0.1, 1e-7
#: Relative distance from a resonance within which a zero shows no dip: half the width of a peak of 0.2 %
#: damping. Symmetric structures have many such zeros.
HIDDEN = 2e-3
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_POINTS, _WEIGHTS = (1.0 + _POINTS) / 2.0, _WEIGHTS / 2.0


@dataclass(frozen=True)
class Bar:
    """A solid rectangle that bends over its height."""

    width_m: float
    height_m: float
    e_pa: float = 2.1e11
    rho: float = 7850.0
    poisson: float = 0.3

    def off(self, stiffness: float, mass: float) -> Bar:
        """With modulus and density times these factors."""
        return replace(self, e_pa=stiffness * self.e_pa, rho=mass * self.rho)

    @property
    def area_m2(self) -> float:
        return self.width_m * self.height_m

    @property
    def second_m4(self) -> float:
        return self.width_m * self.height_m**3 / 12.0

    @property
    def ei(self) -> float:
        return self.e_pa * self.second_m4

    @property
    def shear(self) -> float:
        """Shear stiffness with Cowper's coefficient (1966)."""
        kappa = 10.0 * (1.0 + self.poisson) / (12.0 + 11.0 * self.poisson)
        return kappa * self.e_pa / (2.0 * (1.0 + self.poisson)) * self.area_m2

    @property
    def torsion_m4(self) -> float:
        """St. Venant's constant of a rectangle (Roark's Formulas, table 10.1)."""
        a, b = max(self.width_m, self.height_m) / 2.0, min(self.width_m, self.height_m) / 2.0
        return a * b**3 * (16.0 / 3.0 - 3.36 * b / a * (1.0 - (b / a) ** 4 / 12.0))

    def hinge_n_m(self, length_m: float, loss: float) -> float:
        """A rotational spring that is as flexible as the loss of a beam of this length, bent evenly."""
        return self.ei / length_m * (1.0 - loss) / loss


@dataclass(frozen=True)
class ThinTube(Bar):
    """A round tube of mean diameter ``height_m`` and wall ``width_m``."""

    @property
    def area_m2(self) -> float:
        return np.pi * self.height_m * self.width_m

    @property
    def second_m4(self) -> float:
        return self.area_m2 * (self.height_m**2 + self.width_m**2) / 8.0

    @property
    def shear(self) -> float:
        """Shear stiffness with Cowper's coefficient of a thin wall (1966)."""
        kappa = 2.0 * (1.0 + self.poisson) / (4.0 + 3.0 * self.poisson)
        return kappa * self.e_pa / (2.0 * (1.0 + self.poisson)) * self.area_m2


def bent(ei, shear, mass_per_m, rotary_per_m, length):
    """K, M of (w, slope) at both ends: shape functions exact for end loads (Friedman & Kosmatka 1993)."""
    k_mat, m_mat = np.zeros((4, 4)), np.zeros((4, 4))
    phi = 12.0 * ei / (shear * length**2)
    for x, weight in zip(_POINTS, _WEIGHTS, strict=True):
        w = np.array(
            [
                1 + phi * (1 - x) - 3 * x**2 + 2 * x**3,
                length * (x - 2 * x**2 + x**3 + phi * (x - x**2) / 2),
                phi * x + 3 * x**2 - 2 * x**3,
                length * (x**3 - x**2 - phi * (x - x**2) / 2),
            ]
        )
        slope = np.array(
            [
                6 * (x**2 - x) / length,
                1 - 4 * x + 3 * x**2 + phi * (1 - x),
                6 * (x - x**2) / length,
                3 * x**2 - 2 * x + phi * x,
            ]
        )
        bending = np.array([(12 * x - 6) / length, 6 * x - 4 - phi, (6 - 12 * x) / length, 6 * x - 2 + phi])
        bending /= length
        sheared = phi * np.array([-1 / length, -0.5, 1 / length, -0.5])
        share = weight * length / (1.0 + phi) ** 2
        k_mat += share * (ei * np.outer(bending, bending) + shear * np.outer(sheared, sheared))
        m_mat += share * (mass_per_m * np.outer(w, w) + rotary_per_m * np.outer(slope, slope))
    return k_mat, m_mat


def rod(stiffness, mass):
    """K, M of a straight motion at both ends, linear between them."""
    return stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]]), mass / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])


class Assembly:
    """Matrices that grow by parts; dofs are named by anything, such as (node, "u")."""

    def __init__(self) -> None:
        self._numbers: dict[Hashable, int] = {}
        self._parts: list[tuple[list[int], int, np.ndarray]] = []

    def add(self, dofs: Sequence[Hashable], *, k=None, m=None, c=None) -> None:
        """Stiffness, mass, damping of these dofs."""
        numbers = [self._numbers.setdefault(dof, len(self._numbers)) for dof in dofs]
        for which, matrix in enumerate((k, m, c)):
            if matrix is not None:
                self._parts.append((numbers, which, np.atleast_2d(matrix)))

    def link(self, dof: Hashable, stiffness: float, damping: float = 0.0) -> None:
        """A spring and dashpot to ground."""
        self.add([dof], k=stiffness, c=damping)

    def plane_beam(self, ends, places, section: Bar, hinges: Mapping[int, float] | None = None) -> None:
        """A beam of nodes with (u, v, theta), ``hinges`` springs (N m) between it and the node, by end.

        The angle in a hinge is a dof of its own: the beam's end turns by the node's rotation and that.
        """
        along = np.subtract(places[1], places[0])
        length = float(np.hypot(*along))
        cos, sin = along / length
        dofs: list[Hashable] = [(node, name) for node in ends for name in ("u", "v", "theta")]
        to_local = np.zeros((6, 6))
        for end in (0, 3):
            to_local[end, end : end + 2] = cos, sin
            to_local[end + 1, end : end + 2] = -sin, cos
            to_local[end + 2, end + 2] = 1.0
        parts = [
            ((0, 3), rod(section.e_pa * section.area_m2 / length, section.rho * section.area_m2 * length)),
            ((1, 2, 4, 5), _bent(section, length)),
        ]
        self._add_beam(ends, dofs, to_local, parts, {0: 2, 1: 5}, hinges or {})

    def grid_beam(self, ends, places, section: Bar, hinges: Mapping[int, float] | None = None) -> None:
        """A horizontal beam of nodes with w and its slopes ("x", "y"); twist is free of the hinges."""
        along = np.subtract(places[1], places[0])
        length = float(np.hypot(*along))
        cos, sin = along / length
        dofs: list[Hashable] = [(node, name) for node in ends for name in ("w", "x", "y")]
        to_local = np.zeros((6, 6))
        for end in (0, 3):
            to_local[end, end] = 1.0
            to_local[end + 1, end + 1 : end + 3] = cos, sin
            to_local[end + 2, end + 1 : end + 3] = -sin, cos
        shear_modulus = section.e_pa / (2.0 * (1.0 + section.poisson))
        polar = section.width_m * section.height_m * (section.width_m**2 + section.height_m**2) / 12.0
        twist = rod(shear_modulus * section.torsion_m4 / length, section.rho * polar * length)
        parts = [((0, 1, 3, 4), _bent(section, length)), ((2, 5), twist)]
        self._add_beam(ends, dofs, to_local, parts, {0: 1, 1: 4}, hinges or {})

    def _add_beam(self, ends, dofs, to_local, parts, turning, hinges) -> None:
        k_mat, m_mat = np.zeros((6, 6)), np.zeros((6, 6))
        for own, (k, m) in parts:
            k_mat[np.ix_(own, own)] += k
            m_mat[np.ix_(own, own)] += m
        for end, stiffness in hinges.items():
            angle = ("hinge", ends, end)
            column = np.zeros((6, 1))
            column[turning[end]] = 1.0
            dofs, to_local = [*dofs, angle], np.hstack([to_local, column])
            self.link(angle, stiffness)
        self.add(dofs, k=to_local.T @ k_mat @ to_local, m=to_local.T @ m_mat @ to_local)

    def free(self, held: Sequence[Hashable] = ()) -> Assembled:
        """The matrices without the dofs that are held."""
        n = len(self._numbers)
        matrices = np.zeros((3, n, n))
        for numbers, which, matrix in self._parts:
            matrices[which][np.ix_(numbers, numbers)] += matrix
        left = [number for dof, number in self._numbers.items() if dof not in set(held)]
        names = {dof: left.index(number) for dof, number in self._numbers.items() if number in left}
        return Assembled(*(matrix[np.ix_(left, left)] for matrix in matrices), names)


def _bent(section: Bar, length: float):
    rotary = section.rho * section.second_m4
    return bent(section.ei, section.shear, section.rho * section.area_m2, rotary, length)


@dataclass(frozen=True)
class Assembled:
    """K, M, C and the row of each dof."""

    stiffness: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    rows: dict[Hashable, int]

    def vector(self, weights: Mapping[Hashable, float]) -> np.ndarray:
        """What a sensor reads, or a force acts on: dofs with their weights."""
        found = np.zeros(len(self.stiffness))
        for dof, weight in weights.items():
            found[self.rows[dof]] += weight
        return found

    @property
    def resonances_hz(self) -> np.ndarray:
        """Undamped, ascending."""
        inverse = scipy.linalg.eigh(self.mass, self.stiffness, eigvals_only=True)[::-1]
        return 1.0 / np.sqrt(inverse[inverse > 1e-12 * inverse[0]]) / (2.0 * np.pi)

    def antiresonances(self, sensors, force, band_hz, hidden=HIDDEN) -> list[np.ndarray]:
        """Zeros in band of the responses of sensors to a force, each given by its weights, in Hz.

        Without those that a resonance hides.

        A zero is a motion x with (A - s B) x = -b f and c x = 0; so 1/s are eigenvalues of
        (I - A^-1 b c / (c A^-1 b)) A^-1 B. Undamped A, B are K, M and s is the frequency squared; damped they
        are those of displacements and velocities, and the frequency is abs(s), as identification has it.
        """
        n, damped = len(self.stiffness), bool(self.damping.any())
        a_mat, b_mat = self.stiffness, self.mass
        if damped:
            zero, one = np.zeros((n, n)), np.eye(n)
            a_mat = np.block([[zero, one], [-self.stiffness, -self.damping]])
            b_mat = np.block([[one, zero], [zero, self.mass]])
        drive = self.vector(force)
        right = np.concatenate([np.zeros(n), drive]) if damped else drive
        solved = scipy.linalg.solve(a_mat, np.column_stack([b_mat, right]))
        flexible, static = solved[:, :-1], solved[:, -1]
        found, resonances = [], self.resonances_hz
        for weights in sensors:
            read = np.zeros(len(a_mat))
            read[:n] = self.vector(weights)
            inverse = scipy.linalg.eigvals(flexible - np.outer(static, read @ flexible) / (read @ static))
            freq = _damped_hz(inverse) if damped else _undamped_hz(inverse)
            freq = np.sort(freq[(freq >= band_hz[0]) & (freq <= band_hz[1])])
            apart = np.abs(freq[:, None] / resonances - 1.0).min(axis=1)
            found.append(freq[apart > hidden])
        return found


def _undamped_hz(inverse):
    seen = (inverse.real > 0.0) & (np.abs(inverse.imag) <= REAL * np.abs(inverse))
    return 1.0 / np.sqrt(inverse.real[seen]) / (2.0 * np.pi)


def _damped_hz(inverse):
    s = 1.0 / inverse[np.abs(inverse) > 0.0]
    return np.abs(s[(s.imag > 0.0) & (np.abs(s.real) <= MOST_DAMPING * np.abs(s))]) / (2.0 * np.pi)
