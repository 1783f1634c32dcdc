"""A small measurement and job for the tests of jobs: an eight-mass chain with a damaged spring."""

import json

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app import main as cli

DAMAGE = """\
[data]
file = "measured.json"

[model]
kind = "chain"
masses_kg = [0.5593, 0.4194, 0.4194, 0.4194, 0.4194, 0.4194, 0.4194, 0.4194]
springs_n_per_m = [56.7e3, 56.7e3, 56.7e3, 56.7e3, 56.7e3, 56.7e3, 56.7e3]

[damage]

[search]
seed = 1

[output]
report = false
pictures = false
"""

FACTORS = '[[parameters]]\nkind = "mass_factor"\nterms = "all"\nbounds = [0.9, 1.1]\n\n'
FACTORS += FACTORS[:-1].replace("mass", "stiffness").replace("terms", "elements")
UPDATE = DAMAGE.replace("[damage]\n", FACTORS)


#: Of tests in records, with a table beside them.
SERIES = """\
[data]
file = "records"
excitation = "tip"
band_hz = [0.8, 8.0]
dofs = { "tip" = 0, "mid" = 1, "root" = 2 }
[series]
conditions = "weather.csv"
over = "temperature_c"
[identification]
max_order = 16
"""


def write_measured(folder, level=1, perturbation=0.0):
    """Exact antiresonances of the chain, as ``antires identify --out`` saves them."""
    ar.cases.chain8(perturbation=perturbation, rng=0).exact(level).save(folder / "measured.json")


def write_record(folder, name="record.npz"):
    """A record short enough to be read at once."""
    noise = np.random.default_rng(0).standard_normal((3, 2048))
    record = ar.Recording(noise, 256.0, dofs=["tip", "mid", "root"])
    {".npz": ar.write_npz, ".uff": ar.write_uff, ".csv": ar.write_csv}[name[name.index(".") :]](
        folder / name, record
    )


def run(folder, text, *arguments, name="job.toml"):
    """Carry out a job; its summary."""
    (folder / name).write_text(text, encoding="utf-8")
    task = "update" if "[[parameters]]" in text else "damage"
    assert cli.main([task, str(folder / name), *arguments]) == 0
    return json.loads((folder / f"{name[:-5]}_results" / "summary.json").read_text())


def losses(summary):
    return {
        row["name"]: pytest.approx(row["stiffness_loss"], abs=1e-3)
        for row in summary["elements"]
        if row["stiffness_loss"] > 0
    }
