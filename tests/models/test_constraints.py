"""Constraints are taken out of the matrices: the same structure, against the bordered system and by hand."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import antires_rs as ar


def random_structure(seed, n):
    """A random chain with springs to ground and between far dofs."""
    rng = np.random.default_rng(seed)
    k = np.diag(rng.uniform(1e4, 1e5, n))
    for i, j in [(i, i + 1) for i in range(n - 1)] + [
        tuple(rng.choice(n, 2, replace=False)) for _ in range(n)
    ]:
        s = rng.uniform(1e4, 1e6)
        k[[i, j], [i, j]] += s
        k[i, j] -= s
        k[j, i] -= s
    return k, np.diag(rng.uniform(0.5, 5.0, n)), rng


def bordered_receptance(k, m, c, i, j, hz):
    """H_ij of K u + C' l = f, C u = 0."""
    w2 = (2.0 * np.pi * hz) ** 2
    system = np.block([[k - w2 * m, c.T], [c, np.zeros((len(c), len(c)))]])
    load = np.zeros(len(system))
    load[j] = 1.0
    return np.linalg.solve(system, load)[i]


@pytest.mark.parametrize("seed", range(8))
def test_the_response_is_that_of_the_bordered_system(seed):
    k, m, rng = random_structure(seed, 14)
    c = np.zeros((5, 14))
    for row in c[:4]:
        row[rng.choice(14, 3, replace=False)] = rng.uniform(-2.0, 2.0, 3)
    c[4] = c[0] - 2.0 * c[1]  # follows from others
    keep = [int(dof) for dof in rng.choice(14, 3, replace=False)]
    made = ar.eliminate_constraints(k, m, c, keep=keep)
    assert made.stiffness.shape == (10, 10)
    assert set(keep) <= set(made.dofs)
    assert np.abs(c @ made.transformation.toarray()).max() < 1e-12
    model = ar.MatrixModel(made.stiffness, made.mass)
    row = {dof: nth for nth, dof in enumerate(made.dofs)}
    (i, j), c = keep[:2], c[:4]
    zeros = model.antiresonances(row[i], row[j])
    for hz in zeros:
        here = [bordered_receptance(k, m, c, i, j, hz * (1.0 + step)) for step in (-1e-6, 1e-6)]
        assert here[0] * here[1] < 0.0
    poles = model.modes().freq_hz
    modes = scipy.linalg.eigh(
        *(made.transformation.T @ a @ made.transformation for a in (k, m)), eigvals_only=True
    )
    np.testing.assert_allclose(poles, np.sqrt(modes) / (2.0 * np.pi), rtol=1e-9)


def test_sparse_rows_dicts_and_arrays_say_the_same():
    k, m, _ = random_structure(1, 6)
    c = np.array([[1.0, 0.0, -1.0, 0.4, 0.0, 0.0]])
    made = [
        ar.eliminate_constraints(k, m, given, stiffness_terms=[k], mass_terms=[m])
        for given in (c, scipy.sparse.csr_array(c), [{0: 1.0, 2: -1.0, 3: 0.4}])
    ]
    for each in made[1:]:
        np.testing.assert_array_equal(each.stiffness.toarray(), made[0].stiffness.toarray())
    np.testing.assert_allclose(made[0].stiffness_terms[0].toarray(), made[0].stiffness.toarray())
    np.testing.assert_allclose(made[0].mass_terms[0].toarray(), made[0].mass.toarray())


def test_a_rigid_slab_leaves_its_master():
    """Forty columns' heads follow three dofs of the slab; each is taken out, the master stays."""
    rng = np.random.default_rng(0)
    xy = rng.uniform(-5.0, 5.0, (40, 2))
    equations = []
    for nth, (x, y) in enumerate(xy):
        equations += [{3 + 2 * nth: 1.0, 0: -1.0, 2: y}, {4 + 2 * nth: 1.0, 1: -1.0, 2: -x}]
    k, m = np.diag(np.r_[0.0, 0.0, 0.0, np.full(80, 1e5)]), np.diag(np.r_[1e3, 1e3, 1e4, np.zeros(80)])
    made = ar.eliminate_constraints(k, m, equations)
    np.testing.assert_array_equal(made.dofs, [0, 1, 2])
    expected = np.zeros((3, 3))
    for x, y in xy:
        t = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
        expected += 1e5 * t.T @ t
    np.testing.assert_allclose(made.stiffness.toarray(), expected, rtol=1e-12, atol=1e-6)


def test_lagrange_rows_become_equations():
    k, m, _ = random_structure(3, 8)
    c = np.zeros((2, 8))
    c[0, [1, 4]] = 1.0, -1.0
    c[1, [2, 5, 6]] = 1.0, -0.5, -0.5
    bordered = np.block([[k, c.T], [c, np.zeros((2, 2))]])
    mass = scipy.linalg.block_diag(m, np.zeros((2, 2)))
    order = np.random.default_rng(5).permutation(10)
    bordered, mass = bordered[np.ix_(order, order)], mass[np.ix_(order, order)]
    dofs, equations = ar.lagrange_rows(scipy.sparse.csc_array(bordered), mass)
    assert sorted(order[dofs]) == list(range(8))
    made = ar.eliminate_constraints(bordered[np.ix_(dofs, dofs)], mass[np.ix_(dofs, dofs)], equations)
    direct = ar.eliminate_constraints(k, m, c)
    freq = [ar.MatrixModel(each.stiffness, each.mass).modes().freq_hz for each in (made, direct)]
    np.testing.assert_allclose(*freq, rtol=1e-9)


def test_a_massless_dof_without_stiffness_of_its_own_is_no_multiplier():
    k = np.array([[0.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 3.0]])
    assert list(ar.lagrange_rows(k, np.diag([0.0, 0.0, 1.0]))[0]) == [0, 1, 2]


def test_what_cannot_be_kept_is_told():
    k, m, _ = random_structure(1, 6)
    with pytest.raises(
        ar.InvalidInputError, match=r"constraints\[1\]: got an equation between dofs to keep: 0, 2"
    ):
        ar.eliminate_constraints(k, m, [{1: 1.0, 3: 1.0}, {0: 1.0, 2: -1.0}], keep=[0, 2])
    with pytest.raises(ar.InvalidInputError, match=r"constraints\[0\].*6"):
        ar.eliminate_constraints(k, m, [{6: 1.0}])
    with pytest.raises(ar.InvalidInputError, match=r"constraints\[0\]: got nan; wanted a finite number"):
        ar.eliminate_constraints(k, m, [{1: np.nan}])
    with pytest.raises(ar.InvalidInputError, match="mass: got a matrix of shape"):
        ar.eliminate_constraints(k, np.eye(3), [{1: 1.0}])


WRONG_EQUATIONS = {
    "a text": ("abc", "constraints: got 'abc'"),
    "a number": (3, "constraints: got 3"),
    "one dict": ({1: 1.0, 2: -1.0}, r"one dict.*Put it in a list"),
    "a coefficient that is a text": ([{1: "a"}], r"constraints\[0\]"),
    "a row of texts": (["abc"], r"constraints\[0\]"),
    "a complex row": (np.full((1, 6), 1j), r"constraints\[0\]: got complex"),
    "a row": (np.ones(6), r"constraints\[0\]: got a row of shape"),
    "a name without names": ([{"1:Z": 1.0}], r"constraints\[0\]: got '1:Z'"),
    "a sparse row": (scipy.sparse.coo_array(np.ones(6)), r"sparse array of shape \(6,\)"),
    "more columns": (scipy.sparse.csr_array(np.ones((1, 9))), r"sparse array of shape \(1, 9\)"),
    "fewer columns": (scipy.sparse.csr_array(np.ones((1, 5))), r"sparse array of shape \(1, 5\)"),
    "NaN": (scipy.sparse.csr_array(np.full((1, 6), np.nan)), "constraints: got 6 NaN"),
    "infinite": (scipy.sparse.csr_array(np.full((1, 6), np.inf)), "constraints: got 6 NaN or infinite"),
    "complex": (scipy.sparse.csr_array(np.full((1, 6), 1j)), "constraints: got complex"),
}


@pytest.mark.parametrize("case", WRONG_EQUATIONS)
def test_wrong_equations_are_refused(case):
    k, m, _ = random_structure(1, 6)
    given, match = WRONG_EQUATIONS[case]
    with pytest.raises(ar.InvalidInputError, match=match):
        ar.eliminate_constraints(k, m, given)
    with pytest.raises(ar.InvalidInputError, match=match):
        ar.MatrixModel(k, m, constraints=given)


@pytest.mark.parametrize("keep", [3, "1:Z", np.array(3)])
def test_dofs_to_keep_are_a_sequence(keep):
    k, m, _ = random_structure(1, 6)
    with pytest.raises(ar.InvalidInputError, match="keep: got"):
        ar.MatrixModel(k, m, keep=keep)
    with pytest.raises(ar.InvalidInputError, match="keep: got"):
        ar.eliminate_constraints(k, m, [], keep=keep)


def test_a_name_asks_for_names():
    k, m, _ = random_structure(1, 6)
    for wrong in ({"constraints": [{"1:Z": 1.0}]}, {"keep": ["1:Z"]}):
        with pytest.raises(ar.InvalidInputError, match="no names.*dofs="):
            ar.MatrixModel(k, m, **wrong)


@pytest.mark.parametrize("wrong", [3, "a", None, np.ones((2, 6)), np.ones(6)])
def test_matrices_that_are_none(wrong):
    k, m, _ = random_structure(1, 6)
    for call in (ar.lagrange_rows, lambda k, m: ar.eliminate_constraints(k, m, [{1: 1.0}])):
        with pytest.raises(ar.InvalidInputError, match="stiffness: got"):
            call(wrong, m)
        with pytest.raises(ar.InvalidInputError, match="mass: got"):
            call(k, wrong)


def test_sparse_equations_are_those_of_the_dense():
    k, m, rng = random_structure(2, 6)
    c = np.zeros((2, 6))
    c[0, [1, 3]], c[1, [2, 4, 5]] = [1.0, -1.0], rng.uniform(0.5, 1.0, 3)
    dense = ar.MatrixModel(k, m, constraints=c).antiresonances(0, 0)
    for kind in (scipy.sparse.csr_array, scipy.sparse.coo_array, scipy.sparse.csc_matrix):
        np.testing.assert_array_equal(ar.MatrixModel(k, m, constraints=kind(c)).antiresonances(0, 0), dense)
    empty = ar.MatrixModel(k, m, constraints=scipy.sparse.csr_array((0, 6)))
    assert "taken out" not in repr(empty)
