"""A search on disk: written now and then, resumed bit-identical.

One file of bytes with a checksum, and the one before it beside it as ``<name>.previous``. It is written whole
to ``<name>.tmp`` and put in place in one step, so a process killed at any moment leaves a good file.
"""

from __future__ import annotations

import hashlib
import os
import struct
from pathlib import Path
from typing import Any

from ..exceptions import UnsuitableDataError, reject
from ..support.files import put_in_place
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
        self.previous = self.path.with_name(self.path.name + ".previous")
        self._beside = self.path.with_name(self.path.name + ".tmp")
        self._beside.unlink(missing_ok=True)
        self._failed = False
        self._problem = b""
        self.seed: int | None = None
        self.resume: bytes | None = None
        damaged = []
        for file in (self.path, self.previous):
            try:
                self.seed, self._problem, self.resume = _read(file)
            except FileNotFoundError:
                continue
            except ValueError as exc:
                damaged.append(f"{file.name} ({exc})")
                continue
            if damaged:
                warn("damaged_checkpoint", f"checkpoint: {damaged[0]} is damaged; going on from {file.name}.")
            return
        if damaged:
            got = f"damaged files, {', '.join(damaged)}"
            raise UnsuitableDataError("checkpoint", got, "one that is whole", "Remove them to begin anew.")

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
            with open(self._beside, "wb") as file:
                file.write(_MAGIC + _HEADER.pack(self.seed, self._problem, digest, len(payload)) + payload)
                file.flush()
                os.fsync(file.fileno())
            if self.path.exists():
                os.replace(self.path, self.previous)
            put_in_place(self._beside, self.path)
        except OSError as exc:
            self._beside.unlink(missing_ok=True)
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
    """Seed, fingerprint and payload; ValueError says what is wrong."""
    data = file.read_bytes()
    if not data.startswith(_MAGIC):
        number = data[:40].partition(b"\n")[0].removeprefix(_NAME)
        if data.startswith(_NAME) and number.isdigit():
            # A whole file of another version: no older one beside it will do either.
            maker = "an older" if int(number) < _VERSION else "a newer"
            got = f"{file.name}, the search of {maker} antires_rs (layout {int(number)})"
            remedy = "End that search with the version that began it, or remove the file to begin anew."
            raise UnsuitableDataError("checkpoint", got, f"layout {_VERSION}", remedy)
        raise ValueError("no checkpoint")
    begin = len(_MAGIC) + _HEADER.size
    if len(data) < begin:
        raise ValueError("cut short")
    (seed, problem, digest, length), payload = _HEADER.unpack_from(data, len(_MAGIC)), data[begin:]
    if len(payload) != length:
        raise ValueError(f"{len(payload)} of {length} bytes")
    if hashlib.sha256(payload).digest() != digest:
        raise ValueError("wrong checksum")
    return seed, problem, payload
