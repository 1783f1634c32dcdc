"""Temperature and other conditions: taken off, measured with errors, missing, out of range, or not known."""

import numpy as np
import pytest

import antires_rs as ar
from tests.watch.drawn_tests import chain, drawn, exact

PER_K = -1.5e-3  #: Change of all springs for a degree: 6 % over 40 K.


def weather(temperature_c, rng, *, loss=0.0, bend=None, **options):
    """Tests at these temperatures; below ``bend`` springs change three times as much."""
    sets = []
    usual = exact(chain(loss))
    for t in temperature_c:
        change = PER_K * t if bend is None or t > bend else PER_K * (bend + 3.0 * (t - bend))
        # All springs change alike, and frequencies as their root.
        sets.append(drawn({dof: f * np.sqrt(1.0 + change) for dof, f in usual.items()}, rng, **options))
    return sets


@pytest.fixture(scope="module")
def season():
    rng = np.random.default_rng(31)
    true = rng.uniform(0.0, 20.0, 200)
    sets = weather(true[:160], rng) + weather(true[160:], rng, loss=0.01)
    return sets, true + 0.3 * rng.standard_normal(200)


def test_temperature_is_taken_off_and_what_does_not_matter_is_not_used(season):
    sets, measured = season
    conditions = {"temperature_c": measured, "wind": np.random.default_rng(32).random(200)}
    conditions |= {"hour": np.arange(200.0), "still": 0 * measured}
    watched = ar.monitor(sets, baseline=80, conditions=conditions)
    assert watched.used[0] == "temperature_c"
    assert {"hour", "still"}.isdisjoint(watched.used)
    assert not watched.bends
    assert watched.alarm[160:].all()


def test_the_rate_holds_with_a_thermometer_that_errs():
    alarms = []
    for seed in (35, 36):
        rng = np.random.default_rng(seed)
        true = rng.uniform(0.0, 20.0, 160)
        measured = true + 0.3 * rng.standard_normal(160)
        watched = ar.monitor(weather(true, rng), baseline=80, conditions={"temperature_c": measured})
        alarms.append(watched.alarm[80:])
    assert np.mean(alarms) < 0.02


def test_without_any_condition_what_values_share_is_taken_off(season):
    watched = ar.monitor(season[0], baseline=80)
    assert watched.used == ()
    assert watched.alarm[80:160].sum() <= 3
    assert watched.alarm[160:].mean() > 0.9


def test_a_temperature_that_is_missing(season):
    sets, measured = season
    unknown = np.arange(200) % 7 == 3
    watched = ar.monitor(sets, baseline=80, conditions={"temperature_c": np.where(unknown, np.nan, measured)})
    assert watched.alarm[80:160][unknown[80:160]].sum() <= 1
    assert watched.alarm[160:].mean() > 0.95


def test_outside_the_range_is_told_and_allowed_for():
    rng = np.random.default_rng(33)
    cold, warm = rng.uniform(-5.0, 5.0, 100), np.linspace(20.0, 35.0, 60)
    sets = weather(cold, rng) + weather(warm, rng) + weather(warm, rng, loss=0.02)
    measured = np.concatenate([cold, warm, warm]) + 0.3 * rng.standard_normal(220)
    watched = ar.monitor(sets, baseline=100, conditions={"temperature_c": measured})
    assert np.flatnonzero(watched.outside).tolist() == list(range(100, 220))
    assert "baseline does not have" in str(watched)
    assert watched.alarm[100:160].sum() <= 3
    assert watched.alarm[160:].mean() > 0.8


def test_a_line_that_bends():
    rng = np.random.default_rng(34)
    true = rng.uniform(-15.0, 25.0, 180)
    watched = ar.monitor(weather(true, rng, bend=3.0), baseline=120, conditions={"temperature_c": true})
    assert list(watched.bends) == ["temperature_c"]
    assert watched.alarm[120:].sum() <= 3
    assert "bent at" in str(watched)


def test_a_day_number_is_a_clock():
    rng = np.random.default_rng(38)
    day = np.repeat(np.arange(20.0), 6)
    falling = np.concatenate([np.zeros(60), np.linspace(0.0, 0.01, 60)])
    sets = [drawn(exact(chain(loss)), rng) for loss in falling]
    for column in (day, -day):
        watched = ar.monitor(sets, baseline=60, conditions={"day": column})
        assert watched.clocks == ("day",)
        assert watched.alarm[110:].all()
        assert "not used, since it only grows or falls with the tests: day" in str(watched)


def test_a_reading_that_no_weather_makes_is_not_known(season):
    sets, measured = season[0][100:175], season[1][100:175]
    wrong, missing = measured.copy(), measured.copy()
    wrong[65:], missing[65:] = 1e9, np.nan
    wrong[62], missing[62] = -999.0, np.nan
    one, other = (ar.monitor(sets, baseline=55, conditions={"temperature_c": t}) for t in (wrong, missing))
    assert np.array_equal(one.statistic, other.statistic)
    assert one.alarm[65:].all()
    assert one.outside[65:].all()
