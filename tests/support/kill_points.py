"""Kill a run before each change that it makes on the disk, go on, compare the files.

A process of its own: it forks one that is killed and one that goes on for every point, so that the package
is loaded once. ``python -m tests.support.kill_points FOLDER SCENARIO whole|half`` prints the number of points
and what is wrong as JSON; with "half", files that were being written have lost their second half. Scenarios
are those of ``RUNS``.
"""

import contextlib
import io
import json
import os
import re
import shutil
import signal
import sys
from collections.abc import Callable
from functools import partial, partialmethod
from pathlib import Path

import antires_rs as ar
from antires_rs.app import main as cli, run as drawing
from antires_rs.figures import report
from antires_rs.optimize.checkpoint import Checkpoint
from antires_rs.support.files import write_atomically
from antires_rs.watch import sources as one_test
from antires_rs.watch.store import Store
from reference.small_records import OPTIONS, record
from tests.support.job_files import UPDATE, write_measured

#: A few generations, each of which is written; a report and a picture.
SEARCH = {"max_evaluations": 700, "polish": False}
JOB = UPDATE.replace("seed = 1", "seed = SEED\nmax_evaluations = 700\npolish = false\nworkers = 1").replace(
    "report = false\npictures = false", ""
)


def quick() -> None:
    """Everything is written often, and what only takes time to draw is text."""
    Checkpoint.__init__ = partialmethod(Checkpoint.__init__, every_s=0.0)
    report.write_report = lambda result, path, **_: write_atomically(path, repr(result.x).encode())
    drawing.pictures = lambda drawn, folder: write_atomically(folder / "damage.png", b"drawn")


def script(folder: Path) -> int:
    problem = ar.cases.chain8(perturbation=0.08, rng=1).updating_problem()
    ar.update(problem, optimizer=ar.IslandGA(**SEARCH), rng=3, workers=1, checkpoint="run.ckpt").save(
        "result.npz"
    )
    return 0


def job(*command: str) -> Callable[[Path], int]:
    return lambda folder: cli.main(command)


def series(folder: Path, count: int) -> int:
    conditions = {"temperature_c": [20.0 + i for i in range(count)]}
    sources = [folder.parent / f"test_{i}.npz" for i in range(count)]
    ar.identify_series(sources, **OPTIONS, store=folder / "year.parquet", conditions=conditions)
    return 0


RESUMED = job("resume", "job.toml")
#: What was in the folder before: nothing, the results of another seed, a search of it that was stopped; of a
#: series two tests or nothing.
RUNS = {
    "new": job("update", "job.toml"),
    "again": job("update", "job.toml"),
    "fresh": job("update", "job.toml", "--fresh"),
    "script": script,
    "series": partial(series, count=2),
    "longer series": partial(series, count=3),
}


def quick_series(folder: Path) -> None:
    """Records, each identified at once; a transaction counts as a change on the disk too."""
    real = Store._commit

    def commit(db):
        sys.audit("os.rename", str(Path.cwd() / "transaction"))
        real(db)

    Store._commit = staticmethod(commit)
    one_test.identify_antiresonances = lambda signal, **_: ar.AntiresonanceSet(
        0, {0: [2.0 + abs(signal.responses[0, 0])], 1: []}
    )
    for i in range(4):
        ar.write_npz(folder / f"test_{i}.npz", record(i))


def prepare(folder: Path, scenario: str) -> None:
    folder.mkdir()
    if "series" in scenario:
        quick_series(folder.parent)
        if scenario == "longer series":
            assert forked(folder, RUNS["series"])[0] == 0
        return
    if scenario == "script":
        return
    write_measured(folder, level=0, perturbation=0.08)
    job = folder / "job.toml"
    if scenario in ("again", "fresh"):
        job.write_text(JOB.replace("SEED", "4"))
        waits = folder / "job_results" / "search.ckpt"
        if scenario == "again":
            assert forked(folder, RUNS["new"])[0] == 0
        for number in range(1, 100) if scenario == "fresh" else ():
            assert forked(folder, RUNS["fresh"], number)[0] == -signal.SIGKILL
            if waits.exists():
                break
        assert waits.exists() == (scenario == "fresh")
    job.write_text(JOB.replace("SEED", "3"))


def forked(folder: Path, run: Callable[[Path], int], kill_at: int | None = None) -> tuple[int, str]:
    """Exit code (negative for a signal) and standard error of a run, killed before its n-th change."""
    said = folder.with_suffix(".said")
    child = os.fork()
    if child == 0:
        code = 99
        try:
            os.chdir(folder)
            with (
                open(said, "w") as err,
                contextlib.redirect_stdout(io.StringIO()),
                contextlib.redirect_stderr(err),
            ):
                if kill_at is not None:
                    die_before(folder, kill_at)
                code = run(folder)
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), said.read_text()


def die_before(folder: Path, number: int) -> None:
    """Kill this process before its n-th change of a file in the folder."""
    seen = 0

    def watch(event: str, args: tuple) -> None:
        nonlocal seen
        changes = event in ("os.rename", "os.remove", "os.mkdir") or (
            event == "open" and isinstance(args[2], int) and args[2] & (os.O_WRONLY | os.O_RDWR)
        )
        if changes and isinstance(args[0], str | os.PathLike):
            seen += os.path.abspath(args[0]).startswith(str(folder))
            if seen == number:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(watch)


def files_of(folder: Path) -> dict[str, bytes]:
    found = {
        path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }
    return {
        name: re.sub(rb'"seconds": [\d.]+', b"", data) if name.endswith("summary.json") else data
        for name, data in found.items()
    }


def go_on(folder: Path, scenario: str, whole: dict[str, bytes], before: dict[str, bytes]) -> list[str]:
    """Do what a user would, as the messages say; returns what is wrong."""
    run, left = RUNS[scenario], files_of(folder)
    code, said = forked(folder, RESUMED if scenario in ("new", "again", "fresh") else run)
    if code == 2 and "antires update job.toml" not in said and scenario != "fresh":
        return [f"refused without saying how to go on: {said}"]
    if code == 2 or (left == before and files_of(folder) == before):  # nothing of this run had begun
        code, said = forked(folder, run)
    if code or said:
        return [f"exit code {code}: {said}"]
    got = files_of(folder)
    return sorted(name for name in whole.keys() | got.keys() if whole.get(name) != got.get(name))


def main(folder: Path, scenario: str, half: bool) -> None:
    quick()
    start = folder / "start"
    prepare(start, scenario)
    before = files_of(start)
    shutil.copytree(start, folder / "whole")
    code, said = forked(folder / "whole", RUNS[scenario])
    assert code == 0, said
    whole, wrong = files_of(folder / "whole"), {}
    for number in range(1, 1000):
        own = folder / str(number)
        shutil.copytree(start, own)
        if forked(own, RUNS[scenario], kill_at=number)[0] == 0:
            break
        for file in own.rglob("*.tmp") if half else ():
            os.truncate(file, file.stat().st_size // 2)
        found = go_on(own, scenario, whole, before)
        if found:
            wrong[number] = found
    print(json.dumps({"points": number - 1, "wrong": wrong}))


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3] == "half")
