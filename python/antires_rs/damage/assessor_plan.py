"""What is known before the test: the question, the tables, and what was learned from the baseline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.parameters import stiffness_reduction
from ..support.checks import FloatArray
from ..support.progress import one_blas_thread, step
from ..updating.targets import looked_up_to, model_dof, real_zeros, sorted_out, usual_damping, zero_series
from .inference import Learned, learned_from
from .likelihood import ERRORS, Band, Errors, ModelError, Prepared, Question, factors_of, rows_of
from .measured_states import (
    Column,
    Responses,
    Roots,
    Values,
    measured_states,
    note_of_same_data,
    roots_at,
    same_data,
    values_of,
)

# -- The model's antiresonances over the severity of each element, computed once


#: Severities as u = -ln(1 - beta), from none to 0.99; 0.3 apart where most damage lies.
LEVELS = np.array(
    [0.0, 0.06, 0.15, 0.3, 0.5, 0.75, 1.0, 1.3, 1.6, 2.0, 2.4, 2.9, 3.5, 4.0, 4.6051701859880909]
)
#: Roots so far outside of the baseline's band (ln f) are not looked at.
_MARGIN = 0.35
#: Variance of ln f that the compressed errors of the model may miss, on average.
_DROPPED = 1e-13
#: Largest tables, bytes.
_MOST_BYTES = 2e9

Single = NDArray[np.float32]


@dataclass(frozen=True)
class Tables:
    """Roots (r,), ascending by response, at levels (l,) of u of each element (n,).

    ``seen`` (r,) by the baseline; ``identity`` (r,) is the number among all roots of the undamaged model,
    which ``all_response`` and ``all_log_f`` are, -1 for one that only damage makes; ``intact`` (r,) ln f
    there. By element, level and root: whether the model has it (``there``), ``place`` ln f expected in the
    measured structure, ``beside`` how far that is from the model's, ``by_own`` its slope by u of the element,
    ``slopes`` (n, l, r, n) those of ln f by all u, ``errors`` (n, l, r, q) what multiplies q independent
    errors of the model, of variance 1.
    """

    response: NDArray[np.intp]
    seen: NDArray[np.bool_]
    identity: NDArray[np.intp]
    all_response: NDArray[np.intp]
    all_log_f: FloatArray
    intact: FloatArray
    there: NDArray[np.bool_]
    place: FloatArray
    beside: FloatArray
    by_own: FloatArray
    slopes: Single
    errors: Single


def tables_of(prepared: Prepared) -> Tables:
    """The tables of a model after its baseline."""
    from scipy.interpolate import CubicSpline

    likelihood, error = prepared.likelihood, prepared.likelihood.error
    n, intact = likelihood.n, error.intact
    at: list[list[tuple[Roots, NDArray[np.intp]]]] = []  # roots, and which of the intact ones they have been
    for e in range(n):
        step(f"sensitivities of element {e + 1} of {n}")
        betas = np.zeros((LEVELS.size, n))
        betas[:, e] = -np.expm1(-LEVELS)
        at.append([roots.since(intact) for roots in likelihood.roots(betas, slopes=True)])
    low, high = likelihood.band.low - _MARGIN, likelihood.band.high + _MARGIN
    response, identity_of = _listed(at, intact, low, high)
    factor = _factor(error)
    shape = (n, LEVELS.size, response.size)
    size = 8.0 * float(np.prod(shape)) * (factor.shape[1] + 0.5 * n)
    if size > _MOST_BYTES:
        reject(
            "model",
            f"one with {n} stiffness terms, whose tables take {size / 1e9:.1f} GB",
            f"at most {_MOST_BYTES / 1e9:.0f} GB",
            "Use assess_damage, or a model with fewer terms.",
        )
    there, log_f, beside = np.zeros(shape, dtype=bool), np.zeros(shape), np.zeros(shape)
    slopes, rows = np.zeros((*shape, n), dtype=np.float32), np.zeros((*shape, factor.shape[1]))
    for e, level in np.ndindex(n, LEVELS.size):
        roots, identity = at[e][level]
        slot, root = _slots(identity_of, response, roots, identity, low, high)
        there[e, level, slot] = True
        log_f[e, level, slot] = roots.log_f[root]
        by_u = roots.slopes[root, :n].copy()
        by_u[:, e] *= np.exp(-LEVELS[level])
        slopes[e, level, slot] = by_u
        by_errors = rows_of(roots.slopes[root, n:] * likelihood.factors, identity[root], intact)
        beside[e, level, slot] = by_errors @ error.mean
        rows[e, level, slot] = by_errors @ factor
    by_own = slopes[np.arange(n), :, :, np.arange(n)].astype(np.float64)
    for e in range(n):
        whole = there[e].all(axis=0)
        if whole.any():
            by_own[e][:, whole] += CubicSpline(LEVELS, beside[e][:, whole])(LEVELS, 1)
    # The same products of rows in fewer columns.
    flat = rows.reshape(-1, factor.shape[1])
    sizes, vectors = np.linalg.eigh(flat.T @ flat)
    dropped = np.cumsum(np.maximum(sizes, 0.0)) / len(flat) < _DROPPED
    errors = np.asarray(flat @ vectors[:, ~dropped], dtype=np.float32)
    was = identity_of >= 0
    return Tables(
        response, was & error.seen[identity_of], identity_of, intact.response, intact.log_f,
        np.where(was, intact.log_f[identity_of], 0.0), there, log_f + beside, beside,
        by_own, slopes, errors.reshape(*shape, -1),
    )  # fmt: skip


def _listed(
    at: list[list[tuple[Roots, NDArray[np.intp]]]], intact: Roots, low: float, high: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Response of each root that the tables need, and its number among the intact ones, -1 for new ones."""
    inside = intact.between(low, high)
    new: dict[int, int] = {}
    for roots, identity in (state for row in at for state in row):
        near = roots.between(low, high)
        inside[identity[near & (identity >= 0)]] = True
        own, count = np.unique(roots.response[near & (identity < 0)], return_counts=True)
        for response, more in zip(own.tolist(), count.tolist(), strict=True):
            new[response] = max(new.get(response, 0), more)
    kept = np.flatnonzero(inside)
    responses = np.concatenate([intact.response[kept], np.repeat(list(new), list(new.values()))])
    order = np.argsort(responses, kind="stable")
    numbers = np.concatenate([kept, np.full(sum(new.values()), -1)])
    return responses[order].astype(np.intp), numbers[order].astype(np.intp)


def _slots(
    identity_of: NDArray[np.intp],
    response: NDArray[np.intp],
    roots: Roots,
    identity: NDArray[np.intp],
    low: float,
    high: float,
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where in the table roots stand: their places in it, and their numbers."""
    slot_of = {int(k): slot for slot, k in enumerate(identity_of) if k >= 0}
    free: dict[int, list[int]] = {}
    for slot in np.flatnonzero(identity_of < 0).tolist():
        free.setdefault(int(response[slot]), []).append(slot)
    slots, numbers = [], []
    for number, k in enumerate(identity.tolist()):
        if k in slot_of:
            slots.append(slot_of[k])
            numbers.append(number)
        elif k < 0 and low < roots.log_f[number] < high and (left := free.get(int(roots.response[number]))):
            slots.append(left.pop(0))
            numbers.append(number)
    return np.array(slots, dtype=np.intp), np.array(numbers, dtype=np.intp)


def _factor(error: ModelError) -> FloatArray:
    """L with L L' the covariance of the model's factors and the roots' own errors, after the baseline."""
    from scipy.linalg import cho_solve

    prior, rows = error.prior, error.rows
    covariance = np.diag(prior)
    if rows.size:
        cross = rows * prior
        covariance -= cross.T @ cho_solve(error.factor, cross)
    size, vectors = np.linalg.eigh(covariance)
    kept = size > 1e-14 * size[-1]
    return np.asarray(vectors[:, kept] * np.sqrt(size[kept]))


# -- A measured set as values, by what was prepared: no question to the model


#: Beyond the highest value of the baseline (as a factor) zeros of the model are known.
_BEYOND = 1.3


class Expected(NamedTuple):
    """What a set with one force may hold: the number of each response, and the model's real and complex zeros
    (Hz) there."""

    number: dict[Any, int]
    real: dict[Any, FloatArray]
    complex: dict[Any, tuple[FloatArray, FloatArray]]
    sees: str | None
    channels: set[Any]


def expected_of(question: Question, responses: Responses) -> dict[Any, Expected]:
    """By force label."""
    found, model = {}, question.model
    for each, labels in zip(question.measured, responses.labels, strict=True):
        assert isinstance(each, AntiresonanceSet)
        force = model_dof(model, "excitation", each.excitation)
        dofs = {label: model_dof(model, "measured dof", label) for label in labels}
        limit_hz = looked_up_to(_BEYOND * max(each[dof].max(initial=0.0) for dof in each))
        real = real_zeros(model, list(dofs.values()), force, limit_hz)
        series = {label: zero_series(model, dof, force, limit_hz) for label, dof in dofs.items()}
        channels = set(each.channels or ())
        found[each.excitation] = Expected(
            labels, dict(zip(labels, real, strict=True)), series, each.sees, channels
        )
    return found


class Read(NamedTuple):
    """Values of a test, notes on those that are left out, what the plan does not hold, and whether some lack
    a standard deviation."""

    values: Values
    notes: list[str]
    strange: list[str]
    assumed: bool


def read(sets: Sequence[AntiresonanceSet], expected: dict[Any, Expected], scatter: float) -> Read:
    """The values of a test, without a question to the model."""
    notes: list[str] = []
    strange: list[str] = []
    columns: list[dict[int, Column]] = []
    for one in sets:
        plan = expected.get(one.excitation)
        if plan is None:
            known = ", ".join(map(repr, expected))
            reject(
                "zeros",
                f"a set with the force at {one.excitation!r}",
                f"the force of the baseline: {known}",
                "Make an Assessor from a baseline with the force there too.",
            )
        if one.sees != plan.sees or set(one.channels or ()) != plan.channels:
            strange.append("it was identified from other responses than the baseline")
        usual, own = usual_damping(one), {}
        for label, table in one.tables.items():
            if label not in plan.number:
                strange += [f"the baseline does not have dof {label}"] * bool(len(table))
                continue
            keep = np.ones(len(table), dtype=bool)
            if usual is not None:
                series = partial(plan.complex.__getitem__, label)
                notes += sorted_out(label, table, usual, plan.real[label], series, keep)
            freq, std = table.freq_hz[keep], table.std_hz[keep]
            own[plan.number[label]] = Column(freq, std, "share" in table.scores)
        columns.append(own)
    twice = same_data(columns)
    values = values_of(columns, twice)
    if not values.size:
        reject("zeros", "no antiresonance", "at least one", "Identify in the band of the baseline.")
    assumed = any(not np.isfinite(column.std).all() for own in columns for column in own.values())
    return Read(values.noisier(scatter), [*note_of_same_data("zeros", twice), *notes], strange, assumed)


@dataclass(frozen=True)
class Plan:
    """All that an assessment uses; ``question`` has the baseline in place of a test of now."""

    question: Question
    tables: Tables
    learned: Learned

    def __getstate__(self) -> dict[str, Any]:
        """Without what is made of the rest."""
        return {name: self.__dict__[name] for name in ("question", "tables", "learned")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    @cached_property
    def names(self) -> dict[int, str]:
        """What the elements are called."""
        return {e: self.question.model.element_label(e) for e in self.question.numbers}

    @cached_property
    def errors(self) -> Errors:
        """As the likelihood has them."""
        return tuple((self.learned.outside * kappa, times, p) for kappa, times, p in ERRORS)

    @cached_property
    def tables_in_core(self) -> _core.PreparedTables:
        """The tables, handed over."""
        t = self.tables
        c: Any = np.ascontiguousarray
        undamaged = t.errors[0, 0].astype(np.float64)
        return _core.PreparedTables(
            c(LEVELS), c(t.response), c(t.seen), c(t.identity >= 0), c(t.intact), c(t.there), c(t.place),
            c(t.beside), c(t.by_own), c(t.slopes), c(np.moveaxis(t.slopes, 3, 0)), c(t.errors),
            undamaged @ undamaged.T, self.learned.tau**2,
        )  # fmt: skip

    @cached_property
    def states(self) -> tuple[Responses, Values]:
        """The responses of the baseline, and its values."""
        sets: Any = self.question.baseline
        now: Any = self.question.measured
        return measured_states(self.question.model, sets, now)[:2]

    @cached_property
    def core(self) -> Any:
        """The model's antiresonances, computed."""
        model = self.question.model
        parts = (*stiffness_reduction(self.question.numbers), *factors_of(model))
        return self.states[0].source(model, model.description.core_parameters(parts))

    @cached_property
    def expected(self) -> dict[Any, Expected]:
        """By force label: what a new set may hold."""
        return expected_of(self.question, self.states[0])

    def exact(self, beta: FloatArray, band: Band, *, slopes: bool) -> tuple[FloatArray, FloatArray | None]:
        """ln f of the roots of the tables (r,), computed at severities (n,), NaN where the model has none;
        and their slopes by all u (r, n)."""
        x = np.concatenate([beta, self.learned.factors])
        limits = (float(np.exp(band.low - 0.6)), float(np.exp(band.high + 0.6)))
        roots = roots_at(self.core, x[None], slopes=slopes, threads=1, band_hz=limits)[0]
        t = self.tables
        _, identity = roots.since(Roots(t.all_response, t.all_log_f, np.empty((0, 0))))
        slot, root = _slots(t.identity, t.response, roots, identity, band.low - _MARGIN, band.high + _MARGIN)
        log_f = np.full(t.response.size, np.nan)
        log_f[slot] = roots.log_f[root]
        if not slopes:
            return log_f, None
        by_u = np.zeros((t.response.size, beta.size))
        by_u[slot] = roots.slopes[root, : beta.size] * (1.0 - beta)
        return log_f, by_u


@one_blas_thread
def plan_of(question: Question, rng: np.random.Generator, threads: int) -> Plan:
    """Learn from the baseline and compute the tables."""
    prepared = question.prepared(threads)
    return Plan(question, tables_of(prepared), learned_from(prepared, question, rng, question.hint()))
