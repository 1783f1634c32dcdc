"""Who finds the damage of benchmarks.outside_class: rivals on the same values, pairs of values and model.

All but the paper's run work on the changes ln(f_now / f_intact) of values paired in their order within a
response, each with the model's root that the intact value belongs to, and with the scatter as stated.

- *L1*: least squares of the changes over all elements, losses >= 0, with the sum of losses as penalty,
  linearised again until it rests; its weight by five-fold cross-validation of the values.
- *least squares*: bounded, with exact slopes and a robust loss, from twenty starts; the best.
- *Bayes*: nothing, one element or two; relative error of a predicted change of 2, 5, 10 or 20 %, and an error
  of any change of 0, 0.2 or 1 %, averaged over these; evidence by grids of losses.
- *emcee*: all losses and one common error at once by ensemble sampling, where the package is installed;
  exponential prior of mean 5 %; an element is named whose 5 % quantile is above the threshold.
- *paper*: the penalised sum of errors of the values now by the island genetic algorithm, no baseline.
- *ours*: ``assess_damage`` with the defaults.

Where a rival gives losses, an element is named from a threshold on: of 1 to 15 % the one with most right
answers on the three structures that set limits.

    python -m benchmarks.outside_rivals --single 10 --double 6 --intact 6 --others 3
    python -m benchmarks.outside_rivals --rivals Bayes ours --out rivals.json
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import importlib.util
import json
import sys
import time
import warnings
from functools import cache
from itertools import combinations, product
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.special import logsumexp

import antires_rs as ar
from antires_rs import _core
from antires_rs.damage.measured_states import measured_states, roots_at
from benchmarks.outside_class import is_right
from benchmarks.study_tools import each, print_table
from reference.outside_cases import OUTSIDE, case
from reference.outside_structures import STRUCTURES

#: Difference of ln f up to which values pair with each other, and with the model's roots.
REACH, OF_MODEL = 0.3, 0.2
MOST_LOST = 0.95
THRESHOLDS = (0.01, 0.02, 0.03, 0.05, 0.08, 0.1, 0.15)


class Changes:
    """Measured changes, and those that the model predicts for losses."""

    def __init__(self, one):
        model, elements = one.structure.model, one.structure.elements
        responses, before, now = measured_states(model, [one.before], [one.now])
        parameters = model.description.core_parameters(tuple(ar.stiffness_reduction(elements)))
        self._core, self.n = responses.source(model, parameters), len(elements)
        self._intact = roots_at(self._core, np.zeros((1, self.n)), slopes=True, threads=1)[0]
        pairs = _paired(now, before, REACH)
        # A model that is too stiff as a whole pairs best when it is shifted.
        tried = [_paired(before, self._intact, OF_MODEL, by) for by in np.linspace(-OF_MODEL, OF_MODEL, 41)]
        root = dict(min(tried, key=lambda one: one.cost))
        pairs = [(i, j) for i, j in pairs if j in root]
        self.root = np.array([root[j] for _, j in pairs], dtype=int)
        self.y = np.array([now.log_f[i] - before.log_f[j] for i, j in pairs])
        self.std = np.array([np.hypot(now.std[i], before.std[j]) for i, j in pairs])

    def predicted(self, losses, slopes=False):
        """Changes (m, k) at losses (m, n), and their slopes (m, k, n)."""
        found = np.full((len(losses), self.root.size), REACH)
        by = np.zeros((len(losses), self.root.size, self.n))
        for nth, state in enumerate(roots_at(self._core, losses, slopes=slopes, threads=1)):
            place = np.full(self._intact.size, -1)
            _, was = state.since(self._intact)
            place[was[was >= 0]] = np.flatnonzero(was >= 0)
            own = place[self.root]
            has = own >= 0
            found[nth, has] = state.log_f[own[has]] - self._intact.log_f[self.root[has]]
            if slopes:
                by[nth, has] = state.slopes[own[has]]
        return (found, by) if slopes else found


class Pairs(list):
    """Pairs (i, j), and what they cost: their distances, and half the reach for each that is alone."""

    cost = 0.0


def _paired(one, other, reach, shift=0.0):
    """Pairs of values or roots of one response, in their order."""
    found = Pairs()
    for number in np.unique(one.response):
        a, b = np.flatnonzero(one.response == number), np.flatnonzero(other.response == number)
        if a.size and b.size:
            by = np.abs(one.log_f[a][:, None] - other.log_f[b] - shift)
            partner = _core.align(by, np.full(a.size, 0.5 * reach), np.full(b.size, 0.5 * reach))
            found += [(int(i), int(b[p])) for i, p in zip(a, partner, strict=True) if p >= 0]
            has = partner >= 0
            found.cost += float(by[has, partner[has]].sum()) + 0.5 * reach * (a.size + b.size - 2 * has.sum())
    return found


# -- The rivals: losses (n,), or a set of elements with its probability; intervals where they have them


def by_l1(changes, rng):
    """Losses of least squares with the sum of losses as penalty."""

    def fitted(some, weight):
        x = np.zeros(changes.n)
        for _ in range(4):
            at, by = changes.predicted(x[None], slopes=True)
            a, b = by[0][some] / changes.std[some, None], (changes.y - at[0])[some] / changes.std[some]
            b = b + a @ x

            def cost(x, a=a, b=b):
                rest = a @ x - b
                return 0.5 * rest @ rest + weight * x.sum(), a.T @ rest + weight

            x = minimize(cost, x, jac=True, method="L-BFGS-B", bounds=[(0.0, MOST_LOST)] * changes.n).x
        return x

    k = changes.y.size
    folds = np.array_split(rng.permutation(k), 5)
    weights = np.geomspace(1.0, 1e5, 11)
    errors = []
    for weight in weights:
        error = 0.0
        for fold in folds:
            kept = np.setdiff1d(np.arange(k), fold)
            left = changes.predicted(fitted(kept, weight)[None])[0][fold] - changes.y[fold]
            error += float(np.abs(left / changes.std[fold]).sum())
        errors.append(error)
    return {"losses": fitted(np.arange(k), weights[int(np.argmin(errors))])}


def by_least_squares(changes, rng, starts=20):
    """Losses of the best of many starts."""

    def rest(x):
        return (changes.predicted(x[None])[0] - changes.y) / changes.std

    def slopes(x):
        return changes.predicted(x[None], slopes=True)[1][0] / changes.std[:, None]

    found = []
    for nth in range(starts):
        start = np.zeros(changes.n) if nth == 0 else rng.uniform(0.0, 0.3, changes.n)
        bounds = (-1e-9, MOST_LOST)
        found.append(least_squares(rest, start, slopes, bounds, x_scale=0.1, loss="soft_l1", max_nfev=60))
    return {"losses": min(found, key=lambda one: one.cost).x}


#: Relative errors of a predicted change, and errors of any; losses of the grids; singles whose pairs are
#: looked at.
KAPPAS, FLOORS, GRID, COARSE, PAIRED = (0.02, 0.05, 0.1, 0.2), (0.0, 2e-3, 0.01), 60, 10, 8


def by_bayes(changes, rng):
    """The most probable of nothing, one element and two."""
    n = changes.n

    def log_likelihoods(losses):
        g = changes.predicted(losses)
        each = []
        for kappa, floor in product(KAPPAS, FLOORS):
            var = changes.std**2 + (kappa * g) ** 2 + floor**2
            each.append(-0.5 * np.sum((changes.y - g) ** 2 / var + np.log(var), axis=1))
        return logsumexp(each, axis=0) - np.log(len(each))

    sets = {(): (float(log_likelihoods(np.zeros((1, n)))[0]) + np.log(0.5), None, None)}
    loss = np.geomspace(0.01, MOST_LOST, GRID)
    sets |= {(e,): _on_grid(log_likelihoods, [loss], (e,), n) for e in range(n)}
    best = sorted((s for s in sets if s), key=lambda s: -sets[s][0])[:PAIRED]
    coarse = np.geomspace(0.02, MOST_LOST, COARSE)
    for a, b in combinations(range(n), 2):
        if (a,) in best or (b,) in best:
            sets[a, b] = _on_grid(log_likelihoods, [coarse, coarse], (a, b), n)
    # The grids of the likeliest are made finer about their peaks.
    for s in sorted((s for s in sets if s), key=lambda s: -sets[s][0])[:4]:
        peak = sets[s][2][int(np.argmax(sets[s][1]))]
        axes = [np.geomspace(0.6 * p, min(1.6 * p, MOST_LOST), 40) for p in peak]
        sets[s] = _on_grid(log_likelihoods, axes, s, n)
    total = logsumexp([one[0] for one in sets.values()])
    best = max(sets, key=lambda s: sets[s][0])
    _, log_p, at = sets[best]
    found = {"named": list(best), "probability": float(np.exp(sets[best][0] - total))}
    if best:
        p = np.exp(log_p - logsumexp(log_p))
        found |= {
            "severity": (p @ at).tolist(),
            "interval": [_quantiles(at[:, i], p) for i in range(len(best))],
        }
    return found


def _on_grid(log_likelihoods, axes, elements, n):
    """Log evidence with its prior, log likelihoods and losses over a grid, even in ln of the losses."""
    at = np.array(np.meshgrid(*axes, indexing="ij")).reshape(len(axes), -1).T
    losses = np.zeros((len(at), n))
    losses[:, elements] = at
    log_p = log_likelihoods(losses)
    # The share of the prior, even in ln of a loss from 1 to 95 %, that the grid covers.
    share = sum(np.log(np.log(axis[-1] / axis[0]) / np.log(MOST_LOST / 0.01)) for axis in axes)
    prior = np.log(0.35 / n) if len(elements) == 1 else np.log(0.15 / (0.5 * n * (n - 1)))
    return logsumexp(log_p) - np.log(len(at)) + share + prior, log_p, at


def _quantiles(values, p):
    order = np.argsort(values)
    total = np.cumsum(p[order])
    return [float(np.interp(q, total, values[order])) for q in (0.05, 0.95)]


#: Mean of the exponential prior; standard deviation of the common error; steps kept, and before them.
MEAN_LOSS, ERRORS, STEPS, BURN = 0.05, (1e-5, 0.1), 600, 600


def by_emcee(changes, rng):
    """Losses at the 5 % quantile, for the threshold; means and intervals."""
    import emcee

    n = changes.n

    def log_probability(x):
        losses, common = x[:, :n], x[:, n]
        inside = ((losses >= 0.0) & (losses <= MOST_LOST)).all(axis=1)
        inside &= (common > np.log(ERRORS[0])) & (common < np.log(ERRORS[1]))
        out = np.full(len(x), -np.inf)
        if inside.any():
            var = changes.std**2 + np.exp(2.0 * common[inside, None])
            rest = changes.predicted(losses[inside]) - changes.y
            out[inside] = (
                -0.5 * np.sum(rest**2 / var + np.log(var), axis=1) - losses[inside].sum(axis=1) / MEAN_LOSS
            )
        return out

    walkers = 2 * (n + 1) + 2
    start = np.hstack([rng.exponential(0.5 * MEAN_LOSS, (walkers, n)), rng.uniform(-6.0, -4.0, (walkers, 1))])
    sampler = emcee.EnsembleSampler(walkers, n + 1, log_probability, vectorize=True)
    sampler.random_state = np.random.RandomState(int(rng.integers(2**31))).get_state()
    sampler.run_mcmc(np.clip(start, -20.0, 0.9), BURN + STEPS)
    drawn = sampler.get_chain(discard=BURN, flat=True)[:, :n]
    low, high = np.quantile(drawn, (0.05, 0.95), axis=0)
    return {
        "losses": low,
        "severity_of_all": drawn.mean(axis=0),
        "interval_of_all": np.stack([low, high], axis=1),
    }


def by_paper(one, rng):
    """Losses of the penalised sum of errors, values as they are now."""
    model, elements = one.structure.model, one.structure.elements
    penalty = ar.DamagePenalty(gamma1=0.1, gamma2=0.1)
    problem = ar.UpdatingProblem(model, ar.stiffness_reduction(elements), one.now, penalty=penalty)
    found = ar.update(problem, rng=int(rng.integers(2**31)), workers=1, progress=False)
    return {"losses": np.asarray(found.x)}


def by_us(one):
    """The set of the best hypothesis."""
    found = ar.assess_damage(
        one.structure.model, one.now, baseline=one.before, elements=one.structure.elements, workers=1
    )
    best = found.hypotheses[0]
    named = [] if best.unknown else list(best.elements)
    told = {"named": named, "probability": float(best.probability)}
    # Without reserve: no other place has been left open.
    told["unknown"], told["kind"] = bool(best.unknown), best.kind
    known = [e for e in named if e in found.damaged]
    if known == named:
        told |= {
            "severity": [found.severity[e] for e in named],
            "interval": [list(found.interval[e]) for e in named],
        }
    return told


BY_CHANGES = {"L1": by_l1, "least squares": by_least_squares, "Bayes": by_bayes, "emcee": by_emcee}
RIVALS = [*BY_CHANGES, "paper", "ours"]


def one_task(task):
    """Answers of some rivals to a case."""
    warnings.simplefilter("ignore")
    name, kind, number, seed, rivals = task
    one = case(name, kind, number, seed)
    changes = Changes(one)
    row = {
        "structure": name,
        "kind": kind,
        "number": number,
        "losses": {int(e): x for e, x in one.losses.items()},
    }
    for rival in rivals:
        rng, start = np.random.default_rng([seed, number]), time.process_time()
        if rival in BY_CHANGES:
            told = BY_CHANGES[rival](changes, rng)
        else:
            told = by_us(one) if rival == "ours" else by_paper(one, rng)
        told["seconds"] = time.process_time() - start
        row[rival] = {
            key: np.asarray(v).tolist() if key.endswith(("losses", "_all")) else v for key, v in told.items()
        }
    return row


class Told:
    """An answer as ``outside_class.is_right`` reads it."""

    def __init__(self, told, threshold):
        losses = told.get("losses")
        self.elements = (
            told["named"] if losses is None else np.flatnonzero(np.asarray(losses) > threshold).tolist()
        )
        self.unknown, self.kind = (
            told.get("unknown", False),
            told.get("kind", "element" if self.elements else ""),
        )
        self.sure = told.get("probability", 1.0) > 0.99
        every = told.get("interval_of_all")
        self.intervals = told.get("interval") if every is None else [every[e] for e in self.elements]
        means = told.get("severity_of_all", losses)
        self.severities = told.get("severity") if means is None else [means[e] for e in self.elements]


@cache
def known(*of):
    """A case, made once."""
    return case(*of)


def judged(rows, rival, threshold):
    """Counts of one rival."""
    counts = dict.fromkeys(("n_intact", "alarms", "n_single", "single", "n_double", "double"), 0)
    counts |= {"n_others": 0, "wrong": 0, "held": 0, "n_held": 0}
    errors = []
    for row in rows:
        if rival not in row:
            continue
        one = known(row["structure"], row["kind"], row["number"], row["seed"])
        told = Told(row[rival], threshold)
        kind = row["kind"]
        if kind == "intact":
            counts["n_intact"] += 1
            counts["alarms"] += bool(told.elements) or told.unknown
        elif kind in OUTSIDE:
            counts["n_others"] += 1
            counts["wrong"] += told.sure and bool(told.elements) and not is_right(one, told, False)
        else:
            right = is_right(one, told, False)
            counts[f"n_{kind}"] += 1
            counts[kind] += right
            for nth, e in enumerate(told.elements if right else ()):
                loss = one.losses.get(e)
                if loss is not None and told.severities is not None:
                    errors.append(abs(told.severities[nth] - loss))
                    if told.intervals is not None:
                        low, high = told.intervals[nth]
                        counts["held"] += low <= loss <= high
                        counts["n_held"] += 1
    counts["error"] = 100.0 * float(np.median(errors)) if errors else float("nan")
    return counts


def right(counts):
    """Right answers of all kinds."""
    return (
        counts["n_intact"]
        - counts["alarms"]
        + counts["single"]
        + counts["double"]
        + counts["n_others"]
        - counts["wrong"]
    )


def tables(rows):
    """One row of figures a rival, for the structures that set limits, those that judge, and each."""
    setting = [name for name, one in STRUCTURES.items() if one.sets_limits]
    parts = {"setting three": setting, "judging three": [name for name in STRUCTURES if name not in setting]}
    parts |= {name: [name] for name in STRUCTURES}
    chosen = {}
    for rival in RIVALS:
        own = [row for row in rows if row["structure"] in setting]
        chosen[rival] = max(THRESHOLDS, key=lambda t, own=own, rival=rival: right(judged(own, rival, t)))
    lines = []
    for label, names in parts.items():
        own = [row for row in rows if row["structure"] in names]
        for rival in RIVALS:
            some = [row for row in own if rival in row]
            if not some:
                continue
            c = judged(some, rival, chosen[rival])
            held = f"{c['held']}/{c['n_held']}" if c["n_held"] else "-"
            threshold = f"{100 * chosen[rival]:g} %" if "losses" in some[0][rival] else "-"
            seconds = np.mean([row[rival]["seconds"] for row in some])
            shares = (("alarms", "intact"), ("single",) * 2, ("double",) * 2, ("wrong", "others"))
            counted = [f"{c[what]}/{c[f'n_{of}']}" for what, of in shares]
            lines.append(
                [f"{label}, {rival}", threshold, *counted, held, f"{c['error']:.1f}", f"{seconds:.2f}"]
            )
    header = [
        "",
        "named from",
        "alarms",
        "single",
        "double",
        "others wrong",
        "90 % hold",
        "error, points",
        "CPU s",
    ]
    print_table(header, lines, False)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--structures", nargs="+", default=list(STRUCTURES), choices=list(STRUCTURES))
    parser.add_argument("--rivals", nargs="+", default=RIVALS, choices=RIVALS)
    parser.add_argument("--intact", type=int, default=10)
    parser.add_argument("--single", type=int, default=25)
    parser.add_argument("--double", type=int, default=15)
    parser.add_argument("--others", type=int, default=3, help="cases of each other kind")
    parser.add_argument("--seed0", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="file for the answers, as JSON")
    parser.add_argument("--read", type=Path, nargs="+", help="tables of such files, and no new cases")
    given = parser.parse_args()
    rivals = [r for r in given.rivals if r != "emcee" or importlib.util.find_spec("emcee")]
    counts = {"intact": given.intact, "single": given.single, "double": given.double}
    counts |= dict.fromkeys(OUTSIDE, given.others)
    tasks = [
        (name, kind, number, given.seed0, rivals)
        for number in range(max(counts.values()))
        for kind in counts
        for name in given.structures
        if number < counts[kind]
    ]
    rows = [row for path in given.read or () for row in json.loads(path.read_text())]
    for row in each(one_task, [] if given.read else tasks, given.workers):
        rows.append(row | {"seed": given.seed0})
        if len(rows) % 10 == 0 or len(rows) == len(tasks):
            print(f"{len(rows)} of {len(tasks)}", file=sys.stderr, flush=True)
            if given.out:
                given.out.write_text(json.dumps(rows))
    tables(rows)


if __name__ == "__main__":
    main()
