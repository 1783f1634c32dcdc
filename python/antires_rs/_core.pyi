"""Types of the private Rust module."""

from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]
_Term = tuple[NDArray[np.uint32], NDArray[np.uint32], _Floats]
_Progress = Callable[[dict[str, Any]], bool | None]

__all__ = ["AntiresonanceObjective", "Model", "__version__", "island_options", "minimize"]

__version__: str

@final
class Model:
    @staticmethod
    def chain(
        masses_kg: _Floats,
        springs_n_per_m: _Floats,
        ground_first_n_per_m: float,
        ground_last_n_per_m: float,
    ) -> Model: ...
    @staticmethod
    def from_matrices(
        stiffness: _Floats,
        mass: _Floats,
        stiffness_terms: Sequence[_Term],
        mass_terms: Sequence[_Term],
    ) -> Model: ...
    @property
    def n_dof(self) -> int: ...
    @property
    def n_stiffness_terms(self) -> int: ...
    @property
    def n_mass_terms(self) -> int: ...
    def stiffness(self) -> _Floats: ...
    def mass(self) -> _Floats: ...
    def modes(self) -> tuple[_Floats, _Floats]: ...
    def frf(
        self,
        responses: Sequence[int],
        excitation: int,
        freq_hz: _Floats,
        damping_ratio: _Floats,
        kind: str,
    ) -> NDArray[np.complex128]: ...
    def antiresonances(
        self,
        responses: Sequence[int],
        excitation: int,
        f_max_hz: float,
        method: str,
        include_cancelled: bool,
    ) -> list[tuple[_Floats, bool]]: ...

@final
class AntiresonanceObjective:
    def __new__(
        cls,
        model: Model,
        parameters: Sequence[tuple[str, Sequence[int]]],
        targets: Sequence[tuple[int, int, _Floats]],
        misfit: str,
        penalty: tuple[float, float] | None,
        snap: float,
        weights: _Floats | None,
    ) -> AntiresonanceObjective: ...
    def cost(self, x: _Floats) -> float: ...
    def repaired(self, x: _Floats) -> _Floats: ...
    def pairs(self, x: _Floats) -> _Floats: ...
    def model_at(self, x: _Floats) -> Model: ...
    def evaluate_many(self, candidates: _Floats, threads: int) -> _Floats: ...
    def minimize(
        self,
        lower: _Floats,
        upper: _Floats,
        guesses: Sequence[Sequence[float]],
        options: dict[str, Any],
        seed: int,
        threads: int,
        max_seconds: float | None,
        on_progress: _Progress | None,
    ) -> dict[str, Any]: ...

def minimize(
    function: Callable[[_Floats], _Floats],
    lower: _Floats,
    upper: _Floats,
    guesses: Sequence[Sequence[float]],
    options: dict[str, Any],
    seed: int,
    max_seconds: float | None,
    on_progress: _Progress | None,
) -> dict[str, Any]: ...
def island_options(options: dict[str, Any]) -> dict[str, Any]: ...
