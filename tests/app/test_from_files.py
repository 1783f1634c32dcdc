"""What `antires init` and `antires identify` take from a measurement, and what they leave to the user."""

import json
import tomllib

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app import main as cli

pytest.importorskip("pyuff")


def test_init_lists_the_channels_of_a_measurement(tmp_path, capsys):
    record = ar.Recording(np.random.default_rng(0).standard_normal((2, 64)), 32.0, ["tip [g]", 'a"b'])
    (tmp_path / "data").mkdir()
    ar.write_npz(tmp_path / "data" / "record.npz", record)
    job = tmp_path / "job.toml"
    assert cli.main(["init", str(job), "--data", str(tmp_path / "data" / "record.npz")]) == 0
    assert f"antires damage {job}" in capsys.readouterr().out
    data = tomllib.loads(job.read_text())["data"]
    assert (data["file"], data["dofs"]) == ("data/record.npz", {"tip [g]": "?", 'a"b': "?"})
    assert data["excitation"] == "?"
    assert cli.main(["damage", str(job)]) == 2
    assert "got '?', where the dof is not given yet" in capsys.readouterr().err
    # Dofs that are numbers need no table.
    ar.write_npz(tmp_path / "record.npz", ar.Recording(record.responses, 32.0))
    assert cli.main(["init", str(job), "--data", str(tmp_path / "record.npz"), "--overwrite"]) == 0
    assert "dofs" not in tomllib.loads(job.read_text())["data"]


def impact_file(tmp_path):
    """FRFs of a frame between nodes of the file, the force at node 3 along y."""
    rod = ar.Tube(0.02, 0.01, 2.1e11, 7850.0)
    frame = ar.FrameModel([(0.2 * i, 0.0) for i in range(6)], [(i, i + 1) for i in range(5)], rod, fixed=[0])
    freq = np.arange(1.0, 400.0, 0.25)
    places = {f"{node}+Y": frame.dof(node, "v") for node in (1, 2, 3, 4, 5)}
    values = frame.frf(list(places.values()), frame.dof(3, "v"), freq, damping_ratio=0.01)
    response = ar.FrequencyResponse(freq, values, dofs=list(places))
    return ar.write_uff(tmp_path / "a.uff", response, excitation="3+Y")


def test_init_takes_the_force_from_the_file_and_leaves_dofs_open(tmp_path, capsys):
    file = impact_file(tmp_path)
    job = tmp_path / "job.toml"
    assert cli.main(["init", str(job), "--model", "frame", "--data", str(file)]) == 0
    text = job.read_text()
    data = tomllib.loads(text)["data"]
    assert data["excitation"] == "3+Y"
    assert data["dofs"] == {f"{node}+Y": "?" for node in (1, 2, 3, 4, 5)}
    assert '"1+Y" = "1 v"' in text
    assert all(line.startswith("#") for line in text.splitlines() if '"1 v"' in line)
    capsys.readouterr()
    assert cli.main(["damage", str(job)]) == 2
    assert "'?' for '1+Y', '2+Y'" in capsys.readouterr().err


def test_identify_takes_the_force_from_the_file(tmp_path, capsys):
    file = impact_file(tmp_path)
    assert cli.main(["identify", str(file), "--band", "5", "350", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["excitation"] == "3+Y"
