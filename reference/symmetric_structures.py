"""Symmetric chains, rings, portal frames and grillages with sensors on nodes of their modes.

Each can be built exactly symmetric, or as a twin whose members differ by some per mille. Records are
simulated from K and M as matrices (``MatrixModel.simulate``), whatever model is compared with them
afterwards.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg

import antires_rs as ar

DAMPING_RATIO = 0.01
SAMPLES = 120_000
STEEL = (210e9, 7850.0)


@dataclass(frozen=True)
class Case:
    """``build(spread)`` makes the model; its members differ by this share, 0 for the symmetric one."""

    kind: str
    name: str
    build: Callable[[float], ar.MassSpringChain | ar.MatrixModel | ar.FrameModel]
    excitation: int
    sensors: tuple[int, ...]
    band_hz: tuple[float, float]

    def record(self, model, *, noise, seed):
        """A record simulated from the matrices of a model."""
        fs_hz = 4.0 * self.band_hz[1]
        return ar.MatrixModel(dense(model.stiffness()), dense(model.mass())).simulate(
            excitation=self.excitation,
            responses=list(self.sensors),
            fs_hz=fs_hz,
            duration_s=SAMPLES / fs_hz,
            damping_ratio=DAMPING_RATIO,
            band_hz=(0.0, 1.9 * self.band_hz[1]),
            noise=noise,
            rng=seed,
        )

    def identified(self, model, *, noise=0.0, seed=0, route="transmissibility"):
        """Antiresonances of such a record."""
        record = self.record(model, noise=noise, seed=seed)
        return ar.identify_antiresonances(
            record, excitation=self.excitation, band_hz=self.band_hz, route=route, check="off"
        )


def dense(matrix):
    """An array of a sparse or dense matrix."""
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()


def true_zeros(model, response, excitation):
    """All zeros of an undamped response: complex frequencies in Hz, real part positive, by SciPy."""
    k, m = (
        np.delete(np.delete(dense(a), response, 0), excitation, 1) for a in (model.stiffness(), model.mass())
    )
    scale = np.abs(k).max() / np.abs(m).max()
    upper, lower = scipy.linalg.eig(k / scale, m, right=False, homogeneous_eigvals=True)
    finite = np.abs(lower) > 1e-13 * np.abs(upper)
    freq = np.sqrt((upper[finite] / lower[finite] * scale).astype(complex)) / (2 * np.pi)
    return freq[freq.imag >= -1e-9 * np.abs(freq)]


def _members(n, spread, shift=0.0):
    """Factors of n members: all one, or a fixed pattern within the spread."""
    return 1.0 + spread * np.sin(2.4 * np.arange(n) + 0.7 + shift)


def _chain(masses, springs, grounds=(0.0, 0.0)):
    def build(spread):
        return ar.MassSpringChain(
            masses * _members(len(masses), spread),
            springs * _members(len(springs), spread, 1.0),
            ground_first_n_per_m=grounds[0],
            ground_last_n_per_m=grounds[1],
        )

    return build


def _chains():
    for n, force in ((5, 0), (7, 0), (7, 1), (9, 0), (9, 2), (11, 0)):
        build = _chain(np.ones(n), np.full(n - 1, 5e4))
        yield Case("chain", f"{n} equal masses, force at {force}", build, force, tuple(range(n)), (3.0, 78.0))
    heavy = np.array([1.5, 1.0, 1.0, 2.0, 1.0, 1.0, 1.5])
    stiff = 5e4 * np.array([1.0, 1.3, 0.8, 0.8, 1.3, 1.0])
    build = _chain(heavy, stiff)
    yield Case("chain", "7 unequal masses, force at 0", build, 0, tuple(range(7)), (3.0, 78.0))
    build = _chain(heavy, stiff, (3e4, 3e4))
    yield Case("chain", "7 masses on two ground springs", build, 1, tuple(range(7)), (3.0, 85.0))


def _ring(n, grounds):
    """Equal masses in a circle, springs between neighbours and some to ground."""

    def build(spread):
        k, terms = np.zeros((n, n)), []
        for i, factor in enumerate(_members(n, spread)):
            term = np.zeros((n, n))
            j = (i + 1) % n
            term[[i, j], [i, j]] = 5e4 * factor
            term[[i, j], [j, i]] = -5e4 * factor
            terms.append(term)
            k += term
        for i, stiffness in grounds.items():
            k[i, i] += stiffness
        return ar.MatrixModel(k, np.diag(_members(n, spread, 1.0)), stiffness_terms=terms)

    return build


def _rings():
    for n, held in ((6, 6), (8, 8), (10, 10), (8, 2), (10, 2), (12, 2)):
        grounds = {i: 4e4 if held == 2 else 4e3 for i in range(0, n, n // held)}
        name = f"{n} masses, {held} held"
        yield Case("ring", name, _ring(n, grounds), 1, tuple(range(n)), (4.0, 78.0))
    sensors = (0, 1, 2, 4, 5, 6)
    yield Case("ring", "8 masses, 6 sensors", _ring(8, {0: 3e4, 4: 3e4}), 1, sensors, (4.0, 78.0))


def _strips(n, height_m, spread, shift=0.0):
    factors = _members(n, spread, shift)
    return [ar.Rectangle(0.04, height_m * factor, *STEEL) for factor in factors]


def _portal(storeys, divisions, brace=False):
    """Clamped feet, one bay; nodes by member, beams of ``divisions`` (even) elements."""

    def layout():
        nodes, elements = [], []

        def line(start, end, first, last):
            at = [first if first is not None else len(nodes)]
            if first is None:
                nodes.append(start)
            for step in range(1, divisions):
                nodes.append(tuple(np.array(start) + (np.array(end) - start) * step / divisions))
                at.append(len(nodes) - 1)
            if last is None:
                nodes.append(end)
                last = len(nodes) - 1
            at.append(last)
            elements.extend(zip(at[:-1], at[1:], strict=True))
            return at

        left = right = None
        feet, beams, columns = [], [], []
        for storey in range(storeys):
            low, high = 0.4 * storey, 0.4 * (storey + 1)
            columns.append(line((0.0, low), (0.0, high), left, None))
            columns.append(line((0.6, low), (0.6, high), right, None))
            if not storey:
                feet = [columns[0][0], columns[1][0]]
            left, right = columns[-2][-1], columns[-1][-1]
            beams.append(line((0.0, high), (0.6, high), left, right))
        return nodes, elements, feet, columns, beams

    nodes, elements, feet, columns, beams = layout()

    def build(spread):
        return ar.FrameModel(nodes, elements, _strips(len(elements), 0.008, spread), fixed=feet)

    model = build(0.0)
    sensors = [model.dof(node, "u") for column in columns for node in column[1:]]
    sensors += [model.dof(node, "v") for beam in beams for node in beam[1:-1]]
    return build, model, tuple(sensors), columns, beams


def _portals():
    for storeys, divisions, top in (
        (1, 2, 300.0),
        (1, 4, 300.0),
        (2, 2, 250.0),
        (2, 4, 250.0),
        (3, 2, 120.0),
    ):
        build, model, sensors, columns, _ = _portal(storeys, divisions)
        force = model.dof(columns[0][-1], "u")
        yield Case("portal", f"{storeys} storeys of {divisions}, corner", build, force, sensors, (4.0, top))
    for storeys, divisions, top in ((1, 4, 300.0), (2, 2, 250.0)):
        build, model, sensors, columns, _ = _portal(storeys, divisions)
        force = model.dof(columns[0][divisions // 2], "u")
        yield Case("portal", f"{storeys} storeys of {divisions}, column", build, force, sensors, (4.0, top))
    build, model, sensors, _, beams = _portal(1, 4)
    force = model.dof(beams[0][1], "v")
    yield Case("portal", "1 storey of 4, beam", build, force, sensors, (4.0, 300.0))


def _grillage(nx, ny, span_m, corners):
    """Beams in two directions, bending out of the plane; the edge simply supported, or its corners."""

    def at(i, j):
        return i * ny + j

    nodes = [(span_m[0] * i / (nx - 1), span_m[1] * j / (ny - 1), 0.0) for i in range(nx) for j in range(ny)]
    elements = [(at(i, j), at(i + 1, j)) for i in range(nx - 1) for j in range(ny)]
    elements += [(at(i, j), at(i, j + 1)) for i in range(nx) for j in range(ny - 1)]
    edge = [
        at(i, j)
        for i in range(nx)
        for j in range(ny)
        if (i in (0, nx - 1) and j in (0, ny - 1)) or (not corners and (i in (0, nx - 1) or j in (0, ny - 1)))
    ]
    fixed = [(node, ("u", "v", "rz")) for node in range(nx * ny) if node not in edge]
    fixed += [(node, ("u", "v", "w", "rz")) for node in edge]

    def build(spread):
        return ar.FrameModel(nodes, elements, _strips(len(elements), 0.006, spread), fixed=fixed)

    model = build(0.0)
    inner = [node for node in range(nx * ny) if node not in edge]
    return build, model, {node: model.dof(node, "w") for node in inner}


def _grillages():
    for nx, ny, span, corners, top in (
        (5, 5, (0.8, 0.8), False, 260.0),
        (5, 5, (0.8, 0.6), False, 300.0),
        (7, 5, (0.9, 0.6), False, 260.0),
        (3, 3, (0.8, 0.8), True, 150.0),
        (4, 3, (0.9, 0.6), True, 180.0),
        (5, 3, (1.0, 0.5), True, 180.0),
        (5, 5, (0.8, 0.6), True, 120.0),
    ):
        build, _, sensors = _grillage(nx, ny, span, corners)
        force = next(iter(sensors.values()))
        held = "corners" if corners else "edge"
        name = f"{nx} x {ny}, {span[0]:g} x {span[1]:g} m, {held} held"
        yield Case("grillage", name, build, force, tuple(sensors.values()), (4.0, top))


def cases():
    """The thirty, in four kinds."""
    return [*_chains(), *_rings(), *_portals(), *_grillages()]
