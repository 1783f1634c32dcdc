"""Universal files of a folder: each function read equals what pyuff reads, or is refused with a reason.

The test data of pyuff, for example: clone its repository and give the folder ``data``.

    python -m benchmarks.public_uff DATA --lines 200
"""

from __future__ import annotations

import argparse
import sys
import warnings
from pathlib import Path

import numpy as np

import antires_rs as ar
from antires_rs.io.uff import functions_of


def rivals(path):
    """Datasets 58 as pyuff reads them, or the first line of its error."""
    import pyuff

    try:
        file = pyuff.UFF(str(path))
        types = file.get_set_types()
        return [file.read_sets(i) for i, kind in enumerate(types) if int(kind) == 58], ""
    except Exception as exc:  # pyuff raises nothing more precise
        return None, (str(exc).splitlines() or [type(exc).__name__])[0]


def differs(ours, theirs):
    """The first function that is not the same; '' where all are."""
    if len(ours) != len(theirs):
        return f"{len(ours)} functions, pyuff has {len(theirs)}"
    for i, (mine, other) in enumerate(zip(ours, theirs, strict=True)):
        values = np.asarray(other["data"])
        if mine.values.shape != values.shape or not np.array_equal(mine.values, values):
            return f"other values in function {i + 1}"
        if (mine.response, mine.reference) != (
            (int(other["rsp_node"]), int(other["rsp_dir"])),
            (int(other["ref_node"]), int(other["ref_dir"])),
        ):
            return f"another point in function {i + 1}"
        if not np.allclose(mine.x / mine.x_unit, other["x"], rtol=1e-5, atol=1e-12):
            return f"another abscissa in function {i + 1}"
    return ""


def verdict(path):
    """A word and what there is to say."""
    theirs, problem = rivals(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ar.AntiresWarning)
            ours = functions_of(path, False)
    except ar.AntiresError as exc:
        said = f"{exc.got}".partition(", ")[2] or str(exc)
        return ("refused, as by pyuff" if theirs is None else "refused"), said
    except Exception as exc:  # the very thing that is looked for
        return "RAW", f"{type(exc).__name__}: {exc}"
    if theirs is None:
        return "read, not by pyuff", problem
    odd = differs(ours, theirs)
    if odd:
        return "DIFFERS", odd
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ar.AntiresWarning)
            return "equal", repr(ar.read_uff(path))
    except ar.AntiresError as exc:
        return "equal", f"functions; as one signal: {exc}"


def main():
    """A line for each file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--lines", type=int, default=160, help="letters of what is said")
    options = parser.parse_args()
    files = sorted(
        path
        for path in options.folder.rglob("*")
        if path.suffix.lower() in (".uff", ".unv", ".uf", ".u58", ".txt")
    )
    counts = {}
    for path in files:
        word, said = verdict(path)
        counts[word] = counts.get(word, 0) + 1
        print(f"{path.name}: {word}: {said[: options.lines]}", flush=True)
    print(f"\n{len(files)} files: " + ", ".join(f"{n} {word}" for word, n in counts.items()))
    return "RAW" in counts or "DIFFERS" in counts


if __name__ == "__main__":
    sys.exit(main())
