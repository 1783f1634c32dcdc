"""Ctrl-C, SIGKILL and resume of jobs, on the command line as a user has it."""

import json
import os
import signal
import subprocess
import sys

import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from antires_rs.damage import assess as damage_result
from antires_rs.updating import result as results
from tests.support.campaign import some_of
from tests.support.job_files import DAMAGE, UPDATE, write_measured
from tests.support.paths import ROOT
from tests.support.signalled import ANTIRES, LONG, interrupt_assessments, stopped
from tests.support.tolerances import INTERRUPT_S

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals as sent here are POSIX")

ENDLESS = UPDATE.replace(
    "seed = 1", "seed = 3\npatience = 1_000_000_000\npolish = false\nmax_evaluations = 1_000_000_000_000"
)

FILES = {"antiresonances.json", "result.npz", "run.json", "summary.json"}


def names_in(folder):
    return {path.name for path in folder.iterdir()}


def bytes_of(file):
    result = ar.UpdateResult.load(file)
    search, history = result.search, result.search.history
    arrays = (search.x, history.cost, history.nfev, history.migrations, search.populations)
    numbers = (search.fun.hex(), search.nfev, search.nit, search.status, result.seed)
    return [*(a.tobytes() for a in arrays), *numbers]


def fill(folder, text):
    write_measured(folder, level=0, perturbation=0.08)
    (folder / "job.toml").write_text(text)
    return folder / "job_results"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    results = fill(folder, LONG)
    assert cli.main(["update", str(folder / "job.toml")]) == 0
    assert not (results / "search.ckpt").exists()
    return bytes_of(results / "result.npz")


def test_ctrl_c_hands_back_the_best_so_far_and_a_checkpoint(tmp_path, capsys):
    results = fill(tmp_path, ENDLESS)
    code, out, err, took = stopped(tmp_path, signal.SIGINT, "update", "job.toml")
    assert code == 130
    assert took < INTERRUPT_S
    assert err == "antires: interrupted, the best so far is kept; go on with: antires resume job.toml\n"
    assert "interrupted" in out.splitlines()[0]
    assert names_in(results) == FILES | {"search.ckpt"}
    summary = json.loads((results / "summary.json").read_text())
    best = ar.UpdateResult.load(results / "result.npz")
    assert summary["status"] == best.status == "interrupted"
    assert summary["J"] == best.fun == best.problem.cost(best.x)
    capsys.readouterr()
    assert cli.main(["update", str(tmp_path / "job.toml")]) == 2
    assert "antires resume job.toml" in capsys.readouterr().err
    code, _, _, took = stopped(tmp_path, signal.SIGINT, "resume", "job.toml")
    assert code == 130
    assert took < INTERRUPT_S
    assert ar.UpdateResult.load(results / "result.npz").nit > best.nit
    finished = (tmp_path / "job.toml").read_text().replace("1_000_000_000_000", "2000")
    (tmp_path / "job.toml").write_text(finished)
    assert cli.main(["resume", str(tmp_path / "job.toml")]) == 2  # another budget is another search
    assert "another problem, data or options" in capsys.readouterr().err
    assert cli.main(["update", str(tmp_path / "job.toml"), "--fresh"]) == 0
    assert not (results / "search.ckpt").exists()


def test_what_takes_time_is_not_computed_after_ctrl_c(tmp_path, monkeypatch, capsys):
    write_measured(tmp_path)
    (tmp_path / "job.toml").write_text(DAMAGE.replace("seed = 1", "seed = 1\ncheckpoint = false"))

    def slow(*args):
        raise AssertionError("computed")

    interrupt_assessments(monkeypatch)
    monkeypatch.setattr(damage_result, "smallest_visible", slow)
    monkeypatch.setattr(results, "at_solution", slow)
    assert cli.main(["damage", str(tmp_path / "job.toml")]) == 130
    captured = capsys.readouterr()
    out = captured.out
    assert "without a checkpoint" in captured.err
    assert cli.main(["resume", str(tmp_path / "job.toml")]) == 2
    assert "was stopped and kept no checkpoint" in capsys.readouterr().err
    assert "spring 4   55.00 %" in out
    assert "the best so far" in out
    summary = json.loads((tmp_path / "job_results" / "summary.json").read_text())
    assert {row["smallest_visible"] for row in summary["elements"]} == {None}


def test_a_resumed_job_has_the_bits_of_one_that_was_never_stopped(tmp_path, whole, capsys):
    results = fill(tmp_path, LONG)
    code, _, err, _ = stopped(tmp_path, signal.SIGINT, "update", "job.toml", after=0.1)
    assert code == 130, err
    assert cli.main(["resume", str(tmp_path / "job.toml"), "--workers", "2"]) == 0
    assert bytes_of(results / "result.npz") == whole
    assert names_in(results) == FILES
    capsys.readouterr()
    assert cli.main(["resume", str(tmp_path / "job.toml"), "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["status"] == json.loads((results / "run.json").read_text())["state"]
    assert "has finished" in err


def test_a_time_limit_leaves_a_search_to_go_on_with(tmp_path, whole, capsys):
    results = fill(tmp_path, LONG.replace("seed = 3", "seed = 3\nmax_seconds = 0.2"))
    assert cli.main(["update", str(tmp_path / "job.toml")]) == 0
    assert "out of time; go on with: antires resume" in capsys.readouterr().err
    (tmp_path / "job.toml").write_text(LONG)
    assert cli.main(["resume", str(tmp_path / "job.toml")]) == 0
    assert bytes_of(results / "result.npz") == whole


def test_changed_data_are_not_taken_for_those_of_the_search(tmp_path, capsys):
    results = fill(tmp_path, LONG.replace("seed = 3", "seed = 3\nmax_seconds = 0.1"))
    assert cli.main(["update", str(tmp_path / "job.toml")]) == 0
    before = (results / "search.ckpt").read_bytes()
    write_measured(tmp_path, level=1)
    assert cli.main(["resume", str(tmp_path / "job.toml")]) == 1
    assert "got measured.json, changed since the search began" in capsys.readouterr().err
    assert (results / "search.ckpt").read_bytes() == before


def test_ctrl_c_before_the_search_says_so_in_one_line(tmp_path):
    record = ar.cases.chain8().experiment(0, duration_s=256.0, rng=0)
    ar.write_npz(tmp_path / "record.npz", record)
    code = ANTIRES.replace(
        "from antires_rs.app.main import main",
        """
import antires_rs.app.reading as m
identify = m.identify_antiresonances
def announced(*args, **options):
    open("job_results/run.json", "w").write("searching")
    return identify(*args, **options)
m.identify_antiresonances = announced
from antires_rs.app.main import main""",
    )
    (tmp_path / "job_results").mkdir()
    data = 'file = "record.npz"\nexcitation = 0\nband_hz = [3, 130]'
    (tmp_path / "job.toml").write_text(LONG.replace('file = "measured.json"', data))
    exit_code, out, err, took = stopped(tmp_path, signal.SIGINT, "update", "job.toml", after=0.05, code=code)
    assert (exit_code, out, err) == (130, "", "antires: interrupted\n")
    assert took < INTERRUPT_S


# -- A kill at any point in the life of a run; benchmarks/kill_study.py kills at random times
@pytest.mark.parametrize(
    ("scenario", "writing"),
    some_of([("again", "half"), ("new", "half"), ("again", "whole"), ("fresh", "whole"), ("script", "half")]),
)
def test_killed_before_any_change_on_the_disk(tmp_path, scenario, writing):
    """Half: what was being written has lost its second half, as after a power cut."""
    call = [sys.executable, "-m", "tests.support.kill_points", tmp_path, scenario, writing]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["points"] >= (15 if scenario == "script" else 35)
    assert found["wrong"] == {}


def test_what_another_process_is_writing_to_the_same_file_is_left_alone(tmp_path):
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as other:
        lives = tmp_path / f".zeros.json.{other.pid}.tmp"
        lives.write_text("half")
        (tmp_path / ".zeros.json.tmp").write_text("someone's")
        write_measured(tmp_path)
        zeros = ar.AntiresonanceSet.load(tmp_path / "measured.json")
        zeros.save(tmp_path / "zeros.json")
        assert lives.exists()
        other.communicate(b"\n")
    zeros.save(tmp_path / "zeros.json")
    assert names_in(tmp_path) == {".zeros.json.tmp", "measured.json", "zeros.json"}
