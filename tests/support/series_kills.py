"""Kill a series before each change that it makes on the disk, go on, compare the files.

A process of its own, which forks, so that packages are loaded once: ``python -m tests.support.series_kills
FOLDER`` prints the number of points and what is wrong as JSON.
"""

import contextlib
import json
import os
import shutil
import signal
import sys
from pathlib import Path

import pyarrow.parquet

import antires_rs as ar
from antires_rs.watch import sources as one_test
from antires_rs.watch.store import Store
from reference.small_records import OPTIONS, record
from tests.support.kill_points import die_before

with contextlib.suppress(ImportError):
    import pandas  # noqa: F401 (pyarrow loads it where it is there)
    import pyarrow.pandas_compat  # noqa: F401
#: Loads what a series needs, once for all that are forked.
IDENTIFY_SERIES = ar.identify_series

#: Tests at first, and with those that have come since: what was there before is taken in.
COUNTS = {"new": 3, "more": 4}


def identified(folder: Path, count: int) -> None:
    sources = [folder.parent / f"test_{i}.npz" for i in range(count)]
    conditions = {"temperature_c": [20.0 + i for i in range(count)]}
    IDENTIFY_SERIES(sources, **OPTIONS, store=folder / "year.parquet", conditions=conditions)


def counted_commits(folder: Path) -> None:
    """Each transaction is a change on the disk too, which die_before counts like that of a file."""
    real = Store._commit

    def commit(db):
        sys.audit("os.rename", str(folder / "transaction"))
        real(db)

    Store._commit = staticmethod(commit)


def forked(folder: Path, count: int, kill_at: int | None = None) -> int:
    child = os.fork()
    if child == 0:
        code = 99
        try:
            if kill_at is not None:
                die_before(folder, kill_at)
                counted_commits(folder)
            identified(folder, count)
            code = 0
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def files_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def main(folder: Path) -> None:
    for i in range(max(COUNTS.values())):
        ar.write_npz(folder / f"test_{i}.npz", record(i))
    one_test.identify_antiresonances = lambda signal, **_: ar.AntiresonanceSet(
        0, {0: [2.0 + abs(signal.responses[0, 0])], 1: []}
    )
    points, wrong = 0, []
    for scenario, count in COUNTS.items():
        start, whole = folder / f"start_{scenario}", folder / f"whole_{scenario}"
        if scenario == "new":
            start.mkdir()
        else:
            shutil.copytree(folder / "whole_new", start)
        shutil.copytree(start, whole)
        assert forked(whole, count) == 0
        for number in range(1, 100):
            own = folder / f"{scenario}_{number}"
            shutil.copytree(start, own)
            code = forked(own, count, kill_at=number)
            if code == 0:
                break
            points += code == -signal.SIGKILL
            if forked(own, count) != 0 or files_of(own) != files_of(whole):
                wrong.append([scenario, number])
    print(json.dumps({"points": points, "wrong": wrong}))


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
