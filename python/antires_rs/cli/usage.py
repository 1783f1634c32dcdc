"""Wrong usage of ``antires``, said in the fields of every error of the package.

argparse hands over sentences. What was wrong is therefore found here from the arguments and what is known of
them: what they were given as, how many values they take, which are required.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

from ..exceptions import InvalidInputError
from ..support.wording import EDIT_WANTED, edit_named

__all__ = ["Parser", "WrongValue", "complain", "dof", "edit", "number", "one_of", "pair"]


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
