"""A set on the desk: edits, another band, and what a click means."""

import errno
import shutil

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.measured.replay import asked_in, asked_of, replayed
from tests.support.four_masses import BAND

pytest.importorskip("bokeh", reason="the page needs bokeh")

from antires_rs.figures.identification import pole_table
from antires_rs.figures.page_session import TAKEN, Click, Session, picked
from tests.support.refusals import refused


def test_what_is_identified_later_is_not_added_twice(identified):
    value = float(identified[1][0])
    edited = identified.drop(1, value, reason="a").add(1, value + 0.001, std_hz=0.1, reason="b")
    again, waits = replayed(identified, asked_of(edited))
    assert (again, again.edits, waits) == (edited, edited.edits, [None, None])
    asked = asked_of(ar.AntiresonanceSet(0, {0: [8.7]}).add(0, 23.9, reason="seen by eye"))
    wide, waits = replayed(ar.AntiresonanceSet(0, {0: [8.7, 23.91]}), asked)
    assert wide[0].tolist() == [8.7, 23.91]
    assert waits == ["identified there now"]
    asked = asked_of(wide.add(0, 23.85))
    again, waits = replayed(ar.AntiresonanceSet(0, {0: [8.7, 23.91]}), asked)
    assert again[0].tolist() == [8.7, 23.85, 23.91]
    assert waits == [None]
    _, waits = replayed(ar.AntiresonanceSet(0, {1: [8.7]}), asked)
    assert waits == ["this response is not there now"]


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
    refused("a value that was dropped", session.restore, 0, low)


def test_the_first_identification_makes_the_set(record, identified):
    session = Session(None, record, excitation=0, band_hz=BAND, options={"max_order": 30})
    assert not session.identified
    assert session.curve(0) is not None
    session.make_again(asked_of(identified.drop(0, identified[0][0])))
    assert session.now.waits == ("not identified yet",)
    session.identify()
    assert session.zeros[0].tolist() == pytest.approx(identified[0][1:].tolist())


def test_a_set_alone_can_be_edited(identified, tmp_path):
    session = Session(ar.AntiresonanceSet.from_json(identified.to_json()), save_to=tmp_path / "a.json")
    refused("the measurement", session.identify, (1.0, 2.0))
    session.add(0, 3.21)
    assert session.unsaved
    session.save()
    assert not session.unsaved
    session.take_back(0)
    assert session.unsaved
    session.save()  # its own file is replaced
    other = Session(identified, save_to=tmp_path / "a.json")
    refused("not there yet", other.save)
    other.save(replace_file=True)
    assert ar.AntiresonanceSet.load(tmp_path / "a.json") == identified
    refused("path", Session(identified).save)


def clicked(figure, x, y=0.0, x_per_px=0.01, y_per_px=0.1):
    return Click(figure, x, y, x_per_px, y_per_px)


def test_a_click_means_what_is_nearest(identified, record, session):
    value = float(identified[0][1])
    assert picked(identified, 0, clicked("stabilization", value + 0.05)).action == "drop"
    assert picked(identified.drop(0, value), 0, clicked("curve", value)).action == "restore"
    assert picked(identified, 0, clicked("coherence", 0.5 * (value + identified[0][0]))) is None
    order, freq, damping, _ = pole_table(identified.diagrams[0])
    at = int(np.flatnonzero(np.abs(freq[:, None] - identified[0]).min(axis=1) > 0.2)[0])
    pick = picked(identified, 0, clicked("stabilization", freq[at], order[at]))
    assert (pick.action, pick.freq_hz, pick.damping_ratio) == ("add", freq[at], damping[at])
    assert picked(identified, 0, clicked("stabilization", freq[at], order[at], 1e-9, 1e-9)) is not None
    assert picked(identified, 0, clicked("stabilization", freq[at] + 1e-3, order[at], 1e-9, 1e-9)) is None
    assert session.click(0, clicked("coherence", 0.5 * (value + identified[0][0]))) is None
    for verb in ("dropped", "brought back"):
        assert session.click(0, clicked("curve", value)).startswith(verb)
    assert session.click(0, clicked("stabilization", freq[at], order[at])).startswith("added")


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
    zeros = ar.identify_antiresonances(h, excitation=0, band_hz=BAND, fit=ar.FitOptions(min_share=1.0))
    dof = next(dof for dof, table in zeros.left_out.items() if len(table))
    table, diagram = zeros.left_out[dof], zeros.diagrams[dof]
    at = clicked("stabilization", table.freq_hz[0], float(diagram.orders[-1]) + 0.2, 1e-6)
    pick = picked(zeros, dof, at)
    assert (pick.action, pick.freq_hz, pick.std_hz) == ("add", table.freq_hz[0], table.std_hz[0])


def test_edits_that_wait_are_in_the_file(session, identified, tmp_path):
    value = float(identified[0][-1])
    session.drop(0, value, "hum")
    session.identify((1.0, 0.9 * value))
    assert session.now.waits == ("no value there now",)
    assert session.unsaved
    assert not session.now.warned
    assert "1 still waits" in session.save()
    assert not session.unsaved
    zeros, asked = asked_in(tmp_path / "zeros.json")
    assert zeros == session.zeros == ar.AntiresonanceSet.load(tmp_path / "zeros.json")
    assert asked == session.now.asked
    again = Session(identified)
    again.make_again(asked)
    assert [edit.reason for edit in again.zeros.edits] == ["hum"]
    opened = Session(zeros)
    opened.opened(asked, tmp_path / "zeros.json")
    assert not opened.unsaved
    assert opened.now.waits == ("no value there now",)
    (tmp_path / "zeros.json").write_text((tmp_path / "zeros.json").read_text().replace('"near"', '"far"'))
    refused("damaged", asked_in, tmp_path / "zeros.json")


def test_a_file_that_another_page_wrote_is_not_replaced_unasked(identified, tmp_path):
    file = tmp_path / "zeros.json"
    identified.save(file)
    pages = [Session(identified), Session(identified)]
    for page in pages:
        page.opened((), file)
    pages[0].add(0, 3.21)
    pages[0].save()
    pages[1].add(0, 4.32)
    with pytest.raises(ar.InvalidInputError, match="changed meanwhile") as caught:
        pages[1].save()
    assert caught.value.path == (TAKEN,)
    assert ar.AntiresonanceSet.load(file) == pages[0].zeros
    pages[1].save(replace_file=True)
    pages[1].add(0, 4.5)
    pages[1].save()
    assert ar.AntiresonanceSet.load(file) == pages[1].zeros


def test_what_was_not_saved_replaces_nothing_and_finds_a_place(identified, tmp_path, monkeypatch):
    folder = tmp_path / "there"
    folder.mkdir()
    session = Session(identified, save_to=folder / "zeros.json")
    assert session.keep_unsaved() is None
    session.add(0, 3.21)
    kept = [session.keep_unsaved() for _ in range(3)]
    assert [path.name for path in kept] == [f"zeros_unsaved{end}.json" for end in ("", "_2", "_3")]
    shutil.rmtree(folder)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert session.keep_unsaved() == tmp_path / "zeros_unsaved.json"
    assert ar.AntiresonanceSet.load(tmp_path / "zeros_unsaved.json") == session.zeros
    refused("a folder that exists", session.save)


def test_a_disk_that_refuses_is_told(identified, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    session = Session(identified, save_to=tmp_path / "zeros.json")
    session.add(0, 3.21)
    monkeypatch.setattr("antires_rs.figures.page_session.write_atomically", full)
    refused("cannot be written .No space left", session.save)
    assert session.unsaved
    refused("in neither of which", session.keep_unsaved)


def test_an_added_value_outside_of_the_band_is_told(session, record):
    assert "outside" not in session.add(0, 3.21)
    above = 0.5 * (BAND[1] + 0.5 * record.fs_hz)
    assert f"outside of the band of {BAND[0]:g} to {BAND[1]:g} Hz" in session.add(0, above)
    refused("as the data reach", session.add, 0, record.fs_hz)
    assert len(session.zeros.edits) == 2
