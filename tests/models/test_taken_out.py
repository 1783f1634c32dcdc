"""What is no dof of its own, inside a model: numbers and names stay, roots are those of the whole system."""

import copy
import pickle

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import antires_rs as ar
from tests.models.test_constraints import bordered_receptance, random_structure


def constrained(seed=2, n=12):
    """A structure, three equations, and its model by elimination outside."""
    k, m, rng = random_structure(seed, n)
    c = np.zeros((3, n))
    for row in c:
        row[rng.choice(n, 3, replace=False)] = rng.uniform(-2.0, 2.0, 3)
    return k, m, c


def test_all_dofs_at_once():
    k, m, c = constrained()
    model = ar.MatrixModel(k, m, constraints=c)
    dofs = range(12)
    together = model.antiresonances(dofs, 4)
    for dof in dofs:
        np.testing.assert_array_equal(together[dof], model.antiresonances(dof, 4))
    rows = model.frf(dofs, 4, [3.0], damping_ratio=0.01)
    for dof in dofs:
        np.testing.assert_allclose(rows[dof], model.frf(dof, 4, [3.0], damping_ratio=0.01), rtol=1e-9)


@pytest.mark.parametrize("ends", [(0, 1), (3, 3), (5, 9), (11, 2), (7, 8)])
def test_any_dof_can_be_asked_whether_it_was_taken_out_or_not(ends):
    k, m, c = constrained()
    model = ar.MatrixModel(k, m, constraints=c)
    assert model.n_dof == 12
    assert "3 of them taken out" in repr(model)
    zeros = model.antiresonances(*ends)
    assert zeros.size
    for hz in zeros:
        below, above = (bordered_receptance(k, m, c, *ends, hz * (1.0 + step)) for step in (-1e-6, 1e-6))
        assert below * above < 0.0
    kept = ar.eliminate_constraints(k, m, c, keep=sorted({*ends}))
    rows = [list(kept.dofs).index(dof) for dof in ends]
    np.testing.assert_allclose(
        zeros, ar.MatrixModel(kept.stiffness, kept.mass).antiresonances(*rows), rtol=1e-9
    )


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
        exact = [bordered_receptance(k, m, c, i, j, hz) for hz in freq]
        np.testing.assert_allclose(ours, exact, rtol=1e-8)


def test_lagrange_rows_of_an_export_are_taken_out_and_no_sensors():
    k, m, c = constrained()
    bordered = np.block([[k, c.T], [c, np.zeros((3, 3))]])
    mass = scipy.linalg.block_diag(m, np.zeros((3, 3)))
    names = [f"{dof}:Z" for dof in range(12)] + ["multiplier 1", "multiplier 2", "multiplier 3"]
    model = ar.MatrixModel(scipy.sparse.csc_array(bordered), mass, dofs=names)
    assert model.n_dof == 15
    assert "6 of them taken out" in repr(model)
    direct = ar.MatrixModel(k, m, constraints=c)
    np.testing.assert_allclose(model.modes().freq_hz, direct.modes().freq_hz, rtol=1e-9)
    np.testing.assert_allclose(model.antiresonances("3:Z", "5:Z"), direct.antiresonances(3, 5), rtol=1e-9)
    with pytest.raises(ar.InvalidInputError, match="response: got multiplier 2, a Lagrange multiplier"):
        model.antiresonances(13, 0)
    with pytest.raises(ar.InvalidInputError, match=r"stiffness_terms\[0\]: got an entry in row 12, which is"):
        ar.MatrixModel(bordered, mass, stiffness_terms=[bordered])


def test_terms_and_parameters_go_through_the_equations():
    k, m, c = constrained()
    term = np.zeros_like(k)
    term[np.ix_([2, 3], [2, 3])] = 5e4 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    model = ar.MatrixModel(
        k, m, stiffness_terms=[term], mass_terms=[np.diag(m.diagonal() * (np.arange(12) < 4))], constraints=c
    )
    unknowns = [ar.stiffness_factor(0, bounds=(0.5, 2.0)), ar.mass_factor(0, bounds=(0.5, 2.0))]
    changed = model.with_parameters(unknowns, [1.5, 0.8])
    again = ar.MatrixModel(
        k + 0.5 * term, m - 0.2 * np.diag(m.diagonal() * (np.arange(12) < 4)), constraints=c
    )
    for ends in [(0, 1), (2, 11)]:
        np.testing.assert_allclose(changed.antiresonances(*ends), again.antiresonances(*ends), rtol=1e-9)
    dofs = [0, 1, 2, 3, 4, 6, 8, 11]
    truth = ar.AntiresonanceSet(4, dict(zip(dofs, again.antiresonances(dofs, 4), strict=True)), sees="frf")
    problem = ar.UpdatingProblem(model, unknowns, truth)
    assert problem.cost([1.5, 0.8]) < 1e-7 < problem.cost([1.0, 1.0])
    shapes = again.modes()
    modal = ar.UpdatingProblem(
        model, unknowns, ar.ModalSet(shapes.freq_hz[:4], shapes.shapes[:4, [1, 4, 9, 11]], dofs=[1, 4, 9, 11])
    )
    assert modal.cost([1.5, 0.8]) < 1e-7 < modal.cost([1.0, 1.0])


def test_a_model_with_all_of_it_is_copied_pickled_and_saved(tmp_path):
    k, m, c = constrained()
    names = {f"{dof + 1}:Z": dof for dof in range(12)}
    model = ar.MatrixModel(k, m, constraints=c, keep=["3:Z"], dofs=names)
    ar.write_matrices(tmp_path / "model.npz", model)
    for other in (
        copy.deepcopy(model),
        pickle.loads(pickle.dumps(model)),
        ar.read_matrices(tmp_path / "model.npz"),
        ar.MatrixModel.from_description(model.description),
    ):
        assert other.description == model.description
        np.testing.assert_array_equal(
            other.antiresonances("4:Z", "12:Z"), model.antiresonances("4:Z", "12:Z")
        )


def test_a_dof_to_keep_is_a_row():
    k, m, c = constrained()
    taken = [dof for dof in range(12) if ar.MatrixModel(k, m, constraints=c).stiffness()[[dof]].nnz == 0]
    assert len(taken) == 3
    model = ar.MatrixModel(k, m, constraints=c, keep=taken)
    assert all(model.stiffness()[[dof]].nnz for dof in taken)


def test_two_dofs_that_an_equation_joins_answer_as_one():
    k, m, _ = random_structure(1, 6)
    model = ar.MatrixModel(k, m, constraints=[{2: 1.0, 5: -1.0}])
    both = model.antiresonances([2, 5], 0)
    np.testing.assert_array_equal(*both)
    with pytest.raises(ar.InvalidInputError, match=r"dofs: got dof 2, dof 5 together"):
        ar.MatrixModel(k, m, constraints=[{2: 1.0, 5: -0.5}]).antiresonances(2, 5)


def test_equations_that_repeat_others_but_for_the_last_digits_are_told():
    k, m, _ = random_structure(3, 8)
    row = {2: 1.0, 4: -0.5, 6: 0.25}
    almost = {dof: value * (1.0 + 1e-7 * dof) for dof, value in row.items()}
    with pytest.raises(ar.InvalidInputError, match=r"constraints\[1\].* at .*4, 6"):
        ar.MatrixModel(k, m, constraints=[row, almost])
    with pytest.raises(ar.InvalidInputError, match=r"constraints\[2\]"):
        ar.eliminate_constraints(k, m, [row, {1: 1.0, 3: -1.0}, almost])
    exact = ar.MatrixModel(k, m, constraints=[row, {dof: 3.0 * value for dof, value in row.items()}])
    assert exact.modes().freq_hz.size == 7


@pytest.mark.parametrize("what", ["response", "excitation"])
def test_a_dof_that_an_equation_holds_is_no_place_for_a_sensor_or_a_force(what):
    k, m, _ = random_structure(4, 8)
    model = ar.MatrixModel(k, m, constraints=[{3: 1.0, 5: 1.0}, {3: 1.0, 5: -1.0}, {6: 2.0}])
    for dof in (3, 5, 6):
        ends = {"response": 0, "excitation": 1, what: dof}
        with pytest.raises(ar.InvalidInputError, match=rf"{what}: got dof {dof}, which .* hold at zero"):
            model.antiresonances(**ends)
