"""``antires series``: a job of many tests, its files, and running it again."""

import json
import os
import re

import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from antires_rs.watch import sources as one_test
from reference.small_records import OPTIONS, record

pytest.importorskip("pyarrow")
pytest.importorskip("matplotlib")

JOB = """\
[data]
file = "records"
excitation = "tip"
band_hz = [0.8, 8.0]
dofs = { "tip" = 0, "middle" = 1, "root" = 2 }
[series]
conditions = "weather.csv"
over = "temperature_c"
[identification]
max_order = 16
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "records").mkdir()
    for i in range(3):
        made = record(i)
        named = ar.Recording(made.responses, made.fs_hz, ["tip", "middle", "root"])
        ar.write_npz(tmp_path / "records" / f"test_{i}.npz", named)
    (tmp_path / "records" / "test_3.npz").write_bytes(b"torn")
    rows = "\n".join(f"test_{i},{20 + i}" for i in range(5))
    (tmp_path / "weather.csv").write_text(f"name,temperature_c\n{rows}\n")
    (tmp_path / "job.toml").write_text(JOB)
    return tmp_path


def test_a_job_of_which_no_test_could_be_identified_has_failed(folder, capsys):
    for i in range(3):
        (folder / "records" / f"test_{i}.npz").write_bytes(b"torn")
    for _ in range(2):  # also when nothing is left to do
        assert cli.main(["series", str(folder / "job.toml")]) == 1
        assert "no test could be identified; of the first: " in capsys.readouterr().err


def test_it_writes_series_summary_and_tracks(folder, capsys, monkeypatch):
    assert cli.main(["series", str(folder / "job.toml")]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert "series of 4 tests, force at 0, 3 responses" in said.out
    results = folder / "job_results"
    assert sorted(os.listdir(results)) == ["pictures", "series.parquet", "summary.json"]
    assert sorted(os.listdir(results / "pictures")) == ["tracks_dof_0.png", "tracks_dof_1.png"]
    series = ar.Series.load(results / "series.parquet")
    alone = ar.identify_series([record(1)], **OPTIONS)
    assert series[1] == alone[0]
    assert series.conditions["temperature_c"].tolist() == [20.0, 21.0, 22.0, 23.0]
    assert json.loads((results / "summary.json").read_text())["failed"] == {"test_3.npz": series.failed[3]}
    # Again, with a file that has come since.
    seen = []
    real = one_test.identify_antiresonances
    monkeypatch.setattr(one_test, "identify_antiresonances", lambda *a, **k: seen.append(a) or real(*a, **k))
    (folder / "records" / "test_4.npz").write_bytes((folder / "records" / "test_0.npz").read_bytes())
    assert cli.main(["resume", str(folder / "job.toml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["tests"] == 5
    assert len(seen) == 1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('"records"', '"nowhere"'), "line 2.*'nowhere'.*does not exist"),
        (('"weather.csv"', '"rain.csv"'), r"line 7.*'rain.csv'"),
        (('over = "temperature_c"', 'over = "wind"'), "line 8.*'temperature_c'"),
        (("[0.8, 8.0]", "[8.0, 0.8]"), "line 4"),
        (("max_order = 16", 'estimator = "h3"'), "line 10"),
        (("[series]", "[damage]"), r"\[damage\]"),
        (('excitation = "tip"\n', ""), "excitation"),
        (("[identification]", "[search]\nseed = 1\n[identification]"), r"\[search\] beside \[series\]"),
    ],
)
def test_wrong_jobs(folder, capsys, change, said):
    job = folder / "job.toml"
    job.write_text(JOB.replace(*change))
    assert cli.main(["series", str(job)]) == 2
    assert re.search(said, " ".join(capsys.readouterr().err.split()))
