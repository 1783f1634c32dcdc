"""Chains and matrix models: matrices, modes, responses, antiresonances, names; and what exports are like."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import antires_rs as ar
from antires_rs.support.directions import point_of
from tests.models.shared import random_structure
from tests.support.refusals import refused
from tests.support.snapshots import refusals
from tests.support.tolerances import CLOSED_FORM, ROUNDING


def chain(**ground):
    return ar.MassSpringChain([1.0, 2.0, 3.0], [100.0, 200.0], **ground)


def test_chain_matrices_are_those_of_the_textbook():
    model = chain(ground_first_n_per_m=10.0, ground_last_n_per_m=20.0)
    np.testing.assert_array_equal(model.stiffness(), [[110, -100, 0], [-100, 300, -200], [0, -200, 220]])
    np.testing.assert_array_equal(model.mass(), np.diag([1.0, 2.0, 3.0]))
    assert model.n_dof == 3
    assert repr(model) == "MassSpringChain(3 masses)"
    free, held = ar.MassSpringChain([2.0], []), ar.MassSpringChain([2.0], [], ground_first_n_per_m=800.0)
    assert free.modes().freq_hz.tolist() == [0.0]
    np.testing.assert_allclose(held.modes().freq_hz, [20 / (2 * np.pi)], rtol=ROUNDING)


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


@pytest.mark.parametrize(
    ("k_mat", "m_mat", "said"),
    [
        (np.diag([1.0, 0.0]), np.diag([1.0, 0.0]), "."),  # a motion with neither mass nor stiffness
        (np.diag([1.0, 1.0]), np.array([[0.0, 1.0], [1.0, 0.0]]), "."),  # an indefinite mass
        (np.diag([100.0, -1.0]), np.eye(2), "stiffness is indefinite"),
    ],
)
def test_matrices_without_modes_are_a_numerical_error(k_mat, m_mat, said):
    model = ar.MatrixModel(k_mat, m_mat)
    with pytest.raises(ar.NumericalError, match=said) as caught:
        model.modes()
    assert isinstance(caught.value, ArithmeticError)


@pytest.mark.parametrize("method", ["modal", "pencil"])
def test_where_there_is_nothing_to_vibrate_there_is_no_root(method):
    alone = ar.MassSpringChain([2.0], [], ground_first_n_per_m=800.0)
    assert alone.antiresonances(0, 0, method=method).size == 0
    apart = ar.MatrixModel(np.diag([1e4, 2e4]), np.eye(2))
    with pytest.warns(ar.AntiresWarning, match="response dof 1 is not connected to excitation dof 0"):
        assert apart.antiresonances(1, 0, method=method).size == 0


def test_frf_shapes_and_the_static_limit():
    model = chain(ground_first_n_per_m=100.0)
    one = model.frf(1, 0, [0.0, 1.0], damping_ratio=0.01, kind="receptance")
    several = model.frf([1, 2], 0, [0.0, 1.0], damping_ratio=0.01, kind="receptance")
    assert (one.shape, several.shape, one.dtype) == ((2,), (2, 2), np.complex128)
    np.testing.assert_array_equal(several[0], one)
    np.testing.assert_allclose(several[:, 0], np.linalg.inv(model.stiffness())[1:, 0], rtol=CLOSED_FORM)
    free = chain().frf([0, 1, 2], 0, [0.0], damping_ratio=0.01)  # accelerates as a rigid body
    np.testing.assert_allclose(free, np.full((3, 1), 1 / 6.0), rtol=CLOSED_FORM)


# -- Dofs by name: wherever a number is taken a name is, with the same answer
NAMES = ["1204:Z", "1204:RX", "1205:Z", "1205:RX", "7:X", "hub"]


def named(**options):
    k, m, _ = random_structure(6, 6)
    terms = [np.diag(1e4 * (np.arange(6) == dof)) for dof in range(6)]
    return ar.MatrixModel(k, m, stiffness_terms=terms, dofs=NAMES, **options)


@pytest.mark.parametrize(
    "name", ["1205:Z", "1205+Z", "1205 UZ", "1205:3", "node 1205 w", "1205:+Z", " 1205:T3", "1205z"]
)
def test_a_node_and_a_direction_in_any_spelling(name):
    assert named().dof(name) == 2
    assert point_of(name) == (1205, 3)


def test_a_name_is_as_good_as_a_number():
    model = named()
    numbers, names = [0, 2, 5], ["1204:Z", "1205+Z", "hub"]
    for a, b in zip(model.antiresonances(numbers, 4), model.antiresonances(names, "7:X"), strict=True):
        np.testing.assert_array_equal(a, b)
    ends = (numbers, 4), (names, "7:UX")
    np.testing.assert_array_equal(*(model.frf(*each, [2.0, 20.0], damping_ratio=0.01) for each in ends))
    made = {"fs_hz": 200.0, "duration_s": 2.0, "damping_ratio": 0.01, "rng": 0}
    by_name = model.simulate(excitation="7:X", responses=names, **made).responses
    by_number = model.simulate(excitation=4, responses=numbers, **made).responses
    np.testing.assert_array_equal(by_name, by_number)
    assert [model.dof_label(dof) for dof in numbers] == ["1204:Z", "1205:Z", "hub"]


def sets(model, truth):
    dofs, names = [0, 2, 4, 5], ["1204+Z", "1205 UZ", "7:X", "hub"]
    values = truth.antiresonances(dofs, 4)
    ends = (4, dofs), ("7:X", names)
    return [ar.AntiresonanceSet(at, dict(zip(own, values, strict=True)), sees="frf") for at, own in ends]


def test_updating_takes_sets_with_names():
    model = named()
    unknowns = ar.stiffness_factor([1, 2], bounds=(0.2, 2.0))
    truth = model.with_parameters(unknowns, [0.7, 1.3])
    by_number, by_name = (ar.UpdatingProblem(model, unknowns, each) for each in sets(model, truth))
    assert by_number.cost([1.0, 1.0]) == by_name.cost([1.0, 1.0]) > 0.0
    np.testing.assert_array_equal(by_number.measured_dofs, by_name.measured_dofs)
    results = [ar.update(each, rng=0, progress=False) for each in (by_number, by_name)]
    assert results[0].x.tobytes() == results[1].x.tobytes()
    np.testing.assert_allclose(results[1].x, [0.7, 1.3], rtol=1e-4)
    assert "1205:Z" in str(results[1].table)
    found = [ar.identifiability(each, points=8) for each in (by_number, by_name)]
    assert found[0].words == found[1].words
    freq_hz, shapes = truth.modes().freq_hz[:3], truth.modes().shapes[:3, [0, 2, 5]]
    modes = [ar.ModalSet(freq_hz, shapes, dofs=own) for own in ([0, 2, 5], ["1204:Z", "1205+Z", "hub"])]
    one, other = (ar.UpdatingProblem(model, unknowns, each).cost([1.0, 1.0]) for each in modes)
    assert one == other > 0.0


def test_damage_and_plans_take_names():
    model = named()
    damaged = model.with_parameters(ar.stiffness_reduction(1), 0.5)
    states = zip(sets(model, model), sets(model, damaged), strict=True)
    one, other = (ar.assess_damage(model, now, baseline=intact, rng=0) for intact, now in states)
    assert one.probability == other.probability
    places, how = (([0, 2, 5], 4), (["1204:Z", "1205:Z", "hub"], "7:X")), {"n_sensors": 2, "std": 1e-3}
    plans = [ar.plan_test(model, candidates=each, excitations=force, **how) for each, force in places]
    assert plans[0].sensors == plans[1].sensors
    assert {1, 3}.isdisjoint(model._sensor_dofs)


def test_frames_and_chains_have_names_too():
    tube = ar.Tube(0.02, 0.005, 2.1e11, 7850.0)
    frame = ar.FrameModel([(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)], [(0, 1), (1, 2)], tube, fixed=[0])
    tip = frame.dof(2, "v")
    for name in ("node 2 v", "2:v", "2:Y"):
        by_number = frame.antiresonances(tip, frame.dof(1, "v"))
        np.testing.assert_array_equal(frame.antiresonances(name, "1:v"), by_number)
    chain = ar.MassSpringChain([1.0, 1.0], [500.0])
    np.testing.assert_array_equal(chain.antiresonances("mass 1", "mass 0"), chain.antiresonances(1, 0))


def unlike(dofs):
    return ar.MatrixModel(*random_structure(6, 6)[:2], dofs=dofs)


def test_names_that_do_not_fit_and_unknown_ones_with_those_near_them():
    refusals(__file__, "wrong_names.txt", globals())


# -- What other programs' matrices are like: triangles, damping, rounding-size masses, compression
K, M, _ = random_structure(4, 9)
LABELS = [f"{4 + dof}:Z" for dof in range(9)]


@pytest.mark.parametrize("places", ["indices", "indptr"])
def test_a_sparse_matrix_with_places_outside_is_refused(places):
    given = scipy.sparse.csr_array(K)
    getattr(given, places)[-1] = 10**8
    refused("stiffness: got places outside of the matrix", ar.MatrixModel, given, M)


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize(("half", "word"), [(np.triu, "upper"), (np.tril, "lower")])
def test_one_triangle_is_told_and_not_to_be_halved(sparse, half, word):
    given = scipy.sparse.csc_array(half(K)) if sparse else half(K)
    remedy = rf"the {word} triangle only; wanted .*Pass A \+ A.T - diag\(A\)"
    refused("stiffness: got " + remedy, ar.MatrixModel, given, M)
    refused(r"stiffness_terms\[0\]: got " + remedy, ar.MatrixModel, K, M, stiffness_terms=[given])
    whole = given + given.T - scipy.sparse.diags_array(given.diagonal())
    np.testing.assert_array_equal(ar.MatrixModel(whole, M).stiffness().toarray(), K)


def test_hysteretic_damping_and_masses_below_zero_by_rounding_are_left_out_with_a_word():
    with pytest.warns(ar.AntiresWarning, match="stiffness: its imaginary part, 0.04 of the real one") as said:
        model = ar.MatrixModel(K * (1.0 + 0.04j), M)
    assert said[0].filename == __file__
    np.testing.assert_array_equal(model.antiresonances(2, 5), ar.MatrixModel(K, M).antiresonances(2, 5))
    complex_but_real = ar.MatrixModel(scipy.sparse.csr_array(K.astype(complex)), M)
    np.testing.assert_array_equal(complex_but_real.stiffness().toarray(), K)
    m = M.copy()
    m[3, 3] = 0.0
    without = ar.MatrixModel(K, m)
    m[3, 3] = -1e-18
    words = "mass: negative by rounding at 7:Z, -1e-18: counted as none"
    with pytest.warns(ar.AntiresWarning, match=words) as said:
        model = ar.MatrixModel(K, m, dofs=LABELS)
    assert said[0].filename == __file__
    np.testing.assert_array_equal(model.antiresonances([0, 3], 5)[1], without.antiresonances([0, 3], 5)[1])
    m[3, 3] = -1e-3
    refused(r"mass\[3\]: got -0.001 kg at 7:Z; wanted no negative mass", ar.MatrixModel, K, m, dofs=LABELS)
    m[3, 3], m[3, 2], m[2, 3] = -1e-18, 0.1, 0.1  # joined to others: no rounding
    refused(r"mass\[3\].*at dof 3", ar.MatrixModel, K, m)


def column(n, load):
    """A cantilever column under a load, 1 at buckling: stiffness, mass, its frame."""
    h = 2.0 / n
    nodes, beams = [(h * i, 0.0) for i in range(n + 1)], [(i, i + 1) for i in range(n)]
    frame = ar.FrameModel(nodes, beams, ar.Rectangle(0.03, 0.05, 2.1e11, 7850.0), fixed=[0])
    k = frame.stiffness().toarray()
    g = np.zeros_like(k)
    side = np.array([[36, 3 * h, -36, 3 * h], [3 * h, 4 * h * h, -3 * h, -h * h]])
    element = np.vstack([side, side[:, [2, 3, 0, 1]] * np.outer([1, -1], [1, -1, 1, -1])]) / (30.0 * h)
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
        said = f"grow without bound, most at node {n} (v|theta).*beyond buckling"
        with pytest.raises(ar.NumericalError, match=said):
            model.modes(n_modes=3)
