"""What tests of models share: structures drawn at random, and what models and refusals are held against."""

import warnings

import numpy as np

import antires_rs as ar
from reference.exact_roots import ExactPencil
from tests.support.tolerances import PROMISE, PROMISE_ULPS, ROUNDING


def random_structure(seed, n):
    """Stiffness and mass of a chain with springs to ground and between far dofs, and its generator."""
    rng = np.random.default_rng(seed)
    k = np.diag(rng.uniform(1e4, 1e5, n))
    far = [tuple(rng.choice(n, 2, replace=False)) for _ in range(n)]
    for i, j in [(i, i + 1) for i in range(n - 1)] + far:
        s = rng.uniform(1e4, 1e6)
        k[[i, j], [i, j]] += s
        k[[i, j], [j, i]] -= s
    return k, np.diag(rng.uniform(0.5, 5.0, n)), rng


def bordered_receptance(k, m, c, i, j, hz):
    """H_ij of K u + C' l = f, C u = 0."""
    system = np.block([[k - (2.0 * np.pi * hz) ** 2 * m, c.T], [c, np.zeros((len(c), len(c)))]])
    return np.linalg.solve(system, np.eye(len(system))[j])[i]


def assert_promise(k_mat, m_mat, i, k, freq_hz):
    """Each root within max(1e-9, 20 times the shift of one ulp) of the root of the assembled doubles."""
    exact = ExactPencil(k_mat, m_mat)
    for f in freq_hz:
        error, ulp = exact.error(i, k, f)
        assert abs(error) <= max(PROMISE, PROMISE_ULPS * ulp), (i, k, f, error, ulp)


def same_matrices(one, other, within=100 * ROUNDING):
    for mine, theirs in ((one.stiffness(), other.stiffness()), (one.mass(), other.mass())):
        assert abs(mine - theirs).max() <= within * abs(theirs).max()


def rigid_force(model):
    """Largest force of the rigid motions of a plane frame, over the largest stiffness."""
    motions = np.zeros((model.n_dof, 3))
    for node, (x, y) in enumerate(model.nodes_m):
        motions[[model.dof(node, d) for d in ("u", "v", "theta")]] = [[1, 0, -y], [0, 1, x], [0, 0, 1]]
    return np.abs(model.stiffness() @ motions).max() / abs(model.stiffness()).max()


def warned(make):
    """What a call makes, and the warnings it gives."""
    with warnings.catch_warnings(record=True, action="always") as caught:
        made = make()
    return made, [str(each.message) for each in caught]


def quietly(call, *args, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.AntiresWarning)
        return call(*args, **options)
