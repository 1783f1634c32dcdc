"""Signals of other packages: SDyPy's dictionaries by the text of SEP 5, pandas, xarray."""

from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from reference.io_signals import recording, response
from tests.support.refusals import refused
from tests.support.snapshots import refusal, replay

DATA = np.random.default_rng(0).standard_normal(100)


def channel(**changes):
    made = {"data": DATA, "fs": 125, "name": "tip", "unit_str": "m/s²"} | changes
    return {key: value for key, value in made.items() if value is not ...}


def test_there_and_back():
    made = recording(dofs=("tip", "12+Z"))
    back = ar.from_sep005(ar.to_sep005(made))
    np.testing.assert_array_equal(back.responses, made.responses)
    np.testing.assert_array_equal(back.force, made.force)
    assert (back.fs_hz, back.dofs) == (made.fs_hz, made.dofs)
    whole = recording()
    again = ar.from_sep005(ar.to_sep005(whole), dofs={"0": 0, "tip": "tip", "12+Z": "12+Z"})
    assert again.dofs == whole.dofs


def test_what_is_written_keeps_to_the_proposal():
    for one in ar.to_sep005(recording()):
        assert {"data", "name", "unit_str", "fs"} <= set(one)
        assert isinstance(one["data"], np.ndarray)
        assert isinstance(one["name"], str)
        assert not {"unit", "timestamp", "signal", "sample_frequency", "Fs"} & set(one)
    refused("^rec: got dofs .*; wanted dofs that differ as text", ar.to_sep005, recording(dofs=(1, "1")))
    refused("^rec: got dofs", ar.to_sep005, recording(dofs=("force",)))


def test_units_roles_and_time():
    time = np.arange(100) / 125
    push = channel(name="push", unit_str="kN", start_timestamp="2023-06-29T15:00:00")
    root = channel(name="root", fs=..., time=time, unit_str="g")
    rec = ar.from_sep005([channel(unit_str="g"), root, push])
    assert (rec.fs_hz, rec.dofs) == (125.0, ("tip", "root"))
    np.testing.assert_allclose(rec.responses[1], 9.80665 * DATA, rtol=1e-15)
    np.testing.assert_allclose(rec.force, 1000.0 * DATA, rtol=1e-15)
    assert ar.from_sep005(channel(unit_str=None)).n_channels == 1
    assert ar.from_sep005([channel(), channel(name="b")], dofs=[1, None]).dofs == (1,)


def test_what_the_proposal_forbids_is_refused():
    file = Path(__file__).with_name("wrong_channels.txt")
    replay(file, lambda channels: refusal(lambda: ar.from_sep005(eval(channels))))


ZEROS = ar.AntiresonanceSet(0, {0: [8.0, 3.0], "tip": [5.0], 2: []}, std_hz={0: [0.2, 0.1]})


def test_frames_of_pandas():
    pytest.importorskip("pandas", reason="pandas is optional and not installed")
    rec, resp = recording(), response()
    frame = rec.to_dataframe()
    assert list(frame.columns) == [0, "tip", "12+Z", "force"]
    assert frame.index.name == "time_s"
    np.testing.assert_array_equal(frame["tip"], rec.responses[1])
    np.testing.assert_array_equal(frame.index, np.arange(rec.n_samples) / rec.fs_hz)
    frame = resp.to_dataframe()
    assert list(frame.columns) == list(resp.dofs)
    np.testing.assert_array_equal(frame.to_numpy().T, resp.values)
    assert list(ZEROS.to_dataframe()["freq_hz"]) == [3.0, 8.0, 5.0]


def test_datasets_of_xarray():
    pytest.importorskip("xarray", reason="xarray is optional and not installed")
    rec, resp = recording(), response(kind="transmissibility")
    data = rec.to_xarray()
    np.testing.assert_array_equal(data["responses"].sel(dof="tip"), rec.responses[1])
    assert data.attrs == {"fs_hz": 512.0}
    assert data["force"].dims == ("time_s",)
    data = resp.to_xarray()
    np.testing.assert_array_equal(data["values"].sel(dof=0), resp.values[0])
    np.testing.assert_array_equal(data["coherence"], resp.coherence)
    assert data.attrs == {"kind": "transmissibility", "reference": "tip", "n_averages": 25.5}
    data = ZEROS.to_xarray()
    assert data.sizes == {"dof": 3, "rank": 2}
    np.testing.assert_array_equal(data["freq_hz"], [[3.0, 8.0], [5.0, np.nan], [np.nan, np.nan]])
    np.testing.assert_array_equal(data["std_hz"].sel(dof=0), [0.1, 0.2])
