"""Work that takes seconds says so on standard error, if anyone is there to read it."""

import io
import re
import sys
import threading
import time

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.support import progress as _progress

CASE = ar.cases.chain8()


@pytest.fixture
def at_once(monkeypatch):
    monkeypatch.setattr(_progress, "FIRST_S", 0.0)
    monkeypatch.setattr(_progress, "EVERY_S", 0.001)


def test_a_line_names_the_step_and_ends(at_once, capsys):
    with _progress.waiting("working", True):
        _progress.step("part one, at length")
        time.sleep(0.05)
        with _progress.waiting("part two", None):
            time.sleep(0.05)
    said = capsys.readouterr()
    assert said.out == ""
    assert "\rworking: part one, at length   0 s " in said.err
    # What the longer line left is overwritten.
    assert f"\r{'working: part two   0 s ':<{len('working: part one, at length   0 s ')}}" in said.err
    assert said.err.endswith("\n")
    assert said.err.count("\n") == 1


def test_nothing_is_said_in_the_first_second_nor_without_a_terminal(capsys, monkeypatch):
    before = threading.active_count()
    with _progress.waiting("working", True):
        pass
    monkeypatch.setattr(_progress, "FIRST_S", 0.0)
    with _progress.waiting("working", None):
        time.sleep(0.02)
    with _progress.waiting("working", False), _progress.waiting("within", True):
        time.sleep(0.02)
    assert capsys.readouterr().err == ""
    assert threading.active_count() == before
    monkeypatch.setattr(sys, "stderr", None)  # as under pythonw
    with _progress.waiting("working", True):
        _progress.step("silent")


def test_on_a_terminal_it_is_shown_unasked(at_once, monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)
    record = CASE.experiment(0, rng=0, duration_s=64.0)
    zeros = ar.identify_antiresonances(record, excitation=0, band_hz=CASE.band_hz)
    ar.identify_modes(record, band_hz=CASE.band_hz)
    ar.check_data(record, excitation=0, band_hz=CASE.band_hz)
    said = screen.getvalue()
    shown = [r"recording the virtual test: response \d of 8", r"identifying antiresonances: response \d of 8"]
    shown += ["identifying antiresonances: checking the data", "identifying modes", "\rchecking the data"]
    assert all(re.search(words, said) for words in shown)
    assert len(zeros) == 8
    length = len(said)
    ar.identify_antiresonances(record, excitation=0, band_hz=CASE.band_hz, progress=False)
    CASE.experiment(0, rng=0, duration_s=64.0, progress=False)
    assert len(screen.getvalue()) == length


def test_antiresonances_of_many_dofs_come_from_the_background_unchanged(at_once, monkeypatch, capsys):
    monkeypatch.setattr(_progress, "_shown", lambda progress: True)
    chain = ar.MassSpringChain(np.ones(240), np.full(239, 1e4))
    many = chain.antiresonances([0, 120], 0)
    assert "antiresonances of 2 responses   0 s" in capsys.readouterr().err
    monkeypatch.setattr("antires_rs.models.structural_model.MANY_DOFS", 10**6)
    np.testing.assert_array_equal(np.concatenate(many), np.concatenate(chain.antiresonances([0, 120], 0)))
    assert capsys.readouterr().err == ""


def test_an_error_in_the_background_is_the_callers():
    def fail():
        raise ar.NumericalError("zeros", "no such zero")

    with pytest.raises(ar.NumericalError, match="no such zero"):
        _progress.interruptible(fail, "failing")


def test_warnings_point_at_the_callers_line(monkeypatch):
    record = CASE.experiment(0, rng=0, duration_s=60.0, noise=0.01)
    short = ar.Recording(record.responses[:, :4096], record.fs_hz, dofs=record.dofs)
    with pytest.warns(ar.AntiresWarning, match="data check") as caught:
        ar.identify_antiresonances(short, excitation=0, band_hz=CASE.band_hz)
    assert [w.filename for w in caught] == [__file__] * len(caught)
    monkeypatch.setattr("antires_rs.models.structural_model._LONGEST_LEAD_IN", 10_000)
    with pytest.warns(ar.AntiresWarning, match="lead-in") as caught:
        CASE.true_model(0).simulate(excitation=0, fs_hz=512.0, duration_s=1.0, damping_ratio=1e-9, rng=0)
    assert [w.filename for w in caught] == [__file__] * len(caught)
