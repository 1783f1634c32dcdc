"""``antires series``."""

from __future__ import annotations

import argparse
import sys

from ..jobs import read_job
from ..support.validation import reject
from .terminal import print_json, say

__all__ = ["series"]


def series(args: argparse.Namespace) -> int:
    """Carry out a job of many tests."""
    from ..jobs.series import run_series

    job = read_job(args.job)
    if job.task != "series":
        got = f"{str(args.job)!r}, a job for 'antires {job.task}'"
        reject("JOB", got, "a job with [series]", "'antires init --task series' writes one.")
    outcome = run_series(job, workers=args.workers, say=say)
    if args.json:
        print_json(outcome.summary)
    else:
        print(outcome.series)
        print(f"\nIn {outcome.folder}: {', '.join(sorted(path.name for path in outcome.folder.iterdir()))}")
    for note in outcome.notes:
        print(f"antires: warning: {note}", file=sys.stderr)
    if outcome.series.interrupted:
        print(f"antires: interrupted; go on with: antires series {args.job}", file=sys.stderr)
        return 130
    failed = outcome.series.failed
    if failed and len(failed) == len(outcome.series):
        first = next(iter(failed.values()))
        said = f"antires: no test could be identified; of the first: {first}"
        print(said, file=sys.stderr)
        return 1
    return 0
