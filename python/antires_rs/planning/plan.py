"""Where to measure and where to shake."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from .. import _core
from ..damage.assess import elements_of
from ..damage.inference import smallest_found
from ..damage.options import DamagePrior
from ..damage.shapes import structure_of
from ..exceptions import reject
from ..measured.antiresonance_set import aligned
from ..models.parameters import Parameter, parameter_name, parameter_tuple, stiffness_reduction
from ..models.structural_model import End, StructuralModel, checked_model
from ..optimize.island_ga import thread_count
from ..support.checks import FloatArray, choice, frequency_band, integer, label_text, members, shape_of
from ..support.progress import one_blas_thread, step, waiting
from ..support.values import FrozenDict, ReadOnly, frozen
from ..views import Viewed
from . import placement
from .detection_curves import percent

Sees = Literal["transmissibility", "frf"]
_RESONANCES, _HEADROOM = 12, 1.13  # by default the band ends above so many elastic resonances, by this factor
_RIGID = 1e-4  # below this share of the highest frequency a mode is a rigid motion
UNIFORM = 1.0 / float(np.sqrt(12.0))  # standard deviation of what is uniform between 0 and 1


def _unknowns_of(
    model: StructuralModel, elements: Any
) -> tuple[tuple[Parameter, ...], tuple[str, ...], tuple[int, ...] | None]:
    """Severities of elements with their numbers, or parameters of an updating; and their names."""
    given = [elements] if isinstance(elements, Parameter) else elements
    if isinstance(given, Sequence) and any(isinstance(p, Parameter) for p in given):
        parameters = model._by_number(parameter_tuple(given))
        return parameters, tuple(parameter_name(model, p) for p in parameters), None
    numbers = tuple(elements_of(model, elements))
    return tuple(stiffness_reduction(numbers)), tuple(map(model.element_label, numbers)), numbers


def dofs_of(name: str, model: StructuralModel, dofs: Any, default: list[int] | None = None) -> list[int]:
    """Dofs of the model, each once; by default all but rotations, where names tell them."""
    if dofs is None:
        return model._sensor_dofs if default is None else default
    chosen = [model._dof(name, dof) for dof in ([dofs] if shape_of(dofs) == () else list(dofs))]
    if not chosen or len(set(chosen)) < len(chosen):
        reject(name, dofs, "dofs of the model, each once", "Look them up by model.dof_label.")
    return chosen


def forces_of(name: str, model: StructuralModel, forces: Any, default: list[int]) -> list[End]:
    """Places of the force, each a dof, or the dofs of several forces that act at once."""
    if forces is None or shape_of(forces) == () or all(shape_of(one) == () for one in forces):
        return [*dofs_of(name, model, forces, default)]
    found: list[End] = []
    for one in forces:
        several = dofs_of(name, model, one)
        found.append(several[0] if len(several) == 1 else tuple(sorted(several)))
    return found


def band_of(model: StructuralModel, band_hz: Any) -> tuple[float, float]:
    """The band of the identification; by default up to above the twelfth elastic resonance."""
    if band_hz is not None:
        return frequency_band("band_hz", band_hz, low_hz=0.0, high_hz=np.inf)
    freq = model.modes(min(model.n_dof, _RESONANCES + 6)).freq_hz
    return 0.0, float(_HEADROOM * freq[freq > _RIGID * freq[-1]][:_RESONANCES][-1])


# -- A planned test: its sensors and force, and what it would show

_FORCES = 5  # positions of the force that are printed


@dataclass(frozen=True, eq=False, repr=False)
class SensorPlan(ReadOnly, Viewed):
    """What :func:`plan_test` found; print it for a table.

    Attributes
    ----------
    sensors : tuple of int
        Dofs of the model, in the order of their rounds.
    excitation : int or tuple of int
        Dof of the force, or of all that act at once.
    criterion : {'determinant', 'worst'}
    value, value_of_all : float
        Of the criterion, with these sensors and with one on every candidate: expected information in nats; or
        the largest of ``detectable`` (of parameters, of ``std`` over ``std_before``).
    n_values : int
        Antiresonances in the band that the test would show.
    detectable, detectable_by_all : dict of int to float
        Stiffness loss of each element that nine of ten tests would show, in [0, 0.99], infinity where none
        would: the linear estimate for small losses. Empty for parameters.
    std, std_before : dict of str to float
        Standard deviation of each unknown in its unit: after the test, the others unknown too; and before.
    excitations : dict of int or tuple to float
        ``value`` by position of the force, the best first, each with its own best sensors.
    rounds : tuple of Round
        How the sensors were found, from the first one on.
    names, labels : dict
        What elements and dofs are called.
    value_std, errors : dict of int or tuple to (n,), and str
        Relative standard deviation of each antiresonance of each sensor, or set of them, on which all this
        rests; and whether it was given, or is the Cramer-Rao bound for noise, duration and damping.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.plan_test(ar.cases.chain8().model, n_sensors=3, excitations=0, std=5e-4).sensors
    (0, 3, 1)
    """

    sensors: tuple[int, ...]
    excitation: int | tuple[int, ...]
    criterion: str
    value: float
    value_of_all: float
    n_values: int
    detectable: Mapping[int, float]
    detectable_by_all: Mapping[int, float]
    std: Mapping[str, float]
    std_before: Mapping[str, float]
    excitations: Mapping[int | tuple[int, ...], float]
    rounds: tuple[placement.Round, ...]
    band_hz: tuple[float, float]
    names: Mapping[int, str]
    labels: Mapping[int | tuple[int, ...], str]
    value_std: Mapping[int | tuple[int, ...], FloatArray] = field(default_factory=FrozenDict)
    errors: str = ""

    def __repr__(self) -> str:
        return f"SensorPlan(sensors={self.sensors}, excitation={self.excitation}, {self._value(self.value)})"

    def __str__(self) -> str:
        low, high = self.band_hz
        lines = [
            f"{len(self.sensors)} sensors: " + ", ".join(self.labels[dof] for dof in self.sensors),
            f"force at {self.labels[self.excitation]}",
            f"{self.n_values} antiresonances from {low:g} to {high:g} Hz; {self._value(self.value)}"
            f" (a sensor on every candidate: {self._value(self.value_of_all)})",
        ]
        if self.errors:
            std = np.concatenate([np.empty(0), *self.value_std.values()])
            ends = [f"{100.0 * end:.2g}" for end in (std.min(initial=np.inf), std.max(initial=0.0))]
            lines.append(f"values known to {' to '.join(dict.fromkeys(ends))} %: {self.errors}")
        if len(self.excitations) > 1:
            best = list(self.excitations.items())[:_FORCES]
            names = {dof: f"({own})" if isinstance(dof, tuple) else own for dof, own in self.labels.items()}
            forces = [f"{names[dof]} {self._value(value)}" for dof, value in best]
            lines.append(f"forces: {', '.join(forces)}")
        if self.detectable:
            both = self.detectable, self.detectable_by_all
            rows = [[self.names[e], *(percent(losses[e]) for losses in both)] for e in self.detectable]
            head = ["stiffness loss seen in 9 of 10 tests (%)", "these sensors", "all candidates"]
            lines += ["", *aligned(head, rows, left=head[:1])]
        else:
            rows = [[name, f"{std:.3g}"] for name, std in self.std.items()]
            lines += ["", *aligned(["parameter", "std"], rows, left=["parameter"])]
        return "\n".join(lines)

    def _value(self, value: float) -> str:
        if self.criterion == "determinant":
            return f"{value:.1f} nats"
        return f"worst {100.0 * value:.2g} %" if value != float("inf") else "worst: never"

    def plot(self, ax: Any = None) -> Any:
        """Smallest detectable losses by element; see :func:`antires_rs.figures.plot_plan`."""
        return self._view("plot")(self, ax=ax)


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
        How many, from 2 (1 with ``sees='frf'``), of r forces r - 1 more. With as many as candidates these
        are judged as they are.
    candidates : sequence of int, optional
        Dofs that may get a sensor. Default: all, of a frame all translations.
    excitations : int or sequence of int or of tuples, optional
        Dofs where the force may act; one of them is chosen. Default: the candidates. A tuple stands for
        unknown forces that act at once at its dofs, whose antiresonances belong to sets of as many sensors.
    band_hz : (float, float), optional
        Band of the identification in Hz. Default: from 0 to above the twelfth elastic resonance.
    noise, duration_s, damping_ratio : float
        Noise of each sensor as a fraction of its rms, in [0, 10]; length of the record under random
        excitation, s; damping of every mode, in [1e-4, 0.5].
    std : float, optional
        Relative standard deviation of every antiresonance, in (0, 0.5], instead of what these let expect.
    criterion : {'determinant', 'worst'}
        Most information on all together, or the smallest loss to be seen in the element where it is largest.
    sees : {'transmissibility', 'frf'}
        What is identified: without the force, roots that all sensors share do not count.
    search : {'greedy', 'exhaustive'}
        Greedy with exchanges, or all sets, for few candidates.
    prior : DamagePrior, optional
        For ``detectable``.
    workers, progress
        Threads, and a line of progress, as of :func:`update`.

    Returns
    -------
    SensorPlan

    Notes
    -----
    Information of small changes, at the model as it is (D-optimality: Kammer 1991, Papadimitriou 2004); of
    larger damage see :func:`detectability`. Sets for a frame are compared by their mean over structures that
    it may stand for: their elements move between the nodes, joints turn and supports yield, as the
    assessment learns them. A band without antiresonances is an ``InvalidInputError``.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.plan_test(ar.cases.chain8().model, n_sensors=3, excitations=[0, 3], criterion="worst").excitation
    3
    """
    parameters, names, numbers = _unknowns_of(checked_model(model), elements)
    nominal = _core.nominal_values(model._core, model.description.core_parameters(parameters))
    spread = UNIFORM * np.array([high - low for low, high in (p.bounds for p in parameters)])
    sensors = dofs_of("candidates", model, candidates)
    forces = forces_of("excitations", model, excitations, sensors)
    band = band_of(model, band_hz)
    errors = placement.ExpectedErrors(noise, duration_s, damping_ratio, std)
    choice("criterion", criterion, placement.CRITERIA)
    choice("sees", sees, ("transmissibility", "frf"))
    choice("search", search, ("greedy", "exhaustive"))
    least = max(len(members(force)) for force in forces) + (sees != "frf")
    n, most = integer("n_sensors", n_sensors, low=least), len(sensors)
    if n > most:
        reject("n_sensors", f"{n} of {most} candidates", f"{least} to {most}", "Allow more dofs.")
    threads = thread_count(workers)
    find = placement.exhaustive if search == "exhaustive" else placement.greedy
    plans: dict[End, tuple[placement.Placed, placement.Information, placement.Worth]] = {}
    found: dict[End, placement.VirtualRoots] = {}
    forms = structure_of(model, band[1]).forms()
    with waiting("planning", progress):
        for nth, force in enumerate(forces):
            step(f"force {nth + 1} of {len(forces)}")
            layout = placement.Layout(model, tuple(sensors), force, band, sees)
            every = [layout, *(replace(layout, base=form) for form in forms)]
            rooted = [placement.virtual_roots(one, parameters, nominal, errors, threads) for one in every]
            found[force] = rooted[0]
            # Severities come from the difference of two tests, parameters from one.
            tests = 1 if numbers is None else 2
            told, *others = (placement.information(one, layout, spread, tests) for one in rooted)
            worth = placement.Worth(tuple(others) or (told,), criterion)
            plans[force] = find(worth, n), told, worth

    def shown(force: End, chosen: Sequence[int] = ()) -> int:
        """Antiresonances of the chosen that not all of them share."""
        placed, told, _ = plans[force]
        own = chosen or placed.chosen
        return int(np.isin(found[force].sensor, told.responses(own)).sum()) - told.n_hidden(own)

    if not any(map(shown, plans)):
        reject("band_hz", band, "a band with antiresonances", "Widen it, or put sensors elsewhere.")

    def detectable(force: End, chosen: Sequence[int]) -> FloatArray:
        """Of each element, as :func:`assess_damage` tells it after a test."""
        size, ways = np.linalg.eigh(plans[force][1].of(chosen))
        slopes = np.sqrt(np.maximum(size, 0.0))[:, None] * ways.T / spread
        return smallest_found(slopes, prior or DamagePrior(), n_values=shown(force, chosen))

    def value(force: End, chosen: Sequence[int]) -> float:
        _, told, worth = plans[force]
        if criterion == "determinant":
            return float(worth.of([chosen])[0])
        if numbers is not None:
            return float(detectable(force, chosen).max())
        return float(1.0 / np.sqrt(1.0 + np.diag(told.of(chosen)).min()))

    order = sorted(plans, key=lambda force: -plans[force][0].worth)
    placed, told, _ = plans[order[0]]
    roots, everywhere = found[order[0]], range(len(sensors))
    responses = placement.Layout(model, tuple(sensors), order[0], band, sees).responses
    of_placed = placed.chosen if isinstance(order[0], int) else told.responses(placed.chosen).tolist()
    of_set = told.of(placed.chosen)
    after = spread * np.sqrt(np.diag(np.linalg.inv(np.eye(of_set.shape[0]) + of_set)))
    elements = numbers or ()
    dof_of: dict[int | None, int | None] = {None: None, **dict(enumerate(sensors))}

    def by_element(chosen: Sequence[int]) -> FrozenDict[int, float]:
        own = detectable(order[0], chosen).tolist() if elements else ()
        return FrozenDict(zip(elements, own, strict=True))

    return SensorPlan(
        sensors=tuple(sensors[at] for at in placed.chosen),
        excitation=order[0],
        criterion=criterion,
        value=value(order[0], placed.chosen),
        value_of_all=value(order[0], everywhere),
        n_values=shown(order[0]),
        detectable=by_element(placed.chosen),
        detectable_by_all=by_element(everywhere),
        std=FrozenDict(zip(names, after.tolist(), strict=True)),
        std_before=FrozenDict(zip(names, spread.tolist(), strict=True)),
        excitations=FrozenDict({force: value(force, plans[force][0].chosen) for force in order}),
        rounds=tuple(placement.Round(dof_of[r.added], dof_of[r.removed], r.worth) for r in placed.rounds),
        band_hz=band,
        names=FrozenDict(zip(elements, names, strict=False)),
        labels=FrozenDict({end: label_text(end, model.dof_label) for end in {*sensors, *order}}),
        value_std=FrozenDict({responses[at]: frozen(roots.std[roots.sensor == at]) for at in of_placed}),
        errors=str(errors),
    )
