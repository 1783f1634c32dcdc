"""The face of the package: names, docstrings, imports, stubs, and the house rules that code can check."""

import inspect
import re
import subprocess
import sys
import tomllib

import pytest

import antires_rs as ar
from antires_rs import exceptions
from tests.support.campaign import campaign
from tests.support.paths import ROOT

IN_SOURCE_TREE = (ROOT / "Cargo.toml").is_file()


def test_names_are_sorted_and_every_exception_is_among_them():
    assert list(ar.__all__) == sorted(set(ar.__all__))
    assert set(exceptions.catalogue()) | {"AntiresWarning"} <= set(ar.__all__)


#: Everything but the version.
PUBLIC = [name for name in ar.__all__ if name != "__version__"]


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_is_documented(name):
    thing = getattr(ar, name)
    text = inspect.getdoc(thing)
    assert text
    assert text.splitlines()[0].strip().endswith(".")
    assert re.search(r"^Examples\n-+\n>>> ", text, re.MULTILINE), f"{name} has no example"


@pytest.mark.parametrize("name", [n for n in PUBLIC if inspect.isclass(getattr(ar, n))])
def test_every_public_method_is_documented(name):
    thing = getattr(ar, name)
    for member, value in vars(thing).items():
        if not member.startswith("_") and (callable(value) or isinstance(value, property | classmethod)):
            assert inspect.getdoc(getattr(thing, member)), f"{name}.{member}"


@pytest.mark.parametrize("name", [n for n in PUBLIC if inspect.isfunction(getattr(ar, n))])
def test_functions_document_every_parameter(name):
    function = getattr(ar, name)
    text = inspect.getdoc(function)
    section = re.search(r"Parameters\n-+\n(.*?)\n\n(?:Returns|Yields)\n", text, re.DOTALL)[1]
    named = {
        n.strip()
        for line in re.findall(r"^\*{0,2}([\w, ]+?)(?: :.*)?$", section, re.MULTILINE)
        for n in line.split(",")
    }
    assert set(inspect.signature(function).parameters) <= named


def test_the_version_is_the_packages():
    from importlib.metadata import version

    assert ar.__version__ == version("antires-rs")
    if IN_SOURCE_TREE:
        workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())
        assert ar.__version__ == workspace["workspace"]["package"]["version"]


@campaign  # and in `make lint`
def test_the_stub_is_that_of_the_built_module(tmp_path):
    pytest.importorskip("mypy")
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "antires_rs._core"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stdout + done.stderr
