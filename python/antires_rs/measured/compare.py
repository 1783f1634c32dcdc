"""Two sets of antiresonances of one structure: what is different, and is it more than the errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..support.checks import FloatArray, forces_at
from ..support.messages import some, warn
from ..support.values import FrozenDict, ReadOnly, frozen
from ..views import Viewed
from . import matching
from .antiresonance_set import AntiresonanceSet, aligned, number
from .matching import MAX_SHIFT, SeriesOfTests, check_set, variance_hz, within
from .response_table import label_array

#: Ratio of how strongly two tests shook from which amplitude is named as a reason of differences.
OTHER_AMPLITUDE = 1.5


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(ReadOnly, Viewed):
    """What :func:`compare` found; print it for a table.

    Attributes
    ----------
    excitation : int, str or tuple
    dof : (n,)
        Response of each pair.
    a_hz, b_hz : (n,)
        The two values.
    std_hz : (n,)
        Standard deviation of the difference; NaN where not known.
    z, p : (n,)
        Difference over its standard deviation, and the probability of one as large by chance.
    changed : (n,) bool
        Whether this value is different, with a chance of at most ``alpha`` that any is marked wrongly.
    chi_square, freedom, p_all : float, int, float
        The test of all, see :mod:`antires_rs.measured.matching`.
    alpha : float
        Rate of false alarms of both tests.
    unmatched_a, unmatched_b : mapping of dof to (m,)
        Values in Hz that the other set does not have; dofs without any are left out.
    level_ratio : float
        How strongly the structure shook in b, as a multiple of a (0.999 quantiles of the samples, in the unit
        of both records); NaN where a set is not of a record.

    Examples
    --------
    >>> import antires_rs as ar
    >>> a, b = (ar.AntiresonanceSet(0, {0: f}, std_hz={0: [0.01]}) for f in ([8.70], [8.72]))
    >>> ar.compare(a, b).different
    False
    """

    excitation: Any
    dof: NDArray[Any]
    a_hz: FloatArray
    b_hz: FloatArray
    std_hz: FloatArray
    z: FloatArray
    p: FloatArray
    changed: NDArray[np.bool_]
    chi_square: float
    freedom: int
    p_all: float
    alpha: float
    unmatched_a: Mapping[Any, FloatArray] = field(default_factory=dict)
    unmatched_b: Mapping[Any, FloatArray] = field(default_factory=dict)
    level_ratio: float = np.nan

    @property
    def difference_hz(self) -> FloatArray:
        """b less a, (n,)."""
        return self.b_hz - self.a_hz

    @property
    def difference_percent(self) -> FloatArray:
        """b less a in per cent of a, (n,)."""
        return 100.0 * self.difference_hz / self.a_hz

    @property
    def std_percent(self) -> FloatArray:
        """Standard deviation of the difference in per cent of a, (n,)."""
        return 100.0 * self.std_hz / self.a_hz

    @property
    def different(self) -> bool:
        """Whether the test of all says that the sets differ."""
        return bool(self.p_all < self.alpha)

    def __len__(self) -> int:
        return int(self.a_hz.size)

    def __repr__(self) -> str:
        alone = sum(map(len, self.unmatched_a.values())), sum(map(len, self.unmatched_b.values()))
        return f"Comparison({len(self)} pairs, {alone[0]} + {alone[1]} without a partner, p {self.p_all:.2g})"

    def __str__(self) -> str:
        columns = (self.dof, self.a_hz, self.b_hz, self.difference_percent, self.std_percent, self.z, self.p)
        rows = [
            [str(dof), number(a, 3), number(b, 3), number(change, 3, sign=True), number(std, 3)]
            + [number(z, 1, sign=True), "-" if np.isnan(p) else f"{p:.2g}", "changed" if changed else ""]
            for dof, a, b, change, std, z, p, changed in zip(*columns, self.changed, strict=True)
        ]
        head = ["dof", "a_hz", "b_hz", "diff_%", "std_%", "z", "p", ""]
        lines = [f"antiresonances compared, {forces_at(self.excitation)}", *aligned(head, rows)]
        for name, alone in (("a", self.unmatched_a), ("b", self.unmatched_b)):
            listed = {dof: ", ".join(f"{f:.3f}" for f in values) for dof, values in alone.items()}
            lines += [f"only in {name}: dof {dof}, {values} Hz" for dof, values in listed.items()]
        if not self.freedom:
            return "\n".join([*lines, "not tested: no standard deviations; give std_between"])
        lines.append(
            f"chi-square {self.chi_square:.1f}, {self.freedom} degrees of freedom, p = {self.p_all:.2g}: "
            f"{'different' if self.different else 'no difference'} (false alarms {100 * self.alpha:g} %)"
        )
        if self.different and abs(np.log(self.level_ratio)) > np.log(OTHER_AMPLITUDE):
            lines.append(
                f"b shook {self.level_ratio:.2g} times as strongly as a: stiffness that depends on amplitude "
                "(joints, concrete, soil) moves antiresonances without damage; compare tests of like strength"
            )
        return "\n".join(lines)

    def to_dataframe(self) -> Any:
        """One row a pair; needs pandas."""
        return self._view("to_dataframe")(self)

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` over the pairs, the test of all in its attributes; needs xarray."""
        return self._view("to_xarray")(self)

    def plot(self, ax: Any = None) -> Any:
        """Draw the differences with their errors; see :func:`~antires_rs.figures.plot_comparison`."""
        return self._view("plot")(self, ax=ax)


def _level(one: AntiresonanceSet) -> float:
    """How strongly the structure shook; NaN where that is not known, or not at all."""
    return float(one.options.get("response_level") or np.nan)


def compare(
    a: AntiresonanceSet | SeriesOfTests,
    b: AntiresonanceSet | SeriesOfTests,
    *,
    alpha: float = 0.01,
    max_shift: float = MAX_SHIFT,
    std_between: float = 0.0,
    std_common: float = 0.0,
) -> Comparison:
    """Match two sets of one structure, and test whether they differ.

    Parameters
    ----------
    a, b : AntiresonanceSet or Series
        Of the same excitation; the dofs that both have are compared. Of a series its average.
    alpha : float
        Rate of false alarms, 0 to 1: of the test of all, and of all single values together.
    max_shift : float
        Largest relative difference of two values that are taken for one, up to 0.5, see
        :mod:`antires_rs.measured.matching`. Values that were followed (``near=``) from one value are one.
    std_between, std_common : float
        Relative standard deviation from test to test of an unchanged structure (mounting, sensors): of each
        value by itself, and of what moves all alike (temperature). Repeats tell both, as
        ``track([...]).std_between`` and ``.std_common``; without them every change counts.

    Returns
    -------
    Comparison

    Raises
    ------
    InvalidInputError
        Other excitations, no common dof, or a malformed argument.

    Examples
    --------
    >>> import antires_rs as ar
    >>> before = ar.AntiresonanceSet(0, {0: [8.70, 23.90], 1: [14.40]}, std_hz={0: [0.01, 0.02], 1: [0.01]})
    >>> after = ar.AntiresonanceSet(0, {0: [8.71, 23.50, 31.00], 1: []}, std_hz={0: [0.01, 0.02, 0.1]})
    >>> print(ar.compare(before, after))
    antiresonances compared, force at 0
    dof    a_hz    b_hz  diff_%  std_%      z        p
      0   8.700   8.710  +0.115  0.163   +0.7     0.49
      0  23.900  23.500  -1.674  0.118  -14.1  4.4e-10  changed
    only in a: dof 1, 14.400 Hz
    only in b: dof 0, 31.000 Hz
    chi-square 39.4, 2 degrees of freedom, p = 2.8e-09: different (false alarms 1 %)
    """
    shift, rate = within("max_shift", max_shift), within("alpha", alpha)
    between, common_std = within("std_between", std_between), within("std_common", std_common)
    a, b = (each.average(max_shift=shift) if isinstance(each, SeriesOfTests) else each for each in (a, b))
    check_set("a", a)
    check_set("b", b)
    if a.excitation != b.excitation:
        got, wanted = f"a set of force at {b.excitation!r}", f"that of a, {a.excitation!r}"
        reject("b", got, wanted, "Compare like tests.")
    common = [dof for dof in a if dof in b]
    if not common:
        reject("b", f"dofs {tuple(b)}", f"some of {tuple(a)}", "Compare sets of the same responses.")
    if len({*a, *b}) > len(common):
        counts = f"{len(b)} responses, a {len(a)}, of which {len(common)} are compared: {some(common, 6)}"
        warn("other_channels", f"b: measured at other channels than a: {counts}.")
    dofs: list[Any] = []
    rows: list[tuple[float, float, float, float]] = []
    alone: tuple[dict[Any, FloatArray], dict[Any, FloatArray]] = ({}, {})
    for dof in common:
        one, other = a.tables[dof], b.tables[dof]
        variance = variance_hz(one, between)[:, None] + variance_hz(other, between)
        alike = 2.0 * (common_std * one.freq_hz[:, None]) ** 2
        pairs = matching.matched(one, other, shift, variance + alike)
        averages = np.minimum(matching.averages_of(one)[:, None], matching.averages_of(other))
        dofs += [dof] * len(pairs)
        rows += [(one.freq_hz[i], other.freq_hz[k], variance[i, k], averages[i, k]) for i, k in pairs]
        for side, table, used in ((0, one, [i for i, _ in pairs]), (1, other, [k for _, k in pairs])):
            rest = np.delete(table.freq_hz, used)
            if rest.size:
                alone[side][dof] = frozen(rest)
    a_hz, b_hz, variances, averages = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    # A deviation of zero says that the value is exact: as good as not known.
    own, difference = np.sqrt(np.where(variances > 0.0, variances, np.nan)), b_hz - a_hz
    alike = np.sqrt(2.0) * common_std * a_hz
    std = np.hypot(own, alike)
    p = matching.of_each(difference, std, averages)
    shared = matching.common_part(difference / own, alike / own)
    total, freedom, p_all = matching.of_all(
        matching.of_each(difference - alike * shared, own, averages), shared
    )
    columns: Any = map(frozen, (a_hz, b_hz, std, difference / std, p, matching.holm(p, rate)))
    rests: Any = total, freedom, p_all, rate, *map(FrozenDict, alone), _level(b) / _level(a)
    return Comparison(a.excitation, label_array(dofs), *columns, *rests)
