"""Records of the structures of reference/outside_structures.py, whose zeros are exact."""

from __future__ import annotations

import numpy as np
import scipy.linalg

import antires_rs as ar
from reference.measured_reality import MEASURED, ambient
from reference.modal_structures import MODES_TO, ModalStructure
from reference.outside_structures import Own, State, Structure

#: Samples a cycle at the upper end of the band; damping ratios of the modes.
RATE, DAMPING = 4.0, (0.005, 0.015)


def damping_drawn(rng: np.random.Generator) -> np.ndarray:
    """Of as many modes as any of them has."""
    return rng.uniform(*DAMPING, 200)


def modes_of(structure: Structure, own: Own, state: State, damping: np.ndarray) -> ModalStructure:
    """A state by its modes, each with its damping."""
    one, (_, high) = structure.assembled(own, state), structure.band_hz
    square, shapes = scipy.linalg.eigh(one.stiffness, one.mass)
    freq = np.sqrt(np.maximum(square, 0.0)) / (2.0 * np.pi)
    kept = freq < MODES_TO * high
    driven = {node for node, _ in structure.drive}
    beside = [one.vector({dof: 1.0}) for dof in one.rows if dof[0] in driven]
    sensors = [one.vector(structure.sensor(at, at == state.moved)) for at in range(len(structure.dofs))]
    return ModalStructure(
        name=structure.name,
        freq_hz=freq[kept],
        damping=np.resize(damping, int(kept.sum())),
        sensors=np.array(sensors) @ shapes[:, kept],
        force=one.vector(structure.drive) @ shapes[:, kept],
        beside=np.array(beside) @ shapes[:, kept],
        driven=structure.dofs.index(structure.force),
        band_hz=structure.band_hz,
        fs_hz=RATE * high,
    )


def recorded(
    structure: Structure, own: Own, state: State, damping: np.ndarray, rng: np.random.Generator
) -> ar.Recording:
    """Accelerations under the noise of a shaker, with everything that is wrong with measured ones."""
    made = ambient(modes_of(structure, own, state, damping), MEASURED, int(rng.integers(2**31)))
    return ar.Recording(made.samples, made.fs_hz, dofs=structure.dofs)
