"""Constraints are taken out of the matrices: the same structure, against the bordered system and by hand."""

import copy
import pickle
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import antires_rs as ar
from tests.models.shared import bordered_receptance, random_structure, same_matrices
from tests.support.refusals import refused
from tests.support.snapshots import refusal, replay

K, M, _ = random_structure(1, 6)
TAKE_EQUATIONS = ar.eliminate_constraints, ar.MatrixModel


def constrained(seed=2, n=12):
    k, m, rng = random_structure(seed, n)
    c = np.zeros((3, n))
    for row in c:
        row[rng.choice(n, 3, replace=False)] = rng.uniform(-2.0, 2.0, 3)
    return k, m, c


def model_of(made, **options):
    return ar.MatrixModel(made.stiffness, made.mass, **options)


def assert_zeros(k, m, c, ends, zeros):
    assert zeros.size
    for hz in zeros:
        below, above = (bordered_receptance(k, m, c, *ends, hz * (1.0 + step)) for step in (-1e-6, 1e-6))
        assert below * above < 0.0


@pytest.mark.parametrize("seed", range(4))
def test_the_response_is_that_of_the_bordered_system(seed):
    k, m, c = constrained(seed, 14)
    follows = np.vstack([c, c[0] - 2.0 * c[1]])
    keep = np.random.default_rng(seed).choice(14, 3, replace=False).tolist()
    made = ar.eliminate_constraints(k, m, follows, keep=keep)
    assert made.stiffness.shape == (11, 11)
    assert set(keep) <= set(made.dofs)
    t = made.transformation.toarray()
    assert np.abs(c @ t).max() < 1e-12
    model, row = model_of(made), made.dofs.tolist().index
    assert_zeros(k, m, c, keep[:2], model.antiresonances(row(keep[0]), row(keep[1])))
    modes = scipy.linalg.eigh(t.T @ k @ t, t.T @ m @ t, eigvals_only=True)
    np.testing.assert_allclose(model.modes().freq_hz, np.sqrt(modes) / (2.0 * np.pi), rtol=1e-9)


def test_sparse_rows_dicts_and_arrays_say_the_same():
    c = np.array([[1.0, 0.0, -1.0, 0.4, 0.0, 0.0]])
    rows = scipy.sparse.csr_array(c), scipy.sparse.coo_array(c), scipy.sparse.csc_matrix(c)
    made = ar.eliminate_constraints(K, M, c, stiffness_terms=[K], mass_terms=[M])
    for given in (*rows, [{0: 1.0, 2: -1.0, 3: 0.4}]):
        again = ar.eliminate_constraints(K, M, given).stiffness
        np.testing.assert_array_equal(again.toarray(), made.stiffness.toarray())
        same_matrices(*(ar.MatrixModel(K, M, constraints=each) for each in (given, c)), within=0.0)
    np.testing.assert_allclose(made.stiffness_terms[0].toarray(), made.stiffness.toarray())
    np.testing.assert_allclose(made.mass_terms[0].toarray(), made.mass.toarray())
    assert "taken out" not in repr(ar.MatrixModel(K, M, constraints=scipy.sparse.csr_array((0, 6))))


def test_a_rigid_slab_leaves_its_master():
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


def bordered_matrices(k, m, c):
    zero = np.zeros((len(c), len(c)))
    return np.block([[k, c.T], [c, zero]]), scipy.linalg.block_diag(m, zero)


def test_lagrange_rows_become_equations():
    k, m, c = constrained()
    order = np.random.default_rng(5).permutation(15)
    bordered, mass = (each[np.ix_(order, order)] for each in bordered_matrices(k, m, c))
    dofs, equations = ar.lagrange_rows(scipy.sparse.csc_array(bordered), mass)
    assert sorted(order[dofs]) == list(range(12))
    made = ar.eliminate_constraints(bordered[np.ix_(dofs, dofs)], mass[np.ix_(dofs, dofs)], equations)
    direct = model_of(ar.eliminate_constraints(k, m, c)).modes().freq_hz
    np.testing.assert_allclose(model_of(made).modes().freq_hz, direct, rtol=1e-9)
    # Two massless dofs that are joined: neither is a multiplier.
    joined = np.array([[0.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 3.0]])
    assert list(ar.lagrange_rows(joined, np.diag([0.0, 0.0, 1.0]))[0]) == [0, 1, 2]


def said(given):
    """What both that take equations say of wrong ones."""
    calls = (partial(each, K, M, **{"constraints": []} | eval(given)) for each in TAKE_EQUATIONS)
    return " | ".join(dict.fromkeys(map(refusal, calls)))


def test_wrong_equations_and_dofs_to_keep_are_refused():
    replay(Path(__file__).with_name("wrong_equations.txt"), said)


def test_a_flat_sparse_array_is_no_equation():
    flat = scipy.sparse.coo_array(np.ones(6))  # one row, which is right, in SciPy before 1.13
    for call in TAKE_EQUATIONS:
        if flat.ndim == 1:
            refused(r"sparse array of shape \(6,\)", call, K, M, constraints=flat)
        else:
            call(K, M, constraints=flat)


@pytest.mark.parametrize("wrong", [3, "a", None, np.ones((2, 6)), np.ones(6), np.eye(3)])
def test_matrices_that_are_none(wrong):
    for call in (ar.lagrange_rows, lambda k, m: ar.eliminate_constraints(k, m, [{1: 1.0}])):
        for given in ((wrong, M), (K, wrong)):
            refused("(stiffness|mass): got", call, *given)


# -- Inside a model: numbers and names stay, roots are those of the whole system
@pytest.mark.parametrize("ends", [(0, 1), (3, 3), (5, 9), (11, 2), (7, 8)])
def test_any_dof_can_be_asked_whether_it_was_taken_out_or_not(ends):
    k, m, c = constrained()
    taken = [dof for dof in range(12) if ar.MatrixModel(k, m, constraints=c).stiffness()[[dof]].nnz == 0]
    assert len(taken) == 3
    rows = ar.MatrixModel(k, m, constraints=c, keep=taken).stiffness()
    assert all(rows[[dof]].nnz for dof in taken)
    model = ar.MatrixModel(k, m, constraints=c)
    assert model.n_dof == 12
    assert "3 of them taken out" in repr(model)
    zeros = model.antiresonances(*ends)
    assert_zeros(k, m, c, ends, zeros)
    np.testing.assert_array_equal(model.antiresonances(range(12), ends[1])[ends[0]], zeros)
    kept = ar.eliminate_constraints(k, m, c, keep=sorted({*ends}))
    rows = [list(kept.dofs).index(dof) for dof in ends]
    np.testing.assert_allclose(zeros, model_of(kept).antiresonances(*rows), rtol=1e-9)


def test_modes_obey_the_equations_and_frequency_responses_too():
    k, m, c = constrained()
    model = ar.MatrixModel(k, m, constraints=c)
    modes = model.modes()
    assert modes.freq_hz.size == 9
    assert modes.shapes.shape == (9, 12)
    assert np.abs(modes.shapes @ c.T).max() < 1e-9 * np.abs(modes.shapes).max()
    np.testing.assert_allclose(modes.shapes @ m @ modes.shapes.T, np.eye(9), atol=1e-9)
    freq = np.array([3.0, 11.0])
    for i, j in [(0, 1), (11, 11), (4, 10)]:
        ours = model.frf(i, j, freq, damping_ratio=0.0, kind="receptance")
        np.testing.assert_allclose(ours, [bordered_receptance(k, m, c, i, j, hz) for hz in freq], rtol=1e-8)


def test_lagrange_rows_of_an_export_are_taken_out_and_no_sensors():
    k, m, c = constrained()
    bordered, mass = bordered_matrices(k, m, c)
    names = [f"{dof}:Z" for dof in range(12)] + ["multiplier 1", "multiplier 2", "multiplier 3"]
    model = ar.MatrixModel(scipy.sparse.csc_array(bordered), mass, dofs=names)
    assert model.n_dof == 15
    assert "6 of them taken out" in repr(model)
    direct = ar.MatrixModel(k, m, constraints=c)
    np.testing.assert_allclose(model.modes().freq_hz, direct.modes().freq_hz, rtol=1e-9)
    np.testing.assert_allclose(model.antiresonances("3:Z", "5:Z"), direct.antiresonances(3, 5), rtol=1e-9)
    refused("response: got multiplier 2, a Lagrange multiplier", model.antiresonances, 13, 0)
    with pytest.raises(ar.InvalidInputError, match=r"stiffness_terms\[0\]: got an entry in row 12, which is"):
        ar.MatrixModel(bordered, mass, stiffness_terms=[bordered])


def test_terms_and_parameters_go_through_the_equations():
    k, m, c = constrained()
    term, half = np.zeros_like(k), np.diag(m.diagonal() * (np.arange(12) < 4))
    term[np.ix_([2, 3], [2, 3])] = 5e4 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    model = ar.MatrixModel(k, m, stiffness_terms=[term], mass_terms=[half], constraints=c)
    unknowns = [ar.stiffness_factor(0, bounds=(0.5, 2.0)), ar.mass_factor(0, bounds=(0.5, 2.0))]
    changed = model.with_parameters(unknowns, [1.5, 0.8])
    again = ar.MatrixModel(k + 0.5 * term, m - 0.2 * half, constraints=c)
    for ends in [(0, 1), (2, 11)]:
        np.testing.assert_allclose(changed.antiresonances(*ends), again.antiresonances(*ends), rtol=1e-9)
    dofs, seen, modes = [0, 1, 2, 3, 4, 6, 8, 11], [1, 4, 9, 11], again.modes()
    zeros = dict(zip(dofs, again.antiresonances(dofs, 4), strict=True))
    shapes = ar.ModalSet(modes.freq_hz[:4], modes.shapes[:4, seen], dofs=seen)
    for truth in (ar.AntiresonanceSet(4, zeros, sees="frf"), shapes):
        problem = ar.UpdatingProblem(model, unknowns, truth)
        assert problem.cost([1.5, 0.8]) < 1e-7 < problem.cost([1.0, 1.0])


def test_a_model_with_all_of_it_is_copied_pickled_and_saved(tmp_path):
    k, m, c = constrained()
    names = {f"{dof + 1}:Z": dof for dof in range(12)}
    model = ar.MatrixModel(k, m, constraints=c, keep=["3:Z"], dofs=names)
    ar.write_matrices(tmp_path / "model.npz", model)
    copies = copy.deepcopy(model), pickle.loads(pickle.dumps(model)), ar.read_matrices(tmp_path / "model.npz")
    for other in (*copies, ar.MatrixModel.from_description(model.description)):
        assert other.description == model.description
        one, two = (each.antiresonances("4:Z", "12:Z") for each in (other, model))
        np.testing.assert_array_equal(one, two)


def test_equations_that_repeat_others_but_for_the_last_digits_are_told():
    k, m, _ = random_structure(3, 8)
    row = {2: 1.0, 4: -0.5, 6: 0.25}
    almost = {dof: value * (1.0 + 1e-7 * dof) for dof, value in row.items()}
    refused(r"constraints\[1\].* at .*4, 6", ar.MatrixModel, k, m, constraints=[row, almost])
    refused(r"constraints\[2\]", ar.eliminate_constraints, k, m, [row, {1: 1.0, 3: -1.0}, almost])
    exact = ar.MatrixModel(k, m, constraints=[row, {dof: 3.0 * value for dof, value in row.items()}])
    assert exact.modes().freq_hz.size == 7


@pytest.mark.parametrize("what", ["response", "excitation"])
def test_dofs_that_an_equation_holds_or_joins(what):
    k, m, _ = random_structure(4, 8)
    model = ar.MatrixModel(k, m, constraints=[{3: 1.0, 5: 1.0}, {3: 1.0, 5: -1.0}, {6: 2.0}])
    for dof in (3, 5, 6):
        ends = {"response": 0, "excitation": 1, what: dof}
        refused(rf"{what}: got dof {dof}, which .* hold at zero", model.antiresonances, **ends)
    joined = ar.MatrixModel(K, M, constraints=[{2: 1.0, 5: -1.0}])
    np.testing.assert_array_equal(*joined.antiresonances([2, 5], 0))
    with pytest.raises(ar.InvalidInputError, match=r"dofs: got dof 2, dof 5 together"):
        ar.MatrixModel(K, M, constraints=[{2: 1.0, 5: -0.5}]).antiresonances(2, 5)
