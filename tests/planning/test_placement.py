"""Sensors chosen, against all sets; and the information of a set, against the core asked for that set."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.measured_states import roots_at
from antires_rs.models.parameters import stiffness_reduction
from antires_rs.planning.placement import (
    CRITERIA,
    ExpectedErrors,
    exhaustive,
    greedy,
    information,
    objective,
    virtual_roots,
)
from reference.structures import CHAIN8_MASSES, CHAIN8_SPRINGS
from reference.symmetric_structures import cases

ERRORS = ExpectedErrors(0.01, 200.0, 0.01, 5e-4)
#: Exchanges of two were brought in on the symmetric nine-mass chain; none of these was looked at before.
KINDS = {
    "portal": "3 storeys of 2, corner",
    "grillage": "5 x 3, 1 x 0.5 m, corners held",
    "ring": "12 masses, 2 held",
}
SPREAD = 0.07


def random_chain(seed):
    rng = np.random.default_rng([seed, 77])
    masses = np.repeat(CHAIN8_MASSES[1], 11) * rng.uniform(0.5, 1.5, 11)
    return ar.MassSpringChain(masses, np.repeat(CHAIN8_SPRINGS[0], 10) * rng.uniform(0.5, 1.5, 10))


def setting(name):
    """Model, twelve candidates at most, force, end of the band."""
    if name in KINDS:
        case = next(one for one in cases() if one.kind == name and one.name == KINDS[name])
        return case.build(SPREAD), list(case.sensors)[:12], case.excitation, case.band_hz[1]
    return random_chain(int(name)), list(range(11)), 3, 200.0


def told(name, sees="transmissibility", symmetric=False):
    model, sensors, force, high = setting(name)
    if symmetric:
        model = next(one for one in cases() if one.name == KINDS[name]).build(0.0)
    parameters = tuple(stiffness_reduction(model.default_elements))
    start = np.zeros(len(parameters))
    roots = virtual_roots(model, parameters, start, sensors, force, (1.0, high), sees, ERRORS, 1)
    return model, sensors, force, high, information(roots, len(sensors), np.ones(start.size), 2)


@pytest.mark.parametrize("criterion", CRITERIA)
@pytest.mark.parametrize("name", ["1", "2", *KINDS])
def test_greedy_is_within_two_per_cent_of_the_best_of_all_sets(name, criterion):
    found = told(name)[-1]
    best, ours = exhaustive(found, 4, criterion), greedy(found, 4, criterion)
    assert ours.worth <= best.worth + 1e-9
    # Nats add up; of the worst element e to the minus worth is the size of what it hides.
    if criterion == "determinant":
        assert ours.worth >= 0.98 * best.worth
    else:
        assert ours.worth >= best.worth - 0.02


@pytest.mark.parametrize(
    ("name", "symmetric"),
    [("1", False), ("portal", False), ("portal", True), ("ring", False), ("ring", True)],
)
def test_the_information_of_a_set_is_that_of_the_roots_the_core_shows_of_it(name, symmetric):
    model, sensors, force, high, found = told(name, symmetric=symmetric)
    parameters = tuple(stiffness_reduction(model.default_elements))
    rng = np.random.default_rng(3)
    for _ in range(6):
        chosen = sorted(rng.choice(len(sensors), 3, replace=False).tolist())
        core = objective(model, parameters, [sensors[c] for c in chosen], force, high, "transmissibility")
        roots = roots_at(core, np.zeros((1, len(parameters))), slopes=True, threads=1)[0]
        kept = (np.exp(roots.log_f) > 1.0) & (np.abs(roots.slopes).max(axis=1) < 3.0)
        rows = roots.slopes[kept] / (np.sqrt(2.0) * 5e-4)
        np.testing.assert_allclose(
            found.of(chosen), rows.T @ rows, rtol=1e-6, atol=1e-6 * np.trace(rows.T @ rows)
        )
