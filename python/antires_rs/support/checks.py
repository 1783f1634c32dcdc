"""Argument checks: each returns the value in the form the code works with, or refuses it."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Sequence
from difflib import get_close_matches
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..exceptions import InvalidInputError, Name, reject

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]
T = TypeVar("T")

_LABELS = "List a label for each channel, or leave them out to number the channels from 0."

_SMALLEST, _LARGEST = 1e-100, 1e100  # beyond these, powers of values overflow or vanish


def real_array(
    name: Name, value: Any, *, ndim: int | None, wanted: str, dtype: type = np.float64
) -> NDArray[Any]:
    """Finite, non-empty array of the wanted number of dimensions, float64 unless another type is named."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        got = f"a masked array with {int(np.count_nonzero(np.ma.getmaskarray(value)))} values masked"
        remedy = "Cut what is masked, or fill it in: numpy would take the values below the mask."
        reject(name, got, wanted, remedy)
    try:
        array = np.asarray(value)
        if dtype is np.float64 and np.iscomplexobj(array):
            remedy = "Pass the real parts or the magnitudes, whichever is meant."
            reject(name, f"complex values of dtype {array.dtype}", wanted, remedy)
        array = np.ascontiguousarray(array, dtype=dtype)
    except (TypeError, ValueError) as exc:
        if isinstance(exc, InvalidInputError):
            raise
        got = f"{type(value).__name__} that does not convert ({exc})"
        reject(name, got, wanted, "Pass numbers, as a list or a numpy array.")
    # ascontiguousarray lifts scalars to 1-D; keep what the caller gave.
    array = array.reshape(np.shape(value)) if np.ndim(value) == 0 else array
    if ndim is not None and array.ndim != ndim:
        reject(name, f"an array of shape {array.shape}", wanted, "Check its axes by np.shape.")
    if array.size == 0:
        reject(name, f"an empty array of shape {array.shape}", wanted, "Check how it was read or cut.")
    finite = np.isfinite(array)
    if not finite.all():
        bad = np.argwhere(~finite)
        got = f"{len(bad)} NaN or infinite value(s), the first at index {tuple(bad[0].tolist())}"
        reject(name, got, wanted, "Remove or interpolate them first.")
    return array


def in_range(name: str, array: NDArray[Any]) -> None:
    """Refuse numbers whose powers leave floating point: no quantity in any unit is as large or small."""
    plain = array.view(np.float64) if np.iscomplexobj(array) else array
    largest = max(float(plain.max()), -float(plain.min()))
    if largest and not _SMALLEST <= largest <= _LARGEST:
        wanted = f"values whose largest is between {_SMALLEST:g} and {_LARGEST:g}"
        remedy = "Check how the file was read; scale the values if they are right."
        reject(name, f"values up to {largest:.3g}", wanted, remedy)


def complex_rows(name: str, value: Any, n_columns: int, *, wanted: str) -> ComplexArray:
    """Complex array (n_rows, n_columns); a vector is taken as one row."""
    array = real_array(name, value, ndim=None, wanted=wanted, dtype=np.complex128)
    array = array[None, :] if array.ndim == 1 else array
    if array.ndim != 2 or array.shape[1] != n_columns:
        reject(name, f"an array of shape {array.shape}", wanted, "Check its axes by np.shape.")
    return array


def shape_of(value: Any) -> tuple[int, ...]:
    """Shape of anything array-like; of a ragged sequence, which has none, its length."""
    try:
        return np.shape(value)
    except ValueError:
        return (len(value),)


def random_generator(rng: Any) -> np.random.Generator:
    """The generator given, or one seeded by the integer given, or by the system."""
    if rng is None or isinstance(rng, np.random.Generator):
        return np.random.default_rng(rng)
    if isinstance(rng, bool | np.bool_) or not isinstance(rng, int | np.integer) or rng < 0:
        remedy = "Pass a number such as rng=0 to have the same draw again, or leave it out."
        reject("rng", rng, "an integer of at least 0, a numpy Generator or None", remedy)
    return np.random.default_rng(int(rng))


def finite_scalar(
    name: Name,
    value: Any,
    *,
    low: float = -np.inf,
    high: float = np.inf,
    low_open: bool = False,
    high_open: bool = False,
    unit: str = "",
) -> float:
    """One finite real number inside an interval."""
    left, right = ("(" if low_open else "["), (")" if high_open else "]")
    interval = f" in {left}{low:g}, {high:g}{right}"
    if np.isinf(high):
        interval = "" if np.isinf(low) else f" above {low:g}" if low_open else f" of at least {low:g}"
    wanted = f"a finite number{interval}{' ' + unit if unit else ''}"
    try:
        if isinstance(value, bool | str | bytes) or shape_of(value) != ():
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        reject(name, repr(value), wanted, "Pass one number, without quotes.")
    below = number <= low if low_open else number < low
    above = number >= high if high_open else number > high
    if not np.isfinite(number) or below or above:
        reject(name, repr(value), wanted, _into_limits(below, above))
    return number


def integer(name: Name, value: Any, *, low: int | None = None, high: int | None = None) -> int:
    """One integer inside a closed interval; booleans and floats are refused."""
    wanted = "an integer"
    if low is not None and high is not None:
        wanted += f" in {low}..{high}"
    elif low is not None or high is not None:
        wanted += f" of at most {high}" if low is None else f" of at least {low}"
    try:
        if isinstance(value, bool | np.bool_):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        reject(name, repr(value), wanted, "Pass a whole number, without a fraction.")
    below, above = low is not None and number < low, high is not None and number > high
    if below or above:
        reject(name, repr(value), wanted, _into_limits(below, above))
    return number


def _into_limits(below: bool, above: bool) -> str:
    if below:
        return "Pass a larger one."
    return "Pass a smaller one." if above else "Check the computation that gave it."


def choice(name: str, value: Any, options: Sequence[T]) -> T:
    """One of a short list of allowed values."""
    for option in options:
        if type(value) is type(option) and value == option:
            return option
    known = {str(option).lower(): option for option in options}
    near = get_close_matches(value.lower(), known, 1, 0.6) if isinstance(value, str) else ()
    remedy = f"Did you mean {known[near[0]]!r}?" if near else "Choose one of them."
    reject(name, repr(value), "one of " + ", ".join(repr(option) for option in options), remedy)


def frequency_band(name: str, value: Any, *, low_hz: float, high_hz: float) -> tuple[float, float]:
    """A pair (low, high) in Hz with low < high, inside what the data cover."""
    wanted = f"two numbers in Hz, low and high, with {low_hz:g} <= low < high <= {high_hz:g}"
    try:
        if shape_of(value) != (2,):
            raise TypeError
        low, high = (float(v) for v in value)
    except (TypeError, ValueError):
        reject(name, value, wanted, "Write it as in (5.0, 100.0).")
    # One part in 1e9 of slack: a band typed in decimal must be allowed to meet the data's own edge.
    slack = 1e-9 * max(high_hz, 1.0)
    if not low_hz - slack <= low < high <= high_hz + slack:  # nor NaN
        remedy = "The lower one comes first." if low >= high else "Narrow the band to the data."
        if high > high_hz:
            remedy = "Narrow the band to the data, or correct their sampling rate if it is wrong."
        reject(name, f"{low:g} to {high:g} Hz", wanted, remedy)
    return low, high


def dof_labels(name: str, value: Iterable[Any] | None, count: int) -> tuple[Any, ...]:
    """Unique, hashable labels, one a channel; ``None`` numbers them from zero."""
    wanted = f"{count} distinct labels (integers or strings), one for each channel"
    if value is None:
        return tuple(range(count))
    if isinstance(value, str | bytes):
        reject(name, value, wanted, _LABELS)
    try:
        whole = (int, np.integer)
        labels = tuple(int(v) if isinstance(v, whole) and not isinstance(v, bool) else v for v in value)
        distinct = len(set(labels))
    except TypeError:
        reject(name, value, wanted, _LABELS)
    if len(labels) != count:
        reject(name, f"{len(labels)} labels", wanted, _LABELS)
    if distinct != count:
        twice = next(v for v in labels if labels.count(v) > 1)
        reject(name, f"label {twice!r} more than once", wanted, "Rename one of the two.")
    return labels


# -- Dofs by name: one, or several that act or answer together


class Dofs(tuple[Any, ...]):
    """Several dofs that stand for one thing: where r forces act, or the r responses of a minor.

    Examples
    --------
    >>> from antires_rs.support.checks import Dofs
    >>> pair = Dofs([1, 5])
    >>> str(pair), pair == (1, 5)
    ('1, 5', True)
    """

    __slots__ = ()

    def __str__(self) -> str:
        return label_text(self)

    @classmethod
    def of_file(cls, value: Any) -> Any:
        """A label out of JSON, where several dofs are a list."""
        return cls(value) if isinstance(value, list) else value

    @staticmethod
    def cell(value: Any) -> Any:
        """A label for a table of another program, where several dofs are text."""
        return str(value) if isinstance(value, Dofs) else value


def members(label: Any) -> list[Any]:
    """The dofs of a label, which may be several."""
    return list(label) if isinstance(label, tuple) else [label]


def label_text(label: Any, named: Callable[[Any], str] = str, *, listed: bool = False) -> str:
    """A dof, or several as "1, 5", for a reader; in a list of others (``listed``) as "(1, 5)".

    It is what the key of a set looks like, and leaves "and" to sentences. ``named`` is the name of one dof.
    """
    text = ", ".join(named(dof) for dof in members(label))
    return f"({text})" if listed and isinstance(label, tuple) else text


def label(name: Name, value: Any) -> Any:
    """An integer or a string; numpy's integers become Python's."""
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, bool) or not isinstance(value, int | str):
        reject(name, value, "a dof named by an integer or a string", "Name the dof by a number or a text.")
    return value


def labels(name: Name, value: Any) -> list[Any]:
    """The dofs of a label that may be a list of them, each once."""
    given = value.tolist() if isinstance(value, np.ndarray) else value
    listed = given if isinstance(given, list | tuple) else [given]
    dofs = [label(name, dof) for dof in listed]
    if not dofs or len(set(dofs)) < len(dofs):
        got = f"{value!r}, the same dof twice" if dofs else f"{value!r} without a dof"
        reject(name, got, "one dof or several different ones", "Name each place once, such as [0, 4].")
    return dofs


def force_label(name: Name, value: Any) -> Any:
    """Where the force acts: a dof, of a list of one that one, of a longer list its dofs in one order."""
    dofs = labels(name, value)
    return dofs[0] if len(dofs) == 1 else Dofs(sorted(dofs, key=lambda dof: (isinstance(dof, str), dof)))


def forces_at(excitation: Any) -> str:
    """Where the force acts, or the forces act, as text."""
    return f"force{'s' * isinstance(excitation, Dofs)} at {excitation}"
