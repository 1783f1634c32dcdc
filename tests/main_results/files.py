"""Files of every kind that is kept, as a version writes them, and what is read back from them."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import antires_rs as ar
from reference.small_records import OPTIONS, record
from reference.wrong_chains import NOMINAL, chain, measured, truth

FOLDER = Path(__file__).with_name("files_0")
#: An assessor's file grows with the square of its model.
SHORT = ar.MassSpringChain([0.8, 0.5, 0.6], [4e4, 6e4], ground_first_n_per_m=3e4)


def of_short(loss: float = 0.0) -> ar.AntiresonanceSet:
    """Values of the short chain, its second spring softened."""
    dofs = range(3)
    zeros = SHORT.with_parameters(ar.stiffness_reduction(1), loss).antiresonances(dofs, 0)
    return ar.AntiresonanceSet(
        0, dict(zip(dofs, zeros, strict=True)), std_hz={dof: 3e-4 * zeros[dof] for dof in dofs}
    )


def write(folder: Path) -> None:
    """One file of each kind, into an empty folder."""
    folder.mkdir(exist_ok=True)
    ar.identify_antiresonances(record(730), **OPTIONS).save(folder / "zeros.json")
    case = ar.cases.chain8()
    problem = case.damage_problem(case.exact(1))
    ga = ar.IslandGA(max_evaluations=600)
    ar.update(problem, optimizer=ga, rng=5).save(folder / "updated.npz")
    ar.update(problem, optimizer=ga, rng=5, checkpoint=folder / "search.ckpt")
    rng, factors = truth(890)
    before, now = measured(chain(factors), rng), measured(chain(factors, [0, 0.3, 0, 0, 0]), rng)
    ar.assess_damage(NOMINAL, now, baseline=before, workers=1).save(folder / "damage.npz")
    ar.Assessor(SHORT, baseline=of_short(), workers=1).save(folder / "assessor.npz")
    ar.identify_series([record(s) for s in (731, 732)], **OPTIONS).save(folder / "series.parquet")
    ar.write_npz(folder / "record.npz", record(733, duration_s=4.0))
    ar.write_uff(folder / "record.uff", record(733, duration_s=4.0))


def read(folder: Path) -> dict[str, Any]:
    """What the files say, as plain numbers."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        zeros = ar.AntiresonanceSet.load(folder / "zeros.json")
        updated = ar.UpdateResult.load(folder / "updated.npz")
        damage = ar.DamageResult.load(folder / "damage.npz")
        assessor = ar.Assessor.load(folder / "assessor.npz")
        series = ar.Series.load(folder / "series.parquet")
        rec = ar.read_npz(folder / "record.npz")
    return {
        "zeros": {str(dof): zeros[dof].tolist() for dof in zeros},
        "updated": [*updated.x.tolist(), updated.fun],
        "damage": [[list(one.elements), one.probability] for one in damage.hypotheses],
        "assessor": [list(one.elements) for one in assessor.assess(of_short(0.3)).hypotheses][:1],
        "series": [{str(dof): one[dof].tolist() for dof in one} for one in series],
        "record": [rec.fs_hz, float(np.sum(rec.responses**2))],
    }


def job_keys() -> list[str]:
    """Keys of jobs, as ``antires init`` writes them for every task and model."""
    import tempfile

    from antires_rs.app.main import main

    keys = set()
    with tempfile.TemporaryDirectory() as folder:
        for task in ("damage", "update", "series"):
            for model in ("chain", "frame", "matrices", "result"):
                job = Path(folder) / f"{task}_{model}.toml"
                if main(["init", str(job), "--task", task, "--model", model]) == 0:
                    table = ""
                    for line in job.read_text(encoding="utf-8").splitlines():
                        if head := re.match(r"#? ?\[+([\w.]+)\]+", line):
                            table = head[1]
                        elif key := re.match(r"#? ?([a-z_0-9]+) = ", line):
                            keys.add(f"{table}.{key[1]}")
    return sorted(keys)
