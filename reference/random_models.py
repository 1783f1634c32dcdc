"""Random models and an independent oracle for their antiresonances, by SciPy alone."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

#: A QZ root whose first-order uncertainty exceeds this part of its distance from zero and infinity is
#: taken for zero or infinite: a scattered infinite one of multiplicity m has 1/m, finite ones < 1e-5.
ORACLE_UNCERTAINTY = 1e-3
#: Imaginary part, relative, below which a simple root counts as real.
REAL_ROOT = 1e-9
#: Uncertainties of a QZ root within which it belongs to a multiple one: a defective pair lies one
#: uncertainty apart over n, a margin of ten covers the constants.
CLUSTER = 10.0
#: A QZ root of larger uncertainty leaves open whether it is finite: that pair says nothing and is skipped.
DOUBTFUL = 1e-6
#: Residue, relative to the largest, below which dof and mode do not see each other (the definition).
NEGLIGIBLE_RESIDUE = 1e-12
#: Eigenvalues closer than this many n ulp of the largest are one, repeated: rounding of eigh.
REPEATED = 64.0
#: A root that cancels lies on its pole, relatively in omega squared, but for rounding of both.
ON_A_POLE = 1e-6

KINDS = ("chain", "frame", "spd", "symmetric")


def laplacian(n, springs):
    """Stiffness of springs (a, b, k) between n dofs."""
    k_mat = np.zeros((n, n))
    for a, b, k in springs:
        k_mat[[a, b], [a, b]] += k
        k_mat[[a, b], [b, a]] -= k
    return k_mat


def chain(n, rng):
    k_mat = laplacian(n, [(j, j + 1, k) for j, k in enumerate(1e4 * rng.uniform(0.5, 2.0, n - 1))])
    k_mat[0, 0] += 1e4 * (rng.random() < 0.4)
    k_mat[-1, -1] += 2e4 * (rng.random() < 0.4)
    return k_mat, np.diag(rng.uniform(0.5, 2.0, n))


def frame(n, rng):
    """A random tree with some loops, springs to ground or none, and a mass matrix with coupling."""
    edges = [(int(rng.integers(0, j)), j) for j in range(1, n)]
    edges += [(int(a), int(b)) for a, b in rng.integers(0, n, (n // 2, 2)) if a != b]
    k_mat = laplacian(n, [(a, b, rng.uniform(1e3, 1e5)) for a, b in edges])
    if rng.random() < 0.5:
        k_mat[np.diag_indices(n)] += np.where(rng.random(n) < 0.2, 1e4, 0.0)
    m_mat = np.diag(rng.uniform(0.2, 2.0, n))
    for a, b in edges[: n // 2]:
        m_mat[np.ix_([a, b], [a, b])] += rng.uniform(0.01, 0.1) * np.array([[2.0, 1.0], [1.0, 2.0]])
    return k_mat, m_mat


def spd(n, rng):
    """Two sparse symmetric positive definite matrices without any structure in common."""

    def one(shift):
        factor = np.where(rng.random((n, n)) < 2.0 / n, rng.standard_normal((n, n)), 0.0)
        return factor @ factor.T + shift * np.eye(n)

    return 1e4 * one(0.3), one(0.5)


def symmetric(n, rng):
    """Mirror chain, ring or star: modes with nodes, repeated eigenvalues.

    The mirror chain varies by 10 % only: in a long one with more disorder the modes of its halves come
    in pairs that agree to any number of digits, and no number tells repeated from nearly so.
    """
    shape = rng.integers(0, 3)
    if shape == 0:
        half_m, half_k = rng.uniform(0.9, 1.1, (n + 1) // 2), 1e4 * rng.uniform(0.9, 1.1, n // 2)
        masses = np.r_[half_m, half_m[: n // 2][::-1]]
        springs = np.r_[half_k, half_k[: n - 1 - n // 2][::-1]]
        k_mat = laplacian(n, [(j, j + 1, k) for j, k in enumerate(springs)])
        k_mat[[0, -1], [0, -1]] += 2e4 * (rng.random() < 0.4)
        return k_mat, np.diag(masses)
    if shape == 1:
        n = max(n, 3)
        k_mat = laplacian(n, [(j, (j + 1) % n, 2e4) for j in range(n)])
        return k_mat + 3e3 * (rng.random() < 0.4) * np.eye(n), 0.7 * np.eye(n)
    k_mat = laplacian(n, [(0, j, 1e4) for j in range(1, n)])
    k_mat[0, 0] += 5e3 * (rng.random() < 0.4)
    return k_mat, np.eye(n)


def random_model(kind, rng):
    """(K, M) of 2 to 60 dofs."""
    return globals()[kind](int(rng.integers(2, 61)), rng)


class Oracle:
    """Roots of det(K_ik - x M_ik) = 0 by ``scipy.linalg.eig``, and what is known of each.

    QZ on the whole deleted pencil is not good enough for i and k far apart: the pencil is then so far
    from normal that a relative change of 1e-16 moves its roots by per cents (a random chain of 60).
    What makes it so is its structure, a block-triangular form whose off-diagonal blocks do not matter to the
    roots. So the pencil is first brought to that form (a perfect matching of rows with columns, then the
    strong components of the directed graph: Dulmage & Mendelsohn), which is exact, and QZ is applied
    to each irreducible block.

    An infinite eigenvalue of multiplicity m comes back from QZ scattered over eps**(-1/m). Homogeneous
    eigenvalues (alpha, beta) and both vectors give the first-order chordal uncertainty
    ``n eps |y||v| / hypot(|y'Av|, |y'Bv|)`` (Stewart & Sun 1990, VI.2.2). Such a scattered one has an
    uncertainty of 1/m of its own distance to infinity, a finite one lies far below: dropped is what exceeds
    1e-3. The same holds for zero.
    """

    def __init__(self, k_mat, m_mat, i, k):
        a, b = (np.delete(np.delete(matrix, i, 0), k, 1) for matrix in (k_mat, m_mat))
        roots, uncertain = [np.empty(0)], [np.empty(0)]
        for rows, cols in irreducible_blocks(a, b):
            x, u = qz(a[np.ix_(rows, cols)], b[np.ix_(rows, cols)])
            roots.append(x)
            uncertain.append(u)
        self.roots, self.uncertainty = np.concatenate(roots), np.concatenate(uncertain)

    def is_sound(self, low, high):
        """Whether no root of low < |x| <= high is of the doubtful sort between finite and infinite."""
        size, u = np.abs(np.nan_to_num(self.roots, nan=np.inf)), self.uncertainty
        inside = np.isfinite(size) & (size > low) & (size <= 1.01 * high)
        return not np.any(inside & (u > DOUBTFUL))

    def freq_hz(self, low, high):
        """Real roots of low < x <= high that are certain, as ascending Hz, clusters at their mean.

        The QZ roots of a defective root of multiplicity m lie eps**(1/m) around it, real or complex;
        their mean is as good as a simple root.
        """
        certain = np.isfinite(self.roots) & (self.uncertainty <= ORACLE_UNCERTAINTY) & (self.roots.real > 0)
        x, u = self.roots[certain], self.uncertainty[certain]
        real = np.abs(x.imag) <= np.maximum(REAL_ROOT, CLUSTER * u) * np.abs(x)
        order = np.argsort(x[real].real)
        values, reach = x[real].real[order], (CLUSTER * u[real])[order]
        gap = np.diff(values) > np.maximum(REAL_ROOT, np.maximum(reach[1:], reach[:-1])) * values[1:]
        for cluster in np.split(np.arange(values.size), np.flatnonzero(gap) + 1):
            values[cluster] = values[cluster].mean() if cluster.size else values[cluster]
        return np.sqrt(values[(values > low) & (values <= high)]) / (2 * np.pi)


def irreducible_blocks(a, b):
    """Row and column indices of the diagonal blocks; none for a structurally singular pencil."""
    pattern = (a != 0) | (b != 0)
    if pattern.size == 0:
        return []
    column = perfect_matching(pattern)
    if column is None:
        return []
    count, label = connected_components(csr_array(pattern[:, column].astype(np.int8)), connection="strong")
    return [(np.flatnonzero(label == c), column[label == c]) for c in range(count)]


def perfect_matching(pattern):
    """A column for each row, by augmenting paths; None where there are not enough.

    ``scipy.sparse.csgraph.maximum_bipartite_matching`` does not end on some frames of 200 dofs (SciPy 1.17).
    """
    choices = [np.flatnonzero(row).tolist() for row in pattern]
    row_of, column = {}, [None] * len(choices)
    for root in range(len(choices)):
        came_from, pending, free = {}, [root], None
        while pending and free is None:
            row = pending.pop()
            for c in choices[row]:
                if c not in came_from:
                    came_from[c] = row
                    if c not in row_of:
                        free = c
                        break
                    pending.append(row_of[c])
        if free is None:
            return None
        while free is not None:
            row = came_from[free]
            row_of[free] = row
            free, column[row] = column[row], free
    return np.array(column)


def qz(a, b):
    """Eigenvalues x of A v = x B v, with the uncertainty relative to the distance from 0 and infinity."""
    norm_a, norm_b = np.linalg.norm(a, 2), np.linalg.norm(b, 2)
    if norm_a == 0 or norm_b == 0:
        return np.empty(0), np.empty(0)
    a, b = a / norm_a, b / norm_b
    (alpha, beta), left, right = scipy.linalg.eig(a, b, left=True, right=True, homogeneous_eigvals=True)
    left, right = (v / np.linalg.norm(v, axis=0) for v in (left, right))
    strength = np.hypot(*(np.abs(np.sum(left.conj() * (matrix @ right), axis=0)) for matrix in (a, b)))
    with np.errstate(all="ignore"):
        chordal = len(a) * np.finfo(float).eps / strength
        distance = np.minimum(np.abs(alpha), np.abs(beta)) / np.hypot(np.abs(alpha), np.abs(beta))
        return alpha / beta * (norm_a / norm_b), chordal / distance


def cancelled(k_mat, m_mat, i, k, roots_hz):
    """Which of ``roots_hz`` cancel against a pole, by ``scipy.linalg.eigh``: a mask.

    An eigenvalue of multiplicity m hides m - 1 roots, and one more when the sum of the residues
    phi_i phi_k over its eigenspace vanishes. A residue may also be negligible without a root beside
    it (a mode that lives at the other end of a long chain): there is nothing to cancel then.
    """
    lam, phi = scipy.linalg.eigh(k_mat, m_mat)
    repeated = REPEATED * lam.size * np.finfo(float).eps * lam[-1]
    groups = np.split(np.arange(lam.size), np.flatnonzero(np.diff(lam) > repeated) + 1)
    residue = np.abs([np.sum(phi[i, g] * phi[k, g]) for g in groups])
    blind = residue < NEGLIGIBLE_RESIDUE * residue.max()
    hidden = [lam[g].mean() for g, b in zip(groups, blind, strict=True) for _ in range(g.size - 1 + b)]
    mask = np.zeros(roots_hz.size, dtype=bool)
    for pole in hidden:
        distance = np.where(mask, np.inf, np.abs((2 * np.pi * roots_hz) ** 2 / max(pole, 1e-300) - 1.0))
        if distance.size and distance.min() <= ON_A_POLE:
            mask[distance.argmin()] = True
    return mask


def joined(k_mat, m_mat, i, k):
    """Whether any path of non-zero entries leads from i to k."""
    label = connected_components(csr_array(((k_mat != 0) | (m_mat != 0)).astype(np.int8)))[1]
    return label[i] == label[k]
