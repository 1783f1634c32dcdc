"""The files of two published measurements, as they are."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.measured_data import DATA


def data_file(name):
    path = DATA / name
    if not path.is_file():
        pytest.skip(f"record absent: {path}; set ANTIRES_DATA")
    return path


def test_southampton_frame():
    path = data_file("southampton_3storey/test_2.csv")
    found = ar.read_csv(path)
    table = np.loadtxt(path, delimiter=";", dtype=complex)
    assert (found.kind, found.dofs, found.n_freq) == ("frf", (0, 1, 2), 4096)
    np.testing.assert_array_equal(found.freq_hz, table[:, 0].real)
    np.testing.assert_array_equal(found.values, table[:, 1:].T)


def test_a_file_that_ends_without_a_line_end():
    with pytest.warns(ar.AntiresWarning, match="no line end after its last row"):
        found = ar.read_csv(data_file("southampton_3storey/Experimental.csv"))
    assert found.n_freq == 4096


def test_magnitudes_are_no_responses():
    with pytest.raises(ar.UnsuitableDataError, match="lost the phase"):
        ar.read_csv(data_file("southampton_3storey/ExpDataSo.csv"), first="freq")


def test_brake_reuss_beam():
    rec = ar.read_mat(data_file("brake_reuss_beam/HammerImpact.mat"))
    assert (rec.fs_hz, rec.dofs, rec.n_samples) == (12800.0, ("acc1", "acc2", "acc3"), 65536)


def test_stepped_sine_of_the_beam():
    """One of twelve sweeps, put together from amplitude, phase and force."""
    arrays = ar.io.mat_arrays(data_file("brake_reuss_beam/ForcedFrequencyResponses.mat"))
    assert len(arrays) == 48
    sweep = {
        name: arrays[f"FRdata.ForceControl[0].{name}"].ravel()
        for name in ("frequency", "force", "amplitude", "phase")
    }
    values = sweep["amplitude"] / sweep["force"] * np.exp(1j * sweep["phase"])
    found = ar.FrequencyResponse(sweep["frequency"], values)
    # The resonance of the beam's first bending mode, 80.5 Hz at low level, lower as the joint slips.
    assert 79.8 < found.freq_hz[np.argmax(np.abs(found.values[0]))] < 80.6
