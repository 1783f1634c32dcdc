"""Forty wrong calls of ``antires``: every message names the argument, what was got, what is wanted, a "
"remedy."""

from pathlib import Path

import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from tests.support.job_files import DAMAGE, UPDATE, write_measured, write_record
from tests.support.snapshots import compare, complaints


def identify(*more, file="record.npz", band=("3", "100"), excitation="tip"):
    return ["identify", file, "--band", *band, "--excitation", excitation, *more]


#: What is wrong: (the argument that must be named first, the call).
WRONG = {
    "no command": ("COMMAND", []),
    "an unknown command": ("COMMAND", ["damages", "job.toml"]),
    "an unknown option": ("--sead", ["demo", "--sead", "1"]),
    "an unknown option, near none": ("--fast", ["damage", "job.toml", "--fast"]),
    "a negative seed": ("--seed", ["demo", "--seed", "-1"]),
    "a seed with a fraction": ("--seed", ["demo", "--seed", "1.5"]),
    "noise that is no number": ("--noise", ["demo", "--noise", "much"]),
    "too much noise": ("--noise", ["demo", "--noise", "2"]),
    "no workers": ("--workers", ["demo", "--workers", "0"]),
    "an option without value": ("--out", ["demo", "--out"]),
    "a job that exists": ("JOB", ["init", "damage.toml"]),
    "a job that is no TOML file": ("JOB", ["init", "job.txt"]),
    "a job in no folder": ("JOB", ["init", "no/job.toml"]),
    "an unknown task": ("--task", ["init", "new.toml", "--task", "damages"]),
    "an unknown model": ("--model", ["init", "new.toml", "--model", "plate"]),
    "data that are not there": ("--data", ["init", "new.toml", "--data", "recrd.uff"]),
    "data of an unknown kind": ("--data", ["init", "new.toml", "--data", "damage.toml"]),
    "damaged data": ("--data", ["init", "new.toml", "--data", "cut.npz"]),
    "nothing to identify": ("FILE", ["identify"]),
    "a file that is not there": ("FILE", identify(file="recrd.npz")),
    "a folder in place of a file": ("FILE", identify(file="folder")),
    "an ending that is not known": ("FILE", identify(file="record.xyz")),
    "a file that was cut": ("FILE", identify(file="cut.npz")),
    "an unknown format": ("--format", identify("--format", "aiff")),
    "no band": ("--band", ["identify", "record.npz", "--excitation", "tip"]),
    "half a band": ("--band", ["identify", "record.npz", "--excitation", "tip", "--band", "3"]),
    "a band that is no number": ("--band", identify(band=("3", "high"))),
    "a band beyond the data": ("--band", identify(band=("3", "500"))),
    "a band upside down": ("--band", identify(band=("100", "3"))),
    "no excitation": ("--excitation", ["identify", "record.npz", "--band", "3", "100"]),
    "a channel without dof": ("--dof", identify("--dof", "tip=0")),
    "a channel that is not there": ("--dof", identify("--dof", "top=0")),
    "a dof without channel": ("--dof", identify("--dof", "3")),
    "an order that is too low": ("--max-order", identify("--max-order", "1")),
    "an order that is too high": ("--max-order", identify("--max-order", "500")),
    "an unknown preset": ("--preset", identify("--preset", "papers")),
    "an option of another format": ("--first", identify("--first", "time")),
    "a result that is no JSON": ("--out", identify("--out", "found.csv")),
    "an option beside a job": ("--band", ["identify", "damage.toml", "--band", "3", "100"]),
    "no job": ("JOB", ["damage"]),
    "a job that is not there": ("JOB", ["damage", "damages.toml"]),
    "a job for another command": ("JOB", ["update", "damage.toml"]),
    "nothing to go on from": ("JOB", ["resume", "folder"]),
    "a checkpoint that is not there": ("JOB", ["resume", "results/search.ckpt"]),
    "no result": ("RESULT", ["report", "folder"]),
    "a report of something else": ("RESULT", ["report", "record.npz"]),
    "a report of a report": ("RESULT", ["report", "report.html"]),
    "a report that is no HTML": ("--out", ["report", "result.npz", "--out", "report.pdf"]),
    "an argument too many": ("more.npz", ["report", "result.npz", "more.npz"]),
}


@pytest.fixture(scope="module")
def messages(tmp_path_factory):
    """What ``antires`` says to each call, its exit code, and the error behind it."""
    folder = tmp_path_factory.mktemp("calls")
    write_record(folder)
    write_measured(folder)
    (folder / "folder").mkdir()
    (folder / "damage.toml").write_text(DAMAGE)
    (folder / "update.toml").write_text(UPDATE)
    (folder / "record.xyz").write_text("1 2 3")
    (folder / "cut.npz").write_bytes((folder / "record.npz").read_bytes()[:5000])
    (folder / "report.html").write_text("<html>")
    case = ar.cases.chain8()
    ar.assess_damage(case.model, case.exact(1), rng=0).save(folder / "result.npz")
    before = sorted(folder.rglob("*"))
    said = {}
    with pytest.MonkeyPatch.context() as patch, complaints(patch) as errors:
        patch.chdir(folder)
        written = []
        patch.setattr("sys.stderr.write", written.append)
        for name, (_, call) in WRONG.items():
            written.clear()
            try:
                code = cli.main(call)
            except SystemExit as exc:
                code = exc.code
            said[name] = code, "".join(written).strip(), errors.pop()
    assert sorted(folder.rglob("*")) == before
    return said


@pytest.mark.parametrize("case", WRONG)
def test_each_message_names_argument_got_wanted_and_remedy(messages, case):
    code, said, error = messages[case]
    program, _, message = said.partition(": error: ")
    assert program.startswith("antires")
    assert error.argument == WRONG[case][0]
    assert all((error.argument, error.got, error.wanted, error.remedy))
    assert message == f"{error.argument}: got {error.got}; wanted {error.wanted}. {error.remedy}"
    assert "\n" not in said
    assert code in (1, 2)
    assert (code == 1) <= ("npz" in message)  # 1 is for files that cannot be used


def test_there_are_forty_and_the_messages_are_those_that_were_looked_at(messages):
    assert len(messages) >= 40
    compare(
        Path(__file__).with_name("wrong_calls.txt"),
        {case: f"exit {code}  {said}" for case, (code, said, _) in messages.items()},
    )
