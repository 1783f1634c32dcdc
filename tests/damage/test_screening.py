"""Many candidate elements: a scan looks at those that explain most to first order."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

import antires_rs as ar
from antires_rs.damage.inference import worth_a_scan


def view_of(gain):
    return SimpleNamespace(gain=gain, curvature=np.eye(gain.size))


def test_few_elements_are_all_scanned():
    assert worth_a_scan(view_of(np.ones(60)), list(range(60)), 1) is None


def test_of_many_those_that_gain_most_are():
    gain = np.zeros(100)
    gain[[7, 50, 93]] = 3.0, 1.0, 2.0
    gain[20] = -9.0  # stiffer, which no damage is
    chosen = worth_a_scan(view_of(gain), list(range(100)), 2)
    assert {7, 50, 93} <= set(chosen)
    assert 20 not in chosen
    assert chosen == sorted(chosen)
    assert len(chosen) < 20


def test_one_damage_among_many_elements_is_found():
    # The structure is off the model by 1 % in each spring, and both states have noise.
    rng = np.random.default_rng(31)
    n, hit = 81, 52
    model = ar.MassSpringChain(np.ones(n), np.full(n - 1, 1e6), ground_first_n_per_m=1e6)
    factors = ar.stiffness_factor(range(n - 1), bounds=(0.5, 1.5))
    structure = model.with_parameters(factors, 1.0 + 0.01 * rng.standard_normal(n - 1))
    damaged = structure.with_parameters(ar.stiffness_reduction(hit), 0.5)
    sensors = [22, 60, 80]

    def measured(tested):
        zeros = tested.antiresonances(sensors, 80, f_max_hz=45.0)
        noisy = [np.sort(f * (1.0 + 2e-4 * rng.standard_normal(f.size))) for f in zeros]
        stds = {dof: 2e-4 * f for dof, f in zip(sensors, noisy, strict=True)}
        return ar.AntiresonanceSet(80, dict(zip(sensors, noisy, strict=True)), std_hz=stds)

    before, now = measured(structure), measured(damaged)
    result = ar.assess_damage(model, now, baseline=before)
    assert hit in result.assessment.declared
    assert abs(result.severity[hit] - 0.5) < 0.1
