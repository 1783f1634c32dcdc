"""Impacts in a file each, as one [data] of a job and as files of one command."""

import json

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from antires_rs.app.job import read_job
from antires_rs.app.reading import measured_of
from antires_rs.app.run import measurement_of
from antires_rs.exceptions import InvalidInputError
from reference.virtual_records import chain8_matrices, hit_record
from tests.support.job_files import DAMAGE

DATA = """[data]
file = "hit_0.npz"
repeats = {repeats}
excitation = 0
band_hz = [3.0, 130.0]
"""


@pytest.fixture
def impacts(tmp_path):
    stiffness, mass = chain8_matrices()
    records = [
        ar.Recording(hit_record(stiffness, mass, duration_s=16.0, noise=0.01, seed=seed)[0][:4], 512.0)
        for seed in range(4)
    ]
    for i, rec in enumerate(records):
        ar.write_npz(tmp_path / f"hit_{i}.npz", rec)
    return records


def measured(folder, repeats):
    path = folder / "job.toml"
    data = DATA.format(repeats=json.dumps(repeats))
    path.write_text(DAMAGE.replace('[data]\nfile = "measured.json"\n', data), encoding="utf-8")
    job = read_job(path)
    return job, measured_of(job, None)


def test_repeats_of_a_job(tmp_path, impacts):
    wanted = ar.identify_antiresonances(impacts, excitation=0, band_hz=(3, 130))
    # A pattern takes the first file up too, which is not read twice.
    job, (one,) = measured(tmp_path, ["hit_*.npz"])
    assert one.found == wanted
    assert [path.name for path in one.repeats] == ["hit_1.npz", "hit_2.npz", "hit_3.npz"]
    facts = measurement_of([one])[0]
    assert facts["File"] == [f"hit_{i}.npz" for i in range(4)]
    assert facts["Record"][0].startswith("4 records of one test, together 64 s at 512 Hz")
    _, (same,) = measured(tmp_path, ["hit_1.npz", "hit_2.npz", "hit_3.npz"])
    assert same.found == wanted
    _, (two,) = measured(tmp_path, "hit_1.npz")
    assert two.found == ar.identify_antiresonances(impacts[:2], excitation=0, band_hz=(3, 130))


def test_wrong_repeats_are_named_where_they_stand(tmp_path, impacts):
    with pytest.raises(InvalidInputError, match=r"job.toml, line 3, .data. repeats\[0\]: got 'hit_9.npz'"):
        measured(tmp_path, ["hit_9.npz"])
    with pytest.raises(InvalidInputError, match=r"repeats\[0\]: got \"miss_\*.npz\""):
        measured(tmp_path, ["miss_*.npz"])
    ar.write_npz(tmp_path / "other.npz", ar.Recording(np.random.default_rng(0).random((4, 999)), 100.0))
    with pytest.raises(InvalidInputError, match=r"repeats\[1\]: got a sampling rate of 100 Hz"):
        measured(tmp_path, ["hit_1.npz", "other.npz"])


def test_files_of_one_command(tmp_path, impacts, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    files = [f"hit_{i}.npz" for i in range(4)]
    options = ["--band", "3", "130", "--excitation", "0"]
    assert cli.main(["identify", *files, *options]) == 0
    found = ar.identify_antiresonances(impacts, excitation=0, band_hz=(3, 130))
    assert capsys.readouterr().out.rstrip("\n") == str(found)
    (tmp_path / "job.toml").write_text("", encoding="utf-8")
    assert cli.main(["identify", files[0], "job.toml", *options]) == 2
    assert "FILE: got 'job.toml' among several" in capsys.readouterr().err
