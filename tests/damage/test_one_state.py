"""Without a baseline: what an answer rests on, and a factor on all stiffnesses told from many losses."""

import numpy as np
import pytest

import antires_rs as ar
from reference.wrong_models import JUDGED_ON
from tests.support.wrong_chains import NOMINAL, chain, measured, truth

SAID = "The model does not explain the measurement: every stiffness would have to be multiplied by 0."
CHAIN, FRAME = JUDGED_ON


def test_an_intact_chain_beside_the_model_is_not_said_to_be_damaged_without_reserve(tmp_path):
    rng, factors = truth(95, off=0.05)
    result = ar.assess_damage(NOMINAL, measured(chain(factors), rng), rng=0)
    assert result.damaged  # the model's errors
    first = result.headline.split(". ")[0]
    assert all(f"spring {e} has lost" in first.lower() for e in result.damaged)
    assert first.endswith("if the model is exact")
    assert "an error of the model comes out as damage" in result.headline
    assert "nothing has changed" not in result.headline
    pytest.importorskip("jinja2")
    pytest.importorskip("matplotlib")
    result.report(tmp_path / "r.html")
    html = (tmp_path / "r.html").read_text(encoding="utf-8")
    top = html[html.index('class="answer"') :][:1500]
    assert "if the model is exact" in top
    assert "comes out as damage" in top


def test_headline_and_severity_agree_whatever_the_hypotheses_say():
    exact = measured(chain(np.ones(12)), np.random.default_rng(96), std=1e-7)
    result = ar.assess_damage(NOMINAL, exact, rng=0)
    assert result.damaged == []
    assert result.headline.startswith("No damage found. Without a baseline it is not known")


def assessed(structure, off, losses, seed):
    _, now = structure.states(seed, off, losses)
    return ar.assess_damage(structure.build(), now, rng=0, workers=1)


@pytest.mark.parametrize("structure", JUDGED_ON, ids=lambda each: each.name)
@pytest.mark.parametrize(("loss", "spread", "off"), [(0.15, 0.01, 0.0), (0.4, 0.02, 0.03), (0.75, 0.0, 0.02)])
def test_nearly_equal_losses_of_all(structure, loss, spread, off):
    rng = np.random.default_rng(7)
    losses = {e: loss + spread * rng.uniform(-1.0, 1.0) for e in structure.build().default_elements}
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
    half = rng.permutation(structure.build().default_elements)[:4].tolist()
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
