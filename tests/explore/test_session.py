"""A set on the desk: edits, undo, another band, and what a click means."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.measured.replay import asked_of, replayed
from tests.support.four_masses import BAND

pytest.importorskip("bokeh", reason="the page needs bokeh")

from antires_rs.explore.page.picks import Click, picked
from antires_rs.explore.page.session import Session


@pytest.fixture
def session(identified, record):
    return Session(identified, record, band_hz=BAND, options={"max_order": 30})


def test_undo_and_redo_go_through_all_that_was_done(session, identified):
    seen = [session.zeros]
    session.drop(0, float(identified[0][0]), "hum")
    seen.append(session.zeros)
    session.add(0, 3.21)
    seen.append(session.zeros)
    session.reword(0, "mains hum")
    seen.append(session.zeros)
    for zeros in seen[-2::-1]:
        session.undo()
        assert session.zeros == zeros
        assert session.zeros.edits == zeros.edits
    assert not session.can_undo
    assert session.undo() == "nothing to be undone"
    for zeros in seen[1:]:
        session.redo()
        assert session.zeros.edits == zeros.edits
    session.undo()
    session.add(1, 3.3)
    assert not session.can_redo


def test_no_edit_is_lost_by_a_change_of_band(session, identified):
    low, high = float(identified[0][0]), float(identified[0][-1])
    session.drop(0, low, "hum")
    session.add(0, 3.21, "phase")
    assert low < 2.5 < high
    session.identify((2.5, 9.0))  # the dropped value is below it now
    assert session.now.waits == ("no value there now", None)
    assert [edit.action for edit in session.zeros.edits] == ["add"]
    session.identify(BAND)
    assert session.now.waits == (None, None)
    assert [(edit.action, edit.reason) for edit in session.zeros.edits] == [("drop", "hum"), ("add", "phase")]
    assert session.zeros[0][session.zeros.tables[0].by_hand].tolist() == [3.21]
    assert np.abs(session.zeros[0] - low).min() > 0.01 * low


def test_what_is_identified_later_is_not_added_twice():
    narrow = ar.AntiresonanceSet(0, {0: [8.7]})
    asked = asked_of(narrow.add(0, 23.9, reason="seen by eye"))
    wide, waits = replayed(ar.AntiresonanceSet(0, {0: [8.7, 23.91]}), asked)
    assert wide[0].tolist() == [8.7, 23.91]
    assert waits == ["identified there now"]
    # A value beside another one is no such case.
    asked = asked_of(wide.add(0, 23.85))
    again, waits = replayed(ar.AntiresonanceSet(0, {0: [8.7, 23.91]}), asked)
    assert again[0].tolist() == [8.7, 23.85, 23.91]
    assert waits == [None]
    _, waits = replayed(ar.AntiresonanceSet(0, {1: [8.7]}), asked)
    assert waits == ["this response is not there now"]


def test_replaying_on_the_same_set_gives_the_same_set(identified):
    value = float(identified[1][0])
    edited = identified.drop(1, value, reason="a").add(1, value + 0.001, std_hz=0.1, reason="b")
    again, waits = replayed(identified, asked_of(edited))
    assert again == edited
    assert again.edits == edited.edits
    assert waits == [None, None]


def test_taking_back_leaves_the_other_edits(session, identified):
    low = float(identified[0][0])
    session.drop(0, low, "hum")
    session.add(0, 3.21, "phase")
    session.add(1, 3.3, "dip")
    session.take_back(1)
    assert [(edit.action, edit.dof) for edit in session.zeros.edits] == [("drop", 0), ("add", 1)]
    session.restore(0, low)
    assert session.zeros[0].tolist() == identified[0].tolist()
    assert not session.zeros.tables[0].by_hand.any()  # as it was identified
    session.drop(1, 3.3)  # what was added by hand leaves no trace
    assert not session.zeros.edits
    with pytest.raises(ar.InvalidInputError, match="a value that was dropped"):
        session.restore(0, low)


def test_the_first_identification_makes_the_set(record, identified):
    session = Session(None, record, excitation=0, band_hz=BAND, options={"max_order": 30})
    assert not session.identified
    assert session.curve(0) is not None
    session.make_again(asked_of(identified.drop(0, identified[0][0])))
    assert session.now.waits == ("not identified yet",)
    session.identify()
    assert session.zeros[0].tolist() == pytest.approx(identified[0][1:].tolist())
    assert not session.can_undo


def test_a_set_alone_can_be_edited(identified, tmp_path):
    session = Session(ar.AntiresonanceSet.from_json(identified.to_json()), save_to=tmp_path / "a.json")
    with pytest.raises(ar.InvalidInputError, match="the measurement"):
        session.identify((1.0, 2.0))
    session.add(0, 3.21)
    assert session.unsaved
    session.save()
    assert not session.unsaved
    session.undo()
    assert session.unsaved
    session.save()  # its own file is replaced
    other = Session(identified, save_to=tmp_path / "a.json")
    with pytest.raises(ar.InvalidInputError, match="not there yet"):
        other.save()
    other.save(replace_file=True)
    assert ar.AntiresonanceSet.load(tmp_path / "a.json") == identified
    with pytest.raises(ar.InvalidInputError, match="path"):
        Session(identified).save()


def clicked(figure, x, y=0.0, x_per_px=0.01, y_per_px=0.1):
    return Click(figure, x, y, x_per_px, y_per_px)


def test_a_click_means_what_is_nearest(identified, record, session):
    value = float(identified[0][1])
    assert picked(identified, 0, clicked("stabilization", value + 0.05)).action == "drop"
    assert picked(identified.drop(0, value), 0, clicked("curve", value)).action == "restore"
    assert picked(identified, 0, clicked("coherence", 0.5 * (value + identified[0][0]))) is None
    from antires_rs.plotting.stabilization import pole_table

    order, freq, damping, _ = pole_table(identified.diagrams[0])
    far = np.abs(freq[:, None] - identified[0]).min(axis=1) > 0.2
    at = int(np.flatnonzero(far)[0])
    pick = picked(identified, 0, clicked("stabilization", freq[at], order[at]))
    assert (pick.action, pick.freq_hz, pick.damping_ratio) == ("add", freq[at], damping[at])
    empty = clicked("stabilization", freq[at], order[at], 1e-9, 1e-9)
    assert picked(identified, 0, empty) is not None
    assert picked(identified, 0, clicked("stabilization", freq[at] + 1e-3, order[at], 1e-9, 1e-9)) is None


def test_a_click_on_a_curve_means_its_dip(identified, session):
    value = float(identified[0][1])
    without = ar.AntiresonanceSet(0, {0: []})
    curve = session.curve(0)
    pick = picked(without, 0, clicked("curve", value + 0.02), curve)
    assert pick.action == "add"
    assert pick.freq_hz == pytest.approx(value, abs=0.1)
    assert pick.freq_hz in curve.freq_hz
    assert picked(without, 0, clicked("curve", value), None) is None


def test_what_fits_saw_and_did_not_accept_can_be_added(record):
    h = ar.frf(record, nperseg=512)
    zeros = ar.identify_antiresonances(h, excitation=0, band_hz=BAND, min_share=1.0)
    dof = next(dof for dof, table in zeros.left_out.items() if len(table))
    table, diagram = zeros.left_out[dof], zeros.diagrams[dof]
    pick = picked(
        zeros, dof, clicked("stabilization", table.freq_hz[0], float(diagram.orders[-1]) + 0.2, 1e-6)
    )
    assert (pick.action, pick.freq_hz, pick.std_hz) == ("add", table.freq_hz[0], table.std_hz[0])
