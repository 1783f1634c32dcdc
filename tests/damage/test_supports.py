"""Against a baseline: a support that the model lacks is named, and right models keep their answer."""

from itertools import product

import numpy as np
import pytest

import antires_rs as ar
from reference.forgotten_supports import ANGLE, JUDGED_ON, PORTAL, PROPPED
from tests.support.campaign import some_of

LACKS = (
    "The model does not explain the measurement: held at {} as well, it would explain the intact structure"
)
FIRST = [(PORTAL, 1, 7), (PROPPED, 0, 7)]
EVERY = [(one, nth, 7) for one in (PORTAL, PROPPED, *JUDGED_ON) for nth in range(len(one.supports))]


@pytest.mark.parametrize(("structure", "forgotten", "seed"), some_of(EVERY, FIRST))
def test_a_forgotten_support_is_named(structure, forgotten, seed):
    support = structure.supports[forgotten]
    node = support if isinstance(support, int) else support[0]
    model, before, now = structure.states(seed, forgotten, losses={2: 0.2})
    said = ar.assess_damage(model, now, baseline=before, workers=1).headline
    assert said.startswith(LACKS.format(f"node {node}"))
    assert "one may be missing" in said
    assert "Probability" not in said


RIGHT = product((PORTAL, PROPPED, *JUDGED_ON), (7, 8, 9), (None, 20.0))


@pytest.mark.parametrize(
    ("structure", "seed", "clamp"), some_of(RIGHT, [(PROPPED, 8, 20.0), (ANGLE, 8, 20.0)])
)
def test_a_model_with_all_supports_keeps_its_answer(structure, seed, clamp):
    model, before, now = structure.states(seed, clamp=clamp)
    assert "may be missing" not in ar.assess_damage(model, now, baseline=before, workers=1).headline


def test_a_chain_that_stands_on_no_ground_lacks_it():
    rng = np.random.default_rng(5)
    masses, springs = 1.0 + 0.03 * rng.standard_normal((2, 7))
    truth = ar.MassSpringChain(masses, 1e4 * springs[1:], ground_first_n_per_m=1e4 * springs[0])
    before, now = (
        ar.AntiresonanceSet(
            6, {k: truth.antiresonances(k, 6) * (1.0 + 3e-4 * rng.standard_normal()) for k in range(1, 7)}
        )
        for _ in range(2)
    )
    free, held = (ar.MassSpringChain([1.0] * 7, [1e4] * 6, ground_first_n_per_m=k) for k in (0.0, 1e4))
    assert ar.assess_damage(free, now, baseline=before).headline.startswith(LACKS.format("mass 0"))
    assert "may be missing" not in ar.assess_damage(held, now, baseline=before).headline
