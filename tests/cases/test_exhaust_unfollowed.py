"""Errors of the exhaust's model that no parameter follows: each is there, and the rest stays."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.cases import exhaust_geometry as geometry, exhaust_truth as experiment
from antires_rs.cases.exhaust_truth import EXTRA_CORDS, Unfollowed
from tests.support.tolerances import EIGH

USUAL = experiment.true_model(0)


def test_without_options_the_case_is_what_it_was():
    case = ar.cases.exhaust()
    assert case.unfollowed == Unfollowed() == case.truth()["unfollowed"]
    same = ar.cases.exhaust(wall_scatter=0.005)
    for dof, freq in case.exact(1).items():
        np.testing.assert_array_equal(same.exact(1)[dof], freq)


@pytest.mark.parametrize(
    "options", [{"wall_scatter": 0.05}, {"joint_m": 0.03}, {"shear_coefficient": "cowper"}, {"cord_kg": 0.2}]
)
def test_each_error_moves_the_resonances_by_some_per_cent(options):
    changed, usual = (
        ar.cases.exhaust(**given).truth()["resonances_hz"][experiment.RIGID_MODES :]
        for given in (options, {})
    )
    assert 0.3 < 100.0 * np.abs(changed / usual - 1.0).max() < 15.0


def test_the_wall_scatters_as_said_and_the_crack_follows_it():
    nominal = np.array([geometry.SECTIONS[s][0] * experiment.THICKNESS[s] for _, _, s in geometry.beams()])
    for scatter in (0.02, 0.05):
        errors = Unfollowed(wall_scatter=scatter)
        assert np.std(experiment.walls_m(errors) / nominal) == pytest.approx(scatter, rel=0.2)
        wall = experiment.walls_m(errors)[experiment.CRACKED_ELEMENT]
        assert experiment.compliance(1, errors) != experiment.compliance(1)
        assert wall != experiment.walls_m()[experiment.CRACKED_ELEMENT]
    even = experiment.walls_m(Unfollowed(wall_scatter=0.0))
    np.testing.assert_allclose(even, nominal)


def test_a_joint_turns_as_so_much_more_pipe_would():
    """Element 17 ends at the front muffler: its end's rotation under a moment, with its first node held."""

    def turned(model):
        stiffness = model.stiffness().toarray()
        for spring in model.ground_springs:
            dof = model.dof(spring.node, spring.direction)
            stiffness[dof, dof] -= spring.stiffness_n_per_m
        first, second = geometry.beams()[17][:2]
        held = {model.dof(first, name) for name in ("u", "v", "theta")}
        free = [d for d in range(model.n_dof) if d not in held]
        load = np.zeros(model.n_dof)
        load[model.dof(second, "theta")] = 1.0
        moved = np.zeros(model.n_dof)
        moved[free] = np.linalg.solve(stiffness[np.ix_(free, free)], load[free])
        return moved[model.dof(second, "theta")]

    tube = USUAL.sections[USUAL.element_sections[4 * 17]]
    assert geometry.beams()[17][1] == 18
    bending = tube.youngs_modulus_pa * experiment._inertia(tube.thickness_m)
    soft = experiment.true_model(0, Unfollowed(joint_m=0.03))
    assert turned(soft) - turned(USUAL) == pytest.approx(0.03 / bending, rel=1e-6)


def test_cords_hang_where_the_model_has_none():
    corded = experiment.true_model(0, Unfollowed(cord_kg=0.2))
    unit = np.zeros(corded.n_dof)
    unit[1::3] = 1.0
    more = unit @ (corded.mass() @ unit) - unit @ (USUAL.mass() @ unit)
    assert more == pytest.approx(3 * 0.2, rel=EIGH)
    known = {spring.node for spring in USUAL.ground_springs}
    assert {spring.node for spring in corded.ground_springs} - known == set(EXTRA_CORDS)


@pytest.mark.parametrize(("name", "value"), [("wall_scatter", 0.2), ("joint_m", -0.01), ("cord_kg", np.nan)])
def test_errors_out_of_range_are_refused(name, value):
    with pytest.raises(ar.InvalidInputError, match=name):
        ar.cases.exhaust(**{name: value})
