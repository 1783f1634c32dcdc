"""Ctrl-C at random times into ``antires update``: how long until it has ended, and what it leaves.

Each run is a process of its own that is sent SIGINT during an endless search. The clock starts with the
signal and stops when the process has ended, with its result, summary and checkpoint written. The checkpoint
is then taken up again for one second.

Run: ``python -m benchmarks.interrupt_study [RUNS]``, 20 by default.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import antires_rs as ar
from antires_rs.optimize.checkpoint import Checkpoint
from benchmarks.chain8_job import MEASURED, UPDATING

#: A search that no rule of its own would end.
JOB = (
    MEASURED
    + UPDATING
    + """\
patience = 1_000_000_000
max_evaluations = 1_000_000_000_000
"""
)
# A process in the background inherits that SIGINT is ignored; a terminal's does not.
ANTIRES = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "from antires_rs.app.main import main; sys.exit(main(sys.argv[1:]))"
)


def interrupted(folder: Path, after_s: float) -> float:
    """Seconds from the signal to the end of one run; what it left is checked."""
    record = folder / "job_results" / "run.json"
    with subprocess.Popen(
        [sys.executable, "-c", ANTIRES, "update", "job.toml", "--fresh"],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        while not (record.exists() and "searching" in record.read_text()):
            time.sleep(0.005)
        time.sleep(after_s)
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1]
        took = time.monotonic() - start
    assert process.returncode == 130, said
    best = ar.UpdateResult.load(folder / "job_results" / "result.npz")
    assert best.status == "interrupted"
    assert best.problem.cost(best.x) == best.fun
    assert Checkpoint(folder / "job_results" / "search.ckpt").resume is not None
    assert not list((folder / "job_results").glob(".*"))
    again = ar.update(
        best.problem,
        optimizer=ar.IslandGA(patience=1_000_000_000, max_evaluations=1_000_000_000_000, max_seconds=1.0),
        rng=best.seed,
        checkpoint=folder / "job_results" / "search.ckpt",
    )
    assert again.nfev > best.nfev
    assert again.fun <= best.fun
    return took


def main(runs: int = 20) -> None:
    """Print the times."""
    rng = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ar.cases.chain8(perturbation=0.08, rng=0).exact(0).save(folder / "measured.json")
        (folder / "job.toml").write_text(JOB, encoding="utf-8")
        took = []
        for after_s in rng.uniform(0.0, 4.0, runs):
            took.append(interrupted(folder, after_s))
            record = folder / "job_results" / "run.json"
            record.write_text(record.read_text().replace("searching", "ended"))
    print(
        f"{runs} times SIGINT, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}: median "
        f"{np.median(took):.3f} s, 95 % {np.percentile(took, 95):.3f} s, largest {max(took):.3f} s; "
        f"{runs} valid checkpoints and results"
    )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
