"""Assessments without a baseline say first what they rest on."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.one_state import headline_of_one_state
from tests.support.wrong_chains import NOMINAL, chain, measured, truth


def label(element):
    return f"spring {element}"


def test_an_intact_chain_beside_the_model_is_not_said_to_be_damaged_without_reserve(tmp_path):
    rng, factors = truth(95, off=0.05)
    now = measured(chain(factors), rng)
    result = ar.assess_damage(NOMINAL, now, rng=0)
    assert result.damaged  # the model's errors
    first, second = result.headline.split(". ")[0], result.headline
    assert all(f"{label(e)} has lost".lower() in first.lower() for e in result.damaged)
    assert first.endswith("if the model is exact")
    assert "an error of the model comes out as damage" in second
    assert "nothing has changed" not in second
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


def test_a_search_that_was_stopped():
    first, _ = headline_of_one_state({1: 0.2}, label, finished=False)
    assert first.startswith(
        "The search was stopped: the best so far, if the model is exact, is that spring 1"
    )
    first, second = headline_of_one_state({}, label, finished=False)
    assert first == "The search was stopped: no damage so far."
    assert "not known what was there before" in second
