"""Which damage a test would show, and how probably."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from ..damage.assess import elements_of
from ..damage.inference import HIGHEST, smallest_found
from ..damage.measured_states import roots_at
from ..damage.options import DamagePrior, SearchOptions, checked_prior
from ..exceptions import reject
from ..models.parameters import stiffness_reduction
from ..models.structural_model import End, StructuralModel, checked_model
from ..optimize.island_ga import seed_of, thread_count
from ..support.checks import FloatArray, choice, finite_scalar, integer, real_array
from ..support.progress import one_blas_thread, waiting
from ..support.values import FrozenDict, frozen
from .detection_curves import DetectionCurves, crossing, fit_logit, reached
from .placement import ExpectedErrors, Layout
from .plan import Sees, band_of, dofs_of
from .simulated_tests import Task, VirtualTest, predicted, simulated

#: Severities of a prediction, in units of the linear estimate; and where that is none.
_UNITS, _LARGE = np.geomspace(0.25, 6.0, 14), np.array([0.1, 0.2, 0.3, 0.45, 0.6, 0.75, 0.85, 0.95])
#: Structures of a prediction that only finds the range of severities for simulated tests, and that range.
_SCOUTS, _RANGE = 4, (0.35, 2.5)
_HIGH = 0.97
_CURVE = 40  # points of a fitted curve


@one_blas_thread
def detectability(
    model: StructuralModel,
    elements: Any = None,
    *,
    excitation: int | tuple[int, ...],
    sensors: Any = None,
    band_hz: Any = None,
    noise: float = 0.01,
    duration_s: float = 200.0,
    damping_ratio: float = 0.01,
    std: float | None = None,
    model_error: float = 0.03,
    method: Literal["predicted", "simulated"] = "predicted",
    n_tests: int | None = None,
    severities: Any = None,
    sees: Sees = "transmissibility",
    prior: DamagePrior | None = None,
    false_alarm_rate: float | None = None,
    rng: int | np.random.Generator | None = None,
    workers: Any = None,
    progress: bool | None = None,
) -> DetectionCurves:
    """Tell the probability of detection of damage, by element and severity, before any test is made.

    Structures are drawn about the model, each with a test of the intact and one of the damaged state, and
    assessed as :func:`assess_damage` does with a baseline.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        The structure as it is thought to be; tests are assessed with it.
    elements, band_hz, noise, duration_s, damping_ratio, std, sees
        Candidates and the kind of test, as for :func:`plan_test`.
    excitation : int or tuple of int
        Dof of the force, or of all unknown forces that act at once.
    sensors : sequence of int, optional
        Dofs of the sensors. Default: all, of a frame all translations. A plan's: ``plan.sensors``.
    model_error : float
        Standard deviation of the logarithm of every stiffness and mass about the model's, in (0, 0.3].
    method : {'predicted', 'simulated'}
        By the evidence of single elements, the model being evaluated on a grid of severities for each of a
        few structures; or by whole assessments, each of a structure of its own, with a curve fitted to them.
    n_tests : int, optional
        Structures of a prediction, default 12; or simulated tests of each element, default 60, from 10 on (as
        many are made intact).
    severities : array_like, optional
        Stiffness losses in (0, 0.99), ascending: at which to predict, or between whose ends to simulate.
        Default: about those of interest.
    prior, false_alarm_rate
        As for :func:`assess_damage`.
    rng, progress
        As of :func:`update`. After Ctrl-C what is there is returned.
    workers : int, str or executor, optional
        A number of threads. Simulated tests may also be spread, as by :meth:`IslandGA.minimize`.

    Returns
    -------
    DetectionCurves

    Notes
    -----
    Every antiresonance in the band counts as identified, with Gaussian errors; clutter and lost values are
    not simulated. MIL-HDBK-1823A has the terms. A band without any is an ``InvalidInputError``.

    Examples
    --------
    >>> import antires_rs as ar
    >>> model = ar.MassSpringChain([1.0, 1.2, 1.0, 0.9], [500.0, 450.0, 550.0])
    >>> sorted(ar.detectability(model, excitation=0, std=5e-4, n_tests=3, rng=0).a90)
    [0, 1, 2]
    """
    chosen = tuple(elements_of(checked_model(model), elements))
    several = dofs_of("excitation", model, excitation)
    force: End = several[0] if len(several) == 1 else tuple(sorted(several))
    dofs = dofs_of("sensors", model, sensors)
    band, errors = band_of(model, band_hz), ExpectedErrors(noise, duration_s, damping_ratio, std)
    finite_scalar("model_error", model_error, low=0.0, high=0.3, low_open=True)
    choice("method", method, ("predicted", "simulated"))
    choice("sees", sees, ("transmissibility", "frf"))
    if len(dofs) == 1 and sees == "transmissibility":
        reject("sensors", "1 sensor", "at least 2, for transmissibilities", "Add one, or pass sees='frf'.")
    if len(dofs) < len(several) + (len(several) > 1 and sees == "transmissibility"):
        got, wanted = f"{len(dofs)} for {len(several)} forces", f"{len(several) + (sees != 'frf')} or more"
        reject("sensors", got, wanted, "Add sensors: values belong to sets of as many as there are forces.")
    options = SearchOptions(false_alarm_rate=false_alarm_rate).checked()
    given = None if severities is None else _severities(severities)
    spread = isinstance(workers, str) or callable(getattr(workers, "submit", getattr(workers, "map", None)))
    threads = thread_count(None if spread else workers)
    seed = np.random.SeedSequence(seed_of(rng))
    judging = (checked_prior(prior, options), options)
    layout = Layout(model, tuple(dofs), force, band, sees)
    test, slopes = _virtual_test(layout, chosen, errors, model_error, threads)
    grid = [_around(loss) if given is None else given for loss in smallest_found(slopes, judging[0])]
    names = {e: model.element_label(e) for e in chosen}
    rows: dict[int, tuple[Any, ...]] = {}
    with waiting("predicting" if method == "predicted" else "simulating tests", progress):
        if method == "predicted":
            count = integer("n_tests", 12 if n_tests is None else n_tests, low=1)
            shares, calls, done = predicted(test, grid, *judging, seed.spawn(count), threads)
            for e, a, p in zip(chosen, grid, shares, strict=True):
                rows[e] = frozen(a), frozen(p), crossing(a, p, 0.5), crossing(a, p, 0.9)
            return _curves("predicted", rows, names, calls, done, count)
        count = integer("n_tests", 60 if n_tests is None else n_tests, low=10)
        scouts, own = seed.spawn(2)
        ranges = [(float(each[0]), float(each[-1])) for each in grid]
        if given is None:
            shares, _, _ = predicted(test, grid, *judging, scouts.spawn(_SCOUTS), threads)
            ranges = [_range(a, b) for a, b in zip(grid, shares, strict=True)]
        losses = [np.geomspace(low, high, count) for low, high in ranges]
        cases: list[tuple[int | None, float]] = []
        # Low and high losses of each element and intact tests by turns: Ctrl-C leaves something of all.
        for nth in np.argsort(np.argsort(0.618034 * np.arange(count) % 1.0)):
            cases += [*((at, float(each[nth])) for at, each in enumerate(losses)), (None, 0.0)]
        drawn = zip(cases, own.spawn(len(cases)), strict=True)
        tasks = [Task(*case, *judging, each, 1 if spread else threads) for case, each in drawn]
        declared = simulated(test, tasks, workers if spread else None)
    made = list(zip(tasks, declared, strict=False))
    for at, (e, between) in enumerate(zip(chosen, losses, strict=True)):
        own_tests = sorted((t.severity, float(e in found)) for t, found in made if t.place == at)
        if own_tests:
            severity = np.geomspace(between[0], between[-1], _CURVE)
            results = np.array(own_tests).T
            fit = fit_logit(results[0], results[1] > 0.5)
            ends = (reached(fit.a50), reached(fit.a90), fit.bound)
            rows[e] = (frozen(severity), frozen(fit.at(severity)), *ends, frozen(results))
    intact = [bool(found) for task, found in made if task.place is None]
    calls = float(np.mean(intact)) if intact else float("nan")
    return _curves("simulated", rows, {e: names[e] for e in rows}, calls, len(made), len(tasks))


def _curves(
    method: str, rows: dict[int, tuple[Any, ...]], names: dict[int, str], calls: float, done: int, wanted: int
) -> DetectionCurves:
    """The curves of ``rows``: of each element severities, pod, a50, a90 and, of tests, a90_95 and these."""
    columns: Any = [FrozenDict(zip(rows, own, strict=True)) for own in zip(*rows.values(), strict=True)]
    severity, pod, a50, a90, bound, tests = columns + [FrozenDict()] * (6 - len(columns))
    told: Any = calls, tests, done, done < wanted, FrozenDict(names)
    return DetectionCurves(method, severity, pod, a50, a90, bound, *told)


def _virtual_test(
    layout: Layout, elements: tuple[int, ...], errors: ExpectedErrors, model_error: float, threads: int
) -> tuple[VirtualTest, FloatArray]:
    """The test, and how many of its errors each severity moves the values in the band."""
    core = layout.roots(stiffness_reduction(elements), layout.band_hz[1], layout.sees)
    roots = roots_at(core, np.zeros((1, len(elements))), slopes=True, threads=threads)[0]
    own = [roots.log_f[roots.response == nth] for nth in range(len(layout.responses))]
    std = errors.of(layout, [np.exp(each) for each in own])
    inside = layout.inside(roots)
    if not inside.any():
        reject("band_hz", layout.band_hz, "a band with antiresonances", "Widen it, or put sensors elsewhere.")
    test = VirtualTest(layout, elements, tuple(zip(own, std, strict=True)), model_error)
    return test, (roots.slopes / (np.sqrt(2.0) * np.concatenate(std)[:, None]))[inside]


def _severities(given: Any) -> FloatArray:
    wanted = "ascending stiffness losses in (0, 0.99), at least two"
    found = real_array("severities", given, ndim=1, wanted=wanted)
    if found.size < 2 or found[0] <= 0.0 or found[-1] >= HIGHEST or (np.diff(found) <= 0.0).any():
        reject("severities", given, wanted, "Give losses such as np.geomspace(0.01, 0.9, 12).")
    return found


def _around(loss: float) -> FloatArray:
    """Severities at which to predict, from a linear estimate."""
    if not np.isfinite(loss):
        return _LARGE
    near = _UNITS * loss
    return np.asarray(np.concatenate([near[near < _LARGE[-1]], _LARGE[1.1 * near[-1] < _LARGE]]))


def _range(severity: FloatArray, share: FloatArray) -> tuple[float, float]:
    """Between which severities found and missed change over."""
    a50, a90 = (crossing(severity, share, level) for level in (0.5, 0.9))
    low = _RANGE[0] * (a50 if np.isfinite(a50) else severity[0] / _RANGE[0])
    high = min(_RANGE[1] * a90, _HIGH)
    return float(min(low, 0.5 * high)), float(high)
