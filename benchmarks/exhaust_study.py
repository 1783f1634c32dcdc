"""Updating the exhaust: 21 parameters, antiresonances identified from the record of another, finer structure.

Per seed: a record of 10 minutes with 1 % sensor noise, its antiresonances, the update from those of 12
accelerometers, and what it does to what was kept out: 4 accelerometers and all resonances (identified from
the same record). Differences are printed with the nearest pairing, which the objective uses, and one to one.

    python -m benchmarks.exhaust_study                        # seeds 20 to 24
    python -m benchmarks.exhaust_study --seeds 100 101 --pictures out
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

import antires_rs as ar

#: A true value is found when an identified one lies within 1 % of it.
CLOSE = 0.01
NOISE = 0.01


@dataclass(frozen=True)
class Run:
    """One seed: what was identified, the update, differences in % before and after by name."""

    seed: int
    found: int
    true: int
    false: int
    result: ar.UpdateResult
    differences: dict[str, tuple[np.ndarray, np.ndarray]]
    seconds: dict[str, float]


def identify(case, record):
    """Antiresonances of all accelerometers in the damage band, which holds the updating band."""
    return ar.identify_antiresonances(record, excitation=case.excitation, band_hz=case.damage_band_hz)


def count(case, zeros, level):
    """Found, true and false values in the damage band, one to one within 1 %."""
    low, high = case.damage_band_hz
    found = true = false = 0
    for dof, values in case.truth(level)["freq_hz"].items():
        free = [v for v in values if low <= v <= high]
        true += len(free)
        for value in zeros[dof]:
            near = [v for v in free if abs(value / v - 1.0) <= CLOSE]
            if near:
                free.remove(min(near, key=lambda v: abs(v - value)))
            found, false = found + bool(near), false + (not near)
    return found, true, false


def differences(model, case, zeros, dofs, band_hz, *, one_to_one):
    """Differences in % between the model and the measured values of some dofs in a band."""
    percent = []
    for dof, of_model in zip(
        dofs, model.antiresonances(list(dofs), case.excitation, f_max_hz=1.5 * band_hz[1]), strict=True
    ):
        measured = zeros[dof][(zeros[dof] >= band_hz[0]) & (zeros[dof] <= band_hz[1])]
        if not measured.size:
            continue
        apart = np.abs(np.log(of_model[None, :] / measured[:, None]))
        rows, columns = (
            linear_sum_assignment(apart) if one_to_one else (np.arange(measured.size), apart.argmin(axis=1))
        )
        percent += list(100.0 * (of_model[columns] / measured[rows] - 1.0))
    return np.array(percent)


def resonance_differences(model, measured):
    """Differences in % of the resonances, in order; rigid-body modes lie below the band."""
    elastic = model.modes(f_max_hz=2.0 * measured.freq_hz[-1]).freq_hz
    elastic = elastic[elastic > 5.0][: measured.freq_hz.size]
    return 100.0 * (elastic / measured.freq_hz - 1.0)


def run(seed):
    """Record, identification and update of one seed."""
    case, clock = ar.cases.exhaust(), [time.perf_counter()]
    record = case.experiment(noise=NOISE, rng=seed)
    clock.append(time.perf_counter())
    zeros = identify(case, record)
    clock.append(time.perf_counter())
    result = ar.update(case.updating_problem(zeros), rng=seed, progress=False)
    clock.append(time.perf_counter())
    modes = ar.identify_modes(record, band_hz=case.damage_band_hz)
    both = (case.model, result.model)
    values = {
        f"{name}, {'one to one' if single else 'nearest'}": tuple(
            differences(model, case, zeros, dofs, case.updating_band_hz, one_to_one=single) for model in both
        )
        for name, dofs in (("fitted", case.fitted), ("kept out", case.held_out))
        for single in (False, True)
    }
    values["resonances"] = tuple(resonance_differences(model, modes) for model in both)
    seconds = dict(zip(("record", "identification", "update"), np.diff(clock), strict=True))
    return Run(seed, *count(case, zeros, 0), result, values, seconds)


def pictures(last, folder):
    """Differences before and after, and the model with its sensors and the shaker."""
    from matplotlib.figure import Figure

    case, folder = ar.cases.exhaust(), Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    figure = Figure(figsize=(11, 5), layout="constrained")
    last.result.plot(ax=figure.subplots())
    figure.savefig(folder / "exhaust_differences.png", dpi=120)
    figure = Figure(figsize=(12, 4.5), layout="constrained")
    case.model.plot(ax=figure.subplots(), sensors=case.responses, excitation=case.excitation)
    figure.savefig(folder / "exhaust_model.png", dpi=120)
    print(f"pictures in {folder}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(20, 25)))
    parser.add_argument("--pictures", metavar="FOLDER", help="draw the last seed's pictures there")
    args = parser.parse_args()
    case = ar.cases.exhaust()
    print(
        f"{case}: fit of {len(case.updating_parameters())} parameters to {len(case.fitted)} "
        f"accelerometers, {case.updating_band_hz[0]:g}-{case.updating_band_hz[1]:g} Hz; kept out: "
        + ", ".join(case.model.dof_name(dof) for dof in case.held_out)
    )
    print("largest and mean of the absolute differences in %, before -> after\n")
    runs = []
    for seed in args.seeds:
        one = run(seed)
        runs.append(one)
        took = ", ".join(f"{name} {s:.1f} s" for name, s in one.seconds.items())
        print(
            f"seed {seed}: {one.found} of {one.true} true antiresonances found up to "
            f"{case.damage_band_hz[1]:g} Hz, {one.false} false; {one.result.nfev:,} evaluations, "
            f"{one.result.status}; {took}"
        )
        for name, (before, after) in one.differences.items():
            largest, mean = (tuple(f(np.abs(v)) for v in (before, after)) for f in (np.max, np.mean))
            print(
                f"  {name:<22} {before.size:3d}   largest {largest[0]:6.2f} -> {largest[1]:6.3f}"
                f"   mean {mean[0]:6.2f} -> {mean[1]:6.3f}",
                flush=True,
            )
    print(f"\nthe last seed in full\n{runs[-1].result.table}")
    print("\nparameters, with the tested structure's values beside them (it differs in other ways as well)")
    truth = case.truth(0)
    true = [
        *truth["thickness"].values(),
        *truth["youngs_modulus"].values(),
        *truth["point_mass"].values(),
        *truth["angle"].values(),
    ]
    for name, value, exact in zip(runs[-1].result.problem.names, runs[-1].result.x, true, strict=True):
        print(f"  {name:<40} {value:9.4f} {exact:9.4f}")
    if args.pictures:
        pictures(runs[-1], args.pictures)


if __name__ == "__main__":
    main()
