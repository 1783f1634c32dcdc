"""Do the intervals of updated parameters hold? Simulation-based calibration, and coverage of wrong models.

Talts et al., arXiv:1804.06788: a truth drawn from the prior (uniform within the bounds), antiresonances with
errors drawn as stated, and the rank of the truth among the draws of the posterior. Over many truths every
rank is as likely as another; a Kolmogorov-Smirnov test for every parameter says whether it is. Three chains:
nothing was tuned on the second and third.

Then coverage of the 90 % intervals, without those of parameters that the data leave open on both sides: from
identified records of the chain of eight masses, and with truths outside the class of the model.

    python -m benchmarks.calibration_updating                      # 1,000 ranks of the linear posterior, each
    python -m benchmarks.calibration_updating --method ensemble --ranks 200
    python -m benchmarks.calibration_updating --coverage           # records, and wrong models
    python -m benchmarks.calibration_updating --structures --truths 3    # models of other structures

Of the structures of reference/outside_structures.py the stiffnesses of all elements are updated within 20 %,
while the masses are 1 to 3 % off and shear, finer meshes and dampers are in the truth only ("masses"); or a
support yields besides, of which the model knows nothing ("supports").
"""

from __future__ import annotations

import argparse
import warnings
from copy import copy
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
from scipy.stats import kstest

import antires_rs as ar
from benchmarks.study_tools import MOST_JOBS, each, print_table
from reference.calibration import QUICK, STRUCTURES as CHAINS, ranks
from reference.outside_structures import STRUCTURES, measured


def calibration(method, count, draws, jobs, markdown):
    """Table of the structures with the smallest p of all parameters, beside what it may be."""
    rows = []
    for name in CHAINS:
        found = list(each(partial(ranks, name=name, method=method, draws=draws), range(count), jobs))
        shares, inside, bounded, inflated = (np.array(part) for part in zip(*found, strict=True))
        p = [kstest(column, "uniform").pvalue for column in shares.T]
        rows.append(
            (
                name,
                len(p),
                f"{min(p):.4f}",
                f"{0.01 / len(p):.4f}",
                f"{100 * inside[bounded].mean():.1f} %",
                f"{100 * bounded.mean():.0f} %",
                f"{100 * inflated.mean():.0f} %",
            )
        )
    header = ("chain", "tests", "smallest p", "bar", "90 % covers", "not flat", "model error told")
    print(f"\n{method}: {count} ranks among {draws} draws")
    print_table(header, rows, markdown)


def from_record(seed):
    """Coverage of ratios to spring 0, and of the parameters, from one identified record at 1 % noise."""
    case = ar.cases.chain8(perturbation=0.1, rng=seed)
    record = case.experiment(noise=0.01, rng=seed, progress=False)
    zeros = ar.identify_antiresonances(record, excitation=0, band_hz=case.band_hz, progress=False)
    truth = case.truth()
    return coverage(
        case.updating_problem(zeros), np.r_[truth["mass_factor"], truth["stiffness_factor"]], seed
    )


def wrong(seed, kind):
    """The same with exact values and errors of 0.05 % from a structure that the model cannot become."""
    case = ar.cases.chain8(perturbation=0.1, rng=seed)
    true, truth = case.true_model(), case.truth()
    stiff, mass = true.stiffness(), true.mass()
    rng = np.random.default_rng(seed)
    if kind == "extra spring, 2 %":  # of spring 0, from mass 2 to mass 5
        stiff += 0.02 * 56.7e3 * np.outer(ends := np.eye(8)[2] - np.eye(8)[5], ends)
    elif kind == "spring to ground, 1 %":
        stiff[3, 3] += 0.01 * 56.7e3
    elif kind == "mass coupled, 2 %":  # mass of the springs, consistent
        for j in range(7):
            mass[j : j + 2, j : j + 2] += 0.02 * 0.4194 / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    other = ar.MatrixModel(stiff, mass)
    hz = dict(enumerate(other.antiresonances(range(8), 0)))
    noisy = {dof: f * (1.0 + 5e-4 * rng.standard_normal(f.size)) for dof, f in hz.items()}
    zeros = ar.AntiresonanceSet(0, noisy, std_hz={dof: 5e-4 * f for dof, f in hz.items()})
    return coverage(
        case.updating_problem(zeros), np.r_[truth["mass_factor"], truth["stiffness_factor"]], seed
    )


def coverage(problem, truth, seed):
    """Inside the intervals of the parameters that are not flat, inside those of ratios; chi-square."""
    found = ar.update(problem, optimizer=QUICK, rng=seed, workers=1, progress=False)
    told = found.intervals(workers=1, progress=False)
    open_ends = np.array([words == "flat" for words in told.words])
    inside = ((told.low <= truth) & (truth <= told.high))[~open_ends]
    seen = np.delete(np.arange(truth.size), [0, 8])  # mass 0 moves nothing; spring 0 is the scale
    low, high = np.quantile(told.draws[:, seen] / told.draws[:, [8]], [0.05, 0.95], axis=0)
    ratio = truth[seen] / truth[8]
    return inside, (low <= ratio) & (ratio <= high), found.chi_square, told.model_error


def covered(count, jobs, markdown):
    """Table of coverage from records and with truths outside the class."""
    kinds = ("none", "extra spring, 2 %", "spring to ground, 1 %", "mass coupled, 2 %")
    tasks = [("identified records, 1 % noise", from_record)]
    tasks += [(f"exact with 0.05 %, outside the class: {kind}", partial(wrong, kind=kind)) for kind in kinds]
    rows = []
    for name, task in tasks:
        found = list(each(task, range(100, 100 + count), jobs))
        inside = np.concatenate([part[0] for part in found])
        rows.append(
            (
                name,
                f"{100 * inside.mean():.0f} %",
                f"{100 * np.mean([part[1] for part in found]):.0f} %",
                f"{np.median([part[2] for part in found]):.2f}",
                f"{50 * np.median([part[3] for part in found]):.3f} %",
            )
        )
    print(f"\n90 % intervals, {count} truths of chain8, seeds 100 on")
    print_table(("measured", "parameters", "ratios", "chi-square", "model error"), rows, markdown)


#: What makes supports and joints of a structure firm, lumps nothing; of the elastic beam springs are as they
#: are in the model, or one is half as stiff again.
FIRM = {
    "building": {"base_n": (3.0e12, 1.5e15)},
    "grillage": {"corner_n_per_m": 2.0e10},
    "portal": {"foot": 1e4},
    "cantilever": {"spring": 0.0},
    "truss": {"roller_n_per_m": 4.0e14},
}
WITHOUT = {"crossing_kg": 0.0, "gusset_kg": 0.0, "corner": 1e4}


def of_structure(number, name, lacking, method, seed):
    """Inside the intervals of parameters that are not flat, and of those that are."""
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    structure = copy(STRUCTURES[name])
    structure.__dict__ |= {key: value for key, value in WITHOUT.items() if hasattr(structure, key)}
    structure.__dict__ |= {} if lacking else FIRM.get(name, {})
    rng = np.random.default_rng([seed, 5, list(STRUCTURES).index(name), number])
    own = structure.drawn(rng)
    if name == "elastic_beam":
        own = replace(own, connections=np.where((np.arange(12) == 2) & lacking, 1.5, 1.0))
    std = float(np.exp(rng.uniform(*np.log([1e-4, 1e-3]))))
    zeros = measured(structure, structure.truth(own), std, rng)
    problem = ar.UpdatingProblem(
        structure.model, ar.stiffness_factor(structure.elements, bounds=(0.8, 1.2)), zeros
    )
    found = ar.update(problem, optimizer=QUICK, rng=number, workers=1, progress=False)
    told = found.intervals(method, draws=200, workers=1, progress=False)
    inside = (told.low <= own.stiffness) & (own.stiffness <= told.high)
    flat = np.array([words == "flat" for words in told.words])
    return inside[~flat], inside[flat], told.high - told.low


def of_structures(count, method, seed, jobs, markdown):
    """Table of coverage by structure."""
    rows = []
    for lacking, name in product(
        (False, True), (name for name, one in STRUCTURES.items() if not one.cracks_alone)
    ):
        task = partial(of_structure, name=name, lacking=lacking, method=method, seed=seed)
        told, flat, width = (
            np.concatenate(part) for part in zip(*each(task, range(count), jobs), strict=True)
        )
        shares = (f"{part.sum()} of {part.size}" for part in (told, flat))
        rows.append((f"{name}, {'supports' if lacking else 'masses'}", *shares, f"{np.median(width):.2f}"))
    print_table(("90 % intervals hold", "told", "flat", "median width"), rows, markdown)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--method", choices=("laplace", "ensemble"), default="laplace")
    parser.add_argument("--ranks", type=int, default=1000, help="truths of each chain")
    parser.add_argument("--draws", type=int, default=199, help="draws that a truth is ranked among")
    parser.add_argument("--coverage", action="store_true", help="records and wrong models instead of ranks")
    parser.add_argument("--structures", action="store_true", help="models of other structures")
    parser.add_argument("--seed", type=int, default=0, help="of --structures")
    parser.add_argument("--truths", type=int, default=40, help="truths of each row of --coverage")
    parser.add_argument("--jobs", type=int, default=MOST_JOBS, choices=range(1, MOST_JOBS + 1))
    parser.add_argument("--markdown", action="store_true", help="tables as Markdown")
    options = parser.parse_args()
    if options.structures:
        of_structures(options.truths, options.method, options.seed, options.jobs, options.markdown)
    elif options.coverage:
        covered(options.truths, options.jobs, options.markdown)
    else:
        calibration(options.method, options.ranks, options.draws, options.jobs, options.markdown)


if __name__ == "__main__":
    main()
