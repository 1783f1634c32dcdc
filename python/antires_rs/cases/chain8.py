"""The eight-mass chain of Meruane, J. Sound Vib. 332 (2013) 807-820, section 4.

Eight masses (559.3 g, then seven of 419.4 g) on seven springs of 56.7 kN/m, free at both ends, force at mass
0. The responses H_00 to H_70 have 7, 6, 5, 4, 3, 2, 1 and 0 antiresonances, 28 in all. (The paper counts
eight springs; the eighth would be one to ground.) In the damaged state spring 4, the fifth, has lost 55 %.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.chain import MassSpringChain
from ..models.parameters import mass_factor, stiffness_factor, stiffness_reduction
from ..signals.recording import Recording
from ..support.checks import FloatArray, finite_scalar, integer, random_generator
from ..updating.problem import DamagePenalty, UpdatingProblem

MASSES_KG = np.array([0.5593] + 7 * [0.4194])
SPRINGS_N_PER_M = np.full(7, 56.7e3)
DAMAGED_ELEMENT, SEVERITY = 4, 0.55  # zero-based element and stiffness loss of the damaged state, level 1
#: The test: sampling, length, and the modal damping of every mode.
FS_HZ, DURATION_S, DAMPING_RATIO = 512.0, 256.0, 0.01
#: Band of the identification: above the first dip's foot, beyond the last resonance at 115 Hz.
BAND_HZ = (3.0, 130.0)


class Chain8:
    """The chain with its virtual test. Build it with :func:`chain8`.

    Attributes
    ----------
    model : MassSpringChain
        The nominal model, the one to be updated.
    excitation, responses : int, list of int
        Dofs of the force, 0, and of the accelerometers, all eight.
    band_hz : (float, float)
        Band for the identification.
    """

    def __init__(self, perturbation: float, rng: Any) -> None:
        self.model = MassSpringChain(MASSES_KG, SPRINGS_N_PER_M)
        self.excitation = 0
        self.responses = list(range(8))
        self.band_hz = BAND_HZ
        level = finite_scalar("perturbation", perturbation, low=0.0, high=0.5)
        factors = 1.0 + level * random_generator(rng).uniform(-1.0, 1.0, 15)
        self._mass_factors, self._spring_factors = factors[:8], factors[8:]

    def true_model(self, level: int = 0) -> MassSpringChain:
        """The structure that is tested: ``level`` 0 undamaged, 1 with spring 4 at 55 % loss (the fifth)."""
        springs = SPRINGS_N_PER_M * self._spring_factors * self._intact(level)
        return MassSpringChain(MASSES_KG * self._mass_factors, springs)

    def truth(self, level: int = 0) -> dict[str, Any]:
        """True values: ``mass_factor``, ``stiffness_factor``, ``severity``, ``freq_hz`` by dof."""
        zeros = self.true_model(level).antiresonances(self.responses, self.excitation)
        return {
            "mass_factor": self._mass_factors.copy(),
            "stiffness_factor": self._spring_factors.copy(),
            "severity": {element: float(1.0 - s) for element, s in enumerate(self._intact(level))},
            "freq_hz": dict(zip(self.responses, zeros, strict=True)),
        }

    def exact(self, level: int = 0) -> AntiresonanceSet:
        """The true antiresonances, without a measurement."""
        return AntiresonanceSet(self.excitation, self.truth(level)["freq_hz"])

    def experiment(
        self,
        level: int = 0,
        *,
        noise: float = 0.0,
        duration_s: float = DURATION_S,
        damping_ratio: Any = DAMPING_RATIO,
        rng: int | np.random.Generator | None = None,
        progress: bool | None = None,
    ) -> Recording:
        """Record of a virtual test at 512 Hz: random force at mass 0, accelerations of all masses.

        ``noise`` is white sensor noise as a fraction of each channel's own rms.
        """
        test: dict[str, Any] = {"fs_hz": FS_HZ, "excitation": self.excitation, "responses": self.responses}
        test |= {"duration_s": duration_s, "damping_ratio": damping_ratio, "noise": noise}
        return self.true_model(level).simulate(**test, rng=rng, progress=progress)

    def exact_modes(self, level: int = 0) -> ModalSet:
        """The seven resonances and shapes of the undamped structure, rigid-body mode left out."""
        modes = self.true_model(level).modes()
        return ModalSet(modes.freq_hz[1:], modes.shapes[1:, self.responses], self.responses)

    def updating_problem(self, measured: AntiresonanceSet | ModalSet | None = None) -> UpdatingProblem:
        """Every mass and spring within 10 % of nominal; default: the exact antiresonances. A ModalSet is
        fitted too."""
        parameters = mass_factor(range(8), bounds=(0.9, 1.1)) + stiffness_factor(range(7), bounds=(0.9, 1.1))
        return UpdatingProblem(self.model, parameters, self.exact(0) if measured is None else measured)

    def damage_problem(
        self, measured: AntiresonanceSet | ModalSet | None = None, *, level: int = 1, elements: Any = None
    ) -> UpdatingProblem:
        """Losses of the springs, with the paper's penalties; default: exact values of ``level``, or a
        ModalSet."""
        chosen = stiffness_reduction(list(range(7) if elements is None else elements))
        targets = self.exact(level) if measured is None else measured
        return UpdatingProblem(self.model, chosen, targets, penalty=DamagePenalty())

    def search_problem(self, element: int, beta: float) -> UpdatingProblem:
        """Exact targets of this very model with one damage: for studies of optimizers only."""
        loss = finite_scalar("beta", beta, low=0.0, high=0.99)
        chosen = integer("element", element, low=0, high=6)
        springs = SPRINGS_N_PER_M * np.where(np.arange(7) == chosen, 1.0 - loss, 1.0)
        zeros = MassSpringChain(MASSES_KG, springs).antiresonances(self.responses, self.excitation)
        return self.damage_problem(AntiresonanceSet(self.excitation, dict(enumerate(zeros))))

    @staticmethod
    def _intact(level: int) -> FloatArray:
        loss = SEVERITY * integer("level", level, low=0, high=1)
        return 1.0 - np.where(np.arange(7) == DAMAGED_ELEMENT, loss, 0.0)

    def __repr__(self) -> str:
        return f"Chain8({self.model!r}, force at dof {self.excitation})"


def chain8(*, perturbation: float = 0.0, rng: int | np.random.Generator | None = None) -> Chain8:
    """The eight-mass chain, its virtual experiment and its truth.

    Parameters
    ----------
    perturbation : float
        The tested structure's masses and springs are drawn within this fraction of nominal, [0, 0.5]; 0
        tests the nominal chain (for damage), 0.08 suits updating.
    rng : int or numpy.random.Generator, optional
        Randomness of the draw.

    Returns
    -------
    Chain8

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> [len(f) for f in case.truth(level=1)["freq_hz"].values()]
    [7, 6, 5, 4, 3, 2, 1, 0]
    """
    return Chain8(perturbation, rng)
