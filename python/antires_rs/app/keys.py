"""Every section of a job file: what it holds, and the sentences that explain it.

The same sentences are the comments of ``antires init`` and the remedies of the messages.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import PurePath
from textwrap import wrap
from typing import Any

from ..damage.options import ONE_STATE, TWO_STATES, SearchOptions, options_with
from ..identification.options import declared
from ..io.registry import ENDINGS

# -- What a key and a section of a job file are: name, kind of value, and the sentence that explains it


@dataclass(frozen=True)
class Key:
    """One key.

    Attributes
    ----------
    name : str
    kind : str
        One of :data:`antires_rs.app.keys.KINDS`.
    help : str
        A sentence: what belongs here.
    default : str
        As it would be written; '' where there is none.
    required : bool
    of : tuple of str
        Kinds of model or parameter, or formats, to which the key belongs; empty for all.
    """

    name: str
    kind: str
    help: str
    default: str = ""
    required: bool = False
    of: tuple[str, ...] = ()

    @property
    def explanation(self) -> str:
        """The sentence, and to what the key belongs."""
        if not self.of:
            return self.help
        first = self.help[0].lower() if self.help[1].islower() else self.help[0]
        return f"For {', '.join(self.of)}: {first}{self.help[1:]}"


@dataclass(frozen=True)
class Section:
    """One table of a job.

    Attributes
    ----------
    name : str
    help : str
    keys : tuple of Key
    several : {"no", "may", "must"}
        Whether it is an array of tables, [[name]].
    """

    name: str
    help: str
    keys: tuple[Key, ...]
    several: str = "no"

    def key(self, name: str) -> Key | None:
        """The key of that name."""
        return next((key for key in self.keys if key.name == name), None)


# -- Formats of measurements by the endings of their files


#: Endings of files by format.
FORMATS = {**ENDINGS, "antiresonances": (".json",)}
#: What has no ending: a folder of files of one response each.
FOLDER = "folder"

ARRAYS, SIGNALS = ("mat", "hdf5", "npz"), (*ENDINGS, FOLDER)
#: Tables of columns; records of channels that state themselves; what may hold responses over frequency.
COLUMNS, RECORDS = ("csv", "excel", "parquet"), ("tdms", "lvm", "wav", "miniseed")
RESPONSES = tuple(kind for kind in SIGNALS if kind not in RECORDS)


def format_of(name: str, given: str | None = None) -> str | None:
    """The format named, or that of the file's ending; None where neither is known."""
    if given is not None:
        return given if given in FORMATS else None
    suffix = PurePath(name).suffix.lower()
    return next((kind for kind, endings in FORMATS.items() if suffix in endings), None)


# -- Keys of [data] and [identification]


DATA = Section(
    "data",
    "What was measured. One [[data]] for each position of the force, or a single [data].",
    (
        Key(
            "file",
            "text",
            "The measurement: a file .uff, .unv, .mat, .h5, .csv, .tsv, .txt, .npz, .npy, .tdms, "
            ".lvm, .wav, .xlsx, .parquet or .mseed, a folder of "
            "files of one FRF each, or the .json of 'antires identify'. Relative to this job file.",
            required=True,
        ),
        Key(
            "repeats",
            "texts",
            "Further files of the same test, other impacts or runs, in the same format; * stands for "
            "anything. They are averaged with the first.",
            of=SIGNALS,
        ),
        Key(
            "format",
            "text",
            "One of uff, mat, hdf5, csv, npz, tdms, lvm, wav, excel, parquet, miniseed, "
            "antiresonances. By default the ending tells.",
        ),
        Key(
            "excitation",
            "dof",
            "Dof of the model at which the one force acts, or the name of its channel.",
            of=SIGNALS,
        ),
        Key(
            "band_hz",
            "pair",
            "Lowest and highest frequency in Hz: from above the rigid-body modes to beyond "
            "the highest antiresonance wanted.",
            of=SIGNALS,
        ),
        Key(
            "dofs",
            "dofs",
            "Dof of the model for each channel: a list in their order, or name = dof; false "
            'leaves a channel out. Dofs count from 0; those of frames may be named as in "3 v".',
        ),
        Key(
            "drop",
            "texts",
            'Values to leave out, "DOF=HZ why", each the one within 1 % of it: "3=31.9 mains hum".',
        ),
        Key("add", "texts", "Values that are added, in the same way."),
        Key(
            "unit",
            "text",
            'Unit of the responses, where the file does not tell: "m/s2", "g", "g/N".',
            of=SIGNALS,
        ),
        Key(
            "force",
            "force",
            "Channel of the force; false leaves it out. Antiresonances do not need it.",
            '"auto"',
            of=SIGNALS,
        ),
        Key(
            "fs_hz",
            "number",
            "Sampling rate in Hz, where the file does not tell.",
            of=("mat", "hdf5", "npz", "csv", "tdms", "lvm", "excel", "parquet"),
        ),
        Key(
            "kind",
            "text",
            '"frf" or "transmissibility" (for UFF also "time" and "spectra"): what to read '
            "where a file does not tell or holds several.",
            of=RESPONSES,
        ),
        Key("reference", "dof", "Reference of transmissibilities.", of=RESPONSES),
        Key(
            "responses",
            "texts",
            "Arrays or channels of the responses; * stands for anything.",
            of=(*ARRAYS, *RECORDS, FOLDER),
        ),
        Key("time", "text", "Array of time in s.", of=ARRAYS),
        Key("freq", "text", "Array of frequencies in Hz.", of=(*ARRAYS, FOLDER)),
        Key(
            "df_hz",
            "number",
            "Spacing in Hz of FRFs from 0 Hz on, where the file has no axis.",
            of=(*ARRAYS, *COLUMNS, FOLDER),
        ),
        Key(
            "freq_hz",
            "numbers",
            "Frequencies in Hz of FRFs, in place of df_hz.",
            of=(*ARRAYS, *COLUMNS, FOLDER),
        ),
        Key(
            "roving",
            "text",
            'The sensor that stayed while the hammer roved, as "5+Z", of a universal file with the FRFs of '
            "all hits: by reciprocity they are those of a force at that sensor, the excitation then. "
            "Hits in files of their own are a [[data]] each.",
            of=("uff",),
        ),
        Key("pattern", "text", 'Which files of the folder, as "*.csv".', '"*"', of=(FOLDER,)),
        Key(
            "run",
            "whole",
            "Which run, from 1, where points were recorded several times; which segment of an .lvm.",
            of=("uff", "lvm", FOLDER),
        ),
        Key(
            "pairs",
            "text",
            '"real_imag", "magnitude_deg", "magnitude_rad", "db_deg" or "db_rad": what two neighbouring '
            "columns are, where their names do not tell.",
            of=(*COLUMNS, FOLDER),
        ),
        Key("first", "text", 'What the first column is: "time", "freq" or "channel".', of=(*COLUMNS, FOLDER)),
        Key("sheet", "text", "Sheet of an Excel workbook.", "the first", of=("excel", FOLDER)),
        Key("full_scale", "number", "What full scale of a WAV file stands for, in unit.", "1", of=("wav",)),
        Key("delimiter", "text", "What stands between columns.", of=("csv", FOLDER)),
        Key("decimal", "text", "Decimal sign.", of=("csv", FOLDER)),
        Key(
            "partial",
            "switch",
            "Whether to read what is whole of a file that was cut.",
            "false",
            of=("uff", "csv", "tdms", "lvm", FOLDER),
        ),
    ),
    "may",
)

IDENTIFICATION = Section(
    "identification",
    "How antiresonances are identified. The defaults suit most records.",
    (
        Key("dofs", "list", "Dofs whose antiresonances are used; by default all that were measured."),
        *(
            Key(name, "whole" if one.kind == "segment" else one.kind, one.sentence, one.shown)
            for name, one in declared().items()
        ),
        Key("second_opinion", "text", "The older name of cross_check."),
    ),
)


# -- Keys of [model] and [[parameters]]


CHAIN, FRAME, MATRICES, RESULT = ("chain", "frame", "matrices", "result")

MODEL = Section(
    "model",
    "The model. Masses, springs, nodes, elements and dofs count from 0.",
    (
        Key(
            "kind",
            "text",
            '"chain" (masses and springs in a row), "frame" (beams), "matrices" (K and M of '
            "any finite-element program), \"result\" (the updated model of 'antires update').",
            required=True,
        ),
        Key("masses_kg", "numbers", "Masses in kg, from the first to the last.", of=(CHAIN,)),
        Key(
            "springs_n_per_m",
            "numbers",
            "Stiffness in N/m of the springs between neighbours, one fewer than masses.",
            of=(CHAIN,),
        ),
        Key(
            "ground_first_n_per_m",
            "number",
            "Spring from the first mass to ground; 0 is a free end. With n "
            'masses it is element n - 1, which "all" leaves out.',
            "0",
            of=(CHAIN,),
        ),
        Key(
            "ground_last_n_per_m",
            "number",
            "Spring from the last mass to ground: element n, left out likewise.",
            "0",
            of=(CHAIN,),
        ),
        Key("nodes_m", "list", "Coordinates of the nodes in m, [x, y] or [x, y, z].", of=(FRAME,)),
        Key("elements", "list", '[node, node, "section"] of each beam.', of=(FRAME,)),
        Key(
            "sections",
            "table",
            'Name = { shape = "tube", outer_diameter_m, thickness_m, youngs_modulus_pa, '
            'density_kg_per_m3 }, "rectangle" with width_m, height_m, or "general" with area_m2, inertia_m4; '
            'shear_coefficient = "cowper" or a number makes Timoshenko beams.',
            of=(FRAME,),
        ),
        Key("point_masses", "list", "[node, kg] or [node, kg, inertia in kg m2] of each.", of=(FRAME,)),
        Key(
            "ground_springs",
            "list",
            '[node, "direction", N/m] of each; directions are u, v, theta in the '
            "plane, u, v, w, rx, ry, rz in space.",
            of=(FRAME,),
        ),
        Key(
            "node_springs",
            "list",
            '[node, node, N/m] or [node, node, N/m, "direction"] of each.',
            of=(FRAME,),
        ),
        Key("fixed", "list", 'Nodes, or [node, "direction"], that cannot move.', of=(FRAME,)),
        Key("orientation", "list", "Direction in which the height of the sections points.", of=(FRAME,)),
        Key(
            "file",
            "text",
            "The result.npz of 'antires update', or a file of write_matrices.",
            of=(MATRICES, RESULT),
        ),
        Key("stiffness", "text", "K, as Matrix Market (.mtx) or scipy.sparse (.npz).", of=(MATRICES,)),
        Key("mass", "text", "M, likewise.", of=(MATRICES,)),
        Key(
            "stiffness_terms",
            "texts",
            "The part of K that each element or group contributes.",
            of=(MATRICES,),
        ),
        Key("mass_terms", "texts", "The same for M.", of=(MATRICES,)),
        Key(
            "dof_map",
            "text",
            'Text file with node and direction of each row, so that channels such as "12+Z" find their dof.',
            of=(MATRICES,),
        ),
        Key("first_row", "whole", "Number of the first row in dof_map.", "1", of=(MATRICES,)),
    ),
)

ELEMENTS = ("stiffness_factor", "stiffness_reduction", "angle", "length")
SECTIONED = ("youngs_modulus", "density", "thickness", "diameter")
LUMPED, SUPPORT = ("point_mass", "inertia"), ("support_stiffness",)

PARAMETERS = Section(
    "parameters",
    "What may change in the model: one [[parameters]] for each kind and its bounds.",
    (
        Key(
            "kind",
            "text",
            "stiffness_factor, stiffness_reduction (of elements), mass_factor (of terms); for "
            "frames also youngs_modulus, density, thickness, diameter (of sections), point_mass, inertia (of "
            "masses), support_stiffness (of springs), angle (of elements about a pivot), length (of elements "
            "from a pivot), position (of nodes along a direction).",
            required=True,
        ),
        Key(
            "bounds",
            "pair",
            "Lower and upper bound: a factor, or a value in SI (degrees for an angle, m for a position).",
            required=True,
        ),
        Key("elements", "terms", '"all" or a list such as [0, 1, 2].', of=ELEMENTS),
        Key(
            "terms",
            "terms",
            '"all" or a list such as [0, 1, 2]; for a chain, the masses.',
            of=("mass_factor",),
        ),
        Key("sections", "terms", '"all" or a list of names.', of=SECTIONED),
        Key("masses", "terms", '"all" or positions in point_masses.', of=LUMPED),
        Key("springs", "terms", '"all" or positions in ground_springs.', of=SUPPORT),
        Key(
            "together",
            "switch",
            "Whether one parameter acts on all of them.",
            "false",
            of=(*ELEMENTS[:2], "mass_factor", *SECTIONED, *LUMPED, *SUPPORT, "position"),
        ),
        Key(
            "relative",
            "switch",
            "Whether bounds are factors on the model's value.",
            "false",
            of=(*SECTIONED, *LUMPED, *SUPPORT),
        ),
        Key("nodes", "terms", "A list of nodes.", of=("position",)),
        Key("direction", "numbers", "The direction in which the nodes move, (x, y, z).", of=("position",)),
        Key(
            "pivot", "whole", "The node about which the elements turn, or that stays.", of=("angle", "length")
        ),
        Key("axis", "numbers", "The axis, in space.", "[0, 0, 1]", of=("angle",)),
    ),
    "must",
)


# -- Keys of [updating], [damage], [search] and [output]


UPDATING = Section(
    "updating",
    "The objective of the updating.",
    (
        Key(
            "misfit",
            "text",
            '"absolute" (a few wrong values do not move it), "squared" or "largest".',
            '"absolute"',
        ),
        Key("weights", "text", '"std": what is known badly counts less.'),
    ),
)

#: Options of a search for damage that a job may set.
SEARCH_KEYS = {
    name: Key(name, one.kind, one.explanation, one.shown)
    for name, one in SearchOptions.declared().items()
    if one.kind != "value"
}

DAMAGE = Section(
    "damage",
    "Where damage is looked for.",
    (
        Key(
            "baseline",
            "texts",
            "The intact structure: measurements as in [data], identified with the same options, or the .json "
            "of 'antires identify'; with several [[data]] one for each; * takes records of one test. With it "
            "changes are compared, and errors of the model do not count as damage.",
        ),
        Key("elements", "terms", 'Candidates: "all" or a list such as [0, 1, 2].', '"all"'),
        *(SEARCH_KEYS[name] for name in options_with(TWO_STATES) if name in SEARCH_KEYS),
        Key(
            "prior",
            "shares",
            "With a baseline: probabilities before the test that add up to one, { nothing = 0.5, one = 0.3, "
            "two = 0.1, three = 0.03, elsewhere = 0.05, unknown = 0.02 } by default.",
        ),
        *(SEARCH_KEYS[name] for name in options_with(ONE_STATE) if name in SEARCH_KEYS),
    ),
)

SEARCH = Section(
    "search",
    "The search. The same seed gives bit-identical results for any number of workers.",
    (
        Key("seed", "whole", "A whole number of at least 0.", "0"),
        Key("workers", "whole", "Threads; by default all processors."),
        Key("max_seconds", "number", "Longest time; 'antires resume' goes on from there."),
        Key("checkpoint", "switch", "Whether the search is kept on disk while it runs.", "true"),
        Key("max_evaluations", "whole", "Budget of model evaluations.", "200000"),
        Key("max_generations", "whole", "Budget of generations."),
        Key("islands", "whole", "Number of populations.", "4"),
        Key("population", "whole", "Individuals of each.", "40"),
        Key(
            "polish",
            "switch",
            "Whether a local search polishes the islands' bests; false leaves it out.",
            "true",
        ),
        Key(
            "crossovers",
            "texts",
            'Operators dealt out to the islands: "arithmetic", "heuristic", "blend", "uniform".',
        ),
        Key("crossover_probability", "number", "Of a pair, from 0 to 1.", "0.8"),
        Key("mutation_probability", "number", "Of a gene, from 0 to 1.", "0.02"),
        Key("selection_pressure", "number", "Probability of selecting the best individual.", "0.08"),
        Key("patience", "whole", "Generations without improvement before an island waits.", "40"),
        Key("improvement_tolerance", "number", "Relative gain that counts as improvement.", "1e-4"),
        Key("agreement", "text", '"genes-or-cost" or "genes".', '"genes-or-cost"'),
        Key("gene_tolerance", "number", "Spread of the bests that counts as agreement.", "1e-6"),
        Key("cost_tolerance", "number", "The same for costs, relative.", "1e-6"),
        Key("cost_floor", "number", "The same for costs, absolute.", "1e-12"),
        Key("cost_migrations", "whole", "Migrations in a row for which costs must agree.", "3"),
        Key("polish_interval", "whole", "Generations between two polishes.", "10"),
        Key("polish_evaluations", "whole", "Evaluations after which a polish begins nothing new.", "1000"),
    ),
)

OUTPUT = Section(
    "output",
    "What is written. Files are whole or not there.",
    (
        Key("folder", "text", "Folder of the results, made if need be. Relative to this job file."),
        Key("title", "text", "Heading of the report."),
        Key("report", "switch", "Whether to write report.html.", "true"),
        Key("pictures", "switch", "Whether to write the pictures as PNG too.", "true"),
    ),
)


# -- Keys of [series]


SERIES = Section(
    "series",
    'Many tests of one structure: [data] names a folder, or a pattern such as "records/*.npz".',
    (
        Key(
            "conditions",
            "text",
            "A CSV or Parquet file with what was measured beside: a row a test, in their order, or with "
            'their names in a column "name"; a column "time" dates them.',
        ),
        Key(
            "over",
            "text",
            "The condition over which the pictures draw the antiresonances; by default the tests in order.",
        ),
        Key("workers", "whole", "Processes that identify; by default one. No number depends on it."),
    ),
)

#: In the order of a job file.
SECTIONS = {
    section.name: section
    for section in (DATA, SERIES, IDENTIFICATION, MODEL, PARAMETERS, UPDATING, DAMAGE, SEARCH, OUTPUT)
}


# -- Kinds of values in a job file


#: Stands in a new job for a dof that only its user knows.
UNSET = "?"


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _text(value: Any) -> bool:
    return isinstance(value, str) and value != ""


def _dof(value: Any) -> bool:
    return _whole(value) or _text(value)


def _list(value: Any, item: Callable[[Any], bool], least: int = 1) -> bool:
    return isinstance(value, list) and len(value) >= least and all(map(item, value))


def _dofs(value: Any) -> bool:
    def one(dof: Any) -> bool:
        return dof is False or _dof(dof)

    return _list(value, one) or (isinstance(value, dict) and bool(value) and all(map(one, value.values())))


@dataclass(frozen=True)
class Kind:
    """What is wanted, whether a value is that, and how it is written."""

    wanted: str
    fits: Callable[[Any], bool]
    remedy: str


KINDS = {
    "text": Kind("text in quotes", _text, "Put it in quotes."),
    "texts": Kind(
        "text in quotes, or a list of such",
        lambda v: _text(v) or _list(v, _text),
        'Write "one" or ["one", "another"].',
    ),
    "number": Kind("a finite number", _number, "Write it without quotes, with a decimal point."),
    "numbers": Kind(
        "a list of finite numbers", lambda v: _list(v, _number, 0), "Write them as in [1.0, 2.5]."
    ),
    "whole": Kind("a whole number", _whole, "Write it without quotes and decimal point."),
    "switch": Kind(
        "true or false", lambda v: isinstance(v, bool), "Write it in small letters, without quotes."
    ),
    "pair": Kind(
        "two numbers, [low, high]",
        lambda v: _list(v, _number) and len(v) == 2,
        "Write them as in [3.0, 130.0].",
    ),
    "dof": Kind("a whole number, or a name in quotes", _dof, 'Write it as in 3 or "12+Z".'),
    "dofs": Kind(
        "a list of dofs, or a table name = dof", _dofs, 'Write it as in [0, 1, 2] or { "12+Z" = 0 }.'
    ),
    "force": Kind(
        "a channel's name in quotes, or false", lambda v: v is False or _dof(v), "Put it in quotes."
    ),
    "terms": Kind(
        '"all", a number or name, or a list of them',
        lambda v: _dof(v) or _list(v, _dof),
        'Write it as in "all" or [0, 1, 2].',
    ),
    "list": Kind("a list that is not empty", lambda v: _list(v, lambda item: True), "Put it in [ ]."),
    "shares": Kind(
        "a table name = number",
        lambda v: isinstance(v, dict) and bool(v) and all(map(_number, v.values())),
        "Write it as in { nothing = 0.9, one = 0.1 }.",
    ),
    "table": Kind("a table, name = { ... }", lambda v: isinstance(v, dict) and bool(v), "Put it in { }."),
}


def unset_in(value: Any) -> list[str]:
    """Channels, or places in a list, whose dof is not given yet; [''] for the value itself."""
    if isinstance(value, dict):
        return [name for name, dof in value.items() if dof == UNSET]
    if isinstance(value, list):
        return [f"number {i}" for i, dof in enumerate(value) if dof == UNSET]
    return [""] if value == UNSET else []


def shown(value: Any) -> str:
    """A value as it stands in a job file, cut where it is long."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 60 else text[:57] + "..."


# -- The job that ``antires init`` writes: every key with the sentence that explains it


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
    """A job to be filled in: valid as it stands, but for the files it names and dofs that are not given."""
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
