"""Antiresonances by antires_rs and by the packages nearest to it, on the same data in one run.

No other package returns antiresonances, so each is driven as well as its documentation allows: it fits the
transmissibilities T_pj of every reference j (or what the table's second column says), order by order to 60.
Values are selected from its poles twice: by the rule of Meruane (2013), the same for all and for the poles of
antires_rs too, and by the best rule of its own (``peers/rule.py``; antires_rs: as a user calls it). The
transmissibilities are estimated twice: as H1, which any user has, and as antires_rs' own rank-one estimate,
so that no peer is starved. Settings and rules were chosen on seeds 100-102 for the most found minus false;
each is explained where it is set, in ``peers/``. The chain first, simulated; then measured structures
(``reference/measured.py``), whose FRFs everyone is given, with the same settings and rules.

    pip install sdypy-EMA pyoma-2 strid pyfbs scikit-rf PyDynamic       # those you want; the others are named
    python -m benchmarks.peers_identification                           # half an hour
    python -m benchmarks.peers_identification --quick --only strid      # one record, and what is measured
    python -m benchmarks.peers_identification --choose                  # the rule of each peer, anew

Times are of a whole record, from the samples to the values of all dofs under its own rule, after a first call
that is not counted, on one core: BLAS has one thread.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy
os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"
os.environ["MPLBACKEND"] = "Agg"  # some peers import pyplot

import argparse
import contextlib
import io
import logging
import platform
import time
import warnings
from dataclasses import dataclass, field

import numpy as np
import scipy

import antires_rs as ar
from benchmarks import peers
from benchmarks.peers.method import MAX_ORDER, Method, Source
from benchmarks.peers.rule import COMMON, FAMILY, select
from benchmarks.study_tools import Score, add_options, print_table, score_run
from reference.measured import Counted, counted, structures

BAND_HZ = (3.0, 130.0)
DAMPING = 0.01
DURATION_S = 200.0
ESTIMATORS = {"rank1": "rank-one", "h1": "H1"}
RULES = ("common", "own")
#: Records and noise on which rules are chosen.
CHOOSING_SEEDS, CHOOSING_NOISE = (100, 101, 102), (0.01, 0.05)


@dataclass
class Entry:
    """A row of the tables: a name, what it is given, and two functions.

    ``sweep(source, highest order)`` gives something that holds the poles of every order, and
    ``values(sweep, band, rule)`` the frequencies by dof under the common or its own rule.
    """

    name: str
    given: str
    sweep: object
    values: object
    needs_record: bool = False
    runs: dict = field(default_factory=dict)
    process_s: list = field(default_factory=list)
    measured: dict = field(default_factory=dict)
    measured_s: float = 0.0
    failure: str = ""


def ours(formulation, route="transmissibility"):
    """antires_rs as a user calls it; under the common rule, the poles of its diagrams."""

    def sweep(source, highest):
        return ar.identify_antiresonances(
            source.of,
            excitation=source.excitation,
            band_hz=(source.low_hz, source.high_hz),
            route=route,
            fit=ar.FitOptions(formulation=formulation),
            max_order=None if highest == MAX_ORDER else max(highest, 14),
        )

    def values(found, band_hz, rule):
        if rule == "own":
            return {dof: found[dof] for dof in found}
        return {dof: select(_poles(found.diagrams[dof]), band_hz) for dof in found}

    given = "force too" if route == "frf" else "responses or FRFs"
    name = "default" if formulation == "auto" else formulation
    name = f"antires_rs, {name}{', FRF route' if route == 'frf' else ''}"
    return Entry(name, given, sweep, values)


def _poles(diagram):
    """Poles (rad/s) of every order, in the upper half plane."""
    rows = zip(diagram.freq_hz, diagram.damping_ratio, strict=True)
    return [2 * np.pi * f * (-d + 1j * np.sqrt(np.maximum(1.0 - d**2, 0.0))) for f, d in rows]


def theirs(method: Method, estimator):
    """A peer's sweep and both rules."""

    def sweep(source, highest):
        return dict(zip(source.dofs, method.sweep(source, highest, estimator), strict=True))

    def values(sweeps, band_hz, rule):
        chosen = method.rule if rule == "own" else COMMON
        return {dof: select(poles, band_hz, chosen) for dof, poles in sweeps.items()}

    given = f"T, {ESTIMATORS[estimator]}" if method.data == "T" else method.data
    return Entry(method.name, given, sweep, values, method.needs_record)


@contextlib.contextmanager
def quiet():
    """Progress bars, prints, log lines and warnings of the peers, all silenced."""
    with (
        warnings.catch_warnings(),
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
    ):
        warnings.simplefilter("ignore")
        logging.disable(logging.CRITICAL)
        try:
            yield
        finally:
            logging.disable(logging.NOTSET)


def answers(entry, source):
    """Values by dof under each rule, and process seconds of the sweep with the entry's own rule."""
    band = (source.low_hz, source.high_hz)
    with quiet():
        start = time.process_time()
        sweep = entry.sweep(source, MAX_ORDER)
        own = entry.values(sweep, band, "own")
        seconds = time.process_time() - start
        return {"own": own, "common": entry.values(sweep, band, "common")}, seconds


def table_of_entries(options):
    """Rows to run, and lines on what is not installed."""
    entries = [ours("auto"), ours("joint"), ours("auto", "frf")]
    missing, left_out = {}, []
    for method in wanted(options):
        if method.version() is None:
            missing.setdefault(method.package, []).append(method.name)
        elif options.quick and method.slow:
            left_out.append(f"{method.name}: left out by --quick, it is slow")
        else:
            estimators = options.estimators if method.data == "T" else options.estimators[:1]
            entries += [theirs(method, estimator) for estimator in estimators]
    return entries, [
        f"{', '.join(names)}: not installed: pip install {package}" for package, names in missing.items()
    ] + left_out


def wanted(options):
    """The methods that ``--only`` leaves."""
    words = [word.lower() for word in options.only or [""]]
    return [method for method in peers.METHODS if any(word in method.name.lower() for word in words)]


def of_chain(case, noise, seed, duration_s=DURATION_S):
    """A record of the chain."""
    record = case.experiment(noise=noise, damping_ratio=DAMPING, duration_s=duration_s, rng=seed)
    return Source(record, *BAND_HZ, excitation=case.excitation)


def warm_up(entries, case):
    """A first call of each, on a short record and few orders; an entry that cannot run says why."""
    short = of_chain(case, 0.01, 1000, 64.0)
    for entry in entries:
        try:
            with quiet():
                entry.values(entry.sweep(short, 12), BAND_HZ, "own")
        except Exception as error:  # whatever another version of a peer may raise is that peer's row
            entry.failure = f"{type(error).__name__}: {error}"


def compare(entries, case, options):
    """Run everything on every record."""
    truth = case.truth()["freq_hz"]
    for noise in options.noise:
        for seed in range(options.first_seed, options.first_seed + options.seeds):
            source = of_chain(case, noise, seed)
            for entry in entries:
                values, process_s = answers(entry, source)
                for rule in RULES:
                    entry.runs.setdefault((rule, noise), []).append(score_run(values[rule], truth))
                entry.process_s.append(process_s)


def measure(entries):
    """Run everything that takes FRFs on the measured structures that are there; their names."""
    names = []
    for one in structures():
        names += [one.name] if one.name not in names else []
        source = Source(one.frfs, *one.band_hz, excitation=one.excitation)
        for entry in entries:
            if entry.needs_record or "FRF route" in entry.name:
                continue
            try:
                values, process_s = answers(entry, source)
            except Exception as error:  # see warm_up
                entry.failure = f"{one.name}: {type(error).__name__}: {error}"
                continue
            for rule in RULES:
                before = entry.measured.get((rule, one.name), Counted())
                entry.measured[rule, one.name] = before + counted(one, values[rule])
            entry.measured_s += process_s
    return names


def print_scores(entries, options):
    columns = [(rule, noise) for rule in RULES for noise in options.noise]
    header = ["method", "given", *[f"{rule}, {100 * noise:g} %" for rule, noise in columns], "CPU s"]
    rows = []
    for entry in entries:
        scores = [Score(tuple(entry.runs[column])) for column in columns]
        counts = [f"{np.mean(s.found):.1f} / {np.mean(s.false):.1f}" for s in scores]
        rows.append([entry.name, entry.given, *counts, f"{np.median(entry.process_s):.2f}"])
    last = options.first_seed + options.seeds - 1
    print(
        f"\nchain, {DURATION_S:g} s records, seeds {options.first_seed} to {last}: found / false of 28, "
        "means,\nby the common rule and by its own; median CPU seconds of a record\n"
    )
    print_table(header, rows, options.markdown)


def print_measured(entries, names, options):
    columns = [(rule, name) for rule in RULES for name in names]
    rows = [
        [
            entry.name,
            entry.given,
            *[str(entry.measured[column]) for column in columns],
            f"{entry.measured_s:.1f}",
        ]
        for entry in entries
        if all(column in entry.measured for column in columns)
    ]
    print("\nmeasured FRFs: clear dips found of those there, values without a dip; CPU seconds of all\n")
    header = ["method", "given", *[f"{rule}, {name}" for rule, name in columns], "CPU s"]
    print_table(header, rows, options.markdown)


def choose(options):
    """The best rule of the family for each peer, on the choosing records."""
    case = ar.cases.chain8()
    truth = case.truth()["freq_hz"]
    for method in wanted(options):
        if method.version() is None or (options.quick and method.slow):
            continue
        net = dict.fromkeys(FAMILY, 0)
        for noise in CHOOSING_NOISE:
            for seed in CHOOSING_SEEDS:
                with quiet():
                    sweeps = method.sweep(of_chain(case, noise, seed), MAX_ORDER, "rank1")
                for rule in FAMILY:
                    found = {
                        dof: select(s, BAND_HZ, rule) for dof, s in zip(case.responses, sweeps, strict=True)
                    }
                    score = Score((score_run(found, truth),))
                    net[rule] += score.found[0] - score.false[0]
        best = sorted(FAMILY, key=lambda rule: -net[rule])[:3]
        answers = "; ".join(f"{net[rule]}: {rule}" for rule in best)
        print(f"{method.name}: found less false, common {net[COMMON]}; {answers}", flush=True)


def print_versions():
    own = {
        "antires_rs": ar.__version__,
        "Python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
    }
    own |= {m.package: m.version() for m in peers.METHODS if m.package != "scipy" and m.version()}
    print(", ".join(f"{name} {version}" for name, version in own.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_options(parser, first_seed=20, seeds=3)
    parser.set_defaults(jobs=1)  # a second process would spoil the times
    parser.add_argument("--noise", type=float, nargs="+", default=[0.0, 0.01, 0.05])
    parser.add_argument(
        "--estimators",
        nargs="+",
        choices=ESTIMATORS,
        default=list(ESTIMATORS),
        help="how the peers' transmissibilities are estimated",
    )
    parser.add_argument("--only", nargs="+", metavar="WORD", help="peers whose name has one of these words")
    parser.add_argument("--quick", action="store_true", help="one record at 1 %% noise, no slow peers")
    parser.add_argument("--skip-measured", action="store_true", help="without the second table")
    parser.add_argument("--choose", action="store_true", help="only find the best rule of each peer")
    options = parser.parse_args()
    if options.quick:
        options.seeds, options.noise, options.estimators = 1, [0.01], options.estimators[:1]
    print_versions()
    if options.choose:
        choose(options)
        return
    case = ar.cases.chain8()
    entries, notes = table_of_entries(options)
    warm_up(entries, case)
    notes += [f"{e.name} ({e.given}): failed: {e.failure}" for e in entries if e.failure]
    entries = [e for e in entries if not e.failure]
    compare(entries, case, options)
    print_scores(entries, options)
    if not options.skip_measured:
        names = measure(entries)
        if names:
            print_measured(entries, names, options)
        else:
            notes.append("no measured structures: set ANTIRES_DATA")
        notes += [f"{e.name} ({e.given}): failed: {e.failure}" for e in entries if e.failure]
    shown = {entry.name for entry in entries}
    notes = [f"{m.name}: {m.note}; own rule: {m.rule}" for m in peers.METHODS if m.name in shown] + notes
    print("\n" + "\n".join(notes))


if __name__ == "__main__":
    main()
