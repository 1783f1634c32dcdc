"""Many tests on the command line: ``antires watch``, as files come, and ``antires series``, as a job says."""

import json
import os
import shutil
import time

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app.main import main
from antires_rs.app.watch import Arrivals
from antires_rs.watch import sources as one_test
from reference.small_records import OPTIONS, record
from tests.support.job_files import SERIES

pytest.importorskip("pyarrow")

GIVEN = ["--excitation", "0", "--band", "5", "110"]
MASSES, SPRINGS = [1.0, 1.1, 0.9, 1.0], [5e4, 5.5e4, 4.5e4]


def written(folder, number, loss=0.0):
    chain = ar.MassSpringChain(MASSES, [SPRINGS[0], SPRINGS[1] * (1 - loss), SPRINGS[2]])
    made = {"fs_hz": 256.0, "duration_s": 16.0, "damping_ratio": 0.01, "noise": 0.01}
    path = ar.write_npz(folder / f"test_{number}.npz", chain.simulate(excitation=0, **made, rng=number))
    aged(path)
    return path


def aged(path):
    past = time.time() - 60.0
    os.utime(path, (past, past))


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
def test_files_are_judged_as_they_come(tmp_path, capsys):
    folder, out = tmp_path / "records", tmp_path / "out"
    folder.mkdir()
    command = ["watch", str(folder), *GIVEN, "--baseline", "9", "--out", str(out), "--once"]
    for number in range(8):
        written(folder, number)
    assert main(command) == 0
    assert "8 of 9 baseline tests" in "".join(capsys.readouterr())
    kept = (out / "series.parquet").stat().st_mtime_ns
    written(folder, 8)
    written(folder, 9, loss=0.1)
    (folder / "test_10.npz").write_bytes(b"half a file")
    aged(folder / "test_10.npz")
    assert main(command) == 0
    said = "".join(capsys.readouterr())
    assert "test_9.npz: ALARM" in said
    assert "test_10.npz: failed" in said
    assert "are needed to rely on it" in said
    assert (out / "series.parquet").stat().st_mtime_ns > kept
    assert "1 of 1 tests outside the baseline alarm" in (out / "watch.html").read_text()


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
def test_output_in_the_folder_an_assessor_files_that_go_and_lines_told_once(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(ar.Watched, "report", lambda *_: None)  # a page of another test
    files = [written(tmp_path, number, loss=0.1 * (number == 9)) for number in range(10)]
    before = ar.identify_antiresonances(ar.read_npz(files[0]), excitation=0, band_hz=(5, 110))
    out = tmp_path / "results" / "watched"
    out.mkdir(parents=True)
    plan = ar.Assessor(ar.MassSpringChain(MASSES, SPRINGS), baseline=before).save(out / "plan.npz")
    command = ["watch", str(tmp_path), *GIVEN, "--baseline", "9", "--out", str(out), "--once"]
    command += ["--assessor", str(plan)]
    assert main(command) == 0
    assert "spring 1 has lost" in "".join(capsys.readouterr()).split("test_9.npz: ALARM")[1].splitlines()[1]
    for name in ("test_3.npz", "test_5.npz"):  # kept elsewhere since they were judged
        (tmp_path / name).unlink()
    shutil.copy2(files[8], tmp_path / "test_10.npz")
    assert main(command) == 0
    said = "".join(capsys.readouterr())
    assert "test_10.npz: " in said
    assert "test_9.npz: " not in said
    series = ar.Series.load(out / "series.parquet")
    assert series.names == tuple(f"test_{i}.npz" for i in range(11))
    assert not series.failed


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
def test_a_table_that_is_being_written_is_read_again(tmp_path, capsys, monkeypatch):
    folder, table = tmp_path / "records", tmp_path / "weather.csv"
    folder.mkdir()
    for number in range(2):
        written(folder, number)
    contents = ["name,t\n", "name,t\ntest_0,1\ntest_1", "name,t\ntest_0,1\ntest_1,2\n", None]
    table.write_text(contents.pop(0))
    looks = []

    def wait(seconds):
        looks.append("".join(capsys.readouterr()))
        if contents[0] is None:
            raise KeyboardInterrupt
        table.write_text(contents.pop(0))

    monkeypatch.setattr("antires_rs.app.watch.time.sleep", wait)
    command = ["watch", str(folder), *GIVEN, "--out", str(tmp_path / "out")]
    assert main([*command, "--conditions", str(table)]) == 130
    assert ["read again at the next look" in said for said in looks] == [True, True, False]
    assert "2 of 50 baseline tests" in looks[2]
    table.write_text("name,t\n")
    assert main([*command, "--conditions", str(table), "--once"]) == 2


def test_a_file_that_grows_is_left_alone(tmp_path):
    done, grows = tmp_path / "a.npz", tmp_path / "b.npz"
    done.write_bytes(b"1")
    aged(done)
    grows.write_bytes(b"1")
    (tmp_path / "notes.txt~").write_bytes(b"1")
    arrivals = Arrivals(tmp_path)
    assert arrivals.complete() == [done]
    assert arrivals.growing
    os.utime(grows, 2 * (time.time() + 3600.0,))  # by a clock that is ahead
    assert arrivals.complete() == [done, grows]
    assert not arrivals.growing


@pytest.mark.skipif(os.name != "posix", reason="pipes and links of POSIX")
@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
def test_files_that_will_never_be_read_are_told_and_set_aside(tmp_path, capsys, monkeypatch):
    folder = tmp_path / "records"
    folder.mkdir()
    written(folder, 0)
    os.mkfifo(folder / "pipe.npz")
    (folder / "link.npz").symlink_to("nowhere")
    (folder / "a\x1b[2J\nall.npz").write_bytes(b"torn")
    np.savez_compressed(folder / "large.npz", fs=256.0, a=np.zeros((4, 200_000)))
    (folder / "memory.npz").write_bytes((folder / "test_0.npz").read_bytes())
    for file in filter(os.path.exists, folder.iterdir()):
        aged(file)
    os.utime(folder / "test_0.npz", 2 * (time.time() + 9e8,))  # dated in the future
    monkeypatch.setenv("ANTIRES_MAX_BYTES", "1e6")
    reader = one_test.READERS["npz"]

    def read(path, **options):
        if path.name == "memory.npz":
            raise MemoryError
        return reader(path, **options)

    monkeypatch.setitem(one_test.READERS, "npz", read)
    assert main(["watch", str(folder), *GIVEN, "--once", "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    for name in ("pipe", "link", "large", "memory"):
        assert f"\n{name}.npz: failed, " in f"\n{said}"
    assert r"'a\x1b[2J\nall.npz': failed, " in said
    assert "\x1b" not in said
    assert list(ar.Series.load(tmp_path / "out" / "series.parquet").failed) == [0, 1, 2, 3, 4]


def test_files_are_read_as_identify_reads_them_and_what_fails_is_told(tmp_path, capsys):
    folder = tmp_path / "records"
    folder.mkdir()
    for number in range(2):
        record = ar.read_npz(written(tmp_path, number))
        table = folder / f"t{number}.csv"
        np.savetxt(table, record.responses.T, delimiter=",", header="a,b,c,d", comments="")
        aged(table)
    (folder / "t2.csv").write_text("no numbers\n")
    aged(folder / "t2.csv")
    command = ["watch", str(folder), "--band", "5", "110", "--once", "--out", str(tmp_path / "out")]
    told = [*command, "--excitation", "a", "--fs", "256", "--formulation", "numerators"]
    for channel, dof in zip("abcd", range(4), strict=True):
        told += ["--dof", f"{channel}={dof}"]
    assert main([*told, "--unit", "m/s2"]) == 0
    said = capsys.readouterr().out
    assert "t2.csv: failed, path: " in said
    assert "3 of 50 baseline tests, 1 failed" in said
    series = ar.Series.load(tmp_path / "out" / "series.parquet")
    assert series.excitation == 0
    assert series.dofs == (0, 1, 2, 3)
    assert {series[i].options["fitted"] for i in (0, 1)} == {"numerators"}
    assert main([*told, "--unit", "m/s2"]) == 0
    assert "t2.csv" not in capsys.readouterr().out  # told once
    assert main([*command, "--excitation", "0", "--out", str(tmp_path / "other")]) == 0
    assert "t0.csv: failed, path: " in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main([*command, "--excitation", "0", "--formulation", "rank1"])
    assert "--formulation" in capsys.readouterr().err


# -- ``antires series``: a job of many tests, its files, and running it again
pytest.importorskip("matplotlib")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "records").mkdir()
    for i in range(3):
        made = record(i)
        named = ar.Recording(made.responses, made.fs_hz, ["tip", "mid", "root"])
        ar.write_npz(tmp_path / "records" / f"test_{i}.npz", named)
    (tmp_path / "records" / "test_3.npz").write_bytes(b"torn")
    rows = "\n".join(f"test_{i},{20 + i}" for i in range(5))
    (tmp_path / "weather.csv").write_text(f"name,temperature_c\n{rows}\n")
    (tmp_path / "job.toml").write_text(SERIES)
    return tmp_path


def test_a_job_of_which_no_test_could_be_identified_has_failed(folder, capsys):
    for i in range(3):
        (folder / "records" / f"test_{i}.npz").write_bytes(b"torn")
    for _ in range(2):  # also when nothing is left to do
        assert main(["series", str(folder / "job.toml")]) == 1
        assert "no test could be identified; of the first: " in capsys.readouterr().err


def test_it_writes_series_summary_and_tracks(folder, capsys, monkeypatch):
    assert main(["series", str(folder / "job.toml")]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert "series of 4 tests, force at 0, 3 responses" in said.out
    results = folder / "job_results"
    assert sorted(os.listdir(results)) == ["pictures", "series.parquet", "summary.json"]
    assert sorted(os.listdir(results / "pictures")) == ["tracks_dof_0.png", "tracks_dof_1.png"]
    series = ar.Series.load(results / "series.parquet")
    assert series[1] == ar.identify_series([record(1)], **OPTIONS)[0]
    assert series.conditions["temperature_c"].tolist() == [20.0, 21.0, 22.0, 23.0]
    assert json.loads((results / "summary.json").read_text())["failed"] == {"test_3.npz": series.failed[3]}
    seen = []
    real = one_test.identify_antiresonances
    monkeypatch.setattr(one_test, "identify_antiresonances", lambda *a, **k: seen.append(a) or real(*a, **k))
    (folder / "records" / "test_4.npz").write_bytes((folder / "records" / "test_0.npz").read_bytes())
    assert main(["resume", str(folder / "job.toml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["tests"] == 5
    assert len(seen) == 1
