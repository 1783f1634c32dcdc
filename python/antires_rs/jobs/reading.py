"""Signals of any format, by the options of a job or of the command line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from .. import io
from ..exceptions import InvalidInputError
from ..io._common import Signal
from ..io.channels import kept, renamed
from ..io.own import relabelled
from ..io.readers import READERS
from ..io.uff_names import as_point
from ..support.validation import reject
from ..support.wording import LeftOut, Part, spelled
from .formats import FOLDER
from .keys_data import DATA
from .values import shown

__all__ = ["Signal", "read_signal", "relabelled"]

_READERS: dict[str, Callable[..., Signal]] = {**READERS, FOLDER: io.read_frf_files}
#: How this is done in a job and on the command line.
LEAVE_OUT = "Give it a dof, or leave it out: false in a job, CHANNEL= on the command line"
#: Keys of [data] that are not a reader's.
_OURS = {"file", "repeats", "format", "excitation", "band_hz", "dofs", "drop", "add"}


def _in_a_job(part: Part) -> str:
    if isinstance(part, LeftOut):
        return LEAVE_OUT
    return part.name if part.value is None else f"{part.name} = {shown(part.value)}"


def read_signal(
    file: Path, kind: str, options: dict[str, Any], spell: Callable[[Part], str] = _in_a_job
) -> Signal:
    """Read a signal; ``options`` are keys of [data].

    ``spell`` writes an argument of the reader, or how a channel is left out, as this user would.

    Raises
    ------
    InvalidInputError
        As the reader of that format, or dofs that do not fit its channels.
    """
    chosen = {name: value for name, value in options.items() if name not in _OURS}
    for name in chosen:
        key = DATA.key(name)
        if key and key.of and kind not in key.of:
            reject(name, f"it for a {kind} file", f"{name} with {' or '.join(key.of)} alone", "Leave it out.")
    if kind == FOLDER and "format" in options:
        chosen["format"] = options["format"]
    if chosen.get("force") is False:
        chosen["force"] = None
    dofs = (
        {name: _plain(dof) for name, dof in options["dofs"].items()}
        if isinstance(options.get("dofs"), dict)
        else [_plain(dof) for dof in options.get("dofs", [])]
    )
    # Universal files name points, whose sign may have to be turned: that is the reader's.
    by_point = kind == "uff" and isinstance(dofs, dict) and all(map(_is_point, dofs))
    left_out = {name for name, dof in dofs.items() if dof is None} if isinstance(dofs, dict) else set()
    if by_point:
        chosen["dofs"] = dofs
    elif left_out and kind != FOLDER:  # before the reader finds that they do not fit the rest
        chosen["dofs"] = lambda name: None if str(name) in left_out else name
    try:
        signal = _READERS[kind](file, **chosen)
    except InvalidInputError as exc:  # which speaks to one who calls from Python
        said = (spelled(text, spell) for text in (exc.got, exc.wanted, exc.remedy))
        raise type(exc)(exc.argument, *said) from exc
    return signal if by_point or not dofs else _named(signal, dofs)


def _named(signal: Signal, dofs: dict[Any, Any] | list[Any]) -> Signal:
    """The channels that have a dof, under its name."""
    names = [str(name) for name in signal.dofs] if isinstance(dofs, dict) else list(signal.dofs)
    if isinstance(dofs, dict):
        for name, dof in dofs.items():
            if name not in names and dof is not None:
                reject(
                    "dofs", f"{name!r}, which is no channel", f"names out of {names}", "Correct or remove it."
                )
        for name in names:
            if name not in dofs:
                reject("dofs", f"no dof for channel {name!r}", f"one for each of {names}", f"{LEAVE_OUT}.")
    labels = renamed("dofs", names, dofs)
    rows = kept(labels)
    return relabelled(signal, rows, [labels[i] for i in rows])


def _plain(dof: Any) -> Any:
    return None if dof is False else dof


def _is_point(name: str) -> bool:
    try:
        as_point("dofs", name)
    except InvalidInputError:
        return False
    return True
