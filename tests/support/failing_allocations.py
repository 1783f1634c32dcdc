"""Allocations that fail: the n-th of Python, or all large ones. What comes of it, and what is left.

A process of its own, which forks one for every trial, so that the package is loaded once.
``python -m tests.support.failing_allocations FOLDER EACH [KIND ...]`` prints, as JSON, how often each outcome
came, and what is wrong. Kinds are those of ``reference.mutant_kinds``, which are read, and written where the
writer is ours; and "identification".
"""

import json
import os
import pickle
import resource
import shutil
import signal
import sys
import warnings
from _testcapi import remove_mem_hooks, set_nomemory
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np

import antires_rs as ar
from reference.mutant_kinds import KINDS
from reference.small_records import OPTIONS, record

#: Of others: calls of the system and PyO3 hide that memory was short, and NumPy, by a SystemError.
OF_OTHERS = "not PosixPath", "PyObject pointer is null"
PAGE, MB = os.sysconf("SC_PAGE_SIZE"), 2**20
ROOMS_MB = 1, 8, 16, 32
WRITTEN = "uff time", "uff binary", "uff frf", "antiresonances", "modes", "series sqlite", "series parquet"


def identified():
    return ar.identify_antiresonances(record(), **OPTIONS)


def read_and_identified(path):
    return ar.identify_antiresonances(ar.read_npz(path), **OPTIONS)


def pickled(value):
    try:
        return pickle.dumps(value)
    except Exception:  # of what is not pickled: it is only known to be there
        return b""


def outcome(act, wanted, number, room_mb=None):
    """A word for what came of ``act`` when its n-th allocation failed, or beyond so much memory."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if room_mb is not None:
                used = int(Path("/proc/self/statm").read_text().split()[0]) * PAGE
                resource.setrlimit(resource.RLIMIT_AS, (used + room_mb * MB,) * 2)
            else:
                set_nomemory(number, number + 1)
            try:
                got = act()
            finally:
                remove_mem_hooks()
        return "done" if wanted in (None, pickled(got)) else "WRONG: another value"
    except ar.exceptions.AntiresError as error:
        return f"WRONG: {error}" if "(MemoryError)" in str(error) else "ours"  # said of a good file
    except MemoryError:
        return "MemoryError"
    except BaseException as error:  # a panic is none of Exception
        of_others = isinstance(error, SystemError) or any(said in str(error) for said in OF_OTHERS)
        return "of others" if of_others else f"WRONG: {error!r}"


def trial(act, wanted, *how):
    """The outcome in a process of its own, which a signal may end."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        os.write(writing, outcome(act, wanted, *how).encode())
        os._exit(0)
    os.close(writing)
    with open(reading) as pipe:
        said = pipe.read()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return said if status == 0 else f"WRONG: ended with {status}"


def value_of(act):
    """What it returns twice alike, as bytes; None where that cannot be compared."""
    first, second = (pickled(act()) for _ in range(2))
    return first if first == second != b"" else None


def main(folder, each, kinds):
    rng, seen, wrong = np.random.default_rng(1), Counter(), []

    def tried(name, act, *how, wanted=None):
        said = trial(act, wanted, *how)
        seen[said.partition(":")[0]] += 1
        if said.startswith("WRONG"):
            wrong.append(f"{name} {how}: {said}")

    numbers = (10 ** rng.uniform(0.0, 4.5, (len(kinds), each))).astype(int).tolist()
    for kind, some in zip(kinds, numbers, strict=True):
        if kind == "identification":
            wanted = value_of(identified)
            for number in some:
                tried(kind, identified, number, wanted=wanted)
            large = ar.write_npz(folder / "large.npz", record(duration_s=40_000.0))
            for room_mb in ROOMS_MB:
                tried("large record", partial(read_and_identified, large), 0, room_mb)
            continue
        (own := folder / kind).mkdir()
        try:
            path = KINDS[kind].make(own)
        except ImportError:
            continue
        wanted = value_of(partial(KINDS[kind].read, path))
        for number in some:
            tried(f"{kind} read", partial(KINDS[kind].read, path), number, wanted=wanted)
        written = folder / "written"
        for number in some if kind in WRITTEN or kind.endswith("of ours") else ():
            written.mkdir()
            tried(f"{kind} written", partial(KINDS[kind].make, written), number)
            there = os.listdir(written)
            whole = (
                there == [path.name] and value_of(partial(KINDS[kind].read, written / path.name)) == wanted
            )
            if there and not whole:
                wrong.append(f"{kind} written {number}: {there} is left, or what is there is not whole")
            shutil.rmtree(written)
        shutil.rmtree(own)
    print(json.dumps({"seen": seen, "wrong": wrong}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3:] or ["identification", *KINDS])
