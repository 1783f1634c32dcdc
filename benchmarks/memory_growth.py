"""Memory of 1,000 evaluations of an objective with 10^4 dofs: flat, and what it is.

Resident memory is printed every hundred evaluations, each at parameters of its own. Run
``python -m benchmarks.memory_growth``; ``--evaluations 100`` for a short one.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import antires_rs as ar
from reference.meshes import MESHES, frame

N_PARAMETERS, N_RESPONSES, N_MODES = 10, 3, 6


def resident_mb() -> float:
    """Resident memory of this process, where the system tells it."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS"):
            return float(line.split()[1]) / 1024.0
    return float("nan")


def problem(size: int) -> ar.UpdatingProblem:
    """Ten groups of beams of a tower, three responses."""
    model = frame(MESHES["tower"](size))
    groups = np.array_split(np.arange(len(model.elements)), N_PARAMETERS)
    unknowns = [ar.Parameter("stiffness_factor", tuple(group.tolist()), (0.7, 1.3)) for group in groups]
    dofs = [int(dof) for dof in np.linspace(0, model.n_dof - 1, N_RESPONSES).astype(int)]
    limit_hz = float(model.modes(N_MODES).freq_hz[-1])
    found = model.antiresonances(dofs, dofs[-1], f_max_hz=limit_hz)
    measured = ar.AntiresonanceSet(dofs[-1], dict(zip(dofs, found, strict=True)), sees="frf")
    return ar.UpdatingProblem(model, unknowns, measured)


def main() -> None:
    """The lines."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--evaluations", type=int, default=1000)
    parser.add_argument("--dofs", type=int, default=10_000)
    chosen = parser.parse_args()
    before = resident_mb()
    asked = problem(chosen.dofs)
    rng = np.random.default_rng(0)
    x = rng.uniform(*asked.bounds.T, (chosen.evaluations, N_PARAMETERS))
    print(f"{asked.model.n_dof} dofs, {asked.measured_hz.size} values; {before:.0f} MB before the model")
    step, start = max(chosen.evaluations // 10, 1), time.process_time()
    for nth, row in enumerate(x, 1):
        asked.cost(row)
        if nth in (1, 10) or nth % step == 0:
            seconds = time.process_time() - start
            print(f"after {nth:5d}: {resident_mb():7.1f} MB, {1e3 * seconds / nth:.0f} ms each", flush=True)


if __name__ == "__main__":
    main()
