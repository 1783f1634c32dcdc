"""What the core makes of the tables is what the likelihood of a full run says there."""

from dataclasses import replace

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.assessor_plan import LEVELS, values_of
from antires_rs.damage.assessor_search import QuickSearch, TabulatedLikelihood
from antires_rs.damage.evidence import refitted
from tests.support.wrong_chains import NOMINAL, N, chain, measured, truth


def without(sets, dofs):
    """The sets without some responses."""
    return [
        ar.AntiresonanceSet(
            one.excitation,
            {dof: one[dof] for dof in one if dof not in dofs},
            std_hz={dof: one.std_hz[dof] for dof in one if dof not in dofs},
        )
        for one in sets
    ]


@pytest.fixture(scope="module", params=[(), (1, 3)], ids=["all measured", "two responses lacking"])
def both(request):
    """A search in the tables, and the likelihood of a full run for the same test."""
    rng, factors = truth(401)
    before = measured(chain(factors), rng)
    now = without(measured(chain(factors, (0, 0.4, 0, 0.2, 0)), rng), request.param)
    plan = ar.Assessor(NOMINAL, baseline=before, workers=1)._plan
    full = replace(plan.question, measured=tuple(now)).prepared(1).likelihood
    values, *_ = values_of(now, plan.expected, plan.learned.scatter)
    return TabulatedLikelihood(plan, values), full


def row(tables, elements, u):
    beta = np.zeros((1, tables.n))
    beta[0, list(elements)] = -np.expm1(-np.asarray(u))
    return beta


@pytest.mark.parametrize("level", [0, 2, 5, 9])
def test_at_a_level_the_view_is_that_of_the_likelihood(both, level):
    tables, likelihood = both
    elements = (1,) if level else ()
    u = LEVELS[[level]] if level else np.empty(0)
    view, full = tables.seen(elements, u), likelihood.views(row(tables, elements, u))[0]
    assert np.array_equal(view.partner >= 0, full.partner >= 0)
    # Tables are in single precision but for the places.
    assert view.log_likelihood == pytest.approx(full.log_likelihood, rel=1e-4, abs=1e-2)
    assert view.chi_square == pytest.approx(full.chi_square, rel=1e-4)
    np.testing.assert_allclose(view.gain, full.gain, rtol=1e-3, atol=1e-3 * np.abs(full.gain).max())
    np.testing.assert_allclose(
        view.curvature, full.curvature, rtol=1e-3, atol=1e-4 * np.abs(full.curvature).max()
    )
    assert (view.kappa, view.times) == pytest.approx((full.kappa, full.times))


def test_computed_roots_are_near_the_likelihood(both):
    """Of two severities between levels, and of changes that are no damage."""
    tables, likelihood = both
    beta = row(tables, (1, 3), -np.log1p(-np.array([0.4, 0.2])))
    view, full = tables.views(beta)[0], likelihood.views(beta)[0]
    assert np.array_equal(view.partner >= 0, full.partner >= 0)
    # A fifth of what tells two hypotheses apart: errors of the model are interpolated still.
    assert view.log_likelihood == pytest.approx(full.log_likelihood, abs=0.2)
    assert tables.something_else == pytest.approx(likelihood.something_else, abs=0.5)


@pytest.mark.parametrize("elements", [(1,), (1, 3), (0, 2, 4)])
def test_the_evidence_is_that_of_the_full_run(both, elements):
    tables, _ = both
    u = np.linspace(0.02, 0.5, len(elements))
    settled = tables.test.settle([(list(elements), u.tolist())], 1, 0.0, True)[0]
    fit = refitted(tables.seen(elements, u), elements)
    at, ahead, mean, covariance, log_evidence, log_likelihood = settled
    assert at == u.tolist()
    assert log_likelihood == pytest.approx(fit.view.log_likelihood, abs=1e-9)
    assert log_evidence == pytest.approx(fit.log_evidence, abs=5e-3)
    np.testing.assert_allclose(-np.expm1(-np.array(ahead)), fit.beta, atol=1e-8)
    np.testing.assert_allclose(mean, fit.mean, rtol=1e-8)
    np.testing.assert_allclose(np.reshape(covariance, fit.covariance.shape), fit.covariance, rtol=1e-6)


@pytest.mark.parametrize("parent", [(), (1,), (0, 4)])
def test_a_scan_is_the_distance_from_the_nearest_roots(both, parent):
    tables, _ = both
    response, now = tables.plan.tables.response, tables.now
    u = np.full(len(parent), 0.25)
    distance, _ = tables.test.scan(list(parent), u.tolist(), [2, 3])
    for nth, e in enumerate((2, 3)):
        for level in (1, 6):
            elements = tuple(sorted((*parent, e)))
            joined = [float(LEVELS[level]) if x == e else 0.25 for x in elements]
            place, _, there = tables.test.places(list(elements), joined)
            nearest = [
                min(
                    (abs(f - p) for p, r, t in zip(place, response, there, strict=True) if t and r == own),
                    default=np.inf,
                )
                for f, own in zip(now.log_f, now.response, strict=True)
            ]
            assert distance[nth, level] == pytest.approx(np.minimum(nearest, 0.2).sum(), abs=1e-6)


def test_the_search_finds_both_damages(both):
    search = QuickSearch(both[0], N - 1)
    search.run()
    best = max(search.fits, key=lambda s: search.log_weights()[s])
    assert best == (1, 3)
    np.testing.assert_allclose(search.fits[best].beta, [0.4, 0.2], atol=0.03)
