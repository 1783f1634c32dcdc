"""``antires look``, and edits without a page."""

import json
import signal
import subprocess
import sys
import time
from urllib.request import urlopen

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from tests.support.four_masses import BAND, chain, exact, record
from tests.support.signalled import ANTIRES

BAND_GIVEN = ["--band", *map(str, BAND)]


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    return ar.write_csv(tmp_path_factory.mktemp("look") / "test.csv", record())


@pytest.fixture
def started(tmp_path):
    pytest.importorskip("bokeh", reason="the page needs bokeh")
    running = []

    def start(*given):
        call = [sys.executable, "-c", ANTIRES, "look", *map(str, given), "--no-browser"]
        pipe = subprocess.PIPE
        process = subprocess.Popen(call, stdout=pipe, stderr=pipe, text=True, cwd=tmp_path)
        running.append(process)
        told = process.stdout.readline()
        assert "http://127.0.0.1:" in told, process.stderr.read()
        return process, told.rpartition(" ")[2].strip()

    yield start
    for process in running:
        process.kill()
        process.communicate()


def asked(url, path, body=None):
    base, _, token = url.partition("/?")
    sign, data = "&" if "?" in path else "?", None if body is None else json.dumps(body).encode()
    with urlopen(f"{base}/{path}{sign}{token}", data) as answer:
        return json.load(answer)


def ended(process):
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    return process.returncode, out, err, time.monotonic() - start


def viewed(*given):
    pytest.importorskip("bokeh", reason="the page needs bokeh")
    from antires_rs.app.look_view import view_of
    from antires_rs.app.parser import parser

    return view_of(parser().parse_args(["look", *map(str, given)]))


def test_a_measurement_is_looked_at_edited_and_saved(started, measured, tmp_path):
    given = [*BAND_GIVEN, "--excitation", "0", "--max-order", "30"]
    process, url = started(measured, *given)
    assert not asked(url, "state")["identified"]
    state = asked(url, "do/identify", {})
    assert state["identified"]
    value = state["rows"][0]["freq_hz"]
    asked(url, "do/drop", {"dof": 0, "freq_hz": value, "reason": "hum"})
    asked(url, "do/save", {})
    asked(url, "do/add", {"dof": 1, "freq_hz": 3.21})
    code, out, err, seconds = ended(process)
    assert (code, err.strip()) == (0, "")
    assert seconds < 5.0
    saved = ar.AntiresonanceSet.load(tmp_path / "test_antiresonances.json")
    assert [edit.reason for edit in saved.edits] == ["hum"]
    assert "test_antiresonances_unsaved.json" in out
    kept = ar.AntiresonanceSet.load(tmp_path / "test_antiresonances_unsaved.json")
    assert len(kept.edits) == 2

    edits = tmp_path / "test_antiresonances_unsaved.json"
    view = viewed(measured, *given, "--edits", edits, "--out", tmp_path / "again.json")
    view.do("identify", {})
    view.do("save", {})
    assert ar.AntiresonanceSet.load(tmp_path / "again.json") == kept
    view = viewed(edits)
    view.do("drop", {"dof": 0, "freq_hz": float(kept[0][0])})
    view.do("save", {})
    assert ar.AntiresonanceSet.load(edits)[0].tolist() == kept[0][1:].tolist()


def test_ctrl_c_during_the_identification_ends_it_at_once(started, measured):
    process, url = started(measured, "--excitation", "0")
    asked(url, "state")  # it has been read
    base, _, token = url.partition("/?")
    code = "import sys, urllib.request as u; u.urlopen(sys.argv[1], b'{}')"
    call = [sys.executable, "-c", code, f"{base}/do/identify?{token}"]
    waits = subprocess.Popen(call, stderr=subprocess.DEVNULL)
    time.sleep(0.4)
    code, _, err, seconds = ended(process)
    assert (code, err.strip()) == (0, "")
    assert seconds < 3.0
    waits.wait(timeout=30)


def test_a_file_that_cannot_be_read_is_told_on_the_page_too(started, tmp_path):
    file = tmp_path / "zeros.json"
    file.write_text("{}")
    process, url = started(file)
    assert "without the mark" in asked(url, "state")["error"]
    out, err = process.communicate(timeout=30)
    assert process.returncode == 2
    assert "without the mark" in err
    assert "Traceback" not in err


def test_identify_drops_and_adds(measured):
    out = measured.with_name("zeros.json")
    options = ["--excitation", "0", "--max-order", "30", "--out", str(out)]
    call = ["identify", str(measured), *BAND_GIVEN, *options]
    assert cli.main(call) == 0
    plain = ar.AntiresonanceSet.load(out)
    first = float(plain[0][0])
    edits = ["--drop", f"0={first:.2f} mains hum", "--add", "1=3.21", "--add", "0=3.3 in the phase"]
    assert cli.main([*call, *edits]) == 0
    found = ar.AntiresonanceSet.load(out)
    assert [(e.action, e.dof, e.reason) for e in found.edits] == [
        ("drop", 0, "mains hum"), ("add", 1, ""), ("add", 0, "in the phase"),
    ]  # fmt: skip
    assert found.edits[0].freq_hz == first
    assert 3.21 in found[1]
    assert found.original() == plain


def test_a_single_channel_takes_the_route_over_the_force(tmp_path, capsys):
    freq = np.arange(0.5, 10.0, 0.01)
    values = chain().frf([0], 0, freq, damping_ratio=0.01)
    noise = np.random.default_rng(0).standard_normal((2, *values.shape)) * 1e-4 * np.abs(values).max()
    curve = ar.FrequencyResponse(freq, values + noise[0] + 1j * noise[1], dofs=["tip"])
    file = ar.write_npz(tmp_path / "one.npz", curve)
    given = ["identify", str(file), "--excitation", "tip", *BAND_GIVEN, "--out", str(tmp_path / "a.json")]
    assert cli.main(given) != 0
    assert "take the route 'frf'" in capsys.readouterr().err
    assert cli.main([*given, "--route", "frf"]) == 0
    found = ar.AntiresonanceSet.load(tmp_path / "a.json")["tip"]
    assert found == pytest.approx(exact(chain(), [0])[0], rel=2e-3)


def test_a_job_and_its_results_are_sent_to_the_report(tmp_path, capsys):
    (tmp_path / "run.json").write_text("{}")
    for given in (tmp_path, tmp_path / "job.toml"):
        assert cli.main(["look", str(given)]) == 2
        assert "'antires report' writes the page of a result" in capsys.readouterr().err
