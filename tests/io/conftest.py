"""Files that C code reads are read in this process: one of its own takes longer than the rest of a test.

The first test of each format, and all of damage, take ``own_process``: there everything is as users have it.
"""

import subprocess
import warnings

import pytest

from antires_rs.io import _child
from antires_rs.io.child_process import READER

RUN = subprocess.run


def read_here(command, **how):
    """``subprocess.run`` of the reader without a process; of anything else as ever."""
    if str(READER) not in command:
        return RUN(command, **how)
    code, said = 0, ""
    with warnings.catch_warnings(action="ignore"):
        try:
            _child.main(*command[command.index(str(READER)) + 1 :])
        except Exception as exc:
            code, said = 1, f"{type(exc).__name__}: {str(exc).partition(chr(10))[0]}"
    return subprocess.CompletedProcess(command, code, "", said)


@pytest.fixture
def own_process():
    """For a test whose files are read in a process of their own."""


@pytest.fixture(autouse=True)
def _read_here(request, monkeypatch):
    if "own_process" not in request.fixturenames:
        monkeypatch.setattr(subprocess, "run", read_here)
        monkeypatch.setattr(_child, "limit_memory", lambda gigabytes: None)
