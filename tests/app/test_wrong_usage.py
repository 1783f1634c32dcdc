"""Wrong calls of ``antires`` and wrong jobs: messages name what was got, what is wanted, and a remedy."""

import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from antires_rs.app.job import read_job
from tests.support.job_files import DAMAGE, SERIES, UPDATE, write_measured, write_record
from tests.support.snapshots import compare, complaints

CHAIN = DAMAGE[DAMAGE.index('kind = "chain"') : DAMAGE.index("\n[damage]")]
FRAME = DAMAGE.replace(
    CHAIN,
    """kind = "frame"
nodes_m = [
  [0.0, 0.0],
  [0.5, 0.0],
]
elements = [[0, 1, "pipe"]]
fixed = [0]
[model.sections]
pipe = { shape = "tube", outer_diameter_m = 0.05, thickness_m = 0.002, youngs_modulus_pa = 2.1e11, \
density_kg_per_m3 = 7850 }
""",
)
BASELINE = DAMAGE.replace("[damage]", '[damage]\nbaseline = "measured_intact.json"')
RECORD = DAMAGE.replace('file = "measured.json"', 'file = "record.npz"\nexcitation = 0\nband_hz = [3, 100]')
THREE = RECORD.replace("band_hz", "dofs = [0, 1, 2]\nband_hz")
OTHER_FORCE = RECORD.replace("excitation = 0", 'excitation = "tip"')

#: Jobs that are changed; the lines of wrong_jobs.txt say how, ``job | old | new``, and what is said then.
GOOD = {"damage": DAMAGE, "update": UPDATE, "frame": FRAME, "baseline": BASELINE}
GOOD |= {"record": RECORD, "three": THREE, "tip": OTHER_FORCE, "series": SERIES}
JOBS = {  #: What is wrong, and the job, where more is changed.
    "a key outside its section": "seed = 3\n" + DAMAGE,
    "no model": re.sub(r"\[model\](.|\n)*\[damage\]", "[damage]", DAMAGE),
    "both damage and parameters": UPDATE + "[damage]\n",
    "updating beside damage": DAMAGE + '[updating]\nmisfit = "squared"\n',
    "a file of another kind": DAMAGE.replace('measured.json"', 'record.npz"\nformat = "antiresonances"'),
    "channels that are no dofs": RECORD,
    "a chain without springs": re.sub(r"springs.*\n", "", DAMAGE),
    "bounds in the wrong order": UPDATE.replace("bounds = [0.9, 1.1]", "bounds = [1.1, 0.9]", 1),
    "parameters as a single table": UPDATE.replace("[[parameters]]", "[parameters]", 1).replace(
        '[[parameters]]\nkind = "stiffness_factor"\nelements = "all"\nbounds = [0.9, 1.1]\n', ""
    ),
}


def jobs(lines):
    """What is wrong, and the job: by the lines of the file, then those above."""
    for line in lines:
        change = line.partition(": exit ")[0]
        if change not in JOBS:
            job, old, new = change.replace("\\n", "\n").split(" | ")
            yield change, GOOD[job].replace(old, new)
    yield from JOBS.items()


def said(*call):
    """Exit code of a call of ``antires``, what it says on standard error, and the error behind it."""
    written = []
    with pytest.MonkeyPatch.context() as patch, complaints(patch) as errors:
        patch.setattr("sys.stderr.write", written.append)
        try:
            code = cli.main(call)
        except SystemExit as exc:
            code = exc.code
    (error,) = errors
    text = "".join(written).strip()
    if not isinstance(error, str):  # which argparse says
        assert all((error.argument, error.got, error.wanted, error.remedy))
        assert text.endswith(f"{error.argument}: got {error.got}; wanted {error.wanted}. {error.remedy}")
    assert "\n" not in text
    return code, text


def test_wrong_calls(tmp_path, monkeypatch):
    """Each line of the file is a call and what is said of it."""
    pytest.importorskip("bokeh", reason="the page needs bokeh")
    write_record(tmp_path)
    write_measured(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "results").mkdir()
    (tmp_path / "damage.toml").write_text(DAMAGE)
    (tmp_path / "update.toml").write_text(UPDATE)
    (tmp_path / "record.xyz").write_text("1 2 3")
    (tmp_path / "cut.npz").write_bytes((tmp_path / "record.npz").read_bytes()[:5000])
    (tmp_path / "report.html").write_text("<html>")
    case = ar.cases.chain8()
    ar.assess_damage(case.model, case.exact(1), rng=0).save(tmp_path / "result.npz")
    (tmp_path / "results" / "result.npz").write_bytes(b"")
    ar.AntiresonanceSet(0, {0: [8.7]}).save(tmp_path / "zeros.json")
    before = sorted(tmp_path.rglob("*"))
    monkeypatch.chdir(tmp_path)
    messages, file = {}, Path(__file__).with_name("wrong_calls.txt")
    for line in file.read_text(encoding="utf-8").splitlines():
        call = line.partition(": exit ")[0]
        code, text = said(*shlex.split(call)[1:])
        assert (code == 1) <= ("npz" in text)  # 1 is for files that cannot be used
        messages[call] = f"exit {code}  {text}"
    compare(file, messages)
    assert "invalid choice: 'damages'" in said("damages", "job.toml")[1]
    assert sorted(tmp_path.rglob("*")) == before


def test_wrong_jobs(tmp_path):
    write_measured(tmp_path)
    shutil.copy(tmp_path / "measured.json", tmp_path / "measured_intact.json")
    ar.AntiresonanceSet(1, {0: [10.0]}).save(tmp_path / "other_force_measured_intact.json")
    write_record(tmp_path)
    slow = ar.Recording(np.zeros((3, 64)), 100.0, dofs=["tip", "mid", "root"])
    ar.write_npz(tmp_path / "slow.npz", slow)
    (tmp_path / "records").mkdir()
    write_record(tmp_path / "records")
    (tmp_path / "weather.csv").write_text("name,temperature_c\nrecord,20\n")
    job, before = tmp_path / "job.toml", {*tmp_path.iterdir()}
    messages, file = {}, Path(__file__).with_name("wrong_jobs.txt")
    for name, text in jobs(file.read_text(encoding="utf-8").splitlines()):
        assert text not in (DAMAGE, UPDATE, FRAME, RECORD) or name == "channels that are no dofs", name
        job.write_text(text, encoding="utf-8")
        task = "update" if "[parameters]" in text else "series" if "[series]" in text else "damage"
        code, message = said(task, str(job))
        messages[name] = f"exit {code}  {message.replace(str(tmp_path), 'FOLDER')}"
        assert messages[name].startswith("exit 2  antires: error: job.toml")
        if task == "series":
            shutil.rmtree(tmp_path / "job_results", ignore_errors=True)
    compare(file, messages)
    assert {*tmp_path.iterdir()} == before | {job}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "JOB: got .* does not exist; wanted a job file"),
        (b"[data]\nfile = '\xff'\n", r"job\.toml, line 2: got bytes that are no UTF-8"),
        (b"", r"job\.toml: got no section \[data\]"),
        (b'[data]\nfile = "C:\\Users\\test.uff"\n', "A path is written with / or in single quotes"),
    ],
)
def test_no_job_at_all(tmp_path, content, message):
    job = tmp_path / "job.toml"
    if content is not None:
        job.write_bytes(content)
    with pytest.raises(ar.InvalidInputError, match=message):
        read_job(job)
