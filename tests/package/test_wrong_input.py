"""Wrong calls and input that is far off: an error of ours that names argument, got, wanted and remedy."""

import copy
import os
import pickle
import re
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse

import antires_rs as ar
from antires_rs import exceptions
from antires_rs.app.job import LEAVE_OUT, read_job
from antires_rs.app.reading import spelled
from tests.support.snapshots import replay

NAN, INF = float("nan"), float("inf")
CASE = ar.cases.chain8()
MODEL = CASE.model
RECORD = ar.Recording(np.random.default_rng(0).standard_normal((2, 4000)), 100.0)
SET = ar.AntiresonanceSet(0, {0: [12.0, 36.0]})
FACTORS = ar.stiffness_factor(range(7), bounds=(0.9, 1.1))
PROBLEM = ar.UpdatingProblem(MODEL, FACTORS, SET)
EYE = np.eye(2)
SIMULATE = {"excitation": 0, "fs_hz": 64.0, "duration_s": 4.0, "damping_ratio": 0.01, "rng": 0}
BOX, SPARSE = [(0.0, 1.0)] * 2, scipy.sparse.csc_array(NAN * EYE)


def refused(call):
    with pytest.raises(ar.AntiresError) as caught:
        call()
    return caught.value


def later(function, **usual):
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
plan_of = partial(plan, MODEL)
curves = later(ar.detectability, excitation=0)
frf = later(MODEL.frf, damping_ratio=0.01)
identify = later(ar.identify_antiresonances, excitation=0, band_hz=(1.0, 40.0))


def of_set(freq_hz, force=0):
    return problem(MODEL, FACTORS, ar.AntiresonanceSet(force, freq_hz))


TWO = [1.0, 2.0]
mass_factor, reduction = map(later, (ar.mass_factor, ar.stiffness_reduction))
penalty, modal, recording, many = map(
    later, (ar.DamagePenalty, ar.ModalSet, ar.Recording, PROBLEM.evaluate_many)
)
modes, cost, chain8 = map(later, (MODEL.modes, PROBLEM.cost, ar.cases.chain8))


def test_a_wrong_call_says_what_was_got_and_what_is_wanted():
    """Each line of the file is a call and what is said of it."""

    def said(call):
        raised = refused(eval(call))
        assert isinstance(raised, ar.InvalidInputError)
        for error in (raised, pickle.loads(pickle.dumps(raised)), copy.copy(raised), copy.deepcopy(raised)):
            assert type(error) is type(raised)
            assert (error.path, error.argument, error.got) == (raised.path, raised.argument, raised.got)
            assert all((error.argument, error.got, error.wanted, error.remedy)), error.args
            assert str(error) == f"{error.argument}: got {error.got}; wanted {error.wanted}. {error.remedy}"
            assert error.argument.startswith(error.path[0])
        return " ".join(str(raised).split())

    replay(Path(__file__).with_name("wrong_input.txt"), said)


def beam(tube, **options):
    return lambda: ar.FrameModel(
        [[0.0, 0.0], [1.0, 0.0]], [(0, 1)], [ar.Tube(*tube, 2.1e11, 7850.0)], **options
    )


ALONE = ar.Recording(np.random.default_rng(0).standard_normal((1, 4000)), 100.0)
BAD = ar.InvalidInputError
RAISED = [  #: Call, class, path and what was got: from the core, and from checks in Python.
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


def test_a_failed_computation_says_which_and_how_and_a_part_of_an_argument_stays_one_after_pickle():
    error = refused(ar.MatrixModel(np.diag([1.0, 0.0]), np.diag([1.0, 0.0])).modes)
    assert type(error) is ar.NumericalError
    assert str(pickle.loads(pickle.dumps(error))) == str(error) == f"{error.what} failed: {error.detail}"
    part = pickle.loads(pickle.dumps(exceptions.Argument("sections").item("pipe").attribute("thickness_m")))
    assert part == "sections['pipe'].thickness_m"
    assert part.path == ("sections", "pipe", "thickness_m")


def test_a_text_that_names_arguments_is_spelt_for_each_caller():
    text = "Pass first='time', fs_hz= or x=; dofs={3: 0}. Map a channel to None to leave it out."
    there = spelled(text, lambda name, value: f"<{name} {value}>")
    assert there == f"Pass <first time>, <fs_hz None> or x=; dofs={{3: 0}}. {LEAVE_OUT}."
    assert spelled("as it is", lambda name, value: name) == "as it is"


# -- Every class of the catalogue
BUILTINS = dict.fromkeys(("InvalidInputError", "UnsuitableDataError", "ObjectiveError"), ValueError)
BUILTINS |= dict.fromkeys(("InternalError", "LostWorkerError"), RuntimeError)
BUILTINS |= {"NumericalError": ArithmeticError, "OutOfMemoryError": MemoryError}
BUILTINS |= {"MissingDependencyError": ImportError}


def test_every_class_is_public_and_also_the_fitting_builtin():
    assert {name for name in vars(exceptions) if name.endswith("Error")} == {*BUILTINS, "AntiresError"}
    for name, builtin in BUILTINS.items():
        assert issubclass(getattr(exceptions, name), ar.AntiresError)
        assert issubclass(getattr(exceptions, name), builtin)
        assert getattr(ar, name) is getattr(exceptions, name)


# -- Nothing reads a message
def test_nothing_in_the_package_reads_a_message():
    """Errors have fields; what TOML, the executors and NumPy say of their own stands in their texts alone."""
    text = r"(str\((exc|error|message)\)|(exc|error)\.args\[0\])"
    read = re.compile(rf"re\.\w+\(.*{text}|{text}\.\w*(partition|split|find|with|index)\(|\bif .*\bin {text}")
    found = {
        file.name
        for file in Path(ar.__file__).parent.rglob("*.py")
        for line in file.read_text(encoding="utf-8").splitlines()
        if read.search(line) and not line.strip().startswith(("...", ">>>"))
    }
    assert found == {"job.py", "matrix_files.py", "workers.py"}


# -- Input that is far off: each is an error of ours, at once
RNG = np.random.default_rng(0)
NOISE = RNG.standard_normal((3, 64))


@pytest.mark.parametrize(
    "text",
    [
        "[data]\nband_hz = " + "[" * 5000 + "]" * 5000,
        "[data]\nband_hz = " + "{a=" * 5000 + "1" + "}" * 5000,
        "[search]\nseed = " + "1" * 5000,
        ".".join(["a"] * 20_000) + " = 1",
        "[" + ".".join(["a"] * 20_000) + "]",
        "[data]\nx = { " + '"a" . ' * 20_000 + "a = 1 }",
        "[data]\nband_hz = " + "[" * 50_000,
        '[data]\nfile = "' + "[" * 50_000,
        "time,channel\n" + "0.5,1.5\n" * 50_000,
    ],
    ids=["[", "{", "digits", "a.a.a", "[a.a.a]", "{a.a.a}", "[[", "text", "a table in place of a job"],
)
def test_a_job_of_thousands(tmp_path, text):
    file = tmp_path / "job.toml"
    file.write_text(text)
    begun = time.process_time()
    with pytest.raises(ar.InvalidInputError, match=r"job\.toml, line [12]"):
        read_job(file)
    assert time.process_time() - begun < 5.0


@pytest.mark.parametrize("scale", [1e160, 1e-160])
def test_values_whose_squares_leave_floating_point(scale):
    for said, call in (
        ("responses: got values up to", recording(scale * NOISE, 256.0)),
        ("force: got values up to", recording(NOISE, 256.0, force=scale * NOISE[0])),
        ("values: got values up to", lambda: ar.FrequencyResponse(np.arange(64.0), scale * (NOISE + 1j))),
    ):
        assert str(refused(call)).startswith(said)


def test_a_masked_array_is_refused_and_one_without_masked_values_read():
    assert "values masked" in str(refused(recording(np.ma.masked_greater(NOISE, 1.0), 256.0)))
    assert ar.Recording(np.ma.masked_invalid(NOISE), 256.0).n_samples == 64


@pytest.mark.parametrize(("said", "stops"), [(0, False), (None, False), (1, True), (np.True_, True)])
def test_a_callback_may_return_any_truth_value(said, stops):
    search = ar.IslandGA(max_evaluations=400)
    box = [(-1, 1)] * 2
    found = search.minimize(lambda x: float(x @ x), box, rng=0, callback=lambda state: said)
    assert (found.status == "callback") is stops
    assert refused(minimize(callback=lambda state: np.zeros(3))).argument == "callback"


def test_a_device_is_not_replaced_by_a_file(tmp_path):
    pipe = tmp_path / "pipe.npz"
    os.mkfifo(pipe)
    assert "plain file" in str(refused(lambda: ar.write_npz(pipe, ar.Recording(NOISE, 256.0))))
    assert pipe.is_fifo()
