"""Files made to do harm: none crashes, hangs, fills the memory, opens another file or runs its content."""

import gzip
import json
import os
import pickle
import sqlite3
import struct
import subprocess
import sys
import time
import zipfile
import zlib
from contextlib import closing, suppress

import numpy as np
import pytest
from scipy import sparse

import antires_rs as ar
from antires_rs.io import archive, child_process, matrix_files
from tests.support.campaign import some_of
from tests.support.paths import ROOT
from tests.support.refusals import refused, unsuitable

for _package in ("h5py", "pyarrow"):
    pytest.importorskip(_package)

K = sparse.csr_array(500.0 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]]))
HELD = {"format": np.array(b"csr"), "shape": np.array([3, 3]), "data": K.data}
HELD |= {"indices": K.indices, "indptr": K.indptr}
COO = {"format": np.array(b"coo"), "row": np.array([0, 1]), "col": np.array([0, 1]), "data": np.ones(2)}
BSR = {"format": np.array(b"bsr"), "indices": np.array([0, 1]), "indptr": np.array([0, 1, 2, 2])}
HUGE = np.array([2_000_000_000] * 2)
SPARSE = {  #: What is changed in a file of scipy.sparse.save_npz, all of whose checksums are right.
    "columns beyond": {"indices": K.indices + 10**8},
    "columns below": {"indices": K.indices - 10**8},
    "rows beyond": {"format": np.array(b"csc"), "indices": K.indices + 10**8},
    "pointers beyond": {"indptr": np.array([0, 2, 10**9, 7], dtype=np.int32)},
    "pointers that descend": {"indptr": np.array([0, 5, 2, 7], dtype=np.int32)},
    "pointers with fractions": {"indptr": K.indptr + 0.5},
    "columns with fractions": {"indices": K.indices + 0.5},
    "places with fractions": COO | {"row": np.array([0.0, 0.5])},
    "places beyond": COO | {"row": np.array([0, 10**9])},
    "blocks beyond": BSR | {"indices": np.array([10**8] * 2), "data": np.ones((2, 1, 1))},
    "blocks of no size": BSR | {"data": np.ones((2, 0, 0))},
    "no values": {"data": None},
    "no pointers": {"indptr": None},
    "values of text": {"data": np.array(["a"] * 7)},
    "values of time": {"data": np.array([1] * 7, dtype="M8[s]")},
    "a format of number": {"format": np.array(7)},
    "a shape of fractions": {"shape": np.array([3.5, 3.0])},
    "a shape without axes": {"shape": np.array(3)},
    "dofs without end": COO | {"shape": HUGE},
}


def save_sparse(path, change):
    np.savez(path, **{name: held for name, held in (HELD | change).items() if held is not None})
    return path


@pytest.mark.parametrize("change", SPARSE.values(), ids=SPARSE)
def test_sparse_structure_is_checked_before_c_code_sees_it(tmp_path, change):
    with pytest.raises(ar.UnsuitableDataError):
        ar.read_matrices(save_sparse(tmp_path / "k.npz", change), np.eye(3))


def record(*content):
    data = b"".join(content)
    return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))


HEAD = record(struct.pack("<4i", 1, 2, 6, 2), b"K       ")


@pytest.mark.parametrize("words", [0, 65536, 7 * 65536])
def test_a_string_of_output4_advances_and_ends_in_its_record(tmp_path, words):
    (tmp_path / "k.op4").write_bytes(HEAD + record(struct.pack("<4i", 1, 0, 1, words)))
    unsuitable("a string of", ar.read_matrices, tmp_path / "k.op4", np.eye(2))


def stated_dofs(path):
    text = "%%MatrixMarket matrix coordinate real symmetric\n2000000000 2000000000 1\n1 1 1.0\n"
    path.with_suffix(".mtx").write_text(text)
    return path.with_suffix(".mtx"), "2000000000 dofs"


def stated_dofs_of_nastran(path):
    head = f"{99999999:8d}{99999999:8d}{6:8d}{2:8d}{'K':8s}1P,3E23.16\n"
    path.with_suffix(".op4").write_text(head + f"{100000000:8d}{1:8d}{1:8d}\n 1.0000000000000000E+00\n")
    return path.with_suffix(".op4"), "."


def packed_text(path):
    with gzip.open(path.with_suffix(".mtx.gz"), "wb", 1) as file:
        file.write(b"%%MatrixMarket matrix array real general\n")
        for _ in range(140):
            file.write(b"\n" * 1_000_000)
    return path.with_suffix(".mtx.gz"), "packed text"


def packed_archive(path):
    with zipfile.ZipFile(path.with_suffix(".npz"), "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
        head = b"\x93NUMPY\x01\x00v\x00"
        head += b"{'descr': '<f8', 'fortran_order': False, 'shape': (129000000,), }"
        with file.open("a.npy", "w", force_zip64=True) as member:
            member.write(head.ljust(127) + b"\n")
            for _ in range(129):
                member.write(bytes(8_000_000))
    return path.with_suffix(".npz"), "packed archive"


@pytest.mark.parametrize("make", [stated_dofs, stated_dofs_of_nastran, packed_text, packed_archive])
def test_numbers_of_a_file_are_bounded(tmp_path, make):
    file, found = make(tmp_path / "k")
    unsuitable(rf"{found}.*at most 1e\+09 bytes.*ANTIRES_MAX_BYTES", ar.read_matrices, file, np.eye(2))


def test_the_bound_is_the_users(tmp_path, monkeypatch):
    file = tmp_path / "a.npz"
    np.savez_compressed(file, fs=128.0, a=np.zeros(100_000), b=np.arange(100_000.0))
    plain = tmp_path / "b.npz"
    np.savez(plain, fs=128.0, a=np.arange(100_000.0))
    assert ar.read_npz(file).n_samples == 100_000
    monkeypatch.setenv("ANTIRES_MAX_BYTES", "1e6")
    unsuitable("packed archive", ar.read_npz, file)
    assert ar.read_npz(plain).n_samples == 100_000  # as large as the file itself
    monkeypatch.setenv("ANTIRES_MAX_BYTES", "much")
    refused("ANTIRES_MAX_BYTES: got 'much'", ar.read_npz, file)


def parquet_of_zeros(path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"time": np.arange(400_000) / 1000.0, "a": np.zeros(400_000)}), path)


def hdf5_of_zeros(path):
    import h5py

    with h5py.File(path, "w") as file:
        file.create_dataset("a", data=np.zeros(400_000), compression="gzip")
        file.attrs["fs"] = 1000.0


def excel_of_zeros(path):
    from openpyxl import Workbook

    book = Workbook(write_only=True)
    sheet = book.create_sheet()
    for i in range(6000):
        sheet.append([i / 1000.0, *[0] * 9])
    book.save(path)


def series_of_many(path):
    ar.Series.from_sets([ar.AntiresonanceSet(0, {0: np.arange(1.0, 4000.0)})] * 80).save(path)
    os.utime(path, ns=(1, 1))  # not the file any more that this process wrote


OF_CHILD = {
    "series.parquet": (series_of_many, ar.Series.load),
    "a.parquet": (parquet_of_zeros, ar.read_parquet),
    "a.h5": (hdf5_of_zeros, ar.read_hdf5),
    "a.mat": (hdf5_of_zeros, ar.read_mat),
    "a.xlsx": (excel_of_zeros, ar.read_excel),
}


@pytest.mark.parametrize("name", OF_CHILD)
def test_the_bound_holds_for_what_the_child_hands_over(tmp_path, monkeypatch, name):
    make, read = OF_CHILD[name]
    if name == "a.xlsx":
        pytest.importorskip("openpyxl")
    make(tmp_path / name)
    monkeypatch.setenv("ANTIRES_MAX_BYTES", "3e6")
    unsuitable("ANTIRES_MAX_BYTES", read, tmp_path / name)


def series_file(path):
    sets = [ar.AntiresonanceSet(0, {0: [2.0 + i, 50.0], 1: [3.0]}) for i in range(3)]
    ar.Series.from_sets(sets, names=["a", "b", "c"]).save(path)
    return path


def test_a_table_of_a_series_that_ends_its_reader_ends_a_child_alone(tmp_path, monkeypatch):
    file = series_file(tmp_path / "a.parquet")
    os.utime(file, ns=(1, 1))  # not the file any more that this process wrote
    (tmp_path / "reader.py").write_text("import os\nos.abort()\n")
    monkeypatch.setattr(child_process, "READER", tmp_path / "reader.py")
    unsuitable("the reader ended with code", ar.Series.load, file)


def in_database(file, change, what="columns"):
    """Change the columns, or the facts, of the first test, and make its checksum anew."""
    from antires_rs.watch.store import _checksum

    with closing(sqlite3.connect(file)) as database, database:
        values = list(database.execute("SELECT * FROM tests WHERE place = 1").fetchone()[1:-1])
        values[-1 if what == "columns" else -2] = change
        database.execute(
            f"UPDATE tests SET {what} = ?, checksum = ? WHERE place = 1", (change, _checksum(values))
        )


def test_what_a_test_of_a_series_unpacks_to_is_bounded(tmp_path, monkeypatch):
    file = series_file(tmp_path / "a.sqlite")
    in_database(file, zlib.compress(b" " * 10_000_000))
    monkeypatch.setenv("ANTIRES_MAX_BYTES", "1e6")
    with pytest.raises(ar.UnsuitableDataError, match="whose test 'a' unpacks to more"):
        ar.Series.load(file)[0]


@pytest.mark.parametrize("change", [b"no zlib", zlib.compress(b"{}"), zlib.compress(b"[")])
def test_a_test_of_a_series_with_a_right_checksum_over_wrong_content(tmp_path, change):
    file = series_file(tmp_path / "a.sqlite")
    in_database(file, change)
    with pytest.raises(ar.InvalidInputError, match="test 'a' is damaged"):
        ar.Series.load(file)[0]


@pytest.mark.parametrize(
    "change", [(7,), ('{"excitation": 0, "tables": [["antiresonance", {}, 0, {}]]}', "facts")], ids=str
)
def test_a_field_of_a_test_of_another_type(tmp_path, change):
    file = series_file(tmp_path / "a.sqlite")
    in_database(file, *change)
    with pytest.warns(ar.AntiresWarning, match="1 tests are not as they were written: 'a'"):
        assert ar.Series.load(file).names == ("b", "c")


@pytest.mark.parametrize("value", ['"x"', "[", "null", "1e400"])
def test_facts_of_a_store_that_are_damaged(tmp_path, value):
    file = series_file(tmp_path / "a.sqlite")
    with closing(sqlite3.connect(file)) as database, database:
        database.execute("UPDATE series SET value = ? WHERE name = 'version'", (value,))
    signal = ar.Recording(np.ones((2, 64)), 32.0)
    with pytest.raises(ar.InvalidInputError, match=r"^store: got .*a\.sqlite"):
        ar.identify_series([("a", signal)], excitation=0, band_hz=(1.0, 9.0), store=file)
    refused(r"^path: got .*a\.sqlite", ar.Series.load, file)


def test_a_member_of_an_archive_that_is_no_array(tmp_path):
    np.savez(tmp_path / "a.npz", fs=64.0, a=np.zeros(64))
    with zipfile.ZipFile(tmp_path / "a.npz", "a") as file:
        file.writestr("notes.txt", b"of the test")
    unsuitable("'notes.txt' is no array", ar.read_npz, tmp_path / "a.npz")


LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (5 << 30, 5 << 30))
from antires_rs.io._child import limit_memory
limit_memory(8.0)
print(resource.getrlimit(resource.RLIMIT_AS)[0] >> 30)
limit_memory(2.0)
print(resource.getrlimit(resource.RLIMIT_AS)[1] >> 30)
"""


@pytest.mark.skipif(os.name != "posix", reason="limits of the system are POSIX")
def test_a_lower_limit_of_memory_stays():
    """Only root may raise one: others had whole files refused under ``ulimit -v``."""
    done = subprocess.run([sys.executable, "-c", LIMITED], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["5", "2"]


@pytest.mark.parametrize("kind", ["external", "virtual"])
def test_hdf5_that_points_into_other_files(tmp_path, kind):
    import h5py

    secret = np.arange(64.0)
    (tmp_path / "secret").write_bytes(secret.tobytes())
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["a"] = secret
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.attrs["fs"] = 64.0
        file["own"] = secret[::-1]
        file["linked"] = h5py.ExternalLink("other.h5", "/a")
        if kind == "external":
            file.create_dataset("a", (64,), "f8", external=[(str(tmp_path / "secret"), 0, 512)])
        else:
            layout = h5py.VirtualLayout((64,), "f8")
            layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "a", (64,))
            file.create_virtual_dataset("a", layout)
    for read in (ar.read_hdf5, ar.read_mat):
        unsuitable("'a' lies in another file", read, tmp_path / "a.h5")
        assert read(tmp_path / "a.h5", responses="own").dofs == ("own",)  # what nobody asks for is left alone
    refused("'linked'", ar.read_hdf5, tmp_path / "a.h5", responses="linked")


class Carried:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (self.path,)


def test_parquet_runs_nothing_it_carries(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    ran = str(tmp_path / "ran")
    kind = {b"ARROW:extension:name": b"arrow.py_extension_type"}
    kind |= {b"ARROW:extension:metadata": pickle.dumps(Carried(ran))}
    schema = pa.schema([pa.field("time", pa.float64()), pa.field("a", pa.float64(), metadata=kind)])
    pq.write_table(pa.table([[0.0, 0.5, 1.0], [1.0, 2.0, 4.0]], schema=schema), tmp_path / "a.parquet")
    assert ar.read_parquet(tmp_path / "a.parquet").n_samples == 3
    assert not os.path.exists(ran)


#: What is changed in the text of a file of write_matrices, or in its places, before its checksums are made.
OWN = {"entries beyond": 2**31, "dofs without end": {"n_dof": 2_000_000_000}, "dofs below": {"n_dof": -1}}
OWN |= {"no number of dofs": {"n_dof": "x"}, "no list": {"keep": 7}, "no matrix": {"mass": None}}


@pytest.mark.parametrize("change", OWN.values(), ids=OWN)
def test_matrices_of_ours_with_right_checksums_over_wrong_numbers(tmp_path, change):
    model, store = ar.MatrixModel(K.toarray(), np.eye(3)), archive.Store()
    recipe = archive.encoded(model.description.recipe, store)
    if isinstance(change, dict):
        recipe |= change
    else:
        places = {name: array for name, array in store.arrays.items() if array.dtype == np.uint32}
        store.arrays |= {name: np.full_like(array, change) for name, array in places.items()}
    held = {"format": matrix_files.FORMAT, "version": matrix_files.VERSION, "recipe": recipe}
    file = archive.write_store(tmp_path / "k.npz", held, store)
    with pytest.raises(ar.UnsuitableDataError):
        ar.read_matrices(file)


#: A megabyte of what is looked at again and again where the search is not linear; 20 s and more before.
LONG = {
    "a.uff": (ar.read_uff, b"    -1\n" * 150_000),
    "a.lvm": (ar.read_lvm, b"LabVIEW Measurement\n" + b"***Start_Special***\n" * 200_000),
    "dofs.txt": (ar.io.read_dof_map, b"".join(b"%d UX\n" % (i % 79_999) for i in range(80_000))),
}


@pytest.mark.parametrize("name", LONG)
def test_time_grows_with_the_length_of_a_file(tmp_path, name):
    read, content = LONG[name]
    took = []
    for part in (len(content) // 40, len(content) // 4, len(content)):  # the first imports what is needed
        (tmp_path / name).write_bytes(content[:part])
        start = time.process_time()
        with (
            suppress(ar.UnsuitableDataError) if part < len(content) else pytest.raises(ar.UnsuitableDataError)
        ):
            read(tmp_path / name)
        took.append(time.process_time() - start)
    assert took[2] < 10.0 * took[1]  # 4 by the length, 16 by its square


#: Read and written in this process, and by a child process.
SHORT_OF_MEMORY = ["identification", "csv", "npz of ours", "matrices of ours", "antiresonances", "uff binary"]
SHORT_OF_MEMORY += ["series sqlite", "mat5"]


@pytest.mark.parametrize(("each", "kinds"), some_of([(6, SHORT_OF_MEMORY), (100, [])]))
def test_allocations_that_fail_are_told_and_leave_whole_files(tmp_path, each, kinds):
    pytest.importorskip("_testcapi", exc_type=ImportError)
    pytest.importorskip("resource")
    if np.__version__.startswith("1."):
        pytest.skip("NumPy before 2 crashes itself where an allocation of its own fails")
    command = [sys.executable, "-m", "tests.support.failing_allocations", tmp_path, str(each), *kinds]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["wrong"] == []
    assert found["seen"]["MemoryError"] > found["seen"].get("of others", 0)
