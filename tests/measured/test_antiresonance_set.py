"""The set by hand: order, mapping, file, and what it refuses."""

import json
import pickle
import sys
from dataclasses import FrozenInstanceError
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import antires_rs as ar
from antires_rs.identification.scores import graded
from antires_rs.measured.antiresonance_set import AntiresonanceSet
from antires_rs.measured.response_table import ResponseTable, doubts_of
from antires_rs.support.checks import Dofs, forces_at, label_text
from tests.support.refusals import refused
from tests.support.same_sets import assert_same_set
from tests.support.snapshots import refusals


def example():
    values, std = {0: [36.2, 12.1], "tip": 8.0, 2: []}, {0: [0.2, 0.1], 2: []}
    return AntiresonanceSet("hammer", values, damping_ratio={0: [0.02, 0.01]}, std_hz=std)


def test_it_is_a_mapping_in_ascending_order():
    made = example()
    assert {dof: freq.tolist() for dof, freq in made.items()} == {0: [12.1, 36.2], "tip": [8.0], 2: []}
    assert (len(made), 0 in made, 1 in made) == (3, True, False)
    with pytest.raises(KeyError):
        made[1]
    assert made.damping_ratio[0].tolist() == [0.01, 0.02]
    assert made.std_hz[0].tolist() == [0.1, 0.2]
    assert made.columns(0)["std_hz"] is made.tables[0].std_hz
    assert "tip" not in made.damping_ratio
    assert made.std_hz[2].size == 0
    labels = AntiresonanceSet(np.int64(0), {np.int64(3): np.array([1.0])})
    assert [type(label) for label in (labels.excitation, *labels)] == [int, int]


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(1e-300, 1e300), max_size=6), st.integers() | st.text(max_size=5))
def test_files_keep_every_bit(tmp_path_factory, values, label):
    path = tmp_path_factory.mktemp("set") / "set.json"
    made = AntiresonanceSet(label, {label: values}, std_hz={label: values})
    made.save(path)
    assert AntiresonanceSet.load(path) == made
    assert AntiresonanceSet.load(path)[label].tobytes() == made[label].tobytes()


def test_saving_replaces_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "set.json"
    example().save(path)
    before = path.read_bytes()
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        AntiresonanceSet(0, {0: 1.0}).save(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["set.json"]


#: Entries of a file, of its first dof and of its first edit that damage it.
OF_SET = [{"format": "other"}, {"version": 99}, {"version": "1"}, {"sees": "everything"}, {"dofs": []}]
OF_SET += [{"excitation": [0, 4]}, {"edits": 3}]
OF_DOF = [{"freq_hz": [1.0, None]}, {"freq_hz": [-1.0, 2.0]}, {"damping_ratio": [0.1]}, {"left_out": [1.0]}]
OF_DOF += [{"left_out": {"freq_hz": [-1.0]}}, {"unexplained_hz": [0.0]}, {"unexplained_hz": "x"}]
OF_DOF += [{"scores": {"rows": [1]}}]
OF_EDIT = [{"action": "moved"}, {"freq_hz": "12"}, {"more": 1}]
DAMAGES = [*((lambda d, new=new: d.update(new)) for new in OF_SET)]
DAMAGES += [*((lambda d, new=new: d["dofs"][0].update(new)) for new in OF_DOF)]
DAMAGES += [*((lambda d, new=new: d["edits"][0].update(new)) for new in OF_EDIT), lambda d: d.pop("dofs")]
DAMAGES += [lambda d: d.pop("before_edits"), lambda d: d["dofs"].append(d["dofs"][0])]
DAMAGES += [lambda d: d["dofs"][0].pop("freq_hz"), lambda d: d["edits"][0].pop("freq_hz")]


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_is_named(tmp_path, damage):
    whole = example().add("tip", 9.0).to_json()
    data = json.loads(whole)
    damage(data)
    for content in (json.dumps(data).encode(), b"\x00\x01", b"[1, 2]", whole[:-20].encode(), b"\xff"):
        (tmp_path / "set.json").write_bytes(content)
        refused("^path: got .*set.json", AntiresonanceSet.load, tmp_path / "set.json")


def test_equality():
    values = {0: [36.2, 12.1], "tip": 8.0, 2: []}
    assert example() == example()
    assert example() != AntiresonanceSet("hammer", values)
    assert example() != AntiresonanceSet(1, values, {0: [0.02, 0.01]}, {0: [0.2, 0.1], 2: []})
    assert example() != "a string"
    made = AntiresonanceSet(0, {0: [1.0, 2.0], 1: [3.0]}, {0: [np.nan, 0.1], 1: [np.nan]})
    assert np.isnan(made.damping_ratio[0][0])
    assert 1 not in made.damping_ratio
    assert made == AntiresonanceSet(0, {0: [1.0, 2.0], 1: [3.0]}, {0: [np.nan, 0.1]})


def test_table_and_repr():
    assert repr(example()) == "AntiresonanceSet(excitation='hammer', values by dof {0: 2, 'tip': 1, 2: 0})"
    assert str(example()).splitlines() == [
        "antiresonances, force at hammer",
        "dof  freq_hz  std_hz",
        "  0   12.100   0.100",
        "      36.200   0.200",
        "tip    8.000       -",
        "  2        -",
    ]


def test_dataframe(monkeypatch):
    pytest.importorskip("pandas")
    frame = example().to_dataframe()
    assert frame["freq_hz"].tolist() == [12.1, 36.2, 8.0]
    assert np.isnan(frame["std_hz"].iloc[2])
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ar.MissingDependencyError, match="pip install pandas"):
        example().to_dataframe()


def made(*given, **options):
    return AntiresonanceSet(
        *given, **options if given else {"excitation": 0, "freq_hz": {0: [1.0]}} | options
    )


def test_bad_arguments_are_named():
    refusals(__file__, "wrong_sets.txt", globals())


# -- The table of a response; printed: frequency, deviation, grade and doubts
def table():
    columns = {"rows": [45, 30, 5], "spread": [1e-5, 4e-3, 4e-3], "dominance": [1.0, 1.0, 0.5]}
    columns["how"] = ["chain", "chain", "persistent"]
    made = ResponseTable.of_sweep([8.7, 23.9, 31.0], [0.01] * 3, [0.004, 0.005, 0.2], **columns)
    return graded(made.with_scores(residual=[0.01, 0.01, 0.2], prominence_db=[15.0, 2.0, 2.0]))


def test_rows_of_a_table_are_taken_in_order_and_no_column_has_another_length():
    columns = {"rows": [30, 11, 25], "spread": [1e-4, 2e-4, 3e-4], "dominance": [1.0, 0.9, 0.8]}
    columns["how"] = ["chain", "persistent", "chain"]
    made = ResponseTable.of_sweep([36.2, 12.2, 20.0], [0.02, 0.01, 0.03], **columns)
    assert made.freq_hz.tolist() == [12.2, 20.0, 36.2]
    assert made.rows.tolist() == made.orders.tolist() == [11, 25, 30]
    assert np.isnan([made.std_hz, made.residual]).all()
    for chosen in ([0, 2], np.array([True, False, True])):
        some = made.take(chosen)
        assert (some.freq_hz.tolist(), some.how.tolist()) == ([12.2, 36.2], ["persistent", "chain"])
    assert (len(made.take([])), list(made.take([]).scores)) == (0, list(made.scores))
    assert made.rows.dtype == made.take([]).rows.dtype == np.int64
    refused(r"^std_hz: got an array of shape \(1,\); wanted 2", ResponseTable, [1.0, 2.0], std_hz=[0.1])
    with pytest.raises(FrozenInstanceError):
        made.freq_hz = np.zeros(3)
    with pytest.raises(TypeError, match="read-only"):
        made.scores["how"] = ["chain"] * 3


def test_a_set_has_a_line_a_value_with_its_doubts_in_words():
    found = ar.AntiresonanceSet.from_tables(0, {"tip": table(), 7: table().take([])}).add("tip", 50.0)
    weak = "does not stand still, few orders, unsteady, owns little of its curve, poor fit, no clear peak"
    assert str(found).splitlines()[1:-1] == [
        "dof  freq_hz  std_hz  grade  doubts",
        "tip   8.7000  0.0040  sure",
        "     23.9000  0.0050  fair   unsteady, no clear peak",
        f"     31.0000  0.2000  weak   {weak}",
        "     50.0000       -         added by hand",
        "  7        -",
    ]


def test_a_doubt_of_all_channels_is_not_said_twice():
    two = np.array([0.1, 0.0])
    scores = {"grade": ["weak"] * 2, "second": two, "doubt": ["second force, record too short"] * 2}
    doubts = doubts_of(table().take([0, 1]).with_scores(**scores))
    assert doubts[0][0] == "second force or noise"
    assert [row[-1] for row in doubts] == ["record too short"] * 2
    assert "second force" not in doubts[0]
    assert "second force" in doubts[1]


@pytest.mark.parametrize("known", [{}, {"depth_db": [3.0, 9.0]}, {"rows": [5, 30]}, {"share": [0.5, np.nan]}])
def test_grades_by_hand_without_other_scores_are_printed(known):
    one = AntiresonanceSet(0, {0: [8.7, 12.2]}, scores={0: {"grade": ["weak", "fair"], **known}})
    assert doubts_of(one.tables[0]) == [["few orders"] if "rows" in known else [], []]
    assert str(one).splitlines()[3].split() == ["12.200", "fair"]


# ---- What goes with a set through edits, files, names, problems and joining: sight, and what was left out
def some(**options):
    return ar.AntiresonanceSet(0, {0: [8.7, 12.2], 1: [14.4]}, **options)


@pytest.fixture
def rich():
    left_out = {0: ResponseTable([9.0, 9.5], scores={"why": ["no peak"] * 2}), 1: ResponseTable([])}
    more = {"unexplained_hz": {0: np.array([33.3 + 1e-13]), 1: np.empty(0)}, "sees": "transmissibility"}
    more |= {"channels": [0, 1, 5], "options": {"preset": "strict"}, "left_out": left_out}
    return ar.AntiresonanceSet.from_tables(0, some().tables, **more)


def test_edits_and_files_keep_it(rich, tmp_path):
    assert (some().sees, some().channels) == (None, (0, 1))
    assert not any(name in some().to_json() for name in ("left_out", "unexplained"))
    edited = rich.drop(0, 8.7, reason="to see").add(1, 20.0)
    assert (edited.sees, edited.channels, edited.left_out) == (rich.sees, rich.channels, rich.left_out)
    for one in (rich, edited, some(sees="frf").drop(0, 8.7), some().add(1, 20.0)):
        one.save(tmp_path / "set.json")
        back = ar.AntiresonanceSet.load(tmp_path / "set.json")
        assert_same_set(back, one)
        assert_same_set(back.original(), one.original())
        assert (str(back), back.options) == (str(one), one.options)
    peaks = "peaks of the curves at which no value was found: 1, see .unexplained_hz"
    assert f"left out: 2 (2 no peak), see .left_out\n{peaks}" in str(rich)


def test_other_names_and_problems_keep_it_and_channels_unless_one_has_none(rich, tmp_path):
    named = rich.relabelled("a", {0: "a", 1: "b", 5: "c"})
    assert (named.sees, named.channels) == ("transmissibility", ("a", "b", "c"))
    assert_same_set(named.relabelled(0, {"a": 0, "b": 1, "c": 5}), rich)
    assert rich.relabelled(3, {0: 3, 1: 4}).channels == ()
    model = ar.MassSpringChain(np.full(7, 1.0), np.full(6, 5e3))
    problem = ar.UpdatingProblem(model, ar.stiffness_factor([0], bounds=(0.5, 1.5)), rich)
    ar.update(problem, rng=0, optimizer=ar.IslandGA(max_evaluations=500)).save(tmp_path / "result.npz")
    (back,) = ar.UpdateResult.load(tmp_path / "result.npz").problem.measured
    assert_same_set(rich, back)


def test_joined_setups_are_of_one_kind_or_of_none():
    sets = [some(sees="frf"), some(sees="frf", channels=[0, 1, 4])]
    merged = ar.merge_setups(sets, check="off")
    assert (merged.sees, merged.channels) == ("frf", (0, 1, 4))
    assert ar.merge_setups([sets[0], some(sees="transmissibility")], check="off").sees is None
    moved = [ar.AntiresonanceSet(k, {"tip": [f]}, sees="frf") for k, f in ((3, 20.1), (4, 25.3))]
    merged = ar.merge_setups(moved, excitation="tip", check="off")
    assert (merged.sees, merged.channels) == ("frf", ())


# -- antiresonances_0.1.0.json was made by it: chain8 at level 0, 5 % noise, 64 s, rng=7; dofs 0, 2 and
# 7 identified with excitation=0, band_hz=(3, 130); 48.63 Hz dropped from dof 2, 125 Hz added to dof 0.

FILE = Path(__file__).with_name("antiresonances_0.1.0.json")


def as_read(values):
    return [None if value != value else value for value in values.tolist()]


def test_files_of_older_versions_are_read_with_every_number_and_edit():
    found, data = ar.AntiresonanceSet.load(FILE), json.loads(FILE.read_text())
    for tables, rows in ((found.tables, data["dofs"]), (found.original().tables, data["before_edits"])):
        assert list(tables) == [row["dof"] for row in rows] == [0, 2, 7]
        for table, row in zip(tables.values(), rows, strict=True):
            for name in ("freq_hz", "damping_ratio", "std_hz"):
                assert as_read(getattr(table, name)) == row[name]
            assert list(table.scores) == list(row["scores"])
            for name, column in row["scores"].items():
                assert as_read(table.scores[name]) == column
    assert found[7].size == 0
    assert found.original().scores[2]["rows"].dtype == np.int64
    assert found.by_hand() == {(0, 125.0)}
    assert found.tables[0].by_hand.tolist() == [False] * 7 + [True]
    edits = [("drop", 2, "mains hum of the shaker"), ("add", 0, "clear in the phase")]
    assert [(e.action, e.dof, e.reason) for e in found.edits] == edits
    assert found.original().by_hand() == set()
    assert found.original()[2].size == found[2].size + 1
    assert json.loads(found.to_json()) == json.loads(FILE.read_text())
    assert (found.sees, dict(found.left_out), dict(found.unexplained_hz)) == (None, {}, {})


# -- Several forces


def of_two_forces() -> ar.AntiresonanceSet:
    """Pairs given in any order; the deviation of one of them."""
    values = {(5, 1): [58.5, 36.2], (1, 2): [9.0], (0, 2): []}
    return ar.AntiresonanceSet([4, 0], values, std_hz={(1, 5): [0.2, 0.1]}, channels=range(6))


def test_several_forces_have_tuples_for_keys_in_one_order():
    zeros = of_two_forces()
    assert zeros.order == 2
    assert zeros.excitation == (0, 4)
    assert list(zeros) == [(1, 5), (1, 2), (0, 2)]
    assert zeros[5, 1].tolist() == zeros[[1, 5]].tolist() == [36.2, 58.5]
    assert (2, 0) in zeros
    assert (3, 4) not in zeros
    assert zeros.std_hz[1, 5].tolist() == [0.1, 0.2]
    assert ar.AntiresonanceSet([3], {(2,): [1.0]}) == ar.AntiresonanceSet(3, {2: [1.0]})
    named = ar.AntiresonanceSet(["tip", "base"], {("b", "a"): [1.0]}, channels=["a", "b", "c"])
    assert list(named) == [("a", "b")]
    assert named.channels == ("a", "b", "c")


def test_several_forces_print_without_parentheses_and_come_back_from_a_file_and_a_pickle():
    head, _, first, *_ = str(of_two_forces()).splitlines()
    assert (head, first.split()) == ("antiresonances, forces at 0, 4", ["1,", "5", "36.200", "0.100"])
    zeros = of_two_forces().drop((5, 1), 36.2, reason="hum").add((2, 0), 7.0)
    again = ar.AntiresonanceSet.from_json(zeros.to_json())
    assert again == zeros == pickle.loads(pickle.dumps(zeros))
    assert again.to_json() == zeros.to_json()
    assert again.edits == zeros.edits
    assert again.original() == of_two_forces()
    assert again.channels == tuple(range(6))


def test_several_forces_are_compared_followed_and_joined():
    before = of_two_forces()
    after = before.add((0, 2), 7.0)
    found = ar.compare(before, after)
    assert found.dof.tolist() == [(1, 5), (1, 5), (1, 2)]
    assert {dof: own.tolist() for dof, own in found.unmatched_b.items()} == {(0, 2): [7.0]}
    tracks = ar.track([before, after, before])
    assert tracks.of((1, 5)).tolist() == [0, 1]
    assert tracks.to_dataframe()["dof"].tolist()[:3] == ["1, 5", "1, 5", "1, 2"]
    moved = before.relabelled([0, 4], {i: i + 6 for i in range(6)})
    assert ar.merge_setups([before, moved], check="off").order == 2


def test_minors_are_reciprocal_when_a_hammer_roves():
    other = ar.AntiresonanceSet([1, 2], {(1, 5): [9.0]})
    joined = ar.merge_setups([of_two_forces(), other], excitation=[5, 1], check="off")
    assert {key: own.tolist() for key, own in joined.items()} == {(0, 4): [36.2, 58.5], (1, 2): [9.0]}


def test_several_dofs_have_one_spelling():
    pair = Dofs([1, 5])
    assert (label_text(3), label_text(pair), label_text(pair, listed=True)) == ("3", "1, 5", "(1, 5)")
    assert label_text((1, 5), "mass {}".format) == "mass 1, mass 5"
    assert (str(pair), forces_at(pair), forces_at(3)) == ("1, 5", "forces at 1, 5", "force at 3")
