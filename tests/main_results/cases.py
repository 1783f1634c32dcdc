"""What must come out as it did before: searches, identifications and assessments, by public names alone.

Structures, records and tests come from ``reference`` and from the published measurements, with seeds that
nothing was set on. Each case is a name and a function without arguments that returns plain numbers.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import antires_rs as ar
from benchmarks.search_cases import STRUCTURES as SEARCHED
from reference import measured as published, structures
from reference.small_records import OPTIONS, record
from reference.wrong_chains import NOMINAL, N, chain, measured, truth

Case = tuple[str, Callable[[], Any]]


def searches() -> Iterator[Case]:
    """Twenty searches: updating of two frames, of modes and of a chain, and functions written in Python."""
    for name, make in SEARCHED.items():
        for damages, kind, seed in (
            (1, "noisy", 900),
            (2, "noisy", 901),
            (2, "wrong", 902),
            (3, "exact", 903),
        ):
            yield f"{name} {damages} {kind}", lambda a=(make, damages, kind, seed): _updated(*a)
    for level, seed in ((0, 0), (1, 1), (1, 2)):
        yield f"chain8 level {level} seed {seed}", lambda a=(level, seed): _chain(*a)
    yield "chain8 modes", _modes
    for crossover in ("arithmetic", "heuristic", "blend", "uniform"):
        yield f"function {crossover}", lambda crossover=crossover: _minimized(crossovers=[crossover])
    yield "function two islands", lambda: _minimized(islands=2)
    yield "function, other seed", lambda: _minimized(seed=12)
    yield "function, patience", lambda: _minimized(patience=5)
    yield "function, sphere", lambda: _minimized(function=lambda x: float(np.sum(x**2)))


def _search(found: Any) -> Any:
    return [float.hex(float(v)) for v in (*found.x, found.fun)]


def _updated(make: Any, damages: int, kind: str, seed: int) -> Any:
    problem, _ = make().problem(damages, kind, seed)
    return _search(ar.update(problem, optimizer=ar.IslandGA(max_evaluations=3000), rng=seed, reduction=False))


def _chain(level: int, seed: int) -> Any:
    case = ar.cases.chain8()
    problem = case.damage_problem(case.exact(level))
    return _search(ar.update(problem, optimizer=ar.IslandGA(max_evaluations=4000), rng=seed))


def _modes() -> Any:
    case = ar.cases.chain8()
    problem = ar.UpdatingProblem(case.model, ar.stiffness_reduction(range(7)), case.exact_modes(1))
    return _search(ar.update(problem, optimizer=ar.IslandGA(max_evaluations=3000), rng=4))


def _minimized(*, function: Any = None, seed: int = 11, **options: Any) -> Any:
    def rastrigin(x: Any) -> float:
        return float(10.0 * len(x) + np.sum(x**2 - 10.0 * np.cos(2.0 * np.pi * x)))

    ga = ar.IslandGA(max_evaluations=2500, **options)
    return _search(ga.minimize(function or rastrigin, [(-5.0, 5.0)] * 4, rng=seed))


def identifications() -> Iterator[Case]:
    """Simulated records of nine structures, with options, and every published measurement."""
    for seed, name in enumerate(structures.STRUCTURES):
        yield f"simulated {name}", lambda name=name, seed=seed: _simulated(name, 700 + seed)
    small: dict[str, dict[str, Any]] = {
        "small": {},
        "small welch": {"method": "welch", "nperseg": 1024},
        "small frf rows": {"min_rows": 6, "freq_tol": 0.02, "damping_tol": 0.2},
        "small h2": {"estimator": "h2", "formulation": "joint"},
        "small paper": {"preset": "paper", "estimator": "h1"},
        "small one dof": {"dofs": [1]},
        "small common kept": {"keep_common": True},
        "small depth": {"min_depth_db": 6.0},
    }
    for seed, (name, options) in zip((*range(710, 715), *range(716, 719)), small.items(), strict=True):
        yield name, lambda s=seed, o=options: _set(ar.identify_antiresonances(record(s), **OPTIONS | o))
    three = range(720, 723)
    yield "small three records", lambda: _set(ar.identify_antiresonances([*map(record, three)], **OPTIONS))
    yield "small modes", lambda: _modal(ar.identify_modes(record(723), band_hz=(0.8, 8.0), max_order=20))
    yield "small frf", _frf
    yield from _published()


def _simulated(name: str, seed: int) -> Any:
    make, sensors = structures.STRUCTURES[name]
    made = make(seed)
    signal = made.record(duration_s=120.0, noise=0.01, seed=seed, sensors=sensors)
    given = {"excitation": made.excitation, "band_hz": made.band_hz, "max_order": 40}
    return _set(ar.identify_antiresonances(signal, **given))


def _frf() -> Any:
    curves = ar.transmissibility(record(724), reference=0, nperseg=1024)
    return _set(ar.identify_antiresonances(curves, **OPTIONS))


def _published() -> Iterator[Case]:
    for one in published.structures():
        yield f"published {one.name} {one.excitation}", lambda one=one: _of_curves(one)
    if (published.DATA / "iqs_plates").is_dir():
        for state in ("27A_C60", "36A_S3"):
            yield (
                f"published plate {state}",
                lambda s=state: _of_curves(published.plate(s, published.PLATE_COLUMNS)),
            )
    if (published.DATA / "shake_table").is_dir():
        for kind in ("flexible", "stiff"):
            yield f"published shake table {kind}", lambda kind=kind: _shaken(kind)
    if (published.DATA / "brake_reuss_beam").is_dir():
        yield "published beam", _beam
    if (published.DATA / "frame3_hits").is_dir():
        yield "published hits", _hit


def _of_curves(one: Any) -> Any:
    return _set(ar.identify_antiresonances(one.frfs, excitation=one.excitation, band_hz=one.band_hz))


def _shaken(kind: str) -> Any:
    with np.load(published.DATA / "shake_table" / "records.npz") as file:
        name = next(key for key in file.files if key.startswith(kind) and "orthridge" in key)
        rec = ar.Recording(file[name], float(file["fs_hz"]))
    return _set(ar.identify_antiresonances(rec, excitation=0, band_hz=(2.0, 25.0), check="off"))


def _beam() -> Any:
    from scipy.io import loadmat

    table = loadmat(published.DATA / "brake_reuss_beam" / "HammerImpact.mat", squeeze_me=True)["HIdata"]
    acc = np.stack([np.asarray(table[f"acc{i}"].item(), dtype=float) for i in (1, 2, 3)])
    rec = ar.Recording(acc[:, :32768], 12800.0)
    return _set(ar.identify_antiresonances(rec, excitation="hammer", band_hz=(60.0, 1200.0), check="off"))


def _hit() -> Any:
    path = published.DATA / "frame3_hits" / "imp_ham_set2_nomass.CSV"
    lines = [line for line in path.read_text(encoding="latin-1").splitlines() if line[:1].isdigit()]
    floors = ar.Recording(np.loadtxt(lines, delimiter=",")[:, 1:4].T, 50.0)
    return _set(ar.identify_antiresonances(floors, excitation=1, band_hz=(1.5, 15.0), check="off"))


def _set(found: Any) -> Any:
    parts = {"freq_hz": found, "damping_ratio": found.damping_ratio, "std_hz": found.std_hz}
    return {str(d): {k: p[d].tolist() if d in p else [] for k, p in parts.items()} for d in found}


def _modal(found: Any) -> Any:
    return {"modes": {"freq_hz": found.freq_hz.tolist(), "shapes": np.abs(found.shapes).ravel().tolist()}}


def assessments() -> Iterator[Case]:
    """Chains whose model is wrong by some per cent, with and without a baseline; frames; prepared answers."""
    damages: list[dict[int, float]] = [{}, {0: 0.1}, {2: 0.3}, {4: 0.6}, {1: 0.2, 3: 0.35}]
    damages.append({0: 0.5, 2: 0.2, 4: 0.3})
    for i, losses in enumerate(damages):
        for seed in (810 + i, 830 + i):
            yield f"baseline {losses} {seed}", lambda a=(losses, seed): _assessed(*a)
    yield "baseline, some candidates", lambda: _assessed({2: 0.3}, 850, elements=[0, 1, 3, 4])
    rate, common = ar.SearchOptions(false_alarm_rate=0.2), ar.SearchOptions(std_common=0.002)
    prior = ar.DamagePrior(nothing=0.9, one=0.07, two=0.01, three=0.0, elsewhere=0.01, unknown=0.01)
    yield "baseline, alarm rate", lambda: _assessed({3: 0.05}, 851, search=rate)
    yield "baseline, common", lambda: _assessed({3: 0.25}, 852, search=common)
    yield "baseline, prior", lambda: _assessed({1: 0.1}, 853, prior=prior)
    yield "baseline, two intact", lambda: _assessed({1: 0.15}, 854, intact=2)
    yield "baseline, repeated", lambda: _assessed({0: 0.12}, 855, now=2)
    for seed in (860, 861, 862, 863):
        yield f"no baseline {seed}", lambda seed=seed: _alone(seed)
    for seed in (870, 871, 872):
        yield f"chain8 records {seed}", lambda seed=seed: _records(seed)
    for i, losses in enumerate(damages[:5]):
        yield f"prepared {losses}", lambda a=(losses, 880 + i): _prepared(*a)


def _states(losses: dict[int, float], seed: int, intact: int = 1, now: int = 1) -> tuple[Any, Any]:
    rng, factors = truth(seed)
    lost = np.zeros(N - 1)
    for element, loss in losses.items():
        lost[element] = loss
    before = [one for _ in range(intact) for one in measured(chain(factors), rng)]
    return before, [one for _ in range(now) for one in measured(chain(factors, lost), rng)]


def _assessed(losses: dict[int, float], seed: int, intact: int = 1, now: int = 1, **options: Any) -> Any:
    before, after = _states(losses, seed, intact, now)
    return _judged(ar.assess_damage(NOMINAL, after, baseline=before, workers=1, **options))


def _alone(seed: int) -> Any:
    before, after = _states({seed % 5: 0.4}, seed)
    found = ar.assess_damage(NOMINAL, after, rng=seed, workers=1, optimizer=ar.IslandGA(max_evaluations=3000))
    return {"x": found.x.tolist(), "headline": found.headline}


def _records(seed: int) -> Any:
    case, rng = ar.cases.chain8(), np.random.default_rng(seed)
    sets = []
    for losses in (np.zeros(7), np.eye(7)[seed % 7] * 0.3):
        model = case.true_model(0).with_parameters(ar.stiffness_reduction(range(7)), losses)
        made = {"fs_hz": 512.0, "duration_s": 128.0, "damping_ratio": 0.01, "noise": 0.01}
        signal = model.simulate(excitation=0, **made, responses=list(range(8)), rng=rng)
        sets.append(ar.identify_antiresonances(signal, excitation=0, band_hz=case.band_hz, check="off"))
    return _judged(ar.assess_damage(case.model, sets[1], baseline=sets[0], workers=1))


def _prepared(losses: dict[int, float], seed: int) -> Any:
    before, after = _states(losses, seed)
    found = ar.Assessor(NOMINAL, baseline=before, workers=1).assess(after)
    best = found.hypotheses[0]
    return {"best": [list(best.elements), best.unknown], "full_run_wanted": found.full_run_wanted}


def _judged(found: Any) -> Any:
    return {
        "hypotheses": [[list(one.elements), one.unknown, one.probability] for one in found.hypotheses][:8],
        "severity": {str(e): found.severity[e] for e in found.severity} if found.damaged else {},
        "damaged": list(found.damaged),
        "headline": found.headline,
    }


KINDS = {"searches": searches, "identifications": identifications, "assessments": assessments}


def answer(case: Callable[[], Any]) -> Any:
    """What a case gives, warnings left aside; an error of ours by its name and sentence."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return case()
        except ar.AntiresError as error:
            return {"error": f"{type(error).__name__}: {error}"}
