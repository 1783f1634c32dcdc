"""Single impacts on a plane frame, watched: false alarms, and what is detected at a90 and at twice that.

The portal frame of reference/structures.py under one hammer blow a record (4 s at 512 Hz, 1 % damping, 1 %
noise of each channel's rms), eight of its sensors: 100 intact records as the baseline, 100 more, 100 with one
element at 1 x and 100 at 2 x its a90. That is what ``ar.detectability`` says of a single test against a
single one whose values scatter as those of the baseline do from record to record.

    python -m benchmarks.monitor_impacts                        # some twenty minutes
    python -m benchmarks.monitor_impacts --records 30 --seed 22
    python -m benchmarks.monitor_impacts --sensors 16           # all of them, an hour
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import warnings
from pathlib import Path

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import MOST_JOBS, each
from reference.structures import DAMPING_RATIO, FS_HZ, portal_elements, portal_frame
from reference.virtual_records import accelerance

NOISE, DURATION_S, PULSE_S, HIT_S = 0.01, 4.0, 2e-3, 0.2
#: The blow is synthesised over so many records, so that the slowest mode has died before it wraps around.
PERIODS = 32


def impact(frame, stiffness, dofs, seed):
    """Responses (n_dofs, n) to a half-sine blow at any instant between two samples, with noise."""
    rng = np.random.default_rng(seed)
    n = round(DURATION_S * FS_HZ)
    freq = np.fft.rfftfreq(PERIODS * n, 1 / FS_HZ)
    w, corner = 2 * np.pi * freq, np.pi / PULSE_S
    # The transform of a half-sine; its limit at the corner is not met on these lines.
    shape = corner * (1 + np.exp(-1j * w * PULSE_S)) / (corner**2 - w**2 + 1e-6)
    force = (0.8 + 0.4 * rng.random()) * shape * np.exp(-1j * w * (HIT_S + rng.random() / FS_HZ))
    force[freq > 0.45 * FS_HZ] = 0.0
    curves = accelerance(stiffness, frame.mass, frame.excitation, freq, DAMPING_RATIO)[list(dofs)]
    x = np.fft.irfft(FS_HZ * curves * force)[:, :n]
    return x + NOISE * x.std(axis=1, keepdims=True) * rng.standard_normal(x.shape)


def identified(task):
    """The set of one record, as text; of a file where it is kept there."""
    structure, element, loss, seed, sensors, keep = task
    file = None if keep is None else Path(keep) / f"{structure}_{sensors}_{element}_{loss:.5f}_{seed}.json"
    if file is not None and file.is_file():
        return file.read_text()
    frame = portal_frame(structure)
    stiffness = frame.stiffness
    if loss:
        stiffness = stiffness - loss * portal_elements(structure)[element]
    dofs = frame.responses[:: 16 // sensors]
    record = ar.Recording(impact(frame, stiffness, dofs, seed), FS_HZ, dofs=list(dofs))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.AntiresWarning)
        found = ar.identify_antiresonances(record, excitation=frame.excitation, band_hz=frame.band_hz)
    if file is not None:
        file.write_text(found.to_json())
    return found.to_json()


def sets_of(options, loss, first, count):
    """Sets of so many records."""
    tasks = [
        (options.seed, options.element if loss else 0, loss, first + i, options.sensors, options.keep)
        for i in range(count)
    ]
    return [ar.AntiresonanceSet.from_json(text) for text in each(identified, tasks, options.jobs)]


def smallest(options, baseline):
    """a90 of the element, for values as they scatter in the baseline."""
    frame = portal_frame(options.seed)
    model = ar.MatrixModel(frame.stiffness, frame.mass, stiffness_terms=portal_elements(options.seed))
    followed = ar.track(baseline)
    known = np.sum(~np.isnan(followed.freq_hz), axis=0) >= len(baseline) / 2
    spread = np.nanstd(np.log(followed.freq_hz[:, known]), axis=0, ddof=1)
    std = float(np.median(spread))
    curves = ar.detectability(
        model,
        [options.element],
        excitation=frame.excitation,
        sensors=list(frame.responses[:: 16 // options.sensors]),
        band_hz=frame.band_hz,
        std=std,
        n_tests=6,
        rng=0,
    )
    return curves.a90[options.element], std


def parser():
    """The options."""
    made = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    made.add_argument("--records", type=int, default=100, help="of each of the four parts")
    made.add_argument("--seed", type=int, default=21, help="of the structure")
    made.add_argument("--element", type=int, default=4)
    made.add_argument("--sensors", type=int, default=8, choices=(4, 8, 16))
    made.add_argument("--rate", type=float, default=0.02)
    made.add_argument("--jobs", type=int, default=1, help=f"processes, at most {MOST_JOBS}")
    made.add_argument("--keep", help="folder in which the identified sets stay")
    return made


def main():
    options = parser().parse_args()
    n = options.records
    intact = sets_of(options, 0.0, 0, 2 * n)
    a90, std = smallest(options, intact[:n])
    print(
        f"values scatter by {100 * std:.3f} % from record to record; a90 of element {options.element}: "
        f"{100 * a90:.2f} %"
    )
    damaged = [sets_of(options, times * a90, 10_000 * times, n) for times in (1, 2)]
    watched = ar.monitor(
        intact + damaged[0] + damaged[1], baseline=slice(0, n), false_alarm_rate=options.rate
    )
    print(watched)
    for i, name in enumerate(("baseline", "intact", "1 x a90", "2 x a90")):
        part = watched.alarm[i * n : (i + 1) * n]
        print(f"{name:>10}: {int(part.sum())} of {n} tests alarm")


if __name__ == "__main__":
    main()
