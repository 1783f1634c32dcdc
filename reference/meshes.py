"""Meshes of space beams of any size, by generators: a slender tower, a flat grillage, a lattice."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from antires_rs import FrameModel, Tube

#: Young's modulus (Pa) and density (kg/m3) of steel.
STEEL_PA, STEEL_KG_PER_M3 = 2.1e11, 7850.0


class Mesh(NamedTuple):
    """Nodes (n, 3), elements as (node, node), and the nodes that are held in all six directions."""

    name: str
    nodes_m: np.ndarray
    elements: list[tuple[int, int]]
    held: list[int]

    @property
    def n_dof(self) -> int:
        """Free degrees of freedom."""
        return 6 * (len(self.nodes_m) - len(self.held))


def grid(name: str, cells: tuple[int, int, int], size_m: tuple[float, float, float]) -> Mesh:
    """A lattice of ``cells`` boxes with beams along their edges; its lowest corners are held.

    The nodes are moved by up to 3 % of a cell, always alike, so that no mode is repeated.
    """
    counts = [c + 1 for c in cells]
    index = np.arange(np.prod(counts)).reshape(counts)
    places = np.stack(np.meshgrid(*[np.arange(c) for c in counts], indexing="ij"), axis=-1).reshape(-1, 3)
    moved = 0.03 * np.sin(1.7 * np.arange(places.size).reshape(places.shape) + 0.3)
    nodes = (places + moved * (np.array(counts) > 1)) * np.array(size_m)
    elements: list[tuple[int, int]] = []
    for axis in range(3):
        first = np.take(index, range(counts[axis] - 1), axis=axis).ravel()
        second = np.take(index, range(1, counts[axis]), axis=axis).ravel()
        elements += list(zip(first.tolist(), second.tolist(), strict=True))
    corners = {int(index[x, y, 0]) for x in (0, cells[0]) for y in (0, cells[1])}
    return Mesh(name, nodes, elements, sorted(corners))


def tower(n_dof: int) -> Mesh:
    """Two by two bays, as many storeys as it takes."""
    return grid("tower", (2, 2, max(1, round(n_dof / 54) - 1)), (3.0, 3.0, 3.0))


def grillage(n_dof: int) -> Mesh:
    """A square grid, slightly arched, so that bending and plane motion are one problem."""
    side = max(2, round((n_dof / 6) ** 0.5) - 1)
    mesh = grid("grillage", (side, side, 0), (1.0, 1.0, 1.0))
    across = np.sin(np.pi * mesh.nodes_m[:, :2] / side).prod(axis=1)
    mesh.nodes_m[:, 2] = 0.02 * side * across
    return mesh


def lattice(n_dof: int) -> Mesh:
    """A cube of boxes."""
    side = max(2, round((n_dof / 6) ** (1 / 3)) - 1)
    return grid("lattice", (side, side, side), (2.0, 2.0, 2.0))


MESHES = {"tower": tower, "grillage": grillage, "lattice": lattice}


def frame(mesh: Mesh, **parts: Any) -> FrameModel:
    """The mesh of steel tubes as a ``FrameModel``."""
    directions = ("u", "v", "w", "rx", "ry", "rz")
    return FrameModel(
        mesh.nodes_m,
        mesh.elements,
        Tube(0.2, 0.01, STEEL_PA, STEEL_KG_PER_M3),
        fixed=[(node, direction) for node in mesh.held for direction in directions],
        **parts,
    )


def lumped(mass: Any) -> Any:
    """The mass lumped: rows of translations summed on the diagonal, rotations without mass."""
    n = mass.shape[0]
    axes = np.arange(n) % 6 < 3
    ones = axes.astype(float)
    own = np.where(axes, mass @ ones, 0.0)
    return sp.diags_array(own).tocsc()
