"""The documentation keeps its word: its code runs as printed, and every public name has a page."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import antires_rs as ar
from tests.support.paths import DOCS

pytestmark = pytest.mark.usefixtures("quick_pictures")

#: Pages whose code runs from top to bottom; files.md and the recipes speak of files and packages of others.
PAGES = (
    "start", "identify", "repeats", "series", "monitoring", "model", "parameters", "damage", "stabilization",
    "limits", "long_runs", "migration",
)  # fmt: skip


@pytest.mark.parametrize("page", PAGES)
def test_the_code_of_a_page_runs(page, tmp_path, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (DOCS / f"{page}.md").read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    names = {}
    for number, block in enumerate(blocks, start=1):
        exec(compile(block, f"{page}.md, block {number}", "exec"), names)
    pyplot.close("all")
    if page in FOUND:
        assert FOUND[page](names)


#: What the text beside the code says comes out.
FOUND = {
    "start": lambda n: n["damage"].damaged == [4] and sum(map(len, n["zeros"].values())) == 28,
    "parameters": lambda n: n["damage"].damaged == [4] and n["both"].identifiability.rank == 14,
    "damage": lambda n: (
        n["damage"].damaged == n["watched"].damaged == [4] and "spring 4" in n["damage"].headline
    ),
    "limits": lambda n: n["result"].identifiability.rank == 13 and 0.09 < n["damage"].detectable[0] < 0.11,
    "long_runs": lambda n: n["result"].status == "budget" and Path("run.html").is_file(),
}


def test_the_steps_on_the_command_line_run(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib").use("Agg")
    pytest.importorskip("pyuff")
    pytest.importorskip("jinja2")
    from antires_rs.app.main import main

    monkeypatch.chdir(tmp_path)
    text = (DOCS / "jobs.md").read_text(encoding="utf-8")
    for language, block in re.findall(r"```(python|console|toml)\n(.*?)```", text, re.DOTALL):
        if language == "python":
            exec(compile(block, "jobs.md", "exec"), {})
        elif language == "toml":
            Path("job.toml").write_text(block, encoding="utf-8")
        else:
            for line in block.splitlines():
                prompt, program, *arguments = line.split()
                assert (prompt, program) == ("$", "antires")
                assert main(arguments) == 0, capsys.readouterr().err
    assert ar.AntiresonanceSet.load("zeros.json").excitation == 0
    assert ar.DamageResult.load("job_results/result.npz").damaged == [4]
    written = {path.name for path in Path("job_results").iterdir()}
    assert {"report.html", "result.npz", "antiresonances.json", "summary.json", "run.json"} <= written


def names_of(listing):
    """What the autosummary tables of a page list."""
    tables = re.findall(r"\.\. autosummary::\n(?:   :.*\n)*\n((?:   [\w.]+\n)+)", listing)
    return [name.strip() for table in tables for name in table.splitlines()]


def test_every_public_name_and_picture_is_in_the_reference_once():
    pytest.importorskip("matplotlib")
    from antires_rs import figures

    listed = names_of((DOCS / "api/index.rst").read_text(encoding="utf-8"))
    assert set(ar.__all__) - {"__version__"} | {f"figures.{name}" for name in figures.__all__} <= set(listed)
    assert len(listed) == len(set(listed))


@pytest.mark.parametrize("page", sorted(p.name for p in DOCS.glob("*.md")))
def test_what_a_page_links_to_is_there(page):
    text = (DOCS / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?://|#)([^)#]+)\)", text):
        made = target.startswith("gallery/")
        source = DOCS / target if not made else DOCS.parent / "examples" / target.replace(".rst", ".py")
        assert source.exists() or target == "gallery/index.rst", target


def test_the_pages_are_built_without_a_warning(tmp_path):
    """The gallery is not executed here: test_gallery.py does that."""
    for module in (
        "sphinx",
        "pydata_sphinx_theme",
        "sphinx_gallery",
        "numpydoc",
        "myst_parser",
        "matplotlib",
    ):
        pytest.importorskip(module)
    made = shutil.ignore_patterns("_build", "generated", "backreferences")
    for folder in ("docs", "examples"):
        shutil.copytree(DOCS.parent / folder, tmp_path / folder, ignore=made)
    shutil.rmtree(tmp_path / "docs" / "gallery", ignore_errors=True)
    build = subprocess.run(
        [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-D", "plot_gallery=0", "docs", "html"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env=os.environ | {"MPLBACKEND": "Agg"},
        check=False,
    )
    assert build.returncode == 0, build.stderr
    assert (tmp_path / "html" / "index.html").stat().st_size > 1000
    assert (tmp_path / "html" / "api" / "generated" / "antires_rs.update.html").exists()
