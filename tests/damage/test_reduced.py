"""Damage of large models: roots and answers of reduced models are those of the full one."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.campaign import some_of

N, GROUPS, NOISE = 96, 12, 2e-4
FORCE, SENSORS = 40, [5, 22, 40, 61, 80, 93]
LIMIT_HZ = 9.0


def of_springs(springs, masses):
    terms = []
    for group in np.array_split(np.arange(springs.size), GROUPS):
        term = np.zeros((masses.size, masses.size))
        for i in group:
            ends = [mass for mass in (i - 1, i) if 0 <= mass < masses.size]
            pair = springs[i] * np.array([[1.0, -1.0], [-1.0, 1.0]])
            term[np.ix_(ends, ends)] += pair[: len(ends), : len(ends)]
        terms.append(term)
    return ar.MatrixModel(sum(terms), np.diag(masses), stiffness_terms=terms)


def structure(seed=None, *, damaged=None):
    off_springs, off_masses = np.zeros(N), np.zeros(N)
    if seed is not None:
        rng = np.random.default_rng(seed)
        off_springs, off_masses = 0.02 * rng.standard_normal(N), 0.01 * rng.standard_normal(N)
    springs = 1e5 * (1.0 + off_springs)
    if damaged is not None:
        springs[np.array_split(np.arange(N), GROUPS)[damaged]] *= 0.6
    return of_springs(springs, 1.0 + off_masses)


def measured(model, seed, sensors=SENSORS, force=FORCE):
    rng = np.random.default_rng([seed, 1])
    zeros = model.antiresonances(sensors, force, f_max_hz=LIMIT_HZ)
    noisy = [np.sort(f * (1.0 + NOISE * rng.standard_normal(f.size))) for f in zeros]
    std = {dof: NOISE * f for dof, f in zip(sensors, noisy, strict=True)}
    return ar.AntiresonanceSet(force, dict(zip(sensors, noisy, strict=True)), std_hz=std)


@pytest.mark.parametrize(("seed", "hit"), some_of([(11, 8), (12, None)]))
def test_the_answer_is_that_of_the_full_model(seed, hit):
    before, now = measured(structure(seed), seed), measured(structure(seed, damaged=hit), seed + 100)
    ways = (ar.SearchOptions(reduction=how) for how in (True, False))
    reduced, full = (ar.assess_damage(structure(), now, baseline=before, search=how) for how in ways)
    assert full.reduction is None
    assert reduced.reduction.agreed
    assert reduced.reduction.difference <= 1e-6
    assert 5 < reduced.reduction.size < N
    assert any("reduced model" in note for note in reduced.notes)
    assert reduced.hypotheses[0].elements == full.hypotheses[0].elements == (() if hit is None else (hit,))
    assert reduced.x == pytest.approx(full.x, abs=2e-3)
    if hit is not None:
        assert reduced.severity[hit] == pytest.approx(0.4, abs=0.02)
    assert reduced.probability_of_damage == pytest.approx(full.probability_of_damage, abs=0.02)
