"""Files of every kind that is read: how a good one is made, and how any is read."""

from __future__ import annotations

import gzip
import io
import json
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import antires_rs as ar

RNG = np.random.default_rng(11)
RECORD = ar.Recording(RNG.standard_normal((3, 240)), 256.0, dofs=["a", "b", "c"])
POINTS = ar.Recording(RECORD.responses, 256.0, dofs=["1+X", "2+X", "3+X"])
FRFS = ar.FrequencyResponse(
    np.arange(1.0, 101.0),
    RNG.standard_normal((2, 100)) + 1j * RNG.standard_normal((2, 100)),
    dofs=["1+X", "2+X"],
)
CHAIN = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 400.0])
SET = ar.AntiresonanceSet(0, {0: [2.0, 5.0], 1: [3.0], 2: []})
STIFFNESS = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])


@dataclass(frozen=True)
class Kind:
    """``write(path)`` makes a good file, ``read(path)`` reads any."""

    ending: str
    write: Callable[[Path], object]
    read: Callable[[Path], object]

    def make(self, folder):
        """A good file."""
        path = folder / f"good{self.ending}"
        self.write(path)
        return path


def _csv(path):
    rows = [
        f"{i / 256.0:.8f};" + ";".join(f"{v:.6e}" for v in column)
        for i, column in enumerate(RECORD.responses.T)
    ]
    path.write_text("time [s];a [g];b [g];c [g]\n" + "\n".join(rows) + "\n")


def _mat5(path):
    from scipy.io import savemat

    savemat(
        path,
        {
            "fs": 256.0,
            "acc": RECORD.responses,
            "info": {"name": "x", "cell": np.array([1, "a"], dtype=object)},
        },
    )


def _hdf5(path):
    import h5py

    with h5py.File(path, "w") as file:
        file["test/acc"], file["test/fs"] = RECORD.responses, 256.0
        file.create_dataset("test/more", data=RECORD.responses, chunks=True, compression="gzip")


def _mat73(path):
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in (("acc", RECORD.responses.T), ("fs", np.array([[256.0]]))):
            file[name] = value
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    whole = bytearray(path.read_bytes())
    whole[:10] = b"MATLAB 7.3"
    path.write_bytes(bytes(whole))


def _tdms(path):
    from nptdms import ChannelObject, TdmsWriter

    made = {"wf_increment": 1.0 / 256.0, "unit_string": "g"}
    with TdmsWriter(path) as file:
        for half in (slice(0, 120), slice(120, 240)):
            file.write_segment(
                [
                    ChannelObject("run", name, row[half], properties=made)
                    for name, row in zip("abc", RECORD.responses, strict=True)
                ]
            )


def _wav(path):
    from scipy.io import wavfile

    wavfile.write(path, 256, (RECORD.responses.T * 4000).astype(np.int16))


def _lvm(path):
    head = [
        "LabVIEW Measurement",
        "Separator\tTab",
        "Decimal_Separator\t.",
        "Multi_Headings\tYes",
        "X_Columns\tOne",
        "***End_of_Header***",
        "",
        "Channels\t3",
        "Samples\t240\t240\t240",
        "Y_Unit_Label\tg\tg\tg",
        "X0\t0.0\t0.0\t0.0",
        "Delta_X\t0.00390625\t0.00390625\t0.00390625",
        "***End_of_Header***",
        "X_Value\ta\tb\tc\tComment",
    ]
    rows = [
        f"{i / 256:.8f}\t" + "\t".join(f"{v:.6f}" for v in each) for i, each in enumerate(RECORD.responses.T)
    ]
    path.write_text("\n".join([*head, *rows, ""]))


def _frame():
    import pandas as pd

    return pd.DataFrame(
        {"time": np.arange(240) / 256.0, "a [g]": RECORD.responses[0], "b [g]": RECORD.responses[1]}
    )


def _excel(path):
    _frame().to_excel(path, index=False)


def _mseed(path):
    import obspy

    traces = [
        obspy.Trace(row, {"sampling_rate": 256.0, "station": f"S{i}"})
        for i, row in enumerate(RECORD.responses)
    ]
    obspy.Stream(traces).write(str(path), format="MSEED")


def _testlab(path):
    from scipy.io import savemat

    held = {
        "x_values": {"start_value": 0.0, "increment": 1.0 / 256.0, "number_of_values": 240.0},
        "y_values": {"values": RECORD.responses.T, "quantity": {"label": "g"}},
        "function_record": {"name": np.array(["a", "b", "c"], dtype=object)},
    }
    savemat(path, {"Signal": held})


def _attributes(path):
    import h5py

    with h5py.File(path, "w") as file:
        file["run/acc"] = RECORD.responses
        file["run"].attrs["fs"], file["run/acc"].attrs["unit"] = 256.0, "g"


def _instants(path):
    start = np.datetime64("2026-05-04T12:00:00", "us")
    rows = [
        f"{i};{start + np.timedelta64(3906 * i, 'us')};" + ";".join(f"{v:.6e}" for v in column)
        for i, column in enumerate(RECORD.responses.T)
    ]
    path.write_text(";when;a [g];b [g];c [g]\n" + "\n".join(rows) + "\n")


def _market(path, **options):
    from scipy.io import mmwrite
    from scipy.sparse import coo_array

    buffer = io.BytesIO()
    mmwrite(buffer, coo_array(STIFFNESS) if options.pop("sparse", False) else STIFFNESS, **options)
    path.write_bytes(gzip.compress(buffer.getvalue()) if path.suffix == ".gz" else buffer.getvalue())


def _sparse_npz(path):
    from scipy.sparse import csr_array, save_npz

    save_npz(path, csr_array(STIFFNESS))


def _dmig(path):
    lines = ["DMIG,KAAX,0,6,2,0,,,3"]
    for i in range(3):
        lines.append(f"DMIG,KAAX,{i + 1},3,,{i + 1},3,{STIFFNESS[i, i]:.6f}")
    path.write_text("\n".join(lines) + "\n")


def _matrix(path):
    return ar.read_matrices(path, np.eye(3))


def _result(path):
    ar.assess_damage(CHAIN, SET, rng=0, optimizer=ar.IslandGA(max_evaluations=400), workers=1).save(path)


def _job(path):
    from antires_rs.app.keys import template

    path.write_text(template("damage", "frame"))


def _read_job(path):
    from antires_rs.app.job import read_job

    return read_job(path)


_SIGNAL = {"fs_hz": 256.0}
KINDS = {
    "uff time": Kind(".uff", lambda p: ar.write_uff(p, POINTS, binary=False), ar.read_uff),
    "uff binary": Kind(".uff", lambda p: ar.write_uff(p, POINTS), ar.read_uff),
    "uff frf": Kind(".unv", lambda p: ar.write_uff(p, FRFS, binary=False, excitation="1+X"), ar.read_uff),
    "csv": Kind(".csv", _csv, ar.read_csv),
    "csv of ours": Kind(".csv", lambda p: ar.write_csv(p, RECORD), ar.read_csv),
    "npy": Kind(".npy", lambda p: np.save(p, RECORD.responses), lambda p: ar.read_npz(p, fs_hz=256.0)),
    "npz": Kind(".npz", lambda p: np.savez(p, acc=RECORD.responses, fs=256.0), ar.read_npz),
    "npz of ours": Kind(".npz", lambda p: ar.write_npz(p, RECORD), ar.read_npz),
    "hdf5": Kind(".h5", _hdf5, ar.read_hdf5),
    "hdf5 of ours": Kind(".h5", lambda p: ar.write_hdf5(p, RECORD), ar.read_hdf5),
    "mat5": Kind(".mat", _mat5, ar.read_mat),
    "mat of ours": Kind(".mat", lambda p: ar.write_mat(p, RECORD), ar.read_mat),
    "mat 7.3": Kind(".mat", _mat73, ar.read_mat),
    "mat of testlab": Kind(".mat", _testlab, ar.read_mat),
    "hdf5 attributes": Kind(".h5", _attributes, ar.read_hdf5),
    "csv instants": Kind(".csv", _instants, ar.read_csv),
    "tdms": Kind(".tdms", _tdms, ar.read_tdms),
    "wav": Kind(".wav", _wav, ar.read_wav),
    "lvm": Kind(".lvm", _lvm, ar.read_lvm),
    "excel": Kind(".xlsx", _excel, ar.read_excel),
    "parquet": Kind(".parquet", lambda p: _frame().to_parquet(p), ar.read_parquet),
    "miniseed": Kind(".mseed", _mseed, ar.read_miniseed),
    "mtx array": Kind(".mtx", lambda p: _market(p, symmetry="symmetric"), _matrix),
    "mtx sparse": Kind(".mtx", lambda p: _market(p, sparse=True, symmetry="general"), _matrix),
    "mtx.gz": Kind(".mtx.gz", lambda p: _market(p, symmetry="symmetric"), _matrix),
    "sparse npz": Kind(".npz", _sparse_npz, _matrix),
    "dmig": Kind(".pch", _dmig, _matrix),
    "antiresonances": Kind(".json", SET.save, ar.AntiresonanceSet.load),
    "result": Kind(".npz", _result, lambda p: ar.DamageResult.load(p)),
    "job": Kind(".toml", _job, _read_job),
}

#: What texts of numbers are made of: random bytes seldom form a line that a parser takes further.
_TEXT = b"0123456789.,;:eEijnaf+-#%\"'[]{}()= \t\n\\_abT/\x00"


def mutant(whole, rng):
    """``whole`` after one to four changes."""
    for _ in range(int(rng.integers(1, 5))):
        at = int(rng.integers(0, max(len(whole), 1)))
        length = int(rng.integers(1, 41))
        count = int(rng.integers(1, 9))
        new = bytes(rng.choice(list(_TEXT), count).tolist()) if rng.random() < 0.5 else rng.bytes(count)
        before, piece, after = whole[:at], whole[at : at + length], whole[at + length :]
        whole = (
            before + new + after,
            before + after,
            before + piece + piece + after,
            before,
            before + new + piece + after,
            before + new + piece[len(new) :] + after,
        )[int(rng.choice(6, p=[0.2, 0.15, 0.15, 0.1, 0.15, 0.25]))]
    return whole


def outcome(kind, path):
    """What comes of reading it: a word, and the error where it is a raw one."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
            KINDS[kind].read(path)
    except ar.exceptions.AntiresError:
        return "ours", ""
    except Exception as exc:  # the very thing that is looked for
        trace, where = exc.__traceback__, ""
        while trace is not None:
            if "antires_rs" in trace.tb_frame.f_code.co_filename:
                where = f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}"
            trace = trace.tb_next
        return "RAW", json.dumps(f"{type(exc).__name__}: {str(exc)[:100]} at {where}")
    return "read", ""
