"""Matrices in the files of finite-element programs: a reader for each format, chosen by the ending."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from ...support.validation import reject
from .._common import existing_file
from .abaqus import is_abaqus, read_abaqus
from .archive import read_sparse_npz
from .dmig import read_dmig
from .full import read_full
from .harwell_boeing import read_harwell_boeing
from .labelled import Labelled
from .market import is_matrix_market, read_matrix_market
from .op4 import read_op4

__all__ = ["Labelled", "choose", "matrices_in"]

_READERS: dict[str, Callable[[Path], dict[str, Labelled]]] = {
    ".npz": read_sparse_npz,
    ".mtx": read_matrix_market,
    ".mtx.gz": read_matrix_market,
    ".mm": read_matrix_market,
    ".op4": read_op4,
    ".pch": read_dmig,
    ".bdf": read_dmig,
    ".dmig": read_dmig,
    ".full": read_full,
    ".rsa": read_harwell_boeing,
    ".rua": read_harwell_boeing,
    ".hb": read_harwell_boeing,
}


def matrices_in(name: str, path: str | os.PathLike[str]) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    file = existing_file(path)
    ending = next((e for e in _READERS if file.name.lower().endswith(e)), None)
    if ending is None:
        reject(
            name,
            repr(str(file)),
            "a file that ends in " + ", ".join(_READERS) + ", or a matrix",
            "Export the matrix in one of these formats, or pass it as a scipy.sparse array.",
        )
    if ending == ".mtx" and not is_matrix_market(file) and is_abaqus(file):
        return read_abaqus(file)
    return _READERS[ending](file)


def choose(name: str, path: str | os.PathLike[str], letter: str) -> Labelled:
    """The only matrix of a file, or the only one whose name begins with ``letter``."""
    found = matrices_in(name, path)
    own = list(found) if len(found) == 1 else [each for each in found if each.upper().startswith(letter)]
    if len(own) != 1:
        reject(
            name,
            f"{str(path)!r} with the matrices {', '.join(found)}",
            f"a file with one matrix, or with one whose name begins with {letter}",
            "Write the matrices into files of their own.",
        )
    return found[own[0]]
