"""Reads a MATLAB file of version 5 or 4 and writes its arrays as a NumPy archive.

Run as a program of its own, with a limit on memory, because a damaged file can crash the interpreter that
reads it: ``python _mat_child.py FILE OUT MEMORY_GB``.
"""

from __future__ import annotations

import json
import sys
from typing import Any

#: More parts than this, and the file is no record of a test.
MOST_ARRAYS, DEEPEST = 10_000, 8


def limit_memory(gigabytes: float) -> None:
    """Cap the address space, where the system can."""
    try:
        import resource
    except ImportError:
        return
    most = int(gigabytes * 2**30)
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def flatten(name: str, value: Any, arrays: dict[str, Any], texts: dict[str, str], depth: int = 0) -> None:
    """Numeric arrays and texts of a variable by name: ``struct.field``, ``struct[1].field``, ``cell[2]``."""
    import numpy as np

    if depth > DEEPEST or len(arrays) >= MOST_ARRAYS or not isinstance(value, np.ndarray):
        return
    if value.dtype.names:
        items = list(enumerate(value.ravel(order="F")))
        for i, item in items:
            for field in value.dtype.names:
                each = f"{name}.{field}" if len(items) == 1 else f"{name}[{i}].{field}"
                flatten(each, item[field], arrays, texts, depth + 1)
    elif value.dtype.kind == "O":
        for i, item in enumerate(value.ravel(order="F")):
            flatten(f"{name}[{i}]", item, arrays, texts, depth + 1)
    elif value.dtype.kind == "U":
        texts[name] = "\n".join(map(str, value.ravel()))
    elif value.dtype.kind in "biufc":
        arrays[name] = value


def main(path: str, out: str, gigabytes: str) -> None:
    """Read, flatten, write."""
    limit_memory(float(gigabytes))
    import numpy as np
    from scipy.io import loadmat

    variables = loadmat(path, chars_as_strings=True)
    arrays: dict[str, Any] = {}
    texts: dict[str, str] = {}
    for name, value in variables.items():
        if not name.startswith("__"):
            flatten(name, value, arrays, texts)
    keys = {f"a{i}": name for i, name in enumerate(arrays)}
    names = json.dumps({"arrays": keys, "texts": texts}).encode()
    members: dict[str, Any] = {key: np.ascontiguousarray(arrays[name]) for key, name in keys.items()}
    np.savez(out, names=np.frombuffer(names, dtype=np.uint8), **members)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except Exception as exc:  # the parent shows the last line
        print(f"{type(exc).__name__}: {str(exc).splitlines()[0] if str(exc) else ''}", file=sys.stderr)
        sys.exit(1)
