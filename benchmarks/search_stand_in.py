"""A frame of the exhaust system's size, for studies of searches: 48 nodes in a tree, 47 beams, 144 dofs.

Plane Euler-Bernoulli beams with axial stiffness and consistent mass, assembled here, independently of the
library. A pipe of 38 mm with two bends, a fork at its end, five lumped masses on soft springs; 16
accelerometers, shaker at node 3. ``search_problem(element, beta)`` takes exact targets from the same
model with one element damaged: it asks whether a search finds what is there to be found.
"""

import numpy as np

import antires_rs as ar

E_PA, DENSITY, OUTER_M, WALL_M = 210e9, 7850.0, 0.038, 0.0015
BAND_HZ = 260.0
#: Candidate elements of the paper's damage study, its 18-47.
CANDIDATES = tuple(range(17, 47))
EXCITATION = 3 * 3 + 1
LUMPED_KG = {6: 2.0, 15: 3.5, 24: 1.0, 33: 4.0, 47: 1.5}
SPRINGS_N_PER_M = {1: 2.0e3, 14: 2.5e3, 28: 2.0e3, 40: 2.2e3}


def nodes():
    """Coordinates (48, 2) in m and the 47 pairs of nodes: a line with bends, and a branch from node 36."""
    lengths = np.full(39, 2.3 / 39 * 1.08)
    angles = np.zeros(39)
    angles[8:12], angles[18:22], angles[27:30] = 0.9, -0.8, 0.6
    line = np.vstack([[0.0, 0.0], np.cumsum(lengths[:, None] * np.c_[np.cos(angles), np.sin(angles)], axis=0)])
    branch = line[36] + np.outer(np.arange(1, 9), 0.05 * np.array([np.cos(1.1), np.sin(1.1)]))
    pairs = [(i, i + 1) for i in range(39)] + [(36, 40)] + [(i, i + 1) for i in range(40, 47)]
    return np.vstack([line, branch]), pairs


def beam(a, b):
    """Stiffness and consistent mass (6, 6) of the pipe between two points."""
    inner = OUTER_M - 2 * WALL_M
    area = np.pi / 4 * (OUTER_M**2 - inner**2)
    inertia = np.pi / 64 * (OUTER_M**4 - inner**4)
    span = b - a
    length = float(np.hypot(*span))
    c, s = span / length
    ea, ei = E_PA * area / length, E_PA * inertia / length**3
    k, m = np.zeros((6, 6)), np.zeros((6, 6))
    k[np.ix_([0, 3], [0, 3])] = ea * np.array([[1, -1], [-1, 1]])
    bend = [1, 2, 4, 5]
    k[np.ix_(bend, bend)] = ei * np.array(
        [[12, 6 * length, -12, 6 * length], [6 * length, 4 * length**2, -6 * length, 2 * length**2],
         [-12, -6 * length, 12, -6 * length], [6 * length, 2 * length**2, -6 * length, 4 * length**2]])
    weight = DENSITY * area * length
    m[np.ix_([0, 3], [0, 3])] = weight / 6 * np.array([[2, 1], [1, 2]])
    m[np.ix_(bend, bend)] = weight / 420 * np.array(
        [[156, 22 * length, 54, -13 * length], [22 * length, 4 * length**2, 13 * length, -3 * length**2],
         [54, 13 * length, 156, -22 * length], [-13 * length, -3 * length**2, -22 * length, 4 * length**2]])
    turn = np.zeros((6, 6))
    turn[:3, :3] = turn[3:, 3:] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
    return turn.T @ k @ turn, turn.T @ m @ turn


class StandIn:
    """The frame as a case: ``model``, ``excitation``, ``responses``, ``search_problem``."""

    excitation = EXCITATION
    #: 16 accelerometers, across the pipe and along it in turn.
    responses = tuple(3 * node + (1 if i % 4 else 0) for i, node in enumerate(
        (0, 3, 6, 9, 12, 15, 18, 21, 24, 27, 30, 33, 36, 39, 43, 47)))

    def __init__(self):
        self.stiffness, self.mass, self.terms = self._assembled()
        self.model = ar.MatrixModel(self.stiffness, self.mass, stiffness_terms=self.terms)

    @staticmethod
    def _assembled():
        points, pairs = nodes()
        n = 3 * len(points)
        k, m, terms = np.zeros((n, n)), np.zeros((n, n)), []
        for a, b in pairs:
            dofs = np.r_[3 * a:3 * a + 3, 3 * b:3 * b + 3]
            k_e, m_e = beam(points[a], points[b])
            term = np.zeros((n, n))
            term[np.ix_(dofs, dofs)] = 0.5 * (k_e + k_e.T)
            terms.append(term)
            k += term
            m[np.ix_(dofs, dofs)] += 0.5 * (m_e + m_e.T)
        for node, weight in LUMPED_KG.items():
            m[3 * node, 3 * node] += weight
            m[3 * node + 1, 3 * node + 1] += weight
            m[3 * node + 2, 3 * node + 2] += 2e-3 * weight
        for node, stiffness in SPRINGS_N_PER_M.items():
            k[3 * node, 3 * node] += stiffness
            k[3 * node + 1, 3 * node + 1] += stiffness
        return k, m, terms

    def search_problem(self, element, beta):
        """Exact targets of this model with one element damaged; 30 candidate elements."""
        damaged = ar.MatrixModel(self.stiffness - beta * self.terms[element], self.mass)
        zeros = damaged.antiresonances(self.responses, EXCITATION, f_max_hz=BAND_HZ)
        measured = ar.AntiresonanceSet(EXCITATION, dict(zip(self.responses, zeros, strict=True)))
        return ar.UpdatingProblem(self.model, ar.stiffness_reduction(list(CANDIDATES)), measured,
                                  penalty=ar.DamagePenalty())
