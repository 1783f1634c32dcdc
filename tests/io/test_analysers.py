"""Files as analysers export them, and what attributes and fields say of rate and unit."""

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


LONG = np.random.default_rng(0).standard_normal((3, 500))


def test_a_spectrum_in_tdms_is_no_record(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    said = {"wf_increment": 0.5, "unit_string": "g", "wf_xname": "Frequency", "wf_xunit_string": "Hz"}
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as file:
        file.write_segment([nptdms.ChannelObject("run", "tip", np.arange(3.0), properties=said)])
    with pytest.raises(ar.UnsuitableDataError, match="'tip' lies over frequency"):
        ar.read_tdms(tmp_path / "a.tdms")


def mat(folder, **variables):
    savemat(folder / "a.mat", variables)
    return ar.read_mat(folder / "a.mat")


@pytest.mark.parametrize(
    ("name", "said", "fs_hz"),
    [("fs", "51.2 kHz", 51200.0), ("dt", "10 ms", 100.0), ("fs", "1,5 kHz", 1500.0), ("fs", "256 Hz", 256.0)],
)
def test_the_unit_behind_a_rate_counts(tmp_path, name, said, fs_hz):
    assert mat(tmp_path, test={name: said, "unit": "g", "acc": np.arange(20.0)}).fs_hz == fs_hz


@pytest.mark.parametrize("said", ["65,536", "100 furlongs"])
def test_a_rate_that_may_be_read_in_two_ways_is_none(tmp_path, said):
    with pytest.raises(ar.UnsuitableDataError, match="without a sampling rate"):
        mat(tmp_path, test={"fs": said, "unit": "g", "acc": np.arange(20.0)})


def test_kilohertz_of_pulse(tmp_path):
    head = {"SignalName": "tip", "Unit": "m/s2"}
    file = {"File_Header": {"SampleFrequency": "1.024 kHz"}, "Channel_1_Header": head}
    assert mat(tmp_path, **file, Channel_1_Data=np.arange(20.0)).fs_hz == 1024.0


def of_siemens(folder, label):
    axis = {"start_value": 0.0, "increment": 0.5, "number_of_values": 20.0, "quantity": {"label": label}}
    values = {"values": np.arange(20.0), "quantity": {"label": "g"}}
    return mat(folder, S={"x_values": axis, "y_values": values, "function_record": {"name": "tip"}})


def test_the_abscissa_of_testlab_has_a_unit(tmp_path):
    assert of_siemens(tmp_path, "ms").fs_hz == 2000.0
    with pytest.raises(ar.UnsuitableDataError, match="lies over 'deg'"):
        of_siemens(tmp_path, "deg")


def test_channels_of_dewesoft_that_begin_at_other_times(tmp_path):
    time = np.arange(20.0) / 100
    with pytest.raises(ar.UnsuitableDataError, match="channels that begin together"):
        mat(tmp_path, Data1_a=time, Data1_time_a=time, Data1_b=time, Data1_time_b=time + 5.0)


def test_spectra_of_dewesoft_are_no_records(tmp_path):
    with pytest.raises(ar.AntiresError, match="complex values"):
        mat(tmp_path, Data1_H=np.arange(20.0) + 1j, Sample_rate=100.0)


@pytest.mark.parametrize(
    "arrays",
    [
        {"fs": 1.024, "fs_unit": "kHz"},
        {"dt": 1 / 1.024, "dt_units": "ms"},
        {"time": np.arange(500) / 1.024, "time_unit": "ms"},
    ],
)
def test_a_unit_beside_a_rate_counts(tmp_path, arrays):
    savemat(tmp_path / "a.mat", {"acc": LONG, **arrays})
    assert ar.read_mat(tmp_path / "a.mat", unit="g").fs_hz == pytest.approx(1024.0, rel=1e-9)
    savemat(tmp_path / "b.mat", {"test": {"acc": LONG, **arrays}})
    assert ar.read_mat(tmp_path / "b.mat", unit="g").fs_hz == pytest.approx(1024.0, rel=1e-9)


def test_an_attribute_of_the_time_counts(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["acc"], file["time"] = LONG, np.arange(500) * 2.0
        file["time"].attrs["unit"] = "ms"
    assert ar.read_hdf5(tmp_path / "a.h5", unit="g").fs_hz == pytest.approx(500.0)


def test_an_unknown_unit_of_a_rate_is_refused(tmp_path):
    savemat(tmp_path / "a.mat", {"acc": LONG, "fs": 1.024, "fs_unit": "furlong"})
    with pytest.raises(
        ar.UnsuitableDataError, match="fs is in 'furlong'.*Export it in s or Hz, or give fs_hz="
    ):
        ar.read_mat(tmp_path / "a.mat", unit="g")


def test_single_rows_of_a_matrix_are_named(tmp_path):
    savemat(tmp_path / "a.mat", {"acc": LONG, "fs": 512.0})
    record = ar.read_mat(tmp_path / "a.mat", unit="m/s2", responses=["acc[2]", "acc[0]"], dofs=[7, 5])
    assert record.dofs == (7, 5)
    assert np.array_equal(record.responses, LONG[[2, 0]])
    with pytest.raises(ar.InvalidInputError, match=r"responses: got 'acc\[3\]'"):
        ar.read_mat(tmp_path / "a.mat", unit="m/s2", responses=["acc[3]"])


def test_single_rows_stand_where_they_were_asked_for(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/acc"], file["run/ref"], file["run/fs"] = LONG, LONG[1], 512.0
    record = ar.read_hdf5(tmp_path / "a.h5", unit="m/s2", responses=["run/acc[2]", "run/ref", "run/acc[0]"])
    assert np.array_equal(record.responses, LONG[[2, 1, 0]])


def test_a_unit_that_does_not_matter_is_not_judged(tmp_path):
    savemat(tmp_path / "a.mat", {"acc": LONG, "fs": 512.0, "fs_unit": "furlong"})
    assert ar.read_mat(tmp_path / "a.mat", unit="g", fs_hz=512.0).fs_hz == 512.0
    h5py = pytest.importorskip("h5py")
    for unit in ("seconds since 2020-01-01", "-", ""):
        with h5py.File(tmp_path / "a.h5", "w") as file:
            file["acc"], file["time"] = LONG, np.arange(500) / 512.0
            file["time"].attrs["units"] = unit
        assert ar.read_hdf5(tmp_path / "a.h5", unit="g").fs_hz == pytest.approx(512.0)


@pytest.mark.parametrize("within", [False, True])
def test_a_rate_that_contradicts_the_file_is_told(tmp_path, within):
    arrays = {"acc": LONG, "fs": 1024.0}
    savemat(tmp_path / "a.mat", {"test": arrays} if within else arrays)
    with pytest.warns(ar.AntiresWarning, match="states 1024 Hz; read at 2048 Hz"):
        assert ar.read_mat(tmp_path / "a.mat", unit="g", fs_hz=2048.0).fs_hz == 2048.0
