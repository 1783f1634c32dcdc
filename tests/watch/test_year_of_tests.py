"""The simulated year: every hour can be made alone, and is what it is said to be."""

import numpy as np

from reference import year_of_tests as year


def test_an_hour_is_the_same_alone_and_among_others():
    (_, among, conditions), *_ = list(year.hours([7, 8]))
    alone, beside = year.hour_of_tests(7)
    np.testing.assert_array_equal(among.responses, alone.responses)
    assert conditions == beside


def test_temperature_sensors_and_damage_are_as_said():
    temperatures = year.true_temperature_c(np.arange(year.HOURS))
    ends = ((temperatures.min(), False), (temperatures.max(), False), (10.0, False), (10.0, True))
    cold, warm, intact, damaged = (-np.diag(year.structure(*end)[0], 1) for end in ends)
    moved = 1.0 - warm / cold
    assert 0.015 < moved.min() < 0.025 < moved.max() < 0.031
    measured = np.array([year.conditions_of(h)["temperature_c"] for h in range(0, 8760, 30)])
    assert 0.3 < (measured - temperatures[::30]).std() < 0.5
    out = np.array([len(year.dropped(h)) for h in range(0, 8760, 10)])
    assert 0.015 < out.mean() / 8 < 0.025
    # From day 300 on, of one element.
    assert [bool(year.is_damaged(h)) for h in (0, 7199, 7200, 8759)] == [False, False, True, True]
    np.testing.assert_allclose(1.0 - damaged / intact, [0, 0, 0, 0, 1.5 * year.A90, 0, 0], atol=1e-12)
