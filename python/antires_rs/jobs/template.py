"""The job that ``antires init`` writes: every key with the sentence that explains it."""

from __future__ import annotations

import re
from textwrap import wrap

from .formats import format_of
from .key import Section
from .keys import SECTIONS
from .keys_model import CHAIN, FRAME, MATRICES, RESULT

__all__ = ["template"]

_HEAD = {
    "damage": "Look for damage: antires damage {name}",
    "update": "Update a model: antires update {name}",
    "series": "Identify many tests: antires series {name}",
}
#: What is filled in as an example, by model; None stands for every model.
_EXAMPLES: dict[str, dict[str, str]] = {
    CHAIN: {"masses_kg": "[1.0, 1.0, 1.0]", "springs_n_per_m": "[50e3, 50e3]"},
    FRAME: {
        "nodes_m": "[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]]",
        "elements": '[[0, 1, "pipe"], [1, 2, "pipe"]]',
    },
    MATRICES: {"stiffness": '"K.mtx"', "mass": '"M.mtx"', "stiffness_terms": '"K_element_*.mtx"'},
    RESULT: {"file": '"update_results/result.npz"'},
}
_PARAMETERS = {
    CHAIN: (("mass_factor", "terms", '"all"'), ("stiffness_factor", "elements", '"all"')),
    FRAME: (("thickness", "sections", '"all"'), ("stiffness_factor", "elements", '"all"')),
    MATRICES: (("stiffness_factor", "elements", '"all"'),),
    RESULT: (("stiffness_factor", "elements", '"all"'),),
}
#: What needs a table of its own.
_TABLES = {
    FRAME: [
        "[model.sections.pipe]",
        'shape = "tube"',
        "outer_diameter_m = 0.05",
        "thickness_m = 0.002",
        "youngs_modulus_pa = 2.1e11",
        "density_kg_per_m3 = 7850.0",
        "",
    ]
}
_WIDTH = 108
#: Node and direction of a universal file.
_POINT = re.compile(r"(\d+)[+-]([XYZ])")


def template(
    task: str = "damage",
    model: str = CHAIN,
    *,
    name: str = "job.toml",
    data: str = "record.uff",
    dofs: dict[str, object] | None = None,
    excitation: str | None = None,
) -> str:
    """A job to be filled in: valid as it stands, but for the files it names and dofs that are not given.

    Parameters
    ----------
    task : {"damage", "update", "series"}
    model : {"chain", "frame", "matrices", "result"}
    name : str
        Of the job file, for its heading.
    data : str
        File of the measurement.
    dofs : dict, optional
        Channels of that file, each with its dof; "?" where it is not known, with which no job runs.
    excitation : str, optional
        The same of the force: the name of its channel or point, or "?".

    Returns
    -------
    str
        TOML.

    Examples
    --------
    >>> from antires_rs.jobs import template
    >>> print(template("damage").splitlines()[0])
    # Look for damage: antires damage job.toml
    """
    lines = [
        f"# {_HEAD[task].format(name=name)}",
        "#",
        "# Lines that begin with # are explanations, or keys with their defaults: remove the # to",
        "# change one. Force, band and model that stand here are examples: put your own in their place.",
        "# Paths are relative to this file. Masses, springs, nodes, elements and dofs count from 0.",
        "",
    ]
    force = "0" if excitation is None else _quoted(excitation)
    filled = {"file": _quoted(data), "excitation": force, "band_hz": "[3.0, 130.0]"}
    if dofs:
        pairs = [
            f"{_quoted(channel)} = {_quoted(dof) if isinstance(dof, str) else dof}"
            for channel, dof in dofs.items()
        ]
        filled["dofs"] = "{ " + ", ".join(pairs) + " }"
    if dofs or excitation is not None:
        lines += _comment(_unset(model, list(dofs or ())))
    if task == "series":
        filled["file"] = _quoted("records" if data == "record.uff" else data)
        for part in ("data", "series", "identification", "output"):
            lines += _section(SECTIONS[part], filled if part == "data" else {})
        return "\n".join(lines)
    lines += _section(SECTIONS["data"], filled, of=format_of(data) or "")
    lines += _section(SECTIONS["model"], {"kind": _quoted(model), **_EXAMPLES[model]}, of=model)
    lines += _TABLES.get(model, [])
    if task == "damage":
        lines += _section(SECTIONS["damage"], {})
    else:
        for i, (kind, on, what) in enumerate(_PARAMETERS[model]):
            chosen = {"kind": _quoted(kind), "bounds": "[0.9, 1.1]", on: what}
            chosen |= {"relative": "true"} if on == "sections" else {}
            lines += _section(SECTIONS["parameters"], chosen, of=kind, brief=i > 0)
        lines += _section(SECTIONS["updating"], {})
    lines += _section(SECTIONS["identification"], {})
    lines += _section(SECTIONS["search"], {"seed": "0"})
    lines += _section(SECTIONS["output"], {"folder": _quoted(name.removesuffix(".toml") + "_results")})
    return "\n".join(lines)


def _unset(model: str, channels: list[str]) -> str:
    """What a question mark stands for, with what the names of the channels suggest."""
    points = {channel: found for channel in channels if (found := _POINT.fullmatch(channel))}
    said = (
        'A "?" stands for a dof of your model that the file cannot tell. Put the dof in its place, or false '
        "for a channel that is to be left out; until then the job does not run."
    )
    if model != FRAME:
        return said + (
            " Dofs are rows of the matrices, from 0."
            if model == MATRICES
            else " Dofs count from 0, mass by mass."
            if model == CHAIN
            else ""
        )
    if not points:
        return said + ' Dofs of frames are written as in "2 u": node 2, along x.'
    some = [f'"{name}" = "{p[1]} {"uvw"["XYZ".index(p[2])]}"' for name, p in list(points.items())[:3]]
    return f"{said} If the nodes of the file are those of the model, these are: {', '.join(some)}, and so on."


def _section(section: Section, filled: dict[str, str], *, of: str = "", brief: bool = False) -> list[str]:
    """Its heading and keys; of a kind of model or parameter only those that belong to it."""
    heading = f"[[{section.name}]]" if section.several == "must" else f"[{section.name}]"
    if brief:
        return [heading, *(f"{name} = {value}" for name, value in filled.items()), ""]
    lines = [*_comment(section.help), heading]
    mine = [key for key in section.keys if not of or not key.of or of in key.of]
    for key in (key for key in mine if key.name in filled):
        lines += [*_comment(key.help), f"{key.name} = {filled[key.name]}"]
    rest = [key for key in mine if key.name not in filled]
    width = max((len(f"# {key.name} = {key.default}") for key in rest), default=0) + 2
    for key in rest:
        first, *more = wrap(key.help if of else key.explanation, _WIDTH - width)
        lines.append(f"{f'# {key.name} = {key.default}':<{width}}# {first}")
        lines += [f"#{'':<{width - 1}}# {line}" for line in more]
    return [*lines, ""]


def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in wrap(text, _WIDTH)]


def _quoted(text: str) -> str:
    """A TOML string."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
