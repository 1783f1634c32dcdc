r"""Where forces of unknown places acted: sets of places by how well a model explains what was measured.

Antiresonances of order r are identified without the places of the r forces, of which the model's roots, of
det(K - x M) with rows and columns deleted, depend strongly. A measured value is a root with the chance
:math:`p = 0.8` that a root is found, or a false one, of which there are :math:`q = 0.2` a response; a pair
differs by the value's standard deviation and the error of the model, :math:`s^2 = std^2 + (e f)^2`. So a set
of places has the log evidence, the sums over responses,

.. math:: \sum_{pairs} \left[\log p + \log N(f - f_A; s)\right] + n_{missing} \log(1 - p)
   + n_{unpaired} \log(q / B), \qquad B \text{ the band's width.}

Errors of the model are taken for independent: of two sets near each other the difference says too much.
A root that all responses share is not in transmissibilities, nor in ratios of minors. It is no missing one,
and places that differ by such roots alone, as those behind all sensors of a chain, have the same evidence.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb
from typing import Any

import numpy as np

from ..exceptions import Argument, reject
from ..measured.antiresonance_set import AntiresonanceSet, aligned, number
from ..measured.matching import check_set, paired
from ..models.structural_model import StructuralModel, checked_model
from ..support.checks import FloatArray, IntArray, finite_scalar, frequency_band, members, shape_of
from ..support.messages import warn
from ..support.progress import patient
from ..support.values import Value
from .targets import measured_together, roots_of, shared_by_all

FOUND, FALSE = 0.8, 0.2  # chance that a root is found; false values a response
SHARED = 5e-4  # relative distance in Hz up to which roots of two responses are one
REACH = 3.0  # errors of the model beyond which a value is no root's
_MOST_PLACES = 5_000  # of places that are tried
PRINTED = 10


@dataclass(frozen=True, eq=False)
class ForcePlaces(Value):
    """Sets of places of the forces, the likeliest first, from :func:`rank_force_places`.

    Attributes
    ----------
    places : tuple
        Dofs of the model, zero-based; tuples of r dofs where r forces act at once.
    log_evidence : ndarray, (n,)
        Natural logarithm, 0 for the first. Below -5 a set is unlikely, if ``model_error`` is right.
    explained, missing : ndarray of int, (n,)
        Measured values that are roots with the forces there; roots in the band that were not measured.
    rms_percent : ndarray, (n,)
        Root mean square difference of the explained values, in per cent; NaN if none is.
    n_values : int
        Values that were measured.
    dof_names : dict of int to str
        Names of the dofs in print.

    Examples
    --------
    >>> import antires_rs as ar
    >>> chain = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
    >>> seen = {dof: chain.antiresonances(dof, 2) for dof in range(3)}
    >>> print(ar.rank_force_places(chain, ar.AntiresonanceSet("somewhere", seen), band_hz=(1, 7)))
    places of the forces  log evidence  explained  missing  rms %
    mass 2                         0.0     2 of 2        0   0.00
    mass 1                       -11.4     0 of 2        1      -
    mass 0                       -13.0     0 of 2        2      -
    """

    places: tuple[Any, ...]
    log_evidence: FloatArray
    explained: IntArray
    missing: IntArray
    rms_percent: FloatArray
    n_values: int
    dof_names: Mapping[int, str]

    @property
    def best(self) -> Any:
        """The likeliest place, or set of places."""
        return self.places[0]

    def __str__(self) -> str:
        rows = [
            [
                ", ".join(self.dof_names[dof] for dof in members(self.places[i])),
                number(self.log_evidence[i], 1),
                f"{self.explained[i]} of {self.n_values}",
                str(self.missing[i]),
                number(self.rms_percent[i], 2),
            ]
            for i in range(min(PRINTED, len(self.places)))
        ]
        head = ["places of the forces", "log evidence", "explained", "missing", "rms %"]
        more = len(self.places) - len(rows)
        left = ("places of the forces",)
        return "\n".join([*aligned(head, rows, left), *([f"and {more} more"] if more else [])])


@patient("ranking places of the forces")
def rank_force_places(
    model: Any,
    measured: AntiresonanceSet,
    places: Iterable[Any] | None = None,
    *,
    band_hz: Sequence[float] | None = None,
    model_error: float = 0.02,
    progress: bool | None = None,
) -> ForcePlaces:
    """Rank the places where the forces may have acted by how well the model explains the antiresonances.

    For tests in which forces act at unknown places. Identification does not use the places, only their
    number: name r places of any kind, ``excitation=["first", "second"]``. Without a model the places cannot
    be known. See :mod:`antires_rs.updating.force_places`.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        Nominal, or better updated.
    measured : AntiresonanceSet
        Of order r; its responses are dofs of the model, its excitation is not looked at.
    places : iterable, optional
        Dofs where a force may act, by number or name: all sets of r of them are tried. Or these sets, tuples
        of r dofs. Default: the responses that were measured.
    band_hz : (low, high), optional
        Where roots count; by default the band of the identification.
    model_error : float
        Relative standard deviation of the model's frequencies, above 0 to 0.2.
    progress : bool, optional
        A line on standard error after a second; by default on a terminal and in a notebook.

    Returns
    -------
    ForcePlaces
        All sets, the likeliest first; those that the responses do not tell apart have the same evidence.
        Print it for a table.

    Raises
    ------
    InvalidInputError
        A response or place that the model does not have, too few places or too many sets of them, a set
        without values, or no band.

    Warns
    -----
    AntiresWarning
        If the data check of the set found something fatal, as forces of another number.

    Examples
    --------
    >>> import antires_rs as ar
    >>> chain = ar.cases.chain8().model
    >>> seen = {dof: chain.antiresonances(dof, 3, f_max_hz=100.0) for dof in range(8)}
    >>> somewhere = ar.AntiresonanceSet("somewhere", seen)
    >>> ar.rank_force_places(chain, somewhere, band_hz=(3, 100)).best
    3
    """
    model, measured = checked_model(model), check_set("measured", measured)
    band = _band(measured, band_hz)
    error = finite_scalar("model_error", model_error, low=0.0, high=0.2, low_open=True)
    keys = [*measured.tables]
    values = {key: measured[key][(measured[key] >= band[0]) & (measured[key] <= band[1])] for key in keys}
    n_values = sum(map(len, values.values()))
    if not n_values:
        got = f"no antiresonance from {band[0]:g} to {band[1]:g} Hz"
        reject("measured", got, "some that the model can explain", "Widen the band.")
    checked = measured.data_check.findings if measured.data_check else ()
    for finding in [one for one in checked if one.severity == "fatal"][:1]:
        told = "The data are unfit, and these values may be those of no place"
        warn(finding.name, f"{told}. {finding.text} {finding.advice}")
    silent = [tuple(own) for own in measured.options.get("silent", [])]
    order, rows = measured.order, [*keys, *silent]
    ends = [model._end("measured dof", key) for key in rows]
    sets = _sets(model, places, ends, order)
    by_ratio = measured.sees == "transmissibility"
    together = measured_together(model, measured) if by_ratio else []
    listed = list(dict.fromkeys([*ends, *together]))
    ranked = []
    for force in sets:
        found = dict(zip(listed, roots_of(model, listed, force, band[1], by_ratio), strict=True))
        tally = _Tally(band[1] - band[0], error)
        for key, end in zip(rows, ends, strict=True):
            root = np.empty(0) if found[end] is None else found[end]
            others = (found[own] for own in together if own != end)
            root = root[(root >= band[0]) & ~shared_by_all(root, others, SHARED)]
            std = measured.tables[key].std_hz if key in values else np.empty(0)
            inside = np.isin(measured[key], values[key]) if key in values else slice(None)
            tally.add(values.get(key, np.empty(0)), std[inside], root)
        ranked.append((force, tally))
    ranked.sort(key=lambda one: -round(one[1].evidence, 6))  # equal ones as they were given
    tallies = [tally for _, tally in ranked]
    dofs = {dof for force in sets for dof in members(force)}
    return ForcePlaces(
        tuple(force for force, _ in ranked),
        np.array([tally.evidence - tallies[0].evidence for tally in tallies]),
        np.array([len(tally.off) for tally in tallies]),
        np.array([tally.missing for tally in tallies]),
        np.array([100.0 * np.sqrt(np.mean(np.square(t.off))) if t.off else np.nan for t in tallies]),
        n_values,
        {dof: model.dof_label(dof) for dof in sorted(dofs)},
    )


class _Tally:
    """What one set of places explains."""

    def __init__(self, width_hz: float, error: float) -> None:
        self.evidence, self.missing = 0.0, 0
        self.off: list[float] = []
        self._false, self._error = float(np.log(FALSE / width_hz)), error

    def add(self, values: FloatArray, std_hz: FloatArray, roots: FloatArray) -> None:
        """The values of one response beside the roots of the model."""
        variance = np.nan_to_num(std_hz) ** 2
        pairs = paired(values, roots, REACH * self._error, variance[:, None])
        for i, k in pairs:
            total = variance[i] + (self._error * values[i]) ** 2
            self.evidence += float(np.log(FOUND) - 0.5 * np.log(2.0 * np.pi * total))
            self.evidence -= float(0.5 * (values[i] - roots[k]) ** 2 / total)
            self.off.append(float(values[i] / roots[k] - 1.0))
        missing = roots.size - len(pairs)
        self.missing += missing
        self.evidence += missing * float(np.log(1.0 - FOUND)) + (values.size - len(pairs)) * self._false


def _band(measured: AntiresonanceSet, band_hz: Any) -> tuple[float, float]:
    """Where roots count."""
    band = measured.options.get("band_hz") if band_hz is None else band_hz
    if band is None:
        remedy = "Give the band in which the values were looked for: band_hz=(low, high)."
        reject("band_hz", "None with a set made by hand", "(low, high) in Hz", remedy)
    return frequency_band("band_hz", band, low_hz=0.0, high_hz=np.inf)


def _sets(model: StructuralModel, places: Any, ends: Sequence[Any], order: int) -> list[Any]:
    """Sets of r dofs that are tried, a dof each of one force."""
    wanted = f"dofs, {order} or more, or sets of {order} of them"
    if places is None:
        given = list(dict.fromkeys(dof for end in ends for dof in members(end)))
    elif isinstance(places, str | bytes) or not isinstance(places, Iterable):
        reject("places", places, f"a list of {wanted}", "Put the dofs in a list, such as places=range(8).")
    else:
        given = list(places)
    if not given:
        reject("places", "none", wanted, "Name dofs where a force may have acted.")
    if any(shape_of(one) != () for one in given):
        sets = [one if shape_of(one) != () else (one,) for one in given]
    else:
        if len(given) < order or comb(len(given), order) > _MOST_PLACES:
            got = f"{_counted(len(given), 'place')} for {_counted(order, 'force')}"
            reject("places", got, f"{wanted}; at most {_MOST_PLACES} sets", "Give other places, or the sets.")
        sets = list(combinations(given, order))
    numbers: list[Any] = []
    for nth, own in enumerate(sets):
        dofs = members(model._end(Argument("places").item(nth), own))
        if len({*dofs}) != order:
            got = f"{_counted(len({*dofs}), 'dof')} for {_counted(order, 'force')}"
            needed = _counted(order, "distinct dof")
            reject(Argument("places").item(nth), got, needed, "Name one dof for each force.")
        numbers.append(tuple(dofs) if order > 1 else dofs[0])
    return list(dict.fromkeys(numbers))


def _counted(n: int, noun: str) -> str:
    return f"{n} {noun}{'s' * (n != 1)}"
