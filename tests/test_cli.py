"""The command line: exit codes, streams, and the demo end to end."""

import json
import os
import signal
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import antires_rs as ar
from antires_rs import cli, demo

FILES = {"stabilization.png", "transmissibility.png", "differences.png", "damage.png", "convergence.png",
         "updating.html", "damage.html", "summary.json"}


def test_version_and_help_leave_with_0(capsys):
    for arguments, said in ((["--version"], f"antires {ar.__version__}"), (["--help"], "demo"),
                            (["demo", "--help"], "--noise")):
        with pytest.raises(SystemExit) as caught:
            cli.main(arguments)
        assert caught.value.code == 0
        assert said in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [
    [], ["fly"], ["demo", "--seed", "-1"], ["demo", "--seed", "1.5"], ["demo", "--noise", "nan"],
    ["demo", "--noise", "2"], ["demo", "--workers", "0"], ["demo", "--fast"]])
def test_wrong_usage_leaves_with_2_and_explains(capsys, arguments):
    with pytest.raises(SystemExit) as caught:
        cli.main(arguments)
    assert caught.value.code == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "error:" in err


@pytest.mark.parametrize(("raised", "code", "said"), [
    (ar.UnsuitableDataError("source: got nothing"), 1, "antires: error: source: got nothing"),
    (PermissionError(13, "denied", "here"), 1, "denied"),
    (KeyboardInterrupt(), 130, "interrupted")])
def test_failures_become_exit_codes_without_traceback(monkeypatch, capsys, raised, code, said):
    def fail(*args, **options):
        raise raised
    monkeypatch.setattr(demo, "command", fail)
    assert cli.main(["demo"]) == code
    err = capsys.readouterr().err
    assert said in err
    assert "Traceback" not in err


def test_bugs_are_not_hidden(monkeypatch):
    monkeypatch.setattr(demo, "command", lambda *args, **options: [][1])
    with pytest.raises(IndexError):
        cli.main(["demo"])


def test_a_file_in_the_way_is_a_failed_run(tmp_path, capsys):
    (tmp_path / "taken").write_text("")
    assert cli.main(["demo", "--out", str(tmp_path / "taken")]) == 1
    assert "taken" in capsys.readouterr().err


def test_help_does_not_load_the_pictures():
    code = ("import sys; from antires_rs.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
            "print({'matplotlib', 'jinja2', 'scipy.signal', 'antires_rs.demo'} & set(sys.modules))")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "set()"


def test_demo_tells_the_story_and_writes_the_files(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(demo, "MAX_EVALUATIONS", 20_000)
    out = tmp_path / "new" / "folder"
    assert cli.main(["demo", "--out", str(out), "--seed", "1", "--workers", "2"]) == 0
    assert set(os.listdir(out)) == FILES
    said, progress = capsys.readouterr()
    assert "28     28      0" in said
    assert "largest difference:" in said
    assert "updating 15 parameters" in progress
    assert "updating 15 parameters" not in said
    last = said.rstrip().splitlines()[-2:]
    assert str(out / "damage.html") in last[0]
    assert str(out / "summary.json") in last[1]
    numbers = json.loads((out / "summary.json").read_text())
    assert numbers["updating"]["evaluations"] <= 20_000
    assert numbers["updating"]["largest_after_percent"] < 0.58  # the paper's bar
    assert [name for name, beta in numbers["damage"]["severity"].items() if beta > 0] == ["spring 5"]
    assert numbers["damage"]["severity"]["spring 5"] == pytest.approx(0.55, abs=0.02)
    assert f"{100 * numbers['damage']['severity']['spring 5']:.1f}" in said
    assert "Spring 5 has lost" in (out / "damage.html").read_text()


def test_demo_without_matplotlib_still_gives_the_numbers_as_json(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(demo, "MAX_EVALUATIONS", 3000)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert cli.main(["demo", "--out", str(tmp_path), "--json", "--noise", "0"]) == 0
    said, progress = capsys.readouterr()
    assert json.loads(said)["noise"] == 0.0
    assert said == (tmp_path / "summary.json").read_text()
    assert 'pip install "antires-rs[plot]"' in progress
    assert os.listdir(tmp_path) == ["summary.json"]


def test_comparison_with_the_truth_counts_found_and_false():
    found = ar.AntiresonanceSet(0, {0: [10.1, 20.0, 20.1, 50.0], 1: []})
    first, second = demo.compare(found, {0: np.array([10.0, 20.08, 30.0]), 1: np.empty(0)})
    assert (first.true, first.found, first.false) == (3, 2, 2)
    assert first.largest_percent == pytest.approx(1.0)
    assert (second.true, second.found, second.false, second.largest_percent) == (0, 0, 0, None)


def test_the_pipeline_never_asks_for_the_truth(monkeypatch):
    def forbidden(self, level=0):
        raise AssertionError("the truth was used")
    monkeypatch.setattr(ar.cases.Chain8, "truth", forbidden)
    monkeypatch.setattr(ar.cases.Chain8, "exact", forbidden)
    story = demo.tell(noise=0.0, max_evaluations=2000, workers=1)
    assert story.damage.damaged[0] == 4


def test_an_interrupted_search_ends_the_demo(monkeypatch):
    exact = ar.cases.chain8().exact(0)
    monkeypatch.setattr(demo, "identify_antiresonances", lambda *args, **options: exact)
    monkeypatch.setattr(demo, "update", lambda *args, **options: SimpleNamespace(status="interrupted"))
    with pytest.raises(KeyboardInterrupt):
        demo.tell()


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_leaves_with_130_and_one_line(tmp_path):
    # Where the tests themselves run in the background, SIGINT is ignored, and children inherit that.
    code = ("import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
            "from antires_rs.cli import main; sys.exit(main(['demo', '--out', sys.argv[1]]))")
    with subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as run:
        for line in run.stderr:
            if line.startswith("updating"):
                run.send_signal(signal.SIGINT)
                break
        out, err = run.communicate(timeout=30)
    assert run.returncode == 130
    assert err.splitlines()[-1] == "antires: interrupted"
    assert "Traceback" not in err
    assert out == ""
