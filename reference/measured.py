"""Measured structures with the dips that an eye finds in them, and how many of these a set of values has.

Three published measurements, where they are there (``ANTIRES_DATA``, else ``../shared/data``): eight columns
of an intact cantilever plate, a three-storey frame under a force at each floor, a replica of another on a
shaking base. A dip is a line of an FRF lower than all within 5 %, with both flanks ``CLEAR_DB`` above it in
that range; it knows nothing of rational functions. A value without even a faint dip (``FAINT_DB`` within 3 %)
beside it is false.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import antires_rs as ar

DATA = Path(os.environ.get("ANTIRES_DATA", Path(__file__).resolve().parents[1].parent / "shared" / "data"))
CLEAR_DB, CLEAR_WITHIN = 12.0, 0.05
FAINT_DB, FAINT_WITHIN = 3.0, 0.03
#: A value belongs to a dip this near.
NEAR = 0.01
#: Columns 9 row + col of the plate's grid, away from its clamped edge.
PLATE_COLUMNS = tuple(9 * row + col for row in (0, 2, 4, 6) for col in (2, 6))


@dataclass(frozen=True)
class Measured:
    """FRFs of one excitation, and the band in which they are fair."""

    name: str
    frfs: ar.FrequencyResponse
    excitation: object
    band_hz: tuple[float, float]


def structures():
    """Those that are there."""
    made = []
    plate = DATA / "iqs_plates" / "00A_Ref_1.MAT"
    if plate.is_file():
        from scipy.io import loadmat

        table = loadmat(plate)["MEscope1"]
        freq = 0.5 * np.arange(len(table))
        keep = slice(1, int(600 / 0.5))
        values = np.asarray(table[keep, list(PLATE_COLUMNS)].T, dtype=complex)
        frfs = ar.FrequencyResponse(freq[keep], values, dofs=list(PLATE_COLUMNS))
        made.append(Measured("plate", frfs, "shaker", (100.0, 480.0)))
    for floor, name in enumerate(("Experimental.csv", "test_2.csv", "test_3.csv")):
        path = DATA / "southampton_3storey" / name
        if path.is_file():
            table = np.loadtxt(path, delimiter=";", dtype=complex)
            frfs = ar.FrequencyResponse(table[:, 0].real, table[:, 1:].T)
            made.append(Measured("Southampton frame", frfs, floor, (5.0, 32.0)))
    replica = DATA / "iqs_3storey" / "frf.npz"
    if replica.is_file():
        with np.load(replica) as file:
            table = file[file.files[0]]
        freq = 0.0625 * np.arange(len(table))
        frfs = ar.FrequencyResponse(freq[1:], table[1:, :4].T)
        made.append(Measured("three-storey replica", frfs, 0, (10.0, 95.0)))
    return made


def dips_hz(freq, curve, band_hz, least_db, within):
    """Lines of ``curve`` in the band that are lowest within a share of their frequency, between flanks."""
    level = 20.0 * np.log10(np.maximum(np.abs(curve), 1e-300))
    found = []
    for i in np.flatnonzero((freq >= band_hz[0]) & (freq <= band_hz[1])):
        lines = max(4, int(within * freq[i] / (freq[1] - freq[0])))
        left, right = level[max(i - lines, 0) : i + 1], level[i : i + lines + 1]
        lowest = min(left.min(), right.min()) >= level[i]
        if lowest and min(left.max(), right.max()) - level[i] >= least_db:
            found.append(freq[i])
    return np.array(found)


@dataclass(frozen=True)
class Counted:
    """Clear dips, those of them that have a value, values, and values without a dip."""

    clear: int = 0
    found: int = 0
    values: int = 0
    false: int = 0

    def __add__(self, other):
        return Counted(
            self.clear + other.clear,
            self.found + other.found,
            self.values + other.values,
            self.false + other.false,
        )

    def __str__(self):
        return f"{self.found}/{self.clear}, {self.false} of {self.values} false"


def counted(measured, values):
    """``values`` (Hz by dof) against the dips of the same FRFs."""
    total = Counted()
    freq = measured.frfs.freq_hz
    for dof, curve in zip(measured.frfs.dofs, measured.frfs.values, strict=True):
        own = np.asarray(values[dof], dtype=float)
        clear = dips_hz(freq, curve, measured.band_hz, CLEAR_DB, CLEAR_WITHIN)
        faint = dips_hz(freq, curve, measured.band_hz, FAINT_DB, FAINT_WITHIN)
        total += Counted(
            clear.size,
            sum(bool(own.size) and np.abs(own / f - 1.0).min() <= NEAR for f in clear),
            own.size,
            sum(not faint.size or np.abs(faint / f - 1.0).min() > NEAR for f in own),
        )
    return total


#: Columns 9 row + col of the plates' grid that are read well, and their reference for transmissibilities.
COLUMNS = tuple(9 * row + col for row in (0, 2, 4, 6) for col in (0, 2, 4, 6, 8))
REFERENCE = 40
STATES = ("00A_Ref_1", "00A_Ref_2", "00A_Ref_3", "27A_C60", "29A_C140", "36A_S3")


def plate(state, columns=COLUMNS):
    """FRFs of some columns of one state of the plates."""
    from scipy.io import loadmat

    table = loadmat(DATA / "iqs_plates" / f"{state}.MAT")["MEscope1"]
    keep = slice(1, 1600)
    values = np.asarray(table[keep, list(columns)].T, dtype=complex)
    frfs = ar.FrequencyResponse(0.5 * np.arange(len(table))[keep], values, dofs=list(columns))
    return Measured(state, frfs, "shaker", (100.0, 480.0))


def as_transmissibilities(frfs, reference):
    """The same numbers over those of one row."""
    values = frfs.values / frfs.values[frfs.dofs.index(reference)]
    return ar.FrequencyResponse(
        frfs.freq_hz, values, dofs=frfs.dofs, kind="transmissibility", reference=reference
    )
