"""Meshes whose elements are in groups, and tests of structures that are off them: for damage at size."""

from __future__ import annotations

import warnings

import numpy as np
import scipy.sparse as sp

import antires_rs as ar
from reference.concrete_frames import DIRECTIONS
from reference.meshes import Mesh, frame

#: Relative scatter of frequencies.
NOISE = 5e-4


def grouped(mesh, n_groups):
    """Elements in groups of neighbours: halved across their longest side until there are enough."""
    nodes = np.asarray(mesh.nodes_m)
    middles = np.array([0.5 * (nodes[a] + nodes[b]) for a, b in mesh.elements])
    groups = [np.arange(len(middles))]
    while len(groups) < n_groups:
        largest = groups.pop(int(np.argmax([len(g) for g in groups])))
        axis = int(np.argmax(np.ptp(middles[largest], axis=0)))
        order = largest[np.argsort(middles[largest][:, axis], kind="stable")]
        groups += [order[: order.size // 2], order[order.size // 2 :]]
    return groups


def of_groups(make, groups, bounds):
    """A parameter for each group."""
    return [make([int(e) for e in group], bounds=bounds, together=True) for group in groups]


def measured(model, sensors, force, limit_hz, rng):
    """Antiresonances with noise."""
    zeros = model.antiresonances(sensors, force, f_max_hz=limit_hz)
    noisy = [np.sort(f * (1.0 + NOISE * rng.standard_normal(f.size))) for f in zeros]
    stds = {dof: NOISE * f for dof, f in zip(sensors, noisy, strict=True)}
    return ar.AntiresonanceSet(force, dict(zip(sensors, noisy, strict=True)), std_hz=stds)


def with_groups(mesh, model, groups):
    """The matrices of a model, a term for each group: that of a mesh of its elements alone."""
    terms = []
    for group in groups:
        elements = [mesh.elements[e] for e in group]
        nodes = sorted({node for pair in elements for node in pair})
        own = {node: number for number, node in enumerate(nodes)}
        part = Mesh(
            mesh.name,
            np.asarray(mesh.nodes_m)[nodes],
            [(own[a], own[b]) for a, b in elements],
            [own[node] for node in nodes if node in set(mesh.held)],
        )
        with warnings.catch_warnings():  # a part may fall to pieces
            warnings.simplefilter("ignore")
            alone = frame(part)
        free = [(node, d) for node in nodes if node not in set(mesh.held) for d in DIRECTIONS]
        here = [alone.dof(own[node], d) for node, d in free]
        there = np.array([model.dof(node, d) for node, d in free])
        term = alone.stiffness()[np.ix_(here, here)].tocoo()
        placed = (term.data, (there[term.row], there[term.col]))
        terms.append(sp.coo_array(placed, shape=(model.n_dof, model.n_dof)).tocsc())
    return ar.MatrixModel(model.stiffness(), model.mass(), stiffness_terms=terms)
