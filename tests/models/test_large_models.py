"""Large and sparse models: roots by closed forms and on the deleted pencils, nothing made dense."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as sla

import antires_rs as ar
from antires_rs.exceptions import InvalidInputError, NumericalError
from reference.meshes import MESHES, frame, lumped

#: Roots in Hz against a solver of the deleted pencil that iterates to 1e-11 in x.
AGAINST_ARPACK = 1e-8


def chain(n, k=1e6, m=2.0):
    """Masses in a row, the first on a spring to the ground, as sparse matrices."""
    main, side = np.full(n, 2.0 * k), np.full(n - 1, -k)
    main[-1] = k
    return sp.diags_array([side, main, side], offsets=[-1, 0, 1]).tocsc(), sp.diags_array(
        np.full(n, m)
    ).tocsc()


def deleted_hz(k_mat, m_mat, i, k, f_max_hz):
    """Antiresonances up to ``f_max_hz`` by shift-invert on the pencil without row i and column k."""
    limit, n = (2 * np.pi * f_max_hz) ** 2, k_mat.shape[0]
    rows, columns = np.delete(np.arange(n), i), np.delete(np.arange(n), k)
    k_ik, m_ik = k_mat[rows][:, columns].tocsc(), m_mat[rows][:, columns].tocsc()
    factor = sla.splu((k_ik - 0.41 * limit * m_ik).tocsc())
    inverse = sla.LinearOperator(k_ik.shape, matvec=lambda v: factor.solve(m_ik @ v))
    mu = sla.eigs(inverse, 60, return_eigenvectors=False, tol=1e-11)
    x = 0.41 * limit + 1.0 / mu
    x = np.sort(x[np.abs(x.imag) < 1e-7 * np.abs(x)].real)
    return np.sqrt(x[(x > 1e-6 * limit) & (x <= limit)]) / (2 * np.pi)


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


def test_matrices_come_back_as_they_were_given():
    k_mat, m_mat = chain(3000)
    model = ar.MatrixModel(k_mat, m_mat, stiffness_terms=[0.5 * k_mat])
    assert (model.stiffness() != k_mat).nnz == 0
    assert (model.mass() != m_mat).nnz == 0
    softer = model.with_parameters(ar.stiffness_factor(0, bounds=(0.5, 1.5)), 0.8)
    assert abs(softer.stiffness() - 0.9 * k_mat).max() < 1e-9


@pytest.mark.parametrize("kind", MESHES)
def test_no_root_is_missed_and_none_invented(kind):
    model = frame(MESHES[kind](2400))
    k_mat, m_mat = model.stiffness().tocsc(), model.mass().tocsc()
    lam = sla.eigsh(k_mat, 30, m_mat, sigma=-1.0, return_eigenvectors=False)
    f_max_hz = 1.001 * np.sqrt(lam.max()) / (2 * np.pi)
    n = model.n_dof
    for i, k in ((n // 2 // 6 * 6 + 2, n // 3 // 6 * 6), (n - 6, n - 6)):
        found = model.antiresonances(i, k, f_max_hz=f_max_hz)
        wanted = deleted_hz(k_mat, m_mat, i, k, f_max_hz)
        assert found.size == wanted.size > 10
        np.testing.assert_allclose(found, wanted, rtol=AGAINST_ARPACK)


@pytest.mark.parametrize("kind", ["tower", "lattice"])
def test_dofs_without_mass_are_those_of_the_condensed_matrices(kind):
    model = frame(MESHES[kind](330))
    k_mat, m_mat = model.stiffness().tocsc(), lumped(model.mass())
    massless = ar.MatrixModel(k_mat, m_mat)
    kept = m_mat.diagonal() > 0
    k_full = k_mat.toarray()
    k_cc, k_cr, k_rr = k_full[kept][:, kept], k_full[kept][:, ~kept], k_full[~kept][:, ~kept]
    small = k_cc - k_cr @ np.linalg.solve(k_rr, k_cr.T)
    mass = m_mat.diagonal()[kept]
    places = np.flatnonzero(kept)
    f_max_hz = np.sqrt(np.sort(scipy.linalg.eigh(small, np.diag(mass), eigvals_only=True))[25]) / (2 * np.pi)
    for a, b in ((3, 3), (10, 40), (61, 5)):
        rows, columns = np.delete(np.arange(mass.size), a), np.delete(np.arange(mass.size), b)
        x = scipy.linalg.eigvals(small[rows][:, columns], np.diag(mass)[rows][:, columns])
        x = x[np.isfinite(x)]
        x = np.sort(x[np.abs(x.imag) < 1e-8 * np.abs(x)].real)
        wanted = np.sqrt(x[(x > 0)]) / (2 * np.pi)
        found = massless.antiresonances(int(places[a]), int(places[b]), f_max_hz=f_max_hz)
        wanted = wanted[wanted <= f_max_hz]
        assert found.size == wanted.size > 5
        np.testing.assert_allclose(found, wanted, rtol=1e-7)


def test_a_large_model_asks_for_a_limit():
    model = ar.MatrixModel(*chain(2500))
    with pytest.raises(
        InvalidInputError, match=r"f_max_hz: got no limit for 2500 dofs; wanted a limit in Hz"
    ):
        model.antiresonances(0, 0)
    with pytest.raises(InvalidInputError, match="'pencil' for 2500 dofs"):
        model.antiresonances(0, 0, f_max_hz=1.0, method="pencil")


def test_modes_of_a_large_model():
    n, k, m = 5000, 1e6, 2.0
    model = ar.MatrixModel(*chain(n, k, m))
    wanted = np.sqrt(4 * k / m) * np.sin((2 * np.arange(1, 11) - 1) * np.pi / (4 * n + 2)) / (2 * np.pi)
    np.testing.assert_allclose(model.modes(10).freq_hz, wanted, rtol=1e-9)


def test_no_room_for_all_modes_is_our_error():
    model = ar.MatrixModel(*chain(300_000))
    for ask in (model.modes, lambda: model.frf(0, 0, [1.0], damping_ratio=0.01)):
        with pytest.raises(NumericalError, match="GB of memory are not there") as told:
            ask()
        assert isinstance(told.value, MemoryError)
        assert told.value.bytes_wanted == 8 * 6 * 300_000**2


def test_the_nominal_model_is_never_lost():
    true = ar.MassSpringChain([2.0, 1.0, 1.0], [500.0, 500.0])
    measured = ar.AntiresonanceSet(0, dict(enumerate(true.antiresonances([0, 1, 2], 0))))
    problem = ar.UpdatingProblem(true, ar.stiffness_factor([0, 1], bounds=(0.2, 5.0)), measured)
    short = ar.IslandGA(max_evaluations=200)
    for seed in range(3):
        assert ar.update(problem, optimizer=short, rng=seed).fun <= problem.cost([1.0, 1.0])
