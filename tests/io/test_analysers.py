"""Files as analysers export them, and what attributes and fields say of rate and unit."""

import numpy as np
import pytest
from scipy.io import savemat

import antires_rs as ar

RNG = np.random.default_rng(8)
ROWS = RNG.standard_normal((2, 300))
H = RNG.standard_normal((2, 100)) + 1j * RNG.standard_normal((2, 100))
FS = 512.0
TIME = np.arange(300) / FS


def recorded(read):
    assert read.fs_hz == FS
    np.testing.assert_allclose(read.responses, ROWS, rtol=1e-12)


def mat(folder, variables, **options):
    savemat(folder / "a.mat", variables)
    return ar.read_mat(folder / "a.mat", **options)


def exported(values, step, label, factor, over="s", names=("1:P1", "2:P2"), start=0.0):
    """A struct as Siemens Testlab exports it."""
    titles = np.empty(len(names), dtype=object)
    titles[:] = names
    x = {"start_value": start, "increment": step, "number_of_values": float(values.shape[1])}
    quantity = {"label": label, "unit_transformation": {"factor": factor, "offset": 0.0}}
    record = {"name": titles if len(names) > 1 else names[0], "type": "Time"}
    y = {"values": values.T, "quantity": quantity}
    return {"x_values": x | {"quantity": {"label": over}}, "y_values": y, "function_record": record}


@pytest.mark.parametrize(("label", "factor"), [("g", 1 / 9.80665), ("m/s^2", 1.0), ("mm/s2", 1e3)])
def test_testlab_of_a_record(tmp_path, label, factor):
    read = mat(tmp_path, {"Signal": exported(ROWS, 1 / FS, label, factor)})
    recorded(read)
    assert read.dofs == ("1:P1", "2:P2")
    one = {f"Signal_{i}": exported(ROWS[i : i + 1], 1 / FS, label, factor, names=(f"P{i}",)) for i in (0, 1)}
    read = mat(tmp_path, one, dofs={"P0": 3, "P1": 7})
    recorded(read)
    assert read.dofs == (3, 7)


def test_testlab_of_responses_and_over_milliseconds(tmp_path):
    read = mat(tmp_path, {"FRF": exported(H, 0.5, "g/N", 1 / 9.80665, over="Hz", start=2.0)})
    np.testing.assert_allclose(read.values, H)
    np.testing.assert_allclose(read.freq_hz, 2.0 + 0.5 * np.arange(100))
    recorded(mat(tmp_path, {"Signal": exported(ROWS, 1e3 / FS, "m/s^2", 1.0, over="ms")}))


@pytest.mark.parametrize("rate", ["512", "512,0", "512.0 Hz", "0.512 kHz"])
def test_pulse(tmp_path, rate):
    held = {"File_Header": {"SampleFrequency": rate, "NumberOfChannels": "3"}}
    for i, (row, unit) in enumerate(((ROWS[0], "m/s²"), (ROWS[1] / 9.80665, "g"), (ROWS[0], "N")), start=1):
        held[f"Channel_{i}_Data"] = row[:, None]
        held[f"Channel_{i}_Header"] = {"SignalName": f"Signal {i}", "Unit": unit}
    read = mat(tmp_path, held)
    recorded(read)
    assert read.dofs == ("Signal 1", "Signal 2")
    np.testing.assert_array_equal(read.force, ROWS[0])


@pytest.mark.parametrize("rate", [{"Data1_time_AI_1": TIME, "Data1_time_AI_2": TIME}, {"Sample_rate": FS}])
def test_dewesoft(tmp_path, rate):
    read = mat(tmp_path, {"Data1_AI_1": ROWS[0], "Data1_AI_2": ROWS[1], **rate}, unit="m/s2")
    recorded(read)
    assert read.dofs == ("AI_1", "AI_2")


@pytest.mark.parametrize(
    "rate",
    [
        *({"fs": FS}, {"dt": 1 / FS}, {"sampling_rate": FS}),
        *({"fs": "0.512 kHz"}, {"dt": "1,953125 ms"}, {"fs": "0,512 kHz"}, {"fs": "512 Hz"}),
        *({"fs": 0.512, "fs_unit": "kHz"}, {"dt": 1e3 / FS, "dt_units": "ms"}),
        {"time": 1e3 * TIME, "time_unit": "ms"},
    ],
)
def test_fields_beside_an_array_tell_rate_and_unit(tmp_path, rate):
    read = mat(tmp_path, {"run": {"acc": ROWS / 9.80665, "unit": "g", **rate}})
    assert read.fs_hz == pytest.approx(FS, rel=1e-9)
    np.testing.assert_allclose(read.responses, ROWS, rtol=1e-12)


@pytest.mark.parametrize("place", ["dataset", "group", "file"])
def test_attributes_of_hdf5_tell_rate_and_unit(tmp_path, place):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        made = file.create_dataset("run1/acc", data=ROWS / 9.80665)
        at = {"dataset": made, "group": file["run1"], "file": file}[place]
        at.attrs["unit"], at.attrs["sampling_rate"] = "g", FS
        at.attrs["comment"], at.attrs["odd"] = np.array(["a", "b"], dtype="S1"), h5py.Empty("f")
    recorded(ar.read_hdf5(tmp_path / "a.h5"))
    with pytest.warns(ar.AntiresWarning, match="says g, which was not used"):
        np.testing.assert_allclose(ar.read_hdf5(tmp_path / "a.h5", unit="m/s2").responses, ROWS / 9.80665)


def test_jitter_is_no_drift(tmp_path):
    jitter = np.arange(4001) / FS + RNG.uniform(-0.04, 0.04, 4001) / FS
    np.savez(tmp_path / "b.npz", time=jitter, a=RNG.standard_normal(4001))
    assert abs(ar.read_npz(tmp_path / "b.npz").fs_hz / FS - 1.0) < 1e-4


@pytest.mark.parametrize(
    ("unit", "fs_hz"), [("ms", 1e3 * FS), ("seconds since 2020-01-01", FS), ("-", FS), ("", FS)]
)
def test_an_attribute_of_the_time_counts_if_it_is_a_unit(tmp_path, unit, fs_hz):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["acc"], file["time"] = ROWS, TIME
        file["time"].attrs["units"] = unit
    assert ar.read_hdf5(tmp_path / "a.h5", unit="g").fs_hz == pytest.approx(fs_hz)


def test_single_rows_stand_where_they_were_asked_for(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/acc"], file["run/ref"], file["run/fs"] = ROWS, ROWS[1], FS
    names = ["run/acc[1]", "run/ref", "run/acc[0]"]
    read = ar.read_hdf5(tmp_path / "a.h5", unit="m/s2", responses=names, dofs=[7, 5, 6])
    assert read.dofs == (7, 5, 6)
    assert np.array_equal(read.responses, ROWS[[1, 1, 0]])
    with pytest.raises(ar.InvalidInputError, match=r"responses: got 'acc\[2\]'"):
        mat(tmp_path, {"acc": ROWS, "fs": FS}, unit="m/s2", responses=["acc[2]"])


def test_units_of_responses_and_beside_a_rate_that_does_not_matter(tmp_path):
    read = mat(tmp_path, {"test": {"H": H, "f": np.arange(1.0, 101.0), "unit": "mm/s2/N"}})
    np.testing.assert_allclose(read.values, 1e-3 * H)
    assert mat(tmp_path, {"acc": ROWS, "fs": FS, "fs_unit": "furlong"}, unit="g", fs_hz=FS).fs_hz == FS
