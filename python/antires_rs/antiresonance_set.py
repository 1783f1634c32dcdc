"""The antiresonances of a structure under one force: what identification hands to updating."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ._files import write_atomically
from ._validation import FloatArray, real_array, reject
from .exceptions import InvalidInputError, MissingDependencyError
from .signals import frozen

__all__ = ["AntiresonanceSet"]

FORMAT = "antires_rs.AntiresonanceSet"
VERSION = 1


class AntiresonanceSet(Mapping[Any, FloatArray]):
    """Antiresonant frequencies by response dof, a mapping ``{dof: freq_hz}``.

    Parameters
    ----------
    excitation : int or str
        The dof of the force.
    freq_hz : mapping of dof to array_like
        Antiresonances in Hz, in any order; a number stands for a list of one; an empty list says that the dof
        was looked at and has none.
    damping_ratio, std_hz : mapping of dof to array_like, optional
        Damping ratio and standard deviation of each value, in the order of ``freq_hz``. Dofs may be missing.

    Attributes
    ----------
    excitation : int or str
    damping_ratio, std_hz : dict
        By dof, in the order of the sorted frequencies; without the dofs for which they are not known.
    diagrams : dict
        Stabilization diagram by dof where the set was identified; not saved.

    Raises
    ------
    InvalidInputError
        Frequencies that are not positive and finite, or companions of another length or dof.

    Examples
    --------
    >>> from antires_rs.antiresonance_set import AntiresonanceSet
    >>> table = AntiresonanceSet(0, {0: [23.9, 8.7], 1: 14.4, 2: []})
    >>> table[0].tolist(), len(table), 3 in table
    ([8.7, 23.9], 3, False)
    >>> print(table)
    antiresonances, force at 0
    dof  count  freq_hz
      0      2  8.700  23.900
      1      1  14.400
      2      0  -
    """

    def __init__(self, excitation: Any, freq_hz: Mapping[Any, Any],
                 damping_ratio: Mapping[Any, Any] | None = None, std_hz: Mapping[Any, Any] | None = None, *,
                 diagrams: Mapping[Any, Any] | None = None) -> None:
        self.excitation = _label("excitation", excitation)
        if not isinstance(freq_hz, Mapping) or not freq_hz:
            reject(
                "freq_hz",
                type(freq_hz).__name__ if not isinstance(freq_hz, Mapping) else "an empty mapping",
                "a mapping of dof to frequencies in Hz, e.g. {0: [12.2, 36.2], 1: []}",
            )
        self._freq_hz: dict[Any, FloatArray] = {}
        self.damping_ratio: dict[Any, FloatArray] = {}
        self.std_hz: dict[Any, FloatArray] = {}
        self.diagrams: dict[Any, Any] = dict(diagrams or {})
        rank: dict[Any, Any] = {}
        for key, value in freq_hz.items():
            dof = _label("freq_hz", key)
            if dof in self._freq_hz:
                reject("freq_hz", f"dof {dof!r} more than once", "each dof once")
            values = _values(f"freq_hz[{dof!r}]", value, "positive frequencies in Hz")
            if values.size and values.min() <= 0.0:
                reject(f"freq_hz[{dof!r}]", f"{values.min():g} Hz", "positive frequencies in Hz")
            rank[dof] = np.argsort(values, kind="stable")
            self._freq_hz[dof] = frozen(values[rank[dof]])
        for name, given, store in (("damping_ratio", damping_ratio, self.damping_ratio),
                                   ("std_hz", std_hz, self.std_hz)):
            if given is not None and not isinstance(given, Mapping):
                reject(name, type(given).__name__, "a mapping of dof to one value for each frequency")
            for key, value in (given or {}).items():
                dof = _label(name, key)
                if dof not in rank:
                    reject(name, f"dof {dof!r}", f"dofs of freq_hz, {tuple(rank)}")
                values = _values(f"{name}[{dof!r}]", value, "one finite value for each frequency")
                if values.size != rank[dof].size:
                    reject(
                        f"{name}[{dof!r}]",
                        f"{values.size} values",
                        f"{rank[dof].size}, one for each frequency",
                    )
                if name == "std_hz" and values.size and values.min() < 0.0:
                    reject(f"{name}[{dof!r}]", f"{values.min():g} Hz", "standard deviations of at least 0 Hz")
                store[dof] = frozen(values[rank[dof]])

    def __getitem__(self, dof: Any) -> FloatArray:
        return self._freq_hz[dof]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._freq_hz)

    def __len__(self) -> int:
        return len(self._freq_hz)

    def __eq__(self, other: object) -> bool:
        """Same excitation, dofs and values, bit for bit; diagrams do not count."""
        if not isinstance(other, AntiresonanceSet):
            return NotImplemented
        mine, theirs = (s._tables() for s in (self, other))
        return self.excitation == other.excitation and all(
            a.keys() == b.keys() and all(np.array_equal(a[dof], b[dof]) for dof in a)
            for a, b in zip(mine, theirs, strict=True))

    __hash__ = None  # type: ignore[assignment]

    def _tables(self) -> tuple[dict[Any, FloatArray], ...]:
        return self._freq_hz, self.damping_ratio, self.std_hz

    def __repr__(self) -> str:
        counts = ", ".join(f"{dof!r}: {f.size}" for dof, f in self._freq_hz.items())
        return f"AntiresonanceSet(excitation={self.excitation!r}, values by dof {{{counts}}})"

    def __str__(self) -> str:
        width = max(3, *(len(str(dof)) for dof in self._freq_hz))
        lines = [f"antiresonances, force at {self.excitation}", f"{'dof':>{width}}  count  freq_hz"]
        for dof, freq in self._freq_hz.items():
            values = "  ".join(f"{f:.3f}" for f in freq) or "-"
            lines.append(f"{dof!s:>{width}}  {freq.size:5d}  {values}")
        return "\n".join(lines)

    def to_dataframe(self) -> Any:
        """One row a value: columns dof, freq_hz, damping_ratio, std_hz (NaN where not known).

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        MissingDependencyError
            pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError as exc:
            raise MissingDependencyError("to_dataframe needs pandas; install it: pip install pandas") from exc
        rows = []
        for dof, freq in self._freq_hz.items():
            unknown = np.full(freq.size, np.nan)
            for value in zip(
                freq, self.damping_ratio.get(dof, unknown), self.std_hz.get(dof, unknown), strict=True
            ):
                rows.append((dof, *map(float, value)))
        return pd.DataFrame(rows, columns=["dof", "freq_hz", "damping_ratio", "std_hz"])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as JSON, whole or not at all; every float comes back bit for bit.

        Parameters
        ----------
        path : path-like
            Replaced if it exists.

        Raises
        ------
        InvalidInputError
            The folder does not exist.
        """
        dofs = [{"dof": dof, **{name: table[dof].tolist() for name, table in
                                zip(("freq_hz", "damping_ratio", "std_hz"), self._tables(), strict=True)
                                if dof in table}} for dof in self._freq_hz]
        text = json.dumps({"format": FORMAT, "version": VERSION, "excitation": self.excitation, "dofs": dofs},
                          indent=1, allow_nan=False)
        write_atomically(path, (text + "\n").encode())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> AntiresonanceSet:
        """Read what :meth:`save` wrote.

        Parameters
        ----------
        path : path-like

        Raises
        ------
        InvalidInputError
            The file is damaged, of another kind, or of a newer version.
        FileNotFoundError
            There is none.
        """
        wanted = f"a file written by AntiresonanceSet.save, version {VERSION} or older"
        try:
            data = json.loads(Path(path).read_text(encoding="utf-8"))
        except ValueError as exc:
            text = f"path: got {str(path)!r}, which is not JSON ({exc}); wanted {wanted}."
            raise InvalidInputError(text) from exc
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            reject("path", f"{str(path)!r} without the mark {FORMAT!r}", wanted)
        if not isinstance(data.get("version"), int) or data["version"] > VERSION:
            reject("path", f"{str(path)!r} of version {data.get('version')!r}", wanted, "Update antires_rs.")
        try:
            tables: dict[str, dict[Any, Any]] = {"freq_hz": {}, "damping_ratio": {}, "std_hz": {}}
            for row in data["dofs"]:
                if row["dof"] in tables["freq_hz"]:
                    raise ValueError(f"dof {row['dof']!r} more than once")
                for name, table in tables.items():
                    if name in row or name == "freq_hz":
                        table[row["dof"]] = row[name]
            return cls(data["excitation"], **tables)
        except (KeyError, TypeError, ValueError) as exc:
            text = f"path: got {str(path)!r}, which is damaged ({exc}); wanted {wanted}."
            raise InvalidInputError(text) from exc


def _label(name: str, value: Any) -> Any:
    """An integer or a string; numpy's integers become Python's."""
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, bool) or not isinstance(value, int | str):
        reject(name, value, "a dof named by an integer or a string")
    return value


def _values(name: str, value: Any, wanted: str) -> FloatArray:
    """A 1-D array, possibly empty; a number is a list of one."""
    if np.size(value) == 0:
        return np.empty(0)
    return np.atleast_1d(real_array(name, value, ndim=None, wanted=wanted)).ravel()
