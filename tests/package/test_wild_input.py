"""Input that is far off: each is an error of ours, at once."""

import os
import time

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app.job import read_job
from antires_rs.exceptions import InvalidInputError, UnsuitableDataError

RNG = np.random.default_rng(0)
NOISE = RNG.standard_normal((3, 64))


@pytest.mark.parametrize(
    "text",
    [
        "[data]\nband_hz = " + "[" * 5000 + "]" * 5000,
        "[data]\nband_hz = " + "{a=" * 5000 + "1" + "}" * 5000,
        "[search]\nseed = " + "1" * 5000,
        ".".join(["a"] * 20_000) + " = 1",
        "[" + ".".join(["a"] * 20_000) + "]",
        "[data]\nx = { " + '"a" . ' * 20_000 + "a = 1 }",
        "[data]\nband_hz = " + "[" * 50_000,
        '[data]\nfile = "' + "[" * 50_000,
        "time,channel\n" + "0.5,1.5\n" * 50_000,
    ],
    ids=["[", "{", "digits", "a.a.a", "[a.a.a]", "{a.a.a}", "[[", "text", "a table in place of a job"],
)
def test_a_job_of_thousands(tmp_path, text):
    file = tmp_path / "job.toml"
    file.write_text(text)
    begun = time.process_time()
    with pytest.raises(InvalidInputError, match=r"job\.toml, line [12]"):
        read_job(file)
    assert time.process_time() - begun < 5.0


@pytest.mark.parametrize("scale", [1e160, 1e-160])
def test_values_whose_squares_leave_floating_point(scale):
    with pytest.raises(InvalidInputError, match="responses: got values up to"):
        ar.Recording(scale * NOISE, 256.0)
    with pytest.raises(InvalidInputError, match="force: got values up to"):
        ar.Recording(NOISE, 256.0, force=scale * NOISE[0])
    with pytest.raises(InvalidInputError, match="values: got values up to"):
        ar.FrequencyResponse(np.arange(64.0), scale * (NOISE + 1j))


def test_a_masked_array_is_refused_and_one_without_masked_values_read():
    masked = np.ma.masked_greater(NOISE, 1.0)
    with pytest.raises(InvalidInputError, match="values masked"):
        ar.Recording(masked, 256.0)
    assert ar.Recording(np.ma.masked_invalid(NOISE), 256.0).n_samples == 64


@pytest.mark.parametrize(("said", "stops"), [(0, False), (None, False), (1, True), (np.True_, True)])
def test_a_callback_may_return_any_truth_value(said, stops):
    search = ar.IslandGA(max_evaluations=400)
    box = [(-1, 1)] * 2
    found = search.minimize(lambda x: float(x @ x), box, rng=0, callback=lambda state: said)
    assert (found.status == "callback") is stops
    with pytest.raises(InvalidInputError, match="callback"):
        search.minimize(lambda x: float(x @ x), box, rng=0, callback=lambda state: np.zeros(3))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"(4, 1000)", b"(4, 1000 "),
        (b"{'descr", b"{{{{{{{"),
        (b"'<f8'", b"('a',"),
        (b"(4, 1000), ", b"(9999999999,)"),
    ],
)
def test_a_damaged_head_of_an_array(tmp_path, old, new):
    file = tmp_path / "a.npy"
    np.save(file, np.zeros((4, 1000)))
    file.write_bytes(file.read_bytes().replace(old, new))
    with pytest.raises(UnsuitableDataError, match=r"a\.npy"):
        ar.read_npz(file, fs_hz=100.0)


def test_a_device_is_not_replaced_by_a_file(tmp_path):
    pipe = tmp_path / "pipe.npz"
    os.mkfifo(pipe)
    with pytest.raises(InvalidInputError, match="plain file"):
        ar.write_npz(pipe, ar.Recording(NOISE, 256.0))
    assert pipe.is_fifo()
