"""The band route on frames: against SciPy's QZ and 50 digits. All 200: benchmarks/frames_against_scipy.py."""

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from reference.exact_roots import ExactPencil
from reference.random_frames import assemble, random_frame, rigid_hz
from reference.random_models import Oracle, cancelled
from tests.support.tolerances import AGAINST_SCIPY, PROMISE, PROMISE_ULPS


def band_hz(k_mat, m_mat, modes):
    lam = scipy.linalg.eigvalsh(k_mat, m_mat)
    return np.sqrt(0.3 * lam[modes - 1] + 0.7 * lam[modes]) / (2 * np.pi)


def assert_promise(k_mat, m_mat, i, k, freq_hz):
    """Each root within max(1e-9, 20 times the shift of one ulp) of the root of the assembled doubles."""
    exact = ExactPencil(k_mat, m_mat)
    for f in freq_hz:
        error, ulp = exact.error(i, k, f)
        assert abs(error) <= max(PROMISE, PROMISE_ULPS * ulp), (f, error, ulp)


def matches(freq_hz, others_hz):
    """Which frequencies have one of the others at the bar of the comparison."""
    if others_hz.size == 0:
        return np.zeros(freq_hz.size, dtype=bool)
    return np.abs(others_hz / freq_hz[:, None] - 1.0).min(axis=1) <= AGAINST_SCIPY


@pytest.mark.parametrize("seed", range(12))
def test_random_frames(seed):
    """QZ loses roots of frames on soft supports (seed 3: one at 2.2 Hz); where it differs, 50 digits."""
    rng = np.random.default_rng([5, seed])
    k_mat, m_mat = random_frame(rng, most_dofs=110)
    limit_hz = band_hz(k_mat, m_mat, int(rng.integers(5, 26)))
    k = int(rng.integers(0, len(k_mat)))
    responses = [k, *rng.integers(0, len(k_mat), 2).tolist()]
    model, exact = ar.MatrixModel(k_mat, m_mat), ExactPencil(k_mat, m_mat)
    for i in responses:
        ours = model.antiresonances(i, k, f_max_hz=limit_hz)
        roots = Oracle(k_mat, m_mat, i, k).freq_hz(0.0, (2 * np.pi * limit_hz) ** 2)
        seen = roots[~cancelled(k_mat, m_mat, i, k, roots)]
        agreed = matches(ours, seen)
        if not agreed.all() or ours.size != seen.size:
            assert_promise(k_mat, m_mat, i, k, ours[~agreed])
            moved = [exact.root_near(i, k, f) for f in seen[~matches(seen, ours)]]
            assert all(matches(np.array([f]), ours) for f in moved if f is not None), moved
            assert np.unique(ours).size == ours.size
    full = model.antiresonances(k, k, f_max_hz=limit_hz, include_cancelled=True)
    assert full.size == exact.driving_zeros(k, rigid_hz(k_mat, m_mat), limit_hz)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_every_root_keeps_the_promise(seed):
    rng = np.random.default_rng([6, seed])
    k_mat, m_mat = random_frame(rng, most_dofs=120)
    limit_hz = band_hz(k_mat, m_mat, 15)
    k, i = rng.integers(0, len(k_mat), 2).tolist()
    assert_promise(k_mat, m_mat, i, k, ar.MatrixModel(k_mat, m_mat).antiresonances(i, k, f_max_hz=limit_hz))


def straight(n_nodes, length=2.0):
    """A straight free tube along x; axial and bending motion do not know of one another."""
    nodes = np.column_stack([np.linspace(0, length, n_nodes), np.zeros(n_nodes)])
    elements = [(j, j + 1) for j in range(n_nodes - 1)]
    return assemble(nodes, elements, [(0.04, 0.002)] * len(elements))


@pytest.mark.parametrize("method", ["modal", "pencil"])
def test_a_symmetric_beam_driven_at_its_middle_hides_its_odd_modes(method):
    k_mat, m_mat = straight(21)
    model, middle = ar.MatrixModel(k_mat, m_mat), 3 * 10 + 1
    bending = np.flatnonzero(np.arange(63) % 3 != 0)
    lam, phi = scipy.linalg.eigh(*(a[np.ix_(bending, bending)] for a in (k_mat, m_mat)))
    at_middle = np.abs(phi[list(bending).index(middle)])
    limit_hz = 1500.0
    hz = np.sqrt(np.maximum(lam, 0)) / (2 * np.pi)
    odd = hz[(at_middle < 1e-6 * at_middle.max()) & (hz > 5) & (hz < limit_hz)]
    plain = model.antiresonances(middle, middle, f_max_hz=limit_hz, method=method)
    full = model.antiresonances(middle, middle, f_max_hz=limit_hz, method=method, include_cancelled=True)
    lost = [f for f in odd if plain.size == 0 or np.abs(plain / f - 1).min() > 1e-6]
    assert odd.size >= 2
    assert len(lost) == odd.size
    for f in odd:
        assert np.abs(full / f - 1).min() <= 1e-6


def test_both_routes_agree_with_and_without_cancelled_roots_on_a_square_tube_of_repeated_modes():
    """A straight space tube: every bending mode twice, axial and torsional motion apart."""
    nodes = np.column_stack([np.linspace(0, 1.5, 12), np.zeros((12, 2))])
    k_mat, m_mat = assemble(nodes, [(j, j + 1) for j in range(11)], [(0.04, 0.002)] * 11)
    for d in (0, 1, 2, 3):
        k_mat[d, d] += 4e3
    model = ar.MatrixModel(k_mat, m_mat)
    for i, k in ((7, 7), (1, 25), (61, 13)):
        for flag in (False, True):
            modal, pencil = (
                model.antiresonances(i, k, f_max_hz=900.0, method=m, include_cancelled=flag)
                for m in ("modal", "pencil")
            )
            assert modal.size == pencil.size
            np.testing.assert_allclose(modal, pencil, rtol=AGAINST_SCIPY)


def tuned(masses, springs, rigid=False):
    """A tube of 20 nodes with grounded oscillators hung on it: (node, kg, N/m) each."""
    base_k, base_m = straight(20)
    n = len(base_k)
    k_mat, m_mat = np.zeros((n + len(masses), n + len(masses))), np.zeros((n + len(masses), n + len(masses)))
    k_mat[:n, :n], m_mat[:n, :n] = base_k, base_m
    if not rigid:
        k_mat[1, 1] += 2e4
        k_mat[n - 2, n - 2] += 3e4
        k_mat[0, 0] += 1e5
    for j, ((node, kg), spring) in enumerate(zip(masses, springs, strict=True)):
        dof = 3 * node + 1
        m_mat[n + j, n + j] = kg
        k_mat[[n + j, dof], [n + j, dof]] += spring
        k_mat[[n + j, dof], [dof, n + j]] -= spring
    return k_mat, m_mat


@pytest.mark.parametrize("gap", [5e-7, 1e-7, 1e-8])
def test_two_zeros_closer_than_a_millionth_are_two(gap):
    """One absorber where the force acts, one where the motion is measured: each makes a zero of its own."""
    springs = [3e4, 3e4 * (1 + 2 * gap)]
    k_mat, m_mat = tuned([(6, 0.5), (13, 0.5)], springs)
    i, k = 3 * 6 + 1, 3 * 13 + 1
    want = np.sqrt(np.array(springs) / 0.5) / (2 * np.pi)
    for method in ("modal", "pencil"):
        found = ar.MatrixModel(k_mat, m_mat).antiresonances(i, k, f_max_hz=400.0, method=method)
        near = found[np.abs(found / want[0] - 1) < 1e-4]
        assert near.size == 2
        np.testing.assert_allclose(near, want, rtol=1e-9)


@pytest.mark.parametrize(("gap", "visible"), [(2e-5, 2), (1e-7, 1), (1e-8, 1)])
def test_a_pole_between_two_zeros_cancels_one_of_them_when_it_cannot_be_seen(gap, visible):
    """Two absorbers on the driven dof. The pole between their zeros has a residue of some gap squared."""
    springs = [3e4, 3e4 * (1 + 2 * gap)]
    k_mat, m_mat = tuned([(6, 0.5), (6, 0.5)], springs)
    k = 3 * 6 + 1
    want = np.sqrt(np.array(springs) / 0.5) / (2 * np.pi)
    for method in ("modal", "pencil"):
        for flag, count in ((False, visible), (True, 2)):
            found = ar.MatrixModel(k_mat, m_mat).antiresonances(
                k, k, f_max_hz=400.0, method=method, include_cancelled=flag
            )
            near = found[np.abs(found / want[0] - 1) < 1e-4]
            assert near.size == count
            assert np.abs(near[:, None] / want - 1).min(axis=1).max() <= gap


def test_a_zero_beside_a_pole_is_found():
    """A light absorber far from where it is felt: pole and zero agree to a part in a million."""
    k_mat, m_mat = tuned([(15, 1e-6)], [1e-6 * (2 * np.pi * 60.0) ** 2])
    lam = scipy.linalg.eigvalsh(k_mat, m_mat)
    poles = np.sqrt(np.maximum(lam, 0)) / (2 * np.pi)
    for i, k in ((3 * 6 + 1, 3 * 6 + 1), (3 * 6 + 1, 3 * 15 + 1), (3 * 15 + 1, 3 * 15 + 1)):
        found = ar.MatrixModel(k_mat, m_mat).antiresonances(i, k, f_max_hz=300.0)
        near = found[np.abs(found / 60.0 - 1) < 1e-3]
        assert near.size == 1
        assert np.abs(poles / near - 1).min() < 2e-5
        assert_promise(k_mat, m_mat, i, k, found)


def test_rigid_bodies_free_in_the_plane():
    k_mat, m_mat = tuned([(6, 0.5)], [3e4], rigid=True)
    for i, k in ((1, 1), (1, 58), (4, 31)):
        found = ar.MatrixModel(k_mat, m_mat).antiresonances(i, k, f_max_hz=500.0)
        roots = Oracle(k_mat, m_mat, i, k).freq_hz((2 * np.pi * 0.5) ** 2, (2 * np.pi * 500.0) ** 2)
        seen = roots[~cancelled(k_mat, m_mat, i, k, roots)]
        assert found.size == seen.size
        assert_promise(k_mat, m_mat, i, k, found)


HARD = {
    "two zeros 1e-7 apart": (tuned([(6, 0.5), (13, 0.5)], [3e4, 3e4 * (1 + 2e-7)]), (19, 40), 400.0),
    "zero beside a pole": (tuned([(15, 1e-6)], [1e-6 * (2 * np.pi * 60.0) ** 2]), (19, 19), 300.0),
    "driven at its node": (straight(21), (31, 31), 1500.0),
    "rigid bodies": (tuned([(6, 0.5)], [3e4], rigid=True), (1, 1), 500.0),
    "repeated modes": (tuned([(6, 0.5), (6, 0.5), (6, 0.5)], [3e4] * 3), (19, 40), 400.0),
}


@pytest.mark.parametrize("name", HARD)
def test_hard_pairs_are_the_same_by_bands_by_all_modes_and_by_the_pencil(name):
    """Without a limit the dense solver takes all modes; with one the band route a few."""
    (k_mat, m_mat), (i, k), limit_hz = HARD[name]
    model = ar.MatrixModel(k_mat, m_mat)
    for flag in (False, True):
        band = model.antiresonances(i, k, f_max_hz=limit_hz, include_cancelled=flag)
        dense = model.antiresonances(i, k, include_cancelled=flag)
        pencil = model.antiresonances(i, k, f_max_hz=limit_hz, method="pencil", include_cancelled=flag)
        assert band.size > 2
        for other in (dense[dense <= limit_hz], pencil):
            assert band.size == other.size
            np.testing.assert_allclose(band, other, rtol=AGAINST_SCIPY)
    if name != "repeated modes":  # there a zero lies on a pole that cancels, and K - x M is singular
        assert_promise(k_mat, m_mat, i, k, model.antiresonances(i, k, f_max_hz=limit_hz))


def test_an_objective_of_a_frame_has_the_same_bits_on_any_number_of_threads():
    k_mat, m_mat = straight(24)
    k_mat[[0, 1, 34], [0, 1, 34]] += 2e3
    nodes = np.column_stack([np.linspace(0, 2.0, 24), np.zeros(24)])
    terms = [assemble(nodes, [(e, e + 1)], [(0.04, 0.002)])[0] for e in range(4, 10)]
    model = ar.MatrixModel(k_mat, m_mat, stiffness_terms=terms)
    measured = {i: model.antiresonances(i, 1, f_max_hz=400.0) for i in (1, 16, 40)}
    problem = ar.UpdatingProblem(model, ar.stiffness_reduction(range(6)), ar.AntiresonanceSet(1, measured))
    betas = np.random.default_rng(0).uniform(0.0, 0.8, (40, 6))
    alone = problem.evaluate_many(betas, workers=1)
    np.testing.assert_array_equal(problem.evaluate_many(betas, workers=3), alone)
    np.testing.assert_array_equal([problem.cost(b) for b in betas[::-1]], alone[::-1])


def test_the_same_matrices_give_the_same_bits_whatever_was_asked_before():
    rng = np.random.default_rng(5)
    k_mat, m_mat = random_frame(rng, most_dofs=200)
    assert len(k_mat) > 100
    model = ar.MatrixModel(k_mat, m_mat)
    responses = list(range(0, 30, 3))
    together = model.antiresonances(responses, 4, f_max_hz=800.0)
    for i, freq in reversed(list(zip(responses, together, strict=True))):
        np.testing.assert_array_equal(model.antiresonances(i, 4, f_max_hz=800.0), freq)
