"""Slips of someone who hits a frame: each is named by the command that was given it."""

import os
import time

import numpy as np
import pytest
from scipy.signal import decimate

import antires_rs as ar
from antires_rs.app.main import main
from antires_rs.app.parser import nearest

BAND = ["--band", "2", "16"]
NAMES = ["CH2", "CH3", "CH5"]


def hit(number, noise=5e-5):
    """Velocities of three floors, of which the middle one is hit, at 100 Hz."""
    rng = np.random.default_rng(number)
    frame = ar.MassSpringChain([4.0, 4.0, 3.5], [12e3, 11e3], ground_first_n_per_m=14e3)
    modes = frame.modes()
    shapes, omega = modes.shapes.real.T, 2 * np.pi * modes.freq_hz
    t = np.arange(120_000) / 2000.0
    rings = np.exp(-0.01 * omega * t[:, None]) * np.cos(omega * t[:, None])
    rows = (shapes * shapes[1] / np.diag(shapes.T @ frame.mass() @ shapes)) @ rings.T
    rows = np.hstack([np.zeros((3, 6000)), rows[:, :-6000]])
    rows = decimate(rows, 20, ftype="fir") * rng.uniform(0.7, 1.3)
    return rows + noise * rng.standard_normal(rows.shape)


def written(file, rows, fs_hz=100.0, unit="cm/s", extra=()):
    """A table with a time, named channels and their units."""
    columns = [np.arange(rows.shape[1]) / fs_hz, *rows]
    names = ["time [s]", *(f"{name} [{unit}]" for name in [*NAMES, *extra])]
    np.savetxt(file, np.array(columns).T, delimiter=",", header=",".join(names), comments="", fmt="%.9g")
    past = time.time() - 60.0
    os.utime(file, (past, past))
    return str(file)


@pytest.fixture
def heard(capsys):
    """What the command of these arguments says, and that it did not fail."""

    def call(*args):
        code = main(list(map(str, args)))
        said = "".join(capsys.readouterr())
        assert code == 0, said
        return said

    return call


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
def test_watch_says_why_a_test_is_not_to_be_trusted(tmp_path, heard):
    folder = tmp_path / "hits"
    folder.mkdir()
    for number in range(8):
        written(folder / f"hit_{number}.csv", hit(number))
    command = ["watch", folder, "--excitation", "CH3", *BAND, "--once", "--out", tmp_path / "out"]
    assert "8 of 50 baseline tests, 0 failed; 42 more are needed, or give --baseline N" in heard(*command)
    written(folder / "hit_8.csv", hit(8))
    written(folder / "hit_9.csv", hit(9)[[0, 2, 1]])  # CH3 and CH5 exchanged
    written(folder / "hit_10.csv", decimate(hit(10), 2, ftype="fir"), fs_hz=50.0)
    lines = heard(*command, "--baseline", "8").splitlines()
    good, exchanged, slow = (next(x for x in lines if x.startswith(f"hit_{i}.csv: ")) for i in (8, 9, 10))
    assert "do not trust" not in good
    assert "baseline" not in good
    assert "; do not trust the place of the force (force_location): The force does not seem" in exchanged
    assert "; 50 Hz, the baseline has 100 Hz" in slow


def test_a_force_that_is_a_response_and_a_unit_that_the_file_denies(tmp_path, heard):
    file = written(tmp_path / "hit.csv", np.vstack([hit(0), hit(1)[:1]]), extra=["CH6"])
    call = ["identify", file, "--excitation", "CH3", *BAND]
    right = heard(*call, "--dof", "CH6=")
    assert "other_unit" not in right
    assert "unit: 'm/s'; " in (said := heard(*call, "--dof", "CH6=", "--unit", "m/s"))
    assert "hit.csv' says cm/s, which was not used" in said
    assert "other_unit" not in heard(*call, "--dof", "CH6=", "--unit", "cm/s")
    assert "force: 'CH6' is in cm/s, no force" in heard(*call, "--force", "CH6")


def test_where_the_place_of_the_force_is_not_tested(tmp_path, heard):
    file = written(tmp_path / "hit.csv", hit(0))
    untested = "the place of the force could not be tested"
    assert untested not in heard("identify", file, "--excitation", "CH3", *BAND)
    said = heard("identify", file, "--excitation", "ch3", *BAND)
    assert "Did you mean 'CH3'?" in said
    assert f"{untested}: the response at dof 'ch3'" in said


def test_a_dead_channel_is_the_one_not_to_be_trusted(tmp_path, heard):
    noise = 5e-5 * np.random.default_rng(9).standard_normal((1, 6000))
    file = written(tmp_path / "hit.csv", np.vstack([hit(0), noise]), extra=["CH6"])
    said = heard("identify", file, "--excitation", "CH3", *BAND)
    assert "do not trust dof CH6 (dead_channel): Dof 'CH6' holds only noise" in said
    assert "do not trust:" not in said


def test_channels_of_noise_are_called_so_and_no_length_is_blamed(tmp_path, heard):
    rng = np.random.default_rng(3)
    rows = hit(0, noise=0.0) * 1e-3 + 5e-4 * rng.standard_normal((3, 6000))
    said = heard("identify", written(tmp_path / "weak.csv", rows), "--excitation", "CH3", *BAND)
    assert "The channels hold noise: the responses rise over" in said
    assert "too short" not in said


def test_the_file_that_does_not_decay_is_named(tmp_path, capsys):
    steady = 1e-2 * np.random.default_rng(5).standard_normal((3, 6000))
    files = [written(tmp_path / f"hit_{i}.csv", hit(i)) for i in range(2)]
    files.append(written(tmp_path / "steady.csv", steady))
    assert main(["identify", *files, "--excitation", "CH3", *BAND]) != 0
    said = capsys.readouterr().err
    assert "--method: got 'auto' for records" in said
    assert "the first of these is record steady.csv)" in said
    assert "say --method transient or --method welch" in said


def test_hints_name_both_of_two_names_that_are_as_near():
    known = ("masses_kg", "ground_first_n_per_m", "ground_last_n_per_m")
    assert nearest("ground_n_per_m", known) == "Did you mean 'ground_first_n_per_m' or 'ground_last_n_per_m'?"
    assert nearest("ground_last_n_pr_m", known) == "Did you mean 'ground_last_n_per_m'?"
    assert nearest("wind", known) == ""
