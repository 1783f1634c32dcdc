"""The documentation keeps its word: its code runs as printed, and every public name has a page."""

import contextlib
import io
import os
import re
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from tests.support.measured_data import DATA, needs_hits, needs_southampton
from tests.support.paths import DOCS, ROOT

pytestmark = pytest.mark.usefixtures("quick_pictures")

#: Pages whose code runs from top to bottom; files.md and the recipes speak of files and packages of others.
PAGES = (
    "start", "identify", "repeats", "series", "monitoring", "model", "fe_codes", "parameters", "damage",
    "stabilization", "limits", "long_runs", "migration",
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


#: The frame of the page on identification without its table.
STIFFNESS = np.array([[17e3, -8e3, 0.0], [-8e3, 16e3, -8e3], [0.0, -8e3, 8e3]])
MASS = np.diag([0.5, 0.5, 0.4])
FOUND = {  #: What the text beside the code says comes out.
    "start": lambda n: n["damage"].damaged == [4] and sum(map(len, n["zeros"].values())) == 28,
    "parameters": lambda n: n["damage"].damaged == [4] and n["both"].identifiability.rank == 14,
    "identify": lambda n: np.allclose(  # the frame on a table that is held
        n["on_table"]["ground"], np.sqrt(scipy.linalg.eigvalsh(STIFFNESS, MASS)) / (2 * np.pi), rtol=0.01
    ),
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


@needs_hits
def test_the_first_hour_with_a_hammer_runs_as_printed(tmp_path, monkeypatch, capsys):
    from antires_rs.app.main import main

    monkeypatch.chdir(tmp_path)
    for file in (DATA / "frame3_hits").glob("*.CSV"):
        shutil.copy(file, tmp_path)
    names = {}
    warnings.simplefilter("ignore", ar.AntiresWarning)
    text = (DOCS / "hammer.md").read_text("utf-8")
    for language, block in re.findall(r"```(python|console|toml)\n(.*?)```", text, re.DOTALL):
        if language == "python":
            exec(compile(block, "hammer.md", "exec"), names)
        elif language == "toml":
            Path("storey.toml").write_text(block, encoding="utf-8")
        for line in block.splitlines() if language == "console" else ():
            prompt, program, *arguments = line.split()
            assert (prompt, program) == ("$", "antires")
            if arguments[0] != "look":  # which waits for its page to be closed
                assert main(arguments) == 0, capsys.readouterr().err
    measured = ar.AntiresonanceSet.load("floor2.json")
    assert [np.abs(measured["CH3"] / hz - 1.0).min() < 0.03 for hz in (5.8, 10.2)] == [True, True]
    intact = ar.AntiresonanceSet.load("intact.json")
    frame = ar.MassSpringChain([4.0, 4.0, 3.5], [12e3, 11e3], ground_first_n_per_m=14e3)
    np.testing.assert_allclose(intact[1], frame.antiresonances(1, 1), rtol=0.005)
    assert ar.compare(names["known"], names["zeros"]).different
    said = capsys.readouterr().out
    assert "hit_10.csv: ALARM" in said
    assert "hit_11.csv: ALARM" in said
    damage = ar.DamageResult.load("storey_results/result.npz")
    assert damage.damaged == [2]
    assert damage.severity[2] == pytest.approx(0.2, abs=0.01)


def names_of(listing):
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


def test_the_pages_are_read_without_a_warning(tmp_path):
    """All but their writing as HTML: `make docs` does it, and runs the gallery, as test_examples.py does."""
    modules = "sphinx pydata_sphinx_theme sphinx_gallery numpydoc myst_parser matplotlib"
    for module in modules.split():
        pytest.importorskip(module)
    made = shutil.ignore_patterns("_build", "generated", "backreferences")
    for folder in ("docs", "examples"):
        shutil.copytree(DOCS.parent / folder, tmp_path / folder, ignore=made)
    shutil.rmtree(tmp_path / "docs" / "gallery", ignore_errors=True)
    options = ["-q", "-W", "--keep-going", "-D", "plot_gallery=0"]
    call = [sys.executable, "-m", "sphinx", *options, "-b", "dummy", "docs", "built"]
    env = os.environ | {"MPLBACKEND": "Agg"}
    build = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, env=env, check=False)
    assert build.returncode == 0, build.stderr
    assert (tmp_path / "docs" / "api" / "generated" / "antires_rs.update.rst").exists()


# -- README
README = (ROOT / "README.md").read_text(encoding="utf-8")
STUDIES = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")


def test_the_example_runs_as_printed(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 15
    exec(compile(example, "README.md", "exec"), {})
    assert "spring 4" in capsys.readouterr().out


def test_it_stays_short_and_what_it_and_the_page_of_figures_name_is_there():
    assert len(README.split()) <= 900
    named = re.findall(r"\]\((?!https?://)([^)]+)\)", README)
    named += [f"benchmarks/{study}.py" for study in re.findall(r"benchmarks[./](\w+)", STUDIES)]
    named += re.findall(r"(?:examples|tests)/[\w/]+\.py", STUDIES)
    assert [name for name in named if not (ROOT / name).exists()] == []
    # The last column of its tables holds the name of the study.
    named = set(re.findall(r"\| `(\w+)[^`|]*` \|$", README, re.MULTILINE))
    assert named
    assert named <= set(re.findall(r"benchmarks\.(\w+)", STUDIES))
    targets = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(re.findall(r"^make (\w+)", README, re.MULTILINE)) <= set(targets)


# -- The tutorial on a measured frame prints what it says it prints
#: Of a printed figure; the last digit shown is nearer than that.
AS_PRINTED = 5e-3
NUMBER = re.compile(r"-?\d+(?:,\d{3})*(?:\.\d+)?(?:e-?\d+)?")


def blocks():
    """(code, what it prints or None)."""
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    return re.findall(r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", text, re.DOTALL)


def numbers(text):
    return [float(number.replace(",", "")) for number in NUMBER.findall(text)]


@needs_southampton
def test_it_prints_what_the_page_shows(monkeypatch):
    monkeypatch.setenv("ANTIRES_DATA", str(DATA))
    names = {}
    shown = 0
    for code, wanted in blocks():
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed), warnings.catch_warnings():
            warnings.filterwarnings("ignore", ".*antires explain cut_line", ar.AntiresWarning)
            exec(compile(code, "tutorial.md", "exec"), names)
        if not wanted:
            continue
        shown += 1
        found = printed.getvalue()
        assert NUMBER.sub("#", found).split() == NUMBER.sub("#", wanted).split()
        np.testing.assert_allclose(numbers(found), numbers(wanted), rtol=AS_PRINTED, atol=AS_PRINTED)
    assert shown == 8
    assert all(word in (DOCS / "tutorial.md").read_text("utf-8") for word in ("Cristallo", "BSD-3-Clause"))
    assert names["damage"].damaged == [0]
