"""Files of older versions: version 1 of the format, and a set of antires_rs 0.1.0.

antiresonances_0.1.0.json was made by that version: chain8 at level 0, 5 % noise, 64 s, rng=7; dofs 0, 2 and 7
identified with excitation=0, band_hz=(3, 130); 48.63 Hz dropped from dof 2, 125 Hz added to dof 0.
"""

import json
from pathlib import Path

import numpy as np

from antires_rs.measured.antiresonance_set import AntiresonanceSet

FILE = Path(__file__).with_name("antiresonances_0.1.0.json")


def as_read(values):
    return [None if value != value else value for value in values.tolist()]


def test_every_number_is_read():
    found, data = AntiresonanceSet.load(FILE), json.loads(FILE.read_text())
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
    found = AntiresonanceSet.load(FILE)
    assert found.by_hand() == {(0, 125.0)}
    assert found.tables[0].by_hand.tolist() == [False] * 7 + [True]
    edits = [("drop", 2, "mains hum of the shaker"), ("add", 0, "clear in the phase")]
    assert [(e.action, e.dof, e.reason) for e in found.edits] == edits
    assert found.original().by_hand() == set()
    assert found.original()[2].size == found[2].size + 1
    assert json.loads(found.to_json()) == json.loads(FILE.read_text())


def test_files_of_version_1_still_load(tmp_path):
    path = tmp_path / "old.json"
    path.write_text(
        '{"format": "antires_rs.AntiresonanceSet", "version": 1, "excitation": 0, "dofs": ['
        '{"dof": 0, "freq_hz": [1.0, 2.0], "damping_ratio": [0.1, 0.2]}, '
        '{"dof": 1, "freq_hz": []}]}'
    )
    assert AntiresonanceSet.load(path) == AntiresonanceSet(0, {0: [1.0, 2.0], 1: []}, {0: [0.1, 0.2]})
