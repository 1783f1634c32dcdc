"""Arguments of ``antires``; nothing slow is imported before a command is chosen: --help is at once."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
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
    """Says what was got, what is wanted, and what to do; ``rows`` has the arguments when they are needed."""

    def __init__(self, *args: Any, rows: Callable[[], Iterable[Row]] = tuple, **options: Any) -> None:
        super().__init__(*args, **options)
        self.exit_on_error = False  # errors are explained here
        self._rows = rows

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
        for flags, how in self._rows():
            self.add_argument(*flags, **how)
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
        remedy = _nearest(argument.split("=")[0], self._options(), 0.7) or "Remove it."
        self.refuse(argument, "an argument that is not known", f"those of '{self.prog} --help'", remedy)

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
            remedy = _nearest(given[0], commands) or self.see
            self.refuse("COMMAND", repr(given[0]), f"one of {', '.join(commands)}", remedy)

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
    use = (action.help or "a value").split(" (default")[0].split(": ")[0]
    return f"{use} ({', '.join(action.choices)})" if isinstance(action.choices, dict) else use


def _nearest(name: str, known: Iterable[str], likeness: float = 0.6) -> str:
    near = get_close_matches(name, known, 1, likeness)
    return f"Did you mean {near[0]!r}?" if near else ""


# -- Kinds of values, by the word that stands for them in the help


def number(kind: Callable[[str], Any], low: float, high: float = float("inf")) -> Callable[[str], Any]:
    """A number within limits."""
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


def one_of(options: Sequence[str]) -> dict[str, Any]:
    """One of a few words."""

    def parse(text: str) -> str:
        if text in options:
            return text
        raise WrongValue(repr(text), f"one of {', '.join(options)}", _nearest(text, options))

    return {"type": parse, "metavar": f"{{{','.join(options)}}}"}


def dof(text: str) -> int | str:
    """A dof by number or name."""
    if text[:1] == "-" and text[1:].isdecimal():
        raise WrongValue(text, "a dof of at least 0, or a name")
    return int(text) if text.isdecimal() else text


def pair(text: str) -> tuple[str, int | str | bool]:
    """(channel, dof) of ``channel=dof``; False for a channel that is left out."""
    channel, sign, name = text.rpartition("=")
    if not sign or not channel:
        raise WrongValue(repr(text), "CHANNEL=DOF, such as 12+Z=4")
    return channel, dof(name) if name else False


def edit(text: str) -> str:
    """``DOF=HZ reason``."""
    named = edit_named(text)
    if named is None:
        raise WrongValue(repr(text), EDIT_WANTED)
    dof(named[0])
    return text


_KINDS: dict[str, Callable[[str], Any]] = {
    **dict.fromkeys(("DIR", "FILE", "FILE.json", "FILE.html", "FOLDER", "JOB", "RESULT"), Path),
    **dict.fromkeys(("DOF", "SENSOR"), dof),
    **dict.fromkeys(("HZ", "LOW", "VALUE"), number(float, 0.0)),
    "CHANNEL=DOF": pair,
    "DOF=HZ": edit,
}
#: Flags of an argument, and how argparse is to read it.
Row = tuple[list[str], dict[str, Any]]


def argument(use: str, about: str, default: str | None = None, **how: Any) -> Row:
    """An argument from how it is used, as in ``--fs HZ``, ``--max-order N>=2`` or ``job JOB``."""
    words = use.split()
    flags = [word for word in words if word.startswith("--")] or words[:1]
    values = words[len(flags) :]
    if not values and "type" not in how:
        return flags, {"help": about, "action": "store_true"}
    if values:
        metavar, _, least = values[0].partition(">=")
        kind = number(int, int(least)) if least else _KINDS.get(metavar)
        how = {"metavar": metavar if len(values) == 1 else tuple(values), "type": kind} | how
        if len(values) > 1:
            how["nargs"] = len(values)
    if default is not None:
        how["default"], about = default, f"{about} (default: %(default)s)"
    return flags, how | {"help": about}


# -- The commands


_DATA = (
    "a measurement (.uff .unv .mat .h5 .csv .tsv .txt .npz .npy .tdms .lvm .wav .xlsx .parquet .mseed, or a "
    "folder of files of one FRF each), several of one test, "
)
_JSON = argument("--json", "print JSON instead of the tables")
_JOB = argument("job JOB", "a job file, TOML")
_THREADS = argument(
    "--workers N>=1", "threads of the search (default: all processors); no number depends on it"
)
_ONCE_EACH: dict[str, Any] = {"action": "append"}
_EDIT = ', with a reason after a blank that is kept in the file: "3=31.9 mains hum"; once for each'
_EDITS = (
    argument("--drop DOF=HZ", f"leave a value out{_EDIT}", **_ONCE_EACH),
    argument("--add DOF=HZ", f"add a value{_EDIT}", **_ONCE_EACH),
)
#: What the help says of an argument that it does not take from the sentence of the key of a job.
_HELP = {
    "format": "format of the file (default: its ending tells)",
    "excitation": "dof of the one force: a number, or a name as the file has it",
    "force": "channel of the force",
    "dofs": "name a channel's dof, or leave it out by CHANNEL=; once for each channel",
    "responses": "array or channel of the responses, * for any text; once for each (default: all)",
    "roving": "the sensor that stayed while the hammer roved: of a universal file with all hits, or of "
    "several files, a hit each, which are identified one by one and joined",
}


def measurement_rows() -> Iterable[Row]:
    """How a measurement is read and identified: the keys of a job that have a flag."""
    from ..io.registry import ENDINGS
    from .keys import DATA, IDENTIFICATION, small

    for key in (*DATA.keys, *IDENTIFICATION.keys):
        if key.flag:
            how: dict[str, Any] = {"dest": key.name}
            if key.name in ("dofs", "responses"):
                how |= _ONCE_EACH
            if key.flag.endswith(" WORD"):
                how |= one_of(key.words)
            elif key.name == "format":
                how |= one_of(list(ENDINGS))
            yield argument(key.flag, _HELP.get(key.name, small(key.help).removesuffix(".")), **how)
    yield argument(
        "--hit DOF",
        "with --roving: where the force of each file acted, once for each in their order (default: as "
        "universal files state)",
        **_ONCE_EACH,
    )


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
    for name, (does, what, description, rows) in COMMANDS.items():
        one = commands.add_parser(name, help=what, description=description, rows=rows)
        one.set_defaults(does=_command(does))
    return top


def _command(does: str) -> Callable[[argparse.Namespace], int]:
    """The function of a command, ``module:name``, imported when it is called."""

    def run(args: argparse.Namespace) -> int:
        module, _, name = does.partition(":")
        code: int = getattr(import_module(f"{__package__}.{module}"), name)(args)
        return code

    return run


def _search(what: str) -> tuple[str, str, str, Callable[[], Iterable[Row]]]:
    return (
        "run:search",
        f"{what}, as a job file says",
        f"Carry out a job file: {what}. 'antires init' writes one. Ctrl-C hands back the best so far; "
        "'antires resume' goes on from there.",
        lambda: [_JOB, argument("--fresh", "begin anew, though a search of this job waits"), _THREADS, _JSON],
    )


#: By name: what carries it out, its line in the list, its page of help, its arguments.
COMMANDS: dict[str, tuple[str, str, str, Callable[[], Iterable[Row]]]] = {
    "demo": (
        "demo:demo",
        "a whole study in a few seconds: record, identify, update, find the damage",
        "Virtual test of an eight-mass chain: antiresonances from records alone, an updated model, and the "
        "damaged spring. Writes pictures and reports.",
        lambda: [
            argument("--out DIR", "folder for pictures, reports and summary.json", "demo_output"),
            argument("--seed N>=0", "another structure, another record, another search", "0"),
            argument(
                "--noise FRACTION",
                "sensor noise as a fraction of each channel's rms",
                "0.01",
                type=number(float, 0.0, 1.0),
            ),
            _THREADS,
            _JSON,
        ],
    ),
    "init": (
        "studies:init",
        "write a job file with every key explained",
        "Write a commented job file to be filled in.",
        lambda: [
            argument("job JOB", "the file to write", "job.toml", nargs="?"),
            argument("--task", "what the job is to do", "damage", **one_of(("damage", "update", "series"))),
            argument("--model", "kind of model", "chain", **one_of(("chain", "frame", "matrices", "result"))),
            argument("--data FILE", "a measurement, whose channels are listed in the job"),
            argument("--overwrite", "replace a job file that exists"),
        ],
    ),
    "identify": (
        "studies:identify",
        "antiresonances of a measurement",
        "Identify the antiresonances of every response in a file, or of the [data] of a job.",
        lambda: [
            argument("files FILE", f"{_DATA}or a job (.toml)", nargs="+"),
            *measurement_rows(),
            *_EDITS,
            argument("--out FILE.json", "save the antiresonances, for a job"),
            argument("--pictures DIR", "draw the stabilization diagrams into a folder"),
            _JSON,
        ],
    ),
    "look": (
        "look:look",
        "a page to look at a measurement or a result, to add and drop values",
        "Open a page in the browser of this computer: diagrams, curves and values of a measurement or a set "
        "of antiresonances, which can be edited, or the figures of a result. It ends with Ctrl-C, or when "
        "the page is closed.",
        lambda: [
            argument(
                "files FILE",
                f"{_DATA}antiresonances (.json), or a result.npz or the folder that holds it",
                nargs="+",
            ),
            *measurement_rows(),
            argument(
                "--out FILE.json",
                "where the page saves the set (default: by the name of the file, in this folder)",
            ),
            argument("--edits FILE.json", "a set that was saved: make its edits again"),
            argument("--no-browser", "print the address, and open no browser"),
        ],
    ),
    "update": _search("bring a model to the measured antiresonances"),
    "damage": _search("locate and size damage"),
    "series": (
        "series:series",
        "antiresonances of many tests, as a job file says",
        "Identify all tests of a job with [series]; 'antires init --task series' writes one. Run again it "
        "goes on where it was stopped, and takes in new files.",
        lambda: [
            _JOB,
            argument("--workers N>=1", "processes that identify (default: 1); no number depends on it"),
            _JSON,
        ],
    ),
    "watch": (
        "watch:watch",
        "identify new files of a folder as they come, and say which differ from the first",
        "Identify the measurements in a folder, and new ones when they are complete; tell which differ from "
        "the baseline. Ends with Ctrl-C; it may be killed at any time, and goes on where it was.",
        lambda: [
            argument("folder FOLDER", "where the measurements arrive"),
            argument(
                "--excitation DOF", "dof of the force: a number, or a name as the file has it", required=True
            ),
            argument("--band LOW HIGH", "lowest and highest frequency in Hz", required=True),
            argument("--baseline N>=8", "first tests", "50"),
            argument("--rate P", "of false alarms", "0.01", type=number(float, 1e-6, 0.2)),
            argument("--conditions FILE", "table of temperatures, by name of the file"),
            argument("--assessor FILE", "saved by Assessor.save: what is damaged, at each alarm"),
            argument("--out DIR", "series and page", "watch_output"),
            argument("--every S", "look at least so often", "5", type=number(float, 0.1)),
            argument("--once", "end when all files that are there are judged"),
        ],
    ),
    "resume": (
        "run:resume",
        "go on with a search that was interrupted",
        "Go on with a search; the result is bit-identical to that of one that never stopped.",
        lambda: [argument("target JOB", "a job file, its results folder or its checkpoint"), _THREADS, _JSON],
    ),
    "report": (
        "studies:report",
        "one HTML file of a result",
        "Write the report of a result: one file that needs nothing else.",
        lambda: [
            argument("result RESULT", "a result.npz, or the folder that holds it"),
            argument("--out FILE.html", "the file to write (default: beside the result)"),
            argument("--title TITLE", "heading of the report"),
            argument("--pictures DIR", "write the pictures as PNG too"),
            _JSON,
        ],
    ),
    "explain": (
        "studies:explain",
        "what a warning means",
        "What is seen, why, and what to do, for the names in brackets at the end of warnings.",
        lambda: [argument("names NAME", "of a warning, finding or doubt; without any: all", nargs="*")],
    ),
}
