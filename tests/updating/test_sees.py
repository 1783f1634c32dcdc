"""The model answers in kind: with roots that cancel in an FRF where transmissibilities were measured.

Records of the symmetric structures are simulated from K and M as matrices.
"""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.updating.problem import explained
from antires_rs.updating.targets import complex_zeros
from reference.symmetric_structures import cases, true_zeros
from tests.support.campaign import some_of

CHAIN = ar.MassSpringChain(np.ones(7), np.full(6, 5e4))
SPRINGS = ar.stiffness_reduction(range(6))
#: Free, seven equal masses, k/m = 5e4 1/s^2, force at 0: on the nodes of all odd modes.
ON_NODES = [15.84, 44.38, 64.13]


def zeros_of(model, force):
    return dict(enumerate(model.antiresonances(range(model.n_dof), force, include_cancelled=True)))


def paired(freq_hz, sees, force=0, channels=range(7)):
    measured = ar.AntiresonanceSet(force, freq_hz, sees=sees, channels=channels)
    return ar.UpdatingProblem(CHAIN, SPRINGS, measured).paired_hz(np.zeros(6))


def test_a_transmissibility_sees_what_a_node_hides_but_not_what_all_channels_share():
    for sees in ("transmissibility", None):
        assert paired({3: ON_NODES}, sees) == pytest.approx(ON_NODES, abs=0.005)
    assert np.isnan(paired({3: ON_NODES}, "frf")).all()
    given = {2: [15.84, 44.38]}  # Force on the node of the odd modes, whose roots are in every numerator.
    assert paired(given, None, force=3) == pytest.approx([15.84, 44.38], abs=0.005)
    shown = CHAIN.antiresonances(2, 3)
    for sees in ("transmissibility", "frf"):
        assert set(paired(given, sees, force=3)) <= set(shown)
    # A single channel, or one that the model does not have: nothing is known to be shared.
    assert paired(given, "transmissibility", 3, channels=[2]) == pytest.approx([15.84, 44.38], abs=0.005)
    assert paired(given, "transmissibility", 3, channels=[2, 99]) == pytest.approx([15.84, 44.38], abs=0.005)


def test_an_intact_symmetric_chain_is_found_undamaged_in_each_kind():
    every, plain = zeros_of(CHAIN, 0), dict(enumerate(CHAIN.antiresonances(range(7), 0)))
    for sees, zeros in (("transmissibility", every), ("frf", plain), (None, every), (None, plain)):
        measured = ar.AntiresonanceSet(0, zeros, sees=sees)
        result = ar.assess_damage(CHAIN, measured, search=ar.SearchOptions(gamma1=0.1, gamma2=0.1), rng=0)
        assert (result.damaged, result.table.largest_before_percent) == ([], 0.0)
        assert min(result.detectable.values()) > 0.015


def test_damage_that_keeps_and_damage_that_breaks_the_symmetry_is_found():
    for element in (0, 2):
        true = CHAIN.with_parameters(ar.stiffness_reduction([element]), [0.2])
        measured = ar.AntiresonanceSet(0, zeros_of(true, 0), sees="transmissibility")
        result = ar.assess_damage(CHAIN, measured, rng=0)
        assert result.damaged == [element]
        assert result.severity[element] == pytest.approx(0.2, abs=0.02)


def test_the_objective_does_not_jump_where_the_symmetry_breaks():
    for force, given in ((0, {3: ON_NODES}), (3, {2: [15.9, 22.1]})):
        measured = ar.AntiresonanceSet(force, given, sees="transmissibility", channels=range(7))
        problem = ar.UpdatingProblem(CHAIN, SPRINGS, measured)
        at_rest = problem.cost(np.zeros(6))
        for element in range(6):
            small = np.zeros(6)
            for beta in 10.0 ** np.arange(-15.0, -5.0):
                small[element] = beta
                assert problem.cost(small) == pytest.approx(at_rest, abs=3e-5)


def test_halves_of_complex_zeros_are_left_out_and_named():
    case = next(c for c in cases() if c.name == "10 masses, 2 held")
    model = case.build(0.003)
    met = ((d, *complex_zeros(model, d, case.excitation, 78.0)) for d in case.sensors)
    dof, (freq, *_), (part, *_) = next(one for one in met if one[1].size)  # two antiresonances of this ring
    zeros = dict(zip(case.sensors, model.antiresonances(case.sensors, case.excitation), strict=True))
    damping = {d: np.full(f.size, 0.01) for d, f in zeros.items()}
    zeros[dof] = np.append(zeros[dof], freq)
    damping[dof] = np.append(damping[dof], 0.01 + part)
    measured = ar.AntiresonanceSet(case.excitation, zeros, damping, sees="transmissibility")
    parameters = ar.stiffness_reduction(model.default_elements)
    problem = ar.UpdatingProblem(model, parameters, measured, weights=np.ones(sum(map(len, zeros.values()))))
    (note,) = problem.left_out
    assert note.startswith(f"Left out: {freq:.2f} Hz at dof {dof}, damped by {100 * (0.01 + part):.1f} %")
    assert "half of a complex zero" in note
    assert problem.measured_hz.size == problem.weights.size == sum(map(len, zeros.values())) - 1
    assert np.abs(problem.residuals(problem.nominal)).max() < 1e-9
    # Without damping ratios nothing is told.
    plain = ar.AntiresonanceSet(case.excitation, zeros, sees="transmissibility")
    assert ar.UpdatingProblem(model, parameters, plain).left_out == ()


@pytest.mark.parametrize("name", ["10 masses, 2 held", "1 storeys of 4, corner"])
def test_complex_zeros_are_those_of_the_deleted_pencil(name):
    case = next(c for c in cases() if c.name == name)
    model, limit_hz = case.build(0.003), case.band_hz[1]
    compared = 0
    for dof in case.sensors:
        theirs = true_zeros(model, dof, case.excitation)
        part = theirs.imag / np.abs(theirs)
        theirs = theirs[(part > 0.005) & (part <= 0.15) & (np.abs(theirs) <= limit_hz)]
        freq, ours = complex_zeros(model, dof, case.excitation, limit_hz)
        assert freq == pytest.approx(np.sort(np.abs(theirs)), rel=2e-3)
        assert ours == pytest.approx((theirs.imag / np.abs(theirs))[np.argsort(np.abs(theirs))], abs=2e-3)
        compared += freq.size
    assert compared


QUICK = ["5 equal masses, force at 0", "1 storeys of 2, corner"]


@pytest.mark.parametrize("name", some_of([case.name for case in cases()], QUICK))
def test_intact_symmetric_structures_are_undamaged_and_their_damage_is_as_visible_as_a_twins(name):
    case = next(c for c in cases() if c.name == name)
    model, twin = case.build(0.0), case.build(1e-3)
    assert ar.assess_damage(model, case.identified(model, noise=0.01, seed=1), rng=0).damaged == []
    result, other = (ar.assess_damage(m, case.identified(m), rng=0) for m in (model, twin))
    assert result.damaged == other.damaged == []
    for element, least in result.detectable.items():
        low, high = sorted([least, other.detectable[element]])
        assert low > 0.3 or high < 1.2 * low


def test_what_cancels_in_a_frame_in_space_needs_no_partner_among_values_without_an_origin():
    nodes = [[0, 0, 0], [0, 0, 0.5], [0, 0, 1], [0.5, 0, 1], [1, 0, 1], [1.3, 0, 0.6], [1.6, 0, 0.2]]
    tube = ar.Tube(0.05, 0.002, 2.1e11, 7850.0)
    frame = ar.FrameModel(nodes, [[i, i + 1] for i in range(6)], tube, fixed=[0])
    dofs = [frame.dof(node, "u") for node in (2, 3, 5)]  # in its plane: what bends out of it is not shaken
    values = {k: hz[hz < 700.0] for k, hz in zip(dofs, frame.antiresonances(dofs, dofs[1]), strict=True)}
    for sees in (None, "frf", "transmissibility"):
        measured = ar.AntiresonanceSet(dofs[1], values, sees=sees)
        found = explained(ar.UpdatingProblem(frame, ar.stiffness_reduction([1, 2, 3]), measured), np.zeros(3))
        assert found.enough
        assert found.n_roots == found.n_values == found.n_paired
