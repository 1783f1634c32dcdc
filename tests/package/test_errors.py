"""Errors carry what they say in fields, and nothing in the package reads their sentences."""

import ast
import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.exceptions import Argument
from antires_rs.support.messages import LeftOut, Passed, Wording, spelled

PACKAGE = Path(ar.__file__).parent
TUBE = ar.Tube(0.05, 0.002, 2.1e11, 7850.0)


def refused(call, *args, **options):
    with pytest.raises(ar.AntiresError) as caught:
        call(*args, **options)
    return caught.value


#: Call, class, path and what was got: from the core, and from checks in Python.
RAISED = {
    "core, whole argument": (
        lambda: ar.MassSpringChain([1.0, -1.0], [500.0]),
        (ar.InvalidInputError, ("masses_kg",), "-1 kg at index 1"),
    ),
    "core, item of an item": (
        lambda: ar.IslandGA().minimize(lambda x: 0.0, [(0, 1)] * 2, x0=[0.5, 2.0]),
        (ar.InvalidInputError, ("x0", 0, 1), "2"),
    ),
    "core, field of an item": (
        lambda: ar.FrameModel(
            [[0.0, 0.0], [1.0, 0.0]], [(0, 1)], [ar.Tube(0.05, 0.04, 2.1e11, 7850.0)], fixed=[0]
        ),
        (ar.InvalidInputError, ("sections", 0, "thickness_m"), "a wall of 0.04 m in a tube of 0.05 m"),
    ),
    "Python, item": (
        lambda: ar.mass_factor(0, bounds=(0.0, 0.9)),
        (ar.InvalidInputError, ("bounds", 0), "0.0"),
    ),
    "Python, field of an item": (
        lambda: ar.FrameModel(
            [[0.0, 0.0], [1.0, 0.0]], [(0, 1)], [TUBE], point_masses=[ar.PointMass(0, -1.0)]
        ),
        (ar.InvalidInputError, ("point_masses", 0, "mass_kg"), "-1.0"),
    ),
    "Python, item by key": (
        lambda: ar.AntiresonanceSet(0, {"12+Z": [-1.0]}),
        (ar.InvalidInputError, ("freq_hz", "12+Z"), "-1 Hz"),
    ),
    "unsuitable data": (
        lambda: ar.identify_antiresonances(
            ar.Recording(np.ones((1, 400)), 100.0), excitation=0, band_hz=(1.0, 40.0)
        ),
        (ar.UnsuitableDataError, ("source",), "a single channel"),
    ),
    "objective": (
        lambda: ar.IslandGA().minimize(lambda x: np.zeros(3), [(0, 1)], rng=0, vectorized=True),
        (ar.ObjectiveError, ("fun",), "an array of shape (3,)"),
    ),
}


@pytest.mark.parametrize("case", RAISED)
def test_an_error_has_its_class_and_its_fields_also_after_pickle_and_copy(case):
    call, (kind, path, got) = RAISED[case]
    raised = refused(call)
    for error in (raised, pickle.loads(pickle.dumps(raised)), copy.copy(raised), copy.deepcopy(raised)):
        assert type(error) is kind
        assert (error.path, error.got) == (path, got)
        assert error.wanted
        assert error.remedy
        assert str(error) == f"{error.argument}: got {got}; wanted {error.wanted}. {error.remedy}"


def test_a_failed_computation_says_which_and_how():
    error = refused(ar.MatrixModel(np.diag([1.0, 0.0]), np.diag([1.0, 0.0])).modes)
    assert type(error) is ar.NumericalError
    assert str(error) == f"{error.what} failed: {error.detail}"
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_a_part_of_an_argument_stays_one_after_pickle():
    part = pickle.loads(pickle.dumps(Argument("sections").item("pipe").attribute("thickness_m")))
    assert part == "sections['pipe'].thickness_m"
    assert part.path == ("sections", "pipe", "thickness_m")


def test_a_text_that_names_arguments_is_spelt_for_each_caller():
    text = Wording("Pass {} or {}; {}.", Passed("first", "time"), Passed("fs_hz"), LeftOut("channel"))
    assert text == "Pass first='time' or fs_hz=; Map a channel to None to leave it out."
    there = pickle.loads(pickle.dumps(text))
    assert spelled(there, lambda part: type(part).__name__) == "Pass Passed or Passed; LeftOut."
    assert spelled("as it is", str) == "as it is"


# ---- nothing reads a message ------------------------------------------------------------------------

#: Methods of patterns and texts that take a text apart.
READERS = {"match", "fullmatch", "search", "sub", "subn", "findall", "finditer", "split", "rsplit"}
READERS |= {"partition", "rpartition", "startswith", "endswith", "find", "index", "removeprefix"}
#: Names that hold an error or its sentence wherever they are an argument of a function.
ERRORS = {"exc", "error", "message"}


def readings(source):
    """Lines on which a sentence of an error is taken apart: by a pattern, a method of texts, or ``in``."""
    found = set()
    for scope in ast.walk(ast.parse(source)):
        if isinstance(scope, ast.FunctionDef | ast.Module):
            found |= _readings_in(scope)
    return sorted(found)


def _readings_in(scope):
    told = (
        {a.arg for a in getattr(scope.args, "args", ()) if a.arg in ERRORS}
        if hasattr(scope, "args")
        else set()
    )
    nodes = list(ast.walk(scope))
    told |= {n.name for n in nodes if isinstance(n, ast.ExceptHandler) and n.name}
    if not told:
        return set()
    while True:  # what is made of a sentence is one too
        more = {
            target.id
            for n in nodes
            if isinstance(n, ast.Assign) and _tells(n.value, told)
            for target in n.targets
            if isinstance(target, ast.Name)
        }
        if more <= told:
            break
        told |= more
    lines = set()
    for n in nodes:
        read = []
        if isinstance(n, ast.Call) and isinstance(n.func, ast.Attribute) and n.func.attr in READERS:
            read = [n.func.value, *n.args]
        elif isinstance(n, ast.Compare) and any(isinstance(op, ast.In | ast.NotIn) for op in n.ops):
            read = n.comparators
        if any(_tells(part, told) for part in read):
            lines.add(n.lineno)
    return lines


def _tells(node, told):
    """Whether an expression is a sentence of an error: the name, ``str`` of it, ``args`` or ``msg`` of it."""
    if isinstance(node, ast.Name):
        return node.id in told
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("str", "repr"):
        return any(_tells(part, told) for part in node.args)
    if isinstance(node, ast.Attribute):
        return node.attr in ("args", "msg", "message", "reason") and _tells(node.value, told)
    if isinstance(node, ast.Subscript):
        return _tells(node.value, told)
    if isinstance(node, ast.BinOp):
        return _tells(node.left, told) or _tells(node.right, told)
    if isinstance(node, ast.JoinedStr):
        return any(_tells(part.value, told) for part in node.values if isinstance(part, ast.FormattedValue))
    return False


def test_nothing_in_the_package_reads_a_message():
    found = {
        str(file.relative_to(PACKAGE)): lines
        for file in sorted(PACKAGE.rglob("*.py"))
        if (lines := readings(file.read_text(encoding="utf-8")))
    }
    # Which worker died of what stands nowhere but in the text of the executor's error.
    assert set(found) <= {"support/workers.py"}


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
