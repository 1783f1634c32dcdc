"""Mistakes with files: each ends in an error of ours or in a warning, in the words that were looked at.

With those of jobs (tests/app) and of the command line (tests/app) they are more than 200.
"""

import warnings
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import antires_rs as ar
from tests.support.snapshots import compare
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
    """As Siemens Testlab exports one."""
    x = {"start_value": 0.0, "increment": step, "number_of_values": 32.0, "quantity": {"label": "Hz"}}
    return {"x_values": x, "y_values": {"values": H.T, "quantity": {"label": "g/N"}}}


def matrices(name, content, *more):
    return raw(name, content.encode(), lambda path: ar.read_matrices(path, *more))


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

MISTAKES = {
    "npz: no rate": npz(a=A),
    "npz: two times": npz(run1_time=T, time=T, t=T, a=A),
    "npz: time and frequency": npz(time=T, freq=F, a=A),
    "npz: real responses": npz(freq=F, H=np.abs(H)),
    "npz: responses without imaginary part": npz(freq=F, H=REAL),
    "npz: one response real": npz(more={"responses": "H*"}, freq=F, H1=H[0], H2=np.abs(H[0])),
    "npz: one response zero": npz(more={"responses": "H*"}, freq=F, H1=H[0], H2=np.zeros(32)),
    "npz: a time with a gap": npz(time=GAP, a=A),
    "npz: a time that drifts": npz(time=UNEVEN, a=RNG.standard_normal(4000)),
    "npz: a time that descends": npz(time=T[::-1], a=A),
    "npz: a time in ms": npz(time=1e3 * T, fs=128.0, a=A),
    "npz: a time of another length": npz(time=T[:50], a=A),
    "npz: two axes": npz(more={"df_hz": 0.5, "freq_hz": F}, H=H),
    "npz: an axis of another length": npz(more={"freq_hz": F[:-1]}, H=H),
    "npz: responses of another length": npz(more={"responses": ["G", "H"]}, freq=F, H=H[0], G=H[0, :9]),
    "npz: coherence of another shape": npz(freq=F, H=H, coherence=np.ones(9)),
    "npz: an axis beside its name": npz(more={"df_hz": 0.5, "freq": "freq"}, freq=F, H=H),
    "npz: no such response": npz(more={"responses": "acc*"}, fs=128.0, a=A),
    "npz: no such force": npz(more={"force": "hammer"}, fs=128.0, a=A),
    "npz: an unknown unit": npz(more={"unit": "furlong"}, fs=128.0, a=A),
    "npz: a rate of zero": npz(more={"fs_hz": 0.0}, a=A),
    "npz: NaN in a record": npz(fs=128.0, a=np.where(T > 0.2, np.nan, A)),
    "npz: values of 1e160": npz(fs=128.0, a=1e160 * A),
    "npz: three axes": npz(fs=128.0, a=np.zeros((2, 3, 64)), b=A),
    "npz: a channel that was cut": npz(fs=128.0, a=A, b=B[:50]),
    "npz: objects": npz(a=np.array([1, "a"], dtype=object)),
    "npz: texts alone": npz(a=np.array(["x", "y"])),
    "npz: too many dofs": npz(more={"dofs": [0, 1, 2]}, fs=128.0, a=A, b=B),
    "npz: a dof twice": npz(more={"dofs": [1, 1]}, fs=128.0, a=A, b=B),
    "npz: a .npy cut in the header": raw("a.npy", b"\x93NUMPY\x01\x00", ar.read_npz),
    "csv: real columns over frequency": rows("freq,a", F, np.abs(H[0])),
    "csv: complex columns over time": rows(
        "time,a", T[:32], [f"{x.real!r}{x.imag:+}j" for x in H[0].tolist()]
    ),
    "csv: magnitude without its unit": rows("freq,Magnitude,Phase [deg]", F, np.abs(H[0]), F),
    "csv: phase without its unit": rows("freq,Magnitude [dB],Phase", F, np.abs(H[0]), F),
    "csv: an odd number of parts": rows("freq,a,b,c", F, F, F, F, pairs="real_imag"),
    "csv: an index and no rate": rows("index,a", range(64), A),
    "csv: a first column without name": rows("x,a", T, A),
    "csv: an instant that does not exist": rows(
        "when,a", [f"2026-02-30 12:00:{i:02d}" for i in range(9)], A[:9]
    ),
    "csv: an instant that is missing": text(
        "when,a", "2026-05-04 12:00:00,1", "n/a,2", "2026-05-04 12:00:02,3", "x,4"
    ),
    "csv: a row that is short": text("time,a", "0,1", "1", "2,3"),
    "csv: a word among numbers": text("time,a", "0,1", "1,dead", "2,3"),
    "csv: names that do not fit": text("time,a,b", "0,1", "1,2"),
    "csv: no numbers": text("time,a", "x,y"),
    "csv: one row": text("time,a", "0,1"),
    "csv: an unknown unit of time": text("time [ticks],a [g]", "0,1", "1,2", "2,3"),
    "csv: a rate beside another time": rows("time,a", T, A, fs_hz=100.0),
    "csv: two forces": rows("time,a [N],b [N],c [g]", T, A, B, A),
    "csv: a force alone": rows("time,a [N]", T, A),
    "csv: responses over time": rows("time,a [g/N]", T, A),
    "csv: a time alone": text("time", "0", "1", "2", first="time"),
    "csv: a step beside a time": rows("a,b", A, B, df_hz=1.0, first="time"),
    "csv: a NUL byte": raw("a.csv", b"time,a\n0,1\n\x00,2\n", ar.read_csv),
    "hdf5: rates that disagree": hdf5({"a": ("fs", 128.0), "b": ("fs", 64.0)}),
    "hdf5: a rate that no name tells": hdf5({"a": ("abtastung", 9.0)}),
    "hdf5: another rate than given": hdf5({"a": ("fs", 128.0)}, fs_hz=100.0),
    "hdf5: no file of HDF5": raw("a.h5", b"something else", ar.read_npz),
    "mat: nothing to read": mat({"name": "plate"}),
    "mat: an unknown unit in a field": mat({"run": {"acc": A, "fs": 128.0, "unit": "furlong"}}),
    "mat: an increment of zero": mat({"S": {"x_values": {"increment": 0.0}, "y_values": {"values": A}}}),
    "mat: cut in its head": raw("a.mat", b"MATLAB 7.3 MAT-file", ar.read_mat),
    "mat: a real response of ones": mat({"freq": F, "H1": np.ones(32)}),
    "mat: two axes": mat({"S": response(0.5), "R": response(0.25)}),
    "uff: no dataset": raw("a.uff", b"nothing here\n", ar.read_uff),
    "uff: a header alone": raw("a.uff", b"    -1\n   151\na header\n    -1\n", ar.read_uff),
    "uff: a cut set": uff(RECORD, lambda data: data[:-200]),
    "uff: FRFs without reference to choose": uff(FRFS, reference="7+Z"),
    "uff: a sensor that did not stay": uff(FRFS, write={"excitation": "1+X"}, roving="9+Z"),
    "uff: a kind that is not there": uff(RECORD, kind="frf"),
    "uff: a run that is not there": uff(RECORD, run=2),
    "uff: a point without dof": uff(RECORD, dofs={(1, "+X"): 0}),
    "uff: a force that is not there": uff(RECORD, force="9+Z"),
    "uff: a name that is no point": other(measured(), dofs={"12Q": 4}),
    "uff: dofs in a list": other(measured(), dofs=[1]),
    "uff: several references": other(*(function(node=n, reference=(k, 3)) for k in (1, 2) for n in (3, 4))),
    "uff: a hammer that roved": other(*(function(node=7, reference=(k, 3)) for k in (1, 2))),
    "uff: cross spectra alone": other(function(kind=3, reference=(5, 3))),
    "uff: several kinds": other(measured(), function()),
    "uff: a kind that does not exist": other(measured(), kind="modes"),
    "uff: a function of an unknown type": other(function(kind=0)),
    "uff: m and m/s2 together": other(function(), function(node=2, unit="mm")),
    "uff: a real FRF": other(function(A)),
    "uff: other frequencies": other(function(), function(node=2, step=0.25)),
    "uff: a step of zero": other(measured(step=0.0)),
    "uff: an unknown unit": other(measured(unit="V")),
    "uff: several runs": other(*[measured()] * 3),
    "uff: records of two rates": other(measured(), measured(node=2, step=0.1)),
    "uff: a complex record": other(dataset(H[0], binary=0)),
    "uff: a spectrum that is not positive": other(spectrum(A), function(kind=3, reference=(5, 3))),
    "uff: spectra of other lines": other(spectrum(np.ones(9)), function(kind=3, reference=(5, 3))),
    "uff: two dofs at one point": uff(RECORD, write={"dofs": {"1+X": (1, 0), "2+X": (1, 0)}}),
    "uff: a force that is no point": other(measured(), force="77Q"),
    "uff: a time with a gap": other(measured(even=0, x=np.where(T < 0.2, T, T + 0.05))),
    "uff: a dof without point": uff(RECORD, write={"dofs": {"1+X": (1, 0)}}),
    "uff: points that are none": uff(RECORD, write={"dofs": 7}),
    "uff: a label that is too long": uff(ar.Recording([A], 128.0, dofs=["x" * 100])),
    "sep005: written in g": lambda folder: ar.to_sep005(RECORD, unit="g"),
    "sep005: responses": lambda folder: ar.to_sep005(FRFS),
    "tdms: two rates": tdms([SET, {**SET, "wf_increment": 0.1}], A, B[:9]),
    "tdms: no rate": tdms([{"unit_string": "g"}], A),
    "tdms: no unit": tdms([{"wf_increment": 0.1}], A),
    "tdms: another rate than given": tdms([SET], A, fs_hz=100.0),
    "tdms: no such channel": tdms([SET], A, responses="tip"),
    "tdms: another file": raw("a.tdms", b"RIFF", ar.read_tdms),
    "wav: another file": raw("a.wav", b"TDSm" + bytes(40), ar.read_wav),
    "wav: no samples": raw("a.wav", b"RIFF" + bytes(4) + b"WAVE", ar.read_wav),
    "lvm: no header": raw("a.lvm", b"X_Value\ttip\n0\t1\n1\t2\n", ar.read_lvm),
    "lvm: a header without end": raw("a.lvm", b"LabVIEW Measurement\n", ar.read_lvm),
    "lvm: fewer samples than stated": lvm(*SEGMENT, "\t1", "\t2"),
    "lvm: more samples than stated": lvm(*SEGMENT, "\t1", "\t2", "\t3", "\t4"),
    "lvm: a word among numbers": lvm(*SEGMENT, "\t1", "\tx", "\t3"),
    "lvm: no such channel": lvm(*SEGMENT, "\t1", "\t2", "\t3", responses="b"),
    "lvm: a gap between segments": lvm(*SEGMENT, "\t1", "\t2", "\t3", "", *SEGMENT, "\t1", "\t2", "\t3"),
    "excel: an empty cell": sheet(["time", "a"], [0.0, 1.0], [1.0, 2.0, 3.0], [2.0, 3.0]),
    "excel: no sheet of that name": sheet(["time", "a"], [0.0, 1.0], sheet="run 2"),
    "parquet: texts": parquet({"time": T, "a": ["x"] * 64}),
    "parquet: empty cells": parquet({"time": T, "a": [None, *A[1:]]}),
    "parquet: one row": parquet({"time": T[:1], "a": A[:1]}),
    "file: a folder in place of a file": lambda folder: ar.read_npz(folder),
    "file: empty": raw("a.npz", b"", ar.read_npz),
    "file: a number in place of a name": lambda folder: ar.read_csv(7),
    "file: results into the root": lambda folder: ar.write_npz("/", RECORD),
    "file: into a folder that is not there": lambda folder: ar.write_npz(folder / "no" / "a.npz", RECORD),
    "matrices: a NUL byte": matrices("k.mtx", f"{MARKET}real general\n1 1\n\x00\n", np.eye(1)),
    "matrices: a lost entry": matrices("k.mtx", f"{MARKET}real general\n2 2\n1\n1\n1\n", np.eye(2)),
    "matrices: not square": matrices("k.mtx", f"{SPARSE}real general\n2 3 1\n1 1 1\n", np.eye(2)),
    "matrices: one word": matrices("k.mtx", "stiffness\n", np.eye(2)),
    "matrices: complex": matrices("k.mtx", f"{MARKET}complex hermitian\n1 1\n1 0\n", np.eye(1)),
    "matrices: a cut entry": matrices("k.mtx", f"{SPARSE}real general\n2 2 2\n1 1 1\n2 1\n", np.eye(2)),
    "matrices: a row beyond": matrices("k.mtx", f"{SPARSE}real general\n2 2 2\n1 1 1\n3 1 1\n", np.eye(2)),
    "matrices: other arrays": lambda folder: ar.read_matrices(
        ar.write_npz(folder / "a.npz", RECORD), np.eye(1)
    ),
    "matrices: no DMIG card": matrices("k.pch", "GRID,1,,0.,0.,0.\n", np.eye(1)),
    "matrices: no line end": matrices("k.mtx", f"{MARKET}real general\n1 1\n1", np.eye(1)),
    "matrices: a cut archive": matrices("k.mtx.gz", "\x1f\x8b", np.eye(1)),
    "matrices: an unknown ending": matrices("k.txt", "1 2 3\n", np.eye(1)),
    "matrices: no mass": lambda folder: ar.read_matrices(np.eye(2)),
    "matrices: a cut line of Abaqus": matrices("k.mtx", "1,1, 1,1, 5.0\n1,1, 1\n", np.eye(1)),
    "matrices: complex DMIG": matrices("k.bdf", "DMIG,K2,0,6,3\nDMIG,K2,1,1,,1,1,5.0,1.0\n", np.eye(1)),
    "matrices: written of a chain": lambda folder: ar.write_matrices(folder / "k.npz", ar.cases.chain8()),
    "matrices: another text in place of OUTPUT4": matrices("k.op4", "nothing here\n", np.eye(1)),
    "dof map: of a matrix without names": raw(
        "k.mtx", f"{MARKET}real general\n1 1\n1\n".encode(), ar.io.read_dof_map
    ),
    "dof map: no line": dof_map("nothing\n"),
    "dof map: a point twice": dof_map("1 X\n1 X\n"),
    "dof map: an unknown direction": dof_map("1 X\n2 Q\n"),
}


def test_each_mistake_is_told_in_the_words_that_were_looked_at(tmp_path):
    told = {}
    for number, (case, call) in enumerate(MISTAKES.items()):
        folder = tmp_path / f"m{number}_"
        folder.mkdir()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                call(folder)
            except ar.AntiresError as exc:
                said, kind = str(exc), type(exc).__name__
                assert all(word in said for word in ("got", "wanted")), said
            else:
                said, kind = " | ".join(str(each.message) for each in caught), "warning"
                assert {each.category for each in caught} == {ar.AntiresWarning}, case
        told[case] = f"{kind}  {said.replace(str(folder), 'FOLDER')}"
    compare(Path(__file__).with_name("wrong_files.txt"), told)
