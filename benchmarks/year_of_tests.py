"""A simulated year of hourly records (reference/year_of_tests.py), identified as a series: time and memory.

Prints the time of a test, of the year at that pace, and the memory of the process along the way; and what was
found against the truth. A month by default; the records are made in the process that identifies them.

Run: ``python -m benchmarks.year_of_tests [--hours 720] [--first 0] [--step 1] [--workers N] [--store FILE]``,
or ``--small 2000`` for so many small records (reference/small_records.py), which is about memory alone.
"""

import argparse
import resource
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np

import antires_rs as ar
from reference import small_records, year_of_tests as year

#: Memory is told so often.
PARTS = 5


def rss_mb():
    """Most memory of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def watched(sources, count, told):
    """The sources, with a note of the memory along the way."""
    for i, source in enumerate(sources):
        if i and i % max(count // PARTS, 1) == 0:
            told.append((i, rss_mb()))
        yield source


def hour_of(hour):
    """The record alone, made where it is identified."""
    return year.hour_of_tests(hour)[0]


def of_year(args):
    hours = range(args.first, min(args.first + args.hours * args.step, year.HOURS), args.step)
    sources = ((f"hour {h:04d}", partial(hour_of, h), year.conditions_of(h)) for h in hours)
    return hours, sources, {"excitation": year.EXCITATION, "band_hz": year.BAND_HZ}


def of_small(count):
    sources = ((f"test {i}", partial(small_records.record, i)) for i in range(count))
    return range(count), sources, small_records.OPTIONS


def errors(series, hours):
    """Relative errors of the antiresonances of all tests, nearest to nearest, in units of 1e-4."""
    found = []
    for hour, one in zip(hours, series, strict=True):
        for dof, true in year.exact_hz(hour).items() if one is not None else ():
            if dof in one and len(one[dof]) and len(true):
                near = np.abs(one[dof][:, None] / true - 1.0).min(axis=0)
                found += near[near < 0.01].tolist()
    return 1e4 * np.array(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, default in (("hours", 720), ("first", 0), ("step", 1), ("workers", None), ("small", None)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--store", type=Path)
    args = parser.parse_args()
    hours, sources, options = of_small(args.small) if args.small else of_year(args)
    told = []
    with tempfile.TemporaryDirectory() as folder:
        store = args.store or Path(folder, "year.parquet")
        start, cpu = time.perf_counter(), time.process_time()
        series = ar.identify_series(
            watched(sources, len(hours), told), **options, store=store, workers=args.workers
        )
        seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
        print(series)
        each = seconds / len(hours)
        print(
            f"{seconds:.0f} s, {1e3 * each:.0f} ms a test ({1e3 * cpu / len(hours):.0f} ms of this process)"
        )
        if not args.small:
            print(f"the year at this pace: {each * year.HOURS / 3600:.1f} h")
        print("memory: " + ", ".join(f"{mb:.0f} MB after {i}" for i, mb in [*told, (len(hours), rss_mb())]))
        print(f"file: {store.stat().st_size / len(hours):.0f} bytes a test")
        if not args.small:
            wrong = errors(series, hours)
            sides = np.quantile(wrong, [0.5, 0.95])
            print(f"errors: median {sides[0]:.1f}e-4, 95 % below {sides[1]:.1f}e-4, of {wrong.size} values")


if __name__ == "__main__":
    main()
