"""Antiresonances of order r of models: none missed, slopes, time, and what updating and damage make of them.

Measurements, each by its name:

- ``roots``: random chains, full matrices, coinciding and close eigenvalues, free structures, r = 2 and 3,
  against SciPy's QZ of the deleted pencil, cancelled roots among them;
- ``slopes``: derivatives with respect to all springs and masses against central differences (Richardson);
- ``speed``: 16 minors of order 2 of the exhaust beside its 16 responses of order 1;
- ``updating``: chain8 and a braced tower fitted to values of two unknown forces, each with some error;
- ``damage``: each spring of chain8 with 10 to 55 % less, and 100 intact tests, by an :class:`Assessor`;
- ``records``: the updating of both from simulated records, 1 % of noise, of structures 3 % off;
- ``damage_records``: the damage of such a chain by records;
- ``measured``: FRFs of a measured frame in pairs, against models updated by its antiresonances of order 1;
- ``two_tests``: what order 2 of two tests with one force each adds to order 1 of both.

Run ``python -m benchmarks.several_forces_model`` for all, or name some.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import itertools
import time
import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import eigvals
from scipy.sparse import csr_array
from scipy.sparse.csgraph import structural_rank

import antires_rs as ar
from antires_rs.damage.measured_states import roots_at
from antires_rs.updating.targets import antiresonance_objective
from benchmarks.search_cases import tower
from examples import southampton_frame as frame

KINDS = ("chain", "full", "coinciding", "close", "free")
#: Relative error of a value, and the band of chain8.
STD, BAND_HZ = 5e-4, (3.0, 130.0)
#: Records: how far a structure is from its model, its damping, noise of every sensor.
OFF, DAMPING, NOISE = 0.03, 0.008, 0.01
#: No value is better known than this share of it, and what the unknowns are known to before a test.
LEAST_ERROR, BEFORE = 1e-4, 0.1
#: A value so many standard deviations off is no error but another root: a search leaves it out.
BEYOND = 5.0


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


@dataclass(frozen=True)
class Case:
    """A model with its unknowns, and a test of it."""

    model: Any
    parameters: Any
    channels: list[int]
    forces: tuple[int, int]
    band_hz: tuple[float, float]
    duration_s: float

    def near(self, off: float, rng: np.random.Generator) -> Any:
        """A structure that is not the model, each unknown off by so much."""
        x = np.exp(off * rng.standard_normal(len(self.parameters)))
        return self.model.with_parameters(self.parameters, x.clip(0.82, 1.18))

    def record(self, truth: Any, force: int, rng: int) -> ar.Recording:
        """Under one force, no noise; the damping is not told to anybody."""
        return truth.simulate(
            excitation=force,
            fs_hz=3.1 * self.band_hz[1],
            duration_s=self.duration_s,
            damping_ratio=DAMPING,
            responses=self.channels,
            rng=rng,
        )

    def identified(self, record: Any, *forces: int) -> ar.AntiresonanceSet:
        """What is found in a record, or in several."""
        return ar.identify_antiresonances(record, excitation=list(forces), band_hz=self.band_hz, check="off")

    def test(self, truth: Any, seed: int) -> ar.AntiresonanceSet:
        """Identified under both forces at once."""
        each = [self.record(truth, force, 10 * seed + nth) for nth, force in enumerate(self.forces)]
        both = sum(one.responses for one in each)
        return self.identified(noisy(ar.Recording(both, each[0].fs_hz, self.channels), seed), *self.forces)


def noisy(record: ar.Recording, seed: int) -> ar.Recording:
    """With noise of every sensor."""
    x = record.responses
    noise = np.random.default_rng([seed, 1]).standard_normal(x.shape)
    return ar.Recording(x + NOISE * x.std(axis=1, keepdims=True) * noise, record.fs_hz, record.dofs)


def cases() -> dict[str, Case]:
    """The chain and the tower."""
    chain, frame, sensors = ar.cases.chain8().model, tower().model, list(tower().responses)
    wide = (0.8, 1.2)
    masses_and_springs = [
        *ar.stiffness_factor(range(7), bounds=wide),
        *ar.mass_factor(range(1, 8), bounds=wide),
    ]
    members = ar.stiffness_factor(range(len(frame.default_elements)), bounds=wide)[:12]
    return {
        "chain8": Case(chain, masses_and_springs, list(range(8)), (0, 4), BAND_HZ, 600.0),
        "tower": Case(frame, members, sensors[::2], (sensors[0], sensors[-1]), (20.0, 420.0), 480.0),
    }


def updating(*, by_records: bool = False) -> None:
    """Largest difference before and after, against the values without their errors."""
    rng = np.random.default_rng(0)
    for name, case in cases().items():
        truth = case.near(OFF if by_records else 0.05, rng)
        start = time.perf_counter()
        if by_records:
            values = case.test(truth, 0)
        else:
            values = measured(truth, case.channels, case.forces, case.band_hz, STD, rng)
        result = ar.update(ar.UpdatingProblem(case.model, case.parameters, values), rng=0)
        fitted = case.model.with_parameters(case.parameters, result.x)
        ends, high = list(values), case.band_hz[1]
        differences = [
            np.abs(own / true - 1.0)
            for own, true in zip(
                fitted.antiresonances(ends, case.forces, f_max_hz=high),
                truth.antiresonances(ends, case.forces, f_max_hz=high),
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


def damage(intact: int, *, losses: Any = None, by_records: bool = False) -> None:
    """Right elements, and false alarms."""
    case, model = replace(cases()["chain8"], duration_s=300.0), ar.cases.chain8().model
    structure = case.near(OFF, np.random.default_rng(7)) if by_records else model

    def test(structure: Any, seed: int) -> ar.AntiresonanceSet:
        if by_records:
            return case.test(structure, seed)
        return measured(structure, case.channels, case.forces, BAND_HZ, STD, np.random.default_rng(seed))

    assessor = ar.Assessor(model, baseline=[test(structure, seed) for seed in range(2)], rng=0)
    right = tests = 0
    errors = []
    for spring in range(7):
        for loss in np.arange(0.10, 0.56, 0.05) if losses is None else losses:
            damaged = structure.with_parameters(ar.stiffness_reduction(spring), float(loss))
            found = assessor.assess([test(damaged, 100 + tests)])
            tests += 1
            right += [*found.damaged] == [spring]
            if [*found.damaged] == [spring]:
                errors.append(abs(float(found.severity[spring]) - loss))
            elif by_records:
                print(f"  spring {spring}, {100.0 * loss:.0f} %: {found.damaged}")
    alarms = sum(bool(assessor.assess([test(structure, 1000 + seed)]).damaged) for seed in range(intact))
    print(
        f"damage{' by records' * by_records}: {right} of {tests} right, error of the loss at most "
        f"{100.0 * max(errors):.2f} %; {alarms} alarms of {intact} intact tests"
    )


def storeys(tied: bool) -> tuple[Any, Any]:
    """The measured frame of three storeys, floors 0 and 2 tied by bending or not; its unknowns."""
    pairs = [(-1, 0), (0, 1), (1, 2), (0, 2)]
    terms = []
    for low, high in pairs[: 3 + tied]:
        way = np.eye(3)[high] - (np.eye(3)[low] if low >= 0 else 0.0)
        share = 1.0 if high - low == 1 else -0.02
        terms.append(share * frame.STIFFNESS_N_PER_M * np.outer(way, way))
    masses = [frame.MASS_KG * np.diag(own) for own in np.eye(3)]
    model = ar.MatrixModel(sum(terms), sum(masses), stiffness_terms=terms, mass_terms=masses)
    unknowns = [
        *ar.mass_factor([1, 2], bounds=(0.6, 1.4)),
        *ar.stiffness_factor([0, 1, 2], bounds=(0.5, 1.4)),
    ]
    return model, [*unknowns, *ar.stiffness_factor([3][:tied], bounds=(1e-3, 8.0))] if tied else unknowns


def of_measured_frame() -> None:
    """Order 2 of its FRFs in pairs, beside models that were updated by order 1."""
    folder = frame.data_folder()
    if folder is None:
        print("measured: the frame is not here, set ANTIRES_DATA")
        return
    columns = [frame.read_column(folder / name) for name in frame.FILES]
    once = [
        ar.AntiresonanceSet(zeros.excitation, {i: zeros[i] for i in zeros if i <= zeros.excitation})
        for zeros in frame.identify(folder)
    ]
    pairs = list(itertools.combinations(range(3), 2))
    found = {
        forces: ar.identify_antiresonances(
            [columns[k] for k in forces], excitation=list(forces), band_hz=frame.BAND_HZ, check="off"
        )
        for forces in pairs
    }
    for tied in (False, True):
        model, unknowns = storeys(tied)
        result = ar.update(ar.UpdatingProblem(model, unknowns, once, misfit="squared"), rng=0)
        fitted = model.with_parameters(unknowns, result.x)
        print(f"measured, tied {tied}: order 1 within {result.table.largest_after_percent:.2f} %; order 2:")
        for forces, zeros in found.items():
            for pair, hz in zeros.items():
                of_model = fitted.antiresonances(tuple(pair), forces, f_max_hz=40.0)
                if hz.size or of_model.size:
                    seen = [f"{f:.3f} ({g})" for f, g in zip(hz, zeros.scores[pair]["grade"], strict=True)]
                    found_there = ", ".join(seen) or "none"
                    in_band = of_model[of_model <= frame.BAND_HZ[1]].round(3)
                    print(f"  forces {forces}, responses {pair}: {found_there}; model {in_band} Hz")


def two_tests(seeds: int) -> None:
    """Errors of the unknowns by linear least squares, from order 1, 2 and both of the same tests."""
    for name, case in cases().items():
        case = replace(case, duration_s=0.5 * case.duration_s)
        truth, high = case.near(0.0, np.random.default_rng(0)), case.band_hz[1]
        places: list[Any] = [(i, k) for k in case.forces for i in case.channels]
        n_single = len(places)
        places += [(pair, case.forces) for pair in itertools.combinations(case.channels, 2)]
        core = antiresonance_objective(
            case.model,
            case.model.description.core_parameters(case.parameters),
            [(*end, np.array([high]), None, 0) for end in places],
            "squared",
            None,
            0.0,
            None,
        )
        exact = roots_at(core, np.ones((1, len(case.parameters))), slopes=True, threads=1)[0]
        errors: dict[str, list[Any]] = {"order 1": [], "order 2": [], "both": []}
        stated: dict[str, list[Any]] = {which: [] for which in errors}
        counts, beyond = [], 0
        for seed in range(seeds):
            each = [
                noisy(case.record(truth, force, 10 * seed + nth), 10 * seed + nth)
                for nth, force in enumerate(case.forces)
            ]
            sets = [case.identified(one, force) for one, force in zip(each, case.forces, strict=True)]
            sets.append(case.identified(each, *case.forces))
            rows, off, single = [], [], []
            for zeros in sets:
                for end, table in zeros.tables.items():
                    nth = places.index((tuple(end) if zeros is sets[2] else end, zeros.excitation))
                    of_end = np.flatnonzero(exact.response == nth)
                    for hz, std in zip(table.freq_hz, table.std_hz, strict=True):
                        distance = np.log(hz) - exact.log_f[of_end]
                        if of_end.size and np.abs(distance).min() < 0.01:
                            at = int(np.abs(distance).argmin())
                            error = max(std / hz, LEAST_ERROR)
                            if abs(distance[at]) > BEYOND * error:
                                beyond += 1
                                continue
                            rows.append(exact.slopes[of_end[at]] / error)
                            off.append(distance[at] / error)
                            single.append(nth < n_single)
            own, wrong, alone = np.array(rows), np.array(off), np.array(single)
            counts.append((alone.sum(), (~alone).sum()))
            for which, some in {"order 1": alone, "order 2": ~alone, "both": alone | True}.items():
                inverse = np.linalg.inv(own[some].T @ own[some] + np.eye(own.shape[1]) / BEFORE**2)
                errors[which].append(inverse @ own[some].T @ wrong[some])
                stated[which].append(np.sqrt(np.diag(inverse)))
        print(
            f"two tests, {name}: {np.mean(counts, axis=0).round(1)} values of order 1 and 2, "
            f"{seeds} seeds; {beyond} far off"
        )
        for which in errors:
            seen = 100.0 * np.sqrt(np.mean(np.square(errors[which]), axis=0))
            told = 100.0 * np.mean(stated[which], axis=0)
            print(
                f"  {which}: error of an unknown {np.median(seen):.3f} % (median) to {seen.max():.2f} %; "
                f"stated {np.median(told):.3f} and {told.max():.2f} %"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("parts", nargs="*", help="which, by name; default: all")
    parser.add_argument("--models", type=int, default=200)
    parser.add_argument("--intact", type=int, default=100)
    parser.add_argument("--seeds", type=int, default=8)
    given = parser.parse_args()
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    parts = {
        "roots": lambda: roots(given.models),
        "slopes": slopes,
        "speed": speed,
        "updating": updating,
        "damage": lambda: damage(given.intact),
        "records": lambda: updating(by_records=True),
        "damage_records": lambda: damage(40, losses=np.linspace(0.10, 0.55, 5), by_records=True),
        "measured": of_measured_frame,
        "two_tests": lambda: two_tests(given.seeds),
    }
    for name in given.parts or parts:
        parts[name]()


if __name__ == "__main__":
    main()
