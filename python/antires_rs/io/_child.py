"""Reads a file of another program in a process of its own, and writes its arrays as a NumPy archive.

A damaged file can crash or fill the interpreter that reads it: ``python _child.py SOURCE FUNCTION FILE OUT
REQUEST``, the request in JSON (:mod:`.child_process` makes it). SOURCE is the module of a format; it is run
without what it imports of the package, which takes longer to load than most files to read, but for the
functions below. FUNCTION takes the path and the request and gives arrays, texts and what was listed.
"""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

#: Arrays by name; texts by name; name, shape and "nothing is missing of what was asked for" of each array.
Answer = tuple[dict[str, Any], dict[str, str], list[Any]]


class Unfit(ValueError):
    """A file that is whole and does not hold what is wanted; the parent says it as it is."""


def answer(channels: list[dict[str, Any]], **texts: Any) -> Answer:
    """Values of the channels as arrays, the rest of them as one text."""
    arrays = {f"c{i}": channel.pop("values") for i, channel in enumerate(channels)}
    listed = [[channel["name"], list(arrays[f"c{i}"].shape), True] for i, channel in enumerate(channels)]
    named = {"channels": channels, **texts}
    return arrays, {name: json.dumps(value, default=str) for name, value in named.items()}, listed


def asked(names: Iterable[str], role: str, request: dict[str, Any]) -> bool:
    """Whether an array is one of those asked for: by name, by pattern, or by a role that its name tells."""
    if request["only"] is None or role.lower() in request["roles"]:
        return True
    return any(matches(name, pattern) for name in names for pattern in request["only"])


def matches(name: str, pattern: str) -> bool:
    """Whether a name is meant; names of struct arrays have brackets, which are no patterns."""
    return name == pattern or fnmatchcase(name, pattern.replace("[", "[[]"))


def room(count: int, request: dict[str, Any]) -> None:
    """Refuse more numbers than may be handed over."""
    if 16 * count > request["most_bytes"]:
        raise MemoryError(f"{count} numbers")


def called(names: Iterable[Any]) -> str:
    """Names in a sentence."""
    return ", ".join(repr(name) for name in list(names)[:20]) or "none"


def limit_memory(gigabytes: float) -> None:
    """Cap the address space, where the system can; a lower limit that was set already stays."""
    try:
        import resource
    except ImportError:
        return
    set_already = (each for each in resource.getrlimit(resource.RLIMIT_AS) if each != resource.RLIM_INFINITY)
    most = min([int(gigabytes * 2**30), *set_already])
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def function_of(source: str, name: str) -> Callable[[str, dict[str, Any]], Answer]:
    """The function of a module, which sees this one in place of the package; its readers are left out."""
    tree = ast.parse(Path(source).read_text(encoding="utf-8"), source)
    tree.body = [
        node
        for node in tree.body
        if not (isinstance(node, ast.ImportFrom) and node.level) and not getattr(node, "decorator_list", ())
    ]
    space = dict(globals())
    exec(compile(tree, source, "exec"), space)
    found: Callable[[str, dict[str, Any]], Answer] = space[name]
    return found


def main(source: str, function: str, path: str, out: str, text: str) -> None:
    """Read and write."""
    request = json.loads(text)
    limit_memory(request["memory_gb"])
    import numpy as np

    arrays, texts, listed = function_of(source, function)(path, request)
    keys = {f"a{i}": name for i, name in enumerate(arrays)}
    names = json.dumps({"arrays": keys, "texts": texts, "listed": listed}).encode()
    members: dict[str, Any] = {key: np.ascontiguousarray(arrays[name]) for key, name in keys.items()}
    np.savez(out, names=np.frombuffer(names, dtype=np.uint8), **members)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except Exception as exc:  # the parent shows the last line
        print(f"{type(exc).__name__}: {str(exc).splitlines()[0] if str(exc) else ''}", file=sys.stderr)
        sys.exit(1)
