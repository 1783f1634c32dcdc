"""``import antires_rs`` waits for nothing, and still shows everything to users, editors and type checkers."""

import ast
import pickle
import pkgutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import antires_rs as ar

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


@pytest.mark.parametrize("name", sorted(ar._HOME))
def test_a_name_is_that_of_its_module(name):
    module = import_module(f"antires_rs.{ar._HOME[name]}")
    assert getattr(ar, name) is getattr(module, name)
    assert pickle.loads(pickle.dumps(getattr(ar, name))) is getattr(ar, name)


def test_no_module_can_take_the_place_of_a_public_name():
    assert len(MODULES) > 15
    assert set(ar._HOME) & set(MODULES) == set()


def test_everything_is_listed_before_it_is_imported():
    listed = in_a_new_process("import antires_rs as ar; print(*dir(ar))").split()
    assert set(ar.__all__) | {"cases", "exceptions", "figures", "io"} <= set(listed)


def test_an_unknown_name_is_answered_as_python_does():
    with pytest.raises(AttributeError, match="'antires_rs' has no attribute 'indentify_modes'") as caught:
        ar.indentify_modes  # noqa: B018
    assert (caught.value.name, caught.value.obj) == ("indentify_modes", ar)
    assert not hasattr(ar, "__wrapped__")
    with pytest.raises(ImportError, match="cannot import name 'nothing'"):
        exec("from antires_rs import nothing")
    done = subprocess.run(
        [sys.executable, "-c", "import antires_rs as ar; ar.indentify_modes"], capture_output=True, text=True
    )
    assert "Did you mean: 'identify_modes'?" in done.stderr


def test_a_broken_installation_is_not_taken_for_an_unknown_name():
    code = (
        "import sys; sys.modules['numpy'] = None\nimport antires_rs\n"
        "for name in ('Recording', 'frf'):\n"
        "    try: getattr(antires_rs, name)\n    except ImportError as exc: print(exc.name)"
    )
    assert in_a_new_process(code).split() == ["numpy", "numpy"]


def test_importing_the_package_costs_nothing():
    loaded = in_a_new_process("import sys, antires_rs\nprint(*sys.modules)").split()
    ours = {name for name in loaded if name.startswith("antires_rs")}
    assert ours == {"antires_rs", "antires_rs._core"}
    assert {name.split(".")[0] for name in loaded} & (EXTRAS | {"numpy", "scipy"}) == set()


def test_importing_every_module_costs_no_extra_and_no_scipy():
    code = (
        f"import sys\nfrom antires_rs import *\nimport antires_rs as ar\n"
        f"for name in {MODULES!r}: getattr(ar, name)\nprint(*sys.modules)"
    )
    loaded = in_a_new_process(code).split()
    assert "numpy" in loaded
    assert {name.split(".")[0] for name in loaded} & (EXTRAS | {"scipy"}) == set()
    assert "multiprocessing.pool" not in loaded


@pytest.mark.parametrize("argument", ["--help", "--version"])
def test_the_command_line_answers_without_numpy(argument):
    code = (
        f"import sys; from antires_rs.app.main import main\ntry: main(['{argument}'])\n"
        "except SystemExit: pass\nprint()\nprint(*sys.modules)"
    )
    said, _, loaded = in_a_new_process(code).rpartition("\n")
    assert "antires" in said
    assert {name.split(".")[0] for name in loaded.split()} & (EXTRAS | {"numpy", "scipy"}) == set()


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
