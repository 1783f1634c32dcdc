"""``antires model``: K, M and the terms of groups from runs of a finite-element code."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..exceptions import reject
from ..io.fe_codes import read_model, write_model
from ..io.fe_programs import code_name
from ..models.matrix_model import MatrixModel
from ..updating.result import UpdateResult
from .command import arguments, existing, new_file, show

_PASSED = "command", "out", "mesh", "workers"
_FUNCTION = re.compile(r"(?<=\.py):\w+$")
_ELEMENTS = re.compile(r"\d+(-\d+)?(,\d+(-\d+)?)*")


def model(args: argparse.Namespace) -> int:
    """Run the code, save the model, say what is in it; or write the input with the values of a result."""
    source = existing("SOURCE", Path(_FUNCTION.sub("", args.source)), "Name the input of the code.")
    new_file("--out", args.out, source.suffix if args.result else ".npz")
    if args.result:
        for name in (one for one in ("groups", "mesh") if getattr(args, one)):
            reject(f"--{name}", "it beside --result", "a result, which has its model, alone", "Leave it out.")
        return _write(args)
    if not args.groups:
        reject("--groups", "nothing", "the groups that may be scaled", "As in --groups elset.")
    if args.mesh is not None:
        existing("--mesh", Path(args.mesh), "Name the file of the mesh.")
    named = {name: f"--{name}" for name in ("groups", "command", "mesh")}
    named |= {"source": "SOURCE", "path": "SOURCE"}
    with arguments(named):
        by_number = code_name(args.source, None, args.command) != "command"
        groups = _groups(args.groups, by_number)
        found = read_model(args.source, groups=groups, **{n: getattr(args, n) for n in _PASSED})
    show(args.json, _data(found), "\n".join(_lines(found, str(args.out))))
    return 0


def _write(args: argparse.Namespace) -> int:
    given = Path(args.result)
    file = given / "result.npz" if given.is_dir() else given
    existing("--result", file, "'antires update' and 'antires damage' write result.npz into their folder.")
    with arguments({"source": "SOURCE", "model": "--result", "path": "--result", "file": "--out"}):
        found = UpdateResult.load(file).model
        write_model(args.out, args.source, found, command=args.command)  # type: ignore[arg-type]
    factors = found.group_factors  # type: ignore[attr-defined]
    rows = (f"{name}  {factor:.6g} times its value" for name, factor in factors.items() if factor != 1.0)
    show(args.json, {"factors": factors}, "\n".join([f"{args.out} is written", *rows]))
    return 0


def _groups(words: Iterable[str], by_number: bool) -> Any:
    """What ``read_model`` takes, of ``elset``, ``NAME`` and ``OWN=...``."""
    words = list(words)
    if words in (["elset"], ["material"]):
        return words[0]
    groups: dict[str, Any] = {}
    for word in words:
        name, sign, target = word.partition("=")
        groups[name] = target if sign else word
        if sign and by_number and _ELEMENTS.fullmatch(target):
            ends = ([int(end) for end in part.split("-")] for part in target.split(","))
            groups[name] = [number for each in ends for number in range(each[0], each[-1] + 1)]
        elif sign and not by_number:
            groups[name] = _number(target)
    return groups


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text  # refused with the name of its group


def _data(found: MatrixModel) -> dict[str, Any]:
    rows = [
        {"name": each.name, "quantity": each.quantity, "value": each.value, "linear": each.linear}
        | {"stiffness_powers": each.stiffness_powers, "mass_powers": each.mass_powers}
        | {"elements": len(each.elements)}
        for each in found.groups.values()
    ]
    return {"n_dof": found.n_dof, "groups": rows, "dofs": list(map(found.dof_label, range(found.n_dof)))}


def _lines(found: MatrixModel, file: str) -> Iterable[str]:
    first, last = found.dof_label(0), found.dof_label(found.n_dof - 1)
    yield f"{found.n_dof} dofs, {first} to {last}; saved in {file}"
    width = max(len(name) for name in found.groups)
    for name, each in found.groups.items():
        value = "" if each.value is None else f" {each.value:g}"
        acts = [
            f"{side} with powers {', '.join(str(p) for _, p in powers)}"
            for side, powers in (("stiffness", each.stiffness_powers), ("mass", each.mass_powers))
            if powers
        ]
        of = f", {len(each.elements)} elements" if len(each.elements) else ""
        yield f"{name:<{width}}  {each.quantity}{value}{of}: {' and '.join(acts)}"
