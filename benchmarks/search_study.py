"""Which search finds the damage? Ours, plain rivals, and other packages' optimizers on the same objective.

    python -m benchmarks.search_study --quick               # some ten minutes: two draws of each kind
    python -m benchmarks.search_study --least 95            # as in the campaign: five draws, fails below 95 %
    python -m benchmarks.search_study --packages --draws 1  # other packages' optimizers besides

Two structures, one to three damages, exact and noisy targets and those of a structure that the model misses
by 4 % (``benchmarks.search_cases``). Solved means a J within 1e-4 of the least that anyone found: a descent
on the true elements, ours from two seeds, matching pursuit, and whoever came lower in the race. A run ends as
soon as it has solved, by its own rule, or at the limit of evaluations; a linearization counts as one of them
and is counted beside. Everyone calls the same compiled objective and sensitivities on one thread, so that the
search is compared and not the objective; CPU seconds hold what each spends besides. The packages are in the
dependency group "rivals".
"""

import argparse
import contextlib
import statistics
import time
from dataclasses import dataclass

import numpy as np

import antires_rs as ar
from benchmarks.plain_searches import lasso, many_starts, prune, pursuit, raised, refit, scan
from benchmarks.rival_searches import pycma, pymoo_ga, scipy_de
from benchmarks.search_cases import KINDS, STRUCTURES
from benchmarks.study_tools import print_table

TOLERANCE = 1e-4


class Solved(Exception):
    """Ends an optimizer that has no hook of its own: solved, or at its limit."""


class Account:
    """The objective, what was asked of it, and the best answer."""

    def __init__(self, problem, bar, limit):
        self.problem, self.bar, self.limit = problem, bar, limit
        self.bounds = problem.bounds
        self.nfev, self.njev, self.fun, self.x = 0, 0, np.inf, np.zeros(len(problem.bounds))

    def __call__(self, candidates):
        """Costs of the rows; raises when solved or at the limit."""
        rows = np.atleast_2d(candidates)[: self.limit - self.nfev]
        costs = self.problem.evaluate_many(rows, workers=1)
        solved = np.flatnonzero(costs <= self.bar)
        used = solved[0] + 1 if solved.size else len(costs)
        self._note(rows[costs[:used].argmin()], costs[:used].min(), used)
        return costs

    def linearized(self, x):
        """J, residuals and their slopes; raises likewise."""
        found = self.problem._core.linearized(x)
        self.njev += 1
        self._note(x, found[0], 1)
        return found

    def _note(self, x, cost, used):
        if cost < self.fun:
            self.fun, self.x = cost, self.problem._core.repaired(x)
        self.nfev += used
        if self.fun <= self.bar or self.nfev >= self.limit:
            raise Solved


def islands(**options):
    """The library's search with these options."""

    def run(account, seed):
        ga = ar.IslandGA(max_evaluations=account.limit, **options)
        found = ar.update(
            account.problem,
            optimizer=ga,
            rng=seed,
            workers=1,
            progress=False,
            callback=lambda state: state["fun"] <= account.bar,
        )
        account.nfev, account.njev, account.fun, account.x = found.nfev, found.njev or 0, found.fun, found.x

    return run


PLAIN = {
    "ours": islands(),
    "scan of single elements": scan,
    "matching pursuit": pursuit,
    "LASSO on sensitivities": lasso,
    "least squares, many starts": many_starts,
}
#: The paper's algorithm stops on equal genes only and counts any gain.
METHODS = PLAIN | {
    "paper": islands(polish=False, improvement_tolerance=0.0, agreement="genes"),
    "one island of 160": islands(polish=False, islands=1, population=160),
    "scipy DE": scipy_de,
    "CMA-ES (pycma)": pycma,
    "pymoo GA": pymoo_ga,
}


@dataclass(frozen=True)
class Run:
    """One search of one problem."""

    fun: float
    nfev: int
    njev: int
    right: bool
    seconds: float


def one_run(problem, truth, bar, seed, limit, method):
    """One search until it has solved or knows no further."""
    account = Account(problem, bar, limit)
    start = time.process_time()
    with contextlib.suppress(Solved):
        METHODS[method](account, seed)
    seconds = time.process_time() - start
    right = bool(np.array_equal(raised(account.x), raised(truth)))
    return Run(account.fun, account.nfev, account.njev, right, seconds)


def least_known(problem, truth):
    """The least J that a descent on the true elements, our search and a pursuit find."""
    account = Account(problem, -np.inf, 10**9)
    prune(account, *refit(account, truth))
    pursuit(account, 0)
    ours = [ar.update(problem, rng=seed, progress=False).fun for seed in (1001, 1002)]
    return min(account.fun, *ours)


def race(name, draws, limit, methods):
    """{method: {(damages, kind): [(solved, run)]}} of one structure."""
    tested, found = STRUCTURES[name](), {method: {} for method in methods}
    for damages in (1, 2, 3):
        for kind in KINDS:
            for seed in range(draws):
                problem, truth = tested.problem(damages, kind, seed)
                least = least_known(problem, truth)
                bar = least + TOLERANCE * (1.0 + abs(least))
                runs = {m: one_run(problem, truth, bar, seed, limit, m) for m in methods}
                lowest = min(least, *(run.fun for run in runs.values()))
                for method, run in runs.items():
                    solved = run.fun <= lowest + TOLERANCE * (1.0 + abs(lowest))
                    found[method].setdefault((damages, kind), []).append((solved, run))
    return found


def rows_of(found):
    """A row a method: solved by number of damages and by kind, and what it took."""
    rows = []
    for method, cells in found.items():

        def share(which, cells=cells):
            hits = [solved for key, runs in cells.items() if which in key for solved, _ in runs]
            return f"{sum(hits)}/{len(hits)}"

        runs = [pair for each in cells.values() for pair in each]
        every = [run for _, run in runs]
        solved = [run.seconds for hit, run in runs if hit]
        rows.append(
            [
                method,
                *(share(which) for which in (1, 2, 3, *KINDS)),
                f"{100 * sum(hit for hit, _ in runs) / len(runs):.0f} %",
                f"{100 * sum(run.right for run in every) / len(runs):.0f} %",
                f"{statistics.median(run.nfev for run in every):,.0f}",
                f"{statistics.median(run.njev for run in every):,.0f}",
                f"{statistics.median(run.seconds for run in every):.2f}",
                f"{statistics.median(solved):.2f}" if solved else "-",
            ]
        )
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--structures", nargs="+", choices=STRUCTURES, default=list(STRUCTURES))
    parser.add_argument("--draws", type=int, default=5, help="problems of each kind and number of damages")
    parser.add_argument("--limit", type=int, default=10_000, help="evaluations of one run")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(PLAIN))
    parser.add_argument("--packages", action="store_true", help="all methods")
    parser.add_argument("--quick", action="store_true", help="two draws, 5,000 evaluations")
    parser.add_argument("--least", type=float, default=0.0, help="%% that ours must solve of each structure")
    parser.add_argument("--markdown", action="store_true")
    args = parser.parse_args()
    if args.quick:
        args.draws, args.limit = 2, 5_000
    if args.packages:
        args.methods = list(METHODS)
    header = ["method", "one", "two", "three", *KINDS, "solved", "elements right", "evaluations"]
    header += ["gradients", "CPU s", "where solved"]
    for name in args.structures:
        print(f"{name}: {9 * args.draws} problems, {args.limit:,} evaluations", flush=True)
        found = race(name, args.draws, args.limit, args.methods)
        print_table(header, rows_of(found), args.markdown)
        ours = [solved for runs in found.get("ours", {}).values() for solved, _ in runs]
        if sum(ours) < args.least / 100.0 * len(ours):
            raise SystemExit(f"ours solved {sum(ours)} of {len(ours)}")


if __name__ == "__main__":
    main()
