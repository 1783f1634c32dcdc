"""The rules of the house that code can check: arrows between packages, cycles, sizes of files."""

import os
import re
import subprocess
import sys
import tomllib

import pytest

from tests.support.paths import ROOT

PACKAGE = ROOT / "python/antires_rs"
#: Modules of a room, at most.
MOST_MODULES = 30

pytestmark = pytest.mark.skipif(not (ROOT / "Cargo.toml").is_file(), reason="needs the source tree")


def test_every_import_keeps_the_contracts():
    pytest.importorskip("importlinter")
    command = "from importlinter.cli import lint_imports_command as run; run()"
    env = os.environ | {"PYTHONPATH": str(ROOT / "python")}
    done = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, cwd=ROOT, env=env)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 broken" in done.stdout


#: Eigenvalues of many small matrices, which the core finds and which know nothing of models.
LINEAR_ALGEBRA = {"spectra.py"}


def test_the_signal_side_does_not_load_the_core():
    sources = [*(PACKAGE / "signals").rglob("*.py"), *(PACKAGE / "measured").rglob("*.py")]
    core = re.compile(r"^\s*from \.+ import _core\b", re.MULTILINE)
    assert {source.name for source in sources if core.search(source.read_text())} == LINEAR_ALGEBRA


def test_a_room_is_one_folder_of_few_modules():
    rooms = [path for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"]
    assert len(rooms) > 10
    for room in rooms:
        assert len(list(room.glob("*.py"))) <= MOST_MODULES, room.name
        assert not [path for path in room.rglob("*.py") if path.parent != room], room.name


def test_the_core_knows_neither_python_nor_numpy():
    manifest = tomllib.loads((ROOT / "rust/antires-core/Cargo.toml").read_text())
    for section in ("dependencies", "dev-dependencies", "build-dependencies"):
        assert not {"pyo3", "numpy", "pyo3-ffi"} & set(manifest.get(section, {}))
    sources = list((ROOT / "rust/antires-core/src").rglob("*.rs"))
    assert sources
    for source in sources:
        assert not re.search(r"^\s*use (pyo3|numpy)\b", source.read_text(), re.MULTILINE), source.name
