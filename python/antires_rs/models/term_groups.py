"""Groups of elements whose terms a model of matrices has, by name, and the mesh they belong to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..exceptions import reject
from ..support.checks import FloatArray, IntArray, finite_scalar
from ..support.values import Value

#: Number of a term and the power of the group's value that it goes with, each.
Powers = tuple[tuple[int, int], ...]
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

    def place(self, node: int) -> FloatArray:
        """Where a node is, (3,)."""
        found = np.flatnonzero(self.nodes == node)
        if not found.size:
            reject("node", node, f"a node of the mesh, which has {self.nodes.size}", "Look at mesh.nodes.")
        place: FloatArray = self.coordinates[found[0]]
        return place


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


def factors_of(
    groups: Mapping[str, TermGroup], stiffness: Mapping[int, float], mass: Mapping[int, float]
) -> dict[str, float]:
    """Factors on the values of groups, of those on their terms: the way back of :func:`powers_of`."""
    found = {}
    for name, group in groups.items():
        sides = (stiffness, group.stiffness_powers), (mass, group.mass_powers)
        acting = [(factors.get(term, 1.0), power) for factors, powers in sides for term, power in powers]
        roots = [factor ** (1.0 / power) if factor > 0.0 else 0.0 for factor, power in acting]
        if not min(roots) > 0.0 or max(roots) > (1.0 + 1e-9) * min(roots):
            got = f"terms of {name!r} times {', '.join(f'{factor:g}' for factor, _ in acting)}"
            wanted = "factors that one value, above 0, gives to stiffness and mass"
            reject("model", got, wanted, "Scale it by with_group_factors, or stiffness and mass alike.")
        found[name] = roots[0]
    return found
