"""Wrong calls: an error of ours that names argument, got, wanted and remedy, which nothing takes apart."""

import ast
import copy
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse

import antires_rs as ar
from antires_rs import exceptions
from antires_rs.support.messages import LeftOut, Passed, Wording, spelled

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


def refused(call):
    with pytest.raises(ar.AntiresError) as caught:
        call()
    return caught.value


def later(function, **usual):
    """Calls of a function, made when a test asks for them."""
    return lambda *args, **options: lambda: function(*args, **(usual | options))


def sphere(x):
    return float(np.sum(x**2))


def minimize(bounds=BOX, fun=sphere, **options):
    return lambda: ar.IslandGA(max_evaluations=10).minimize(fun, bounds, **options)


chain, matrices, problem, measured = map(
    later, (ar.MassSpringChain, ar.MatrixModel, ar.UpdatingProblem, ar.AntiresonanceSet)
)
zeros, option, update, damage = map(later, (MODEL.antiresonances, ar.IslandGA, ar.update, ar.assess_damage))
simulate, plan = later(MODEL.simulate, **SIMULATE), later(ar.plan_test, n_sensors=2)
curves = later(ar.detectability, excitation=0)
frf = later(MODEL.frf, damping_ratio=0.01)
identify = later(ar.identify_antiresonances, excitation=0, band_hz=(1.0, 40.0))


#: What is wrong: (argument that the message must name first, the call).
WRONG = [
    ("masses_kg", chain([], [])),
    ("masses_kg", chain([1.0, NAN], [1.0])),
    ("masses_kg", chain([1.0, -2.0], [1.0])),
    ("masses_kg", chain([1.0, 0.0], [1.0])),
    ("masses_kg", chain([1.0, 1j], [1.0])),
    ("masses_kg", chain(["a", "b"], [1.0])),
    ("masses_kg", chain([[1.0, 2.0]], [1.0])),
    ("springs_n_per_m", chain([1.0, 2.0], [1.0, 2.0])),
    ("springs_n_per_m", chain([1.0, 2.0], [INF])),
    ("springs_n_per_m", chain([1.0, 2.0], [-1.0])),
    ("ground_first_n_per_m", chain([1.0], [], ground_first_n_per_m=-1.0)),
    ("ground_last_n_per_m", chain([1.0], [], ground_last_n_per_m=NAN)),
    ("stiffness", matrices(np.ones((2, 3)), EYE)),
    ("stiffness", matrices(np.ones((0, 0)), EYE)),
    ("stiffness", matrices(np.ones(4), EYE)),
    ("stiffness", matrices(NAN * EYE, EYE)),
    ("stiffness", matrices(scipy.sparse.csc_array(NAN * EYE), EYE)),
    ("stiffness", matrices([[1.0, 2.0], [0.0, 1.0]], EYE)),
    ("mass", matrices(EYE, np.eye(3))),
    ("mass", matrices(EYE, -EYE)),
    ("stiffness_terms[1]", matrices(EYE, EYE, stiffness_terms=[EYE, np.eye(3)])),
    ("mass_terms[0]", matrices(EYE, EYE, mass_terms=[[[0.0, 1.0], [0.0, 0.0]]])),
    ("n_modes", lambda: MODEL.modes(n_modes=0)),
    ("f_max_hz", lambda: MODEL.modes(f_max_hz=NAN)),
    ("excitation", zeros(0, 8)),
    ("excitation", zeros(0, -1)),
    ("excitation", zeros(0, 0.5)),
    ("response", zeros(8, 0)),
    ("response[1]", zeros([0, 9], 0)),
    ("response", zeros([], 0)),
    ("response", zeros("0", 0)),
    ("response", zeros(2**70, 0)),
    ("method", zeros(0, 0, method="qz")),
    ("f_max_hz", zeros(0, 0, f_max_hz=0.0)),
    ("freq_hz", frf(0, 0, [NAN])),
    ("freq_hz", frf(0, 0, [-1.0])),
    ("freq_hz", frf(0, 0, [])),
    ("kind", frf(0, 0, [1.0], kind="fast")),
    ("damping_ratio", frf(0, 0, [1.0], damping_ratio=[0.1] * 3)),
    ("damping_ratio", frf(0, 0, [1.0], damping_ratio=-0.01)),
    ("fs_hz", simulate(fs_hz=0.0)),
    ("duration_s", simulate(duration_s=-1.0)),
    ("duration_s", simulate(duration_s=1e-3)),
    ("duration_s", simulate(duration_s=1e300, fs_hz=1e300)),
    ("noise", simulate(noise=-0.1)),
    ("band_hz", simulate(band_hz=(1.0, 40.0))),
    ("band_hz", simulate(band_hz=(20.0, 10.0))),
    ("band_hz", simulate(band_hz=(1.01, 1.0101))),
    ("band_hz", simulate(band_hz=(1.0,))),
    ("damping_ratio", simulate(damping_ratio=NAN)),
    ("responses", simulate(responses=[])),
    ("rng", simulate(rng="seed")),
    ("rng", simulate(rng=-1)),
    ("bounds", lambda: ar.mass_factor(0, bounds=(1.1, 0.9))),
    ("bounds[0]", lambda: ar.mass_factor(0, bounds=(0.0, 0.9))),
    ("bounds[1]", lambda: ar.stiffness_reduction(0, bounds=(0.0, 1.5))),
    ("bounds[1]", lambda: ar.stiffness_factor(0, bounds=(0.9, NAN))),
    ("bounds", lambda: ar.stiffness_factor(0, bounds=(0.9, 1.0, 1.1))),
    ("response[0]", zeros([[0], [1, 2]], 0)),
    ("bounds[0]", lambda: ar.mass_factor(0, bounds=((1.0,), (1.0, 2.0)))),
    ("elements[0]", lambda: ar.stiffness_reduction([[0], [1, 2]])),
    ("rng", lambda: ar.cases.chain8(perturbation=0.1, rng="seed")),
    ("elements", lambda: ar.stiffness_reduction([])),
    ("elements", lambda: ar.stiffness_reduction(-1)),
    ("elements", lambda: ar.stiffness_reduction([1, 1])),
    ("model", problem(EYE, FACTORS, SET)),
    ("measured", problem(MODEL, FACTORS, {0: [1.0]})),
    ("parameters", problem(MODEL, [], SET)),
    ("parameters[0]", problem(MODEL, [FACTORS], SET)),
    ("parameters", problem(MODEL, 3, SET)),
    ("parameters", problem(MODEL, [*FACTORS, FACTORS[0]], SET)),
    ("parameters[0]", problem(MODEL, ar.stiffness_reduction(9), SET)),
    ("parameters[0]", problem(MODEL, ar.stiffness_reduction(7), SET)),
    ("measured dof", problem(MODEL, FACTORS, ar.AntiresonanceSet(0, {8: [1.0]}))),
    ("measured dof", problem(MODEL, FACTORS, ar.AntiresonanceSet(0, {"a": [1.0]}))),
    ("excitation", problem(MODEL, FACTORS, ar.AntiresonanceSet(9, {0: [1.0]}))),
    ("measured", problem(MODEL, FACTORS, ar.AntiresonanceSet(0, {0: []}))),
    ("misfit", problem(MODEL, FACTORS, SET, misfit="median")),
    ("gamma1", lambda: ar.DamagePenalty(-0.1)),
    ("gamma2", problem(MODEL, FACTORS, SET, penalty=(0.1, NAN))),
    ("snap", lambda: ar.DamagePenalty(snap=0.1)),
    ("penalty", problem(MODEL, FACTORS, SET, penalty=0.1)),
    ("x", lambda: PROBLEM.cost([1.0])),
    ("x", lambda: PROBLEM.cost([NAN] * 7)),
    ("candidates", lambda: PROBLEM.evaluate_many([1.0] * 7)),
    ("candidates", lambda: PROBLEM.evaluate_many(np.ones((3, 6)))),
    ("candidates", lambda: PROBLEM.evaluate_many(np.ones((0, 7)))),
    ("workers", lambda: PROBLEM.evaluate_many(np.ones((1, 7)), workers=0)),
    ("problem", update(MODEL)),
    ("optimizer", update(PROBLEM, optimizer="ga")),
    ("rng", update(PROBLEM, rng=0.5)),
    ("x0[0][0]", update(PROBLEM, x0=[2.0] * 7)),
    ("model", damage(EYE, SET)),
    ("elements", damage(ar.MatrixModel(EYE, EYE), SET)),
    ("elements[0]", damage(MODEL, SET, elements=[[0], [1, 2]])),
    ("elements[0]", damage(MODEL, SET, elements=[20])),
    ("gamma1", damage(MODEL, SET, search=ar.SearchOptions(gamma1=INF))),
    ("model", plan(EYE)),
    ("elements", plan(MODEL, [20])),
    ("elements", plan(MODEL, [1, 1])),
    ("n_sensors", plan(MODEL, n_sensors=1)),
    ("n_sensors", plan(MODEL, n_sensors=9)),
    ("candidates", plan(MODEL, candidates=[0, 8])),
    ("candidates", plan(MODEL, candidates=[0, 0])),
    ("excitations", plan(MODEL, excitations=8)),
    ("band_hz", plan(MODEL, band_hz=(0.0, 0.1))),
    ("duration_s", plan(MODEL, duration_s=0.0)),
    ("criterion", plan(MODEL, criterion="best")),
    ("model", curves(EYE)),
    ("band_hz", curves(MODEL, band_hz=(0, 0.1))),
    ("sensors", curves(MODEL, sensors=[0])),
    ("model_error", curves(MODEL, model_error=0.0)),
    ("n_tests", curves(MODEL, method="simulated", n_tests=9)),
    ("severities", curves(MODEL, severities=[0.2, 0.1])),
    ("prior", curves(MODEL, prior=0.5)),
    ("bounds[1]", minimize([(0, 1), (2, 1)])),
    ("bounds[0]", minimize([(0, INF)])),
    ("bounds", minimize([1.0])),
    ("bounds", minimize([])),
    ("bounds", minimize([("a", "b")])),
    ("bounds", minimize([(0, 1), (0,)])),
    ("x0[0][1]", minimize(x0=[0.5, 2.0])),
    ("x0", minimize(x0=[0.5] * 3)),
    ("fun", minimize(fun=3)),
    ("workers", minimize(vectorized=True, workers=2)),
    ("workers", minimize(workers=0)),
    ("option", option(ilands=4)),
    ("islands", option(islands=0)),
    ("islands", option(islands=2.5)),
    ("islands", option(islands=2**70)),
    ("population", option(population=1)),
    ("crossover_probability", option(crossover_probability=1.5)),
    ("mutation_probability", option(mutation_probability=NAN)),
    ("crossovers", option(crossovers=["two-point"])),
    ("crossovers", option(crossovers=[])),
    ("crossovers", option(crossovers=5)),
    ("agreement", option(agreement="costs")),
    ("max_seconds", option(max_seconds=-1.0)),
    ("max_evaluations", option(max_evaluations=0)),
    ("freq_hz", lambda: ar.ModalSet([2.0, 1.0], np.ones((2, 2)))),
    ("shapes", lambda: ar.ModalSet([1.0], np.ones((2, 2)))),
    ("freq_hz[0]", measured(0, {0: [0.0]})),
    ("responses", lambda: ar.Recording([[1.0, NAN]], 10.0)),
    ("fs_hz", lambda: ar.Recording(np.ones((1, 10)), 0.0)),
    ("band_hz", identify(RECORD, band_hz=(10.0, 60.0))),
    ("route", identify(RECORD, route="fastest")),
    ("dofs", identify(RECORD, dofs=[7])),
    ("perturbation", lambda: ar.cases.chain8(perturbation=0.9)),
    ("level", lambda: CASE.experiment(level=2)),
    ("element", lambda: CASE.search_problem(7, 0.5)),
]


@pytest.mark.parametrize(("argument", "call"), WRONG)
def test_a_wrong_call_says_what_was_got_and_what_is_wanted(argument, call):
    raised = refused(call)
    assert isinstance(raised, ar.InvalidInputError)
    assert re.match(rf"{re.escape(argument)}(?!\w)", raised.argument), raised.argument
    for error in (raised, pickle.loads(pickle.dumps(raised)), copy.copy(raised), copy.deepcopy(raised)):
        assert type(error) is type(raised)
        assert (error.path, error.argument, error.got) == (raised.path, raised.argument, raised.got)
        assert all((error.argument, error.got, error.wanted, error.remedy)), error.args
        assert str(error) == f"{error.argument}: got {error.got}; wanted {error.wanted}. {error.remedy}"
        assert error.argument.startswith(error.path[0])


def test_the_unknown_option_lists_the_known():
    with pytest.raises(ar.InvalidInputError, match="one of islands, population"):
        ar.IslandGA(ilands=4)


def beam(tube, **options):
    return lambda: ar.FrameModel(
        [[0.0, 0.0], [1.0, 0.0]], [(0, 1)], [ar.Tube(*tube, 2.1e11, 7850.0)], **options
    )


ALONE = ar.Recording(np.random.default_rng(0).standard_normal((1, 4000)), 100.0)
BAD = ar.InvalidInputError
#: Call, class, path and what was got: from the core, and from checks in Python.
RAISED = [
    (chain([1.0, -1.0], [500.0]), BAD, ("masses_kg",), "-1 kg at index 1"),
    (minimize(x0=[0.5, 2.0]), BAD, ("x0", 0, 1), "2"),
    (beam((0.05, 0.04)), BAD, ("sections", 0, "thickness_m"), "a wall of 0.04 m in a tube of 0.05 m"),
    (beam((0.05, 0.002), point_masses=[(0, -1.0)]), BAD, ("point_masses", 0, "mass_kg"), "-1.0"),
    (lambda: ar.mass_factor(0, bounds=(0.0, 0.9)), BAD, ("bounds", 0), "0.0"),
    (measured(0, {"12+Z": [-1.0]}), BAD, ("freq_hz", "12+Z"), "-1 Hz"),
    (identify(ALONE), ar.UnsuitableDataError, ("source",), "a single channel"),
    (minimize(fun=np.zeros_like, vectorized=True), ar.ObjectiveError, ("fun",), "an array of shape (10, 2)"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "kind", "path", "got"), RAISED)
def test_an_error_has_its_class_and_its_fields(call, kind, path, got):
    error = refused(call)
    assert (type(error), error.path, error.got) == (kind, path, got)


def test_a_failed_computation_says_which_and_how():
    error = refused(ar.MatrixModel(np.diag([1.0, 0.0]), np.diag([1.0, 0.0])).modes)
    assert type(error) is ar.NumericalError
    assert str(error) == f"{error.what} failed: {error.detail}"
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_a_part_of_an_argument_stays_one_after_pickle():
    part = pickle.loads(pickle.dumps(exceptions.Argument("sections").item("pipe").attribute("thickness_m")))
    assert part == "sections['pipe'].thickness_m"
    assert part.path == ("sections", "pipe", "thickness_m")


def test_a_text_that_names_arguments_is_spelt_for_each_caller():
    text = Wording("Pass {} or {}; {}.", Passed("first", "time"), Passed("fs_hz"), LeftOut("channel"))
    assert text == "Pass first='time' or fs_hz=; Map a channel to None to leave it out."
    there = pickle.loads(pickle.dumps(text))
    assert spelled(there, lambda part: type(part).__name__) == "Pass Passed or Passed; LeftOut."
    assert spelled("as it is", str) == "as it is"


# -- Every class of the catalogue


BUILTINS = {
    "InvalidInputError": ValueError,
    "UnsuitableDataError": ValueError,
    "NumericalError": ArithmeticError,
    "ObjectiveError": ValueError,
    "OutOfMemoryError": MemoryError,
    "InternalError": RuntimeError,
    "LostWorkerError": RuntimeError,
    "MissingDependencyError": ImportError,
}


def test_every_class_is_public_and_also_the_fitting_builtin():
    assert set(exceptions.catalogue()) == {*BUILTINS, "AntiresError"}
    for name, builtin in BUILTINS.items():
        assert issubclass(exceptions.catalogue()[name], ar.AntiresError)
        assert issubclass(exceptions.catalogue()[name], builtin)
        assert getattr(ar, name) is exceptions.catalogue()[name]


# -- Nothing reads a message


#: Methods of patterns and texts that take a text apart.
READERS = {"match", "fullmatch", "search", "sub", "subn", "findall", "finditer", "split", "rsplit"}
READERS |= {"partition", "rpartition", "startswith", "endswith", "find", "index", "removeprefix"}
#: Names that hold an error or its sentence wherever they are an argument of a function, and its parts.
ERRORS, SENTENCES = {"exc", "error", "message"}, {"args", "msg", "message", "reason"}


def tells(node, told):
    """Whether a value is made of the sentence of an error by one of these names; its fields are none."""
    if isinstance(node, ast.Attribute):
        return node.attr in SENTENCES and tells(node.value, told)
    if isinstance(node, ast.Call) and not (
        isinstance(node.func, ast.Name) and node.func.id in ("str", "repr")
    ):
        return False
    if isinstance(node, ast.Name):
        return node.id in told
    return any(tells(part, told) for part in ast.iter_child_nodes(node))


def readings(source):
    """Lines on which a sentence of an error is taken apart: by a pattern, a method of texts, or ``in``."""
    lines = set()
    for scope in ast.walk(ast.parse(source)):
        if not isinstance(scope, ast.FunctionDef | ast.Module):
            continue
        told = {a.arg for a in scope.args.args} & ERRORS if isinstance(scope, ast.FunctionDef) else set()
        nodes = list(ast.walk(scope))
        told |= {n.name for n in nodes if isinstance(n, ast.ExceptHandler) and n.name}
        for n in nodes:
            if isinstance(n, ast.Assign) and tells(n.value, told):  # what is made of a sentence is one too
                told |= {target.id for target in n.targets if isinstance(target, ast.Name)}
        for n in nodes:
            read = []
            if isinstance(n, ast.Call) and isinstance(n.func, ast.Attribute) and n.func.attr in READERS:
                read = [n.func.value, *n.args]
            elif isinstance(n, ast.Compare) and any(isinstance(op, ast.In | ast.NotIn) for op in n.ops):
                read = n.comparators
            if any(tells(part, told) for part in read):
                lines.add(n.lineno)
    return sorted(lines)


def test_nothing_in_the_package_reads_a_message():
    package = Path(ar.__file__).parent
    found = {
        file.relative_to(package).as_posix()
        for file in package.rglob("*.py")
        if readings(file.read_text(encoding="utf-8"))
    }
    # Which worker died of what stands nowhere but in the text of the executor's error.
    assert found <= {"support/workers.py"}


@pytest.mark.parametrize(
    "code",
    [
        "try: f()\nexcept E as exc:\n    re.match(P, str(exc))",
        "try: f()\nexcept E as exc:\n    said = str(exc)\n    _ARGUMENT.search(said)",
        "try: f()\nexcept E as exc:\n    re.sub(P, '', exc.args[0])",
        "try: f()\nexcept E as exc:\n    name, _, rest = str(exc).partition(':')",
        "try: f()\nexcept E as exc:\n    if 'pickle' in f'{exc}': pass",
        "def error(self, message):\n    if found := re.fullmatch(P, message): pass",
    ],
)
def test_a_message_that_is_read_is_found(code):
    assert readings(code)


def test_what_reads_no_message_is_left_alone():
    assert not readings("try: f()\nexcept E as exc:\n    raise G(exc.argument, exc.got) from exc")
    assert not readings("try: f()\nexcept E as exc:\n    say(str(exc))\nre.match(P, file.name)")
