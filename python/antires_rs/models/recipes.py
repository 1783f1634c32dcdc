"""What models are made of: one frozen value a kind, as the constructor of that kind found it valid."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .. import _core
from ..exceptions import part, reject
from ..support.checks import FloatArray, integer
from ..support.values import Value
from .constraints import Independent, Matrices, independent_of
from .frame_parts import AnySection, shear_of
from .matrices import Entries

if TYPE_CHECKING:
    from .._core import Model as CoreModel


class _Recipe(Value):
    """What all kinds answer."""

    def core(self) -> CoreModel:
        """The core's model, made anew, bit-identical."""
        raise NotImplementedError

    def section_index(self, name: str | int) -> int:
        """Index of a section by its name; only frames have sections."""
        if isinstance(name, str):
            wanted = "zero-based terms, as the model is not a FrameModel"
            remedy = "Count the terms from 0, or build a FrameModel, which has named sections."
            reject("parameters", f"the section {name!r}", wanted, remedy)
        return name


@dataclass(frozen=True, eq=False)
class ChainRecipe(_Recipe):
    """A chain of masses (n,) and springs (n - 1,); those to ground are 0 where that end is free."""

    masses_kg: FloatArray
    springs_n_per_m: FloatArray
    ground_first_n_per_m: float
    ground_last_n_per_m: float

    def core(self) -> CoreModel:
        """The chain, made anew."""
        return _core.Model.chain(
            self.masses_kg, self.springs_n_per_m, self.ground_first_n_per_m, self.ground_last_n_per_m
        )


@dataclass(frozen=True, eq=False)
class MatrixRecipe(_Recipe):
    """Stiffness and mass, the terms that parameters may scale, and equations between the dofs, a row each."""

    n_dof: int
    stiffness: Entries
    mass: Entries
    stiffness_terms: tuple[Entries, ...] = ()
    mass_terms: tuple[Entries, ...] = ()
    names: tuple[str, ...] = ()  # of the dofs
    constraints: Entries | None = None
    keep: tuple[int, ...] = ()  # dofs that are not taken out

    def independent(self, keep: Iterable[int] = ()) -> Independent:
        """Matrices and terms without what is no dof of its own; ``keep`` are further dofs to be kept."""
        given = Matrices(self.n_dof, self.stiffness, self.mass, self.stiffness_terms, self.mass_terms)
        return independent_of(given, self.constraints, {*self.keep, *keep})

    def core(self) -> CoreModel:
        """The matrices and terms, handed over anew."""
        return self.independent().core()


@dataclass(frozen=True, eq=False)
class FrameRecipe(_Recipe):
    """Beams (first node, second node, section) with lumped masses, springs and supports."""

    nodes_m: FloatArray
    beams: tuple[tuple[int, int, int], ...]
    section_names: tuple[str | int, ...]
    sections: tuple[AnySection, ...]
    orientation: FloatArray | None = None
    parts: dict[str, tuple[Any, ...]] = field(default_factory=dict)  # by the argument that lists them
    fixed: tuple[tuple[int, str], ...] = ()

    @property
    def in_space(self) -> bool:
        """Whether the nodes have three coordinates."""
        return bool(self.nodes_m.shape[1] == 3)

    def section_index(self, name: str | int) -> int:
        """Index of a section by its name."""
        names = self.section_names
        if name not in names and isinstance(name, str):
            wanted = f"a section of the model: {', '.join(map(repr, names))}"
            reject("sections", repr(name), wanted, "Correct the name.")
        return names.index(name) if isinstance(name, str) else integer("sections", name, low=0)

    def core(self) -> CoreModel:
        """The frame, assembled anew."""
        named = list(zip(self.sections, map(section_argument, self.section_names), strict=True))
        sections = [section._parts(name, self.in_space) for section, name in named]
        shear = [shear_of(section, name) for section, name in named]
        frame = _core.Frame(
            self.nodes_m,
            self.orientation,
            sections,
            [
                ("elements", [(list(beam), None, []) for beam in self.beams]),
                *((kind, [each._row() for each in parts]) for kind, parts in self.parts.items()),
            ],
            list(self.fixed),
            *([] if all(one is None for one in shear) else [shear]),
        )
        return _core.Model.from_frame(frame)


def section_argument(name: str | int) -> str:
    """A section as messages call the argument."""
    return part("sections", name)
