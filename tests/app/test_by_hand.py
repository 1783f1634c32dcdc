"""Values that a job drops and adds."""

import json

import pytest

import antires_rs as ar
from antires_rs.app.job import read_job
from antires_rs.app.reading import measured_of
from antires_rs.exceptions import InvalidInputError
from tests.support.four_masses import BAND, chain, exact, record
from tests.support.job_files import DAMAGE, run, write_measured

DATA = '[data]\nfile = "{file}"\n{more}\n'
OF_A_RECORD = f"excitation = 0\nband_hz = [{BAND[0]}, {BAND[1]}]\n"


def job_with(folder, more, file="measured.json"):
    path = folder / "job.toml"
    head, found, tail = DAMAGE.partition('[data]\nfile = "measured.json"\n')
    assert found
    path.write_text(head + DATA.format(file=file, more=more) + tail, encoding="utf-8")
    return read_job(path)


def measured(job):
    return [one.found for one in measured_of(job, None)]


@pytest.fixture
def saved(tmp_path):
    zeros = exact(chain())
    zeros.save(tmp_path / "measured.json")
    return zeros


def test_values_are_dropped_and_added_with_their_reasons(tmp_path, saved):
    value = float(saved[1][0])
    drop, add = json.dumps([f"1={value:.3f} mains hum"]), json.dumps("0 = 3.21 clear in the phase")
    (found,) = measured(job_with(tmp_path, f"drop = {drop}\nadd = {add}"))
    assert [str(edit) for edit in found.edits] == [
        f"dropped {value:.2f} Hz at dof 1 (mains hum)", "added 3.21 Hz at dof 0 (clear in the phase)",
    ]  # fmt: skip
    assert found.edits[0].freq_hz == value
    assert found.original() == saved
    assert measured(job_with(tmp_path, ""))[0] == saved


def test_what_was_identified_can_be_edited_too(tmp_path):
    ar.write_npz(tmp_path / "record.npz", record())
    (plain,) = measured(job_with(tmp_path, OF_A_RECORD, "record.npz"))
    value = float(plain[0][0])
    (found,) = measured(job_with(tmp_path, OF_A_RECORD + f'drop = "0={value:.2f}"\n', "record.npz"))
    assert found[0].tolist() == plain[0][1:].tolist()
    assert found.diagrams.keys() == plain.diagrams.keys()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ('drop = ["0=55"]', "drop[0] (line"),
        ('drop = ["0 55"]', "DOF=HZ"),
        ('add = ["0=x"]', "DOF=HZ"),
        ("add = [3.2]", "add"),
        ('drop = ["9=3.2"]', "one of"),
    ],
)
def test_edits_that_cannot_be_made_name_their_line(tmp_path, saved, more, said):
    with pytest.raises(InvalidInputError) as info:
        measured(job_with(tmp_path, more))
    assert said.partition(" (")[0] in str(info.value)
    assert "line" in str(info.value)


def test_the_result_keeps_what_was_edited(tmp_path):
    write_measured(tmp_path)
    value = float(ar.AntiresonanceSet.load(tmp_path / "measured.json")[1][0])
    more = f'file = "measured.json"\ndrop = ["1={value:.3f} mains hum"]\n'
    run(tmp_path, DAMAGE.replace('file = "measured.json"\n', more))
    kept = ar.AntiresonanceSet.load(tmp_path / "job_results" / "antiresonances.json")
    assert [edit.reason for edit in kept.edits] == ["mains hum"]
