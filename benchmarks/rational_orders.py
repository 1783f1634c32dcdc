"""How exactly the rational fit recovers exact data, by order: the numerics without a measurement.

Three curves with common poles, 0.1 to 5 % damped, and zeros of their own, in pole-zero form (so that poles
and zeros are known to the last digit), sampled without noise and fitted by ``fit_rational`` at the true
order. Then the stabilization diagram of the same data, which does not know the order: all poles found, none
false?

    python -m benchmarks.rational_orders [--draws 5] [--orders 10 20 30 40 50 60] [--sweep-draws 2]
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from reference.rational_curves import FAMILIES, fit_errors, sweep_counts

ORDERS = (10, 20, 30, 40, 50, 60)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=5)
    parser.add_argument("--orders", type=int, nargs="+", default=list(ORDERS))
    parser.add_argument("--sweep-draws", type=int, default=2)
    options = parser.parse_args()
    print(
        f"fit at the true order; worst of {options.draws} draws: relative error of a pole / of a zero / "
        "residual"
    )
    print("order  " + "  ".join(f"{name:>24s}" for name in FAMILIES))
    for order in options.orders:
        cells = []
        for family in FAMILIES:
            worst = np.max([fit_errors(family, order, seed) for seed in range(options.draws)], axis=0)
            cells.append(" / ".join(f"{e:.0e}" for e in worst))
        print(f"{order:5d}  " + "  ".join(f"{cell:>24s}" for cell in cells), flush=True)
    print(
        f"\nstabilization, orders up to the true one plus 24; sums of {options.sweep_draws} draws: "
        "found of true, false"
    )
    print("order  " + "  ".join(f"{name:>24s}" for name in FAMILIES) + "  seconds a sweep")
    for order in options.orders:
        cells, start = [], time.process_time()
        for family in FAMILIES:
            true, found, false = np.sum(
                [sweep_counts(family, order, seed, order + 24) for seed in range(options.sweep_draws)], axis=0
            )
            cells.append(f"{found} of {true}, {false} false")
        seconds = (time.process_time() - start) / (len(FAMILIES) * options.sweep_draws)
        print(f"{order:5d}  " + "  ".join(f"{cell:>24s}" for cell in cells) + f"  {seconds:8.2f}", flush=True)


if __name__ == "__main__":
    main()
