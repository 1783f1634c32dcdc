"""Real-time assessment against the full run: time, the same hypothesis, and how right both are.

Tests of structures that are not the model: the exhaust's finer frame (other sections, masses, hangers), every
element off by 2 % more (its own for each structure), against the model that was never updated; or the portal
frame of reference/structures.py, every element off by 5 %. Each structure gives a baseline and tests of it:
intact, one and two damages of 0.7 to 4 times a90 (log-uniform) or any of 5 to 80 %. Antiresonances have
errors of 0.02 to 0.1 %, stated; 3 % are missed, 1 % are false.

    python -m benchmarks.assessor_study                         # 500 tests, an hour
    python -m benchmarks.assessor_study --tests 30 --structures 2
    python -m benchmarks.assessor_study --structure frame --tests 30
    python -m benchmarks.assessor_study --keep DIR              # full runs that DIR has are not run again
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import hashlib
import json
import time
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

import antires_rs as ar
from antires_rs.cases import exhaust_truth as experiment
from benchmarks.study_tools import each
from reference.structures import portal_elements, portal_frame

MISSED, FALSE = 0.03, 0.01
KINDS = ("intact", "one", "two", "one, any size", "two, any size")


class Exhaust:
    """The exhaust's finer frame, every element off by 2 %."""

    def __init__(self, seed):
        self.case = ar.cases.exhaust()
        self.model, self.candidates = self.case.model, self.case.candidates
        self.excitation, self.responses = self.case.excitation, list(self.case.responses)
        self.band_hz = self.case.damage_band_hz
        fine = experiment.true_model(0)
        count = len(self.model.default_elements)
        pieces = np.full(count, experiment.PIECES)
        pieces[experiment.CRACKED_ELEMENT] += len(fine.default_elements) - pieces.sum()
        self.pieces = np.split(np.arange(pieces.sum()), np.cumsum(pieces)[:-1])
        factors = np.exp(0.02 * np.random.default_rng([seed, 1]).standard_normal(count))
        self.fine = fine.with_parameters(
            ar.stiffness_factor(range(len(fine.default_elements)), bounds=(0.8, 1.25)),
            np.repeat(factors, pieces),
        )

    def exact(self, losses):
        """Antiresonances by response, with stiffness losses by element."""
        parts = [int(p) for e in losses for p in self.pieces[e]]
        values = [loss for e, loss in losses.items() for _ in self.pieces[e]]
        model = self.fine.with_parameters(ar.stiffness_reduction(parts), values) if parts else self.fine
        return model.antiresonances(self.responses, self.excitation, f_max_hz=self.band_hz[1])


class Frame:
    """The portal frame of reference/structures.py, every element off by 5 %."""

    def __init__(self, seed):
        frame, self.terms = portal_frame(seed), portal_elements(seed)
        self.model = ar.MatrixModel(frame.stiffness, frame.mass, stiffness_terms=self.terms)
        self.candidates = list(range(len(self.terms)))
        self.excitation, self.responses = frame.excitation, list(frame.responses)
        self.band_hz = frame.band_hz
        self.off = np.exp(0.05 * np.random.default_rng([seed, 1]).standard_normal(len(self.terms)))
        rest = frame.stiffness - sum(self.terms)
        self.rest, self.mass = rest, frame.mass

    def exact(self, losses):
        """Antiresonances by response, with stiffness losses by element."""
        share = [f * (1.0 - losses.get(e, 0.0)) for e, f in enumerate(self.off)]
        stiffness = self.rest + sum(s * term for s, term in zip(share, self.terms, strict=True))
        model = ar.MatrixModel(stiffness, self.mass)
        return model.antiresonances(self.responses, self.excitation, f_max_hz=self.band_hz[1])


def measured(structure, losses, rng):
    """What a test gives: errors, missed and false values."""
    freq, std = {}, {}
    for dof, exact in zip(structure.responses, structure.exact(losses), strict=True):
        exact = exact[exact > structure.band_hz[0]]
        exact = exact[rng.random(exact.size) >= MISSED]
        false = rng.uniform(*structure.band_hz, rng.binomial(max(exact.size, 1), FALSE))
        relative = np.exp(rng.uniform(np.log(2e-4), np.log(1e-3), exact.size + false.size))
        value = np.concatenate([exact, false]) * (1.0 + relative * rng.standard_normal(relative.size))
        order = np.argsort(value)
        freq[dof], std[dof] = value[order], (relative * value)[order]
    return ar.AntiresonanceSet(structure.excitation, freq, std_hz=std)


def drawn(kind, structure, a90, rng):
    """Severities by element."""
    count = {"i": 0, "o": 1, "t": 2}[kind[0]]
    where = rng.choice([e for e in structure.candidates if a90[e] < 0.5], size=count, replace=False)
    if "any" in kind:
        return {int(e): float(np.exp(rng.uniform(np.log(0.05), np.log(0.8)))) for e in where}
    return {int(e): float(min(a90[e] * np.exp(rng.uniform(np.log(0.7), np.log(4.0))), 0.9)) for e in where}


def of_structure(task):
    """Rows of all tests of one structure."""
    name, seed, tests, keep = task
    warnings.simplefilter("ignore")
    structure = (Exhaust if name == "exhaust" else Frame)(seed)
    rng = np.random.default_rng([seed, 2])
    before = measured(structure, {}, rng)
    begun = time.perf_counter()
    assessor = ar.Assessor(structure.model, baseline=before, elements=structure.candidates, workers=1)
    offline_s = time.perf_counter() - begun
    assessor.assess(before)  # tables that are made at first use
    rows = []
    for nth in range(tests):
        kind = KINDS[nth % len(KINDS)]
        losses = drawn(kind, structure, assessor.detectable, rng)
        now = measured(structure, losses, rng)
        timed = []
        for _ in range(3):
            cpu, wall = time.thread_time(), time.perf_counter()
            quick = assessor.assess(now)
            timed.append((time.thread_time() - cpu, time.perf_counter() - wall))
        full = kept(keep, f"{name}-{seed}-{nth:03d}", structure, before, now)
        rows.append(
            {
                "kind": kind, "losses": losses, "timed": timed, "full_s": full["full_s"],
                "offline_s": offline_s, "wanted": quick.full_run_wanted, "reasons": quick.reasons,
                "quick": _answer(quick), "full": full, "odds": full["odds"],
                "above": all(loss >= assessor.detectable[e] for e, loss in losses.items()),
            }
        )  # fmt: skip
    return rows


def kept(keep, name, structure, before, now):
    """The answer of the full run, from a file where there is one of the very values."""
    digest = hashlib.sha256(repr([each.to_json() for each in (before, now)]).encode()).hexdigest()
    path = Path(keep) / f"{name}.json" if keep else None
    if path and path.exists():
        found = json.loads(path.read_text())
        if found["digest"] == digest:
            return _plain(found)
    begun = time.thread_time()
    full = ar.assess_damage(
        structure.model, now, baseline=before, elements=structure.candidates, workers=1, progress=False
    )
    found = {
        **_answer(full),
        "full_s": time.thread_time() - begun,
        "odds": [(h.elements, h.probability) for h in list(full.hypotheses)[:3]],
        "digest": digest,
    }
    if path:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(found))
    return found


def _plain(found):
    """An answer read from JSON: tuples, and elements as numbers."""
    return {
        **found,
        "best": tuple(found["best"]),
        "declared": tuple(found["declared"]),
        "severity": {int(e): x for e, x in found["severity"].items()},
        "interval": {int(e): x for e, x in found["interval"].items()},
        "odds": [(tuple(e), p) for e, p in found["odds"]],
    }


def _answer(found):
    return {
        "best": found.hypotheses[0].elements,
        "declared": tuple(found.assessment.declared),
        "severity": dict(found.severity),
        "interval": dict(found.interval),
    }


def _accuracy(rows, who):
    intact = [r for r in rows if not r["losses"]]
    damaged = [r for r in rows if r["losses"] and r["above"]]
    right = [r for r in damaged if set(r[who]["declared"]) == set(r["losses"])]
    errors = [abs(r[who]["severity"][e] - b) for r in right for e, b in r["losses"].items()]
    inside = [
        r[who]["interval"][e][0] <= b <= r[who]["interval"][e][1]
        for r in right
        for e, b in r["losses"].items()
    ]
    false = sum(bool(r[who]["declared"]) for r in intact)
    middle, most = 100 * np.quantile(errors or [np.nan], [0.5, 0.95])
    return (
        f"false alarms {false} of {len(intact)}; right elements {len(right)} of {len(damaged)} above a90; "
        f"error of the loss, median {middle:.2f} %, 95th {most:.2f} %; 90 % intervals hold {sum(inside)} of "
        f"{len(inside)}"
    )


def told(rows):
    """Sentences."""
    cpu, wall = (1e3 * np.array([t[k] for r in rows for t in r["timed"]]) for k in (0, 1))
    best = 1e3 * np.array([min(t[1] for t in r["timed"]) for r in rows])
    for name, each_ms in (("CPU", cpu), ("wall", wall), ("wall, best of three", best)):
        figures = ", ".join(f"{q:g} %: {np.quantile(each_ms, q / 100):.1f}" for q in (50, 90, 99, 100))
        yield f"ms, {name}: {figures}"
    full_s, offline_s = np.median([r["full_s"] for r in rows]), rows[0]["offline_s"]
    yield f"full run, CPU s: median {full_s:.1f}; offline {offline_s:.0f} s"
    for name, some in (("all", rows), *((k, [r for r in rows if r["kind"] == k]) for k in KINDS)):
        same = sum(r["quick"]["best"] == r["full"]["best"] for r in some)
        sure = [r for r in some if not r["wanted"]]
        among = sum(r["quick"]["best"] == r["full"]["best"] for r in sure)
        slow = np.quantile([1e3 * t[0] for r in some for t in r["timed"]], 0.99) if some else np.nan
        yield (
            f"{name}: same hypothesis {same} of {len(some)}; without a wish for a full run {among} of "
            f"{len(sure)}; CPU ms, 99 %: {slow:.1f}"
        )
    for who in ("full", "quick"):
        yield f"{who}: {_accuracy(rows, who)}"
    yield f"reasons for a full run: {dict(Counter(x for r in rows for x in r['reasons']))}"
    for r in rows:
        if r["quick"]["best"] != r["full"]["best"]:
            losses = {e: round(b, 3) for e, b in r["losses"].items()}
            odds = ", ".join(f"{e}: {p:.3f}" for e, p in r["odds"])
            yield f"differs: truth {losses}, quick {r['quick']['best']}, full {odds}; {r['reasons']}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--structure", choices=("exhaust", "frame"), default="exhaust")
    parser.add_argument("--tests", type=int, default=100, help="of each structure")
    parser.add_argument("--structures", type=int, default=5)
    parser.add_argument("--first-seed", type=int, default=7000)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--keep", metavar="DIR", help="answers of full runs are kept there")
    given = parser.parse_args()
    tasks = [
        (given.structure, given.first_seed + i, given.tests, given.keep) for i in range(given.structures)
    ]
    found = [row for rows in each(of_structure, tasks, given.workers) for row in rows]
    print("\n".join(told(found)))
