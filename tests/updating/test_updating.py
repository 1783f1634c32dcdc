"""Searches and what their results tell, by antiresonances and by modes; where damage can be seen.

The full studies are ``benchmarks/chain8_study.py`` and ``benchmarks/both_objectives.py``."""

import dataclasses
import os
import re
import signal
import threading

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import assert_refused, refused
from tests.support.tolerances import COST, DETECTABLE_PERCENT, EXACT_SEVERITY, UPDATED_PERCENT
from tests.updating.test_objective import disturbed

CASE = ar.cases.chain8()
DAMAGED, SEVERITY = 4, 0.55


@pytest.fixture(scope="module")
def updated():
    case = ar.cases.chain8(perturbation=0.08, rng=5)
    return case, ar.update(case.updating_problem(), rng=1, optimizer=ar.IslandGA(max_evaluations=30_000))


@pytest.fixture(scope="module")
def damage():
    return ar.assess_damage(CASE.model, CASE.exact(1), rng=1)


@pytest.fixture(scope="module")
def modal_damage():
    measured = disturbed(CASE.exact_modes(1), list(range(8)), 0.01, np.random.default_rng(3))
    return ar.assess_damage(CASE.model, measured, rng=1)


# ---- tables and notes --------------------------------------------------------------------------------
def test_the_table_says_what_was_measured_before_and_after(updated, modal_damage):
    case, result = updated
    table, modal = result.table, modal_damage.table
    assert isinstance(modal, ar.ModalTable)
    np.testing.assert_array_equal(modal.before_mac, modal_damage.problem.paired_mac(np.zeros(7)))
    assert modal.before_mac.min() < 0.8 < 0.99 < modal.after_mac.min()
    assert f"{modal.after_mac[3]:.3f}" in str(modal)
    np.testing.assert_array_equal(table.measured_hz, np.concatenate(list(case.truth()["freq_hz"].values())))
    np.testing.assert_array_equal(table.after_hz, result.problem.paired_hz(result.x))
    np.testing.assert_allclose(table.after_percent, 100 * (table.after_hz / table.measured_hz - 1.0))
    assert len(str(table).splitlines()) == 2 + 28 + 1
    assert f"{table.largest_after_percent:.2f} % after" in str(table)
    assert table.largest_before_percent > 2.0 > UPDATED_PERCENT > table.largest_after_percent
    assert result.fun == result.problem.cost(result.x)
    zeros = np.concatenate(result.model.antiresonances(range(8), 0))
    np.testing.assert_allclose(zeros, table.after_hz, rtol=COST)


def test_what_antiresonances_cannot_tell_is_said(updated):
    case, result = updated
    found = result.identifiability
    assert found.rank == 13
    assert found.unseen.shape == (2, 15)
    blind = [name for name, size in zip(found.names, found.sensitivity, strict=True) if size < 1e-6]
    assert blind == ["mass 0"]
    notes = " ".join(result.notes)
    for words in ("Not seen by any measured antiresonance: mass 0.", "13 of 15", "ratios"):
        assert words in notes
    assert "note:" in result.summary()
    assert result.summary().count("not determined") == 1  # the others but for a common scale
    of_ratios = found.std_of_ratios[1:]
    assert np.isinf(found.std).all()
    assert ((of_ratios > 0.0) & (of_ratios < 0.05)).all()
    # Ratios to the last spring are free of the common scale.
    truth = np.concatenate([case.truth()["mass_factor"], case.truth()["stiffness_factor"]])
    ratios, within = result.x[1:] / result.x[-1], 20 * UPDATED_PERCENT / 100
    np.testing.assert_allclose(ratios, truth[1:] / truth[-1], rtol=within)


def test_what_modes_cannot_tell_is_said():
    case = ar.cases.chain8(perturbation=0.05, rng=3)
    problem = case.updating_problem(case.exact_modes(0))
    result = ar.update(problem, rng=0, optimizer=ar.IslandGA(max_evaluations=20_000))
    assert result.table.largest_after_percent < 0.1
    assert (result.identifiability.rank, result.identifiability.scale_unseen) == (14, True)
    notes = " ".join(result.notes)
    assert "a common scale moves no mode" in notes
    assert "antiresonance" not in notes
    truth = np.concatenate([case.truth()["mass_factor"], case.truth()["stiffness_factor"]])
    np.testing.assert_allclose(result.x / result.x[-1], truth / truth[-1], atol=0.02)


def test_of_two_unknown_combinations_the_scale_is_one():
    chain = ar.MassSpringChain([1.0] * 4, [500.0] * 3, ground_first_n_per_m=500.0)
    measured = ar.AntiresonanceSet(3, dict(enumerate(chain.antiresonances(range(4), 3))))
    every = ar.stiffness_factor(range(4), bounds=(0.9, 1.1)) + ar.mass_factor(range(3), bounds=(0.9, 1.1))
    result = ar.update(ar.UpdatingProblem(chain, every, measured), rng=0)
    assert result.identifiability.rank == 5
    assert result.notes == [
        "2 combinations of all parameters that are seen cannot be told: no measured antiresonance moves with "
        "them, a common scale among them (5 of 7 combinations are)."
    ]
    assert result.summary().count("not determined") == 7
    assert np.isinf(result.std).all()
    assert np.isnan(ar.assess_damage(chain, measured, rng=0).std).all()  # no damage: decided


def test_standard_deviations_are_those_of_repeated_measurements():
    masses, springs, truth = np.ones(6), np.full(5, 500.0), np.array([1.05, 0.97, 1.02, 0.94, 1.01])
    model = ar.MassSpringChain(masses, springs, ground_first_n_per_m=300.0)
    parameters = ar.stiffness_factor(range(5), bounds=(0.8, 1.2))
    tested = ar.MassSpringChain(masses, springs * truth, ground_first_n_per_m=300.0)
    exact = {dof: f for dof, f in enumerate(tested.antiresonances(range(6), 0)) if f.size}
    rng, scores = np.random.default_rng(7), []
    for _ in range(24):
        noisy = {dof: freq * (1 + 3e-3 * rng.standard_normal(freq.size)) for dof, freq in exact.items()}
        problem = ar.UpdatingProblem(model, parameters, ar.AntiresonanceSet(0, noisy), misfit="squared")
        result = ar.update(problem, rng=0)
        assert not result.identifiability.weak.any()
        scores.append((result.x - truth) / result.std)
    np.testing.assert_allclose(np.std(scores, axis=0), 1.0, atol=0.4)
    assert re.search(r"1\.0\d+ \u00b1 0\.0\d+ ", result.summary())


def ended_at(result, x):
    return ar.UpdateResult(result.problem, dataclasses.replace(result.search, x=np.array(x)), result.seed)


def test_a_parameter_on_its_bound_is_named():
    short = ar.IslandGA(max_evaluations=200)
    problem = ar.UpdatingProblem(CASE.model, ar.stiffness_factor(range(4), bounds=(0.9, 1.1)), CASE.exact())
    result = ar.update(problem, rng=0, optimizer=short)  # What a polish leaves a hair off is on it.
    result = ended_at(result, [0.9 + 3e-13, 1.1 - 2e-14, 0.9 + 1e-5, 1.0])
    assert result.at_bound == problem.names[:2]
    assert "On a bound" in " ".join(result.notes)
    # Where it began is not where the data pushed it.
    reduction = ar.UpdatingProblem(CASE.model, ar.stiffness_reduction([0]), CASE.exact())
    assert ended_at(ar.update(reduction, rng=0, optimizer=short), [1e-9]).at_bound == []


# ---- damage ------------------------------------------------------------------------------------------
def test_damage_is_found_where_it_is_and_nowhere_else(damage):
    assert damage.damaged == [DAMAGED]
    assert damage.severity == pytest.approx({**dict.fromkeys(range(7), 0.0), 4: SEVERITY}, abs=EXACT_SEVERITY)
    assert np.count_nonzero(damage.x) == 1
    assert damage.fun == pytest.approx(0.155, abs=2 * EXACT_SEVERITY)
    assert damage.success
    chosen = ar.assess_damage(CASE.model, CASE.exact(1), elements=[4, 2], rng=0)
    assert list(chosen.severity) == [4, 2]
    assert chosen.damaged == [4]


@pytest.mark.parametrize(("dofs", "error", "seed"), [(range(8), 0.0, 0), ([2, 5], 0.01, 2)])
def test_damage_is_found_from_modes(dofs, error, seed):
    measured = disturbed(CASE.exact_modes(1), list(dofs), error, np.random.default_rng(seed))
    result = ar.assess_damage(CASE.model, measured, rng=seed)
    assert result.success
    assert result.damaged == [DAMAGED]
    assert result.severity[DAMAGED] == pytest.approx(SEVERITY, abs=0.01 if error else EXACT_SEVERITY)


def test_no_damage_comes_out_as_none_and_damage_where_no_candidate_is_with_a_doubt():
    record = CASE.experiment(noise=0.01, rng=2)
    zeros = ar.identify_antiresonances(record, excitation=CASE.excitation, band_hz=CASE.band_hz)
    np.testing.assert_array_equal(ar.assess_damage(CASE.model, zeros, rng=2).x, np.zeros(7))
    # Nor does what the penalties outweigh come out.
    np.testing.assert_array_equal(ar.update(CASE.search_problem(0, 0.06), rng=0).x, np.zeros(7))
    # A shear frame that has lost 30 % of its lowest storey, the spring to ground.

    def frame(lowest):
        springs = [52.5e3, 52.5e3, 50e3, 50e3, 48e3]
        return ar.MassSpringChain([5.2] * 5 + [4.4], springs, ground_first_n_per_m=lowest)

    zeros = ar.AntiresonanceSet(5, dict(enumerate(frame(0.7 * 55e3).antiresonances(range(6), 5))))
    blamed = ar.assess_damage(frame(55e3), zeros, rng=0)
    assert any(note.startswith("No candidates: first ground spring.") for note in blamed.notes)
    assert any(note.startswith("Hardly explained: the largest difference is ") for note in blamed.notes)
    found = ar.assess_damage(frame(55e3), zeros, elements=range(6), rng=0)
    assert found.damaged == [5]
    assert not any(note.startswith(("No candidates", "Hardly explained")) for note in found.notes)


def test_the_smallest_visible_damage_is_about_what_theory_says(damage):
    """gamma1 = gamma2 = 0.1 on exact data: spring 0 from about 10 %, spring 1 from about 5 %."""
    assert 100 * damage.detectable[0] == pytest.approx(10.0, abs=DETECTABLE_PERCENT)
    assert 100 * damage.detectable[1] == pytest.approx(5.0, abs=DETECTABLE_PERCENT)
    # The definition, at its edge, for the dofs and the band that were measured.
    top = damage.problem.measured_hz.max()
    for element, beta in damage.detectable.items():
        for side, seen in ((1.1, True), (0.9, False)):
            x = side * beta * np.eye(7)[element]
            zeros = damage.problem.model_at(x).antiresonances(range(8), 0, f_max_hz=top)
            problem = CASE.damage_problem(ar.AntiresonanceSet(0, dict(enumerate(zeros))))
            assert (problem.cost(x) < problem.cost(np.zeros(7))) == seen
    assert any(note.startswith("Smallest damage that would be seen: ") for note in damage.notes)


def test_every_spring_of_a_free_chain_is_seen_alike_by_modes(modal_damage):
    """A chain is statically determinate: phi' K_i phi / lambda, summed over modes, is trace(K+ K_i) = 1 for
    every spring i. To first order a loss beta costs beta whichever spring it is, against 0.05 beta + 0.05."""
    visible = np.array(list(modal_damage.detectable.values()))
    np.testing.assert_allclose(visible, 1 / 19, rtol=0.1)
    assert np.ptp(visible) < 2e-3


# ---- the search --------------------------------------------------------------------------------------
def springs_off():
    case = ar.cases.chain8(perturbation=0.08, rng=2)
    springs = ar.stiffness_factor([0, 1], bounds=(0.9, 1.1))
    return ar.UpdatingProblem(case.model, springs, case.exact(), weights=np.linspace(0.5, 1.0, 28))


def test_linearizations_exchanges_and_a_search_cut_short_are_told():
    problem = springs_off()
    result = ar.update(problem, rng=0)
    assert 0 < result.njev < result.nfev
    assert f"{result.nfev:,} evaluations ({result.njev:,} of them linearizations)" in result.summary()
    assert f"{result.migrations} exchanges" in result.summary()
    assert (result.status, result.migrations) == ("agreed", 0)
    assert "exchanged nothing yet" in result.message
    alone = ar.update(problem, rng=0, optimizer=ar.IslandGA.paper(max_evaluations=2000))
    assert (alone.njev, alone.search.options["polish"]) == (0, False)
    assert "linearizations)" not in alone.summary()
    for most in (162, 165, 170):
        result = ar.update(springs_off(), rng=0, optimizer=ar.IslandGA(max_evaluations=most))
        assert result.nfev <= most
        assert result.njev > 0
        assert not result.success
        assert result.notes[0].startswith("The search did not finish")
        assert "budget" in repr(result)


def test_three_damages_are_found_that_moves_from_the_intact_state_miss():
    """Pursuit from the intact exhaust ends at two elements and J = 0.885, the truth has 0.857."""
    case = ar.cases.exhaust()
    losses = np.zeros(30)
    losses[[4, 5, 7]] = 0.62, 0.47, 0.71
    parameters = ar.stiffness_reduction(case.candidates)
    tested = case.model.with_parameters(parameters, losses)
    low, high = case.damage_band_hz
    found = tested.antiresonances(case.responses, case.excitation, f_max_hz=high)
    zeros = {dof: f[f >= low] for dof, f in zip(case.responses, found, strict=True)}
    measured = ar.AntiresonanceSet(case.excitation, zeros)
    problem = ar.UpdatingProblem(case.model, parameters, measured, penalty="scaled")
    result = ar.update(problem, rng=0, optimizer=ar.IslandGA(max_generations=1))
    assert result.fun <= problem.cost(losses) + 1e-6
    assert result.nfev < 4000
    np.testing.assert_allclose(result.x, losses, atol=EXACT_SEVERITY)


def test_problems_and_results_are_read_only():
    problem = springs_off()
    result = ar.update(problem, rng=0, optimizer=ar.IslandGA(max_evaluations=300))
    damage = ar.assess_damage(CASE.model, CASE.exact(), rng=0, optimizer=ar.IslandGA(max_evaluations=300))
    values = [problem, result, result.search, result.history, result.table, result.identifiability, damage]
    for value in values:
        arrays = [each for each in vars(value).values() if isinstance(each, np.ndarray)]
        assert arrays
        for array in arrays:
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0
        for name in (*vars(value), "remark"):
            with pytest.raises(AttributeError):
                setattr(value, name, None)
    with pytest.raises(TypeError, match="read-only"):
        result.search.options["islands"] = 1
    problem.names.clear()  # What is made anew at each call may be changed, and changes nothing.
    damage.severity.clear()
    damage.detectable.clear()
    problem.nominal[:] = 7.0
    assert problem.names == ["stiffness of spring 0", "stiffness of spring 1"]
    assert len(damage.severity) == len(damage.detectable) == 7
    assert problem.nominal.tolist() == [1.0, 1.0]


# ---- Many updatings by any workers: the bits of single ones, in order, and what fails is told
SHORT = ar.IslandGA(max_evaluations=400)


def problem(stiffness=550.0, measured=None):
    true = ar.MassSpringChain([2.0, 1.0, 1.5], [stiffness, 480.0], ground_first_n_per_m=300.0)
    nominal = ar.MassSpringChain([2.0, 1.0, 1.5], [500.0, 500.0], ground_first_n_per_m=300.0)
    values = dict(enumerate(true.antiresonances([0, 1, 2], 0))) if measured is None else measured
    springs = ar.stiffness_factor([0, 1], bounds=(0.7, 1.3))
    return ar.UpdatingProblem(nominal, springs, ar.AntiresonanceSet(0, values))


def bits(found):
    return found.x.tobytes(), found.fun.tobytes(), found.seeds


@pytest.mark.parametrize("workers", ["threads", 2])
def test_the_bits_do_not_depend_on_the_workers(workers):
    several = [problem(k) for k in (520.0, 550.0, 580.0)]
    alone = ar.update_ensemble(iter(several), optimizer=SHORT, rng=3)
    assert bits(ar.update_ensemble(several, optimizer=SHORT, rng=3, workers=workers)) == bits(alone)
    one = [ar.update_ensemble(problem(), count=3, optimizer=SHORT, rng=0, workers=w) for w in (None, workers)]
    assert bits(one[0]) == bits(one[1])
    assert one[0].x.shape == (3, 2)
    assert "3 updatings, 3 with a result" in str(one[0])
    assert alone.failed == {}
    assert not alone.interrupted


def test_each_is_what_update_gives_with_its_seed():
    several = [problem(k) for k in (520.0, 580.0)]
    found = ar.update_ensemble(several, optimizer=SHORT, rng=7)
    for k, one in enumerate(found):
        again = ar.update(several[k], optimizer=SHORT, rng=found.seeds[k], workers=1)
        assert one.x.tobytes() == again.x.tobytes()
        assert one.problem is several[k]
    assert len(set(found.seeds)) == len(found) == 2
    fewer = ar.UpdatingProblem(problem().model, several[0].parameters[:1], problem().measured)
    with pytest.raises(ar.InvalidInputError, match="problems of 1, 2 parameters"):
        _ = ar.update_ensemble([several[0], fewer], optimizer=SHORT, rng=0).x
    np.testing.assert_allclose(found.x[:, 0], [1.04, 1.16], atol=0.01)


def test_what_fails_is_told_and_the_others_stand(monkeypatch):
    from antires_rs.updating import update as room

    real = room.update

    def brittle(given, **options):
        if given is several[1]:
            raise ar.NumericalError("the modes", "this one only")
        return real(given, **options)

    several = [problem(k) for k in (520.0, 550.0, 580.0)]
    monkeypatch.setattr(room, "update", brittle)
    found = ar.update_ensemble(several, optimizer=SHORT, rng=0)
    assert found.failed == {1: "NumericalError: the modes failed: this one only"}
    assert found[1] is None
    assert np.isnan(found.x[1]).all()
    assert np.isfinite(found.x[[0, 2]]).all()
    assert "updating 1 failed" in str(found)


def test_ctrl_c_keeps_what_is_there():
    def stopped():
        yield problem(520.0)
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
        for _ in range(10_000):
            yield problem(550.0)

    found = ar.update_ensemble(stopped(), optimizer=SHORT, rng=0)
    assert found.interrupted
    assert 1 <= len(found) < 10_000
    assert found.x[0, 0] == pytest.approx(1.04, abs=0.01)


@pytest.mark.parametrize(
    ("argument", "given", "count"),
    [("count", problem(), None), ("count", [problem()], 3), ("count", problem(), 0)]
    + [("problems[1]", [problem(), "no problem"], None), ("problems", 5, None)],
)
def test_wrong_arguments_are_refused(argument, given, count):
    assert_refused(argument, ar.update_ensemble, given, optimizer=SHORT, rng=0, count=count)


def test_modes_are_paired_by_number_and_a_saved_set_is_the_same(tmp_path):
    case = ar.cases.chain8(perturbation=0.05, rng=3)
    modes = case.exact_modes()
    some = modes.freq_hz[[0, 2]], 1j * modes.shapes[[0, 2]], modes.dofs, [0.01, 0.02]
    given = ar.ModalSet(*some, std_hz=[0.1, 0.0])
    result = ar.update(case.updating_problem(), rng=0, optimizer=ar.IslandGA(max_evaluations=2000))
    table = result.modes_beside(given)
    assert table.before_mode.tolist() == table.after_mode.tolist() == [1, 3]  # 0 is the rigid body
    assert [line.split()[2] for line in str(table).splitlines()[2:4]] == ["1", "3"]
    assert table.after_mac.min() > 0.999
    given.save(tmp_path / "modes.json")
    read = ar.ModalSet.load(tmp_path / "modes.json")
    for name in ("freq_hz", "shapes", "damping_ratio", "std_hz"):
        assert getattr(read, name).tobytes() == getattr(given, name).tobytes()
    (tmp_path / "modes.json").write_text((tmp_path / "modes.json").read_text().replace("freq_hz", "hz"))
    refused("damaged", ar.ModalSet.load, tmp_path / "modes.json")
