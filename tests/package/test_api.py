"""The face of the package: names, docstrings, imports, stubs, and the house rules that code can check."""

import inspect
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from antires_rs import exceptions
from tests.support.paths import ROOT

IN_SOURCE_TREE = (ROOT / "Cargo.toml").is_file()
LONGEST_FILE = 400


def test_all_is_sorted_and_without_repetition():
    assert list(ar.__all__) == sorted(set(ar.__all__))


def test_every_exception_is_at_the_top():
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
        for line in re.findall(r"^([\w, ]+?)(?: :.*)?$", section, re.MULTILINE)
        for n in line.split(",")
    }
    assert set(inspect.signature(function).parameters) <= named


def test_the_version_is_the_packages():
    from importlib.metadata import version

    assert ar.__version__ == version("antires-rs")
    if IN_SOURCE_TREE:
        workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())
        assert ar.__version__ == workspace["workspace"]["package"]["version"]


def test_the_package_is_typed():
    for name in ("py.typed", "_core.pyi", "__init__.pyi"):
        assert (Path(ar.__file__).parent / name).is_file()


def test_the_stub_is_that_of_the_built_module(tmp_path):
    pytest.importorskip("mypy")
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "antires_rs._core"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_results_of_the_core_are_arrays_of_numpys_own():
    freq, shapes = ar.cases.chain8().model._core.modes()
    assert (freq.dtype, shapes.dtype) == (np.float64, np.float64)
    assert freq.flags.writeable


# ---- the house --------------------------------------------------------------------------------------

needs_source = pytest.mark.skipif(not IN_SOURCE_TREE, reason="needs the source tree")


@needs_source
def test_the_core_knows_neither_python_nor_numpy():
    manifest = tomllib.loads((ROOT / "rust/antires-core/Cargo.toml").read_text())
    for section in ("dependencies", "dev-dependencies", "build-dependencies"):
        assert not {"pyo3", "numpy", "pyo3-ffi"} & set(manifest.get(section, {}))
    sources = list((ROOT / "rust/antires-core/src").rglob("*.rs"))
    assert sources
    for source in sources:
        assert not re.search(r"^\s*use (pyo3|numpy)\b", source.read_text(), re.MULTILINE), source.name


@needs_source
def test_the_optimizer_sees_no_structure():
    """It knows f(x) only; linalg knows no models; the signal side meets the models in AntiresonanceSet."""
    core = ROOT / "rust/antires-core/src"
    forbidden = {
        "optimize": "fem|modal|update|linalg",
        "linalg": "fem|modal|optimize|update",
        "fem": "modal|optimize|update",
        "modal": "optimize|update",
    }
    for folder, others in forbidden.items():
        sources = list((core / folder).rglob("*.rs"))
        assert sources, folder
        for source in sources:
            code = "\n".join(line for line in source.read_text().splitlines() if "//" not in line)
            assert not re.search(rf"\bcrate::({others})\b", code), f"{folder}/{source.name}"
    package = ROOT / "python/antires_rs"
    for folder in ("signals", "rational", "order_sweep", "data_check", "identification"):
        sources = list((package / folder).rglob("*.py"))
        assert sources, folder
        for source in sources:
            code = source.read_text()
            above = r"^\s*from antires_rs\.(models|updating|optimize|_core)\b"
            assert not re.search(above, code, re.MULTILINE), f"{folder}/{source.name}"


@needs_source
def test_no_source_file_is_too_long():
    folders = ("python", "tests", "reference", "examples", "benchmarks", "rust")
    sources = [
        path
        for folder in folders
        for suffix in ("*.py", "*.rs", "*.pyi")
        for path in (ROOT / folder).rglob(suffix)
    ]
    lengths = {str(path.relative_to(ROOT)): len(path.read_text().splitlines()) for path in sources}
    assert len(lengths) > 50
    assert {name: n for name, n in lengths.items() if n > LONGEST_FILE} == {}
