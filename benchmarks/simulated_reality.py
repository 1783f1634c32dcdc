"""Values identified from records as somebody measures them (reference/measured_reality.py), and the truth.

Rules and thresholds may be set on the frame, the beam and the truss. The plate strip and the tower are kept
back: they judge, and nothing is tuned on them.

A reported value is right if a true zero of its response that no other value has lies within max(1 %, three
standard deviations) of it (``std_hz`` of the truth: Cramer-Rao and what moves within the record); "strict" is
1 %. Wanted are zeros damped less than 4 % whose standard deviation is below 1 %; "shared" are those of them
that at least half of the channels have within 0.5 %: zeros beside a mode that the force hardly excites.
"Stated false" is the mean of ``expected_false`` of the sets that have one, "held" those of them that have no
more false values. "Again" is the share of the values of one record that another record of the structure has
within 1 %; "could" is the same of the wanted zeros themselves, which hits in different places move. For
pooled hits a record is a list.

    python -m benchmarks.simulated_reality --structures frame --kind hit --records 10
    python -m benchmarks.simulated_reality --structures frame --kind hit --records 10 --each
    python -m benchmarks.simulated_reality --league          # consistency, as of measured records
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import time
import warnings
from dataclasses import dataclass, field

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import print_table
from reference.measured_reality import CLEAN, MEASURED, SWITCHES, ambient, hit, hits, only, without
from reference.modal_structures import KEPT_BACK, STRUCTURES, TUNING

TOLERANCE, DEVIATIONS, SHARED, HITS = 0.01, 3.0, 0.005, 10
KINDS = ("hit", "pooled", "ambient")


@dataclass
class Tally:
    """Counts over records of one structure."""

    reported: int = 0
    right: int = 0
    strict: int = 0
    wanted: int = 0
    found: int = 0
    shared: int = 0
    found_shared: int = 0
    false: list[int] = field(default_factory=list)
    sets: list[list[np.ndarray]] = field(default_factory=list)
    truths: list[list[np.ndarray]] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)
    fitted: list[str] = field(default_factory=list)
    seconds: float = 0.0
    stated: list[float] = field(default_factory=list)

    def add(self, values, truth):
        """One set: values by channel."""
        wrong = 0
        wanted = truth.wanted()
        for row, own in enumerate(values):
            zeros, std = truth.zeros_hz[row], np.minimum(truth.std_hz[row], 1e3)
            pairs = paired(own, zeros, np.maximum(TOLERANCE * zeros, DEVIATIONS * std))
            self.right += len(pairs)
            wrong += own.size - len(pairs)
            self.strict += len(paired(own, zeros, TOLERANCE * zeros))
            seen = {float(zeros[k]) for _, k in pairs}
            for value in wanted[row]:
                others = [np.abs(z / value - 1).min(initial=1.0) < SHARED for z in truth.zeros_hz]
                both = sum(others) >= 0.5 * len(others)
                self.wanted, self.found = self.wanted + 1, self.found + (float(value) in seen)
                self.shared, self.found_shared = (
                    self.shared + both,
                    self.found_shared + (both and float(value) in seen),
                )
            self.reported += own.size
        self.false.append(wrong)
        self.sets.append(values)
        self.truths.append(wanted)

    def row(self):
        """Cells of the table."""
        plain, plain_found = self.wanted - self.shared, self.found - self.found_shared
        return [
            f"{self.reported / max(len(self.sets), 1):.1f}",
            percent(self.right, self.reported),
            percent(self.strict, self.reported),
            f"{np.mean(self.false):.1f}",
            f"{self.wanted / max(len(self.sets), 1):.1f}",
            percent(self.found, self.wanted),
            percent(plain_found, plain),
            percent(*again(self.sets)),
            percent(*again(self.truths)),
            self.held(),
            f"{self.seconds / max(len(self.sets), 1):.2f}",
            " ".join(f"{self.fitted.count(one)} {one}" for one in sorted(set(self.fitted))),
        ]

    def held(self):
        """Mean bound on false values where one is stated, and the sets whose false values it holds."""
        known = [
            (bound, seen) for bound, seen in zip(self.stated, self.false, strict=True) if np.isfinite(bound)
        ]
        if not known:
            return "-"
        return f"{np.mean([bound for bound, _ in known]):.1f}; {sum(n <= b for b, n in known)}/{len(known)}"


HEADER = [
    "structure, records",
    "values",
    "right",
    "strict",
    "false",
    "wanted",
    "recall",
    "not shared",
    "again",
    "could",
    "stated false; held",
    "CPU s",
    "fitted",
]


def percent(part, whole):
    return f"{part / whole:.0%}" if whole else "-"


def paired(values, zeros, within):
    """Pairs (i, k) of values and true zeros, the closest first by the tolerance of each zero."""
    if not values.size or not zeros.size:
        return []
    off = np.abs(values[:, None] - zeros[None, :]) / within
    pairs, left, right = [], set(), set()
    for flat in np.argsort(off, axis=None, kind="stable"):
        i, k = divmod(int(flat), zeros.size)
        if off[i, k] > 1.0:
            break
        if i not in left and k not in right:
            pairs.append((i, k))
            left.add(i)
            right.add(k)
    return pairs


def again(sets):
    """(found again, could be) of values by channel over ordered pairs of sets."""
    found = could = 0
    for i, one in enumerate(sets):
        for j, other in enumerate(sets):
            if i != j:
                for own, others in zip(one, other, strict=True):
                    could += own.size
                    found += sum(np.abs(others / v - 1.0).min(initial=1.0) < TOLERANCE for v in own)
    return found, could


def made(structure, level, kind, seed):
    """(source, truth) of one record or list."""
    if kind == "pooled":
        records, truth = hits(structure, level, seed, HITS)
        return [ar.Recording(r.samples, r.fs_hz) for r in records], truth
    record = hit(structure, level, seed) if kind == "hit" else ambient(structure, level, seed)
    return ar.Recording(record.samples, record.fs_hz), record.truth


def identified(source, structure, band_hz=None, **options):
    """(values by channel, what fitted or the error, CPU s, bound on false values)."""
    start = time.process_time()
    count = len(structure.sensors)
    try:
        found = ar.identify_antiresonances(
            source, excitation=structure.driven, band_hz=band_hz or structure.band_hz, **options
        )
    except ar.exceptions.AntiresError as error:
        return [np.zeros(0)] * count, f"{type(error).__name__}", time.process_time() - start, np.nan
    stated = np.nan if found.expected_false is None else found.expected_false
    values = [np.asarray(found[dof]) if dof in found else np.zeros(0) for dof in range(count)]
    return values, found.options.get("fitted", "?"), time.process_time() - start, stated


def study(structure, level, kind, records, seed, **options):
    tally = Tally()
    for k in range(seed, seed + records):
        source, truth = made(structure, level, kind, k)
        values, fitted, seconds, stated = identified(source, structure, **options)
        tally.add(values, truth)
        tally.fitted.append(fitted)
        tally.seconds += seconds
        tally.stated.append(stated)
    return tally


def league(structure, level, kind, records, seed):
    """Consistency of the same measurement as it varies: another band, half, one channel less, another hit."""
    (low, high), count = structure.band_hz, len(structure.sensors)
    bands = [(low, high), (1.3 * low, 0.8 * high)]
    sources = [made(structure, level, kind, k)[0] for k in range(seed, seed + records)]
    if kind == "ambient":
        half = sources[0].n_samples // 2
        x, fs = sources[0].responses, sources[0].fs_hz
        sources = [ar.Recording(part, fs) for part in (x, x[:, :half], x[:, half:], x[:-1])]
    variants = [(source, band) for source in sources for band in bands]
    sets = []
    for source, band in variants:
        have = source[0].n_channels if isinstance(source, list) else source.n_channels
        values, said, *_ = identified(source, structure, band)
        sets.append((values, said, band, have))
    found = could = 0
    for i, (one, _, a, _) in enumerate(sets):
        for j, (other, _, b, have) in enumerate(sets):
            if i == j:
                continue
            inside = 1.02 * max(a[0], b[0]), 0.98 * min(a[1], b[1])
            for row in range(min(count, have)):
                own = one[row][(one[row] > inside[0]) & (one[row] < inside[1])]
                could += own.size
                found += sum(np.abs(other[row] / v - 1.0).min(initial=1.0) < TOLERANCE for v in own)
    sizes = [sum(v.size for v in values) for values, *_ in sets]
    said = sorted({said for _, said, *_ in sets})
    return [percent(found, could), str(could), " ".join(map(str, sizes)), ", ".join(said)]


def levels(args):
    """(name, imperfections) of the rows."""
    if args.each:
        yield "nothing wrong", CLEAN
        yield from ((f"only {name}", only(name)) for name in SWITCHES)
        yield from ((f"all but {name}", without(name)) for name in SWITCHES if name != "dead")
        yield "all", MEASURED
    elif args.only:
        yield from ((f"only {name}", only(name)) for name in args.only)
    elif args.without:
        yield from ((f"all but {name}", without(name)) for name in args.without)
    else:
        yield ("nothing wrong", CLEAN) if args.clean else ("as measured", MEASURED)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--structures", nargs="+", choices=STRUCTURES, default=list(STRUCTURES))
    parser.add_argument("--kind", nargs="+", choices=KINDS, default=["hit", "pooled"])
    parser.add_argument("--records", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--clean", action="store_true", help="nothing wrong but little noise")
    parser.add_argument("--only", nargs="+", choices=SWITCHES, help="clean but for one imperfection")
    parser.add_argument("--without", nargs="+", choices=SWITCHES, help="all but one imperfection")
    parser.add_argument("--each", action="store_true", help="each imperfection alone, and all but each")
    parser.add_argument("--league", action="store_true", help="consistency instead of truth")
    parser.add_argument("--formulation", help="of the fit; by default as the library chooses")
    args = parser.parse_args()
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    options = {"fit": ar.FitOptions(formulation=args.formulation)} if args.formulation else {}
    rows, header = [], HEADER
    for name in args.structures:
        structure = STRUCTURES[name]()
        role = "tuning" if name in TUNING else "kept back" if name in KEPT_BACK else ""
        for kind in args.kind:
            for label, level in levels(args):
                title = f"{name} ({role}), {kind}, {label}"
                if args.league:
                    header = ["structure, records", "again", "of", "values", "fitted"]
                    rows.append([title, *league(structure, level, kind, args.records, args.seed)])
                else:
                    tally = study(structure, level, kind, args.records, args.seed, **options)
                    rows.append([title, *tally.row()])
                print(" | ".join(rows[-1]), flush=True)
    print()
    print_table(header, rows, markdown=True)


if __name__ == "__main__":
    main()
