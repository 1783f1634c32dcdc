"""Damage against a baseline as a file: every field of the assessment comes back bit for bit."""

from dataclasses import fields, replace

import pytest

import antires_rs as ar
from antires_rs.damage.hypotheses import UNKNOWN, Assessment, Hypotheses, Hypothesis
from tests.support.four_masses import chain, exact


@pytest.fixture(scope="module")
def made():
    """Springs off the model by a few per cent, the second softened; the third is no candidate."""
    intact, damaged = chain([510.0, 441.0, 525.0]), chain([510.0, 331.0, 525.0])
    return ar.assess_damage(
        chain(),
        exact(damaged),
        baseline=exact(intact),
        elements=[0, 1],
        search=ar.SearchOptions(false_alarm_rate=0.05),
        rng=0,
    )


def test_every_field_comes_back(tmp_path, made):
    made.save(tmp_path / "damage.npz")
    back = ar.DamageResult.load(tmp_path / "damage.npz")
    mine, theirs = made.assessment, back.assessment
    for field in fields(Assessment):
        assert getattr(mine, field.name) == getattr(theirs, field.name), field.name
        assert repr(getattr(mine, field.name)) == repr(getattr(theirs, field.name)), field.name
    assert mine == theirs
    assert any(len(one.elements) > 1 for one in theirs.hypotheses)
    for name in ("headline", "severity", "interval", "probability", "detectable", "notes"):
        assert getattr(back, name) == getattr(made, name), name
    assert back.summary() == made.summary()
    assert back.intervals("ensemble", draws=100) == made.intervals("ensemble", draws=100)
    made.save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "damage.npz").read_bytes()


def test_what_a_field_may_be(tmp_path, made):
    """Infinity, no threshold, no group, notes, something else."""
    rows = [*made.hypotheses, Hypothesis(UNKNOWN, 1e-8, (), (), (), candidate=False)]
    rare = replace(
        made.assessment,
        hypotheses=Hypotheses(rows, made.hypotheses.names),
        detectable=(float("inf"), 0.1),
        threshold=None,
        group=(),
        notes=("left out",),
    )
    result = ar.DamageResult(made.problem, made.search, made.seed, rare)
    result.save(tmp_path / "rare.npz")
    assert ar.DamageResult.load(tmp_path / "rare.npz").assessment == rare
