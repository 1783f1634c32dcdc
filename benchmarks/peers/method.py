"""What a method of a peer package looks like, and the curves they all start from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata

import numpy as np

import antires_rs as ar

from .rule import COMMON, Rule

#: Lines of the chain given to the fits.
LOW_HZ, HIGH_HZ = 3.0, 130.0
#: Highest order of every sweep, unless the method's note says otherwise.
MAX_ORDER = 60


@dataclass(frozen=True)
class Source:
    """What is fitted: a record or FRFs of several channels, and the lines given to the fits."""

    of: ar.Recording | ar.FrequencyResponse
    low_hz: float = LOW_HZ
    high_hz: float = HIGH_HZ
    excitation: object = 0

    @property
    def dofs(self):
        """Of the channels."""
        return self.of.dofs

    @property
    def measured(self):
        """Whether it is FRFs, whose resolution is as it is."""
        return isinstance(self.of, ar.FrequencyResponse)


@dataclass(frozen=True)
class Method:
    """One way to get antiresonances out of a package.

    ``sweep(source, highest order, estimator)`` returns, for each response, the complex poles (rad/s) of every
    order, lowest order first. ``package`` is the name under which it is installed; ``data`` is "T" for what
    ``estimator`` estimates, or says what is used instead.
    """

    name: str
    package: str
    data: str
    note: str
    sweep: Callable
    rule: Rule = COMMON
    slow: bool = False
    needs_record: bool = False

    def version(self):
        """Version of the installed package, or None."""
        try:
            return metadata.version(self.package)
        except metadata.PackageNotFoundError:
            return None


def transmissibilities(source, nperseg, estimator, from_zero=True):
    """Frequencies to the upper limit, and for each reference j the other channels over j, (n - 1, n_freq).

    Called only through the public interface of antires_rs. One rank-one estimate serves all references,
    because T_pq = T_pj / T_qj; H1 is made for each of them. Given FRFs are divided.
    """
    given = source.of
    if source.measured:
        freq = given.freq_hz
        tables = [given.values / given.values[j] for j in range(len(given.dofs))]
    elif estimator == "rank1":
        one = ar.transmissibility(given, given.dofs[0], nperseg=nperseg, estimator="rank1")
        freq, tables = one.freq_hz, [one.values / row for row in one.values]
    else:
        each = [ar.transmissibility(given, dof, nperseg=nperseg, estimator=estimator) for dof in given.dofs]
        freq, tables = each[0].freq_hz, [resp.values for resp in each]
    keep = _lines(freq, source, from_zero)
    return freq[keep], [
        _filled(np.delete(table, j, axis=0)[:, keep], source, from_zero) for j, table in enumerate(tables)
    ]


def responses_to_force(source, nperseg):
    """Frequencies within the limits and FRFs (n, n_freq), H1, each channel scaled to unit rms."""
    resp = source.of if source.measured else ar.frf(source.of, nperseg=nperseg, estimator="h1")
    keep = _lines(resp.freq_hz, source, False)
    values = resp.values[:, keep]
    return resp.freq_hz[keep], values / np.sqrt(np.mean(np.abs(values) ** 2, axis=1, keepdims=True))


def _lines(freq, source, from_zero):
    """Discrete-time fits want every line from zero to half their rate."""
    return (freq <= source.high_hz) & ((freq >= source.low_hz) | from_zero)


def _filled(values, source, from_zero):
    """Lines 0 and 1 replaced by line 2: removing the mean has emptied them, and some fits want them."""
    if from_zero:
        values = np.where(np.isfinite(values), values, 0.0)
        values[:, :2] = values[:, 2:3].real
    return values
