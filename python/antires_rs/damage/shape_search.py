"""The search for what is no loss of a whole element, each judged by the likelihood of the assessment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..models.structural_model import StructuralModel
from ..support.checks import FloatArray
from ..support.progress import step
from .evidence import Fit, fitted
from .inference import SHARES, USUALLY_LOST, Elements, Search, stepped, too_much
from .likelihood import Likelihood, Prepared, Question, View
from .measured_states import Responses, Roots, Values, roots_at
from .shapes import Found, Shape, Shaped, Shapes, Structure

#: Shares of the prior of what is in no element, by kind.
_ELSEWHERE = {"mass": 0.4, "joint": 0.2, "support": 0.2}
SENSOR = 0.2
#: With fewer sensors the values of one are not told from those of all.
_LEAST_SENSORS = 3

# -- The likelihood with shapes behind the elements


class ShapedLikelihood(Likelihood):
    """p(values | severities of elements and amounts of shapes)."""

    offset: FloatArray

    def roots(self, betas: FloatArray, *, slopes: bool) -> list[Roots]:
        """See the base class."""
        return super().roots(betas + self.offset, slopes=slopes)


def with_shapes(prepared: Prepared, question: Question, shapes: Shapes) -> ShapedLikelihood | None:
    """None where the model with the shapes has not the same roots, as when some are close together."""
    plain, model = prepared.likelihood, prepared.base
    joined, responses = shapes.joined(model), prepared.responses
    assert isinstance(responses, Responses)
    own = prepared.reductions
    parameters = (*own, *shapes.parameters(model), *prepared.factors)
    core = responses.source(joined, question.model.description.core_parameters(parameters))
    offset = np.concatenate([np.zeros(len(own)), shapes.offset])
    x = np.concatenate([offset, plain.factors])
    intact = roots_at(core, x[None], slopes=True, threads=plain.threads)[0]
    before = plain.error.intact
    if intact.size != before.size or not np.allclose(intact.log_f, before.log_f, rtol=0.0, atol=1e-6):
        return None
    error = replace(plain.error, intact=intact)
    found = ShapedLikelihood(
        core, offset.size, error, prepared.intact, plain.now, plain.common, plain.threads, plain.ambient
    )
    found.offset, found.n_elements = offset, len(own)
    return found


# -- The search

#: Shapes that are looked at for their gain, to first order; elements whose cracks are, for their evidence.
_BY_GAIN, _BY_EVIDENCE, _MOST_SCANNED = 16, 3, 40
#: Gain of the log-likelihood, to first order, from which a shape may explain what no element does.
_GAIN = 4.0
#: Errors added on the way to the most probable amounts; sets given up when so far behind, but for so many.
_TEMPERED, _HOPELESS, _KEPT = (0.03, 0.01, 0.003, 0.0, 0.0, 0.0), 12.0, 6
#: Of pairs: sets that get another column, columns that join each, and pairs that are refined.
_PARENTS, _JOINING, _PAIRS = 4, 12, 12
#: Amounts of a scan.
_SCAN = np.array([0.03, 0.1, 0.25, 0.5, 0.75, 0.93])
#: Rounds in which the place of a crack is narrowed down, for so many elements.
_ROUNDS, _NARROWED = 2, 2
_SHARES = np.linspace(0.0, 1.0, 101)
#: What the likeliest place of a crack has over the mean of its element (ln), about.
_OVER_PLACES = 1.0


def found_shapes(search: Search, prepared: Prepared, question: Question) -> Found:
    """Judge the shapes of a frame beside the sets of elements that a search has found; nothing for others."""
    found = Found()
    if isinstance(prepared.responses, Responses):
        try:
            _search(search, prepared, question, found)
        except KeyboardInterrupt:
            search.interrupted = True
    return found


def _search(search: Search, prepared: Prepared, question: Question, found: Found) -> None:
    """Add to what is found."""
    frame = prepared.structure
    plain = prepared.likelihood.start
    lost = plain.partner.size - plain.n_matched
    changed = too_much(plain) or lost > max(1, USUALLY_LOST * plain.partner.size)
    if changed:
        found.others += _sensors(prepared, question.model)
    factor = prepared.stiffness_factors
    shapes = frame.shapes(factor)
    if not len(shapes):
        return
    step("cracks, joints and masses")
    likelihood = with_shapes(prepared, question, shapes)
    if likelihood is None:
        return
    n, numbers = search.likelihood.n, prepared.numbers
    start = likelihood.start
    likeliest = max(search.fits.values(), key=lambda fit: fit.log_evidence)
    if not (changed or likeliest.elements) and start.gains[n:].max(initial=0.0) < _GAIN:
        return
    singles = sorted((s for s in search.fits if len(s) == 1), key=lambda s: -search.fits[s].log_evidence)
    near = {numbers[s[0]] for s in singles[:_BY_EVIDENCE]}
    near |= {other for e in near for other in frame.neighbours(e)}
    # Large changes leave few values with a partner, and gains say little: what is in no element is scanned.
    beside = [n + k for k, shape in enumerate(shapes.shapes) if shape.kind != "crack"]
    scanned = beside if len(beside) <= _MOST_SCANNED else []
    by_gain = n + np.argsort(-start.gains[n:], kind="stable")[:_BY_GAIN]
    chosen = {*by_gain.tolist(), *scanned, *(n + k for k, s in enumerate(shapes.shapes) if s.element in near)}
    chosen |= {s[0] for s in singles[:_PARENTS]}
    fits = _refined(likelihood, [(c,) for c in sorted(chosen)])
    _narrow(prepared, question, frame, shapes, n, fits, found)
    # A spring that is a candidate is judged as one.
    named = {question.model.element_label(e) for e in question.elements}
    for kind, share in _ELSEWHERE.items():
        own = [k for k, s in enumerate(shapes.shapes) if s.kind == kind and s.name not in named]
        for k in own:
            if (n + k,) in fits:
                prior = float(np.log(share / len(own)))
                found.others.append(_beside(shapes.shapes[k], fits[n + k,], prior))
    best = max([likeliest, *fits.values()], key=lambda fit: fit.log_evidence)
    unknown = search.likelihood.something_else
    cracks = any(shape.kind == "crack" for shape in shapes.shapes)
    if cracks and (too_much(best.view) or best.log_evidence < unknown):
        pairs = _pairs(likelihood, shapes, numbers, question.elements, fits)
        _join_pairs(shapes, numbers, pairs, found)


#: Changes (ln f) of the values of a sensor that has moved.
_MOVED = (3e-3, 1e-2, 3e-2, 1e-1)


def _sensors(prepared: Prepared, model: StructuralModel) -> list[Shaped]:
    """Each sensor, or place of the force, by itself moved: its values changed, and no others."""
    likelihood, responses = prepared.likelihood, prepared.responses
    assert isinstance(responses, Responses)
    now: Values = likelihood.now
    dofs, compared = np.array([part[:2] for part in responses.parts]), np.unique(now.response)
    sides = [np.unique(dofs[compared, side]).tolist() for side in (0, 1)]
    moved_one = [(s, dof) for s, own in enumerate(sides) if len(own) >= _LEAST_SENSORS for dof in own]
    found: list[Shaped] = []
    for side, dof in moved_one:
        logs, views = [], []
        for moved in _MOVED:
            views.append(likelihood.without_damage(np.where(dofs[:, side] == dof, moved, 0.0), 0.0))
            logs.append(views[-1].log_likelihood)
        prior = np.log(SENSOR / len(moved_one)) - np.log(len(_MOVED))
        place = f"{('sensor', 'force')[side]} at {model.dof_label(dof)} moved or changed"
        view = views[int(np.argmax(logs))]
        found.append(Shaped("sensor", place, float(np.logaddexp.reduce(logs) + prior), view))
    return found


def _refined(
    likelihood: Likelihood, sets: Sequence[Elements], starts: FloatArray | None = None
) -> dict[Elements, Fit]:
    """The most probable amounts of each set, and its evidence."""
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
    sets = list(sets)
    for nth, extra in enumerate(_TEMPERED):
        views = likelihood.views(betas, extra)
        logs = np.array([view.log_likelihood for view in views])
        order = np.argsort(-logs, kind="stable")
        kept = sorted(
            n
            for rank, n in enumerate(order)
            if nth < 2 or rank < _KEPT or logs[n] > logs[order[0]] - _HOPELESS
        )
        sets, views = [sets[n] for n in kept], [views[n] for n in kept]
        if not extra:
            _keep(fits, sets, views)
        betas = np.array([stepped(s, view) for s, view in zip(sets, views, strict=True)])
    _keep(fits, sets, likelihood.views(betas))
    return fits


def _keep(fits: dict[Elements, Fit], sets: Sequence[Elements], views: Sequence[View]) -> None:
    for s, view in zip(sets, views, strict=True):
        for fit in fitted(view, [s]):
            if s not in fits or fit.log_evidence > fits[s].log_evidence:
                fits[s] = fit


def _narrow(
    prepared: Prepared,
    question: Question,
    frame: Structure,
    shapes: Shapes,
    n: int,
    fits: dict[Elements, Fit],
    found: Found,
) -> None:
    """Cracks of each element: evidence over their places, and the likeliest place narrowed down."""
    by_element: dict[int, list[tuple[Shape, Fit]]] = {}
    for k, shape in enumerate(shapes.shapes):
        if shape.kind == "crack" and (n + k,) in fits:
            by_element.setdefault(shape.element, []).append((shape, fits[n + k,]))
    order = sorted(by_element, key=lambda e: -max(fit.log_evidence for _, fit in by_element[e]))
    top = max((fit.log_evidence for each in by_element.values() for _, fit in each), default=0.0)
    for rank, element in enumerate(order):
        if element not in question.elements:
            continue
        own = by_element[element]
        best = max(fit.log_evidence for _, fit in own)
        if rank < _NARROWED and best > top - _HOPELESS:
            for _ in range(_ROUNDS):
                shares = _between(own)
                if not shares:
                    break
                extra = frame.cracks(element, shares, prepared.stiffness_factors)
                likelihood = with_shapes(prepared, question, extra)
                if likelihood is None:
                    break
                more = _refined(likelihood, [(n + k,) for k in range(len(extra))])
                own = own + [(extra.shapes[key[0] - n], fit) for key, fit in more.items()]
        found.cracked[(prepared.numbers.index(element),)] = _over_places(own)


def _between(own: list[tuple[Shape, Fit]]) -> list[float]:
    """Places beside the likeliest one, between it and its neighbours."""
    shares = np.array(sorted({shape.share for shape, _ in own}))
    likeliest = max(own, key=lambda each: each[1].log_evidence)[0].share
    at = int(np.argmin(np.abs(shares - likeliest)))
    around = [0.0 if at == 0 else shares[at - 1], 1.0 if at == shares.size - 1 else shares[at + 1]]
    middles = [0.5 * (likeliest + other) for other in around]
    return [m for m in middles if np.abs(shares - m).min() > 0.02]


def _over_places(own: list[tuple[Shape, Fit]]) -> Shaped:
    """Evidence averaged over the length, and the interval of the place."""
    best: dict[float, float] = {}
    for shape, fit in own:
        best[shape.share] = max(best.get(shape.share, -np.inf), fit.log_evidence)
    shares = np.array(sorted(best))
    curve = np.interp(_SHARES, shares, [best[s] for s in shares])
    weight = np.exp(curve - curve.max())
    total = float(curve.max() + np.log(weight.mean()))
    cumulative = np.cumsum(weight) / weight.sum()
    low, high = (float(_SHARES[np.searchsorted(cumulative, q)]) for q in SHARES)
    shape, fit = max(own, key=lambda each: each[1].log_evidence)
    return _cracked([shape], fit, [0], total, (min(low, shape.share), max(high, shape.share)))


def _cracked(
    shapes: Sequence[Shape | int],
    fit: Fit,
    at: Sequence[int],
    log_evidence: float,
    reach: tuple[float, float] | None = None,
) -> Shaped:
    """A crack, or one beside another or beside the loss of an element; ``at`` are their places in the fit."""
    places, rows = [], []
    for one, nth in zip(shapes, at, strict=True):
        losses = [float(fit.beta[nth]), *fit.interval(nth, SHARES)]
        if isinstance(one, Shape):
            losses = [one.loss(beta) for beta in losses]
            middle, ends = one.share * one.length_m, ""
            if reach is not None:
                ends = f" ({reach[0] * one.length_m:.3g} to {reach[1] * one.length_m:.3g})"
            places.append(f"crack {middle:.3g} m{ends} from node {one.node} in element {one.element}")
        rows.append(losses)
    kinds = "crack" if len(places) == len(rows) else "crack and element"
    return Shaped(kinds, "; ".join(places), log_evidence, fit.view, *map(tuple, zip(*rows, strict=True)))


def _beside(shape: Shape, fit: Fit, log_prior: float) -> Shaped:
    """What is in no element."""
    low, high = fit.interval(0, SHARES)
    if shape.kind == "mass":
        kg = [shape.size * beta for beta in (float(fit.beta[0]), low, high)]
        place = f"{kg[0]:.3g} kg ({kg[1]:.3g} to {kg[2]:.3g}) added at {shape.name or f'node {shape.node}'}"
    elif shape.name:
        lost = [f"{100 * beta:.1f}" for beta in (float(fit.beta[0]), low, high)]
        place = f"{shape.name} has lost {lost[0]} % ({lost[1]} to {lost[2]})"
    else:
        what = "support" if shape.kind == "support" else f"joint of element {shape.element}"
        place = f"{what} at node {shape.node} turns"
    return Shaped(shape.kind, place, fit.log_evidence + log_prior, fit.view)


def _pairs(
    likelihood: Likelihood,
    shapes: Shapes,
    numbers: Sequence[int],
    candidates: Sequence[int],
    fits: dict[Elements, Fit],
) -> dict[Elements, Fit]:
    """Pairs of cracks, or of a crack and an element, in two candidates."""
    owner = np.array([*numbers, *(s.element if s.kind == "crack" else -1 for s in shapes.shapes)])
    owner[~np.isin(owner, candidates)] = -1
    parents = sorted((s for s in fits if owner[s[0]] >= 0), key=lambda s: -fits[s].log_evidence)
    taken: list[Elements] = []
    for s in parents:  # the likeliest place of each element
        if owner[s[0]] not in [owner[t[0]] for t in taken]:
            taken.append(s)
    rows, sets = [], []
    for (first,) in taken[:_PARENTS]:
        view = fits[first,].view
        gains = np.where((owner >= 0) & (owner != owner[first]), view.gains, -1.0)
        joining = np.argsort(-gains, kind="stable")[: min(_JOINING, int((gains > 0.0).sum()))]
        for second in joining.tolist():
            for amount in _SCAN:
                row = view.beta.copy()
                row[second] = amount
                rows.append(row)
                sets.append((first, second))
    if not rows:
        return {}
    left = likelihood.unexplained(np.array(rows))
    chosen: dict[Elements, FloatArray] = {}
    for at in np.argsort(left, kind="stable").tolist():
        key = tuple(sorted(sets[at]))
        if key not in chosen and len(chosen) < _PAIRS:
            chosen[key] = rows[at]
    return _refined(likelihood, list(chosen), np.array(list(chosen.values())))


def _element(one: Shape | int) -> int:
    return one.element if isinstance(one, Shape) else one


def _join_pairs(shapes: Shapes, numbers: Sequence[int], pairs: dict[Elements, Fit], found: Found) -> None:
    """Pairs by their elements; over places, the likeliest stands for its share."""
    for columns, fit in pairs.items():
        n = len(numbers)
        named = [(nth, shapes.shapes[c - n] if c >= n else numbers[c]) for nth, c in enumerate(columns)]
        own = sorted(named, key=lambda each: numbers.index(_element(each[1])))
        key = tuple(numbers.index(_element(one)) for _, one in own)
        n_cracks = sum(isinstance(one, Shape) for _, one in own)
        if not n_cracks:
            continue
        log_evidence = fit.log_evidence - n_cracks * _OVER_PLACES
        if key not in found.cracked or log_evidence > found.cracked[key].log_evidence:
            found.cracked[key] = _cracked([one for _, one in own], fit, [nth for nth, _ in own], log_evidence)
