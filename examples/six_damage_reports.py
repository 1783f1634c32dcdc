"""Six virtual tests against a baseline, each with its report: what a reader should find on the first screen.

    python examples/six_damage_reports.py [FOLDER]

The structure is a chain of seven masses whose masses and springs are up to 3 % off the model, which is never
updated. It is recorded intact, something happens, and it is recorded again. In the last two cases no honest
report can say where, or whether, there is damage.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

import antires_rs as ar

MASSES = np.full(7, 0.45)
SPRINGS = np.full(6, 56.7e3)
OFF = 0.03


class Case(NamedTuple):
    """What happens, which springs are candidates, and whether each stands for two in parallel."""

    name: str
    happened: str
    losses: dict[int, float]
    elements: tuple[int, ...] = tuple(range(6))
    in_pairs: bool = False


CASES = (
    Case("clear", "spring 4 has lost 40 %", {4: 0.40}),
    Case("none", "nothing", {}),
    Case("two", "springs 1 and 4 have lost 30 and 20 %", {1: 0.30, 4: 0.20}),
    Case("elsewhere", "spring 4 has lost 40 %, and is no candidate", {4: 0.40}, (0, 1, 2, 3, 5)),
    Case("alike", "one of two parallel springs has lost 40 %", {1: 0.20}, tuple(range(12)), in_pairs=True),
    Case("small", "spring 0 has lost 0.7 %, too little to tell", {0: 0.007}),
)


def nominal(in_pairs: bool) -> ar.MassSpringChain | ar.MatrixModel:
    """The model: one spring between two masses, or two in parallel, each half as stiff."""
    chain = ar.MassSpringChain(MASSES, SPRINGS)
    if not in_pairs:
        return chain
    halves = []
    for n, stiffness in enumerate(SPRINGS):
        half = np.zeros((MASSES.size, MASSES.size))
        half[n : n + 2, n : n + 2] = 0.5 * stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
        halves += [half, half]
    return ar.MatrixModel(chain.stiffness(), chain.mass(), stiffness_terms=halves)


def assessed(case: Case, seed: int = 0) -> ar.DamageResult:
    """Both tests of a case, and what they come to."""
    rng = np.random.default_rng(seed)
    masses = MASSES * rng.uniform(1.0 - OFF, 1.0 + OFF, MASSES.size)
    springs = SPRINGS * rng.uniform(1.0 - OFF, 1.0 + OFF, SPRINGS.size)
    hurt = springs * (1.0 - np.array([case.losses.get(e, 0.0) for e in range(SPRINGS.size)]))

    def tested(stiffness: np.ndarray) -> ar.AntiresonanceSet:
        record = ar.MassSpringChain(masses, stiffness).simulate(
            excitation=0, fs_hz=512.0, duration_s=60.0, damping_ratio=0.01, noise=0.05, rng=rng
        )
        return ar.identify_antiresonances(record, excitation=0, band_hz=(3.0, 130.0))

    before, now = tested(springs), tested(hurt)
    return ar.assess_damage(nominal(case.in_pairs), now, baseline=before, elements=case.elements)


def main(folder: Path) -> None:
    """Write the six reports."""
    folder.mkdir(parents=True, exist_ok=True)
    for case in CASES:
        result = assessed(case)
        result.report(folder / f"{case.name}.html")
        print(f"{case.name}; what happened: {case.happened}\n   {result.headline}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "six_damage_reports"))
