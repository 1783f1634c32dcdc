"""What a method of a peer package looks like, and the curves they all start from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata

import numpy as np

import antires_rs as ar

#: Lines given to the fits; values are kept from LOW_HZ on.
LOW_HZ, HIGH_HZ = 3.0, 130.0
#: Highest order of every sweep, unless the method's note says otherwise.
MAX_ORDER = 60


@dataclass(frozen=True)
class Method:
    """One way to get antiresonances out of a package.

    ``sweep(record, highest order, estimator)`` returns, for each response, the complex poles (rad/s) of every
    order, lowest order first. ``package`` is the name under which it is installed; ``data`` is "T" for what
    ``estimator`` estimates, or says what is used instead.
    """

    name: str
    package: str
    data: str
    note: str
    sweep: Callable
    slow: bool = False

    def version(self):
        """Version of the installed package, or None."""
        try:
            return metadata.version(self.package)
        except metadata.PackageNotFoundError:
            return None


def transmissibilities(record, nperseg, estimator, low_hz=0.0):
    """Frequencies to HIGH_HZ, and for each reference j the other channels over j, (7, n_freq).

    Called only through the public interface of antires_rs. One rank-one estimate serves all references,
    because T_pq = T_pj / T_qj; H1 is made for each of them.
    """
    n = len(record.dofs)
    if estimator == "rank1":
        one = ar.transmissibility(record, record.dofs[0], nperseg=nperseg, estimator="rank1")
        tables = [one.values / one.values[j] for j in range(n)]
    else:
        both = [ar.transmissibility(record, dof, nperseg=nperseg, estimator=estimator) for dof in record.dofs]
        one, tables = both[0], [resp.values for resp in both]
    keep = (one.freq_hz >= low_hz) & (one.freq_hz <= HIGH_HZ)
    return one.freq_hz[keep], [
        _from_zero(np.delete(t, j, axis=0)[:, keep], low_hz) for j, t in enumerate(tables)
    ]


def responses_to_force(record, nperseg, low_hz=0.0):
    """Frequencies to HIGH_HZ and FRFs (8, n_freq), H1, each channel scaled to unit rms."""
    resp = ar.frf(record, nperseg=nperseg, estimator="h1")
    keep = (resp.freq_hz >= low_hz) & (resp.freq_hz <= HIGH_HZ)
    values = _from_zero(resp.values[:, keep], low_hz)
    return resp.freq_hz[keep], values / np.sqrt(np.mean(np.abs(values) ** 2, axis=1, keepdims=True))


def _from_zero(values, low_hz):
    """Lines 0 and 1 replaced by line 2: removing the mean has emptied them, and some fits want them."""
    if low_hz == 0.0:
        values = values.copy()
        values[:, :2] = values[:, 2:3].real
    return values
