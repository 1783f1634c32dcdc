"""Files of every format cut at random bytes: how many cuts are noticed.

For each format 300 cuts at distinct random places inside records, and as many on boundaries between records
(all, where there are fewer). An error is the rule; "warned" is a result with a warning, "whole" a result
equal to that of the whole file (a last line end was lost); "silent" is what must not be, except on a
boundary of a format that does not state its size. Formats with ``partial=True`` are read that way too. A
crash of the process ends the table.

Run: ``python -m benchmarks.truncated_files [--cuts 300] [--seed 0] [NAME ...]``; half a minute.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from reference import truncation

OUTCOMES = ("error", "warning", "whole", "silence")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="formats, all by default")
    parser.add_argument("--cuts", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print("| format | cut | cuts | error | warned | whole | silent |")
    print("|---|---|---|---|---|---|---|")
    failed = []
    for name in options.names or truncation.FORMATS:
        with tempfile.TemporaryDirectory() as folder:
            counts, bad = truncation.judged(name, Path(folder), options.cuts, options.seed)
        failed += [(name, *each) for each in bad]
        for where in ("inside", "inside, partial", "boundary", "boundary, partial"):
            row = [counts[where, outcome] for outcome in OUTCOMES]
            if sum(row):
                print(f"| {name} | {where} | {sum(row)} | " + " | ".join(map(str, row)) + " |", flush=True)
    print(f"\nunnoticed where they should not be: {len(failed)} {failed[:5] or ''}")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
