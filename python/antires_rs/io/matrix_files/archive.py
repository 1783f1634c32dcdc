"""Files of ``scipy.sparse.save_npz``, every checksum compared before SciPy sees them."""

from __future__ import annotations

from pathlib import Path

from .._common import unsuitable
from ..npz import read_archive
from .labelled import Labelled

__all__ = ["read_sparse_npz"]


def read_sparse_npz(file: Path) -> dict[str, Labelled]:
    """The matrix of a file, under its stem."""
    from scipy.sparse import load_npz

    arrays = read_archive(file)
    if "format" not in arrays or "shape" not in arrays:
        unsuitable(
            file,
            f"with the arrays {', '.join(arrays)}",
            "a file of scipy.sparse.save_npz",
            "Save it by scipy.sparse.save_npz.",
        )
    return {file.stem: Labelled(load_npz(file))}
