"""1,000 pencils that are hard on eigensolvers, against exact roots: ``python -m benchmarks.torture``.

Numbers before the kinds choose the seeds: ``40 100 penalties`` are seeds 40 to 99 of that kind.

A root counts as right within the bound stated for it; the table says how many are told to be uncertain
instead.
"""

from __future__ import annotations

import sys
import time
from collections import Counter

from reference.torture import KINDS, OF_EACH, torture
from reference.torture_verdict import verdict


def main(seeds: range, kinds: list[str]) -> int:
    """One line a kind; the number of wrong statements."""
    total: Counter[str] = Counter()
    print(f"{'kind':22} pencils refused  roots uncertain wrong  largest bound  of its bound  slowest s")
    for kind in kinds:
        judged = [(seed, verdict(torture(kind, seed))) for seed in seeds]
        line = Counter(
            pencils=len(judged),
            refused=sum(bool(v.refused) for _, v in judged),
            certain=sum(v.certain for _, v in judged),
            uncertain=sum(v.uncertain for _, v in judged),
            wrong=sum(bool(v.wrong) for _, v in judged),
        )
        total += line
        worst = {
            name: max(getattr(v, name) for _, v in judged)
            for name in ("largest_bound", "largest_part", "seconds")
        }
        print(
            f"{kind:22} {line['pencils']:7} {line['refused']:7} {line['certain']:6} {line['uncertain']:9} "
            f"{line['wrong']:5}  {worst['largest_bound']:13.1e} {worst['largest_part']:13.2g}"
            f"{'':4}{worst['seconds']:7.2f}"
        )
        for seed, v in judged:
            for text in v.wrong[:3]:
                print(f"    seed {seed}: {text}")
    print(dict(total))
    return total["wrong"]


if __name__ == "__main__":
    started = time.perf_counter()
    numbers = [int(argument) for argument in sys.argv[1:] if argument.isdigit()] or [OF_EACH]
    named = [argument for argument in sys.argv[1:] if not argument.isdigit()]
    wrong = main(range(*numbers), named or list(KINDS))
    print(f"{time.perf_counter() - started:.0f} s")
    sys.exit(bool(wrong))
