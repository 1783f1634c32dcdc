"""Reads a file of another program and writes its arrays as a NumPy archive.

Run as a program of its own, with a limit on memory, because a damaged file can crash or fill the interpreter
that reads it: ``python _child.py KIND FILE OUT REQUEST``, the request in JSON (:mod:`.child` makes it).
"""

from __future__ import annotations

import json
import sys
from typing import Any

#: More parts than this, and the file is no record of a test.
MOST_ARRAYS, DEEPEST = 10_000, 8
MOST_ATTRIBUTES, LONGEST_TEXT = 100, 1_000
#: Complex numbers as pairs: MATLAB's, and those of h5py.
#: Before the name of an object, whose class is the text.
OPAQUE = "object "
COMPLEX = (("real", "imag"), ("r", "i"))


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
    if value.dtype.names == ("s0", "s1", "s2", "arr"):  # an object, which only MATLAB reads
        texts[f"{OPAQUE}{name}"] = b"".join(map(bytes, value["s2"].ravel()[:1])).decode("latin-1")
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


def mat5(path: str, request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, str], list[Any]]:
    """Variables of version 5 or 4, structs and cells taken apart."""
    from scipy.io import loadmat

    arrays: dict[str, Any] = {}
    texts: dict[str, str] = {}
    for name, value in loadmat(path, chars_as_strings=True).items():
        if not name.startswith("__"):
            flatten(name, value, arrays, texts)
    return arrays, texts, [[name, list(each.shape), True] for name, each in arrays.items()]


class Datasets:
    """Those of an HDF5 file: arrays that are asked for, and the shapes of all."""

    def __init__(self, request: dict[str, Any]) -> None:
        self.request, self.left = request, request["most_bytes"]
        self.arrays: dict[str, Any] = {}
        #: Name, shape, and whether nothing is missing of what was asked for.
        self.listed: list[Any] = []
        #: Attributes, by path@name, and MATLAB's texts.
        self.texts: dict[str, str] = {}

    def visit(self, name: str, item: Any) -> None:
        """Keep a data set; MATLAB's own places are reached by references."""
        self.attributes(name, item)
        if hasattr(item, "dtype") and not name.startswith("#"):
            self.keep(name, item)

    def attributes(self, name: str, item: Any) -> None:
        """Keep the attributes that are a number or a short text."""
        for key in list(item.attrs)[:MOST_ATTRIBUTES]:
            if key.startswith("MATLAB_") or len(self.texts) >= MOST_ARRAYS:
                continue
            try:
                value = item.attrs[key]
            except (OSError, TypeError, ValueError):  # of a type that h5py does not know
                continue
            value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
            single = getattr(value, "size", 1) == 1 and not isinstance(value, str)
            value = value.ravel()[0] if single and hasattr(value, "ravel") else value
            if isinstance(value, bytes | str):
                value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
                self.texts[f"{name}@{key}"] = value[:LONGEST_TEXT]
            elif single and getattr(value, "dtype", None) is not None and value.dtype.kind in "iuf":
                self.texts[f"{name}@{key}"] = repr(float(value))

    def text(self, name: str, item: Any) -> None:
        """Keep a text of MATLAB, which is stored as the numbers of its letters."""
        if item.dtype.kind == "u" and 0 < item.size <= LONGEST_TEXT and len(self.texts) < MOST_ARRAYS:
            self.texts[name] = "".join(map(chr, item[()].ravel(order="F").tolist()))

    def keep(self, name: str, item: Any, above: tuple[Any, ...] = ()) -> None:
        """Keep a data set, or what it refers to."""
        made = matlab_class(item)
        if made == "char" and "MATLAB_empty" not in item.attrs:
            self.text(name, item)
        if "MATLAB_empty" in item.attrs or made == "char" or len(self.listed) >= MOST_ARRAYS:
            return  # MATLAB stores texts as numbers, and the shape of what is empty
        struct = made != "cell" and item.dtype.kind == "O" and matlab_class(item.parent) == "struct"
        if made == "cell" or struct:
            self.refer(name, item, above, struct)
        elif item.shape is not None and (item.dtype.kind in "biufc" or item.dtype.names in COMPLEX):
            self.take(name, item)

    def take(self, name: str, item: Any) -> None:
        """Read an array of numbers, if it is asked for and there is room for it."""
        size = 2 * item.size * item.dtype.itemsize
        wanted = self.request["every"] or (item.ndim <= 2 and asked(name, self.request))
        read = wanted and size <= self.left
        shape = item.shape[::-1] if "MATLAB_class" in item.attrs else item.shape
        self.listed.append([name, list(shape), read or not wanted])
        if read:
            self.left -= size
            self.arrays[name] = values_of(item)

    def refer(self, name: str, item: Any, above: tuple[Any, ...], struct: bool) -> None:
        """What the cells of an array refer to, by names as in version 5."""
        parent, _, field = name.rpartition("/")
        for i, reference in enumerate(item[()].ravel() if item.size <= MOST_ARRAYS else ()):
            target = item.file[reference] if reference else item
            if target in (item, *above) or len(above) >= DEEPEST:
                continue  # nothing, or a damaged file that refers to itself
            each = f"{parent}[{i}]/{field}" if struct else f"{name}[{i}]"
            found = {each: target}
            if not hasattr(target, "dtype"):  # a group: a struct, in which others may lie
                found = {}
                target.visititems(lambda n, part, at=each, into=found: into.update({f"{at}/{n}": part}))
            for label, part in found.items():
                if hasattr(part, "dtype"):
                    self.keep(label, part, (*above, item))


def hdf5(path: str, request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, str], list[Any]]:
    """Datasets by path; of those that are not asked for, or are too large, the shape alone."""
    import h5py

    with h5py.File(path, "r") as opened:
        text = opened.attrs.get("antires_rs")
        found = Datasets(request if text is None else {**request, "only": None})  # ours are read whole
        opened.visititems(found.visit)
        found.attributes("", opened)
    return found.arrays, found.texts if text is None else {"antires_rs": str(text)}, found.listed


def asked(name: str, request: dict[str, Any]) -> bool:
    """Whether an array is one of those asked for: by name, by pattern, or by a role that its name tells."""
    from fnmatch import fnmatchcase

    if request["only"] is None:
        return True
    names = (name, name.replace("/", "."))
    last = name.rpartition("/")[2].lower()
    return last in request["roles"] or any(
        each == pattern or fnmatchcase(each, pattern.replace("[", "[[]"))
        for each in names
        for pattern in request["only"]
    )


def matlab_class(item: Any) -> str:
    """What MATLAB says that it is; '' for others."""
    made = item.attrs.get("MATLAB_class", b"")
    return made.decode() if isinstance(made, bytes) else str(made)


def values_of(item: Any) -> Any:
    """Values of a dataset; MATLAB's are stored transposed, and its complex numbers as pairs."""
    import numpy as np

    values = np.asarray(item[()])
    if values.dtype.names:
        real, imaginary = values.dtype.names
        values = values[real] + 1j * values[imaginary]
    return values.T if "MATLAB_class" in item.attrs else values


def reader_of(kind: str) -> Any:
    """The function that reads files of a kind; those of records and tables stand in the file beside this."""
    own = {"mat5": mat5, "hdf5": hdf5}
    if kind in own:
        return own[kind]
    from pathlib import Path
    from runpy import run_path  # which needs no package around it

    return run_path(str(Path(__file__).with_name("_child_records.py")))["READERS"][kind]


def main(kind: str, path: str, out: str, text: str) -> None:
    """Read and write."""
    request = json.loads(text)
    limit_memory(request["memory_gb"])
    import numpy as np

    arrays, texts, listed = reader_of(kind)(path, request)
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
