"""The eight-mass chain, many times over: identification, updating and damage, from simulated records.

Four tables, each from records that were simulated, identified and used as on a real test; nothing
exact enters but the truth they are compared with.

    python -m benchmarks.chain8_study            # all of it
    python -m benchmarks.chain8_study --quick    # two seeds of each
"""

from __future__ import annotations

import argparse

import numpy as np

import antires_rs as ar

#: A true value is found when an identified one lies within 1 % of it.
CLOSE = 0.01
DAMAGED = 4


def compare(identified, truth):
    """How many true values were found, how many are false, and the largest error of those found in %."""
    found, false, errors = 0, 0, [0.0]
    for dof, true_hz in truth.items():
        free = list(true_hz)
        for value in identified[dof]:
            nearest = min(free, key=lambda t: abs(t - value), default=None)
            if nearest is None or abs(value / nearest - 1.0) > CLOSE:
                false += 1
                continue
            free.remove(nearest)
            found += 1
            errors.append(100.0 * abs(value / nearest - 1.0))
    return found, false, max(errors)


def identified(case, record, route="transmissibility"):
    return ar.identify_antiresonances(record, excitation=case.excitation, band_hz=case.band_hz, route=route)


def identification_study(seeds):
    """Rows of (noise, seed, route, found, false, largest error in %), and the routes' disagreement."""
    case = ar.cases.chain8()
    truth = case.truth()["freq_hz"]
    rows = []
    for noise in (0.0, 0.01, 0.02):
        for seed in seeds:
            record = case.experiment(noise=noise, rng=seed)
            both = {route: identified(case, record, route) for route in ("transmissibility", "frf")}
            apart = max(
                (
                    100.0 * np.abs(a / b - 1.0).max()
                    for a, b in ((both["transmissibility"][d], both["frf"][d]) for d in truth)
                    if a.size == b.size and a.size
                ),
                default=0.0,
            )
            rows += [(noise, seed, route, *compare(found, truth), apart) for route, found in both.items()]
    return rows


def damage_study(seeds, noise):
    """Rows of (seed, J, severity of spring 4, largest severity of another spring, status)."""
    case = ar.cases.chain8()
    rows = []
    for seed in seeds:
        zeros = identified(case, case.experiment(level=1, noise=noise, rng=seed))
        result = ar.assess_damage(case.model, zeros, rng=seed)
        others = max(beta for element, beta in result.severity.items() if element != DAMAGED)
        rows.append((seed, result.fun, result.severity[DAMAGED], others, result.status, result.nfev))
    return rows


def updating_study(seeds):
    """Rows of (seed, largest difference before and after in %, status), and the last result."""
    rows, result = [], None
    for seed in seeds:
        case = ar.cases.chain8(perturbation=0.08, rng=seed)
        zeros = identified(case, case.experiment(rng=seed))
        result = ar.update(case.updating_problem(zeros), rng=seed)
        rows.append(
            (
                seed,
                result.table.largest_before_percent,
                result.table.largest_after_percent,
                result.fun,
                result.status,
                result.nfev,
            )
        )
    return rows, result


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="two seeds of each instead of five or ten")
    quick = parser.parse_args().quick
    few, many = (range(2), range(2)) if quick else (range(5), range(10))

    print("identification, 256 s at 512 Hz, 1 % damping: 28 true antiresonances")
    print(" noise  seed  route             found  false  largest error  routes apart")
    for noise, seed, route, found, false, error, apart in identification_study(few):
        print(
            f"{100 * noise:4.0f} %  {seed:4d}  {route:<16s} {found:6d} {false:6d} {error:12.3f} %"
            f" {apart:11.3f} %"
        )

    for noise in (0.0, 0.01):
        print(f"\ndamage, spring 4 at 55 %, identified antiresonances, {100 * noise:.0f} % sensor noise")
        print(" seed       J   spring 4     error  largest other  status         evaluations")
        for seed, cost, beta, others, status, nfev in damage_study(many, noise):
            print(
                f"{seed:5d}  {cost:6.3f}  {100 * beta:7.2f} %  {100 * (beta - 0.55):+6.2f} %"
                f"  {100 * others:11.3f} %  {status:<12s} {nfev:12,d}"
            )

    print("\nupdating, true masses and springs within 8 % of nominal, identified antiresonances")
    print(" seed   before    after        J  status         evaluations")
    rows, last = updating_study(few)
    for seed, before, after, cost, status, nfev in rows:
        print(f"{seed:5d}  {before:5.2f} %  {after:5.3f} %  {cost:7.4f}  {status:<12s} {nfev:12,d}")
    print(f"\nthe last of them in full\n{last.table}")


if __name__ == "__main__":
    main()
