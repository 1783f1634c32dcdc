"""Speed of one chain8 objective value, one core: the Rust core against the same J in numpy and SciPy.

Run:  python -m benchmarks.objective_speed
The three compute the same J of spring 4 at 55 % for the same random severities; values are compared
before times are. Figures are ratios of one run; absolute times depend on the machine.
"""

# ruff: noqa: E402  (the number of BLAS threads is read once, when numpy is imported)
import os

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import statistics
import time
import warnings

import numpy as np
import scipy.linalg

import antires_rs as ar

GAMMA1 = GAMMA2 = 0.1


def matrices(case, betas):
    """K (m, 8, 8) of severities (m, 7), and M."""
    k = np.zeros((len(betas), 8, 8))
    stiffness = 56.7e3 * (1.0 - betas)
    for spring in range(7):
        for a, b, sign in ((0, 0, 1), (1, 1, 1), (0, 1, -1), (1, 0, -1)):
            k[:, spring + a, spring + b] += sign * stiffness[:, spring]
    return k, case.model.mass()


def misfit(roots_hz, measured_hz):
    """Sum of abs(e) of one response, nearest pairing."""
    if len(measured_hz) == 0:
        return 0.0
    if len(roots_hz) == 0:
        return float(len(measured_hz))
    nearest = roots_hz[np.abs(roots_hz[None, :] - measured_hz[:, None]).argmin(axis=1)]
    return float(np.abs((nearest / measured_hz) ** 2 - 1.0).sum())


def real_hz(x, limit_hz):
    """Positive real roots in Hz below the limit."""
    good = np.isfinite(x) & (np.abs(x.imag) <= 1e-9 * np.abs(x)) & (x.real > 0)
    roots = np.sqrt(x.real[good]) / (2 * np.pi)
    return np.sort(roots[roots <= limit_hz])


def by_scipy(case, measured, limit_hz, beta):
    """One J by scipy.linalg.eig on each deleted pencil, as a script would do it."""
    k, m = matrices(case, beta[None])
    total = 0.0
    for dof, freq in measured.items():
        pencil = [np.delete(np.delete(a, dof, 0), 0, 1) for a in (k[0], m)]
        with np.errstate(all="ignore"):
            total += misfit(real_hz(scipy.linalg.eigvals(*pencil), limit_hz), freq)
    return total + GAMMA1 * beta.sum() + GAMMA2 * np.count_nonzero(beta > 0)


def by_numpy(case, measured, limit_hz, betas):
    """J of all rows with numpy's stacked eigvals.

    The mass of a deleted pencil is singular, so the reversed problem ``K_ik^-1 M_ik v = v / x`` is solved,
    for all candidates at once; the pairing stays a loop.
    """
    k, m = matrices(case, betas)
    total = GAMMA1 * betas.sum(axis=1) + GAMMA2 * (betas > 0).sum(axis=1)
    for dof, freq in measured.items():
        k_ik = np.delete(np.delete(k, dof, 1), 0, 2)
        m_ik = np.delete(np.delete(m, dof, 0), 0, 1)
        inverse = np.linalg.eigvals(np.linalg.solve(k_ik, np.broadcast_to(m_ik, k_ik.shape)))
        with np.errstate(all="ignore"):
            for row, mu in enumerate(inverse):
                total[row] += misfit(real_hz(1.0 / mu, limit_hz), freq)
    return total


def seconds(function, repeats):
    """Median seconds of a call."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def main():
    warnings.simplefilter("ignore")
    case = ar.cases.chain8()
    measured = dict(case.exact(1).items())
    problem = case.damage_problem()
    limit_hz = 1.5 * problem.measured_hz.max()
    betas = np.random.default_rng(0).uniform(0.01, 0.9, (2000, 7))

    ours = problem.evaluate_many(betas, workers=1)
    numpy_values = by_numpy(case, measured, limit_hz, betas[:200])
    scipy_values = np.array([by_scipy(case, measured, limit_hz, b) for b in betas[:200]])
    print(
        f"largest difference of J, 200 points: numpy {np.abs(numpy_values - ours[:200]).max():.1e}, "
        f"scipy {np.abs(scipy_values - ours[:200]).max():.1e}"
    )
    core = seconds(lambda: problem.evaluate_many(betas, workers=1), 7) / len(betas)
    stacked = seconds(lambda: by_numpy(case, measured, limit_hz, betas), 3) / len(betas)
    script = seconds(lambda: [by_scipy(case, measured, limit_hz, b) for b in betas[:200]], 5) / 200
    print(f"{'one chain8 objective value, one core':40} {'us':>9} {'ratio':>8}")
    for name, value in (
        ("antires_rs", core),
        ("numpy, stacked eigvals", stacked),
        ("scipy.linalg.eig, one pencil at a time", script),
    ):
        print(f"{name:40} {1e6 * value:9.1f} {value / core:8.1f}")


if __name__ == "__main__":
    main()
