"""The simulator of measured records itself: zeros, their standard deviations, switches, determinism."""

from dataclasses import replace

import numpy as np
import pytest

from reference.measured_reality import CLEAN, MEASURED, SWITCHES, ambient, as_measured, hit, only
from reference.modal_structures import STRUCTURES


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
