"""Search on reduced models, against the full ones. Nothing was set on the structures and seeds used here."""

from __future__ import annotations

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.updating.reduced_model import Reduction, reduced_search
from reference.building_frames import building
from reference.meshes import frame, tower
from tests.support.campaign import some_of
from tests.support.refusals import refused

LIMIT_HZ = 14.0
FEW = ar.IslandGA(islands=1, population=6, max_generations=2)


@pytest.fixture(scope="module")
def concrete():
    """A small building, half of whose dofs have no mass; its sensors and force."""
    made = building((2, 1), 3)
    sensors = [made.dof[int(made.heads[s, c]), d] for s, c, d in ((0, 0, "u"), (1, 5, "v"), (2, 3, "u"))]
    sensors.append(made.dof[int(made.heads[2, 0]), "u"])
    model = ar.MatrixModel(made.stiffness, made.mass, stiffness_terms=made.terms)
    assert (made.mass.diagonal() == 0.0).sum() == model.n_dof // 2
    return model, sensors, sensors[-1]


def measured_of(model, sensors, force, limit_hz=LIMIT_HZ):
    zeros = model.antiresonances(sensors, force, f_max_hz=limit_hz)
    return ar.AntiresonanceSet(force, dict(zip(sensors, zeros, strict=True)))


def concrete_problem(concrete, seed, **options):
    model, sensors, force = concrete
    n = len(model.default_elements)
    factors = ar.stiffness_factor(range(n), bounds=(0.7, 1.3))
    truth = np.random.default_rng(seed).uniform(0.75, 1.25, n)
    measured = measured_of(model.with_parameters(factors, truth), sensors, force)
    return ar.UpdatingProblem(model, factors, measured, **options), truth


@pytest.mark.parametrize("seed", some_of([104, 105]))
def test_an_update_on_reduced_models_finds_what_the_full_model_does(concrete, seed):
    problem, truth = concrete_problem(concrete, seed)
    result = ar.update(problem, optimizer=FEW, rng=seed, reduction=True, progress=False)
    seen = np.isfinite(result.std)
    assert seen.any()
    assert np.abs(result.x - truth)[seen].max() < 1e-4
    assert result.reduction.agreed
    assert result.reduction.difference <= 1e-6
    assert result.fun == problem.cost(result.x)
    assert result.reduction.note in result.notes
    again = ar.update(problem, optimizer=FEW, rng=seed, workers=2, reduction=True, progress=False)
    assert again.x.tobytes() == result.x.tobytes()


def test_a_search_that_ends_before_both_models_agree_says_so(concrete):
    problem, _ = concrete_problem(concrete, 106)
    strict = ar.Reduction(rounds=1, tolerance=1e-16)
    result = ar.update(problem, optimizer=FEW, rng=0, reduction=strict, progress=False)
    assert not result.reduction.agreed
    assert result.reduction.difference > 1e-16
    assert any("still differ" in note for note in result.notes)
    assert result.fun <= problem.cost(problem.nominal)


def test_masses_and_reductions_of_a_frame_with_consistent_masses():
    mesh = frame(tower(400))
    parameters = [
        ar.stiffness_reduction(range(20), together=True),
        ar.stiffness_factor(range(20, 60), bounds=(0.6, 1.4), together=True),
        ar.mass_factor(range(30), bounds=(0.8, 1.25), together=True),
    ]
    truth = np.array([0.25, 0.85, 1.1])
    sensors = [mesh.dof(node, d) for node, d in ((20, "u"), (40, "v"), (53, "u"))]
    tested = mesh.with_parameters(parameters, truth)
    measured = measured_of(tested, sensors, sensors[-1], float(tested.modes(n_modes=9).freq_hz[-1]))
    problem = ar.UpdatingProblem(mesh, parameters, measured)
    result = ar.update(problem, optimizer=FEW, rng=1, reduction=True, progress=False)
    assert np.abs(result.x - truth).max() < 1e-4
    assert result.reduction.agreed


def test_what_cannot_be_reduced_is_told(concrete, tmp_path):
    problem, _ = concrete_problem(concrete, 108)
    refused("checkpoint", ar.update, problem, reduction=True, checkpoint=tmp_path / "kept")
    refused("reduction", ar.update, problem, reduction="always")
    with pytest.raises(ar.NumericalError, match=r"model of 5 vectors.*size="):
        ar.update(problem, optimizer=FEW, rng=0, reduction=ar.Reduction(size=5), progress=False)
    twice = [ar.stiffness_factor([0, 1], bounds=(0.9, 1.1), together=True), ar.stiffness_reduction(1)]
    shared = ar.UpdatingProblem(problem.model, twice, problem.measured)
    refused("two parameters scale term 1", ar.update, shared, reduction=True)
    # Small models are not reduced unasked.
    assert ar.update(problem, optimizer=FEW, rng=0, progress=False).reduction is None


def test_two_sensors_on_a_stiff_tie_are_one_sensor_more():
    n = 60
    stretch = np.eye(n) - np.eye(n, k=-1)  # of springs to the mass before, the first to ground
    term = 1e6 * stretch[:20].T @ stretch[:20]
    stiffness = 1e6 * stretch.T @ stretch
    stiffness[n - 2 :, n - 2 :] += 1e10 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    model = ar.MatrixModel(stiffness, np.eye(n), stiffness_terms=[term])
    factor = ar.stiffness_factor(0, bounds=(0.9, 1.1))
    measured = measured_of(model.with_parameters(factor, 1.05), [5, n - 2, n - 1], 5, 40.0)
    problem = ar.UpdatingProblem(model, factor, measured)
    result = ar.update(problem, optimizer=FEW, rng=0, reduction=True, progress=False)
    assert abs(result.x[0] - 1.05) < 1e-6
    assert result.reduction.agreed


def searched(problem, interrupted_at=None):
    options, asked = FEW.options, []

    def minimize(core, lower, upper, at, _):
        asked.append(at)
        if len(asked) == interrupted_at:
            raise KeyboardInterrupt
        begin = at.tolist()
        raw = core.minimize(lower.copy(), upper.copy(), [begin], options, 0, 1, None, None, None, begin)
        return ar.OptimizeResult._of(raw, options)

    return reduced_search(problem, Reduction(), minimize, problem.nominal, 0, lambda: np.inf)[0]


def test_a_time_limit_and_ctrl_c_between_searches_hand_back_the_best(concrete):
    problem, _ = concrete_problem(concrete, 31)
    # The time limit is that of all searches together.
    result = ar.update(problem, optimizer=ar.IslandGA(max_seconds=0.0), reduction=True, rng=0)
    assert (result.status, result.success, result.reduction.rounds) == ("budget", False, 1)
    assert "time limit" in result.message
    assert result.fun <= problem.cost(problem.nominal)
    found = searched(problem, interrupted_at=2)
    assert (found.status, found.success) == ("interrupted", False)
    assert found.fun == problem.cost(found.x)
    with pytest.raises(KeyboardInterrupt):
        searched(problem, interrupted_at=1)
