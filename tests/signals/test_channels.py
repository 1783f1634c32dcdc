"""Channels that are dead, clipped, doubled, torn, late or of another quantity."""

import numpy as np
import pytest

from antires_rs.signals.data_check import check_data
from antires_rs.signals.recording import Recording
from tests.support.checked_records import BAND, FS, changed, check, seen


def test_a_dead_channel_is_named(good):
    result = check(changed(good, 4, np.zeros_like))
    assert seen(result) == [("dead_channel", (4,))]
    assert result.fatal
    assert result.dofs == (0, 1, 2, 3, 5, 6, 7)
    rng = np.random.default_rng(57)
    for level in (1.0, 1e-4):
        result = check(changed(good, 4, lambda x, level=level: level * rng.standard_normal(x.size)))
        assert seen(result) == [("dead_channel", (4,))]
        assert "only noise" in result.findings[0].text
    assert seen(check_data(Recording(np.ones((2, 4096)), FS), band_hz=BAND)) == [("dead_channel", (0, 1))]


@pytest.mark.parametrize(("low", "high"), [(-2.5, 2.5), (-9.0, 2.0), (-3.2, 9.0)])
def test_a_clipped_channel_is_named(good, low, high):
    def adc(x):
        step = x.std() / 2**6
        return step * np.clip(np.round(x / step), -(2**7), 2**7)

    assert seen(check(changed(good, 2, adc))) == [("clipped_channel", (2,))]  # also with coarse digits
    result = check(changed(good, 2, lambda x: np.clip(x, low * x.std(), high * x.std())))
    assert seen(result) == [("clipped_channel", (2,))]
    x = good[0][2]
    beyond = np.mean((x < low * x.std()) | (x > high * x.std()))
    # The pile holds what was beyond, and the few samples just below.
    assert beyond <= result.findings[0].value <= 1.3 * beyond


def test_the_same_signal_twice_is_named(good):
    responses = good[0].copy()
    responses[6] = -2.0 * responses[1]
    result = check(Recording(responses, FS))
    assert seen(result) == [("duplicated_channels", (1, 6))]
    assert "-2" in result.findings[0].text


def test_dropouts_and_spikes_are_named(good):
    def dropout(x):
        x[5000:5060] = x[5000]
        return x

    def spike(x):
        x[5000] += 30.0 * x.std()
        return x

    assert seen(check(changed(good, 3, dropout))) == [("dropouts", (3,))]
    assert seen(check(changed(good, 3, spike))) == [("spikes", (3,))]


def filtered(x, response):
    return np.fft.irfft(np.fft.rfft(x) * response(np.fft.rfftfreq(x.size, 1.0 / FS)), x.size)


@pytest.mark.parametrize("delay_samples", [1.0, -1.0, 30.0])
def test_a_late_channel_is_named_with_its_delay(good, delay_samples):
    result = check(
        changed(good, 4, lambda x: filtered(x, lambda f: np.exp(-2j * np.pi * f * delay_samples / FS)))
    )
    assert seen(result) == [("time_shift", (4,))]
    assert result.findings[0].value * FS == pytest.approx(delay_samples, abs=0.1)


@pytest.mark.parametrize("band", [(30, 40), (50, 60), (40, 60)])
def test_an_antiresonance_in_a_narrow_band_is_no_delay(good, band):
    """Its turn, continued from there to 0 Hz, looked like tens of samples or like another quantity."""
    result = check_data(Recording(good[0], FS), excitation=0, band_hz=band)
    assert not result.named("time_shift") + result.named("quadrature")


def test_a_velocity_among_accelerations_is_named(good):
    def integral(f):
        return (f > 1) / (2j * np.pi * np.maximum(f, 1))

    result = check(changed(good, 4, lambda x: filtered(x, integral)))
    assert seen(result) == [("quadrature", (4,))]
    assert check(changed(good, 4, np.negative)).ok  # polarity cannot be seen


def test_of_two_channels_the_pair_is_named(good):
    late = filtered(good[0][5], lambda f: np.exp(-2j * np.pi * f * 2 / FS))
    assert seen(check(Recording([good[0][0], late], FS))) == [("time_shift", (0, 1))]


def test_a_channel_under_its_noise_is_a_note(good):
    rng = np.random.default_rng(58)
    result = check(changed(good, 5, lambda x: x + 0.5 * x.std() * rng.standard_normal(x.size)))
    assert result.ok
    assert [(f.severity, f.where) for f in result.named("signal_to_noise")] == [("note", (5,))]
