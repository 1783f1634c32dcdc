"""Columns of an AntiresonanceSet: checked, sorted with the frequencies, and as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.pickling import frozen
from ..support.validation import FloatArray, real_array, reject

if TYPE_CHECKING:
    from .antiresonance_set import AntiresonanceSet

#: What a text score of a value added by hand says.
BY_HAND = "by hand"


def label(name: str, value: Any) -> Any:
    """An integer or a string; numpy's integers become Python's."""
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, bool) or not isinstance(value, int | str):
        reject(name, value, "a dof named by an integer or a string")
    return value


def values_of(name: str, value: Any, wanted: str) -> FloatArray:
    """A 1-D array, possibly empty; a number is a list of one."""
    if np.size(value) == 0:
        return np.empty(0)
    return np.atleast_1d(real_array(name, value, ndim=None, wanted=wanted)).ravel()


def companions(name: str, given: Mapping[Any, Any] | None, rank: Mapping[Any, Any]) -> dict[Any, FloatArray]:
    """One value for each frequency, in the order of ``rank``; NaN where not known."""
    if given is not None and not isinstance(given, Mapping):
        reject(name, type(given).__name__, "a mapping of dof to one value for each frequency")
    store: dict[Any, FloatArray] = {}
    for key, value in (given or {}).items():
        dof = label(name, key)
        if dof not in rank:
            reject(name, f"dof {dof!r}", f"dofs of freq_hz, {tuple(rank)}")
        wanted = "one value for each frequency, finite or NaN for not known"
        try:
            array = np.atleast_1d(np.asarray(value, dtype=np.float64)).ravel()
        except (TypeError, ValueError) as exc:
            reject(f"{name}[{dof!r}]", f"{type(value).__name__} that does not convert ({exc})", wanted)
        if array.size != rank[dof].size:
            reject(f"{name}[{dof!r}]", f"{array.size} values", f"{rank[dof].size}, one for each frequency")
        if np.isinf(array).any():
            reject(f"{name}[{dof!r}]", "an infinite value", wanted)
        if name == "std_hz" and (array < 0.0).any():
            reject(f"{name}[{dof!r}]", f"{np.nanmin(array):g} Hz", "standard deviations of at least 0 Hz")
        store = with_column(store, dof, array[rank[dof]])
    return store


def with_column(table: Mapping[Any, FloatArray], dof: Any, column: FloatArray) -> dict[Any, FloatArray]:
    """The table with this column; a column in which nothing is known is left out."""
    rest = {key: value for key, value in table.items() if key != dof}
    return rest if column.size and np.isnan(column).all() else {**rest, dof: frozen(column)}


def sorted_scores(
    given: Mapping[Any, Mapping[str, Any]] | None, rank: Mapping[Any, Any]
) -> dict[Any, dict[str, Any]]:
    """Scores of each dof, in the order of ``rank``."""
    store: dict[Any, dict[str, Any]] = {}
    for key, columns in (given or {}).items():
        dof = label("scores", key)
        if dof not in rank:
            reject("scores", f"dof {dof!r}", f"dofs of freq_hz, {tuple(rank)}")
        store[dof] = {}
        for name, column in columns.items():
            array = np.asarray(column)
            if array.shape != (rank[dof].size,):
                reject(
                    f"scores[{dof!r}][{name!r}]",
                    f"an array of shape {array.shape}",
                    f"{rank[dof].size} scores, one for each frequency",
                )
            store[dof][name] = frozen(array[rank[dof]])
    return store


def unknown_scores(column: Any, count: int) -> Any:
    """The scores of values that no method found."""
    return np.full(count, BY_HAND) if column.dtype.kind == "U" else np.full(count, np.nan)


def table(values: AntiresonanceSet) -> tuple[list[str], list[dict[str, Any]]]:
    """Column names and one row a value, for data frames."""
    made = values.by_hand()
    scores = list(dict.fromkeys(name for columns in values.scores.values() for name in columns))
    opinion = values.second_opinion
    rows = []
    for dof in values:
        columns = values.columns(dof)
        own = values.scores.get(dof, {})
        for i, freq in enumerate(columns["freq_hz"].tolist()):
            row = {
                "dof": dof,
                **{name: float(column[i]) for name, column in columns.items()},
                "source": BY_HAND if (dof, freq) in made else "identified",
            }
            row |= {name: own[name][i].item() if name in own else None for name in scores}
            if opinion is not None:
                row["confirmed"] = opinion.is_confirmed(dof, freq)
            rows.append(row)
    known = ["dof", "freq_hz", "damping_ratio", "std_hz", "source"]
    return [*known, *scores, *([] if opinion is None else ["confirmed"])], rows
