"""Universal files: dataset 58, functions at nodal dofs, in text or binary form.

The format is documented by the Structural Dynamics Research Laboratory, University of Cincinnati, after SDRC.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..signals.recording import Recording
from ..support.validation import choice
from ..support.wording import Passed, Wording
from ._common import Signal, existing_file, rate_of, simplest_rate, unsuitable
from .channels import Channel, recording_of
from .uff_names import Point, as_point, dof_of, label_of
from .uff_response import half_digit, response_of
from .uff_roving import roved
from .uff_runs import listed, one_run
from .uff_sets import Function, functions_of

__all__ = ["list_uff", "read_uff"]

Kind = Literal["time", "frf", "transmissibility", "spectra"]
_KIND_OF = {"auto spectrum": "spectra", "cross spectrum": "spectra"}


def read_uff(
    path: str | os.PathLike[str],
    *,
    kind: Kind | None = None,
    dofs: Any = None,
    reference: Any = None,
    force: Any = "auto",
    unit: str | None = None,
    run: int | None = None,
    roving: Any = None,
    partial: bool = False,
) -> Signal:
    """Read dataset 58 of a universal file, in text or binary form.

    Parameters
    ----------
    path : path-like
    kind : {"time", "frf", "transmissibility", "spectra"}, optional
        What to read, where a file holds several. Spectra: cross spectra S_jp (mean of X_p times the
        conjugate of X_j) over the auto spectrum S_jj of their reference become FRFs where that is a force,
        and transmissibilities otherwise (the H1 estimate); their labels name the units of the two channels.
        Coherences go with the values they belong to.
    dofs : mapping or callable, optional
        ``{(node, direction): dof}`` or a function of both, direction being ``'+Z'``, ``'-RX'`` or ``'S'``;
        None leaves a channel out. A mapping with ``(12, '+Z')`` takes a channel in ``-Z`` with its sign
        changed. Default: labels such as ``'12+Z'``; in files of ours, the dofs that were written.
    reference : str or (int, str), optional
        Reference point, where a file has several: ``'1+X'`` or ``(1, '+X')``.
    force : str, (int, str) or None
        Force channel of a time record: "auto" is the only one there is, None leaves it out. A channel is a
        force by its ordinate type or its unit.
    unit : str, optional
        Unit of the responses, in place of the file's labels: ``'g'``, ``'m/s2'``, ``'g/N'`` and the like.
        Without labels the units of dataset 164 hold, where there is one, and SI otherwise.
    run : int, optional
        Which run to read, where points were recorded several times: 1 is the first of each point. Read each,
        and identify from all of them: ``identify_antiresonances([run 1, run 2], ...)``.
    roving : str or (int, str), optional
        The sensor that stayed while the hammer roved, ``'5+Z'``: its FRFs to all references become, by
        reciprocity, those of the references to a force at that sensor. Name it as the excitation then.
    partial : bool
        Read the whole sets of a file that was cut, with a warning that counts what is missing.

    Returns
    -------
    Recording or FrequencyResponse
        In SI.

    Raises
    ------
    UnsuitableDataError
        A set that is cut or shorter than its header states, sets that do not fit together, several kinds or
        references to choose from.
    MissingDependencyError
        pyuff is not installed.
    FileNotFoundError
        There is none.

    Notes
    -----
    A universal file does not state how many sets it has. In one of another program that was cut exactly
    between two sets the rest is missing without a trace; ours are numbered. Steps of time and frequency have
    six digits in the format; the simplest rate or step that fits is taken (1.95313E-03 s is 512 Hz).

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     record = ar.Recording([[1.0, 2.0, 4.0, 3.0]], 512.0, dofs=["12+Z"])
    ...     file = ar.write_uff(folder + "/a.uff", record)
    ...     ar.read_uff(file, dofs={(12, "+Z"): 4})
    Recording(1 channels, 0.0078125 s at 512 Hz, dofs=(4,), no force)
    """
    file = existing_file(path)
    if kind is not None:
        choice("kind", kind, ("time", "frf", "transmissibility", "spectra"))
    functions = functions_of(file, partial)
    if roving is not None:
        functions = roved(file, functions, roving)
    there = list(
        dict.fromkeys(
            _KIND_OF.get(f.what, f.what)
            for f in functions
            if f.what != "coherence" and not f.what.startswith("function type")
        )
    )
    found = ", ".join(there) or "no function that can be read"
    if kind is None:
        if len(there) != 1:
            unsuitable(
                file,
                f"with {found}",
                "one kind of function",
                Wording("Pass {} or another of them.", Passed("kind", there[0]))
                if there
                else _listed(functions),
            )
        kind = there[0]  # type: ignore[assignment]
    elif kind not in there:
        unsuitable(
            file,
            f"with {found}",
            Wording("{}", Passed("kind", kind)),
            "Pass the kind that the file holds, or leave it out.",
        )
    wanted = [f for f in functions if _KIND_OF.get(f.what, f.what) in (kind, "coherence")]
    functions = one_run(file, wanted, run)
    own = {f.response: f.own["dof"] for f in functions if f.own.get("dof") is not None}
    named = dof_of(dofs, own)
    if kind == "time":
        return _recording(file, [f for f in functions if f.what == "time"], named, force, unit)
    return response_of(file, functions, str(kind), named, reference, unit)


def list_uff(path: str | os.PathLike[str], *, partial: bool = False) -> list[str]:
    """One line for each function of a universal file: what it is, where, how long, in which unit, which run.

    Parameters
    ----------
    path : path-like
    partial : bool
        As in :func:`~antires_rs.read_uff`.

    Returns
    -------
    list of str

    Raises
    ------
    UnsuitableDataError
        As in :func:`~antires_rs.read_uff`.
    MissingDependencyError
        pyuff is not installed.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_uff(folder + "/a.uff", ar.Recording([[1.0, 2.0, 4.0]], 512.0, dofs=["12+Z"]))
    ...     print(*ar.io.list_uff(file))
    time             12+Z, 3 points, m/s2
    """
    return listed(functions_of(existing_file(path), partial, "list_uff"))


def _recording(file: Path, functions: list[Function], named: Any, force: Any, unit: str | None) -> Recording:
    rates = {_rate(file, f) for f in functions}
    starts = {round(float(f.x[0]), 9) for f in functions}
    if len(rates) > 1 or len(starts) > 1:
        unsuitable(
            file,
            f"with records of rates {sorted(rates)} Hz that begin at {sorted(starts)} s",
            "channels recorded together",
            "Read them one by one.",
        )
    channels, signs = [], {}
    for f in functions:
        if np.iscomplexobj(f.values):
            unsuitable(
                file,
                f"with a complex time record of {label_of(f.response)}",
                "real ones",
                "Export the record as real numbers.",
            )
        named_by_user = unit is not None and f.role != "force"
        values = f.values if f.scale == 1.0 or named_by_user else f.values * f.scale
        channels.append(Channel(f.response, values, f.unit, f.role))
    if force not in ("auto", None):
        force = as_point("force", force)

    def dof(point: Point) -> Any:
        label, signs[point] = named(point)
        return label

    made = recording_of(file, channels, rates.pop(), dofs=dof, force=force, unit=unit)
    kept = [s for (p, s) in signs.items()]
    if all(s == 1.0 for s in kept):
        return made
    signed = {named(p)[0]: s for p, s in signs.items()}
    turned = made.responses * np.array([[signed[d]] for d in made.dofs])
    return Recording(turned, made.fs_hz, made.dofs, made.force)


def _rate(file: Path, f: Function) -> float:
    if "rate_hz" in f.own:
        return float(f.own["rate_hz"])
    if not f.even:
        return rate_of(file, f.x, digits=5e-6)
    half = half_digit(f.step, f.x_unit)
    return simplest_rate(1.0 / (f.step + half), 1.0 / (f.step - half))


def _listed(functions: list[Function]) -> str:
    return "It holds " + "; ".join(map(str, functions[:10])) + "."
