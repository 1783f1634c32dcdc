"""Models from stiffness and mass matrices of any finite-element program."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property, partial
from typing import Any, Self

import numpy as np

from .._core import Model as CoreModel
from ..exceptions import InvalidInputError, part, reject
from ..support.checks import FloatArray, members
from ..support.directions import names_of
from ..views import Viewed
from .constraints import equations_by_number
from .matrices import Columns, Entries, as_masses, as_square, as_term
from .parameters import Parameter
from .penalties import warn_penalties
from .recipes import Independent, MatrixRecipe
from .structural_model import End, ModelDescription, StructuralModel
from .term_groups import Mesh, TermGroup, applied_factors, checked_groups, factor_of, powers_of

#: Decades between the K / M of dofs from which on one method alone loses roots; most dofs to ask both.
_APART, _MOST_FOR_BOTH = 8.0, 200
_ANY = (1e-12, 1e12)  # bounds of factors that are applied, not searched


class MatrixModel(StructuralModel, Viewed):
    """Stiffness and mass from any finite-element code, with the terms that parameters may scale.

    Parameters
    ----------
    stiffness, mass : array_like or scipy.sparse, (n, n)
        Symmetric nominal matrices; the mass may be singular (massless dofs). Sparse ones stay sparse: memory
        and time go with their entries. An imaginary part (hysteretic damping) is left out, and a damping
        matrix has no place: antiresonances are those of the undamped structure.
    stiffness_terms, mass_terms : sequence or mapping of array_like or scipy.sparse, (n, n)
        Contribution of each element (or group) to the matrix. A parameter with factor s turns K into
        ``K + (s - 1) K_i``; the terms need not add up to K. A mapping names them for tables and parameters.
    constraints : sequence of dict, array_like or scipy.sparse, (c, n)
        Homogeneous equations between dofs, as in :func:`eliminate_constraints`: ``{12: 1.0, 3: -1.0}`` is
        u12 = u3. Of each one dof is taken out of the matrices.
    keep : sequence of int or str
        Dofs that must not be taken out: those of sensors and of the force.
    dofs : sequence of str or (int, str), or mapping of them to rows, optional
        Names, one for each row: ``"1204:Z"`` or ``(1204, "+Z")``; or what :func:`antires_rs.io.read_dof_map`
        returns. A dof may then be given by its name wherever its number may.
    groups : sequence of TermGroup
        What the terms belong to, as :func:`read_model` finds it.
    mesh : Mesh, optional

    Raises
    ------
    InvalidInputError
        A matrix that is not square, symmetric and finite, or a negative mass; constraints between dofs to
        keep; one name for two dofs, in two spellings too; groups of one name, or of terms that are not there.

    Warns
    -----
    AntiresWarning
        An imaginary part; a mass below zero by rounding; penalties so stiff that rounding takes 1e-6 of a
        frequency beside them; dofs tied by 1e17 and more that nothing holds.

    Notes
    -----
    Taken out are also Lagrange multipliers (rows without mass and with nothing on the diagonal of the
    stiffness). All dofs keep their numbers, and a sensor or force may be at any of them: where one was taken
    out, another dof of its equation is taken out instead. A tie by a very stiff spring stays in the matrices,
    where rounding takes as many digits as it is stiffer than its neighbours.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> stiffness = 500.0 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    >>> names, rigid = ["1:Z", "2:Z", "3:Z"], [{"3:Z": 1.0, "2:Z": -1.0}]
    >>> bar = ar.MatrixModel(stiffness, np.eye(3), constraints=rigid, dofs=names)
    >>> bar.antiresonances("1:Z", "1:Z").round(3)
    array([2.516])
    >>> spring = stiffness[1:, 1:] - np.diag([500.0, 0.0])
    >>> ar.MatrixModel(spring, np.eye(2), stiffness_terms=[spring]).antiresonances(0, 0).round(3)
    array([3.559])
    """

    _recipe_type = MatrixRecipe
    _recipe: MatrixRecipe

    def __init__(
        self,
        stiffness: Any,
        mass: Any,
        *,
        stiffness_terms: Iterable[Any] | Mapping[str, Any] = (),
        mass_terms: Iterable[Any] | Mapping[str, Any] = (),
        constraints: Any = None,
        keep: Sequence[int | str] = (),
        dofs: Any = None,
        groups: Iterable[TermGroup] = (),
        mesh: Mesh | None = None,
    ) -> None:
        n, k = as_square("stiffness", stiffness)
        names = names_of("dofs", dofs, n)
        m = as_masses(as_square("mass", mass, n)[1], n, partial(_label, names))
        names_k, of_k = _terms("stiffness_terms", stiffness_terms, n)
        names_m, of_m = _terms("mass_terms", mass_terms, n)
        tied = equations_by_number(names, n, constraints, keep)
        known = checked_groups(groups, len(of_k), len(of_m))
        if mesh is not None and not isinstance(mesh, Mesh):
            reject("mesh", type(mesh).__name__, "a Mesh", "As in ar.Mesh(nodes, coordinates, ...).")
        recipe = MatrixRecipe(n, k, m, of_k, of_m, names, *tied, names_k, names_m, known, mesh)
        independent = recipe.independent()
        self._build(ModelDescription(recipe), independent.core())
        self._fill(_independent=independent)
        remedy = "Give ties, rigid links and supports as constraints=, or penalties a million times softer."
        warn_penalties(self.dof_label, self.stiffness(), remedy)

    @property
    def groups(self) -> dict[str, TermGroup]:
        """What the terms belong to, by name; empty but for models of :func:`read_model`."""
        return {group.name: group for group in self._recipe.groups}

    @property
    def mesh(self) -> Mesh | None:
        """Nodes and elements, where the model was read with them."""
        return self._recipe.mesh

    def with_group_factors(self, factors: Mapping[str, float]) -> Self:
        """The model as the code would give it with values of groups, by name, times factors.

        Exact also where matrices are polynomials in a value, as in a thickness. A factor that is not positive
        and an unknown group are an InvalidInputError.

        Examples
        --------
        >>> import numpy as np, antires_rs as ar
        >>> spring = np.array([[500.0]])
        >>> strip = ar.TermGroup("strip", "thickness", 0.002, ((0, 3),))
        >>> model = ar.MatrixModel(spring, [[1.0]], stiffness_terms={"strip^3": spring}, groups=[strip])
        >>> model.with_group_factors({"strip": 2.0}).stiffness().toarray()
        array([[4000.]])
        """
        stiffness, mass = powers_of(self.groups, factors)
        chosen = [Parameter("stiffness_factor", (term,), _ANY) for term in stiffness]
        chosen += [Parameter("mass_factor", (term,), _ANY) for term in mass]
        if not chosen:
            return self
        return self.with_parameters(chosen, [*stiffness.values(), *mass.values()])

    @property
    def group_factors(self) -> dict[str, float]:
        """Factors on the values of groups that updating, or :meth:`with_group_factors`, has applied.

        InvalidInputError where no one value of a group gives what its terms have.

        Examples
        --------
        >>> import numpy as np, antires_rs as ar
        >>> web = ar.TermGroup("web", "youngs_modulus", 2.1e11, ((0, 1),))
        >>> model = ar.MatrixModel(np.eye(1), np.eye(1), stiffness_terms={"web": np.eye(1)}, groups=[web])
        >>> model.with_parameters(ar.stiffness_reduction("web"), 0.25).group_factors
        {'web': 0.75}
        """
        sides = applied_factors(self.groups, self.description.applied)
        return {name: factor_of(group, sides) for name, group in self.groups.items()}

    def element_label(self, element: int) -> str:
        """Name of its stiffness term, or ``element 3`` where it has none."""
        names = self._recipe.stiffness_names
        return names[element] if names else super().element_label(element)

    def mass_label(self, term: int) -> str:
        """Name of the mass term, or ``mass 3`` where it has none."""
        names = self._recipe.mass_names
        return names[term] if names else super().mass_label(term)

    def dof(self, name: str) -> int:
        """Number of a dof from 0 by its name, in any spelling: ``"1204:Z"``, ``"1204+Z"``, ``"1204 UZ"``."""
        return self._names.find("name", name)

    def dof_label(self, dof: int) -> str:
        """Its name, or ``dof 3`` where it has none."""
        return _label(self._recipe.names, dof)

    @cached_property
    def _independent(self) -> Independent:
        return self._recipe.independent()

    def _dof(self, name: str, value: Any) -> int:
        dof, dependent = super()._dof(name, value), self._independent.dependent
        if dof in dependent.multipliers:
            got = f"{self.dof_label(dof)}, a Lagrange multiplier without mass or stiffness of its own"
            reject(name, got, "a dof of the structure", "Its row is an equation; name one of the other rows.")
        if dependent.has(dof) and not dependent.masters(dof):
            got = f"{self.dof_label(dof)}, which the constraints hold at zero"
            reject(name, got, "a dof that moves", "Name another dof, or mend the equations.")
        return dof

    @cached_property
    def _needs_both_methods(self) -> bool:
        if self.n_dof > _MOST_FOR_BOTH:
            return False
        k, m = self._recipe.stiffness.diagonal(self.n_dof), self._recipe.mass.diagonal(self.n_dof)
        moving = (k > 0.0) & (m > 0.0)
        rates = np.log10(k[moving]) - np.log10(m[moving])
        return bool(rates.size) and float(np.ptp(rates)) >= _APART

    def _core_for(self, dofs: Sequence[int]) -> tuple[CoreModel, list[int]]:
        here, core = self._independent, self._core
        moving = [here.dependent.moving_as(dof) for dof in dofs]
        if any(map(here.dependent.has, moving)):
            here, core = self._with_rows(frozenset(moving))
        return core, here.rows[moving].tolist()

    def _together(self, responses: Sequence[End], force: End) -> list[list[int]]:
        dependent = self._independent.dependent  # All dofs of one equation cannot be rows of one core.
        masters = {dof for one in members(force) for dof in dependent.masters(one)}
        apart = [any(dependent.has(dof) or dof in masters for dof in members(end)) for end in responses]
        own = [i for i, is_apart in enumerate(apart) if not is_apart]
        return ([own] if own else []) + [[i] for i in sorted({*range(len(responses))} - {*own})]

    def _with_rows(self, dofs: frozenset[int]) -> tuple[Independent, CoreModel]:
        """The same model with other dofs taken out than these; the last one is kept."""
        known = self.__dict__.get("_other")
        if known is None or known[0] != dofs:
            try:
                here = self._recipe.independent(dofs)
            except InvalidInputError as exc:
                got = f"{', '.join(map(self.dof_label, sorted(dofs)))} together, against {exc.argument}"
                wanted = "responses and forces of which none follows from the others"
                reject("dofs", got, wanted, "Ask for fewer of them, or leave one out of what is measured.")
            known = dofs, here, self._description.core(here.core())
            self._fill(_other=known)
        return known[1], known[2]

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in super().__getstate__().items() if name != "_other"}

    @property
    def n_dof(self) -> int:
        """Number of degrees of freedom, those that were taken out among them."""
        return self._recipe.n_dof

    @property
    def default_elements(self) -> list[int]:
        """Stiffness terms of which the equations leave something; of groups those of linear ones."""
        given, left = self._recipe.stiffness_terms, self._independent.matrices.stiffness_terms
        kept = [i for i, term in enumerate(left) if term.values.size or term is given[i]]
        powers = self._of_polynomials("stiffness_powers")
        return [i for i in kept if i not in powers]

    @property
    def _masses(self) -> list[int]:
        """Those of polynomials move together: one alone would leave an indefinite mass."""
        powers = self._of_polynomials("mass_powers")
        return [i for i in super()._masses if i not in powers]

    def _of_polynomials(self, side: str) -> set[int]:
        return {i for each in self._recipe.groups if not each.linear for i, _ in getattr(each, side)}

    @property
    def _free_dofs(self) -> list[int]:
        return np.flatnonzero(self._independent.rows >= 0).tolist()

    def _whole_shapes(self, shapes: FloatArray) -> FloatArray:
        here = self._independent
        if not here.dependent.dofs.size:
            return shapes
        whole = np.zeros((len(shapes), self.n_dof))
        whole[:, here.rows >= 0] = shapes
        return np.ascontiguousarray((here.dependent.transformation(self.n_dof) @ whole.T).T)

    def _matrix(self, columns: Columns) -> Any:
        """Rows of dofs that were taken out are empty."""
        from scipy.sparse import csc_array

        matrix, number = super()._matrix(columns), self._free_dofs
        if len(number) == self.n_dof:
            return matrix
        entries = matrix.tocoo()
        at = np.take(number, entries.row), np.take(number, entries.col)
        return csc_array((entries.data, at), shape=(self.n_dof, self.n_dof))

    def plot(self, values: Any = None, ax: Any = None, **options: Any) -> Any:
        """Draw the mesh; ``values`` and ``options`` as in :func:`antires_rs.figures.plot_mesh`."""
        return self._view("plot")(self, values, ax=ax, **options)

    def __repr__(self) -> str:
        gone = self._independent.dependent.dofs.size
        out = f", {gone} of them taken out" if gone else ""
        terms = f"{self._core.n_stiffness_terms} stiffness terms, {self._core.n_mass_terms} mass terms"
        return f"MatrixModel({self.n_dof} dofs{out}, {terms})"


def _terms(name: str, given: Any, n: int) -> tuple[tuple[str, ...], tuple[Entries, ...]]:
    """Names of terms, if they have any, and their entries."""
    named = isinstance(given, Mapping)
    items = given.items() if named else enumerate(given)
    terms = {key: as_term(part(name, key), term, n) for key, term in items}
    return tuple(map(str, terms)) if named else (), tuple(terms.values())


def _label(names: tuple[str, ...], dof: int) -> str:
    return names[dof] if names else f"dof {dof}"
