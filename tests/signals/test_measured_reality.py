"""The simulator of measured records itself: zeros, their standard deviations, switches, determinism."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.optimize

from reference.measured_reality import CLEAN, MEASURED, SWITCHES, ambient, as_measured, hit, hits, only
from reference.modal_structures import STRUCTURES, ModalStructure, cramer_rao


def winding(structure, row, low_hz, high_hz, damping):
    """Zeros less poles of a response in a strip about the real axis, by the argument principle."""

    def response(s):
        w = 2 * np.pi * structure.freq_hz[:, None]
        gain = structure.sensors[row] * structure.force
        return gain @ (s**2 / (s**2 + 2 * structure.damping[:, None] * w * s + w**2))

    side = 2 * np.pi * damping * high_hz
    along = 2 * np.pi * np.linspace(low_hz, high_hz, 40001)
    across = np.linspace(-side, side, 4001)
    path = np.concatenate([side + 1j * along, -across + 1j * along[-1], -side + 1j * along[::-1]])
    path = np.concatenate([path, across + 1j * along[0]])
    phase = np.unwrap(np.angle(response(path)))
    return round((phase[-1] - phase[0]) / (2 * np.pi)), side


@pytest.mark.parametrize("name", STRUCTURES)
def test_zeros_are_all_of_them_and_the_response_vanishes_there(name):
    structure = as_measured(STRUCTURES[name](), MEASURED)
    low, high = structure.band_hz
    for row in range(len(structure.sensors)):
        freq, damping = structure.zeros(row)
        s = 2 * np.pi * freq * (np.sqrt(1 - damping**2) * 1j - damping)
        w = 2 * np.pi * structure.freq_hz[:, None]
        parts = (structure.sensors[row] * structure.force)[:, None] * (
            s**2 / (s**2 + 2 * structure.damping[:, None] * w * s + w**2)
        )
        assert np.all(np.abs(parts.sum(axis=0)) < 1e-6 * np.abs(parts).sum(axis=0))
        count, side = winding(structure, row, low, high, 0.02)
        inside = np.abs(s.real) < side
        assert np.sum(inside & (s.imag > 2 * np.pi * low) & (s.imag < 2 * np.pi * high)) - np.sum(
            (structure.freq_hz > low) & (structure.freq_hz < high)
        ) == pytest.approx(count)


def test_bound_is_the_scatter_of_the_best_fit():
    """Two channels with one zero each and known smooth factors, noise drawn anew, fitted by least squares."""
    modes = np.array([8.0, 30.0]), np.full(2, 0.01), np.array([[1.0, 1.0], [1.0, -0.6]]), np.ones(2)
    structure = ModalStructure("two masses", *modes, np.ones((1, 2)), 0, (5.0, 50.0), 128.0)
    zeros = [structure.zeros(row) for row in range(2)]
    assert zeros[0][0].size == 1  # and none of the other near it
    low, high = zeros[0][0][0] / 1.25, zeros[0][0][0] * 1.25
    freq = np.linspace(low, high, 300)
    noise = np.array([1e-4, 4e-4])
    bound = cramer_rao(structure, zeros, np.ones(300), noise, freq)[0]
    clean = structure.accelerance(freq)
    z0 = zeros[0][0][0] * (np.sqrt(1 - zeros[0][1][0] ** 2) + 1j * zeros[0][1][0])
    t = (freq - 0.5 * (low + high)) / (0.5 * (high - low))
    ratio = clean[0] / (freq - z0) / clean[1]
    rng = np.random.default_rng(0)
    found = []
    for _ in range(150):
        x = clean + np.sqrt(noise / 2)[:, None] * (rng.standard_normal((2, 300, 2)) @ [1, 1j])

        def left(p, x=x):
            q = p.view(complex)
            model = ratio * (freq - z0 - q[0]) * (1 + q[1] + q[2] * t + q[3] * t**2)
            off = (x[0] - model * x[1]) / np.sqrt(noise[0] + np.abs(model) ** 2 * noise[1])
            return off.view(float)

        found.append(scipy.optimize.least_squares(left, np.zeros(8)).x[0])
    assert np.std(found) == pytest.approx(bound[0], rel=0.2)


def test_same_seed_same_record_and_every_switch_does_something():
    structure = STRUCTURES["truss"]()
    assert np.array_equal(hit(structure, MEASURED, 3).samples, hit(structure, MEASURED, 3).samples)
    undisturbed = {make: make(structure, CLEAN, 3) for make in (ambient, hit)}
    for name in SWITCHES:
        level = only(name)
        if name in ("between", "rest_s", "clocks", "misplaced", "double"):
            level = replace(level, double=1.0 if name == "double" else 0.0)
        make = ambient if name == "second_force" else hit
        one, clean = make(structure, level, 3), undisturbed[make]
        assert not np.array_equal(one.samples, clean.samples) or one.fs_hz != clean.fs_hz


def test_ten_hits_know_more_than_one():
    structure = STRUCTURES["beam"]()
    records, truth = hits(structure, replace(CLEAN, misplaced=0.03), seed=1, count=5)
    one = np.concatenate(records[0].truth.bound_hz)
    assert np.concatenate(truth.bound_hz).size == pytest.approx(one.size, abs=2)
    assert np.median(np.concatenate(truth.bound_hz)) < 0.6 * np.median(one)
    assert all(np.all(s >= b) for s, b in zip(truth.std_hz, truth.bound_hz, strict=True))
