"""The set by hand: order, mapping, file, and what it refuses."""

import json
import sys
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import antires_rs as ar
from antires_rs.exceptions import InvalidInputError, MissingDependencyError
from antires_rs.identification.scores import graded, grades
from antires_rs.measured.antiresonance_set import AntiresonanceSet, doubts_of
from antires_rs.measured.response_table import ResponseTable
from tests.support.refusals import each_of


def example():
    return AntiresonanceSet(
        "hammer",
        {0: [36.2, 12.1], "tip": 8.0, 2: []},
        damping_ratio={0: [0.02, 0.01]},
        std_hz={0: [0.2, 0.1], 2: []},
    )


def test_it_is_a_mapping_in_ascending_order():
    made = example()
    assert {dof: freq.tolist() for dof, freq in made.items()} == {0: [12.1, 36.2], "tip": [8.0], 2: []}
    assert (len(made), 0 in made, 1 in made) == (3, True, False)
    with pytest.raises(KeyError):
        made[1]
    # Companions follow their frequency.
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
OF_SET += [{"excitation": [0]}, {"edits": 3}]
OF_DOF = [{"freq_hz": [1.0, None]}, {"freq_hz": [-1.0, 2.0]}, {"damping_ratio": [0.1]}, {"left_out": [1.0]}]
OF_DOF += [{"left_out": {"freq_hz": [-1.0]}}, {"unexplained_hz": [0.0]}, {"unexplained_hz": "x"}]
OF_DOF += [{"scores": {"rows": [1]}}]
OF_EDIT = [{"action": "moved"}, {"freq_hz": "12"}, {"more": 1}]
DAMAGES = [
    *((lambda d, new=new: d.update(new)) for new in OF_SET),
    *((lambda d, new=new: d["dofs"][0].update(new)) for new in OF_DOF),
    *((lambda d, new=new: d["edits"][0].update(new)) for new in OF_EDIT),
    lambda d: d.pop("dofs"),
    lambda d: d.pop("before_edits"),
    lambda d: d["dofs"].append(d["dofs"][0]),
    lambda d: d["dofs"][0].pop("freq_hz"),
    lambda d: d["edits"][0].pop("freq_hz"),
]


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_is_named(tmp_path, damage):
    whole = example().add("tip", 9.0).to_json()
    data = json.loads(whole)
    damage(data)
    for content in (json.dumps(data).encode(), b"\x00\x01", b"[1, 2]", whole[:-20].encode(), b"\xff"):
        (tmp_path / "set.json").write_bytes(content)
        with pytest.raises(InvalidInputError, match="^path: got .*set.json"):
            AntiresonanceSet.load(tmp_path / "set.json")


def test_equality():
    values = {0: [36.2, 12.1], "tip": 8.0, 2: []}
    assert example() == example()
    assert example() != AntiresonanceSet("hammer", values)
    assert example() != AntiresonanceSet(1, values, {0: [0.02, 0.01]}, {0: [0.2, 0.1], 2: []})
    assert example() != "a string"
    # Companions that are not known are NaN or absent.
    made = AntiresonanceSet(0, {0: [1.0, 2.0], 1: [3.0]}, {0: [np.nan, 0.1], 1: [np.nan]})
    assert np.isnan(made.damping_ratio[0][0])
    assert 1 not in made.damping_ratio
    assert made == AntiresonanceSet(0, {0: [1.0, 2.0], 1: [3.0]}, {0: [np.nan, 0.1]})


def test_table_and_repr():
    assert repr(example()) == "AntiresonanceSet(excitation='hammer', values by dof {0: 2, 'tip': 1, 2: 0})"
    # A line each, the dof once; example() states a deviation for some.
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
    with pytest.raises(MissingDependencyError, match="pip install pandas"):
        example().to_dataframe()


WRONG = {
    "freq_hz": [{}, [1.0, 2.0], {0: [1.0, -2.0]}, {0: [0.0]}, {0: [np.nan]}, {0: ["x"]}, {1.5: [1.0]}],
    "excitation": [None],
    "damping_ratio": [{1: [0.1]}, {0: [0.1, 0.2]}, [0.1], {0: ["x"]}, {0: [np.inf]}],
    "std_hz": [{0: [-0.1]}],
    "scores": [{5: {"rows": [1]}}, {0: {"rows": [1, 2]}}],
    "sees": ["both"],
    "channels": ["01", [5], 3],
}


@pytest.mark.parametrize(("argument", "value"), each_of(WRONG))
def test_bad_arguments_are_named(argument, value):
    with pytest.raises(InvalidInputError, match=f"^{argument}.*: got "):
        AntiresonanceSet(**({"excitation": 0, "freq_hz": {0: [1.0]}} | {argument: value}))


# -- The table of a response; printed: frequency, deviation, grade and doubts
def table():
    made = ResponseTable.of_sweep(
        [8.7, 23.9, 31.0],
        [0.01, 0.01, 0.01],
        [0.004, 0.005, 0.2],
        rows=[45, 30, 5],
        spread=[1e-5, 4e-3, 4e-3],
        dominance=[1.0, 1.0, 0.5],
        how=["chain", "chain", "persistent"],
    )
    return graded(made.with_scores(residual=[0.01, 0.01, 0.2], prominence_db=[15.0, 2.0, 2.0]))


def test_rows_of_a_table_are_taken_in_order_and_no_column_has_another_length():
    made = ResponseTable.of_sweep(
        [36.2, 12.2, 20.0],
        [0.02, 0.01, 0.03],
        rows=[30, 11, 25],
        spread=[1e-4, 2e-4, 3e-4],
        dominance=[1.0, 0.9, 0.8],
        how=["chain", "persistent", "chain"],
    )
    assert made.freq_hz.tolist() == [12.2, 20.0, 36.2]
    assert made.rows.tolist() == made.orders.tolist() == [11, 25, 30]
    assert np.isnan([made.std_hz, made.residual]).all()
    for chosen in ([0, 2], np.array([True, False, True])):
        some = made.take(chosen)
        assert (some.freq_hz.tolist(), some.how.tolist()) == ([12.2, 36.2], ["persistent", "chain"])
    assert (len(made.take([])), list(made.take([]).scores)) == (0, list(made.scores))
    assert made.rows.dtype == made.take([]).rows.dtype == np.int64
    with pytest.raises(InvalidInputError, match=r"^std_hz: got an array of shape \(1,\); wanted 2"):
        ResponseTable([1.0, 2.0], std_hz=[0.1])
    with pytest.raises(FrozenInstanceError):
        made.freq_hz = np.zeros(3)
    with pytest.raises(TypeError, match="read-only"):
        made.scores["how"] = ["chain"] * 3


def test_grades_count_what_is_passed_and_what_is_not_known_is_not():
    good, bad = (30, 1e-4, 0.95, 0.05, 10.0), (12, 1e-2, 0.50, 0.50, 1.0)
    for passed, word in enumerate(["weak", "weak", "weak", "fair", "sure", "sure"]):
        assert grades(*np.array([*good[:passed], *bad[passed:]])[:, None]).tolist() == [word]
    assert grades(*np.array([30, 1e-4, np.nan, np.nan, 10.0])[:, None]).tolist() == ["fair"]
    assert grades(*[np.empty(0)] * 5).size == 0


class Other:
    def is_confirmed(self, dof, freq_hz):
        return {8.7: True, 23.9: None, 31.0: False}[freq_hz]


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
    words = doubts_of(0, table(), Other())
    assert words == [[], ["unsteady", "no clear peak"], [*weak.split(", "), "not confirmed"]]
