"""Chains and frames with measured values, and mistakes made with their models: units, matrices, dofs.

The truth is the nominal model with every stiffness and mass off by some per cent; a mistake is made with the
nominal model or with the values, as an engineer would make it. The limits in the package were set on
``SET_ON`` and judged on ``JUDGED_ON``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import antires_rs as ar

STD = 3e-4


@dataclass(frozen=True)
class Structure:
    """``build(stiffness, mass, size, radian)`` makes the model with its numbers multiplied by these."""

    name: str
    build: Callable[..., ar.MassSpringChain | ar.FrameModel]
    dofs: tuple[int, ...]
    forces: tuple[int, ...]
    wrong_force: int
    f_max_hz: float

    def truth(self, rng, off, losses=None):
        """The nominal model, every term off by up to ``off``; ``losses`` by element."""
        model = self.build()
        elements = list(model.default_elements)
        parts = (
            *ar.stiffness_factor(elements, bounds=(0.01, 2.0)),
            *ar.mass_factor(list(range(model._core.n_mass_terms)), bounds=(0.01, 2.0)),
        )
        values = 1.0 + off * rng.uniform(-1.0, 1.0, len(parts))
        for element, loss in (losses or {}).items():
            values[elements.index(element)] *= 1.0 - loss
        return model.with_parameters(parts, values)

    def measured(self, model, rng, std=STD):
        """Values up to ``f_max_hz`` with Gaussian errors."""
        sets = []
        for force in self.forces:
            exact = model.antiresonances(list(self.dofs), force, f_max_hz=self.f_max_hz)
            freq = {
                dof: f * (1.0 + std * rng.standard_normal(f.size))
                for dof, f in zip(self.dofs, exact, strict=True)
            }
            sets.append(ar.AntiresonanceSet(force, freq, std_hz={dof: std * f for dof, f in freq.items()}))
        return sets

    def states(self, seed, off, losses=None):
        """Intact and present values of one truth."""
        factors = np.random.default_rng(seed)
        intact = self.truth(factors, off)
        now = self.truth(np.random.default_rng(seed), off, losses)
        return self.measured(intact, factors), self.measured(now, factors)


def _chain(masses, springs, ground):
    def build(stiffness=1.0, mass=1.0, size=1.0, radian=1.0):
        k = stiffness * radian
        return ar.MassSpringChain(
            mass * np.array(masses), k * np.array(springs), ground_first_n_per_m=k * ground
        )

    return build


def _frame(nodes, elements, outer, wall, fixed):
    """``radian`` other than 1: the angles of the members' polar coordinates were taken for degrees."""

    def build(stiffness=1.0, mass=1.0, size=1.0, radian=1.0):
        steel = ar.Tube(size * outer, size * wall, stiffness * 2.1e11, mass * 7850.0)
        places = [(0.0, 0.0)]
        for length, angle in nodes:
            x, y = places[-1]
            turned = math.radians(angle) * radian
            places.append((x + length * math.cos(turned), y + length * math.sin(turned)))
        return ar.FrameModel(size * np.array(places), elements, steel, fixed=fixed)

    return build


def _line(count):
    return [(i, i + 1) for i in range(count)]


SET_ON = (
    Structure(
        "chain of 6",
        _chain([0.8, 0.5, 0.6, 0.5, 0.7, 0.5], [4e4, 6e4, 5e4, 3e4, 5e4], 3e4),
        tuple(range(6)),
        (0, 3),
        2,
        1e3,
    ),
    Structure(
        "bent cantilever",
        _frame([(0.2, 60.0)] * 4 + [(0.2, 0.0)] * 4, _line(8), 0.03, 0.003, [0]),
        (1, 4, 7, 10, 13, 16, 19, 22),
        (22,),
        13,
        800.0,
    ),
    Structure(
        "chain of 8", _chain([0.5593] + [0.4194] * 7, [5.67e4] * 7, 0.0), tuple(range(8)), (0,), 3, 1e3
    ),
    Structure(
        "chain of 7",
        _chain([1.2, 0.9, 1.5, 0.7, 1.1, 0.8, 1.0], [2.0e5, 1.4e5, 2.6e5, 1.1e5, 1.9e5, 1.5e5], 8e4),
        tuple(range(7)),
        (1, 5),
        3,
        1e3,
    ),
)
JUDGED_ON = (
    Structure(
        "chain of 9",
        _chain([3.0, 2.2, 2.6, 3.4, 1.9, 2.8, 2.4, 3.1, 2.0], [9e5, 7e5, 6e5, 8e5, 1e6, 5e5, 7e5, 9e5], 6e5),
        tuple(range(9)),
        (0, 6),
        4,
        1e3,
    ),
    Structure(
        "portal frame",
        _frame([(0.25, 90.0)] * 3 + [(0.3, 20.0)] * 3 + [(0.25, -90.0)] * 3, _line(9), 0.04, 0.002, [0, 9]),
        (0, 3, 6, 7, 10, 13, 15, 18, 21),
        (6,),
        16,
        900.0,
    ),
)


def _scaled(sets, factor):
    return [
        ar.AntiresonanceSet(
            each.excitation,
            {dof: factor * each[dof] for dof in each},
            std_hz={dof: factor * each.std_hz[dof] for dof in each},
        )
        for each in sets
    ]


def _moved(sets, places):
    """The values of each dof given to another one."""
    return [
        ar.AntiresonanceSet(
            each.excitation,
            {places[dof]: each[dof] for dof in each},
            std_hz={places[dof]: each.std_hz[dof] for dof in each},
        )
        for each in sets
    ]


def _of_force(sets, force):
    first = sets[0]
    found = ar.AntiresonanceSet(
        force, {dof: first[dof] for dof in first}, std_hz={dof: first.std_hz[dof] for dof in first}
    )
    return [found]


def _swapped(model):
    """A MatrixModel with stiffness and mass exchanged; its terms are the element masses, as given."""
    masses = ar.mass_factor(list(range(model._core.n_mass_terms)), bounds=(0.5, 2.0))
    whole = _dense(model.mass())
    terms = [2.0 * (whole - _dense(model.with_parameters((each,), [0.5]).mass())) for each in masses]
    return ar.MatrixModel(whole, _dense(model.stiffness()), stiffness_terms=terms)


def _dense(matrix):
    return np.asarray(matrix if isinstance(matrix, np.ndarray) else matrix.toarray())


#: By name: from structure and both states to model and both states as they are given.
MISTAKES = {
    "springs in N/mm, modulus in kPa": lambda s, b, n: (s.build(stiffness=1e-3), b, n),
    "springs in N/um, modulus in MPa": lambda s, b, n: (s.build(stiffness=1e-6), b, n),
    "springs in kgf/mm": lambda s, b, n: (s.build(stiffness=1.0 / 9806.65), b, n),
    "masses in tonnes": lambda s, b, n: (s.build(mass=1e-3), b, n),
    "masses in grams": lambda s, b, n: (s.build(mass=1e3), b, n),
    "springs in N/mm, masses in tonnes": lambda s, b, n: (s.build(stiffness=1e-3, mass=1e3), b, n),
    "frequencies in kHz": lambda s, b, n: (s.build(), _scaled(b, 1e-3), _scaled(n, 1e-3)),
    "frequencies in rad/s": lambda s, b, n: (s.build(), _scaled(b, math.tau), _scaled(n, math.tau)),
    "frequencies in rpm": lambda s, b, n: (s.build(), _scaled(b, 60.0), _scaled(n, 60.0)),
    "K and M swapped": lambda s, b, n: (_swapped(s.build()), b, n),
    "lengths in mm": lambda s, b, n: (s.build(size=1e3), b, n),
    "degrees for radians": lambda s, b, n: (s.build(radian=180.0 / math.pi), b, n),
    "twice the sampling rate": lambda s, b, n: (s.build(), _scaled(b, 2.0), _scaled(n, 2.0)),
    "dofs reversed": lambda s, b, n: (
        s.build(),
        *(_moved(x, dict(zip(s.dofs, s.dofs[::-1], strict=True))) for x in (b, n)),
    ),
    "dofs one further": lambda s, b, n: (
        s.build(),
        *(_moved(x, dict(zip(s.dofs, s.dofs[1:] + s.dofs[:1], strict=True))) for x in (b, n)),
    ),
    "force at another dof": lambda s, b, n: (s.build(), *(_of_force(x, s.wrong_force) for x in (b, n))),
}
#: These mistakes have no meaning for a chain: its numbers are the same.
ONLY_FRAMES = ("lengths in mm",)
