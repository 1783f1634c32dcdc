"""What every structural model can do: modes, frequency responses, antiresonances, virtual tests."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, ClassVar, Literal, Self, get_args

import numpy as np

from .._core import Model as CoreModel
from ..exceptions import NumericalError, part, reject
from ..measured.modal_set import ModalSet
from ..signals.recording import Recording
from ..support.checks import (
    ComplexArray,
    FloatArray,
    choice,
    finite_scalar,
    frequency_band,
    integer,
    members,
    random_generator,
    real_array,
    shape_of,
)
from ..support.directions import DofNames, point_of
from ..support.messages import some, warn
from ..support.progress import interruptible, patient, step
from ..support.values import AroundCore, Value
from .matrices import Columns, as_sparse, check_room_for_all_modes
from .parameters import MOVES, OF_SECTIONS, AppliedParameters, CoreParameter, Parameter, parameter_tuple
from .recipes import ChainRecipe, FrameRecipe, MatrixRecipe
from .term_groups import in_groups

# -- One description of a model, by which it is built, copied, pickled and saved, to the same bits

Recipe = ChainRecipe | MatrixRecipe | FrameRecipe


@dataclass(frozen=True, eq=False)
class ModelDescription(Value):
    """What a model is: what its constructor was given, and what each updating since applied, in order."""

    recipe: Recipe
    applied: tuple[AppliedParameters, ...] = ()

    def core_parameters(self, parameters: Iterable[Parameter]) -> list[CoreParameter]:
        """Parameters as the core takes them, the names of sections resolved, none listed twice."""
        parts: list[CoreParameter] = []
        acting: list[Any] = []
        for p in parameters:
            if p.quantity in OF_SECTIONS and isinstance(self.recipe, MatrixRecipe):
                parts.append(in_groups(self.recipe.groups, p, self.applied))
                acting += [("value", name) for name in p.terms]
                continue
            about = (p.pivot or 0, p.axis) if p.quantity in MOVES else None
            named = p.quantity in OF_SECTIONS
            indices = [self.recipe.section_index(term) if named else term for term in p.terms]
            parts.append((p.quantity, indices, p.relative, about))
            # Several angles, lengths and positions may move one node.
            acting += [(p.quantity, about, tuple(indices))] if about else [(p.quantity, i) for i in indices]
        twice = {pair for pair in acting if acting.count(pair) > 1}
        if twice:
            got = f"{sorted(twice)} more than once"
            reject("parameters", got, "each quantity of a term once", "Leave one of the two parameters out.")
        return parts

    def core(self, made: CoreModel | None = None) -> CoreModel:
        """The core's model, from nothing but this description, or from what its recipe ``made``."""
        core = self.recipe.core() if made is None else made
        for nth, applied in enumerate(self.applied):
            before = replace(self, applied=self.applied[:nth])
            core = core.at(before.core_parameters(applied.parameters), applied.values)
        return core


# -- What the core leaves in doubt about antiresonances and modes, in words

_EDGE = 1e-6  # relative distance from which on a mode is above the highest one found


def _warn_doubts(
    dof: End, excitation: Any, n_dof: int, uncertain: Sequence[float], zero: bool, doubtful: bool
) -> None:
    """Say whether H is zero, whether roots may be missing, and which (by their bounds) are not certain."""
    response = f"response dof{'s' * isinstance(dof, tuple)} {', '.join(map(str, members(dof)))}"
    if zero and isinstance(dof, tuple):
        text = f"the minor with forces at {', '.join(map(str, excitation))} is identically zero: not every "
        text += "force has a way of its own through the structure to a response. It has no antiresonance."
        warn("not_connected", f"{response}: {text}")
    elif zero:
        text = f"is not connected to excitation dof {excitation}: H is identically zero and has no "
        warn("not_connected", f"{response} {text}antiresonance.")
    if doubtful:
        text = f"{response}: rounding hides whether antiresonances of it are missing or double; with {n_dof} "
        text += "dofs only other units or fewer digits between the stiffest and the softest part would tell."
        warn("hidden_by_rounding", text)
    if len(uncertain):
        named = some(f"{f:.6g}" for f in uncertain)
        text = f"{response}: {named} Hz are not certain: too close to others to be told from them, or moved "
        warn("uncertain_roots", text + "too far by the rounding of K and M.")


def _warn_modes_left_out(freq_hz: FloatArray, stiffness: Any, mass: Any, label: Callable[[int], str]) -> None:
    """Name dofs joined to no other whose modes are not among all modes found: too far above the lowest."""
    from scipy.sparse import csc_array

    k, m = csc_array(stiffness), csc_array(mass)
    joined = np.zeros(k.shape[0], dtype=bool)
    for matrix in (k.tocoo(), m.tocoo()):
        joined[matrix.row[(matrix.row != matrix.col) & (matrix.data != 0.0)]] = True
    own, of_mass = k.diagonal(), m.diagonal()
    alone = np.flatnonzero(~joined & (own > 0.0) & (of_mass > 0.0))
    hz = np.sqrt(own[alone] / of_mass[alone]) / (2.0 * np.pi)
    out = hz > (1.0 + _EDGE) * float(freq_hz.max(initial=0.0))
    if out.any():
        named = some(label(int(dof)) for dof in alone[out])
        text = f"modes at {named}, from {hz[out].min():.6g} Hz on, are left out: they lie too far above the "
        text += f"lowest, {freq_hz[0]:.6g} Hz, for double precision. Models of these dofs alone have them."
        warn("modes_left_out", text)


MANY_DOFS = 200  # from so many dofs on antiresonances may take seconds

#: A dof, or several: the forces that act together, or the responses of a minor.
End = int | tuple[int, ...]
_MOST_FORCES = 4

Method = Literal["modal", "pencil"]
Motion = Literal["accelerance", "mobility", "receptance"]


# -- A model and its description: how it is built, copied and changed, and what its parts are called


class StructuralModel(AroundCore[CoreModel]):
    """What a :class:`MassSpringChain`, a :class:`FrameModel` and a :class:`MatrixModel` can do."""

    _recipe_type: ClassVar[tuple[type, ...] | type] = ()  # what this class is built from
    _description: ModelDescription

    def _build(self, description: ModelDescription, core: CoreModel | None = None) -> None:
        self._fill(_description=description, _core=description.core() if core is None else core)

    def _made_core(self) -> CoreModel:
        return self._description.core()

    @property
    def _recipe(self) -> Any:
        return self._description.recipe

    @property
    def description(self) -> ModelDescription:
        """What the model was made of and the parameters applied since: all that a copy or a file needs."""
        return self._description

    @classmethod
    def from_description(cls, description: ModelDescription) -> Self:
        """Build a model of this class from its :attr:`description`, to the same bits."""
        recipe = getattr(description, "recipe", description)
        if not isinstance(recipe, cls._recipe_type):
            got, wanted = type(recipe).__name__, f"the description of a {cls.__name__}"
            reject("description", got, wanted, "Take it from .description of a model of that class.")
        model = object.__new__(cls)
        model._build(description)
        return model

    def with_parameters(self, parameters: Any, values: Any) -> Self:
        """The model with parameters applied, as an updating leaves it; this one stays as it is.

        ``values``, (n,), one for each parameter in its unit, are not held to the bounds. A parameter that
        changes nothing, or a value that leaves no structure, is an InvalidInputError.

        Examples
        --------
        >>> import antires_rs as ar
        >>> chain = ar.MassSpringChain([1.0, 2.0], [500.0])
        >>> chain.with_parameters(ar.stiffness_reduction(0), 0.4).stiffness()
        array([[ 300., -300.],
               [-300.,  300.]])
        """
        chosen, before = self._by_number(parameter_tuple(parameters)), self._description
        wanted = f"an array ({len(chosen)},), one value for each parameter"
        vector = np.atleast_1d(real_array("values", values, ndim=None, wanted=wanted))
        if vector.shape != (len(chosen),):
            got = f"an array of shape {np.shape(values)}"
            reject("values", got, wanted, "Give a value for each parameter, in their order.")
        model = object.__new__(type(self))
        after = ModelDescription(before.recipe, (*before.applied, AppliedParameters(chosen, vector)))
        model._build(after, self._core.at(before.core_parameters(chosen), vector))
        return model

    def _by_number(self, parameters: tuple[Parameter, ...]) -> tuple[Parameter, ...]:
        """Parameters whose terms are numbers where they were names of terms."""
        index, numbered = self._recipe.term_index, []
        for one in parameters:
            if one.quantity not in OF_SECTIONS and any(isinstance(term, str) for term in one.terms):
                terms = (index(one.quantity, term) if isinstance(term, str) else term for term in one.terms)
                one = replace(one, terms=tuple(terms))
            numbered.append(one)
        return tuple(numbered)

    def _core_for(self, dofs: Sequence[int]) -> tuple[CoreModel, list[int]]:
        """The core's model in which ``dofs`` are rows, and these rows."""
        return self._core, list(dofs)

    @property
    def _needs_both_methods(self) -> bool:
        """Whether only poles and QZ together, each root confirmed, are right: few dofs, K / M far apart."""
        return False

    @property
    def _middle_is_lost(self) -> bool:
        """Whether the stiffest dof has no digit of the stiffness of the middle one."""
        k = np.abs(self.stiffness().diagonal())
        return bool(np.finfo(np.float64).eps * k.max() > 0.1 * np.median(k[k > 0.0])) if k.any() else False

    def _together(self, responses: Sequence[End], force: End) -> list[list[int]]:
        """Places of responses that one core has with the force, core by core."""
        return [list(range(len(responses)))]

    def _roots(
        self,
        responses: Sequence[End],
        force: End,
        solve: Callable[[CoreModel, list[list[int]], list[int]], Any],
    ) -> list[Any]:
        """What ``solve`` gives for each response, of the core in which all dofs are rows."""
        found: list[Any] = [None] * len(responses)
        for which in self._together(responses, force):
            ends = [members(responses[i]) for i in which]
            core, rows = self._core_for([*(dof for own in ends for dof in own), *members(force)])
            at, r = iter(rows), len(members(force))
            own_rows = [[next(at) for _ in own] for own in ends]
            for i, of_one in zip(which, solve(core, own_rows, rows[len(rows) - r :]), strict=True):
                found[i] = of_one
        return found

    @property
    def n_dof(self) -> int:
        """Number of degrees of freedom."""
        return self._core.n_dof

    def element_label(self, element: int) -> str:
        """Name of stiffness term ``element`` in tables and pictures, with its number as an argument."""
        return f"element {element}"

    def element(self, name: str) -> int:
        """Number of a stiffness term by its name, where the model names them."""
        number: int = self._recipe.term_index("stiffness_factor", name)
        return number

    def dof_label(self, dof: int) -> str:
        """Name of a dof in tables and pictures: its zero-based number, where nothing else names it."""
        return f"dof {dof}"

    @cached_property
    def _names(self) -> DofNames:
        return DofNames(self._dof_labels())

    def _dof_labels(self) -> list[str]:
        """:meth:`dof_label` of all dofs."""
        return [self.dof_label(dof) for dof in range(self.n_dof)]

    @property
    def _free_dofs(self) -> list[int]:
        """Those that are not taken out of the matrices."""
        return list(range(self.n_dof))

    @property
    def _sensor_dofs(self) -> list[int]:
        """Where an accelerometer may be: all of these but rotations, where names tell them."""
        points = map(point_of, self._dof_labels())
        turning = {dof for dof, point in enumerate(points) if point is not None and abs(point[1]) > 3}
        return [dof for dof in self._free_dofs if dof not in turning]

    def mass_label(self, term: int) -> str:
        """Name of mass term ``term`` in tables, with its number as an argument."""
        return f"mass {term}"

    @property
    def default_elements(self) -> list[int]:
        """Stiffness terms that :func:`assess_damage` looks at unless told otherwise."""
        return list(range(self._core.n_stiffness_terms))

    @property
    def _springs(self) -> list[int]:
        """Stiffness terms that have a stiffness."""
        return self.default_elements

    @property
    def _masses(self) -> list[int]:
        """Mass terms of which each may have a factor of its own."""
        return list(range(self._core.n_mass_terms))

    def stiffness(self) -> Any:
        """Stiffness matrix, (n, n), N/m, as ``scipy.sparse.csc_array``, of a chain as ``ndarray``.

        Fixed dofs of a frame have no row, those that a MatrixModel has taken out an empty one.
        """
        return self._matrix(self._core.stiffness())

    def mass(self) -> Any:
        """Mass matrix, (n, n), kg, as :meth:`stiffness`."""
        return self._matrix(self._core.mass())

    def _matrix(self, columns: Columns) -> Any:
        return as_sparse(columns)

    def modes(self, n_modes: int | None = None, f_max_hz: float | None = None) -> ModalSet:
        """Undamped resonances and mass-normalised shapes.

        Parameters
        ----------
        n_modes : int, optional
            Keep the lowest ``n_modes``.
        f_max_hz : float, optional
            Keep those up to this frequency. With either, slender models are solved by bands.

        Returns
        -------
        ModalSet
            ``freq_hz`` (n_modes,) ascending, ``shapes`` (n_modes, n_dof). Rigid-body modes at 0 Hz. Without a
            limit, modes of dofs joined to no other, too far above the lowest for double precision, are left
            out with a warning.

        Raises
        ------
        InvalidInputError
            No mode up to ``f_max_hz``.
        NumericalError
            K and M share a motion with neither mass nor stiffness, or one is indefinite; all modes of more
            dofs than there is memory for.

        Examples
        --------
        >>> import antires_rs as ar
        >>> ar.MassSpringChain([1.0, 1.0], [500.0]).modes().freq_hz.round(3)
        array([0.   , 5.033])
        """
        most = None if n_modes is None else integer("n_modes", n_modes, low=1)
        limit = None if f_max_hz is None else finite_scalar("f_max_hz", f_max_hz, low=0.0, unit="Hz")
        every = limit is None and most is None
        if every:
            check_room_for_all_modes(self.n_dof)
        freq, shapes = self._core.modes(limit, most)
        if np.isnan(freq).any():
            moved = np.nan_to_num(np.abs(self._whole_shapes(shapes[:, np.isnan(freq)].T))).argmax(axis=1)
            named = ", ".join(map(self.dof_label, dict.fromkeys(moved.tolist())))
            why = (
                f"the stiffness is indefinite, so that {np.isnan(freq).sum()} motion(s) grow without bound, "
                f"most at {named}. Check its signs, or with geometric stiffness whether the load is beyond "
                "buckling; antiresonances are still found."
            )
            raise NumericalError("modes of (K, M)", why)
        if every:
            _warn_modes_left_out(freq, self.stiffness(), self.mass(), self.dof_label)
        keep = int(np.count_nonzero(freq[:most] <= (np.inf if limit is None else limit)))
        if limit is not None and keep == 0:
            wanted = f"at least the first resonance, {freq[0]:.6g} Hz"
            remedy = "Raise it, or leave it out for all modes; check the units."
            reject("f_max_hz", f"{limit:g} Hz", wanted, remedy)
        return ModalSet(freq[:keep], self._whole_shapes(shapes[:, :keep].T), dofs=range(self.n_dof))

    def frf(
        self,
        response: int | str | Sequence[int | str],
        excitation: int | str,
        freq_hz: Any,
        *,
        damping_ratio: Any,
        kind: Motion = "accelerance",
    ) -> ComplexArray:
        r"""Frequency response by modal superposition.

        .. math:: H_{ik}(\omega) = \sum_r \frac{\phi_{ir}\phi_{kr}}{\omega_r^2 - \omega^2
                  + 2 j \zeta_r \omega_r \omega}

        Parameters
        ----------
        response : int, str or sequence of them
            Response dof(s), by number or name.
        excitation : int or str
            Dof of the force.
        freq_hz : array_like, (n_freq,)
            Frequencies in Hz, not negative.
        damping_ratio : float or array_like, (n_modes,)
            Modal damping ratio, one for all modes or one each; 0.01 is 1 %.
        kind : {'accelerance', 'mobility', 'receptance'}
            Acceleration, velocity or displacement over force.

        Returns
        -------
        ndarray of complex
            (n_freq,) for one response, (n_responses, n_freq) for a sequence.

        Notes
        -----
        Ewins, Modal Testing, 2nd ed. (2000), section 2.4.

        Examples
        --------
        >>> import antires_rs as ar
        >>> chain = ar.MassSpringChain([1.0, 1.0], [500.0])
        >>> abs(chain.frf(0, 0, [3.5588], damping_ratio=0.01)).round(3)   # its antiresonance
        array([0.014])
        """
        freq = real_array("freq_hz", freq_hz, ndim=1, wanted="an array (n_freq,) of frequencies in Hz")
        if freq.min() < 0:
            reject("freq_hz", f"{freq.min():g} Hz", "no negative frequency", "Pass the positive half axis.")
        choice("kind", kind, get_args(Motion))
        dofs, force = self._dofs("response", response), self._dof("excitation", excitation)
        damping = self._damping(damping_ratio)
        values = np.empty((len(dofs), freq.size), dtype=np.complex128)
        for which in self._together(dofs, force):
            core, at = self._core_for([*(dofs[i] for i in which), force])
            values[which] = core.frf(at[:-1], at[-1], freq, damping, kind)
        return values[0] if shape_of(response) == () else values

    def antiresonances(
        self,
        response: int | str | Sequence[int | str] | Sequence[End | Sequence[int | str]],
        excitation: int | str | Sequence[int | str],
        *,
        f_max_hz: float | None = None,
        method: Method = "modal",
        include_cancelled: bool = False,
        bounds: bool = False,
    ) -> Any:
        r"""Antiresonant frequencies: positive real roots of ``det(K_ik - w**2 M_ik) = 0``.

        Row ``i`` (the response) and column ``k`` (the excitation) are deleted. Of r forces that act at once,
        antiresonances of order r: roots of the minor ``det H[I, J]`` of r responses I and the r forces J,
        where the rows I and the columns J are deleted.

        Parameters
        ----------
        response : int, str or sequence of them
            Response dof(s), by number or name. Of several forces the r responses, or a list of such tuples.
        excitation : int, str or sequence of them
            Dof of the force, or the dofs of two to four forces.
        f_max_hz : float, optional
            Highest frequency wanted; all by default, but of more than 2,000 dofs, where it has to be given.
        method : {'modal', 'pencil'}
            One symmetric eigenproblem for all responses, and the zeros of the modal series bracketed with
            proof that none is missed; or QZ of each deleted pencil. Both return the same set.
        include_cancelled : bool
            Return also the roots on a resonance which response or excitation does not see (residue below
            1e-12 of the largest). The FRF shows no dip there.
        bounds : bool
            Return also how far each may be from the root of the matrices as given, to first order in their
            rounding (Stewart & Sun, Matrix Perturbation Theory, 1990, section VI.2). Up to 400 dofs both
            methods are then used, and what only one of them finds counts if the matrices confirm it.

        Returns
        -------
        ndarray, (n,)
            Hz, ascending, a list of them for a sequence of responses, or of tuples; with ``bounds`` a pair of
            arrays (n,), frequencies and bounds of their errors in Hz, infinite where a root is not certain:
            too close to others, moved by more than 1e-3 in frequency squared by rounding of the entries, or
            hidden by it in a model of which one dof is so stiff that the middle one has no digit beside it.
            Dropped are roots that are infinite or zero at working precision (an ulp of K and M moves them by
            more than 1e-3 of their own distance from there), negative, or complex (imaginary part above 1e-9
            of the modulus, or above ten times that uncertainty, at most 3e-7).

        Raises
        ------
        InvalidInputError
            No such dof; of several forces: not as many responses, one of them twice, more than four forces.

        Warns
        -----
        AntiresWarning
            The response is not connected to the excitation, or the minor is identically zero; rounding leaves
            a doubt about the number of roots, which only models of up to 2,000 dofs can settle; some roots
            are not certain.

        Examples
        --------
        >>> import antires_rs as ar
        >>> chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 500.0])
        >>> [zeros.round(3).tolist() for zeros in chain.antiresonances([0, 1, 2], 0)]
        [[1.666, 5.375], [2.516], []]
        >>> forces = (0, 2)  # both at once
        >>> [zeros.round(3).tolist() for zeros in chain.antiresonances([(0, 2), (1, 2)], forces)]
        [[5.033], []]
        """
        choice("method", method, get_args(Method))
        limit = np.inf
        if f_max_hz is not None:
            limit = finite_scalar("f_max_hz", f_max_hz, low=0.0, low_open=True, unit="Hz")
        dofs, force, is_one = self._ends(response, excitation)
        both = bounds or self._needs_both_methods

        def solve(core: CoreModel, rows: list[list[int]], forces: list[int]) -> Any:
            call = partial(core.antiresonances, rows, forces, limit, method, bool(include_cancelled), both)
            what = f"antiresonances of {len(rows)} responses"
            return call() if self.n_dof < MANY_DOFS else interruptible(call, what)

        zeros = []
        for dof, found in zip(dofs, self._roots(dofs, force, solve), strict=True):
            freq_hz, error_hz, is_zero, is_doubtful = found
            if bounds and is_doubtful and self._middle_is_lost:  # a bound of first order says nothing there
                error_hz = np.full_like(error_hz, np.inf)
            uncertain = freq_hz[np.isinf(error_hz)] if both else []
            _warn_doubts(dof, excitation, self.n_dof, uncertain, is_zero, is_doubtful)
            zeros.append((freq_hz, error_hz) if bounds else freq_hz)
        return zeros[0] if is_one else zeros

    def simulate(
        self,
        *,
        excitation: int | str,
        fs_hz: float,
        duration_s: float,
        damping_ratio: Any,
        band_hz: tuple[float, float] | None = None,
        noise: float = 0.0,
        responses: Sequence[int | str] | None = None,
        rng: int | np.random.Generator | None = None,
        progress: bool | None = None,
    ) -> Recording:
        """Record the accelerations of a virtual test under one random force.

        Parameters
        ----------
        excitation, damping_ratio
            As of :meth:`frf`.
        fs_hz, duration_s : float
            Sampling rate, and length of the record.
        band_hz : (float, float), optional
            Band of the force; all up to half the sampling rate by default.
        noise : float
            Standard deviation of white sensor noise, as a fraction of each channel's own rms.
        responses : sequence of int or str, optional
            Dofs of the accelerometers; all by default.
        rng : int or numpy.random.Generator, optional
        progress : bool, optional
            A line on standard error after a second; by default on a terminal and in a notebook.

        Returns
        -------
        Recording
            Accelerations (n_responses, n_samples) of a unit-rms force, which is kept in ``.force``,
            synthesised in the frequency domain over a longer record: no integration error, not periodic.

        Examples
        --------
        >>> import antires_rs as ar
        >>> chain = ar.MassSpringChain([1.0, 1.0], [500.0])
        >>> chain.simulate(excitation=0, fs_hz=50.0, duration_s=10.0, damping_ratio=0.01, rng=0)
        Recording(2 channels, 10 s at 50 Hz, dofs=(0, 1), with force)
        """
        self._damping(damping_ratio)
        dofs = self._free_dofs if responses is None else self._dofs("responses", responses)
        lowest_hz = min((f for f in self._core.modes()[0] if f > 0), default=0.0)
        if shape_of(excitation) != ():
            remedy = "Simulate one record for each force, with rng= of its own, and add their responses."
            reject("excitation", excitation, "one dof", remedy)
        force = self._dof("excitation", excitation)
        test = fs_hz, duration_s, damping_ratio, band_hz, noise, rng
        return simulate(self, dofs, force, lowest_hz, *test, progress=progress)

    def _dof(self, name: str, value: Any) -> int:
        """Number of a dof that is given by its number or its name."""
        if isinstance(value, str):
            return self._names.find(name, value)
        if isinstance(value, int | np.integer) and value >= self.n_dof:
            remedy = f"The model has {self.n_dof} dofs; a set with more belongs to another model."
            reject(name, value, f"an integer in 0..{self.n_dof - 1}", remedy)
        return integer(name, value, low=0, high=self.n_dof - 1)

    def _end(self, name: str, value: Any) -> End:
        """A dof, or several, each by its number or name, ascending."""
        if not isinstance(value, list | tuple | np.ndarray):
            return self._dof(name, value)
        return tuple(sorted(self._dof(name, dof) for dof in value))

    def _ends(self, response: Any, excitation: Any) -> tuple[list[End], End, bool]:
        """Responses and force, or sets of responses and forces, and whether one of them was asked for."""
        if shape_of(excitation) == ():
            force = self._dof("excitation", excitation)
            return [*self._dofs("response", response)], force, shape_of(response) == ()
        forces = _distinct("excitation", self._dofs("excitation", excitation))
        r = len(forces)
        if r > _MOST_FORCES:
            wanted = f"at most {_MOST_FORCES} forces that act at once"
            reject("excitation", f"{r} dofs", wanted, "Ask for fewer of them.")
        given = [response] if shape_of(response) == () else list(response)
        is_one = all(shape_of(one) == () for one in given)
        ends: list[End] = []
        for nth, one in enumerate([given] if is_one else given):
            name = "response" if is_one else part("response", nth)
            dofs = _distinct(name, self._dofs(name, [one] if shape_of(one) == () else one))
            if len(dofs) != r:
                remedy = "An antiresonance of order r belongs to r responses and r forces."
                got = f"{len(dofs)} response{'s' * (len(dofs) != 1)} for {r} force{'s' * (r != 1)}"
                reject(name, got, "as many responses as forces", remedy)
            ends.append(tuple(dofs) if r > 1 else dofs[0])
        return ends, tuple(forces) if r > 1 else forces[0], is_one

    def _whole_shapes(self, shapes: FloatArray) -> FloatArray:
        """Shapes (n_modes, n_dof) with the motion of dofs that are taken out."""
        return shapes

    def _dofs(self, name: str, value: Any) -> list[int]:
        if shape_of(value) == ():
            return [self._dof(name, value)]
        values = [self._dof(part(name, i), v) for i, v in enumerate(value)]
        if not values:
            reject(name, "an empty sequence", "at least one dof", "Name the dofs, counted from 0.")
        return values

    def _damping(self, value: Any) -> FloatArray:
        check_room_for_all_modes(self.n_dof)
        n_modes = self._core.n_modes()
        wanted = f"one damping ratio of at least 0, or {n_modes} of them, one for each mode"
        ratio = np.atleast_1d(real_array("damping_ratio", value, ndim=None, wanted=wanted))
        if ratio.ndim != 1 or ratio.size not in (1, n_modes) or ratio.min() < 0:
            reject("damping_ratio", value, wanted, "Give one ratio for all modes, or one for each.")
        return ratio


def _distinct(name: str, dofs: list[int]) -> list[int]:
    twice = [dof for dof in dofs if dofs.count(dof) > 1]
    if twice:
        reject(name, f"dof {twice[0]} twice", "distinct dofs", "Leave one of the two out.")
    return dofs


def checked_model(model: Any) -> StructuralModel:
    """A model of ours."""
    if not isinstance(model, StructuralModel):
        wanted = "a MassSpringChain, FrameModel or MatrixModel"
        reject("model", model, wanted, "Build the model as one of these first.")
    return model


# -- Virtual experiments: what accelerometers would record on a model under a random force
#
# The response is synthesised in the frequency domain over a record longer than asked for, and a window is cut
# out of its middle: an exact sample of the stationary response, and not periodic, so that an analysis meets
# the leakage of a real test. (A zero-order-hold time integration would report 2.6 % damping for 0.51 %.)

#: Time constants 1 / (zeta omega) that the lead-in must cover; its samples that fit some hundred MB.
_TIME_CONSTANTS, _LONGEST_LEAD_IN = 8.0, 4_000_000
_MOST_SAMPLES = 1e10  # more samples than this of one channel fit no memory


@patient("recording the virtual test")
def simulate(
    model: Any,
    responses: list[int],
    excitation: int,
    lowest_hz: float,
    fs_hz: float,
    duration_s: float,
    damping_ratio: Any,
    band_hz: tuple[float, float] | None = None,
    noise: float = 0.0,
    rng: int | np.random.Generator | None = None,
    *,
    progress: bool | None = None,
) -> Recording:
    """Record accelerations under a band-limited random force; see ``MassSpringChain.simulate``."""
    rate = finite_scalar("fs_hz", fs_hz, low=0.0, low_open=True, unit="Hz")
    duration = finite_scalar("duration_s", duration_s, low=0.0, low_open=True, unit="s")
    if not 2 <= duration * rate < _MOST_SAMPLES:
        got = f"{duration:g} s, {duration * rate:.3g} samples at {rate:g} Hz"
        remedy = "Lengthen the record." if duration * rate < 2.0 else "Shorten the record, or lower the rate."
        reject("duration_s", got, f"2 to {_MOST_SAMPLES:.0g} samples", remedy)
    samples = round(duration * rate)
    level, random = finite_scalar("noise", noise, low=0.0), random_generator(rng)
    low, high = (0.0, rate / 2)
    if band_hz is not None:
        low, high = frequency_band("band_hz", band_hz, low_hz=0.0, high_hz=rate / 2)

    total = samples + 2 * (lead := _lead_in(samples, rate, lowest_hz, damping_ratio))
    freq_hz = np.fft.rfftfreq(total, 1.0 / rate)
    inside = (freq_hz >= low) & (freq_hz <= high) & (freq_hz > 0.0)
    if not inside.any():
        wanted = f"a band wider than the resolution of {rate / total:.3g} Hz"
        reject("band_hz", f"({low:g}, {high:g}) Hz without any spectral line", wanted, "Record longer.")
    spectrum = np.zeros(freq_hz.size, dtype=np.complex128)
    spectrum[inside] = random.standard_normal((int(inside.sum()), 2)) @ np.array([1.0, 1.0j])
    force = np.fft.irfft(spectrum, total)
    spectrum /= force.std()  # A unit-rms force: absolute levels mean nothing to a ratio of responses.
    force /= force.std()
    window = slice(lead, lead + samples)
    records = np.empty((len(responses), samples))
    for row, dof in enumerate(responses):
        step(f"response {row + 1} of {len(responses)}")
        transfer = np.zeros(freq_hz.size, dtype=np.complex128)
        transfer[inside] = model.frf(dof, excitation, freq_hz[inside], damping_ratio=damping_ratio)
        records[row] = np.fft.irfft(transfer * spectrum, total)[window]
    rms: FloatArray = records.std(axis=1, keepdims=True)
    records += level * rms * random.standard_normal(records.shape)
    return Recording(records, rate, dofs=responses, force=force[window])


def _lead_in(samples: int, rate: float, lowest_hz: float, damping_ratio: Any) -> int:
    """Samples before and after the window, long enough that its ends do not see each other."""
    least = float(np.min(np.asarray(damping_ratio, dtype=float)))
    if not (lowest_hz > 0.0 and least > 0.0):
        return samples // 2  # nothing rings, or nothing ever stops ringing
    memory = _TIME_CONSTANTS / (2 * np.pi * lowest_hz * least) * rate
    if memory > _LONGEST_LEAD_IN:
        mode = f"the slowest mode ({lowest_hz:.3g} Hz, damping ratio {least:.3g})"
        cut = f"the lead-in is cut to {_LONGEST_LEAD_IN / rate:.3g} s and that mode is not quite stationary"
        warn("lead_in_cut", f"{mode} remembers {memory / rate:.3g} s; {cut} in the record.")
    return int(min(memory, _LONGEST_LEAD_IN)) + 1
