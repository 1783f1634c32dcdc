"""Consistency of values from measured time records: the share that is found again when nothing has changed.

No truth is needed. Each record is identified with the defaults in two bands, from its first half, with one
channel less; or from 30 s, 60 s and all that follows a hit. A value counts where another variant could see
it, and is found again within 1 %. The table says how many values a variant has: none is consistent, too.

Which halves and what noise perturb the fits is drawn once, the same for every call of the library; other
draws move a share by some 6 points, so the table is their mean, with the least and the largest.

    python -m benchmarks.measured_records --draws 3    # needs data, see reference/measured.py
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import time
import warnings

import numpy as np

import antires_rs as ar
from antires_rs.identification import stability
from reference.measured import DATA

TOLERANCE = 0.01
FLOORS = ["ground", "floor 1", "floor 2", "floor 3"]


def shaken():
    """(name, excitation, variants) of the frames on a shaker table; a variant is (record, band)."""
    kept = np.load(DATA / "shake_table" / "records.npz")
    fs_hz = float(kept["fs_hz"])
    for name in sorted(set(kept) - {"fs_hz"}):
        x, high = kept[name], 18.0 if name.startswith("flexible") else 30.0
        wide, narrow = (1.0, high), (1.5, 0.8 * high)
        half, whole = (
            ar.Recording(x[:, : x.shape[1] // 2], fs_hz, dofs=FLOORS),
            ar.Recording(x, fs_hz, dofs=FLOORS),
        )
        three = ar.Recording(x[:3], fs_hz, dofs=FLOORS[:3])
        yield name, "ground", [(whole, wide), (whole, narrow), (half, wide), (three, wide)]


def hit():
    """The same of one hammer hit a record."""
    for number, file in enumerate(sorted((DATA / "frame3_hits").glob("*.CSV")), start=1):
        rows = file.read_text(encoding="latin-1").splitlines()
        table = np.array([row.split(",") for row in rows if row[:1].isdigit()], dtype=float).T
        fs_hz, x = 50.0, 0.01 * table[1:4]
        variants = [
            (ar.Recording(x[:, : int(seconds * fs_hz)], fs_hz, dofs=FLOORS[1:]), band)
            for seconds in (30, 60, x.shape[1] / fs_hz)
            for band in ((1.5, 20.0), (1.0, 23.0), (2.0, 15.0))
        ]
        yield f"hit on floor {number}", f"floor {number}", variants


def again(one, other, band_hz):
    """(found again, could be found again) of the values of one set inside the band."""
    found = could = 0
    for dof in one:
        if dof not in other.channels:
            continue
        values = one[dof][(one[dof] > 1.02 * band_hz[0]) & (one[dof] < 0.98 * band_hz[1])]
        could += values.size
        found += sum(np.abs(other[dof] / v - 1.0).min(initial=np.inf) < TOLERANCE for v in values)
    return found, could


def drawn(variants, excitation, seed):
    """(values found again, that could be) of all pairs of variants, values a variant, and what was fitted."""
    stability.SEED = seed
    sets = [ar.identify_antiresonances(r, excitation=excitation, band_hz=b) for r, b in variants]
    counts = np.zeros(2, dtype=int)
    for i, (_, a) in enumerate(variants):
        for j, (_, b) in enumerate(variants):
            if i != j:
                counts += again(sets[i], sets[j], (max(a[0], b[0]), min(a[1], b[1])))
    return counts, [sum(map(len, s.values())) for s in sets], {s.options["fitted"] for s in sets}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=3)
    args = parser.parse_args()
    first = stability.SEED
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    print("| record | found again | of | values a variant | fitted | CPU s |\n|---|---|---|---|---|---|")
    for name, excitation, variants in (*shaken(), *hit()):
        start = time.process_time()
        each = [drawn(variants, excitation, first + k) for k in range(args.draws)]
        seconds = (time.process_time() - start) / len(variants) / args.draws
        counts = np.array([one for one, _, _ in each])
        shares = counts[:, 0] / np.maximum(counts[:, 1], 1)
        of = int(counts[:, 1].mean())
        found = f"{shares.mean():.0%} ({shares.min():.0%} to {shares.max():.0%})" if of else "none"
        sizes = " ".join(f"{np.mean(own):.2g}" for own in zip(*(one for _, one, _ in each), strict=True))
        fitted = ", ".join(sorted(set().union(*(one for _, _, one in each))))
        print(f"| {name} | {found} | {of} | {sizes} | {fitted} | {seconds:.2f} |", flush=True)


if __name__ == "__main__":
    main()
