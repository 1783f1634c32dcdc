"""Fuzzing of what reads files in this process, guided by the lines that are reached (atheris, Linux).

Each kind begins with a good file and what runs before found (``reference/fuzz_corpus``); changes that reach
new lines are changed further. Where a checksum covers a text, or what Rust reads, that is changed, and the
checksum made anew. An error that is not ours, 20 s or 1.5 GB end it; the file is kept.

    python -m benchmarks.fuzz_files --seconds 10              # of each kind
    python -m benchmarks.fuzz_files --seconds 600 --kinds csv "op4 binary" --keep
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

FOUND = Path("reference/fuzz_corpus")
#: Bytes of one input and of all that are kept of a kind.
LONGEST, MOST_KEPT = 4096, 8000
PLAIN = [
    "uff time",
    "uff binary",
    "uff frf",
    "csv",
    "csv instants",
    "npy",
    "lvm",
    "mtx array",
    "mtx sparse",
    "dmig",
]
PLAIN += [
    "abaqus",
    "op4 text",
    "op4 binary",
    "harwell-boeing",
    "antiresonances",
    "modes",
    "job",
    "conditions",
    "points",
]
TEXTS = ["result", "assessor", "matrices of ours", "evidence", "npz of ours"]
FUZZED = [*PLAIN, *TEXTS, "checkpoint"]


def fuzz(kind, folder, *options):
    """Endless, in a process of its own: libFuzzer ends it."""
    import atheris

    with atheris.instrument_imports(
        include=["antires_rs.io", "antires_rs.watch", "antires_rs.app", "antires_rs.measured"]
    ):
        from reference.mutant_kinds import INSIDE, KINDS, outcome

    path = Path(folder, f"input{KINDS[kind].ending}")
    whole = Path(folder, "good").read_bytes()
    pack = INSIDE[kind][1] if kind in INSIDE else lambda whole, data: data

    def one(data):
        path.write_bytes(pack(whole, data))
        what, why = outcome(kind, path)
        assert what != "RAW", why

    atheris.Setup(["fuzz_files", *options], one)
    atheris.Fuzz()


def kept(kind, inputs):
    """Put the shortest of the new inputs beside those that are there, as far as there is room."""
    own = FOUND / kind.replace(" ", "_")
    own.mkdir(parents=True, exist_ok=True)
    room = MOST_KEPT - sum(each.stat().st_size for each in own.iterdir())
    for path in sorted(inputs.iterdir(), key=lambda each: each.stat().st_size):
        room -= path.stat().st_size
        if room < 0:
            return
        (own / path.name[:16]).write_bytes(path.read_bytes())


def main():
    """A line for each kind."""
    if find_spec("atheris") is None:
        print("atheris is not installed: nothing is fuzzed.")
        return 0
    from reference.mutant_kinds import INSIDE, KINDS

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=int, default=10, help="of each kind")
    parser.add_argument("--kinds", nargs="*", choices=FUZZED, default=FUZZED)
    parser.add_argument("--keep", action="store_true", help="keep new inputs in the corpus")
    options = parser.parse_args()
    bad = 0
    for kind in options.kinds:
        with tempfile.TemporaryDirectory() as folder:
            good, inputs = Path(folder, "good"), Path(folder, "inputs")
            whole = KINDS[kind].make(Path(folder)).read_bytes()
            good.write_bytes(whole)
            inputs.mkdir()
            (inputs / "good").write_bytes(INSIDE[kind][0](whole) if kind in INSIDE else whole)
            more = [str(own)] if (own := FOUND / kind.replace(" ", "_")).is_dir() else []
            limits = [f"-max_total_time={options.seconds}", "-timeout=20", "-rss_limit_mb=1500"]
            limits += [
                f"-max_len={LONGEST}",
                "-print_final_stats=1",
                f"-artifact_prefix={kind.replace(' ', '_')}_",
            ]
            command = [sys.executable, "-m", "benchmarks.fuzz_files", "child", kind, folder]
            done = subprocess.run(
                [*command, *limits, str(inputs), *more], capture_output=True, text=True, check=False
            )
            lines = done.stderr.splitlines()
            runs = next((each.split()[-1] for each in lines if "number_of_executed_units" in each), "?")
            bad += done.returncode != 0
            new = len(list(inputs.iterdir())) - 1
            print(f"{kind}: {runs} inputs, {new} reach new lines, code {done.returncode}")
            if done.returncode:
                print(*[f"    {line}" for line in (done.stdout.splitlines() + lines)[-25:]], sep="\n")
            (inputs / "good").unlink()
            if options.keep:
                kept(kind, inputs)
        sys.stdout.flush()
    return bool(bad)


if __name__ == "__main__":
    if sys.argv[1:2] == ["child"]:
        fuzz(*sys.argv[2:])
    else:
        sys.exit(main())
