"""SIGKILL at random times in the life of a checkpointed run: what is left, and where it goes on to.

A quarter of the trials are ``antires update job.toml`` with a record, which is read and identified, a
quarter the same with antiresonances, report and pictures; half are a script that calls
``ar.update(..., checkpoint=)`` and saves the result. Each has a folder of its own, a checkpoint interval out
of ``INTERVALS_S``, and one to four processes that are killed, each at a time drawn over the whole life of
such a process; then one that is left alone. A job is taken up by ``antires resume``, or, where that says that
nothing waits, by the command that it names; the script by itself. In the end all files must be those of a run
that nobody stopped, byte for byte: only the seconds in ``summary.json`` and the date in ``report.html`` may
differ.

Run: ``python -m benchmarks.kill_study [RUNS] [SEED]``, 100 and 0 by default.
"""

import functools
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.chain8_job import MEASURED, UPDATING

#: At 0 every generation is written, at 2, the default, the search here is written once, at its end.
INTERVALS_S = (0.0, 0.02, 0.2, 2.0)
PHASES = (
    "start-up and imports",
    "reading and identification",
    "search",
    "writing a checkpoint",
    "writing the results",
    "report and pictures",
    "ending",
)
SEARCH = {
    "seed": 3,
    "max_evaluations": 150_000,
    "patience": 5,
    "improvement_tolerance": 0.02,
    "polish": False,
    "workers": 1,
}
RECORD = """\
[output]
report = false
pictures = false
[data]
file = "record.npz"
excitation = 0
band_hz = [3.0, 130.0]
"""
JOB = UPDATING + "".join(f"{key} = {json.dumps(value)}\n" for key, value in SEARCH.items())


def child(log: str, every_s: str, *command: str) -> int:
    """One process: an ``antires`` command, or without one the script; its phases go to the file ``log``."""
    import antires_rs as ar
    from antires_rs.app import main as cli, run, run as drawing
    from antires_rs.optimize.checkpoint import Checkpoint

    phases = os.open(log, os.O_WRONLY | os.O_APPEND)

    def at(phase: str) -> None:
        os.write(phases, f"{phase}\n".encode())

    def announce(owner: object, name: str, phase: str, after: str | None = None) -> None:
        inner = getattr(owner, name)

        @functools.wraps(inner)
        def call(*args: object, **options: object) -> object:
            at(phase)
            value = inner(*args, **options)
            if after:
                at(after)
            return value

        setattr(owner, name, call)

    Checkpoint.__init__ = functools.partialmethod(Checkpoint.__init__, every_s=float(every_s))
    announce(run, "measured_of", "reading and identification")
    announce(run, "update", "search", "writing the results")
    announce(Checkpoint, "store", "writing a checkpoint", "search")
    announce(drawing, "draw", "report and pictures", "ending")
    if command:
        return cli.main(command)
    problem = ar.cases.chain8(perturbation=0.08, rng=1).updating_problem()
    options = {key: value for key, value in SEARCH.items() if key not in ("seed", "workers")}
    at("search")
    result = ar.update(
        problem, optimizer=ar.IslandGA(**options), rng=SEARCH["seed"], workers=1, checkpoint="run.ckpt"
    )
    at("writing the results")
    result.save("result.npz")
    at("ending")
    return 0


@dataclass
class Process:
    """How a process ended: killed in a phase, or by itself."""

    phase: str
    killed: bool
    code: int
    said: str
    life_s: float


def process(folder: Path, every_s: float, command: tuple[str, ...], kill_after_s: float | None) -> Process:
    log = folder.with_suffix(".phases")
    log.write_bytes(b"")
    start = time.monotonic()
    with subprocess.Popen(
        [sys.executable, "-m", "benchmarks.kill_study", "child", str(log), str(every_s), *command],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as running:
        if kill_after_s is not None:
            try:
                running.wait(kill_after_s)
            except subprocess.TimeoutExpired:
                running.send_signal(signal.SIGKILL)
        said = running.communicate()[1]
    phases = log.read_text().splitlines()
    return Process(
        phases[-1] if phases else PHASES[0],
        running.returncode == -signal.SIGKILL,
        running.returncode,
        said,
        time.monotonic() - start,
    )


def files_of(folder: Path) -> dict[str, bytes]:
    """All files by name, without what a clock wrote."""
    found = {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
    for name, data in found.items():
        if name.endswith("summary.json"):
            found[name] = re.sub(rb'"seconds": [\d.]+', b'"seconds": 0', data)
        elif name.endswith("report.html"):
            found[name] = re.sub(rb"\d{4}-\d\d-\d\d \d\d:\d\d UTC", b"DATE", data)
    return found


@dataclass
class Kind:
    """Jobs or scripts: how they begin and go on, the files and the seconds of one that nobody stopped."""

    name: str
    begin: tuple[str, ...]
    resume: tuple[str, ...]
    fill: Callable[[Path], object]
    share: int
    files: dict[str, bytes] = field(default_factory=dict)
    life_s: float = 0.0


@dataclass
class Count:
    """What was seen over the trials of a kind."""

    trials: int = 0
    same: int = 0
    ended_first: int = 0
    phases: Counter[str] = field(default_factory=Counter)
    ways: Counter[str] = field(default_factory=Counter)
    kills: Counter[int] = field(default_factory=Counter)
    left: Counter[str] = field(default_factory=Counter)


def whole(kind: Kind, folder: Path) -> None:
    """Run a kind three times undisturbed: its files must be the same each time."""
    lives = []
    for i in range(3):
        own = folder / f"{kind.name}{i}"
        own.mkdir()
        kind.fill(own)
        done = process(own, INTERVALS_S[i], kind.begin, None)
        assert done.code == 0, done.said
        assert not kind.files or differences(kind.files, files_of(own)) == [], "runs differ by themselves"
        kind.files = files_of(own)
        lives.append(done.life_s)
    kind.life_s = float(np.median(lives))


def differences(wanted: dict[str, bytes], got: dict[str, bytes]) -> list[str]:
    return sorted(name for name in wanted.keys() | got.keys() if wanted.get(name) != got.get(name))


def trial(kind: Kind, folder: Path, rng: np.random.Generator, count: Count) -> list[str]:
    """Kill, go on, compare; returns what is wrong."""
    folder.mkdir()
    kind.fill(folder)
    every_s, kills = float(rng.choice(INTERVALS_S)), int(rng.choice([1, 1, 1, 2, 3, 4]))
    command, happened = kind.begin, 0
    while happened < kills:
        ran = process(folder, every_s, command, float(rng.uniform(0.0, kind.life_s)))
        command, told = way_on(kind, command, ran, count)
        if told:
            continue
        if not ran.killed:
            count.ended_first += 1
            if ran.code != 0:
                return [f"{' '.join(command)}: exit code {ran.code}: {ran.said.strip()}"]
            if happened:
                break  # the chain is over before its last kill
            return []  # no kill at all: not a trial
        happened += 1
        count.phases[ran.phase] += 1
        if happened == kills:
            count.left.update(name_of(path) for path in folder.rglob("*") if unfinished(path))
    ran = process(folder, every_s, command, None)
    command, told = way_on(kind, command, ran, count)
    if told:
        ran = process(folder, every_s, command, None)
    count.trials += 1
    count.kills[happened] += 1
    count.ways[command[0] if command else "the script again"] += 1
    wrong = [f"{' '.join(command)}: exit code {ran.code}: {ran.said.strip()}"] if ran.code else []
    wrong += [f"{name} differs" for name in differences(kind.files, files_of(folder))]
    count.same += not wrong
    return wrong


def way_on(kind: Kind, command: tuple[str, ...], ran: Process, count: Count) -> tuple[tuple[str, ...], bool]:
    """The command that goes on, and whether the process only said so."""
    if ran.code == 2 and command == kind.resume and "Begin with 'antires update job.toml'" in ran.said:
        return kind.begin, True
    return (kind.resume if ran.killed else command), False


def unfinished(path: Path) -> bool:
    return path.name.endswith((".tmp", ".ckpt"))


def name_of(path: Path) -> str:
    return re.sub(r"\.\d+\.tmp$", ".PID.tmp", path.name)


def main(runs: int = 100, seed: int = 0) -> int:
    """Print what was found; returns the number of trials that did not end in the same files."""
    import antires_rs as ar

    rng = np.random.default_rng(seed)
    record = ar.cases.chain8(perturbation=0.08, rng=1).experiment(duration_s=64.0, noise=0.01, rng=1)

    def read(folder: Path) -> None:
        ar.write_npz(folder / "record.npz", record)
        (folder / "job.toml").write_text(RECORD + JOB, encoding="utf-8")

    def drawn(folder: Path) -> None:
        ar.cases.chain8(perturbation=0.08, rng=1).exact(0).save(folder / "measured.json")
        (folder / "job.toml").write_text(MEASURED + JOB, encoding="utf-8")

    commands = ("update", "job.toml"), ("resume", "job.toml")
    kinds = (
        Kind("record", *commands, read, 1),
        Kind("drawn", *commands, drawn, 1),
        Kind("script", (), (), lambda folder: None, 2),
    )
    counts = {kind.name: Count() for kind in kinds}
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        for kind in kinds:
            whole(kind, Path(name))
            print(f"{kind.name}: {kind.life_s:.1f} s undisturbed; {', '.join(kind.files)}", flush=True)
        number = 0
        while sum(count.trials for count in counts.values()) < runs:
            kind = min(kinds, key=lambda kind: counts[kind.name].trials / kind.share)
            number += 1
            for wrong in trial(kind, Path(name) / f"trial{number}", rng, counts[kind.name]):
                print(f"trial {number}, {kind.name}: {wrong}", flush=True)
    tell(counts, time.monotonic() - start)
    return runs - sum(count.same for count in counts.values())


def tell(counts: dict[str, Count], seconds: float) -> None:
    names = list(counts)
    width = max(map(len, PHASES))
    print(f"\n{'killed in':<{width}}  " + "  ".join(f"{name:>8}" for name in names))
    for phase in PHASES:
        print(f"{phase:<{width}}  " + "  ".join(f"{counts[name].phases[phase]:>8}" for name in names))
    print(f"{'all kills':<{width}}  " + "  ".join(f"{counts[name].phases.total():>8}" for name in names))
    for name, count in counts.items():
        print(
            f"\n{name}: {count.trials} trials, {count.same} ended in the files of the undisturbed run. "
            f"Kills in one trial: {dict(sorted(count.kills.items()))}. Went on by: {dict(count.ways)}. "
            f"Processes that had ended before their kill: {count.ended_first}. "
            f"Found after the last kill: {dict(sorted(count.left.items()))}."
        )
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}, {seconds:.0f} s")


if __name__ == "__main__":
    sys.exit(child(*sys.argv[2:]) if sys.argv[1:2] == ["child"] else main(*map(int, sys.argv[1:])))
