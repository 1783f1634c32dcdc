"""What files say of rate and unit, and tables of other programs: right, or refused by what is wrong."""

import numpy as np
import pytest
from scipy.io import savemat

import antires_rs as ar

ROWS = np.random.default_rng(0).standard_normal((3, 500))


def test_a_spectrum_in_tdms_is_no_record(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    said = {"wf_increment": 0.5, "unit_string": "g", "wf_xname": "Frequency", "wf_xunit_string": "Hz"}
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as file:
        file.write_segment([nptdms.ChannelObject("run", "tip", np.arange(3.0), properties=said)])
    with pytest.raises(ar.UnsuitableDataError, match="'tip' lies over frequency"):
        ar.read_tdms(tmp_path / "a.tdms")


def mat(folder, **variables):
    from scipy.io import savemat

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
    pytest.importorskip("scipy")
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
    savemat(tmp_path / "a.mat", {"acc": ROWS, **arrays})
    assert ar.read_mat(tmp_path / "a.mat", unit="g").fs_hz == pytest.approx(1024.0, rel=1e-9)
    savemat(tmp_path / "b.mat", {"test": {"acc": ROWS, **arrays}})
    assert ar.read_mat(tmp_path / "b.mat", unit="g").fs_hz == pytest.approx(1024.0, rel=1e-9)


def test_an_attribute_of_the_time_counts(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["acc"], file["time"] = ROWS, np.arange(500) * 2.0
        file["time"].attrs["unit"] = "ms"
    assert ar.read_hdf5(tmp_path / "a.h5", unit="g").fs_hz == pytest.approx(500.0)


def test_an_unknown_unit_of_a_rate_is_refused(tmp_path):
    savemat(tmp_path / "a.mat", {"acc": ROWS, "fs": 1.024, "fs_unit": "furlong"})
    with pytest.raises(
        ar.UnsuitableDataError, match="fs is in 'furlong'.*Export it in s or Hz, or give fs_hz="
    ):
        ar.read_mat(tmp_path / "a.mat", unit="g")


def test_single_rows_of_a_matrix_are_named(tmp_path):
    savemat(tmp_path / "a.mat", {"acc": ROWS, "fs": 512.0})
    record = ar.read_mat(tmp_path / "a.mat", unit="m/s2", responses=["acc[2]", "acc[0]"], dofs=[7, 5])
    assert record.dofs == (7, 5)
    assert np.array_equal(record.responses, ROWS[[2, 0]])
    with pytest.raises(ar.InvalidInputError, match=r"responses: got 'acc\[3\]'"):
        ar.read_mat(tmp_path / "a.mat", unit="m/s2", responses=["acc[3]"])


def test_single_rows_stand_where_they_were_asked_for(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/acc"], file["run/ref"], file["run/fs"] = ROWS, ROWS[1], 512.0
    record = ar.read_hdf5(tmp_path / "a.h5", unit="m/s2", responses=["run/acc[2]", "run/ref", "run/acc[0]"])
    assert np.array_equal(record.responses, ROWS[[2, 1, 0]])


def test_a_unit_that_does_not_matter_is_not_judged(tmp_path):
    savemat(tmp_path / "a.mat", {"acc": ROWS, "fs": 512.0, "fs_unit": "furlong"})
    assert ar.read_mat(tmp_path / "a.mat", unit="g", fs_hz=512.0).fs_hz == 512.0
    h5py = pytest.importorskip("h5py")
    for unit in ("seconds since 2020-01-01", "-", ""):
        with h5py.File(tmp_path / "a.h5", "w") as file:
            file["acc"], file["time"] = ROWS, np.arange(500) / 512.0
            file["time"].attrs["units"] = unit
        assert ar.read_hdf5(tmp_path / "a.h5", unit="g").fs_hz == pytest.approx(512.0)


@pytest.mark.parametrize("within", [False, True])
def test_a_rate_that_contradicts_the_file_is_told(tmp_path, within):
    arrays = {"acc": ROWS, "fs": 1024.0}
    savemat(tmp_path / "a.mat", {"test": arrays} if within else arrays)
    with pytest.warns(ar.AntiresWarning, match="states 1024 Hz; read at 2048 Hz"):
        assert ar.read_mat(tmp_path / "a.mat", unit="g", fs_hz=2048.0).fs_hz == 2048.0
