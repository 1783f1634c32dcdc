"""What a result says of how sure its parameters are: intervals, profiles, and chi-square."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.pickling import ReadOnly
from ..support.validation import FloatArray
from .fit import fitted
from .intervals import intervals
from .parameter_intervals import Method, ParameterIntervals
from .profile import ProfileLikelihood, profile

if TYPE_CHECKING:
    from .problem import UpdatingProblem

__all__ = ["WithIntervals"]


class WithIntervals(ReadOnly):
    """A result with a problem and the parameters ``x`` that solve it."""

    problem: UpdatingProblem
    x: FloatArray

    @property
    def interval(self) -> dict[Any, tuple[float, float]]:
        """90 % interval of each parameter by name: the quick answer of :meth:`intervals`."""
        return self._quick.interval

    @cached_property
    def _quick(self) -> ParameterIntervals:
        return intervals(self.problem, self.x, progress=False)

    @cached_property
    def chi_square(self) -> float:
        """Reduced chi-square of the least-squares residuals by their stated errors; NaN where none are."""
        return fitted(self.problem, self.x).chi_square

    def intervals(
        self,
        method: Method = "laplace",
        *,
        level: float = 0.9,
        draws: int = 1000,
        rng: int | np.random.Generator | None = 0,
        workers: int | None = None,
        progress: bool | None = None,
    ) -> ParameterIntervals:
        """Intervals of the parameters, with draws of their posterior.

        Uniform within the bounds before the test; Gaussian errors with the ``std_hz`` of the measured values,
        and an error of the model that the residuals tell. Where no errors are stated, one error of all
        is learned. Around the least-squares solution near ``x``.

        Parameters
        ----------
        method : {'laplace', 'ensemble'}
            Quick, with residuals linear around the solution; or sure, with the residuals that the model has:
            some ten thousand evaluations. Both stay in the valley that the search found.
        level : float
            Probability of each interval, within [0.5, 0.999].
        draws : int
            At least 50.
        rng : int or numpy.random.Generator, optional
            The same seed gives the same bits for any number of ``workers``.
        workers : int, optional
            Threads of the ensemble; all processors by default.
        progress : bool, optional
            Show progress on standard error; by default on a terminal, after one second.

        Returns
        -------
        ParameterIntervals

        Raises
        ------
        InvalidInputError
            A method, level or number out of range.

        Examples
        --------
        >>> import antires_rs as ar
        >>> true = ar.MassSpringChain([2.0, 1.0, 1.0], [550.0, 480.0])
        >>> hz = dict(enumerate(true.antiresonances([0, 1, 2], 0)))
        >>> measured = ar.AntiresonanceSet(0, hz, std_hz={dof: 1e-3 * f for dof, f in hz.items()})
        >>> nominal = ar.MassSpringChain([2.0, 1.0, 1.0], [500.0, 500.0])
        >>> problem = ar.UpdatingProblem(nominal, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), measured)
        >>> found = ar.update(problem, rng=0).intervals("ensemble", draws=200)
        >>> low, high = found["stiffness of spring 0"]
        >>> low < 1.1 < high, found.words
        (True, ('two-sided', 'two-sided'))
        """
        return intervals(
            self.problem,
            self.x,
            method=method,
            level=level,
            draws=draws,
            rng=rng,
            workers=workers,
            progress=progress,
        )

    def profile(
        self, name: str, *, level: float = 0.9, points: int = 21, progress: bool | None = None
    ) -> ProfileLikelihood:
        """Profile likelihood of one parameter: the others are fitted again at ``points`` of its values.

        For parameters on a bound, and those that the data hardly tell; ``kind`` says whether both sides
        close. An unknown name is an ``InvalidInputError``.
        """
        return profile(self.problem, self.x, name, level=level, points=points, progress=progress)
