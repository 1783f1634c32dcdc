"""Resonances and mode shapes, measured or computed."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..exceptions import InvalidInputError, reject
from ..support.checks import FloatArray, dof_labels, real_array
from ..support.files import marked_json, write_atomically
from ..support.messages import some
from ..support.values import ReadOnly, frozen

_FORMAT, _VERSION = "antires_rs.ModalSet", 1
_WANTED = f"a file written by ModalSet.save, version {_VERSION} or older"
_ANOTHER = "'antires identify --modes --out modes.json' writes one; or name the file that holds it."
_COLUMNS = ("damping_ratio", "std_hz", "std_shapes")  # a number for each mode, where they are known


class ModalSet(ReadOnly):
    """Resonant frequencies with their mode shapes.

    Parameters
    ----------
    freq_hz : array_like, (n_modes,)
        Resonant frequencies in Hz, ascending; may be empty.
    shapes : array_like, (n_modes, n_dofs)
        One mode a row, real or complex, at as many or as few dofs as are known.
    dofs : iterable of int or str, optional
        Name of each column.
    damping_ratio, std_hz : array_like, (n_modes,), optional
        Modal damping ratios, and standard deviations of the frequencies in Hz.
    std_shapes : array_like, (n_modes,), optional
        Standard deviation of each component of a shape that is scaled to unit length.
    diagram : StabilizationDiagram, optional
        The evidence, where the modes were identified.

    All are attributes, as given, read-only.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.ModalSet([1.0, 2.0], [[1.0, 1.0], [1.0, -1.0]])
    ModalSet(2 modes x 2 dofs, 1 to 2 Hz)
    """

    freq_hz: FloatArray
    shapes: NDArray[Any]
    dofs: tuple[Any, ...]
    damping_ratio: FloatArray | None
    diagram: Any
    std_hz: FloatArray | None
    std_shapes: FloatArray | None

    def __init__(
        self,
        freq_hz: Any,
        shapes: Any,
        dofs: Iterable[Any] | None = None,
        damping_ratio: Any = None,
        *,
        diagram: Any = None,
        std_hz: Any = None,
        std_shapes: Any = None,
    ) -> None:
        freq = frozen(_maybe_empty("freq_hz", freq_hz, "an array (n_modes,) in Hz"))
        if np.any(np.diff(freq) < 0):
            remedy = "Sort the modes by frequency, shapes and damping with them."
            reject("freq_hz", "frequencies out of order", "ascending frequencies", remedy)
        array = np.asarray(shapes)
        numeric = array.dtype.kind in "biufc"
        if array.ndim != 2 or array.shape[0] != freq.size or not array.shape[1] or not numeric:
            got = f"an array of shape {array.shape}, {array.dtype}"
            wanted = f"numbers ({freq.size}, n_dofs), one mode a row"
            reject("shapes", got, wanted, "Transpose it if the modes are in the columns.")
        if not np.all(np.isfinite(array)):
            remedy = "Leave out the modes or dofs that were not measured."
            reject("shapes", "NaN or infinite values", "finite shapes", remedy)
        names = dof_labels("dofs", dofs, array.shape[1])
        self._fill(freq_hz=freq, shapes=frozen(array), dofs=names, diagram=diagram)
        self._fill(damping_ratio=_each("damping_ratio", damping_ratio, freq.size))
        for name, std in (("std_hz", std_hz), ("std_shapes", std_shapes)):
            self._fill(**{name: _each(name, std, freq.size, least=0.0)})

    def at_dofs(self, columns: list[int], dofs: Iterable[Any]) -> ModalSet:
        """The set with these columns of the shapes, which are of ``dofs``."""
        known = {name: getattr(self, name) for name in _COLUMNS}
        return ModalSet(self.freq_hz, self.shapes[:, columns], dofs, diagram=self.diagram, **known)

    def mac(self, other: ModalSet) -> FloatArray:
        """Modal assurance criterion between two sets of shapes, over the dofs that both have.

        ``abs(phi^H psi)^2 / (phi^H phi psi^H psi)``, (len(self), len(other)): one for the same shape up to a
        complex factor, 0 for orthogonal ones; with a single common dof one by construction. No dof in common,
        or a shape that vanishes at all of them, is an InvalidInputError. R. J. Allemang and D. L. Brown,
        Proc. IMAC 1 (1982) 110-116.

        Examples
        --------
        >>> import antires_rs as ar
        >>> measured = ar.ModalSet([1.0], [[2.0j, -2.0j]], dofs=["b", "a"])
        >>> measured.mac(ar.ModalSet([1.0], [[-1.0, 1.0]], dofs=["a", "b"])).round(9).tolist()
        [[1.0]]
        """
        if not isinstance(other, ModalSet):
            reject("other", type(other).__name__, "a ModalSet", "Make it: ModalSet(freq_hz, shapes, dofs).")
        common = [dof for dof in self.dofs if dof in other.dofs]
        if not common:
            reject("other", f"dofs {other.dofs}", f"some of {self.dofs}", "Name the dofs of both sets alike.")
        a, b = (one.shapes[:, [one.dofs.index(dof) for dof in common]] for one in (self, other))
        norms = [np.sum(np.abs(x) ** 2, axis=1) for x in (a, b)]
        for name, norm in zip(("self", "other"), norms, strict=True):
            if not norm.all():
                got = f"mode {np.argmin(norm)} of {name} without motion at the common dofs {tuple(common)}"
                remedy = "Leave that mode out, or compare at more dofs."
                reject("other", got, "shapes that do not vanish there", remedy)
        product = np.abs(a.conj() @ b.T) ** 2
        return np.asarray(product / (norms[0][:, None] * norms[1]), dtype=np.float64)

    def to_real(self) -> ModalSet:
        """Real shapes: each turned by the phase that leaves the least imaginary part, which is dropped.

        The component of largest magnitude is positive.

        Examples
        --------
        >>> import antires_rs as ar
        >>> ar.ModalSet([1.0], [[3.0j, -1.0j]]).to_real().shapes.round(12).tolist()
        [[3.0, -1.0]]
        """
        turn = 0.5 * np.angle(np.sum(np.asarray(self.shapes, dtype=np.complex128) ** 2, axis=1))
        real = (self.shapes * np.exp(-1j * turn)[:, None]).real
        largest = np.take_along_axis(real, np.argmax(np.abs(real), axis=1)[:, None], axis=1)
        made = copy.copy(self)
        made._fill(shapes=frozen(np.where(largest < 0.0, -real, real)))
        return made

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as JSON, whole or not at all; every float comes back bit for bit, the diagram does not."""
        data: dict[str, Any] = {"format": _FORMAT, "version": _VERSION, "dofs": list(self.dofs), "modes": []}
        known = {name: getattr(self, name) for name in _COLUMNS if getattr(self, name) is not None}
        for r, (freq, shape) in enumerate(zip(self.freq_hz, self.shapes, strict=True)):
            row = {"freq_hz": float(freq)} | {name: float(column[r]) for name, column in known.items()}
            row |= {"real": np.real(shape).tolist()}
            row |= {"imaginary": np.imag(shape).tolist()} if np.iscomplexobj(shape) else {}
            data["modes"].append(row)
        write_atomically(path, (json.dumps(data, indent=1, allow_nan=False) + "\n").encode())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read what :meth:`save` wrote; others are an InvalidInputError."""
        try:
            text = Path(path).read_text(encoding="utf-8")
            data = marked_json(text, str(path), _FORMAT, _VERSION, _WANTED, _ANOTHER)
            modes, dofs = data["modes"], data["dofs"]
            columns = {
                name: [mode[name] for mode in modes] for name in _COLUMNS if modes and name in modes[0]
            }
            shapes = np.array([mode["real"] for mode in modes], dtype=np.float64).reshape(-1, len(dofs))
            if modes and "imaginary" in modes[0]:
                shapes = shapes + 1j * np.array([mode["imaginary"] for mode in modes], dtype=np.float64)
            return cls([mode["freq_hz"] for mode in modes], shapes, dofs, **columns)
        except (KeyError, TypeError, ValueError, AttributeError) as exc:
            if isinstance(exc, InvalidInputError) and exc.argument == "path":
                raise
            raise InvalidInputError(
                "path", f"{str(path)!r}, which is damaged ({exc})", _WANTED, _ANOTHER
            ) from exc

    def __len__(self) -> int:
        return int(self.freq_hz.size)

    def __str__(self) -> str:
        """Frequencies and damping, a line a mode."""
        lines = [f"mode          Hz  damping (%)   {len(self.dofs)} dofs: {some(map(str, self.dofs), 8)}"]
        damping = np.full(len(self), np.nan) if self.damping_ratio is None else 100.0 * self.damping_ratio
        for r, (freq, share) in enumerate(zip(self.freq_hz, damping, strict=True)):
            lines.append(f"{r:4d}  {freq:10.3f}  {'-' if share != share else f'{share:.3f}':>11}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        band = f", {self.freq_hz[0]:.4g} to {self.freq_hz[-1]:.4g} Hz" if len(self) else ""
        return f"ModalSet({len(self)} modes x {len(self.dofs)} dofs{band})"


def _each(name: str, given: Any, n_modes: int, least: float = -np.inf) -> FloatArray | None:
    """One number for each mode, or none."""
    if given is None:
        return None
    values = frozen(_maybe_empty(name, given, "an array (n_modes,)"))
    if values.shape != (n_modes,) or values.min(initial=0.0) < least:
        wanted = f"{n_modes}, one a mode" + (", of at least 0" if least == 0.0 else "")
        reject(name, f"{values.size} values", wanted, "Give one for each mode, or leave it out.")
    return values


def _maybe_empty(name: str, value: Any, wanted: str) -> FloatArray:
    """A real 1-D array that may have no element."""
    if isinstance(value, list | tuple | np.ndarray) and np.shape(value) == (0,):
        return np.empty(0)
    return real_array(name, value, ndim=1, wanted=wanted)
