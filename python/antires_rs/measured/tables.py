"""What a caller or a file gives by dof, checked: one :class:`ResponseTable` for each response."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..order_sweep.table import ResponseTable
from ..support.validation import FloatArray, part, real_array, reject

__all__ = ["frequencies_hz", "label", "tables_of"]


def label(name: str, value: Any) -> Any:
    """An integer or a string; numpy's integers become Python's."""
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, bool) or not isinstance(value, int | str):
        reject(name, value, "a dof named by an integer or a string", "Name the dof by a number or a text.")
    return value


def tables_of(
    freq_hz: Any, damping_ratio: Any, std_hz: Any, scores: Mapping[Any, Mapping[str, Any]] | None
) -> dict[Any, ResponseTable]:
    """Tables by dof; the companions follow their frequencies."""
    if not isinstance(freq_hz, Mapping) or not freq_hz:
        got = "an empty mapping" if isinstance(freq_hz, Mapping) else type(freq_hz).__name__
        reject(
            "freq_hz",
            got,
            "a mapping of dof to frequencies in Hz, e.g. {0: [12.2, 36.2], 1: []}",
            "Pass a dict, with an empty list for a response without antiresonances.",
        )
    frequencies: dict[Any, FloatArray] = {}
    for key, value in freq_hz.items():
        dof = label("freq_hz", key)
        if dof in frequencies:
            reject("freq_hz", f"dof {dof!r} more than once", "each dof once", "Join its values in one list.")
        frequencies[dof] = frequencies_hz(part("freq_hz", dof), value)
    sizes = {dof: values.size for dof, values in frequencies.items()}
    damping, std = _companions("damping_ratio", damping_ratio, sizes), _companions("std_hz", std_hz, sizes)
    known = _scores(scores, sizes)
    return {
        dof: ResponseTable(values, damping.get(dof), std.get(dof), known.get(dof))
        for dof, values in frequencies.items()
    }


def frequencies_hz(name: str, value: Any) -> FloatArray:
    """A 1-D array, possibly empty; a number is a list of one."""
    if np.size(value) == 0:
        return np.empty(0)
    wanted = "positive frequencies in Hz"
    values = np.atleast_1d(real_array(name, value, ndim=None, wanted=wanted)).ravel()
    if values.min() <= 0.0:
        reject(name, f"{values.min():g} Hz", wanted, "Leave out what is not above zero.")
    return values


def _companions(name: str, given: Any, sizes: Mapping[Any, int]) -> dict[Any, FloatArray]:
    """One number for each frequency, NaN where not known."""
    if given is not None and not isinstance(given, Mapping):
        reject(
            name,
            type(given).__name__,
            "a mapping of dof to one value for each frequency",
            "Pass a dict with the keys of freq_hz.",
        )
    wanted = "one value for each frequency, finite or NaN for not known"
    columns: dict[Any, FloatArray] = {}
    for key, value in (given or {}).items():
        dof = _of_freq_hz(name, key, sizes)
        try:
            array = np.atleast_1d(np.asarray(value, dtype=np.float64)).ravel()
        except (TypeError, ValueError) as exc:
            reject(
                part(name, dof),
                f"{type(value).__name__} that does not convert ({exc})",
                wanted,
                "Pass numbers, as a list or a numpy array.",
            )
        if array.size != sizes[dof]:
            reject(
                part(name, dof),
                f"{array.size} values",
                f"{sizes[dof]}, one for each frequency",
                "Give a value for each frequency; NaN where it is not known.",
            )
        if np.isinf(array).any():
            reject(part(name, dof), "an infinite value", wanted, "Pass NaN where it is not known.")
        if name == "std_hz" and (array < 0.0).any():
            reject(
                part(name, dof),
                f"{np.nanmin(array):g} Hz",
                "standard deviations of at least 0 Hz",
                "Pass NaN where it is not known.",
            )
        columns[dof] = array
    return columns


def _scores(
    given: Mapping[Any, Mapping[str, Any]] | None, sizes: Mapping[Any, int]
) -> dict[Any, dict[str, Any]]:
    """Arrays of one score for each frequency, by dof and name."""
    scores: dict[Any, dict[str, Any]] = {}
    for key, columns in (given or {}).items():
        dof = _of_freq_hz("scores", key, sizes)
        scores[dof] = {name: np.asarray(column) for name, column in columns.items()}
        for name, array in scores[dof].items():
            if array.shape != (sizes[dof],):
                reject(
                    part("scores", dof).item(name),
                    f"an array of shape {array.shape}",
                    f"{sizes[dof]} scores, one for each frequency",
                    "Give a score for each frequency; NaN where it is not known.",
                )
    return scores


def _of_freq_hz(name: str, key: Any, sizes: Mapping[Any, int]) -> Any:
    dof = label(name, key)
    if dof not in sizes:
        reject(
            name,
            f"dof {dof!r}",
            f"dofs of freq_hz, {tuple(sizes)}",
            "Leave that dof out, or give its frequencies too.",
        )
    return dof
