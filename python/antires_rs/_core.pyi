"""Types of the private Rust module."""

from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from .optimize.checkpoint import Checkpoint

_Floats = NDArray[np.float64]
_Complexes = NDArray[np.complex128]
_Term = tuple[NDArray[np.uint32], NDArray[np.uint32], _Floats]
_Columns = tuple[NDArray[np.int64], NDArray[np.int64], _Floats]
_Section = tuple[str, list[float], float, float, float]
_Row = tuple[list[int], str | None, list[float]]
_Parameter = tuple[str, list[int], bool, tuple[int, tuple[float, float, float]] | None]
_Progress = Callable[[dict[str, Any]], bool | None]

__all__ = [
    "Frame", "Model", "Objective", "PreparedTables", "PreparedTest", "__version__", "align", "associate",
    "check_bounds", "dominant_pairs", "follow", "forsythe_basis_at", "hermitian_values", "island_options",
    "minimize", "nominal_values", "refined_roots",
]  # fmt: skip

__version__: str

@final
class Model:
    @staticmethod
    def chain(
        masses_kg: _Floats, springs_n_per_m: _Floats, ground_first_n_per_m: float, ground_last_n_per_m: float
    ) -> Model: ...
    @staticmethod
    def from_matrices(
        n_dof: int,
        stiffness: _Term,
        mass: _Term,
        stiffness_terms: Sequence[_Term],
        mass_terms: Sequence[_Term],
    ) -> Model: ...
    @staticmethod
    def from_frame(frame: Frame) -> Model: ...
    def at(self, parameters: Sequence[_Parameter], x: _Floats) -> Model: ...
    def frame(self) -> Frame | None: ...
    @property
    def n_dof(self) -> int: ...
    @property
    def n_stiffness_terms(self) -> int: ...
    @property
    def n_mass_terms(self) -> int: ...
    def stiffness_terms(self) -> list[_Term]: ...
    def mass_terms(self) -> list[_Term]: ...
    def stiffness(self) -> _Columns: ...
    def mass(self) -> _Columns: ...
    def modes(self, f_max_hz: float | None = None, n_modes: int | None = None) -> tuple[_Floats, _Floats]: ...
    def n_modes(self) -> int: ...
    def frf(
        self, responses: Sequence[int], excitation: int, freq_hz: _Floats, damping_ratio: _Floats, kind: str
    ) -> NDArray[np.complex128]: ...
    def antiresonances(
        self, responses: Sequence[int], excitation: int, f_max_hz: float, method: str, include_cancelled: bool
    ) -> list[tuple[_Floats, bool, bool]]: ...
    def bounded_antiresonances(
        self, responses: Sequence[int], excitation: int, f_max_hz: float, method: str, include_cancelled: bool
    ) -> list[tuple[_Floats, _Floats, bool, bool]]: ...

@final
class Frame:
    def __new__(
        cls,
        nodes_m: _Floats,
        references: _Floats | None,
        sections: Sequence[_Section],
        elements: Sequence[tuple[str, list[_Row]]],
        fixed: Sequence[tuple[int, str]],
        shear: Sequence[list[float] | None] | None = None,
    ) -> Frame: ...
    def nodes_m(self) -> _Floats: ...
    def sections(self) -> list[_Section]: ...
    def elements(self, argument: str) -> list[_Row]: ...
    def dof(self, node: int, direction: str) -> int: ...
    def dof_names(self) -> list[tuple[int, str]]: ...
    def parts(self) -> list[int]: ...

@final
class Objective:
    @staticmethod
    def antiresonance(
        model: Model,
        parameters: Sequence[_Parameter],
        targets: Sequence[tuple[int, int, _Floats, str | None, int]],
        misfit: str,
        penalty: tuple[float, float] | None,
        snap: float,
        weights: _Floats | None,
    ) -> Objective: ...
    @staticmethod
    def modal(
        model: Model,
        parameters: Sequence[_Parameter],
        modes: Sequence[tuple[_Floats, Sequence[int], NDArray[np.complex128]]],
        misfit: str,
        penalty: tuple[float, float] | None,
        snap: float,
        weights: _Floats | None,
    ) -> Objective: ...
    def cost(self, x: _Floats) -> float: ...
    def repaired(self, x: _Floats) -> _Floats: ...
    def pairs(self, x: _Floats) -> tuple[_Floats, tuple[_Floats, _Floats] | None]: ...
    def cost_and_pairs(self, x: _Floats) -> tuple[float, _Floats]: ...
    def residuals(self, x: _Floats) -> _Floats | None: ...
    def linearized(self, x: _Floats) -> tuple[float, _Floats, _Floats] | None: ...
    def states(
        self, candidates: _Floats, with_slopes: bool, threads: int, from_hz: float = 0.0, to_hz: float = ...
    ) -> list[tuple[NDArray[np.uint32], _Floats, _Floats, _Floats]]: ...
    def null_vectors(
        self, x: _Floats, from_hz: float, to_hz: float
    ) -> tuple[NDArray[np.uint32], _Floats, _Floats, _Floats, _Floats, _Floats]: ...
    def modal_states(
        self, candidates: _Floats, with_slopes: bool, threads: int
    ) -> list[tuple[_Floats, _Floats, _Floats, _Floats]]: ...
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
        checkpoint: Checkpoint | None,
        start: Sequence[float] | None = None,
    ) -> dict[str, Any]: ...

@final
class PreparedTables:
    def __new__(
        cls,
        levels: _Floats,
        response: NDArray[np.intp],
        seen: NDArray[np.bool_],
        old: NDArray[np.bool_],
        intact: _Floats,
        there: NDArray[np.bool_],
        place: _Floats,
        beside: _Floats,
        by_own: _Floats,
        slopes: NDArray[np.float32],
        crossed: NDArray[np.float32],
        errors: NDArray[np.float32],
        spread: _Floats,
        new_variance: float,
    ) -> PreparedTables: ...

@final
class PreparedTest:
    def __new__(
        cls,
        tables: PreparedTables,
        response: Sequence[int],
        log_f: Sequence[float],
        std: Sequence[float],
        set: Sequence[int],
        times: Sequence[float],
        band: tuple[float, float],
        common: float,
        extra: float,
        errors: Sequence[tuple[float, float, float]],
        outside: float,
    ) -> PreparedTest: ...
    def look(
        self, elements: Sequence[int], u: Sequence[float]
    ) -> tuple[float, _Floats, _Floats, int, NDArray[np.intp], _Floats, _Floats, _Floats, float]: ...
    def scan(
        self, elements: Sequence[int], u: Sequence[float], further: Sequence[int]
    ) -> tuple[_Floats, _Floats]: ...
    def refine(
        self, sets: Sequence[tuple[Sequence[int], Sequence[float]]], steps: int
    ) -> list[tuple[list[float], float]]: ...
    def settle(
        self, sets: Sequence[tuple[Sequence[int], Sequence[float]]], looks: int, rests: float
    ) -> list[tuple[list[float], list[float], list[float], list[float], float, float]]: ...

def align(cost: _Floats, alone_row: _Floats, alone_column: _Floats) -> NDArray[np.intp]: ...
def associate(
    response: NDArray[np.intp],
    log_f: _Floats,
    std: _Floats,
    root_response: NDArray[np.intp],
    root_log_f: _Floats,
    root_std: _Floats,
    alone: float,
    alone_root: _Floats,
) -> NDArray[np.intp]: ...
def follow(
    response: NDArray[np.intp],
    log_f: _Floats,
    response_after: NDArray[np.intp],
    log_f_after: _Floats,
    born: float,
) -> NDArray[np.intp]: ...
def minimize(
    function: Callable[[_Floats], tuple[_Floats, str | None]],
    lower: _Floats,
    upper: _Floats,
    guesses: Sequence[Sequence[float]],
    options: dict[str, Any],
    seed: int,
    max_seconds: float | None,
    on_progress: _Progress | None,
    checkpoint: Checkpoint | None,
) -> dict[str, Any]: ...
def island_options(options: dict[str, Any]) -> dict[str, Any]: ...
def nominal_values(model: Model, parameters: Sequence[_Parameter]) -> _Floats: ...
def check_bounds(model: Model, parameters: Sequence[_Parameter], lower: _Floats, upper: _Floats) -> None: ...
def forsythe_basis_at(points: _Complexes, b: _Floats) -> _Complexes: ...
def refined_roots(coefficients: _Floats, b: _Floats, start: _Complexes) -> _Complexes | None: ...
def hermitian_values(matrices: _Complexes, scale: _Floats) -> _Floats: ...
def dominant_pairs(matrices: _Complexes, scale: _Floats) -> tuple[_Floats, _Floats, _Complexes]: ...
