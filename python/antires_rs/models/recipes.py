"""What models are made of: one frozen value a kind, as the constructor of that kind found it valid."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._core import Frame as CoreFrame, Model as CoreModel
from ..exceptions import part, reject
from ..support.checks import FloatArray, integer
from ..support.values import Value
from .constraints import Dependent, Equation, congruent, equations_of, multipliers, solved, without
from .frame_parts import AnySection, shear_of
from .matrices import Entries
from .term_groups import Mesh, TermGroup


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

    def term_index(self, quantity: str, name: str) -> int:
        """Number of a stiffness or mass term by its name; only models of matrices have named terms."""
        side = "mass" if quantity == "mass_factor" else "stiffness"
        names: tuple[str, ...] = getattr(self, f"{side}_names", ())
        if name in names:
            return names.index(name)
        wanted = f"one of {', '.join(map(repr, names))}" if names else "a number: its terms have no names"
        if name in (group.name for group in getattr(self, "groups", ())):
            remedy = "It is no straight line in its value, or has none of this side: see with_group_factors."
        else:
            remedy = "Correct the name." if names else "Count the terms from 0."
        reject("parameters", f"the {side} term {name!r}", wanted, remedy)


@dataclass(frozen=True, eq=False)
class ChainRecipe(_Recipe):
    """A chain of masses (n,) and springs (n - 1,); those to ground are 0 where that end is free."""

    masses_kg: FloatArray
    springs_n_per_m: FloatArray
    ground_first_n_per_m: float
    ground_last_n_per_m: float

    def core(self) -> CoreModel:
        """The chain, made anew."""
        ends = self.ground_first_n_per_m, self.ground_last_n_per_m
        return CoreModel.chain(self.masses_kg, self.springs_n_per_m, *ends)


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
    stiffness_names: tuple[str, ...] = ()  # of the terms
    mass_names: tuple[str, ...] = ()
    groups: tuple[TermGroup, ...] = ()
    mesh: Mesh | None = None

    def independent(self, keep: Iterable[int] = ()) -> Independent:
        """Matrices and terms without what is no dof of its own; ``keep`` are further dofs to be kept."""
        n, given = self.n_dof, []
        left, of_multipliers = self._without_multipliers()
        if self.constraints is not None:
            given = equations_of(self.constraints.sparse(int(self.constraints.rows.max()) + 1, n), n)
        gone = solved([*given, *of_multipliers.values()], {*self.keep, *keep})
        dependent = Dependent.of(gone, of_multipliers)
        rows = dependent.rows(n)
        if gone:
            t = Dependent.of(gone).transformation(n)
            left = left._each(lambda own: Entries.of_sparse(congruent(own.sparse(n), t)))
        if dependent.dofs.size:
            left = replace(left._each(lambda own: without(own, rows)), n_dof=int(rows.max()) + 1)
        return Independent(left, dependent, rows)

    def _each(self, change: Callable[[Entries], Entries]) -> MatrixRecipe:
        """All matrices changed."""
        terms = [tuple(map(change, each)) for each in (self.stiffness_terms, self.mass_terms)]
        own = change(self.stiffness), change(self.mass)
        return replace(self, stiffness=own[0], mass=own[1], stiffness_terms=terms[0], mass_terms=terms[1])

    def _without_multipliers(self) -> tuple[MatrixRecipe, dict[int, Equation]]:
        """The matrices without the rows of Lagrange multipliers, and the equations that these are."""
        k = self.stiffness
        multiplier = multipliers(self.n_dof, k, self.mass)
        if not multiplier.any():
            return self, {}
        for name in ("stiffness_terms", "mass_terms"):
            for i, term in enumerate(getattr(self, name)):
                touched = term.rows[multiplier[term.rows]]
                if touched.size:
                    got = f"an entry in row {int(touched[0])}, which is a Lagrange multiplier"
                    wanted = "terms of the structure: an equation has no stiffness that could be scaled"
                    reject(part(name, i), got, wanted, "Leave the rows of the equations out of the term.")
        equations: dict[int, Equation] = {int(row): {} for row in np.flatnonzero(multiplier)}
        for row, column, value in zip(*(each.tolist() for each in k.those(multiplier[k.rows])), strict=True):
            equations[row][column] = value
        return replace(self, stiffness=k.those(~(multiplier[k.rows] | multiplier[k.columns]))), equations

    def core(self) -> CoreModel:
        """The matrices and terms, handed over anew."""
        return self.independent().core()


class Independent(NamedTuple):
    """Matrices without rows that hold nothing, what was taken out, and the row of each dof (n,) or -1."""

    matrices: MatrixRecipe
    dependent: Dependent
    rows: NDArray[np.intp]

    def core(self) -> CoreModel:
        """The core's model."""
        own = self.matrices
        terms = own.stiffness_terms, own.mass_terms
        return CoreModel.from_matrices(own.n_dof, own.stiffness, own.mass, *terms)


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
        if name in names:
            return names.index(name)
        if not isinstance(name, str) and integer("sections", name, low=0) < len(names):
            return name
        wanted = f"a section of the model: {', '.join(map(repr, names))}"
        remedy = "Correct the name."
        if not isinstance(name, str):
            remedy = (
                f"{len(self.beams)} elements share these, equal sections being one: element_sections tells "
            )
            remedy += "which. For single elements use stiffness_factor."
        reject("sections", repr(name), wanted, remedy)

    def core(self) -> CoreModel:
        """The frame, assembled anew."""
        names = [part("sections", name) for name in self.section_names]
        sections = [own._parts(name, self.in_space) for own, name in zip(self.sections, names, strict=True)]
        shear = list(map(shear_of, self.sections, names))
        rows: list[Any] = [("elements", [(list(beam), None, []) for beam in self.beams])]
        rows += [(kind, [each._row() for each in parts]) for kind, parts in self.parts.items()]
        how = [] if all(one is None for one in shear) else [shear]
        frame = CoreFrame(self.nodes_m, self.orientation, sections, rows, list(self.fixed), *how)
        return CoreModel.from_frame(frame)
