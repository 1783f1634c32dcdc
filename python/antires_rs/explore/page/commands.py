"""What the page may ask for: each command by name, its arguments checked, in plain data both ways."""

from __future__ import annotations

import math
from collections.abc import Callable
from threading import Lock
from typing import Any

from ...support.validation import reject
from ..canvas import item
from ..evidence import evidence_figure
from .picks import Click
from .session import Session
from .sight import Sight
from .told import told
from .view import Arguments

__all__ = ["SetView"]

#: No number of a response, an edit or an order is larger.
MOST = 1_000_000


class SetView:
    """The page of a set."""

    slow = frozenset({"identify"})

    def __init__(self, session: Session, title: str) -> None:
        self.session, self.title = session, title
        self._drawing = Lock()
        self._drawn: tuple[Sight, int, dict[str, Any]] | None = None
        self._commands: dict[str, Callable[[Arguments], str | None]] = {
            "click": self._click,
            "drop": lambda a: session.drop(self._dof(a), _number(a, "freq_hz"), _text(a, "reason")),
            "add": lambda a: session.add(self._dof(a), _number(a, "freq_hz"), _text(a, "reason")),
            "take_back": lambda a: session.take_back(_whole(a, "number")),
            "reword": lambda a: session.reword(_whole(a, "number"), _text(a, "reason")),
            "identify": self._identify,
            "undo": lambda a: session.undo(),
            "redo": lambda a: session.redo(),
            "save": lambda a: session.save(replace_file=a.get("replace") is True),
        }

    def state(self, shown: int) -> dict[str, Any]:
        """See :func:`~antires_rs.explore.page.told.told`."""
        return told(self.session, self._at(shown))

    def figure(self, shown: int) -> dict[str, Any]:
        """Everything that speaks for the values of a response."""
        with self._drawing:
            now = self.session.now
            if self._drawn is None or self._drawn[0] is not now or self._drawn[1] != shown:
                self._drawn = (now, shown, self._figure(shown))
            return self._drawn[2]

    def _figure(self, shown: int) -> dict[str, Any]:
        session, dof = self.session, self._at(shown)
        response = None if session.source is None else session.source.response
        return item(
            evidence_figure(
                session.zeros, dof, session.curve(dof), response, session.now.band_hz, every_kind=True
            )
        )

    def do(self, command: str, arguments: Arguments) -> str:
        """One of the commands above.

        Raises
        ------
        AntiresError
            What the command itself refuses; a command or an argument that is none.
        """
        if command not in self._commands:
            reject("command", command, f"one of {', '.join(self._commands)}", "Load the page again.")
        return self._commands[command](arguments) or ""

    def file(self) -> tuple[str, str]:
        """What :meth:`~antires_rs.explore.page.session.Session.save` writes."""
        path = self.session.file.path
        return "antiresonances.json" if path is None else path.name, self.session.text

    def _click(self, a: Arguments) -> str:
        names = ("x", "y", "x_per_px", "y_per_px")
        click = Click(_text(a, "figure"), *(_number(a, name) for name in names))
        said = self.session.click(self._dof(a), click, _text(a, "reason"))
        return said or "nothing there: click a pole, a dip or the line of a value"

    def _identify(self, a: Arguments) -> str:
        order = a.get("max_order")
        band = None if a.get("low_hz") is None else (_number(a, "low_hz"), _number(a, "high_hz"))
        return self.session.identify(band, None if order is None else _whole(a, "max_order"))

    def _dof(self, a: Arguments) -> Any:
        return self._at(_whole(a, "dof"))

    def _at(self, number: int) -> Any:
        dofs = list(self.session.zeros)
        if not 0 <= number < len(dofs):
            reject("dof", number, f"a response from 0 to {len(dofs) - 1}", "Load the page again.")
        return dofs[number]


def _number(a: Arguments, name: str) -> float:
    value = a.get(name)
    try:
        if not isinstance(value, bool) and isinstance(value, int | float) and math.isfinite(value):
            return float(value)
    except OverflowError:  # a whole number beyond all floats
        value = "a number of hundreds of digits"
    reject(name, value, "a finite number", "Type a number.")


def _whole(a: Arguments, name: str) -> int:
    value = a.get(name)
    if isinstance(value, bool) or not isinstance(value, int) or abs(value) > MOST:
        reject(name, value, f"a whole number of at most {MOST:,}", "Type a smaller one.")
    return value


def _text(a: Arguments, name: str) -> str:
    value = a.get(name, "")
    if not isinstance(value, str) or len(value) > 1000:
        reject(name, type(value).__name__, "a text of at most 1,000 characters", "Shorten it.")
    return value
