"""Arguments of ``antires``; nothing slow is imported here, so that --help is at once."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from .._core import __version__
from .measured_parsers import DOF, identify, look
from .usage import Parser, dof, number, one_of

__all__ = ["parser"]


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
        job.set_defaults(run=_command("jobs", "search"), task=task)
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
    series.set_defaults(run=_command("series", "series"))
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
    again.set_defaults(run=_command("jobs", "resume"))
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
    init.set_defaults(run=_command("jobs", "init"))


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


def _explain(commands: Any) -> None:
    told = commands.add_parser(
        "explain",
        help="what a warning means",
        description="What is seen, why, and what to do, for the names in brackets at the end of warnings.",
    )
    told.add_argument(
        "names", metavar="NAME", nargs="*", help="of a warning, finding or doubt; without any: all"
    )
    told.set_defaults(run=_command("explain", "explain"))


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
