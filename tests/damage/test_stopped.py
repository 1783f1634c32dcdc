"""Searches that Ctrl-C stops: what they say begins with it."""

import re

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.inference import Search
from tests.support.wrong_chains import NOMINAL, chain, measured, truth


@pytest.fixture
def stopped(monkeypatch):
    rng, factors = truth(90)
    before, now = measured(chain(factors), rng), measured(chain(factors, [0, 0, 0.3, 0, 0]), rng)

    def ctrl_c(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Search, "_refine", ctrl_c)
    return ar.assess_damage(NOMINAL, now, baseline=before)


def test_the_headline_begins_with_it(stopped):
    assert not stopped.success
    assert stopped.headline.startswith("The search was stopped: ")
    assert not re.search(r"probability [\d a]|above 99", stopped.headline)


def test_so_does_the_report_and_a_file(stopped, tmp_path):
    pytest.importorskip("jinja2")
    pytest.importorskip("matplotlib")
    stopped.report(tmp_path / "run.html")
    html = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert '<p class="answer">The search was stopped: ' in html
    stopped.save(tmp_path / "run.npz")
    assert ar.DamageResult.load(tmp_path / "run.npz").headline == stopped.headline


def test_baselines_that_are_scaled_give_no_confident_damage():
    rng, factors = truth(91)
    before = measured(chain(factors), rng)
    other = [
        ar.AntiresonanceSet(s.excitation, {d: 1.03 * s[d] for d in s}, std_hz={d: s.std_hz[d] for d in s})
        for s in before
    ]
    losses = np.zeros(5)
    losses[4] = 0.3
    result = ar.assess_damage(NOMINAL, measured(chain(factors, losses), rng), baseline=[*before, *other])
    assert result.headline.startswith("The baseline contradicts itself")
    assert "If the baseline can be trusted at all, " in result.headline
    assert "Probability" not in result.headline
    assert "%" not in result.headline.split("If the baseline")[1]
