"""HDF5 and MATLAB files are read in a child process: only what is asked for, within limits."""

import os
import re

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.exceptions import InvalidInputError, UnsuitableDataError

h5py = pytest.importorskip("h5py")
ROWS = np.random.default_rng(1).standard_normal((3, 500))


@pytest.fixture
def beside_a_huge_one(tmp_path):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["test/acc"] = ROWS
        file["test/fs"] = 256.0
        file["coherence_of_all"] = np.zeros(4)
        file.create_dataset("video", shape=(20_000_000_000,), dtype="f8", chunks=(1_000_000,))
        file.create_dataset("cube", shape=(4000, 4000, 4000), dtype="f4", chunks=(10, 10, 10))
    return path


def test_an_unrelated_data_set_of_149_gb_is_not_read(beside_a_huge_one):
    record = ar.read_hdf5(beside_a_huge_one, responses=["test/acc"], dofs=[0, 1, 2])
    assert np.array_equal(record.responses, ROWS)
    assert record.fs_hz == 256.0


def test_what_is_too_large_is_named(beside_a_huge_one):
    with pytest.raises(UnsuitableDataError, match=r"video of 20000000000 values.*responses="):
        ar.read_hdf5(beside_a_huge_one)


def test_a_name_that_is_not_there(beside_a_huge_one):
    with pytest.raises(InvalidInputError, match=r"responses: got 'test/accc'.*test/acc 3x500"):
        ar.read_hdf5(beside_a_huge_one, responses=["test/accc"])


def test_limits_are_kept(tmp_path):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["acc"], file["fs"] = np.zeros((2, 4_000_000)), 256.0
    with pytest.raises(UnsuitableDataError, match=r"acc of 2x4000000 values.*memory_limit_gb"):
        ar.read_hdf5(path, memory_limit_gb=0.3)
    with pytest.raises(UnsuitableDataError, match=r"within 0\.01 s"):
        ar.read_hdf5(path, time_limit_s=0.01)
    with pytest.raises(InvalidInputError, match="time_limit_s"):
        ar.read_hdf5(path, time_limit_s=0.0)


@pytest.mark.skipif(os.name != "posix", reason="needs a signal")
def test_a_reader_that_dies_is_an_error(tmp_path, monkeypatch):
    from antires_rs.io import child_process as child

    path = ar.write_hdf5(tmp_path / "a.h5", ar.Recording(ROWS, 256.0))
    dying = tmp_path / "dies.py"
    dying.write_text("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n")
    monkeypatch.setattr(child, "READER", dying)
    with pytest.raises(UnsuitableDataError, match=re.escape("ended with code -11")):
        ar.read_hdf5(path)
