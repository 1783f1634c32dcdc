"""Mistakes with files: each ends in an error of ours or in a warning, in the words that were looked at.

With those of jobs (tests/app) and of the command line (tests/app) they are more than 200.
"""

import warnings
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest
from scipy.io import savemat

import antires_rs as ar
from tests.io.test_analysers import exported
from tests.support.snapshots import replay
from tests.support.uff_files import dataset, written

for _package in ("pyuff", "h5py", "pandas", "pyarrow", "openpyxl", "nptdms"):
    pytest.importorskip(_package)

RNG = np.random.default_rng(9)
A, B = RNG.standard_normal((2, 64))
H = RNG.standard_normal((2, 32)) + 1j * RNG.standard_normal((2, 32))
T, F = np.arange(64) / 128.0, np.arange(1.0, 33.0)


def call(function):
    """A function of a folder and data as one of the data, which gives one of the folder."""
    return lambda *data, **options: lambda folder: function(folder, *data, **options)


@call
def npz(folder, more=None, **arrays):
    np.savez(folder / "a.npz", **arrays)
    return ar.read_npz(folder / "a.npz", **(more or {}))


@call
def raw(folder, name, data, read, **options):
    (folder / name).write_bytes(data)
    return read(folder / name, **options)


def text(*lines, **options):
    return raw("a.csv", ("\n".join(lines) + "\n").encode(), ar.read_csv, **options)


def rows(head, *columns, **options):
    return text(head, *(",".join(map(str, row)) for row in zip(*columns, strict=True)), **options)


@call
def hdf5(folder, rates, **options):
    import h5py

    with h5py.File(folder / "a.h5", "w") as file:
        for name, (key, rate) in rates.items():
            file.create_dataset(name, data=A).attrs[key] = rate
    return ar.read_hdf5(folder / "a.h5", **options)


@call
def mat(folder, held, **options):
    savemat(folder / "a.mat", held)
    return ar.read_mat(folder / "a.mat", **options)


@call
def uff(folder, signal, change=bytes, write=None, **options):
    file = ar.write_uff(folder / "a.uff", signal, **{"binary": False, **(write or {})})
    file.write_bytes(change(file.read_bytes()))
    return ar.read_uff(file, **options)


@call
def other(folder, *sets, **options):
    return ar.read_uff(written(folder / "a.uff", *sets), **options)


def function(values=H[0], **more):
    return dataset(values, **{"kind": 4, "reference": (1, 3), "step": 0.5, "per": "N", "binary": 0, **more})


def measured(**more):
    return dataset(A, binary=0, **more)


def spectrum(power):
    return function(power + 0j, kind=2, node=5, reference=(5, 3), data_type=0)


def response(step):
    return exported(H, step, "g/N", 1.0, over="Hz")


def matrices(name, content, *more):
    return raw(name, content.encode(), lambda path: ar.read_matrices(path, *more))


def points(given):
    return lambda folder: ar.match_points(given, {1: (0.0, 0.0, 0.0)})


def dof_map(content):
    return raw("dofs.txt", content.encode(), ar.io.read_dof_map)


@call
def tdms(folder, properties, *values, **options):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(folder / "a.tdms") as file:
        for i, (own, each) in enumerate(zip(properties, values, strict=True)):
            file.write_segment([ChannelObject("run", f"c{i}", each, properties=own)])
    return ar.read_tdms(folder / "a.tdms", **options)


@call
def sheet(folder, *lines, **options):
    from openpyxl import Workbook

    book = Workbook()
    for line in lines:
        book.active.append(line)
    book.save(folder / "a.xlsx")
    return ar.read_excel(folder / "a.xlsx", **options)


@call
def parquet(folder, held, **options):
    import pandas as pd

    pd.DataFrame(held).to_parquet(folder / "a.parquet")
    return ar.read_parquet(folder / "a.parquet", **options)


def lvm(*lines, **options):
    head = ["LabVIEW Measurement", "Separator\tTab", "X_Columns\tNo", "***End_of_Header***", ""]
    return raw("a.lvm", "\n".join([*head, *lines, ""]).encode(), ar.read_lvm, **options)


FRFS = ar.FrequencyResponse(F, H, dofs=["1+X", "2+X"])
RECORD = ar.Recording([A, B], 128.0, dofs=["1+X", "2+X"])
SEGMENT = ["Channels\t1", "Samples\t3", "Y_Unit_Label\tg", "Delta_X\t0.01"]
SEGMENT += ["***End_of_Header***", "X_Value\ta\tComment"]
REAL = np.abs(H) + 0j
UNEVEN = np.concatenate([np.arange(2000) / 128.0, 2000 / 128.0 + np.arange(2000) / 127.3])
GAP = np.delete(np.arange(65) / 128.0, 30)
MARKET, SPARSE = "%%MatrixMarket matrix array ", "%%MatrixMarket matrix coordinate "
SET = {"wf_increment": 1 / 128, "unit_string": "g"}


def test_each_mistake_is_told_in_the_words_that_were_looked_at(tmp_path):
    """Each line of the file is what is wrong, the call, and what is said of it."""

    def said(case):
        folder = Path(mkdtemp(dir=tmp_path, suffix="_"))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                eval(case.partition(" | ")[2])(folder)
            except ar.AntiresError as exc:
                told, kind = str(exc), type(exc).__name__
                assert all(word in told for word in ("got", "wanted")), told
            else:
                told, kind = " | ".join(str(each.message) for each in caught), "warning"
                assert {each.category for each in caught} == {ar.AntiresWarning}, case
        return f"{kind}  {told.replace(str(folder), 'FOLDER')}"

    replay(Path(__file__).with_name("wrong_files.txt"), said)
