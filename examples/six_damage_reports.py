"""Six virtual tests against a baseline, each with its report: what a reader should find on the first screen.

    python examples/six_damage_reports.py [FOLDER]

The structure is a chain of seven masses whose masses and springs are up to 3 % off the model, which is never
updated. It is recorded intact, something happens, and it is recorded again. In the last two cases no honest
report can say where, or whether, there is damage.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import antires_rs as ar

MASSES = np.full(7, 0.45)
SPRINGS = np.full(6, 56.7e3)
OFF = 0.03


@dataclass(frozen=True)
class Case:
    """What happens, which springs are candidates, and what is measured; all count from 0."""

    name: str
    asked: str
    losses: dict[int, float]
    elements: tuple[int, ...] = tuple(range(6))
    dofs: tuple[int, ...] = tuple(range(7))
    force: int = 0
    seed: int = 0


CASES = (
    Case("clear", "spring 5 has lost 40 %", {4: 0.40}),
    Case("none", "nothing has happened", {}),
    Case("two", "springs 2 and 5 have lost 30 and 20 %", {1: 0.30, 4: 0.20}),
    Case("elsewhere", "spring 5 has lost 40 %, and is no candidate", {4: 0.40}, (0, 1, 2, 3, 5)),
    Case(
        "alike",
        "spring 2 or its mirror image, spring 5, has lost 20 %",
        {1: 0.20},
        dofs=(3,),
        force=3,
        seed=1,
    ),
    Case("small", "spring 1 has lost 0.5 %, too little to tell", {0: 0.005}),
)


def assessed(case: Case) -> ar.DamageResult:
    """Both tests of a case, and what they come to.

    Parameters
    ----------
    case : Case

    Returns
    -------
    antires_rs.DamageResult
    """
    rng = np.random.default_rng(case.seed)
    masses = MASSES * rng.uniform(1.0 - OFF, 1.0 + OFF, MASSES.size)
    springs = SPRINGS * rng.uniform(1.0 - OFF, 1.0 + OFF, SPRINGS.size)
    hurt = springs * (1.0 - np.array([case.losses.get(e, 0.0) for e in range(SPRINGS.size)]))
    before, now = (
        ar.identify_antiresonances(
            ar.MassSpringChain(masses, k).simulate(
                excitation=case.force, fs_hz=512.0, duration_s=60.0, damping_ratio=0.01, noise=0.05, rng=rng
            ),
            excitation=case.force,
            band_hz=(3.0, 130.0),
            dofs=case.dofs,
        )
        for k in (springs, hurt)
    )
    return ar.assess_damage(ar.MassSpringChain(MASSES, SPRINGS), now, baseline=before, elements=case.elements)


def main(folder: Path) -> None:
    """Write the six reports."""
    folder.mkdir(parents=True, exist_ok=True)
    for case in CASES:
        result = assessed(case)
        result.report(folder / f"{case.name}.html")
        print(f"{case.name}: {case.asked}\n   {result.headline}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "six_damage_reports"))
