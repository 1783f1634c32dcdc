"""Frames on several supports with their intact values, and the model of one who forgot a support.

A truth has two beams for each element of the model, with shear, every stiffness and density off by some per
cent, and clamps that turn. The limit of the package was set on ``SET_ON``; ``JUDGED_ON`` judges it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import antires_rs as ar

YOUNGS_PA, DENSITY, STD = 2.1e11, 7850.0, 3e-4
_FURTHEST = 2.5  # factors are drawn no further off, in standard deviations


@dataclass(frozen=True)
class Supported:
    """Nodes, beams between them, supports as ``fixed`` of a frame has them, sensors, and the force."""

    name: str
    nodes_m: tuple[tuple[float, ...], ...]
    lines: tuple[tuple[int, int], ...]
    supports: tuple[int | tuple[int, tuple[str, ...]], ...]
    sensors: tuple[tuple[int, str], ...]
    force: tuple[int, str]
    f_max_hz: float
    section_m: tuple[float, float] = (0.05, 0.012)

    def model(self, forgotten: int | None = None) -> ar.FrameModel:
        """As a user makes it, without the support of this position."""
        kept = [support for nth, support in enumerate(self.supports) if nth != forgotten]
        return ar.FrameModel(self.nodes_m, self.lines, self._section(1.0, 1.0), fixed=kept)

    def states(self, seed, forgotten=None, *, off=0.03, clamp=None, losses=None):
        """The model, intact and present values; clamps turn by ``clamp`` in EI / L of the first element."""
        model, noise = self.model(forgotten), np.random.default_rng(seed)
        sets = [
            self._measured(model, self._truth(seed, off, clamp, each), noise) for each in ({}, losses or {})
        ]
        return model, *sets

    def _section(self, stiffer, heavier, **shear):
        return ar.Rectangle(*self.section_m, YOUNGS_PA * stiffer, DENSITY * heavier, **shear)

    def _truth(self, seed, off, clamp, losses):
        rng = np.random.default_rng([seed, 1])
        nodes, lines, sections = list(self.nodes_m), [], []
        for element, (a, b) in enumerate(self.lines):
            by = 1.0 + off * np.clip(rng.standard_normal(2), -_FURTHEST, _FURTHEST)
            by[0] *= 1.0 - losses.get(element, 0.0)
            nodes.append(tuple(np.mean([self.nodes_m[a], self.nodes_m[b]], axis=0)))
            lines += [(a, len(nodes) - 1), (len(nodes) - 1, b)]
            sections += [self._section(*by, shear_coefficient="cowper")] * 2
        moves, turns = (
            (("u", "v"), ("theta",)) if len(nodes[0]) == 2 else (("u", "v", "w"), ("rx", "ry", "rz"))
        )
        fixed, springs = [], []
        for support in self.supports:
            clamped = isinstance(support, int) and clamp is not None
            fixed.append((support, moves) if clamped else support)
            springs += [ar.GroundSpring(support, turn, clamp * self._bending) for turn in turns if clamped]
        return ar.FrameModel(nodes, lines, sections, fixed=fixed, ground_springs=springs)

    @property
    def _bending(self):
        """EI / L of the first element."""
        width, height = self.section_m
        length = np.linalg.norm(np.subtract(*(self.nodes_m[node] for node in self.lines[0])))
        return YOUNGS_PA * width * height**3 / 12.0 / length

    def _measured(self, model, truth, noise):
        freq = {}
        for node, direction in self.sensors:
            dof, force = truth.dof(node, direction), truth.dof(*self.force)
            exact = truth.antiresonances(dof, force, f_max_hz=self.f_max_hz)
            freq[model.dof(node, direction)] = exact * (1.0 + STD * noise.standard_normal(exact.size))
        std_hz = {dof: STD * hz for dof, hz in freq.items()}
        return ar.AntiresonanceSet(model.dof(*self.force), freq, std_hz=std_hz)


def _line(n):
    return tuple((k, k + 1) for k in range(n))


def _at(direction, *nodes):
    return tuple((node, direction) for node in nodes)


PORTAL = Supported(
    "portal",
    (
        *((0.0, 0.25 * k) for k in range(5)),
        *((0.2 * k, 1.0) for k in range(1, 5)),
        *((0.8, 1.0 - 0.25 * k) for k in range(1, 5)),
    ),
    _line(12),
    (0, 12),
    (*_at("u", 2, 3, 4), *_at("v", 5, 6, 7), *_at("u", 9, 10)),
    (3, "u"),
    260.0,
)
PROPPED = Supported(
    "propped beam",
    tuple((0.2 * k, 0.0) for k in range(11)),
    _line(10),
    (0, (10, ("u", "v"))),
    _at("v", 2, 3, 5, 7, 8),
    (4, "v"),
    400.0,
)
SPANS = Supported(
    "three spans",
    tuple((0.25 * k, 0.0) for k in range(13)),
    _line(12),
    ((0, ("u", "v")), (4, ("v",)), (8, ("v",)), (12, ("v",))),
    _at("v", 1, 2, 3, 5, 6, 7, 9, 10, 11),
    (2, "v"),
    500.0,
)
TWO_BAYS = Supported(
    "two bays",
    (
        *((0.0, 0.5 * k) for k in range(3)),
        (0.5, 1.0),
        *((1.0, 1.0 - 0.5 * k) for k in range(3)),
        (1.5, 1.0),
        *((2.0, 1.0 - 0.5 * k) for k in range(3)),
    ),
    ((0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (4, 7), (7, 8), (8, 9), (9, 10)),
    (0, 6, 10),
    (*_at("u", 1, 2, 4, 5, 9), *_at("v", 3, 7)),
    (1, "u"),
    300.0,
)
ANGLE = Supported(
    "angle",
    (*((0.0, 0.5 * k) for k in range(5)), *((0.4 * k, 2.0) for k in range(1, 5))),
    _line(8),
    (0, 8),
    (*_at("u", 1, 2, 3), *_at("v", 5, 6, 7)),
    (2, "u"),
    300.0,
)
TABLE = Supported(
    "table",
    tuple((x, y, 0.5 * k) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.3), (0.0, 1.3)) for k in range(3)),
    (
        *((3 * leg + k, 3 * leg + k + 1) for leg in range(4) for k in range(2)),
        (2, 5),
        (5, 8),
        (8, 11),
        (11, 2),
    ),
    (0, 3, 6, 9),
    (*_at("u", 1, 2, 4, 7, 8, 10), *_at("v", 1, 2, 4, 7)),
    (2, "u"),
    200.0,
    (0.04, 0.03),
)
SET_ON, JUDGED_ON = (PORTAL, PROPPED), (SPANS, TWO_BAYS, ANGLE, TABLE)
