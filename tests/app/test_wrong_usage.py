"""Wrong calls of ``antires`` and wrong jobs: messages name what was got, what is wanted, and a remedy."""

import re
import shlex
from pathlib import Path

import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from antires_rs.app.job import read_job
from tests.support.job_files import DAMAGE, UPDATE, write_measured, write_record
from tests.support.snapshots import compare, complaints

FRAME = DAMAGE.replace(
    """kind = "chain"
masses_kg = [0.5593, 0.4194, 0.4194, 0.4194, 0.4194, 0.4194, 0.4194, 0.4194]
springs_n_per_m = [56.7e3, 56.7e3, 56.7e3, 56.7e3, 56.7e3, 56.7e3, 56.7e3]
""",
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
BASELINE = DAMAGE.replace("[damage]", '[damage]\nbaseline = "measured.json"')
RECORD = DAMAGE.replace('file = "measured.json"', 'file = "record.npz"\nexcitation = 0\nband_hz = [3, 100]')


def record(more, job=RECORD):
    """With more in its [data]."""
    return job.replace("band_hz", f"{more}\nband_hz")


THREE = record("dofs = [0, 1, 2]")
OTHER_FORCE = RECORD.replace("excitation = 0", 'excitation = "tip"')
ANTIRESONANCES = 'file = "record.npz"\nformat = "antiresonances"'


def section(text, job=DAMAGE):
    """With a section more, or the end of one, before [model], [damage] or [search]."""
    before = "[search]" if job is BASELINE or "[updating]" in text else "[model]"
    return job.replace(before, f"{text}\n{before}")


#: What is wrong, and the job.
JOBS = {
    "no TOML: text without quotes": DAMAGE.replace('"chain"', "chain"),
    "no TOML: a key twice": DAMAGE.replace("seed = 1", "seed = 1\nseed = 2"),
    "no TOML: a list that does not end": DAMAGE.replace("56.7e3]", "56.7e3"),
    "no TOML: [data] twice": DAMAGE.replace("[model]", '[data]\nfile = "b.json"\n[model]'),
    "a key of records beside antiresonances": DAMAGE.replace("[model]", "excitation = 3\n[model]"),
    "a force at a channel that is left out": record("dofs = { tip = false, mid = 1, root = 2 }", OTHER_FORCE),
    "an unknown section": DAMAGE.replace("[search]", "[serach]"),
    "a key outside its section": "seed = 3\n" + DAMAGE,
    "an unknown key, near a known one": DAMAGE.replace("seed", "sead"),
    "an unknown key, of another section": DAMAGE.replace("seed = 1", "gamma1 = 0.1"),
    "an unknown key, near none": DAMAGE.replace("seed", "colour"),
    "a number as text": DAMAGE.replace("seed = 1", 'seed = "1"'),
    "a whole number with a fraction": DAMAGE.replace("seed = 1", "islands = 4.5"),
    "a switch as text": DAMAGE.replace("report = false", 'report = "no"'),
    "a number that is not finite": DAMAGE.replace("[damage]", "[damage]\ngamma1 = nan"),
    "a negative price": DAMAGE.replace("[damage]", "[damage]\ngamma2 = -0.1"),
    "no data": DAMAGE.replace('[data]\nfile = "measured.json"\n', ""),
    "no model": re.sub(r"\[model\](.|\n)*\[damage\]", "[damage]", DAMAGE),
    "neither damage nor parameters": DAMAGE.replace("[damage]\n", ""),
    "both damage and parameters": UPDATE + "[damage]\n",
    "updating beside damage": DAMAGE + '[updating]\nmisfit = "squared"\n',
    "a file that is not there": DAMAGE.replace("measured.json", "measurd.json"),
    "an ending that is not known": DAMAGE.replace("measured.json", "measured.xyz"),
    "a file of another kind": DAMAGE.replace('file = "measured.json"', ANTIRESONANCES),
    "a key of another format": record('delimiter = ";"'),
    "no band": RECORD.replace("band_hz = [3, 100]\n", ""),
    "a band of one number": RECORD.replace("[3, 100]", "[3]"),
    "a band beyond the data": THREE.replace("[3, 100]", "[3, 500]"),
    "channels that are no dofs": RECORD,
    "too many dofs": record("dofs = [0, 1, 2, 3]"),
    "a channel without dof": record("dofs = { tip = 0, mid = 1 }"),
    "a dof beyond the model": record("dofs = [0, 1, 8]"),
    "a force beyond the model": THREE.replace("excitation = 0", "excitation = 9"),
    "an unknown option of the identification": section('[identification]\nestimator = "rank2"\n', THREE),
    "options of an identification that is done": section("[identification]\nmax_order = 30"),
    "an unknown kind of model": DAMAGE.replace('"chain"', '"chian"'),
    "a key of another model": DAMAGE.replace("[damage]", "nodes_m = [[0, 0], [1, 0]]\n[damage]"),
    "a chain without springs": re.sub(r"springs.*\n", "", DAMAGE),
    "a mass of zero": DAMAGE.replace("0.5593", "0.0"),
    "a spring too many": DAMAGE.replace("springs_n_per_m = [", "springs_n_per_m = [1.0, "),
    "a frame without nodes": re.sub(r"nodes_m = \[\n(.*\n){2}\]\n", "", FRAME),
    "a section without thickness": FRAME.replace("thickness_m = 0.002, ", ""),
    "a misspelt size of a section": FRAME.replace("thickness_m", "thicknes_m"),
    "an unknown shape": FRAME.replace('"tube"', '"tub"'),
    "an element to a node that is not there": FRAME.replace("[[0, 1,", "[[0, 2,"),
    "an element as a number": FRAME.replace('[[0, 1, "pipe"]]', "[0, 1]"),
    "a direction that is none": FRAME.replace("[model]", 'dofs = { 0 = "1 w" }\n[model]', 1),
    "an unknown kind of parameter": UPDATE.replace('"mass_factor"', '"mas_factor"'),
    "bounds in the wrong order": UPDATE.replace("bounds = [0.9, 1.1]", "bounds = [1.1, 0.9]", 1),
    "a parameter of nothing": UPDATE.replace('terms = "all"\n', ""),
    "a parameter of frames": UPDATE.replace(
        'kind = "mass_factor"\nterms = "all"', 'kind = "thickness"\nsections = "all"'
    ),
    "a mass that is not there": UPDATE.replace('terms = "all"', "terms = [0, 9]"),
    "an element twice": UPDATE.replace('elements = "all"', "elements = [0, 0]"),
    "a candidate that is not there": DAMAGE.replace("[damage]", "[damage]\nelements = [0, 17]"),
    "a baseline that is not there": BASELINE.replace('baseline = "m', 'baseline = "n'),
    "a baseline with the force elsewhere": BASELINE.replace('baseline = "m', 'baseline = "other_force_m'),
    "a baseline that is a number": DAMAGE.replace("[damage]", "[damage]\nbaseline = 3"),
    "a price beside a baseline": section("gamma1 = 0.1", BASELINE),
    "a search beside a baseline": BASELINE.replace("seed = 1", "islands = 2"),
    "a rate of false alarms without a baseline": DAMAGE.replace(
        "[damage]", "[damage]\nfalse_alarm_rate = 0.05"
    ),
    "a rate of false alarms above a half": section("false_alarm_rate = 5", BASELINE),
    "too much that moves all values": section("std_common = 0.2", BASELINE),
    "a prior that is a number": section("prior = 0.5", BASELINE),
    "a prior that does not add up": section("prior = { nothing = 0.9 }", BASELINE),
    "a prior of something else": section("prior = { none = 0.9 }", BASELINE),
    "a prior beyond certainty": section("prior = { nothing = 1.5 }", BASELINE),
    "parameters as a single table": UPDATE.replace("[[parameters]]", "[parameters]", 1).replace(
        '[[parameters]]\nkind = "stiffness_factor"\nelements = "all"\nbounds = [0.9, 1.1]\n', ""
    ),
    "an unknown misfit": section('[updating]\nmisfit = "L2"\n', UPDATE),
    "no islands": DAMAGE.replace("seed = 1", "islands = 0"),
    "an unknown crossover": DAMAGE.replace("seed = 1", 'crossovers = ["blend", "random"]'),
    "a negative seed": DAMAGE.replace("seed = 1", "seed = -1"),
    "two names of one dof": DAMAGE.replace("[model]", "dofs = [3, 3, 0, 1, 2, 4, 5, 6]\n[model]"),
    "a folder that is a file": DAMAGE.replace("report", 'folder = "measured.json"\nreport'),
}


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
    (tmp_path / "damage.toml").write_text(DAMAGE)
    (tmp_path / "update.toml").write_text(UPDATE)
    (tmp_path / "record.xyz").write_text("1 2 3")
    (tmp_path / "cut.npz").write_bytes((tmp_path / "record.npz").read_bytes()[:5000])
    (tmp_path / "report.html").write_text("<html>")
    case = ar.cases.chain8()
    ar.assess_damage(case.model, case.exact(1), rng=0).save(tmp_path / "result.npz")
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
    assert sorted(tmp_path.rglob("*")) == before


def test_wrong_jobs(tmp_path):
    write_measured(tmp_path)
    ar.AntiresonanceSet(1, {0: [10.0]}).save(tmp_path / "other_force_measured.json")
    write_record(tmp_path)
    job = tmp_path / "job.toml"
    messages = {}
    for name, text in JOBS.items():
        assert text not in (DAMAGE, UPDATE, FRAME, RECORD) or name == "channels that are no dofs", name
        job.write_text(text, encoding="utf-8")
        code, message = said("update" if "[parameters]" in text else "damage", str(job))
        messages[name] = f"exit {code}  {message.replace(str(tmp_path), 'FOLDER')}"
        assert messages[name].startswith("exit 2  antires: error: job.toml")
    compare(Path(__file__).with_name("wrong_jobs.txt"), messages)
    files = {"job.toml", "measured.json", "other_force_measured.json", "record.npz"}
    assert {path.name for path in tmp_path.iterdir()} == files


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
