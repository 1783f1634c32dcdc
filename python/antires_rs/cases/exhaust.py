"""The exhaust with its virtual test: what a study of updating and damage needs, in one object."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.response_table import ResponseTable
from ..models.parameters import Parameter, angle, point_mass, stiffness_reduction, thickness, youngs_modulus
from ..models.structural_model import StructuralModel, simulate
from ..signals.recording import Recording
from ..support.checks import finite_scalar, integer
from ..support.progress import patient
from ..updating.problem import DamagePenalty, UpdatingProblem
from . import exhaust_geometry as geometry, exhaust_truth as experiment
from .exhaust_truth import Unfollowed, true_antiresonances, truth

#: Sampling, length of the record, and the force's band.
FS_HZ, DURATION_S, FORCE_HZ = 1024.0, 600.0, (1.0, 512.0)
#: Bands of the fit and of the damage study. Below are the rigid-body modes on the cords.
UPDATING_BAND_HZ, DAMAGE_BAND_HZ = (8.0, 180.0), (8.0, 260.0)
HELD_OUT = (2, 7, 10, 14)  # positions in the list of accelerometers that stay out of the updating fit
CANDIDATES = range(17, 47)  # candidates of the damage study: 17 to 46, which the paper counts as 18 to 47


class Exhaust:
    """The exhaust with its virtual test. Build it with :func:`exhaust`.

    Attributes
    ----------
    model : FrameModel
        The nominal model, the one to be updated: 48 nodes, 47 elements, 144 dofs.
    excitation, responses : int, list of int
        Dofs of the shaker and of the 16 accelerometers.
    held_out, fitted : list of int
        The 4 of them that stay out of the updating fit, and the other 12.
    updating_band_hz, damage_band_hz : (float, float)
        Bands of the two identifications.
    candidates, cracked_element : list of int, int
        Elements of the damage study, 17 to 46, and 30, behind the weld; the paper counts from 1.
    sections, masses, bends : list of str
        Names, in the order of the updating parameters.
    unfollowed : Unfollowed
        Errors of the model that no updating parameter follows.
    """

    def __init__(self, unfollowed: Unfollowed = experiment.USUAL) -> None:
        self.unfollowed = unfollowed
        self.model = geometry.nominal_model()
        self.excitation = self.model.dof(*geometry.SHAKER)
        self.responses = [self.model.dof(*sensor) for sensor in geometry.SENSORS]
        self.held_out = [self.responses[i] for i in HELD_OUT]
        self.fitted = [dof for dof in self.responses if dof not in self.held_out]
        self.updating_band_hz, self.damage_band_hz = UPDATING_BAND_HZ, DAMAGE_BAND_HZ
        self.candidates = list(CANDIDATES)
        self.cracked_element = experiment.CRACKED_ELEMENT
        self.sections = list(geometry.SECTIONS)
        self.masses = [name for name, *_ in geometry.MASSES]
        self.bends = [name for name, *_ in geometry.BENDS]

    @patient("recording the virtual test")
    def experiment(
        self,
        level: int = 0,
        *,
        noise: float = 0.01,
        duration_s: float = DURATION_S,
        rng: int | np.random.Generator | None = None,
        progress: bool | None = None,
    ) -> Recording:
        """Record of the virtual test at 1024 Hz: random force, accelerations of the 16 places, by dofs of
        ``model``.

        ``level`` 0 is undamaged, 1 to 3 a crack over 60, 70, 85 % of the perimeter; ``noise`` is white sensor
        noise as a fraction of each channel's own rms. The force is kept, unused by default.
        """
        tested = experiment.TestedStructure(self._level(level), self.unfollowed)
        # The slowest mode decides how long the lead-in is; each mode's own damping is in ``tested.frf``.
        test = float(tested.freq_hz[0]), FS_HZ, duration_s, experiment.RIGID_DAMPING, FORCE_HZ, noise, rng
        return simulate(tested, self.responses, self.excitation, *test, progress=progress)

    def truth(self, level: int = 0) -> dict[str, Any]:
        """What was tested, by name.

        ``thickness``, ``youngs_modulus``, ``point_mass``, ``inertia``, ``hanger`` (factors), ``unfollowed``,
        ``angle`` (degrees); ``crack_share``, ``equivalent_loss``, ``severity``; ``freq_hz`` by dof,
        ``resonances_hz`` and ``damping_ratio``.
        """
        return truth(self._level(level), self.responses, self.unfollowed)

    @staticmethod
    def _level(level: int) -> int:
        return integer("level", level, low=0, high=3)

    def exact(self, level: int = 0, *, band_hz: tuple[float, float] | None = None) -> AntiresonanceSet:
        """Antiresonances of the tested structure in a band (default: the damage band), without a test."""
        band, state = self.damage_band_hz if band_hz is None else band_hz, self._level(level)
        found = true_antiresonances(state, self.responses, band[1], self.unfollowed)
        return self._within(AntiresonanceSet(self.excitation, found), band)

    def updating_parameters(self) -> list[Parameter]:
        """The 21 of the updating study: wall thicknesses and moduli of 6 sections, 5 masses, 4 bends."""
        return [
            *thickness(self.sections, bounds=(0.75, 1.25), relative=True),
            *youngs_modulus(self.sections, bounds=(0.90, 1.10), relative=True),
            *point_mass(range(len(self.masses)), bounds=(0.75, 1.25), relative=True),
            *(angle(list(group), pivot, bounds_deg=(-8.0, 8.0)) for _, group, pivot in geometry.BENDS),
        ]

    def updating_problem(
        self,
        measured: AntiresonanceSet | None = None,
        *,
        held_out: Sequence[int] | None = None,
        band_hz: tuple[float, float] | None = None,
    ) -> UpdatingProblem:
        """Fit of the 21 parameters to the antiresonances of the accelerometers that are not held out.

        ``measured`` is by default what is exact of the undamaged structure; ``held_out`` is ``[]`` for the
        baseline of a damage study.
        """
        band = self.updating_band_hz if band_hz is None else band_hz
        out = self.held_out if held_out is None else held_out
        source = self.exact(0, band_hz=band) if measured is None else measured
        return UpdatingProblem(self.model, self.updating_parameters(), self._within(source, band, out))

    def damage_problem(
        self,
        measured: AntiresonanceSet | None = None,
        *,
        level: int = 1,
        elements: Any = None,
        model: StructuralModel | None = None,
    ) -> UpdatingProblem:
        """Stiffness losses with the paper's penalties. Default: the exact values of ``level``.

        ``model`` is the updated one, by default the nominal one, which is far from the tested structure.
        """
        source = self.exact(level) if measured is None else measured
        losses = stiffness_reduction(self.candidates if elements is None else list(elements))
        within, undamaged = self._within(source, self.damage_band_hz), model or self.model
        return UpdatingProblem(undamaged, losses, within, penalty=DamagePenalty())

    def search_problem(self, element: int, beta: float) -> UpdatingProblem:
        """Exact targets of the nominal model itself with one damage: for studies of optimizers only."""
        chosen = integer("element", element, low=0, high=len(self.model.elements) - 1)
        loss = finite_scalar("beta", beta, low=0.0, high=0.99)
        damaged = self.model.with_parameters(stiffness_reduction(chosen), loss)
        found = damaged.antiresonances(self.responses, self.excitation, f_max_hz=self.damage_band_hz[1])
        zeros = dict(zip(self.responses, found, strict=True))
        return self.damage_problem(AntiresonanceSet(self.excitation, zeros))

    @staticmethod
    def _within(
        values: AntiresonanceSet, band_hz: tuple[float, float], without: Sequence[int] = ()
    ) -> AntiresonanceSet:
        """The values of a band, with their damping and standard deviations, but for some dofs."""
        tables = {}
        for dof in (each for each in values if each not in without):
            inside = (band_hz[0] <= values[dof]) & (values[dof] <= band_hz[1])
            freq, damping, std = (column[inside] for column in values.columns(dof).values())
            tables[dof] = ResponseTable(freq, damping, std)
        own: dict[str, Any] = {"sees": values.sees, "channels": values.channels}
        return AntiresonanceSet.from_tables(values.excitation, tables, **own)

    def __repr__(self) -> str:
        return f"Exhaust({self.model!r}, force at {self.model.dof_name(self.excitation)})"


def exhaust(
    *,
    wall_scatter: float = experiment.USUAL.wall_scatter,
    joint_m: float = 0.0,
    shear_coefficient: float | str | None = None,
    cord_kg: float = 0.0,
) -> Exhaust:
    """A car's exhaust system, its virtual experiment and its truth.

    A documented surrogate of the second case of Meruane, J. Sound Vib. 332 (2013) 807-820: a plane frame of
    2.3 m x 0.45 m on soft cords, 47 beams, 5 lumped inertias, 144 dofs, 16 accelerometers, one shaker. The
    experiment comes from another, finer model, with a crack in the pipe at three levels.

    Parameters
    ----------
    wall_scatter : float
        Relative standard deviation of the wall thickness from one element's pipe to the next; [0, 0.1].
    joint_m : float
        Flexibility of the joints at catalyst, mufflers and flange: that of so many metres of pipe; [0, 0.2].
    shear_coefficient : 'cowper' or float, optional
        The tested pipe as Timoshenko beams; the model's are Euler-Bernoulli beams.
    cord_kg : float
        Mass of each of three cords that the model does not have, with 1500 N/m across; [0, 1]. No updating
        parameter follows any of these four.

    Returns
    -------
    Exhaust

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.exhaust()
    >>> case.model
    FrameModel(plane, 48 nodes, 47 elements, 144 dofs)
    >>> [round(100 * case.truth(level)["equivalent_loss"], 1) for level in (1, 2, 3)]
    [88.1, 93.4, 97.3]
    """
    return Exhaust(Unfollowed(wall_scatter, joint_m, shear_coefficient, cord_kg))
