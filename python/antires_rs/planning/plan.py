"""Where to measure and where to shake."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from ..damage.candidates import checked_model
from ..damage.limits import smallest_found
from ..damage.prior import DamagePrior
from ..models.structural_model import StructuralModel
from ..optimize.arguments import thread_count
from ..support.one_thread import one_blas_thread
from ..support.pickling import FrozenDict, frozen
from ..support.progress import step, waiting
from ..support.validation import FloatArray, choice, integer, reject
from .information import CRITERIA, Information, information
from .placement import Placed, Round, exhaustive, greedy
from .question import Sees, Unknowns, band_of, dofs_of, unknowns_of
from .sensor_plan import SensorPlan
from .value_errors import ExpectedErrors
from .virtual_roots import virtual_roots

__all__ = ["plan_test"]

Search = Literal["greedy", "exhaustive"]


@one_blas_thread
def plan_test(
    model: StructuralModel,
    elements: Any = None,
    *,
    n_sensors: int,
    candidates: Any = None,
    excitations: Any = None,
    band_hz: Any = None,
    noise: float = 0.01,
    duration_s: float = 200.0,
    damping_ratio: float = 0.01,
    std: float | None = None,
    criterion: Literal["determinant", "worst"] = "determinant",
    sees: Sees = "transmissibility",
    search: Search = "greedy",
    prior: DamagePrior | None = None,
    workers: int | None = None,
    progress: bool | None = None,
) -> SensorPlan:
    """Find the sensors and the position of the force whose antiresonances tell most.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        The structure as it is thought to be.
    elements : sequence of int, or of Parameter, optional
        Elements whose damage is to be found against a baseline, zero-based; default as for
        :func:`assess_damage`. Or parameters to be updated from one test.
    n_sensors : int
        How many, from 2 (1 with ``sees='frf'``). With as many as candidates these are judged as they are.
    candidates : sequence of int, optional
        Dofs that may get a sensor. Default: all, of a frame all translations.
    excitations : int or sequence of int, optional
        Dofs where the force may act; one of them is chosen. Default: the candidates.
    band_hz : (float, float), optional
        Band of the identification in Hz. Default: from 0 to above the twelfth elastic resonance.
    noise : float
        Noise of each sensor as a fraction of its rms, in [0, 10].
    duration_s : float
        Length of the record under random excitation, s.
    damping_ratio : float
        Of every mode, in [1e-4, 0.5]; 0.01 is 1 %.
    std : float, optional
        Relative standard deviation of every antiresonance, in (0, 0.5], instead of what noise, duration and
        damping let expect (:mod:`antires_rs.planning.value_errors`).
    criterion : {'determinant', 'worst'}
        Most information on all together, or the smallest loss to be seen in the element where it is largest.
    sees : {'transmissibility', 'frf'}
        What is identified: without the force, roots that all sensors share do not count.
    search : {'greedy', 'exhaustive'}
        Greedy with exchanges, or all sets, for few candidates.
    prior : DamagePrior, optional
        For ``detectable``.
    workers : int, optional
        Threads; the result does not depend on it.
    progress : bool, optional
        Show a line of progress; by default on a terminal.

    Returns
    -------
    SensorPlan
        ``.sensors``, ``.excitation``, ``.value``, ``.detectable`` {element: loss}, ``.excitations``
        {dof: value}, ``.rounds``, ``.value_std`` {dof: errors that were assumed}; prints as a table,
        ``.plot()``.

    Raises
    ------
    InvalidInputError
        Elements or dofs outside the model, too few or too many sensors, nothing in the band.

    Notes
    -----
    Information of small changes, at the model as it is (D-optimality: Kammer 1991, Papadimitriou 2004). What
    larger damage and errors of the model make of it is told by :func:`detectability`.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> plan = ar.plan_test(case.model, n_sensors=3, excitations=[0, 3], criterion="worst")
    >>> plan.excitation, len(plan.sensors), max(plan.detectable.values()) < 0.01
    (3, 3, True)
    """
    unknowns = unknowns_of(checked_model(model), elements)
    sensors = dofs_of("candidates", model, candidates)
    forces = dofs_of("excitations", model, excitations, sensors)
    band = band_of(model, band_hz)
    errors = ExpectedErrors(noise, duration_s, damping_ratio, std)
    choice("criterion", criterion, CRITERIA)
    choice("sees", sees, ("transmissibility", "frf"))
    choice("search", search, ("greedy", "exhaustive"))
    n = _count(n_sensors, len(sensors), sees)
    threads = thread_count(workers)
    find = exhaustive if search == "exhaustive" else greedy
    plans: dict[int, tuple[Placed, Information, int]] = {}
    stds: dict[int, list[FloatArray]] = {}
    with waiting("planning", progress):
        for nth, force in enumerate(forces):
            step(f"force {nth + 1} of {len(forces)}")
            args = (unknowns.parameters, unknowns.nominal, sensors, force, band, sees, errors, threads)
            roots = virtual_roots(model, *args)
            told = information(roots, len(sensors), unknowns.spread, unknowns.tests)
            placed = find(told, n, criterion)
            plans[force] = placed, told, _shown(roots.sensor, roots.common, placed.chosen)
            stds[force] = [roots.std[roots.sensor == at] for at in placed.chosen]
    if not any(shown for _, _, shown in plans.values()):
        reject("band_hz", f"{band[0]:g} to {band[1]:g} Hz", "a band with antiresonances", "Widen it.")
    return _plan(model, unknowns, sensors, band, criterion, prior or DamagePrior(), plans, stds, str(errors))


def _count(n_sensors: Any, n_candidates: int, sees: str) -> int:
    least = 1 if sees == "frf" else 2
    n = integer("n_sensors", n_sensors, low=least)
    if n > n_candidates:
        reject(
            "n_sensors", f"{n} of {n_candidates} candidates", f"{least} to {n_candidates}", "Allow more dofs."
        )
    return n


def _shown(sensor: Any, common: dict[int, FloatArray], chosen: tuple[int, ...]) -> int:
    """Antiresonances of the chosen that at least one other of them does not share."""
    mine = np.flatnonzero(np.isin(sensor, chosen)).tolist()
    others = {root: [c for c in chosen if c != sensor[root]] for root in mine if root in common}
    hidden = sum(bool(rest) and common[root][rest].max() < 0.5 for root, rest in others.items())
    return len(mine) - int(hidden)


def _plan(
    model: StructuralModel,
    unknowns: Unknowns,
    sensors: list[int],
    band_hz: tuple[float, float],
    criterion: str,
    prior: DamagePrior,
    plans: dict[int, tuple[Placed, Information, int]],
    stds: dict[int, list[FloatArray]],
    errors: str,
) -> SensorPlan:
    """The best force and its plan in words and numbers of the user."""
    order = sorted(plans, key=lambda force: -plans[force][0].worth)

    def value(told: Information, chosen: Any) -> float:
        if criterion == "determinant":
            return told.worth(chosen, criterion)
        if unknowns.elements is not None:
            return float(_detectable(told.of(chosen), unknowns, prior).max())
        return float(1.0 / np.sqrt(1.0 + np.diag(told.of(chosen)).min()))

    placed, told, shown = plans[order[0]]
    everywhere = range(len(sensors))
    found = told.of(placed.chosen)
    after = unknowns.spread * np.sqrt(np.diag(np.linalg.inv(np.eye(found.shape[0]) + found)))
    elements = unknowns.elements or ()
    both = [
        dict(zip(elements, _detectable(told.of(chosen), unknowns, prior).tolist(), strict=False))
        for chosen in (placed.chosen, everywhere)
    ]
    dof_of: dict[int | None, int | None] = {None: None, **dict(enumerate(sensors))}
    rounds = tuple(Round(dof_of[one.added], dof_of[one.removed], one.worth) for one in placed.rounds)
    return SensorPlan(
        sensors=tuple(sensors[at] for at in placed.chosen),
        excitation=order[0],
        criterion=criterion,
        value=value(told, placed.chosen),
        value_of_all=value(told, everywhere),
        n_values=shown,
        detectable=FrozenDict(both[0]),
        detectable_by_all=FrozenDict(both[1]),
        std=FrozenDict(zip(unknowns.names, after.tolist(), strict=True)),
        std_before=FrozenDict(zip(unknowns.names, unknowns.spread.tolist(), strict=True)),
        excitations=FrozenDict({force: value(plans[force][1], plans[force][0].chosen) for force in order}),
        rounds=rounds,
        band_hz=band_hz,
        names=FrozenDict(zip(elements, unknowns.names, strict=False)),
        labels=FrozenDict({dof: model.dof_label(dof) for dof in {*sensors, *order}}),
        value_std=FrozenDict(
            {sensors[at]: frozen(own) for at, own in zip(placed.chosen, stds[order[0]], strict=True)}
        ),
        errors=errors,
    )


def _detectable(found: FloatArray, unknowns: Unknowns, prior: DamagePrior) -> FloatArray:
    """Of each element alone, as :func:`assess_damage` tells it after a test."""
    return smallest_found(np.diag(np.sqrt(np.diag(found)) / unknowns.spread), prior)
