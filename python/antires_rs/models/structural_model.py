"""What every structural model can do: modes, frequency responses, antiresonances, virtual tests.

A thin, typed wrapper over the Rust core, which owns the matrices, the eigenproblems and the antiresonances.
SI units; degrees of freedom zero-based.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..exceptions import NumericalError
from ..measured.modal_set import ModalSet
from ..support.progress import interruptible
from ..support.validation import choice, finite_scalar, integer, part, real_array, reject, shape_of
from .described import Described
from .doubts import warn_doubts, warn_modes_left_out
from .memory import check_room_for_all_modes

if TYPE_CHECKING:
    from ..signals.recording import Recording
    from ..support.validation import ComplexArray, FloatArray

__all__ = ["StructuralModel"]

#: From here on antiresonances may take seconds.
MANY_DOFS = 200

Method = Literal["modal", "pencil"]
Motion = Literal["accelerance", "mobility", "receptance"]


class StructuralModel(Described):
    """What every model can do.

    Build a :class:`MassSpringChain`, a :class:`FrameModel` or a :class:`MatrixModel`.
    """

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
            ``freq_hz`` (n_modes,) ascending, ``shapes`` (n_modes, n_dof). Rigid-body modes at 0 Hz.

        Raises
        ------
        InvalidInputError
            No mode up to ``f_max_hz``.
        NumericalError
            K and M share a motion with neither mass nor stiffness, or one of them is indefinite; all modes of
            more dofs than there is memory for.

        Warns
        -----
        AntiresWarning
            Without a limit: modes of dofs joined to no other, too far above the lowest for double precision,
            are left out.

        Examples
        --------
        >>> import antires_rs as ar
        >>> ar.MassSpringChain([1.0, 1.0], [500.0]).modes().freq_hz.round(3)
        array([0.   , 5.033])
        """
        most = None if n_modes is None else integer("n_modes", n_modes, low=1)
        limit = None if f_max_hz is None else finite_scalar("f_max_hz", f_max_hz, low=0.0, unit="Hz")
        if limit is None and most is None:
            check_room_for_all_modes(self.n_dof)
        freq, shapes = self._core.modes(limit, most)
        if np.isnan(freq).any():
            raise NumericalError(
                "modes of (K, M)",
                f"the stiffness is indefinite, so that {np.isnan(freq).sum()} motion(s) grow without bound, "
                f"most at {self._most_moved(shapes[:, np.isnan(freq)])}. Check its signs, or with geometric "
                "stiffness whether the load is beyond buckling; antiresonances are still found.",
            )
        if limit is None and most is None:
            whole: Any = self  # every kind of model has these matrices
            warn_modes_left_out(freq, whole.stiffness(), whole.mass(), self.dof_label)
        keep = int(np.count_nonzero(freq[:most] <= (np.inf if limit is None else limit)))
        if limit is not None and keep == 0:
            reject(
                "f_max_hz",
                f"{limit:g} Hz",
                f"at least the first resonance, {freq[0]:.6g} Hz",
                "Raise it, or leave it out for all modes.",
            )
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

        Raises
        ------
        InvalidInputError
            A dof outside the model, a negative frequency or damping, an unknown kind.

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
            reject(
                "freq_hz",
                f"{freq.min():g} Hz",
                "no negative frequency",
                "Pass the positive half of the axis.",
            )
        choice("kind", kind, ("accelerance", "mobility", "receptance"))
        dofs, force = self._dofs("response", response), self._dof("excitation", excitation)
        damping = self._damping(damping_ratio)
        values = np.empty((len(dofs), freq.size), dtype=np.complex128)
        for which in self._together(dofs, force):
            core, at = self._core_for([*(dofs[i] for i in which), force])
            values[which] = core.frf(at[:-1], at[-1], freq, damping, kind)
        return values[0] if shape_of(response) == () else values

    def antiresonances(
        self,
        response: int | str | Sequence[int | str],
        excitation: int | str,
        *,
        f_max_hz: float | None = None,
        method: Method = "modal",
        include_cancelled: bool = False,
        bounds: bool = False,
    ) -> Any:
        r"""Antiresonant frequencies: positive real roots of ``det(K_ik - w**2 M_ik) = 0``.

        Row ``i`` (the response) and column ``k`` (the excitation) are deleted.

        Parameters
        ----------
        response : int, str or sequence of them
            Response dof(s), by number or name.
        excitation : int or str
            Dof of the force.
        f_max_hz : float, optional
            Highest frequency wanted; all by default, but of more than 2,000 dofs, where it has to be given.
        method : {'modal', 'pencil'}
            ``'modal'`` takes one symmetric eigenproblem for all responses and brackets the zeros of the
            modal series, with proof that none is missed; ``'pencil'`` solves each deleted pencil by QZ, and
            adds what QZ cannot tell from zero but the matrices confirm. Both return the same set.
        include_cancelled : bool
            Return also the roots that coincide with a resonance which response or excitation does not
            see (residue below 1e-12 of the largest). The FRF shows no dip there.
        bounds : bool
            Return also how far each may be from the root of the matrices as given. Up to 400 dofs both
            methods are then used, and what only one of them finds counts if the matrices confirm it.

        Returns
        -------
        ndarray, (n,)
            Hz, ascending; with ``bounds`` a pair of arrays (n,), frequencies and bounds of their errors in
            Hz, infinite for one that is not certain: it lies too close to others to be told from them, or
            rounding of the entries moves it by more than 1e-3 in frequency squared. A list for a sequence of
            responses.
            Dropped are roots that are
            infinite or zero at working precision (an ulp of K and M moves them by more than 1e-3 of their own
            distance from there), negative, or complex (imaginary part above 1e-9 of the modulus, or above
            ten times that uncertainty, at most 3e-7). Every QZ root is checked to a backward error of 1e-10
            (3e-7 within 1e-6 of another), or polished on the matrices.

        Raises
        ------
        InvalidInputError
            A dof outside the model, an unknown method, or a large model without a limit.
        NumericalError
            An eigenproblem that cannot be solved.

        Warns
        -----
        AntiresWarning
            The response is not connected to the excitation: H is identically zero; or rounding leaves a doubt
            about the number of roots, which only models of up to 2,000 dofs can settle; with ``bounds``, some
            roots are not certain.

        Notes
        -----
        A bound is of first order in the rounding of K and M,
        :math:`c\,\epsilon\,|v|^T(|K| + \omega^2 |M|)|u| / |v^T M u|` in frequency squared, with the null
        vectors u and v (Stewart & Sun, Matrix Perturbation Theory, 1990, section VI.2).

        Examples
        --------
        >>> import antires_rs as ar
        >>> chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 500.0])
        >>> [zeros.round(3).tolist() for zeros in chain.antiresonances([0, 1, 2], 0)]
        [[1.666, 5.375], [2.516], []]
        >>> freq_hz, error_hz = chain.antiresonances(1, 0, bounds=True)
        >>> bool(0.0 < error_hz[0] < 1e-12)
        True
        """
        choice("method", method, ("modal", "pencil"))
        limit = (
            np.inf
            if f_max_hz is None
            else finite_scalar("f_max_hz", f_max_hz, low=0.0, low_open=True, unit="Hz")
        )
        dofs = self._dofs("response", response)
        force = self._dof("excitation", excitation)
        found: list[Any] = [None] * len(dofs)
        for which in self._together(dofs, force):
            own = self._core_as_given if bounds else self._core_exactly
            core, at = own([*(dofs[i] for i in which), force])
            asked = (at[:-1], at[-1], limit, method, bool(include_cancelled))
            solved = (
                core.bounded_antiresonances if bounds or self._needs_both_methods else core.antiresonances
            )
            call = partial(solved, *asked)
            roots: Any = (
                call()
                if self.n_dof < MANY_DOFS
                else interruptible(call, f"antiresonances of {len(which)} responses")
            )
            for i, of_one in zip(which, roots, strict=True):
                found[i] = of_one
        for dof, (*values, is_zero, is_doubtful) in zip(dofs, found, strict=True):
            warn_doubts(dof, excitation, self.n_dof, values, is_zero=is_zero, is_doubtful=is_doubtful)
        zeros = [(values[0], values[1]) if bounds else values[0] for *values, _, _ in found]
        return zeros[0] if shape_of(response) == () else zeros

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
        excitation : int or str
            Dof of the force.
        fs_hz : float
            Sampling rate.
        duration_s : float
            Length of the record.
        damping_ratio : float or array_like, (n_modes,)
            Modal damping ratio.
        band_hz : (float, float), optional
            Band of the force; all up to half the sampling rate by default.
        noise : float
            Standard deviation of white sensor noise, as a fraction of each channel's own rms.
        responses : sequence of int or str, optional
            Dofs of the accelerometers; all by default.
        rng : int or numpy.random.Generator, optional
            Randomness.
        progress : bool, optional
            A line on standard error after a second; by default on a terminal and in a notebook.

        Returns
        -------
        Recording
            Accelerations (n_responses, n_samples) of a unit-rms force, which is kept in ``.force``.
            Synthesised in the frequency domain over a longer record: no integration error, not periodic.

        Raises
        ------
        InvalidInputError
            A rate or duration that is not positive, a band above half the rate, a dof outside the model.

        Examples
        --------
        >>> import antires_rs as ar
        >>> chain = ar.MassSpringChain([1.0, 1.0], [500.0])
        >>> chain.simulate(excitation=0, fs_hz=50.0, duration_s=10.0, damping_ratio=0.01, rng=0)
        Recording(2 channels, 10 s at 50 Hz, dofs=(0, 1), with force)
        """
        from .simulation import simulate

        dofs = self._free_dofs if responses is None else self._dofs("responses", responses)
        self._damping(damping_ratio)
        elastic = [f for f in self._core.modes()[0] if f > 0]
        return simulate(
            self,
            responses=dofs,
            excitation=self._dof("excitation", excitation),
            fs_hz=fs_hz,
            duration_s=duration_s,
            damping_ratio=damping_ratio,
            lowest_hz=min(elastic, default=0.0),
            band_hz=band_hz,
            noise=noise,
            rng=rng,
            progress=progress,
        )

    def _most_moved(self, shapes: FloatArray) -> str:
        """Names of the dofs that move most in some shapes (n, m)."""
        whole = np.abs(self._whole_shapes(shapes.T))
        return ", ".join(map(self.dof_label, dict.fromkeys(np.nan_to_num(whole).argmax(axis=1).tolist())))

    def _dof(self, name: str, value: Any) -> int:
        """Number of a dof that is given by its number or its name."""
        if isinstance(value, str):
            return self._names.find(name, value)
        return integer(name, value, low=0, high=self.n_dof - 1)

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
