"""Places of unknown forces, ranked by what a model explains."""

from functools import partial
from itertools import combinations

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.updating.problem import explained
from reference.forgotten_supports import PORTAL, PROPPED
from reference.several_forces import record_of
from tests.support.snapshots import refusals

CHAIN = ar.cases.chain8().model
BAND = (3.0, 130.0)


def seen_of(forces, rng, model=CHAIN, std=1e-3):
    """Exact antiresonances of all sets of responses, with errors."""
    sets = [*combinations(range(8), len(forces))]
    with pytest.warns(ar.AntiresWarning):  # minors that are zero
        exact = model.antiresonances(sets, forces, f_max_hz=BAND[1])
    values = {own: hz[hz > BAND[0]] for own, hz in zip(sets, exact, strict=True)}
    values = {own: np.sort(hz * (1.0 + std * rng.standard_normal(hz.size))) for own, hz in values.items()}
    return ar.AntiresonanceSet(("first", "second"), values, std_hz={k: std * v for k, v in values.items()})


@pytest.mark.parametrize("forces", [(0, 4), (2, 6), (1, 7)])
def test_places_are_found_with_a_model_some_per_cent_off(forces):
    rng = np.random.default_rng(forces[0])
    off = ar.stiffness_reduction(range(7))
    model = CHAIN.with_parameters(off, rng.uniform(-0.06, 0.06, 7))
    ranked = ar.rank_force_places(model, seen_of(forces, rng), band_hz=BAND)
    assert ranked.best == forces
    assert len(ranked.places) == 28
    assert ranked.log_evidence[0] == 0.0
    assert ranked.log_evidence[1] < -5.0
    assert ranked.explained[0] > 0.9 * ranked.n_values
    assert ranked.rms_percent[0] < 3.0


def test_places_of_a_record_whose_places_nobody_named():
    record = record_of(CHAIN, (1, 5), 200.0, 0.01, 4)
    zeros = ar.identify_antiresonances(record, excitation=["first", "second"], band_hz=BAND, check="off")
    ranked = ar.rank_force_places(CHAIN, zeros, places=[(0, 5), (5, 1), (1, 6), (2, 5)])
    assert ranked.best == (1, 5)
    assert ranked.log_evidence[1] < -20.0
    named = zeros.relabelled(ranked.best, {dof: dof for dof in range(8)})
    assert named.excitation == (1, 5)
    head = "places of the forces log evidence explained missing rms %"
    assert str(ranked).splitlines()[0].split() == head.split()
    assert len(str(ranked).splitlines()) == 5


def test_one_force_needs_its_place_too():
    exact = {dof: CHAIN.antiresonances(dof, 3, f_max_hz=BAND[1]) for dof in range(8)}
    ranked = ar.rank_force_places(CHAIN, ar.AntiresonanceSet("somewhere", exact), [0, 3, 5], band_hz=BAND)
    assert ranked.best == 3
    assert ranked.places[0] == 3


def test_refusals():
    zeros = ar.AntiresonanceSet(("a", "b"), {(0, 1): [20.0]})
    names = {"zeros": zeros, "ranked": partial(ar.rank_force_places, CHAIN)}
    refusals(__file__, "wrong_places.txt", globals() | names)


@pytest.mark.parametrize(("structure", "seed"), [(PORTAL, 4), (PROPPED, 5)])
def test_a_force_named_at_another_dof_is_said_to_fit_better_where_it_was(structure, seed):
    model, found, _ = structure.states(seed)
    right = model.dof(*structure.force)
    problems = {}
    for dof in found:
        moved = found.relabelled(dof, {own: own for own in found})
        problems[dof] = ar.UpdatingProblem(model, ar.stiffness_factor(0, bounds=(0.9, 1.1)), moved)
    for dof, problem in problems.items():
        said = explained(problem, problem.nominal, doubted=True).hint
        named = (
            f"With the force at {model.dof_label(right)} it would fit better than at {model.dof_label(dof)}."
        )
        assert said == ("" if dof == right else named)


def test_a_chain_hit_elsewhere_is_told_so_in_the_headline():
    rng = np.random.default_rng(2)
    masses, springs = 1.0 + 0.03 * rng.standard_normal((2, 6))
    nominal = ar.MassSpringChain(np.ones(6), np.full(5, 1e4), ground_first_n_per_m=1e4)

    def measured(loss):
        truth = ar.MassSpringChain(
            masses, 1e4 * springs[1:], ground_first_n_per_m=1e4 * (1.0 - loss) * springs[0]
        )
        exact = {dof: truth.antiresonances(dof, 2) for dof in range(6)}
        freq = {d: f * (1.0 + 3e-4 * rng.standard_normal(f.size)) for d, f in exact.items()}
        return ar.AntiresonanceSet(4, freq, std_hz={d: 3e-4 * f for d, f in freq.items()})

    said = ar.assess_damage(nominal, measured(0.2), baseline=measured(0.0), workers=1).headline
    assert said.startswith("The model does not explain the measurement")
    assert "With the force at mass 2 it would fit better than at mass 4." in said
