"""A search on disk: written now and then, resumed bit-identical.

One file of bytes with a checksum, put in place in one step: a process killed at any moment leaves a good one.
"""

from __future__ import annotations

import hashlib
import os
import struct
from pathlib import Path
from typing import Any, NoReturn

from ..exceptions import InvalidInputError, UnsuitableDataError, reject
from ..support.files import write_atomically
from ..support.messages import warn

_NAME, _VERSION = b"antires_rs search ", 2  # of the layout; version 2 counts the linearizations
_MAGIC = _NAME + b"%d\n" % _VERSION
_HEADER = struct.Struct("<Q32s32sQ")  # seed, fingerprint of the problem, checksum and length of what follows


class Checkpoint:
    """Where a search is kept; ``seed`` and ``resume`` are those of the search in the file, None without."""

    def __init__(self, path: str | os.PathLike[str], every_s: float = 2.0) -> None:
        if not isinstance(path, str | os.PathLike):
            reject("checkpoint", path, "a path", "Pass a text or a Path, or None to keep no checkpoint.")
        self.path, self.every_s = Path(path), every_s
        if not self.path.parent.is_dir():
            remedy = f"Make the folder {str(self.path.parent)!r} first."
            reject("checkpoint", str(path), "a file in a folder that exists", remedy)
        if self.path.is_dir():
            reject("checkpoint", str(path), "a file, not a folder", "Name a file in it.")
        self._failed = False
        self._problem = b""
        self.seed: int | None = None
        self.resume: bytes | None = None
        if self.path.exists():
            self.seed, self._problem, self.resume = _read(self.path)

    def begin(self, problem: bytes, seed: int) -> None:
        """Say which search this is; refuses a file that holds another."""
        if self.resume is not None and (problem, seed) != (self._problem, self.seed):
            what = f"seed {self.seed}" if seed != self.seed else "another problem, data or options"
            remedy = "Give the same problem, optimizer and rng, or another file name."
            got = f"{self.path.name}, the search of {what}"
            reject("checkpoint", got, "the file of this very search", remedy)
        self._problem, self.seed = problem, seed

    def store(self, payload: bytes) -> None:
        """Write the search as it stands. A disk that is full is warned of once; the search goes on."""
        assert self.seed is not None
        digest = hashlib.sha256(payload).digest()
        try:
            head = _MAGIC + _HEADER.pack(self.seed, self._problem, digest, len(payload))
            write_atomically(self.path, head + payload)
        except (OSError, InvalidInputError) as exc:  # a disk, or a folder that is not there any more
            if not self._failed:
                why = f"checkpoint: {self.path} cannot be written ({exc}); the search goes on without."
                warn("checkpoint_not_written", why)
            self._failed = True


def digest_of(*items: Any) -> bytes:
    """32 bytes that tell these items, bytes or what prints in full, from any others."""
    digest = hashlib.sha256()
    for item in items:
        digest.update(item if isinstance(item, bytes) else repr(item).encode())
        digest.update(b"\0")
    return digest.digest()


def _read(file: Path) -> tuple[int, bytes, bytes]:
    """Seed, fingerprint and payload."""
    data = file.read_bytes()

    def damaged(how: str) -> NoReturn:
        got = f"{file.name}, which is damaged ({how})"
        raise UnsuitableDataError("checkpoint", got, "one that is whole", "Remove it to begin anew.")

    if not data.startswith(_MAGIC):
        number = data[:40].partition(b"\n")[0].removeprefix(_NAME)
        if data.startswith(_NAME) and number.isdigit():
            maker = "an older" if int(number) < _VERSION else "a newer"
            got = f"{file.name}, the search of {maker} antires_rs (layout {int(number)})"
            remedy = "End that search with the version that began it, or remove the file to begin anew."
            raise UnsuitableDataError("checkpoint", got, f"layout {_VERSION}", remedy)
        damaged("no checkpoint")
    begin = len(_MAGIC) + _HEADER.size
    if len(data) < begin:
        damaged("cut short")
    (seed, problem, digest, length), payload = _HEADER.unpack_from(data, len(_MAGIC)), data[begin:]
    if len(payload) != length:
        damaged(f"{len(payload)} of {length} bytes")
    if hashlib.sha256(payload).digest() != digest:
        damaged("wrong checksum")
    return seed, problem, payload
