"""MAT, HDF5 and npz of other programs: which array is what; the child process that reads them."""

import contextlib

import numpy as np
import pytest
from scipy.io import savemat

import antires_rs as ar
from reference.io_signals import recording
from tests.support.refusals import refused, unsuitable

h5py = pytest.importorskip("h5py")

N = 300
TIME = np.arange(N) / 250.0
A, B, F = np.random.default_rng(0).standard_normal((3, N))
H = A + 1j * B


def npz(path, **arrays):
    np.savez(path.with_suffix(".npz"), **arrays)
    return path.with_suffix(".npz")


def mat(path, **arrays):
    savemat(path, arrays)
    return path


def hdf5(path, **arrays):
    with h5py.File(path, "w") as file:
        for name, value in arrays.items():
            file[name] = value
    return path


BAGS = [(npz, ar.read_npz), (mat, ar.read_mat), (hdf5, ar.read_hdf5)]
every_bag = pytest.mark.parametrize(("save", "read"), BAGS)


@every_bag
def test_names_tell_the_roles(tmp_path, save, read):
    rec = read(save(tmp_path / "a", time=TIME, acc=A, root=B, force=F, temperature=21.5))
    assert (rec.fs_hz, rec.dofs) == (250.0, ("acc", "root"))
    np.testing.assert_array_equal(rec.responses, [A, B])
    np.testing.assert_array_equal(rec.force, F)


@every_bag
def test_roles_are_named(tmp_path, save, read):
    path = save(tmp_path / "a", Fs=250, acc1=A, acc2=B, cell=F)
    rec = read(path, responses="acc*", force="cell", unit="g", dofs={"acc1": 4, "acc2": 2})
    assert (rec.fs_hz, rec.dofs) == (250.0, (4, 2))
    np.testing.assert_allclose(rec.responses, 9.80665 * np.array([A, B]), rtol=1e-15)
    np.testing.assert_array_equal(rec.force, F)
    with pytest.warns(ar.AntiresWarning, match="states 250 Hz; read at 100 Hz"):
        assert read(path, responses=["acc2"], fs_hz=100.0).fs_hz == 100.0
    refused("^time: got 'uhr'; wanted a numeric array of", read, path, time="uhr")


@every_bag
@pytest.mark.parametrize("turned", [False, True])
def test_matrices_have_channels_along_the_shorter_axis(tmp_path, save, read, turned):
    rows = np.array([A, B])
    rec = read(save(tmp_path / "a", t=TIME, y=rows.T if turned else rows))
    assert rec.dofs == ("y[0]", "y[1]")
    np.testing.assert_array_equal(rec.responses, rows)


@every_bag
def test_responses_over_frequency(tmp_path, save, read):
    path = save(tmp_path / "a", freq=TIME, H=np.array([H, 2 * H]), coherence=np.full((2, N), 0.9))
    found = read(path, dofs=[1, 0], unit="g/N")
    assert (found.kind, found.dofs, found.coherence.max()) == ("frf", (1, 0), 0.9)
    np.testing.assert_allclose(found.values[1], 9.80665 * 2 * H, rtol=1e-15)
    assert read(path, dofs=[None, 7]).dofs == (7,)
    beside = save(tmp_path / "c", freq=TIME, H=H, magnitude=np.abs(H), phase=np.angle(H))
    assert read(beside).dofs == ("H",)
    unsuitable("whose magnitude is real", read, beside, responses=["H", "magnitude"])
    ones = save(tmp_path / "b", f=TIME, T=np.array([H, np.ones(N)]))
    assert read(ones, kind="transmissibility", dofs=[0, 1], reference=1).reference == 1


def test_structs(tmp_path):
    runs = np.array([({"t": TIME, "a": A},), ({"t": TIME, "a": B},)], dtype=object)
    path = mat(tmp_path / "a.mat", test={"time": TIME, "acc": {"x": A, "y": B}}, runs=runs, note="hello")
    unsuitable("several candidates for time=.*Name it: time='test", ar.read_mat, path)
    rec = ar.read_mat(path, time="test.time", responses="test.acc.*")
    assert rec.dofs == ("x", "y")
    np.testing.assert_array_equal(rec.responses, [A, B])
    assert ar.read_mat(path, time="runs[1].t", responses="runs[1].a").dofs == ("a",)


def test_version_73(tmp_path, own_process):
    path = tmp_path / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("test")
        for name, value in (("time", TIME[None]), ("acc", np.array([A, B]))):
            group.create_dataset(name, data=value.T).attrs["MATLAB_class"] = np.bytes_("double")
        pair = np.zeros((N, 1), dtype=[("real", "f8"), ("imag", "f8")])
        pair["real"][:, 0], pair["imag"][:, 0] = A, B
        file.create_dataset("H", data=pair).attrs["MATLAB_class"] = np.bytes_("double")
        file["note"], file["none"] = np.arange(N, dtype=np.uint16), np.array([0, 0])
        file["note"].attrs["MATLAB_class"] = np.bytes_("char")
        file["none"].attrs["MATLAB_empty"] = np.uint8(1)
    np.testing.assert_array_equal(ar.read_mat(path, responses="test.acc").responses, [A, B])
    np.testing.assert_array_equal(ar.read_mat(path, responses="H", df_hz=0.5).values, [H])


def cells_73(path):
    """Cells and struct arrays as MATLAB 7.3 has them: references to datasets and groups in #refs#."""
    with h5py.File(path, "w", userblock_size=512) as file:
        hidden = file.create_group("#refs#")

        def put(group, name, value, made="double"):
            group.create_dataset(name, data=value).attrs["MATLAB_class"] = np.bytes_(made)
            return group[name].ref

        def references(group, name, targets, made=None):
            table = group.create_dataset(name, data=np.array([targets], dtype=object), dtype=h5py.ref_dtype)
            if made:
                table.attrs["MATLAB_class"] = np.bytes_(made)
            return table.ref

        def struct(group, name):
            group.create_group(name).attrs["MATLAB_class"] = np.bytes_("struct")
            return group[name]

        a, b = put(hidden, "a", A[:, None]), put(hidden, "b", B[:, None])
        t = put(hidden, "t", TIME[:, None])
        word = put(hidden, "w", np.array([[104]], dtype=np.uint16), "char")
        runs = struct(file, "runs")
        references(runs, "t", [t, t])
        references(runs, "a", [a, b])
        inner = struct(hidden, "s")
        put(inner, "x", A[:, None])
        references(inner, "deep", [b], "cell")
        both = references(hidden, "c", [a, word], "cell")
        references(file, "channels", [a, b, inner.ref, both, h5py.Reference()], "cell")
        ring = references(hidden, "ring", [a], "cell")
        hidden["ring"][0, 0] = ring
        references(file, "endless", [ring], "cell")
    return path


def test_cells_and_struct_arrays_of_version_73(tmp_path):
    path = cells_73(tmp_path / "a.mat")
    expected = {"runs[0].a": A, "runs[1].a": B, "channels[0]": A, "channels[1]": B}
    expected |= {"channels[2].x": A, "channels[2].deep[0]": B, "channels[3][0]": A}
    cell = {"x": A, "deep": np.array([B, None], dtype=object)[:1]}
    channels = np.array([A, B, cell, np.array([A, "h"], dtype=object)], dtype=object)
    runs = np.array([(TIME, A), (TIME, B)], dtype=[("t", "O"), ("a", "O")])
    for file in (path, mat(tmp_path / "b.mat", channels=channels, runs=runs)):
        rec = ar.read_mat(file, time="runs[1].t", responses=list(expected))
        np.testing.assert_array_equal(rec.responses, list(expected.values()))


def test_damaged_matlab_files_do_not_end_the_process(tmp_path, own_process):
    """Flipped bytes beyond the head, where the element's length still fits: only the child reads them."""
    path = ar.write_mat(tmp_path / "a.mat", recording(n=50))
    data, rng = path.read_bytes(), np.random.default_rng(0)
    for _ in range(5):
        changed = bytearray(data)
        for at in rng.integers(136, len(data), 4):
            changed[at] = rng.integers(256)
        path.write_bytes(changed)
        with contextlib.suppress(ar.InvalidInputError):  # any other error, or the end of the process, fails
            ar.read_mat(path)


ROWS = np.random.default_rng(1).standard_normal((3, 500))


def test_an_unrelated_data_set_of_149_gb_is_not_read_or_else_named(tmp_path, own_process):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["test/acc"] = ROWS
        file["test/fs"] = 256.0
        file["coherence_of_all"] = np.zeros(4)
        file.create_dataset("video", shape=(20_000_000_000,), dtype="f8", chunks=(1_000_000,))
        file.create_dataset("cube", shape=(4000, 4000, 4000), dtype="f4", chunks=(10, 10, 10))
    record = ar.read_hdf5(path, responses=["test/acc"], dofs=[0, 1, 2])
    assert np.array_equal(record.responses, ROWS)
    assert record.fs_hz == 256.0
    unsuitable(r"video of 20000000000 values.*responses=", ar.read_hdf5, path)
    refused(r"responses: got 'test/accc'.*test/acc 3x500", ar.read_hdf5, path, responses=["test/accc"])


def test_limits_are_kept(tmp_path, own_process):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["acc"], file["fs"] = np.zeros((2, 4_000_000)), 256.0
    unsuitable(r"acc of 2x4000000 values.*memory_limit_gb", ar.read_hdf5, path, memory_limit_gb=0.3)
    unsuitable(r"within 0\.01 s", ar.read_hdf5, path, time_limit_s=0.01)
    refused("time_limit_s", ar.read_hdf5, path, time_limit_s=0.0)
