"""Signals as CSV or TSV with a header that states everything, the number of rows included."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np

from ..signals.recording import Recording
from ..support.files import write_atomically
from ..support.validation import choice, reject
from ._common import Signal, signal_given
from ._packing import check_dofs
from .delimited_text import MARK, VERSION
from .units import named_unit

__all__ = ["write_csv"]


def write_csv(
    path: str | os.PathLike[str], signal: Signal, *, unit: str | None = None, delimiter: str = ","
) -> Path:
    """Write columns of text, whole or not at all; every float comes back bit for bit.

    Parameters
    ----------
    path : path-like
        Replaced if it exists.
    signal : Recording or FrequencyResponse
    unit : str, optional
        Unit of the values, which are in SI and stay as they are: ``'m/s2'`` (default), ``'m/s'``, ``'m'``
        for a recording, ``'m/s2/N'`` and the like for FRFs.
    delimiter : {",", ";", "\\\\t"}

    Returns
    -------
    pathlib.Path

    Raises
    ------
    InvalidInputError
        The folder does not exist, a unit that is not SI, dofs that are neither integers nor strings.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_csv(folder + "/a.csv", ar.Recording([[1.0, 2.5, 4.0]], 8.0, dofs=["tip"]))
    ...     print(file.read_text())
    # antires_rs csv 1
    # kind: "recording"
    # dofs: ["tip"]
    # rows: 3
    # unit: "m/s2"
    # fs_hz: 8.0
    # force: false
    time [s],tip [m/s2]
    0.0,1.0
    0.125,2.5
    0.25,4.0
    <BLANKLINE>
    """
    signal_given(signal)
    choice("delimiter", delimiter, (",", ";", "\t"))
    dofs = check_dofs(signal)
    head: dict[str, object] = {}
    if isinstance(signal, Recording):
        unit = "m/s2" if unit is None else unit
        head = {
            "kind": "recording",
            "dofs": dofs,
            "rows": signal.n_samples,
            "unit": unit,
            "fs_hz": signal.fs_hz,
            "force": signal.force is not None,
        }
        columns = [np.arange(signal.n_samples) / signal.fs_hz, *signal.responses]
        names = ["time [s]", *(f"{dof} [{unit}]" for dof in dofs)]
        if signal.force is not None:
            columns.append(signal.force)
            names.append("force [N]")
    else:
        unit = ("m/s2/N" if signal.kind == "frf" else "1") if unit is None else unit
        more = [name for name in ("coherence", "std") if getattr(signal, name) is not None]
        head = {
            "kind": signal.kind,
            "dofs": dofs,
            "rows": signal.n_freq,
            "unit": unit,
            "reference": signal.reference,
            "n_averages": signal.n_averages,
            "more": more,
        }
        columns = [signal.freq_hz, *(part for row in signal.values for part in (row.real, row.imag))]
        names = ["freq [Hz]", *(f"{part}({dof})" for dof in dofs for part in ("re", "im"))]
        for name in more:
            columns += list(getattr(signal, name))
            names += [f"{name}({dof})" for dof in dofs]
    if named_unit("unit", unit).factor != 1.0:
        reject(
            "unit",
            repr(unit),
            "an SI unit, such as 'm/s2' or 'm/s2/N': signals are in SI",
            "Convert the values to SI first, or leave unit out.",
        )
    lines = [
        f"{MARK} {VERSION}",
        *(f"# {name}: {json.dumps(value)}" for name, value in head.items()),
        delimiter.join(_safe(name, delimiter) for name in names),
    ]
    lines += [delimiter.join(map(repr, row)) for row in np.column_stack(columns).tolist()]
    return write_atomically(path, ("\n".join(lines) + "\n").encode())


def _safe(name: str, delimiter: str) -> str:
    """A column's name for the eye; the header has the dofs in full."""
    return "".join("_" if letter in (delimiter, "\n", "\r", '"') else letter for letter in name)
