"""Random frames of Euler-Bernoulli beams, assembled here only: trees and loops, free and supported."""

from __future__ import annotations

import numpy as np

STEEL = {"e": 2.1e11, "g": 8.1e10, "rho": 7850.0}


def bending(ei, mass, length, sign):
    """Stiffness and consistent mass of (deflection, slope) at both ends; sign = -1 where slope = -dw/dx."""
    s = sign * length
    shape_k = [
        [12, 6 * s, -12, 6 * s],
        [6 * s, 4 * s * s, -6 * s, 2 * s * s],
        [-12, -6 * s, 12, -6 * s],
        [6 * s, 2 * s * s, -6 * s, 4 * s * s],
    ]
    shape_m = [
        [156, 22 * s, 54, -13 * s],
        [22 * s, 4 * s * s, 13 * s, -3 * s * s],
        [54, 13 * s, 156, -22 * s],
        [-13 * s, -3 * s * s, -22 * s, 4 * s * s],
    ]
    return ei / length**3 * np.array(shape_k), mass / 420 * np.array(shape_m)


def rod(stiffness, inertia):
    """Axial or torsional stiffness and consistent mass."""
    return stiffness * np.array([[1, -1], [-1, 1]]), inertia / 6 * np.array([[2, 1], [1, 2]])


def beam(length, diameter, wall, dimension):
    """Local K, M of a tube; (u, v, theta) or (u, v, w, tx, ty, tz) at both ends."""
    inner = diameter - 2 * wall
    area, inertia = np.pi / 4 * (diameter**2 - inner**2), np.pi / 64 * (diameter**4 - inner**4)
    mass, ei = STEEL["rho"] * area * length, STEEL["e"] * inertia
    parts = {
        2: [((0, 3), rod(STEEL["e"] * area / length, mass)), ((1, 2, 4, 5), bending(ei, mass, length, 1))],
        3: [
            ((0, 6), rod(STEEL["e"] * area / length, mass)),
            ((3, 9), rod(STEEL["g"] * 2 * inertia / length, mass * 2 * inertia / area)),
            ((1, 5, 7, 11), bending(ei, mass, length, 1)),
            ((2, 4, 8, 10), bending(ei, mass, length, -1)),
        ],
    }[dimension]
    n = 6 if dimension == 2 else 12
    k_mat, m_mat = np.zeros((n, n)), np.zeros((n, n))
    for dofs, (k, m) in parts:
        k_mat[np.ix_(dofs, dofs)] += k
        m_mat[np.ix_(dofs, dofs)] += m
    return k_mat, m_mat


def rotation(axis):
    """Matrix from global to local dofs of one element."""
    if axis.size == 2:
        c, s = axis
        block = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        return np.kron(np.eye(2), block)
    other = np.eye(3)[np.argmin(np.abs(axis))]
    second = np.cross(axis, other)
    second /= np.linalg.norm(second)
    return np.kron(np.eye(4), np.array([axis, second, np.cross(axis, second)]))


def assemble(nodes, elements, tubes):
    """K and M of a frame; ``tubes`` are (diameter, wall) of each element."""
    dimension = nodes.shape[1]
    per_node = 3 if dimension == 2 else 6
    n = per_node * len(nodes)
    k_mat, m_mat = np.zeros((n, n)), np.zeros((n, n))
    for (a, b), (diameter, wall) in zip(elements, tubes, strict=True):
        along = nodes[b] - nodes[a]
        length = np.linalg.norm(along)
        turn = rotation(along / length)
        k, m = beam(length, diameter, wall, dimension)
        dofs = np.r_[per_node * a : per_node * (a + 1), per_node * b : per_node * (b + 1)]
        k_mat[np.ix_(dofs, dofs)] += turn.T @ k @ turn
        m_mat[np.ix_(dofs, dofs)] += turn.T @ m @ turn
    return (k_mat + k_mat.T) / 2, (m_mat + m_mat.T) / 2


def random_frame(rng, most_dofs=300):
    """(K, M) of a plane or space frame of pipes: branches from a main line, some joined to loops."""
    dimension = int(rng.integers(2, 4))
    per_node = 3 if dimension == 2 else 6
    n_nodes = int(rng.integers(48 // per_node, most_dofs // per_node + 1))
    step = rng.uniform(0.03, 0.15)
    nodes, elements, ends = [np.zeros(dimension)], [], [0]
    heading = {0: unit(rng.standard_normal(dimension))}
    while len(nodes) < n_nodes:
        branch = rng.random() < 0.06
        start = int(rng.integers(0, len(nodes))) if branch else ends[-1]
        bend = 1.0 if branch else 0.15
        direction = unit(heading[start] + bend * rng.standard_normal(dimension))
        nodes.append(nodes[start] + step * rng.uniform(0.7, 1.3) * direction)
        elements.append((start, len(nodes) - 1))
        heading[len(nodes) - 1] = direction
        ends.append(len(nodes) - 1)
    if rng.random() < 0.5:
        for _ in range(int(rng.integers(1, 3))):
            a, b = rng.choice(n_nodes, 2, replace=False)
            if (a, b) not in elements and (b, a) not in elements:
                elements.append((int(a), int(b)))
    tubes = np.column_stack([rng.uniform(0.03, 0.06, len(elements)), rng.uniform(1e-3, 3e-3, len(elements))])
    k_mat, m_mat = assemble(np.array(nodes), elements, tubes)
    support = rng.integers(0, 3)
    if support == 1:
        for node in rng.choice(n_nodes, 3, replace=False):
            for d in range(dimension):
                k_mat[per_node * node + d, per_node * node + d] += rng.uniform(5e2, 5e3)
    for node in rng.choice(n_nodes, 3, replace=False):
        mass = rng.uniform(0.5, 5.0)
        for d in range(per_node):
            m_mat[per_node * node + d, per_node * node + d] += mass * (1.0 if d < dimension else 2e-3)
    if support == 2:
        fixed = np.r_[0:per_node]
        free = np.setdiff1d(np.arange(len(k_mat)), fixed)
        k_mat, m_mat = k_mat[np.ix_(free, free)], m_mat[np.ix_(free, free)]
    return k_mat, m_mat


def unit(v):
    return v / np.linalg.norm(v)


def rigid_hz(k_mat, m_mat):
    """Below this a motion is rigid: a few ulp of the stiffness against the mass."""
    scale = np.sqrt(np.diag(m_mat))
    highest = np.abs(k_mat / np.outer(scale, scale)).sum(axis=0).max()
    return np.sqrt(16 * np.finfo(float).eps * highest) / (2 * np.pi)
