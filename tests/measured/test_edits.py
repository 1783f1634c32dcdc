"""Edits by hand give new sets, on record; a set itself cannot be changed."""

import copy
import pickle
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.measured.edits import Edit
from tests.support.snapshots import refusal, replay

HOW = ["chain", "persistent", "chain"]


def scored():
    more = {"damping_ratio": {0: [0.02, 0.01, 0.03]}, "std_hz": {0: [0.2, 0.1, 0.3], 2: []}}
    more["scores"] = {0: {"rows": [30, 11, 25], "how": HOW, "residual": [0.01, np.nan, 0.03]}}
    values = {0: [36.2, 12.2, 20.0], 1: [8.0], 2: []}
    return ar.AntiresonanceSet(0, values, diagrams={0: "diagram"}, **more)


def test_dropping_leaves_the_set_as_it_was_and_keeps_a_record():
    before = scored()
    after = before.drop(0, 12.25, reason="mains hum")
    assert before[0].tolist() == [12.2, 20.0, 36.2]
    assert before.edits == ()
    assert after[0].tolist() == [20.0, 36.2]
    assert after.damping_ratio[0].tolist() == [0.03, 0.02]
    assert after.std_hz[0].tolist() == [0.3, 0.2]
    assert after.scores[0]["rows"].tolist() == [25, 30]
    assert after.diagrams == before.diagrams
    edit = Edit("drop", 0, 12.2, "mains hum", 0.01, 0.1, {"rows": 11, "how": "persistent"})
    assert after.edits == (edit,)
    assert after.original() is before.original() is before


def test_adding_without_companions_makes_none_up():
    after = scored().add(1, 30.0).add(2, 4.0)
    assert 1 not in after.damping_ratio
    assert 2 not in after.std_hz
    assert after[2].tolist() == [4.0]
    added = scored().add(0, 15.0)
    assert np.isnan(added.std_hz[0][1])
    assert np.isnan(added.scores[0]["rows"][1])
    assert added.scores[0]["how"].tolist() == ["persistent", "by hand", "chain", "chain"]
    there_and_back = added.drop(0, 15.0, reason="b")
    assert there_and_back == scored()
    assert len(there_and_back.edits) == 2
    assert there_and_back.by_hand() == set()


def test_edits_are_printed_and_survive_the_file(tmp_path):
    made = scored().drop(0, 12.2, reason="hum").add(1, [9.0], std_hz=0.1).add(0, 15.0)
    told = "dropped 12.20 Hz at dof 0 (hum); added 9.00 Hz at dof 1; added 15.00 Hz at dof 0"
    assert str(made).splitlines()[-1] == f"edited by hand: {told}"
    assert "by hand" not in str(scored())
    made.save(tmp_path / "set.json")
    back = ar.AntiresonanceSet.load(tmp_path / "set.json")
    assert back == made
    assert (back.edits, back.original(), str(back)) == (made.edits, scored(), str(made))
    assert back.original().scores[0]["rows"].dtype.kind == "i"
    np.testing.assert_equal(dict(back.scores[0]), dict(made.scores[0]))
    assert back.drop(1, 9.0).original() == scored()


def test_what_cannot_be_edited_is_told():
    file = Path(__file__).with_name("wrong_edits.txt")
    replay(file, lambda call: refusal(partial(eval(call), scored())))


def set_first(mapping):
    mapping[0] = 1


@pytest.mark.parametrize(
    "copied", [lambda s: s, copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))]
)
def test_a_set_cannot_be_changed(copied):
    made = copied(scored().add(1, 9.0))
    for name in ("excitation", "tables", "std_hz", "scores", "edits", "diagrams", "data_check", "new"):
        with pytest.raises(AttributeError, match="read-only"):
            setattr(made, name, None)
    with pytest.raises(AttributeError, match="read-only"):
        del made._tables
    for mapping in (made.tables, made.damping_ratio, made.std_hz, made.scores, made.scores[0], made.diagrams):
        for change in (lambda m: m.update({0: 1}), lambda m: m.pop(0), lambda m: m.clear(), set_first):
            with pytest.raises(TypeError, match="read-only"):
                change(mapping)
    for array in (made[0], made.damping_ratio[0], made.std_hz[0], made.scores[0]["rows"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    assert made == scored().add(1, 9.0)
    assert made.original() == scored()
    assert made.by_hand() == {(1, 9.0)}


def test_what_goes_in_is_copied_and_edits_keep_evidence_and_names():
    values, damping, check = np.array([1.0, 2.0]), np.array([0.1, 0.2]), object()
    made = ar.AntiresonanceSet(0, {0: values}, {0: damping}, data_check=check)
    values[:], damping[:] = 5.0, 5.0
    assert made[0].tolist() == [1.0, 2.0]
    assert made.damping_ratio[0].tolist() == [0.1, 0.2]
    for each in (made, made.drop(0, 1.0), copy.copy(made)):
        assert each.data_check is check
    made = scored().drop(0, 12.2, reason="hum").add(1, 9.0).relabelled("hammer", {0: "tip", 2: 5})
    assert (made.excitation, list(made), dict(made.diagrams)) == ("hammer", ["tip", 5], {})
    assert made["tip"].tolist() == [20.0, 36.2]
    assert made.std_hz["tip"].tolist() == [0.3, 0.2]
    assert [(e.action, e.dof) for e in made.edits] == [("drop", "tip")]
    assert made.original()["tip"].tolist() == [12.2, 20.0, 36.2]
    only = scored().add(1, 9.0).relabelled(0, {0: 0})
    assert (only.edits, only.original()) == ((), only)
