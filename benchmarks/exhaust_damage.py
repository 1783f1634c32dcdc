"""Damage of the exhaust: three crack levels, 30 candidate elements, identified values up to 260 Hz.

Per seed: the model is first updated on the record of the undamaged structure (all 16 accelerometers); then
each level's record is identified and the losses of elements 17 to 46 are searched with the paper's penalties.
The crack lies in element 30, behind the weld near its joint with element 29. Beside the antiresonances, from
the same records, the paper's comparison: resonances and mode shapes (Eq. 18), with a baseline of its own.

    python -m benchmarks.exhaust_damage                       # seeds 20 to 24, three levels
    python -m benchmarks.exhaust_damage --seeds 100 --levels 1 3 --pictures out
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import antires_rs as ar
from benchmarks.exhaust_study import NOISE, count, identify

#: What counts as a false damage.
FALSE = 0.10
METHODS = ("antiresonances", "resonances, shapes")


@dataclass(frozen=True)
class Run:
    """One seed, level and method: how the search came out."""

    seed: int
    level: int
    method: str
    values: str
    result: ar.DamageResult
    seconds: float

    @property
    def ranked(self):
        """(element, loss) of the damaged elements, the worst first."""
        found = [(element, loss) for element, loss in self.result.severity.items() if loss > 0]
        return sorted(found, key=lambda pair: -pair[1])


def measured(case, seed, level, methods):
    """What the methods compare, from one record, and how many values that are; every record its own noise."""
    record = case.experiment(level, noise=NOISE, rng=10 * seed + level)
    found = {}
    if METHODS[0] in methods:
        zeros = identify(case, record)
        matched, true, false = count(case, zeros, level)
        found[METHODS[0]] = zeros, f"{matched}/{true} {false}"
    if METHODS[1] in methods:
        modes = ar.identify_modes(record, band_hz=case.damage_band_hz)
        found[METHODS[1]] = modes, f"{modes.freq_hz.size} modes"
    return found


def baseline(case, data, seed):
    """The model updated on what was measured of the undamaged structure, with every accelerometer."""
    if isinstance(data, ar.ModalSet):
        problem = ar.UpdatingProblem(case.model, case.updating_parameters(), data)
    else:
        problem = case.updating_problem(data, held_out=[], band_hz=case.damage_band_hz)
    return ar.update(problem, rng=seed, progress=False)


def assess(case, model, data, seed):
    """The search for damage, and its seconds."""
    start = time.perf_counter()
    values = data if isinstance(data, ar.ModalSet) else case.damage_problem(data, model=model).measured
    result = ar.assess_damage(
        model,
        values,
        elements=case.candidates,
        search=ar.SearchOptions(gamma1=0.1, gamma2=0.1),
        rng=seed,
        progress=False,
    )
    return result, time.perf_counter() - start


def verdict(case, runs):
    """Text: what the runs of one method show together."""
    cracked = case.cracked_element
    near = (cracked - 1, cracked, cracked + 1)
    first = sum(one.ranked[0][0] in near if one.ranked else 0 for one in runs)
    exact = sum(one.ranked[0][0] == cracked if one.ranked else 0 for one in runs)
    false = [sum(loss > FALSE for _, loss in one.ranked[1:]) for one in runs]
    lines = [
        f"{first} of {len(runs)} runs have the cracked element or its neighbour first, {exact} the "
        f"cracked one; further elements above {100 * FALSE:.0f} %: at most {max(false)} a run, "
        f"in all {sum(false)}"
    ]
    for seed in dict.fromkeys(one.seed for one in runs):
        losses = [one.ranked[0][1] if one.ranked else 0.0 for one in runs if one.seed == seed]
        rising = "rising" if np.all(np.diff(losses) > 0) else "NOT rising"
        lines.append(f"seed {seed}: severity {' '.join(f'{100 * v:.1f}' for v in losses)} %, {rising}")
    return "\n".join(lines)


def pictures(case, runs, folder):
    """Losses by element, and on the frame, for every level of the last seed."""
    from matplotlib.figure import Figure

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for one in (r for r in runs if r.seed == runs[-1].seed):
        figure = Figure(figsize=(11, 8), layout="constrained")
        top, bottom = figure.subplots(2)
        one.result.plot(ax=top, truth=case.truth(one.level)["severity"])
        case.model.plot(
            {e: 100 * b for e, b in one.result.severity.items()}, ax=bottom, label="Stiffness loss (%)"
        )
        figure.savefig(folder / f"exhaust_damage_{one.method.split(',')[0]}_{one.level}.png", dpi=120)
    print(f"pictures in {folder}")


def run_seed(case, seed, levels, methods):
    """All levels and methods of one seed, printed as they come."""
    sound, runs = measured(case, seed, 0, methods), []
    updated = {method: baseline(case, data, seed) for method, (data, _) in sound.items()}
    for method, result in updated.items():
        print(
            f"{seed:4d}     0 {method:<20}{sound[method][1]:>10} {result.fun:8.3f} {result.nfev:12,d} "
            f"{'':8} {result.status:<13} baseline",
            flush=True,
        )
    for level in levels:
        for method, (data, values) in measured(case, seed, level, methods).items():
            result, seconds = assess(case, updated[method].model, data, seed)
            runs.append(Run(seed, level, method, values, result, seconds))
            named = ", ".join(f"{element}: {100 * loss:.1f}" for element, loss in runs[-1].ranked) or "none"
            print(
                f"{seed:4d} {level:5d} {method:<20}{values:>10} {result.fun:8.3f} {result.nfev:12,d} "
                f"{seconds:8.1f} {result.status:<13} {named}",
                flush=True,
            )
    return runs


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(20, 25)))
    parser.add_argument("--levels", type=int, nargs="+", default=[1, 2, 3], choices=(0, 1, 2, 3))
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=METHODS)
    parser.add_argument("--pictures", metavar="FOLDER", help="draw the last seed's pictures there")
    args = parser.parse_args()
    case = ar.cases.exhaust()
    print(
        f"crack in element {case.cracked_element}: share of the perimeter, and stiffness loss of the "
        "whole element that turns as much"
    )
    for level in args.levels:
        truth = case.truth(level)
        print(f"  level {level}: {100 * truth['crack_share']:.0f} %, {100 * truth['equivalent_loss']:.1f} %")
    print(
        f"values: antiresonances found/true and false in {case.damage_band_hz[0]:g}-"
        f"{case.damage_band_hz[1]:g} Hz, or modes\n\n"
        "seed level method                  values        J  evaluations  seconds status        "
        "damaged elements, %"
    )
    runs = [one for seed in args.seeds for one in run_seed(case, seed, args.levels, args.methods)]
    for method in args.methods:
        print(f"\n{method}\n{verdict(case, [one for one in runs if one.method == method])}")
    if args.pictures:
        pictures(case, runs, args.pictures)


if __name__ == "__main__":
    main()
