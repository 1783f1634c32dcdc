"""Lumped masses, rotations without mass, against consistent ones: grillages and space frames.

All pairs of 6 x 6 dofs, each force with its six responses in one call, up to the frequency that 20 modes lie
below; CPU seconds on one thread, the best of three. The roots are compared with those of the same matrices
with 1e-9 of rotary mass. Run
``python -m benchmarks.lumped_masses``; ``--sizes 300 1000`` for fewer.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
import scipy.sparse as sp

import antires_rs as ar
from reference.meshes import MESHES, frame, lumped

N_MODES, N_PAIRS = 20, 6
SIZES = (300, 1000, 2000, 5000)


def roots_of(model: ar.MatrixModel, dofs: list[int], forces: list[int], limit_hz: float) -> list[Any]:
    """Roots of all responses to some forces."""
    return [zeros for force in forces for zeros in model.antiresonances(dofs, force, f_max_hz=limit_hz)]


def all_pairs(model: ar.MatrixModel, dofs: list[int], limit_hz: float) -> tuple[list[Any], float]:
    """Roots of all pairs, and the least CPU seconds of three times."""
    best = np.inf
    for _ in range(3):
        start = time.process_time()
        found = roots_of(model, dofs, dofs, limit_hz)
        best = min(best, time.process_time() - start)
    return found, best


def apart(one: list[Any], other: list[Any]) -> str:
    """Largest relative difference of two lists of roots, or where their numbers differ."""
    odd = [nth for nth, (a, b) in enumerate(zip(one, other, strict=True)) if a.size != b.size]
    if odd:
        return f"{len(odd)} pairs differ in number, the first {odd[0]}"
    return f"{max(np.abs(a / b - 1.0).max(initial=0.0) for a, b in zip(one, other, strict=True)):.0e}"


def compared(mesh: str, size: int) -> None:
    """One line of the table."""
    whole = frame(MESHES[mesh](size))
    stiffness, consistent = whole.stiffness(), whole.mass()
    mass = lumped(consistent)
    rotary = mass + sp.diags_array(np.where(mass.diagonal() == 0.0, 1e-9, 0.0))
    models = [ar.MatrixModel(stiffness, m) for m in (consistent, mass, rotary)]
    moving = np.flatnonzero(mass.diagonal() > 0.0)
    dofs = [int(dof) for dof in moving[np.linspace(0, moving.size - 1, N_PAIRS).astype(int)]]
    limit_hz = float(models[0].modes(N_MODES).freq_hz[-1]) * 1.01
    found, seconds = zip(*(all_pairs(model, dofs, limit_hz) for model in models[:2]), strict=True)
    try:
        away = apart(found[1], roots_of(models[2], dofs, dofs, limit_hz))
    except ar.NumericalError:
        away = "not settled with rotary mass"
    roots = sum(zeros.size for zeros in found[1])
    print(
        f"{mesh:9s} {whole.n_dof:6d} {mass.shape[0] - moving.size:6d} {roots:6d}"
        f" {seconds[0]:11.3f} {seconds[1]:7.3f} {seconds[1] / seconds[0]:6.2f}   {away}",
        flush=True,
    )


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="*", default=["grillage", "tower"])
    parser.add_argument("--sizes", nargs="+", type=int, default=SIZES)
    chosen = parser.parse_args()
    print("mesh        dofs massless  roots  consistent  lumped  ratio   from rotary mass")
    for mesh in chosen.meshes:
        for size in chosen.sizes:
            compared(mesh, size)


if __name__ == "__main__":
    main()
