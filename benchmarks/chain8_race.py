"""Wall time of a whole chain8 damage run: the library against six optimizers on a vectorised objective.

Run:  python -m benchmarks.chain8_race [--seeds 10] [--limit 100000]     (with the dependency group "rivals")

Spring 4 has lost 55 %; the targets are the exact antiresonances. A rival's clock stops at the first candidate
whose severities are all within 0.5 % of the truth, exact zeros included (severities below 1e-3 count as zero,
or no continuous sampler would ever pay the right penalty). Ours runs on to its own stop: nobody tells it the
truth. Rivals drive J computed in numpy for a whole generation at once, with stacked eigenvalue problems;
pygmo's CMA-ES knows only single candidates. One core, one run, in turn. Settings are each package's own, with
populations of 160 where one must be given.
"""

# ruff: noqa: E402  (the number of BLAS threads is read once, when numpy is imported)
import os

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import argparse
import statistics
import time

import numpy as np

import antires_rs as ar
from benchmarks.objective_speed import by_numpy
from benchmarks.rival_searches import pycma, pymoo_ga, scipy_de

SNAP, WITHIN, UPPER = 1e-3, 0.005, 0.99
TRUTH = np.array([0, 0, 0, 0, 0.55, 0, 0])


class Done(Exception):
    """Ends an optimizer that has no hook of its own."""


class Account:
    """J in numpy for rows of severities; raises at the bar or at the limit."""

    bounds = np.tile([0.0, UPPER], (7, 1))

    def __init__(self, case, measured, limit):
        self.case, self.measured, self.limit = case, measured, limit
        self.limit_hz = 1.5 * max(freq.max() for freq in measured.values() if freq.size)
        self.nfev, self.reached = 0, False

    def __call__(self, rows):
        """Costs (m,) of severities (m, 7)."""
        rows = np.clip(np.atleast_2d(rows), 0.0, UPPER)
        rows[rows < SNAP] = 0.0
        costs = by_numpy(self.case, self.measured, self.limit_hz, rows)
        self.nfev += len(rows)
        self.reached |= bool((np.abs(rows - TRUTH) <= WITHIN).all(axis=1).any())
        if self.reached or self.nfev >= self.limit:
            raise Done
        return costs


def deap_ga(account, seed):
    """DEAP's eaSimple with tournament, blend and bounded polynomial operators; a generation is one batch."""
    import random

    from deap import algorithms, base, creator, tools

    random.seed(seed)
    if not hasattr(creator, "Least"):
        creator.create("Least", base.Fitness, weights=(-1.0,))
        creator.create("Severities", list, fitness=creator.Least)
    box = base.Toolbox()
    box.register("individual", tools.initRepeat, creator.Severities, lambda: random.uniform(0.0, UPPER), 7)
    box.register("mate", tools.cxSimulatedBinaryBounded, eta=15.0, low=0.0, up=UPPER)
    box.register("mutate", tools.mutPolynomialBounded, eta=20.0, low=0.0, up=UPPER, indpb=1 / 7)
    box.register("select", tools.selTournament, tournsize=3)
    box.register("evaluate", lambda x: x)
    box.register("map", lambda _, people: [(cost,) for cost in account(np.array(list(people)))])
    people = tools.initRepeat(list, box.individual, 160)
    algorithms.eaSimple(people, box, cxpb=0.9, mutpb=0.3, ngen=10**6, verbose=False)


class Severities:
    """The problem as pygmo wants it."""

    account = None

    def fitness(self, x):
        """Cost of one candidate."""
        return [float(Severities.account(x)[0])]

    def batch_fitness(self, rows):
        """Costs of a generation."""
        return Severities.account(np.asarray(rows).reshape(-1, 7))

    def get_bounds(self):
        """The box."""
        return [0.0] * 7, [UPPER] * 7


def pygmo_with(make):
    """A run of one of pygmo's algorithms, evolved until the bar or the limit."""

    def run(account, seed):
        import pygmo as pg

        Severities.account = account
        rng = np.random.default_rng(seed)
        while True:
            people = pg.population(
                pg.problem(Severities()), 160, b=pg.bfe(pg.member_bfe()), seed=int(rng.integers(2**31))
            )
            algorithm = pg.algorithm(make(pg, int(rng.integers(2**31))))
            algorithm.evolve(people)

    return run


def swarm(pg, seed):
    swarm = pg.pso_gen(gen=400, seed=seed)
    swarm.set_bfe(pg.bfe(pg.member_bfe()))
    return swarm


RIVALS = {
    "scipy DE": scipy_de,
    "CMA-ES (pycma)": pycma,
    "pymoo GA": pymoo_ga,
    "DEAP GA": deap_ga,
    "pygmo PSO": pygmo_with(swarm),
    "pygmo CMA-ES": pygmo_with(lambda pg, seed: pg.cmaes(gen=400, seed=seed, force_bounds=True)),
}


def ours(case, measured, seed, polish):
    """(reached, evaluations, seconds) of a run to its own stop."""
    start = time.perf_counter()
    found = ar.assess_damage(
        case.model, measured, optimizer=ar.IslandGA(polish=polish), rng=seed, workers=1, progress=False
    )
    return bool((np.abs(found.x - TRUTH) <= WITHIN).all()), found.nfev, time.perf_counter() - start


def rival(case, measured, seed, limit, run):
    """(reached, evaluations, seconds) of a run to the bar."""
    account = Account(case, measured, limit)
    start = time.perf_counter()
    try:
        run(account, seed)
    except Exception:
        # pygmo passes exceptions on as its own.
        if not (account.reached or account.nfev >= limit):
            raise
    return account.reached, account.nfev, time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--limit", type=int, default=100_000, help="evaluations of one rival's run")
    args = parser.parse_args()
    case = ar.cases.chain8()
    zeros = case.truth(1)["freq_hz"]
    measured = ar.AntiresonanceSet(case.excitation, zeros)
    print(f"chain8, spring 4 at 55 %, exact targets, {args.seeds} seeds, one core")
    print(
        f"{'method':28} {'bar reached':>12} {'evaluations':>12} {'seconds':>9} {'slowest':>9} "
        f"{'over ours':>10}"
    )
    base = None
    contestants = {
        "ours, to its own stop": lambda seed: ours(case, measured, seed, None),
        "ours without polish": lambda seed: ours(case, measured, seed, False),
    }
    for name, run in RIVALS.items():
        contestants[name] = lambda seed, run=run: rival(case, measured, seed, args.limit, run)
    for name, run in contestants.items():
        reached, nfev, seconds = zip(*[run(seed) for seed in range(args.seeds)], strict=True)
        middle = statistics.median(seconds)
        base = base or middle
        print(
            f"{name:28} {sum(reached):6d} of {args.seeds:2d} {statistics.median(nfev):12,.0f} "
            f"{middle:9.3f} {max(seconds):9.3f} {middle / base:10.0f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
