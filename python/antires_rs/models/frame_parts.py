"""What a frame carries beside its beams: lumped masses, springs and supports."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from ..exceptions import Argument, part, reject
from ..support.checks import finite_scalar, integer, shape_of

#: An element as the core takes it: its nodes (of a beam also its section), its direction, its values.
Row = tuple[list[int], str | None, list[float]]


class _Spring:
    """A spring of one stiffness at the nodes that ``_nodes`` names."""

    _nodes: ClassVar[tuple[str, ...]] = ("node",)
    direction: str | None
    stiffness_n_per_m: float

    def _checked(self, name: str, i: int) -> Self:
        nodes, direction, (stiffness,) = self._row()
        nodes = [integer(part(name, i).attribute("node"), node, low=0) for node in nodes]
        if direction is not None or len(nodes) == 1:
            direction = text(name, i, direction)
        return self._of_row((nodes, direction, [_number(name, i, "stiffness_n_per_m", stiffness)]))

    def _row(self) -> Row:
        return [getattr(self, each) for each in self._nodes], self.direction, [self.stiffness_n_per_m]

    @classmethod
    def _of_row(cls, row: Row) -> Self:
        nodes, direction, (stiffness,) = row
        own = dict(zip(cls._nodes, nodes, strict=True), direction=direction, stiffness_n_per_m=stiffness)
        return cls(**own)

    @classmethod
    def _of_saved(cls, saved: Sequence[Any]) -> Self:
        """Of what files of 0.1 have."""
        *nodes, direction, value = saved
        return cls._of_row((nodes, direction, [value]))


@dataclass(frozen=True)
class PointMass:
    """A lumped mass at a node; in space its inertia is the same about x, y and z, or three values.

    Examples
    --------
    >>> import antires_rs as ar
    >>> flange = ar.PointMass(3, 1.2, 0.004)
    """

    node: int
    mass_kg: float
    inertia_kg_m2: float | Sequence[float] = 0.0
    _in_job = "[node, kg] or [node, kg, inertia in kg m2] of each."

    def _checked(self, name: str, i: int) -> Self:
        inertia, wanted = self.inertia_kg_m2, "one inertia, or three about x, y and z"
        if shape_of(inertia) not in ((), (3,)):
            argument = part(name, i).attribute("inertia_kg_m2")
            reject(argument, inertia, wanted, "Give it in kg m^2, about the centre of mass.")
        three: Any = (inertia,) * 3 if shape_of(inertia) == () else inertia
        node = integer(part(name, i).attribute("node"), self.node, low=0)
        mass = _number(name, i, "mass_kg", self.mass_kg)
        return type(self)(node, mass, tuple(_number(name, i, "inertia_kg_m2", each) for each in three))

    def _row(self) -> Row:
        return [self.node], None, [self.mass_kg, *self.inertia_kg_m2]  # type: ignore[misc]

    @classmethod
    def _of_row(cls, row: Row) -> Self:
        (node,), _, (mass, *inertia) = row
        return cls(node, mass, inertia[0] if len(set(inertia)) == 1 else tuple(inertia))

    @classmethod
    def _of_saved(cls, saved: Sequence[Any]) -> Self:
        node, mass, inertia = saved
        return cls(node, mass, tuple(inertia))


@dataclass(frozen=True)
class GroundSpring(_Spring):
    """A spring from one dof of a node to ground, in N/m, or in N m/rad for a rotation.

    Directions are ``'u', 'v', 'theta'`` in the plane, ``'u', 'v', 'w', 'rx', 'ry', 'rz'`` in space.

    Examples
    --------
    >>> import antires_rs as ar
    >>> cord = ar.GroundSpring(0, "v", 2e3)
    """

    node: int
    direction: str
    stiffness_n_per_m: float
    _in_job = '[node, "direction", N/m] of each: u, v, theta in the plane, u, v, w, rx, ry, rz in space.'


@dataclass(frozen=True)
class NodeSpring(_Spring):
    """A spring between two nodes, in N/m, or in N m/rad for a rotation.

    ``direction`` is the dof whose relative motion it resists, for a joint between nodes at the same place; by
    default along the line between the nodes, which leaves rigid motions free.

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

    _nodes: ClassVar[tuple[str, ...]] = ("node", "other")
    _in_job = '[node, node, N/m] or [node, node, N/m, "direction"] of each.'


#: Kinds of parts by the argument that lists them; each says what its key of a job holds.
PARTS: dict[str, type[PointMass | GroundSpring | NodeSpring]] = {
    "point_masses": PointMass,
    "ground_springs": GroundSpring,
    "node_springs": NodeSpring,
}


def iterable(name: str, value: Any, wanted: str) -> Iterable[Any]:
    """Anything that can be gone through, but text."""
    if not isinstance(value, Iterable) or isinstance(value, str):
        reject(name, value, wanted, "Put a single one in a list.")
    return value


def parts_of(name: str, items: Iterable[Any]) -> tuple[Any, ...]:
    """Parts of the kind that the argument ``name`` lists, or tuples of their fields, checked."""
    kind = PARTS[name]
    found = []
    for i, item in enumerate(iterable(name, items, f"a sequence of {kind.__name__}")):
        try:
            given = item if isinstance(item, kind) else kind(*item)
        except TypeError:
            reject(part(name, i), item, f"a {kind.__name__}", f"Make it by antires_rs.{kind.__name__}(...).")
        found.append(given._checked(name, i))
    return tuple(found)


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
            remedy = "Write it as 0, (0, 'v') or (0, ('u', 'v'))."
            reject(part("fixed", i), item, "a node, (node, direction) or (node, directions)", remedy)
        for direction in held:
            found[integer(part("fixed", i), node, low=0), text("fixed", i, direction)] = None
    return list(found)


def _number(name: str, i: int, attribute: str, value: Any) -> float:
    return finite_scalar(part(name, i).attribute(attribute), value, low=0.0)


def text(name: str, i: int | None, value: Any) -> str:
    """The name of a direction."""
    if not isinstance(value, str):
        remedy = "Translations are u, v, w; rotations theta in a plane, else rx, ry, rz."
        reject(name if i is None else part(name, i), value, "a direction by its name, such as 'v'", remedy)
    return value


# -- Cross-sections of beams, each of one material

#: (shape, dimensions, E, density, Poisson's ratio), as the core takes it.
SectionParts = tuple[str, list[float], float, float, float]

#: Young's moduli below this, or below so much for each kg/m3 of density, are taken for another unit: rubber
#: has 800 for each, what is in MPa 10 to 30, and mm, N and tonnes throughout 3e13.
SOFTEST_PA, SOFTEST_OF_DENSITY = 1e5, 500.0
#: Densities below this are taken for g/cm3, t/m3 or the mass of a metre: no solid but foam has so little.
LIGHTEST_KG_PER_M3 = 50.0


@dataclass(frozen=True)
class Tube:
    """A round tube; a wall of half the diameter makes it a rod.

    Attributes
    ----------
    outer_diameter_m, thickness_m : float
        Outer diameter and thickness of the wall.
    youngs_modulus_pa, density_kg_per_m3, poisson : float
        Material; Poisson's ratio is for torsion and shear.
    shear_coefficient : float, "cowper" or None
        Shear area over area, for Timoshenko beams, which have the rotary inertia of the section too; "cowper"
        takes it from shape and Poisson's ratio. Default: none, that is, Euler-Bernoulli beams.

    Examples
    --------
    >>> import antires_rs as ar
    >>> pipe = ar.Tube(0.038, 0.0015, 2.1e11, 7850.0)
    """

    outer_diameter_m: float
    thickness_m: float
    youngs_modulus_pa: float
    density_kg_per_m3: float
    poisson: float = 0.3
    shear_coefficient: float | str | None = field(default=None, kw_only=True)

    def _parts(self, name: str, in_space: bool) -> SectionParts:
        return _parts(self, name, "tube", "outer_diameter_m", "thickness_m")


@dataclass(frozen=True)
class Rectangle:
    """A solid rectangle; material and shear as of a :class:`Tube`.

    The height lies in the plane of a plane frame, or along the element's reference direction in space.

    Examples
    --------
    >>> import antires_rs as ar
    >>> bar = ar.Rectangle(0.03, 0.01, 7.0e10, 2700.0)
    """

    width_m: float
    height_m: float
    youngs_modulus_pa: float
    density_kg_per_m3: float
    poisson: float = 0.3
    shear_coefficient: float | str | None = field(default=None, kw_only=True)

    def _parts(self, name: str, in_space: bool) -> SectionParts:
        return _parts(self, name, "rectangle", "width_m", "height_m")


@dataclass(frozen=True)
class Section:
    """Any cross-section, by its constants.

    Attributes
    ----------
    area_m2, inertia_m4 : float
        Area, and second moment for bending in the plane of a plane frame; in space, in the plane of the
        element and its reference direction.
    youngs_modulus_pa, density_kg_per_m3, poisson
        As of a :class:`Tube`.
    inertia_y_m4, torsion_m4 : float, optional
        Second moment for bending across that plane (default: the same), and St. Venant torsion constant; used
        in space only, where ``torsion_m4`` must be given.
    shear_coefficient, shear_coefficient_y : float, optional
        As of a :class:`Tube`, for forces in the plane of ``inertia_m4``, and, in space, for those in the
        other plane (default: the same).

    Examples
    --------
    >>> import antires_rs as ar
    >>> profile = ar.Section(1e-4, 8.3e-10, 2.1e11, 7850.0)
    """

    area_m2: float
    inertia_m4: float
    youngs_modulus_pa: float
    density_kg_per_m3: float
    inertia_y_m4: float | None = field(default=None, kw_only=True)
    torsion_m4: float | None = field(default=None, kw_only=True)
    poisson: float = field(default=0.3, kw_only=True)
    shear_coefficient: float | None = field(default=None, kw_only=True)
    shear_coefficient_y: float | None = field(default=None, kw_only=True)

    def _parts(self, name: str, in_space: bool) -> SectionParts:
        if in_space and self.torsion_m4 is None:
            argument, wanted = Argument(name).attribute("torsion_m4"), "the torsion constant in m^4, in space"
            reject(argument, None, wanted, "Give the section its torsion_m4, or use a plane frame.")
        bending = self.inertia_m4
        across = bending if self.inertia_y_m4 is None else self.inertia_y_m4
        torsion = bending if self.torsion_m4 is None else self.torsion_m4
        whole = replace(self, inertia_y_m4=across, torsion_m4=torsion)
        return _parts(whole, name, "general", "area_m2", "inertia_y_m4", "inertia_m4", "torsion_m4")


AnySection = Tube | Rectangle | Section


def _parts(section: Any, name: str, kind: str, *sizes: str) -> SectionParts:
    names = *sizes, "youngs_modulus_pa", "density_kg_per_m3", "poisson"
    found = [finite_scalar(Argument(name).attribute(each), getattr(section, each)) for each in names]
    youngs, density, poisson = found[-3:]
    return kind, found[:-3], youngs, density, poisson


def shear_of(section: AnySection, name: str) -> list[float] | None:
    """As the core takes it: coefficients along y and z, an empty list for Cowper's, None for rigid."""
    given, across = section.shear_coefficient, getattr(section, "shear_coefficient_y", None)
    if given == "cowper" or (given is None and across is None):
        return [] if given else None
    argument = Argument(name).attribute("shear_coefficient")
    if given is None or isinstance(given, str):
        allowed = "a number" if isinstance(section, Section) else "a number, 'cowper' or None"
        reject(argument, given, allowed, "It is the shear area over the area, 5/6 for a rectangle.")
    own = finite_scalar(argument, given)
    other = Argument(name).attribute("shear_coefficient_y")
    return [own, own if across is None else finite_scalar(other, across)]


def section_of(parts: SectionParts, given: AnySection) -> AnySection:
    """The section that the core describes; ``given`` is the one it was made from, whose shear it keeps."""
    kind, size, *material = parts
    if not isinstance(given, Section):
        made = Tube if kind == "tube" else Rectangle
        return made(*size, *material, shear_coefficient=given.shear_coefficient)
    names = ("area_m2", "inertia_y_m4", "inertia_m4", "torsion_m4", "youngs_modulus_pa", "density_kg_per_m3")
    return replace(given, **dict(zip(names, (*size, *material), strict=False)))
