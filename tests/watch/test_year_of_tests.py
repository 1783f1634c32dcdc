"""The simulated year: every hour can be made alone, and is what it is said to be."""

import numpy as np

from reference import year_of_tests as year


def test_an_hour_is_the_same_alone_and_among_others():
    (_, among, conditions), *_ = list(year.hours([7, 8]))
    alone, beside = year.hour_of_tests(7)
    np.testing.assert_array_equal(among.responses, alone.responses)
    assert conditions == beside


def test_temperature_moves_the_stiffness_by_three_per_cent():
    hours = np.arange(year.HOURS)
    temperatures = year.true_temperature_c(hours)
    springs = [-np.diag(year.structure(t, False)[0], 1) for t in (temperatures.min(), temperatures.max())]
    moved = 1.0 - springs[1] / springs[0]
    assert 0.015 < moved.min() < 0.025 < moved.max() < 0.031
    measured = np.array([year.conditions_of(h)["temperature_c"] for h in range(0, 8760, 30)])
    error = measured - temperatures[::30]
    assert 0.3 < error.std() < 0.5


def test_two_per_cent_of_the_sensors_are_out():
    out = np.array([len(year.dropped(h)) for h in range(0, 8760, 10)])
    assert 0.015 < out.mean() / 8 < 0.025


def test_the_damage_is_that_of_one_element_from_day_300_on():
    assert [bool(year.is_damaged(h)) for h in (0, 7199, 7200, 8759)] == [False, False, True, True]
    intact, damaged = (-np.diag(year.structure(10.0, d)[0], 1) for d in (False, True))
    lost = 1.0 - damaged / intact
    np.testing.assert_allclose(lost, [0, 0, 0, 0, 1.5 * year.A90, 0, 0], atol=1e-12)
