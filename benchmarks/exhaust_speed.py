"""Speed of one objective value of the exhaust, one core, against SciPy on the pencils, same run.

Run:  python -m benchmarks.exhaust_speed
The damage problem of the exhaust: 144 dofs, 16 responses, 30 elements, the exact antiresonances up to 260 Hz
with element 30 at 75 % as measurement. Values are compared before times are. The rivals solve the same J:
SciPy's QZ on each deleted pencil, and numpy's eigh once for all responses with the roots between the poles by
scan and bisection, vectorised. Candidates are of the kind a search meets: a few damaged elements.
"""

# ruff: noqa: E402  (the number of BLAS threads is read once, when numpy is imported)
import os

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import warnings

import numpy as np
import scipy.linalg

import antires_rs as ar
from benchmarks.objective_speed import misfit, real_hz, seconds


def by_pencil(pairs, measured, limit_hz, excitation):
    """Misfit by scipy.linalg.eigvals on each deleted pencil."""
    total = 0.0
    for dof, freq in measured.items():
        pencil = [np.delete(np.delete(a, dof, 0), excitation, 1) for a in pairs]
        total += misfit(real_hz(scipy.linalg.eigvals(*pencil), limit_hz), freq)
    return total


def by_eigh(pairs, measured, limit_hz, excitation):
    """Misfit by one eigh, sign changes on 200 points between poles, and bisection of all at once."""
    lam, phi = scipy.linalg.eigh(*pairs)
    top = (2 * np.pi * limit_hz) ** 2
    ends = np.concatenate([[1e-3], lam[(lam > 1.0) & (lam < top)], [top]])
    share = np.linspace(1e-9, 1.0 - 1e-9, 200)
    grid = (ends[:-1, None] + np.diff(ends)[:, None] * share).ravel()
    inverse = 1.0 / (lam - grid[:, None])
    total = 0.0
    for dof, freq in measured.items():
        residue = phi[dof] * phi[excitation]
        positive = (inverse * residue).sum(axis=1) > 0
        change = np.flatnonzero(positive[1:] != positive[:-1])
        # Between the last point of a cell and the first of the next lies a pole, not a root.
        change = change[(change + 1) % share.size != 0]
        low, high, at_low = grid[change], grid[change + 1], positive[change]
        for _ in range(50):
            middle = 0.5 * (low + high)
            same = ((residue / (lam - middle[:, None])).sum(axis=1) > 0) == at_low
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        total += misfit(np.sqrt(low) / (2 * np.pi), freq)
    return total


def candidates(count, n):
    """Severities (count, n), three elements damaged in each."""
    rng = np.random.default_rng(0)
    rows = np.zeros((count, n))
    for row in rows:
        row[rng.choice(n, 3, replace=False)] = rng.uniform(0.05, 0.9, 3)
    return rows


def main():
    warnings.simplefilter("ignore")
    case = ar.cases.exhaust()
    problem = case.search_problem(case.cracked_element, 0.75)
    measured = dict(problem.measured[0].items())
    limit_hz, excitation = 1.5 * problem.measured_hz.max(), case.excitation
    modes = case.model.modes().freq_hz
    print(
        f"{case.model.n_dof} dofs, {len(measured)} responses, {problem.measured_hz.size} antiresonances, "
        f"{np.sum(modes < limit_hz)} modes to {limit_hz:.0f} Hz"
    )
    betas = candidates(200, len(problem.bounds))

    def pairs(beta):
        model = problem.model_at(beta)
        return model.stiffness().toarray(), model.mass().toarray()

    def misfits(rows, by):
        return np.array([by(pairs(row), measured, limit_hz, excitation) for row in rows])

    penalty = 0.1 * betas.sum(axis=1) + 0.1 * (betas > 0).sum(axis=1)
    ours = problem.evaluate_many(betas, workers=1) - penalty
    few = betas[:3]
    print(
        f"J, largest difference from ours over {len(few)}: "
        f"scipy {np.abs(misfits(few, by_pencil) - ours[:3]).max():.1e}, "
        f"numpy {np.abs(misfits(few, by_eigh) - ours[:3]).max():.1e}"
    )
    formed = [pairs(row) for row in few]
    core = seconds(lambda: problem.evaluate_many(betas, workers=1), 5) / len(betas)
    eigh = seconds(lambda: [by_eigh(p, measured, limit_hz, excitation) for p in formed], 3) / len(few)
    pencil = seconds(lambda: by_pencil(formed[0], measured, limit_hz, excitation), 3)
    print(f"{'one objective value, one core':40} {'ms':>9} {'per second':>11} {'ratio':>7}")
    for name, value in (
        ("antires_rs", core),
        ("numpy eigh + secular roots", eigh),
        ("scipy.linalg.eigvals on 16 pencils", pencil),
    ):
        print(f"{name:40} {1e3 * value:9.3f} {1 / value:11.0f} {value / core:7.0f}")


if __name__ == "__main__":
    main()
