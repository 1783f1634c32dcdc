"""Damage assessment: which elements have lost stiffness, how much, and how sure that is."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .._core import __version__
from ..exceptions import part, reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import History, IslandGA, OptimizeResult, seed_of, thread_count
from ..support.checks import integer, shape_of
from ..support.options import gathered
from ..support.progress import waiting
from ..updating.problem import DamagePenalty, Measured, UpdatingProblem
from ..updating.update import search as find
from .inference import Inferred, infer
from .options import ONE_STATE, TWO_STATES, DamagePrior, SearchOptions, checked_prior
from .question import Question
from .reduced_roots import wanted_reduced
from .result import DamageResult

# -- The model, the elements and the prior that a question about damage names


def checked_model(model: Any) -> StructuralModel:
    """A model of ours."""
    if not isinstance(model, StructuralModel):
        reject(
            "model",
            model,
            "a MassSpringChain, FrameModel or MatrixModel",
            "Build the model as one of these first.",
        )
    return model


def checked_search(search: Any) -> SearchOptions:
    """Options of a search."""
    if search is not None and not isinstance(search, SearchOptions):
        reject("search", search, "a SearchOptions", "As in search=SearchOptions(std_common=0.001).")
    return search or SearchOptions()


def elements_of(model: StructuralModel, elements: Any) -> list[int]:
    """Candidate elements by number: all springs between masses, all beams or all terms by default."""
    terms = model._core.n_stiffness_terms
    if elements is None:
        chosen = list(model.default_elements)
    elif isinstance(elements, str) or (shape_of(elements) == () and not np.isscalar(elements)):
        reject("elements", elements, "numbers of elements", "As in elements=[3, 4].")
    else:
        chosen = [elements] if shape_of(elements) == () else list(elements)
    if not chosen:
        reject(
            "elements",
            "no candidate",
            "at least one stiffness term",
            f"Name some of 0 to {terms - 1}." if terms else "Give the MatrixModel its stiffness_terms.",
        )
    return [integer(part("elements", i), e, low=0, high=terms - 1) for i, e in enumerate(chosen)]


def assess_damage(
    model: StructuralModel,
    measured: Measured,
    *,
    baseline: Measured | None = None,
    elements: Any = None,
    prior: DamagePrior | None = None,
    search: SearchOptions | None = None,
    optimizer: IslandGA | None = None,
    rng: int | np.random.Generator | None = None,
    workers: int | None = None,
    callback: Callable[[dict[str, Any]], bool | None] | None = None,
    progress: bool | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    **older: Any,
) -> DamageResult:
    """Locate and size damage: the stiffness loss of each element that explains the measurement.

    With a baseline, the way to go, changes of the measured values are set against changes of the model,
    whose own errors are learned from the baseline; the answer is the most probable set of damaged elements,
    with its probability. Without one, the paper's search, in which every error of the model may come out as
    damage.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        The undamaged structure. With a baseline it need not be updated; without, it must be.
    measured : AntiresonanceSet, ModalSet, or several of one kind
        The structure as it is now: antiresonances, one set for each position of the force (or several, from
        repeated tests); or resonances with their shapes, one set for each setup of sensors.
        See :class:`UpdatingProblem`.
    baseline : AntiresonanceSet, ModalSet, or several of one kind, optional
        The intact structure, identified with the same sensors and forces. Standard deviations of both count.
    elements : sequence of int, optional
        Candidate elements, zero-based. Default: all springs between masses, all beams,
        all stiffness terms.
    prior : DamagePrior, optional
        What is believed before the test; with a baseline.
    search : SearchOptions, optional
        What few calls change: the rate of false alarms and reduced models with a baseline, the penalties
        without one.
    optimizer, callback, checkpoint
        Of the search without a baseline, as in :func:`update`.
    rng, workers, progress
        As in :func:`update`. With a baseline ``rng`` serves a rate of false alarms only.
    **older
        Options of ``search`` by name, as until 0.1; with a warning.

    Returns
    -------
    DamageResult
        ``.headline``, ``.hypotheses``, ``.probability`` {element: p}, ``.severity`` {element: beta},
        ``.interval``, ``.detectable`` {element: smallest visible beta}.

    Raises
    ------
    InvalidInputError
        An element outside the model or listed twice, measured dofs outside the model, a baseline without the
        forces of ``measured``, options of the search together with a baseline or those of a baseline without
        one.

    Examples
    --------
    >>> import antires_rs as ar
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [510.0, 495.0, 500.0])
    >>> damaged = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [510.0, 297.0, 500.0])
    >>> before, now = (ar.AntiresonanceSet(0, dict(enumerate(m.antiresonances([0, 1, 2, 3], 0))))
    ...                for m in (intact, damaged))
    >>> model = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 500.0, 500.0])
    >>> result = ar.assess_damage(model, now, baseline=before)
    >>> {element: round(beta, 2) for element, beta in result.severity.items()}, result.probability[1] > 0.99
    ({0: 0.0, 1: 0.4, 2: 0.0}, True)

    The paper's way:

    >>> result = ar.assess_damage(intact, now, rng=0)
    >>> {element: round(beta, 2) for element, beta in result.severity.items()}
    {0: 0.0, 1: 0.4, 2: 0.0}
    """
    checked_model(model)
    chosen = elements_of(model, elements)
    options = gathered("assess_damage", "search", checked_search(search), older)
    if baseline is None:
        _without({"prior": prior}, "together with a baseline")
        options = options.of(ONE_STATE)
        problem = UpdatingProblem(
            model, stiffness_reduction(chosen), measured, penalty=options.prices, weights=options.weights
        )
        found, seed, _ = find(problem, optimizer, rng, workers, callback, options.x0, progress, checkpoint)
        told = {"antires_rs": __version__, **options.held(ONE_STATE), **found.options}
        return DamageResult(problem, found, seed, options=told)
    options = options.of(TWO_STATES)
    _without({"optimizer": optimizer, "callback": callback, "checkpoint": checkpoint}, ONE_STATE)
    believed = checked_prior(prior, options)
    before, now = _sets("baseline", baseline), _sets("measured", measured)
    problem = UpdatingProblem(model, stiffness_reduction(chosen), now)  # speaks up where they do not fit
    if type(before[0]) is not type(now[0]):
        kinds = [
            "a ModalSet" if isinstance(each[0], ModalSet) else "an AntiresonanceSet" for each in (before, now)
        ]
        reject("baseline", kinds[0], f"{kinds[1]}, as measured", "Compare what is of one kind.")
    if not any(
        any(each.freq_hz) if isinstance(each, ModalSet) else any(map(len, each.values())) for each in before
    ):
        reject("baseline", f"no {problem.noun}", "those of the intact structure", "Identify in a wider band.")
    seed = seed_of(rng)
    reduced = wanted_reduced(model, now[0], options.reduction)
    question = Question(model, before, now, tuple(chosen), believed, options, reduced=reduced)
    with waiting("assessing damage", progress):
        inferred = infer(question, rng=np.random.default_rng(seed), threads=thread_count(workers))
    return _result(question, inferred, seed)


def _result(question: Question, inferred: Inferred, seed: int) -> DamageResult:
    """The answer as a result: the model after the baseline, and the values as it would have them."""
    elements = question.elements
    learned = question.model.with_parameters(inferred.factors, inferred.values)
    problem = UpdatingProblem(
        learned, stiffness_reduction(elements), inferred.corrected, penalty=DamagePenalty(0.0, 0.0, 0.0)
    )
    found = inferred.assessment
    x = np.array([found.severities.get(e, 0.0) for e in elements])
    judged, interrupted = len(found.hypotheses), found.interrupted
    none = np.empty(0)
    search_result = OptimizeResult(
        x=x,
        fun=problem.cost(x),
        success=not interrupted,
        status="interrupted" if interrupted else "judged",
        message=f"{judged} hypotheses were judged" + (" before Ctrl-C" if interrupted else ""),
        nfev=inferred.nfev,
        njev=None,
        nit=0,
        history=History(none, np.empty((0, 1)), none),
        populations=np.empty((0, 0, x.size)),
        population_costs=np.empty((0, 0)),
    )
    told = {"antires_rs": __version__, "prior": vars(question.prior), **question.options.held(TWO_STATES)}
    return DamageResult(problem, search_result, seed, found, question, inferred.reduction, options=told)


def _sets(name: str, given: Any) -> tuple[Any, ...]:
    sets = (given,) if isinstance(given, AntiresonanceSet | ModalSet) else given
    kinds = {type(each) for each in sets} if isinstance(sets, Sequence) else set()
    if kinds not in ({AntiresonanceSet}, {ModalSet}):
        reject(
            name,
            given,
            "an AntiresonanceSet or a ModalSet, or several of one kind",
            "Identify both states in the same way.",
        )
    return tuple(sets)


def _without(options: dict[str, Any], when: str) -> None:
    """Options that have no effect are refused, not ignored."""
    for name, value in options.items():
        if value is not None:
            reject(name, value, f"None: it counts only {when}", f"Leave {name} out.")
