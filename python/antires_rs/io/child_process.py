"""Files that C code reads: in a child process with limits, as a damaged one may do anything."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..support.checks import finite_scalar, shape_of
from ._child import Answer, matches
from .common import most_bytes, unsuitable
from .options import Reading
from .own_format import read_archive
from .raw_arrays import ROLES, array_of

#: Share of the memory that arrays may take; the rest is for the archive in which they are handed over.
_SHARE = 0.3
_OR = " (or ANTIRES_MAX_BYTES, if it is set)"
READER = Path(__file__).with_name("_child.py")  # the program of the child
#: What reads in the child: its path and the request give arrays, texts and what was listed.
Function = Callable[[str, dict[str, Any]], Answer]


class Limits(NamedTuple):
    """Of the child process, as its callers give them."""

    time_limit_s: Any
    memory_limit_gb: Any


class Found(NamedTuple):
    """Arrays that were read, and texts; arrays that nobody asked for have their shape alone."""

    arrays: dict[str, NDArray[Any]]
    texts: dict[str, str]


def channels_of_child(
    function: Function, file: Path, wanted: str, limits: Limits, given: Reading | None = None, **more: Any
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """What the child makes of a file: the entries of its channels, with their values, and further texts."""
    found = in_a_child(function, file, wanted, limits, given, **more)
    entries = json.loads(found.texts["channels"])
    for i, entry in enumerate(entries):
        entry["values"] = found.arrays[f"c{i}"]
    return entries, found.texts


def in_a_child(
    function: Function, file: Path, wanted: str, limits: Limits, given: Reading | None = None, **more: Any
) -> Found:
    """What ``function`` makes of the file in the child; of ``given.responses``, if named, those alone."""
    import tempfile

    time_limit_s = finite_scalar("time_limit_s", limits.time_limit_s, low=0.0, low_open=True, unit="s")
    memory_gb = finite_scalar("memory_limit_gb", limits.memory_limit_gb, low=0.0, low_open=True, unit="GB")
    most_gb = memory_gb
    if "ANTIRES_MAX_BYTES" in os.environ:
        most_gb = min(memory_gb, most_bytes(file) / (_SHARE * 2**30))
    limits = Limits(time_limit_s, most_gb)
    asked = [] if given is None else list(_texts(given.responses))
    only = None
    if given is not None and asked:
        roles = (given.time, given.freq, None if given.force == "auto" else given.force)
        names = [*asked, *(name for each in roles for name in _texts(each))]
        only = list(dict.fromkeys(each for name in names for each in (name, array_of(name))))
    request = {"memory_gb": memory_gb, "most_bytes": int(_SHARE * most_gb * 2**30), **more}
    request |= {"only": only, "roles": sorted(ROLES)}
    with tempfile.TemporaryDirectory(prefix="antires_") as folder:
        out = Path(folder) / "arrays.npz"
        source = function.__code__.co_filename
        arguments = [source, function.__name__, str(file.resolve()), str(out), json.dumps(request)]
        _run(file, wanted, arguments, limits, out)
        arrays = read_archive(out)
    about = json.loads(bytes(arrays.pop("names")).decode())
    texts, listed = about["texts"], about["listed"]
    found = {name: np.asarray(arrays[key]) for key, name in about["arrays"].items()}
    if only is not None and "channels" not in texts and "antires_rs" not in texts:
        # A file of ours is judged as a whole.
        there = {spelled for name, _, _ in listed for spelled in (name, name.replace("/", "."))}
        for pattern in asked:
            if not any(name == array_of(pattern) or matches(name, pattern) for name in there):
                shown = ", ".join(f"{name} {'x'.join(map(str, shape))}" for name, shape, _ in listed[:20])
                remedy = "Correct the name or pattern."
                reject("responses", repr(pattern), f"arrays of {str(file)!r}: {shown}", remedy)
    large = [(name, shape) for name, shape, whole in listed if not whole]
    if large:
        name, shape = max(large, key=lambda each: float(np.prod([float(n) for n in each[1]])))
        problem = f"with {name} of {'x'.join(map(str, shape))} values"
        remedy = (
            f"Name the responses= to be read, which leaves the others alone, or raise memory_limit_gb{_OR}."
        )
        unsuitable(file, problem, f"arrays of at most {0.5 * _SHARE * most_gb:.3g} GB", remedy)
    for name, shape, _ in listed:
        if name not in found and len(shape) > 2:  # told of, never filled
            found[name] = np.broadcast_to(np.float64(0.0), shape)
    return Found(found, texts)


def _texts(given: Any) -> Iterator[str]:
    """The names among what may be one or several."""
    several: Sequence[Any] = [given] if shape_of(given) == () else list(given)
    return (each for each in several if isinstance(each, str))


def _run(file: Path, wanted: str, arguments: list[str], limits: Limits, out: Path) -> None:
    """Run the child, which writes ``out``, and say what it met."""
    import subprocess

    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    environment |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    environment["ARROW_DEFAULT_MEMORY_POOL"] = "system"  # others reserve more than the limit
    command = [sys.executable, "-P", str(READER), *arguments]  # -P: its folder must not hide standard modules
    how: dict[str, Any] = {"capture_output": True, "text": True, "errors": "replace", "check": False}
    how |= {"env": environment, "timeout": limits.time_limit_s, "stdin": subprocess.DEVNULL}
    try:
        done = subprocess.run(command, **how)
    except subprocess.TimeoutExpired:
        found = f"which was not read within {limits.time_limit_s:g} s"
        unsuitable(file, found, wanted, "Raise time_limit_s if it is large; otherwise it is damaged.")
    if done.returncode == 0 and out.is_file():
        return
    said = (done.stderr.strip().splitlines() or [f"the reader ended with code {done.returncode}"])[-1]
    if said.startswith("MemoryError"):
        remedy = f"Name the responses= to be read, or raise memory_limit_gb{_OR}, if it is not damaged."
        unsuitable(file, f"which takes more than {limits.memory_limit_gb:.3g} GB", wanted, remedy)
    if said.startswith("Unfit: "):
        unsuitable(file, f"in which {said[7:400]}", wanted, "Correct the file, or the names you gave.")
    got = f"which cannot be read ({said[:300]})"
    unsuitable(file, got, wanted, "It was cut or damaged, or is no such file.")
