"""Arguments of ``antires``; nothing slow is imported here, so that --help is at once."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from .._core import __version__

__all__ = ["parser"]

_DOF = "a number, or a name as the file has it"


class _Parser(argparse.ArgumentParser):
    """Says what was got, what is wanted, and what to do."""

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse; what is not known is the command's to explain, not that of the program."""
        found, unknown = self.parse_known_args(args, namespace)
        if unknown:
            command = getattr(found, "command", None)
            for action in self._actions:
                if isinstance(action.choices, dict) and command in action.choices:
                    action.choices[command].error(f"unrecognized arguments: {unknown[0]}")
            self.error(f"unrecognized arguments: {unknown[0]}")
        return found

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: error: {self._explained(message)}\n")

    def _explained(self, message: str) -> str:
        see = f"See '{self.prog} --help'."
        if found := re.fullmatch(r"the following arguments are required: (.*)", message):
            name = found[1].split(", ")[0]
            return f"{name}: got nothing; wanted {self._wanted(name)}. {see}"
        if found := re.fullmatch(r"unrecognized arguments: (.*)", message):
            known = [option for action in self._actions for option in action.option_strings]
            near = get_close_matches(found[1].split("=")[0], known, 1, 0.7)
            return (
                f"{found[1]}: got an argument that is not known; wanted those of '{self.prog} --help'. "
                + (f"Did you mean {near[0]!r}?" if near else "Remove it.")
            )
        if found := re.match(r"argument (.*?): invalid choice: (.*?) \(choose from (.*)\)", message):
            got = found[2].split(", maybe")[0]  # newer versions guess too
            known = [part.strip(" '") for part in found[3].split(",")]
            near = get_close_matches(got.strip("'"), known, 1, 0.6)
            return f"{found[1]}: got {got}; wanted one of {', '.join(known)}. " + (
                f"Did you mean {near[0]!r}?" if near else see
            )
        if found := re.match(r"argument (.*?): expected (.*)", message):
            got = "another number of values" if found[2] == "2 arguments" else "no value"
            return f"{found[1]}: got {got}; wanted {self._wanted(found[1])}. {see}"
        if found := re.match(r"argument (.*?): (got .*; wanted .*)", message):
            return f"{found[1]}: {found[2]}. {see}"
        if found := re.match(r"ambiguous option: (\S+) could match (.*)", message):
            return f"{found[1]}: got a short form of several; wanted one of {found[2]}. Write it in full."
        if found := re.match(r"argument (.*?): not allowed with argument (.*)", message):
            return f"{found[1]}: got it together with {found[2]}; wanted one of them. {see}"
        return f"{message}. {see}"

    def _wanted(self, name: str) -> str:
        """What an argument is for, from its help."""
        for action in self._actions:
            names = [*action.option_strings, str(action.metavar), action.dest]
            if name in names or name == "/".join(action.option_strings):
                said = (action.help or "a value").split(" (default")[0]
                return f"{said} ({', '.join(action.choices)})" if isinstance(action.choices, dict) else said
        return "a value"


def parser() -> argparse.ArgumentParser:
    """The parser of ``antires`` and all its commands."""
    top = _Parser(
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
        parser_class=_Parser,
        help="a command",
    )
    _demo(commands)
    _init(commands)
    _identify(commands)
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
        job.set_defaults(run=_command("jobs", "search"), task=task)
    again = commands.add_parser(
        "resume",
        help="go on with a search that was interrupted",
        description="Go on with a search, to the same bits as if it had never stopped.",
    )
    again.add_argument(
        "target", metavar="JOB", type=Path, help="a job file, its results folder or its checkpoint"
    )
    _common(again)
    again.set_defaults(run=_command("jobs", "resume"))
    _report(commands)
    return top


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
        type=_number(int, 0),
        default=0,
        metavar="N",
        help="another structure, another record, another search (default: %(default)s)",
    )
    demo.add_argument(
        "--noise",
        type=_number(float, 0.0, 1.0),
        default=0.01,
        metavar="FRACTION",
        help="sensor noise as a fraction of each channel's rms (default: %(default)s)",
    )
    _common(demo)
    demo.set_defaults(run=_command("study", "demo"))


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
        choices=("damage", "update"),
        default="damage",
        help="what the job is to do (default: %(default)s)",
    )
    init.add_argument(
        "--model",
        choices=("chain", "frame", "matrices", "result"),
        default="chain",
        help="kind of model (default: %(default)s)",
    )
    init.add_argument(
        "--data", type=Path, metavar="FILE", help="a measurement, whose channels are listed in the job"
    )
    init.add_argument("--overwrite", action="store_true", help="replace a job file that exists")
    init.set_defaults(run=_command("jobs", "init"))


def _identify(commands: Any) -> None:
    found = commands.add_parser(
        "identify",
        help="antiresonances of a measurement",
        description="Identify the antiresonances of every response in a file, or of the [data] of a job.",
    )
    found.add_argument(
        "file",
        metavar="FILE",
        type=Path,
        help="a measurement (.uff .unv .mat .h5 .csv .tsv .txt .npz) or a job (.toml)",
    )
    found.add_argument(
        "--band",
        nargs=2,
        type=_number(float, 0.0),
        metavar=("LOW", "HIGH"),
        help="lowest and highest frequency in Hz",
    )
    found.add_argument("--excitation", type=_dof, metavar="DOF", help=f"dof of the one force: {_DOF}")
    found.add_argument(
        "--format",
        choices=("uff", "mat", "hdf5", "csv", "npz"),
        help="format of the file (default: its ending tells)",
    )
    found.add_argument(
        "--dof",
        action="append",
        type=_pair,
        metavar="CHANNEL=DOF",
        dest="dofs",
        help="name a channel's dof, or leave it out by CHANNEL=; once for each channel",
    )
    found.add_argument(
        "--kind",
        choices=("frf", "transmissibility", "time", "spectra"),
        help="what to read, where a file does not tell or holds several",
    )
    found.add_argument(
        "--reference", type=_dof, metavar="DOF", help=f"reference of transmissibilities: {_DOF}"
    )
    found.add_argument("--force", metavar="CHANNEL", help="channel of the force")
    found.add_argument(
        "--fs",
        type=_number(float, 0.0),
        metavar="HZ",
        dest="fs_hz",
        help="sampling rate in Hz, where the file does not tell",
    )
    found.add_argument(
        "--unit", help="unit of the responses, such as g or m/s2, where the file does not tell"
    )
    found.add_argument("--first", choices=("time", "freq", "channel"), help="first column of a CSV file")
    found.add_argument(
        "--preset", choices=("paper", "strict", "sensitive"), help="options of the identification"
    )
    found.add_argument("--max-order", type=_number(int, 2), metavar="N", help="highest order (default: 60)")
    found.add_argument(
        "--second-opinion",
        choices=("aaa", "vector_fitting"),
        help="another method that confirms or flags every value",
    )
    found.add_argument("--out", type=Path, metavar="FILE.json", help="save the antiresonances, for a job")
    found.add_argument(
        "--pictures", type=Path, metavar="DIR", help="draw the stabilization diagrams into a folder"
    )
    found.add_argument("--json", action="store_true", help="print JSON instead of the table")
    found.set_defaults(run=_command("study", "identify"))


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
    report.set_defaults(run=_command("study", "report"))


def _common(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--workers",
        type=_number(int, 1),
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


def _number(kind: Callable[[str], Any], low: float, high: float = float("inf")) -> Callable[[str], Any]:
    """Argument type: a number within limits, or a usage error that says which."""
    what = "an integer" if kind is int else "a number"
    limits = f"of at least {low:g}" if high == float("inf") else f"from {low:g} to {high:g}"

    def parse(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not low <= value <= high or value == float("inf"):
            raise argparse.ArgumentTypeError(f"got {text!r}; wanted {what} {limits}")
        return value

    return parse


def _dof(text: str) -> int | str:
    if re.fullmatch(r"-\d+", text):
        raise argparse.ArgumentTypeError(f"got {text}; wanted a dof of at least 0, or a name")
    return int(text) if re.fullmatch(r"\d+", text) else text


def _pair(text: str) -> tuple[str, int | str | bool]:
    """(channel, dof) of ``channel=dof``; False for a channel that is left out."""
    channel, sign, dof = text.rpartition("=")
    if not sign or not channel:
        raise argparse.ArgumentTypeError(f"got {text!r}; wanted CHANNEL=DOF, such as 12+Z=4")
    return channel, _dof(dof) if dof else False
