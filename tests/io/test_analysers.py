"""MATLAB files as analysers export them, and what attributes and fields say of rate and unit."""

import numpy as np
import pytest
from scipy.io import savemat

import antires_rs as ar

RNG = np.random.default_rng(8)
ROWS = RNG.standard_normal((2, 300))
H = RNG.standard_normal((2, 100)) + 1j * RNG.standard_normal((2, 100))
FS = 512.0


def recorded(read, rows=ROWS):
    assert read.fs_hz == FS
    np.testing.assert_allclose(read.responses, rows, rtol=1e-12)


def exported(values, step, label, factor, over="s", names=("1:P1", "2:P2"), start=0.0):
    """A struct as Siemens Testlab exports it."""
    titles = np.empty(len(names), dtype=object)
    titles[:] = names
    return {
        "x_values": {
            "start_value": start,
            "increment": step,
            "number_of_values": float(values.shape[1]),
            "quantity": {"label": over},
        },
        "y_values": {
            "values": values.T,
            "quantity": {"label": label, "unit_transformation": {"factor": factor, "offset": 0.0}},
        },
        "function_record": {"name": titles if len(names) > 1 else names[0], "type": "Time"},
    }


@pytest.mark.parametrize(("label", "factor"), [("g", 1 / 9.80665), ("m/s^2", 1.0), ("mm/s2", 1e3)])
def test_testlab_of_a_record(tmp_path, label, factor):
    savemat(tmp_path / "a.mat", {"Signal": exported(ROWS, 1 / FS, label, factor)})
    read = ar.read_mat(tmp_path / "a.mat")
    recorded(read)
    assert read.dofs == ("1:P1", "2:P2")
    one = {f"Signal_{i}": exported(ROWS[i : i + 1], 1 / FS, label, factor, names=(f"P{i}",)) for i in (0, 1)}
    savemat(tmp_path / "b.mat", one)
    read = ar.read_mat(tmp_path / "b.mat", dofs={"P0": 3, "P1": 7})
    recorded(read)
    assert read.dofs == (3, 7)


def test_testlab_of_responses(tmp_path):
    savemat(tmp_path / "a.mat", {"FRF": exported(H, 0.5, "g/N", 1 / 9.80665, over="Hz", start=2.0)})
    read = ar.read_mat(tmp_path / "a.mat")
    np.testing.assert_allclose(read.values, H)
    np.testing.assert_allclose(read.freq_hz, 2.0 + 0.5 * np.arange(100))
    both = {"FRF": exported(H, 0.5, "g/N", 1.0, over="Hz"), "Signal": exported(ROWS, 1 / FS, "g", 1.0)}
    savemat(tmp_path / "b.mat", both)
    with pytest.raises(ar.UnsuitableDataError, match="over time and functions over frequency"):
        ar.read_mat(tmp_path / "b.mat")


@pytest.mark.parametrize("rate", ["512", "512,0", "512.0 Hz"])
def test_pulse(tmp_path, rate):
    held = {"File_Header": {"SampleFrequency": rate, "NumberOfChannels": "3"}}
    for i, (row, unit) in enumerate(((ROWS[0], "m/s²"), (ROWS[1] / 9.80665, "g"), (ROWS[0], "N")), start=1):
        held[f"Channel_{i}_Data"] = row[:, None]
        held[f"Channel_{i}_Header"] = {"SignalName": f"Signal {i}", "Unit": unit}
    savemat(tmp_path / "a.mat", held)
    read = ar.read_mat(tmp_path / "a.mat")
    recorded(read)
    assert read.dofs == ("Signal 1", "Signal 2")
    np.testing.assert_array_equal(read.force, ROWS[0])


def test_dewesoft(tmp_path):
    time = np.arange(300) / FS
    held = {"Data1_AI_1": ROWS[0], "Data1_AI_2": ROWS[1], "Data1_time_AI_1": time, "Data1_time_AI_2": time}
    savemat(tmp_path / "a.mat", held)
    savemat(tmp_path / "b.mat", {"Data1_AI_1": ROWS[0], "Data1_AI_2": ROWS[1], "Sample_rate": FS})
    for name in ("a.mat", "b.mat"):
        read = ar.read_mat(tmp_path / name, unit="m/s2")
        recorded(read)
        assert read.dofs == ("AI_1", "AI_2")


def test_fields_of_a_struct_tell_rate_and_unit(tmp_path):
    for rate in ({"fs": FS}, {"dt": 1 / FS}, {"sampling_rate": FS}):
        savemat(tmp_path / "a.mat", {"run": {"acc": ROWS / 9.80665, "unit": "g", **rate}})
        recorded(ar.read_mat(tmp_path / "a.mat"))
    savemat(tmp_path / "a.mat", {"test": {"H": H, "f": np.arange(1.0, 101.0), "unit": "mm/s2/N"}})
    np.testing.assert_allclose(ar.read_mat(tmp_path / "a.mat").values, 1e-3 * H)


@pytest.mark.parametrize("place", ["dataset", "group", "file"])
def test_attributes_of_hdf5_tell_rate_and_unit(tmp_path, place):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        made = file.create_dataset("run1/acc", data=ROWS / 9.80665)
        at = {"dataset": made, "group": file["run1"], "file": file}[place]
        at.attrs["unit"], at.attrs["sampling_rate"] = "g", FS
        at.attrs["comment"], at.attrs["odd"] = np.array(["a", "b"], dtype="S1"), h5py.Empty("f")
    recorded(ar.read_hdf5(tmp_path / "a.h5"))
    np.testing.assert_allclose(ar.read_hdf5(tmp_path / "a.h5", unit="m/s2").responses, ROWS / 9.80665)


def test_a_step_that_drifts_is_refused_with_the_place(tmp_path):
    steps = np.full(4000, 1.0 / FS)
    steps[3000:] *= 1.005
    time = np.concatenate([[0.0], np.cumsum(steps)])
    np.savez(tmp_path / "a.npz", time=time, a=RNG.standard_normal(4001))
    with pytest.raises(ar.UnsuitableDataError, match=r"whose steps are 0.00196\d* s on average from"):
        ar.read_npz(tmp_path / "a.npz")
    jitter = np.arange(4001) / FS + RNG.uniform(-0.04, 0.04, 4001) / FS
    np.savez(tmp_path / "b.npz", time=jitter, a=RNG.standard_normal(4001))
    assert abs(ar.read_npz(tmp_path / "b.npz").fs_hz / FS - 1.0) < 1e-4
