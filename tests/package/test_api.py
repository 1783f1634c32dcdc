"""The face of the package: names, docstrings, imports, stubs, and the house rules that code can check."""

import ast
import inspect
import pickle
import pkgutil
import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import antires_rs as ar
from antires_rs import exceptions
from tests.support.paths import ROOT

IN_SOURCE_TREE = (ROOT / "Cargo.toml").is_file()


def test_names_are_sorted_and_every_exception_is_among_them():
    assert list(ar.__all__) == sorted(set(ar.__all__))
    assert {name for name in vars(exceptions) if name.endswith(("Error", "Warning"))} <= set(ar.__all__)


PUBLIC = [name for name in ar.__all__ if name != "__version__"]  #: Everything but the version.


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_method_and_parameter_is_documented(name):
    thing = getattr(ar, name)
    text = inspect.getdoc(thing)
    assert text.splitlines()[0].strip().endswith(".")
    assert re.search(r"^Examples\n-+\n>>> ", text, re.MULTILINE), f"{name} has no example"
    for member, value in vars(thing).items() if inspect.isclass(thing) else ():
        if not member.startswith("_") and (callable(value) or isinstance(value, property | classmethod)):
            assert inspect.getdoc(getattr(thing, member)), f"{name}.{member}"
    if inspect.isfunction(thing):
        section = re.search(r"Parameters\n-+\n(.*?)\n\n(?:Returns|Yields)\n", text, re.DOTALL)[1]
        lines = re.findall(r"^\*{0,2}([\w, ]+?)(?: :.*)?$", section, re.MULTILINE)
        named = {each.strip() for line in lines for each in line.split(",")}
        assert set(inspect.signature(thing).parameters) <= named


def test_the_version_is_the_packages():
    from importlib.metadata import version

    assert ar.__version__ == version("antires-rs")
    if IN_SOURCE_TREE:
        workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())
        assert ar.__version__ == workspace["workspace"]["package"]["version"]


# -- ``import antires_rs`` waits for nothing, and still shows everything to users, editors and type checkers
HERE = Path(ar.__file__).parent
MODULES = sorted({module.name for module in pkgutil.iter_modules([str(HERE)])} - {"__main__"})
#: What no import of ours may cost.
EXTRAS = {"matplotlib", "h5py", "dask", "pyuff", "pandas", "xarray", "jinja2", "tqdm"}


def in_a_new_process(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def stub():
    """(name, module) of what the stub imports, the modules it shows, and its ``__all__``."""
    names, modules, public = {}, [], None
    for node in ast.parse((HERE / "__init__.pyi").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and node.module is None:
            modules += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names |= {alias.name: node.module for alias in node.names}
        elif isinstance(node, ast.Assign):
            public = ast.literal_eval(node.value)
    return names, modules, public


def test_the_stub_says_what_the_package_does():
    names, modules, public = stub()
    assert names == ar._HOME | {"__version__": "_core"}
    assert tuple(modules) == ar._MODULES
    assert public == ar.__all__
    assert set(ar.__all__) == set(names) | {"cases"}


def test_a_name_is_that_of_its_module_and_no_module_can_take_its_place():
    assert len(MODULES) > 15
    assert set(ar._HOME) & set(MODULES) == set()
    for name, home in ar._HOME.items():
        assert getattr(ar, name) is getattr(import_module(f"antires_rs.{home}"), name)
        assert pickle.loads(pickle.dumps(getattr(ar, name))) is getattr(ar, name)


def test_an_unknown_name_is_answered_as_python_does():
    with pytest.raises(AttributeError, match="'antires_rs' has no attribute 'indentify_modes'") as caught:
        ar.indentify_modes  # noqa: B018
    assert (caught.value.name, caught.value.obj) == ("indentify_modes", ar)
    assert not hasattr(ar, "__wrapped__")
    with pytest.raises(ImportError, match="cannot import name 'nothing'"):
        exec("from antires_rs import nothing")
    call = [sys.executable, "-c", "import antires_rs as ar; ar.indentify_modes"]
    assert "Did you mean: 'identify_modes'?" in subprocess.run(call, capture_output=True, text=True).stderr


def test_a_broken_installation_is_not_taken_for_an_unknown_name():
    code = (
        "import sys; sys.modules['numpy'] = None\nimport antires_rs\nprint(*dir(antires_rs))\n"
        "for name in ('Recording', 'frf'):\n"
        "    try: getattr(antires_rs, name)\n    except ImportError as exc: print(exc.name)"
    )
    listed, *missing = in_a_new_process(code).splitlines()
    assert set(ar.__all__) | {"cases", "exceptions", "figures", "io"} <= set(listed.split())
    assert missing == ["numpy", "numpy"]


ALL = f"from antires_rs import *; import antires_rs as ar\nfor name in {MODULES!r}: getattr(ar, name)"
ASKED = "from antires_rs.app.main import main\ntry: main(['{}'])\nexcept SystemExit: pass"


@pytest.mark.parametrize(
    ("code", "more"),
    [("import antires_rs", {"numpy"}), (ALL, set()), (ASKED.format("--help"), {"numpy"})]
    + [(ASKED.format("--version"), {"numpy"})],
)
def test_importing_and_asking_for_help_cost_nothing(code, more):
    loaded = in_a_new_process(f"{code}\nimport sys; print()\nprint(*sys.modules)").splitlines()[-1].split()
    assert {name.split(".")[0] for name in loaded} & (EXTRAS | more | {"scipy"}) == set()
    assert "multiprocessing.pool" not in loaded
    if code == "import antires_rs":
        own = {name for name in loaded if name.startswith("antires_rs")}
        assert own == {"antires_rs", "antires_rs._core"}


def test_threads_may_ask_at_once():
    code = """
import random, sys, threading
sys.setswitchinterval(1e-6)
import antires_rs as ar
found, start = [], threading.Barrier(8)
def ask(seed):
    names = list(ar.__all__)
    random.Random(seed).shuffle(names)
    start.wait()
    found.append({name: id(getattr(ar, name)) for name in names})
threads = [threading.Thread(target=ask, args=(seed,)) for seed in range(8)]
for thread in threads: thread.start()
for thread in threads: thread.join()
print(len(found), all(each == found[0] for each in found), len(found[0]))
"""
    assert in_a_new_process(code) == f"8 True {len(ar.__all__)}"


# -- What has left says what is used now
@pytest.mark.parametrize(
    ("module", "name"), [("figures", "data_of"), ("figures", "plot_transmissibility"), ("io", "mat_arrays")]
)
def test_a_name_that_has_left_is_told(module, name):
    with pytest.raises(AttributeError, match=f"{name} has left: "):
        getattr(import_module(f"antires_rs.{module}"), name)
    with pytest.raises(AttributeError, match="has no 'never_there'"):
        _ = import_module(f"antires_rs.{module}").never_there


def test_a_keyword_that_has_left_warns_and_changes_nothing():
    zeros = ar.AntiresonanceSet(0, {1: [5.0, 9.0]})
    with pytest.warns(FutureWarning, match="AntiresonanceSet.drop: tol_hz has left and has no effect"):
        assert zeros.drop(1, 9.0, tol_hz=0.1) == zeros.drop(1, 9.0)
    with pytest.warns(FutureWarning, match="times has left") as caught:
        assert len(ar.Series.from_sets([zeros], times=[0.0])) == 1
    assert caught[0].filename == __file__
