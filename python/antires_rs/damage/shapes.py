"""Damage that is no loss of a whole element: cracks, loosened joints, added mass, a sensor that has moved.

A hinge at the share x of a beam leaves, as rigid pieces, the displacement d of the second end when the first
is held: a unit turn and what it carries along. With the beam's stiffness K, a rotational spring there turns

.. math:: K \\;\\to\\; K - \\beta\\, \\frac{K d\\, d^T K}{d^T K d}, \\qquad
   \\varphi = \\frac{\\beta}{1 - \\beta}\\, \\frac{1}{d^T K d},

where beta = 0 is the sound beam, 1 a free hinge, and phi (rad / N m) the spring's flexibility; this holds for
any beam theory. So a crack is a loss of stiffness of one more term, of rank one, and is judged as any other.
Cracks as rotational springs: A. D. Dimarogonas, Eng. Fract. Mech. 55 (1996) 831-857.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from .._core import Model as CoreModel
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.matrices import Columns, Entries, as_sparse
from ..models.parameters import Parameter
from ..models.structural_model import ModelDescription
from ..support.checks import FloatArray

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

Kind = Literal["crack", "joint", "support", "mass"]
#: Share of the prior of an element's damage that is of cracks.
CRACKED = 0.3

#: Places of cracks along an element.
PLACES = (0.1, 0.3, 0.5, 0.7, 0.9)
#: The largest mass that may be added, as a share of the structure's.
_MOST_MASS = 0.2
#: Directions in which a mass counts, and about which a beam bends.
_TRANSLATIONS = ("u", "v", "w")
#: Two elements are one straight beam up to this angle (rad).
_STRAIGHT = 0.02


class Shape(NamedTuple):
    """A way to change the model, of one amount beta from 0 to 1."""

    kind: Kind
    element: int  # cracks and joints: of the model; else -1
    share: float  # where along the element
    node: int  # of a crack the first of its element
    #: Of a hinge: its flexibility over that of the whole element, L / EI, where beta / (1 - beta) is 1; of a
    #: mass: kg at beta = 1.
    size: float
    length_m: float = 0.0
    name: str = ""  # of a spring, or of the mass of a chain that gets more

    def loss(self, beta: float) -> float:
        """Loss of the whole element that makes it as flexible as a hinge."""
        flexible = self.size * beta / (1.0 - beta)
        return flexible / (1.0 + flexible)


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


@dataclass
class Found:
    """Damage with cracks, by elements as the search has them; and what is in no element."""

    cracked: dict[tuple[int, ...], Shaped] = field(default_factory=dict)
    others: list[Shaped] = field(default_factory=list)


@dataclass(frozen=True)
class Shapes:
    """All of a model, with their terms (n, n) of stiffness or mass by dof."""

    shapes: tuple[Shape, ...]
    terms: tuple[Any, ...]

    def __len__(self) -> int:
        return len(self.shapes)

    def parameters(self, model: StructuralModel | Joined) -> tuple[Parameter, ...]:
        """One each, as the model of :meth:`joined` has them; of a mass 1 + beta."""
        stiffness, mass = model._core.n_stiffness_terms, model._core.n_mass_terms
        found = []
        for shape in self.shapes:
            if shape.kind == "mass":
                found.append(Parameter("mass_factor", (mass,), (1.0, 2.0)))
                mass += 1
            else:
                found.append(Parameter("stiffness_reduction", (stiffness,), (0.0, 1.0)))
                stiffness += 1
        return tuple(found)

    def factors(self, model: StructuralModel | Joined, bounds: tuple[float, float]) -> tuple[Parameter, ...]:
        """A factor of each that is not to change between the tests."""
        kinds: Any = {"stiffness_reduction": "stiffness_factor", "mass_factor": "mass_factor"}
        return tuple(Parameter(kinds[p.quantity], p.terms, bounds) for p in self.parameters(model))

    @property
    def offset(self) -> FloatArray:
        """What the core takes for no change, of each."""
        return np.array([1.0 if shape.kind == "mass" else 0.0 for shape in self.shapes])

    def joined(self, model: StructuralModel | Joined) -> Joined:
        """The model with these terms behind its own."""
        core = model._core
        stiffness, mass = core.stiffness_terms(), core.mass_terms()
        for shape, term in zip(self.shapes, self.terms, strict=True):
            (mass if shape.kind == "mass" else stiffness).append(Entries.of_sparse(term))
        whole = _entries(core.stiffness()), _entries(core.mass())
        return Joined(core.n_dof, CoreModel.from_matrices(core.n_dof, *whole, stiffness, mass))


@dataclass(frozen=True)
class Joined:
    """A model with more terms than it was built with, for its roots alone."""

    n_dof: int
    _core: CoreModel

    def _core_for(self, dofs: Sequence[int]) -> tuple[CoreModel, list[int]]:
        return self._core, list(dofs)


def _entries(columns: Columns) -> tuple[Any, Any, FloatArray]:
    starts, rows, values = columns
    column = np.repeat(np.arange(len(starts) - 1, dtype=np.uint32), np.diff(starts))
    return rows.astype(np.uint32), column, values


def _of_core(term: Any, n: int) -> Any:
    from scipy.sparse import coo_array

    rows, columns, values = term
    return coo_array((values, (rows, columns)), shape=(n, n)).tocsr()


def structure_of(model: StructuralModel) -> Structure:
    """What is known of a model beside its matrices."""
    if isinstance(model, FrameModel):
        return Frame(model)
    return Chain(model) if isinstance(model, MassSpringChain) else Structure(model)


#: Dofs of a model of matrices up to which each may have another mass; terms up to which they are put in
#: order, and by how much that must be the plainest order.
_MOST_DOFS, _MOST_TERMS, _PLAINLY = 100, 300, 1.05


class Structure:
    """A model of matrices: its masses may be wrong, where it has no terms that say how."""

    def __init__(self, model: StructuralModel) -> None:
        self.model = model

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

    @property
    def springs(self) -> tuple[Parameter, ...]:
        """A factor of each spring that is no element."""
        return ()

    def shapes(self, factor: Mapping[int, float]) -> Shapes:
        """What may change beside the losses of elements."""
        del factor
        return Shapes((), ())

    def joints(self) -> Shapes:
        """What the model may lack: the mass at each dof."""
        from scipy.sparse import csr_array

        n = self.model.n_dof
        if self.model._core.n_mass_terms or n > _MOST_DOFS:
            return Shapes((), ())
        own = np.asarray(self.model.mass().diagonal())
        found = []
        for dof in np.flatnonzero(own > 0.0).tolist():
            term = csr_array(([own[dof]], ([dof], [dof])), shape=(n, n))
            found.append((Shape("mass", -1, 0.0, dof, float(own[dof])), term))
        return _listed(found)

    def cracks(self, element: int, shares: Sequence[float], factor: Mapping[int, float]) -> Shapes:
        """None."""
        del element, shares, factor
        return Shapes((), ())

    def neighbours(self, element: int) -> list[int]:
        """None are known."""
        del element
        return []


#: Powers of the height with which a building tilts and bends as a whole.
_TILTS = (1, 2, 3)


class Chain(Structure):
    """A chain; where it stands on the ground it may tilt there, and bend as a whole."""

    @property
    def along(self) -> FloatArray:
        """From the first spring to the last, springs to ground behind them."""
        between = np.linspace(-1.0, 1.0, max(self.model.n_dof - 1, 1))
        return np.concatenate([between, [-1.0, 1.0]])

    def shapes(self, factor: Mapping[int, float]) -> Shapes:
        """A mass at each of the masses."""
        from scipy.sparse import csr_array

        n, mass = self.model.n_dof, np.diag(np.asarray(self.model.mass()))
        most = _MOST_MASS * float(mass.sum())
        terms = [csr_array(([most], ([node], [node])), shape=(n, n)) for node in range(n)]
        named = self.model.mass_label
        return _listed(
            [(Shape("mass", -1, 0.0, node, most, name=named(node)), term) for node, term in enumerate(terms)]
        )

    def joints(self) -> Shapes:
        """What tilting and bending leave of the stiffness, by the formula of a hinge."""
        from scipy.sparse import csr_array

        recipe = self.model._recipe
        ends = recipe.ground_first_n_per_m, recipe.ground_last_n_per_m
        if (ends[0] == 0.0) == (ends[1] == 0.0):
            return Shapes((), ())
        n, stiffness = self.model.n_dof, np.asarray(self.model.stiffness())
        height = np.arange(1.0, n + 1.0) / n
        found = []
        for power in _TILTS:
            way = (height if ends[0] else height[::-1]) ** power
            force = stiffness @ way
            column = csr_array((force / np.sqrt(way @ force))[:, None])
            found.append((Shape("joint", -1, 0.0, -1, 1.0), column @ column.T))
        return _listed(found)


class Frame(Structure):
    """The geometry of a frame, its matrices with every dof free, and the shapes that these give.

    ``factor`` is that of each element's stiffness, after the baseline.
    """

    def __init__(self, model: FrameModel) -> None:
        recipe = model._recipe
        whole = ModelDescription(replace(recipe, fixed=()), model.description.applied).core()
        frame = whole.frame()
        assert frame is not None
        super().__init__(model)
        self.ends, self.nodes = model.elements.tolist(), np.asarray(model.nodes_m)
        self.n = whole.n_dof
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

    def shapes(self, factor: Mapping[int, float]) -> Shapes:
        """Cracks, joints and masses."""
        found: list[tuple[Shape, Any]] = []
        for element in range(len(self.ends)):
            for share in PLACES:
                found += self._hinges(element, share, "crack", self.ends[element][0], factor)
        return _listed([*found, *self._turning(factor), *self._supports(), *self._masses()])

    @property
    def along(self) -> FloatArray:
        """Place of each element along the longer side of the frame, from -1 to 1."""
        middles = self.nodes[np.array(self.ends)].mean(axis=1)
        own = middles[:, int(np.argmax(np.ptp(self.nodes, axis=0)))]
        size = float(np.ptp(own))
        return np.asarray(2.0 * (own - own.min()) / size - 1.0 if size else np.zeros(own.size))

    def joints(self) -> Shapes:
        """Joints and supports of the sound frame, one a node: all ends there turn alike."""
        found: dict[int, tuple[Shape, Any]] = {}
        for shape, term in self._turning({}):
            before = found.get(shape.node)
            found[shape.node] = (shape, term if before is None else before[1] + term)
        return _listed(list(found.values()))

    @property
    def springs(self) -> tuple[Parameter, ...]:
        """A factor of each spring, to ground or between nodes."""
        first, last = len(self.ends), self.model._core.n_stiffness_terms
        terms = [self.model._core.stiffness_terms()[k] for k in range(first, last)]
        held = [first + k for k, term in enumerate(terms) if np.any(term[2])]
        return tuple(Parameter("stiffness_factor", (k,), (0.2, 5.0)) for k in held)

    def _supports(self) -> list[tuple[Shape, Any]]:
        """Springs that lose stiffness."""
        terms, n = self.model._core.stiffness_terms(), self.model.n_dof
        found = []
        for (k,) in (p.terms for p in self.springs):
            shape = Shape("support", -1, 0.0, -1, 1.0, name=self.model.element_label(k))
            found.append((shape, _of_core(terms[k], n)))
        return found

    def _turning(self, factor: Mapping[int, float]) -> list[tuple[Shape, Any]]:
        found = []
        for node, kind in self.turning.items():
            for element, end in self.meeting[node]:
                found += self._hinges(element, float(end), kind, node, factor)
        return found

    def cracks(self, element: int, shares: Sequence[float], factor: Mapping[int, float]) -> Shapes:
        """Of one element, at some places."""
        return _listed(
            [one for x in shares for one in self._hinges(element, x, "crack", self.ends[element][0], factor)]
        )

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
    ) -> list[tuple[Shape, Any]]:
        """A hinge about each axis about which the beam bends, where what is free of it moves."""
        from scipy.sparse import csr_array

        along, length = self._along(element)
        second, found = self.ends[element][1], []
        for turn in self._axes(element, along):
            kink = np.zeros(self.n)
            arm = (1.0 - share) * length * np.pad(along, (0, 3 - along.size))
            kink[self._dofs(second)] = [*np.cross(turn, arm)[: along.size], *self._turns(turn)]
            force = self.stiffness[element] @ kink
            stiff = float(kink @ force)
            own = (force / np.sqrt(stiff))[self.free]
            if not stiff > 0.0 or not own.any():
                continue
            column = csr_array(own[:, None])
            shape = Shape(kind, element, share, node, self._bending(element, turn) / stiff, length)
            found.append((shape, factor.get(element, 1.0) * (column @ column.T)))
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

    def _dofs(self, node: int) -> list[int]:
        return [self.at[node, name] for name in (*self.moves, *self.turns)]

    def _turns(self, turn: FloatArray) -> FloatArray:
        return turn if self.in_space else turn[2:]

    def _bending(self, element: int, turn: FloatArray) -> float:
        """EI / L of an element about an axis: the moment over the angle between ends that turn alike."""
        bent, still = np.zeros(self.n), np.zeros(self.nodes.shape[1])
        for sign, node in zip((-0.5, 0.5), self.ends[element], strict=True):
            bent[self._dofs(node)] = [*still, *(sign * self._turns(turn))]
        return float(bent @ (self.stiffness[element] @ bent))

    def _masses(self) -> list[tuple[Shape, Any]]:
        """A mass at each node that can move."""
        from scipy.sparse import csr_array

        one, found = np.zeros(self.n), []
        one[[self.at[node, self.moves[0]] for node in range(len(self.nodes))]] = 1.0
        most = _MOST_MASS * float(one @ (self.mass @ one))
        for node in range(len(self.nodes)):
            row = np.flatnonzero(np.isin(self.free, [self.at[node, name] for name in self.moves]))
            if row.size:
                term = csr_array((np.full(row.size, most), (row, row)), shape=(self.free.size,) * 2)
                found.append((Shape("mass", -1, 0.0, node, most), term))
        return found


def _listed(found: Sequence[tuple[Shape, Any]]) -> Shapes:
    return Shapes(tuple(shape for shape, _ in found), tuple(term for _, term in found))
