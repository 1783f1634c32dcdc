"""Places of unknown forces, ranked by what a model explains."""

from functools import partial
from itertools import combinations

import numpy as np
import pytest

import antires_rs as ar
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
