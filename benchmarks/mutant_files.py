"""Mutants of every kind of file that is read: crashes, hangs, raw tracebacks and memory are counted.

A good file of each kind is changed in one to four places (bytes replaced, lost, doubled, put in, the rest cut
off), or inside, its checksums made anew, and read in another process, with a limit of 20 s and 1 GB (of the
process and its children). What may come of it: a result, or an error of ours.

    python -m benchmarks.mutant_files --each 30            # ten minutes
    python -m benchmarks.mutant_files --each 300 --kinds mtx mat5
"""

from __future__ import annotations

import argparse
import contextlib
import multiprocessing
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from reference.mutant_kinds import KINDS, outcome

TIME_S, MEMORY_GB = 20.0, 1.0  # of processor time, as others may use the machine
TICKS = os.sysconf("SC_CLK_TCK")
OUTCOMES = ("read", "ours", "RAW", "HANG", "CRASH", "MEMORY")


def reader(kind, connection):
    """Read the files that are named, and tell what came of each; a crash ends this process alone."""
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stderr(nowhere):
        connection.send("begun")
        for path in iter(connection.recv, None):
            connection.send(outcome(kind, Path(path)))


def used(process):
    """Resident memory (GB) and processor time (s) so far of a process and its children, from the system."""
    total_gb = total_s = 0.0
    pids = [process]
    for pid in pids:
        try:
            status = Path(f"/proc/{pid}/status").read_text()
            total_gb += int(status.partition("VmRSS:")[2].split()[0]) / 2**20
            fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
            total_s += sum(map(int, fields[11:15])) / TICKS  # its own, and that of children that ended
            for task in Path(f"/proc/{pid}/task").iterdir():
                pids += map(int, (task / "children").read_text().split())
        except (OSError, IndexError, ValueError):
            continue
    return total_gb, total_s


class Reading:
    """A process that reads files of one kind, begun anew after one that it did not survive."""

    def __init__(self, kind):
        self.kind, self.process = kind, None

    def begin(self):
        """Start the process."""
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=reader, args=(self.kind, theirs), daemon=True)
        self.process.start()
        theirs.close()
        self.connection.recv()

    def end(self):
        """Stop the process."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.process = None

    def read(self, path):
        """What comes of a file, and the error where it is a raw one."""
        if self.process is None:
            self.begin()
        self.connection.send(str(path))
        begun, most, (_, before_s) = time.monotonic(), 0.0, used(self.process.pid)
        while not self.connection.poll(0.02):
            now_gb, now_s = used(self.process.pid)
            most = max(most, now_gb)
            late = now_s - before_s > TIME_S or time.monotonic() - begun > 20.0 * TIME_S  # it waits
            if late or most > MEMORY_GB:
                self.end()
                return ("HANG" if late else "MEMORY"), f"{most:.2f} GB"
        try:
            return self.connection.recv()
        except EOFError:
            self.end()
            return "CRASH", ""


def main():
    """A line for each kind."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--each", type=int, default=30)
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=list(KINDS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for mutants that went wrong")
    options = parser.parse_args()
    print("| kind | mutants | " + " | ".join(OUTCOMES) + " |\n|---|---|" + "---|" * len(OUTCOMES))
    bad = 0
    for kind in options.kinds:
        counts, wrong = dict.fromkeys(OUTCOMES, 0), []
        with tempfile.TemporaryDirectory() as folder:
            whole = KINDS[kind].make(Path(folder))
            good, reading = whole.read_bytes(), Reading(kind)
            if reading.read(whole) != ("read", ""):
                raise SystemExit(f"the good file of {kind} is not read: {outcome(kind, whole)}")
            for number in range(options.each):
                rng = np.random.default_rng([options.seed, list(KINDS).index(kind), number])
                path = Path(folder) / f"mutant{KINDS[kind].ending}"
                path.write_bytes(KINDS[kind].mutate(good, rng))
                what, why = reading.read(path)
                counts[what] += 1
                if what not in ("read", "ours"):
                    wrong.append(f"{kind} {number}: {what} {why}")
                    if options.keep is not None:
                        options.keep.mkdir(parents=True, exist_ok=True)
                        (options.keep / f"{kind}_{number}{path.suffix}").write_bytes(path.read_bytes())
            reading.end()
        bad += len(wrong)
        print(
            f"| {kind} | {options.each} | " + " | ".join(str(counts[w]) for w in OUTCOMES) + " |", flush=True
        )
        for line in wrong[:10]:
            print(f"    {line}", flush=True)
    print(f"\n{bad} of {options.each * len(options.kinds)} went wrong")
    return bool(bad)


if __name__ == "__main__":
    sys.exit(main())
