"""Antiresonances of order r of models: none missed, slopes, time, and what updating and damage make of them.

Five measurements, each by its name:

- ``roots``: random chains, full matrices, coinciding and close eigenvalues, free structures, r = 2 and 3,
  against SciPy's QZ of the deleted pencil, cancelled roots among them;
- ``slopes``: derivatives with respect to all springs and masses against central differences (Richardson);
- ``speed``: 16 minors of order 2 of the exhaust beside its 16 responses of order 1;
- ``updating``: chain8 and a braced tower fitted to values of two unknown forces, each with some error;
- ``damage``: each spring of chain8 with 10 to 55 % less, and 100 intact tests, by an :class:`Assessor`.

Run ``python -m benchmarks.several_forces_model`` for all, or name some.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import itertools
import time
import warnings
from typing import Any

import numpy as np
from scipy.linalg import eigvals
from scipy.sparse import csr_array
from scipy.sparse.csgraph import structural_rank

import antires_rs as ar
from antires_rs.updating.targets import antiresonance_objective
from benchmarks.search_cases import tower

KINDS = ("chain", "full", "coinciding", "close", "free")
#: Relative error of a value, and the band of chain8.
STD, BAND_HZ = 5e-4, (3.0, 130.0)


def random_model(kind: str, rng: np.random.Generator) -> ar.MassSpringChain | ar.MatrixModel:
    """A chain, or a full mass matrix with eigenvalues of that kind."""
    if kind == "chain":
        n = int(rng.integers(5, 15))
        ends: dict[str, Any] = {
            f"ground_{end}_n_per_m": float(rng.choice([0.0, 1e4])) for end in ("first", "last")
        }
        return ar.MassSpringChain(rng.uniform(0.5, 2.0, n), rng.uniform(1e4, 5e4, n - 1), **ends)
    n = int(rng.integers(6, 16))
    lam = np.sort(rng.uniform(1e3, 1e6, n))
    at = int(rng.integers(0, n - 3))
    if kind == "coinciding":
        lam[at : at + int(rng.integers(2, 4))] = lam[at]
    if kind == "close":
        lam[at + 1] = lam[at] * (1.0 + 10.0 ** -rng.uniform(2, 6))
    if kind == "free":
        lam[: int(rng.integers(2, 4))] = 0.0
    turn = np.linalg.qr(rng.standard_normal((n, n)))[0]
    other = 0.3 * rng.standard_normal((n, n))
    half = np.linalg.cholesky(other @ other.T + np.eye(n))
    k, m = half @ turn @ np.diag(lam) @ turn.T @ half.T, half @ half.T
    return ar.MatrixModel(0.5 * (k + k.T), 0.5 * (m + m.T))


def dense(matrix: Any) -> Any:
    return matrix.toarray() if hasattr(matrix, "toarray") else np.asarray(matrix)


def by_qz(model: Any, responses: tuple[int, ...], forces: tuple[int, ...]) -> Any:
    """Antiresonances (Hz) by SciPy; none of a pencil that is singular by its pattern."""
    k, m = dense(model.stiffness()), dense(model.mass())
    kept = [[dof for dof in range(len(k)) if dof not in gone] for gone in (responses, forces)]
    a, b = k[np.ix_(*kept)], m[np.ix_(*kept)]
    if structural_rank(csr_array((a != 0.0) | (b != 0.0), dtype=float)) < len(a):
        return np.empty(0)
    unit = np.abs(k).max() / np.abs(m).max()
    x = eigvals(a / unit, b)
    x = x[np.isfinite(x)]
    real = x[(np.abs(x.imag) < 1e-6 * np.abs(x)) & (x.real > 1e-10)].real
    return np.sort(np.sqrt(real * unit)) / (2.0 * np.pi)


def roots(count: int) -> None:
    """Count models whose roots are not those of QZ."""
    differ, total = 0, 0
    for seed in range(count):
        rng = np.random.default_rng(seed)
        model = random_model(KINDS[seed % len(KINDS)], rng)
        r = 2 + seed // len(KINDS) % 2
        ends = [tuple(rng.choice(model.n_dof, r, replace=False).tolist()) for _ in range(2)]
        want = by_qz(model, *ends)
        found = [
            model.antiresonances(*ends, method=method, include_cancelled=True)
            for method in ("modal", "pencil")
        ]
        total += want.size
        same = [own.size == want.size and np.allclose(own, want, rtol=1e-5) for own in found]
        if not all(same):
            differ += 1
            print(f"  seed {seed}: {ends}\n    QZ {want}\n    modal {found[0]}\n    pencil {found[1]}")
    print(f"roots: {count} models, {total} roots; {differ} models differ from QZ")


def slopes() -> None:
    """The largest error of a derivative, relative to the largest of its root."""
    chain = ar.cases.chain8().model
    wide = (0.5, 2.0)
    parameters = [*ar.stiffness_factor(range(7), bounds=wide), *ar.mass_factor(range(8), bounds=wide)]
    two, three = (0, 4), (0, 2, 6)
    ends = [((1, 5), two), ((2, 6), two), ((0, 4), two), ((1, 3, 5), three), ((2, 3, 7), three)]
    parts = [(i, k, np.array([80.0]), None, 0) for i, k in ends]
    core = antiresonance_objective(
        chain, chain.description.core_parameters(parameters), parts, "squared", None, 0.0, None
    )
    x, step = np.random.default_rng(0).uniform(0.8, 1.2, len(parameters)), 1e-4
    _, hz, _, found = core.states(x[None], True, 1)[0]
    worst = 0.0
    for p in range(len(parameters)):
        rows = np.repeat(x[None], 4, axis=0)
        rows[:, p] += step * np.array([-2.0, -1.0, 1.0, 2.0])
        low2, low, high, high2 = (state[1] for state in core.states(rows, False, 1))
        change = (8.0 * (high - low) - (high2 - low2)) / (12.0 * step * hz)
        worst = max(worst, float(np.max(np.abs(change - found[:, p]) / np.abs(found).max(axis=1))))
    print(f"slopes: {found.size} derivatives of {hz.size} roots, largest relative error {worst:.1e}")


def speed() -> None:
    """Least time of both."""
    case = ar.cases.exhaust()
    model, dofs = case.model, case.responses
    forces = (case.excitation, dofs[6])
    pairs = [(dofs[i], dofs[(i + 3) % 16]) for i in range(16)]

    def least(call: Any) -> float:
        times = []
        for _ in range(100):
            start = time.perf_counter()
            call()
            times.append(time.perf_counter() - start)
        return 1e3 * min(times)

    one = least(lambda: model.antiresonances(dofs, case.excitation, f_max_hz=512.0))
    two = least(lambda: model.antiresonances(pairs, forces, f_max_hz=512.0))
    print(f"speed: 16 responses {one:.2f} ms, 16 minors {two:.2f} ms, {two / one:.1f} times as long")


def measured(
    model: Any,
    dofs: list[int],
    force: Any,
    band_hz: tuple[float, float],
    std: float,
    rng: np.random.Generator,
) -> ar.AntiresonanceSet:
    """Exact values with a relative error."""
    r = len(force) if isinstance(force, tuple) else 1
    ends: list[Any] = list(itertools.combinations(dofs, r)) if r > 1 else dofs
    found = {}
    for end, hz in zip(ends, model.antiresonances(ends, force, f_max_hz=band_hz[1]), strict=True):
        inside = hz[hz >= band_hz[0]]
        found[end] = inside * (1.0 + std * rng.standard_normal(inside.size))
    errors = {end: std * hz for end, hz in found.items()}
    return ar.AntiresonanceSet(force, found, std_hz=errors, sees="transmissibility", channels=dofs)


def updating() -> None:
    """Largest difference before and after, against the values without their errors."""
    rng = np.random.default_rng(0)
    chain = ar.cases.chain8().model
    frame, sensors = tower().model, list(tower().responses)
    cases = {
        "chain8": (
            chain,
            [
                *ar.stiffness_factor(range(7), bounds=(0.8, 1.2)),
                *ar.mass_factor(range(1, 8), bounds=(0.8, 1.2)),
            ],
            list(range(8)),
            (0, 4),
            BAND_HZ,
        ),
        "tower": (
            frame,
            ar.stiffness_factor(range(len(frame.default_elements)), bounds=(0.8, 1.2))[:12],
            sensors[::2],
            (sensors[0], sensors[-1]),
            (20.0, 420.0),
        ),
    }
    for name, (model, parameters, dofs, forces, band) in cases.items():
        truth = model.with_parameters(
            parameters, np.exp(0.05 * rng.standard_normal(len(parameters))).clip(0.82, 1.18)
        )
        values = measured(truth, dofs, forces, band, STD, rng)
        start = time.perf_counter()
        result = ar.update(ar.UpdatingProblem(model, parameters, values), rng=0)
        fitted = model.with_parameters(parameters, result.x)
        differences = [
            np.abs(own / true - 1.0)
            for own, true in zip(
                fitted.antiresonances(list(values), forces, f_max_hz=band[1]),
                truth.antiresonances(list(values), forces, f_max_hz=band[1]),
                strict=True,
            )
            if own.size == true.size
        ]
        after = 100.0 * np.concatenate(differences).max()
        count = sum(map(len, values.values()))
        print(
            f"updating {name}: {count} values, {result.table.largest_before_percent:.2f} % before, "
            f"{after:.3f} % from the truth after, {time.perf_counter() - start:.0f} s"
        )


def damage(intact: int) -> None:
    """Right elements, and false alarms."""
    model, forces, dofs = ar.cases.chain8().model, (0, 4), list(range(8))

    def test(model: Any, seed: int) -> ar.AntiresonanceSet:
        return measured(model, dofs, forces, BAND_HZ, STD, np.random.default_rng(seed))

    assessor = ar.Assessor(model, baseline=[test(model, seed) for seed in range(2)], rng=0)
    right = tests = 0
    errors = []
    for spring in range(7):
        for loss in np.arange(0.10, 0.56, 0.05):
            damaged = model.with_parameters(ar.stiffness_reduction(spring), float(loss))
            found = assessor.assess([test(damaged, 100 + tests)])
            tests += 1
            right += [*found.damaged] == [spring]
            if [*found.damaged] == [spring]:
                errors.append(abs(float(found.severity[spring]) - loss))
    alarms = sum(bool(assessor.assess([test(model, 1000 + seed)]).damaged) for seed in range(intact))
    print(
        f"damage: {right} of {tests} right, error of the loss at most {100.0 * max(errors):.2f} %; "
        f"{alarms} alarms of {intact} intact tests"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("parts", nargs="*", help="roots, slopes, speed, updating, damage; default: all")
    parser.add_argument("--models", type=int, default=200)
    parser.add_argument("--intact", type=int, default=100)
    given = parser.parse_args()
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    parts = {
        "roots": lambda: roots(given.models),
        "slopes": slopes,
        "speed": speed,
        "updating": updating,
        "damage": lambda: damage(given.intact),
    }
    for name in given.parts or parts:
        parts[name]()


if __name__ == "__main__":
    main()
