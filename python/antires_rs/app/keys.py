"""Every section of a job file, and the sentences that explain it in jobs, help and messages."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from textwrap import wrap
from typing import Any

from ..damage.options import ONE_STATE, TWO_STATES, DamagePrior, SearchOptions, options_with
from ..identification.options import declared
from ..io.registry import ENDINGS, formats_of
from ..models.frame_parts import PARTS
from ..support.options import Option, small
from ..support.values import FrozenDict

# -- What a key and a section of a job file are


@dataclass(frozen=True)
class Key:
    """One key: its kind, a sentence on what belongs there, and its default as it would be written."""

    name: str
    kind: str
    help: str
    default: str = ""
    required: bool = False
    #: Kinds of model or parameter, or formats, to which the key belongs; empty for all.
    of: tuple[str, ...] = ()
    flag: str = ""  # the same on the command line, as in ``--fs HZ``; '' where it is a key of jobs alone
    choices: tuple[str, ...] = ()

    @property
    def explanation(self) -> str:
        """The sentence, and to what the key belongs."""
        return f"For {', '.join(self.of)}: {small(self.help)}" if self.of else self.help

    @property
    def words(self) -> list[str]:
        """Those of which the value is one: if they are not said, those in quotes in the sentence."""
        return list(self.choices) or re.findall(r'"([\w-]+)"', self.help)


@dataclass(frozen=True)
class Section:
    """One table of a job; whether there "may" or "must" be ``several`` of that name, [[name]]."""

    name: str
    help: str
    keys: tuple[Key, ...]
    several: str = ""

    def key(self, name: str) -> Key | None:
        """The key of that name."""
        return next((key for key in self.keys if key.name == name), None)


# -- Formats of measurements, and what belongs to which

FORMATS = {**ENDINGS, "antiresonances": (".json",)}  # endings of files by format
SIGNAL_ENDINGS = [ending for endings in ENDINGS.values() for ending in endings]
FOLDER = "folder"  # what has no ending: a folder of files of one response each
SIGNALS = (*ENDINGS, FOLDER)
RECORDS = formats_of("records")
MODELS = CHAIN, FRAME, MATRICES, RESULT = ("chain", "frame", "matrices", "result")
GROUPS = {  #: Names of several formats, or kinds of parameter, in the declarations below.
    "signals": SIGNALS,
    "records": RECORDS,
    "responses": tuple(kind for kind in SIGNALS if kind not in RECORDS),
    "arrays": formats_of("arrays"),
    "columns": formats_of("columns"),
    "stiffness": ("stiffness_factor", "stiffness_reduction"),
    "sectioned": ("youngs_modulus", "density", "thickness", "diameter"),
    "lumped": ("point_mass", "inertia"),
    "turned": ("angle", "length"),
}


def format_of(name: str, given: str | None = None) -> str | None:
    """The format named, or that of the file's ending; None where neither is known."""
    if given is not None:
        return given if given in FORMATS else None
    suffix = PurePath(name).suffix.lower()
    return next((kind for kind, endings in FORMATS.items() if suffix in endings), None)


# -- The sections, a key a paragraph: ``name (required kind of formats, --flag VALUE) = default: sentence``

_DECLARED = re.compile(r"(\w+) \((required )?(\w+)(?: of ([\w ]+))?(?:, (--[^)]+))?\)(?: = (.+?))?: (.+)")


def _sections(text: str, **inserted: Sequence[Key]) -> dict[str, Section]:
    """Every section; ``<name>`` stands for keys that are declared elsewhere."""
    sections = {}
    for part in text.strip().split("\n\n"):
        head, *paragraphs = re.split(r"\n(?! )", part)
        heading, _, about = head.partition(": ")
        name, _, several = heading[1:].partition("]")
        keys: list[Key] = []
        for paragraph in paragraphs:
            keys += inserted.get(paragraph[1:-1]) or [_key(" ".join(paragraph.split()))]
        sections[name] = Section(name, about, tuple(keys), several.strip())
    return sections


def _key(paragraph: str) -> Key:
    found = _DECLARED.fullmatch(paragraph)
    if found is None:
        raise ValueError(f"no declaration of a key: {paragraph!r}")
    name, required, kind, of, flag, default, sentence = (part or "" for part in found.groups())
    groups = tuple(one for word in of.split() for one in GROUPS.get(word, (word,)))
    return Key(name, kind, sentence, default, bool(required), groups, flag)


def _of_options(options: Mapping[str, Option], names: Iterable[str]) -> list[Key]:
    """The keys of options of a call, but for those whose values no job can write."""
    kinds = {name: "whole" if options[name].kind == "segment" else options[name].kind for name in names}
    keys = []
    for name, kind in kinds.items():
        if kind != "value":
            one = options[name]
            choices = one.choices if name == "formulation" else ()
            keys.append(Key(name, kind, one.explanation, one.shown, flag=one.flag, choices=choices))
    return keys


_TEXT = """
[data] may: What was measured. One [[data]] for each position of the force, or a single [data].
file (required text): The measurement: a file <endings>, a folder of files of one FRF each, or the .json of
    'antires identify'. Relative to this job file.
repeats (texts of signals): Further files of the same test, other impacts or runs, in the same format; *
    stands for anything. They are averaged with the first; FRFs of several forces are one of each.
format (text, --format FORMAT): One of <formats>. By default the ending tells.
excitation (places of signals, --excitation DOFS): Dof of the model at which the one force acts, or the name
    of its channel; a list, as [0, 4], of several unknown forces that act at once.
band_hz (pair of signals, --band LOW HIGH): Lowest and highest frequency in Hz: from above the rigid-body
    modes to beyond the highest antiresonance wanted.
dofs (dofs, --dof CHANNEL=DOF ...): Dof of the model for each channel: a list in their order, or name = dof;
    false leaves a channel out. Dofs count from 0, or are named: "3 v" of a frame, "12:Z" of a code.
drop (texts): Values to leave out, "DOF=HZ why", each the one within 1 % of it: "3=31.9 mains hum".
add (texts): Values that are added, in the same way.
unit (text of signals, --unit UNIT): Unit of the responses, where the file does not tell: "m/s2", "g", "g/N".
force (force of signals, --force CHANNEL) = "auto": Channel of the force; false leaves it out. Antiresonances
    do not need it.
fs_hz (number of arrays csv tdms lvm excel parquet, --fs HZ): Sampling rate in Hz, where the file does not
    tell.
kind (word of responses, --kind WORD): "frf" or "transmissibility" (for UFF also "time" and "spectra"): what
    to read where a file does not tell or holds several.
reference (dof of responses, --reference DOF): Reference of transmissibilities.
responses (texts of arrays columns records folder, --responses NAME ...): Arrays, columns or channels of the
    responses; * stands for anything.
align (switch of arrays columns, --align) = false: Whether the file, and those of repeats, are sensors of one
    test that have a clock each: they are joined by their instants, and samples that were missed made up.
time (text of arrays): Array of time in s.
freq (text of arrays folder): Array of frequencies in Hz.
df_hz (number of arrays columns folder, --df HZ): Spacing in Hz of FRFs from 0 Hz on, where the file has no
    axis.
freq_hz (numbers of arrays columns folder): Frequencies in Hz of FRFs, in place of df_hz.
roving (text of uff, --roving SENSOR): The sensor that stayed while the hammer roved, as "5+Z", of a universal
    file with the FRFs of all hits: by reciprocity they are those of a force at that sensor, the excitation
    then. Hits in files of their own are a [[data]] each.
pattern (text of folder, --pattern GLOB) = "*": Which files of the folder, as "*.csv".
run (whole of uff lvm folder, --run N>=1): Which run, from 1, where points were recorded several times; which
    segment of an .lvm.
pairs (word of columns folder, --pairs WORD): "real_imag", "magnitude_deg", "magnitude_rad", "db_deg" or
    "db_rad": what two neighbouring columns are, where their names do not tell.
first (word of columns folder, --first WORD): What the first column is: "time", "freq" or "channel".
sheet (text of excel folder, --sheet NAME) = the first: Sheet of an Excel workbook.
full_scale (number of wav, --full-scale VALUE) = 1: What full scale of a WAV file stands for, in unit.
delimiter (text of csv folder): What stands between columns.
decimal (text of csv folder): Decimal sign.
partial (switch of uff csv tdms lvm folder) = false: Whether to read what is whole of a file that was cut.

[measured]: Measured modes: what is fitted if there is no [data], else compared beside its antiresonances.
modes (texts): The .json of 'antires identify --modes', or of ModalSet.save; a file for each setup of
    sensors. Relative to this job file.
dofs (dofs): Dof of the model for each column of the shapes: a list in their order, or name = dof; false
    leaves a column out.

[series]: Many tests of one structure: [data] names a folder, or a pattern such as "records/*.npz".
conditions (text): A CSV or Parquet file with what was measured beside: a row a test, in their order, or with
    their names in a column "name"; a column "time" dates them.
over (text): The condition over which the pictures draw the antiresonances; by default the tests in order.
workers (whole): Processes that identify; by default one. No number depends on it.

[identification]: How antiresonances are identified. The defaults suit most records.
dofs (list): Dofs whose antiresonances are used; by default all that were measured.
<options>

[model]: The model. Masses, springs, nodes, elements and dofs count from 0.
kind (required text): "chain" (masses and springs in a row), "frame" (beams), "matrices" (K and M of any
    finite-element program), "result" (the updated model of 'antires update').
masses_kg (required numbers of chain): Masses in kg, from the first to the last.
springs_n_per_m (required numbers of chain): Stiffness in N/m of the springs between neighbours, one fewer
    than masses.
ground_first_n_per_m (number of chain) = 0: Spring from the first mass to ground; 0 is a free end. With n
    masses it is element n - 1, which "all" leaves out.
ground_last_n_per_m (number of chain) = 0: Spring from the last mass to ground: element n, left out likewise.
nodes_m (required list of frame): Coordinates of the nodes in m, [x, y] or [x, y, z].
elements (required list of frame): [node, node, "section"] of each beam.
sections (required table of frame): Name = { shape = "tube", outer_diameter_m, thickness_m, youngs_modulus_pa,
    density_kg_per_m3 }, "rectangle" with width_m, height_m, or "general" with area_m2, inertia_m4;
    shear_coefficient = "cowper" or a number makes Timoshenko beams.
<parts>
fixed (list of frame): Nodes, or [node, "direction"], that cannot move.
orientation (list of frame): Direction in which the height of the sections points.
file (text of matrices result): The result.npz of 'antires update', or a file of write_matrices.
stiffness (text of matrices): K, as Matrix Market (.mtx) or scipy.sparse (.npz).
mass (text of matrices): M, likewise.
stiffness_terms (texts of matrices): The part of K that each element or group contributes.
mass_terms (texts of matrices): The same for M.
dof_map (text of matrices): Text file with node and direction of each row, so that channels such as "12+Z"
    find their dof.
first_row (whole of matrices) = 1: Number of the first row in dof_map.

[parameters] must: What may change in the model: one [[parameters]] for each kind and its bounds.
kind (required text): stiffness_factor, stiffness_reduction (of elements), mass_factor (of terms); for frames
    also youngs_modulus, density, thickness, diameter (of sections), point_mass, inertia (of masses),
    support_stiffness (of springs), angle (of elements about a pivot), length (of elements from a pivot),
    position (of nodes along a direction).
bounds (required pair): Lower and upper bound: a factor, or a value in SI (degrees for an angle, m for a
    position).
elements (required terms of stiffness turned): "all" or a list such as [0, 1, 2].
terms (required terms of mass_factor): "all" or a list such as [0, 1, 2]; for a chain, the masses.
sections (required terms of sectioned): "all" or a list of names.
masses (required terms of lumped): "all" or positions in point_masses.
springs (required terms of support_stiffness): "all" or positions in ground_springs.
together (switch of stiffness mass_factor sectioned lumped support_stiffness position) = false: Whether one
    parameter acts on all of them.
relative (switch of sectioned lumped support_stiffness) = false: Whether bounds are factors on the model's
    value.
nodes (required terms of position): A list of nodes.
direction (required numbers of position): The direction in which the nodes move, (x, y, z).
pivot (required whole of turned): The node about which the elements turn, or that stays.
axis (numbers of angle) = [0, 0, 1]: The axis, in space.

[updating]: The objective of the updating.
objective (text): "antiresonance", of [data], or "modal", the modes of [measured]; what was measured tells it.
misfit (text) = "absolute": "absolute" (a few wrong values do not move it), "squared" or "largest".
weights (text): "std": what is known badly counts less.

[damage]: Where damage is looked for.
baseline (texts): The intact structure: measurements as in [data], identified with the same options, or the
    .json of 'antires identify'; with several [[data]] one for each; * takes records of one test. With it
    changes are compared, and errors of the model do not count as damage.
elements (terms) = "all": Candidates: "all" or a list such as [0, 1, 2].
<two_states>
prior (shares): With a baseline: probabilities before the test that add up to one, <prior> by default.
<one_state>

[search]: The search. The same seed gives bit-identical results for any number of workers.
seed (whole) = 0: A whole number of at least 0.
workers (whole): Threads; by default all processors.
max_seconds (number): Longest time; 'antires resume' goes on from there.
checkpoint (switch) = true: Whether the search is kept on disk while it runs.
max_evaluations (whole) = 200000: Budget of model evaluations.
max_generations (whole): Budget of generations.
islands (whole) = 4: Number of populations.
population (whole) = 40: Individuals of each.
polish (switch) = true: Whether a local search polishes the islands' bests; false leaves it out.
crossovers (texts): Operators dealt out to the islands: "arithmetic", "heuristic", "blend", "uniform".
crossover_probability (number) = 0.8: Of a pair, from 0 to 1.
mutation_probability (number) = 0.02: Of a gene, from 0 to 1.
selection_pressure (number) = 0.08: Probability of selecting the best individual.
patience (whole) = 40: Generations without improvement before an island waits.
improvement_tolerance (number) = 1e-4: Relative gain that counts as improvement.
agreement (text) = "genes-or-cost": "genes-or-cost" or "genes".
gene_tolerance (number) = 1e-6: Spread of the bests that counts as agreement.
cost_tolerance (number) = 1e-6: The same for costs, relative.
cost_floor (number) = 1e-12: The same for costs, absolute.
cost_migrations (whole) = 3: Migrations in a row for which costs must agree.
polish_interval (whole) = 10: Generations between two polishes.
polish_evaluations (whole) = 1000: Evaluations after which a polish begins nothing new.

[output]: What is written. Files are whole or not there.
folder (text): Folder of the results, made if need be. Relative to this job file.
title (text): Heading of the report.
report (switch) = true: Whether to write report.html.
pictures (switch) = true: Whether to write the pictures as PNG too.
"""
SECTIONS = _sections(  #: In the order of a job file.
    _TEXT.replace("<endings>", " ".join(SIGNAL_ENDINGS))
    .replace("<formats>", ", ".join(FORMATS))
    .replace(
        "<prior>", f"{{ {', '.join(f'{name} = {share:g}' for name, share in vars(DamagePrior()).items())} }}"
    ),
    options=_of_options(declared(), declared()),
    parts=[Key(name, "list", part._in_job, of=(FRAME,)) for name, part in PARTS.items()],
    two_states=_of_options(SearchOptions.declared(), options_with(TWO_STATES)),
    one_state=_of_options(SearchOptions.declared(), options_with(ONE_STATE)),
)
DATA, IDENTIFICATION, PARAMETERS = (SECTIONS[name] for name in ("data", "identification", "parameters"))
#: How a file is read, without places, and the band.
READING = [
    key for key in DATA.keys if key.flag and key.name not in ("excitation", "band_hz", "dofs", "roving")
]
TASKS = {  #: What a job of each task may hold, in the order in which ``antires init`` writes it.
    "damage": ("data", "measured", "model", "damage", "identification", "search", "output"),
    "update": ("data", "measured", "model", "parameters", "updating", "identification", "search", "output"),
    "series": ("data", "series", "identification", "output"),
}
#: What tells the task of a job.
HEADINGS = {"damage": "[damage]", "update": "[[parameters]]", "series": "[series]"}


# -- Kinds of values in a job file

UNSET = "?"  # stands in a new job for a dof that only its user knows


@dataclass(frozen=True)
class Kind:
    """What is wanted, whether a value is that, and how it is written."""

    wanted: str
    fits: Callable[[Any], bool]
    remedy: str


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _plain(*types: type) -> Callable[[Any], bool]:
    """Of these types; true and false are no numbers, and a text is not empty."""
    return lambda value: isinstance(value, types) and not isinstance(value, bool) and value != ""


def _switch(value: Any) -> bool:
    return isinstance(value, bool)


def _list(item: Callable[[Any], bool], least: int = 1, most: float = math.inf) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and least <= len(value) <= most and all(map(item, value))


def _table(item: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, dict) and bool(value) and all(map(item, value.values()))


def _any_of(*kinds: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: any(fits(value) for fits in kinds)


_whole, _text, _dof = _plain(int), _plain(str), _plain(int, str)
_dof_or_false = _any_of(_dof, lambda value: value is False)
_names = _any_of(_text, _list(_text, 0))
_texts, _terms = _any_of(_text, _list(_text)), _any_of(_dof, _list(_dof))
_dofs = _any_of(_list(_dof_or_false), _table(_dof_or_false))
_QUOTED = Kind("text in quotes", _text, "Put it in quotes.")
KINDS = {
    "text": _QUOTED,
    "word": _QUOTED,
    "texts": Kind("text in quotes, or a list of such", _texts, 'Write "one" or ["one", "another"].'),
    "names": Kind("text in quotes, or a list of such", _names, 'Write "one", ["one", "another"] or [].'),
    "number": Kind("a finite number", _number, "Write it without quotes, with a decimal point."),
    "numbers": Kind("a list of finite numbers", _list(_number, 0), "Write them as in [1.0, 2.5]."),
    "whole": Kind("a whole number", _whole, "Write it without quotes and decimal point."),
    "switch": Kind("true or false", _switch, "Write it in small letters, without quotes."),
    "pair": Kind("two numbers, [low, high]", _list(_number, 2, 2), "Write them as in [3.0, 130.0]."),
    "places": Kind("a whole number or a name in quotes, or a list of them", _terms, "As in 3 or [0, 4]."),
    "dof": Kind("a whole number, or a name in quotes", _dof, 'Write it as in 3 or "12+Z".'),
    "dofs": Kind("a list of dofs, or a table name = dof", _dofs, 'As in [0, 1, 2] or { "12+Z" = 0 }.'),
    "force": Kind("a channel's name in quotes, or false", _dof_or_false, "Put it in quotes."),
    "terms": Kind('"all", a number or name, or a list of them', _terms, 'As in "all" or [0, 1, 2].'),
    "list": Kind("a list that is not empty", _list(lambda item: True), "Put it in [ ]."),
    "shares": Kind("a table name = number", _table(_number), "Write it as in { nothing = 0.9, one = 0.1 }."),
    "table": Kind("a table, name = { ... }", _table(lambda item: True), "Put it in { }."),
}


def shown(value: Any) -> str:
    """A value as it stands in a job file, cut where it is long."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 60 else text[:57] + "..."


# -- The job that ``antires init`` writes: every key with the sentence that explains it

_HEAD = {"damage": "Look for damage", "update": "Update a model", "series": "Identify many tests"}
_EXAMPLES = {  #: What is filled in as an example, by model.
    CHAIN: {"masses_kg": "[1.0, 1.0, 1.0]", "springs_n_per_m": "[50e3, 50e3]"},
    FRAME: {
        "nodes_m": "[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]]",
        "elements": '[[0, 1, "pipe"], [1, 2, "pipe"]]',
    },
    MATRICES: {"stiffness": '"K.mtx"', "mass": '"M.mtx"', "stiffness_terms": '"K_element_*.mtx"'},
    RESULT: {"file": '"update_results/result.npz"'},
}
_PARAMETERS = {  #: Kinds of parameter, and on what they act.
    CHAIN: {"mass_factor": "terms", "stiffness_factor": "elements"},
    FRAME: {"thickness": "sections", "stiffness_factor": "elements"},
    MATRICES: {"stiffness_factor": "elements"},
    RESULT: {"stiffness_factor": "elements"},
}
# What needs a table of its own.
_PIPE = """\
[model.sections.pipe]
shape = "tube"
outer_diameter_m = 0.05
thickness_m = 0.002
youngs_modulus_pa = 2.1e11
density_kg_per_m3 = 7850.0
"""
_DOFS = {  #: Which dofs a question mark may stand for, by model.
    CHAIN: " Dofs count from 0, mass by mass.",
    FRAME: ' Dofs of frames are written as in "2 u": node 2, along x.',
    MATRICES: ' Dofs are rows of the matrices, from 0, or their names, as "12:Z".',
    RESULT: "",
}
_WIDTH = 108
_QUESTION = (
    'A "?" stands for a dof of your model that the file cannot tell. Put the dof in its place, or false for '
    "a channel that is to be left out; until then the job does not run."
)


def template(
    task: str = "damage",
    model: str = CHAIN,
    *,
    name: str = "job.toml",
    data: str | None = None,
    channels: Sequence[str] = (),
    excitation: str | None = None,
    band_hz: Sequence[float] | None = None,
    model_file: str | None = None,
    baseline: str | None = None,
    reading: Mapping[str, Any] = FrozenDict(),
) -> str:
    """A job to be filled in: valid as it stands, but for the files it names and dofs that are not given."""
    lines = [
        f"# {_HEAD[task]}: antires {task} {name}",
        "#",
        "# Lines that begin with # are explanations, or keys with their defaults: remove the # to",
        "# change one. Force, band and model that were not given are examples: put your own in their place.",
        "# Paths are relative to this file. Masses, springs, nodes, elements and dofs count from 0.",
        "",
    ]
    file = data or ("records" if task == "series" else "record.uff")
    force = "0" if excitation is None else excitation
    force = force if force.isdecimal() and force not in channels else _quoted(force)
    filled = {
        "data": {"file": _quoted(file), "excitation": force, "band_hz": str([*(band_hz or (3.0, 130.0))])},
        "model": {"kind": _quoted(model)}
        | ({"file": _quoted(model_file)} if model_file else _EXAMPLES[model]),
        "damage": {"baseline": _quoted(baseline)} if baseline else {},
        "search": {"seed": "0"},
        "output": {"folder": _quoted(name.removesuffix(".toml") + "_results")},
    }
    filled["data"] |= {key: json.dumps(value, ensure_ascii=False) for key, value in reading.items()}
    kinds = {"data": reading.get("format") or format_of(file) or "", "model": model}
    if task == "series":  # every format is explained
        kinds, filled["output"] = {}, {}
    if channels:
        dofs = ", ".join(f"{_quoted(channel)} = {_quoted(UNSET)}" for channel in channels)
        filled["data"]["dofs"] = f"{{ {dofs} }}"
    if channels or excitation == UNSET:
        lines += _comment(_QUESTION + _DOFS[model])
    for part in TASKS[task]:
        if part == "parameters":
            lines += _parameters(model)
        else:
            lines += _commented(SECTIONS[part], filled.get(part, {}), kinds.get(part, ""))
        if (part, model) == ("model", FRAME):
            lines += _PIPE.split("\n")
    return "\n".join(lines)


def _parameters(model: str) -> list[str]:
    """An entry of each kind; the first with all its keys."""
    lines: list[str] = []
    for kind, on in _PARAMETERS[model].items():
        chosen = {"kind": _quoted(kind), "bounds": "[0.9, 1.1]", on: '"all"'}
        if on == "sections":
            chosen["relative"] = "true"
        if not lines:
            lines += _commented(PARAMETERS, chosen, kind)
        else:
            lines += ["[[parameters]]", *(f"{name} = {value}" for name, value in chosen.items()), ""]
    return lines


def _commented(section: Section, filled: dict[str, str], of: str) -> list[str]:
    """Its heading and keys; of a kind of model or parameter only those that belong to it."""
    heading = f"[[{section.name}]]" if section.several == "must" else f"[{section.name}]"
    lines = [*_comment(section.help), heading]
    mine = [key for key in section.keys if not of or not key.of or of in key.of]
    for key in (key for key in mine if key.name in filled):
        lines += [*_comment(key.help), f"{key.name} = {filled[key.name]}"]
    rest = {f"# {key.name} = {key.default}": key for key in mine if key.name not in filled}
    width = max(map(len, rest), default=0) + 2
    for left, key in rest.items():
        first, *more = wrap(key.help if of else key.explanation, _WIDTH - width)
        lines.append(f"{left:<{width}}# {first}")
        lines += [f"#{'':<{width - 1}}# {line}" for line in more]
    return [*lines, ""]


def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in wrap(text, _WIDTH)]


def _quoted(text: str) -> str:
    """A TOML string."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
