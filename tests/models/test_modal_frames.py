"""The band route on frames: against SciPy's QZ and 50 digits. All 200: benchmarks/frames_against_scipy.py.

On soft springs the lowest roots are some 1e10 below the stiffest entries: what one ulp of the norm of K
moves, QZ cannot tell from zero. Every way of asking has to give one set.
"""

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from reference.exact_roots import ExactPencil
from reference.random_frames import assemble, random_frame, rigid_hz
from reference.random_models import Oracle, cancelled
from tests.models.shared import assert_promise, quietly
from tests.support.campaign import some_of
from tests.support.tolerances import AGAINST_SCIPY

TUBE = ar.Tube(0.038, 0.0015, 2.1e11, 7850.0)
BAND_HZ = 500.0
METHODS = ("modal", "pencil")


def band_hz(k_mat, m_mat, modes):
    lam = scipy.linalg.eigvalsh(k_mat, m_mat)
    return np.sqrt(0.3 * lam[modes - 1] + 0.7 * lam[modes]) / (2 * np.pi)


def matches(freq_hz, others_hz, within=AGAINST_SCIPY):
    if others_hz.size == 0:
        return np.zeros(freq_hz.size, dtype=bool)
    return np.abs(others_hz / freq_hz[:, None] - 1.0).min(axis=1) <= within


def seen_by_qz(k_mat, m_mat, i, k, limit_hz, from_hz=0.0):
    roots = Oracle(k_mat, m_mat, i, k).freq_hz((2 * np.pi * from_hz) ** 2, (2 * np.pi * limit_hz) ** 2)
    return roots[~cancelled(k_mat, m_mat, i, k, roots)]


@pytest.mark.parametrize("seed", some_of(range(12), [3, 4, 7, 8, 10, 11]))
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
        seen = seen_by_qz(k_mat, m_mat, i, k, limit_hz)
        agreed = matches(ours, seen)
        if not agreed.all() or ours.size != seen.size:
            assert_promise(k_mat, m_mat, i, k, ours[~agreed])
            moved = [exact.root_near(i, k, f) for f in seen[~matches(seen, ours)]]
            assert all(matches(np.array([f]), ours) for f in moved if f is not None), moved
            assert np.unique(ours).size == ours.size
    full = model.antiresonances(k, k, f_max_hz=limit_hz, include_cancelled=True)
    assert full.size == exact.driving_zeros(k, rigid_hz(k_mat, m_mat), limit_hz)


def straight(n_nodes, columns=2, length=2.0):
    nodes = np.column_stack([np.linspace(0, length, n_nodes), np.zeros((n_nodes, columns - 1))])
    elements = [(j, j + 1) for j in range(n_nodes - 1)]
    return assemble(nodes, elements, [(0.04, 0.002)] * len(elements))


def tuned(masses, springs, rigid=False):
    """A tube of 20 nodes with grounded oscillators hung on it: (node, kg, N/m) each."""
    k_mat, m_mat = (scipy.linalg.block_diag(a, np.zeros((len(masses),) * 2)) for a in straight(20))
    n = 60
    if not rigid:
        k_mat[1, 1] += 2e4
        k_mat[n - 2, n - 2] += 3e4
        k_mat[0, 0] += 1e5
    for j, ((node, kg), spring) in enumerate(zip(masses, springs, strict=True), start=n):
        dof = 3 * node + 1
        m_mat[j, j] = kg
        k_mat[[j, dof], [j, dof]] += spring
        k_mat[[j, dof], [dof, j]] -= spring
    return k_mat, m_mat


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("gap", "visible"), [(2e-5, 2), (1e-7, 1), (1e-8, 1)])
def test_a_pole_between_two_zeros_cancels_one_of_them_when_it_cannot_be_seen(gap, visible, method):
    """Two absorbers on the driven dof. The pole between their zeros has a residue of some gap squared."""
    springs = [3e4, 3e4 * (1 + 2 * gap)]
    model, k = ar.MatrixModel(*tuned([(6, 0.5), (6, 0.5)], springs)), 3 * 6 + 1
    want = np.sqrt(np.array(springs) / 0.5) / (2 * np.pi)
    for flag, count in ((False, visible), (True, 2)):
        found = model.antiresonances(k, k, f_max_hz=400.0, method=method, include_cancelled=flag)
        near = found[np.abs(found / want[0] - 1) < 1e-4]
        assert near.size == count
        assert matches(near, want, within=gap).all()


def square_tube():
    k_mat, m_mat = straight(12, columns=3, length=1.5)
    k_mat[range(4), range(4)] += 4e3
    return k_mat, m_mat


NEAR_HZ, LIGHT = np.sqrt(6e4) / (2 * np.pi), tuned([(15, 1e-6)], [1e-6 * (2 * np.pi * 60.0) ** 2])
CLOSE = {gap: tuned([(6, 0.5), (13, 0.5)], [3e4, 3e4 * (1 + 2 * gap)]) for gap in (5e-7, 1e-7, 1e-8)}
HARD = {  #: Matrices, dofs, limit in Hz; and how many roots lie within a thousandth of a frequency.
    **{f"two zeros {gap:g} apart": (pair, (19, 40), 400.0, (NEAR_HZ, 2)) for gap, pair in CLOSE.items()},
    **{f"a pole beside {ends}": (LIGHT, ends, 300.0, (60.0, 1)) for ends in ((19, 19), (19, 46), (46, 46))},
    "driven at its node": (straight(21), (31, 31), 1500.0, None),
    "rigid bodies": (tuned([(6, 0.5)], [3e4], rigid=True), (1, 1), 500.0, None),
    # There a zero lies on a pole that cancels, and K - x M is singular.
    "repeated: absorbers": (tuned([(6, 0.5), (6, 0.5), (6, 0.5)], [3e4] * 3), (19, 40), 400.0, None),
    "repeated: both planes": (square_tube(), (1, 25), 900.0, None),
}


@pytest.mark.parametrize("name", HARD)
def test_hard_pairs_are_the_same_by_bands_by_all_modes_and_by_the_pencil(name):
    """Without a limit the dense solver takes all modes; with one the band route a few."""
    (k_mat, m_mat), (i, k), limit_hz, near = HARD[name]
    model = ar.MatrixModel(k_mat, m_mat)
    for flag in (True, False):
        band = model.antiresonances(i, k, f_max_hz=limit_hz, include_cancelled=flag)
        dense = model.antiresonances(i, k, include_cancelled=flag)
        pencil = model.antiresonances(i, k, f_max_hz=limit_hz, method="pencil", include_cancelled=flag)
        assert band.size > 1
        for other in (dense[dense <= limit_hz], pencil):
            np.testing.assert_allclose(band, other, rtol=AGAINST_SCIPY)
    if "repeated" not in name:
        assert_promise(k_mat, m_mat, i, k, band)
    if near:
        assert np.count_nonzero(np.abs(band / near[0] - 1.0) < 1e-3) == near[1]


# -- Soft springs
def pipe(beams, wave, spring):
    nodes, tenth = [(2.0 * j / beams, wave * np.sin(j)) for j in range(beams + 1)], beams // 10
    springs = [(tenth, "v", spring), (9 * tenth, "v", spring), (tenth, "u", spring)]
    pairs, masses = [(j, j + 1) for j in range(beams)], [(3 * tenth, 2.0, 0.01)]
    return ar.FrameModel(nodes, pairs, TUBE, ground_springs=springs, point_masses=masses)


def test_a_root_at_two_hertz_that_was_lost():
    model = pipe(40, 0.02, 500.0)
    i, k = model.dof(20, "u"), model.dof(2, "v")
    k_mat, m_mat = model.stiffness().toarray(), model.mass().toarray()
    load = np.eye(model.n_dof)[k]
    left, right = (np.linalg.solve(k_mat - (2 * np.pi * f) ** 2 * m_mat, load)[i] for f in (1.97, 1.99))
    assert left * right < 0.0
    for method in METHODS:
        found = model.antiresonances(i, k, method=method)
        found, wanted = found[found < BAND_HZ], [1.981467, 2.547607, 44.458773, 398.506783]
        np.testing.assert_allclose(found, wanted, rtol=1e-5)


SOFT = [(12, 0.02, 20.0), (12, 0.0, 20.0), (24, 0.02, 500.0), (40, 0.02, 20.0), (40, 0.0, 500.0)]
SOFT += [(40, 0.02, 500.0), (60, 0.0, 500.0), (60, 0.02, 20.0), (99, 0.02, 500.0)]


@pytest.mark.parametrize(("beams", "wave", "spring"), some_of(SOFT, kept=2))
def test_limit_and_method_do_not_change_the_set(beams, wave, spring):
    model, near = pipe(beams, wave, spring), max(1, beams // 20)
    k_mat, m_mat = model.stiffness().toarray(), model.mass().toarray()
    exact, k = ExactPencil(k_mat, m_mat), model.dof(near, "v")
    for node, direction in [(near, "v"), (beams - near, "v"), (beams // 2, "u"), (beams // 3, "v")]:
        i = model.dof(node, direction)
        # In the straight pipe u is not connected to v, of which it warns.
        limits = ((BAND_HZ, "modal"), (None, "modal"), (6.0 * BAND_HZ, "modal"), (BAND_HZ, "pencil"))
        band, *others = (quietly(model.antiresonances, i, k, f_max_hz=hz, method=how) for hz, how in limits)
        assert_promise(k_mat, m_mat, i, k, band)
        for other in others:
            other = other[other <= BAND_HZ]
            np.testing.assert_allclose(other, band, rtol=1e-5)  # soft roots are good to some ulps of K
            assert_promise(k_mat, m_mat, i, k, other)
        if band.size:
            moved = [exact.root_near(i, k, f) for f in seen_by_qz(k_mat, m_mat, i, k, BAND_HZ)]
            assert matches(np.array([f for f in moved if f is not None]), band, within=1e-5).all()
    full = model.antiresonances(k, k, include_cancelled=True)
    assert np.count_nonzero(full <= BAND_HZ) == exact.driving_zeros(k, 0.1, BAND_HZ)


@pytest.mark.parametrize(("beams", "wave"), [(12, 0.02), (40, 0.02), (100, 0.0)])
def test_the_lowest_modes_are_those_of_all(beams, wave):
    model = pipe(beams, wave, 2e4)
    k_mat, m_mat = model.stiffness().toarray(), model.mass().toarray()
    # 1 / lambda from the flipped pair: LAPACK keeps the digits of the largest.
    want = np.sqrt(1.0 / scipy.linalg.eigvalsh(m_mat, k_mat)[::-1]) / (2 * np.pi)
    below, most = np.count_nonzero(want <= BAND_HZ), 2 * beams
    for f_max_hz, n_modes, count in (
        (BAND_HZ, None, below), (None, 5, 5), (BAND_HZ, 3, 3), (BAND_HZ, 99, below), (None, most, most)
    ):  # fmt: skip
        modes = model.modes(n_modes=n_modes, f_max_hz=f_max_hz)
        np.testing.assert_allclose(modes.freq_hz, want[:count], rtol=AGAINST_SCIPY)
        shapes, lam = modes.shapes.real, (2 * np.pi * modes.freq_hz) ** 2
        np.testing.assert_allclose(shapes @ m_mat @ shapes.T, np.eye(count), atol=1e-9)
        np.testing.assert_allclose(shapes @ k_mat @ shapes.T, np.diag(lam), atol=1e-7 * lam.max())
    with pytest.raises(ar.InvalidInputError, match=r"^f_max_hz: got 0.01 Hz; wanted .*first resonance"):
        model.modes(f_max_hz=0.01)
