"""Rivals of ``benchmarks.large_models``: what a user of SciPy writes in some lines, on factors by choice.

*SuperLU* is SciPy's; *CHOLMOD* is that of SuiteSparse, supernodal, by cvxopt (a package for the
benchmark only: its licence is the GPL). Both are ordered by minimum degree.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla

N_MODES, SCAN = 30, 40


def superlu(a: Any) -> tuple[Callable[[Any], Any], int]:
    """Solution with A, and bytes of its factors."""
    lu = sla.splu(a.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return lu.solve, 12 * lu.L.nnz


def cholmod(a: Any) -> tuple[Callable[[Any], Any], int]:
    """The same by CHOLMOD."""
    import cvxopt
    import cvxopt.cholmod

    low = sp.tril(a).tocoo()
    matrix = cvxopt.spmatrix(low.data, low.row.astype(int), low.col.astype(int), a.shape)
    factor = cvxopt.cholmod.symbolic(matrix)
    cvxopt.cholmod.numeric(matrix, factor)

    def solve(v: Any) -> Any:
        x = cvxopt.matrix(np.asarray(v, dtype=float))
        cvxopt.cholmod.solve(factor, x)
        return np.array(x).ravel()

    return solve, 0


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


def by_eigsh(k: Any, m: Any, dofs: list[int], force: int, limit: float, factors: Any = None) -> list[Any]:
    """Roots from modes by shift-invert and one flexibility residual.

    Without ``factors`` those that SciPy's ``eigsh`` takes itself.
    """
    sigma = 0.1 * limit
    shifted = (k + sigma * m).tocsc()
    solve = sla.splu(shifted).solve if factors is None else factors(shifted)[0]
    inverse = sla.LinearOperator(k.shape, matvec=solve, dtype=float)
    most = N_MODES + N_MODES // 2
    lam, phi = sla.eigsh(k, most, m, sigma=-sigma, OPinv=inverse)
    load = np.zeros(k.shape[0])
    load[force] = 1.0
    rest = solve(load) - phi @ (phi[force] / (lam + sigma))

    def receptance(dof: int) -> Callable[[Any], Any]:
        return lambda x: (phi[dof] * phi[force]) @ (1.0 / (lam[:, None] - x)) + rest[dof]

    return [bisected(receptance(dof), lam, limit) for dof in dofs]


def by_lanczos(k: Any, m: Any, dofs: list[int], force: int, limit: float, factors: Any = None) -> list[Any]:
    """Roots from the Krylov space of the load."""
    sigma = 0.1 * limit
    solve, _ = (factors or superlu)(k + sigma * m)
    load = np.zeros(k.shape[0])
    load[force] = 1.0
    w, alpha, beta = solve(load), [], []
    q, mq = np.empty((400, w.size)), np.empty((400, w.size))
    norm = np.sqrt(w @ (m @ w))
    s, first, n = 1.02 * limit + sigma, norm, 0
    while True:
        q[n] = w / norm
        mq[n] = m @ q[n]
        w = solve(mq[n])
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
