"""SIGKILL at random times during a series, until it is through; then another, until there were so many kills.

Each file must be that of a series that nobody stopped, byte for byte, and nothing else may be left.

Run: ``python -m benchmarks.series_kills [KILLS] [SEED]``, 20 and 0 by default; a minute or two.
"""

import json
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import antires_rs as ar
from antires_rs.watch.store import part_path
from reference.small_records import OPTIONS, dead, record

#: Tests of the series; a process lives for so long, in s, from its first result on.
TESTS, LIFE_S = 250, (0.0, 1.2)
#: Every tenth lacks a sensor, every twenty-fifth all.
CHILD = "from benchmarks.series_kills import identified; import sys; identified(sys.argv[1])"


def identified(folder):
    conditions = {"temperature_c": np.linspace(-5.0, 30.0, TESTS)}
    ar.identify_series(
        f"{folder}/records", **OPTIONS, store=f"{folder}/year.parquet", conditions=conditions, progress=False
    )


def made(folder):
    (folder / "records").mkdir(parents=True)
    for i in range(TESTS):
        dofs = (0, 1, 2) if i % 25 == 3 else (i % 3,)
        one = dead(i, dofs) if i % 10 == 3 or i % 25 == 3 else record(i)
        ar.write_npz(folder / "records" / f"test_{i}.npz", one)


def killed_at(folder, after_s):
    """Tests that are kept after a kill; None if the series was through before."""
    part = part_path(folder / "year.parquet")
    log = part.with_name(part.name + "-wal")
    size = log.stat().st_size if log.exists() else 0
    with subprocess.Popen([sys.executable, "-c", CHILD, str(folder)]) as child:
        while child.poll() is None and not (log.exists() and log.stat().st_size > size):
            time.sleep(0.005)
        time.sleep(after_s)
        if child.poll() is not None:
            return None
        child.send_signal(signal.SIGKILL)
    return len(ar.Series.load(folder / "year.parquet")) if part.exists() else 0


def killed_series(folder, whole, kills, rng):
    """Tests that were kept after each kill of a series, and whether its file is that of the other."""
    folder.mkdir()
    (folder / "records").symlink_to(whole / "records")
    kept = []
    while len(kept) < kills and (at := killed_at(folder, rng.uniform(*LIFE_S))) is not None:
        kept.append(at)
    subprocess.run([sys.executable, "-c", CHILD, str(folder)], check=True)
    same = (folder / "year.parquet").read_bytes() == (whole / "year.parquet").read_bytes()
    left = sorted(path.name for path in folder.iterdir())
    print(f"{len(kept)} kills; tests that were kept after each: {kept}")
    print(f"same file: {same}; left beside the records: {left}", flush=True)
    return len(kept), same and left == ["records", "year.parquet"]


def main(kills=20, seed=0):
    rng, total, right = np.random.default_rng(seed), 0, True
    with tempfile.TemporaryDirectory() as name:
        whole = Path(name, "whole")
        made(whole)
        identified(whole)
        failed = len(ar.Series.load(whole / "year.parquet").failed)
        print(f"series of {TESTS} tests ({failed} failed), {(whole / 'year.parquet').stat().st_size:,} bytes")
        while total < kills and right:
            count, right = killed_series(Path(name, f"killed_{total}"), whole, kills - total, rng)
            total += count
    return right


if __name__ == "__main__":
    sys.exit(not main(*map(json.loads, sys.argv[1:])))
