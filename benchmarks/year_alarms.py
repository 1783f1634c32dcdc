"""A year of hourly records, watched: false alarms before the damage of day 300, the delay, and the element.

The year of reference/year_of_tests.py. The baseline is the first month; by default the rest is every fourth
hour of two stretches of five days and of sixteen days about day 300. ``--every 4`` takes the whole year.

    python -m benchmarks.year_alarms                     # 340 records, some minutes of a quiet core
    python -m benchmarks.year_alarms --every 4 --store year.parquet
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import warnings
from functools import partial
from pathlib import Path

import numpy as np

import antires_rs as ar
from benchmarks.year_of_tests import hour_of
from reference import year_of_tests as year

BASELINE_H = 30 * 24
STRETCHES_DAYS = ((100, 105), (200, 205), (year.DAMAGE_DAY - 8, year.DAMAGE_DAY + 8))


def chosen_hours(every):
    """The baseline and some stretches, or all hours in steps."""
    if every:
        return list(range(0, year.HOURS, every))
    found = list(range(0, BASELINE_H, 4))
    for first, last in STRETCHES_DAYS:
        found += range(24 * first, 24 * last, 4)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--every", type=int, default=0, help="hours between records; default: some stretches")
    parser.add_argument("--rate", type=float, default=0.01)
    parser.add_argument("--store", type=Path, help="Parquet file in which the series stays")
    parser.add_argument("--workers", type=int, default=1)
    options = parser.parse_args()
    chosen = np.array(chosen_hours(options.every))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.AntiresWarning)
        series = ar.identify_series(
            ((f"hour {h:04d}", partial(hour_of, h), year.conditions_of(h)) for h in chosen.tolist()),
            excitation=year.EXCITATION,
            band_hz=year.BAND_HZ,
            store=options.store,
            workers=options.workers,
        )
    watched = ar.monitor(
        series,
        baseline=np.flatnonzero(chosen < BASELINE_H),
        false_alarm_rate=options.rate,
        model=ar.cases.chain8().model,
    )
    print(watched)
    tell(watched, chosen)


def tell(watched, chosen):
    """False alarms, delay, elements."""
    damaged = np.array([year.is_damaged(hour) for hour in chosen])
    judged = watched.outside_baseline
    false = watched.alarm[judged & ~damaged]
    hits = watched.alarm[judged & damaged]
    print(f"\nbefore day {year.DAMAGE_DAY}: {false.sum()} of {false.size} alarm ({100 * false.mean():.2f} %)")
    print(f"after it: {hits.sum()} of {hits.size} alarm")
    if hits.any():
        first = chosen[watched.alarm & damaged][0]
        print(f"first alarm {first - 24 * year.DAMAGE_DAY} hours after the damage")
    for first, last in watched.runs:
        if first in watched.assessments and year.is_damaged(chosen[last]):
            found = watched.assessments[first]
            right = list(found.damaged) == [year.DAMAGED_ELEMENT]
            print(f"run from hour {chosen[first]}: {'right' if right else 'WRONG'}, {found.headline}")


if __name__ == "__main__":
    main()
