"""Fuzzing of what reads files in this process, guided by the lines that are reached (atheris, Linux).

The first byte of an input says which kind of file the rest is. It begins with a good file of each and what
runs before found (``reference/fuzz_corpus.zip``); changes that reach new lines are changed further. Where a
checksum covers a text, or what Rust reads, that is changed, and the checksum made anew. An error that is not
ours, a minute or 1.5 GB end it; the input is kept as ``fuzz_crash-...``.

    python -m benchmarks.fuzz_files --seconds 60
    python -m benchmarks.fuzz_files --seconds 3600 --keep     # what reaches new lines goes into the corpus
    python -m benchmarks.fuzz_files --again fuzz_crash-...    # one input, with its error
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import zipfile
from importlib.util import find_spec
from pathlib import Path

FOUND = Path("reference/fuzz_corpus.zip")
#: Bytes of one input, and of all that are kept.
LONGEST, MOST_KEPT = 4096, 150_000


def fuzz(folder, *options):
    """Endless, in a process of its own: libFuzzer ends it."""
    import atheris

    with atheris.instrument_imports(include=["antires_rs.io", "antires_rs.watch", "antires_rs.measured"]):
        from reference.mutant_kinds import FUZZED, of_input

    good = {kind: Path(folder, kind).read_bytes() for kind in FUZZED}

    def one(data):
        what, why = of_input(data, good, Path(folder))
        assert what != "RAW", why

    atheris.Setup(["fuzz_files", *options], one)
    atheris.Fuzz()


def made(folder):
    """A good file of each kind, and an input of it."""
    from reference.mutant_kinds import FUZZED, INSIDE, KINDS

    (folder / "inputs").mkdir()
    for number, kind in enumerate(FUZZED):
        whole = KINDS[kind].make(folder).read_bytes()
        (folder / kind).write_bytes(whole)
        inside = INSIDE[kind][0](whole) if kind in INSIDE else whole
        (folder / "inputs" / kind).write_bytes(bytes([number]) + inside)
    return FUZZED


def kept(inputs):
    """Put the shortest of the new inputs beside those that are there, as far as there is room."""
    with zipfile.ZipFile(FOUND, "a", zipfile.ZIP_DEFLATED) as corpus:
        room = MOST_KEPT - sum(each.file_size for each in corpus.infolist())
        for path in sorted(inputs.iterdir(), key=lambda each: each.stat().st_size):
            room -= path.stat().st_size
            if room < 0:
                return
            corpus.write(path, path.name[:16])


def main():
    """How many inputs were tried, and the error if one ended it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0, help="of the changes; 0 is another one each time")
    parser.add_argument("--keep", action="store_true", help="keep new inputs in the corpus")
    parser.add_argument("--again", type=Path, nargs="*", default=[], help="inputs to be tried once")
    asked = parser.parse_args()
    if find_spec("atheris") is None:
        print("atheris is not installed: nothing is fuzzed.")
        return 0
    with tempfile.TemporaryDirectory() as name:
        folder, inputs, before = Path(name), Path(name, "inputs"), Path(name, "before")
        good = made(folder)
        with zipfile.ZipFile(FOUND) as corpus:
            corpus.extractall(before)
        limits = ["-timeout=60", "-rss_limit_mb=1500", f"-max_len={LONGEST}", "-artifact_prefix=fuzz_"]
        limits += [f"-max_total_time={asked.seconds}", f"-seed={asked.seed}", "-print_final_stats=1"]
        places = [*map(str, asked.again)] or [str(inputs), str(before)]
        command = [sys.executable, "-m", "benchmarks.fuzz_files", "child", name, *limits, *places]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        lines = (done.stdout + done.stderr).splitlines()
        if done.returncode:
            print(*lines[-40:], sep="\n")
        tried = next((each.split()[-1] for each in lines if "number_of_executed_units" in each), "?")
        for kind in good:
            (inputs / kind).unlink()
        print(
            f"{tried} inputs tried, {len(list(inputs.iterdir()))} reached new lines, code {done.returncode}"
        )
        if asked.keep:
            kept(inputs)
    return done.returncode


if __name__ == "__main__":
    if sys.argv[1:2] == ["child"]:
        fuzz(*sys.argv[2:])
    else:
        sys.exit(main())
