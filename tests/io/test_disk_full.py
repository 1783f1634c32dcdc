"""A disk that is full: an error without a traceback, nothing half-written, what was there stays."""

import subprocess
import sys
from pathlib import Path

import pytest

import antires_rs as ar

pytest.importorskip("resource")
# A limit on the size of files stands for a disk without room: writing beyond it fails in the same place.
LIMITED = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
sys.argv[1:] = {arguments!r}
{code}
"""
COMMAND = "from antires_rs.app.main import main; sys.exit(main())"


def limited(folder, code, *arguments):
    text = LIMITED.format(arguments=[str(a) for a in arguments], code=code)
    return subprocess.run(
        [sys.executable, "-c", text], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("writer", ["write_npz", "write_mat", "write_csv", "write_uff"])
def test_writers_leave_what_was_there(tmp_path, writer):
    target = tmp_path / "a.out"
    target.write_bytes(b"before")
    code = (
        "import numpy as np, antires_rs as ar\n"
        "record = ar.Recording(np.random.default_rng(0).standard_normal((2, 2000)), 100.0)\n"
        f"try:\n    ar.{writer}({str(target)!r}, record)\n"
        "except OSError as exc:\n    print(type(exc).__name__)"
    )
    done = limited(tmp_path, code)
    assert (done.returncode, done.stdout.strip()) == (0, "OSError"), done.stderr
    assert target.read_bytes() == b"before"
    assert [path.name for path in tmp_path.iterdir()] == ["a.out"]


def test_the_command_line_ends_with_a_sentence(tmp_path):
    chain = ar.cases.chain8()
    ar.write_npz(tmp_path / "record.npz", chain.experiment(noise=0.01, duration_s=30.0, rng=0))
    given = ["identify", "record.npz", "--band", "3", "130", "--excitation", "0", "--out", "found.json"]
    done = limited(tmp_path, COMMAND, *given)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert done.stderr.strip().splitlines()[-1].startswith("antires: error: ")
    assert [path.name for path in Path(tmp_path).iterdir()] == ["record.npz"]
