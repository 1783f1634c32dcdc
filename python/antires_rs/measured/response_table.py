"""One table for the antiresonances of one response, from the order sweep to the saved set."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..exceptions import Argument, Name, part, reject
from ..support.checks import Dofs, FloatArray, label, labels, members, real_array
from ..support.values import FrozenDict, ReadOnly, frozen

# The five tests of a grade.
MORE_ROWS, MOST_SPREAD, LEAST_DOMINANCE, MOST_RESIDUAL, LEAST_PROMINENCE_DB = 20, 1e-3, 0.9, 0.1, 6.0

#: Columns of numbers in every table, and those of every row; scores stand beside them by their names.
NUMBERS = ("freq_hz", "damping_ratio", "std_hz")
COLUMNS = (*NUMBERS, "by_hand")

MOST_SECOND = 0.025  # second eigenvalue over the first beside a value up to which it is of one force
SURE_SHARE, SURE_SPREAD, SURE_DEPTH_DB = 0.9, 3e-3, 6.0  # of fits over windows: what a value that is sure has

#: Scores that are calculated with; others may be texts.
FIGURES = frozenset(
    ("rows", "spread", "dominance", "residual", "prominence_db", "share", "depth_db", "own_depth_db")
    + ("second", "averages", "expected_false", "followed", "known_hz")
)


def _score(name: str, says: str) -> Any:
    """A column of ``scores`` as an attribute."""
    return property(lambda table: table.scores[name], doc=says)


@dataclass(frozen=True, eq=False, init=False)
class ResponseTable(ReadOnly):
    """The antiresonances of one response, a row each, ascending in frequency, with what is known of them.

    Parameters
    ----------
    freq_hz : array_like, (n,)
        In any order; the other columns follow it.
    damping_ratio, std_hz, by_hand : array_like, (n,), optional
        NaN where not known, which is the default; whether a person added it.
    scores : mapping of name to array_like, (n,), optional
        What speaks for each, see :mod:`~antires_rs.identification.scores`; those below are attributes too.

    Examples
    --------
    >>> from antires_rs.measured.response_table import ResponseTable
    >>> table = ResponseTable([14.2, 8.7], std_hz=[0.1, 0.2], scores={"how": ["chain", "persistent"]})
    >>> table.freq_hz.tolist(), table.std_hz.tolist(), table.how.tolist(), table.damping_ratio.tolist()
    ([8.7, 14.2], [0.2, 0.1], ['persistent', 'chain'], [nan, nan])
    """

    freq_hz: FloatArray
    damping_ratio: FloatArray
    std_hz: FloatArray
    scores: Mapping[str, NDArray[Any]]
    by_hand: NDArray[np.bool_]

    rows = orders = _score("rows", "Model orders that have it.")
    spread = _score("spread", "Relative standard deviation of its frequency over the orders.")
    dominance = _score("dominance", "Share of the curve at its frequency.")
    # "chain": stable over consecutive orders; "persistent": in most orders, though it does not stand still;
    # "likeliest order": accepted at once from the fit of the order that the data support; "windows": seen by
    # most of the fits over windows; "directions": seen again by perturbed local fits; "followed": near the
    # place of a value that was known.
    how = _score("how", "Why accepted: chain, persistent, likeliest order, windows, directions, followed.")
    residual = _score("residual", "Relative misfit of the fit around it.")
    prominence_db = _score("prominence_db", "Height of its peak.")

    def __init__(
        self,
        freq_hz: ArrayLike,
        damping_ratio: ArrayLike | None = None,
        std_hz: ArrayLike | None = None,
        scores: Mapping[str, ArrayLike] | None = None,
        by_hand: ArrayLike | None = None,
    ) -> None:
        freq = np.asarray(freq_hz, dtype=np.float64)
        rank = np.argsort(freq, kind="stable")

        def column(name: str, values: Any, default: float | bool | None = None) -> NDArray[Any]:
            kind = None if default is None else type(default)
            array = np.full(freq.size, default) if values is None else np.asarray(values, dtype=kind)
            if array.shape != freq.shape:
                got, wanted = f"an array of shape {array.shape}", f"{freq.size}, one for each frequency"
                reject(name, got, wanted, "Give a value for each frequency.")
            return frozen(array[rank])

        self._fill(
            freq_hz=frozen(freq[rank]),
            damping_ratio=column("damping_ratio", damping_ratio, np.nan),
            std_hz=column("std_hz", std_hz, np.nan),
            scores=FrozenDict({name: column(name, values) for name, values in (scores or {}).items()}),
            by_hand=column("by_hand", by_hand, False),
        )

    @classmethod
    def of_sweep(
        cls,
        freq_hz: ArrayLike,
        damping_ratio: ArrayLike,
        std_hz: ArrayLike | None = None,
        *,
        rows: Sequence[int] | NDArray[Any],
        spread: ArrayLike,
        dominance: ArrayLike,
        how: str | Sequence[str] | NDArray[Any],
    ) -> ResponseTable:
        """What an order sweep tells; ``how`` is one for all, or one each. The other scores are not known."""
        n = len(rows)
        scores = {"rows": np.array(rows, dtype=np.int64)}
        scores |= {"spread": np.array(spread, dtype=float), "dominance": np.array(dominance, dtype=float)}
        scores["how"] = np.full(n, how) if isinstance(how, str) else np.array(how, dtype=np.str_)
        scores |= {"residual": np.full(n, np.nan), "prominence_db": np.full(n, np.nan)}
        return cls(freq_hz, damping_ratio, std_hz, scores)

    @classmethod
    def concatenated(cls, tables: Sequence[ResponseTable]) -> ResponseTable:
        """All rows of some tables; a score that one of them lacks is NaN there, or an empty text."""
        columns = {name: np.concatenate([getattr(one, name) for one in tables]) for name in COLUMNS}
        kinds = {name: values.dtype.kind for one in tables for name, values in one.scores.items()}
        missing = {name: "" if kind == "U" else np.nan for name, kind in kinds.items()}
        scores = {
            name: np.concatenate([one.scores.get(name, np.full(len(one), missing[name])) for one in tables])
            for name in kinds
        }
        return cls(**columns, scores=scores)

    def take(self, chosen: Sequence[int] | NDArray[Any]) -> ResponseTable:
        """Some of the rows, by index or by mask."""
        at = np.asarray(chosen, dtype=None if len(chosen) else np.intp)
        columns = {name: getattr(self, name)[at] for name in COLUMNS}
        return ResponseTable(**columns, scores={name: values[at] for name, values in self.scores.items()})

    def with_scores(self, **columns: Any) -> ResponseTable:
        """The same rows with more scores, or others."""
        return replace(self, scores={**self.scores, **columns})

    def same_as(self, other: ResponseTable) -> bool:
        """Same frequencies, damping ratios and standard deviations, bit for bit; scores do not count."""
        both = ((getattr(self, name), getattr(other, name)) for name in NUMBERS)
        return all(np.array_equal(*columns, equal_nan=True) for columns in both)

    def __len__(self) -> int:
        return int(self.freq_hz.size)


# -- Why an antiresonance asks for a look: a few words for each


Tests = tuple[tuple[str, Callable[[ResponseTable], NDArray[np.bool_]]], ...]
_SECOND = ("second force or noise", lambda t: ~(t.scores.get("second", np.zeros(1)) > MOST_SECOND))
#: What a grade's tests are called where they fail: of the sweep over orders, and of windows.
_TESTS: Tests = (
    _SECOND,
    ("few orders", lambda table: table.rows > MORE_ROWS),
    ("unsteady", lambda table: table.spread <= MOST_SPREAD),
    ("owns little of its curve", lambda table: table.dominance >= LEAST_DOMINANCE),
    ("poor fit", lambda table: table.residual <= MOST_RESIDUAL),
    ("no clear peak", lambda table: table.prominence_db >= LEAST_PROMINENCE_DB),
)
_OF_WINDOWS: Tests = (
    _SECOND,
    ("not in all fits", lambda table: table.scores["share"] >= SURE_SHARE),
    ("unsteady", lambda table: table.spread <= SURE_SPREAD),
    ("shallow dip", lambda t: np.fmin(t.scores["depth_db"], t.scores["own_depth_db"]) >= SURE_DEPTH_DB),
)
#: How a value was accepted, where that is a doubt.
_HOW = {"persistent": "does not stand still", "likeliest order": "one order only"}


def doubts_of(table: ResponseTable) -> list[list[str]]:
    """Words for every row: added by hand, how it was accepted, tests failed below "sure"."""
    found: list[list[str]] = [[] for _ in range(len(table))]
    for words, how in zip(found, table.scores.get("how", ()), strict=False):
        words += [_HOW[how]] if how in _HOW else []
    if "grade" in table.scores:
        sure = table.scores["grade"].astype(str) == "sure"
        for word, passed in _OF_WINDOWS if "depth_db" in table.scores else _TESTS:
            with suppress(KeyError):  # a score that a set made by hand lacks raises no doubt
                for row in np.flatnonzero(~sure & ~passed(table)):
                    found[row].append(word)
    for words, doubt in zip(found, table.scores.get("doubt", ()), strict=False):
        # "second force or noise" beside the value says it already.
        words += [one for one in str(doubt).split(", ") if one and not any(one in word for word in words)]
    return [["added by hand"] if hand else words for hand, words in zip(table.by_hand, found, strict=True)]


# -- What a caller or a file gives by dof, checked: one :class:`ResponseTable` for each response


#: Of r forces so many sets of r responses are looked at, where there are more.
MOST_SETS = 300


def key_of(excitation: Any, keys: Iterable[Any], channels: Iterable[Any]) -> Callable[[Name, Any], Any]:
    """How responses to such a force are named: a dof, or of r forces r dofs.

    Numbers ascend, other dofs stand in the order of the channels, behind them of all ``keys``.
    """
    order = len(members(excitation))
    named = [*channels, *(dof for key in keys if isinstance(key, list | tuple) for dof in key)]
    rank = {dof: at for at, dof in enumerate(dict.fromkeys(named))} if order > 1 else {}

    def key(name: Name, value: Any) -> Any:
        if order == 1 and not isinstance(value, list | tuple):
            return label(name, value)
        dofs = labels(name, value)
        if len(dofs) != order:
            what, each = ("force", "response") if order == 1 else ("forces", "responses")
            got = f"{value!r}, which is {len(dofs)} dof{'s' * (len(dofs) > 1)}"
            remedy = "Name as many responses as forces act: excitation=[0, 4] goes with {(1, 5): [...]}."
            reject(name, got, f"{order} {each} for {order} {what}", remedy)
        if order == 1:
            return dofs[0]
        numbers = all(isinstance(dof, int) for dof in dofs)
        return Dofs(sorted(dofs) if numbers else sorted(dofs, key=lambda dof: rank.get(dof, len(rank))))

    return key


def label_array(labels: Sequence[Any]) -> NDArray[Any]:
    """Labels of any kind side by side, (n,), of which numpy would make text, or two axes."""
    array = np.empty(len(labels), dtype=object)
    for at, one in enumerate(labels):
        array[at] = one
    return frozen(array)


def rows_with(labels: NDArray[Any], *some: Any) -> NDArray[np.bool_]:
    """Which of the labels, (n,), are one of ``some``."""
    return np.array([one in some for one in labels], dtype=bool)


def tables_of(
    freq_hz: Mapping[Any, Any],
    damping_ratio: Any,
    std_hz: Any,
    scores: Mapping[Any, Mapping[str, Any]] | None,
    named: Callable[[Name, Any], Any],
) -> dict[Any, ResponseTable]:
    """Tables by dof; the companions follow their frequencies. ``named`` of :func:`key_of`."""
    frequencies: dict[Any, FloatArray] = {}
    for key, value in freq_hz.items():
        dof = named("freq_hz", key)
        if dof in frequencies:
            reject("freq_hz", f"dof {dof!r} more than once", "each dof once", "Join its values in one list.")
        frequencies[dof] = frequencies_hz(("freq_hz", dof), value)
    damping, std = (
        {
            dof: companion((name, dof), value, n, std=name == "std_hz")
            for dof, value, n in _by_dof(name, given, frequencies, named)
        }
        for name, given in (("damping_ratio", damping_ratio), ("std_hz", std_hz))
    )
    known: dict[Any, dict[str, NDArray[Any]]] = {}
    for dof, own, n in _by_dof("scores", scores, frequencies, named):
        if not isinstance(own, Mapping):
            wanted = "a mapping of score to one value for each frequency"
            reject(part("scores", dof), type(own).__name__, wanted, "As in {'grade': ['sure', 'weak']}.")
        known[dof] = {name: score(part("scores", dof).item(name), given, n) for name, given in own.items()}
    return {d: ResponseTable(own, damping.get(d), std.get(d), known.get(d)) for d, own in frequencies.items()}


def frequencies_hz(name: Name, value: Any, *, empty: bool = True) -> FloatArray:
    """A 1-D array, which may be ``empty``, in the order given; a number is a list of one."""
    if empty and np.size(value) == 0:
        return np.empty(0)
    wanted = "positive frequencies in Hz" if empty else "one or more positive frequencies in Hz"
    values = np.atleast_1d(real_array(name, value, ndim=None, wanted=wanted)).ravel()
    if values.min() <= 0.0:
        reject(name, f"{values.min():g} Hz", wanted, "Leave out what is not above zero.")
    return values


def _by_dof(
    name: str, given: Any, frequencies: Mapping[Any, FloatArray], named: Callable[[Name, Any], Any]
) -> Iterator[tuple[Any, Any, int]]:
    """Dof, companions and number of frequencies."""
    if given is not None and not isinstance(given, Mapping):
        wanted = "a mapping of dof to one value for each frequency"
        reject(name, type(given).__name__, wanted, "Pass a dict with the keys of freq_hz.")
    for key, value in (given or {}).items():
        dof = named(name, key)
        if dof not in frequencies:
            wanted = f"dofs of freq_hz, {tuple(frequencies)}"
            reject(name, f"dof {dof!r}", wanted, "Leave that dof out, or give its frequencies too.")
        yield dof, value, frequencies[dof].size


def score(name: Argument, values: Any, count: int) -> NDArray[Any]:
    """One score for each frequency: numbers where something is calculated with it."""
    kinds, what = ("biuf", "numbers") if name.path[-1] in FIGURES else ("biufU", "numbers or texts")
    remedy = "Give a score for each frequency; NaN where it is not known."
    try:
        array = np.asarray(values)
    except ValueError:
        reject(name, "lists of different lengths", f"{count} {what}, one for each frequency", remedy)
    if array.shape != (count,):
        got, wanted = f"an array of shape {array.shape}", f"{count} scores, one for each frequency"
        reject(name, got, wanted, remedy)
    if array.dtype.kind not in kinds:
        reject(name, f"values of type {array.dtype}", what, remedy)
    return array


def companion(name: Name, value: Any, count: int, *, std: bool) -> FloatArray:
    """One number for each frequency, NaN where not known; ``std``: standard deviations in Hz."""
    wanted = "one value for each frequency, finite or NaN for not known"
    try:
        array = np.atleast_1d(np.asarray(value, dtype=np.float64)).ravel()
    except (TypeError, ValueError) as exc:
        got = f"{type(value).__name__} that does not convert ({exc})"
        reject(name, got, wanted, "Pass numbers, as a list or a numpy array.")
    if array.size != count:
        remedy = "Give a value for each frequency; NaN where it is not known."
        reject(name, f"{array.size} values", f"{count}, one for each frequency", remedy)
    if np.isinf(array).any():
        reject(name, "an infinite value", wanted, "Pass NaN where it is not known.")
    if std and (array < 0.0).any():
        wanted = "standard deviations of at least 0 Hz"
        reject(name, f"{np.nanmin(array):g} Hz", wanted, "Pass NaN where it is not known.")
    return array
