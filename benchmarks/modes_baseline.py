"""Damage against a baseline by modes beside antiresonances, the model wrong: the same structures, both ways.

The chains of benchmarks/baseline_study.py (every mass and spring up to 1 to 10 % off; intact, or one damage
of 2 to 60 %), identified from the same records with 1 % noise at all eight masses: antiresonances of a force
at the first, and resonances with shapes from the same FRFs. Modes have no standard deviations: frequencies
count as known to 0.05 %, shapes to 0.5 % of their length, or as --std says.

    python -m benchmarks.modes_baseline                     # 30 intact, 60 damaged, ten minutes on two cores
    python -m benchmarks.modes_baseline --exact --std 2e-4 2e-3
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import warnings

import numpy as np

import antires_rs as ar
from benchmarks.baseline_study import DURATION_S, NOISE, drawn
from benchmarks.study_tools import each, print_table


def damaged(case, losses):
    """The chain with these losses."""
    return case.true_model(0).with_parameters(ar.stiffness_reduction(range(7)), losses)


def identified(case, losses, rng, std):
    """Antiresonances and modes of one record; ``std`` of ln f and of the components of shapes."""
    record = damaged(case, losses).simulate(
        excitation=0, fs_hz=512.0, duration_s=DURATION_S, damping_ratio=0.01, noise=NOISE,
        responses=list(range(8)), rng=rng,
    )  # fmt: skip
    zeros = ar.identify_antiresonances(record, excitation=0, band_hz=case.band_hz, check="off")
    modes = ar.identify_modes(record, band_hz=(10.0, 150.0))
    return {"antiresonances": zeros, "modes": _told(modes.freq_hz, modes.shapes, std)}


def disturbed(case, losses, rng, std):
    """Exact values with these errors, without a record."""
    model, (of_f, of_shape) = damaged(case, losses), std
    modes = model.modes()
    freq = modes.freq_hz[1:] * (1.0 + of_f * rng.standard_normal(7))
    shapes = modes.shapes[1:] / np.linalg.norm(modes.shapes[1:], axis=1)[:, None]
    shapes = shapes + of_shape * rng.standard_normal(shapes.shape)
    exact = dict(enumerate(model.antiresonances(range(8), 0)))
    zeros = {dof: f * (1.0 + of_f * rng.standard_normal(f.size)) for dof, f in exact.items()}
    zeros = ar.AntiresonanceSet(0, zeros, std_hz={dof: of_f * f for dof, f in zeros.items()})
    order = np.argsort(freq)
    return {"antiresonances": zeros, "modes": _told(freq[order], shapes[order], std)}


def _told(freq_hz, shapes, std):
    if std is None:
        return ar.ModalSet(freq_hz, shapes)
    return ar.ModalSet(freq_hz, shapes, std_hz=std[0] * freq_hz, std_shapes=np.full(freq_hz.size, std[1]))


def one_run(task):
    """Truth and both answers of one structure."""
    warnings.simplefilter("ignore")
    kind, seed, exact, std = task
    off, losses, rng = drawn(kind, seed)
    case = ar.cases.chain8(perturbation=off, rng=rng)
    test = disturbed if exact else identified
    before, now = (test(case, each, rng, std) for each in (np.zeros(7), losses))
    rows = []
    for name in ("antiresonances", "modes"):
        result = ar.assess_damage(case.model, now[name], baseline=before[name], workers=1)
        true = np.flatnonzero(losses).tolist()
        inside = [result.interval[e][0] <= losses[e] <= result.interval[e][1] for e in true]
        error = [abs(result.severity[e] - losses[e]) for e in true]
        rows.append(
            {
                "by": name,
                "kind": kind,
                "declared": sorted(result.damaged),
                "true": true,
                "visible": all(losses[e] >= result.detectable[e] for e in true),
                "inside": inside,
                "error": error,
                "a90": float(np.median(list(result.detectable.values()))),
                "chi_square": result.chi_square,
            }
        )
    return rows


def table(rows):
    """A line for each way."""
    lines = []
    for name in ("antiresonances", "modes"):
        own = [row for row in rows if row["by"] == name]
        intact = [row for row in own if not row["kind"]]
        seen = [row for row in own if row["kind"] and row["visible"]]
        right = [row for row in seen if row["declared"] == row["true"]]
        inside = [x for row in right for x in row["inside"]]
        error = [x for row in right for x in row["error"]]
        lines.append(
            [
                name,
                f"{sum(bool(row['declared']) for row in intact)} of {len(intact)}",
                f"{len(right)} of {len(seen)}",
                f"{100 * np.mean(inside):.0f} %" if inside else "-",
                f"{100 * np.median(error):.2f} %" if error else "-",
                f"{100 * np.median([row['a90'] for row in own]):.1f} %",
                f"{np.median([row['chi_square'] for row in own]):.2f}",
            ]
        )
    return lines


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, nargs=2, default=[30, 60])
    parser.add_argument("--first-seed", type=int, default=5000)
    parser.add_argument("--exact", action="store_true", help="exact values with errors, no records")
    parser.add_argument("--std", type=float, nargs=2, help="of ln f and of the components of shapes")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    spread = given.std or ([5e-4, 5e-3] if given.exact else None)
    tasks = [
        (kind, given.first_seed + i, given.exact, spread)
        for kind, n in enumerate(given.count)
        for i in range(n)
    ]
    found = [row for rows in each(one_run, tasks, given.workers) for row in rows]
    head = ["by", "false alarms", "right above a90", "90 % covers", "error", "a90", "chi-square"]
    print_table(head, table(found), markdown=True)
