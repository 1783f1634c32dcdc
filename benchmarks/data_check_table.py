"""What the data check finds: no fault where there is none, and faults that were put in.

Published measurements (ANTIRES_DATA), as FRFs and as transmissibilities, and simulated records of
reference/structures.py. Each source is checked as it is: every warning is a false alarm. Then one channel,
drawn at random, is made dead, late by a part of a period at the highest line, a velocity among accelerations;
in records it is clipped, and a second force of 0.3 acts elsewhere; where the force is known, the driving
point is exchanged with another channel. Found means: the finding of that name, with that channel.

The limits of the phase were set on the plates and the two three-storey frames, on other random choices of
channels and bands; the impact and the simulated structures had no part in them.

    python -m benchmarks.data_check_table              # about two minutes
    python -m benchmarks.data_check_table --seeds 5 --markdown
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import print_table
from reference import faults
from reference.structures import STRUCTURES

DATA = Path(os.environ.get("ANTIRES_DATA", Path(__file__).parents[2] / "shared" / "data"))
PLATES, COLUMNS = (100.0, 480.0), [9 * row + column for row in (0, 2, 4, 6) for column in (0, 2, 4, 6, 8)]
#: Columns of the plates from here on are beside the clamp and hold noise: no fault is put into them.
CLAMPED = 63
#: Delays, of a period at the highest line.
LATE = (0.25, 0.5, 1.0)
FAULTS = ("dead", *(f"late {part:g}" for part in LATE), "velocity", "clipped", "second force", "exchanged")
NAMES = {
    "dead": "dead_channel",
    "velocity": "quadrature",
    "clipped": "clipped_channel",
    "second force": "one_force",
    "exchanged": "force_location",
}
SECOND = 0.3


def measured():
    """Name, source, band and excitation of every measurement."""
    for file in sorted((DATA / "iqs_plates").glob("*.MAT")):
        plate = ar.read_mat(file, df_hz=0.5, dofs=range(81))
        for name, rows in (("plates, 20 columns", COLUMNS), ("plates, 81 columns", list(range(81)))):
            yield name, some_rows(plate, rows), PLATES, None
    file = DATA / "iqs_3storey" / "frf.npz"
    if file.is_file():
        frame = ar.read_npz(file, df_hz=0.0625, dofs=range(9))
        yield "three-storey frame, 9 points", some_rows(frame, list(range(9))), (10.0, 95.0), None
    for floor, name in enumerate(("Experimental.csv", "test_2.csv", "test_3.csv")):
        file = DATA / "southampton_3storey" / name
        if file.is_file():
            yield "Southampton, 3 forces", ar.read_csv(file), (5.0, 32.0), floor
    file = DATA / "brake_reuss_beam" / "HammerImpact.mat"
    if file.is_file():
        yield "Brake-Reuss, one impact", ar.read_mat(file), (50.0, 1200.0), None


def some_rows(response, rows):
    """Some outputs, without 0 Hz."""
    return ar.FrequencyResponse(
        response.freq_hz[1:], response.values[rows, 1:], [response.dofs[i] for i in rows]
    )


def over(response, reference):
    """The same as transmissibilities."""
    values = response.values / response.values[reference]
    return ar.FrequencyResponse(
        response.freq_hz, values, response.dofs, "transmissibility", response.dofs[reference]
    )


def simulated(seed):
    """The same for records, with the structure of each."""
    for name, (maker, sensors) in STRUCTURES.items():
        structure = maker(seed)
        record = structure.record(noise=0.01, seed=seed, sensors=sensors)
        yield name, record, structure.band_hz, structure.excitation, structure


def with_fault(source, fault, p, band, rng, structure=None):
    """The source with a fault in channel p; None where it cannot have it."""
    is_record = isinstance(source, ar.Recording)
    values = (source.responses if is_record else source.values).copy()

    def spectral(change):
        if is_record:
            return faults.filtered(values[p], source.fs_hz, change)
        return change(values[p], source.freq_hz)

    if fault == "dead":
        values[p] = faults.noise_only(values[p], rng)
    elif fault.startswith("late"):
        values[p] = spectral(lambda x, f: faults.late(x, f, float(fault[5:]) / band[1]))
    elif fault == "velocity":
        values[p] = spectral(faults.integrated)
    elif fault == "exchanged":
        q = int(rng.choice([q for q in range(len(values)) if q != p]))
        values[[p, q]] = values[[q, p]]
    elif not is_record or (fault == "second force" and structure is None):
        return None
    elif fault == "clipped":
        values[p] = faults.clipped(values[p])
    else:
        others = [dof for dof in structure.responses if dof != structure.excitation]
        second = replace(structure, excitation=int(rng.choice(others)))
        values = values + SECOND * second.record(seed=int(rng.integers(1 << 30))).responses
    if is_record:
        return ar.Recording(values, source.fs_hz, source.dofs)
    return ar.FrequencyResponse(source.freq_hz, values, source.dofs)


def seen(source, excitation, band):
    """Findings beyond notes, by name."""
    found = ar.check_data(source, excitation=excitation, band_hz=band).findings
    return {f.name: f.where for f in found if f.severity != "note"}


def run(seeds):
    """Found and tried, by structure and fault; false alarms under ''."""
    table = {}

    def count(name, fault, hit):
        found, tried = table.setdefault(name, {}).get(fault, (0, 0))
        table[name][fault] = (found + hit, tried + 1)

    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        cases = [(*case, None) for case in measured()] + list(simulated(seed))
        for name, source, band, excitation, structure in cases:
            channels = [p for p, dof in enumerate(source.dofs) if "plates" not in name or dof < CLAMPED]
            kinds = ["", " as T"] if isinstance(source, ar.FrequencyResponse) else [""]
            for kind in kinds:
                reference = int(rng.choice(channels))
                shown = over(source, reference) if kind else source
                count(name + kind, "", bool(seen(shown, excitation, band)))
                for fault in FAULTS:
                    known = excitation in source.dofs
                    if fault == "exchanged" and (kind or not known):
                        continue
                    p = int(rng.choice([c for c in channels if not kind or c != reference]))
                    p = source.dofs.index(excitation) if fault == "exchanged" else p
                    bad = with_fault(source, fault, p, band, rng, structure)
                    if bad is None:
                        continue
                    found = seen(over(bad, reference) if kind else bad, excitation, band)
                    test = NAMES.get(fault, "time_shift")
                    where = found.get(test)
                    count(name + kind, fault, where is not None and (not where or source.dofs[p] in where))
    return table


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--markdown", action="store_true")
    args = parser.parse_args()
    warnings.simplefilter("ignore", ar.AntiresWarning)
    table = run(args.seeds)
    header = ["structure", "false alarms", *FAULTS]
    rows = [
        [name, *("-" if cell is None else f"{cell[0]}/{cell[1]}" for cell in map(cells.get, ["", *FAULTS]))]
        for name, cells in table.items()
    ]
    print_table(header, rows, args.markdown)


if __name__ == "__main__":
    main()
