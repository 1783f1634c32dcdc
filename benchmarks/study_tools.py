"""What the studies share: two worker processes, scores by response, tables as text or Markdown."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

from reference.matching import Matched, match

#: More processes than this have no place on a shared machine.
MOST_JOBS = 2


def each(worker, tasks, jobs):
    """Results of ``worker(task)`` in the order of the tasks, by ``jobs`` processes."""
    if jobs <= 1:
        yield from map(worker, tasks)
        return
    # Not fork: a forked child inherits locks of the parent's BLAS.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, MOST_JOBS), mp_context=context) as pool:
        yield from pool.map(worker, tasks)


@dataclass(frozen=True)
class Score:
    """Several runs of one configuration: for each run, the matches by dof."""

    runs: tuple[dict[int, Matched], ...]

    @property
    def found(self):
        """Values found in each run."""
        return [sum(len(m.pairs) for m in run.values()) for run in self.runs]

    @property
    def true(self):
        """True values of each run."""
        return [
            n + sum(len(m.missed) for m in run.values()) for n, run in zip(self.found, self.runs, strict=True)
        ]

    @property
    def false(self):
        """False values of each run."""
        return [sum(len(m.false) for m in run.values()) for run in self.runs]

    @property
    def errors(self):
        """Relative errors of all values found."""
        return np.array([e for run in self.runs for m in run.values() for e in m.errors] or [np.nan])

    def dof(self, dof):
        """The same for one response."""
        return Score(tuple({dof: run[dof]} for run in self.runs))

    def missed(self):
        """Text: how often which true value was missed, for structures that do not change."""
        return _counted((dof, value) for run in self.runs for dof, m in run.items() for value in m.missed)

    def false_values(self):
        """Text: all false values."""
        return _counted((dof, value) for run in self.runs for dof, m in run.items() for value in m.false)


def _counted(pairs):
    named = [f"dof {dof}: {value:.4g} Hz" for dof, value in pairs]
    return "; ".join(f"{name} x{named.count(name)}" for name in dict.fromkeys(sorted(named))) or "none"


def score_run(identified, truth):
    """Matches by dof of one identification."""
    return {dof: match(identified[dof], values) for dof, values in truth.items()}


def print_table(header, rows, markdown):
    """Columns right-aligned but the first."""
    cells = [[str(cell) for cell in row] for row in (header, *rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(header))]
    if markdown:
        lines = ["| " + " | ".join(row) + " |" for row in cells]
        lines.insert(1, "|---|" + "---:|" * (len(header) - 1))
    else:
        lines = [
            "  ".join(
                [row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))]
            )
            for row in cells
        ]
        lines.insert(1, "-" * len(lines[0]))
    print("\n".join(lines), flush=True)


def add_options(parser, first_seed, seeds):
    """Options that all studies have."""
    parser.add_argument("--first-seed", type=int, default=first_seed)
    parser.add_argument("--seeds", type=int, default=seeds, help="records of each configuration")
    parser.add_argument(
        "--jobs", type=int, default=MOST_JOBS, choices=range(1, MOST_JOBS + 1), help="worker processes"
    )
    parser.add_argument("--markdown", action="store_true", help="tables as Markdown")
