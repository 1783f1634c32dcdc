"""ARCHITECTURE.md is the map: 900 words, a line a room, files that exist; and its index of first lines."""

import ast
import os
import re
import subprocess
import sys
import tomllib
from functools import cache

import pytest

from tests.support.paths import ROOT

MAP = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
INDEX = ROOT / "docs" / "house.md"
FACE = ROOT / "python" / "antires_rs"
CORE = ROOT / "rust" / "antires-core" / "src"
BINDING = ROOT / "rust" / "antires-py" / "src"
PLACES = [FACE, CORE, ROOT / "rust", ROOT]


def folders(root):
    return sorted(path.name for path in root.iterdir() if path.is_dir() and path.name != "__pycache__")


@cache
def first_line(path):
    """What a file says of itself in its first line, None if it says nothing."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".rs":
        return next((line[3:].strip() for line in text.splitlines() if line.startswith("//!")), None)
    doc = ast.get_docstring(ast.parse(text))
    return doc.split("\n\n")[0].replace("\n", " ") if doc else None


def files(root, ending):
    own = sorted(root.glob(f"*.{ending}"))
    yield from ((root.name, path) for path in own)
    for room in folders(root):
        inside = sorted((root / room).rglob(f"*.{ending}"))
        yield from ((room, path) for path in inside if path.stem != "tests")


def index():
    """The page docs/house.md."""
    said = "Made of the first lines of all files, by `pytest tests/package/test_architecture.py` with\n"
    said += "`ANTIRES_SNAPSHOTS=write` in the environment."
    more = "ARCHITECTURE.md, beside the README, says how the rooms hang together."
    lines = ["# The house, file by file", "", said, more]
    for root, ending in ((FACE, "py"), (CORE, "rs"), (BINDING, "rs")):
        lines += ["", f"## {root.relative_to(ROOT).as_posix()}"]
        room = None
        for name, path in files(root, ending):
            if name != room:
                room = name
                lines += ["", f"### {name}", "", "| file | what it is |", "|---|---|"]
            said = (first_line(path) or "").replace("|", "\\|")
            lines.append(f"| `{path.relative_to(root).as_posix()}` | {said} |")
    return "\n".join(lines) + "\n"


def test_it_has_900_words_a_line_for_every_room_and_module_and_paths_that_exist():
    assert len(MAP.split()) <= 900
    for title, root in (("Rooms of the package", FACE), ("Modules of the core", CORE)):
        text = MAP.split(f"\n## {title}\n")[1].split("\n## ")[0]
        assert [name for name in folders(root) if f"\n| `{name}` | " not in text] == []
    named = set(re.findall(r"`([\w/-]+/[\w.-]+)`", MAP))
    assert [name for name in named if not any((place / name).exists() for place in PLACES)] == []


@pytest.mark.parametrize(("root", "ending"), [(FACE, "py"), (CORE, "rs")], ids=["python", "core"])
def test_every_file_says_what_it_is_as_no_other_does(root, ending):
    said = {}
    for _, path in files(root, ending):
        line = first_line(path)
        assert line, f"{path.relative_to(root)} has no first line"
        assert said.setdefault(line, path) == path, f"{path} and {said[line]} say the same: {line}"


def test_the_index_is_made_of_the_first_lines():
    if os.environ.get("ANTIRES_SNAPSHOTS") == "write":
        INDEX.write_text(index(), encoding="utf-8")
    assert INDEX.read_text(encoding="utf-8") == index()


# -- Rules of the house that code can check: arrows between packages, cycles, sizes of rooms
MOST_MODULES = 30  #: Modules of a room, at most.

pytestmark = pytest.mark.skipif(not (ROOT / "Cargo.toml").is_file(), reason="needs the source tree")


def test_every_import_keeps_the_contracts():
    pytest.importorskip("importlinter")
    command = "from importlinter.cli import lint_imports_command as run; run()"
    env = os.environ | {"PYTHONPATH": str(ROOT / "python")}
    done = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, cwd=ROOT, env=env)
    assert (done.returncode, "0 broken" in done.stdout) == (0, True), done.stdout + done.stderr


def test_the_signal_side_does_not_load_the_core():
    """But for eigenvalues of many small matrices, which know nothing of models."""
    sources = [*(FACE / "signals").rglob("*.py"), *(FACE / "measured").rglob("*.py")]
    core = re.compile(r"^\s*from \.+ import _core\b", re.MULTILINE)
    assert {source.name for source in sources if core.search(source.read_text())} == {"spectra.py"}


def test_a_room_is_one_folder_of_few_modules():
    assert len(folders(FACE)) > 10
    for room in map(FACE.joinpath, folders(FACE)):
        assert len(list(room.glob("*.py"))) <= MOST_MODULES, room.name
        assert not [path for path in room.rglob("*.py") if path.parent != room], room.name


def test_the_core_knows_neither_python_nor_numpy():
    manifest = tomllib.loads((ROOT / "rust/antires-core/Cargo.toml").read_text())
    for section in ("dependencies", "dev-dependencies", "build-dependencies"):
        assert not {"pyo3", "numpy", "pyo3-ffi"} & set(manifest.get(section, {}))
    sources = list(CORE.rglob("*.rs"))
    assert sources
    for source in sources:
        assert not re.search(r"^\s*use (pyo3|numpy)\b", source.read_text(), re.MULTILINE), source.name
