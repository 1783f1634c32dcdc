"""Signals of any format, by the options of a job or of the command line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from .. import io
from .._validation import reject
from ..signals import FrequencyResponse, Recording
from .keys import DATA

__all__ = ["Signal", "read_signal", "relabelled"]

Signal = Recording | FrequencyResponse

_READERS: dict[str, Callable[..., Signal]] = {"uff": io.read_uff, "mat": io.read_mat, "hdf5": io.read_hdf5, "csv": io.read_csv,
            "npz": io.read_npz}
#: Keys of [data] that are not a reader's.
_OURS = {"file", "format", "excitation", "band_hz"}


def read_signal(file: Path, kind: str, options: dict[str, Any]) -> Signal:
    """Read a signal; ``options`` are keys of [data], false standing for None.

    Raises
    ------
    InvalidInputError
        As the reader of that format.
    """
    chosen = {name: value for name, value in options.items() if name not in _OURS}
    for name in chosen:
        key = DATA.key(name)
        if key and key.of and kind not in key.of:
            reject(name, f"{name!r} for a {kind} file", f"{name} with {' or '.join(key.of)} alone",
                   "Leave it out.")
    if chosen.get("force") is False:
        chosen["force"] = None
    if "dofs" in chosen:
        chosen["dofs"] = _dofs(chosen["dofs"], kind)
    return _READERS[kind](file, **chosen)


def relabelled(signal: Signal, dofs: list[Any], reference: Any = None) -> Signal:
    """The same signal with other names of its dofs."""
    if isinstance(signal, Recording):
        return Recording(signal.responses, signal.fs_hz, dofs, signal.force)
    return FrequencyResponse(signal.freq_hz, signal.values, dofs, signal.kind, reference, signal.coherence,
                             signal.n_averages, signal.std)


def _dofs(dofs: Any, kind: str) -> Any:
    """Dofs as the readers take them: None leaves a channel out."""
    def one(dof: Any) -> Any:
        return None if dof is False else dof
    if isinstance(dofs, dict):
        return {name: one(dof) for name, dof in dofs.items()}
    if kind == "uff":
        reject("dofs", "a list for a universal file", "name = dof for each channel, such as \"12+Z\" = 0",
               "'antires init --data FILE' lists the channels.")
    return [one(dof) for dof in dofs]
