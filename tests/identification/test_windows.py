"""Fits over windows: curves without averages, measured and made from matrices that no model of ours holds."""

from functools import cache

import numpy as np
import pytest

import antires_rs as ar
from reference.measured import DATA, REFERENCE, STATES, as_transmissibilities, counted, plate, structures
from tests.support.campaign import some_of

BAND = (8.0, 60.0)


def free_chain(n=7, k_over_m=5e4, damping=0.01, sensors=range(7), force=0, noise=0.0, seed=0):
    """Receptances of equal masses and springs by inverting K + i eta K - w^2 M at every line."""
    stiffness = k_over_m * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    stiffness[0, 0] = stiffness[-1, -1] = k_over_m
    freq = np.arange(5.0, 75.0, 0.05)
    dynamic = stiffness[None] * (1.0 + 2j * damping) - ((2 * np.pi * freq) ** 2)[:, None, None] * np.eye(n)
    column = np.linalg.inv(dynamic)[:, :, force].T[list(sensors)]
    rng = np.random.default_rng(seed)
    rough = rng.standard_normal(column.shape) + 1j * rng.standard_normal(column.shape)
    column = column + noise * np.sqrt(np.mean(np.abs(column) ** 2, axis=1, keepdims=True) / 2) * rough
    return ar.FrequencyResponse(freq, column, dofs=list(sensors))


@cache
def rough():
    return free_chain(noise=0.01, seed=1, sensors=(0, 3, 6))


def zeros_of(source, band_hz=BAND, excitation=0, **options):
    return ar.identify_antiresonances(source, excitation=excitation, band_hz=band_hz, check="off", **options)


@pytest.mark.parametrize("noise", some_of([0.01, 1e-4]))
def test_frfs_and_transmissibilities_agree_but_for_nodes(noise):
    # Of the middle mass, on a node of every second mode, transmissibilities see three more.
    frfs = free_chain(noise=noise)
    by_frfs = zeros_of(frfs)
    by_quotients = zeros_of(as_transmissibilities(frfs, 4))
    for dof in frfs.dofs:
        extra = [f for f in by_quotients[dof] if not np.any(np.abs(by_frfs[dof] / f - 1.0) < 1e-3)]
        assert by_quotients[dof].size == by_frfs[dof].size + len(extra)
        marked = by_frfs.left_out[dof]
        for f in extra:
            near = int(np.argmin(np.abs(marked.freq_hz - f)))
            assert marked.freq_hz[near] == pytest.approx(f, rel=1e-3)
            assert marked.scores["why"][near] == "seen by transmissibilities only"
    at_middle = by_frfs.left_out[3].freq_hz
    for f in (15.84, 44.38):
        assert np.abs(at_middle - f).min() < 0.1, f


def damped_zeros(n=7, k_over_m=5e4, damping=0.01):
    """abs(s) of the zeros at the force, from the matrix without it, with the same hysteretic damping."""
    stiffness = k_over_m * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    stiffness[-1, -1] = k_over_m
    return np.sqrt(np.linalg.eigvalsh(stiffness[1:, 1:]) * np.abs(1.0 + 2j * damping)) / (2 * np.pi)


@pytest.mark.parametrize("seeds", some_of([range(40, 43), range(40, 46)]))
def test_stated_deviations_cover_white_noise(seeds):
    truth = damped_zeros()  # 90 % intervals of the driving point's zeros, over seeds that nothing was set on.
    truth = truth[(truth > BAND[0]) & (truth < BAND[1])]
    inside = asked = 0
    stated, errors = [], []
    for seed in seeds:
        table = zeros_of(free_chain(noise=0.02, seed=seed, sensors=(0, 2, 5))).tables[0]
        for f in truth:
            near = np.abs(table.freq_hz / f - 1.0) < 0.01
            assert near.sum() == 1, f
            asked += 1
            stated.append(table.std_hz[near][0])
            errors.append(abs(table.freq_hz[near][0] - f))
            inside += abs(table.freq_hz[near][0] - f) <= 1.645 * table.std_hz[near][0]
    assert inside >= 0.75 * asked, (inside, asked)
    # And are no excuse: the median deviation is not twice the median error of a normal value.
    assert np.median(stated) < 2.0 * np.median(errors) / 0.6745


@pytest.mark.skipif(not (DATA / "iqs_3storey").is_dir(), reason="iqs_3storey absent; set ANTIRES_DATA")
@pytest.mark.parametrize("kind", some_of(["transmissibility", "frf"]))
def test_three_storey_replica(kind):
    frfs = next(m.frfs for m in structures() if m.name == "three-storey replica")
    found = zeros_of(frfs if kind == "frf" else as_transmissibilities(frfs, 0), (10.0, 95.0))
    read = {0: [44.2, 66.9], 1: [76.4], 2: [27.3], 3: [17.4, 58.9]}
    for dof, values in read.items():
        assert found[dof] == pytest.approx(values, rel=5e-3)
    assert {str(g) for g in found.scores[0]["grade"]} <= {"sure", "fair", "weak"}


@pytest.mark.skipif(not (DATA / "iqs_plates").is_dir(), reason="iqs_plates absent; set ANTIRES_DATA")
@pytest.mark.parametrize("states", some_of([["36A_S3"], list(STATES)]))
def test_plates(states):
    counts = [plate_counts(state) for state in states]
    assert sum(c.found for c in counts) >= 0.97 * sum(c.clear for c in counts)
    assert sum(c.false for c in counts) <= 0.10 * sum(c.values for c in counts)


def plate_counts(state):
    """Dips found by FRFs, after the transmissibilities were seen to lose none of their values."""
    measured = plate(state)
    found = zeros_of(measured.frfs, measured.band_hz, "x")
    other = zeros_of(as_transmissibilities(measured.frfs, REFERENCE), measured.band_hz, "x")
    lost = [f for dof in found for f in found[dof] if not np.any(np.abs(other[dof] / f - 1.0) < 2e-3)]
    assert len(lost) <= 1
    return counted(measured, found)


WITHOUT_EFFECT = {
    "min_rows has no effect on fits over windows": {"min_rows": 5},
    "damping_tol and persistent have no effect": {"damping_tol": 0.05, "persistent": False},
    "counts there is freq_tol, max_damping, min_share, min_d": {"min_dominance": 0.1},
    "min_order above 16 has no effect": {"min_order": 17},
    "min_share has no.*formulation 'joint'": {"min_share": 0.4, "formulation": "joint"},
}


@pytest.mark.parametrize("said", [*WITHOUT_EFFECT, "max_order above 16 has no effect"])
def test_options_without_effect_are_named(said):
    fit = WITHOUT_EFFECT.get(said)
    with pytest.warns(ar.AntiresWarning, match=said):
        zeros_of(rough(), (20.0, 40.0), **({"fit": ar.FitOptions(**fit)} if fit else {"max_order": 30}))


def test_options_that_count_are_no_cause_for_a_warning_and_few_orders_are_enough():
    zeros_of(rough(), preset="strict")
    zeros_of(rough(), max_order=16, fit=ar.FitOptions(min_share=0.4, freq_tol=0.02))
    found = zeros_of(rough(), max_order=8)  # Chains of more than min_rows = 10 orders are the sweep's.
    assert found[0].size >= 3
    assert max(d.orders.max() for d in found.diagrams.values()) <= 8
    with pytest.raises(ar.InvalidInputError, match="^max_order"):
        zeros_of(rough(), max_order=8, fit=ar.FitOptions(formulation="numerators"))


def test_few_lines_are_told():
    frfs = free_chain(noise=0.003, seed=2, sensors=(0, 3, 6))
    with pytest.warns(ar.AntiresWarning, match=r"holds 40 lines.*carry 8 orders.*want 48.*0\.041 Hz apart"):
        few = zeros_of(frfs, (24.01, 26.01))
    assert few[0] == pytest.approx([damped_zeros()[1]], rel=2e-3)
    coarse = ar.FrequencyResponse(frfs.freq_hz[::30], frfs.values[:, ::30], dofs=frfs.dofs)
    with pytest.warns(ar.AntiresWarning, match="want 48 lines"):
        zeros_of(coarse)


def hiding_chain(noise, seed):
    """Inertances of a grounded chain whose fourth mode is near zeros of all responses; and these zeros.

    Mode 56.05 Hz, 0.8 % damping: half its width is 0.45 Hz, the zeros are 0.03 and 0.06 Hz away.
    """
    from scipy.linalg import eigh

    draw = np.random.default_rng(123)
    mass, spring = draw.uniform(1, 2, 5), draw.uniform(3e4, 6e4, 5)
    stiffness = np.diag(spring + np.append(spring[1:], 0.0))
    stiffness -= np.diag(spring[1:], 1) + np.diag(spring[1:], -1)
    squares, shapes = eigh(stiffness, np.diag(mass))
    freq = 0.125 * np.arange(1, 801)
    w, own = 2.0 * np.pi * freq[:, None], np.sqrt(squares)
    values = (-(w**2) * shapes[2] / (squares - w**2 + 0.016j * own * w)) @ shapes.T
    rng = np.random.default_rng(seed)
    values *= 1.0 + noise * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape))
    behind = (eigh(stiffness[s, s], np.diag(mass[s]))[0] for s in (slice(0, 2), slice(3, 5)))
    parts = [np.sqrt(squares) / (2 * np.pi) for squares in behind]
    return ar.FrequencyResponse(freq, values.T.copy(), dofs=list(range(5))), parts


@pytest.mark.parametrize("noise", some_of([0.005, 0.002]))
def test_a_zero_that_a_resonance_hides_is_left_out_with_the_reason(noise):
    frfs, (below, above) = hiding_chain(noise, 1)
    # Zeros of a chain's response are modes of what lies behind it, as seen from the force.
    hidden = {0: above[-1], 1: above[-1], 3: below[-1], 4: below[-1]}
    found = zeros_of(frfs, (5.0, 80.0), 2)
    for dof, zero in hidden.items():
        assert 55.0 < zero < 57.0
        assert not np.any(np.abs(found[dof] / zero - 1.0) < 0.005)  # it makes no dip
        left = found.left_out[dof]
        why = left.scores["why"] == "hidden by a resonance beside it"
        assert left.freq_hz[why] == pytest.approx([zero], rel=3e-4)
    assert " hidden by a resonance beside it), see .left_out" in str(found)
