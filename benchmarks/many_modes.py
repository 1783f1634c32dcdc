"""Identification where the band holds many modes: random chains of 20 to 80 masses, 9 to 21 sensors.

Every seed draws masses, springs and sensors; 300 s at 512 Hz, 1 % damping, 1 % noise, force at mass 0. Found
means within 1 % of the undamped model's antiresonance, one to one. By default the orders follow the data;
beside it the same records with orders up to 60.

    python -m benchmarks.many_modes
    python -m benchmarks.many_modes --first-seed 200
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import time
import warnings

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import print_table
from reference.matching import match

#: Masses, sensors beside mass 0, and the end of the band in Hz.
CASES = (
    (20, 8, 100.0),
    (30, 10, 100.0),
    (40, 10, 100.0),
    (60, 12, 100.0),
    (80, 12, 60.0),
    (30, 20, 60.0),
    (50, 8, 80.0),
)
FIRST_HZ = 1.0


def drawn(seed: int, masses: int, sensors: int) -> tuple[ar.MassSpringChain, ar.Recording]:
    """A chain and its record."""
    rng = np.random.default_rng(seed)
    mass_kg = rng.uniform(0.3, 0.6, masses)
    chain = ar.MassSpringChain(mass_kg, rng.uniform(4e4, 7e4, masses - 1), ground_first_n_per_m=2e4)
    chosen = sorted({0, *rng.choice(masses, sensors, replace=False).tolist()})
    record = chain.simulate(
        excitation=0, fs_hz=512, duration_s=300, damping_ratio=0.01, noise=0.01, responses=chosen, rng=seed
    )
    return chain, record


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--first-seed", type=int, default=100)
    options = parser.parse_args()
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    rows = []
    for seed, (masses, sensors, last_hz) in enumerate(CASES, options.first_seed):
        chain, record = drawn(seed, masses, sensors)
        row = [f"{masses} masses, to {last_hz:g} Hz", len(record.dofs)]
        for limited in ({"max_order": 60}, {}):
            begin = time.process_time()
            zeros = ar.identify_antiresonances(
                record, excitation=0, band_hz=(FIRST_HZ, last_hz), progress=False, **limited
            )
            seconds = time.process_time() - begin
            there = found = false = 0
            for dof, values in zeros.items():
                true = np.array(chain.antiresonances(dof, 0))
                true = true[(true > FIRST_HZ) & (true < last_hz)]
                matched = match(values, true)
                there, found = there + true.size, found + len(matched.pairs)
                false += len(matched.false)
            highest = max(one.orders[-1] for one in zeros.diagrams.values())
            row += [f"{found}/{there}", false, f"{highest:.0f}", f"{seconds:.1f}"]
        rows.append(row)
    heads = ["found", "false", "orders to", "CPU s"]
    print_table(["chain", "channels", *(f"{h}, 60 orders" for h in heads), *heads], rows, markdown=False)


if __name__ == "__main__":
    main()
