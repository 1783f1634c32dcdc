"""Virtual records: the force, the noise, the randomness, and the response's own statistics."""

import numpy as np
import pytest
import scipy.signal

import antires_rs as ar
from tests.support.tolerances import H1_SIGMAS, RECORD_STATISTICS

FS_HZ = 128.0
MODEL = ar.MassSpringChain([1.0, 0.7, 1.2], [2e4, 3e4], ground_first_n_per_m=5e3)


def record(**options):
    settings = {"excitation": 0, "fs_hz": FS_HZ, "duration_s": 64.0, "damping_ratio": 0.02, "rng": 3}
    return MODEL.simulate(**(settings | options))


def test_shape_rate_dofs_and_force_and_the_same_record_for_a_seed():
    made = record(responses=[2, 0])
    assert (made.responses.shape, made.fs_hz, made.dofs) == ((2, 8192), FS_HZ, (2, 0))
    assert made.force.shape == (8192,)
    assert made.force.std() == pytest.approx(1.0, rel=RECORD_STATISTICS)
    assert record().dofs == (0, 1, 2)
    np.testing.assert_array_equal(record(noise=0.1).responses, record(noise=0.1).responses)
    generators = [np.random.default_rng(8) for _ in range(2)]
    a, b = (record(rng=g) for g in generators)
    np.testing.assert_array_equal(a.responses, b.responses)
    assert not np.array_equal(record(rng=4).responses, record().responses)
    assert not np.array_equal(record(rng=None).responses, record(rng=None).responses)
    assert not np.array_equal(record(rng=generators[0]).responses, a.responses)


def test_the_force_keeps_to_its_band():
    made = record(band_hz=(10.0, 30.0), duration_s=256.0)
    freq, power = scipy.signal.welch(made.force, FS_HZ, nperseg=2048)
    # Welch takes each segment's mean away, which leaves a trace at the first two lines.
    inside, outside = (freq > 11.0) & (freq < 29.0), ((freq > 0.5) & (freq < 8.0)) | (freq > 32.0)
    # Flat inside: 31 averages leave each line a spread of 18 %; the extremes of 290 lie within 4 of those.
    assert np.abs(power[inside] / power[inside].mean() - 1.0).max() < 0.75
    assert power[outside].max() < 1e-8 * power[inside].mean()


def test_noise_is_white_and_a_fraction_of_each_channels_rms():
    clean, noisy = record(duration_s=256.0), record(duration_s=256.0, noise=0.05)
    noise = noisy.responses - clean.responses
    level = noise.std(axis=1) / clean.responses.std(axis=1)
    np.testing.assert_allclose(level, 0.05, rtol=RECORD_STATISTICS)
    assert np.abs(np.corrcoef(noise) - np.eye(3)).max() < RECORD_STATISTICS
    assert np.abs([np.corrcoef(row[1:], row[:-1])[0, 1] for row in noise]).max() < RECORD_STATISTICS
    np.testing.assert_array_equal(noisy.force, clean.force)


def test_h1_of_a_long_record_is_the_models_frf():
    """The peaks would tell a wrong damping; the error allowed is the statistical one of Welch's H1.

    var|H1| = (1 - coherence) / (2 n coherence) |H|^2 plus the bias of the resolution (about a hundred
    lines over a half-power bandwidth of 0.2 Hz keep it below 1 %).
    """
    damping_ratio = 0.01, 0.02, 0.04
    made = record(duration_s=4096.0, damping_ratio=damping_ratio)
    nperseg = 16384
    freq, cross = scipy.signal.csd(made.force, made.responses, FS_HZ, nperseg=nperseg)
    _, power = scipy.signal.welch(made.force, FS_HZ, nperseg=nperseg)
    h1 = cross / power
    band = (freq > 3.0) & (freq < 60.0)
    exact = MODEL.frf([0, 1, 2], 0, freq[band], damping_ratio=damping_ratio)
    averages = 1.7 * made.force.size / nperseg  # hann window, half overlap: 1.7 independent each
    for resonance in MODEL.modes().freq_hz:
        line = np.argmin(np.abs(freq[band] - resonance))
        lines = slice(line - 3, line + 4)
        ratio = h1[:, band][:, lines] / exact[:, lines]  # with its phase: force and response begin together
        assert np.abs(ratio.mean() - 1.0) < 0.01 + H1_SIGMAS / np.sqrt(2 * averages * 7)


def test_a_lightly_damped_structure_rings_at_its_full_level_in_a_short_record():
    """Mean variance over many short records against the integral of |H|^2 (the memory exceeds the record)."""
    chain = ar.MassSpringChain([1.0, 1.0], [500.0])
    fs_hz, zeta, seconds = 20.0, 0.002, 10.0
    options = {"excitation": 0, "fs_hz": fs_hz, "duration_s": seconds, "damping_ratio": zeta}
    variance = np.mean([chain.simulate(**options, responses=[1], rng=s).responses.var() for s in range(150)])
    freq = np.arange(1, 200_001) * (fs_hz / 2 / 200_000)
    integral = np.mean(np.abs(chain.frf(1, 0, freq, damping_ratio=zeta)) ** 2)
    # 150 records of two or three correlation times each: a standard error of some 6 %.
    assert abs(variance / integral - 1.0) < 0.25
