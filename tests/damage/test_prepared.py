"""What the core makes of the tables is what the likelihood of a full run says there."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.assessor_plan import LEVELS, values_of
from antires_rs.damage.assessor_search import QuickSearch
from antires_rs.damage.evidence import fitted
from antires_rs.damage.likelihood import Band
from antires_rs.damage.question import Question
from tests.support.wrong_chains import NOMINAL, chain, measured, truth


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
    asked = plan.question
    question = Question(
        NOMINAL, tuple(before), tuple(now), asked.elements, asked.prior, asked.options, reduced=asked.reduced
    )
    likelihood = question.prepared(1).likelihood
    values, *_ = values_of(now, plan.expected, plan.learned.scatter)
    low, high = float(values.log_f.min()), float(values.log_f.max())
    search = QuickSearch(
        plan.interpolated,
        values,
        Band(min(plan.learned.low, low), max(plan.learned.high, high)),
        asked.options.std_common,
        plan.errors,
        plan.learned.outside,
        len(plan.numbers),
        len(asked.elements),
        asked.prior,
        plan.pairs,
    )
    return search, likelihood, plan


@pytest.mark.parametrize("level", [0, 2, 5, 9])
def test_at_a_level_the_view_is_that_of_the_likelihood(both, level):
    search, likelihood, _ = both
    elements = (1,) if level else ()
    u = LEVELS[[level]] if level else np.empty(0)
    view = search.view(elements, u)
    full = likelihood.views(search.beta(elements, u)[None])[0]
    assert np.array_equal(view.partner >= 0, full.partner >= 0)
    # Tables are in single precision but for the places.
    assert view.log_likelihood == pytest.approx(full.log_likelihood, rel=1e-4, abs=1e-2)
    assert view.chi_square == pytest.approx(full.chi_square, rel=1e-4)
    np.testing.assert_allclose(view.gain, full.gain, rtol=1e-3, atol=1e-3 * np.abs(full.gain).max())
    np.testing.assert_allclose(
        view.curvature, full.curvature, rtol=1e-3, atol=1e-4 * np.abs(full.curvature).max()
    )
    assert (view.kappa, view.times) == pytest.approx((full.kappa, full.times))


def test_two_severities_are_near_the_likelihood(both):
    """Between levels, with the exact roots in place of those of the tables."""
    search, likelihood, plan = both
    u = -np.log1p(-np.array([0.4, 0.2]))
    beta = search.beta((1, 3), u)
    place, beside, there = search.test.places([1, 3], u.tolist())
    exact, slopes = plan.exact(beta, search.band, slopes=True)
    place = np.where(np.isfinite(exact), exact + beside, place)
    view = search.view((1, 3), u, place.tolist(), there.tolist(), slopes)
    full = likelihood.views(beta[None])[0]
    assert np.array_equal(view.partner >= 0, full.partner >= 0)
    # A fifth of what tells two hypotheses apart: errors of the model are interpolated still.
    assert view.log_likelihood == pytest.approx(full.log_likelihood, abs=0.2)


@pytest.mark.parametrize("elements", [(1,), (1, 3), (0, 2, 4)])
def test_the_evidence_is_that_of_the_full_run(both, elements):
    search, _, _ = both
    u = np.linspace(0.02, 0.5, len(elements))
    settled = search.test.settle([(list(elements), u.tolist())], 1, 0.0, True)[0]
    fit = fitted(search.view(elements, u), elements, reach=np.inf)
    at, ahead, mean, covariance, log_evidence, log_likelihood = settled
    assert at == u.tolist()
    assert log_likelihood == pytest.approx(fit.view.log_likelihood, abs=1e-9)
    assert log_evidence == pytest.approx(fit.log_evidence, abs=5e-3)
    np.testing.assert_allclose(-np.expm1(-np.array(ahead)), fit.beta, atol=1e-8)
    np.testing.assert_allclose(mean, fit.mean, rtol=1e-8)
    np.testing.assert_allclose(np.reshape(covariance, fit.covariance.shape), fit.covariance, rtol=1e-6)


@pytest.mark.parametrize("parent", [(), (1,), (0, 4)])
def test_a_scan_is_the_distance_from_the_nearest_roots(both, parent):
    search, _, _ = both
    tables, now = search.tables.tables, search.now
    u = np.full(len(parent), 0.25)
    distance, _ = search.test.scan(list(parent), u.tolist(), [2, 3])
    for nth, e in enumerate((2, 3)):
        for level in (1, 6):
            elements = tuple(sorted((*parent, e)))
            joined = [float(LEVELS[level]) if x == e else 0.25 for x in elements]
            place, _, there = search.test.places(list(elements), joined)
            nearest = [
                min(
                    (
                        abs(f - p)
                        for p, r, t in zip(place, tables.response, there, strict=True)
                        if t and r == own
                    ),
                    default=np.inf,
                )
                for f, own in zip(now.log_f, now.response, strict=True)
            ]
            assert distance[nth, level] == pytest.approx(np.minimum(nearest, 0.2).sum(), abs=1e-6)


def test_the_search_finds_both_damages(both):
    search, _, _ = both
    search.run()
    best = max(search.fits, key=lambda s: search.weights[s])
    assert best == (1, 3)
    np.testing.assert_allclose(search.fit(best).beta, [0.4, 0.2], atol=0.03)
