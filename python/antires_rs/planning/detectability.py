"""Which damage a test would show, and how probably."""

from __future__ import annotations

from math import gcd
from typing import Any, Literal

import numpy as np

from ..damage.assess import checked_model, elements_of
from ..damage.evidence import HIGHEST
from ..damage.inference import smallest_found
from ..damage.measured_states import roots_at
from ..damage.options import DamagePrior, SearchOptions, checked_prior
from ..exceptions import reject
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import seed_of, thread_count
from ..support.checks import FloatArray, choice, finite_scalar, integer, real_array
from ..support.progress import one_blas_thread, waiting
from ..support.values import FrozenDict, frozen
from .detection_curves import DetectionCurves, crossing, fit_logit, reached
from .plan import Sees, band_of, dofs_of
from .simulated_tests import Task, VirtualTest, predicted, simulated
from .virtual_roots import ExpectedErrors, objective

#: Severities of a prediction, in units of the linear estimate; and where that is none.
_UNITS, _LARGE = np.geomspace(0.25, 6.0, 14), np.array([0.1, 0.2, 0.3, 0.45, 0.6, 0.75, 0.85, 0.95])
#: Structures of a prediction that only finds the range of severities for simulated tests, and that range.
_SCOUTS, _RANGE = 4, (0.35, 2.5)
_HIGH = 0.97
#: Points of a fitted curve.
_CURVE = 40


@one_blas_thread
def detectability(
    model: StructuralModel,
    elements: Any = None,
    *,
    excitation: int,
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
    elements : sequence of int, optional
        Candidates, zero-based; default as for :func:`assess_damage`.
    excitation : int
        Dof of the force.
    sensors : sequence of int, optional
        Dofs of the sensors. Default: all, of a frame all translations. A plan's: ``plan.sensors``.
    band_hz, noise, duration_s, damping_ratio, std, sees
        Of the test, as for :func:`plan_test`.
    model_error : float
        Standard deviation of the logarithm of every stiffness and mass of the structure about its model's, in
        (0, 0.3]; 0.03 is 3 %.
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
    rng : int or numpy Generator, optional
        The same seed gives the same bits for any number of workers.
    workers : int, str or executor, optional
        A number of threads. Simulated tests may also be spread: over ``"processes"``, ``"threads"``, or
        anything with ``submit`` or ``map``, such as a ``ProcessPoolExecutor`` or a Dask ``Client``.
    progress : bool, optional
        Show a line of progress; by default on a terminal. After Ctrl-C what is there is returned.

    Returns
    -------
    DetectionCurves
        ``.pod``, ``.a50``, ``.a90``, ``.a90_95`` {element: loss}, ``.false_call_rate``; prints as a table,
        ``.plot()``.

    Raises
    ------
    InvalidInputError
        Elements or dofs outside the model, a band without antiresonances, numbers out of range.

    Notes
    -----
    Every antiresonance in the band counts as identified, with Gaussian errors; clutter and lost values are
    not simulated. MIL-HDBK-1823A has the terms.

    Examples
    --------
    >>> import antires_rs as ar
    >>> model = ar.MassSpringChain([1.0, 1.2, 1.0, 0.9], [500.0, 450.0, 550.0])
    >>> curves = ar.detectability(model, excitation=0, std=5e-4, n_tests=3, rng=0)
    >>> sorted(curves.a90), max(curves.a90.values()) < 0.05, curves.false_call_rate < 0.05
    ([0, 1, 2], True, True)
    """
    chosen = tuple(elements_of(checked_model(model), elements))
    if len(set(chosen)) < len(chosen):
        reject("elements", "an element twice", "each element once", "Drop the second one.")
    (force,) = dofs_of("excitation", model, excitation)
    dofs = dofs_of("sensors", model, sensors)
    band, errors = band_of(model, band_hz), ExpectedErrors(noise, duration_s, damping_ratio, std)
    finite_scalar("model_error", model_error, low=0.0, high=0.3, low_open=True)
    choice("method", method, ("predicted", "simulated"))
    choice("sees", sees, ("transmissibility", "frf"))
    if len(dofs) == 1 and sees == "transmissibility":
        reject("sensors", "1 sensor", "at least 2, for transmissibilities", "Add one, or pass sees='frf'.")
    options = SearchOptions(false_alarm_rate=false_alarm_rate).checked()
    given = None if severities is None else _severities(severities)
    spread = isinstance(workers, str) or callable(getattr(workers, "submit", getattr(workers, "map", None)))
    threads = thread_count(None if spread else workers)
    seed = np.random.SeedSequence(seed_of(rng))
    judging = (checked_prior(prior, options), options)
    test, linear = _virtual_test(
        model, chosen, dofs, force, band, sees, errors, model_error, judging[0], threads
    )
    grid = [_around(loss) if given is None else given for loss in linear]
    names = FrozenDict({e: model.element_label(e) for e in chosen})
    with waiting("predicting" if method == "predicted" else "simulating tests", progress):
        if method == "predicted":
            count = integer("n_tests", 12 if n_tests is None else n_tests, low=1)
            share, calls, done = predicted(test, grid, *judging, seed.spawn(count), threads)
            return _predicted(chosen, grid, share, calls, done, count, names)
        count = integer("n_tests", 60 if n_tests is None else n_tests, low=10)
        scouts, own = seed.spawn(2)
        ranges = [(float(each[0]), float(each[-1])) for each in grid]
        if given is None:
            share, _, _ = predicted(test, grid, *judging, scouts.spawn(_SCOUTS), threads)
            ranges = [_range(a, b) for a, b in zip(grid, share, strict=True)]
        losses = [np.geomspace(low, high, count) for low, high in ranges]
        seeds = own.spawn((len(chosen) + 1) * count)
        cases = [(at, loss) for nth in range(count) for at, loss in _nth(losses, nth)]
        tasks = [
            Task(at, loss, *judging, each, 1 if spread else threads)
            for (at, loss), each in zip(cases, seeds, strict=True)
        ]
        declared = simulated(test, tasks, workers if spread else None)
    return _simulated(chosen, losses, tasks, declared, names)


def _virtual_test(
    model: StructuralModel,
    elements: tuple[int, ...],
    sensors: list[int],
    force: int,
    band: tuple[float, float],
    sees: Sees,
    errors: ExpectedErrors,
    model_error: float,
    prior: DamagePrior,
    threads: int,
) -> tuple[VirtualTest, FloatArray]:
    """The test, and the severity of each candidate that it shows by the linear estimate."""
    core = objective(model, tuple(stiffness_reduction(list(elements))), sensors, force, band[1], sees)
    roots = roots_at(core, np.zeros((1, len(elements))), slopes=True, threads=threads)[0]
    own = [roots.log_f[roots.response == nth] for nth in range(len(sensors))]
    std = errors.of(model, sensors, force, [np.exp(each) for each in own], band[1])
    pairs = tuple((a, b) for a, b in zip(own, std, strict=True))
    test = VirtualTest(model, elements, tuple(sensors), force, band, sees, pairs, model_error)
    inside = test.inside(roots)
    if not inside.any():
        reject("band_hz", f"{band[0]:g} to {band[1]:g} Hz", "a band with antiresonances", "Widen it.")
    rows = roots.slopes / (np.sqrt(2.0) * np.concatenate(std)[:, None])
    return test, smallest_found(rows[inside], prior)


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


def _nth(losses: list[FloatArray], nth: int) -> list[tuple[int | None, float]]:
    """A test of each element, and an intact one: in this order, so that Ctrl-C leaves something of all."""
    # Low and high losses take turns.
    return [*((at, float(each[_turn(each.size)[nth]])) for at, each in enumerate(losses)), (None, 0.0)]


def _turn(count: int) -> list[int]:
    """0 to count - 1, in strides of about 0.62 count, each once."""
    stride = next(s for s in range(round(0.62 * count), 2 * count) if gcd(s, count) == 1)
    return [(nth * stride) % count for nth in range(count)]


def _predicted(
    elements: tuple[int, ...],
    severities: list[FloatArray],
    share: list[FloatArray],
    calls: float,
    done: int,
    wanted: int,
    names: FrozenDict[int, str],
) -> DetectionCurves:
    pairs = list(zip(elements, severities, share, strict=True))
    return DetectionCurves(
        method="predicted",
        severity=FrozenDict({e: frozen(a) for e, a, _ in pairs}),
        pod=FrozenDict({e: frozen(p) for e, _, p in pairs}),
        a50=FrozenDict({e: crossing(a, p, 0.5) for e, a, p in pairs}),
        a90=FrozenDict({e: crossing(a, p, 0.9) for e, a, p in pairs}),
        a90_95=FrozenDict(),
        false_call_rate=calls,
        tests=FrozenDict(),
        n_tests=done,
        interrupted=done < wanted,
        names=names,
    )


def _simulated(
    elements: tuple[int, ...],
    losses: list[FloatArray],
    tasks: list[Task],
    declared: list[tuple[int, ...]],
    names: FrozenDict[int, str],
) -> DetectionCurves:
    done = list(zip(tasks, declared, strict=False))
    intact = [bool(found) for task, found in done if task.place is None]
    severity, pod, tests = {}, {}, {}
    fits = {}
    for at, e in enumerate(elements):
        own = [(task.severity, float(e in found)) for task, found in done if task.place == at]
        rows = np.array(sorted(own), dtype=np.float64).reshape(-1, 2).T
        severity[e] = np.geomspace(losses[at][0], losses[at][-1], _CURVE)
        tests[e] = rows
        if rows.shape[1]:
            fits[e] = fit_logit(rows[0], rows[1] > 0.5)
            pod[e] = fits[e].at(severity[e])
    kept = [e for e in elements if e in fits]
    return DetectionCurves(
        method="simulated",
        severity=FrozenDict({e: frozen(severity[e]) for e in kept}),
        pod=FrozenDict({e: frozen(pod[e]) for e in kept}),
        a50=FrozenDict({e: reached(fits[e].a50) for e in kept}),
        a90=FrozenDict({e: reached(fits[e].a90) for e in kept}),
        a90_95=FrozenDict({e: fits[e].bound for e in kept}),
        false_call_rate=float(np.mean(intact)) if intact else float("nan"),
        tests=FrozenDict({e: frozen(tests[e]) for e in kept}),
        n_tests=len(done),
        interrupted=len(done) < len(tasks),
        names=FrozenDict({e: names[e] for e in kept}),
    )
