"""The exhaust: its geometry, its crack, and that its experiment comes from another structure."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

import antires_rs as ar
from antires_rs.cases import exhaust_truth as crack
from tests.support.campaign import campaign
from tests.support.refusals import assert_refused

LEVELS = (1, 2, 3)
#: Sizes of the issue that ordered the case.
LEAST_RISE, LEAST_DIFFERENCE_PERCENT, VALUES = 0.03, 25.0, (28, 40)


@pytest.fixture(scope="module")
def case():
    return ar.cases.exhaust()


@pytest.fixture(scope="module")
def tested():
    return crack.TestedStructure(0)


def test_the_frame_has_the_size_of_the_papers(case, tested):
    model = case.model
    assert (model.n_dof, len(model.nodes_m), len(model.elements)) == (144, 48, 47)
    np.testing.assert_allclose(np.ptp(model.nodes_m, axis=0), [2.3, 0.45])
    assert {tube.outer_diameter_m for tube in model.sections.values()} == {0.038}
    assert len(model.point_masses) == 5
    assert len(case.responses) == len(set(case.responses)) == 16
    assert sorted(case.held_out + case.fitted) == sorted(case.responses)
    assert len(case.held_out) == 4
    assert len(case.updating_parameters()) == 21
    assert (case.candidates[0], case.candidates[-1]) == (17, 46)
    for freq in (case.model.modes().freq_hz, tested.freq_hz):
        assert np.count_nonzero(freq < 5.0) == 3
        assert freq[3] > case.damage_band_hz[0]
    losses = [case.truth(level)["equivalent_loss"] for level in (0, *LEVELS)]
    assert losses[0] == 0.0
    assert np.all(np.diff(losses) >= LEAST_RISE)
    assert losses[-1] < 0.99  # within the bounds of a stiffness reduction


def test_factors_of_the_crack_agree_with_another_fit():
    # Paris & Tada, NUREG/CR-3464 (1983), for R/t = 10 and up to 100 of 180 degrees: 3 % apart at most.
    for share in (0.2, 0.3, 0.4, 0.5):
        other = 1.0 + 6.8 * share**1.5 - 13.6 * share**2.5 + 20.0 * share**3.5
        assert crack.bending_factor(share, 10.0) == pytest.approx(other, rel=0.035)


def test_compliance_is_the_energy_of_the_opening_crack():
    outer, wall, modulus, share = 0.038, 0.002, 2.1e11, 0.7
    radius = 0.5 * (outer - wall)

    def rate(theta):  # K^2 / E over two fronts, under a unit moment
        stress = crack.bending_factor(theta / np.pi, radius / wall) / (np.pi * radius**2 * wall)
        return 2 * wall * radius * stress**2 * np.pi * radius * theta / modulus

    pipe = {"outer_diameter_m": outer, "thickness_m": wall, "youngs_modulus_pa": modulus}
    found = crack.crack_compliance(share, **pipe)
    assert found == pytest.approx(2 * quad(rate, 0.0, share * np.pi)[0], rel=1e-9)
    assert crack.crack_compliance(0.0, **pipe) == 0.0


def motion(model, first, second, directions):
    """Of a node along ``directions`` (u, v, theta) under unit loads there, another held and the cords cut."""
    stiffness = np.array(model.stiffness().todense())
    for spring in model.ground_springs:
        dof = model.dof(spring.node, spring.direction)
        stiffness[dof, dof] -= spring.stiffness_n_per_m
    load = np.zeros(model.n_dof)
    for name, share in directions.items():
        load[model.dof(second, name)] = share
    # Nothing before the first: what lies behind hangs on it alone.
    held = {model.dof(first, name) for name in ("u", "v", "theta")}
    free = [d for d in range(model.n_dof) if d not in held]
    return load[free] @ np.linalg.solve(stiffness[np.ix_(free, free)], load[free])


@pytest.mark.parametrize("level", LEVELS)
def test_the_cracked_pipe_turns_by_the_compliance_more_and_stretches_as_before(level):
    along = np.diff(crack.true_nodes()[[30, 31]], axis=0)[0]
    along /= np.linalg.norm(along)
    cracked, intact = crack.true_model(level), crack.true_model(0)
    turned = motion(cracked, 30, 31, {"theta": 1.0}) - motion(intact, 30, 31, {"theta": 1.0})
    assert turned == pytest.approx(crack.compliance(level), rel=1e-6)
    pulled = {"u": along[0], "v": along[1]}
    assert motion(cracked, 30, 31, pulled) == pytest.approx(motion(intact, 30, 31, pulled), rel=1e-6)


def test_the_experiment_is_another_structure_than_the_model(case, tested):
    assert np.mean(np.abs(case.model.modes().freq_hz[3:9] / tested.freq_hz[3:9] - 1.0)) > 0.02
    problem = case.updating_problem()
    before = 100.0 * (problem.paired_hz(problem.nominal) / problem.measured_hz - 1.0)
    assert np.abs(before).max() >= LEAST_DIFFERENCE_PERCENT
    assert VALUES[0] <= problem.measured_hz.size <= VALUES[1]


def test_no_set_of_updating_parameters_is_the_truth(case):
    truth = case.truth()
    kinds = ("thickness", "youngs_modulus", "point_mass", "angle")
    true = np.array([value for kind in kinds for value in truth[kind].values()])
    problem = case.updating_problem()
    low, high = problem.bounds.T
    assert np.all((low < true) & (true < high))
    assert 0.05 < problem.cost(true) < 0.2 * problem.cost(problem.nominal)


def test_responses_are_those_of_the_matrices(case, tested):
    stiffness, mass = csc_array(tested.model.stiffness()), csc_array(tested.model.mass())
    bare = crack.TestedStructure(0)
    bare.damping_ratio = np.zeros_like(bare.damping_ratio)
    force = np.zeros(tested.model.n_dof)
    force[tested.excitation] = 1.0
    for freq in (10.0, 50.0, 200.0, 260.0):
        square = (2 * np.pi * freq) ** 2
        direct = -square * splu(stiffness - square * mass).solve(force)
        found = [bare.frf(dof, bare.excitation, [freq])[0] for dof in case.responses]
        np.testing.assert_allclose(np.real(found), direct[case.responses], rtol=1e-4)


@pytest.mark.parametrize("element", [17, 30, 46])
def test_the_search_problem_costs_only_its_penalties_at_the_truth(case, element):
    problem = case.search_problem(element, 0.75)
    x = np.zeros(30)
    x[element - 17] = 0.75
    assert problem.cost(x) == pytest.approx(0.1 * 0.75 + 0.1, abs=1e-8)


@campaign
def test_a_short_record_gives_the_ordered_number_of_antiresonances(case):
    record = case.experiment(duration_s=100.0, rng=100)
    zeros = ar.identify_antiresonances(record, excitation=case.excitation, band_hz=case.updating_band_hz)
    assert VALUES[0] <= case.updating_problem(zeros).measured_hz.size <= VALUES[1]


def test_held_out_accelerometers_and_other_bands_are_left_out(case):
    problem = case.updating_problem()
    assert not set(problem.measured_dofs) & set(case.held_out)
    low, high = case.updating_band_hz
    assert low <= problem.measured_hz.min() <= problem.measured_hz.max() <= high
    everything = case.updating_problem(held_out=[], band_hz=case.damage_band_hz)
    assert everything.measured_hz.size > problem.measured_hz.size
    spread = {dof: 0.01 * freq for dof, freq in case.exact().items()}
    known = ar.AntiresonanceSet(case.excitation, dict(case.exact().items()), std_hz=spread)
    kept = case.updating_problem(known).measured[0]
    np.testing.assert_allclose(kept.std_hz[case.fitted[3]], 0.01 * kept[case.fitted[3]])


def test_from_exact_values_the_update_and_the_crack_are_found(case):
    baseline = case.updating_problem(held_out=[], band_hz=case.damage_band_hz)
    update = ar.update(baseline, rng=100, progress=False)
    assert update.table.largest_after_percent < 2.0
    problem = case.damage_problem(level=1, model=update.model)
    severity = ar.assess_damage(update.model, problem.measured, elements=case.candidates, rng=100).severity
    assert max(severity, key=severity.get) == case.cracked_element
    assert severity[case.cracked_element] == pytest.approx(case.truth(1)["equivalent_loss"], abs=0.03)


# -- Errors of the model that no parameter follows: each is there, and the rest stays
@pytest.mark.parametrize(
    "options", [{"wall_scatter": 0.05}, {"joint_m": 0.03}, {"shear_coefficient": "cowper"}, {"cord_kg": 0.2}]
)
def test_each_error_moves_the_resonances_by_some_per_cent(options):
    both = (ar.cases.exhaust(**given).truth()["resonances_hz"] for given in (options, {}))
    changed, usual = (hz[crack.RIGID_MODES :] for hz in both)
    assert 0.3 < 100.0 * np.abs(changed / usual - 1.0).max() < 15.0


def test_errors_and_levels_out_of_range_are_refused(case):
    for name, value in (("wall_scatter", 0.2), ("joint_m", -0.01), ("cord_kg", np.nan)):
        assert_refused(name, ar.cases.exhaust, **{name: value})
    for level in (-1, 4, 1.5, True):
        for ask in (case.truth, case.exact, case.experiment):
            assert_refused("level", ask, level)
