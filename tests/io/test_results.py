"""Results as files and copies: every bit comes back, for every kind of model."""

import copy
import json
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.hypotheses import UNKNOWN, Assessment, Hypotheses, Hypothesis
from tests.support.four_masses import chain, exact
from tests.support.problems import PROBLEMS, QUICK, zeros
from tests.support.refusals import unsuitable


def dense(matrix):
    return np.asarray(matrix.todense() if hasattr(matrix, "todense") else matrix)


def same_search(a, b):
    for name in ("x", "populations", "population_costs"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
        assert getattr(a, name).dtype == getattr(b, name).dtype
    for name in ("nfev", "cost", "migrations"):
        np.testing.assert_array_equal(getattr(a.history, name), getattr(b.history, name))
    for name in ("fun", "success", "status", "message", "nfev", "nit", "options"):
        assert getattr(a, name) == getattr(b, name)


def through_a_file(result, folder):
    result.save(folder / "run.npz")
    return type(result).load(folder / "run.npz")


COPIES = {
    "file": through_a_file,
    "pickle": lambda result, _: pickle.loads(pickle.dumps(result)),
    "deepcopy": lambda result, _: copy.deepcopy(result),
}


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("name", PROBLEMS)
def test_results_come_back(tmp_path, name, copied):
    problem = PROBLEMS[name]
    made = ar.update(problem, rng=3, optimizer=QUICK)
    fresh = copied(made, tmp_path)  # before anything was computed of it, and after
    assert fresh.summary() == made.summary()
    back = copied(made, tmp_path)
    assert type(back) is type(made)
    assert back.fun == back.problem.cost(back.x)
    same_search(made.search, back.search)
    assert back.search.options["max_evaluations"] == 600
    assert (back.seed, back.problem.names) == (3, problem.names)
    assert back.problem.parameters == problem.parameters
    for mine, theirs in zip(problem.measured, back.problem.measured, strict=True):
        if isinstance(mine, ar.AntiresonanceSet):
            assert mine == theirs
        else:
            np.testing.assert_array_equal(mine.shapes, theirs.shapes)
            np.testing.assert_array_equal(mine.damping_ratio, theirs.damping_ratio)
            assert mine.dofs == theirs.dofs
    assert str(back.table) == str(made.table)
    assert back.summary() == made.summary()
    np.testing.assert_array_equal(dense(made.model.stiffness()), dense(back.model.stiffness()))
    np.testing.assert_array_equal(dense(made.model.mass()), dense(back.model.mass()))
    np.testing.assert_array_equal(ar.update(back.problem, rng=back.seed, optimizer=QUICK).x, made.x)


def test_damage_of_an_updated_model(tmp_path):
    reference = ar.update(PROBLEMS["chain"], rng=0, optimizer=QUICK).model
    hurt = ar.UpdatingProblem(reference, ar.stiffness_reduction(1), zeros(reference, [0], 0)).model_at([0.4])
    measured = zeros(hurt, [0, 1], 0, scale=1.0)
    measured = measured.drop(0, measured[0][0], reason="by hand")
    made = ar.assess_damage(reference, measured, rng=1)
    for copied in COPIES.values():
        back = copied(made, tmp_path)
        assert back.problem.penalty == made.problem.penalty
        assert back.problem.measured[0].edits == measured.edits
        np.testing.assert_array_equal(back.problem.model.stiffness(), reference.stiffness())
        assert (back.severity, back.summary()) == (made.severity, made.summary())
    assert type(ar.UpdateResult.load(tmp_path / "run.npz")) is ar.DamageResult


@pytest.fixture
def saved(tmp_path):
    ar.update(PROBLEMS["chain"], rng=0, optimizer=QUICK).save(tmp_path / "run.npz")
    return tmp_path / "run.npz"


def rewritten(path, change):
    import hashlib

    arrays = dict(np.load(path))
    text = json.dumps(change(json.loads(bytes(arrays["antires_rs"])))).encode()
    arrays["antires_rs"] = np.frombuffer(text, dtype=np.uint8)
    arrays["text_sha256"] = np.frombuffer(hashlib.sha256(text).digest(), dtype=np.uint8)
    np.savez(path, **arrays)


def test_another_text_is_refused_and_another_objective_told(saved):
    rewritten(saved, lambda d: d | {"search": d["search"] | {"fun": 0.5}})
    with pytest.warns(ar.AntiresWarning, match="its objective was 0.5 where this version computes"):
        ar.UpdateResult.load(saved)
    rewritten(saved, lambda d: {k: v for k, v in d.items() if k != "search"})
    unsuitable("which is damaged", ar.UpdateResult.load, saved)
    rewritten(saved, lambda d: d | {"version": 5})
    unsuitable("of version 5; wanted version 4 or older. Update", ar.UpdateResult.load, saved)
    rewritten(saved, lambda d: d | {"format": "other"})
    unsuitable("which holds 'other'", ar.UpdateResult.load, saved)


def test_other_and_edited_files_are_noticed(saved, tmp_path):
    unsuitable("which holds an UpdateResult.*Use UpdateResult.load", ar.DamageResult.load, saved)
    with pytest.raises(ar.InvalidInputError, match="^path: got .*; wanted a file that ends in .npz"):
        ar.UpdateResult.load(saved).save(tmp_path / "run.json")
    arrays = dict(np.load(saved, allow_pickle=False))
    text = bytes(arrays["antires_rs"]).replace(b'"seed": 0', b'"seed": 1')
    for changed, said in (
        ({"a": 1.0}, "an archive of another kind"),
        (arrays | {"a0": arrays["a0"] + 1e-9}, "array a0 is missing or does not have its checksum"),
        (arrays | {"antires_rs": np.frombuffer(text, dtype=np.uint8)}, "whose text does not have its checks"),
    ):
        np.savez(saved, **changed)
        unsuitable(said, ar.UpdateResult.load, saved)


@pytest.fixture(scope="module")
def assessed():
    intact, damaged = chain([510.0, 441.0, 525.0]), chain([400.0, 331.0, 525.0])
    given = {"elements": [0, 1], "search": ar.SearchOptions(false_alarm_rate=0.05), "rng": 0}
    return ar.assess_damage(chain(), exact(damaged), baseline=exact(intact), **given)


def test_every_field_comes_back(tmp_path, assessed):
    assessed.save(tmp_path / "damage.npz")
    back = ar.DamageResult.load(tmp_path / "damage.npz")
    mine, theirs = assessed.assessment, back.assessment
    for field in fields(Assessment):
        assert getattr(mine, field.name) == getattr(theirs, field.name), field.name
        assert repr(getattr(mine, field.name)) == repr(getattr(theirs, field.name)), field.name
    assert mine == theirs
    assert any(len(one.elements) > 1 for one in theirs.hypotheses)
    for name in ("headline", "severity", "interval", "probability", "detectable", "notes"):
        assert getattr(back, name) == getattr(assessed, name), name
    assert back.summary() == assessed.summary()
    assert back.intervals("ensemble", draws=100) == assessed.intervals("ensemble", draws=100)
    assessed.save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "damage.npz").read_bytes()


def test_what_a_field_may_be(tmp_path, assessed):
    rows = [*assessed.hypotheses, Hypothesis(UNKNOWN, 1e-8, (), (), (), candidate=False)]
    odd = {"detectable": (float("inf"), 0.1), "threshold": None, "group": (), "notes": ("left out",)}
    rare = replace(assessed.assessment, hypotheses=Hypotheses(rows, assessed.hypotheses.names), **odd)
    ar.DamageResult(assessed.problem, assessed.search, assessed.seed, rare).save(tmp_path / "rare.npz")
    assert ar.DamageResult.load(tmp_path / "rare.npz").assessment == rare
