"""Presets: what they hold, and that what is given wins."""

import pytest
from antires_rs.identification.rule import DEFAULTS, PRESETS, Rule, rule_options

from antires_rs.exceptions import InvalidInputError


def test_without_a_preset_the_defaults_hold():
    assert rule_options() == dict(DEFAULTS)


def test_the_defaults_are_those_of_the_rule():
    rule = Rule()
    for name in ("freq_tol", "damping_tol", "min_rows", "max_damping", "min_dominance"):
        assert DEFAULTS[name] == getattr(rule, name)


def test_the_papers_rule():
    options = rule_options("paper")
    assert (options["freq_tol"], options["damping_tol"], options["min_rows"]) == (0.01, 0.05, 10)
    assert options["min_dominance"] == 0.0  # no test
    assert options["persistent"] is False


@pytest.mark.parametrize("preset", [None, *PRESETS])
def test_what_is_given_wins(preset):
    options = rule_options(preset, min_rows=3, persistent=False, damping_tol=None)
    assert options["min_rows"] == 3
    assert options["persistent"] is False
    assert options["damping_tol"] == rule_options(preset)["damping_tol"]
    assert set(options) == set(DEFAULTS)


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_is_a_rule(preset):
    options = rule_options(preset)
    names = ("freq_tol", "damping_tol", "min_rows", "max_damping", "min_dominance")
    assert Rule(**{name: options[name] for name in names}).checked()


def test_presets_cannot_be_changed_by_accident():
    with pytest.raises(TypeError):
        PRESETS["paper"]["min_rows"] = 1


def test_unknown_names_are_told():
    with pytest.raises(InvalidInputError, match="^preset: got 'loose'; wanted one of None, 'paper'"):
        rule_options("loose")
    with pytest.raises(InvalidInputError, match="^options: got rows; wanted names out of"):
        rule_options(rows=3)
