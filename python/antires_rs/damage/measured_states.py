"""Two states of a structure, as values side by side: what was measured intact, and as it is now."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import FloatArray, reject
from ..updating.antiresonance_targets import AntiresonanceTargets
from ..updating.model_dofs import antiresonance_objective
from .association import ALONE, associate
from .common_responses import not_in_both
from .roots import Roots
from .same_data import note_of_same_data, same_data

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["ASSUMED_STD", "LEAST_STD", "Responses", "Values", "measured_states", "scatter_between"]

#: Relative standard deviation of a value that has none, and the least of one from a single curve: its noise
#: tells little of how another test would come out.
ASSUMED_STD = 5e-4
#: No value is known better.
LEAST_STD = 2e-6
#: So many repeated values tell how much tests scatter.
_LEAST_REPEATS = 5
#: In the scan: distance in ln f beyond which a value counts as unexplained; places of the responses on one
#: line, so that one search in it serves all.
_FAR, _APART = 0.2, 100.0

#: Response dof, force dof, frequencies (Hz), what they see, number of those measured together.
Part = tuple[int, int, FloatArray, str | None, int]


@dataclass(frozen=True)
class Values:
    """Measured values of one state, (m,) each: response by number, ln f, relative std, number of the test.

    They ascend within each response of each test. ``asked`` are response and test (k, 2) of all measured,
    with or without a value; None for those that have one.
    """

    response: NDArray[np.intp]
    log_f: FloatArray
    std: FloatArray
    test: NDArray[np.intp]
    asked: NDArray[np.intp] | None = field(default=None, kw_only=True)

    @property
    def size(self) -> int:
        """How many."""
        return int(self.log_f.size)

    @cached_property
    def tests(self) -> NDArray[np.intp]:
        """Numbers of the tests that have values."""
        return np.unique(self.test)

    @cached_property
    def _times_measured(self) -> FloatArray:
        """By response: in how many tests it was measured."""
        asked = np.stack([self.response, self.test], axis=1) if self.asked is None else self.asked
        return np.bincount(np.unique(asked, axis=0)[:, 0]).astype(np.float64)

    def times_measured(self, response: NDArray[np.intp]) -> FloatArray:
        """In how many tests each of some responses was measured."""
        times = np.zeros(max(int(response.max(initial=-1)) + 1, self._times_measured.size))
        times[: self._times_measured.size] = self._times_measured
        return times[response]

    def noisier(self, times: float) -> Values:
        """The same with larger standard deviations."""
        return replace(self, std=times * self.std)

    @property
    def frequencies(self) -> FloatArray:
        """ln f of all that have a frequency."""
        return self.log_f

    @property
    def plain(self) -> Values:
        """Frequencies alone."""
        return self

    def associated(
        self,
        roots: Roots,
        place: FloatArray,
        sigma: FloatArray,
        alone: float,
        price: FloatArray,
        wider: float = 1.0,
    ) -> tuple[NDArray[np.intp], FloatArray, float]:
        """Root of each value, test by test, the values as seen from there, and what those without one cost.

        The roots are expected at ``place`` with errors ``sigma``; ``alone`` is the price of a value without
        root, ``price`` that of each root without value; all errors count ``wider``.
        """
        found = np.full(self.size, ALONE)
        for test in self.tests:
            own = np.flatnonzero(self.test == test)
            value = (self.response[own], self.log_f[own], wider * self.std[own])
            found[own] = associate(value, (roots.response, place, wider * sigma), alone, price)
        return found, self.log_f, alone * int(np.sum(found < 0))

    def unexplained(self, roots: Roots, place: FloatArray) -> float:
        """Sum of the distances of the values from the nearest roots of their responses."""
        place = np.sort(place + _APART * roots.response)
        place = np.concatenate([[-np.inf], place, [np.inf]])
        value = self.log_f + _APART * self.response
        after = np.searchsorted(place, value)
        near = np.minimum(value - place[after - 1], place[after] - value)
        return float(np.minimum(near, _FAR).sum())


def scatter_between(values: Values, place: FloatArray, root: NDArray[np.intp]) -> float:
    """Scatter of several tests of one state over what their standard deviations say; at least 1.

    ``root`` tells which values are of one root, ``place`` the values as seen from there. 1 where fewer than
    ``_LEAST_REPEATS`` repeats tell.
    """
    total, spare = 0.0, 0
    for number in np.unique(root[root >= 0]):
        own = np.flatnonzero(root == number)
        weight = values.std[own] ** -2
        mean = np.sum(weight * place[own]) / weight.sum()
        total += float(np.sum(weight * (place[own] - mean) ** 2))
        spare += own.size - 1
    return float(max(np.sqrt(total / spare), 1.0)) if spare >= _LEAST_REPEATS else 1.0


@dataclass(frozen=True)
class Responses:
    """The responses of all sets, as the core is asked for them."""

    parts: list[Part]
    #: Of each set of now, its responses' numbers by label.
    labels: list[dict[Any, int]]
    #: Sentences on values that are not compared.
    left_out: tuple[str, ...]
    #: Whether standard deviations had to be assumed.
    assumed: bool
    measured: tuple[AntiresonanceSet, ...]
    #: Force of each test of the intact structure.
    tests: tuple[int, ...]
    noun = "antiresonances"

    def source(self, model: StructuralModel, parts: Any) -> _core.Objective:
        """The model's antiresonances, to be asked for."""
        return antiresonance_objective(model, parts, self.parts, "squared", None, 0.0, None)

    def corrected(
        self, now: Values, roots: Roots, partner: NDArray[np.intp], beside: FloatArray
    ) -> list[AntiresonanceSet]:
        """The sets of now without what is wrong in both states."""
        sets = []
        for nth, (each, labels) in enumerate(zip(self.measured, self.labels, strict=True)):
            freq, std = {}, {}
            for label, number in labels.items():
                own = (now.test == nth) & (now.response == number)
                corrected = np.exp(now.log_f[own] - beside[own])
                order = np.argsort(corrected, kind="stable")
                freq[label] = corrected[order]
                std[label] = now.std[own][order] * freq[label]
            channels = each.channels or None
            sets.append(
                AntiresonanceSet(each.excitation, freq, std_hz=std, sees=each.sees, channels=channels)
            )
        return sets


def measured_states(
    model: StructuralModel, baseline: Sequence[AntiresonanceSet], measured: Sequence[AntiresonanceSet]
) -> tuple[Responses, Values, Values]:
    """The responses of all sets, the intact values and those of now.

    Raises
    ------
    InvalidInputError
        A set of now whose force no intact one has, dofs outside the model, nothing measured, no response in
        both states.
    """
    before = [AntiresonanceTargets(model, (each,)) for each in baseline]
    after = [AntiresonanceTargets(model, (each,)) for each in measured]
    _same_forces(before, after, measured)
    numbers: dict[tuple[int, int], int] = {}
    freq: list[list[FloatArray]] = []
    sight: dict[int, set[str | None]] = {}
    for target in (*before, *after):
        for dof, force, values, sees, _ in target.parts:
            sight.setdefault(force, set()).add(sees)
            if numbers.setdefault((dof, force), len(numbers)) == len(freq):
                freq.append([])
            freq[numbers[dof, force]].append(values)
    together = {force: nth for nth, force in enumerate(sight)}
    twice = [same_data([_columns(target) for target in targets]) for targets in (before, after)]
    parts: list[Part] = [
        (dof, force, np.concatenate(freq[nth]), _common(sight[force]), together[force])
        for (dof, force), nth in numbers.items()
    ]
    if not any(part[2].size for part in parts):
        reject("measured", "no antiresonance", "at least one", "Identify in a wider band, or at more dofs.")
    responses = Responses(
        parts,
        [
            {
                label: numbers[dof, target.forces[0]]
                for label, dof in zip(each, target.dofs_of[0], strict=True)
            }
            for each, target in zip(measured, after, strict=True)
        ],
        (
            *(note for target in (*before, *after) for note in target.left_out),
            *not_in_both(model, before, after),
            *note_of_same_data("baseline", twice[0]),
            *note_of_same_data("measured", twice[1]),
        ),
        any(not np.isfinite(std).all() for target in (*before, *after) for std in target.stds),
        tuple(measured),
        tuple(target.forces[0] for target in before),
    )
    return responses, _values(before, numbers, twice[0]), _values(after, numbers, twice[1])


def _columns(target: AntiresonanceTargets) -> dict[Hashable, tuple[FloatArray, FloatArray]]:
    """Values and their standard deviations by response."""
    parts = zip(target.parts, target.stds, strict=True)
    return {(dof, force): (freq, std) for (dof, force, freq, _, _), std in parts}


def _common(sees: set[str | None]) -> str | None:
    """What all sets of a force see; not known where they differ."""
    return next(iter(sees)) if len(sees) == 1 else None


def _same_forces(
    before: list[AntiresonanceTargets],
    after: list[AntiresonanceTargets],
    measured: Sequence[AntiresonanceSet],
) -> None:
    known = {target.forces[0] for target in before}
    for target, each in zip(after, measured, strict=True):
        if known and target.forces[0] not in known:
            reject(
                "baseline",
                f"no set with the force at {each.excitation!r}",
                "sets of the intact structure with the same forces as measured",
                "Test the intact structure with the force there too, or leave that set out.",
            )


def _values(
    targets: list[AntiresonanceTargets], numbers: dict[tuple[int, int], int], twice: dict[int, int]
) -> Values:
    """All values; of sets ``twice`` (later to earlier) those of the earlier one only."""
    rows: list[tuple[int, int, float, float]] = []
    asked: list[tuple[int, int]] = []
    for nth, target in enumerate(targets):
        known = _columns(targets[twice[nth]]) if nth in twice else {}
        parts = zip(target.parts, target.stds, target.single, strict=True)
        for place, ((dof, force, freq, _, _), std, single) in enumerate(parts):
            if (dof, force) in known and known[dof, force][0].size:
                continue
            if place < len(target.dofs_of[0]):  # behind them come channels that are no responses
                asked.append((numbers[dof, force], nth))
            least = ASSUMED_STD if single else LEAST_STD
            relative = np.where(np.isfinite(std), std / freq, ASSUMED_STD)
            rows += [
                (nth, numbers[dof, force], float(np.log(f)), max(float(s), least))
                for f, s in zip(freq, relative, strict=True)
            ]
    rows.sort()
    return Values(
        np.array([row[1] for row in rows], dtype=np.intp),
        np.array([row[2] for row in rows], dtype=np.float64),
        np.array([row[3] for row in rows], dtype=np.float64),
        np.array([row[0] for row in rows], dtype=np.intp),
        asked=np.array(asked, dtype=np.intp).reshape(-1, 2),
    )
