"""Values that are higher than in the intact state: swapped sets, something stiffened."""

import numpy as np
import pytest

import antires_rs as ar
from tests.damage.test_modes import measured as modes
from tests.support.wrong_chains import NOMINAL, chain, measured, truth

QUESTION = "are the sets swapped, or has something been stiffened?"


@pytest.mark.parametrize(("seed", "loss"), [(110, 0.1), (111, 0.3), (112, 0.5)])
def test_swapped_sets_are_asked_about(seed, loss):
    rng, factors = truth(seed)
    losses = np.zeros(5)
    losses[seed % 5] = loss
    intact, hurt = measured(chain(factors), rng), measured(chain(factors, losses), rng)
    swapped = ar.assess_damage(NOMINAL, intact, baseline=hurt)
    assert swapped.damaged == []
    assert QUESTION in swapped.headline
    assert swapped.assessment.n_risen >= 0.75 * swapped.assessment.n_moved > 0
    assert QUESTION not in ar.assess_damage(NOMINAL, hurt, baseline=intact).headline
    assert QUESTION not in ar.assess_damage(NOMINAL, measured(chain(factors), rng), baseline=intact).headline


def test_swapped_modes_are_asked_about():
    rng, factors = truth(114)
    intact, hurt = (modes(chain(factors, losses), rng) for losses in (None, [0, 0.4, 0, 0, 0]))
    assert QUESTION in ar.assess_damage(NOMINAL, intact, baseline=hurt).headline
    assert QUESTION not in ar.assess_damage(NOMINAL, hurt, baseline=intact).headline


def test_an_unknown_change_that_lowers_values_is_not_asked_about():
    rng, factors = truth(113)
    heavier = factors.copy()
    heavier[4] *= 1.3
    result = ar.assess_damage(NOMINAL, measured(chain(heavier), rng), baseline=measured(chain(factors), rng))
    assert not result.assessment.explained or result.hypotheses[0].unknown
    assert QUESTION not in result.headline
