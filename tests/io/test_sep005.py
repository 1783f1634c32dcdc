"""SDyPy's dictionaries, by the text of SEP 5."""

import numpy as np
import pytest

import antires_rs as ar
from reference.io_signals import recording

DATA = np.random.default_rng(0).standard_normal(100)


def channel(**changes):
    return {
        k: v
        for k, v in ({"data": DATA, "fs": 125, "name": "tip", "unit_str": "m/s²"} | changes).items()
        if v is not ...
    }


def test_there_and_back():
    made = recording(dofs=("tip", "12+Z"))
    channels = ar.to_sep005(made)
    back = ar.from_sep005(channels)
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
    with pytest.raises(ar.InvalidInputError, match="^rec: got dofs .*; wanted dofs that differ as text"):
        ar.to_sep005(recording(dofs=(1, "1")))
    with pytest.raises(ar.InvalidInputError, match="^rec: got dofs"):
        ar.to_sep005(recording(dofs=("force",)))
    with pytest.raises(ar.InvalidInputError, match="^unit: got 'g'"):
        ar.to_sep005(recording(), unit="g")


def test_units_roles_and_time():
    time = np.arange(100) / 125
    rec = ar.from_sep005(
        [
            channel(unit_str="g"),
            channel(name="root", fs=..., time=time, unit_str="g"),
            channel(name="push", unit_str="kN", start_timestamp="2023-06-29T15:00:00"),
        ]
    )
    assert (rec.fs_hz, rec.dofs) == (125.0, ("tip", "root"))
    np.testing.assert_allclose(rec.responses[1], 9.80665 * DATA, rtol=1e-15)
    np.testing.assert_allclose(rec.force, 1000.0 * DATA, rtol=1e-15)
    assert ar.from_sep005(channel(unit_str=None)).n_channels == 1
    assert ar.from_sep005([channel(), channel(name="b")], dofs=[1, None]).dofs == (1,)


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        ([], "^channels: got none"),
        ("tip", "^channels: got str"),
        ([3], r"^channels\[0\]: got int; wanted a dict"),
        ([channel(data=...)], r"^channels\[0\]: got no 'data'"),
        ([channel(unit_str=...)], r"^channels\[0\]: got no 'unit_str'"),
        ([channel(fs=...)], r"^channels\[0\]: got neither 'fs' nor 'time'"),
        ([channel(Fs=3)], "the key 'Fs'; wanted 'fs', as SEP 5 spells it"),
        ([channel(starttimestamp="x")], "the key 'starttimestamp'; wanted 'start_timestamp'"),
        ([channel(unit="g")], "the key 'unit', which SEP 5 prohibits"),
        ([channel(sampleFrequency=3)], "the key 'sampleFrequency', which SEP 5 prohibits"),
        ([channel(), channel()], "the name 'tip' twice"),
        ([channel(), channel(name="b", fs=126)], "rates from 125 to 126 Hz"),
        ([channel(data=DATA[:, None])], r"channels\[0\]\['data'\]: got an array of shape"),
        ([channel(name=3)], r"channels\[0\]\['name'\]: got 3"),
        ([channel(unit_str=3)], r"channels\[0\]\['unit_str'\]: got 3"),
        ([channel(fs=..., time=np.arange(9.0))], r"channels\[0\]\['time'\]: got 9 instants; wanted 100"),
        ([channel(fs=1000, time=np.arange(100) / 125)], r"\['fs'\]: got 1000 Hz beside a 'time' of 125 Hz"),
        ([channel(), channel(name="b", data=DATA[:50])], r"channels of \[50, 100\] samples"),
        (
            [channel(start_timestamp="a"), channel(name="b", start_timestamp="b")],
            "2 different start_timestamp",
        ),
    ],
)
def test_what_the_proposal_forbids_is_refused(channels, message):
    with pytest.raises(ar.InvalidInputError, match=message):
        ar.from_sep005(channels)
