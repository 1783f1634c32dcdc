"""Which search finds one damaged element among 30? Success rate and evaluations, ours and others'.

Run:  python -m benchmarks.search_study [--elements 17 46] [--seeds 5] [--limit 20000] [--methods ours ...]

Each problem has exact targets of the very model that is searched, with one element at 75 % loss, so the
question is the search alone. Solved means J <= min(J(truth), J(0)) + 1e-6 within the limit of
evaluations, which is the same for all and counts linearizations. All methods call the same objective,
negligible severities set to zero; every run ends as soon as it has solved. The other optimizers are in the
dependency group "rivals".
"""

import argparse
import contextlib
import statistics
import time

import numpy as np

import antires_rs as ar
from benchmarks.rival_searches import pycma, pymoo_ga, scipy_de

SEVERITY, TOLERANCE = 0.75, 1e-6


class Solved(Exception):
    """Ends an optimizer that has no hook of its own: solved, or at its limit."""


class Account:
    """The objective, its evaluations, and the best of them."""

    def __init__(self, problem, bar, limit):
        self.problem, self.bar, self.limit = problem, bar, limit
        self.bounds = problem.bounds
        self.nfev, self.fun, self.x = 0, np.inf, None

    def __call__(self, candidates):
        """Costs of the rows; raises when solved or at the limit."""
        rows = np.atleast_2d(candidates)[: self.limit - self.nfev]
        costs = self.problem.evaluate_many(rows)
        solved = np.flatnonzero(costs <= self.bar)
        used = solved[0] + 1 if solved.size else len(costs)
        best = costs[:used].argmin()
        if costs[best] < self.fun:
            self.fun, self.x = costs[best], rows[best].copy()
        self.nfev += used
        if self.fun <= self.bar or self.nfev >= self.limit:
            raise Solved
        return costs


def islands(**options):
    """The library's search with these options."""

    def run(account, seed):
        ga = ar.IslandGA(max_evaluations=account.limit, **options)
        found = ar.update(
            account.problem,
            optimizer=ga,
            rng=seed,
            progress=False,
            callback=lambda state: state["fun"] <= account.bar,
        )
        account.nfev, account.fun, account.x = found.nfev, found.fun, found.x

    return run


#: The paper's algorithm stops on equal genes only and counts any gain.
METHODS = {
    "ours": islands(),
    "paper": islands(polish=False, improvement_tolerance=0.0, agreement="genes"),
    "one island of 160": islands(polish=False, islands=1, population=160),
    "scipy DE": scipy_de,
    "CMA-ES (pycma)": pycma,
    "pymoo GA": pymoo_ga,
}


def one_run(case, first, element, seed, limit, method):
    """(solved, evaluations, right element, right severity, seconds) of one search."""
    problem = case.search_problem(element, SEVERITY)
    truth = np.zeros(len(problem.bounds))
    truth[element - first] = SEVERITY
    bar = min(problem.cost(truth), problem.cost(0 * truth)) + TOLERANCE
    account = Account(problem, bar, limit)
    start = time.perf_counter()
    with contextlib.suppress(Solved):
        METHODS[method](account, seed)
    right = account.x.argmax() == element - first
    close = bool(right and abs(account.x[element - first] - SEVERITY) <= 0.01)
    return account.fun <= bar, account.nfev, right, close, time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--elements",
        type=int,
        nargs=2,
        default=(17, 46),
        metavar=("FIRST", "LAST"),
        help="zero-based range of damaged elements",
    )
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--limit", type=int, default=20_000, help="evaluations of one run")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS))
    args = parser.parse_args()
    case = ar.cases.exhaust()
    elements = range(args.elements[0], args.elements[1] + 1)
    print(
        f"{type(case).__name__}: elements {elements[0]}-{elements[-1]}, {args.seeds} seeds, "
        f"{args.limit:,} evaluations"
    )
    print(f"{'method':20} {'solved':>12} {'evaluations':>12} {'element':>9} {'severity':>9} {'seconds':>9}")
    print(f"{'':20} {'':>12} {'median':>12} {'right':>9} {'+-0.01':>9} {'median':>9}")
    for method in args.methods:
        runs = [
            one_run(case, 17, element, seed, args.limit, method)
            for element in elements
            for seed in range(args.seeds)
        ]
        solved, nfev, right, close, seconds = zip(*runs, strict=True)
        n = len(runs)
        share = [100 * sum(hits) / n for hits in (solved, right, close)]
        print(
            f"{method:20} {sum(solved):4d}/{n} {share[0]:4.0f} % {statistics.median(nfev):10,.0f}"
            f" {share[1]:7.0f} % {share[2]:7.0f} % {statistics.median(seconds):9.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
