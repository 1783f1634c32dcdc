"""What other programs' matrices are like: triangles, damping, rounding-size masses, compression."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import antires_rs as ar
from tests.models.shared import random_structure

K, M, _ = random_structure(4, 9)
NAMES = [f"{4 + dof}:Z" for dof in range(9)]


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize(("half", "word"), [(np.triu, "upper"), (np.tril, "lower")])
def test_one_triangle_is_told_and_not_to_be_halved(sparse, half, word):
    given = scipy.sparse.csc_array(half(K)) if sparse else half(K)
    remedy = rf"the {word} triangle only; wanted .*Pass A \+ A.T - diag\(A\)"
    with pytest.raises(ar.InvalidInputError, match="stiffness: got " + remedy):
        ar.MatrixModel(given, M)
    with pytest.raises(ar.InvalidInputError, match=r"stiffness_terms\[0\]: got " + remedy):
        ar.MatrixModel(K, M, stiffness_terms=[given])
    whole = given + given.T - scipy.sparse.diags_array(given.diagonal())
    np.testing.assert_array_equal(ar.MatrixModel(whole, M).stiffness().toarray(), K)


def test_hysteretic_damping_is_left_out_with_a_word():
    with pytest.warns(ar.AntiresWarning, match="stiffness: its imaginary part, 0.04 of the real one") as said:
        model = ar.MatrixModel(K * (1.0 + 0.04j), M)
    assert said[0].filename == __file__
    np.testing.assert_array_equal(model.antiresonances(2, 5), ar.MatrixModel(K, M).antiresonances(2, 5))
    complex_but_real = ar.MatrixModel(scipy.sparse.csr_array(K.astype(complex)), M)
    np.testing.assert_array_equal(complex_but_real.stiffness().toarray(), K)


def test_masses_below_zero_by_rounding_count_as_none():
    m = M.copy()
    m[3, 3] = 0.0
    without = ar.MatrixModel(K, m)
    m[3, 3] = -1e-18
    with pytest.warns(
        ar.AntiresWarning, match="mass: negative by rounding at 7:Z, -1e-18: counted as none"
    ) as said:
        model = ar.MatrixModel(K, m, dofs=NAMES)
    assert said[0].filename == __file__
    np.testing.assert_array_equal(model.antiresonances([0, 3], 5)[1], without.antiresonances([0, 3], 5)[1])
    m[3, 3] = -1e-3
    with pytest.raises(
        ar.InvalidInputError, match=r"mass\[3\]: got -0.001 kg at 7:Z; wanted no negative mass"
    ):
        ar.MatrixModel(K, m, dofs=NAMES)
    m[3, 3], m[3, 2], m[2, 3] = -1e-18, 0.1, 0.1  # joined to others: no rounding
    with pytest.raises(ar.InvalidInputError, match=r"mass\[3\].*at dof 3"):
        ar.MatrixModel(K, m)


def column(n, load):
    """A cantilever column under a load, 1 at buckling: stiffness, mass, its frame."""
    h = 2.0 / n
    nodes, beams = [(h * i, 0.0) for i in range(n + 1)], [(i, i + 1) for i in range(n)]
    frame = ar.FrameModel(nodes, beams, ar.Rectangle(0.03, 0.05, 2.1e11, 7850.0), fixed=[0])
    k = frame.stiffness().toarray()
    g = np.zeros_like(k)
    side = np.array([[36, 3 * h, -36, 3 * h], [3 * h, 4 * h * h, -3 * h, -h * h]])
    turned = side[:, [2, 3, 0, 1]] * np.outer([1, -1], [1, -1, 1, -1])
    element = np.vstack([side, turned]) / (30.0 * h)
    for i in range(n):
        dofs = [frame.dof(node, d) if node else None for node in (i, i + 1) for d in ("v", "theta")]
        free = [i for i, dof in enumerate(dofs) if dof is not None]
        g[np.ix_([dofs[i] for i in free], [dofs[i] for i in free])] += element[np.ix_(free, free)]
    buckling = 1.0 / scipy.linalg.eigh(g, k, eigvals_only=True)[-1]
    assert abs(buckling / (np.pi**2 * 2.1e11 * 0.03 * 0.05**3 / 12 / 16.0) - 1.0) < 1e-3  # Euler
    return k - load * buckling * g, frame.mass().toarray(), frame


@pytest.mark.parametrize("load", [0.5, 0.99, 1.5, 6.0])
@pytest.mark.parametrize("n", [8, 24])
def test_a_column_below_and_above_its_buckling_load(n, load):
    k, m, frame = column(n, load)
    model = ar.MatrixModel(k, m, dofs=[frame.dof_name(dof) for dof in range(len(k))])
    tip = frame.dof(n, "v")
    rest = np.arange(len(k)) != tip
    exact = scipy.linalg.eigh(k[np.ix_(rest, rest)], m[np.ix_(rest, rest)], eigvals_only=True)
    exact = np.sqrt(exact[exact > 0.0]) / (2.0 * np.pi)
    found = model.antiresonances(tip, tip, f_max_hz=400.0)
    np.testing.assert_allclose(found, exact[exact <= 400.0], rtol=1e-7)
    if load < 1.0:
        assert model.modes(n_modes=1).freq_hz[0] < frame.modes(n_modes=1).freq_hz[0]
    else:
        with pytest.raises(
            ar.NumericalError, match=f"grow without bound, most at node {n} (v|theta).*beyond buckling"
        ):
            model.modes(n_modes=3)
