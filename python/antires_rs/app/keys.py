"""Every section of a job file, and the sentences that explain it in jobs, help and messages."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from pathlib import Path, PurePath
from textwrap import wrap
from typing import Any

from ..damage.options import ONE_STATE, TWO_STATES, DamagePrior, SearchOptions, options_with
from ..identification.options import declared
from ..io.options import ENDINGS, READERS
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
MODELS = CHAIN, FRAME, MATRICES, RESULT = ("chain", "frame", "matrices", "result")
GROUPS = {  #: Names of several formats, or kinds of parameter, in the declarations below.
    "signals": SIGNALS,
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


# -- The sections as ``job_keys.txt`` declares them, a key a paragraph:
#
#    name (required kind of formats, --flag VALUE) = default: sentence

_DECLARATIONS = Path(__file__).with_name("job_keys.txt")
_DECLARED = re.compile(r"(\w+) \((required )?(\w+)(?: of ([\w ]+))?(?:, (--[^)]+))?\)(?: = (.+?))?: (.+)")


def _sections(words: Mapping[str, str], **inserted: Sequence[Key]) -> dict[str, Section]:
    """Every section; ``<name>`` stands for some words, or for keys that are declared elsewhere."""
    sections = {}
    text = re.sub(r"<(\w+)>", lambda m: words.get(m[1], m[0]), _DECLARATIONS.read_text(encoding="utf-8"))
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
    readers = tuple(kind for kind, reader in READERS.items() if name in signature(reader).parameters)
    named = {**GROUPS, "readers": readers}  # those that have such an option
    groups = tuple(one for word in of.split() for one in named.get(word, (word,)))
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


_PRIOR = ", ".join(f"{name} = {share:g}" for name, share in vars(DamagePrior()).items())
_WORDS = {"endings": " ".join(SIGNAL_ENDINGS), "formats": ", ".join(FORMATS), "prior": f"{{ {_PRIOR} }}"}
SECTIONS = _sections(  #: In the order of a job file.
    _WORDS,
    options=_of_options(declared(), declared()),
    parts=[Key(name, "list", part._in_job, of=(FRAME,)) for name, part in PARTS.items()],
    two_states=_of_options(SearchOptions.declared(), options_with(TWO_STATES)),
    one_state=_of_options(SearchOptions.declared(), options_with(ONE_STATE)),
)
DATA, IDENTIFICATION, PARAMETERS = (SECTIONS[name] for name in ("data", "identification", "parameters"))
#: How a file is read, without places, and the band.
_PLACES = ("excitation", "band_hz", "dofs", "roving")
READING = [key for key in DATA.keys if key.flag and key.name not in _PLACES]
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
    "switch": Kind(
        "true or false", lambda value: isinstance(value, bool), "Write it in small letters, without quotes."
    ),
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
    FRAME: ' Dofs of frames are written as in "node 2 u", along x.',
    MATRICES: ' Dofs are rows of the matrices, from 0, or their names, as "12:Z".',
    RESULT: "",
}
#: Names of channels that are dofs of a frame.
_OF_FRAME = re.compile(r"(?:node\s*)?(\d+)[\s.:_]*(u|v|w|theta|rx|ry|rz)")
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
    known: list[str] = []
    if channels:
        named = [_OF_FRAME.fullmatch(channel) if model == FRAME else None for channel in channels]
        known = [f"node {name[1]} {name[2]}" if name else UNSET for name in named]
        dofs = ", ".join(f"{_quoted(a)} = {_quoted(b)}" for a, b in zip(channels, known, strict=True))
        filled["data"]["dofs"] = f"{{ {dofs} }}"
    if UNSET in (excitation, *known):
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
