"""What a frame carries beside its beams: lumped masses, springs and supports."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..support.validation import FloatArray, finite_scalar, integer, part, reject, shape_of

if TYPE_CHECKING:
    from .parameter import Parameter

__all__ = ["GroundSpring", "NodeSpring", "PointMass"]


@dataclass(frozen=True)
class PointMass:
    """A lumped mass at a node.

    Attributes
    ----------
    node : int
    mass_kg : float
    inertia_kg_m2 : float or (float, float, float)
        Rotational inertia; in space the same about x, y, z, or three values.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.PointMass(3, 1.2, 0.004)
    PointMass(node=3, mass_kg=1.2, inertia_kg_m2=0.004)
    """

    node: int
    mass_kg: float
    inertia_kg_m2: float | Sequence[float] = 0.0


@dataclass(frozen=True)
class GroundSpring:
    """A spring from one dof of a node to ground.

    Attributes
    ----------
    node : int
    direction : str
        ``'u', 'v', 'theta'`` in the plane, ``'u', 'v', 'w', 'rx', 'ry', 'rz'`` in space.
    stiffness_n_per_m : float
        N/m, or N m/rad for a rotation.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.GroundSpring(0, "v", 2e3).direction
    'v'
    """

    node: int
    direction: str
    stiffness_n_per_m: float


@dataclass(frozen=True)
class NodeSpring:
    """A spring between two nodes.

    Attributes
    ----------
    node, other : int
    stiffness_n_per_m : float
        N/m, or N m/rad for a rotation.
    direction : str, optional
        The dof whose relative motion it resists, for a joint between nodes at the same place. Default: along
        the line between the nodes, which leaves rigid motions free.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.NodeSpring(4, 5, 1e4, "theta")   # a flexible joint
    NodeSpring(node=4, other=5, stiffness_n_per_m=10000.0, direction='theta')
    """

    node: int
    other: int
    stiffness_n_per_m: float
    direction: str | None = None


def iterable(name: str, value: Any, wanted: str) -> Iterable[Any]:
    """Anything that can be gone through, but text."""
    if not isinstance(value, Iterable) or isinstance(value, str):
        reject(name, value, wanted, "Put a single one in a list.")
    return value


def point_masses_of(items: Iterable[Any]) -> tuple[PointMass, ...]:
    """Point masses as given, checked, each with three inertias."""
    return tuple(
        PointMass(
            _node("point_masses", i, m.node),
            _number("point_masses", i, "mass_kg", m.mass_kg),
            _inertia(i, m.inertia_kg_m2),
        )
        for i, m in enumerate(_items("point_masses", items, PointMass))
    )


def ground_springs_of(items: Iterable[Any]) -> tuple[GroundSpring, ...]:
    """Springs to ground as given, checked."""
    return tuple(
        GroundSpring(
            _node("ground_springs", i, s.node),
            text("ground_springs", i, s.direction),
            _number("ground_springs", i, "stiffness_n_per_m", s.stiffness_n_per_m),
        )
        for i, s in enumerate(_items("ground_springs", items, GroundSpring))
    )


def node_springs_of(items: Iterable[Any]) -> tuple[NodeSpring, ...]:
    """Springs between nodes as given, checked."""
    return tuple(
        NodeSpring(
            _node("node_springs", i, s.node),
            _node("node_springs", i, s.other),
            _number("node_springs", i, "stiffness_n_per_m", s.stiffness_n_per_m),
            None if s.direction is None else text("node_springs", i, s.direction),
        )
        for i, s in enumerate(_items("node_springs", items, NodeSpring))
    )


def scaled_node_springs(
    springs: Iterable[NodeSpring], first: int, parameters: Iterable[Parameter], values: FloatArray
) -> list[NodeSpring]:
    """Springs with the parameters applied that act on their terms, ``first`` and on."""
    springs = list(springs)
    for parameter, value in zip(parameters, values, strict=True):
        if parameter.quantity in ("stiffness_reduction", "stiffness_factor"):
            factor = float(1.0 - value if parameter.quantity == "stiffness_reduction" else value)
            for term in parameter.terms:
                if term >= first:
                    old = springs[term - first]
                    springs[term - first] = replace(old, stiffness_n_per_m=old.stiffness_n_per_m * factor)
    return springs


def fixed_dofs(fixed: Iterable[Any], in_space: bool) -> list[tuple[int, str]]:
    """Fixed dofs as (node, direction), each once."""
    directions: tuple[Any, ...] = ("u", "v", "w", "rx", "ry", "rz") if in_space else ("u", "v", "theta")
    found: dict[tuple[int, str], None] = {}
    for i, item in enumerate(iterable("fixed", fixed, "nodes, or (node, direction)")):
        if shape_of(item) == () and not isinstance(item, str):
            node, held = item, directions
        elif isinstance(item, Sequence) and not isinstance(item, str) and len(item) == 2:
            node = item[0]
            held = (item[1],) if isinstance(item[1], str) or shape_of(item[1]) == () else tuple(item[1])
        else:
            reject(
                part("fixed", i),
                item,
                "a node, (node, direction) or (node, directions)",
                "Write it as 0, (0, 'v') or (0, ('u', 'v')).",
            )
        for direction in held:
            found[integer(part("fixed", i), node, low=0), text("fixed", i, direction)] = None
    return list(found)


def _items(name: str, items: Any, kind: type) -> list[Any]:
    """Items of a kind, or tuples of its fields."""
    found = []
    for i, item in enumerate(iterable(name, items, f"a sequence of {kind.__name__}")):
        try:
            found.append(item if isinstance(item, kind) else kind(*item))
        except TypeError:
            reject(part(name, i), item, f"a {kind.__name__}", f"Make it by antires_rs.{kind.__name__}(...).")
    return found


def _node(name: str, i: int, node: Any) -> int:
    return integer(part(name, i).attribute("node"), node, low=0)


def _number(name: str, i: int, attribute: str, value: Any) -> float:
    return finite_scalar(part(name, i).attribute(attribute), value, low=0.0)


def text(name: str, i: int | None, value: Any) -> str:
    """The name of a direction."""
    if not isinstance(value, str):
        reject(
            name if i is None else part(name, i),
            value,
            "a direction by its name, such as 'v'",
            "Translations are u, v, w; rotations theta in a plane, else theta_x, theta_y, theta_z.",
        )
    return value


def _inertia(i: int, value: Any) -> tuple[float, float, float]:
    if shape_of(value) not in ((), (3,)):
        reject(
            part("point_masses", i).attribute("inertia_kg_m2"),
            value,
            "one inertia, or three about x, y and z",
            "Give it in kg m^2, about the centre of mass.",
        )
    x, y, z = (_number("point_masses", i, "inertia_kg_m2", v) for v in three_inertias(value))
    return x, y, z


def three_inertias(value: Any) -> tuple[float, float, float]:
    """Inertias about x, y and z of one for all, or of three."""
    x, y, z = (value,) * 3 if shape_of(value) == () else value
    return x, y, z
