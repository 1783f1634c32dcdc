"""The README keeps its word: its example runs as printed, and what it names is there."""

import re

import pytest

from tests.support.paths import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_examples_run_as_printed(capsys):
    first, second = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    lines = [line for line in first.splitlines() if line.strip()]
    assert len(lines) <= 15
    names = {}
    exec(compile(first, "README.md", "exec"), names)
    assert "spring 5" in capsys.readouterr().out
    exec(compile(second, "README.md", "exec"), names)


@pytest.mark.parametrize("target", sorted(set(re.findall(r"\]\((?!https?://)([^)]+)\)", README))))
def test_every_file_it_links_to_exists(target):
    assert (ROOT / target).exists()


@pytest.mark.parametrize("script", sorted(set(re.findall(r"benchmarks[./](\w+)", README))))
def test_every_benchmark_it_names_exists(script):
    assert (ROOT / "benchmarks" / f"{script}.py").exists()


@pytest.mark.parametrize("target", sorted(set(re.findall(r"^make (\w+)", README, re.MULTILINE))))
def test_every_make_target_it_names_exists(target):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert re.search(rf"^{target}:", makefile, re.MULTILINE)


def test_nothing_is_left_to_fill_in():
    assert not re.search(r"\b(TODO|TBD|[A-Z]+TABLE)\b", README)
