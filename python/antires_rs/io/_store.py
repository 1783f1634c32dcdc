"""Arrays and a JSON text in one archive, every part with its SHA-256.

In the text an array stands as ``{"array": "a3"}``.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._common import existing_file, unsuitable
from .npz import TEXT, read_archive, write_archive

__all__ = ["Store", "read_store", "write_store"]


class Store:
    """The arrays of a file being written."""

    def __init__(self) -> None:
        self.arrays: dict[str, NDArray[Any]] = {}

    def put(self, array: Any) -> dict[str, str]:
        """Keep an array; returns what stands for it in the text."""
        name = f"a{len(self.arrays)}"
        self.arrays[name] = np.ascontiguousarray(array)
        return {"array": name}


def write_store(path: str | os.PathLike[str], data: dict[str, Any], store: Store) -> Path:
    """Write text, arrays and their hashes, whole or not at all."""
    hashes = {name: _digest(array) for name, array in store.arrays.items()}
    text = json.dumps({**data, "sha256": hashes}, allow_nan=False, indent=1)
    own = np.frombuffer(bytes.fromhex(_sha256(text.encode())), dtype=np.uint8)
    return write_archive(path, text, {**store.arrays, "text_sha256": own})


def read_store(
    path: str | os.PathLike[str],
    form: str,
    version: int,
    wanted: str,
    remedy: str = "It was cut, or is another file: copy it again, or name the right one.",
) -> tuple[Path, dict[str, Any]]:
    """The text with its arrays in place, after all hashes were compared.

    ``wanted`` and ``remedy`` are said of a file that is no archive.
    """
    file = existing_file(path)
    arrays = read_archive(file, wanted, remedy)
    if TEXT not in arrays or "text_sha256" not in arrays:
        unsuitable(
            file, "an archive of another kind", wanted, "It was cut, or is another file: name the right one."
        )
    text = bytes(arrays[TEXT])
    if _sha256(text) != bytes(arrays["text_sha256"]).hex():
        unsuitable(file, "whose text does not have its checksum", wanted, "It was damaged or edited.")
    data = json.loads(text)
    if data.get("format") != form:
        unsuitable(
            file,
            f"which holds {data.get('format')!r}",
            wanted,
            "It is another file of antires_rs: name the right one.",
        )
    if not isinstance(data.get("version"), int) or data["version"] > version:
        unsuitable(
            file, f"of version {data.get('version')!r}", f"version {version} or older", "Update antires_rs."
        )
    for name, digest in data["sha256"].items():
        if name not in arrays or _digest(arrays[name]) != digest:
            unsuitable(
                file,
                f"whose array {name} is missing or does not have its checksum",
                wanted,
                "It was damaged or edited.",
            )
    return file, _filled(data, arrays)


def _filled(value: Any, arrays: dict[str, NDArray[Any]]) -> Any:
    if isinstance(value, dict):
        if value.keys() == {"array"}:
            return arrays[value["array"]]
        return {key: _filled(item, arrays) for key, item in value.items()}
    return [_filled(item, arrays) for item in value] if isinstance(value, list) else value


def _digest(array: NDArray[Any]) -> str:
    head = f"{array.dtype.str}{array.shape}".encode()
    return _sha256(head + np.ascontiguousarray(array).tobytes())


def _sha256(data: bytes) -> str:
    import hashlib  # slow to load

    return hashlib.sha256(data).hexdigest()
