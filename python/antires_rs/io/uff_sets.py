"""The functions of a universal file, read through pyuff and counted by ourselves."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._common import missing_package, missing_part, unsuitable
from .uff_checksum import checked
from .uff_names import Point, label_of
from .uff_scan import Dataset, plain_exponents, scan
from .units import abscissa_factor

__all__ = ["FUNCTIONS", "MARK", "Function", "functions_of"]

#: Function types of record 6 that are read.
FUNCTIONS = {
    1: "time",
    2: "auto spectrum",
    3: "cross spectrum",
    4: "frf",
    5: "transmissibility",
    6: "coherence",
    9: "auto spectrum",
}
#: Specific data types of a force.
FORCES = (9, 13)
#: What a function without labels is in, by its specific data type, after dataset 164 was heeded.
_SI = {8: "m", 11: "m/s", 12: "m/s2", 9: "N", 13: "N"}
#: ID line 2 of our files, with the place of the set among all that were written together.
MARK = re.compile(r"^antires_rs uff (\d+) set (\d+) of (\d+)$")
VERSION = 1
WANTED = "a whole universal file with datasets 58"


@dataclass(frozen=True)
class Function:
    """One dataset 58.

    Attributes
    ----------
    what : str
        One of ``FUNCTIONS``, or "function type n".
    response, reference : (int, int)
        Node and direction code.
    x, values : (n_points,)
    unit, reference_unit : str
        Of the ordinate and its denominator.
    role : {"force", ""}
    scale : float
        Into SI by the units of dataset 164, for functions without a unit of their own.
    x_unit : float
        Unit of the abscissa in the file, in s or Hz.
    own : dict
        What our writer adds: dof, exact rate or abscissa, averages.
    """

    what: str
    response: Point
    reference: Point
    x: NDArray[np.float64]
    values: NDArray[Any]
    unit: str
    reference_unit: str
    role: str
    even: bool
    step: float
    scale: float = 1.0
    x_unit: float = 1.0
    own: dict[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        over = "" if self.what == "time" else f" / {label_of(self.reference)}"
        unit = self.unit + (f" / {self.reference_unit}" if self.reference_unit else "") or "no unit"
        return f"{self.what:<16} {label_of(self.response)}{over}, {self.values.size} points, {unit}"


def functions_of(file: Path, partial: bool, reader: str = "read_uff") -> list[Function]:
    """Every dataset 58 of a file, none lost in silence."""
    try:
        import pyuff
    except ImportError as exc:
        raise missing_package(reader, "pyuff", "uff", exc) from exc
    data = file.read_bytes()
    datasets = [checked(data, dataset) for dataset in scan(data)]
    if not datasets or all(d.number == 0 for d in datasets):
        unsuitable(
            file, "without a dataset between lines '    -1'", WANTED, "It is no universal file, or was cut."
        )
    whole = [d for d in datasets if not d.problem]
    kept = sum(d.number == 58 for d in whole)
    functions = _read(pyuff, file, data, datasets, whole)
    bad = [(i, d) for i, d in enumerate(datasets) if d.problem]
    if bad:
        i, first = bad[0]
        of = next((f" of {f.own['of']}" for f in functions if "of" in f.own), "")
        missing_part(
            file,
            f"dataset {i + 1} ({first.number or 'unknown'}) is damaged: {first.problem}; "
            f"{kept}{of} functions are whole",
            WANTED,
            partial,
            kept,
        )
    else:
        _check_marks(file, functions, partial)
    if not functions:
        unsuitable(
            file,
            f"with {len(datasets)} datasets and no 58 among them",
            WANTED,
            "Export the measured functions as dataset 58.",
        )
    return functions


def _read(
    pyuff: Any, file: Path, data: bytes, datasets: list[Dataset], whole: list[Dataset]
) -> list[Function]:
    parts = [plain_exponents(data, d) for d in whole]
    if len(whole) == len(datasets) and all(
        part == data[d.start : d.stop] for part, d in zip(parts, whole, strict=True)
    ):
        return _through_pyuff(pyuff, file, file, whole)
    import tempfile

    with tempfile.TemporaryDirectory(prefix="antires_uff_") as folder:
        # pyuff pairs markers by their order, so that a damaged set would shift all that follow.
        only = Path(folder) / "whole.uff"
        only.write_bytes(b"\n".join(parts) + b"\n")
        return _through_pyuff(pyuff, file, only, whole)


def _through_pyuff(pyuff: Any, file: Path, source: Path, whole: list[Dataset]) -> list[Function]:
    opened = pyuff.UFF(str(source))
    types = [int(t) for t in opened.get_set_types()] if opened.get_n_sets() else []
    if types != [d.number for d in whole]:
        unsuitable(
            file,
            f"in which pyuff sees {len(types)} datasets and we {len(whole)}",
            WANTED,
            "Its markers are damaged.",
        )
    functions, factors = [], (1.0, 1.0)
    for i, dataset in enumerate(whole):
        if dataset.number not in (58, 164):
            continue
        try:
            made = opened.read_sets(i)
        except Exception as exc:  # pyuff raises nothing more precise
            unsuitable(file, f"whose dataset {i + 1} pyuff cannot read ({exc})", WANTED, "It was damaged.")
        if dataset.number == 164:
            factors = _factors(file, made)
            continue
        got = np.asarray(made["data"])
        if got.size != dataset.points or len(made["x"]) != dataset.points:
            unsuitable(
                file,
                f"whose dataset {i + 1} has {got.size} points of the {dataset.points} that its header states",
                WANTED,
                "It was damaged.",
            )
        if not (np.isfinite(got).all() and np.isfinite(made["x"]).all()):
            unsuitable(
                file,
                f"whose dataset {i + 1} has values that are not finite",
                WANTED,
                "Export it again, or correct that dataset.",
            )
        functions.append(_function(made, got, factors))
        if functions[-1].even and not functions[-1].step > 0.0:
            unsuitable(
                file,
                f"whose dataset {i + 1} has a step of {functions[-1].step:g}",
                "a positive step",
                "Correct the abscissa of that dataset.",
            )
    return functions


def _factors(file: Path, made: dict[str, Any]) -> tuple[float, float]:
    """Length and force of the file's units in SI; dataset 164 has what SI is to be multiplied by."""
    length, force = float(made["length"]), float(made["force"])
    if not (np.isfinite([length, force]).all() and length > 0.0 and force > 0.0):
        unsuitable(
            file,
            f"whose units (dataset 164) have the factors {length:g} and {force:g}",
            WANTED,
            "Export it again in SI units.",
        )
    return 1.0 / length, 1.0 / force


def _si(data_type: int, factors: tuple[float, float]) -> float:
    """Factor into SI of a specific data type: displacement, velocity, acceleration, or a force."""
    return factors[0] if data_type in (8, 11, 12) else factors[1] if data_type in FORCES else 1.0


def _function(made: dict[str, Any], values: NDArray[Any], factors: tuple[float, float]) -> Function:
    kind = int(made["func_type"])
    what = FUNCTIONS.get(kind, f"function type {kind}")
    if kind == 0 and int(made["abscissa_spec_data_type"]) == 17:
        what = "time"
    even = int(made["abscissa_spacing"]) == 1
    step = float(made["abscissa_inc"]) if even else 0.0
    own = _own(made, step)
    # The format has s and Hz; some programs label what they wrote in ms.
    into_si = abscissa_factor(made["abscissa_axis_units_lab"].strip())
    x, step = into_si * np.asarray(made["x"], dtype=np.float64), into_si * step
    if "start" in own:
        x = own["start"] + own["step"] * np.arange(values.size)
    above, below = int(made["ordinate_spec_data_type"]), int(made["orddenom_spec_data_type"])
    unit, per = _label(made["ordinate_axis_units_lab"]), _label(made["orddenom_axis_units_lab"])
    scale = 1.0 if unit or per else _si(above, factors) / _si(below, factors)
    if not (unit or per):
        unit, per = _SI.get(above, ""), _SI.get(below, "")
    return Function(
        what,
        (int(made["rsp_node"]), int(made["rsp_dir"])),
        (int(made["ref_node"]), int(made["ref_dir"])),
        x,
        values,
        unit,
        per,
        "force" if above in FORCES else "",
        even,
        step,
        scale,
        into_si,
        own,
    )


def _own(made: dict[str, Any], step: float) -> dict[str, Any]:
    """What our writer adds, as far as it agrees with the header."""
    match = MARK.match(made["id2"].strip())
    if match is None or int(match[1]) > VERSION:
        return {}
    own: dict[str, Any] = {"set": int(match[2]), "of": int(match[3])}
    for line in (made["id4"], made["id5"]):
        try:
            own |= json.loads(line)
        except (ValueError, TypeError):
            return own
    numbers = [own.get(name, 0.0) for name in ("start", "step", "rate_hz", "n_averages")]
    agree = all(isinstance(n, int | float) for n in numbers) and all(
        f"{own.get(name, stated):.5e}" == f"{stated:.5e}"
        for name, stated in (("start", float(made["abscissa_min"])), ("step", step))
    )
    exact = ("start", "step", "rate_hz")
    return (
        own
        if agree and ("start" in own) == ("step" in own) == (step > 0.0)
        else {name: value for name, value in own.items() if name not in (*exact, "n_averages")}
    )


def _check_marks(file: Path, functions: list[Function], partial: bool) -> None:
    """Files of ours state how many sets were written together."""
    expected = 1
    for f in functions:
        if "set" in f.own:
            if f.own["set"] != expected:
                missing_part(
                    file, f"set {expected} of {f.own['of']} is missing", WANTED, partial, len(functions)
                )
            expected = 1 if f.own["set"] == f.own["of"] else f.own["set"] + 1
    marked = [f for f in functions if "set" in f.own]
    if marked and expected != 1:
        last = marked[-1].own
        missing_part(file, f"{last['set']} of {last['of']} sets are there", WANTED, partial, len(functions))


def _label(text: str) -> str:
    text = text.strip()
    return "" if text.upper() in ("NONE", "") else text
