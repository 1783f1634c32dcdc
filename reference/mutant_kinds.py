"""Files of every kind that is read: how a good one is made, how any is read, and how it is damaged.

Most mutants are blind. Those of the kinds "... repaired" are changed inside, and the checksums made anew:
what is read then are wrong values of the right form.
"""

from __future__ import annotations

import copy
import gzip
import io
import json
import sqlite3
import struct
import tempfile
import warnings
import zipfile
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from zlib import compress, crc32, decompress

import numpy as np

import antires_rs as ar
from reference.small_records import OPTIONS, record

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
CHAIN_SET = ar.AntiresonanceSet(0, {dof: CHAIN.antiresonances(0, dof) for dof in range(3)})
STIFFNESS = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])


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


@dataclass(frozen=True)
class Kind:
    """``write(path)`` makes a good file, ``read(path)`` reads any."""

    ending: str
    write: Callable[[Path], object]
    read: Callable[[Path], object]
    mutate: Callable[[bytes, np.random.Generator], bytes] = mutant

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


def _op4_text(path):
    lines = [f"{3:8d}{3:8d}{6:8d}{2:8d}{'KAA':<8}1P,3E23.16"]
    for j, column in enumerate(STIFFNESS.T):
        lines += [f"{j + 1:8d}{1:8d}{6:8d}", "".join(f"{value:23.16E}" for value in column)]
    path.write_text("\n".join([*lines, f"{4:8d}{1:8d}{1:8d}", f"{1.0:23.16E}"]) + "\n")


def _op4_binary(path):
    def of_fortran(*content):
        data = b"".join(content)
        return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))

    out = of_fortran(struct.pack("<4i8s", 3, 3, 6, 2, b"KAA     "))
    for j, column in enumerate(STIFFNESS.T):
        rows = np.flatnonzero(column)
        run = column[rows[0] : rows[-1] + 1]
        head = struct.pack("<4i", j + 1, 0, 2 * run.size + 1, rows[0] + 1 + 65536 * (2 * run.size + 1))
        out += of_fortran(head, run.astype("<f8").tobytes())
    path.write_bytes(out + of_fortran(struct.pack("<5i", 4, 1, 2, 0, 0)))


def _harwell_boeing(path):
    from scipy.io import hb_write
    from scipy.sparse import csc_matrix

    hb_write(str(path), csc_matrix(STIFFNESS))


def _abaqus(path):
    rows = [f"{i + 1},3, {j + 1},3, {STIFFNESS[i, j]:.16e}" for i in range(3) for j in range(3)]
    path.write_text("*MATRIX, NAME=K\n" + "\n".join(rows) + "\n")


def _matrices_of_ours(path):
    ar.write_matrices(path, ar.MatrixModel(STIFFNESS, np.eye(3), stiffness_terms={"web": STIFFNESS}))


def _series(path):
    conditions = {"temperature_c": [20.0, np.nan, 22.0], "time": [f"2026-01-0{i}T00:00" for i in (1, 2, 3)]}
    sets = [SET, None, SET.add(1, 9.0, reason="seen in the curve")]
    ar.Series.from_sets(sets, names=["a", "b", "c"], conditions=conditions).save(path)


def _read_series(path):
    series = ar.Series.load(path)
    return [*series], series.conditions, series.times, series.to_dataframe()


def _read_conditions(path):
    from antires_rs.watch.conditions import condition_table

    return condition_table(path)[0].in_order(("a", "b", "c"))


def _conditions_of_parquet(path):
    import pandas as pd

    pd.DataFrame({"name": ["a", "b", "c"], "temperature_c": [20.0, 21.5, 22.0]}).to_parquet(path)


def _assessor(path):
    ar.Assessor(CHAIN, baseline=CHAIN_SET, rng=0, workers=1).save(path)


def _updating(path, **more):
    factors = [ar.stiffness_factor(i, bounds=(0.8, 1.2)) for i in range(2)]
    problem = ar.UpdatingProblem(CHAIN, factors, CHAIN_SET)
    search = ar.IslandGA(max_evaluations=400)
    return ar.update(problem, optimizer=search, rng=0, workers=1, **more)


def _checkpoint(path):
    _updating(path, checkpoint=path)


def _evidence(path):
    from antires_rs.app.run import Evidence

    found = ar.identify_antiresonances(record(), **OPTIONS)
    Evidence((found.diagrams,), FRFS).save(path)


def _read_evidence(path):
    from antires_rs.app.run import Evidence

    return Evidence.load(path)


def _modes(path):
    shapes = np.array([[1.0, 0.5, -1.0], [1.0, -0.5, 0.25]])
    ar.ModalSet([2.0, 5.0], shapes, ["a", "b", "c"], std_hz=[0.01, 0.02]).save(path)


def _points(path):
    path.write_text("name;x [mm];y [mm];z [mm];direction\ntip;500;0;0;-Z\nmid;250;0;0;+Y\nroot;0;0;0;z\n")


def _match(path):
    return ar.match_points(path, [(0.0, 0.0, 0.0), (0.25, 0.0, 0.0), (0.5, 0.0, 0.0)])


# -- Changes inside a file, after which its checksums are made anew

_OTHER = (None, True, -1, 0, 1, 2**31, 2**63, 10**30, 0.5, -1.5, 1e308, "", "x", "inf", [], [1], {}, {"a": 1})
_OTHER += ({"array": "a0"}, {"class": "Plan"}, {"tuple": []}, {"float": "nan"}, {"dict": [[1, 2]]}, [[]])


def changed(data, rng):
    """Plain data of which one to three leaves or branches are others, gone, or more."""
    data = copy.deepcopy(data)
    for _ in range(int(rng.integers(1, 4))):
        at, places = data, []
        while isinstance(at, dict | list) and len(at) and (not places or rng.random() < 0.8):
            keys = list(at) if isinstance(at, dict) else range(len(at))
            places.append((at, keys[int(rng.integers(len(keys)))]))
            at = at[places[-1][1]]
        if not places:
            return data
        held, key = places[-1]
        way = rng.random()
        if way < 0.15:
            del held[key]
        elif way < 0.3 and isinstance(held, list):
            held.append(held[key])
        elif way < 0.4 and isinstance(held[key], int | float) and abs(held[key]) < 1e300:
            held[key] = -held[key] if rng.random() < 0.5 else 3 * held[key] + 1
        else:
            held[key] = copy.deepcopy(_OTHER[int(rng.integers(len(_OTHER)))])
    return data


def _array(array, rng):
    """Another array: of other values, another shape or type."""
    flat = array.reshape(-1)
    ways = (
        lambda: flat[: flat.size // 2],
        lambda: array[np.newaxis],
        lambda: array.astype("U8"),
        lambda: np.array(7),
        lambda: np.full_like(array, 10**6),
        lambda: -array.astype(np.float64),
        lambda: np.where(np.arange(flat.size) % 3, flat, np.nan).reshape(array.shape),
        lambda: np.concatenate([flat, flat]),
        lambda: array.astype("M8[s]"),
        lambda: array + 1j,
    )
    try:
        return np.asarray(ways[int(rng.integers(len(ways)))]())
    except (TypeError, ValueError):
        return np.zeros(0)


def _archive(whole):
    with np.load(io.BytesIO(whole)) as held:
        return dict(held)


def _saved(arrays):
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def _store_repaired(whole, rng):
    """What archive.write_store writes: a text and arrays, all with SHA-256."""
    from antires_rs.io.archive import _digest

    held = _archive(whole)
    data = json.loads(bytes(held.pop("antires_rs")))
    del held["text_sha256"], data["sha256"]
    if held and rng.random() < 0.4:
        name = list(held)[int(rng.integers(len(held)))]
        held[name] = _array(held[name], rng)
    else:
        frame = {key: data.pop(key) for key in ("format", "version", "class", "made_with") if key in data}
        data = frame | changed(data, rng)
    data["sha256"] = {name: _digest(array) for name, array in held.items()}
    text = json.dumps(data).encode()
    own = {"antires_rs": text, "text_sha256": sha256(text).digest()}
    return _saved(own_arrays(own) | held)


def own_arrays(texts):
    """Bytes as arrays."""
    return {name: np.frombuffer(text, dtype=np.uint8) for name, text in texts.items()}


def _signal_repaired(whole, rng):
    """What write_npz writes."""
    held = _archive(whole)
    data = json.loads(bytes(held.pop("antires_rs")))
    if rng.random() < 0.4:
        name = list(held)[int(rng.integers(len(held)))]
        held[name] = _array(held[name], rng)
        data["arrays"][name] = [str(held[name].dtype), *held[name].shape]
    else:
        data = {"format": data.pop("format")} | changed(data, rng)
    data.pop("text_crc32", None)
    data["crc32"] = {name: crc32(np.ascontiguousarray(array).tobytes()) for name, array in held.items()}
    data["text_crc32"] = crc32(json.dumps(data).encode())
    return _saved(own_arrays({"antires_rs": json.dumps(data).encode()}) | held)


def _zip_repaired(whole, rng):
    """Members of a zip archive are mutants, under right checksums."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(whole)) as old, zipfile.ZipFile(buffer, "w") as new:
        names = old.namelist()
        chosen = names[int(rng.integers(len(names)))]
        for name in names:
            new.writestr(name, mutant(old.read(name), rng) if name == chosen else old.read(name))
    return buffer.getvalue()


def _gzip_repaired(whole, rng):
    return gzip.compress(mutant(gzip.decompress(whole), rng))


def _csv_repaired(whole, rng):
    """Without the checksum, which files of versions before lack."""
    return mutant(b"".join(line for line in whole.splitlines(True) if b"crc32" not in line), rng)


def _json_changed(whole, rng):
    data = json.loads(whole)
    return json.dumps({"format": data.pop("format")} | changed(data, rng)).encode()


def _checkpoint_repaired(whole, rng):
    return _with_payload(whole, mutant(_payload_of(whole), rng))


def _sqlite_repaired(whole, rng):
    """A database of a series of which one field is another, or the text in it, and all checksums right."""
    from antires_rs.watch.store import _checksum

    with tempfile.NamedTemporaryFile(suffix=".sqlite") as file:
        Path(file.name).write_bytes(whole)
        with closing(sqlite3.connect(file.name)) as db, db:
            column = ("name", "conditions", "time", "failed", "facts", "columns")[int(rng.integers(6))]
            place, value = db.execute(f"SELECT place, {column} FROM tests").fetchall()[int(rng.integers(3))]
            if column in ("conditions", "facts", "columns") and value and rng.random() < 0.9:
                text = decompress(value) if column == "columns" else value
                value = json.dumps(changed(json.loads(text), rng))
                value = compress(value.encode()) if column == "columns" else value
            else:
                value = (None, 7, "x", b"\xff\x00", 1.5, "2026-13-99")[int(rng.integers(6))]
            db.execute(f"UPDATE OR REPLACE tests SET {column} = ? WHERE place = ?", (value, place))
            own = "name, fingerprint, conditions, time, failed, facts, columns"
            for at, *values in db.execute(f"SELECT place, {own} FROM tests").fetchall():
                db.execute("UPDATE tests SET checksum = ? WHERE place = ?", (_checksum(values), at))
            if rng.random() < 0.3:
                known = dict(db.execute("SELECT name, value FROM series WHERE name != 'checksum'"))
                facts = changed({name: json.loads(text) for name, text in known.items()}, rng)
                facts["checksum"] = _checksum(sorted(facts.items(), key=str))
                db.execute("DELETE FROM series")
                items = [(name, json.dumps(value)) for name, value in facts.items()]
                db.executemany("INSERT INTO series VALUES (?, ?)", items)
        return Path(file.name).read_bytes()


def _parquet_repaired(whole, rng):
    """A table of a series of which a field or the text in its metadata is another."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pq.read_table(pa.BufferReader(whole))
    about = json.loads(table.schema.metadata[b"antires_rs"])
    if rng.random() < 0.4:
        about = {"format": about.pop("format")} | changed(about, rng)
    else:
        name = table.column_names[int(rng.integers(table.num_columns))]
        values, at = table.column(name).to_pylist(), int(rng.integers(table.num_rows))
        if name == "facts" and rng.random() < 0.9:
            at = next(i for i, value in enumerate(values) if value)
            values[at] = json.dumps(changed(json.loads(values[at]), rng))
        else:
            values[at] = None if rng.random() < 0.5 else values[int(rng.integers(len(values)))]
        kind = table.schema.field(name)
        if rng.random() < 0.2:
            kind, values = pa.field(name, pa.string()), [None if v is None else str(v) for v in values]
        table = table.set_column(table.column_names.index(name), kind, pa.array(values, kind.type))
        if rng.random() < 0.1:
            table = table.drop_columns([name])
    buffer = pa.BufferOutputStream()
    pq.write_table(table.replace_schema_metadata({"antires_rs": json.dumps(about)}), buffer)
    return buffer.getvalue().to_pybytes()


def _text_of(whole):
    return bytes(_archive(whole)["antires_rs"])


def _with_text(whole, text):
    """An archive of ours with another text, under the checksum of that."""
    held = _archive(whole) | own_arrays({"antires_rs": text})
    if "text_sha256" in held:
        held |= own_arrays({"text_sha256": sha256(text).digest()})
    return _saved(held)


def _payload_of(whole):
    return whole[whole.index(b"\n") + 1 + struct.calcsize("<Q32s32sQ") :]


def _with_payload(whole, payload):
    """A checkpoint with another search in it."""
    fixed = whole.index(b"\n") + 1 + struct.calcsize("<Q32s")
    return whole[:fixed] + sha256(payload).digest() + struct.pack("<Q", len(payload)) + payload


#: What a checksum covers, and a file with another one.
INSIDE = {"checkpoint": (_payload_of, _with_payload)}
INSIDE |= dict.fromkeys(
    ("result", "assessor", "matrices of ours", "evidence", "npz of ours"), (_text_of, _with_text)
)
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
    "op4 text": Kind(".op4", _op4_text, _matrix),
    "op4 binary": Kind(".op4", _op4_binary, _matrix),
    "harwell-boeing": Kind(".rua", _harwell_boeing, _matrix),
    "abaqus": Kind(".mtx", _abaqus, _matrix),
    "matrices of ours": Kind(".npz", _matrices_of_ours, ar.read_matrices),
    "series parquet": Kind(".parquet", _series, _read_series),
    "series sqlite": Kind(".sqlite", _series, _read_series),
    "conditions": Kind(".csv", lambda p: p.write_text("name;t\na;20,5\nb;\nc;22\n"), _read_conditions),
    "conditions parquet": Kind(".parquet", _conditions_of_parquet, _read_conditions),
    "assessor": Kind(".npz", _assessor, ar.Assessor.load),
    "checkpoint": Kind(".ckpt", _checkpoint, _checkpoint),
    "evidence": Kind(".npz", _evidence, _read_evidence),
    "modes": Kind(".json", _modes, ar.ModalSet.load),
    "points": Kind(".csv", _points, _match),
}
_REPAIRED = {
    "npz": _zip_repaired,
    "sparse npz": _zip_repaired,
    "excel": _zip_repaired,
    "mtx.gz": _gzip_repaired,
}
_REPAIRED |= dict.fromkeys(("result", "matrices of ours", "assessor", "evidence"), _store_repaired)
_REPAIRED |= {
    "npz of ours": _signal_repaired,
    "csv of ours": _csv_repaired,
    "checkpoint": _checkpoint_repaired,
}
_REPAIRED |= {"series parquet": _parquet_repaired, "series sqlite": _sqlite_repaired}
_REPAIRED |= dict.fromkeys(("antiresonances", "modes"), _json_changed)
KINDS |= {f"{name} repaired": replace(KINDS[name], mutate=mutate) for name, mutate in _REPAIRED.items()}


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


#: What is fuzzed, by the first byte of an input; new kinds come last.
FUZZED = ["uff time", "uff binary", "uff frf", "csv", "csv instants", "npy", "lvm", "mtx array", "mtx sparse"]
FUZZED += ["dmig", "abaqus", "op4 text", "op4 binary", "harwell-boeing", "antiresonances", "modes", "job"]
FUZZED += ["conditions", "points", "result", "assessor", "matrices of ours", "evidence", "npz of ours"]
FUZZED += ["checkpoint"]


def of_input(data, good, folder):
    """Outcome of an input of a fuzzer: the kind, and the rest of a file; ``good`` has a file of each kind."""
    kind = FUZZED[data[0] % len(FUZZED)] if data else FUZZED[0]
    path = folder / f"input{KINDS[kind].ending}"
    path.write_bytes(INSIDE[kind][1](good[kind], data[1:]) if kind in INSIDE else data[1:])
    return outcome(kind, path)
