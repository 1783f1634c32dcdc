"""Without a baseline: a factor on all stiffnesses is told from the losses of several elements."""

import numpy as np
import pytest

import antires_rs as ar
from reference.wrong_models import JUDGED_ON

SAID = "The model does not explain the measurement: every stiffness would have to be multiplied by 0."
CHAIN, FRAME = JUDGED_ON


def assessed(structure, off, losses, seed):
    _, now = structure.states(seed, off, losses)
    return ar.assess_damage(structure.build(), now, rng=0, workers=1)


def elements_of(structure):
    return list(structure.build().default_elements)


@pytest.mark.parametrize("structure", JUDGED_ON, ids=lambda each: each.name)
@pytest.mark.parametrize(("loss", "spread", "off"), [(0.15, 0.01, 0.0), (0.4, 0.02, 0.03), (0.75, 0.0, 0.02)])
def test_nearly_equal_losses_of_all(structure, loss, spread, off):
    rng = np.random.default_rng(7)
    losses = {e: loss + spread * rng.uniform(-1.0, 1.0) for e in elements_of(structure)}
    result = assessed(structure, off, losses, 7)
    assert result.headline.startswith(SAID)
    factor = float(result.headline.removeprefix(SAID[:-2]).split(",")[0])
    assert factor == pytest.approx(1.0 - loss, abs=0.03)
    assert "which is no finding" in result.headline


@pytest.mark.parametrize("structure", JUDGED_ON, ids=lambda each: each.name)
@pytest.mark.parametrize("off", [0.0, 0.03])
def test_damage_of_half_of_them_is_damage(structure, off):
    """Equal losses too: the others have none."""
    rng = np.random.default_rng(8)
    half = rng.permutation(elements_of(structure))[:4].tolist()
    for losses in ({e: 0.3 for e in half}, {e: float(rng.uniform(0.1, 0.6)) for e in half}):
        result = assessed(structure, off, losses, 8)
        assert "every stiffness" not in result.headline
        assert {e for e in result.damaged if result.severity[e] > 0.08} == set(half)


@pytest.mark.parametrize("structure", JUDGED_ON, ids=lambda each: each.name)
def test_a_model_that_is_off_here_and_there_needs_no_factor(structure):
    assert "every stiffness" not in assessed(structure, 0.08, None, 9).headline


def test_modes_too():
    rng = np.random.default_rng(10)
    for losses, told in (({e: 0.3 for e in range(8)}, True), ({1: 0.3, 4: 0.2, 6: 0.4}, False)):
        modes = CHAIN.truth(rng, 0.01, losses).modes()
        result = ar.assess_damage(CHAIN.build(), modes, rng=0, workers=1)
        assert result.headline.startswith(SAID) is told
