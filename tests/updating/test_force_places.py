"""Places of unknown forces, ranked by what a model explains."""

from itertools import combinations

import numpy as np
import pytest

import antires_rs as ar
from reference.several_forces import record_of
from tests.support.refusals import refused

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
    refused("band_hz: got None with a set made by hand", ar.rank_force_places, CHAIN, zeros)
    refused("1 place for 2 forces", ar.rank_force_places, CHAIN, zeros, [3], band_hz=BAND)
    with pytest.raises(ar.InvalidInputError, match=r"places\[1\]: got 1 dof for 2 forces"):
        ar.rank_force_places(CHAIN, zeros, [(1, 2), (3, 3)], band_hz=BAND)
    refused("no antiresonance from 30 to 40", ar.rank_force_places, CHAIN, zeros, band_hz=(30, 40))
    refused("places", ar.rank_force_places, CHAIN, zeros, [], band_hz=BAND)
    for one in (3.0, "mass 3", True):
        refused("Put the dofs in a list", ar.rank_force_places, CHAIN, zeros, one, band_hz=BAND)
    with pytest.raises(ar.InvalidInputError, match="measured dof: got 50"):
        ar.rank_force_places(CHAIN, ar.AntiresonanceSet(("a", "b"), {(0, 50): [20.0]}), band_hz=BAND)


def seen_by_ratios(sensors, force):
    """What transmissibilities of some masses of the chain show: no root that all of them share."""
    exact = [CHAIN.antiresonances(dof, force, f_max_hz=BAND[1]) for dof in sensors]
    shared = [f for f in exact[0] if all(np.isclose(other, f, rtol=1e-8).any() for other in exact)]
    own = [[f for f in hz if not np.isclose(shared, f, rtol=1e-8).any()] for hz in exact]
    return ar.AntiresonanceSet("somewhere", dict(zip(sensors, own, strict=True)), sees="transmissibility")


def test_roots_that_transmissibilities_do_not_show_are_not_missing():
    """Behind all sensors of a chain every place shows the same."""
    zeros = seen_by_ratios(range(3), 4)
    ranked = ar.rank_force_places(CHAIN, zeros, range(8), band_hz=BAND)
    assert ranked.places[:6] == (2, 3, 4, 5, 6, 7)
    np.testing.assert_allclose(ranked.log_evidence[:6], 0.0, atol=1e-6)
    assert ranked.missing[:6].tolist() == [0] * 6
    assert ranked.log_evidence[6] < -5.0


def test_roots_on_a_resonance_are_seen_by_transmissibilities():
    """A symmetric beam of four masses, forced in the middle: the odd mode is no pole of any response."""
    model = ar.MassSpringChain([1.0] * 5, [1000.0] * 4)
    zeros = {dof: model.antiresonances(dof, 2, include_cancelled=True) for dof in range(5)}
    shared = [f for f in zeros[2] if all(np.isclose(zeros[d], f).any() for d in range(5))]
    own = {d: [f for f in hz if not np.isclose(shared, f).any()] for d, hz in zeros.items()}
    measured = ar.AntiresonanceSet("somewhere", own, sees="transmissibility")
    ranked = ar.rank_force_places(model, measured, band_hz=(1.0, 11.0))
    assert ranked.best == 2
    assert ranked.explained[0] == ranked.n_values
    assert ranked.missing[0] == 0


def test_one_force_named_where_two_act_is_no_answer():
    record = record_of(CHAIN, (1, 5), 100.0, 0.01, 4)
    with pytest.warns(ar.AntiresWarning):
        zeros = ar.identify_antiresonances(record, excitation="somewhere", band_hz=BAND)
    with pytest.warns(ar.AntiresWarning, match="unfit.*no place"):
        ar.rank_force_places(CHAIN, zeros, places=[0, 5], band_hz=BAND)
