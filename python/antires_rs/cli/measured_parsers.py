"""Arguments of the commands that read a measurement: ``antires identify`` and ``antires look``."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .usage import dof, edit, number, one_of, pair

__all__ = ["DOF", "identify", "look"]

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
    found.set_defaults(run=command("study", "identify"))


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
