"""Limits and the statistics below them, on draws whose laws are known."""

import numpy as np
import pytest
from scipy import stats

from antires_rs.watch.baseline import correlations, degrees_of, fitted, scores, variances
from antires_rs.watch.charts import chi_square, event_limit, upper_limit, wilson_hilferty


@pytest.mark.parametrize(("law", "n"), [("norm", 30), ("norm", 100), ("norm", 1000), ("t", 300)])
def test_a_further_one_exceeds_the_limit_at_the_rate(law, n):
    rng = np.random.default_rng(61)
    law = stats.norm() if law == "norm" else stats.t(4)
    above = np.mean([law.sf(upper_limit(law.rvs(n, random_state=rng), 0.01)) for _ in range(200)])
    assert 0.004 < above < 0.013


@pytest.mark.parametrize("p", [1, 5, 40])
def test_chi_squares_of_any_freedom_become_normal(p):
    freedom = np.array([float(p)])
    for level in (1.0, 2.5):
        t2 = chi_square(level, freedom)
        assert stats.chi2.sf(t2[0], p) == pytest.approx(stats.norm.sf(level), rel=0.2)
        assert wilson_hilferty(t2, freedom)[0] == pytest.approx(level)


def test_scores_are_normal_deviates():
    rng = np.random.default_rng(63)
    rest = rng.standard_t(4, (400, 30)) * np.geomspace(1e-4, 1e-2, 30)
    assert degrees_of(rest) in (3.0, 4.0, 5.0)
    assert np.isinf(degrees_of(rng.standard_normal((400, 30))))
    z = scores(rest / np.sqrt(variances(rest, np.full(30, np.nan), 4.0, 0.0)), 4.0)
    assert z.std() == pytest.approx(1.0, abs=0.05)
    assert stats.kurtosis(z.ravel()) == pytest.approx(0.0, abs=0.2)
    assert scores(np.array([3.0]), 4.0)[0] == pytest.approx(stats.norm.isf(stats.t.sf(3.0, 4)))


def test_correlations_of_few_tests_keep_what_is_shared():
    rng = np.random.default_rng(64)
    z = 2.0 * rng.standard_normal((25, 1)) + rng.standard_normal((25, 40))
    z /= np.sqrt(5.0)
    found, factors = correlations(z)
    assert factors.shape[1] >= 1
    assert np.linalg.eigvalsh(found).min() > 0.01
    assert found[~np.eye(40, dtype=bool)].mean() == pytest.approx(0.8, abs=0.12)
    independent, none = correlations(rng.standard_normal((25, 40)))
    assert none.shape[1] == 0
    assert np.abs(independent - np.eye(40)).max() < 0.25


def test_lines_in_spite_of_wild_points_and_gaps():
    rng = np.random.default_rng(65)
    t = rng.uniform(-1, 1, 80)
    y = 3.0 + np.outer(t, [0.1, -0.2]) + 0.01 * rng.standard_normal((80, 2))
    y[::16] += 5.0
    y[3::9, 1] = np.nan
    found = fitted(y, np.stack([np.ones(80), t], axis=1))
    assert found.coefficients[0] == pytest.approx([3.0, 3.0], abs=0.01)
    assert found.coefficients[1] == pytest.approx([0.1, -0.2], abs=0.015)


def test_short_baselines_want_more_than_one_event():
    assert event_limit(np.zeros(60), 60, 0.002) > np.log(61.0)
    assert event_limit(np.zeros(4000), 4000, 0.002) < np.log(4001.0)
