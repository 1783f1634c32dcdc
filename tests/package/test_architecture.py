"""ARCHITECTURE.md is the map of what is there: every room has its line, every file it names exists."""

import re

import pytest

from tests.support.paths import ROOT

MAP = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
FACE = ROOT / "python" / "antires_rs"
CORE = ROOT / "rust" / "antires-core" / "src"
BINDING = ROOT / "rust" / "antires-py" / "src"
ROOTS = {"py": FACE, "core": CORE, "binding": BINDING}


def section(title):
    """Text under a heading of second order."""
    return MAP.split(f"\n## {title}\n")[1].split("\n## ")[0]


def rooms(folder):
    return sorted(path.name for path in folder.iterdir() if path.is_dir() and path.name != "__pycache__")


@pytest.mark.parametrize("room", rooms(FACE))
def test_every_package_has_a_line(room):
    assert f"\n| `{room}/` | " in section("Rooms of python/antires_rs")


@pytest.mark.parametrize("room", rooms(CORE))
def test_every_module_of_the_core_has_a_line(room):
    assert f"\n| `{room}/` | " in section("Rooms of rust/antires-core/src")


def named():
    """Files of the table of changes, each under the root that the word before it names."""
    for line in section("Where a change goes").splitlines():
        if not line.startswith("| ") or line.startswith("| change"):
            continue
        root = None
        for word, token in re.findall(r"\b(py|core|binding)\b|`([^`]+)`", line.split("|")[2]):
            root = ROOTS[word] if word else root
            if token and "NAME" not in token and re.search(r"\.(py|rs)$", token):
                yield root / token


def test_the_table_of_changes_names_files():
    assert len(list(named())) >= 20


@pytest.mark.parametrize("file", sorted(set(named())), ids=lambda file: str(file.relative_to(ROOT)))
def test_every_file_of_the_table_of_changes_exists(file):
    assert file.is_file()


@pytest.mark.parametrize(
    "name", sorted(set(re.findall(r"`([a-z_]+)`", section("Rooms of python/antires_rs"))))
)
def test_every_module_of_a_room_exists(name):
    fields = {"argument", "got", "wanted", "remedy", "data_of", "antires"}
    assert name in fields or any(FACE.glob(f"*/**/{name}.py"))


@pytest.mark.parametrize("path", sorted(set(re.findall(r"`([a-z_]+/[\w/]+\.py)`", section("Three walks")))))
def test_every_file_of_the_walks_exists(path):
    assert (FACE / path).is_file()


def test_it_is_read_in_ten_minutes():
    assert len(MAP.splitlines()) <= 250
