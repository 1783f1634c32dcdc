"""One record given twice counts once; two tests at the same force count twice."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.wrong_chains import NOMINAL, N, chain, measured, truth

LOSSES = (0, 0.02, 0, 0, 0)
NOTE = "[1] repeats the values of "


@pytest.fixture(scope="module")
def tests():
    """An intact test, one of a small damage, and another one of the same damage; force at mass 0."""
    rng, factors = truth(611)
    intact = measured(chain(factors), rng, forces=(0,))
    return *intact, *(measured(chain(factors, LOSSES), rng, forces=(0,))[0] for _ in range(2))


def full(now, before):
    return ar.assess_damage(NOMINAL, now, baseline=before, workers=1)


def figures(result):
    return [(one.elements, one.probability, one.severities) for one in result.hypotheses]


def test_a_set_of_now_given_twice(tests):
    before, now, again = tests
    once, twice, repeated = (full(sets, before) for sets in ([now], [now, now], [now, again]))
    assert figures(twice) == figures(once) != figures(repeated)
    assert any("measured" + NOTE in note for note in twice.notes)
    assert not any(NOTE in note for note in [*once.notes, *repeated.notes])
    assert twice.assessment.n_values == once.assessment.n_values
    assert repeated.assessment.n_values == 2 * once.assessment.n_values


def test_the_baseline_given_twice(tests):
    before, now, _ = tests
    once, twice = full(now, before), full(now, [before, before])
    assert figures(twice) == figures(once)
    assert any("baseline" + NOTE in note for note in twice.notes)
    assert twice.assessment.n_baselines == 1


def test_the_assessor_counts_alike(tests):
    before, now, again = tests
    assessor = ar.Assessor(NOMINAL, baseline=before, workers=1)
    once, twice, repeated = (assessor.assess(sets) for sets in ([now], [now, now], [now, again]))
    assert figures(twice) == figures(once) != figures(repeated)
    assert any("zeros" + NOTE in note for note in twice.notes)
    assert not any(NOTE in note for note in repeated.notes)


def test_one_record_cut_into_overlapping_sets(tests):
    """The response that both have is of one record; the others count."""
    before, now, _ = tests

    def only(dofs):
        return ar.AntiresonanceSet(0, {d: now[d] for d in dofs}, std_hz={d: now.std_hz[d] for d in dofs})

    parts, whole = full([only((0, 1, 2)), only((2, 3, 4, 5))], before), full(now, before)
    assert parts.assessment.n_values == whole.assessment.n_values == sum(map(len, now.values()))
    assert figures(parts)[0][1] == pytest.approx(figures(whole)[0][1], abs=1e-6)


def test_modes_given_twice():
    rng, factors = truth(612)

    def modes(losses=None):
        found = chain(factors, losses).modes()
        hz = found.freq_hz * (1.0 + 3e-4 * rng.standard_normal(N))
        return ar.ModalSet(hz, found.shapes, range(N), std_hz=3e-4 * hz)

    before, now, again = modes(), modes(LOSSES), modes(LOSSES)
    once, twice, repeated = (full(sets, before) for sets in ([now], [now, now], [now, again]))
    assert figures(twice) == figures(once) != figures(repeated)
    assert any("measured" + NOTE in note for note in twice.notes)
    assert twice.table.measured_hz.size == once.table.measured_hz.size
    assert np.array_equal(twice.x, once.x)
