"""Row 2 of the files' bar: every format and every kind of data comes back to the format's precision."""

import os
import subprocess
import sys

import numpy as np
import pytest

import antires_rs as ar
from reference.io_signals import KINDS, differences, recording, response
from tests.support.refusals import refused, unsuitable

pytest.importorskip("h5py")

EXACT = {
    "npz": (ar.write_npz, ar.read_npz, ".npz"),
    "HDF5": (ar.write_hdf5, ar.read_hdf5, ".h5"),
    "MAT": (ar.write_mat, ar.read_mat, ".mat"),
    "CSV": (ar.write_csv, ar.read_csv, ".csv"),
    "TSV": (lambda path, s: ar.write_csv(path, s, delimiter="\t"), ar.read_csv, ".tsv"),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("form", EXACT)
def test_every_bit_comes_back(tmp_path, form, kind):
    write, read, ending = EXACT[form]
    made = KINDS[kind]()
    path = write(tmp_path / f"signal{ending}", made)
    assert path == tmp_path / f"signal{ending}"
    assert set(differences(made, read(path)).values()) == {0.0}


@pytest.mark.parametrize("kind", [k for k in KINDS if "deviations" not in k])
@pytest.mark.parametrize("binary", [True, False])
def test_universal_files(tmp_path, kind, binary):
    made = KINDS[kind]()
    found = differences(made, ar.read_uff(ar.write_uff(tmp_path / "signal.uff", made, binary=binary)))
    # Text has 12 digits; its abscissa, where it is uneven, 6. Even lines are made again from first and step.
    digits = 0.0 if binary else 5e-12
    uneven = 0.0 if binary else 5e-6
    limits = dict.fromkeys(("responses", "force", "values", "coherence"), digits)
    limits["freq_hz"] = uneven if kind == "FRF on uneven lines" else 1e-12
    limits["std"] = 0.0 if binary else 1e-9  # derived from coherence, where 1 - coherence loses digits
    assert all(found[name] <= limits[name] for name in found), found


def test_universal_files_keep_no_deviations_of_their_own(tmp_path):
    made = response(std=True)
    with pytest.warns(ar.AntiresWarning, match="standard deviations are not those of coherence"):
        back = ar.read_uff(ar.write_uff(tmp_path / "signal.uff", made))
    np.testing.assert_array_equal(back.values, made.values)
    assert not np.allclose(back.std, made.std)


@pytest.mark.parametrize("write", [ar.write_npz, ar.write_hdf5, ar.write_mat, ar.write_csv, ar.write_uff])
def test_writers_take_signals_and_existing_folders(tmp_path, write):
    odd = ar.Recording(np.ones((1, 4)), 1.0, dofs=[(3, "z")])
    if write is not ar.write_uff:
        refused(r"^signal: got the dof \(3, 'z'\)", write, tmp_path / "x", odd)
    refused("^signal: got list; wanted a Recording", write, tmp_path / "x", [1.0])
    with pytest.raises(ar.InvalidInputError, match="^path: got .*; wanted a file in a folder that exists"):
        write(tmp_path / "none" / "x", recording())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("read", [ar.read_npz, ar.read_hdf5, ar.read_mat, ar.read_csv, ar.read_uff])
def test_readers_name_the_file(tmp_path, read):
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "none")
    (tmp_path / "noise").write_bytes(np.random.default_rng(0).bytes(5000))
    unsuitable("^path: got '.*noise', .*; wanted ", read, tmp_path / "noise")
    (tmp_path / "prose").write_text("To whom it may concern:\nno number here.\n")
    unsuitable("^path: got '.*prose', .*; wanted ", read, tmp_path / "prose")


# A limit on the size of files stands for a disk without room: writing beyond it fails in the same place.
LIMITED = """
import resource, signal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
import numpy as np, antires_rs as ar
record = ar.Recording(np.random.default_rng(0).standard_normal((2, 2000)), 100.0)
for write in (ar.write_npz, ar.write_mat, ar.write_csv, ar.write_uff):
    try:
        write("a.out", record)
    except OSError as exc:
        print(type(exc).__name__)
for ending in ("sqlite", "parquet"):
    try:
        ar.Series.from_sets([ar.AntiresonanceSet(0, {0: np.arange(1.0, 900.0)})]).save(f"a.{ending}")
    except OSError as exc:
        print(type(exc).__name__)
"""


@pytest.mark.skipif(os.name != "posix", reason="limits as set here are POSIX")
def test_writers_leave_what_was_there(tmp_path):
    (tmp_path / "a.out").write_bytes(b"before")
    call = [sys.executable, "-c", LIMITED]
    done = subprocess.run(call, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stdout.split()) == (0, ["OSError"] * 6), done.stderr
    assert (tmp_path / "a.out").read_bytes() == b"before"
    assert [path.name for path in tmp_path.iterdir()] == ["a.out"]
