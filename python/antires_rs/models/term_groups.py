"""Groups of elements whose terms a model of matrices has, by name, and the mesh they belong to."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import InvalidInputError, reject
from ..support.checks import FloatArray, IntArray, choice, finite_scalar, integer, real_array, shape_of
from ..support.values import Value
from .parameters import OF_SECTIONS, AppliedParameters, CoreParameter, Parameter

#: Number of a term and the power of the group's value that it goes with, each.
Powers = tuple[tuple[int, int], ...]
QUANTITIES = ("youngs_modulus", "density", "thickness", "stiffness", "value")
NO_ELEMENTS = np.empty(0, dtype=np.intp)


@dataclass(frozen=True, eq=False)
class TermGroup(Value):
    """What may be scaled in a model that :func:`read_model` has made.

    Attributes
    ----------
    name, quantity : str
        ``quantity`` is ``"youngs_modulus"``, ``"density"``, ``"thickness"``, ``"stiffness"`` (of whole
        elements) or ``"value"`` (a number that the input of the code holds).
    value : float or None
        Of the model as it was read, in the unit of the code; None where it has several.
    stiffness_powers, mass_powers : tuple of (int, int)
        Number of each term, and the power of the value that it goes with.
    elements : ndarray of int
        Numbers of the elements in the code; empty where it does not tell.
    place : str
        Argument of the script or function that has the value, where the group is one.

    Raises
    ------
    InvalidInputError
        Another quantity, or terms that are no numbers from 0, or given twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> web = ar.TermGroup("web", "youngs_modulus", 2.1e11, ((0, 1),))
    >>> web.linear, ar.TermGroup("skin", "thickness", 2e-3, ((1, 1), (2, 3))).linear
    (True, False)
    """

    name: str
    quantity: str
    value: float | None
    stiffness_powers: Powers = ()
    mass_powers: Powers = ()
    elements: IntArray = field(default_factory=lambda: NO_ELEMENTS, repr=False)
    place: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            reject("name", self.name, "a text", "As in ar.TermGroup('web', ...).")
        choice("quantity", self.quantity, QUANTITIES)
        if self.value is not None:
            finite_scalar("value", self.value)
        for side in ("stiffness_powers", "mass_powers"):
            wanted = "pairs of a term's number and a power, each term once"
            pairs = getattr(self, side)
            if any(shape_of(pair) != (2,) for pair in (pairs if isinstance(pairs, tuple | list) else [0])):
                reject(side, pairs, wanted, "As in stiffness_powers=((0, 1), (1, 3)).")
            terms = [integer((side, i), term, low=0) for i, (term, _) in enumerate(pairs)]
            for i, (_, power) in enumerate(pairs):
                if integer((side, i), power) == 0:
                    remedy = "Leave it out: what does not move with the value is no term of the group."
                    reject((side, i), "the power 0", "another power", remedy)
            if len({*terms}) < len(terms):
                reject(side, pairs, wanted, "Leave one of the two out: matrices are sums of their terms.")
        _numbers("elements", self.elements)
        super().__post_init__()

    @property
    def linear(self) -> bool:
        """Whether stiffness and mass are straight lines in the value."""
        return all(power == 1 for _, power in (*self.stiffness_powers, *self.mass_powers))


@dataclass(frozen=True, eq=False)
class Mesh(Value):
    """Nodes and elements as a finite-element code has them, for pictures and places.

    Attributes
    ----------
    nodes, coordinates : ndarray, (n,) of int and (n, 3)
        Numbers of the nodes, and where they are, in the unit of the code.
    elements, connectivity : ndarray of int, (e,) and (e, k)
        Numbers of the elements and of their nodes, -1 behind the last.
    kinds, kind : tuple of str, and ndarray of int, (e,)
        Types of elements as the code calls them, and which one each element has.

    Raises
    ------
    InvalidInputError
        Arrays that do not fit each other, a number given twice, a node that the mesh has not.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> ends = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    >>> ar.Mesh(np.array([1, 2]), ends, np.array([7]), np.array([[1, 2]]), ("B31",), np.array([0])).place(2)
    array([0.5, 0. , 0. ])
    """

    nodes: IntArray
    coordinates: FloatArray
    elements: IntArray
    connectivity: IntArray
    kinds: tuple[str, ...]
    kind: IntArray

    def __post_init__(self) -> None:
        for name in ("nodes", "coordinates", "elements", "connectivity", "kind"):
            object.__setattr__(self, name, _array(name, getattr(self, name)))
        nodes, elements = _numbers("nodes", self.nodes), _numbers("elements", self.elements)
        if nodes.size and nodes.min() < 0:
            reject("nodes", f"node {nodes.min()}", "numbers of at least 0", "-1 stands for no node.")
        if self.coordinates.shape != (nodes.size, 3):
            got = f"an array of shape {self.coordinates.shape}"
            reject(
                "coordinates", got, f"({nodes.size}, 3), a place for each node", "Add zeros for what lacks."
            )
        if nodes.size:
            real_array("coordinates", self.coordinates, ndim=2, wanted="finite places, (n, 3)")
        of = self.connectivity
        if of.ndim != 2 or len(of) != elements.size:
            wanted = f"({elements.size}, k), the nodes of each element"
            reject("connectivity", f"an array of shape {of.shape}", wanted, "Fill short rows up with -1.")
        used = of != -1
        unknown = of[used & ~np.isin(of, nodes)]
        if unknown.size:
            remedy = "Name nodes by their numbers, and nodes that are not there by -1."
            reject("connectivity", f"node {unknown[0]}", "nodes of the mesh", remedy)
        odd = np.flatnonzero(~used.any(axis=1) | (used[:, 1:] & ~used[:, :-1]).any(axis=1))
        if odd.size:
            got = f"{of[odd[0]].tolist()} of element {elements[odd[0]]}"
            reject("connectivity", got, "nodes, and -1 behind the last", "Move -1 to the end of the row.")
        kind, kinds = self.kind, self.kinds
        if (
            not isinstance(kinds, tuple)
            or kind.shape != elements.shape
            or not np.isin(kind, range(len(kinds))).all()
        ):
            got = f"{kind.ravel()[:6].tolist()} with kinds {kinds!r}"
            wanted = f"a place in the tuple kinds for each of {elements.size} elements"
            reject("kind", got, wanted, 'As in kinds=("S4",), kind=np.array([0]).')
        super().__post_init__()

    def place(self, node: int) -> FloatArray:
        """Where a node is, (3,)."""
        found = np.flatnonzero(self.nodes == node)
        if not found.size:
            reject("node", node, f"a node of the mesh, which has {self.nodes.size}", "Look at mesh.nodes.")
        place: FloatArray = self.coordinates[found[0]]
        return place


def _array(name: str, given: Any) -> NDArray[Any]:
    """An array of what may be a list."""
    try:
        return np.asarray(given)
    except ValueError as exc:
        raise InvalidInputError(name, "rows of different lengths", "an array", "Fill short rows up.") from exc


def _numbers(name: str, given: Any) -> IntArray:
    """Numbers of nodes or elements, (n,), each once."""
    numbers = _array(name, given)
    wanted = "whole numbers, (n,), each once"
    if numbers.ndim != 1 or (numbers.size and not np.issubdtype(numbers.dtype, np.integer)):
        got = f"an array of shape {numbers.shape} of {numbers.dtype}"
        reject(name, got, wanted, "Give them as integers, in one axis.")
    once, counts = np.unique(numbers, return_counts=True)
    if once.size < numbers.size:
        reject(name, f"{once[np.argmax(counts)]} twice", wanted, "Number them apart.")
    return numbers


def checked_groups(groups: Any, n_stiffness: int, n_mass: int) -> tuple[TermGroup, ...]:
    """Groups of different names whose terms a model of so many has, each term in one."""
    if isinstance(groups, str | bytes | Mapping) or not isinstance(groups, Iterable):
        reject("groups", groups, "a list of TermGroup", "Put the groups in a list.")
    given = tuple(groups)
    names: set[str] = set()
    owners: dict[tuple[str, int], str] = {}
    for i, group in enumerate(given):
        if not isinstance(group, TermGroup):
            remedy = 'As in ar.TermGroup("web", "youngs_modulus", 2.1e11, ((0, 1),)).'
            reject(("groups", i), type(group).__name__, "a TermGroup", remedy)
        if group.name in names:
            reject(
                ("groups", i), f"a second {group.name!r}", "groups of different names", "Rename one of them."
            )
        names.add(group.name)
        sides = ("stiffness", n_stiffness, group.stiffness_powers), ("mass", n_mass, group.mass_powers)
        for side, count, powers in sides:
            for term, _ in powers:
                if term >= count:
                    wanted = (
                        f"one of the {count} {side}_terms, counted from 0" if count else f"no {side} term"
                    )
                    remedy = f"Give {side}_terms= to the model, or correct the number."
                    reject(("groups", group.name), f"{side} term {term}", wanted, remedy)
                other = owners.setdefault((side, term), group.name)
                if other != group.name:
                    got = f"{side} term {term}, which {other!r} has too"
                    reject(("groups", group.name), got, "terms of its own", "Take the terms apart.")
    return given


def powers_of(groups: Mapping[str, TermGroup], factors: Any) -> tuple[dict[int, float], dict[int, float]]:
    """Factors on stiffness and on mass terms, of factors on the values of groups by name."""
    wanted = f"factors by group: {', '.join(map(repr, groups))}" if groups else "a model with groups"
    if not isinstance(factors, Mapping):
        reject("factors", factors, wanted, 'As in {"web": 0.9}.')
    stiffness: dict[int, float] = {}
    mass: dict[int, float] = {}
    for name, given in factors.items():
        if name not in groups:
            reject(("factors", name), "an unknown group", wanted, "Correct the name.")
        factor = finite_scalar(("factors", name), given, low=0.0, low_open=True)
        stiffness |= {term: factor**power for term, power in groups[name].stiffness_powers}
        mass |= {term: factor**power for term, power in groups[name].mass_powers}
    return stiffness, mass


Sides = tuple[dict[int, float], dict[int, float]]  # factors on stiffness and on mass terms


def applied_factors(groups: Mapping[str, TermGroup], applied: Iterable[AppliedParameters]) -> Sides:
    """What parameters have made of the terms, one after the other."""
    sides: Sides = {}, {}
    pairs = [zip(each.parameters, each.values.tolist(), strict=True) for each in applied]
    for one, value in chain.from_iterable(pairs):
        new: Sides = {}, {}
        if one.quantity in OF_SECTIONS:
            nominal = 1.0 if one.relative else value_now(groups[one.terms[0]], sides)
            new = powers_of(groups, dict.fromkeys(one.terms, value / nominal))
        else:
            scale = 1.0 - value if one.quantity == "stiffness_reduction" else value
            new[one.quantity == "mass_factor"].update(dict.fromkeys(one.terms, scale))
        for factors, scales in zip(sides, new, strict=True):
            factors |= {term: scale * factors.get(term, 1.0) for term, scale in scales.items()}
    return sides


def factor_of(group: TermGroup, sides: Sides) -> float:
    """Factor on the value of a group, of those on its terms: the way back of :func:`powers_of`."""
    both = zip(sides, (group.stiffness_powers, group.mass_powers), strict=True)
    acting = [(factors.get(term, 1.0), power) for factors, powers in both for term, power in powers]
    roots = [factor ** (1.0 / power) if factor > 0.0 else 0.0 for factor, power in acting] or [1.0]
    if not min(roots) > 0.0 or max(roots) > (1.0 + 1e-9) * min(roots):
        got = f"terms of {group.name!r} times {', '.join(f'{factor:g}' for factor, _ in acting)}"
        wanted = "factors that one value, above 0, gives to stiffness and mass"
        reject("model", got, wanted, "Scale it by with_group_factors, or stiffness and mass alike.")
    return roots[0]


def value_now(group: TermGroup, sides: Sides) -> float:
    """Of a group after what was applied; NaN where it had several."""
    return math.nan if group.value is None else group.value * factor_of(group, sides)


def in_groups(
    groups: Iterable[TermGroup], parameter: Parameter, applied: Iterable[AppliedParameters]
) -> CoreParameter:
    """A parameter of the value of groups as the core takes it, where some were applied before."""
    named = {group.name: group for group in groups}
    fit = [name for name, group in named.items() if group.quantity in (parameter.quantity, "value")]
    if unknown := [name for name in parameter.terms if name not in fit]:
        got = f"{parameter.quantity} of {unknown[0]!r}"
        wanted = f"one of {', '.join(map(repr, fit))}" if fit else "a model with groups of it"
        reject("parameters", got, wanted, "Groups are made by read_model, 'NAME:thickness' and the like.")
    own, nominal = [named[name] for name in parameter.terms], 1.0
    if not parameter.relative:
        sides = applied_factors(named, applied)
        values = [value_now(group, sides) for group in own]
        nominal = values[0]
        if not all(value > 0.0 and abs(value / nominal - 1.0) <= 1e-9 for value in values):
            each = (f"{value:g} of {group.name!r}" for value, group in zip(values, own, strict=True))
            remedy = "Take factors on it: relative=True."
            reject("parameters", f"{parameter.quantity} {', '.join(each)}", "one value, above 0", remedy)
    both = (((False, group.stiffness_powers), (True, group.mass_powers)) for group in own)
    acting = [(term, (mass, power)) for pair in both for mass, powers in pair for term, power in powers]
    return "group_value", [term for term, _ in acting], False, (nominal, [of for _, of in acting])
