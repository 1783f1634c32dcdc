"""Identify one long record: CPU seconds, and memory beside the record.

A chain of 16 masses under one random force, 1 % sensor noise, 512 Hz, all 16 responses with their standard
deviations. The first part times ``identify_antiresonances`` on 10 minutes, several times in one process
(the first call imports SciPy). The second writes a longer record to a file, reads and identifies it in a
process of its own, and compares its largest memory with what it has before, and with the record. Run
``python -m benchmarks.record_speed --minutes 10 60 255``: 255 minutes are 1 GB.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: one core is what is measured

import argparse
import multiprocessing
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

import antires_rs as ar

FS_HZ, BAND_HZ, N = 512.0, (3.0, 110.0), 16
#: Longer records are this one's minutes again and again, with other sensor noise.
PIECE_S = 600.0


def structure() -> ar.MassSpringChain:
    return ar.MassSpringChain(np.ones(N), np.linspace(9e4, 12e4, N - 1), ground_first_n_per_m=1e5)


def record(minutes: float, rng: np.random.Generator) -> ar.Recording:
    piece = structure().simulate(
        excitation=0, fs_hz=FS_HZ, duration_s=min(60.0 * minutes, PIECE_S), damping_ratio=0.01, rng=rng
    )
    x = np.tile(piece.responses, round(60.0 * minutes / piece.duration_s))
    for row in x:
        row += 0.01 * row.std() * rng.standard_normal(row.size)
    x.setflags(write=False)
    return ar.Recording(x, FS_HZ)


def peak_mb() -> float:
    """Largest resident memory of this process so far."""
    status = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) / 1024.0 for line in status if line.startswith("VmHWM"))


def alone(path: str) -> tuple[float, float, float, float, int]:
    """Memory before, record, largest (MB), CPU seconds with reading, values: in a process of its own."""
    warnings.simplefilter("ignore")
    short = structure().simulate(excitation=0, fs_hz=FS_HZ, duration_s=30.0, damping_ratio=0.01, rng=0)
    ar.identify_antiresonances(short, excitation=0, band_hz=BAND_HZ)  # imports
    before, start = peak_mb(), time.process_time()
    rec = ar.read_npz(path)
    found = ar.identify_antiresonances(rec, excitation=0, band_hz=BAND_HZ)
    seconds = time.process_time() - start
    values = sum(found[dof].size for dof in found)
    return before, rec.responses.nbytes / 2**20, peak_mb(), seconds, values


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--minutes", type=float, nargs="*", default=[10.0, 60.0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--seed", type=int, default=3)
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    rec = record(10.0, np.random.default_rng(args.seed))
    seconds = []
    for _ in range(args.repeats):
        start = time.process_time()
        ar.identify_antiresonances(rec, excitation=0, band_hz=BAND_HZ)
        seconds.append(time.process_time() - start)
    print(f"{rec}: first {seconds[0]:.2f} CPU s, then {min(seconds):.2f} to {max(seconds[1:]):.2f}")
    del rec
    print("minutes  record MB  before MB  largest MB  (largest - before) / record  CPU s  values")
    for minutes in args.minutes:
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "record.npz")
            ar.write_npz(path, record(minutes, np.random.default_rng(args.seed)))
            with multiprocessing.get_context("spawn").Pool(1) as pool:
                before, size, largest, spent, values = pool.apply(alone, (path,))
        share = (largest - before) / size
        memory = f"{size:>9.0f}  {before:>9.0f}  {largest:>10.0f}  {share:>27.2f}"
        print(f"{minutes:>7g}  {memory}  {spent:>5.1f}  {values:>6}")


if __name__ == "__main__":
    main()
