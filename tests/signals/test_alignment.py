"""Sensors with clocks of their own become one record, without a phase of its own."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.measured_data import DATA, needs_shake_table
from tests.support.refusals import refused
from tests.support.snapshots import refusals

RNG = np.random.default_rng(31)
FS = 100.0


def sensor(times, name, *, at=7.3, clock=None, fs=FS, delay=0.0):
    """A sine of that frequency, seen by a sensor."""
    values = 9.81 + np.sin(2 * np.pi * at * (times - delay))
    return ar.Recording([values], fs, dofs=[name], time_s=times if clock is None else clock)


def phases(joined, at):
    """Phases of all channels at a frequency, against the first."""
    t = np.arange(joined.n_samples) / joined.fs_hz
    window = np.hanning(t.size) * np.exp(-2j * np.pi * at * t)
    lines = (joined.responses - joined.responses.mean(axis=1, keepdims=True)) @ window
    return np.angle(lines / lines[0]), np.abs(lines / lines[0])


T = 100.0 + np.arange(6000) / FS


@pytest.mark.parametrize("at", [0.7, 7.3, 23.0, 38.0])
@pytest.mark.parametrize(
    ("times", "fs"),
    [
        (T[300:] + 0.0037, FS),  # begins later, between the samples of the other
        (99.0 + np.arange(6200) / (FS * 1.0004), FS * 1.0004),  # a clock that is a little faster
        (98.0 + np.arange(13000) / 203.7, 203.7),
    ],
)
def test_other_starts_and_rates_keep_amplitude_and_phase(at, times, fs):
    joined = ar.align([sensor(T, "a", at=at), sensor(times, "b", at=at, fs=fs)])
    assert (joined.dofs, joined.fs_hz) == (("a", "b"), FS)
    assert joined.n_samples > 5200
    phase, size = phases(joined, at)
    assert abs(phase[1]) < 1e-4
    assert abs(size[1] - 1.0) < 1e-4
    assert np.allclose(joined.responses[0], 9.81 + np.sin(2 * np.pi * at * joined.time_s), atol=1e-9)


def test_what_a_slower_sensor_cannot_show_does_not_fold_back():
    times = 98.0 + np.arange(16000) / 250.0
    joined = ar.align([sensor(T, "a", at=5.0), sensor(times, "b", at=72.0, fs=250.0)])  # would be at 28 Hz
    assert np.std(joined.responses[1]) < 1e-4


@pytest.mark.parametrize("at", [2.0, 7.3, 23.0])
def test_missed_samples_are_made_up_and_other_samples_stay(at):
    left = np.ones(T.size, dtype=bool)
    left[[*range(500, 505), 900, 902, *RNG.integers(1000, 5900, 20)]] = False
    gappy = sensor(T[left], "b", at=at)
    joined = ar.align([sensor(T, "a", at=at), gappy])
    assert joined.n_samples == T.size
    assert np.array_equal(joined.responses[1][left], gappy.responses[0])
    assert np.abs(joined.responses[1] - joined.responses[0]).max() < 1e-4
    for use in (
        lambda rec: ar.check_data(rec, band_hz=(1, 9)),
        lambda rec: ar.identify_antiresonances(rec, excitation="b", band_hz=(1, 9)),
    ):
        refused("gaps in its time.*ar.align", use, gappy)


def test_clocks_that_tick_together_lose_nothing():
    joined = ar.align([sensor(T, "a"), sensor(T[250:5000], "b")])
    assert np.array_equal(joined.responses[1], sensor(T[250:5000], "b").responses[0])
    assert np.array_equal(joined.time_s, T[250:5000])


def test_jitter_of_the_stamps_is_not_one_of_the_samples():
    jitter = T + RNG.uniform(-0.2, 0.2, T.size) / FS
    joined = ar.align([sensor(T, "a"), sensor(T, "b", clock=jitter)])
    phase, size = phases(joined, 7.3)
    assert abs(phase[1]) < 0.01
    assert abs(size[1] - 1.0) < 1e-3


def test_a_counter_that_began_again_is_told():
    wrap = 2.0**32 * 1e-6
    late = T[3000:] + wrap - T[3000] + 5.0
    a = sensor(T, "a", clock=T + wrap - T[3000])
    b = sensor(T[3000:], "b", clock=late - wrap)
    with pytest.warns(ar.AntiresWarning, match="began again"):
        joined = ar.align([a, b])
    assert joined.duration_s == pytest.approx(25.0, abs=0.1)


HAMMER = ar.Recording([np.sin(T), np.cos(T)], FS, force=np.sin(3 * T), time_s=T)


def test_what_was_never_on_one_clock_is_refused():
    refusals(__file__, "wrong_clocks.txt", globals())


def test_clocks_that_begin_at_zero_are_told():
    zero = T - T[0]
    with pytest.warns(ar.AntiresWarning, match="begins at zero"):
        ar.align([sensor(T, "a", clock=zero), sensor(T, "b", clock=zero)])


def test_channels_are_named_or_left_out_and_the_force_stays():
    joined = ar.align([HAMMER, sensor(T[10:-10], 0)], dofs=["tip", None, "root"])
    assert joined.dofs == ("tip", "root")
    assert np.array_equal(joined.force, HAMMER.force[10:-10])


@needs_shake_table
def test_the_shake_table_as_its_sensors_wrote_it():
    floors = ("ground", "1st", "2nd", "3rd")
    files = [DATA / "shake_table" / f"flexible_sine_1.5_{floor}_floor.csv" for floor in floors]
    joined = ar.align([ar.read_csv(file, responses="Acc_X") for file in files], dofs=floors)
    known = np.load(DATA / "shake_table" / "records.npz")["flexible_sine_1.5"]
    found = joined.responses - joined.responses.mean(axis=1, keepdims=True)
    assert joined.fs_hz == pytest.approx(120.0, rel=1e-4)
    assert all(np.corrcoef(a[: b.size], b[: a.size])[0, 1] > 0.98 for a, b in zip(found, known, strict=True))
