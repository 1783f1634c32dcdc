"""Damage of large models: roots and answers of reduced models are those of the full one."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.likelihood import factors_of
from antires_rs.damage.measured_states import measured_states, roots_at
from antires_rs.damage.reduced_roots import ReducedRoots, Terms
from antires_rs.models.parameters import stiffness_reduction

N, GROUPS, NOISE = 96, 12, 2e-4
FORCE, SENSORS = 40, [5, 22, 40, 61, 80, 93]
LIMIT_HZ = 9.0


def of_springs(springs, masses):
    """A chain held at its first mass, its springs in groups of neighbours, as matrices and terms."""
    terms = []
    for group in np.array_split(np.arange(springs.size), GROUPS):
        term = np.zeros((masses.size, masses.size))
        for i in group:
            ends = [mass for mass in (i - 1, i) if 0 <= mass < masses.size]
            pair = springs[i] * np.array([[1.0, -1.0], [-1.0, 1.0]])
            term[np.ix_(ends, ends)] += pair[: len(ends), : len(ends)]
        terms.append(term)
    return ar.MatrixModel(sum(terms), np.diag(masses), stiffness_terms=terms)


def structure(seed=None, *, damaged=None, masses=N):
    """The model, or one with all springs and masses off by some percent; N - 1 masses: held at both ends."""
    off_springs, off_masses = np.zeros(N), np.zeros(masses)
    if seed is not None:
        rng = np.random.default_rng(seed)
        off_springs, off_masses = 0.02 * rng.standard_normal(N), 0.01 * rng.standard_normal(masses)
    springs = 1e5 * (1.0 + off_springs)
    if damaged is not None:
        springs[np.array_split(np.arange(N), GROUPS)[damaged]] *= 0.6
    return of_springs(springs, 1.0 + off_masses)


def measured(model, seed, sensors=SENSORS, force=FORCE):
    rng = np.random.default_rng([seed, 1])
    zeros = model.antiresonances(sensors, force, f_max_hz=LIMIT_HZ)
    noisy = [np.sort(f * (1.0 + NOISE * rng.standard_normal(f.size))) for f in zeros]
    std = {dof: NOISE * f for dof, f in zip(sensors, noisy, strict=True)}
    return ar.AntiresonanceSet(force, dict(zip(sensors, noisy, strict=True)), std_hz=std)


@pytest.fixture(scope="module")
def sources():
    """The core's roots and those of reduced models; how many elements and factors."""
    model = structure()
    found = measured(structure(3), 3)
    responses, _, _ = measured_states(model, (found,), (found,))
    elements, factors = list(range(GROUPS)), factors_of(model)
    parts = model.description.core_parameters((*stiffness_reduction(elements), *factors))
    full = responses.source(model, parts)
    terms = Terms(model, responses.parts, parts, elements, factors)
    return full, ReducedRoots(terms, full), terms


def at(losses, seed=5):
    factors = np.exp(0.05 * np.random.default_rng(seed).standard_normal(GROUPS))
    x = np.concatenate([np.zeros(GROUPS), factors])
    for element, beta in losses.items():
        x[element] = beta
    return x


@pytest.mark.parametrize(
    "losses", [{}, {3: 0.1}, {3: 0.4}, {7: 0.9}, {3: 0.4, 4: 0.6}, {0: 0.2, 5: 0.3, 11: 0.5}]
)
def test_roots_and_slopes_are_those_of_the_full_model(sources, losses):
    full, reduced, terms = sources
    x = at(losses)[None]
    ours = reduced.roots(x, True, 1)[0]
    exact = roots_at(full, x, slopes=True, threads=1, band_hz=terms.slopes_hz)[0]
    low, high = np.log(terms.measured_hz)
    one, other = (roots.only(roots.between(low, high)) for roots in (ours, exact))
    assert other.size > 15
    assert np.array_equal(one.response, other.response)
    assert np.abs(one.log_f - other.log_f).max() < 1e-5  # as the search needs them: noise is 2e-4
    assert np.abs(one.slopes - other.slopes).max() < 1e-3 * np.abs(other.slopes).max()


def test_a_settled_point_has_the_roots_of_the_full_model(sources):
    full, reduced, terms = sources
    x = at({3: 0.4})
    assert reduced.settle(x) <= 1e-6
    low, high = np.log(terms.measured_hz)
    both = reduced.roots(x[None], False, 1)[0], roots_at(full, x[None], slopes=False, threads=1)[0]
    one, other = (each.only(each.between(low, high)) for each in both)
    assert np.abs(one.log_f - other.log_f).max() <= 1e-6
    assert reduced.expected < 1e-4


@pytest.mark.parametrize(("seed", "hit"), [(11, 8), (12, None)])
def test_the_answer_is_that_of_the_full_model(seed, hit):
    before, now = measured(structure(seed), seed), measured(structure(seed, damaged=hit), seed + 100)
    reduced, full = (
        ar.assess_damage(
            structure(), now, baseline=before, search=ar.SearchOptions(reduction=how), progress=False
        )
        for how in (True, False)
    )
    assert full.reduction is None
    assert reduced.reduction.agreed
    assert reduced.reduction.difference <= 1e-6
    assert 5 < reduced.reduction.size < N
    assert any("reduced model" in note for note in reduced.notes)
    assert reduced.hypotheses[0].elements == full.hypotheses[0].elements == (() if hit is None else (hit,))
    assert reduced.x == pytest.approx(full.x, abs=2e-3)
    if hit is not None:
        assert reduced.severity[hit] == pytest.approx(0.4, abs=0.02)
    assert reduced.probability_of_damage == pytest.approx(full.probability_of_damage, abs=0.02)


def test_groups_that_cannot_be_told_apart_are_both_named():
    """Force and sensor in the middle: each group and its mirror images are one to them."""
    middle = (N - 1) // 2
    before, now = (
        measured(structure(damaged=hit, masses=N - 1), seed, [middle], middle)
        for hit, seed in ((None, 21), (3, 22))
    )
    found = ar.assess_damage(
        structure(masses=N - 1), now, baseline=before, search=ar.SearchOptions(reduction=True), progress=False
    )
    alike = {one.elements: one for one in found.hypotheses[:4]}
    twins = alike[3,], alike[GROUPS - 1 - 3,]
    assert all(0.1 < one.probability < 0.5 for one in twins)
    assert all(one.severities[0] == pytest.approx(0.4, abs=0.02) for one in twins)
    assert "cannot tell which" in found.headline
    assert found.reduction.agreed


def test_factors_that_may_not_change_are_found_among_many():
    model = structure()
    whole = model.stiffness()
    dense = [part.sparse(N).toarray() for part in model.description.recipe.stiffness_terms]
    dense[5] = 10.0 * dense[5]  # a tenth of it is in the matrix: without most of it nothing holds together
    odd = ar.MatrixModel(whole, np.eye(N), stiffness_terms=dense)
    assert [one.terms[0] for one in factors_of(odd)] == [t for t in range(GROUPS) if t != 5]
