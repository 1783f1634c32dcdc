"""Damage that is no loss of a whole element: cracks, joints, supports and springs, added mass.

A hinge at the share x of a beam leaves, as rigid pieces, the displacement d of the second end when the first
is held: a unit turn and what it carries along. With the beam's stiffness K, a rotational spring there turns

.. math:: K \\;\\to\\; K - \\beta\\, \\frac{K d\\, d^T K}{d^T K d}, \\qquad
   \\varphi = \\frac{\\beta}{1 - \\beta}\\, \\frac{1}{d^T K d},

where beta = 0 is the sound beam, 1 a free hinge, and phi (rad / N m) the spring's flexibility; this holds for
any beam theory. So a crack is a loss of stiffness of one more term, of rank one, and is judged as any other.
Cracks as rotational springs: A. D. Dimarogonas, Eng. Fract. Mech. 55 (1996) 831-857.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._core import Model as CoreModel
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.matrices import Columns, Entries, as_sparse
from ..models.parameters import Parameter
from ..models.recipes import FrameRecipe
from ..models.structural_model import ModelDescription
from ..support.checks import FloatArray

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

Kind = Literal["crack", "joint", "support", "mass"]
#: Bounds of a factor of stiffness or mass, exp(-1.6) to exp(1.6): no engineer errs as much.
BOUNDS = (0.2, 5.0)
CRACKED = 0.3  # share of the prior of an element's damage that is of cracks

PLACES = (0.1, 0.3, 0.5, 0.7, 0.9)  # places of cracks along an element
_MOST_MASS = 0.2  # the largest mass that may be added, as a share of the structure's
_TRANSLATIONS = ("u", "v", "w")  # directions in which a mass counts, and about which a beam bends
_STRAIGHT = 0.02  # two elements are one straight beam up to this angle (rad)


@dataclass(frozen=True)
class Shape:
    """A way to change the model, of one amount beta from 0 to 1."""

    kind: Kind
    element: int  # cracks and joints: of the model; else -1
    share: float  # where along the element
    node: int  # of a crack the first of its element
    #: Of a hinge: its flexibility over that of the whole element, L / EI, where beta / (1 - beta) is 1; of a
    #: mass: kg at beta = 1.
    size: float
    term: Entries = field(repr=False, compare=False)  # of stiffness or mass, by dof
    length_m: float = 0.0
    name: str = ""  # of a spring, or of the mass of a chain that gets more

    def loss(self, beta: Any) -> Any:
        """Loss of the whole element that makes it as flexible as a hinge."""
        flexible = self.size * beta / (1.0 - beta)
        return flexible / (1.0 + flexible)

    def amount(self, loss: Any) -> Any:
        """The amount beta of that loss."""
        return loss / (loss + (1.0 - loss) * self.size)

    def told(self, reach: tuple[float, float] | None = None) -> str:
        """Where a crack is, with the interval of its place."""
        ends = "" if reach is None else f" ({reach[0] * self.length_m:.3g} to {reach[1] * self.length_m:.3g})"
        return (
            f"crack {self.share * self.length_m:.3g} m{ends} from node {self.node} in element {self.element}"
        )


@dataclass(frozen=True)
class Shaped:
    """A hypothesis that is no loss of whole elements, in words and figures."""

    kind: str
    place: str
    log_evidence: float  # over all places
    view: Any
    severities: tuple[float, ...] = ()  # of elements that are as flexible
    low: tuple[float, ...] = ()
    high: tuple[float, ...] = ()
    #: The set that values do not tell from it: each has half of its prior.
    halves: tuple[int, ...] = field(default=(), kw_only=True)


@dataclass
class Found:
    """Damage with cracks, by elements as the search has them; and what is in no element."""

    cracked: dict[tuple[int, ...], Shaped] = field(default_factory=dict)
    others: list[Shaped] = field(default_factory=list)


@dataclass(frozen=True)
class Joined:
    """A model with more terms than it was built with, for its roots alone."""

    n_dof: int
    _core: CoreModel

    def _core_for(self, dofs: Sequence[int]) -> tuple[CoreModel, list[int]]:
        return self._core, list(dofs)


def joined(model: StructuralModel | Joined, shapes: Sequence[Shape]) -> Joined:
    """The model with the terms of ``shapes`` behind its own."""
    core = model._core
    stiffness, mass = core.stiffness_terms(), core.mass_terms()
    for shape in shapes:
        (mass if shape.kind == "mass" else stiffness).append(shape.term)
    whole = _entries(core.stiffness()), _entries(core.mass())
    return Joined(core.n_dof, CoreModel.from_matrices(core.n_dof, *whole, stiffness, mass))


def parameters_of(
    model: StructuralModel | Joined, shapes: Sequence[Shape], bounds: tuple[float, float] | None = None
) -> tuple[Parameter, ...]:
    """One each, as :func:`joined` has them: a loss, of a mass 1 + beta; with ``bounds`` a factor of what is
    not to change between the tests."""
    core, found = model._core, []
    behind = {"stiffness": core.n_stiffness_terms, "mass": core.n_mass_terms}
    for shape in shapes:
        of = "mass" if shape.kind == "mass" else "stiffness"
        lost = of == "stiffness" and bounds is None
        quantity: Any = "stiffness_reduction" if lost else f"{of}_factor"
        found.append(Parameter(quantity, (behind[of],), bounds or ((0.0, 1.0) if lost else (1.0, 2.0))))
        behind[of] += 1
    return tuple(found)


def _entries(columns: Columns) -> tuple[Any, Any, FloatArray]:
    starts, rows, values = columns
    column = np.repeat(np.arange(len(starts) - 1, dtype=np.uint32), np.diff(starts))
    return rows.astype(np.uint32), column, values


def _bordered(at: Any, own: Any, side: FloatArray, corner: FloatArray) -> tuple[Any, Any, FloatArray]:
    """Entries of the rows and columns ``own``, beside those ``at`` and among themselves."""
    row, column = (each.ravel() for each in np.meshgrid(at, own, indexing="ij"))
    ends = [each.ravel() for each in np.meshgrid(own, own, indexing="ij")]
    values = np.concatenate([side.ravel(), side.ravel(), corner.ravel()])
    return np.concatenate([row, column, ends[0]]), np.concatenate([column, row, ends[1]]), values


def _together(several: Sequence[tuple[Any, Any, FloatArray]]) -> Entries:
    """Their sum."""
    from scipy.sparse import coo_array

    rows, columns, values = map(np.concatenate, zip(*several, strict=True))
    n = 1 + max(int(each.max(initial=0)) for each in (rows, columns))
    return Entries.of_sparse(coo_array((values, (rows, columns)), shape=(n, n)))


def _product(force: FloatArray, factor: float = 1.0) -> Entries:
    """The term factor f f' of forces f by dof."""
    at = np.flatnonzero(force).astype(np.uint32)
    values = factor * np.outer(force[at], force[at]).ravel()
    return Entries(np.repeat(at, at.size), np.tile(at, at.size), values)


def _masses(kg: float, dofs: Sequence[int] | NDArray[np.intp]) -> Entries:
    """The term of a mass that moves with some dofs."""
    at = np.array(dofs, dtype=np.uint32)
    return Entries(at, at, np.full(at.size, kg))


def _of_core(term: Any, n: int) -> Any:
    from scipy.sparse import coo_array

    rows, columns, values = term
    return coo_array((values, (rows, columns)), shape=(n, n)).tocsr()


def structure_of(model: StructuralModel, highest_hz: float = 0.0) -> Structure:
    """What is known of a model beside its matrices; ``highest_hz`` is the frequency up to which the elements
    of a frame are to move as beams do between their nodes, too."""
    if isinstance(model, FrameModel):
        return Frame(model, highest_hz)
    return Chain(model) if isinstance(model, MassSpringChain) else Structure(model)


#: Dofs of a model of matrices up to which each may have another mass; terms up to which they are put in
#: order, and by how much that must be the plainest order.
_MOST_DOFS, _MOST_TERMS, _PLAINLY = 100, 300, 1.05
_HOLDS = 30.0  # stiffness of a support, over that of the dof that it holds
_STRAINED = 1e-6  # share of a term's largest entry from which on a force of it on the ground counts


class Structure:
    """A model of matrices: its masses may be wrong, where it has no terms that say how."""

    def __init__(self, model: StructuralModel) -> None:
        self.model = model
        #: The model with what its elements do between their nodes; None where that does not count.
        self.finer: Joined | None = None

    @property
    def along(self) -> FloatArray | None:
        """Place of each element along the structure, from -1 to 1, where it is known: of matrices by which of
        them share dofs (M. Fiedler, Czech. Math. J. 25 (1975) 619-633)."""
        terms = self.model._core.stiffness_terms()
        if not 2 < len(terms) <= _MOST_TERMS:
            return None
        touched = np.zeros((len(terms), self.model.n_dof))
        for nth, (rows, _, values) in enumerate(terms):
            touched[nth, np.asarray(rows)[np.asarray(values) != 0.0]] = 1.0
        shared = (touched @ touched.T > 0.0).astype(np.float64)
        sizes, ways = np.linalg.eigh(np.diag(shared.sum(axis=1)) - shared)
        if sizes[1] < 1e-9 or sizes[2] < _PLAINLY * sizes[1]:
            return None
        return np.linspace(-1.0, 1.0, len(terms))[np.argsort(np.argsort(ways[:, 1], kind="stable"))]

    @cached_property
    def _directions(self) -> NDArray[np.intp]:
        """Direction of each dof, as masses couple those of one; one for all where that tells nothing."""
        from scipy.sparse.csgraph import connected_components

        count, found = connected_components(as_sparse(self.model._core.mass()), directed=False)
        return found if count <= len(_TRANSLATIONS) else np.zeros(self.model.n_dof, dtype=np.intp)

    @property
    def grounded(self) -> list[int]:
        """Elements that stand on the ground, where that is seen: a shift of all strains few of them."""
        terms, held = self.model._core.stiffness_terms(), []
        shifts = self._directions == np.arange(self._directions.max() + 1)[:, None]
        for nth, (rows, columns, values) in enumerate(terms):
            pulls = [np.abs(np.bincount(rows, values * shift[columns])).max(initial=0.0) for shift in shifts]
            if max(pulls) > _STRAINED * np.abs(values).max(initial=0.0):
                held.append(nth)
        return held if 2 * len(held) < len(terms) else []

    @property
    def springs(self) -> tuple[Parameter, ...]:
        """A factor of each spring that is no element."""
        return ()

    @property
    def yielding(self) -> tuple[Parameter, ...]:
        """The same, and of what joints yield where they are dofs of their own."""
        return self.springs

    def hinged(self, left: Callable[[Structure], float]) -> Structure:
        """With joints that yield as dofs of their own."""
        del left
        return self

    def forms(self) -> list[Joined]:
        """Structures that the model may stand for, where it is not simply one of them."""
        return []

    def shapes(self, factor: Mapping[int, float]) -> list[Shape]:
        """A mass at each dof, or at two that are a node's: they follow each other, with the same mass, in
        different directions."""
        del factor
        mass, named = as_sparse(self.model._core.mass()), self.model.dof_label
        own, n = mass.diagonal(), self.model.n_dof
        if n > _MOST_DOFS:
            return []
        most, way = _MOST_MASS * float(own.sum()), self._directions
        pairs = [(k, k + 1) for k in range(n - 1) if way[k] != way[k + 1] and np.isclose(own[k], own[k + 1])]
        alone = [(k,) for k in range(n) if not any(k in pair for pair in pairs) and own[k] > 0.0]
        return [
            Shape("mass", -1, 0.0, at[0], most, _masses(most, at), name=" and ".join(map(named, at)))
            for at in (*pairs, *alone)
        ]

    def joints(self) -> list[Shape]:
        """What the model may lack: the mass at each dof."""
        if self.model._core.n_mass_terms or self.model.n_dof > _MOST_DOFS:
            return []
        own = enumerate(np.asarray(self.model.mass().diagonal()).tolist())
        return [Shape("mass", -1, 0.0, dof, kg, _masses(kg, [dof])) for dof, kg in own if kg > 0.0]

    def _learned(self, k: int, factor: Mapping[int, float]) -> Entries:
        """A term of the finer model as the baseline has it."""
        assert self.finer is not None
        rows, columns, values = self.finer._core.stiffness_terms()[k]
        return Entries(rows, columns, factor.get(k, 1.0) * values)

    def places(self, taken: set[int], *, at_ends: bool) -> list[tuple[str, list[int]]]:
        """Where a support may have been forgotten, at ends or else, and dofs it would hold; not those
        ``taken``."""
        del taken, at_ends
        return []

    def held(self, dofs: Sequence[int]) -> Structure:
        """With some dofs of the model held by stiff springs."""
        core, other = (self.finer or self.model)._core, copy(self)
        whole = _together([_entries(core.stiffness()), *self._stiff(dofs)])
        terms = core.stiffness_terms(), core.mass_terms()
        made = CoreModel.from_matrices(core.n_dof, whole, _entries(core.mass()), *terms)
        other.finer = Joined(core.n_dof, made)
        return other

    def _stiff(self, dofs: Sequence[int]) -> list[Entries]:
        own = np.asarray(self.model.stiffness().diagonal())
        return [_masses(_HOLDS * float(own[dof]), [dof]) for dof in dofs]

    def cracks(self, element: int, shares: Sequence[float], factor: Mapping[int, float]) -> list[Shape]:
        """None."""
        del element, shares, factor
        return []

    def neighbours(self, element: int) -> list[int]:
        """None are known."""
        del element
        return []


_BASES = (30.0, 10.0, 4.0, 2.0)  # springs under a base, over that of the lowest storey
_TILTS = (1, 2, 3)  # powers of the height with which a building tilts and bends as a whole


class Chain(Structure):
    """A chain; where it stands on the ground it may tilt there, and bend as a whole."""

    @property
    def along(self) -> FloatArray:
        """From the first spring to the last, springs to ground behind them."""
        return np.concatenate([np.linspace(-1.0, 1.0, max(self.model.n_dof - 1, 1)), [-1.0, 1.0]])

    def shapes(self, factor: Mapping[int, float]) -> list[Shape]:
        """A mass at each of the masses; and the base."""
        most = _MOST_MASS * float(np.diag(np.asarray(self.model.mass())).sum())
        nodes, named = range(self.model.n_dof), self.model.mass_label
        found = [Shape("mass", -1, 0.0, k, most, _masses(most, [k]), name=named(k)) for k in nodes]
        if self.finer is not None:  # it was learned that the base moves
            spring = self._learned(self.model._core.n_stiffness_terms, factor)
            found.append(Shape("support", -1, 0.0, -1, 1.0, spring, name="spring under the base"))
            found.append(replace(self.joints()[0], kind="support", node=0, name="base against tilting"))
        return found

    def places(self, taken: set[int], *, at_ends: bool) -> list[tuple[str, list[int]]]:
        """Where it is free at an end, and may have a spring as soft as the next one."""
        recipe, last = self.model._recipe, self.model.n_dof - 1
        ends = (0, recipe.ground_first_n_per_m), (last, recipe.ground_last_n_per_m)
        return [(self.model.mass_label(dof), [dof]) for dof, stiffness in ends if at_ends and not stiffness]

    def _stiff(self, dofs: Sequence[int]) -> list[Entries]:
        springs = self.model._recipe.springs_n_per_m
        return [_masses(float(springs[min(dof, len(springs) - 1)]), [dof]) for dof in dofs]

    @property
    def _stands(self) -> tuple[int, int] | None:
        """Its spring to the ground, where it has one, and the mass on that."""
        last, recipe = self.model.n_dof - 1, self.model._recipe
        first, second = recipe.ground_first_n_per_m != 0.0, recipe.ground_last_n_per_m != 0.0
        return None if first == second else (last, 0) if first else (last + 1, last)

    def based(self, left: Callable[[Structure], float]) -> Chain:
        """With a base of its own, as heavy as the mass above it, on a spring with which least is left."""
        if self._stands is None:
            return self
        core, n, (term, foot) = self.model._core, self.model.n_dof, self._stands
        terms, masses = core.stiffness_terms(), core.mass_terms()
        stiff, mass = float(np.sum(terms[term][2])), as_sparse(core.mass()).diagonal()[foot]
        under = np.array([foot, n, n]), np.array([n, foot, n]), stiff * np.array([-1.0, -1.0, 1.0])
        terms[term], base = _together([terms[term], under]), _masses(mass, [n])
        found: list[tuple[float, Chain]] = []
        for times in _BASES:
            other, spring = copy(self), _masses(times * stiff, [n])
            whole = _together([_entries(core.stiffness()), under, spring])
            heavy = _together([_entries(core.mass()), base])
            made = CoreModel.from_matrices(n + 1, whole, heavy, [*terms, spring], [*masses, base])
            other.finer = Joined(n + 1, made)
            found.append((left(other), other))
        return min(found, key=lambda each: each[0])[1]

    @property
    def yielding(self) -> tuple[Parameter, ...]:
        """The spring and the mass of the base."""
        if self.finer is None:
            return ()
        core = self.model._core
        stiffness = Parameter("stiffness_factor", (core.n_stiffness_terms,), BOUNDS)
        return stiffness, Parameter("mass_factor", (core.n_mass_terms,), BOUNDS)

    def joints(self) -> list[Shape]:
        """What tilting and bending leave of the stiffness, by the formula of a hinge."""
        if self._stands is None:
            return []
        n, (_, foot) = self.model.n_dof, self._stands
        stiffness: Any = self.model.stiffness()  # dense for a chain
        if self.finer is not None:
            stiffness = as_sparse(self.finer._core.stiffness()).toarray()
        height = np.arange(1.0, n + 1.0)[:: -1 if foot else 1] / n
        found = []
        for power in _TILTS:
            way = np.pad(height**power, (0, len(stiffness) - n))
            force = stiffness @ way
            found.append(Shape("joint", -1, 0.0, -1, 1.0, _product(force / np.sqrt(way @ force))))
        return found


# -- What elements do between their nodes, where they are long against the waves in them, as further dofs
#
# Each is cut into some parts; its lowest modes with both ends held join the static shapes (R. R. Craig and M.
# C. C. Bampton, AIAA J. 6 (1968) 1313-1319), and scale with its stiffness and mass. What a frame may lack are
# hinges and supports on springs, dofs of their own too: the loss of an element leaves them as they are.

#: Parts of an element; modes up to this multiple of the highest frequency that was measured.
_PARTS, _HELD_UP_TO = 4, 8.0
#: Springs of joints and supports that turn, in EI / L of the element; of supports that move, in what the
#: elements there have.
_HINGES, _SUPPORTS = (60.0, 25.0, 12.0, 6.0, 3.0), (30.0, 10.0, 4.0)
_MOST_PLACES = 60  # nodes of which a support may have been forgotten
_STILL = 1e-3  # least mass that such a mode carries along, over that of the element, as a square root


class Inner(NamedTuple):
    """Modes of an element whose ends are held, of mass one."""

    dofs: NDArray[np.intp]  # (k,)
    squares: FloatArray  # of their frequencies (rad/s), (k,)
    carried: FloatArray  # mass between the dofs of both ends and them, (m, k)
    forces: tuple[FloatArray, ...]  # on them by the second end of each part, (dofs of a node, k)


class Frame(Structure):
    """Geometry of a frame, its matrices with every dof free, its shapes with the baseline's ``factor``."""

    def __init__(self, model: FrameModel, highest_hz: float = 0.0) -> None:
        recipe = model._recipe
        whole = ModelDescription(replace(recipe, fixed=()), model.description.applied).core()
        frame = whole.frame()
        assert frame is not None
        super().__init__(model)
        self.ends, self.nodes = model.elements.tolist(), np.asarray(model.nodes_m)
        self.n, self.sections = whole.n_dof, list(model.sections.values())
        self.stiffness = [_of_core(term, self.n) for term in whole.stiffness_terms()[: len(self.ends)]]
        self.at = {tuple(name): dof for dof, name in enumerate(frame.dof_names())}
        self.free = np.array([self.at[name] for name in map(tuple, model._frame.dof_names())])
        self.mass = as_sparse(whole.mass())
        self.in_space = self.nodes.shape[1] == 3
        held = set(model.fixed)
        self.meeting: dict[int, list[tuple[int, int]]] = {}
        for element, pair in enumerate(self.ends):
            for end, node in enumerate(pair):
                self.meeting.setdefault(node, []).append((element, end))
        self.moves = _TRANSLATIONS[: self.nodes.shape[1]]
        self.turns = ("rx", "ry", "rz") if self.in_space else ("theta",)
        #: Nodes at which an element's end may turn: supports that hold it, and corners.
        self.turning: dict[int, Kind] = {}
        for node, several in self.meeting.items():
            if any((node, name) in held for name in self.turns) and len(several) == 1:
                self.turning[node] = "support"
            elif len(several) > 2 or (len(several) == 2 and not self._straight(several)):
                self.turning[node] = "joint"
        self.inner: dict[int, Inner] = {}
        self.masses = [_of_core(term, self.n) for term in whole.mass_terms()[: len(self.ends)]]
        #: Dofs of an element's hinges, and how they turn the dofs of its ends, (m, k); nodes that have
        #: any, and in which direction they move.
        self.hinges: dict[int, tuple[list[int], FloatArray]] = {}
        self.hinge_nodes: list[tuple[int, str]] = []
        if highest_hz:
            n = self.free.size
            for element in range(len(self.ends)):
                inner = self._held(element, n, (2.0 * np.pi * _HELD_UP_TO * highest_hz) ** 2)
                if inner.dofs.size:
                    self.inner[element] = inner
                    n += inner.dofs.size
            if self.inner:
                self.finer = self._refined()

    def _refined(self, turn: float = 0.0, move: float = 0.0) -> Joined:
        """The model with what elements do between their nodes, hinges of so many times EI / L, and springs
        under supports of so many times the stiffness that the elements have there."""
        core, row = self.model._core, np.full(self.n, -1)
        row[self.free] = np.arange(self.free.size)
        n = self.free.size + sum(inner.dofs.size for inner in self.inner.values())
        terms = core.stiffness_terms(), core.mass_terms()
        added: tuple[list[Any], list[Any]] = ([_entries(core.stiffness())], [_entries(core.mass())])
        springs: dict[tuple[int, str], list[tuple[int, float]]] = {}
        under: dict[int, int] = {}
        for element in range(len(self.ends)):
            ends = self._ends_of(element)
            k, m = (each[ends][:, ends].toarray() for each in (self.stiffness[element], self.masses[element]))
            free = row[ends] >= 0
            none = np.empty(0, dtype=np.intp), np.empty(0), np.empty((ends.size, 0)), ()
            inner = self.inner.get(element, Inner(*none))
            turned: list[FloatArray] = []
            own: list[int] = []
            for node, axis, stiffness in self._turns_of(element) if turn else ():
                column = np.zeros(ends.size)
                column[np.isin(ends, [self.at[node, name] for name in self.turns])] = self._turns(axis)
                if (k @ column)[free].any():
                    turned.append(column)
                    own.append(n)
                    springs.setdefault((node, ""), []).append((n, turn * stiffness))
                    n += 1
            for node, name in product(self.ends[element], self.moves) if move else ():
                column = (ends == self.at[node, name]).astype(np.float64)
                if not free[ends == self.at[node, name]].all() and (k @ column)[free].any():
                    turned.append(column)
                    own.append(under.setdefault(self.at[node, name], n))
                    n += own[-1] == n
                    springs.setdefault((node, name), []).append((own[-1], move * float(column @ k @ column)))
            d = np.array(turned).reshape(-1, ends.size).T
            if own:
                self.hinges[element] = own, d
            dofs = np.concatenate([inner.dofs, own]).astype(np.intp)
            zero = np.zeros((inner.dofs.size, d.shape[1]))
            beside = np.hstack([0.0 * inner.carried, k @ d]), np.hstack([inner.carried, m @ d])
            joint, size = inner.carried.T @ d, inner.dofs.size
            stiff = np.block([[np.diag(inner.squares), zero], [zero.T, d.T @ k @ d]])
            corner = stiff, np.block([[np.eye(size), joint], [joint.T, d.T @ m @ d]])
            for own_terms, whole, side, block in zip(terms, added, beside, corner, strict=True):
                if dofs.size:
                    more = _bordered(row[ends][free], dofs, side[free], block)
                    own_terms[element] = _together([own_terms[element], more])
                    whole.append(more)
        for key, several in springs.items():
            at = np.array([dof for dof, _ in several])
            terms[0].append((at, at, np.array([stiffness for _, stiffness in several])))
            added[0].append(terms[0][-1])
            self.hinge_nodes.append(key)
        k_terms, m_terms = ([_together([each]) for each in own] for own in terms)
        stiffness_of_all, mass_of_all = map(_together, added)
        return Joined(n, CoreModel.from_matrices(n, stiffness_of_all, mass_of_all, k_terms, m_terms))

    def _turns_of(self, element: int) -> Iterator[tuple[int, FloatArray, float]]:
        """Nodes at which an element may turn, axes, and its EI / L."""
        for node in self.ends[element]:
            for turn in self._axes(element, self._along(element)[0]) if node in self.turning else ():
                yield node, turn, self._bending(element, turn)

    def _held(self, element: int, first: int, most: float) -> Inner:
        """Modes of an element with its ends held, where they move with what is free."""
        from scipy.linalg import eigh

        recipe, ends = self.model._recipe, self._ends_of(element)
        line = self.nodes[self.ends[element]]
        core = FrameRecipe(
            line[0] + np.linspace(0.0, 1.0, _PARTS + 1)[:, None] * (line[1] - line[0]),
            tuple((nth, nth + 1, 0) for nth in range(_PARTS)),
            (0,),
            (self.sections[recipe.beams[element][2]],),
            None if recipe.orientation is None else np.tile(recipe.orientation[element], (_PARTS, 1)),
        ).core()
        n, per = core.n_dof, ends.size // 2
        outer, inside = np.r_[:per, n - per : n], np.r_[per : n - per]
        k, m = (as_sparse(each).toarray() for each in (core.stiffness(), core.mass()))
        static = np.zeros((n, ends.size))
        static[outer] = np.eye(ends.size)
        static[inside] = -np.linalg.solve(k[np.ix_(inside, inside)], k[np.ix_(inside, outer)])
        # Updating may have changed both by factors.
        now = [float(each.diagonal()[ends].sum()) for each in (self.stiffness[element], self.masses[element])]
        by = [own / float(np.trace(static.T @ each @ static)) for own, each in zip(now, (k, m), strict=True)]
        squares, shapes = eigh(by[0] * k[np.ix_(inside, inside)], by[1] * m[np.ix_(inside, inside)])
        carried = by[1] * (static.T @ m)[:, inside] @ shapes
        modes = np.zeros((n, squares.size))
        modes[inside] = shapes
        moved = np.abs(carried[np.isin(ends, self.free)]).max(axis=0, initial=0.0)
        kept = (squares < most) & (moved > _STILL * np.sqrt(by[1] * np.trace(m)))
        forces = []
        for part, term in enumerate(core.stiffness_terms()):
            second = np.arange((part + 1) * per, (part + 2) * per)
            forces.append(by[0] * (_of_core(term, n)[second] @ modes[:, kept]))
        return Inner(first + np.arange(kept.sum()), squares[kept], carried[:, kept], tuple(forces))

    def _ends_of(self, element: int) -> NDArray[np.intp]:
        return np.array([dof for node in self.ends[element] for dof in self._of_node(node)])

    def shapes(self, factor: Mapping[int, float]) -> list[Shape]:
        """Cracks, joints, supports and masses."""
        found = [one for e in range(len(self.ends)) for one in self.cracks(e, PLACES, factor)]
        for node, kind in self.turning.items():
            for element, end in self.meeting[node]:
                found += self._hinges(element, float(end), kind, node, factor)
        terms = self.model._core.stiffness_terms()
        for (k,) in (p.terms for p in self.springs):  # that lose stiffness
            label = self.model.element_label(k)
            found.append(Shape("support", -1, 0.0, -1, 1.0, Entries(*terms[k]), name=label))
        found += self._pins(factor)
        one = np.zeros(self.n)
        one[[self.at[node, self.moves[0]] for node in range(len(self.nodes))]] = 1.0
        most = _MOST_MASS * float(one @ (self.mass @ one))
        for node in range(len(self.nodes)):  # that can move
            row = np.flatnonzero(np.isin(self.free, [self.at[node, name] for name in self.moves]))
            if row.size:
                found.append(Shape("mass", -1, 0.0, node, most, _masses(most, row)))
        return found

    def places(self, taken: set[int], *, at_ends: bool) -> list[tuple[str, list[int]]]:
        """Nodes that nothing holds: in each direction alone, in all of them, and clamped."""
        nodes = [node for node, several in self.meeting.items() if (len(several) == 1) == at_ends]
        found = []
        for node in nodes[:_MOST_PLACES]:
            moves, every = (
                np.flatnonzero(np.isin(self.free, own)).tolist()
                for own in ([self.at[node, name] for name in self.moves], self._of_node(node))
            )
            if len(moves) == len(self.moves) and taken.isdisjoint(moves):
                ways = [*([dof] for dof in moves), moves, every]
                found += [(f"node {node}", way) for way in ways]
        return found

    @property
    def along(self) -> FloatArray:
        """Place of each element along the longer side of the frame, from -1 to 1."""
        middles = self.nodes[np.array(self.ends)].mean(axis=1)
        own = middles[:, int(np.argmax(np.ptp(self.nodes, axis=0)))]
        size = float(np.ptp(own))
        return np.asarray(2.0 * (own - own.min()) / size - 1.0 if size else np.zeros(own.size))

    def forms(self) -> list[Joined]:
        """As its elements move between their nodes, and with some springs of joints and supports."""
        found = [self.finer or joined(self.model, [])]
        for turn, move in product((0.0, *_HINGES[1:4]), (0.0, _SUPPORTS[1])):
            other = self._on(turn, move)
            kinds = {bool(name) for _, name in other.hinge_nodes}
            if other.finer and kinds and kinds == {kind for kind, on in ((False, turn), (True, move)) if on}:
                found.append(other.finer)
        return found if self.finer or found[1:] else []

    def _on(self, turn: float, move: float) -> Frame:
        """With hinges and supports on springs, as :meth:`_refined` has them."""
        other = copy(self)
        other.hinges, other.hinge_nodes = {}, []
        other.finer = other._refined(turn, move)
        return other

    def hinged(self, left: Callable[[Structure], float]) -> Structure:
        """With springs between elements and the nodes at which they may turn, and under supports, of those
        stiffnesses with which least is ``left``; itself if it has no such node or is best as it is."""
        found: list[tuple[float, float, float, Structure]] = [(left(self), 0.0, 0.0, self)]
        for turns, moves in ((_HINGES, (0.0,)), ((0.0, -1.0), _SUPPORTS)):
            best = min(found, key=lambda each: each[0])[1]
            for turn, move in product(dict.fromkeys(best if each < 0.0 else each for each in turns), moves):
                other = self._on(turn, move)
                if other.hinge_nodes:
                    found.append((left(other), turn, move, other))
        return min(found, key=lambda each: each[0])[3]

    @property
    def yielding(self) -> tuple[Parameter, ...]:
        """Springs, and those of the hinges, one a node."""
        first = self.model._core.n_stiffness_terms
        turning = range(first, first + len(self.hinge_nodes))
        return (*self.springs, *(Parameter("stiffness_factor", (k,), BOUNDS) for k in turning))

    @property
    def springs(self) -> tuple[Parameter, ...]:
        """A factor of each spring, to ground or between nodes."""
        first, last = len(self.ends), self.model._core.n_stiffness_terms
        terms = [self.model._core.stiffness_terms()[k] for k in range(first, last)]
        held = [first + k for k, term in enumerate(terms) if np.any(term[2])]
        return tuple(Parameter("stiffness_factor", (k,), BOUNDS) for k in held)

    def _pins(self, factor: Mapping[int, float]) -> list[Shape]:
        """Pins and rollers that yield; a clamp turns first."""
        first, found = self.model._core.n_stiffness_terms, []
        for node, name in self.model._recipe.fixed:
            if self.turning.get(node) == "support" or name not in self.moves:
                continue
            at, force = self.at[node, name], np.zeros(self.n)
            for element, _ in self.meeting.get(node, ()):
                force += factor.get(element, 1.0) * self.stiffness[element][:, [at]].toarray()[:, 0]
            if not force[self.free].any():
                continue
            term = _product(force[self.free] / np.sqrt(force[at]))
            if self.finer is not None and (node, name) in self.hinge_nodes:  # it was learned
                k = first + self.hinge_nodes.index((node, name))
                term = self._learned(k, factor)
            found.append(Shape("support", -1, 0.0, node, 1.0, term, name=f"support at node {node} ({name})"))
        return found

    def cracks(self, element: int, shares: Sequence[float], factor: Mapping[int, float]) -> list[Shape]:
        """Of one element, at some places."""
        first = self.ends[element][0]
        return [one for x in shares for one in self._hinges(element, x, "crack", first, factor)]

    def neighbours(self, element: int) -> list[int]:
        """Elements with a node in common; a spring has none."""
        if element >= len(self.ends):
            return []
        return [other for node in self.ends[element] for other, _ in self.meeting[node] if other != element]

    def _along(self, element: int) -> tuple[FloatArray, float]:
        first, second = (self.nodes[node] for node in self.ends[element])
        length = float(np.linalg.norm(second - first))
        return (second - first) / length, length

    def _straight(self, pair: list[tuple[int, int]]) -> bool:
        one, other = (self._along(element)[0] * (1.0 if end else -1.0) for element, end in pair)
        return bool(one @ other < -np.cos(_STRAIGHT))

    def _hinges(
        self, element: int, share: float, kind: Kind, node: int, factor: Mapping[int, float]
    ) -> list[Shape]:
        """A hinge about each axis about which the beam bends, where what is free of it moves."""
        along, length = self._along(element)
        second, found = self.ends[element][1], []
        for turn in self._axes(element, along):
            kink = np.zeros(self.n)
            arm = (1.0 - share) * length * np.pad(along, (0, 3 - along.size))
            kink[self._of_node(second)] = [*np.cross(turn, arm)[: along.size], *self._turns(turn)]
            force = self.stiffness[element] @ kink
            stiff = float(kink @ force)
            own = force[self.free]
            if not stiff > 0.0 or not own.any():
                continue
            if self.finer is not None:
                own = np.pad(own, (0, self.finer.n_dof - own.size))
            if element in self.hinges:
                dofs, turned_by = self.hinges[element]
                own[dofs] = force[self._ends_of(element)] @ turned_by
            if element in self.inner:
                inner, part = self.inner[element], min(int(share * _PARTS), _PARTS - 1)
                arm *= ((part + 1) / _PARTS - share) / (1.0 - share) if share < 1.0 else 0.0
                turned = [*np.cross(turn, arm)[: along.size], *self._turns(turn)]
                own[inner.dofs] = turned @ inner.forces[part]
                stiff += float(np.sum(own[inner.dofs] ** 2 / inner.squares))
            term = _product(own / np.sqrt(stiff), factor.get(element, 1.0))
            found.append(
                Shape(kind, element, share, node, self._bending(element, turn) / stiff, term, length)
            )
        return found

    def _axes(self, element: int, along: FloatArray) -> list[FloatArray]:
        """Principal axes of bending."""
        if not self.in_space:
            return [np.array([0.0, 0.0, 1.0])]
        one, other = np.linalg.svd(along[None])[2][1:]
        own = self._bending(element, one), self._bending(element, other)
        both = 0.5 * (self._bending(element, one + other) - sum(own))
        _, ways = np.linalg.eigh([[own[0], both], [both, own[1]]])
        return [one * first + other * second for first, second in ways.T]

    def _of_node(self, node: int) -> list[int]:
        return [self.at[node, name] for name in (*self.moves, *self.turns)]

    def _turns(self, turn: FloatArray) -> FloatArray:
        return turn if self.in_space else turn[2:]

    def _bending(self, element: int, turn: FloatArray) -> float:
        """EI / L of an element about an axis: the moment over the angle between ends that turn alike."""
        bent, still = np.zeros(self.n), np.zeros(self.nodes.shape[1])
        for sign, node in zip((-0.5, 0.5), self.ends[element], strict=True):
            bent[self._of_node(node)] = [*still, *(sign * self._turns(turn))]
        return float(bent @ (self.stiffness[element] @ bent))
