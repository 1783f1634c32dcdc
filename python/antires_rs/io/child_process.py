"""Files that C code reads: in a child process with limits, as a damaged one may do anything."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..support.checks import shape_of
from .common import unsuitable
from .npz import read_archive
from .raw_arrays import ROLES, array_of

#: Before the names of objects among the texts, whose class is the text (as the child has it).
OPAQUE = "object "

#: Share of the memory that arrays may take; the rest is for the archive in which they are handed over.
_SHARE = 0.3
#: The program of the child.
READER = Path(__file__).with_name("_child.py")


@dataclass(frozen=True)
class Asked:
    """What is wanted of a file: ``every`` array, or those ``named``, by argument; others by their size.

    Examples
    --------
    >>> Asked.of(responses=["a*"], time=None, force="auto").names
    ['a*']
    """

    named: tuple[tuple[str, str], ...] = ()
    every: bool = False

    @classmethod
    def of(cls, **arguments: Any) -> Asked:
        """Of the arguments of a reader."""
        named = []
        for argument, given in arguments.items():
            if given is None or (argument == "force" and given == "auto"):
                continue
            each: Sequence[Any] = [given] if shape_of(given) == () else list(given)
            named += [(argument, name) for name in each if isinstance(name, str)]
        return cls(tuple(named))

    @property
    def names(self) -> list[str] | None:
        """Names and patterns; None where the responses are not named, so that any array may be one."""
        if not any(argument == "responses" for argument, _ in self.named):
            return None
        return list(dict.fromkeys(each for _, name in self.named for each in (name, array_of(name))))


class Found(NamedTuple):
    """Arrays that were read, and texts; arrays that nobody asked for have their shape alone."""

    arrays: dict[str, NDArray[Any]]
    texts: dict[str, str]


def in_a_child(
    kind: str,
    file: Path,
    asked: Asked,
    wanted: str,
    *,
    time_limit_s: float,
    memory_limit_gb: float,
    **more: Any,
) -> Found:
    """What the child makes of the file, handed over as an archive of plain arrays."""
    import subprocess
    import tempfile

    request = {
        "memory_gb": memory_limit_gb,
        "most_bytes": int(_SHARE * memory_limit_gb * 2**30),
        "only": asked.names,
        "every": asked.every,
        "roles": sorted(ROLES),
        **more,
    }
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "ARROW_DEFAULT_MEMORY_POOL": "system",  # others reserve more than the limit
    }
    with tempfile.TemporaryDirectory(prefix="antires_") as folder:
        out = Path(folder) / "arrays.npz"
        # -P: the folder of the reader must not hide standard modules.
        call = [sys.executable, "-P", str(READER), kind, str(file.resolve()), str(out), json.dumps(request)]
        try:
            done = subprocess.run(
                call,
                env=environment,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=time_limit_s,
                stdin=subprocess.DEVNULL,
                check=False,
            )
        except subprocess.TimeoutExpired:
            unsuitable(
                file,
                f"which was not read within {time_limit_s:g} s",
                wanted,
                "Raise time_limit_s if it is large; otherwise it is damaged.",
            )
        if done.returncode != 0 or not out.is_file():
            said = done.stderr.strip().splitlines()
            if said and said[-1].startswith("MemoryError"):
                unsuitable(
                    file,
                    f"which takes more than {memory_limit_gb:.3g} GB",
                    wanted,
                    "Name the responses= to be read, or raise memory_limit_gb, if it is not damaged.",
                )
            if said and said[-1].startswith("Unfit: "):
                unsuitable(
                    file, f"in which {said[-1][7:400]}", wanted, "Correct the file, or the names you gave."
                )
            reason = said[-1][:300] if said else f"the reader ended with code {done.returncode}"
            unsuitable(
                file, f"which cannot be read ({reason})", wanted, "It was cut or damaged, or is no such file."
            )
        arrays = read_archive(out)
    names = json.loads(bytes(arrays.pop("names")).decode())
    found = {name: np.asarray(arrays[key]) for key, name in names["arrays"].items()}
    if (
        kind in ("mat5", "hdf5") and "antires_rs" not in names["texts"]
    ):  # a file of ours holds what it says, and is judged as a whole
        _named(file, asked, names["listed"])
    _complete(file, names["listed"], memory_limit_gb)
    for name, shape, _ in names["listed"]:
        if name not in found and len(shape) > 2:  # told of, never filled
            found[name] = np.broadcast_to(np.float64(0.0), shape)
    return Found(found, names["texts"])


def _named(file: Path, asked: Asked, listed: list[Any]) -> None:
    """Refuse names of responses that the file lacks."""
    from fnmatch import fnmatchcase

    there = {name.replace("/", ".") for name, _, _ in listed} | {name for name, _, _ in listed}
    shown = ", ".join(f"{name} {'x'.join(map(str, shape))}" for name, shape, _ in listed[:20])
    for argument, pattern in asked.named if asked.names is not None else ():
        known = {pattern, array_of(pattern)} & there or any(
            fnmatchcase(name, pattern.replace("[", "[[]")) for name in there
        )
        if not known and argument == "responses":
            reject(
                argument, repr(pattern), f"arrays of {str(file)!r}: {shown}", "Correct the name or pattern."
            )


def _complete(file: Path, listed: list[Any], memory_limit_gb: float) -> None:
    """Refuse arrays that are too large to be read."""
    large = [(name, shape) for name, shape, whole in listed if not whole]
    if large:
        name, shape = max(large, key=lambda each: float(np.prod([float(n) for n in each[1]])))
        unsuitable(
            file,
            f"with {name} of {'x'.join(map(str, shape))} values",
            f"arrays that fit into {_SHARE * memory_limit_gb:.3g} GB twice",
            "Name the responses= to be read, which leaves the others alone, or raise memory_limit_gb.",
        )
