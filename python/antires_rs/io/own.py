"""Options of a reader for a file of our own, which states itself what they would say."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.validation import finite_scalar, reject
from ._common import Signal
from .channels import Dofs, kept, renamed
from .units import named_unit

__all__ = ["own_signal", "relabelled"]


def own_signal(
    path: Path,
    signal: Signal,
    *,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
    fs_hz: float | None = None,
    **stated: Any,
) -> Signal:
    """A signal of ours with the channels that are kept, by their new names, and with its force or without.

    Every other option is refused, unless it says what the file says: an option that is passed over in silence
    looks as if it had worked.
    """
    made = _named(signal, dofs)
    _check_force(path, signal, force)
    if isinstance(made, Recording) and force is None:
        made = Recording(made.responses, made.fs_hz, made.dofs)
    stated |= {"fs_hz": None if fs_hz is None else finite_scalar("fs_hz", fs_hz), "unit": unit}
    if isinstance(signal, Recording):
        same: dict[str, tuple[Any, ...]] = {"responses": ("responses", ["responses"]), "first": ("time",)}
        if fs_hz is not None and np.isclose(stated["fs_hz"], signal.fs_hz, rtol=1e-9, atol=0.0):
            del stated["fs_hz"]
    else:
        same = {
            "responses": ("values", ["values"]),
            "first": ("freq",),
            "freq": ("freq_hz",),
            "kind": (signal.kind,),
            "reference": (signal.reference, _reference(made)),
        }
    # Our files hold SI, and any SI unit leaves values as they are.
    if unit is not None and named_unit("unit", unit).factor == 1.0:
        del stated["unit"]
    for name, value in stated.items():
        if value is not None and not any(
            type(value) is type(own) and value == own for own in same.get(name, ())
        ):
            reject(
                name,
                f"{value!r} for {str(path)!r}, a file of antires_rs ({_said(name, signal)})",
                "it with files of other programs alone",
                "This file states it itself; leave it out."
                + (" To leave channels out, name them by dofs." if name == "responses" else ""),
            )
    return made


def relabelled(signal: Signal, rows: list[int], dofs: list[Any]) -> Signal:
    """Some channels of a signal under other names."""
    if isinstance(signal, Recording):
        return Recording(signal.responses[rows], signal.fs_hz, dofs, signal.force)
    old = [signal.dofs[i] for i in rows]
    if signal.reference is not None and signal.reference not in old:
        reject("dofs", f"no dof for the reference, {signal.reference!r}", "one for it", "Keep that channel.")
    reference = None if signal.reference is None else dofs[old.index(signal.reference)]
    coherence, std = (None if a is None else a[rows] for a in (signal.coherence, signal.std))
    return FrequencyResponse(
        signal.freq_hz, signal.values[rows], dofs, signal.kind, reference, coherence, signal.n_averages, std
    )


def _named(signal: Signal, dofs: Dofs) -> Signal:
    if dofs is None:
        return signal
    labels = renamed("dofs", signal.dofs, dofs)
    rows = kept(labels)
    return relabelled(signal, rows, [labels[i] for i in rows])


def _check_force(path: Path, signal: Signal, force: Any) -> None:
    there = isinstance(signal, Recording) and signal.force is not None
    if force is not None and not (isinstance(force, str) and force in ("auto", *["force"] * there)):
        reject(
            "force",
            f"{force!r} for {str(path)!r}, a file of antires_rs {'with' if there else 'without'} a force",
            "'auto', 'force' or None" if there else "'auto' or None",
            "The file states itself which channel is its force; leave it out.",
        )


def _reference(signal: Signal) -> Any:
    return None if isinstance(signal, Recording) else signal.reference


def _said(name: str, signal: Signal) -> str:
    """What the file has in place of the option."""
    if name == "unit":
        return "in SI"
    if isinstance(signal, Recording):
        return f"a recording at {signal.fs_hz:g} Hz"
    return f"kind {signal.kind!r}" + ("" if signal.reference is None else f", reference {signal.reference!r}")
