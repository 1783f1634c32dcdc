"""Damage against a baseline, the model wrong: false alarms, right hypotheses, intervals, probabilities.

The eight-mass chain, every mass and spring of the truth off by up to a percentage drawn between 1 and 10,
intact and damaged state identified from records of their own with 1 % noise: intact, one damage of 2 to 60 %
(log-uniform), two of 5 to 60 %. The model is the nominal chain, never updated.

    python -m benchmarks.baseline_study                  # 200, 200 and 100 structures, half an hour on two
    cores python -m benchmarks.baseline_study --count 20 20 10
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import pickle
import warnings
from itertools import pairwise

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import each

NOISE, DURATION_S, RATE = 0.01, 256.0, 0.05
LEAST, MOST = 0.02, 0.60


def drawn(kind, seed):
    """Model error and severities of one structure."""
    rng = np.random.default_rng([seed, kind])
    off = float(rng.uniform(0.01, 0.10))
    losses = np.zeros(7)
    where = rng.choice(7, size=kind, replace=False)
    least = LEAST if kind == 1 else 0.05
    losses[where] = np.exp(rng.uniform(np.log(least), np.log(MOST), kind))
    return off, losses, rng


def identified(case, losses, rng):
    """Antiresonances of a record."""
    chain = case.true_model(0)
    model = chain.with_parameters(ar.stiffness_reduction(range(7)), losses)
    record = model.simulate(
        excitation=0,
        fs_hz=512.0,
        duration_s=DURATION_S,
        damping_ratio=0.01,
        noise=NOISE,
        responses=list(range(8)),
        rng=rng,
    )
    return ar.identify_antiresonances(record, excitation=0, band_hz=case.band_hz, check="off")


def one_run(task):
    """Truth and answers of one structure."""
    warnings.simplefilter("ignore")
    kind, seed = task
    off, losses, rng = drawn(kind, seed)
    case = ar.cases.chain8(perturbation=off, rng=rng)
    before, now = identified(case, np.zeros(7), rng), identified(case, losses, rng)
    result = ar.assess_damage(case.model, now, baseline=before, workers=1)
    bounded = ar.assess_damage(
        case.model, now, baseline=before, workers=1, search=ar.SearchOptions(false_alarm_rate=RATE), rng=seed
    )
    return {
        "kind": kind,
        "seed": seed,
        "off": off,
        "losses": losses,
        "declared": result.assessment.declared,
        "at_rate": bounded.assessment.declared,
        "severity": result.severity,
        "interval": result.interval,
        "probability": result.probability,
        "damage": result.probability_of_damage,
        "elsewhere": result.probability_elsewhere,
        "best": (result.hypotheses[0].elements, result.hypotheses[0].probability),
        "a90": result.detectable,
        "chi_square": result.chi_square,
        "kappa": result.assessment.kappa,
        "tau": result.assessment.root_std,
        "s": result.assessment.factor_std,
        "values": (sum(len(before[d]) for d in before), sum(len(now[d]) for d in now)),
    }


def told(rows):
    """Sentences: false alarms, right answers above a90, intervals, stated and observed probabilities."""
    intact = [row for row in rows if row["kind"] == 0]
    by_default, at_rate = (sum(bool(row[key]) for row in intact) for key in ("declared", "at_rate"))
    yield f"false alarms of {len(intact)}: {by_default} by default, {at_rate} with false_alarm_rate={RATE}"
    for kind in (1, 2):
        own = [(row, tuple(np.flatnonzero(row["losses"]).tolist())) for row in rows if row["kind"] == kind]
        above = [(row, e) for row, e in own if all(row["losses"][i] >= row["a90"][i] for i in e)]
        right = sum(tuple(row["declared"]) == e for row, e in above)
        held = [row["interval"][i][0] <= row["losses"][i] <= row["interval"][i][1]
                for row, e in above if tuple(row["declared"]) == e for i in e]  # fmt: skip
        yield (
            f"{kind} damaged: right {right} of {len(above)} above a90 ({len(own)} in all); "
            f"90 % intervals hold {sum(held)} of {len(held)}"
        )
    stated, true = [], []
    for row in rows:
        for element, p in row["probability"].items():
            stated.append(p)
            true.append(row["losses"][element] > 0.0)
    stated, true = np.array(stated), np.array(true)
    for low, high in pairwise((0.0, 1e-3, 0.01, 0.1, 0.5, 0.9, 0.99, 1.0001)):
        within = (stated >= low) & (stated < high)
        if within.any():
            yield (
                f"probability {low:g} to {min(high, 1.0):g}: stated {stated[within].mean():.4f}, "
                f"observed {true[within].mean():.4f} of {within.sum()}"
            )


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, nargs=3, default=[200, 200, 100])
    parser.add_argument("--first-seed", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out")
    given = parser.parse_args()
    tasks = [(kind, given.first_seed + i) for kind, n in enumerate(given.count) for i in range(n)]
    rows = list(each(one_run, tasks, given.workers))
    print("\n".join(told(rows)))
    if given.out:
        with open(given.out, "wb") as file:
            pickle.dump(rows, file)
