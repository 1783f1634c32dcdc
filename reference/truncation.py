"""Files of every format, cut at any byte: is the cut noticed?

A cut lies inside a record (a dataset, a row, a variable, a header) or on the boundary between two. What may
come of it: an error of ours; a result with a warning; a result equal to the whole one, where only a last line
end was lost; or silence, which is allowed on a boundary of a format that does not state its size.
"""

import io
import re
import warnings
from collections import Counter
from dataclasses import dataclass

import numpy as np
from scipy.io import mmwrite, savemat

import antires_rs as ar
from reference.io_signals import differences, recording, response

DAMPED = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 400.0])
SET = ar.AntiresonanceSet(0, {0: [1.7, 5.3], 1: [2.5], 2: []}, std_hz={0: [0.01, 0.02]})
# Files of more than a few hundred bytes, so that 300 cuts find 300 places.
LONG = ar.MassSpringChain([1.0] * 40, [500.0] * 39)
MANY = ar.AntiresonanceSet(0, {dof: [1.7 + dof, 5.3 + dof] for dof in range(20)}, std_hz={0: [0.01, 0.02]})


@dataclass
class Format:
    """How a file of a format is made and read, and where its records end."""

    write: object
    read: object
    ends: object = None
    #: Whether the file tells how many records it should have.
    states_size: bool = True
    partial: bool = False
    ending: str = ".bin"


def uff_ends(data):
    """After each closing marker, with its line end and without: the dataset is whole either way."""
    ends = [m.end() for m in re.finditer(rb"(?:\A|(?<=\n)) {4}-1 *\n", data)][1::2]
    return sorted(end - i for end in ends for i in (0, 1))


def line_ends(data):
    return [i + 1 for i, byte in enumerate(data) if byte == 10]


def mat_ends(data):
    ends, at = [128], 128
    while at < len(data):
        at += 8 + int.from_bytes(data[at + 4 : at + 8], "little")
        ends.append(at)
    return ends


def foreign_uff(binary):
    def write(path):
        ar.write_uff(path, recording(n=100), binary=binary)
        path.write_bytes(path.read_bytes().replace(b"antires_rs uff", b"other program."))

    return write


def foreign_csv(path):
    rec = recording(n=100)
    rows = [";".join(f"{v:.9g}" for v in (t / 512.0, *column)) for t, column in enumerate(rec.responses.T)]
    path.write_text("time [s];a [g];b [g];c [g]\n" + "\n".join(rows) + "\n")


def foreign_mat(path):
    rec = recording(n=100)
    savemat(path, {"fs": 512.0, "a": rec.responses[0], "b": rec.responses[1], "c": rec.responses[2]})


def mat73(path):
    """As MATLAB writes it: HDF5 after a block of 512 bytes, columns first."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in (("fs", np.array([[512.0]])), ("a", recording(n=100).responses)):
            file.create_dataset(name, data=value.T).attrs["MATLAB_class"] = np.bytes_("double")
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def foreign_hdf5(path):
    import h5py

    with h5py.File(path, "w") as file:
        file["test/fs"], file["test/acc"] = 512.0, recording(n=100).responses


def foreign_npz(path):
    with open(path, "wb") as file:
        np.savez(file, fs=512.0, acc=recording(n=100).responses)


def market(path):
    buffer = io.BytesIO()
    mmwrite(buffer, LONG.stiffness(), symmetry="symmetric")
    path.write_bytes(buffer.getvalue())


def result(path):
    problem = ar.UpdatingProblem(DAMPED, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), SET)
    ar.update(problem, rng=0, optimizer=ar.IslandGA(max_evaluations=400)).save(path)


FORMATS = {
    "UFF 58b, ours": Format(lambda p: ar.write_uff(p, recording(n=100)), ar.read_uff, uff_ends, partial=True),
    "UFF 58, ours": Format(
        lambda p: ar.write_uff(p, response(n=60), binary=False), ar.read_uff, uff_ends, partial=True
    ),
    "UFF 58b, other": Format(foreign_uff(True), ar.read_uff, uff_ends, states_size=False, partial=True),
    "UFF 58, other": Format(foreign_uff(False), ar.read_uff, uff_ends, states_size=False, partial=True),
    "CSV, ours": Format(lambda p: ar.write_csv(p, response(n=60)), ar.read_csv, line_ends, partial=True),
    "CSV, other": Format(foreign_csv, ar.read_csv, line_ends, states_size=False, partial=True),
    "MAT 5, ours": Format(lambda p: ar.write_mat(p, recording(n=100)), ar.read_mat, mat_ends),
    "MAT 5, other": Format(foreign_mat, ar.read_mat, mat_ends, states_size=False),
    "MAT 7.3": Format(mat73, ar.read_mat),
    "HDF5, ours": Format(lambda p: ar.write_hdf5(p, recording(n=100)), ar.read_hdf5),
    "HDF5, other": Format(foreign_hdf5, ar.read_hdf5),
    "npz, ours": Format(lambda p: ar.write_npz(p, recording(n=100)), ar.read_npz),
    "npz, other": Format(foreign_npz, ar.read_npz),
    "Matrix Market": Format(market, lambda p: ar.read_matrices(p, np.eye(40)), line_ends, ending=".mtx"),
    "matrices, npz": Format(
        lambda p: ar.write_matrices(p, ar.MatrixModel(DAMPED.stiffness(), np.eye(3))), ar.read_matrices
    ),
    "result, npz": Format(result, ar.UpdateResult.load, ending=".npz"),
    "AntiresonanceSet": Format(MANY.save, ar.AntiresonanceSet.load, ending=".json"),
}


def equal(a, b):
    """Whether nothing was lost."""
    if isinstance(a, ar.AntiresonanceSet):
        return a == b
    if isinstance(a, ar.MatrixModel):
        return all(abs(x - y).max() == 0.0 for x, y in ((a.stiffness(), b.stiffness()), (a.mass(), b.mass())))
    if isinstance(a, ar.UpdateResult):
        return a.summary() == b.summary()
    try:
        return set(differences(a, b).values()) == {0.0}
    except AssertionError:
        return False


def outcome(form, path, whole, **options):
    """What reading the file does; anything but these is a bug, and is raised."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            got = form.read(path, **options)
        except ar.AntiresError:
            return "error"
    if any(issubclass(w.category, ar.AntiresWarning) for w in told):
        return "warning"
    return "whole" if equal(got, whole) else "silence"


def places(form, data, count, seed=0):
    """Where to cut: distinct random places inside records, and distinct ones on boundaries."""
    rng = np.random.default_rng(seed)
    ends = [] if form.ends is None else [e for e in form.ends(data) if e < len(data)]
    within = np.setdiff1d(np.arange(1, len(data)), ends)
    inside = rng.choice(within, min(within.size, count), replace=False)
    on = rng.choice(ends, min(len(ends), count), replace=False) if ends else []
    return [int(i) for i in inside], [int(i) for i in on]


def cut_at(name, folder, count, seed=0):
    """(class, outcome, outcome with partial=True or None) of cuts inside records, then on boundaries."""
    form = FORMATS[name]
    path = folder / f"whole{form.ending}"
    form.write(path)
    data, whole = path.read_bytes(), form.read(path)
    inside, on = places(form, data, count, seed)
    for where, position in [("inside", i) for i in inside] + [("boundary", i) for i in on]:
        cut = folder / f"cut{form.ending}"
        cut.write_bytes(data[:position])
        yield (
            where,
            outcome(form, cut, whole),
            outcome(form, cut, whole, partial=True) if form.partial else None,
        )


def judged(name, folder, count, seed=0):
    """Counts of (class, outcome), ``partial=True`` as a class of its own; and what breaks the bar."""
    counts, bad = Counter(), []
    for where, strict, partial in cut_at(name, folder, count, seed):
        counts[where, strict] += 1
        if partial is not None:
            counts[where + ", partial", partial] += 1
        allowed = {"error", "warning", "whole"}
        if where == "boundary" and not FORMATS[name].states_size:
            allowed |= {"silence"}
        bad += [(where, o) for o in (strict, partial) if o is not None and o not in allowed]
    return counts, bad
