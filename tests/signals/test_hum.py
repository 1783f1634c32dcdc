"""Mains hum in simulated records: found, told, and without a trace in the values; no mode is taken for it."""

import dataclasses

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from antires_rs.signals.hum import without_hum
from reference import faults, nothing_to_find, structures
from tests.support.campaign import some_of

BAND = (3.0, 130.0)


def responses(one, kind, seed):
    if kind == "hit":
        return nothing_to_find.hit(one, seed)
    return one.record(noise=0.01, seed=seed, duration_s=60.0).responses


HUMMING = [("random_chain", 1, "hit", 0.05), ("random_chain", 4, "random", 0.3)]
HUMMING += [("full_stiffness", 3, "hit", 0.05)]
LEVELS = (("hit", 0.05), ("random", 0.05), ("random", 0.3))
MORE = [
    (name, n, *each) for name in ("random_chain", "full_stiffness") for n in range(11, 17) for each in LEVELS
]


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
@pytest.mark.parametrize(("family", "seed", "kind", "level"), some_of(HUMMING + MORE, 2))
def test_values_are_those_without_hum(family, seed, kind, level):
    """Or more that are right. Before, the first three had 13, 6, 6 at the hum, five "sure"."""
    one = getattr(structures, family)(seed)
    clean = responses(one, kind, seed)
    base = 50.03 if seed % 2 else 59.97
    added = faults.hum(*clean.shape, structures.FS_HZ, base, np.random.default_rng(seed))
    humming = clean + level * clean.std(axis=1).mean() * added
    before, after = (
        ar.identify_antiresonances(ar.Recording(x, structures.FS_HZ), excitation=0, band_hz=BAND)
        for x in (clean, humming)
    )
    assert not before.data_check.named("mains_hum")
    (told,) = after.data_check.named("mains_hum")
    assert f"{round(base)}" in told.text
    lost, truth = 0, one.truth()
    for dof in before:
        known = np.r_[before[dof], truth[dof]]
        for value, grade in zip(after[dof], after.tables[dof].scores["grade"], strict=True):
            if np.abs(known / value - 1.0).min(initial=np.inf) > 0.01:
                assert grade == "weak"
                assert abs(value / base / max(1, round(value / base)) - 1.0) > 0.01  # not at the hum
        lost += before[dof].size - after[dof].size
    assert lost <= 1


@pytest.mark.parametrize("kind", ["hit", "random"])
def test_what_is_left_is_a_tenth(kind):
    clean = responses(structures.random_chain(1), kind, 1)
    added = faults.hum(*clean.shape, structures.FS_HZ, 50.03, np.random.default_rng(1))
    added *= 0.2 * clean.std(axis=1).mean()
    found, hum = without_hum(ar.Recording(clean + added, structures.FS_HZ), BAND)
    assert hum.freq_hz == (50.0, 100.0, 150.0)
    assert np.median(np.std(found.responses - clean, axis=1) / added.std(axis=1)) < 0.1


def with_a_mode_at(freq_hz, seed, damping_ratio):
    one = structures.random_chain(seed)
    modes = np.sqrt(np.maximum(scipy.linalg.eigvalsh(one.stiffness, one.mass), 0.0)) / (2 * np.pi)
    stiffness = one.stiffness * (freq_hz / modes[np.argmin(np.abs(modes - freq_hz))]) ** 2
    damping = structures.modal_damping_matrix(stiffness, one.mass, damping_ratio)
    return dataclasses.replace(one, stiffness=stiffness, damping=damping)


@pytest.mark.parametrize("kind", ["hit", "random"])
@pytest.mark.parametrize("damping_ratio", [0.001, 0.01])
def test_a_mode_at_a_multiple_is_no_hum(kind, damping_ratio):
    for seed in range(1, 5):
        at = (50.0, 60.0, 100.0, 120.0)[seed % 4] * 1.0003
        x = responses(with_a_mode_at(at, seed, damping_ratio), kind, seed)
        assert without_hum(ar.Recording(x, structures.FS_HZ), BAND)[1] is None
