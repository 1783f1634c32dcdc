"""Errors of the exhaust's model that no updating parameter can follow."""

from __future__ import annotations

from dataclasses import dataclass

from ...models.frame_parts import GroundSpring, PointMass
from ...support.validation import finite_scalar
from . import geometry

__all__ = ["EXTRA_CORDS", "Unfollowed"]

#: Nodes and stiffness (N/m, across) of cords that the model does not know: of a cable, a hose and a strap.
EXTRA_CORDS, CORD_N_PER_M = (10, 26, 43), 1500.0


@dataclass(frozen=True)
class Unfollowed:
    """How far the tested structure is from anything that the model could become.

    Attributes
    ----------
    wall_scatter : float
        Standard deviation of the wall thickness from one element's pipe to the next, relative; a fixed draw.
    joint_m : float
        Flexibility of the joints where the pipe enters catalyst, mufflers and flange: each turns as so many
        metres of pipe would more.
    shear_coefficient : 'cowper', float or None
        Tubes as Timoshenko beams with this coefficient; the model's are Euler-Bernoulli beams.
    cord_kg : float
        Mass that each of three cords adds that the model does not have, with 1500 N/m across; 0: no cords.

    Examples
    --------
    >>> from antires_rs.cases.exhaust.unfollowed import Unfollowed
    >>> Unfollowed(joint_m=0.02).wall_scatter
    0.005
    """

    wall_scatter: float = 0.005
    joint_m: float = 0.0
    shear_coefficient: float | str | None = None
    cord_kg: float = 0.0

    def __post_init__(self) -> None:
        finite_scalar("wall_scatter", self.wall_scatter, low=0.0, high=0.1)
        finite_scalar("joint_m", self.joint_m, low=0.0, high=0.2, unit="m")
        finite_scalar("cord_kg", self.cord_kg, low=0.0, high=1.0, unit="kg")

    @property
    def masses(self) -> list[PointMass]:
        """What the added cords weigh."""
        return [PointMass(node, self.cord_kg) for node in EXTRA_CORDS] if self.cord_kg else []

    @property
    def springs(self) -> list[GroundSpring]:
        """The added cords."""
        return [GroundSpring(node, "v", CORD_N_PER_M) for node in EXTRA_CORDS] if self.cord_kg else []

    def joined(self, second: int) -> bool:
        """Whether an element that ends at this node ends in a flexible joint."""
        return self.joint_m > 0.0 and second in {node for _, node, *_ in geometry.MASSES}
