"""Speed of one objective value of an exhaust-like frame, one core, against SciPy on the pencils, same run.

Run:  python benchmarks/exhaust_speed.py
A stand-in for the exhaust: 48 nodes in a tree of pipes on soft springs, 144 dofs, 16 responses, the exact zeros
up to 260 Hz of a damaged state as measurement, ten elements as parameters. Values are compared before times are.
The three rivals solve the same J: SciPy's QZ on each deleted pencil, and numpy's eigh once for all responses
with the roots between the poles by bisection, vectorised over cells.
"""

# ruff: noqa: E402  (the number of BLAS threads is read once, when numpy is imported)
import os

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import pathlib
import sys
import warnings

import numpy as np
import scipy.linalg

import antires_rs as ar

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).parents[1] / "tests")]
from objective_speed import misfit, real_hz, seconds
from random_frames import assemble

MAIN, BRANCH, BAND_HZ = 36, 12, 260.0
ELEMENTS = range(18, 28)


def frame():
    """Nodes, elements and tubes; point masses and hangers as (node, value)."""
    x = np.linspace(0.0, 4.6, MAIN)
    nodes = [(v, 0.06 * np.sin(3 * v)) for v in x]
    elements = [(j, j + 1) for j in range(MAIN - 1)]
    for j in range(BRANCH):
        nodes.append((nodes[20][0] + 0.02 * (j + 1), nodes[20][1] + 0.07 * (j + 1)))
        elements.append((20 if j == 0 else MAIN + j - 1, MAIN + j))
    masses = ((0, 1.2), (8, 4.0), (18, 3.0), (30, 6.0), (47, 2.0))
    return np.array(nodes), elements, masses, (2, 15, 33)


def matrices():
    """K, M, and K of each element in ELEMENTS."""
    nodes, elements, masses, hangers = frame()
    tubes = [(0.038, 0.0015)] * len(elements)
    k_mat, m_mat = assemble(nodes, elements, tubes)
    for node, kg in masses:
        m_mat[range(3 * node, 3 * node + 3), range(3 * node, 3 * node + 3)] += kg * np.array([1, 1, 0.004])
    for node in hangers:
        k_mat[[3 * node, 3 * node + 1], [3 * node, 3 * node + 1]] += (800.0, 3000.0)
    terms = [assemble(nodes, [elements[e]], tubes[:1])[0] for e in ELEMENTS]
    return k_mat, m_mat, terms


def by_pencil(pairs, measured, limit_hz, excitation):
    """Misfit by scipy.linalg.eigvals on each deleted pencil."""
    total = 0.0
    for dof, freq in measured.items():
        pencil = [np.delete(np.delete(a, dof, 0), excitation, 1) for a in pairs]
        total += misfit(real_hz(scipy.linalg.eigvals(*pencil), limit_hz), freq)
    return total


def by_eigh(pairs, measured, limit_hz, excitation):
    """Misfit by one eigh, and bisection in every cell whose ends differ in sign: two roots in one are missed."""
    lam, phi = scipy.linalg.eigh(*pairs)
    top = (2 * np.pi * limit_hz) ** 2
    inside = np.append(lam[lam < top], top)
    total = 0.0
    for dof, freq in measured.items():
        residue = phi[dof] * phi[excitation]
        low, high = inside[:-1].copy(), inside[1:].copy()
        rising = residue[:low.size] > 0
        for _ in range(60):
            middle = 0.5 * (low + high)
            positive = (residue / (lam - middle[:, None])).sum(axis=1) > 0
            up = positive == ~rising
            low, high = np.where(up, middle, low), np.where(up, high, middle)
        crossing = np.abs((residue / (lam - low[:, None])).sum(axis=1)) < 1e3 * np.abs(residue).max()
        total += misfit(np.sqrt(low[crossing & (low > 1.0)]) / (2 * np.pi), freq)
    return total


def main():
    warnings.simplefilter("ignore")
    k_mat, m_mat, terms = matrices()
    model = ar.MatrixModel(k_mat, m_mat, stiffness_terms=terms)
    excitation, responses = 1, [3 * j + 1 for j in range(1, 48, 3)]
    damaged = ar.MatrixModel(k_mat - 0.7 * terms[4], m_mat)
    zeros = damaged.antiresonances(responses, excitation, f_max_hz=BAND_HZ)
    measured = {i: f for i, f in zip(responses, zeros, strict=True) if f.size}
    problem = ar.UpdatingProblem(model, ar.stiffness_reduction(range(len(terms))),
                                 ar.AntiresonanceSet(excitation, measured))
    limit_hz = 1.5 * problem.measured_hz.max()
    modes = model.modes().freq_hz
    print(f"{model.n_dof} dofs, {len(measured)} responses, {problem.measured_hz.size} antiresonances to {BAND_HZ:.0f} "
          f"Hz, {np.sum(modes < BAND_HZ)} modes there, {np.sum(modes < limit_hz)} to {limit_hz:.0f} Hz")
    betas = np.random.default_rng(0).uniform(0.0, 0.9, (200, len(terms)))

    def pairs(beta):
        return k_mat - np.tensordot(beta, terms, 1), m_mat

    ours = problem.evaluate_many(betas, workers=1)
    few = betas[:3]
    theirs = np.array([by_pencil(pairs(b), measured, limit_hz, excitation) for b in few])
    series = np.array([by_eigh(pairs(b), measured, limit_hz, excitation) for b in few])
    print(f"J, largest difference from ours over {len(few)}: scipy {np.abs(theirs - ours[:3]).max():.1e}, "
          f"numpy {np.abs(series - ours[:3]).max():.1e}")
    core = seconds(lambda: problem.evaluate_many(betas, workers=1), 5) / len(betas)
    eigh = seconds(lambda: [by_eigh(pairs(b), measured, limit_hz, excitation) for b in few], 3) / len(few)
    pencil = seconds(lambda: by_pencil(pairs(few[0]), measured, limit_hz, excitation), 3)
    print(f"{'one objective value, one core':40} {'ms':>9} {'per second':>11} {'ratio':>7}")
    for name, value in (("antires_rs", core), ("numpy eigh + bisection between poles", eigh),
                        ("scipy.linalg.eig on 16 pencils", pencil)):
        print(f"{name:40} {1e3 * value:9.3f} {1 / value:11.0f} {value / core:7.0f}")


if __name__ == "__main__":
    main()
