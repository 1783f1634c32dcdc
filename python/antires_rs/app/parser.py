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


# -- Arguments of the commands that read a measurement: ``antires identify`` and ``antires look``


DOF = "a number, or a name as the file has it"
_KINDS = (
    ".uff .unv .mat .h5 .csv .tsv .txt .npz .npy .tdms .lvm .wav .xlsx .parquet .mseed, or a folder of files "
    "of one FRF each"
)
Command = Callable[[str, str], Callable[[argparse.Namespace], int]]


def identify(commands: Any, command: Command) -> None:
    """``antires identify``."""
    found = commands.add_parser(
        "identify",
        help="antiresonances of a measurement",
        description="Identify the antiresonances of every response in a file, or of the [data] of a job.",
    )
    found.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        type=Path,
        help=f"a measurement ({_KINDS}), several of one test, or a job (.toml)",
    )
    _measurement(found)
    for option, what in (("drop", "leave a value out"), ("add", "add a value")):
        found.add_argument(
            f"--{option}",
            action="append",
            type=edit,
            metavar="DOF=HZ",
            help=f"{what}, with a reason after a blank that is kept in the file: "
            '"3=31.9 mains hum"; once for each',
        )
    found.add_argument("--out", type=Path, metavar="FILE.json", help="save the antiresonances, for a job")
    found.add_argument(
        "--pictures", type=Path, metavar="DIR", help="draw the stabilization diagrams into a folder"
    )
    found.add_argument("--json", action="store_true", help="print JSON instead of the table")
    found.set_defaults(run=command("studies", "identify"))


def look(commands: Any, command: Command) -> None:
    """``antires look``."""
    found = commands.add_parser(
        "look",
        help="a page to look at a measurement or a result, to add and drop values",
        description="Open a page in the browser of this computer: diagrams, curves and values of a "
        "measurement or a set of antiresonances, which can be edited, or the figures of a result. It ends "
        "with Ctrl-C, or when the page is closed.",
    )
    found.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        type=Path,
        help=f"a measurement ({_KINDS}), several of one test, antiresonances (.json), or a result.npz or "
        "the folder that holds it",
    )
    _measurement(found)
    found.add_argument(
        "--out",
        type=Path,
        metavar="FILE.json",
        help="where the page saves the set (default: by the name of the file, in this folder)",
    )
    found.add_argument(
        "--edits", type=Path, metavar="FILE.json", help="a set that was saved: make its edits again"
    )
    found.add_argument("--no-browser", action="store_true", help="print the address, and open no browser")
    found.set_defaults(run=command("look", "look"))


def _measurement(command: argparse.ArgumentParser) -> None:
    """How a measurement is read and identified."""
    command.add_argument(
        "--band",
        nargs=2,
        type=number(float, 0.0),
        metavar=("LOW", "HIGH"),
        help="lowest and highest frequency in Hz",
    )
    command.add_argument("--excitation", type=dof, metavar="DOF", help=f"dof of the one force: {DOF}")
    command.add_argument(
        "--format",
        **one_of("uff", "mat", "hdf5", "csv", "npz", "tdms", "lvm", "wav", "excel", "parquet", "miniseed"),
        help="format of the file (default: its ending tells)",
    )
    command.add_argument(
        "--dof",
        action="append",
        type=pair,
        metavar="CHANNEL=DOF",
        dest="dofs",
        help="name a channel's dof, or leave it out by CHANNEL=; once for each channel",
    )
    command.add_argument(
        "--kind",
        **one_of("frf", "transmissibility", "time", "spectra"),
        help="what to read, where a file does not tell or holds several",
    )
    command.add_argument(
        "--reference", type=dof, metavar="DOF", help=f"reference of transmissibilities: {DOF}"
    )
    command.add_argument("--force", metavar="CHANNEL", help="channel of the force")
    command.add_argument(
        "--fs",
        type=number(float, 0.0),
        metavar="HZ",
        dest="fs_hz",
        help="sampling rate in Hz, where the file does not tell",
    )
    command.add_argument(
        "--unit", help="unit of the responses, such as g or m/s2, where the file does not tell"
    )
    command.add_argument("--first", **one_of("time", "freq", "channel"), help="first column of a table")
    command.add_argument(
        "--pairs",
        **one_of("real_imag", "magnitude_deg", "magnitude_rad", "db_deg", "db_rad"),
        help="what two neighbouring columns of a CSV file are, where their names do not tell",
    )
    command.add_argument(
        "--df",
        type=number(float, 0.0),
        metavar="HZ",
        dest="df_hz",
        help="spacing of FRFs from 0 Hz on, where the file has no axis",
    )
    command.add_argument(
        "--run",
        type=number(int, 1),
        metavar="N",
        dest="of_run",
        help="which run of a universal file with several, or segment of an .lvm",
    )
    command.add_argument(
        "--responses",
        action="append",
        metavar="NAME",
        help="array or channel of the responses, * for any text; once for each (default: all)",
    )
    command.add_argument(
        "--roving",
        type=dof,
        metavar="SENSOR",
        help="the sensor that stayed while the hammer roved: of a universal file with all hits, or "
        "of several files, a hit each, which are identified one by one and joined",
    )
    command.add_argument(
        "--hit",
        action="append",
        type=dof,
        metavar="DOF",
        help="with --roving: where the force of each file acted, once for each in their order (default: as "
        "universal files state)",
    )
    command.add_argument("--sheet", metavar="NAME", help="sheet of an Excel workbook (default: the first)")
    command.add_argument(
        "--full-scale",
        type=number(float, 0.0),
        metavar="VALUE",
        help="what full scale of a WAV file stands for, in --unit",
    )
    command.add_argument("--pattern", metavar="GLOB", help="which files of a folder (default: *)")
    command.add_argument(
        "--preset", **one_of("paper", "strict", "sensitive"), help="options of the identification"
    )
    command.add_argument(
        "--route",
        **one_of("transmissibility", "frf"),
        help="from the responses alone, or over the force (for a single channel; default: transmissibility)",
    )
    command.add_argument(
        "--max-order", type=number(int, 2), metavar="N", help="highest order (default: as the data want)"
    )
    command.add_argument(
        "--cross-check",
        "--second-opinion",
        **one_of("aaa", "vector_fitting"),
        help="another method that confirms or flags every value",
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
    _demo(commands)
    _init(commands)
    for verb in (identify, look):
        verb(commands, _command)
    for task, what in (
        ("update", "bring a model to the measured antiresonances"),
        ("damage", "locate and size damage"),
    ):
        job = commands.add_parser(
            task,
            help=f"{what}, as a job file says",
            description=f"Carry out a job file: {what}. 'antires init' writes one. Ctrl-C hands back the "
            "best so far; 'antires resume' goes on from there.",
        )
        job.add_argument("job", metavar="JOB", type=Path, help="a job file, TOML")
        job.add_argument("--fresh", action="store_true", help="begin anew, though a search of this job waits")
        _common(job)
        job.set_defaults(run=_command("studies", "search"), task=task)
    series = commands.add_parser(
        "series",
        help="antiresonances of many tests, as a job file says",
        description="Identify all tests of a job with [series]; 'antires init --task series' writes one. Run "
        "again it goes on where it was stopped, and takes in new files.",
    )
    series.add_argument("job", metavar="JOB", type=Path, help="a job file, TOML")
    series.add_argument(
        "--workers",
        type=number(int, 1),
        default=None,
        metavar="N",
        help="processes that identify (default: 1); no number depends on it",
    )
    series.add_argument("--json", action="store_true", help="print JSON instead of the tables")
    series.set_defaults(run=_command("studies", "series"))
    _watch(commands)
    again = commands.add_parser(
        "resume",
        help="go on with a search that was interrupted",
        description="Go on with a search; the result is bit-identical to that of one that never stopped.",
    )
    again.add_argument(
        "target", metavar="JOB", type=Path, help="a job file, its results folder or its checkpoint"
    )
    _common(again)
    again.set_defaults(run=_command("studies", "resume"))
    _report(commands)
    _explain(commands)
    return top


def _watch(commands: Any) -> None:
    watch = commands.add_parser(
        "watch",
        help="identify new files of a folder as they come, and say which differ from the first",
        description="Identify the measurements in a folder, and new ones when they are complete; tell which "
        "differ from the baseline. Ends with Ctrl-C; it may be killed at any time, and goes on where it was.",
    )
    watch.add_argument("folder", metavar="FOLDER", type=Path, help="where the measurements arrive")
    watch.add_argument("--excitation", type=dof, required=True, metavar="DOF", help=f"of the force: {DOF}")
    watch.add_argument(
        "--band", type=number(float, 0.0), nargs=2, required=True, metavar=("LOW", "HIGH"), help="in Hz"
    )
    watch.add_argument(
        "--baseline", type=number(int, 8), default=50, metavar="N", help="first tests (default: %(default)s)"
    )
    watch.add_argument(
        "--rate",
        type=number(float, 1e-6, 0.2),
        default=0.01,
        metavar="P",
        help="of false alarms (default: 0.01)",
    )
    watch.add_argument(
        "--conditions", type=Path, metavar="FILE", help="table of temperatures, by name of the file"
    )
    watch.add_argument(
        "--assessor", type=Path, metavar="FILE", help="saved by Assessor.save: what is damaged, at each alarm"
    )
    watch.add_argument(
        "--out",
        type=Path,
        default=Path("watch_output"),
        metavar="DIR",
        help="series and page (default: %(default)s)",
    )
    watch.add_argument(
        "--every",
        type=number(float, 0.1),
        default=5.0,
        metavar="S",
        help="look at least so often (default: 5)",
    )
    watch.add_argument("--once", action="store_true", help="end when all files that are there are judged")
    watch.set_defaults(run=_command("watch", "watch"))


def _demo(commands: Any) -> None:
    demo = commands.add_parser(
        "demo",
        help="a whole study in a few seconds: record, identify, update, find the damage",
        description="Virtual test of an eight-mass chain: antiresonances from records alone, an updated "
        "model, and the damaged spring. Writes pictures and reports.",
    )
    demo.add_argument(
        "--out",
        type=Path,
        default=Path("demo_output"),
        metavar="DIR",
        help="folder for pictures, reports and summary.json (default: %(default)s)",
    )
    demo.add_argument(
        "--seed",
        type=number(int, 0),
        default=0,
        metavar="N",
        help="another structure, another record, another search (default: %(default)s)",
    )
    demo.add_argument(
        "--noise",
        type=number(float, 0.0, 1.0),
        default=0.01,
        metavar="FRACTION",
        help="sensor noise as a fraction of each channel's rms (default: %(default)s)",
    )
    _common(demo)
    demo.set_defaults(run=_command("studies", "demo"))


def _init(commands: Any) -> None:
    init = commands.add_parser(
        "init",
        help="write a job file with every key explained",
        description="Write a commented job file to be filled in.",
    )
    init.add_argument(
        "job",
        metavar="JOB",
        type=Path,
        nargs="?",
        default=Path("job.toml"),
        help="the file to write (default: %(default)s)",
    )
    init.add_argument(
        "--task",
        **one_of("damage", "update", "series"),
        default="damage",
        help="what the job is to do (default: %(default)s)",
    )
    init.add_argument(
        "--model",
        **one_of("chain", "frame", "matrices", "result"),
        default="chain",
        help="kind of model (default: %(default)s)",
    )
    init.add_argument(
        "--data", type=Path, metavar="FILE", help="a measurement, whose channels are listed in the job"
    )
    init.add_argument("--overwrite", action="store_true", help="replace a job file that exists")
    init.set_defaults(run=_command("studies", "init"))


def _report(commands: Any) -> None:
    report = commands.add_parser(
        "report",
        help="one HTML file of a result",
        description="Write the report of a result: one file that needs nothing else.",
    )
    report.add_argument(
        "result", metavar="RESULT", type=Path, help="a result.npz, or the folder that holds it"
    )
    report.add_argument(
        "--out", type=Path, metavar="FILE.html", help="the file to write (default: beside the result)"
    )
    report.add_argument("--title", help="heading of the report")
    report.add_argument("--pictures", type=Path, metavar="DIR", help="write the pictures as PNG too")
    report.add_argument("--json", action="store_true", help="print JSON instead of the tables")
    report.set_defaults(run=_command("studies", "report"))


def _explain(commands: Any) -> None:
    told = commands.add_parser(
        "explain",
        help="what a warning means",
        description="What is seen, why, and what to do, for the names in brackets at the end of warnings.",
    )
    told.add_argument(
        "names", metavar="NAME", nargs="*", help="of a warning, finding or doubt; without any: all"
    )
    told.set_defaults(run=_command("studies", "explain"))


def _common(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--workers",
        type=number(int, 1),
        default=None,
        metavar="N",
        help="threads of the search (default: all processors); no number depends on it",
    )
    command.add_argument("--json", action="store_true", help="print JSON instead of the tables")


def _command(module: str, name: str) -> Callable[[argparse.Namespace], int]:
    """The function of a command, imported when it is called."""

    def run(args: argparse.Namespace) -> int:
        code: int = getattr(import_module(f"{__package__}.{module}"), name)(args)
        return code

    return run
