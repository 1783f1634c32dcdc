"""Arguments of ``antires``; nothing slow is imported here, so that --help is at once."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from .._core import __version__
from ..exceptions import InvalidInputError
from ..support.messages import EDIT_WANTED, edit_named

# -- Wrong usage of ``antires``, said in the fields of every error of the package
#
# argparse hands over sentences. What was wrong is therefore found here from the arguments and what is known
# of them: what they were given as, how many values they take, which are required.


def complain(error: object, program: str = "antires") -> None:
    """The one line on standard error that ends a command."""
    print(f"{program}: error: {error}", file=sys.stderr)


class WrongValue(argparse.ArgumentTypeError):
    """A value that an argument cannot take; argparse adds which argument that is."""

    def __init__(self, got: str, wanted: str, remedy: str = "") -> None:
        super().__init__(got)
        self.got, self.wanted, self.remedy = got, wanted, remedy


class Parser(argparse.ArgumentParser):
    """Says what was got, what is wanted, and what to do."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.exit_on_error = False  # errors are explained here

    @property
    def see(self) -> str:
        """Where more is said."""
        return f"See '{self.prog} --help'."

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse; what is not known is the command's to explain, not that of the program."""
        found, unknown = self.parse_known_args(args, namespace)
        if unknown:
            self._commands().get(str(getattr(found, "command", "")), self).unknown(unknown[0])
        return found

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse, but that a wrong value is said in our fields."""
        given = list(sys.argv[1:] if args is None else args)
        self._check_command(given)
        self._check_short_forms(given)
        try:
            return super().parse_known_args(given, namespace)
        except argparse.ArgumentError as exc:
            self._explain(exc)

    def error(self, message: str) -> NoReturn:
        """What is left for argparse to find itself: a required argument that is not there."""
        missing = next((action for action in self._actions if action.required), None)
        if missing is None:
            self.refuse("arguments", f"what argparse refuses ({message})", "those of --help", self.see)
        self.refuse(_name(missing), "nothing", _use(missing), self.see)

    def refuse(self, argument: str, got: str, wanted: str, remedy: str) -> NoReturn:
        """End the program with a usage error."""
        complain(InvalidInputError(argument, got, wanted, remedy), self.prog)
        self.exit(2)

    def unknown(self, argument: str) -> NoReturn:
        """Refuse an argument that no action takes."""
        near = get_close_matches(argument.split("=")[0], self._options(), 1, 0.7)
        self.refuse(
            argument,
            "an argument that is not known",
            f"those of '{self.prog} --help'",
            f"Did you mean {near[0]!r}?" if near else "Remove it.",
        )

    def _explain(self, exc: argparse.ArgumentError) -> NoReturn:
        wrong, name = exc.__context__, exc.argument_name
        if isinstance(wrong, WrongValue):
            self.refuse(str(name), wrong.got, wrong.wanted, wrong.remedy or self.see)
        action = next((a for a in self._actions if _name(a) == name), None)
        if action is None:  # newer versions say so what is required
            self.error(str(exc))
        alone = action.nargs == 0
        got = "a value" if alone else "no value" if action.nargs is None else "another number of values"
        self.refuse(_name(action), got, "it alone" if alone else _use(action), self.see)

    def _check_command(self, given: Sequence[str]) -> None:
        commands = self._commands()
        if commands and given and not given[0].startswith("-") and given[0] not in commands:
            known = ", ".join(commands)
            near = get_close_matches(given[0], commands, 1, 0.6)
            remedy = f"Did you mean {near[0]!r}?" if near else self.see
            self.refuse("COMMAND", repr(given[0]), f"one of {known}", remedy)

    def _check_short_forms(self, given: Sequence[str]) -> None:
        known = self._options()
        for argument in given[: given.index("--")] if "--" in given else given:
            short = argument.split("=")[0]
            meant = [option for option in known if option.startswith(short)]
            if short.startswith("--") and short not in known and len(meant) > 1:
                wanted = f"one of {', '.join(meant)}"
                self.refuse(short, "a short form of several", wanted, "Write it in full.")

    def _options(self) -> list[str]:
        return [option for action in self._actions for option in action.option_strings]

    def _commands(self) -> dict[str, Parser]:
        return next((a.choices for a in self._actions if isinstance(a.choices, dict)), {})


def _name(action: argparse.Action) -> str:
    return "/".join(action.option_strings) or str(action.metavar or action.dest)


def _use(action: argparse.Action) -> str:
    """What an argument is for, from its help."""
    said = (action.help or "a value").split(" (default")[0]
    return f"{said} ({', '.join(action.choices)})" if isinstance(action.choices, dict) else said


def number(kind: Callable[[str], Any], low: float, high: float = float("inf")) -> Callable[[str], Any]:
    """Argument type: a number within limits."""
    what = "an integer" if kind is int else "a number"
    limits = f"of at least {low:g}" if high == float("inf") else f"from {low:g} to {high:g}"

    def parse(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not low <= value <= high or value == float("inf"):
            raise WrongValue(repr(text), f"{what} {limits}")
        return value

    return parse


def one_of(*options: str) -> dict[str, Any]:
    """Options of ``add_argument`` for one of a few words."""

    def parse(text: str) -> str:
        if text in options:
            return text
        near = get_close_matches(text, options, 1, 0.6)
        remedy = f"Did you mean {near[0]!r}?" if near else ""
        raise WrongValue(repr(text), f"one of {', '.join(options)}", remedy)

    return {"type": parse, "metavar": f"{{{','.join(options)}}}"}


def dof(text: str) -> int | str:
    """Argument type: a dof by number or name."""
    if text[:1] == "-" and text[1:].isdecimal():
        raise WrongValue(text, "a dof of at least 0, or a name")
    return int(text) if text.isdecimal() else text


def pair(text: str) -> tuple[str, int | str | bool]:
    """(channel, dof) of ``channel=dof``; False for a channel that is left out."""
    channel, sign, name = text.rpartition("=")
    if not sign or not channel:
        raise WrongValue(repr(text), "CHANNEL=DOF, such as 12+Z=4")
    return channel, dof(name) if name else False


def edit(text: str) -> tuple[int | str, float, str]:
    """(dof, frequency in Hz, reason) of ``DOF=HZ reason``."""
    named = edit_named(text)
    if named is None:
        raise WrongValue(repr(text), EDIT_WANTED)
    name, freq_hz, reason = named
    return dof(name), freq_hz, reason


# -- Arguments of the commands, each with its help and how it is read


DOF = "a number, or a name as the file has it"
_KINDS = (
    ".uff .unv .mat .h5 .csv .tsv .txt .npz .npy .tdms .lvm .wav .xlsx .parquet .mseed, or a folder of files "
    "of one FRF each"
)
Row = tuple[str, str, dict[str, Any]]
_ONCE_EACH: dict[str, Any] = {"action": "append"}
_SWITCH: dict[str, Any] = {"action": "store_true"}
_DOF: dict[str, Any] = {"type": dof, "metavar": "DOF"}
_HZ: dict[str, Any] = {"type": number(float, 0.0), "metavar": "HZ"}
_BAND: dict[str, Any] = {"nargs": 2, "type": number(float, 0.0), "metavar": ("LOW", "HIGH")}


def _path(metavar: str, **more: Any) -> dict[str, Any]:
    return {"type": Path, "metavar": metavar, **more}


def _count(least: int, **more: Any) -> dict[str, Any]:
    return {"type": number(int, least), "metavar": "N", **more}


#: How a measurement is read and identified.
_MEASUREMENT: tuple[Row, ...] = (
    ("--band", "lowest and highest frequency in Hz", _BAND),
    ("--excitation", f"dof of the one force: {DOF}", _DOF),
    (
        "--format",
        "format of the file (default: its ending tells)",
        one_of("uff", "mat", "hdf5", "csv", "npz", "tdms", "lvm", "wav", "excel", "parquet", "miniseed"),
    ),
    (
        "--dof",
        "name a channel's dof, or leave it out by CHANNEL=; once for each channel",
        {"type": pair, "metavar": "CHANNEL=DOF", "dest": "dofs"} | _ONCE_EACH,
    ),
    (
        "--kind",
        "what to read, where a file does not tell or holds several",
        one_of("frf", "transmissibility", "time", "spectra"),
    ),
    ("--reference", f"reference of transmissibilities: {DOF}", _DOF),
    ("--force", "channel of the force", {"metavar": "CHANNEL"}),
    ("--fs", "sampling rate in Hz, where the file does not tell", _HZ | {"dest": "fs_hz"}),
    ("--unit", "unit of the responses, such as g or m/s2, where the file does not tell", {}),
    ("--first", "first column of a table", one_of("time", "freq", "channel")),
    (
        "--pairs",
        "what two neighbouring columns of a CSV file are, where their names do not tell",
        one_of("real_imag", "magnitude_deg", "magnitude_rad", "db_deg", "db_rad"),
    ),
    ("--df", "spacing of FRFs from 0 Hz on, where the file has no axis", _HZ | {"dest": "df_hz"}),
    ("--run", "which run of a universal file with several, or segment of an .lvm", _count(1, dest="of_run")),
    (
        "--responses",
        "array or channel of the responses, * for any text; once for each (default: all)",
        {"metavar": "NAME"} | _ONCE_EACH,
    ),
    (
        "--roving",
        "the sensor that stayed while the hammer roved: of a universal file with all hits, or of several "
        "files, a hit each, which are identified one by one and joined",
        {"type": dof, "metavar": "SENSOR"},
    ),
    (
        "--hit",
        "with --roving: where the force of each file acted, once for each in their order (default: as "
        "universal files state)",
        _DOF | _ONCE_EACH,
    ),
    ("--sheet", "sheet of an Excel workbook (default: the first)", {"metavar": "NAME"}),
    (
        "--full-scale",
        "what full scale of a WAV file stands for, in --unit",
        {"type": number(float, 0.0), "metavar": "VALUE"},
    ),
    ("--pattern", "which files of a folder (default: *)", {"metavar": "GLOB"}),
    ("--preset", "options of the identification", one_of("paper", "strict", "sensitive")),
    (
        "--route",
        "from the responses alone, or over the force (for a single channel; default: transmissibility)",
        one_of("transmissibility", "frf"),
    ),
    ("--max-order", "highest order (default: as the data want)", _count(2)),
    (
        "--cross-check --second-opinion",
        "another method that confirms or flags every value",
        one_of("aaa", "vector_fitting"),
    ),
)
_JSON: Row = ("--json", "print JSON instead of the tables", _SWITCH)
_THREADS: Row = (
    "--workers",
    "threads of the search (default: all processors); no number depends on it",
    _count(1, default=None),
)
_JOB: Row = ("job", "a job file, TOML", _path("JOB"))
_EDIT = ', with a reason after a blank that is kept in the file: "3=31.9 mains hum"; once for each'
_EDITS = {"type": edit, "metavar": "DOF=HZ"} | _ONCE_EACH


def parser() -> argparse.ArgumentParser:
    """The parser of ``antires`` and all its commands."""
    top = Parser(
        prog="antires",
        description="Antiresonances from measured responses, model updating, damage location.",
        epilog="Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted.",
    )
    top.add_argument("--version", action="version", version=f"antires {__version__}")
    commands = top.add_subparsers(
        title="commands",
        metavar="COMMAND",
        dest="command",
        required=True,
        parser_class=Parser,
        help="a command",
    )

    def add(name: str, what: str, description: str, does: tuple[str, str], *rows: Row) -> Any:
        """A command: its line in the list, its page of help, its function, its arguments."""
        command = commands.add_parser(name, help=what, description=description)
        for flags, about, how in rows:
            command.add_argument(*flags.split(), help=about, **how)
        command.set_defaults(run=_command(*does))
        return command

    add(
        "demo",
        "a whole study in a few seconds: record, identify, update, find the damage",
        "Virtual test of an eight-mass chain: antiresonances from records alone, an updated model, and the "
        "damaged spring. Writes pictures and reports.",
        ("studies", "demo"),
        (
            "--out",
            "folder for pictures, reports and summary.json (default: %(default)s)",
            _path("DIR", default=Path("demo_output")),
        ),
        (
            "--seed",
            "another structure, another record, another search (default: %(default)s)",
            _count(0, default=0),
        ),
        (
            "--noise",
            "sensor noise as a fraction of each channel's rms (default: %(default)s)",
            {"type": number(float, 0.0, 1.0), "default": 0.01, "metavar": "FRACTION"},
        ),
        _THREADS,
        _JSON,
    )
    add(
        "init",
        "write a job file with every key explained",
        "Write a commented job file to be filled in.",
        ("studies", "init"),
        (
            "job",
            "the file to write (default: %(default)s)",
            _path("JOB", nargs="?", default=Path("job.toml")),
        ),
        (
            "--task",
            "what the job is to do (default: %(default)s)",
            one_of("damage", "update", "series") | {"default": "damage"},
        ),
        (
            "--model",
            "kind of model (default: %(default)s)",
            one_of("chain", "frame", "matrices", "result") | {"default": "chain"},
        ),
        ("--data", "a measurement, whose channels are listed in the job", _path("FILE")),
        ("--overwrite", "replace a job file that exists", _SWITCH),
    )
    add(
        "identify",
        "antiresonances of a measurement",
        "Identify the antiresonances of every response in a file, or of the [data] of a job.",
        ("studies", "identify"),
        (
            "files",
            f"a measurement ({_KINDS}), several of one test, or a job (.toml)",
            _path("FILE", nargs="+"),
        ),
        *_MEASUREMENT,
        ("--drop", "leave a value out" + _EDIT, _EDITS),
        ("--add", "add a value" + _EDIT, _EDITS),
        ("--out", "save the antiresonances, for a job", _path("FILE.json")),
        ("--pictures", "draw the stabilization diagrams into a folder", _path("DIR")),
        ("--json", "print JSON instead of the table", _SWITCH),
    )
    add(
        "look",
        "a page to look at a measurement or a result, to add and drop values",
        "Open a page in the browser of this computer: diagrams, curves and values of a measurement or a set "
        "of antiresonances, which can be edited, or the figures of a result. It ends with Ctrl-C, or when "
        "the page is closed.",
        ("look", "look"),
        (
            "files",
            f"a measurement ({_KINDS}), several of one test, antiresonances (.json), or a result.npz or the "
            "folder that holds it",
            _path("FILE", nargs="+"),
        ),
        *_MEASUREMENT,
        (
            "--out",
            "where the page saves the set (default: by the name of the file, in this folder)",
            _path("FILE.json"),
        ),
        ("--edits", "a set that was saved: make its edits again", _path("FILE.json")),
        ("--no-browser", "print the address, and open no browser", _SWITCH),
    )
    for task, what in (
        ("update", "bring a model to the measured antiresonances"),
        ("damage", "locate and size damage"),
    ):
        add(
            task,
            f"{what}, as a job file says",
            f"Carry out a job file: {what}. 'antires init' writes one. Ctrl-C hands back the best so far; "
            "'antires resume' goes on from there.",
            ("studies", "search"),
            _JOB,
            ("--fresh", "begin anew, though a search of this job waits", _SWITCH),
            _THREADS,
            _JSON,
        ).set_defaults(task=task)
    add(
        "series",
        "antiresonances of many tests, as a job file says",
        "Identify all tests of a job with [series]; 'antires init --task series' writes one. Run again it "
        "goes on where it was stopped, and takes in new files.",
        ("studies", "series"),
        _JOB,
        (
            "--workers",
            "processes that identify (default: 1); no number depends on it",
            _count(1, default=None),
        ),
        _JSON,
    )
    add(
        "watch",
        "identify new files of a folder as they come, and say which differ from the first",
        "Identify the measurements in a folder, and new ones when they are complete; tell which differ from "
        "the baseline. Ends with Ctrl-C; it may be killed at any time, and goes on where it was.",
        ("watch", "watch"),
        ("folder", "where the measurements arrive", _path("FOLDER")),
        ("--excitation", f"of the force: {DOF}", _DOF | {"required": True}),
        ("--band", "in Hz", _BAND | {"required": True}),
        ("--baseline", "first tests (default: %(default)s)", _count(8, default=50)),
        (
            "--rate",
            "of false alarms (default: 0.01)",
            {"type": number(float, 1e-6, 0.2), "default": 0.01, "metavar": "P"},
        ),
        ("--conditions", "table of temperatures, by name of the file", _path("FILE")),
        ("--assessor", "saved by Assessor.save: what is damaged, at each alarm", _path("FILE")),
        ("--out", "series and page (default: %(default)s)", _path("DIR", default=Path("watch_output"))),
        (
            "--every",
            "look at least so often (default: 5)",
            {"type": number(float, 0.1), "default": 5.0, "metavar": "S"},
        ),
        ("--once", "end when all files that are there are judged", _SWITCH),
    )
    add(
        "resume",
        "go on with a search that was interrupted",
        "Go on with a search; the result is bit-identical to that of one that never stopped.",
        ("studies", "resume"),
        ("target", "a job file, its results folder or its checkpoint", _path("JOB")),
        _THREADS,
        _JSON,
    )
    add(
        "report",
        "one HTML file of a result",
        "Write the report of a result: one file that needs nothing else.",
        ("studies", "report"),
        ("result", "a result.npz, or the folder that holds it", _path("RESULT")),
        ("--out", "the file to write (default: beside the result)", _path("FILE.html")),
        ("--title", "heading of the report", {}),
        ("--pictures", "write the pictures as PNG too", _path("DIR")),
        _JSON,
    )
    add(
        "explain",
        "what a warning means",
        "What is seen, why, and what to do, for the names in brackets at the end of warnings.",
        ("studies", "explain"),
        ("names", "of a warning, finding or doubt; without any: all", {"metavar": "NAME", "nargs": "*"}),
    )
    return top


def _command(module: str, name: str) -> Callable[[argparse.Namespace], int]:
    """The function of a command, imported when it is called."""

    def run(args: argparse.Namespace) -> int:
        code: int = getattr(import_module(f"{__package__}.{module}"), name)(args)
        return code

    return run
