"""What goes with a set through edits, files, names, problems and joining: sight, and what was left out."""

import json
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.measured.response_table import ResponseTable
from tests.support.same_sets import assert_same_set


def some(**options):
    return ar.AntiresonanceSet(0, {0: [8.7, 12.2], 1: [14.4]}, **options)


@pytest.fixture
def rich():
    """With values that were left out, and a peak that nothing explains, to the last bit."""
    return ar.AntiresonanceSet.from_tables(
        0,
        some().tables,
        left_out={0: ResponseTable([9.0, 9.5], scores={"why": ["no peak", "no peak"]}), 1: ResponseTable([])},
        unexplained_hz={0: np.array([33.3 + 1e-13]), 1: np.empty(0)},
        sees="transmissibility",
        channels=[0, 1, 5],
        options={"preset": "strict"},
    )


def test_edits_and_files_keep_it(rich, tmp_path):
    # By default nothing is known, and the dofs are the channels.
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
    assert "left out: 2 (2 no peak), see .left_out\nunexplained: 1, see .unexplained_hz" in str(rich)


def test_other_names_keep_it_and_channels_unless_one_has_none(rich):
    named = rich.relabelled("a", {0: "a", 1: "b", 5: "c"})
    assert (named.sees, named.channels) == ("transmissibility", ("a", "b", "c"))
    assert_same_set(named.relabelled(0, {"a": 0, "b": 1, "c": 5}), rich)
    assert rich.relabelled(3, {0: 3, 1: 4}).channels == ()


def test_problems_keep_it(rich, tmp_path):
    model = ar.MassSpringChain(np.full(7, 1.0), np.full(6, 5e3))
    problem = ar.UpdatingProblem(model, ar.stiffness_factor([0], bounds=(0.5, 1.5)), rich)
    ar.update(problem, rng=0, optimizer=ar.IslandGA(max_evaluations=500)).save(tmp_path / "result.npz")
    (back,) = ar.UpdateResult.load(tmp_path / "result.npz").problem.measured
    assert_same_set(rich, back)


def test_identification_says_what_its_route_sees():
    chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 700.0])
    record = chain.simulate(excitation=0, fs_hz=40.0, duration_s=400.0, damping_ratio=0.01, rng=0)
    for route in ("transmissibility", "frf"):
        found = ar.identify_antiresonances(
            record, excitation=0, band_hz=(1.0, 12.0), route=route, dofs=[0, 1], check="off"
        )
        assert (found.sees, found.channels, list(found)) == (route, (0, 1, 2), [0, 1])


def test_joined_setups_are_of_one_kind_or_of_none():
    sets = [some(sees="frf"), some(sees="frf", channels=[0, 1, 4])]
    merged = ar.merge_setups(sets, check="off")
    assert (merged.sees, merged.channels) == ("frf", (0, 1, 4))
    assert ar.merge_setups([sets[0], some(sees="transmissibility")], check="off").sees is None
    moved = [ar.AntiresonanceSet(k, {"tip": [f]}, sees="frf") for k, f in ((3, 20.1), (4, 25.3))]
    merged = ar.merge_setups(moved, excitation="tip", check="off")
    assert (merged.sees, merged.channels) == ("frf", ())


# -- Files of older versions
#
# antiresonances_0.1.0.json was made by that version: chain8 at level 0, 5 % noise, 64 s, rng=7; dofs 0, 2 and
# 7 identified with excitation=0, band_hz=(3, 130); 48.63 Hz dropped from dof 2, 125 Hz added to dof 0.

FILE = Path(__file__).with_name("antiresonances_0.1.0.json")


def as_read(values):
    return [None if value != value else value for value in values.tolist()]


def test_every_number_is_read():
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


def test_what_was_done_by_hand_is_known_again_and_written_as_it_was():
    found = ar.AntiresonanceSet.load(FILE)
    assert found.by_hand() == {(0, 125.0)}
    assert found.tables[0].by_hand.tolist() == [False] * 7 + [True]
    edits = [("drop", 2, "mains hum of the shaker"), ("add", 0, "clear in the phase")]
    assert [(e.action, e.dof, e.reason) for e in found.edits] == edits
    assert found.original().by_hand() == set()
    assert found.original()[2].size == found[2].size + 1
    assert json.loads(found.to_json()) == json.loads(FILE.read_text())
    assert (found.sees, dict(found.left_out), dict(found.unexplained_hz)) == (None, {}, {})


def test_files_of_version_1_still_load(tmp_path):
    path = tmp_path / "old.json"
    path.write_text(
        '{"format": "antires_rs.AntiresonanceSet", "version": 1, "excitation": 0, "dofs": ['
        '{"dof": 0, "freq_hz": [1.0, 2.0], "damping_ratio": [0.1, 0.2]}, '
        '{"dof": 1, "freq_hz": []}]}'
    )
    assert ar.AntiresonanceSet.load(path) == ar.AntiresonanceSet(0, {0: [1.0, 2.0], 1: []}, {0: [0.1, 0.2]})
