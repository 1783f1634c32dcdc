"""Large and sparse models: roots by closed forms and on the deleted pencils, nothing made dense."""

from itertools import product

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as sla
from scipy.optimize import brentq

import antires_rs as ar
from reference.meshes import MESHES, frame, lumped
from tests.support.campaign import some_of
from tests.support.refusals import refused

AGAINST_ARPACK = 1e-8  #: Roots in Hz against a solver of the deleted pencil that iterates to 1e-11 in x.


def chain(n, k=1e6, m=2.0, held=False):
    main, side = np.full(n, 2.0 * k), np.full(n - 1, -k)
    main[-1] = k * (1.0 + held)
    return sp.diags_array([side, main, side], offsets=[-1, 0, 1]).tocsc(), m * sp.eye_array(n, format="csc")


def deleted(matrices, i, k):
    n = matrices[0].shape[0]
    return [a[np.delete(np.arange(n), i)][:, np.delete(np.arange(n), k)] for a in matrices]


def real_hz(x, within, f_max_hz):
    """Frequencies of the real positive ones among roots in omega squared."""
    x = x[np.isfinite(x)]
    x = np.sort(x[np.abs(x.imag) < within * np.abs(x)].real)
    hz = np.sqrt(x[x > 0.0]) / (2 * np.pi)
    return hz[(hz > 1e-3 * f_max_hz) & (hz <= f_max_hz)]


def deleted_hz(k_mat, m_mat, i, k, f_max_hz):
    """Antiresonances up to ``f_max_hz`` by shift-invert on the pencil without row i and column k."""
    shift = 0.41 * (2 * np.pi * f_max_hz) ** 2
    k_ik, m_ik = deleted((k_mat, m_mat), i, k)
    factor = sla.splu((k_ik - shift * m_ik).tocsc())
    inverse = sla.LinearOperator(k_ik.shape, matvec=lambda v: factor.solve(m_ik @ v))
    mu = sla.eigs(inverse, 60, return_eigenvectors=False, tol=1e-11)
    return real_hz(shift + 1.0 / mu, 1e-7, f_max_hz)


def test_twenty_thousand_masses_have_their_closed_form():
    n, k, m = 20_000, 1e6, 2.0
    model = ar.MatrixModel(*chain(n, k, m))
    # Held at its end, the chain is one of n - 1 masses between two walls.
    wanted = np.sqrt(4 * k / m) * np.sin(np.arange(1, 31) * np.pi / (2 * n)) / (2 * np.pi)
    found = model.antiresonances(n - 1, n - 1, f_max_hz=1.01 * wanted[-1])
    assert found.size == 30
    # An ulp of each entry of K may move x by as much, relatively.
    ulp = np.finfo(float).eps * (4 * k / m) / (2 * np.pi * wanted) ** 2
    assert np.all(np.abs(found / wanted - 1) <= ulp)


@pytest.mark.parametrize("kind", MESHES)
def test_no_root_is_missed_and_none_invented(kind):
    model = frame(MESHES[kind](2400))
    k_mat, m_mat = model.stiffness(), model.mass()
    lam = sla.eigsh(k_mat, 30, m_mat, sigma=-1.0, return_eigenvectors=False)
    f_max_hz = 1.001 * np.sqrt(lam.max()) / (2 * np.pi)
    n = model.n_dof
    for i, k in ((n // 2 // 6 * 6 + 2, n // 3 // 6 * 6), (n - 6, n - 6)):
        wanted = deleted_hz(k_mat, m_mat, i, k, f_max_hz)
        assert wanted.size > 10
        found = model.antiresonances(i, k, f_max_hz=f_max_hz)
        np.testing.assert_allclose(found, wanted, rtol=AGAINST_ARPACK)


LUMPED = product(("tower", "grillage", "lattice"), (0.0, 1e-14, 1e-11, 1e-9, 1e-8, 1e-7))
KEPT = [("tower", 0.0), ("grillage", 0.0), ("lattice", 0.0), ("tower", 1e-11), ("grillage", 1e-8)]


@pytest.mark.parametrize(
    ("kind", "rotary"), some_of(LUMPED, [*KEPT, ("lattice", 1e-14), ("grillage", 1e-9), ("tower", 1e-7)])
)
def test_dofs_with_next_to_no_mass_are_those_of_the_condensed_matrices(kind, rotary):
    mesh = frame(MESHES[kind](200 if kind == "grillage" else 330))
    stiffness, mass = mesh.stiffness(), lumped(mesh.mass())
    none = mass.diagonal() == 0.0
    model = ar.MatrixModel(stiffness, mass + sp.diags_array(np.where(none, rotary, 0.0)))
    k, kept, rest = stiffness.toarray(), np.flatnonzero(~none), np.flatnonzero(none)
    joined = k[np.ix_(kept, rest)]
    condensed = k[np.ix_(kept, kept)] - joined @ np.linalg.solve(k[np.ix_(rest, rest)], joined.T)
    masses = np.diag(mass.diagonal()[kept])
    f_max_hz = np.sqrt(scipy.linalg.eigh(condensed, masses, eigvals_only=True)[25]) / (2 * np.pi)
    for i, j in ((0, 0),) if rotary else ((0, 0), (3, 3), (10, 40), (61, 5)):
        wanted = real_hz(scipy.linalg.eigvals(*deleted((condensed, masses), i, j)), 1e-8, f_max_hz)
        assert wanted.size > 5
        found = model.antiresonances(int(kept[i]), int(kept[j]), f_max_hz=f_max_hz)
        # The inertia itself moves them by its share of the rotations' stiffness.
        np.testing.assert_allclose(found, wanted, rtol=1e-7 + 10.0 * rotary)


def test_modes_of_a_large_model_have_their_closed_form_and_all_of_them_no_room():
    n, k, m = 9000, 1e9, 1.0
    wanted = np.sqrt(4 * k / m) * np.sin(0.5 * np.pi * np.arange(1, 60) / (n + 1)) / (2.0 * np.pi)
    model = ar.MatrixModel(*chain(n, k, m, held=True))
    np.testing.assert_allclose(model.modes(f_max_hz=20.0).freq_hz, wanted[wanted <= 20.0], rtol=1e-8)
    np.testing.assert_allclose(model.modes(10).freq_hz, wanted[:10], rtol=1e-9)
    model = ar.MatrixModel(*chain(300_000))
    for ask in (model.modes, lambda: model.frf(0, 0, [1.0], damping_ratio=0.01)):
        with pytest.raises(ar.NumericalError, match="GB of memory are not there") as told:
            ask()
        assert isinstance(told.value, MemoryError)
        assert told.value.bytes_wanted == 8 * 6 * 300_000**2


def test_what_would_be_made_dense_is_refused():
    model = ar.MatrixModel(*chain(2500))
    refused("got no limit for 2500 dofs", model.antiresonances, 0, 0)
    refused("'pencil' for 2500", model.antiresonances, 0, 0, method="pencil", f_max_hz=1.0)
    k_mat, m_mat = chain(9000, 1e9)
    k_mat[4000, 4000] -= 1e10
    with pytest.raises(ar.NumericalError, match="modes of 9000 dofs up to a limit.*Check the signs"):
        ar.MatrixModel(k_mat, m_mat).modes(f_max_hz=5.0)


# -- Square structures, whose modes come in pairs
STIFFNESS = 1e6


def membrane(m, apart=0.0):
    """The model of m by m unit masses, along one side stiffer by the part `apart`."""
    line = sp.diags_array([np.full(m, 2.0), np.full(m - 1, -1.0), np.full(m - 1, -1.0)], offsets=[0, 1, -1])
    one = sp.eye_array(m)
    stiffness = STIFFNESS * (sp.kron(line, one) + (1.0 + apart) * sp.kron(one, line))
    return ar.MatrixModel(stiffness.tocsc(), sp.eye_array(m * m))


def exact_hz(m, row, column, limit_hz, apart=0.0):
    """Roots of the driving-point response in closed form, to rounding."""
    step = np.arange(1, m + 1)
    own = STIFFNESS * (2.0 - 2.0 * np.cos(np.pi * step / (m + 1)))
    shape = np.sin(np.pi * np.outer(step, step) / (m + 1)) ** 2
    poles, parts = (own[:, None] + (1.0 + apart) * own).ravel(), np.outer(shape[:, row], shape[:, column])
    order = np.argsort(poles)
    poles, parts = poles[order], parts.ravel()[order]
    first = np.flatnonzero(np.diff(poles, prepend=-1.0) > 1e-12 * poles)
    poles, parts = poles[first], np.add.reduceat(parts, first)
    poles, parts = poles[parts > 1e-12], parts[parts > 1e-12]
    inside = poles[poles < 3.0 * (2 * np.pi * limit_hz) ** 2]

    def root(low, high):
        # From the pole below on, so that two poles that nearly coincide keep their distance.
        gap = high - low
        share = brentq(lambda part: np.sum(parts / ((poles - low) - part * gap)), 1e-9, 1 - 1e-9, rtol=1e-14)
        return low + share * gap

    roots = [root(low, high) for low, high in zip(inside[:-1], inside[1:], strict=True)]
    found = np.sqrt(roots) / (2 * np.pi)
    return found[found < limit_hz]


def assert_every_root(model, m, place, limit_hz, apart=0.0):
    row, column = place
    at = row * m + column
    found = model.antiresonances([at], at, f_max_hz=limit_hz)[0]
    exact = exact_hz(m, row, column, limit_hz, apart)
    assert found.size == exact.size > 10
    np.testing.assert_allclose(found, exact, rtol=1e-9)


PLACES = {"diagonal": lambda m: (m // 3, m // 3), "anywhere": lambda m: (m // 9, m // 2)}
PLACES |= {"corner": lambda m: (0, m - 2)}
FIRST = [(18, "anywhere"), (25, "diagonal"), (27, "corner"), (33, "anywhere"), (40, "diagonal")]


@pytest.mark.parametrize(("m", "place"), some_of(product((18, 25, 27, 33, 40, 55), PLACES), FIRST))
def test_every_antiresonance_of_a_square_membrane(m, place):
    model = membrane(m)
    for limit_hz in (90.0, 125.0, 150.0):
        assert_every_root(model, m, PLACES[place](m), limit_hz * 40 / m)


FIRST = [(25, 1e-4), (33, 1e-6), (25, 1e-7), (33, 1e-8)]


@pytest.mark.parametrize(("m", "apart"), some_of(product((25, 33, 44), (1e-4, 1e-6, 1e-7, 1e-8)), FIRST))
def test_two_modes_that_nearly_coincide_keep_the_antiresonance_between_them(m, apart):
    model = membrane(m, apart)
    for place in ((m // 3, m // 3), (2, 5)):
        assert_every_root(model, m, place, 110.0 * 40 / m, apart)
