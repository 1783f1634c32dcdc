"""What detectable damage is told from: roots that can be followed and that stay while nothing is damaged."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.updating.targets import STEP, complex_zeros, followed, steady
from reference.symmetric_structures import cases, true_zeros


def case_named(name):
    return next(case for case in cases() if case.name == name)


def weights_of(case, model, sees="transmissibility"):
    """Roots and weights of each sensor."""
    parameters = ar.stiffness_reduction(model.default_elements)
    moved = [model.with_parameters(parameters, STEP * unit) for unit in np.eye(len(parameters))]
    dofs = list(case.sensors)
    found = steady(model, moved, dofs, case.excitation, case.band_hz[1], sees, dofs)
    return dict(zip(dofs, found, strict=True))


@pytest.mark.parametrize("name", ["10 masses, 2 held", "1 storeys of 4, corner"])
def test_complex_zeros_are_those_of_the_deleted_pencil(name):
    case = case_named(name)
    model, limit_hz = case.build(0.003), case.band_hz[1]
    compared = 0
    for dof in case.sensors:
        theirs = true_zeros(model, dof, case.excitation)
        part = theirs.imag / np.abs(theirs)
        theirs = theirs[(part > 0.005) & (part <= 0.15) & (np.abs(theirs) <= limit_hz)]
        freq, ours = complex_zeros(model, dof, case.excitation, limit_hz)
        assert freq == pytest.approx(np.sort(np.abs(theirs)), rel=2e-3)
        order = np.argsort(np.abs(theirs))
        assert ours == pytest.approx((theirs.imag / np.abs(theirs))[order], abs=2e-3)
        compared += freq.size
    assert compared


def test_roots_of_a_chain_count_in_full_on_nodes_too():
    case = case_named("7 equal masses, force at 0")
    found = weights_of(case, case.build(0.0))
    assert found[3][0] == pytest.approx([15.84, 44.38, 64.13], abs=0.005)
    assert all(np.all(weight == 1.0) for _, weight in found.values())
    # No FRF shows what lies on a resonance.
    assert not weights_of(case, case.build(0.0), "frf")[3][1].any()


def test_roots_that_hang_on_small_differences_do_not_count():
    case = case_named("1 storeys of 2, corner")
    for spread in (0.0, 1e-3):
        found = weights_of(case, case.build(spread))
        # The middle of the beam hardly follows a push at the corner, but for asymmetry.
        middle = found.pop(case.sensors[-1])
        inside = middle[1][(middle[0] > 50.0) & (middle[0] < 150.0)]
        assert inside.size
        assert not inside.any()
        assert all(np.median(weight) == 1.0 for _, weight in found.values())


def test_each_root_has_one_heir_and_new_ones_count_nothing():
    own = (np.array([10.0, 20.0, 20.0, 30.0]), np.array([1.0, 0.5, 0.25, 0.0]))
    now = np.array([9.8, 14.0, 19.5, 20.0, 29.0])
    freq, weight = followed(own, now)
    assert (freq.tolist(), sorted(weight.tolist())) == ([9.8, 19.5, 20.0], [0.25, 0.5, 1.0])
    assert followed(own, None)[0].size == followed((np.empty(0), np.empty(0)), now)[0].size == 0
