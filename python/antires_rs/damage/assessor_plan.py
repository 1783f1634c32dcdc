"""What is known before a test: the question, the tables, and what was learned; and the search in it.

Sets are found in the tables; those that may be the answer are judged by the likelihood of the full run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.checks import FloatArray
from ..support.progress import one_blas_thread, step
from ..updating.targets import Series, sorted_out, usual_damping, zeros_beside
from .inference import (
    BLIND,
    FURTHEST,
    HIGHEST,
    LARGEST,
    LINEAR,
    Elements,
    Fit,
    Learned,
    Search,
    learned_from,
    refitted,
)
from .likelihood import ALIKE_STD, MANY, Likelihood, ModelError, Prepared, Question, View, rows_of
from .measured_states import Column, Responses, Roots, Values, roots_at, same_data, values_of
from .shape_search import Crack
from .shapes import CRACKED, PLACES, Shape, Shaped, joined, parameters_of

# -- The model's antiresonances over the severity of each element, computed once

#: Severities as u = -ln(1 - beta), from none to 0.99; 0.3 apart where most damage lies.
LEVELS = np.array(
    [0.0, 0.06, 0.15, 0.3, 0.5, 0.75, 1.0, 1.3, 1.6, 2.0, 2.4, 2.9, 3.5, 4.0, 4.6051701859880909]
)
_MARGIN = 0.35  # roots so far outside of the baseline's band (ln f) are not looked at
_DROPPED = 1e-13  # variance of ln f that the compressed errors of the model may miss, on average
_MOST_BYTES = 2e9  # largest tables, bytes

Single = NDArray[np.float32]


@dataclass(frozen=True)
class Tables:
    """Roots (r,), ascending by response, at levels (l,) of u of each element (n,), and of cracks behind them,
    at levels of the loss of a whole element that is as flexible: (k,) in all."""

    response: NDArray[np.intp]
    seen: NDArray[np.bool_]  # by the baseline, (r,)
    identity: NDArray[np.intp]  # number among all intact roots, -1 for one that only damage makes, (r,)
    intact: FloatArray  # ln f in the undamaged model, (r,)
    there: NDArray[np.bool_]  # whether the model has it, (k, l, r)
    place: FloatArray  # ln f expected in the measured structure, (k, l, r)
    beside: FloatArray  # how far that is from the model's
    by_own: FloatArray  # its slope by u of the element
    slopes: Single  # of ln f by all u, (n, l, r, n)
    #: What multiplies q independent errors of the model, of variance 1: of elements, and of the cracks behind
    #: them that were computed, (n + c, l, r, q).
    errors: Single


def tables_of(prepared: Prepared, question: Question) -> Tables:
    """The tables of a model after its baseline."""
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
    factor, ambient = _factor(error), likelihood.ambient
    n_errors = factor.shape[1] + ambient.shape[1]
    shape = (n, LEVELS.size, response.size)
    size = 8.0 * float(np.prod(shape)) * (n_errors + 0.5 * n)
    if size > _MOST_BYTES:
        got = f"one with {n} stiffness terms, whose tables take {size / 1e9:.1f} GB"
        remedy = "Use assess_damage, or a model with fewer terms."
        reject("model", got, f"at most {_MOST_BYTES / 1e9:.0f} GB", remedy)
    there, log_f, beside = np.zeros(shape, dtype=bool), np.zeros(shape), np.zeros(shape)
    slopes, rows = np.zeros((*shape, n), dtype=np.float32), np.zeros((*shape, n_errors))
    for e, level in np.ndindex(n, LEVELS.size):
        roots, identity = at[e][level]
        slot, root = _slots(identity_of, response, roots, identity, low, high)
        there[e, level, slot] = True
        log_f[e, level, slot] = roots.log_f[root]
        by_u = roots.slopes[root, :n].copy()
        by_u[:, e] *= np.exp(-LEVELS[level])
        slopes[e, level, slot] = by_u
        by_theta = roots.slopes[root, n:] * likelihood.factors
        by_errors = rows_of(by_theta, identity[root], intact)
        beside[e, level, slot] = by_errors @ error.mean
        rows[e, level, slot] = np.hstack([by_errors @ factor, by_theta @ ambient])
    by_own = slopes[np.arange(n), :, :, np.arange(n)].astype(np.float64)
    for e in range(n):
        always = there[e].all(axis=0)
        by_own[e][:, always] += _along_levels(beside[e][:, always])

    # The same products of rows in fewer columns.
    flat = rows.reshape(-1, n_errors)
    sizes, vectors = np.linalg.eigh(flat.T @ flat)
    kept = vectors[:, ~(np.cumsum(np.maximum(sizes, 0.0)) / len(flat) < _DROPPED)]
    errors = np.asarray(flat @ kept, dtype=np.float32).reshape(*shape, -1)
    count = likelihood.factors.size
    own = np.vstack([factor[count:] @ kept[: factor.shape[1]], np.zeros(kept.shape[1])])
    by_factors = factor[:count] @ kept[: factor.shape[1]] + ambient @ kept[factor.shape[1] :]

    def placed(roots: Roots, by_theta: FloatArray) -> tuple[Any, ...]:
        """Places in the tables, numbers of the roots there, how far they lie beside the model's, errors."""
        roots, identity = roots.since(intact)
        slot, root = _slots(identity_of, response, roots, identity, low, high)
        by_theta, identity = by_theta[root] * likelihood.factors, identity[root]
        beside = rows_of(by_theta, identity, intact) @ error.mean
        return slot, root, beside, by_theta @ by_factors + own[identity]

    whole = there, log_f + beside, beside, by_own, errors
    there, place, beside, by_own, errors = _with_cracks(prepared, question, placed, whole)
    was = identity_of >= 0
    return Tables(
        response, was & error.seen[identity_of], identity_of, np.where(was, intact.log_f[identity_of], 0.0),
        there, place, beside, by_own, slopes, errors,
    )  # fmt: skip


def _along_levels(values: FloatArray) -> FloatArray:
    """Slopes by u of what is there at all levels, (l, r)."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(LEVELS, values)(LEVELS, 1)) if values.size else values


#: Places of cracks in the tables; every other one, but for the ends, is computed, the rest is between these.
_SHARES = np.linspace(0.0, 1.0, 2 * len(PLACES) + 1)
_NEAREST = np.clip((np.arange(_SHARES.size) - 1) // 2, 0, len(PLACES) - 1)  # computed one of each


def cracks_of(prepared: Prepared, question: Question) -> list[list[Shape]]:
    """Of each candidate and axis of bending those at all places."""
    every = (
        prepared.structure.cracks(e, _SHARES.tolist(), prepared.stiffness_factors) for e in question.elements
    )
    ways = ((own, len(own) // _SHARES.size) for own in every if len(own) % _SHARES.size == 0)
    return [own[way::n_ways] for own, n_ways in ways for way in range(n_ways)]


def _with_cracks(
    prepared: Prepared,
    question: Question,
    placed: Callable[[Roots, FloatArray], tuple[Any, ...]],
    tables: tuple[NDArray[np.bool_], FloatArray, FloatArray, FloatArray, Single],
) -> list[Any]:
    """Tables of what is there, places, how far beside the model's, slopes, and errors, with rows of cracks
    behind those of elements; errors of those that are computed."""
    from scipy.interpolate import BarycentricInterpolator

    parameters, found = question.model.description.core_parameters, [[each] for each in tables]
    likelihood, base = prepared.likelihood, prepared.base
    responses: Any = prepared.responses
    loss, candidates = -np.expm1(-LEVELS), cracks_of(prepared, question)
    # Where there is no room for errors of their own those of the whole element stand in.
    roomy = tables[4].nbytes * (1.0 + len(candidates) * len(PLACES) / len(tables[4])) < _MOST_BYTES
    for cracks in candidates:
        step(f"cracks of element {cracks[0].element}")
        own = cracks[1::2]
        every = parameters((*parameters_of(base, own), *prepared.factors))
        source = responses.source(joined(base, own), every, silent=True)
        there = np.zeros((len(own), *tables[0].shape[1:]), dtype=bool)
        place, beside, by_own = np.zeros((3, *there.shape))
        errors = np.zeros((*there.shape, tables[4].shape[3]), dtype=np.float32)
        for nth, shape in enumerate(own):
            x = np.zeros((LEVELS.size, len(every)))
            x[:, nth], x[:, len(own) :] = shape.amount(loss), likelihood.factors
            by_u = (1.0 - loss) * shape.size / (loss + (1.0 - loss) * shape.size) ** 2
            for level, roots in enumerate(roots_at(source, x, slopes=True, threads=likelihood.threads)):
                slot, root, *rest = placed(roots, roots.slopes[:, len(own) :])
                there[nth, level, slot] = True
                beside[nth, level, slot], errors[nth, level, slot] = rest
                place[nth, level, slot] = roots.log_f[root] + rest[0]
                by_own[nth, level, slot] = roots.slopes[root, nth] * by_u[level]
            always = there[nth].all(axis=0)
            by_own[nth][:, always] += _along_levels(beside[nth][:, always])
        smooth = there.all(axis=0)
        for table, each in zip(found, (there, place, beside, by_own), strict=False):
            table.append(each[_NEAREST])
            if each is not there:
                table[-1][:, smooth] = BarycentricInterpolator(PLACES, each[:, smooth])(_SHARES)
        found[4] += [errors] * roomy
    return [np.concatenate(each) for each in found]


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

_BEYOND = 1.3  # beyond the highest value of the baseline (as a factor) zeros of the model are known


class Expected(NamedTuple):
    """What a set with one force may hold: numbers of responses, the model's real and complex zeros (Hz)."""

    number: dict[Any, int]
    zeros: dict[Any, tuple[FloatArray, Series]]
    sees: str | None
    channels: set[Any]
    silent: set[int]  # responses that the baseline has no value of


def read(
    sets: Sequence[AntiresonanceSet], expected: dict[Any, Expected], scatter: float
) -> tuple[Values, list[str], list[str], bool]:
    """A test's values, notes on those left out, what the plan lacks, whether standard deviations lack."""
    notes: list[str] = []
    strange: list[str] = []
    columns: list[dict[int, Column]] = []
    for one in sets:
        plan = expected.get(one.excitation)
        if plan is None:
            known = ", ".join(map(repr, expected))
            got = f"a set with the force at {one.excitation!r}"
            remedy = "Make an Assessor from a baseline with the force there too."
            reject("zeros", got, f"the force of the baseline: {known}", remedy)
        if one.sees != plan.sees or set(one.channels or ()) != plan.channels:
            strange.append("it was identified from other responses than the baseline")
        usual, own = usual_damping(one), {}
        for label, table in one.tables.items():
            if label not in plan.number:
                strange += [f"the baseline does not have dof {label}"] * bool(len(table))
                continue
            keep = np.ones(len(table), dtype=bool)
            if usual is not None:
                real, series = plan.zeros[label]
                notes += sorted_out(f"dof {label}", table, usual, real, series, keep)
            freq, std = table.freq_hz[keep], table.std_hz[keep]
            number = plan.number[label]
            # What neither state shows tells nothing, and a full run does not ask for it.
            asked = bool(freq.size) or number not in plan.silent
            own[number] = Column(freq, std, "share" in table.scores, asked)
        columns.append(own)
    twice, repeats = same_data("zeros", columns)
    values = values_of(columns, twice)
    if not values.size:
        reject("zeros", "no antiresonance", "at least one", "Identify in the band of the baseline.")
    assumed = any(not np.isfinite(column.std).all() for own in columns for column in own.values())
    return values.noisier(scatter), [*repeats, *notes], strange, assumed


@dataclass(frozen=True)
class Plan:
    """All that an assessment uses; ``question`` has the baseline in place of a test of now."""

    question: Question
    tables: Tables
    learned: Learned

    def __getstate__(self) -> dict[str, Any]:
        """Without what is made of the rest."""
        return {name: self.__dict__[name] for name in ("question", "tables", "learned")}

    @cached_property
    def names(self) -> dict[int, str]:
        """What the elements are called."""
        return {e: self.question.model.element_label(e) for e in self.question.numbers}

    @cached_property
    def tables_in_core(self) -> _core.PreparedTables:
        """The tables, handed over."""
        t = self.tables
        c: Any = np.ascontiguousarray
        undamaged = t.errors[0, 0].astype(np.float64)
        return _core.PreparedTables(
            c(LEVELS), c(t.response), c(t.seen), c(t.identity >= 0), c(t.intact), c(t.there), c(t.place),
            c(t.beside), c(t.by_own), c(t.slopes), c(np.moveaxis(t.slopes, 3, 0)), c(t.errors),
            undamaged @ undamaged.T, np.array(self.hosts, dtype=np.intp), self.errors_of, self.learned.tau**2,
        )  # fmt: skip

    @cached_property
    def cracks(self) -> list[list[Shape]]:
        """Those in the tables, in their order."""
        asked = len(self.tables.place) > len(self.question.numbers)
        return cracks_of(self.prepared, self.question) if asked else []

    @cached_property
    def losing(self) -> list[Shape]:
        """The same, with losses of the whole element as amounts."""
        return [replace(shape, size=1.0) for own in self.cracks for shape in own]

    @cached_property
    def hosts(self) -> list[int]:
        """The element of each."""
        return [self.question.numbers.index(shape.element) for own in self.cracks for shape in own]

    @property
    def errors_of(self) -> NDArray[np.intp]:
        """Rows of errors of each: of the nearest that was computed, or of its element where none was."""
        n = len(self.question.numbers)
        if len(self.tables.errors) == n:
            return np.array(self.hosts, dtype=np.intp)
        return np.concatenate([n + nth * len(PLACES) + _NEAREST for nth, _ in enumerate(self.cracks)])

    @cached_property
    def heat(self) -> list[float]:
        """Changes of ln stiffness by temperature, (k, n), one after the other."""
        both = zip(self.prepared.factors, self.prepared.likelihood.warmer, strict=True)
        by_term = {p.terms: row for p, row in both if p.quantity == "stiffness_factor"}
        numbers, none = self.question.numbers, np.zeros(self.prepared.likelihood.warmer.shape[1])
        return np.array([by_term.get((e,), none) for e in numbers]).T.ravel().tolist()

    @cached_property
    def prepared(self) -> Prepared:
        """The full run's own likelihood: its antiresonances and errors are computed."""
        return self.question.prepared(1, silent=True)

    @cached_property
    def expected(self) -> dict[Any, Expected]:
        """By force label: what a new set may hold."""
        found, model = {}, self.question.model
        responses = self.prepared.responses
        assert isinstance(responses, Responses)
        for each, labels in zip(self.question.measured, responses.labels, strict=True):
            assert isinstance(each, AntiresonanceSet)
            force = model._end("excitation", each.excitation)
            dofs = [model._end("measured dof", label) for label in labels]
            highest_hz = _BEYOND * max(each[dof].max(initial=0.0) for dof in each)
            every = zip(labels, zeros_beside(model, dofs, force, highest_hz), strict=True)
            zeros: dict[Any, tuple[FloatArray, Series]] = {
                label: (real, cache(series)) for label, (real, series) in every
            }
            silent = {number for number in labels.values() if not responses.parts[number][2].size}
            found[each.excitation] = Expected(labels, zeros, each.sees, set(each.channels or ()), silent)
        return found


@one_blas_thread
def plan_of(question: Question, rng: np.random.Generator, threads: int) -> Plan:
    """Learn from the baseline and compute the tables."""
    prepared = question.prepared(threads, silent=True)
    return Plan(
        question, tables_of(prepared, question), learned_from(prepared, question, rng, question.hint())
    )


# -- The search of :mod:`~antires_rs.damage.inference` with antiresonances from tables, for one test


class TabulatedLikelihood(Likelihood):
    """The full run's likelihood of a test, with tables for what is asked often; views are computed."""

    def __init__(self, plan: Plan, now: Values) -> None:
        prepared = plan.prepared
        vars(self).update(vars(prepared.likelihood.of(now, prepared.intact)))
        self.plan = plan
        self._asked = np.arange(int(plan.tables.response.max(initial=-1)) + 1)
        self.test = self._test(0.0, 0.0)

    @cached_property
    def start(self) -> View:
        """By the tables, unless sets are judged from where the surroundings lead to."""
        return super().without_damage(0.0, 0.0) if self.ambient.shape[1] else self.seen((), np.empty(0))

    def _test(self, extra: float, common: float) -> _core.PreparedTest:
        now, plan = self.now, self.plan
        return _core.PreparedTest(
            plan.tables_in_core,
            now.response.tolist(),
            now.log_f.tolist(),
            now.std.tolist(),
            now.test.tolist(),
            now.times_measured(self._asked).tolist(),
            (self.band.low, self.band.high),
            float(np.hypot(self.common, common)),
            extra,
            self.errors.tolist(),
            (ALIKE_STD, plan.heat, MANY),
            plan.learned.outside,
        )

    def without_damage(self, extra: Any, common: float) -> View:
        """See the base class; by the tables."""
        return self._from_tables(np.zeros(self.n), self._test(extra, common).look([], []))

    def log_without_damage(self, extra: float, common: float) -> float:
        """The same without slopes."""
        return float(self._test(extra, common).settle([([], [])], 1, 0.0)[0][-1])

    def seen(self, elements: Elements, u: FloatArray) -> View:
        """From severities of some elements, by the tables."""
        (beta,) = self.rows(elements, -np.expm1(-u)[None])
        return self._from_tables(beta, self.test.look(list(elements), u.tolist()))

    def _from_tables(self, beta: FloatArray, found: Any) -> View:
        log_likelihood, gain, curvature, error, *rest = found
        kappa, times = self.errors[error, :2].tolist()
        rest.append(self.error.gain_std)
        return View(beta, log_likelihood, gain, curvature, kappa, times, *rest)


#: Sets so near to the likeliest (log probability) are judged; looks at computed antiresonances before larger
#: sets, and all.
_NEAR, _EARLY, _MOST_LOOKS = 0.8, 1, 3
#: Sets that a scan leaves, by their number of elements; what it refines, by distances and by misfits.
_LIKELIEST, _BY_DISTANCE, _BY_MISFIT = (10, 4, 3), 5, 5
#: Steps of the refinement; sets so far behind the first of them (log-likelihood) are given up.
_STEPS, _HOPELESS = 2, 18.0
#: Looks at the tables from which a set is settled roughly; sets so far behind the first (log evidence) have
#: one.
_SETTLING, _FAR = 2, 6.0
#: Pairs that are seen from so many single elements; how far the second one's severity (u) may be.
_GROWN, _GROWING, _GROWS = 4, 2, 0.3
_LINEAR = 6  # sets known from another one's severities alone that are looked at from their own in the end
_JOINED = (0, 10, 3)  # so many elements join a set of one and of two in the linear model of its view
#: A set is judged anew where its severities are further (u) than this from where it was judged; so often; and
#: the same for those of the answer.
_RESTS, _LOOKS, _SURE_RESTS = 0.06, 2, 1e-2
#: Elements so near to the likeliest set (log probability), and so many, may be cracked instead; cracks so far
#: behind it do not count. Steps by the nearest values, after which those so far behind are left out; looks,
#: and the longest step (u).
_NEAR_CRACKS, _MOST_CRACKED, _LEAST_CRACK = 10.0, 6, 4.0
_CRACK_STEPS, _CRACK_HOPELESS, _CRACK_LOOKS, _CRACK_STEP = 3, 12.0, 4, 0.3
_CRACK_PRIOR, _CRACK_SHARP = float(np.log(CRACKED)), 4.0  # ln of its prior, and what more places may gain


@dataclass
class QuickSearch(Search):
    """A search in tables; the few sets that may be the answer are judged as the full run judges them."""

    likelihood: TabulatedLikelihood
    ends_by_slopes: bool = True
    #: Log evidence and severities (u) of sets as the tables have them; sets seen from their own severities,
    #: and those of them that were judged there by computed antiresonances and errors.
    rough: dict[Elements, tuple[float, FloatArray]] = field(default_factory=dict)
    seen: set[Elements] = field(default_factory=set)
    judged: set[Elements] = field(default_factory=set)
    #: The same as in ``rough`` of pairs in the linear model of a single element.
    grown: dict[Elements, tuple[float, FloatArray]] = field(default_factory=dict)
    looks: int = 0  # at computed antiresonances
    cut: bool = False  # whether sets that may be the most probable ones were not judged

    def run(self) -> None:
        """See the base class; then cracks of the likeliest elements."""
        super().run()
        cracks = self.likelihood.plan.cracks
        if cracks and not self.interrupted:
            known = self._weights() | {s: rough[0] + self.log_prior(s) for s, rough in self.rough.items()}
            least = max(known.values()) - _NEAR_CRACKS
            alone = (s for s in known if len(s) == 1 and not self.outside(s) and known[s] > least)
            for s in sorted(alone, key=lambda s: -known[s])[:_MOST_CRACKED]:
                for nth, own in enumerate(cracks):
                    if self.likelihood.plan.hosts[nth * len(own)] == s[0]:
                        self._crack(s, self.likelihood.n + nth * len(own), own)

    def _crack(self, s: Elements, first: int, shapes: list[Shape]) -> None:
        """Judge cracks of an element, the first one's number given, by the tables."""
        likelihood, test, u = self.likelihood, self.likelihood.test, self._u(s)
        top = max(self._weights().values()) - _CRACK_PRIOR - self.log_prior(s)
        asked = [(first + k, shapes[k].size, u) for k in range(1, len(shapes), 2)]
        fits = self._cracked(asked, top)
        if not fits or max(fit.log_evidence for fit in fits.values()) < top - _LEAST_CRACK - _CRACK_SHARP:
            return
        best = max(fits.values(), key=lambda fit: fit.log_evidence)
        (k,) = best.elements
        fits |= self._cracked([(other, shapes[other - first].size, best.u) for other in (k - 1, k + 1)], top)
        best = max(fits.values(), key=lambda fit: fit.log_evidence)
        (beta,) = likelihood.rows(s, best.beta[None])
        view = likelihood._from_tables(beta, test.look(list(best.elements), best.u.tolist()))
        # At all other places it explains next to nothing.
        rest = replace(best, log_evidence=best.log_evidence - _CRACK_HOPELESS)
        every = {*fits, *(first + k for k in range(1, len(shapes), 2))}
        losing = likelihood.plan.losing[first - likelihood.n :]
        total, reach, losses = Crack([(losing[c - first], fits.get(c, rest)) for c in every]).over_places()
        rows = [(float(each),) for each in losses]
        told = shapes[best.elements[0] - first].told(reach)
        known = self.shaped.cracked.get(s)
        if known is None or total > known.log_evidence:
            self.shaped.cracked[s] = Shaped("crack", told, total, view, *rows)

    def _cracked(self, asked: list[tuple[int, float, FloatArray]], top: float) -> dict[int, Fit]:
        """Cracks, by number, size and start, at their most probable amounts, by the tables; severities (u)
        are of whole elements. Those far behind ``top`` (log evidence) are not looked at again."""
        found: dict[int, Fit] = {}
        test, view = self.likelihood.test, self.likelihood.start
        starts = test.refine([([c], u.tolist()) for c, _, u in asked], _CRACK_STEPS)
        least = min(left for _, left in starts) + 1.5 * _CRACK_HOPELESS
        pairs = zip(asked, starts, strict=True)
        ahead = [(c, size, np.array(u)) for (c, size, _), (u, left) in pairs if left < least]
        # By number the share of a step to come, the log-likelihood where it is from, and where to.
        climbs: dict[int, tuple[float, float, FloatArray, FloatArray]] = {}
        for _ in range(_CRACK_LOOKS):
            asked, ahead = ahead, []
            settled = test.settle([([c], u.tolist()) for c, _, u in asked], 1, 0.0)
            for (c, size, u), (_, peak, mean, variance, seen, height) in zip(asked, settled, strict=True):
                share, known, start, best = climbs.get(c, (1.0, -np.inf, u, u))
                climbs[c] = 0.5 * share, known, start, best
                if height > known:
                    best, middle = np.minimum(peak, FURTHEST), np.array(mean)
                    climbs[c] = 1.0, height, u, best
                    if abs(best[0] - u[0]) > LINEAR:  # slopes mislead
                        seen -= 0.5 * (mean[0] - u[0]) ** 2 / variance[0]
                        best = middle = u
                    # All amounts of a crack are equally probable, not all losses that are as flexible.
                    seen += np.log(size) - 2.0 * np.log(1.0 - np.exp(-best[0]) * (1.0 - size))
                    if c not in found or seen > found[c].log_evidence:
                        rest = middle, np.array(variance).reshape(1, 1), view
                        found[c] = Fit((c,), float(seen), -np.expm1(-best), *rest)
                share, _, u, best = climbs[c]
                step_by = float(best[0] - u[0])
                may = found[c].log_evidence > top - _LEAST_CRACK - _CRACK_SHARP
                if share * abs(step_by) > _RESTS and (may or abs(step_by) > LINEAR):
                    ahead.append((c, size, u + share * np.clip(step_by, -_CRACK_STEP, _CRACK_STEP)))
        return found

    def _pairs(self) -> dict[Elements, FloatArray]:
        """Too many for a quick search."""
        return {}

    def _starts(self, size: int) -> dict[Elements, FloatArray]:
        """The sets with one element more that explain most at any severity, and their severities (u)."""
        if size == 1:  # all are scanned
            self.hopeless.update((e,) for e in range(self.likelihood.n))
        parents = self._known(size - 1)[: self._most_parents(size - 1)]
        grown, self.grown = {s: u for s, (_, u) in self.grown.items()}, {}
        return grown | self._scanned([(s, self._u(s)) for s in parents])

    def _known(self, size: int) -> list[Elements]:
        """Sets of a size, the likeliest first."""
        known = {s: fit.log_evidence for s, fit in self.fits.items()}
        for s, (log_evidence, _) in self.rough.items():
            known[s] = max(log_evidence, known.get(s, -np.inf))
        own = [s for s in known if len(s) == size and not self.outside(s)]
        return sorted(own, key=lambda s: -known[s])

    def _scanned(self, parents: list[tuple[Elements, FloatArray]]) -> dict[Elements, FloatArray]:
        """Sets with one element more than ``parents``, which have severities (u): those that explain most."""
        chosen = self._joined(parents)
        asked = [(list(elements), u) for (elements, _), u in chosen.items()]
        best: dict[Elements, tuple[float, FloatArray]] = {}
        for (elements, _), (u, score) in zip(chosen, self.likelihood.test.refine(asked, _STEPS), strict=True):
            if elements not in best or score < best[elements][0]:
                best[elements] = score, np.array(u)
        likeliest = sorted(best, key=lambda s: best[s][0])
        likeliest = likeliest[: _LIKELIEST[len(likeliest[0]) - 1]] if likeliest else []
        return {s: best[s][1] for s in likeliest if best[s][0] < best[likeliest[0]][0] + _HOPELESS}

    def _joined(self, parents: list[tuple[Elements, FloatArray]]) -> dict[tuple[Elements, int], list[float]]:
        """What a scan refines: sets with the level of their last element, and all severities (u)."""
        scans: tuple[list[FloatArray], ...] = ([], [])
        joined: list[tuple[list[tuple[int, float]], int]] = []
        for parent, u in parents:
            further = self._further(parent)
            if further:
                found = self.likelihood.test.scan(list(parent), u.tolist(), further)
                for scan, one in zip(scans, found, strict=True):
                    scan.append(one)
                own = list(zip(parent, u.tolist(), strict=True))
                joined += [(own, e) for e in further]
        chosen: dict[tuple[Elements, int], list[float]] = {}
        few = (_BY_DISTANCE, _BY_MISFIT if joined and joined[0][0] else len(joined))
        for scan, most in zip(scans if joined else (), few, strict=False):
            left = np.concatenate(scan)
            level = np.argmin(left, axis=1)
            order = np.argsort(left[np.arange(level.size), level], kind="stable").tolist()
            sets = (_with(joined[nth][0], joined[nth][1], int(level[nth])) for nth in order)
            for elements, at, start in islice((one for one in sets if one[0] not in self.seen), most):
                chosen.setdefault((elements, at), start)
        return chosen

    def _further(self, elements: Elements, view: View | None = None) -> list[int]:
        """See the base class; as seen from a point those that would gain most."""
        further = super()._further(elements)
        if view is None or not elements:
            return further
        gains = view.gains
        return sorted(further, key=lambda e: -gains[e])[: _JOINED[len(elements)]]

    def _u(self, elements: Elements) -> FloatArray:
        fit, rough = self.fits.get(elements), self.rough.get(elements)
        if rough and (fit is None or rough[0] > fit.log_evidence):
            return rough[1]
        return _within(self.fits[elements].beta)

    def _refine(self, chosen: dict[Elements, FloatArray]) -> None:
        """See those that may be the most probable ones, the likeliest first."""
        if not chosen:
            return
        self._tabulate(chosen)
        size = max(map(len, chosen))
        while near := self._open(size, 0.0, self.seen):
            self._settle(near[0], computed=len(near[0]) > 1 and self.looks < _EARLY)
        if size == 1:
            self._grow()

    def _tabulate(self, chosen: dict[Elements, FloatArray], looks: int = _SETTLING) -> None:
        """Evidence and severities of sets as the tables have them."""
        asked = {s: u for s, u in chosen.items() if s not in self.seen}
        for _ in range(looks):
            if not asked:
                return
            lists = [(list(s), u.tolist()) for s, u in asked.items()]
            settled = self.likelihood.test.settle(lists, 1, _RESTS)
            found = {s: (one[4], np.minimum(one[1], FURTHEST)) for s, one in zip(asked, settled, strict=True)}
            self.rough |= found
            least = max(log_evidence for log_evidence, _ in found.values()) - _FAR
            asked = {s: u for s, (e, u) in found.items() if e > least and np.abs(u - asked[s]).max() > _RESTS}

    def _open(self, size: int, room: float, done: set[Elements]) -> list[Elements]:
        """Sets of at most ``size`` elements near the likeliest that are not done, the likeliest first."""
        weights = self._weights()
        weights |= {s: log_evidence + self.log_prior(s) for s, (log_evidence, _) in self.rough.items()}
        least = max(w for s, w in weights.items() if len(s) <= size) - room
        if least == -np.inf:
            return []
        near = [s for s, w in weights.items() if w >= least and s and len(s) <= size and s not in done]
        return sorted(near, key=lambda s: -weights[s])

    def _settle(self, elements: Elements, *, computed: bool) -> None:
        """Judge a set from its own severities by the tables or, ``computed``, as the full run does."""
        for _ in range(_LOOKS):
            u = self._u(elements)
            if computed:
                (view,) = self.likelihood.views(self.likelihood.rows(elements, -np.expm1(-u)[None]))
                self.looks += 1
                self.judged.add(elements)
            else:
                view = self.likelihood.seen(elements, u)
            self.rough.pop(elements, None)
            self.seen.add(elements)
            self.fits[elements] = refitted(view, elements)
            if np.abs(self._u(elements) - u).max() <= (_RESTS if computed else _SURE_RESTS):
                break
        self._judge(elements, self.fits[elements].view, itself=False)

    def _hidden(self, fit: Fit, gain: float) -> bool:
        """Whether a pair that was not judged may be likelier; see the base class, which asks for more."""
        most = max((log_evidence for log_evidence, _ in self.grown.values()), default=-np.inf)
        return most > self._likeliest.log_evidence

    def _grow(self) -> None:
        """See pairs in the linear model of their likeliest single elements, as the full run does."""
        found: list[tuple[float, int, int]] = []
        for (a,) in self._known(1)[:_GROWING]:
            view = self.likelihood.seen((a,), self._u((a,)))
            own, other, rise = _both(view, a)
            near = (np.abs(own) <= LINEAR) & (other > 0.0) & (other <= _GROWS)
            further = (e for e in self._further((a,)) if near[e])
            found += [(view.log_likelihood + float(rise[e]), a, e) for e in further]
        asked = []
        for _, a, e in sorted(found, reverse=True)[:_GROWN]:
            both = sorted([(a, float(self._u((a,))[0])), (e, 0.0)])
            asked.append(([k for k, _ in both], [u for _, u in both]))
        for (elements, _), seen in zip(asked, self.likelihood.test.settle(asked, 2, _RESTS), strict=True):
            if tuple(elements) not in self.fits:
                self.grown[tuple(elements)] = seen[4], np.array(seen[1])

    def _judge_smaller(self, starts: dict[Elements, FloatArray]) -> None:
        """See the base class; only those that are new."""
        new = {s: _within(row[list(s)]) for s, row in starts.items() if s not in self.fits}
        self._refine({s: u for s, u in new.items() if s not in self.rough})

    def _renew(self) -> None:
        """Judge the likeliest sets anew, until none that was not may be the answer."""
        new = [s for s in self._near() if s not in self.judged and s not in self.rough][:_LINEAR]
        linear = {s: _within(self.fits[s].beta) for s in new}
        self._tabulate(linear, looks=1)
        while near := self._open(LARGEST, _NEAR, self.judged):
            if self.looks >= _MOST_LOOKS:
                self.cut = True
                break
            self._settle(near[0], computed=True)


def _both(view: View, a: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Newton steps (u) of one element and of each other one that joins it, and what both gain; (n,)."""
    room = 1.0 - view.beta
    gain = view.gain * room - 1.0
    matrix = view.curvature * np.outer(room, room)
    by_own, by_both, by_other = matrix[a, a] + BLIND, matrix[a], np.diag(matrix) + BLIND
    size = np.maximum(by_own * by_other - by_both**2, 1e-9 * by_own * by_other)
    own = (by_other * gain[a] - by_both * gain) / size
    other = (by_own * gain - by_both * gain[a]) / size
    return own, other, 0.5 * (gain[a] * own + gain * other)


def _with(own: list[tuple[int, float]], further: int, level: int) -> tuple[Elements, int, list[float]]:
    """A set with one element more, the level of its severity, and all severities (u)."""
    joined = sorted([*own, (further, float(LEVELS[level]))])
    return tuple(e for e, _ in joined), level, [u for _, u in joined]


def _within(beta: FloatArray) -> FloatArray:
    """The same severities as u, within their bounds."""
    return np.asarray(-np.log1p(-np.minimum(beta, HIGHEST)))
