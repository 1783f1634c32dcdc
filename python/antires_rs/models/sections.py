"""Cross-sections of beams, each of one material."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from ..exceptions import Argument
from ..support.validation import finite_scalar, reject
from ..support.warned import warn

__all__ = ["AnySection", "Rectangle", "Section", "Tube", "section_of", "shear_of", "warn_soft"]

#: (shape, dimensions, E, density, Poisson's ratio), as the core takes it.
SectionParts = tuple[str, list[float], float, float, float]

#: Young's moduli below this are taken for another unit.
SOFTEST_PA = 1e5


@dataclass(frozen=True)
class Tube:
    """A round tube; a wall of half the diameter makes it a rod.

    Attributes
    ----------
    outer_diameter_m, thickness_m : float
        Outer diameter and thickness of the wall.
    youngs_modulus_pa, density_kg_per_m3 : float
        Material.
    poisson : float
        Poisson's ratio, for torsion and shear.
    shear_coefficient : float, "cowper" or None
        Shear area over area, for Timoshenko beams, which have the rotary inertia of the section too; "cowper"
        takes it from shape and Poisson's ratio. Default: none, that is, Euler-Bernoulli beams.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.Tube(0.038, 0.0015, 2.1e11, 7850.0).poisson
    0.3
    """

    outer_diameter_m: float
    thickness_m: float
    youngs_modulus_pa: float
    density_kg_per_m3: float
    poisson: float = 0.3
    shear_coefficient: float | str | None = field(default=None, kw_only=True)

    def _parts(self, name: str, in_space: bool) -> SectionParts:
        return _parts(self, name, "tube", ["outer_diameter_m", "thickness_m"])


@dataclass(frozen=True)
class Rectangle:
    """A solid rectangle.

    Attributes
    ----------
    width_m, height_m : float
        The height lies in the plane of a plane frame, or along the element's reference direction in space.
    youngs_modulus_pa, density_kg_per_m3 : float
        Material.
    poisson : float
        Poisson's ratio, for torsion and shear.
    shear_coefficient : float, "cowper" or None
        Shear area over area, for Timoshenko beams, which have the rotary inertia of the section too; "cowper"
        takes it from shape and Poisson's ratio. Default: none, that is, Euler-Bernoulli beams.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.Rectangle(0.03, 0.01, 7.0e10, 2700.0).height_m
    0.01
    """

    width_m: float
    height_m: float
    youngs_modulus_pa: float
    density_kg_per_m3: float
    poisson: float = 0.3
    shear_coefficient: float | str | None = field(default=None, kw_only=True)

    def _parts(self, name: str, in_space: bool) -> SectionParts:
        return _parts(self, name, "rectangle", ["width_m", "height_m"])


@dataclass(frozen=True)
class Section:
    """Any cross-section, by its constants.

    Attributes
    ----------
    area_m2 : float
        Area.
    inertia_m4 : float
        Second moment for bending in the plane of a plane frame; in space, in the plane of the element and
        its reference direction.
    youngs_modulus_pa, density_kg_per_m3 : float
        Material.
    inertia_y_m4, torsion_m4 : float, optional
        Second moment for bending across that plane (default: the same), and St. Venant torsion constant;
        used in space only, where ``torsion_m4`` must be given.
    poisson : float
        Poisson's ratio, for torsion and shear.
    shear_coefficient, shear_coefficient_y : float, optional
        Shear area over area for forces in the plane of ``inertia_m4``, and, in space, for those in the other
        plane (default: the same); for Timoshenko beams, which have the rotary inertia of the section too.
        Default: none, that is, Euler-Bernoulli beams.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.Section(1e-4, 8.3e-10, 2.1e11, 7850.0).area_m2
    0.0001
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
            reject(
                Argument(name).attribute("torsion_m4"),
                None,
                "the torsion constant in m^4, as the frame is in space",
                "Give the section its torsion_m4, or use a plane frame.",
            )
        across = self.inertia_m4 if self.inertia_y_m4 is None else self.inertia_y_m4
        torsion = self.inertia_m4 if self.torsion_m4 is None else self.torsion_m4
        kind, (area, inertia), youngs, density, poisson = _parts(
            self, name, "general", ["area_m2", "inertia_m4"]
        )
        size = [
            area,
            finite_scalar(Argument(name).attribute("inertia_y_m4"), across),
            inertia,
            finite_scalar(Argument(name).attribute("torsion_m4"), torsion),
        ]
        return kind, size, youngs, density, poisson


AnySection = Tube | Rectangle | Section


def warn_soft(name: str, section: AnySection) -> None:
    """A material softer than rubber is a slip of units."""
    if (
        0.0
        < finite_scalar(Argument(name).attribute("youngs_modulus_pa"), section.youngs_modulus_pa)
        < SOFTEST_PA
    ):
        warn(
            "softer_than_rubber",
            f"{name}.youngs_modulus_pa: {section.youngs_modulus_pa:g} Pa is softer than rubber. "
            "Steel has 2.1e11 Pa, and lengths are in metres.",
        )


def _parts(section: Any, name: str, kind: str, sizes: list[str]) -> SectionParts:
    def number(attribute: str) -> float:
        return finite_scalar(Argument(name).attribute(attribute), getattr(section, attribute))

    return (
        kind,
        [number(size) for size in sizes],
        number("youngs_modulus_pa"),
        number("density_kg_per_m3"),
        number("poisson"),
    )


def shear_of(section: AnySection, name: str) -> list[float] | None:
    """As the core takes it: coefficients along y and z, an empty list for Cowper's, None for rigid."""
    given = section.shear_coefficient
    across = getattr(section, "shear_coefficient_y", None)
    if given is None and across is None:
        return None
    if given == "cowper":
        return []
    argument = Argument(name).attribute("shear_coefficient")
    if given is None or isinstance(given, str):
        allowed = "a number" if isinstance(section, Section) else "a number, 'cowper' or None"
        reject(argument, given, allowed, "It is the shear area over the area, 5/6 for a rectangle.")
    own = finite_scalar(argument, given)
    if across is None:
        return [own, own]
    return [own, finite_scalar(Argument(name).attribute("shear_coefficient_y"), across)]


def section_of(parts: SectionParts, given: AnySection) -> AnySection:
    """The section that the core describes; ``given`` is the one it was made from, whose shear it keeps."""
    kind, size, *material = parts
    if not isinstance(given, Section):
        made = Tube if kind == "tube" else Rectangle
        return made(*size, *material, shear_coefficient=given.shear_coefficient)
    area, inertia_y, inertia_z, torsion = size
    return replace(
        given,
        area_m2=area,
        inertia_m4=inertia_z,
        youngs_modulus_pa=material[0],
        density_kg_per_m3=material[1],
        inertia_y_m4=inertia_y,
        torsion_m4=torsion,
    )
