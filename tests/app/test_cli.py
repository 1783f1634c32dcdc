"""The command line: exit codes, streams, and the demo end to end."""

import contextlib
import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app import demo, main as cli
from antires_rs.app.parser import COMMANDS
from tests.support import four_masses
from tests.support.job_files import DAMAGE, write_measured

pytestmark = pytest.mark.usefixtures("quick_pictures")
PICTURES = ("stabilization", "response", "differences", "damage", "convergence")


def test_failures_become_exit_codes_without_traceback_and_bugs_are_not_hidden(tmp_path, monkeypatch, capsys):
    (tmp_path / "taken").write_text("")
    assert cli.main(["demo", "--out", str(tmp_path / "taken")]) == 1
    err = capsys.readouterr().err
    assert "taken" in err
    assert "Traceback" not in err
    monkeypatch.setattr(demo, "demo", lambda args: bytearray(2**62))
    assert cli.main(["demo"]) == 1
    assert capsys.readouterr().err == "antires: error: there is not enough memory.\n"
    monkeypatch.setattr(demo, "demo", lambda args: [][1])
    with pytest.raises(IndexError):
        cli.main(["demo"])


def test_demo_tells_the_story_and_writes_the_files(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(demo, "MAX_EVALUATIONS", 20_000)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    out = tmp_path / "new" / "folder"
    assert cli.main(["demo", "--out", str(out), "--seed", "1", "--workers", "2"]) == 0
    pictures = {f"{name}.png" for name in PICTURES}
    assert set(os.listdir(out)) == pictures | {"updating.html", "damage.html", "summary.json"}
    said, progress = capsys.readouterr()
    assert said.count("28 of 28 antiresonances found, 0 false") == 2
    assert "largest difference:" in said
    assert "updating 15 parameters" in progress
    assert "updating 15 parameters" not in said
    last = said.rstrip().splitlines()[-2:]
    assert str(out / "damage.html") in last[0]
    assert str(out / "summary.json") in last[1]
    numbers = json.loads((out / "summary.json").read_text())
    assert numbers["updating"]["evaluations"] <= 20_000
    assert numbers["updating"]["largest_after_percent"] < 0.58  # the paper's bar
    assert "Damage: spring 4 has lost" in (out / "damage.html").read_text()
    found = numbers["damage"]
    assert [name for name, beta in found["severity"].items() if beta > 0] == ["spring 4"]
    assert found["severity"]["spring 4"] == pytest.approx(0.55, abs=0.005)
    assert found["probability"]["spring 4"] > 0.99
    assert found["headline"].startswith("Damage: spring 4 has lost")
    assert " ".join(found["headline"].split()) in " ".join(said.split())


def test_demo_without_matplotlib_still_gives_the_numbers_as_json(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(demo, "MAX_EVALUATIONS", 3000)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert cli.main(["demo", "--out", str(tmp_path), "--json", "--noise", "0"]) == 0
    said, progress = capsys.readouterr()
    assert json.loads(said)["noise"] == 0.0
    assert said == (tmp_path / "summary.json").read_text()
    assert "updating" not in progress  # no terminal, no progress
    assert 'pip install "antires-rs[plot]"' in progress
    assert os.listdir(tmp_path) == ["summary.json"]


def test_help_lists_every_command_and_is_quick(capsys):
    def said(*call):
        with pytest.raises(SystemExit) as caught:
            cli.main(call)
        assert caught.value.code == 0
        return capsys.readouterr().out

    assert said("--version") == f"antires {ar.__version__}\n"
    for command in COMMANDS:
        assert f"\n    {command} " in said("--help")
        assert said(command, "--help").startswith(f"usage: antires {command}")


def test_identify_prints_saves_and_draws(tmp_path, monkeypatch, capsys):
    record = four_masses.record()
    named = ar.Recording(record.responses, record.fs_hz, [f"a{dof}" for dof in record.dofs])
    ar.write_csv(tmp_path / "record.csv", named)
    monkeypatch.chdir(tmp_path)
    call = ["identify", "record.csv", "--band", *map(str, four_masses.BAND), "--max-order", "30"]
    names = [f"--dof=a{dof}={dof}" for dof in range(4)]
    more = ["--excitation", "a0", *names, "--out", "found.json", "--pictures", "pictures"]
    assert cli.main([*call, *more]) == 0
    printed = capsys.readouterr().out
    found = ar.AntiresonanceSet.load("found.json")
    assert str(found) == printed.rstrip("\n")
    assert found == four_masses.identified()
    assert sorted(os.listdir("pictures")) == [f"stabilization_dof_{dof}.png" for dof in range(4)]
    assert cli.main([*call, "--excitation", "a0", "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["excitation"] == "a0"
    assert [row["dof"] for row in numbers["antiresonances"]] == [f"a{dof}" for dof in range(4)]
    assert numbers["antiresonances"][0]["freq_hz"] == found[0].tolist()
    assert cli.main([*call, "--excitation", "a0", "--dof", "a0=", *names[1:], "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["antiresonances"]
    assert [row["dof"] for row in rows] == list(range(1, 4))
    assert cli.main(["identify", "found.json", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["antiresonances"]) == 4


def test_a_force_that_is_no_channel_is_mentioned(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    record = ar.cases.chain8().experiment(noise=0.01, duration_s=60.0, rng=1)
    floors = ["Floor 1", "Floor 2", "Floor 3"]
    ar.write_csv("test.csv", ar.Recording(record.responses[:3], record.fs_hz, floors))
    call = ["identify", "test.csv", "--band", "3", "60", "--excitation"]
    assert cli.main([*call, "Flor 1"]) == 0
    said = (
        f"--excitation: 'Flor 1' is none of the channels {str(floors)[1:-1]}: the place of the force cannot"
    )
    assert f"{said} be tested. Did you mean 'Floor 1'?" in capsys.readouterr().err
    assert cli.main([*call, "Floor 1"]) == 0
    assert "none of the channels" not in capsys.readouterr().err


def test_warnings_take_one_line(tmp_path, capsys):
    noise = np.random.default_rng(0).standard_normal((3, 4096))
    noise[1] = 0.0
    ar.write_npz(tmp_path / "record.npz", ar.Recording(noise, 256.0))
    call = ["identify", str(tmp_path / "record.npz"), "--band", "3", "100", "--excitation", "0"]
    assert cli.main(call) == 1
    assert "got no signal at all from dof 1" in capsys.readouterr().err
    noise[1] = np.clip(noise[0], -1.0, 1.0)
    ar.write_npz(tmp_path / "record.npz", ar.Recording(noise, 256.0))
    assert cli.main(call) == 0
    err = capsys.readouterr().err.splitlines()
    assert any(line.startswith("antires: warning: data check: ") for line in err)
    assert all(line.startswith("antires: warning: ") for line in err)


def test_names_from_files_move_no_cursor(tmp_path, capsys):
    """Control characters in names cleared the screen, or turned the direction of what follows."""
    name, saved = "tip\x1b[2J\u202e", str(tmp_path / "zeros.json")
    ar.AntiresonanceSet(0, {name: [2.0, 5.0]}).save(saved)
    assert cli.main(["identify", saved]) == 0
    noise = np.random.default_rng(0).standard_normal((3, 4096))
    for clipped, code in ((0.0 * noise[0], 1), (np.clip(noise[0], -1.0, 1.0), 0)):
        noise[1] = clipped
        ar.write_npz(tmp_path / "record.npz", ar.Recording(noise, 256.0, dofs=["root", name, "mid"]))
        call = ["identify", str(tmp_path / "record.npz"), "--band", "3", "100", "--excitation", "root"]
        assert cli.main(call) == code
    out, err = capsys.readouterr()
    assert "tip\\x1b[2J\\u202e" in out
    assert err.count("tip\\x1b[2J\\u202e") >= 2
    assert not {"\x1b", "\u202e"} & {*out, *err}


def test_report_of_a_result_and_of_its_folder(tmp_path, capsys):
    case = ar.cases.chain8()
    ar.assess_damage(case.model, case.exact(1), rng=0).save(tmp_path / "result.npz")
    assert cli.main(["report", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"Wrote {tmp_path / 'report.html'}\n"
    assert "Spring 4 has lost 55.0 %" in (tmp_path / "report.html").read_text()
    result, page, pictures = (str(tmp_path / name) for name in ("result.npz", "a.html", "pictures"))
    more = ["--pictures", pictures, "--title", "Chain <8>", "--json"]
    assert cli.main(["report", result, "--out", page, *more]) == 0
    written = json.loads(capsys.readouterr().out)
    assert "Chain &lt;8&gt;" in (tmp_path / "a.html").read_text()
    assert cli.main(["report", result, "--out", page]) == 0  # its own it writes anew
    (tmp_path / "thesis.html").write_text("<html>mine")
    assert cli.main(["report", result, "--out", str(tmp_path / "thesis.html")]) == 2
    assert (tmp_path / "thesis.html").read_text() == "<html>mine"
    capsys.readouterr()
    drawn = set(os.listdir(tmp_path / "pictures"))
    assert drawn == {os.path.basename(file) for file in written["pictures"]}
    assert drawn == {"damage.png", "model.png", "differences.png", "convergence.png"}


def test_a_remedy_is_spelled_as_its_reader_would_write_it(tmp_path, capsys):
    table = tmp_path / "unnamed.csv"
    table.write_text("".join(f"{0.01 * i:.2f},{i % 7},{i % 5}\n" for i in range(200)), encoding="utf-8")
    with pytest.raises(ar.InvalidInputError, match="Pass first='time', first='freq' or first='channel'."):
        ar.read_csv(table)
    assert cli.main(["identify", str(table), "--band", "3", "30", "--excitation", "0"]) == 1
    said = capsys.readouterr().err
    assert "Pass --first time, --first freq or --first channel." in said
    assert cli.main(["identify", str(table), "--band", "3", "30", "--first", "channel", "--fs", "500"]) == 2
    assert capsys.readouterr().err.startswith("antires: 200 samples at 500 Hz are 0.4 s\n")
    job = tmp_path / "job.toml"
    job.write_text(
        '[data]\nfile = "unnamed.csv"\nexcitation = 0\nband_hz = [3.0, 30.0]\n[model]\n'
        'kind = "chain"\nmasses_kg = [1, 1]\nsprings_n_per_m = [1e4]\n[damage]\n'
    )
    assert cli.main(["damage", str(job)]) == 1
    said = capsys.readouterr().err
    assert "line 2, [data] file: got" in said
    assert 'Pass first = "time", first = "freq" or first = "channel".' in said


@pytest.mark.skipif(os.name != "posix", reason="signals as sent here are POSIX")
@pytest.mark.parametrize("module", ["antires_rs.app.command", "antires_rs.app.parser", "antires_rs.app.run"])
def test_ctrl_c_while_modules_are_loaded_is_one_line(tmp_path, module):
    write_measured(tmp_path)
    (tmp_path / "job.toml").write_text(DAMAGE)
    code = f"""
import os, signal, sys
class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupting())
from antires_rs.app.main import main
sys.exit(main())
"""
    call = [sys.executable, "-c", code, "damage", "job.toml"]
    done = subprocess.run(call, cwd=tmp_path, check=False, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "antires: interrupted\n")


@pytest.mark.skipif(os.name != "posix", reason="signals as sent here are POSIX")
def test_an_import_that_ctrl_c_broke_is_ctrl_c_and_no_other(monkeypatch, capsys):
    """NumPy's C code, for one, makes an ImportError of a KeyboardInterrupt."""

    def broken(*args, **options):
        with contextlib.suppress(KeyboardInterrupt):
            os.kill(os.getpid(), interrupt)
        raise ImportError("PyCapsule_Import could not import module")

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        monkeypatch.setattr(demo, "demo", broken)
        interrupt = signal.SIGINT
        assert cli.main(["demo"]) == 130
        assert capsys.readouterr().err == "antires: interrupted\n"
        interrupt = 0
        with pytest.raises(ImportError, match="PyCapsule"):
            cli.main(["demo"])
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
