"""The README keeps its word: its example runs as printed, and what it names is there."""

import re

import pytest

from tests.support.paths import ROOT

pytestmark = pytest.mark.usefixtures("quick_pictures")

README = (ROOT / "README.md").read_text(encoding="utf-8")
STUDIES = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")


def test_the_example_runs_as_printed(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    lines = [line for line in example.splitlines() if line.strip()]
    assert len(lines) <= 15
    exec(compile(example, "README.md", "exec"), {})
    assert "spring 4" in capsys.readouterr().out


def test_every_file_that_it_and_the_page_of_figures_name_exists():
    named = re.findall(r"\]\((?!https?://)([^)]+)\)", README)
    named += [f"benchmarks/{study}.py" for study in re.findall(r"benchmarks[./](\w+)", STUDIES)]
    named += re.findall(r"(?:examples|tests)/[\w/]+\.py", STUDIES)
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_every_study_it_names_is_on_the_page_of_figures():
    """The last column of its tables holds the name of the study."""
    named = set(re.findall(r"\| `(\w+)[^`|]*` \|$", README, re.MULTILINE))
    assert named
    assert named <= set(re.findall(r"benchmarks\.(\w+)", STUDIES))


def test_it_stays_short():
    assert len(README.split()) <= 900


def test_every_make_target_it_names_exists():
    targets = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(re.findall(r"^make (\w+)", README, re.MULTILINE)) <= set(targets)


def test_nothing_is_left_to_fill_in():
    assert not re.search(r"\b(TODO|TBD|[A-Z]+TABLE)\b", README)
