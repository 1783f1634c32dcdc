"""Wrong job files: every message names file, line and key, what was got, what is wanted, and a remedy."""

import re
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

#: What is wrong: (the job, the line that must be named).
WRONG = {
    "no TOML: text without quotes": (DAMAGE.replace('"chain"', "chain"), 5),
    "no TOML: a key twice": (DAMAGE.replace("seed = 1", "seed = 1\nseed = 2"), 13),
    "no TOML: a list that does not end": (DAMAGE.replace("56.7e3]", "56.7e3"), 7),
    "no TOML: [data] twice": (DAMAGE.replace("[model]", '[data]\nfile = "b.json"\n[model]'), 4),
    "a key of records beside antiresonances": (DAMAGE.replace("[model]", "excitation = 3\n[model]"), 4),
    "a force at a channel that is left out": (
        RECORD.replace("excitation = 0", 'excitation = "tip"').replace(
            "band_hz", "dofs = { tip = false, mid = 1, root = 2 }\nband_hz"
        ),
        3,
    ),
    "an unknown section": (DAMAGE.replace("[search]", "[serach]"), 11),
    "a key outside its section": ("seed = 3\n" + DAMAGE, 1),
    "an unknown key, near a known one": (DAMAGE.replace("seed", "sead"), 12),
    "an unknown key, of another section": (DAMAGE.replace("seed = 1", "gamma1 = 0.1"), 12),
    "an unknown key, near none": (DAMAGE.replace("seed", "colour"), 12),
    "a number as text": (DAMAGE.replace("seed = 1", 'seed = "1"'), 12),
    "a whole number with a fraction": (DAMAGE.replace("seed = 1", "islands = 4.5"), 12),
    "a switch as text": (DAMAGE.replace("report = false", 'report = "no"'), 15),
    "a number that is not finite": (DAMAGE.replace("[damage]", "[damage]\ngamma1 = nan"), 10),
    "a negative price": (DAMAGE.replace("[damage]", "[damage]\ngamma2 = -0.1"), 10),
    "no data": (DAMAGE.replace('[data]\nfile = "measured.json"\n', ""), None),
    "no model": (re.sub(r"\[model\](.|\n)*\[damage\]", "[damage]", DAMAGE), None),
    "neither damage nor parameters": (DAMAGE.replace("[damage]\n", ""), None),
    "both damage and parameters": (UPDATE + "[damage]\n", 25),
    "updating beside damage": (DAMAGE + '[updating]\nmisfit = "squared"\n', 17),
    "a file that is not there": (DAMAGE.replace("measured.json", "measurd.json"), 2),
    "an ending that is not known": (DAMAGE.replace("measured.json", "measured.xyz"), 2),
    "a file of another kind": (
        DAMAGE.replace('file = "measured.json"', 'file = "record.npz"\nformat = "antiresonances"'),
        2,
    ),
    "a key of another format": (RECORD.replace("band_hz", 'delimiter = ";"\nband_hz'), 4),
    "no band": (RECORD.replace("band_hz = [3, 100]\n", ""), 1),
    "a band of one number": (RECORD.replace("[3, 100]", "[3]"), 4),
    "a band beyond the data": (
        RECORD.replace("[3, 100]", "[3, 500]").replace("band_hz", "dofs = [0, 1, 2]\nband_hz"),
        5,
    ),
    "channels that are no dofs": (RECORD, 1),
    "too many dofs": (RECORD.replace("band_hz", "dofs = [0, 1, 2, 3]\nband_hz"), 4),
    "a channel without dof": (RECORD.replace("band_hz", "dofs = { tip = 0, mid = 1 }\nband_hz"), 4),
    "a dof beyond the model": (RECORD.replace("band_hz", "dofs = [0, 1, 8]\nband_hz"), 4),
    "a force beyond the model": (
        RECORD.replace("excitation = 0", "excitation = 9").replace("band_hz", "dofs = [0, 1, 2]\nband_hz"),
        3,
    ),
    "an unknown option of the identification": (
        RECORD.replace("band_hz", "dofs = [0, 1, 2]\nband_hz").replace(
            "[model]", '[identification]\nestimator = "rank2"\n\n[model]'
        ),
        8,
    ),
    "options of an identification that is done": (
        DAMAGE.replace("[model]", "[identification]\nmax_order = 30\n[model]"),
        4,
    ),
    "an unknown kind of model": (DAMAGE.replace('"chain"', '"chian"'), 5),
    "a key of another model": (DAMAGE.replace("[damage]", "nodes_m = [[0, 0], [1, 0]]\n[damage]"), 9),
    "a chain without springs": (re.sub(r"springs.*\n", "", DAMAGE), 4),
    "a mass of zero": (DAMAGE.replace("0.5593", "0.0"), 6),
    "a spring too many": (DAMAGE.replace("springs_n_per_m = [", "springs_n_per_m = [1.0, "), 7),
    "a frame without nodes": (re.sub(r"nodes_m = \[\n(.*\n){2}\]\n", "", FRAME), 4),
    "a section without thickness": (FRAME.replace("thickness_m = 0.002, ", ""), 13),
    "a misspelt size of a section": (FRAME.replace("thickness_m", "thicknes_m"), 13),
    "an unknown shape": (FRAME.replace('"tube"', '"tub"'), 13),
    "an element to a node that is not there": (FRAME.replace("[[0, 1,", "[[0, 2,"), 10),
    "an element as a number": (FRAME.replace('[[0, 1, "pipe"]]', "[0, 1]"), 10),
    "a direction that is none": (
        FRAME.replace('file = "measured.json"', 'file = "measured.json"\ndofs = { 0 = "1 w" }'),
        3,
    ),
    "an unknown kind of parameter": (UPDATE.replace('"mass_factor"', '"mas_factor"'), 10),
    "bounds in the wrong order": (UPDATE.replace("bounds = [0.9, 1.1]", "bounds = [1.1, 0.9]", 1), 12),
    "a parameter of nothing": (UPDATE.replace('terms = "all"\n', ""), 9),
    "a parameter of frames": (
        UPDATE.replace('kind = "mass_factor"\nterms = "all"', 'kind = "thickness"\nsections = "all"'),
        11,
    ),
    "a mass that is not there": (UPDATE.replace('terms = "all"', "terms = [0, 9]"), 11),
    "an element twice": (UPDATE.replace('elements = "all"', "elements = [0, 0]"), 16),
    "a candidate that is not there": (DAMAGE.replace("[damage]", "[damage]\nelements = [0, 17]"), 10),
    "a baseline that is not there": (BASELINE.replace('baseline = "m', 'baseline = "n'), 10),
    "a baseline with the force elsewhere": (
        BASELINE.replace('baseline = "m', 'baseline = "other_force_m'),
        10,
    ),
    "a baseline that is a number": (DAMAGE.replace("[damage]", "[damage]\nbaseline = 3"), 10),
    "a price beside a baseline": (BASELINE.replace("[search]", "gamma1 = 0.1\n[search]"), 12),
    "a search beside a baseline": (BASELINE.replace("seed = 1", "islands = 2"), 13),
    "a rate of false alarms without a baseline": (
        DAMAGE.replace("[damage]", "[damage]\nfalse_alarm_rate = 0.05"),
        10,
    ),
    "a rate of false alarms above a half": (
        BASELINE.replace("[search]", "false_alarm_rate = 5\n[search]"),
        12,
    ),
    "too much that moves all values": (BASELINE.replace("[search]", "std_common = 0.2\n[search]"), 12),
    "a prior that is a number": (BASELINE.replace("[search]", "prior = 0.5\n[search]"), 12),
    "a prior that does not add up": (BASELINE.replace("[search]", "prior = { nothing = 0.9 }\n[search]"), 12),
    "a prior of something else": (BASELINE.replace("[search]", "prior = { none = 0.9 }\n[search]"), 12),
    "a prior beyond certainty": (BASELINE.replace("[search]", "prior = { nothing = 1.5 }\n[search]"), 12),
    "parameters as a single table": (
        UPDATE.replace("[[parameters]]", "[parameters]", 1).replace(
            '[[parameters]]\nkind = "stiffness_factor"\nelements = "all"\nbounds = [0.9, 1.1]\n', ""
        ),
        9,
    ),
    "an unknown misfit": (UPDATE.replace("[search]", '[updating]\nmisfit = "L2"\n\n[search]'), 20),
    "no islands": (DAMAGE.replace("seed = 1", "islands = 0"), 12),
    "an unknown crossover": (DAMAGE.replace("seed = 1", 'crossovers = ["blend", "random"]'), 12),
    "a negative seed": (DAMAGE.replace("seed = 1", "seed = -1"), 12),
    "a folder that is a file": (DAMAGE.replace("report", 'folder = "measured.json"\nreport'), 15),
}


@pytest.fixture(scope="module")
def messages(tmp_path_factory):
    """What ``antires`` says to each job, its exit code, and the error behind it."""
    folder = tmp_path_factory.mktemp("jobs")
    write_measured(folder)
    ar.AntiresonanceSet(1, {0: [10.0]}).save(folder / "other_force_measured.json")
    write_record(folder)
    job = folder / "job.toml"
    said = {}
    for case, (text, _) in WRONG.items():
        assert text not in (DAMAGE, UPDATE, FRAME, RECORD) or case == "channels that are no dofs", case
        job.write_text(text, encoding="utf-8")
        task = "update" if "[[parameters]]" in text or "[parameters]" in text else "damage"
        with pytest.MonkeyPatch.context() as patch, complaints(patch) as errors:
            written = []
            patch.setattr("sys.stderr.write", written.append)
            code = cli.main([task, str(job)])
        said[case] = code, "".join(written).strip().replace(str(folder), "FOLDER"), *errors
    assert sorted(p.name for p in folder.iterdir()) == [
        "job.toml",
        "measured.json",
        "other_force_measured.json",
        "record.npz",
    ]
    return said


@pytest.mark.parametrize("case", WRONG)
def test_each_message_names_line_got_wanted_and_remedy(messages, case):
    code, said, error = messages[case]
    line = WRONG[case][1]
    assert said.startswith("antires: error: job.toml" + (f", line {line}" if line else ":"))
    assert all((error.argument, error.got, error.wanted, error.remedy))
    assert str(error) == f"{error.argument}: got {error.got}; wanted {error.wanted}. {error.remedy}"
    assert "\n" not in said
    assert code == 2 or "path" not in said


def test_the_messages_are_those_that_were_looked_at(messages):
    compare(
        Path(__file__).with_name("wrong_jobs.txt"),
        {case: f"exit {code}  {said}" for case, (code, said, _) in messages.items()},
    )


def test_no_text_at_all_and_no_utf_8(tmp_path):
    job = tmp_path / "job.toml"
    with pytest.raises(ar.InvalidInputError, match="JOB: got .* does not exist; wanted a job file"):
        read_job(job)
    job.write_bytes(b"[data]\nfile = '\xff'\n")
    with pytest.raises(ar.InvalidInputError, match=r"job\.toml, line 2: got bytes that are no UTF-8"):
        read_job(job)
    job.write_text("", encoding="utf-8")
    with pytest.raises(ar.InvalidInputError, match=r"job\.toml: got no section \[data\]"):
        read_job(job)
