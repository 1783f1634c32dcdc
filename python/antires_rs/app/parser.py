"""Arguments of ``antires``; nothing slow is imported before a command is chosen: --help is at once."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from difflib import SequenceMatcher
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from .._core import __version__
from ..support.messages import EDIT_WANTED, edit_named

if TYPE_CHECKING:
    from .keys import Key

# -- Wrong usage of ``antires``: the sentence of argparse, in one line


def complain(error: object, program: str = "antires") -> None:
    """The one line on standard error that ends a command."""
    print(printable(f"{program}: error: {error}"), file=sys.stderr)


#: What moves the cursor of a terminal, colours it, or turns the direction of writing; lines may end.
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


def printable(text: object) -> str:
    r"""A text for a terminal: control characters, which names in files may have, as escapes, ``\x1b``."""
    return _CONTROL.sub(lambda found: repr(found[0])[1:-1], str(text))


class Parser(argparse.ArgumentParser):
    """Ends with one line where it is used wrongly; ``rows`` has the arguments when they are needed."""

    def __init__(self, *args: Any, rows: Callable[[], Iterable[Row]] = tuple, **options: Any) -> None:
        super().__init__(*args, **options | {"allow_abbrev": False})
        self._rows = rows

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse, which refuses here what a command does not know."""
        for flags, how in self._rows():
            self.add_argument(*flags, **how)
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            known = [option for action in self._actions for option in action.option_strings]
            near = nearest(unknown[0].split("=")[0], known, 0.7)
            self.error(f"unknown argument {unknown[0]}. {near}".strip())
        return found, unknown

    def error(self, message: str) -> NoReturn:
        """End the program with a usage error."""
        complain(f"{message}{'' if message[-1] in '.?' else '.'} See '{self.prog} --help'.", self.prog)
        self.exit(2)


def nearest(name: str, known: Iterable[str], likeness: float = 0.6) -> str:
    """A hint at the known name nearest to an unknown one, or two that are as near; '' where none is near."""
    ratios = {one: SequenceMatcher(None, one.lower(), name.lower()).ratio() for one in known}
    least = max(likeness, max(ratios.values(), default=0.0) - 0.03)
    near = [repr(one) for one, ratio in ratios.items() if ratio >= least]
    return f"Did you mean {' or '.join(near[:2])}?" if near else ""


# -- Kinds of values, by the word that stands for them in the help


def _refused(got: str, wanted: str, remedy: str = "") -> argparse.ArgumentTypeError:
    """A value that an argument cannot take; argparse adds which argument that is."""
    return argparse.ArgumentTypeError(f"got {got!r}; wanted {wanted}. {remedy}".strip())


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
            raise _refused(text, f"{what} {limits}")
        return value

    return parse


def one_of(options: Sequence[str]) -> dict[str, Any]:
    """One of a few words."""

    def parse(text: str) -> str:
        if text in options:
            return text
        raise _refused(text, f"one of {', '.join(options)}", nearest(text, options))

    return {"type": parse, "metavar": f"{{{','.join(options)}}}"}


def dof(text: str) -> int | str:
    """A dof by number or name."""
    if text[:1] == "-" and text[1:].isdecimal():
        raise _refused(text, "a dof of at least 0, or a name")
    return int(text) if text.isdecimal() else text


def pair(text: str) -> tuple[str, int | str | bool]:
    """(channel, dof) of ``channel=dof``; False for a channel that is left out."""
    channel, sign, name = text.rpartition("=")
    if not sign or not channel:
        raise _refused(text, "CHANNEL=DOF, such as 12+Z=4")
    return channel, dof(name) if name else False


def edit(text: str) -> str:
    """``DOF=HZ reason``."""
    named = edit_named(text)
    if named is None:
        raise _refused(text, EDIT_WANTED)
    dof(named[0])
    return text


_KINDS: dict[str, Callable[[str], Any]] = {  #: By the word that stands for a value.
    **dict.fromkeys(("DIR", "FILE", "FILE.json", "FILE.html", "FILE.npz", "FOLDER", "JOB", "RESULT"), Path),
    **dict.fromkeys(("DOF", "DOFS", "SENSOR"), dof),
    **dict.fromkeys(("HZ", "LOW", "VALUE"), number(float, 0.0)),
    "FRACTION": number(float, 0.0, 1.0),
    "P": number(float, 1e-6, 0.2),
    "S": number(float, 0.1),
    "CHANNEL=DOF": pair,
    "DOF=HZ": edit,
}
Row = tuple[list[str], dict[str, Any]]  # flags of an argument, and how argparse is to read it


def argument(use: str, about: str, **how: Any) -> Row:
    """An argument from how it is used: ``--fs HZ``, ``--max-order N>=2``, ``job JOB? = job.toml``."""
    use, _, default = use.partition(" = ")
    words = use.split()
    flags = [word for word in words if word.startswith("--")] or words[:1]
    values = [word for word in words[len(flags) :] if word not in ("!", "...")]
    if not values:
        return flags, {"help": about, "action": "store_true"} | how
    first, _, least = values[0].rstrip("?*+").partition(">=")
    if first.startswith("{"):
        how = one_of(first[1:-1].split(",")) | how
    else:
        how = {"metavar": first, "type": number(int, int(least)) if least else _KINDS.get(first)} | how
    if len(values) > 1:
        how |= {"metavar": tuple(values), "nargs": len(values)}
    elif values[0][-1] in "?*+":
        how["nargs"] = values[0][-1]
    if "!" in words:
        how["required"] = True
    if "..." in words:
        how["action"] = "append"
    if default:
        how["default"], about = default, f"{about} (default: %(default)s)"
    return flags, how | {"help": about}


# -- The commands

# ``commands.txt`` has what carries a command out, its line in the list, its page of help, and its arguments:
# "?", "*" and "+" say how many values there may be, "..." that it may be given several times, "!" that it
# must be; "=" has the default.

#: What several commands say.
_SHARED = {
    "job": "job JOB: a job file, TOML",
    "groups": "elset, material, NAME, NAME:density or NAME:thickness; or OWN=NAME, OWN=1,2,7-9 (elements), "
    "OWN=2.1e11 (the number that stands for {OWN})",
    "json": "--json: print JSON instead of the tables",
    "fresh": "--fresh: begin anew, though a search of this job waits",
    "threads": "--workers N>=1: threads of the search (default: all processors); no number depends on it",
    "search": "'antires init' writes one. Ctrl-C hands back the best so far; 'antires resume' goes on from "
    "there.",
    "files": "a measurement (<endings>, or a folder of files of one FRF each), several of one test,",
    "edit": ', with a reason after a blank that is kept in the file: "3=31.9 mains hum"; once for each',
}
_HELP = {  #: What the help says of an argument that it does not take from the sentence of the key of a job.
    "format": "format of the file (default: its ending tells)",
    "excitation": "dof of the one force: a number, or a name as the file has it; of several unknown forces "
    "that act at once as in 0,4",
    "force": "channel of the force",
    "dofs": "name a channel's dof, or leave it out by CHANNEL=; once for each channel",
    "align": "the files are sensors of one test with a clock each: join them by their columns of time, and "
    "make up missed samples; named by what differs between the files",
    "responses": "array, column or channel of the responses, * for any text; once for each (default: all)",
    "roving": "the sensor that stayed while the hammer roved: of a universal file with all hits, of a folder "
    "of FRFs, or of several files, a hit each, which are identified one by one and joined",
}


def measurement_rows(needed: Sequence[str] = (), without: Sequence[str] = ()) -> Iterator[Row]:
    """How a measurement is read and identified: the keys of a job that have a flag, some of them needed."""
    from .keys import DATA, IDENTIFICATION

    keys = (*DATA.keys, *IDENTIFICATION.keys)
    yield from rows_of([key for key in keys if key.name not in without], needed)
    if "hit" in without:
        return
    about = "with --roving: where the force of each file acted, once for each in their order (default: as "
    yield argument("--hit DOF ...", f"{about}universal files state)")


def rows_of(keys: Iterable[Key], needed: Sequence[str] = ()) -> Iterator[Row]:
    """Those of some keys of a job that have a flag."""
    from ..io.options import ENDINGS
    from ..support.options import small

    for key in keys:
        if key.flag:
            how: dict[str, Any] = {"dest": key.name}
            if key.name in needed:
                how["required"] = True
            if key.flag.endswith(" WORD"):
                how |= one_of(key.words)
            elif key.name == "format":
                how |= one_of(list(ENDINGS))
            elif " " not in key.flag:
                how["default"] = None  # a switch that is not given says nothing
            yield argument(key.flag, _HELP.get(key.name, small(key.help).removesuffix(".")), **how)


class Command(NamedTuple):
    """A command as it is declared."""

    does: str
    about: str
    description: str
    arguments: list[str]

    def rows(self) -> Iterator[Row]:
        """Its arguments."""
        for text in self.arguments:
            if text == "<measurement>":
                yield from measurement_rows()
                continue
            if text == "<test>":
                yield from measurement_rows(("excitation", "band_hz"), ("roving", "hit"))
                continue
            if text == "<reading>":
                from .keys import READING

                yield from rows_of(READING)
                continue
            use, _, about = text.partition(": ")
            if "<endings>" in about:
                from .keys import SIGNAL_ENDINGS

                about = about.replace("<endings>", " ".join(SIGNAL_ENDINGS))
            yield argument(use, about)


def _declared(text: str) -> dict[str, Command]:
    commands = {}
    for paragraph in re.split(r"\n(?! )", text.strip()):
        head, *lines = re.sub(r"<(\w+)>", lambda m: _SHARED.get(m[1], m[0]), paragraph).split("\n")
        name, _, about = head.partition(": ")
        name, _, does = name.partition(" ")
        description = " ".join(line.strip() for line in lines if not line.startswith(_DEEP))
        arguments = [line.strip() for line in lines if line.startswith(_DEEP)]
        commands[name] = Command(does.strip("()"), about, description, arguments)
    return commands


_DEEP = 8 * " "
COMMANDS = _declared(Path(__file__).with_name("commands.txt").read_text(encoding="utf-8"))


def parser() -> argparse.ArgumentParser:
    """The parser of ``antires`` and all its commands."""
    top = Parser(
        prog="antires",
        description="Antiresonances from measured responses, model updating, damage location.",
        epilog="Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted.",
    )
    top.add_argument("--version", action="version", version=f"antires {__version__}")
    names: Any = {"title": "commands", "metavar": "COMMAND", "dest": "command", "help": "a command"}
    commands = top.add_subparsers(required=True, parser_class=Parser, **names)
    for name, one in COMMANDS.items():
        added = commands.add_parser(name, help=one.about, description=one.description, rows=one.rows)
        added.set_defaults(does=one.does)
    return top
