"""Pencils that are hard on eigensolvers: 25 kinds, each a function of a random generator.

The first kinds are those of a LAPACK test of generalized eigenvalues (zero, identity, diagonal, defective,
graded, near over- and underflow, singular), the others those of structures (penalties, rods, repeated poles,
twins, parts that are not joined, rigid modes, dofs on different parts). Sizes 1 to 30.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference.random_models import laplacian

#: Of each kind in the full set: 1,000 pencils in all.
OF_EACH = 40


@dataclass(frozen=True)
class Torture:
    """K, M and the two dofs."""

    kind: str
    seed: int
    stiffness: np.ndarray
    mass: np.ndarray
    response: int
    excitation: int


def torture(kind, seed):
    """One pencil of a kind."""
    rng = np.random.default_rng([list(KINDS).index(kind), seed, 14])
    made = KINDS[kind](rng)
    k_mat, m_mat = made[:2]
    n = len(k_mat)
    ends = made[2:] or (rng.integers(n), rng.integers(n) if seed % 3 else None)
    i = int(ends[0])
    k = i if ends[1] is None else int(ends[1])
    k_mat, m_mat = (np.tril(a) + np.tril(a, -1).T for a in (k_mat, m_mat))
    return Torture(kind, seed, k_mat, m_mat, i, k)


def size(rng, most=24):
    """Small ones more often."""
    return int(rng.integers(2, 9)) if rng.random() < 0.5 else int(rng.integers(2, most + 1))


def chain(rng, n=None, spread=0.5):
    """A chain of masses, to ground at one end or not."""
    n = n or size(rng)
    springs = 1e4 * 2.0 ** rng.uniform(-spread, spread, n - 1)
    k_mat = laplacian(n, [(j, j + 1, s) for j, s in enumerate(springs)])
    k_mat[0, 0] += 1e4 * (rng.random() < 0.7)
    return k_mat, np.diag(2.0 ** rng.uniform(-spread, spread, n))


def mesh(rng, n=None):
    """A random tree with loops, held at some places, and a mass matrix with coupling."""
    n = n or size(rng)
    edges = [(int(rng.integers(0, j)), j) for j in range(1, n)]
    edges += [(int(a), int(b)) for a, b in rng.integers(0, n, (n // 2, 2)) if a != b]
    k_mat = laplacian(n, [(a, b, rng.uniform(1e3, 1e5)) for a, b in edges])
    k_mat[0, 0] += 1e4
    m_mat = np.diag(rng.uniform(0.2, 2.0, n))
    for a, b in edges[: n // 2]:
        m_mat[np.ix_([a, b], [a, b])] += rng.uniform(0.01, 0.1) * np.array([[2.0, 1.0], [1.0, 2.0]])
    return k_mat, m_mat


def beam(n_elements, length=1.0, stiffness=1e4, mass=1.0):
    """Euler-Bernoulli beam, free, with consistent masses."""
    h, n = length / n_elements, 2 * (n_elements + 1)
    k_mat, m_mat = np.zeros((n, n)), np.zeros((n, n))
    bend = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                     [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]])  # fmt: skip
    inert = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                      [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]])  # fmt: skip
    for e in range(n_elements):
        at = np.ix_(range(2 * e, 2 * e + 4), range(2 * e, 2 * e + 4))
        k_mat[at] += stiffness / h**3 * bend
        m_mat[at] += mass * h / 420 * inert
    return k_mat, m_mat


def some(rng):
    """Any benign structure."""
    return (chain, mesh)[int(rng.integers(2))](rng)


def zero(rng):
    k_mat, m_mat = some(rng)
    which = rng.integers(3)
    if which == 2:
        half = len(k_mat) // 2
        k_mat[half:] = k_mat[:, half:] = 0.0
        return k_mat, m_mat
    return (0.0 * k_mat, m_mat) if which else (k_mat, 0.0 * m_mat)


def identity(rng):
    n = int(rng.integers(1, 13))
    if rng.random() < 0.5:
        return np.eye(n) * rng.uniform(1, 1e6), np.eye(n)
    k_mat, _ = mesh(rng, max(n, 2))
    return (k_mat, np.eye(len(k_mat))) if rng.random() < 0.5 else (np.eye(len(k_mat)), k_mat)


def diagonal(rng):
    n = int(rng.integers(1, 25))
    k_mat, m_mat = (np.diag(10.0 ** rng.uniform(-6, 6, n)) for _ in range(2))
    dof = int(rng.integers(n))
    return k_mat, m_mat, dof, dof if rng.random() < 0.7 else int(rng.integers(n))


def defective(rng):
    """Mirror chains between mirrored dofs: the two ends leave the same roots, in one Jordan block."""
    half = int(rng.integers(2, 9))
    springs = 1e3 * rng.integers(1, 5, half).astype(float)
    masses = rng.integers(1, 4, half).astype(float)
    masses, springs = np.r_[masses, masses[::-1]], np.r_[springs, springs[:-1][::-1]]
    k_mat = laplacian(2 * half, [(j, j + 1, s) for j, s in enumerate(springs)])
    k_mat[[0, -1], [0, -1]] += 1e3
    at = int(rng.integers(1, half))
    return k_mat, np.diag(masses), at, 2 * half - 1 - at


def graded_units(rng):
    """D K D and D M D with D over 12 or 24 decades: only the units of the dofs differ."""
    k_mat, m_mat = some(rng)
    most = rng.choice([6, 12])
    d = 10.0 ** (
        rng.uniform(-most, most, len(k_mat)) if rng.random() < 0.7 else np.linspace(-most, most, len(k_mat))
    )
    return k_mat * np.outer(d, d), m_mat * np.outer(d, d)


def graded_stiffness(rng):
    """D K D beside a plain M: roots over many decades."""
    k_mat, m_mat = some(rng)
    d = 10.0 ** rng.uniform(-3, 3, len(k_mat))
    return k_mat * np.outer(d, d), m_mat


def graded_mass(rng):
    k_mat, m_mat = some(rng)
    d = 10.0 ** rng.uniform(-3, 3, len(k_mat))
    return k_mat, m_mat * np.outer(d, d)


def overflow(rng):
    k_mat, m_mat = some(rng)
    a, b = rng.choice([1e150, 1e280, 1e300, 1.0], 2)
    return k_mat * a, m_mat * b


def underflow(rng):
    k_mat, m_mat = some(rng)
    a, b = rng.choice([1e-150, 1e-290, 1.0], 2)
    return k_mat * a, m_mat * b


def singular_mass(rng):
    """Massless dofs, or a mass of low rank."""
    k_mat, m_mat = some(rng)
    n = len(k_mat)
    k_mat[0, 0] += 1e4
    if rng.random() < 0.6:
        gone = rng.random(n) < 0.5
        gone[int(rng.integers(n))] = False
        m_mat[gone] = m_mat[:, gone] = 0.0
        return k_mat, m_mat
    factor = rng.integers(-3, 4, (n, max(1, n // 2))).astype(float)
    return k_mat, factor @ factor.T


def singular_stiffness(rng):
    n = size(rng)
    springs = 1e3 * rng.integers(1, 9, n - 1).astype(float)
    k_mat = laplacian(n, [(int(rng.integers(0, j)), j, s) for j, s in enumerate(springs, 1)])
    if rng.random() < 0.3:
        factor = rng.integers(-3, 4, (n, max(1, n // 2))).astype(float)
        k_mat = 1e3 * factor @ factor.T
    return k_mat, mesh(rng, n)[1]


def both_singular(rng):
    k_mat, m_mat = singular_stiffness(rng)
    n = len(k_mat)
    gone = rng.random(n) < 0.4
    gone[int(rng.integers(n))] = False
    m_mat[gone] = m_mat[:, gone] = 0.0
    return k_mat, m_mat


def penalties(rng):
    """Supports and ties far stiffer than the structure."""
    k_mat, m_mat = some(rng) if rng.random() < 0.6 else beam(int(rng.integers(1, 8)))
    n = len(k_mat)
    for _ in range(int(rng.integers(1, 4))):
        stiff = 10.0 ** rng.uniform(6, 20)
        a, b = rng.integers(0, n, 2)
        if a == b or rng.random() < 0.5:
            k_mat[a, a] += stiff
        else:
            k_mat += laplacian(n, [(a, b, stiff)])
    return k_mat, m_mat


def rods(rng):
    """Uniform rods: masses lumped or consistent, ends free or fixed."""
    n = int(rng.integers(2, 31))
    k_mat = laplacian(n, [(j, j + 1, 1e8) for j in range(n - 1)])
    k_mat[0, 0] += 1e8 * (rng.random() < 0.5)
    if rng.random() < 0.5:
        return k_mat, np.diag(np.r_[0.5, np.ones(n - 2), 0.5] if n > 1 else np.ones(1))
    m_mat = np.zeros((n, n))
    for j in range(n - 1):
        m_mat[j : j + 2, j : j + 2] += np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    return k_mat, m_mat


def repeated_poles(rng):
    """Rings, stars, and all joined to all."""
    n = int(rng.integers(3, 21))
    shape = rng.integers(3)
    if shape == 0:
        edges = [(j, (j + 1) % n, 2e4) for j in range(n)]
    elif shape == 1:
        edges = [(0, j, 1e4) for j in range(1, n)]
    else:
        edges = [(a, b, 1e3) for a in range(n) for b in range(a)]
    k_mat = laplacian(n, edges)
    return k_mat + 3e3 * (rng.random() < 0.5) * np.eye(n), np.eye(n)


def twins(rng):
    """Two equal parts on one mass."""
    part, mass = chain(rng, int(rng.integers(2, 9)))
    n = len(part)
    k_mat, m_mat = np.zeros((2 * n + 1,) * 2), np.zeros((2 * n + 1,) * 2)
    for first in (0, n):
        at = slice(first, first + n)
        k_mat[at, at], m_mat[at, at] = part, mass
        k_mat += laplacian(2 * n + 1, [(first, 2 * n, 1e4)])
    m_mat[-1, -1] = 1.5
    return k_mat, m_mat


def joined(parts):
    """Parts beside each other."""
    n = sum(len(k) for k, _ in parts)
    k_mat, m_mat, first = np.zeros((n, n)), np.zeros((n, n)), 0
    for k_part, m_part in parts:
        at = slice(first, first + len(k_part))
        k_mat[at, at], m_mat[at, at] = k_part, m_part
        first += len(k_part)
    return k_mat, m_mat


def disconnected(rng):
    """Parts that nothing joins, both dofs on the first."""
    first = chain(rng, int(rng.integers(2, 9)))
    n = len(first[0])
    others = [first if rng.random() < 0.5 else mesh(rng, int(rng.integers(2, 9))) for _ in range(2)]
    return *joined([first, *others]), int(rng.integers(n)), int(rng.integers(n))


def different_parts(rng):
    """The response on one part, the force on another."""
    parts = [chain(rng, int(rng.integers(1, 9)) + 1), mesh(rng, int(rng.integers(2, 9)))]
    n = len(parts[0][0])
    return *joined(parts), int(rng.integers(n)), n + int(rng.integers(len(parts[1][0])))


def rigid_body(rng):
    """Free trusses in space: six rigid modes."""
    nodes = int(rng.integers(4, 11))
    where = rng.uniform(0, 1, (nodes, 3))
    k_mat = np.zeros((3 * nodes, 3 * nodes))
    for a in range(nodes):
        for b in range(a):
            if a - b <= 3:
                along = where[a] - where[b]
                bar = np.r_[along, -along] / np.linalg.norm(along)
                at = np.r_[3 * a : 3 * a + 3, 3 * b : 3 * b + 3]
                k_mat[np.ix_(at, at)] += 1e6 * np.outer(bar, bar)
    return k_mat, np.diag(np.repeat(rng.uniform(0.5, 2.0, nodes), 3))


def beams(rng):
    """Beams, held or free, in metres or millimetres."""
    k_mat, m_mat = beam(int(rng.integers(1, 15)), 10.0 ** rng.uniform(-1, 3), 10.0 ** rng.uniform(0, 8))
    fixed = 2 * int(rng.integers(2))
    return k_mat[fixed:, fixed:], m_mat[fixed:, fixed:]


def indefinite_stiffness(rng):
    """A load beyond buckling."""
    k_mat, m_mat = some(rng)
    k_mat -= np.diag(rng.uniform(0, 2, len(k_mat)) * np.abs(np.diag(k_mat)) * (rng.random(len(k_mat)) < 0.4))
    return k_mat, m_mat


def without_structure(rng):
    """Symmetric positive definite matrices that have nothing in common, of any condition."""
    n = size(rng)

    def one(decades):
        q, _ = np.linalg.qr(rng.standard_normal((n, n)))
        return q @ np.diag(10.0 ** rng.uniform(-decades, 0, n)) @ q.T

    return 1e4 * one(float(rng.choice([1, 4, 9]))), one(float(rng.choice([0.5, 3])))


def touching(rng):
    """Two roots that nearly meet: a driving point whose parts are nearly equal, or a transfer past them."""
    part, mass = chain(rng, int(rng.integers(2, 6)))
    other = part * (1.0 + 10.0 ** rng.uniform(-16, -3))
    n = len(part)
    k_mat, m_mat = joined([(part, mass), (other, mass), (np.zeros((2, 2)), np.eye(2))])
    k_mat += laplacian(2 * n + 2, [(0, 2 * n, 1e3), (2 * n, 2 * n + 1, 1e4), (2 * n + 1, n, 1e3)])
    return k_mat, m_mat, 2 * n, 2 * n + int(rng.integers(2))


def nearly_cancelled(rng):
    """A mirror chain whose symmetry is off by 1e-3 to 1e-16, held at its middle."""
    half = int(rng.integers(2, 10))
    masses = rng.uniform(0.9, 1.1, half)
    springs = 1e4 * rng.uniform(0.9, 1.1, half)
    springs = np.r_[springs, springs[::-1]]
    springs[-1] *= 1.0 + 10.0 ** rng.uniform(-16, -3)
    n = 2 * half + 1
    k_mat = laplacian(n, [(j, j + 1, s) for j, s in enumerate(springs)])
    k_mat[[0, -1], [0, -1]] += 1e4
    return k_mat, np.diag(np.r_[masses, 1.0, masses[::-1]]), half, int(rng.integers(n))


def weakly_joined(rng):
    """Two parts on a spring of next to nothing."""
    parts = [chain(rng, int(rng.integers(2, 10))), mesh(rng, int(rng.integers(2, 10)))]
    k_mat, m_mat = joined(parts)
    n = len(parts[0][0])
    weak = 1e4 * 10.0 ** rng.uniform(-18, -3)
    return k_mat + laplacian(len(k_mat), [(n - 1, n, weak)]), m_mat


KINDS = {
    made.__name__: made
    for made in (
        zero, identity, diagonal, defective, graded_units, graded_stiffness, graded_mass, overflow,
        underflow, singular_mass, singular_stiffness, both_singular, penalties, rods, repeated_poles, twins,
        disconnected, different_parts, rigid_body, beams, indefinite_stiffness, without_structure, touching,
        nearly_cancelled, weakly_joined,
    )
}  # fmt: skip
