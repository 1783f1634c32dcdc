"""Wrong calls: an error of ours that is also a ValueError and names argument, got and wanted (row 10)."""

import re
import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse

import antires_rs as ar
from antires_rs import exceptions

NAN, INF = float("nan"), float("inf")
CASE = ar.cases.chain8()
MODEL = CASE.model
RECORD = ar.Recording(np.random.default_rng(0).standard_normal((2, 4000)), 100.0)
SET = ar.AntiresonanceSet(0, {0: [12.0, 36.0]})
FACTORS = ar.stiffness_factor(range(7), bounds=(0.9, 1.1))
PROBLEM = ar.UpdatingProblem(MODEL, FACTORS, SET)
EYE = np.eye(2)
SIMULATE = {"excitation": 0, "fs_hz": 64.0, "duration_s": 4.0, "damping_ratio": 0.01, "rng": 0}
BOX = [(0.0, 1.0)] * 2


def sphere(x):
    return float(np.sum(x**2))


def minimize(bounds=BOX, fun=sphere, **options):
    return lambda: ar.IslandGA(max_evaluations=10).minimize(fun, bounds, **options)


def simulate(**options):
    return lambda: MODEL.simulate(**(SIMULATE | options))


def option(**options):
    return lambda: ar.IslandGA(**options)


#: What is wrong: (argument that the message must name first, the call).
WRONG = {
    "no mass": ("masses_kg", lambda: ar.MassSpringChain([], [])),
    "NaN mass": ("masses_kg", lambda: ar.MassSpringChain([1.0, NAN], [1.0])),
    "negative mass": ("masses_kg", lambda: ar.MassSpringChain([1.0, -2.0], [1.0])),
    "zero mass": ("masses_kg", lambda: ar.MassSpringChain([1.0, 0.0], [1.0])),
    "complex mass": ("masses_kg", lambda: ar.MassSpringChain([1.0, 1j], [1.0])),
    "masses as text": ("masses_kg", lambda: ar.MassSpringChain(["a", "b"], [1.0])),
    "masses 2-D": ("masses_kg", lambda: ar.MassSpringChain([[1.0, 2.0]], [1.0])),
    "too many springs": ("springs_n_per_m", lambda: ar.MassSpringChain([1.0, 2.0], [1.0, 2.0])),
    "infinite spring": ("springs_n_per_m", lambda: ar.MassSpringChain([1.0, 2.0], [INF])),
    "negative spring": ("springs_n_per_m", lambda: ar.MassSpringChain([1.0, 2.0], [-1.0])),
    "negative ground": (
        "ground_first_n_per_m",
        lambda: ar.MassSpringChain([1.0], [], ground_first_n_per_m=-1.0),
    ),
    "NaN ground": ("ground_last_n_per_m", lambda: ar.MassSpringChain([1.0], [], ground_last_n_per_m=NAN)),
    "K not square": ("stiffness", lambda: ar.MatrixModel(np.ones((2, 3)), EYE)),
    "K empty": ("stiffness", lambda: ar.MatrixModel(np.ones((0, 0)), EYE)),
    "K 1-D": ("stiffness", lambda: ar.MatrixModel(np.ones(4), EYE)),
    "K with NaN": ("stiffness", lambda: ar.MatrixModel(NAN * EYE, EYE)),
    "K sparse with NaN": ("stiffness", lambda: ar.MatrixModel(scipy.sparse.csc_array(NAN * EYE), EYE)),
    "K not symmetric": ("stiffness", lambda: ar.MatrixModel([[1.0, 2.0], [0.0, 1.0]], EYE)),
    "M of another size": ("mass", lambda: ar.MatrixModel(EYE, np.eye(3))),
    "M negative": ("mass", lambda: ar.MatrixModel(EYE, -EYE)),
    "term of another size": (
        "stiffness_terms[1]",
        lambda: ar.MatrixModel(EYE, EYE, stiffness_terms=[EYE, np.eye(3)]),
    ),
    "term not symmetric": (
        "mass_terms[0]",
        lambda: ar.MatrixModel(EYE, EYE, mass_terms=[[[0.0, 1.0], [0.0, 0.0]]]),
    ),
    "no modes": ("n_modes", lambda: MODEL.modes(n_modes=0)),
    "modes to NaN": ("f_max_hz", lambda: MODEL.modes(f_max_hz=NAN)),
    "excitation out of range": ("excitation", lambda: MODEL.antiresonances(0, 8)),
    "excitation negative": ("excitation", lambda: MODEL.antiresonances(0, -1)),
    "excitation a fraction": ("excitation", lambda: MODEL.antiresonances(0, 0.5)),
    "response out of range": ("response", lambda: MODEL.antiresonances(8, 0)),
    "one response out of range": ("response[1]", lambda: MODEL.antiresonances([0, 9], 0)),
    "no response": ("response", lambda: MODEL.antiresonances([], 0)),
    "response as text": ("response", lambda: MODEL.antiresonances("0", 0)),
    "response beyond any integer": ("response", lambda: MODEL.antiresonances(2**70, 0)),
    "unknown method": ("method", lambda: MODEL.antiresonances(0, 0, method="qz")),
    "no band": ("f_max_hz", lambda: MODEL.antiresonances(0, 0, f_max_hz=0.0)),
    "frf at NaN": ("freq_hz", lambda: MODEL.frf(0, 0, [NAN], damping_ratio=0.01)),
    "frf at a negative frequency": ("freq_hz", lambda: MODEL.frf(0, 0, [-1.0], damping_ratio=0.01)),
    "frf nowhere": ("freq_hz", lambda: MODEL.frf(0, 0, [], damping_ratio=0.01)),
    "frf of an unknown kind": ("kind", lambda: MODEL.frf(0, 0, [1.0], damping_ratio=0.01, kind="fast")),
    "frf damping for other modes": ("damping_ratio", lambda: MODEL.frf(0, 0, [1.0], damping_ratio=[0.1] * 3)),
    "frf negative damping": ("damping_ratio", lambda: MODEL.frf(0, 0, [1.0], damping_ratio=-0.01)),
    "simulate at no rate": ("fs_hz", simulate(fs_hz=0.0)),
    "simulate no time": ("duration_s", simulate(duration_s=-1.0)),
    "simulate one sample": ("duration_s", simulate(duration_s=1e-3)),
    "simulate forever": ("duration_s", simulate(duration_s=1e300, fs_hz=1e300)),
    "simulate negative noise": ("noise", simulate(noise=-0.1)),
    "simulate above the band": ("band_hz", simulate(band_hz=(1.0, 40.0))),
    "simulate a reversed band": ("band_hz", simulate(band_hz=(20.0, 10.0))),
    "simulate an empty band": ("band_hz", simulate(band_hz=(1.01, 1.0101))),
    "simulate half a band": ("band_hz", simulate(band_hz=(1.0,))),
    "simulate NaN damping": ("damping_ratio", simulate(damping_ratio=NAN)),
    "simulate no responses": ("responses", simulate(responses=[])),
    "simulate seeded by a word": ("rng", simulate(rng="seed")),
    "simulate seeded below zero": ("rng", simulate(rng=-1)),
    "lower above upper": ("bounds", lambda: ar.mass_factor(0, bounds=(1.1, 0.9))),
    "factor of zero": ("bounds[0]", lambda: ar.mass_factor(0, bounds=(0.0, 0.9))),
    "reduction above one": ("bounds[1]", lambda: ar.stiffness_reduction(0, bounds=(0.0, 1.5))),
    "bound NaN": ("bounds[1]", lambda: ar.stiffness_factor(0, bounds=(0.9, NAN))),
    "three bounds": ("bounds", lambda: ar.stiffness_factor(0, bounds=(0.9, 1.0, 1.1))),
    "responses ragged": ("response[0]", lambda: MODEL.antiresonances([[0], [1, 2]], 0)),
    "bounds ragged": ("bounds[0]", lambda: ar.mass_factor(0, bounds=((1.0,), (1.0, 2.0)))),
    "elements ragged": ("elements[0]", lambda: ar.stiffness_reduction([[0], [1, 2]])),
    "case seeded by a word": ("rng", lambda: ar.cases.chain8(perturbation=0.1, rng="seed")),
    "no elements": ("elements", lambda: ar.stiffness_reduction([])),
    "negative element": ("elements", lambda: ar.stiffness_reduction(-1)),
    "element twice": ("elements", lambda: ar.stiffness_reduction([1, 1])),
    "not a model": ("model", lambda: ar.UpdatingProblem(EYE, FACTORS, SET)),
    "not a set": ("measured", lambda: ar.UpdatingProblem(MODEL, FACTORS, {0: [1.0]})),
    "no parameters": ("parameters", lambda: ar.UpdatingProblem(MODEL, [], SET)),
    "nested parameters": ("parameters[0]", lambda: ar.UpdatingProblem(MODEL, [FACTORS], SET)),
    "parameters of the wrong sort": ("parameters", lambda: ar.UpdatingProblem(MODEL, 3, SET)),
    "parameter twice": ("parameters", lambda: ar.UpdatingProblem(MODEL, [*FACTORS, FACTORS[0]], SET)),
    "element outside": ("parameters[0]", lambda: ar.UpdatingProblem(MODEL, ar.stiffness_reduction(9), SET)),
    "parameter without effect": (
        "parameters[0]",
        lambda: ar.UpdatingProblem(MODEL, ar.stiffness_reduction(7), SET),
    ),
    "measured dof outside": (
        "measured dof",
        lambda: ar.UpdatingProblem(MODEL, FACTORS, ar.AntiresonanceSet(0, {8: [1.0]})),
    ),
    "measured dof named": (
        "measured dof",
        lambda: ar.UpdatingProblem(MODEL, FACTORS, ar.AntiresonanceSet(0, {"a": [1.0]})),
    ),
    "force outside": (
        "excitation",
        lambda: ar.UpdatingProblem(MODEL, FACTORS, ar.AntiresonanceSet(9, {0: [1.0]})),
    ),
    "nothing measured": (
        "measured",
        lambda: ar.UpdatingProblem(MODEL, FACTORS, ar.AntiresonanceSet(0, {0: []})),
    ),
    "unknown misfit": ("misfit", lambda: ar.UpdatingProblem(MODEL, FACTORS, SET, misfit="median")),
    "negative penalty": ("gamma1", lambda: ar.DamagePenalty(-0.1)),
    "NaN penalty": ("gamma2", lambda: ar.UpdatingProblem(MODEL, FACTORS, SET, penalty=(0.1, NAN))),
    "snap too large": ("snap", lambda: ar.DamagePenalty(snap=0.1)),
    "penalty of the wrong sort": ("penalty", lambda: ar.UpdatingProblem(MODEL, FACTORS, SET, penalty=0.1)),
    "x too short": ("x", lambda: PROBLEM.cost([1.0])),
    "x with NaN": ("x", lambda: PROBLEM.cost([NAN] * 7)),
    "candidates 1-D": ("candidates", lambda: PROBLEM.evaluate_many([1.0] * 7)),
    "candidates too narrow": ("candidates", lambda: PROBLEM.evaluate_many(np.ones((3, 6)))),
    "candidates none": ("candidates", lambda: PROBLEM.evaluate_many(np.ones((0, 7)))),
    "no workers": ("workers", lambda: PROBLEM.evaluate_many(np.ones((1, 7)), workers=0)),
    "update of nothing": ("problem", lambda: ar.update(MODEL)),
    "update by another optimizer": ("optimizer", lambda: ar.update(PROBLEM, optimizer="ga")),
    "update seeded by a float": ("rng", lambda: ar.update(PROBLEM, rng=0.5)),
    "update from outside": ("x0[0][0]", lambda: ar.update(PROBLEM, x0=[2.0] * 7)),
    "damage of nothing": ("model", lambda: ar.assess_damage(EYE, SET)),
    "damage without terms": ("elements", lambda: ar.assess_damage(ar.MatrixModel(EYE, EYE), SET)),
    "damage of a ragged list": ("elements[0]", lambda: ar.assess_damage(MODEL, SET, elements=[[0], [1, 2]])),
    "damage of an element outside": ("elements[0]", lambda: ar.assess_damage(MODEL, SET, elements=[20])),
    "damage with a wrong gamma": (
        "gamma1",
        lambda: ar.assess_damage(MODEL, SET, search=ar.SearchOptions(gamma1=INF)),
    ),
    "plan of nothing": ("model", lambda: ar.plan_test(EYE, n_sensors=2)),
    "plan of an element outside": ("elements", lambda: ar.plan_test(MODEL, [20], n_sensors=2)),
    "plan of an element twice": ("elements", lambda: ar.plan_test(MODEL, [1, 1], n_sensors=2)),
    "plan of one sensor": ("n_sensors", lambda: ar.plan_test(MODEL, n_sensors=1)),
    "plan of too many sensors": ("n_sensors", lambda: ar.plan_test(MODEL, n_sensors=9)),
    "plan with a sensor outside": ("candidates", lambda: ar.plan_test(MODEL, n_sensors=2, candidates=[0, 8])),
    "plan with a sensor twice": ("candidates", lambda: ar.plan_test(MODEL, n_sensors=2, candidates=[0, 0])),
    "plan with a force outside": ("excitations", lambda: ar.plan_test(MODEL, n_sensors=2, excitations=8)),
    "plan without a value": ("band_hz", lambda: ar.plan_test(MODEL, n_sensors=2, band_hz=(0.0, 0.1))),
    "plan of a short record": ("duration_s", lambda: ar.plan_test(MODEL, n_sensors=2, duration_s=0.0)),
    "plan by no criterion": ("criterion", lambda: ar.plan_test(MODEL, n_sensors=2, criterion="best")),
    "detection of nothing": ("model", lambda: ar.detectability(EYE, excitation=0)),
    "detection without a band": ("band_hz", lambda: ar.detectability(MODEL, excitation=0, band_hz=(0, 0.1))),
    "detection with one sensor": ("sensors", lambda: ar.detectability(MODEL, excitation=0, sensors=[0])),
    "detection by a perfect model": (
        "model_error",
        lambda: ar.detectability(MODEL, excitation=0, model_error=0.0),
    ),
    "detection by few tests": (
        "n_tests",
        lambda: ar.detectability(MODEL, excitation=0, method="simulated", n_tests=9),
    ),
    "detection of falling losses": (
        "severities",
        lambda: ar.detectability(MODEL, excitation=0, severities=[0.2, 0.1]),
    ),
    "detection with no prior": ("prior", lambda: ar.detectability(MODEL, excitation=0, prior=0.5)),
    "box with lower above upper": ("bounds[1]", minimize([(0, 1), (2, 1)])),
    "box without end": ("bounds[0]", minimize([(0, INF)])),
    "box of one number": ("bounds", minimize([1.0])),
    "box of nothing": ("bounds", minimize([])),
    "box of words": ("bounds", minimize([("a", "b")])),
    "box ragged": ("bounds", minimize([(0, 1), (0,)])),
    "guess outside": ("x0[0][1]", minimize(x0=[0.5, 2.0])),
    "guess too long": ("x0", minimize(x0=[0.5] * 3)),
    "no function": ("fun", minimize(fun=3)),
    "workers with vectorized": ("workers", minimize(vectorized=True, workers=2)),
    "workers below one": ("workers", minimize(workers=0)),
    "unknown option": ("option", option(ilands=4)),
    "no islands": ("islands", option(islands=0)),
    "islands a fraction": ("islands", option(islands=2.5)),
    "islands beyond any integer": ("islands", option(islands=2**70)),
    "population too small": ("population", option(population=1)),
    "probability above one": ("crossover_probability", option(crossover_probability=1.5)),
    "probability NaN": ("mutation_probability", option(mutation_probability=NAN)),
    "unknown crossover": ("crossovers", option(crossovers=["two-point"])),
    "no crossover": ("crossovers", option(crossovers=[])),
    "crossovers not a list": ("crossovers", option(crossovers=5)),
    "unknown agreement": ("agreement", option(agreement="costs")),
    "negative time": ("max_seconds", option(max_seconds=-1.0)),
    "no evaluations": ("max_evaluations", option(max_evaluations=0)),
    "modal set out of order": ("freq_hz", lambda: ar.ModalSet([2.0, 1.0], np.ones((2, 2)))),
    "modal set of another size": ("shapes", lambda: ar.ModalSet([1.0], np.ones((2, 2)))),
    "antiresonance of zero": ("freq_hz[0]", lambda: ar.AntiresonanceSet(0, {0: [0.0]})),
    "record with NaN": ("responses", lambda: ar.Recording([[1.0, NAN]], 10.0)),
    "record at no rate": ("fs_hz", lambda: ar.Recording(np.ones((1, 10)), 0.0)),
    "band outside the data": (
        "band_hz",
        lambda: ar.identify_antiresonances(RECORD, excitation=0, band_hz=(10.0, 60.0)),
    ),
    "unknown route": (
        "route",
        lambda: ar.identify_antiresonances(RECORD, excitation=0, band_hz=(1.0, 40.0), route="fastest"),
    ),
    "dof that was not recorded": (
        "dofs",
        lambda: ar.identify_antiresonances(RECORD, excitation=0, band_hz=(1.0, 40.0), dofs=[7]),
    ),
    "perturbation too large": ("perturbation", lambda: ar.cases.chain8(perturbation=0.9)),
    "no such level": ("level", lambda: CASE.experiment(level=2)),
    "no such spring": ("element", lambda: CASE.search_problem(7, 0.5)),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_call_says_what_was_got_and_what_is_wanted(wrong):
    argument, call = WRONG[wrong]
    with pytest.raises(ValueError) as caught:
        call()
    assert isinstance(caught.value, ar.InvalidInputError)
    assert isinstance(caught.value, ar.AntiresError)
    error = caught.value
    assert re.match(rf"{re.escape(argument)}(?!\w)", error.argument), error.argument
    assert all((error.argument, error.got, error.wanted, error.remedy)), error.args
    assert str(error) == f"{error.argument}: got {error.got}; wanted {error.wanted}. {error.remedy}"
    assert error.argument.startswith(error.path[0])


def test_the_table_is_as_long_as_promised():
    assert len(WRONG) >= 40


def test_the_unknown_option_lists_the_known():
    with pytest.raises(ar.InvalidInputError, match="one of islands, population"):
        ar.IslandGA(ilands=4)


def test_no_wrong_call_panics():
    """A Rust panic would be a BaseException that ``except Exception`` lets through."""
    for name, (_, call) in WRONG.items():
        with pytest.raises(BaseException) as caught:
            call()
        assert isinstance(caught.value, Exception), name


# ---- every class of the catalogue -------------------------------------------------------------------


def numerical():
    ar.MatrixModel(np.diag([1.0, 0.0]), np.diag([1.0, 0.0])).modes()


def unsuitable():
    ar.identify_antiresonances(
        ar.Recording(np.random.default_rng(0).standard_normal((1, 4000)), 100.0),
        excitation=0,
        band_hz=(1.0, 40.0),
    )


def objective():
    ar.IslandGA().minimize(lambda x: "no number", [(0, 1)], rng=0)


def missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    SET.to_dataframe()


def test_every_class_of_the_catalogue_is_raised(monkeypatch):
    """Except the root, which is never raised itself, and InternalError, which would be a bug."""
    raised = set()
    for cause in (numerical, unsuitable, objective, lambda: missing(monkeypatch), WRONG["no mass"][1]):
        with pytest.raises(ar.AntiresError) as caught:
            cause()
        raised.add(type(caught.value).__name__)
    # LostWorkerError: tests/package/test_workers.py
    elsewhere = {"AntiresError", "InternalError", "LostWorkerError", "OutOfMemoryError"}
    assert raised == set(exceptions.catalogue()) - elsewhere


@pytest.mark.parametrize(
    ("name", "builtin"),
    [
        ("InvalidInputError", ValueError),
        ("UnsuitableDataError", ValueError),
        ("NumericalError", ArithmeticError),
        ("ObjectiveError", ValueError),
        ("OutOfMemoryError", MemoryError),
        ("InternalError", RuntimeError),
        ("LostWorkerError", RuntimeError),
        ("MissingDependencyError", ImportError),
    ],
)
def test_every_class_is_also_the_fitting_builtin(name, builtin):
    assert issubclass(exceptions.catalogue()[name], ar.AntiresError)
    assert issubclass(exceptions.catalogue()[name], builtin)
    assert getattr(ar, name) is exceptions.catalogue()[name]


def test_a_wrong_call_leaves_the_process_alive():
    """In a process of its own: a crash of the core would take this one along."""
    code = "import antires_rs as ar\ntry: ar.MassSpringChain([-1.0], [])\nexcept ValueError: print('alive')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "alive"
