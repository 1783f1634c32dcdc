"""Frames of beams in the plane or in space, with lumped masses, springs and supports."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import Frame as CoreFrame
from ..exceptions import part, reject
from ..support.checks import FloatArray, finite_scalar, integer, real_array
from ..support.directions import DofNames
from ..support.messages import warn
from ..views import Viewed
from . import frame_parts
from .frame_parts import AnySection, GroundSpring, NodeSpring, PointMass, iterable
from .penalties import warn_penalties
from .recipes import FrameRecipe
from .structural_model import ModelDescription, StructuralModel

# -- What the constructor of a frame was given, checked


def _sections_and_choice(
    sections: Any, rows: list[tuple[Any, ...]]
) -> tuple[tuple[str | int, ...], list[AnySection], list[int]]:
    """Names and values of the sections, and the index of each beam's."""
    wanted = "a Tube, Rectangle or Section, or a sequence or mapping of them"
    if isinstance(sections, AnySection):
        sections = [sections]
    named = isinstance(sections, Mapping)
    listed = list(sections.values() if named else iterable("sections", sections, wanted))
    names = tuple(sections) if named else tuple(range(len(listed)))
    for name, section in zip(names, listed, strict=True):
        if not isinstance(section, AnySection):
            reject(part("sections", name), section, wanted, "Make it by Tube, Rectangle or Section(...).")
        if named and not isinstance(name, str):
            reject("sections", f"the name {name!r}", "names that are text", "Put the name in quotes.")
    referring = [len(row) == 3 for row in rows]
    if not any(referring):
        if len(listed) == 1:
            return names, listed, [0] * len(rows)
        if named or len(listed) != len(rows):
            got = f"no section for any of {len(rows)} elements and {len(listed)} sections"
            wanted = "(node, node, section) for each element, or one section each"
            remedy = "Name one as the third item of each; another model has them in element_sections."
            reject("elements", got, wanted, remedy)
        # Equal sections are one, so that a parameter acts on all beams that have it.
        unique = list(dict.fromkeys(listed))
        return tuple(range(len(unique))), unique, [unique.index(section) for section in listed]
    if not all(referring):
        bare, wanted = part("elements", referring.index(False)), "a section for every element, or for none"
        reject(bare, "no section", wanted, "Name its section as the third item.")
    chosen = []
    for i, (*_, section) in enumerate(rows):
        element = part("elements", i)
        if named and section not in names:
            wanted, remedy = f"one of {', '.join(map(repr, names))}", "Correct the name, or add that section."
            reject(element, f"section {section!r}", wanted, remedy)
        index = names.index(section) if named else section
        chosen.append(integer(element, index, low=0, high=len(listed) - 1))
    return names, listed, chosen


def _orientation(orientation: Any, n: int, in_space: bool) -> FloatArray | None:
    if orientation is None:
        return None
    if not in_space:
        remedy = "Leave it out: all beams of a plane frame bend in its plane."
        reject("orientation", "a direction for a plane frame", "None", remedy)
    wanted = f"one direction (3,), or an array ({n}, 3) with one for each element"
    rows = np.atleast_2d(real_array("orientation", orientation, ndim=None, wanted=wanted))
    if rows.shape not in ((1, 3), (n, 3)):
        got = f"an array of shape {np.shape(orientation)}"
        reject("orientation", got, wanted, "Give one direction for all elements, or one for each.")
    return np.ascontiguousarray(np.broadcast_to(rows, (n, 3)))


class FrameModel(StructuralModel, Viewed):
    """Beams with consistent mass, in the plane (u, v, theta) or in space (six dofs a node).

    Euler-Bernoulli beams, or Timoshenko beams where a section has a shear coefficient.

    Parameters
    ----------
    nodes_m : array_like, (n_nodes, 2) or (n_nodes, 3)
        Coordinates; two columns make a plane frame.
    elements : sequence of (int, int) or (int, int, section)
        Nodes of each beam, and its section by name or index.
    sections : Tube, Rectangle or Section, or a sequence or mapping of them
        One for all beams; one each, in the order of the beams; or those that ``elements`` refer to.
    point_masses, ground_springs, node_springs : sequence of PointMass, of GroundSpring, of NodeSpring
    fixed : sequence of int or (int, str) or (int, sequence of str)
        Nodes with all dofs fixed, or single dofs. Fixed dofs are left out of the matrices.
    orientation : array_like, (3,) or (n_elements, 3), optional
        In space: reference direction, across the element, in which the height of its section points.
        Default: z, or x for elements along z.

    Raises
    ------
    InvalidInputError
        An element listed twice or without length, a node that nothing holds.

    Warns
    -----
    AntiresWarning
        The frame is in several parts that neither beams nor springs join.

    Notes
    -----
    Free dofs are numbered node by node; see :meth:`dof`. Elements are the beams, then the springs to ground,
    then those between nodes; mass terms are the beams, then the point masses. Beams: Przemieniecki, Theory
    of Matrix Structural Analysis (1968), with St. Venant torsion.

    Examples
    --------
    >>> import antires_rs as ar
    >>> rod = ar.Tube(0.02, 0.01, 2.1e11, 7850.0)
    >>> nodes = [(0.1 * i, 0.0) for i in range(11)]
    >>> beam = ar.FrameModel(nodes, [(i, i + 1) for i in range(10)], rod, fixed=[0])
    >>> beam.modes(1).freq_hz.round(3)   # 3.516 / (2 pi L**2) sqrt(EI / rho A)
    array([14.472])
    >>> beam.antiresonances(beam.dof(10, "v"), beam.dof(10, "v"), f_max_hz=300.0).round(1)
    array([ 63.5, 205.7])
    """

    _recipe_type = FrameRecipe
    _recipe: FrameRecipe

    def __init__(
        self,
        nodes_m: Any,
        elements: Iterable[Any],
        sections: AnySection | Sequence[AnySection] | Mapping[str, AnySection],
        *,
        point_masses: Iterable[Any] = (),
        ground_springs: Iterable[Any] = (),
        node_springs: Iterable[Any] = (),
        fixed: Iterable[Any] = (),
        orientation: Any = None,
    ) -> None:
        wanted = "an array (n_nodes, 2) or (n_nodes, 3) of coordinates in m"
        nodes = real_array("nodes_m", nodes_m, ndim=2, wanted=wanted)
        if nodes.shape[1] not in (2, 3):
            got, remedy = f"an array of shape {nodes.shape}", "Give each node its coordinates in a row."
            reject("nodes_m", got, wanted, remedy)
        pairs = "two nodes, or two nodes and a section, for each of one or more elements"
        given = enumerate(iterable("elements", elements, pairs))
        rows = [tuple(iterable(part("elements", i), row, pairs)) for i, row in given]
        if not rows:
            reject("elements", "none", pairs, "Write them as (0, 1) or (0, 1, 'pipe').")
        for i, row in enumerate(rows):
            if len(row) not in (2, 3):
                reject(part("elements", i), row, pairs, "Write it as (0, 1) or (0, 1, 'pipe').")
        names, listed, chosen = _sections_and_choice(sections, rows)
        ends = [[integer(part("elements", i), node, low=0) for node in row[:2]] for i, row in enumerate(rows)]
        parts = {"point_masses": point_masses, "ground_springs": ground_springs, "node_springs": node_springs}
        in_space = nodes.shape[1] == 3
        recipe = FrameRecipe(
            nodes_m=nodes,
            beams=tuple((a, b, section) for (a, b), section in zip(ends, chosen, strict=True)),
            section_names=names,
            sections=tuple(listed),
            fixed=tuple(frame_parts.fixed_dofs(fixed, in_space)),
            orientation=_orientation(orientation, len(rows), in_space),
            parts={kind: frame_parts.parts_of(kind, given) for kind, given in parts.items()},
        )
        for name, section in zip(recipe.section_names, recipe.sections, strict=True):
            argument, lean = map(part("sections", name).attribute, ("youngs_modulus_pa", "density_kg_per_m3"))
            modulus = finite_scalar(argument, section.youngs_modulus_pa)
            density = finite_scalar(lean, section.density_kg_per_m3)
            softest = max(frame_parts.SOFTEST_PA, frame_parts.SOFTEST_OF_DENSITY * density)
            if 0.0 < modulus < softest:  # a slip of units
                said = "is softer than rubber. Steel has 2.1e11 Pa, and lengths are in metres."
                warn("softer_than_rubber", f"{argument}: {modulus:g} Pa {said}")
            if 0.0 < density < frame_parts.LIGHTEST_KG_PER_M3:
                said = "is as light as foam. Steel has 7850 kg/m3: 1000 times g/cm3, or kg/m over the area."
                warn("lighter_than_foam", f"{lean}: {density:g} kg/m3 {said}")
        self._build(ModelDescription(recipe))
        remedy = "Use fixed= for rigid supports, and softer springs for ties."
        warn_penalties(self.dof_label, self.stiffness(), remedy)
        part_of = np.array(self._frame.parts())
        if part_of.max() > 0:
            alone = np.flatnonzero(part_of != part_of[0]).tolist()
            said = f"the frame is in {part_of.max() + 1} parts that nothing joins; apart from node 0 are "
            said += f"nodes {alone}. A response in one part to a force in another is zero."
            warn("frame_in_parts", said)

    @property
    def _frame(self) -> CoreFrame:
        frame = self._core.frame()
        assert frame is not None  # every core of this class comes from one
        return frame

    @property
    def nodes_m(self) -> FloatArray:
        """Coordinates of the nodes, (n_nodes, 2) or (n_nodes, 3)."""
        return self._frame.nodes_m()

    @property
    def elements(self) -> NDArray[np.intp]:
        """Nodes of each beam, (n_elements, 2)."""
        return np.array([beam[:2] for beam in self._recipe.beams], dtype=np.intp)

    @property
    def sections(self) -> dict[str | int, AnySection]:
        """Sections by name, or by index where they have none, with the values of this state."""
        recipe = self._recipe
        now = map(frame_parts.section_of, self._frame.sections(), recipe.sections)
        return dict(zip(recipe.section_names, now, strict=True))

    @property
    def element_sections(self) -> list[str | int]:
        """Name (or index) of each beam's section."""
        names = self._recipe.section_names
        return [names[section] for _, _, section in self._recipe.beams]

    @property
    def point_masses(self) -> list[PointMass]:
        """Lumped masses with the values of this state."""
        return self._parts("point_masses")

    @property
    def ground_springs(self) -> list[GroundSpring]:
        """Springs to ground with the values of this state."""
        return self._parts("ground_springs")

    @property
    def node_springs(self) -> list[NodeSpring]:
        """Springs between nodes with the values of this state."""
        return self._parts("node_springs")

    def _parts(self, name: str) -> list[Any]:
        return [frame_parts.PARTS[name]._of_row(row) for row in self._frame.elements(name)]

    @property
    def fixed(self) -> list[tuple[int, str]]:
        """Fixed dofs as (node, direction)."""
        return list(self._recipe.fixed)

    def dof(self, node: int, direction: str) -> int:
        """Number of a dof from 0, as rows of the matrices and of FRFs are counted.

        Directions are ``'u', 'v', 'theta'`` in the plane, ``'u', 'v', 'w', 'rx', 'ry', 'rz'`` in space, and
        ``'x', 'y', 'z'`` translations. A dof that is not there, or fixed, is an InvalidInputError.
        """
        named = frame_parts.text("direction", None, direction)
        named = {"x": "u", "y": "v", "z": "w"}.get(named.lower(), named)
        return self._frame.dof(integer("node", node, low=0), named)

    def dof_name(self, dof: int) -> str:
        """``'node 3 v'`` for the dof that ``dof(3, 'v')`` returns."""
        return self._dof_labels()[self._dof("dof", dof)]

    dof_label = dof_name

    def _dof_labels(self) -> list[str]:
        return [f"node {node} {direction}" for node, direction in self._frame.dof_names()]

    @cached_property
    def _names(self) -> DofNames:
        return DofNames(self._dof_labels(), [f"{node}:{direction}" for node, direction in self.fixed])

    def section_index(self, name: str | int) -> int:
        """Index of a section, by its name."""
        return self._recipe.section_index(name)

    def section_label(self, section: int) -> str:
        """Name of a section in tables; those without a name by their number."""
        name = self._recipe.section_names[section]
        return name if isinstance(name, str) else f"section {section}"

    def element_label(self, element: int) -> str:
        """``element 0`` and on for the beams, then the springs to ground, then those between nodes."""
        ground = element - len(self._recipe.beams)
        if ground < 0:
            return f"element {element}"
        springs = self.ground_springs
        if ground < len(springs):
            return f"ground spring {ground} (node {springs[ground].node} {springs[ground].direction})"
        return f"node spring {ground - len(springs)}"

    def mass_label(self, term: int) -> str:
        """``element 0`` and on for the beams, then the point masses."""
        lump = term - len(self._recipe.beams)
        return f"element {term}" if lump < 0 else f"mass {lump} (node {self.point_masses[lump].node})"

    @property
    def default_elements(self) -> list[int]:
        """The beams, in order; springs only on request."""
        return list(range(len(self._recipe.beams)))

    def plot(self, values: Any = None, ax: Any = None, **options: Any) -> Any:
        """Draw the frame; ``values`` and ``options`` as in :func:`antires_rs.figures.plot_frame`."""
        return self._view("plot")(self, values, ax=ax, **options)

    def __repr__(self) -> str:
        where, nodes = "space" if self._recipe.in_space else "plane", len(self._recipe.nodes_m)
        return f"FrameModel({where}, {nodes} nodes, {len(self._recipe.beams)} elements, {self.n_dof} dofs)"
