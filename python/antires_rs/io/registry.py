"""Readers of signals by format, the endings of their files, and FRFs in several files."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..support.checks import choice, shape_of
from .channels import kept, renamed
from .common import existing_file, unsuitable
from .options import ENDINGS, READERS, Dofs, PathLike

__all__ = ["read_frf_files"]


def format_by_ending(name: str) -> str | None:
    """The format that the ending of a file says; None for any other."""
    suffix = PurePath(name).suffix.lower()
    return next((kind for kind, endings in ENDINGS.items() if suffix in endings), None)


#: What to do with files of formats that are not read, and of endings that several programs use.
CONVERT = "else export or convert it to a universal file (58), MAT, HDF5, CSV, Parquet or WAV."


# -- One measurement in several files, each with the FRF of one point

_TOKEN = re.compile(r"\d+|[^\W\d_]+|[\W_]+")
# Frequencies that differ by less than this part of the highest are one line, written with other digits.
SAME_LINE = 1e-6


def read_frf_files(
    files: PathLike | Iterable[PathLike],
    *,
    dofs: Dofs = None,
    pattern: str = "*",
    format: str | None = None,
    kind: str | None = None,
    reference: Any = None,
    **options: Any,
) -> FrequencyResponse:
    """Read files that hold one FRF or transmissibility each, over common frequencies.

    Parameters
    ----------
    files : path-like, or sequence of path-like
        A folder, of which all files with a known ending are read, or the files.
    dofs : sequence, mapping or callable, optional
        Dof of each file: in their order (that of numbers in a folder: 2 before 10), by the file's name
        without its ending, or a function of that name; None leaves a file out. Default: what differs between
        the names, ``FRF_2.csv`` and ``FRF_10.csv`` being 2 and 10; of universal files, their points.
    pattern : str
        Which files of a folder: ``"*.csv"``, ``"run2_*"``.
    format : {"uff", "mat", "hdf5", "csv", "npz"}, optional
        By default the endings tell.
    kind : {"frf", "transmissibility"}, optional
        As in :class:`FrequencyResponse`; "frf" by default.
    reference : int or str, optional
        Dof of the reference of transmissibilities, whose own file holds ones.
    options : any, optional
        Of the reader of that format: ``pairs=``, ``df_hz=``, ``unit=``, ``responses=`` and the like.

    Returns
    -------
    FrequencyResponse
        Coherences and averages with it, where every file has them.

    Raises
    ------
    UnsuitableDataError, InvalidInputError
        A file with several responses, none over frequency, or other frequencies than the others, which is
        named; options that do not fit, several formats in one folder, or two files of one dof.

    Examples
    --------
    >>> import pathlib, tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for point in (2, 10):
    ...         text = "Frequency [Hz],Magnitude [dB],Phase [deg]\\n1,0,0\\n2,20,90\\n"
    ...         _ = pathlib.Path(folder, f"FRF_{point}.csv").write_text(text)
    ...     ar.read_frf_files(folder).dofs
    (2, 10)
    """
    paths = _paths(files, pattern, format)
    if format is None:
        formats = Counter(format_by_ending(path.name) for path in paths)
        if len(formats) > 1 or None in formats:
            counts = ", ".join(f"{n} {kind or 'of unknown ending'}" for kind, n in formats.items())
            got = f"files of several formats ({counts})"
            remedy = "Choose them by pattern=, or name the format=."
            reject("files", got, "files of one format that is known", remedy)
        format = next(iter(formats)) or ""
    choice("format", format, tuple(READERS))
    if kind is not None:
        choice("kind", kind, ("frf", "transmissibility"))
        if format == "uff":  # which may hold several
            options["kind"] = kind
    read = [_one(path, format, options) for path in paths]
    stems = [path.stem for path in paths]
    points = [each.dofs[0] for each in read]
    default = points if format == "uff" and len(set(points)) == len(points) else differences(stems)
    labels = default if dofs is None else renamed("dofs", stems, dofs)
    rows = kept(labels)
    _check_axes([paths[i] for i in rows], [read[i] for i in rows])
    chosen = [read[i] for i in rows]
    kinds = {each.kind for each in chosen}
    if len(kinds) > 1:
        found = f"files of {' and '.join(sorted(kinds))}"
        reject("kind", found, "files of one kind", "Read them one by one.")
    averages = {each.n_averages for each in chosen}
    parts = {name: [getattr(each, name) for each in chosen] for name in ("coherence", "std")}
    stacked = {name: np.vstack(each) for name, each in parts.items() if all(row is not None for row in each)}
    values, of_kind = np.vstack([each.values for each in chosen]), chosen[0].kind if kind is None else kind
    more: dict[str, Any] = {"n_averages": averages.pop() if len(averages) == 1 else None, **stacked}
    dofs = [labels[i] for i in rows]
    return FrequencyResponse(chosen[0].freq_hz, values, dofs, of_kind, reference, **more)  # type: ignore[arg-type]


def _paths(files: Any, pattern: str, format: str | None) -> list[Path]:
    if isinstance(files, str | os.PathLike):
        folder = Path(files)
        if not folder.is_dir():
            return [existing_file(folder)]
        there = sorted(filter(Path.is_file, folder.iterdir()), key=natural)
        fitting = [path for path in there if fnmatchcase(path.name, pattern)]
        found = [path for path in fitting if format is not None or format_by_ending(path.name)]
        if not found:
            why = f"none of which fits {pattern!r} and has a known ending"
            got = f"{str(folder)!r}, a folder with {len(there)} files, {why}"
            reject("files", got, "files of one FRF each", "Name the file, or choose by pattern= and format=.")
        return found
    if shape_of(files) in ((), (0,)):
        reject("files", files, "a folder or a sequence of files", "Name the folder, or each file.")
    return [existing_file(path) for path in files]


def _one(path: Path, format: str, options: dict[str, Any]) -> FrequencyResponse:
    signal = READERS[format](path, **options)
    if not isinstance(signal, FrequencyResponse) or len(signal.dofs) != 1:
        several = isinstance(signal, FrequencyResponse)
        found = f"{len(signal.dofs)} responses" if several else "a record over time"
        each = (
            f"Name the records, as in {str(path.parent / '*')}{path.suffix}, and not their folder; in Python "
        )
        each += "read each by its own reader. Sensors of one test, a file each: join them by align."
        alone = "Read it alone by its own reader, or name the response that is meant."
        remedy = alone if several else each
        unsuitable(path, f"with {found}", "one response over frequency in each file", remedy)
    return signal


def _check_axes(paths: list[Path], read: list[FrequencyResponse]) -> None:
    """All files over one axis; the odd one is named, even if it is the first."""

    def alike(a: FrequencyResponse, b: FrequencyResponse) -> bool:
        same = a.freq_hz.size == b.freq_hz.size
        return same and bool(np.abs(a.freq_hz - b.freq_hz).max() <= SAME_LINE * a.freq_hz[-1])

    groups: list[list[int]] = []
    for i, one in enumerate(read):
        same = next((group for group in groups if alike(read[group[0]], one)), [])
        groups += [] if same else [same]
        same.append(i)
    most = max(groups, key=len)
    if len(groups) > 1:
        odd, usual = next(g[0] for g in groups if g is not most), most[0]
        wanted = f"{_axis(read[usual])}, as {len(most)} of {len(read)} files have ({paths[usual].name})"
        remedy = "Export all files over the same frequencies, or leave that one out."
        unsuitable(paths[odd], f"with {_axis(read[odd])}", wanted, remedy)


def _axis(response: FrequencyResponse) -> str:
    freq = response.freq_hz
    return f"{freq.size} lines {freq[0]:.9g}-{freq[-1]:.9g} Hz"


def natural(file: Path) -> list[tuple[int, str]]:
    """test_2 before test_10."""
    return [(int(part) if part.isdecimal() else -1, part.lower()) for part in re.split(r"(\d+)", file.name)]


def differences(stems: list[str]) -> list[Any]:
    """What tells names from each other, as numbers where all are."""
    tokens = [_TOKEN.findall(stem) for stem in stems]
    if len(stems) == 1 or len(set(stems)) < len(stems):
        return list(stems)
    for _ in range(2):  # what is common at the beginning, then at the end
        common = len(os.path.commonprefix(tokens))
        tokens = [each[common:][::-1] for each in tokens]
    found = ["".join(each).strip(" _-.") for each in tokens]
    if not all(found) or len(set(found)) < len(found):
        return list(stems)
    return [int(each) for each in found] if all(each.isdecimal() for each in found) else found
