"""A folder of files with one FRF each, on the command line and in a job."""

import json

import numpy as np

from antires_rs.app import main as cli
from reference.virtual_records import accelerance, chain8_matrices

FREQ = np.arange(1, 2240) / 16


def test_a_folder_is_identified_on_the_command_line_and_in_a_job(tmp_path, capsys):
    folder = tmp_path / "frfs"
    folder.mkdir()
    for dof, h in enumerate(accelerance(*chain8_matrices(), 0, FREQ, 0.01)[:4]):
        columns = np.c_[FREQ, 20 * np.log10(np.abs(h)), np.degrees(np.angle(h))]
        np.savetxt(folder / f"H_{dof}_0.csv", columns, delimiter=",")
    (tmp_path / "notes.txt").write_text("not in the folder")
    call = ["identify", str(folder), "--band", "3", "130", "--excitation", "0", "--json"]
    assert cli.main([*call, "--pairs", "db_deg"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [row["dof"] for row in found["antiresonances"]] == list(range(4))
    assert cli.main(call) == 1
    assert "--first freq" in capsys.readouterr().err
    job = tmp_path / "job.toml"
    job.write_text(
        '[[data]]\nfile = "frfs"\npairs = "db_deg"\nexcitation = 0\nband_hz = [3.0, 130.0]\n'
        '[model]\nkind = "chain"\nmasses_kg = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]\n'
        "springs_n_per_m = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]\n[damage]\n"
    )
    assert cli.main(["identify", str(job), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["antiresonances"] == found["antiresonances"]
