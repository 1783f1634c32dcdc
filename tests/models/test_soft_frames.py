"""Stiff frames on soft springs: the lowest roots are some 1e10 below the stiffest entries.

What one ulp of the norm of K moves, QZ cannot tell from zero. Here every way of asking has to give one set.
"""

import warnings

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from reference.exact_roots import ExactPencil
from reference.random_models import Oracle, cancelled
from tests.support.campaign import some_of
from tests.support.tolerances import AGAINST_SCIPY, PROMISE, PROMISE_ULPS

TUBE = ar.Tube(0.038, 0.0015, 2.1e11, 7850.0)
BAND_HZ = 500.0


def pipe(beams, wave, spring):
    """2 m of tube, wavy or straight, on three springs and with a mass that breaks its symmetry."""
    nodes = [(2.0 * j / beams, wave * np.sin(j)) for j in range(beams + 1)]
    tenth = beams // 10
    return ar.FrameModel(
        nodes,
        [(j, j + 1) for j in range(beams)],
        TUBE,
        ground_springs=[(tenth, "v", spring), (9 * tenth, "v", spring), (tenth, "u", spring)],
        point_masses=[(3 * tenth, 2.0, 0.01)],
    )


def pairs(model, beams):
    near = max(1, beams // 20)
    k = model.dof(near, "v")
    responses = [(near, "v"), (beams - near, "v"), (beams // 2, "u"), (beams // 3, "v")]
    return k, [model.dof(*r) for r in responses]


def assert_exact(exact, i, k, freq_hz):
    for f in freq_hz:
        error, ulp = exact.error(i, k, f)
        assert abs(error) <= max(PROMISE, PROMISE_ULPS * ulp), (i, f, error, ulp)


def missing(freq_hz, others_hz):
    """Those of freq_hz that none of the others is near; soft roots are only good to some ulps of K."""
    return [f for f in freq_hz if others_hz.size == 0 or np.abs(others_hz / f - 1.0).min() > 1e-5]


def test_a_root_at_two_hertz_that_was_lost():
    """40 wavy beams: H changes its sign at 1.981 Hz."""
    nodes = [(0.05 * j, 0.02 * np.sin(j)) for j in range(41)]
    model = ar.FrameModel(
        nodes,
        [(j, j + 1) for j in range(40)],
        TUBE,
        point_masses=[(12, 2.0, 0.01)],
        ground_springs=[(4, "v", 500.0), (36, "v", 500.0), (4, "u", 500.0)],
    )
    i, k = model.dof(20, "u"), model.dof(2, "v")
    k_mat, m_mat = model.stiffness().toarray(), model.mass().toarray()
    load = np.eye(model.n_dof)[k]
    left, right = (np.linalg.solve(k_mat - (2 * np.pi * f) ** 2 * m_mat, load)[i] for f in (1.97, 1.99))
    assert left * right < 0.0
    for method in ("modal", "pencil"):
        found = model.antiresonances(i, k, method=method)
        assert missing([1.981467, 2.547607, 44.458773, 398.506783], found) == []
        assert np.count_nonzero(found < BAND_HZ) == 4


@pytest.mark.parametrize(
    ("beams", "wave", "spring"),
    some_of(
        [
            (12, 0.02, 20.0),
            (40, 0.02, 500.0),
            (40, 0.02, 20.0),
            (12, 0.0, 20.0),
            (40, 0.0, 500.0),
            (60, 0.0, 500.0),
            (60, 0.02, 20.0),
            (99, 0.02, 500.0),
        ],
        kept=5,
    ),
)
def test_limit_and_method_do_not_change_the_set(beams, wave, spring):
    model = pipe(beams, wave, spring)
    k_mat, m_mat = model.stiffness().toarray(), model.mass().toarray()
    exact = ExactPencil(k_mat, m_mat)
    k, responses = pairs(model, beams)
    for i in responses:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ar.AntiresWarning)  # the straight pipe: u is not connected to v
            band = model.antiresonances(i, k, f_max_hz=BAND_HZ)
            others = [
                model.antiresonances(i, k),
                model.antiresonances(i, k, f_max_hz=6.0 * BAND_HZ),
                model.antiresonances(i, k, f_max_hz=BAND_HZ, method="pencil"),
            ]
        assert_exact(exact, i, k, band)
        for other in others:
            other = other[other <= BAND_HZ]
            assert other.size == band.size, (model.dof_name(i), band, other)
            assert missing(band, other) == []
            assert_exact(exact, i, k, other)
        roots = Oracle(k_mat, m_mat, i, k).freq_hz(0.0, (2 * np.pi * BAND_HZ) ** 2)
        if band.size:
            seen = roots[~cancelled(k_mat, m_mat, i, k, roots)]
            moved = [exact.root_near(i, k, f) for f in seen]
            assert missing([f for f in moved if f is not None], band) == []
    full = model.antiresonances(k, k, include_cancelled=True)
    assert np.count_nonzero(full <= BAND_HZ) == exact.driving_zeros(k, 0.1, BAND_HZ)


@pytest.mark.parametrize(("beams", "wave"), [(12, 0.02), (40, 0.02), (100, 0.0)])
def test_the_lowest_modes_are_those_of_all(beams, wave):
    model = pipe(beams, wave, 2e4)
    k_mat, m_mat = model.stiffness().toarray(), model.mass().toarray()
    # 1 / lambda from the flipped pair: LAPACK keeps the digits of the largest.
    want = np.sqrt(1.0 / scipy.linalg.eigvalsh(m_mat, k_mat)[::-1]) / (2 * np.pi)
    below = np.count_nonzero(want <= BAND_HZ)
    for f_max_hz, n_modes, count in (
        (BAND_HZ, None, below),
        (None, 5, 5),
        (BAND_HZ, 3, 3),
        (BAND_HZ, 99, below),
        (None, 2 * beams, 2 * beams),
    ):
        modes = model.modes(n_modes=n_modes, f_max_hz=f_max_hz)
        assert len(modes) == count
        np.testing.assert_allclose(modes.freq_hz, want[:count], rtol=AGAINST_SCIPY)
        shapes, lam = modes.shapes.real, (2 * np.pi * modes.freq_hz) ** 2
        np.testing.assert_allclose(shapes @ m_mat @ shapes.T, np.eye(count), atol=1e-9)
        np.testing.assert_allclose(shapes @ k_mat @ shapes.T, np.diag(lam), atol=1e-7 * lam.max())


def test_free_frames_keep_their_rigid_modes_and_too_low_a_limit_is_refused():
    nodes = [(0.05 * j, 0.02 * np.sin(j)) for j in range(41)]
    free = ar.FrameModel(nodes, [(j, j + 1) for j in range(40)], TUBE)
    modes = free.modes(n_modes=5)
    assert np.count_nonzero(modes.freq_hz < 1e-2) == 3
    np.testing.assert_allclose(modes.freq_hz[3:], free.modes().freq_hz[3:5], rtol=AGAINST_SCIPY)
    with pytest.raises(ar.InvalidInputError, match="first resonance"):
        pipe(40, 0.02, 2e4).modes(f_max_hz=0.01)


def test_the_solution_kept_by_a_model_serves_its_damping_and_frequency_responses():
    model = pipe(12, 0.02, 2e4)
    freq = np.linspace(1.0, 300.0, 50)
    n_modes = len(model.modes())
    each = model.frf(4, 1, freq, damping_ratio=np.full(n_modes, 0.02))
    np.testing.assert_array_equal(each, pipe(12, 0.02, 2e4).frf(4, 1, freq, damping_ratio=0.02))
    with pytest.raises(ar.InvalidInputError, match=f"or {n_modes} of them"):
        model.frf(4, 1, freq, damping_ratio=np.full(n_modes - 1, 0.02))
