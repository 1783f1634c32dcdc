"""Large sparse models: building them, and antiresonances of 16 responses with 30 modes in band.

Rivals (``benchmarks.large_rivals``), each from the same matrices and in one run, CPU seconds on one thread:

- *eigsh*: shift-invert Lanczos with SuperLU for 30 modes and half as many more, one flexibility residual,
  roots by scan and bisection of the truncated series;
- *Lanczos*: one factor of K + sigma M by SuperLU, a Krylov space of the load in the inner product of M to
  convergence below the limit, partial fractions, roots by scan and bisection;
- the same two with factors by CHOLMOD, where cvxopt is installed.

With ``--check`` every root is bounded on the matrices, and those of four pairs are compared with
shift-invert on the deleted pencils; ``--lumped``
lumps the masses, rotations without mass. *memory* is what a process with our part alone grows by, over the
bytes of SuperLU's factors; ``--plot FILE`` draws the growth with the number of dofs. The ``block`` is a solid
by scikit-fem. Run ``python -m benchmarks.large_models tower --sizes 1000``.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: one core is what is measured

import argparse
import gc
import importlib.util
import multiprocessing
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse.linalg as sla

import antires_rs as ar
from benchmarks.large_rivals import N_MODES, by_eigsh, by_lanczos, cholmod, definite, superlu
from reference.meshes import MESHES, frame, lumped
from reference.solid_meshes import block

N_RESPONSES = 16
#: Shift of the modes that tell the limit, (rad/s)2: below the lowest, and not far.
SHIFT = 1.0
#: Dofs above which the limit comes from modes by CHOLMOD: SuperLU takes long.
MOST_SUPERLU = 200_000
RIVALS = {"eigsh": (by_eigsh, None), "Lanczos": (by_lanczos, superlu)}
if importlib.util.find_spec("cvxopt"):
    RIVALS |= {"eigsh, CHOLMOD": (by_eigsh, cholmod), "Lanczos, CHOLMOD": (by_lanczos, cholmod)}
NAMES = ["ours", *RIVALS]


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """What ``work`` returns, and the CPU seconds that it took."""
    start = time.process_time()
    return work(), time.process_time() - start


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


def matrices(kind: str, n_dof: int, *, is_lumped: bool) -> tuple[Any, Any, float]:
    """Stiffness and mass of a mesh, and the CPU seconds of its ``FrameModel`` (none for the block)."""
    if kind == "block":
        k, m = block(n_dof)
        return k, m, float("nan")
    mesh = MESHES[kind](n_dof)
    model, built = timed(lambda: frame(mesh))
    k, m = model.stiffness().tocsc(), model.mass().tocsc()
    return k, lumped(m) if is_lumped else m, built


def sensors(n: int, directions: int) -> tuple[list[int], int]:
    """Responses in translations of nodes drawn at random, and the force at one of them."""
    rng = np.random.default_rng(0)
    nodes = rng.choice(n // directions, N_RESPONSES, replace=False)
    dofs = sorted((directions * nodes + rng.integers(0, 3, N_RESPONSES)).tolist())
    return dofs, dofs[5]


def memory_bytes(which: str) -> int:
    """Resident memory of this process: ``VmRSS`` now, ``VmHWM`` its peak (Linux)."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * int(next(line for line in lines if line.startswith(which)).split()[1])


def growth(k: Any, m: Any, dofs: list[int], force: int, f_max_hz: float) -> int:
    """Bytes by which this process grows at most with our part: the model and its antiresonances."""
    gc.collect()
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    before = memory_bytes("VmRSS")
    ar.MatrixModel(k, m).antiresonances(dofs, force, f_max_hz=f_max_hz)
    return memory_bytes("VmHWM") - before


def study(kind: str, n_dof: int, given: argparse.Namespace) -> dict[str, Any]:
    """One line of the table."""
    k, m, built = matrices(kind, n_dof, is_lumped=given.lumped)
    model, from_matrices = timed(lambda: ar.MatrixModel(k, m))
    whole = definite(m)
    quicker = cholmod if importlib.util.find_spec("cvxopt") and k.shape[0] > MOST_SUPERLU else superlu
    solve, factor_bytes = quicker(k + SHIFT * whole)
    inverse = sla.LinearOperator(k.shape, matvec=solve, dtype=float)
    lam = sla.eigsh(k, given.modes, whole, sigma=-SHIFT, OPinv=inverse, return_eigenvectors=False)
    del solve, inverse
    limit = 1.002 * lam.max()
    f_max_hz = float(np.sqrt(limit) / (2 * np.pi))
    dofs, force = sensors(model.n_dof, 3 if kind == "block" else 6)
    zeros, cpu_s = timed(lambda: model.antiresonances(dofs, force, f_max_hz=f_max_hz))
    ours, seconds, roots = [(2 * np.pi * hz) ** 2 for hz in zeros], [cpu_s], {}
    for name, (rival, factors) in RIVALS.items():
        if name in given.without:
            seconds.append(float("nan"))
            continue
        roots[name], cpu_s = timed(lambda: rival(k, whole, dofs, force, limit, factors))  # noqa: B023
        seconds.append(cpu_s)
    apart = {
        name: tuple(sum(np.array(missed(a, b)) for a, b in zip(theirs, ours, strict=True)).tolist())
        for name, theirs in roots.items()
        if "CHOLMOD" not in name
    }
    with multiprocessing.get_context("spawn").Pool(1) as alone:
        memory = alone.apply(growth, (k, m, dofs, force, f_max_hz))
    print(
        f"{kind:9s}{model.n_dof:8d}{built:8.2f}{from_matrices:8.2f}"
        + "".join(f"{cpu_s:9.3f}" for cpu_s in seconds)
        + f"{sum(map(len, ours)):7d}  {apart}  {memory / 2**20:.0f} MB"
        + (f", {memory / factor_bytes:.1f}" if factor_bytes else ""),
        flush=True,
    )
    if given.check:
        bounded = model.antiresonances(dofs, force, f_max_hz=f_max_hz, bounds=True)
        parts = np.concatenate([error_hz / freq_hz for freq_hz, error_hz in bounded])
        sure = np.isfinite(parts)
        print(f"{'':9s}largest bound {parts[sure].max():.0e} of a frequency, {(~sure).sum()} not certain")
        pairs = [missed(ours[q], deleted(k, whole, dofs[q], force, limit)) for q in range(0, N_RESPONSES, 4)]
        print(f"{'':9s}against the deleted pencils, four pairs (missed, invented): {pairs}", flush=True)
    return {"kind": kind, "n_dof": model.n_dof, "seconds": seconds}


def plot(rows: list[dict[str, Any]], file: str) -> None:
    """Seconds over dofs, one panel for each kind of mesh."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    kinds = list(dict.fromkeys(row["kind"] for row in rows))
    figure, axes = plt.subplots(
        1, len(kinds), figsize=(3.2 * len(kinds), 3.4), sharey=True, squeeze=False, layout="constrained"
    )
    greys = dict(zip(NAMES, ["0.0", "0.55", "0.3", "0.75", "0.45"], strict=False))
    styles = dict(zip(NAMES, ["-o", "--s", ":^", "--d", ":v"], strict=False))
    for ax, kind in zip(axes[0], kinds, strict=True):
        own = [row for row in rows if row["kind"] == kind]
        for nth, name in enumerate(NAMES):
            seconds = [row["seconds"][nth] for row in own]
            ax.loglog(
                [row["n_dof"] for row in own], seconds, styles[name], color=greys[name], label=name, ms=4
            )
        ax.set(title=kind, xlabel="degrees of freedom")
    axes[0, 0].set_ylabel(f"CPU time of {N_RESPONSES} responses, s")
    axes[0, 0].legend(fontsize=8)
    figure.savefig(file, dpi=130)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", default=list(MESHES))
    parser.add_argument("--sizes", type=int, nargs="+", default=[300, 1000, 2000, 5000, 10000])
    parser.add_argument("--modes", type=int, default=N_MODES, help="modes in band")
    parser.add_argument("--lumped", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--without", nargs="*", default=[], choices=list(RIVALS), help="rivals left out")
    parser.add_argument("--plot", metavar="FILE")
    given = parser.parse_args()
    columns = "".join(f"  {name}" for name in NAMES)
    print(f"mesh         dofs   frame  matrix{columns}  roots  missed, invented by them  memory", flush=True)
    rows = [study(kind, n_dof, given) for kind in given.kinds for n_dof in given.sizes]
    if given.plot:
        plot(rows, given.plot)


if __name__ == "__main__":
    main()
