"""Large sparse models: building them, and antiresonances of 16 responses with 30 modes in band.

Rivals, each from the same matrices and in one run, CPU seconds on one thread:

- *eigsh*: shift-invert Lanczos with SuperLU for 30 modes and half as many more, one flexibility residual,
  roots by scan and bisection of the truncated series;
- *Lanczos*: one SuperLU factor of K + sigma M, a Krylov space of the load in the inner product of M to
  convergence below the limit, partial fractions, roots by scan and bisection.

With ``--check`` the roots of four pairs are compared with shift-invert on the deleted pencils; ``--lumped``
lumps the masses, rotations without mass. Run ``python -m benchmarks.large_models tower --sizes 1000``.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla

import antires_rs as ar
from reference.meshes import MESHES, frame, lumped

N_MODES, N_RESPONSES, SCAN = 30, 16, 40


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """What ``work`` returns, and the CPU seconds that it took."""
    start = time.process_time()
    return work(), time.process_time() - start


def definite(mass: Any) -> Any:
    """The mass with 1e-9 where it has none, for rivals that need one."""
    return (mass + sp.diags_array(np.where(mass.diagonal() == 0.0, 1e-9, 0.0))).tocsc()


def bisected(value: Callable[[Any], Any], poles: Any, limit: float) -> Any:
    """Roots of ``value`` in (0, limit): a scan of each gap between poles, then bisection."""
    ends = np.concatenate([[0.0], np.sort(poles[(poles > 0) & (poles < limit)]), [limit]])
    share = 0.5 - 0.5 * np.cos(np.linspace(0.01, np.pi - 0.01, SCAN))
    x = (ends[:-1, None] + np.diff(ends)[:, None] * share).ravel()
    sign = np.sign(value(x))
    at = np.flatnonzero((sign[1:] != sign[:-1]) & (np.arange(1, x.size) % SCAN != 0))
    low, high, left = x[at], x[at + 1], sign[at]
    for _ in range(55):
        middle = 0.5 * (low + high)
        same = np.sign(value(middle)) == left
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)


def by_eigsh(k: Any, m: Any, dofs: list[int], force: int, limit: float) -> list[Any]:
    """Roots from modes by shift-invert and one flexibility residual."""
    sigma = 0.1 * limit
    lu = sla.splu((k + sigma * m).tocsc())
    inverse = sla.LinearOperator(k.shape, matvec=lu.solve)
    most = N_MODES + N_MODES // 2
    lam, phi = sla.eigsh(k, most, m, sigma=-sigma, OPinv=inverse)
    load = np.zeros(k.shape[0])
    load[force] = 1.0
    rest = lu.solve(load) - phi @ (phi[force] / (lam + sigma))

    def receptance(dof: int) -> Callable[[Any], Any]:
        return lambda x: (phi[dof] * phi[force]) @ (1.0 / (lam[:, None] - x)) + rest[dof]

    return [bisected(receptance(dof), lam, limit) for dof in dofs]


def by_lanczos(k: Any, m: Any, dofs: list[int], force: int, limit: float) -> list[Any]:
    """Roots from the Krylov space of the load."""
    sigma = 0.1 * limit
    lu = sla.splu((k + sigma * m).tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    load = np.zeros(k.shape[0])
    load[force] = 1.0
    w, alpha, beta = lu.solve(load), [], []
    q, mq = np.empty((400, w.size)), np.empty((400, w.size))
    norm = np.sqrt(w @ (m @ w))
    s, first, n = 1.02 * limit + sigma, norm, 0
    while True:
        q[n] = w / norm
        mq[n] = m @ q[n]
        w = lu.solve(mq[n])
        n += 1
        for _ in range(2):
            part = mq[:n] @ w
            w -= part @ q[:n]
            alpha += [part[-1]] if len(alpha) < n else []
        norm = np.sqrt(w @ (m @ w))
        if n % 10 == 0:
            t = np.diag(alpha) + np.diag(beta, 1) + np.diag(beta, -1)
            last = np.linalg.solve(np.eye(n) - s * t, np.eye(n)[0])[-1]
            if abs(s * norm * last) < 1e-13 or n == len(q):
                break
        beta.append(norm)
    theta, y = np.linalg.eigh(t)
    rows, strength, poles = q[:n, dofs].T @ y, first * y[0], 1.0 / theta - sigma

    def receptance(row: Any) -> Callable[[Any], Any]:
        return lambda x: (row * strength) @ (1.0 / (1.0 - theta[:, None] * (x + sigma)))

    return [bisected(receptance(row), poles, limit) for row in rows]


def deleted(k: Any, m: Any, i: int, j: int, limit: float) -> Any:
    """Roots by shift-invert on the pencil without row i and column j."""
    n = k.shape[0]
    rows, columns = np.delete(np.arange(n), i), np.delete(np.arange(n), j)
    k, m = k[rows][:, columns].tocsc(), m[rows][:, columns].tocsc()
    lu = sla.splu((k - 0.41 * limit * m).tocsc())
    inverse = sla.LinearOperator(k.shape, matvec=lambda v: lu.solve(m @ v))
    mu = sla.eigs(inverse, 2 * N_MODES, which="LM", return_eigenvectors=False, tol=1e-11)
    x = 0.41 * limit + 1.0 / mu
    x = np.sort(x[abs(x.imag) < 1e-7 * abs(x)].real)
    return x[(x > 1e-6 * limit) & (x <= limit)]


def missed(found: Any, wanted: Any) -> tuple[int, int]:
    """How many of the wanted roots were not found to 1e-6 in x, and how many found ones are not wanted."""
    near = lambda a, b: sum(not np.any(abs(b - x) <= 1e-6 * x) for x in a)  # noqa: E731
    return near(wanted, found), near(found, wanted)


def study(kind: str, n_dof: int, *, is_lumped: bool, check: bool) -> None:
    """One line of the table."""
    mesh = MESHES[kind](n_dof)
    model, built = timed(lambda: frame(mesh))
    k, m = model.stiffness().tocsc(), model.mass().tocsc()
    m = lumped(m) if is_lumped else m
    model, from_matrices = timed(lambda: ar.MatrixModel(k, m))
    whole = definite(m)
    lam = sla.eigsh(k, N_MODES, whole, sigma=-1.0, return_eigenvectors=False)
    limit = 1.002 * lam.max()
    f_max_hz = np.sqrt(limit) / (2 * np.pi)
    rng = np.random.default_rng(0)
    nodes = rng.choice(model.n_dof // 6, N_RESPONSES, replace=False)
    dofs = sorted((6 * nodes + rng.integers(0, 3, N_RESPONSES)).tolist())
    force = dofs[5]
    ours, seconds = timed(lambda: model.antiresonances(dofs, force, f_max_hz=f_max_hz))
    ours = [(2 * np.pi * hz) ** 2 for hz in ours]
    eigsh, by_modes = timed(lambda: by_eigsh(k, whole, dofs, force, limit))
    lanczos, by_space = timed(lambda: by_lanczos(k, whole, dofs, force, limit))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    apart = [
        sum(np.array(missed(a, b)) for a, b in zip(other, ours, strict=True)) for other in (eigsh, lanczos)
    ]
    print(
        f"{kind:9s}{model.n_dof:8d}{built:8.2f}{from_matrices:8.2f}{seconds:9.3f}{by_modes:9.2f}{by_space:9.3f}"
        f"{sum(map(len, ours)):7d}  {apart[0]} {apart[1]}  {memory:.2f} GB",
        flush=True,
    )
    if check:
        pairs = [missed(ours[q], deleted(k, whole, dofs[q], force, limit)) for q in range(0, N_RESPONSES, 4)]
        print(f"{'':9s}against the deleted pencils, four pairs (missed, invented): {pairs}", flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", default=list(MESHES))
    parser.add_argument("--sizes", type=int, nargs="+", default=[300, 1000, 2000, 5000, 10000])
    parser.add_argument("--lumped", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    print(
        "mesh         dofs   frame  matrix     ours    eigsh  Lanczos  roots  missed, invented by both  peak"
    )
    for kind in given.kinds:
        for n_dof in given.sizes:
            study(kind, n_dof, is_lumped=given.lumped, check=given.check)


if __name__ == "__main__":
    main()
