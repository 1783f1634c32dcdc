"""Models whose antiresonances rounding hides, against exact roots: none is missed or invented in silence.

Springs and masses have few binary digits, so that K of a free structure is singular to the last bit.
"""

from __future__ import annotations

import warnings

import flint
import mpmath
import numpy as np

import antires_rs as ar
from reference.exact_pencils import PRECISION, ExactRoots, determinant, number, whole_numbers
from reference.torture import Torture
from reference.torture_verdict import NEARLY_REAL, VANISHING

#: Relative distance within which a frequency is that of a root.
SAME = 1e-6
#: Ten times the part of the largest residue below which a pole is not seen.
NEGLIGIBLE = 1e-11


def rounded(values, digits=20):
    """``values`` with so many binary digits, so that sums of some are exact."""
    fraction, exponent = np.frexp(values)
    return np.ldexp(np.round(np.ldexp(fraction, digits)), exponent - digits)


def springs(rng, n, links=0.3):
    """K of a free tree of springs with some more of them."""
    k_mat = np.zeros((n, n))
    pairs = [(int(rng.integers(j)), j) for j in range(1, n)]
    pairs += [(a, b) for a in range(n) for b in range(a) if rng.random() < links / n]
    for (a, b), stiffness in zip(pairs, rounded(1e3 * 10 ** rng.uniform(0, 3, len(pairs))), strict=True):
        k_mat[[a, b], [a, b]] += stiffness
        k_mat[a, b] -= stiffness
        k_mat[b, a] -= stiffness
    return k_mat


def massless(rng, free):
    """One to n - 1 (of those held n - 2) dofs without mass, response and force anywhere."""
    n = int(rng.integers(3, 13))
    k_mat, mass = springs(rng, n), rounded(rng.uniform(0.3, 3.0, n))
    mass[rng.permutation(n)[: rng.integers(1, n if free else n - 1)]] = 0.0
    if not free:
        held = rng.permutation(n)[: rng.integers(1, 3)]
        k_mat[held, held] += rounded(rng.uniform(1e3, 1e6, held.size))
    return k_mat, np.diag(mass), *map(int, rng.integers(n, size=2))


def clustered(rng):
    """Oscillators on a structure whose frequencies are 1e-6 to 1e-12 of each other apart."""
    n, more = int(rng.integers(2, 8)), int(rng.integers(2, 4))
    k_mat, mass = np.zeros((n + more, n + more)), rounded(rng.uniform(0.3, 3.0, n + more))
    k_mat[:n, :n] = springs(rng, n)
    k_mat[0, 0] += rounded(rng.uniform(1e3, 1e6))
    rate, gap = 10 ** rng.uniform(3, 6), 10 ** rng.uniform(-12, -6)
    at = int(rng.integers(n))
    for j in range(n, n + more):
        place = at if rng.random() < 0.7 else int(rng.integers(n))
        stiffness = rate * mass[j] * (1 + 2 * gap * rng.uniform(-1, 1))
        k_mat[[place, j], [place, j]] += stiffness
        k_mat[place, j] = k_mat[j, place] = -stiffness
    ends = [at, at if rng.random() < 0.5 else int(rng.integers(n))]
    return k_mat, np.diag(mass), *ends


def both_singular(rng):
    """Parts without a support, of which each has dofs without mass."""
    k_one, m_one, *ends = massless(rng, free=True)
    k_other, m_other, *_ = massless(rng, free=bool(rng.integers(2)))
    n, m = len(k_one), len(k_other)
    k_mat, m_mat = np.zeros((n + m, n + m)), np.zeros((n + m, n + m))
    k_mat[:n, :n], k_mat[n:, n:], m_mat[:n, :n], m_mat[n:, n:] = k_one, k_other, m_one, m_other
    return k_mat, m_mat, *ends


KINDS = {
    "massless": lambda rng: massless(rng, free=False),
    "massless and free": lambda rng: massless(rng, free=True),
    "clusters": clustered,
    "free parts": both_singular,
}


def silent_model(kind, seed):
    """The model of a kind and a seed."""
    return Torture(kind, seed, *KINDS[kind](np.random.default_rng([seed, *kind.encode()])))


def wanted_hz(case):
    """Zeros of H_ik (Hz) that the FRF shows, all real ones, and all that may count as real; repeated."""
    exact = ExactRoots(case.stiffness, case.mass, case.response, case.excitation)
    if exact.is_zero:
        return [], [], []
    unseen = poles_not_seen(case, exact)
    real, nearly = [], []
    for root in exact.roots:
        hz = [float(mpmath.sqrt(root.x) / (2 * mpmath.pi))] * root.multiplicity
        if abs(root.imaginary) > NEARLY_REAL * root.x:
            continue
        nearly += hz
        if root.imaginary == 0 and exact.ulp(root) <= VANISHING:
            real += hz
    shown = list(real)
    for pole in unseen:
        for hz in [f for f in shown if abs(f - pole) <= SAME * pole][:1]:
            shown.remove(hz)
    return shown, real, nearly


def poles_not_seen(case, exact):
    """Poles (Hz) whose residue in H_ik is at most ten times what counts as negligible, with multiplicity."""
    mpmath.mp.prec = flint.ctx.prec = 2 * PRECISION
    a, b, shift = whole_numbers(case.stiffness, case.mass)
    below, (*of_pencil, other) = determinant(a, b), whole_numbers(exact.a, exact.b)
    above, residues = determinant(*of_pencil), []
    for place, multiplicity in below.complex_roots():
        top, bottom = above, below
        for _ in range(multiplicity - 1):
            top, bottom = top.derivative(), bottom.derivative()
        x = place.real * flint.arb(2) ** (shift - other)
        size = abs(number(top(x)) / number(bottom.derivative()(place.real)))
        hz = mpmath.sqrt(mpmath.ldexp(abs(number(place.real)), shift)) / (2 * mpmath.pi)
        residues += [(size, hz)] + [(mpmath.mpf(0), hz)] * (multiplicity - 1)
    most = max((size for size, _ in residues), default=0)
    return [float(hz) for size, hz in residues if hz > 0 and size <= NEGLIGIBLE * most]


def unmatched(these, those):
    """Which of these have no partner of their own among those."""
    those, left = list(those), []
    for f in these:
        near = min(those, key=lambda g: abs(g - f), default=np.inf)
        if abs(near - f) <= SAME * f:
            those.remove(near)
        else:
            left.append(f)
    return left


def judged(case, **options):
    """What the call missed or invented, in words, and what it warned of."""
    shown, real, nearly = wanted_hz(case)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        model = ar.MatrixModel(case.stiffness, case.mass)
        found = model.antiresonances(case.response, case.excitation, **options)
    wanted = real if options.get("include_cancelled") else shown
    wrong = [f"missed {f:.9g}" for f in unmatched(wanted, found)]
    wrong += [f"invented {f:.9g}" for f in unmatched(found, nearly)]
    return wrong, [str(w.message) for w in told]
