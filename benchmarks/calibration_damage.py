"""Simulation-based calibration of damage assessments: truths from the prior, values with their stated errors.

Chains of the fitted class: factors of every mass and spring log-normal with a scatter drawn from the prior of
``damage.likelihood``; damage drawn from :class:`antires_rs.DamagePrior` given that a candidate is damaged;
severities uniform. Values of both states are the exact ones with Gaussian errors of the stated size. The
rank of a true severity among draws of the posterior given the right elements is uniform if intervals mean
what they say.

    python -m benchmarks.calibration_damage                 # 1,000 ranks, ten minutes on two cores
    python -m benchmarks.calibration_damage --count 100
    python -m benchmarks.calibration_damage --first 500 --count 150 --sure   # among sampled severities too
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
from functools import partial

import numpy as np
from scipy.stats import kstest, norm

import antires_rs as ar
from benchmarks.study_tools import each

STD, N = 3e-4, 8
MASSES_KG, SPRINGS_N_PER_M = np.array([0.5593] + 7 * [0.4194]), np.full(7, 56.7e3)
#: Scatter of the factors, ln: median and logarithmic deviation, cut to what keeps responses apart.
SCATTER, CUT = (0.05, 0.5), (0.01, 0.12)


def values(masses, springs, rng):
    """A set with Gaussian errors."""
    exact = ar.MassSpringChain(masses, springs).antiresonances(list(range(N)), 0)
    freq = {dof: np.sort(f * (1.0 + STD * rng.standard_normal(f.size))) for dof, f in enumerate(exact)}
    return ar.AntiresonanceSet(0, freq, std_hz={dof: STD * f for dof, f in freq.items()})


def one_run(seed, sure=False):
    """Ranks of the true severities, what was found, and the probability of the truth."""
    rng = np.random.default_rng([13, seed])
    s = float(np.clip(np.exp(np.log(SCATTER[0]) + SCATTER[1] * rng.standard_normal()), *CUT))
    masses = MASSES_KG * np.exp(s * rng.standard_normal(N))
    springs = SPRINGS_N_PER_M * np.exp(s * rng.standard_normal(7))
    prior = ar.DamagePrior()
    shares = np.array([prior.nothing, prior.one, prior.two, prior.three])
    count = int(rng.choice(4, p=shares / shares.sum()))
    elements = tuple(sorted(int(e) for e in rng.choice(7, size=count, replace=False)))
    losses = np.zeros(7)
    losses[list(elements)] = rng.uniform(0.0, 0.99, count)
    before, now = values(masses, springs, rng), values(masses, springs * (1.0 - losses), rng)
    nominal = ar.MassSpringChain(MASSES_KG, SPRINGS_N_PER_M)
    result = ar.assess_damage(
        nominal, now, baseline=before, workers=1, search=ar.SearchOptions(std_common=0.0)
    )
    true = next((h for h in result.hypotheses if h.elements == elements and h.candidate), None)
    ranks, held, sampled = [], [], []
    if true is not None and elements:
        for e, low, high in zip(elements, true.low, true.high, strict=True):
            # The interval is that of a Gaussian of ln(1 - severity), cut at the bounds.
            limits, own = np.log1p(-np.array([low, high])), np.log1p(-losses[e])
            sd = (limits[0] - limits[1]) / (2.0 * norm.ppf(0.95))
            ranks.append(float(norm.cdf((limits.mean() - own) / sd)) if sd > 0.0 else 0.5)
            held.append(low <= losses[e] <= high)
    if sure and elements and tuple(sorted(result.damaged)) == elements:
        drawn = result.intervals("ensemble", rng=seed, workers=1).draws
        sampled = [float(np.mean(drawn[:, e] < losses[e])) for e in elements]
    best = result.hypotheses[0]
    return {
        "count": count,
        "right": best.elements == elements and best.candidate,
        "probability": best.probability,
        "of_truth": 0.0 if true is None else true.probability,
        "ranks": ranks,
        "held": held,
        "sampled": sampled,
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=2000, help="structures; about half of them damaged")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--sure", action="store_true", help="severities sampled as well")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.count)
    rows = list(each(partial(one_run, sure=given.sure), seeds, given.workers))
    ranks = np.array([r for row in rows for r in row["ranks"]])
    held = np.array([h for row in rows for h in row["held"]])
    print(f"{len(rows)} structures, {ranks.size} ranks: KS p = {kstest(ranks, 'uniform').pvalue:.3f}")
    print(f"90 % intervals hold {100 * held.mean():.1f} %")
    print("ranks in tenths:", np.histogram(ranks, np.linspace(0.0, 1.0, 11))[0].tolist())
    if given.sure:
        among = np.array([r for row in rows for r in row["sampled"]])
        inside = np.mean((among > 0.05) & (among < 0.95))
        print(f"sampled: {among.size} ranks: KS p = {kstest(among, 'uniform').pvalue:.3f}")
        print(f"90 % intervals hold {100 * inside:.1f} %")
    right, stated = np.array([r["right"] for r in rows]), np.array([r["probability"] for r in rows])
    for low, high in ((0.0, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 0.99), (0.99, 1.01)):
        own = (stated >= low) & (stated < high)
        if own.any():
            print(
                f"stated {low:.2f} to {min(high, 1.0):.2f}: {own.sum():4d} cases, "
                f"stated {stated[own].mean():.3f}, observed {right[own].mean():.3f}"
            )
    by_count = [(k, np.array([r["right"] for r in rows if r["count"] == k])) for k in range(4)]
    print("right by number of damages:", {k: f"{v.sum()} of {v.size}" for k, v in by_count})
