"""How many of chain8's 28 antiresonances identification finds, how many false, how far off, and how fast.

Records are simulated by the tests' own helper, independent of the package's models.

Run: ``OPENBLAS_NUM_THREADS=1 python benchmarks/identify_chain8.py [--seeds 5] [--noise 0 0.01 0.02]``
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

from antires_rs.identification import identify_antiresonances
from antires_rs.signals import Recording

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from virtual_records import (
    CHAIN8_MASSES,
    CHAIN8_SPRINGS,
    chain_matrices,
    random_record,
    true_antiresonances,
)

FS_HZ = 512.0
BAND_HZ = (3.0, 130.0)
HIT = 0.01


def score(found, truth):
    """(found, false, errors): each true value may be hit once, within 1 %."""
    errors, used = [], set()
    for dof, values in enumerate(truth):
        for value in values:
            off = np.abs(found[dof] / value - 1.0)
            if off.size and off.min() < HIT and (dof, int(off.argmin())) not in used:
                used.add((dof, int(off.argmin())))
                errors.append(float(off.min()))
    return len(errors), sum(found[dof].size for dof in found) - len(errors), errors


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first-seed", type=int, default=13)
    parser.add_argument("--noise", type=float, nargs="+", default=[0.0, 0.01, 0.02])
    parser.add_argument("--damping", type=float, default=0.01)
    parser.add_argument("--duration", type=float, default=256.0)
    options = parser.parse_args()
    stiffness, mass = chain_matrices(CHAIN8_MASSES, CHAIN8_SPRINGS)
    truth = [true_antiresonances(stiffness, mass, dof, 0) for dof in range(8)]
    identify_antiresonances(  # imports and first calls are not timed
        Recording(random_record(stiffness, mass, duration_s=64.0)[0], FS_HZ), excitation=0, band_hz=BAND_HZ)
    print("noise  route            found (of 28)          false  largest error  seconds  routes apart")
    for noise in options.noise:
        rows = {"transmissibility": [], "frf": []}
        apart = 0.0
        for seed in range(options.first_seed, options.first_seed + options.seeds):
            responses, force = random_record(stiffness, mass, noise=noise, seed=seed,
                                             damping_ratio=options.damping, duration_s=options.duration)
            rec = Recording(responses, FS_HZ, force=force)
            both = {}
            for route, row in rows.items():
                start = time.process_time()
                both[route] = identify_antiresonances(rec, excitation=0, band_hz=BAND_HZ, route=route)
                row.append((*score(both[route], truth), time.process_time() - start))
            a, b = both.values()
            apart = max([apart] + [float(np.abs(a[d] / f - 1).min()) for d in b for f in b[d] if a[d].size])
        for route, row in rows.items():
            counts = " ".join(str(r[0]) for r in row)
            false, worst = sum(r[1] for r in row), max(e for r in row for e in r[2])
            seconds = np.mean([r[3] for r in row])
            print(f"{noise:5.2f}  {route:16s} {counts:22s} {false:5d}  {worst:13.1e}  {seconds:7.2f}  "
                  f"{apart:.1e}")


if __name__ == "__main__":
    main()
