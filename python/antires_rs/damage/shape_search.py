"""The search for what is no loss of a whole element, each judged by the likelihood of the assessment."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..support.checks import FloatArray, members
from ..support.progress import step
from .inference import (
    FURTHEST,
    SHARES,
    USUALLY_LOST,
    Climb,
    Elements,
    Fit,
    Search,
    fitted,
    refitted,
    too_much,
)
from .likelihood import Likelihood, Prepared, Question
from .measured_states import Responses, Values, roots_at
from .shapes import Found, Shape, Shaped, Structure, joined, parameters_of

#: Shares of the prior of what is in no element, by kind; with that of a sensor they add up to one.
_ELSEWHERE = {"mass": 0.4, "joint": 0.2, "support": 0.2}
SENSOR = 0.2
_LEAST_SENSORS = 3  # with fewer sensors the values of one are not told from those of all


def with_shapes(prepared: Prepared, question: Question, shapes: Sequence[Shape]) -> Likelihood | None:
    """The likelihood with shapes behind the elements; None where the model with these has not the same
    roots, as when some are close together."""
    plain, model, responses = prepared.likelihood, prepared.base, prepared.responses
    assert isinstance(responses, Responses)
    own = stiffness_reduction(prepared.numbers)
    parameters = (*own, *parameters_of(model, shapes), *prepared.factors)
    core = responses.source(joined(model, shapes), question.model.description.core_parameters(parameters))
    # What the core takes for no change.
    offset = np.array([0.0] * len(own) + [float(shape.kind == "mass") for shape in shapes])
    x = np.concatenate([offset, plain.factors])
    intact = roots_at(core, x[None], slopes=True, threads=plain.threads)[0]
    before = plain.error.intact
    if intact.size != before.size or not np.allclose(intact.log_f, before.log_f, rtol=0.0, atol=1e-6):
        return None
    error = replace(plain.error, intact=intact)
    how = plain.common, plain.threads, plain.ambient, plain.warmer
    found = Likelihood(core, offset.size, error, prepared.intact, plain.now, *how)
    found.offset, found.n_elements = offset, len(own)
    return found


# -- The search

#: Shapes that are looked at for their gain, to first order; elements whose cracks are, for their evidence.
_BY_GAIN, _BY_EVIDENCE, _MOST_SCANNED = 16, 3, 40
_GAIN = 4.0  # gain of the log-likelihood, to first order, from which a shape may explain what no element does
#: Errors added on the way to the most probable amounts; sets given up when so far behind, but for so many.
_TEMPERED, _HOPELESS, _KEPT, _FURTHER = (0.03, 0.01, 0.003, 0.0, 0.0, 0.0), 30.0, 6, 6
#: Of pairs: sets that get another column, columns that join each, and pairs that are refined.
_PARENTS, _JOINING, _PAIRS = 6, 12, 12
_NEAREST = 2  # pairs whose members are joined by others once more
_SCAN = np.array([0.03, 0.1, 0.25, 0.5, 0.75, 0.93])  # amounts of a scan
#: Rounds in which the place of a crack is narrowed down, for so many elements and pairs; errors added.
_ROUNDS, _NARROWED, _NEAR = 3, 2, (0.0, 0.0, 0.0)
_SHARES, _QUANTILES = np.linspace(0.0, 1.0, 401), np.arange(0.5, 20.0) / 20.0
#: Error of a place (share of the element) over that of a loss (u), by the model's own error: both come of how
#: its modes bend. Set on the cracks of seed 0 of the outside class.
_OFF_PLACE = 0.5
_SAME_PLACE, _STEP = 2e-3, 0.2  # places so near are one; the first step from a single one
_OVER_PLACES = 1.0  # what the likeliest place of a crack has over the mean of its element (ln), about


def find_shapes(search: Search, prepared: Prepared, question: Question) -> None:
    """Judge the shapes of a structure beside the sets of elements that a search has found."""
    found, frame = search.shaped, prepared.structure
    plain = prepared.likelihood.start
    likeliest = max(search.fits.values(), key=lambda fit: fit.log_evidence)
    lost = plain.partner.size - plain.n_matched
    changed = too_much(plain) or lost > max(1, USUALLY_LOST * plain.partner.size)
    if changed or lost:
        found.others += _sensors(prepared, question.model)
    # What such a support carries loses as much by it: the values do not tell the two apart.
    for e in frame.grounded if type(frame) is Structure and likeliest.elements else ():
        if fit := search.fits.get(bar := (prepared.numbers.index(e),)):
            place = f"support of {question.model.element_label(e)} yields"
            found.others.append(Shaped("support", place, fit.log_evidence, fit.view, halves=bar))
    shapes = frame.shapes(prepared.stiffness_factors)
    if not shapes:
        return
    step("cracks, joints and masses")
    likelihood = with_shapes(prepared, question, shapes)
    if likelihood is None:
        return
    n, numbers = search.likelihood.n, prepared.numbers
    start = likelihood.start
    if not (changed or likeliest.elements) and start.gains[n:].max(initial=0.0) < _GAIN:
        return
    singles = sorted((s for s in search.fits if len(s) == 1), key=lambda s: -search.fits[s].log_evidence)
    near = {numbers[s[0]] for s in singles[:_BY_EVIDENCE]}
    near |= {other for e in near for other in frame.neighbours(e)}
    # Large changes leave few values with a partner, and gains say little: what is in no element is scanned.
    beside = [n + k for k, shape in enumerate(shapes) if shape.kind != "crack"]
    scanned = beside if len(beside) <= _MOST_SCANNED else []
    by_gain = n + np.argsort(-start.gains[n:], kind="stable")[:_BY_GAIN]
    chosen = {*by_gain.tolist(), *scanned, *(n + k for k, s in enumerate(shapes) if s.element in near)}
    chosen |= {s[0] for s in singles[:_PARENTS]}
    fits = _refined(likelihood, [(c,) for c in sorted(chosen)])
    _singles(prepared, question, shapes, n, fits, found)
    # A spring that is a candidate is judged as one.
    named = {question.model.element_label(e) for e in question.elements}
    for kind, share in _ELSEWHERE.items():
        own = [k for k, s in enumerate(shapes) if s.kind == kind and s.name not in named]
        for k in own:
            if (n + k,) in fits:
                prior = float(np.log(share / len(own)))
                found.others.append(_beside(shapes[k], fits[n + k,], prior))
    best = max([likeliest, *fits.values()], key=lambda fit: fit.log_evidence)
    unknown = search.likelihood.something_else
    cracks = any(shape.kind == "crack" for shape in shapes)
    unsure = best.view.kappa > 0.0 or best.view.times > 1.0
    if cracks and (unsure or too_much(best.view) or best.log_evidence < unknown):
        pairs = _pairs(likelihood, shapes, numbers, question.elements, fits)
        _doubles(prepared, question, shapes, pairs, found)


_MOVED = (3e-3, 1e-2, 3e-2, 1e-1, 3e-1)  # changes (ln f) of the values of a sensor that has moved
_MOVES = 0.5  # probability that such a value changes


def _sensors(prepared: Prepared, model: StructuralModel) -> list[Shaped]:
    """Each sensor, or place of the force, by itself moved: some of its values changed, and no others."""
    likelihood, responses = prepared.likelihood, prepared.responses
    assert isinstance(responses, Responses)
    now: Values = likelihood.now
    ends = [[members(i) for i, *_ in responses.parts], [members(k) for _, k, *_ in responses.parts]]
    compared = np.unique(now.response).tolist()
    sides = [sorted({dof for nth in compared for dof in own[nth]}) for own in ends]
    moved_one = [(s, dof) for s, own in enumerate(sides) if len(own) >= _LEAST_SENSORS for dof in own]
    found: list[Shaped] = []
    for side, dof in moved_one:
        at = np.array([dof in several for several in ends[side]])
        view = likelihood.without_damage(np.where(at, _MOVED[-1], 0.0), 0.0)
        own = at[now.response[view.partner >= 0]]
        residual, wide = view.residual[own], view.std[own] ** 2
        # Independent by value: the same, or changed by one of these.
        still = np.maximum(wide - _MOVED[-1] ** 2, 1e-12)
        variance = still + np.square([0.0, *_MOVED])[:, None]
        share = np.repeat([1.0 - _MOVES, _MOVES / len(_MOVED)], [1, len(_MOVED)])[:, None]
        each = np.log(share) - 0.5 * (np.log(variance / wide) + residual**2 * (1.0 / variance - 1.0 / wide))
        evidence = view.log_likelihood + float(np.logaddexp.reduce(each, axis=0).sum())
        prior = float(np.log(SENSOR / len(moved_one)))
        place = f"{('sensor', 'force')[side]} at {model.dof_label(dof)} moved or changed"
        found.append(Shaped("sensor", place, evidence + prior, view))
    return found


def _refined(
    likelihood: Likelihood,
    sets: Sequence[Elements],
    starts: FloatArray | None = None,
    errors: Sequence[float] = _TEMPERED,
) -> dict[Elements, Fit]:
    """The most probable amounts of each set, and its evidence."""
    if not sets:
        return {}
    betas = np.array([likelihood.rows(s, [[0.0] * len(s)])[0] for s in sets])
    if starts is None:
        rows = np.repeat(betas, _SCAN.size, axis=0)
        for nth, s in enumerate(sets):
            rows[nth * _SCAN.size : (nth + 1) * _SCAN.size, s[0]] = _SCAN
        left = likelihood.unexplained(rows).reshape(len(sets), -1)
        betas = rows.reshape(len(sets), _SCAN.size, -1)[np.arange(len(sets)), left.argmin(axis=1)]
    else:
        betas = starts
    fits: dict[Elements, Fit] = {}
    climbs, top = [Climb(s) for s in sets], -np.inf
    for nth, extra in enumerate((*errors, *[0.0] * (1 + _FURTHER))):
        views = likelihood.views(betas, extra)
        for climb, view in [] if extra else zip(climbs, views, strict=True):
            climb.sees(view)
            for fit in fitted(view, [climb.elements]):
                if climb.elements not in fits or fit.log_evidence > fits[climb.elements].log_evidence:
                    fits[climb.elements] = fit
        ahead = [c.ahead(v if extra else None) for c, v in zip(climbs, views, strict=True)]
        if nth < len(errors):
            logs = [view.log_likelihood for view in views]
            least = min(max(logs) - _HOPELESS, sorted(logs)[-_KEPT:][0]) if nth > 1 else -np.inf
            kept = [len(c.elements) == 1 or log >= least for c, log in zip(climbs, logs, strict=True)]
        else:  # those that have not come to rest
            top = max([top, *(climb.height for climb in climbs)])
            kept = [c.elements not in fits and c.height > top - _HOPELESS for c in climbs]
        climbs, betas = [climbs[n] for n in np.flatnonzero(kept)], np.array(ahead)[kept]
        if not climbs:
            break
    return fits | {c.elements: refitted(c.view, c.elements, at_peak=True) for c in climbs if c.share < 1.0}


class Crack(NamedTuple):
    """A crack at several places, and the most probable amounts at each; its own comes first."""

    places: list[tuple[Shape, Fit]]
    #: What is beside it: a crack at one place, or the number of an element among the likelihood's.
    beside: Shape | int | None = None

    @property
    def likeliest(self) -> tuple[Shape, Fit]:
        """The likeliest place."""
        return max(self.places, key=lambda each: each[1].log_evidence)

    def curve(self) -> tuple[FloatArray, FloatArray, list[tuple[Shape, Fit]]]:
        """Places in ascending order, log evidence, and the likelier crack at each."""
        best: dict[float, tuple[Shape, Fit]] = {}
        for shape, fit in self.places:
            known = best.get(shape.share)
            if known is None or fit.log_evidence > known[1].log_evidence:
                best[shape.share] = (shape, fit)
        places, own = sorted(best), [best[share] for share in sorted(best)]
        return np.array(places), np.array([fit.log_evidence for _, fit in own]), own

    def ahead(self) -> list[float]:
        """Places from where to see more of it: the top of a parabola through the likeliest, and beside it."""
        shares, heights, _ = self.curve()
        at = int(np.argmax(heights))
        near, ends = slice(max(at - 1, 0), at + 2), (0.0, 1.0)
        x, y = shares[near], heights[near]
        wanted: list[float] = []
        if x.size == 3:
            bent, slope, _ = np.polyfit(x - x[1], y, 2)
            if bent < 0.0:
                top, wide = x[1] - 0.5 * slope / bent, np.sqrt(-0.5 / bent)
                wanted = [top, top - 1.5 * wide, top + 1.5 * wide]
        around = [x[0] if at else shares[at] - _STEP, x[-1] if at + 1 < shares.size else shares[at] + _STEP]
        wanted = wanted or [0.5 * (shares[at] + other) for other in around]
        found: list[float] = []
        for each in np.clip(wanted, *ends).tolist():
            if min(abs(each - other) for other in [*shares.tolist(), *found]) > _SAME_PLACE:
                found.append(each)
        return found

    def over_places(self) -> tuple[float, tuple[float, float], tuple[float, float, float]]:
        """Log evidence averaged over the length, interval of the place, severity with its interval."""
        from scipy.interpolate import PchipInterpolator
        from scipy.special import ndtri

        shares, heights, best = self.curve()
        along = np.clip(_SHARES, shares[0], shares[-1])
        height = PchipInterpolator(shares, heights)(along) if shares.size > 1 else heights[0] + 0.0 * along
        weight = np.exp(height - heights.max())
        total = float(heights.max() + np.log(weight.mean()))
        cumulative = np.cumsum(weight) / weight.sum()
        low, high = (float(_SHARES[np.searchsorted(cumulative, q)]) for q in SHARES)
        shape, fit = self.likeliest
        losses = []
        for one, own in best:
            u = own.mean[0] + np.sqrt(own.covariance[0, 0]) * ndtri(_QUANTILES)
            losses.append(one.loss(-np.expm1(-np.clip(u, 0.0, FURTHEST))))
        every = np.array([np.interp(_SHARES, shares, each) for each in np.transpose(losses)])
        order = np.argsort(every, axis=None)
        mass = np.cumsum(np.broadcast_to(weight, every.shape).ravel()[order])
        ends = np.interp(SHARES, mass / mass[-1], every.ravel()[order])
        loss = float(shape.loss(fit.beta[0]))
        severity = loss, min(float(ends[0]), loss), max(float(ends[1]), loss)
        wrong = float(ndtri(SHARES[1])) * _OFF_PLACE * fit.view.gain_std
        reach = [float(np.hypot(max(side, 0.0), wrong)) for side in (shape.share - low, high - shape.share)]
        return total, (max(shape.share - reach[0], 0.0), min(shape.share + reach[1], 1.0)), severity


def _narrowed(prepared: Prepared, question: Question, crack: Crack) -> Crack:
    """More places of a crack, ever nearer to the likeliest."""
    n, factors, beside = len(prepared.numbers), prepared.stiffness_factors, crack.beside
    for _ in range(_ROUNDS):
        shares, (likeliest, fit) = crack.ahead(), crack.likeliest
        if not shares:
            break
        more, other = prepared.structure.cracks(likeliest.element, shares, factors), []
        own: list[Elements] = [(n + k,) for k in range(len(more))]
        if isinstance(beside, Shape):
            other = prepared.structure.cracks(beside.element, [beside.share], factors)
            own = [(*each, n + len(more) + other.index(beside)) for each in own]
        elif beside is not None:
            own = [(*each, beside) for each in own]
        likelihood = with_shapes(prepared, question, more + other)
        if likelihood is None:
            break
        starts = np.zeros((len(own), likelihood.n))
        for row, columns, shape in zip(starts, own, more, strict=True):
            row[list(columns)] = [shape.amount(likeliest.loss(float(fit.beta[0]))), *fit.beta[1:]]
        fits = _refined(likelihood, own, starts, _NEAR)
        crack.places.extend((more[columns[0] - n], one) for columns, one in fits.items())
    return crack


def _singles(
    prepared: Prepared,
    question: Question,
    shapes: Sequence[Shape],
    n: int,
    fits: dict[Elements, Fit],
    found: Found,
) -> None:
    """Cracks of each element: evidence over their places, and the likeliest place narrowed down."""
    by_element: dict[int, Crack] = {}
    for k, shape in enumerate(shapes):
        if shape.kind == "crack" and (n + k,) in fits and shape.element in question.elements:
            by_element.setdefault(shape.element, Crack([])).places.append((shape, fits[n + k,]))
    order = sorted(by_element.values(), key=lambda crack: -crack.likeliest[1].log_evidence)
    for rank, crack in enumerate(order):
        height = crack.likeliest[1].log_evidence
        if rank < _NARROWED and height > order[0].likeliest[1].log_evidence - _HOPELESS:
            crack = _narrowed(prepared, question, crack)
        shape, fit = crack.likeliest
        total, reach, losses = crack.over_places()
        rows = [(float(each),) for each in losses]
        key = (prepared.numbers.index(shape.element),)
        found.cracked[key] = Shaped("crack", shape.told(reach), total, fit.view, *rows)


def _beside(shape: Shape, fit: Fit, log_prior: float) -> Shaped:
    """What is in no element."""
    low, high = fit.interval(0, SHARES)[0]
    if shape.kind == "mass":
        kg = [shape.size * beta for beta in (float(fit.beta[0]), low, high)]
        place = f"{kg[0]:.3g} kg ({kg[1]:.3g} to {kg[2]:.3g}) added at {shape.name or f'node {shape.node}'}"
    elif shape.name and shape.node < 0:
        lost = [f"{100 * beta:.1f}" for beta in (float(fit.beta[0]), low, high)]
        place = f"{shape.name} has lost {lost[0]} % ({lost[1]} to {lost[2]})"
    else:
        what = "support" if shape.kind == "support" else f"joint of element {shape.element}"
        place = f"{shape.name} yields" if shape.name else f"{what} at node {shape.node} turns"
    return Shaped(shape.kind, place, fit.log_evidence + log_prior, fit.view)


def _pairs(
    likelihood: Likelihood,
    shapes: Sequence[Shape],
    numbers: Sequence[int],
    candidates: Sequence[int],
    fits: dict[Elements, Fit],
) -> dict[Elements, Fit]:
    """Pairs of cracks, or of a crack and an element, in two candidates."""
    owner = np.array([*numbers, *(s.element if s.kind == "crack" else -1 for s in shapes)])
    owner[~np.isin(owner, candidates)] = -1
    singles = sorted((s for s in fits if owner[s[0]] >= 0), key=lambda s: -fits[s].log_evidence)
    first: dict[tuple[int, bool], tuple[int, float]] = {}
    for (c,) in singles:  # each element, and its likeliest crack
        first.setdefault((owner[c], c < len(numbers)), (c, float(fits[c,].beta[0])))
    parents, tried = list(first.values())[:_PARENTS], set[int]()
    found: dict[Elements, Fit] = {}
    while parents:
        tried.update(c for c, _ in parents)
        found |= _refined(likelihood, *_joined(likelihood, owner, parents, found))
        # What the members of the likeliest pairs are joined by, of the amount that they have in these.
        near = sorted(found.values(), key=lambda fit: -fit.log_evidence)[:_NEAREST]
        members = {c: float(beta) for fit in near for c, beta in zip(fit.elements, fit.beta, strict=True)}
        parents = [(c, beta) for c, beta in members.items() if c not in tried]
    return found


def _joined(
    likelihood: Likelihood,
    owner: NDArray[np.intp],
    parents: Sequence[tuple[int, float]],
    known: Container[Elements],
) -> tuple[list[Elements], FloatArray]:
    """New pairs that explain most, and the amounts at which they do."""
    rows, sets = [], []
    alone = np.concatenate([likelihood.rows((c,), [[beta]]) for c, beta in parents])
    for (first, _), view in zip(parents, likelihood.views(alone), strict=True):
        gains = np.where((owner >= 0) & (owner != owner[first]), view.gains, -1.0)
        joining = np.argsort(-gains, kind="stable")[: min(_JOINING, int((gains > 0.0).sum()))]
        for second in joining.tolist():
            for amount in _SCAN:
                row = view.beta.copy()
                row[second] = amount
                rows.append(row)
                sets.append((first, second))
    chosen: dict[Elements, FloatArray] = {}
    left = likelihood.unexplained(np.array(rows)) if rows else np.empty(0)
    for at in np.argsort(left, kind="stable").tolist():
        key = tuple(sorted(sets[at]))
        if key not in chosen and key not in known and len(chosen) < _PAIRS:
            chosen[key] = rows[at]
    return list(chosen), np.array(list(chosen.values()))


def _doubles(
    prepared: Prepared, question: Question, shapes: Sequence[Shape], pairs: dict[Elements, Fit], found: Found
) -> None:
    """Pairs by their elements; places of the likeliest are narrowed down, of others one stands for all."""
    n, numbers = len(prepared.numbers), prepared.numbers
    order = sorted(pairs.values(), key=lambda fit: -fit.log_evidence)
    for rank, fit in enumerate(order):
        parts: list[Shape | int] = [shapes[c - n] if c >= n else c for c in fit.elements]
        near = rank < _NARROWED and fit.log_evidence > order[0].log_evidence - _HOPELESS
        rows: dict[int, tuple[float, float, float]] = {}
        places, averaged = [], 0.0
        for nth in (0, 1):
            part, fit = parts[nth], refitted(fit.view, fit.elements[::-1] if nth else fit.elements)
            if not isinstance(part, Shape):
                rows[part] = (float(fit.beta[0]), *fit.interval(0, SHARES)[0])
                continue
            crack = Crack([(part, fit)], parts[1 - nth])
            if near:
                crack = _narrowed(prepared, question, crack)
            total, reach, losses = crack.over_places()
            part, fit = crack.likeliest
            parts[nth] = part
            averaged += total - fit.log_evidence if near else -_OVER_PLACES
            rows[numbers.index(part.element)] = losses
            places.append(part.told(reach if near else None))
        key, log_evidence = tuple(sorted(rows)), fit.log_evidence + averaged
        if places and (key not in found.cracked or log_evidence > found.cracked[key].log_evidence):
            kind = "crack" if len(places) == len(rows) else "crack and element"
            severities, low, high = zip(*(rows[each] for each in key), strict=True)
            found.cracked[key] = Shaped(
                kind, "; ".join(places), log_evidence, fit.view, severities, low, high
            )
