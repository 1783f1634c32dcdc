"""Chains and matrix models: matrices, modes, frequency responses, antiresonances."""

import numpy as np
import pytest
import scipy.sparse

import antires_rs as ar
from tests.support.tolerances import CLOSED_FORM, ROUNDING


def chain(**ground):
    return ar.MassSpringChain([1.0, 2.0, 3.0], [100.0, 200.0], **ground)


def test_chain_matrices_are_those_of_the_textbook():
    model = chain(ground_first_n_per_m=10.0, ground_last_n_per_m=20.0)
    np.testing.assert_array_equal(model.stiffness(), [[110, -100, 0], [-100, 300, -200], [0, -200, 220]])
    np.testing.assert_array_equal(model.mass(), np.diag([1.0, 2.0, 3.0]))
    assert model.n_dof == 3
    assert repr(model) == "MassSpringChain(3 masses)"


def test_a_single_mass_is_a_chain():
    free, held = ar.MassSpringChain([2.0], []), ar.MassSpringChain([2.0], [], ground_first_n_per_m=800.0)
    assert free.modes().freq_hz.tolist() == [0.0]
    np.testing.assert_allclose(held.modes().freq_hz, [20 / (2 * np.pi)], rtol=ROUNDING)
    for method in ("modal", "pencil"):
        assert held.antiresonances(0, 0, method=method).size == 0


def test_labels_count_from_one():
    model = chain()
    labels = [model.element_label(i) for i in range(4)]
    assert labels == ["spring 0", "spring 1", "first ground spring", "last ground spring"]
    assert model.mass_label(0) == "mass 0"
    assert model.default_elements == [0, 1]
    spring = scipy.sparse.csc_array(np.array([[1.0, -1.0], [-1.0, 1.0]]))
    matrix_model = ar.MatrixModel(spring, np.eye(2), stiffness_terms=[spring], mass_terms=[np.eye(2)])
    assert matrix_model.element_label(0) == "element 0"
    assert matrix_model.default_elements == [0]
    assert repr(matrix_model) == "MatrixModel(2 dofs, 1 stiffness terms, 1 mass terms)"


def test_a_matrix_model_returns_the_matrices_it_was_given():
    k_mat, m_mat = chain().stiffness(), chain().mass()
    for convert in (np.asarray, list, scipy.sparse.csr_array, scipy.sparse.coo_matrix):
        model = ar.MatrixModel(convert(k_mat), convert(m_mat))
        assert scipy.sparse.issparse(model.stiffness())
        np.testing.assert_array_equal(model.stiffness().toarray(), k_mat)
        np.testing.assert_array_equal(model.mass().toarray(), m_mat)


def test_modes_can_be_cut_by_number_and_by_frequency():
    model = ar.cases.chain8().model
    everything = model.modes()
    assert (len(everything), everything.shapes.shape, everything.dofs) == (8, (8, 8), tuple(range(8)))
    assert everything.freq_hz[0] == 0.0
    assert len(model.modes(n_modes=3)) == 3
    assert len(model.modes(n_modes=99)) == 8
    below = model.modes(f_max_hz=60.0).freq_hz
    np.testing.assert_array_equal(below, everything.freq_hz[everything.freq_hz <= 60.0])
    assert len(model.modes(n_modes=2, f_max_hz=60.0)) == 2


def test_an_unstable_structure_has_no_resonances_and_says_so():
    unstable = ar.MatrixModel(np.diag([100.0, -1.0]), np.eye(2))
    with pytest.raises(ar.NumericalError, match="stiffness is indefinite"):
        unstable.modes()


@pytest.mark.parametrize(
    ("k_mat", "m_mat"),
    [
        (np.diag([1.0, 0.0]), np.diag([1.0, 0.0])),  # a motion with neither mass nor stiffness
        (np.diag([1.0, 1.0]), np.array([[0.0, 1.0], [1.0, 0.0]])),  # an indefinite mass
    ],
)
def test_matrices_without_modes_are_a_numerical_error(k_mat, m_mat):
    model = ar.MatrixModel(k_mat, m_mat)
    with pytest.raises(ar.NumericalError) as caught:
        model.modes()
    assert isinstance(caught.value, ArithmeticError)


@pytest.mark.parametrize("method", ["modal", "pencil"])
def test_antiresonances_up_to_a_frequency(method):
    model = ar.cases.chain8().model
    everything = model.antiresonances(0, 0, method=method)
    limit = everything[3]
    for share, count in ((1.0001, 4), (0.9999, 3)):
        below = model.antiresonances(0, 0, method=method, f_max_hz=limit * share)
        np.testing.assert_allclose(below, everything[:count], rtol=CLOSED_FORM)


@pytest.mark.parametrize("method", ["modal", "pencil"])
def test_cancelled_roots_come_on_request_only(method):
    """Driven at its middle, a symmetric chain hides its odd modes: clamping leaves two equal halves."""
    model = ar.MassSpringChain(np.ones(5), np.full(4, 1e4))
    odd = model.modes().freq_hz[[1, 3]]
    np.testing.assert_allclose(model.antiresonances(2, 2, method=method), odd, rtol=CLOSED_FORM)
    everything = model.antiresonances(2, 2, method=method, include_cancelled=True)
    np.testing.assert_allclose(everything, np.repeat(odd, 2), rtol=CLOSED_FORM)


@pytest.mark.parametrize("method", ["modal", "pencil"])
def test_an_unconnected_response_has_none_and_warns(method):
    model = ar.MatrixModel(np.diag([1e4, 2e4]), np.eye(2))
    with pytest.warns(ar.AntiresWarning, match="response dof 1 is not connected to excitation dof 0"):
        assert model.antiresonances(1, 0, method=method).size == 0


def test_frf_shapes_and_the_static_limit():
    model = chain(ground_first_n_per_m=100.0)
    one = model.frf(1, 0, [0.0, 1.0], damping_ratio=0.01, kind="receptance")
    several = model.frf([1, 2], 0, [0.0, 1.0], damping_ratio=0.01, kind="receptance")
    assert (one.shape, several.shape, one.dtype) == ((2,), (2, 2), np.complex128)
    np.testing.assert_array_equal(several[0], one)
    compliance = np.linalg.inv(model.stiffness())
    np.testing.assert_allclose(several[:, 0], compliance[1:, 0], rtol=CLOSED_FORM)
    free = chain().frf([0, 1, 2], 0, [0.0], damping_ratio=0.01)  # accelerates as a rigid body
    np.testing.assert_allclose(free, np.full((3, 1), 1 / 6.0), rtol=CLOSED_FORM)
