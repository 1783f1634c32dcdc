"""One set that stands for many tests of an unchanged structure."""

from __future__ import annotations

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.tracks import Tracks
from ..order_sweep.table import ResponseTable

__all__ = ["averaged"]

#: Part of the tests that must have an antiresonance.
MOST = 0.5


def averaged(tracks: Tracks, dofs: tuple[object, ...]) -> AntiresonanceSet:
    """Mean of each track that most tests have, with the standard deviation of that mean."""
    freq = tracks.freq_hz
    count = np.sum(~np.isnan(freq), axis=0)
    tables = {}
    for dof in dofs:
        own = tracks.of(dof)
        own = own[count[own] >= max(MOST * count[own].max(initial=0), 2)]
        n = count[own]
        std = np.nanstd(freq[:, own], axis=0, ddof=1) / np.sqrt(n) if own.size else np.empty(0)
        mean = np.nanmean(freq[:, own], axis=0) if own.size else np.empty(0)
        tables[dof] = ResponseTable(mean, std_hz=std, scores={"averages": n.astype(np.float64)})
    return AntiresonanceSet.from_tables(tracks.excitation, tables)
