"""A response that a test did not measure tells nothing: its roots are not missed."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.likelihood import Band, Foreseen, associated
from antires_rs.damage.measured_states import Values
from tests.support.wrong_chains import NOMINAL, chain, measured, truth


def roots(response, place):
    size = len(place)
    return Foreseen(
        np.array(response),
        np.array(place),
        np.zeros(size),
        1e-6 * np.eye(size),
        np.zeros(size),
        np.empty((size, 0)),
        np.ones(size, dtype=bool),
    )


def test_roots_of_other_responses_cost_nothing():
    values = Values(np.array([0, 0]), np.array([1.0, 2.0]), np.full(2, 1e-3), np.zeros(2, dtype=int))
    band = Band(0.0, 4.0)
    alone = associated(values, roots([0, 0, 0], [1.0, 2.0, 3.0]), band, np.full(3, 1e-3), 1.0)
    beside = associated(
        values, roots([0, 0, 0, 1, 1], [1.0, 2.0, 3.0, 1.5, 2.5]), band, np.full(5, 1e-3), 1.0
    )
    assert beside[2] == alone[2]


def test_a_root_is_missed_once_in_each_test_of_its_response():
    """Two tests with the force at one dof, one of which lacks response 1."""
    band, expected = Band(0.0, 4.0), roots([0, 1], [1.0, 2.0])
    values = Values(np.array([0, 0]), np.array([3.0, 3.0]), np.full(2, 1e-3), np.arange(2))
    both = Values(np.array([0, 1, 0]), np.full(3, 3.0), np.full(3, 1e-3), np.array([0, 0, 1]))
    missed = -np.log(0.03)
    lost = band.alone
    assert associated(values, expected, band, np.full(2, 1e-3), 1.0)[2] == pytest.approx(2 * (missed + lost))
    assert associated(both, expected, band, np.full(2, 1e-3), 1.0)[2] == pytest.approx(3 * (missed + lost))


def test_a_response_without_a_value_was_measured():
    """Its roots were looked for and not found."""
    band, expected = Band(0.0, 4.0), roots([0, 1], [1.0, 2.0])
    values = [np.array([0]), np.array([1.0]), np.full(1, 1e-3), np.zeros(1, dtype=int)]
    alone, looked = (Values(*values, asked=asked) for asked in (None, np.array([[0, 0], [1, 0]])))
    prices = [associated(each, expected, band, np.full(2, 1e-3), 1.0)[2] for each in (alone, looked)]
    assert prices[1] - prices[0] == pytest.approx(-np.log(0.03))


@pytest.fixture(scope="module")
def lacking():
    """An assessor, a test, and the same without what was measured at masses 1 to 4."""
    rng, factors = truth(621)
    before = measured(chain(factors), rng)
    now = measured(chain(factors, (0, 0, 0.85, 0, 0)), rng)
    few = [
        ar.AntiresonanceSet(
            each.excitation, {d: each[d] for d in (0, 5)}, std_hz={d: each.std_hz[d] for d in (0, 5)}
        )
        for each in now
    ]
    return ar.Assessor(NOMINAL, baseline=before, workers=1), before, few


def test_the_assessor_prices_them_as_a_full_run(lacking):
    assessor, before, few = lacking
    full = ar.assess_damage(NOMINAL, few, baseline=before, workers=1)
    quick = assessor.assess(few)
    assert [each.elements for each in quick.hypotheses[:1]] == [each.elements for each in full.hypotheses[:1]]
    assert quick.probability[2] == pytest.approx(full.probability[2], abs=0.02)
