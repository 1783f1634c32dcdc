"""Laws that hold for every structure, on models drawn by hypothesis."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import antires_rs as ar
from tests.support.tolerances import DIP, LAW

FEW = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)


@st.composite
def chains(draw):
    n = draw(st.integers(2, 8))
    masses = draw(st.lists(st.floats(0.5, 2.0), min_size=n, max_size=n))
    springs = draw(st.lists(st.floats(5e3, 2e4), min_size=n - 1, max_size=n - 1))
    ground = draw(st.floats(5e3, 2e4)) if draw(st.booleans()) else 0.0
    return ar.MassSpringChain(masses, springs, ground_first_n_per_m=ground)


@FEW
@given(chains(), st.integers(0, 7))
def test_driving_point_zeros_interlace_the_resonances(model, dof):
    dof %= model.n_dof
    zeros = model.antiresonances(dof, dof, include_cancelled=True)
    resonances = model.modes().freq_hz
    assert zeros.size == model.n_dof - 1
    slack = 1.0 + LAW
    assert np.all(resonances[:-1] <= zeros * slack)
    assert np.all(zeros <= resonances[1:] * slack)


@FEW
@given(chains(), st.integers(0, 7), st.integers(0, 7))
def test_antiresonances_are_zeros_of_the_undamped_frf(model, i, k):
    i, k = i % model.n_dof, k % model.n_dof
    zeros = model.antiresonances(i, k)
    resonances = model.modes().freq_hz
    for zero in zeros:
        if np.abs(resonances / zero - 1.0).min() < 0.02:
            continue  # too near a pole to tell
        aside = model.frf(i, k, zero * np.array([0.99, 1.0, 1.01]), damping_ratio=0.0, kind="receptance")
        assert abs(aside[1]) <= DIP * min(abs(aside[0]), abs(aside[2]))


# ---- the objective ----------------------------------------------------------------------------------
CASE = ar.cases.chain8()
DAMAGE = CASE.damage_problem()
UPDATING = CASE.updating_problem(ar.cases.chain8(perturbation=0.08, rng=3).exact())
severities = st.lists(st.one_of(st.just(0.0), st.just(0.99), st.floats(0.0, 0.99)), min_size=7, max_size=7)
factors = st.lists(st.one_of(st.just(0.9), st.just(1.1), st.floats(0.9, 1.1)), min_size=15, max_size=15)


@FEW
@given(factors, st.randoms(use_true_random=False))
def test_pairing_does_not_depend_on_the_order_of_the_measured_values(x, random):
    exact = dict(UPDATING.measured[0])
    dofs = list(exact)
    random.shuffle(dofs)
    shuffled = {dof: random.sample(list(exact[dof]), len(exact[dof])) for dof in dofs}
    other = CASE.updating_problem(ar.AntiresonanceSet(0, shuffled))
    assert other.cost(x) == pytest.approx(UPDATING.cost(x), rel=LAW)

    def pairs(problem):
        keys = zip(problem.measured_dofs, problem.measured_hz, strict=True)
        return dict(zip(keys, problem.paired_hz(x), strict=True))

    assert pairs(other) == pairs(UPDATING)
