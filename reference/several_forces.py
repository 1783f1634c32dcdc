"""Records of a chain under several uncorrelated forces, and what is found in them against exact roots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

import antires_rs as ar
from reference.deleted_pencils import antiresonances_hz
from reference.modal_structures import ModalStructure

#: A value this far from an exact one, as a share of it, is that one.
SAME = 0.01


def modal_record(structure, forces, duration_s, noise, rng):
    """Accelerations of a structure of modes under uncorrelated white forces at some of its sensors."""
    rng = np.random.default_rng(rng)
    n = int(duration_s * structure.fs_hz)
    freq = np.fft.rfftfreq(2 * n, 1.0 / structure.fs_hz)
    shape = (len(forces), freq.size)
    white = (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) * (freq > 0.0)
    modal = structure.oscillators(freq) * (structure.sensors[list(forces)].T @ white)
    x = np.fft.irfft(structure.sensors @ modal, 2 * n)[:, n // 2 : n // 2 + n]
    x += noise * x.std(axis=1, keepdims=True) * rng.standard_normal(x.shape)
    return ar.Recording(x, structure.fs_hz)


def modes_of(model, damping_ratio, band_hz, fs_hz):
    """A chain with all masses measured, by its modes; no place of a force is that of the structure."""
    stiffness, mass = (np.asarray(matrix) for matrix in (model.stiffness(), model.mass()))
    squares, shapes = scipy.linalg.eigh(stiffness, mass)
    freq_hz = np.maximum(np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi), 1e-3)
    damping = np.full(freq_hz.size, damping_ratio)
    return ModalStructure("chain", freq_hz, damping, shapes, shapes[0], shapes[:1], 0, band_hz, fs_hz)


def record_of(model, forces, duration_s, noise, rng, *, fs_hz=400.0, damping_ratio=0.01, levels=None):
    """Responses of all dofs to forces of their own spectra, ``levels`` the amplitude of each."""
    rng = np.random.default_rng(rng)
    how = {"fs_hz": fs_hz, "duration_s": duration_s, "damping_ratio": damping_ratio, "rng": rng}
    each = [model.simulate(excitation=place, **how).responses for place in forces]
    x = np.tensordot(np.ones(len(each)) if levels is None else np.asarray(levels), np.stack(each), 1)
    x = x + noise * x.std(axis=1, keepdims=True) * rng.standard_normal(x.shape)
    return ar.Recording(x, fs_hz)


@dataclass
class Verdict:
    """Counts over a set, deviations of what was found in stated standard deviations, and what was not."""

    there: int
    found: int
    false: int
    deviations: np.ndarray
    off: np.ndarray  # relative
    missed: list
    invented: list

    @property
    def held(self):
        """Share of the 90 % intervals that hold the exact value."""
        return float(np.mean(np.abs(self.deviations) < 1.645))


def verdict(zeros, stiffness, mass, band_hz):
    """What a set of several forces has of the exact roots; minors that are zero everywhere have none."""

    def exact(pair):
        found = antiresonances_hz(stiffness, mass, list(pair), list(zeros.excitation))
        return np.empty(0) if found is None else found

    return verdict_of(zeros, exact, band_hz)


def verdict_of(zeros, exact_of, band_hz, damped_of=None, held_of=None):
    """The same with exact roots by the set of responses; values at ``damped_of`` are not false either.

    ``held_of`` (rows, exact) has what intervals are to hold: of each exact value its zeros with damping, in
    rad/s. A value that is there twice has two: where as many are found each holds its own, else their mean.
    """
    low, high = band_hz
    there = found = 0
    deviations, off, missed, invented = [], [], [], []
    for pair, got in zeros.items():
        exact = exact_of(pair)
        inside = exact[(exact > low) & (exact < high)]
        there += inside.size
        with_damping = 2 * np.pi * inside[:, None] if held_of is None else held_of(pair, inside)
        for value, damped in zip(inside.tolist(), with_damping, strict=True):
            distance = np.abs(got / value - 1.0)
            if not distance.size or distance.min() > SAME:
                missed.append((pair, value))
                continue
            found, at = found + 1, int(distance.argmin())
            off.append(got[at] / value - 1.0)
            near = np.flatnonzero(distance <= SAME)
            each = near.size == len(damped)
            held = np.sort(np.abs(damped))[near.searchsorted(at)] if each else abs(np.mean(damped))
            deviations.append((got[at] - held / (2 * np.pi)) / zeros.tables[pair].std_hz[at])
        there_too = exact if damped_of is None else np.append(exact, damped_of(pair))
        invented += [(pair, f) for f in got.tolist() if np.abs(there_too / f - 1.0).min(initial=1.0) > SAME]
    return Verdict(there, found, len(invented), np.array(deviations), np.array(off), missed, invented)
