"""A kill at any point in the life of a run: it goes on to the same files, and leaves none of its own.

Here before every single change on the disk; benchmarks/kill_study.py kills at random times.
"""

import json
import os
import signal
import subprocess
import sys

import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from tests.support.campaign import some_of
from tests.support.job_files import write_measured
from tests.support.paths import ROOT
from tests.support.signalled import LONG, stopped

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and SIGKILL")


@pytest.mark.parametrize(
    ("scenario", "writing"),
    some_of(
        [("new", "half"), ("again", "whole"), ("fresh", "whole"), ("script", "half")], kept=[("new", "half")]
    ),
)
def test_killed_before_any_change_on_the_disk(tmp_path, scenario, writing):
    """Half: what was being written has lost its second half, as after a power cut."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.kill_points", tmp_path, scenario, writing],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["points"] >= (15 if scenario == "script" else 35)
    assert found["wrong"] == {}


def test_killed_before_its_first_checkpoint_a_job_begins_again_with_resume(tmp_path, capsys):
    """Though results of an earlier job stand there, which are not what it was asked for."""
    write_measured(tmp_path, level=0, perturbation=0.08)
    results, job = tmp_path / "job_results", tmp_path / "job.toml"
    job.write_text(LONG.replace("60_000", "600"))
    assert cli.main(["update", str(job)]) == 0
    job.write_text(LONG)
    assert stopped(tmp_path, signal.SIGKILL, "update", "job.toml", after=0.05)[0] == -signal.SIGKILL
    assert not (results / "search.ckpt").exists()  # it is written after two seconds
    capsys.readouterr()
    assert cli.main(["resume", str(job)]) == 0
    assert capsys.readouterr().err == ""
    assert ar.UpdateResult.load(results / "result.npz").nfev == 60_000


def test_what_another_process_is_writing_to_the_same_file_is_left_alone(tmp_path):
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as other:
        lives = tmp_path / f".zeros.json.{other.pid}.tmp"
        lives.write_text("half")
        unrelated = tmp_path / ".zeros.json.tmp"
        unrelated.write_text("someone's")
        write_measured(tmp_path)
        zeros = ar.AntiresonanceSet.load(tmp_path / "measured.json")
        zeros.save(tmp_path / "zeros.json")
        assert lives.exists()
        other.communicate(b"\n")
    zeros.save(tmp_path / "zeros.json")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        ".zeros.json.tmp",
        "measured.json",
        "zeros.json",
    ]
