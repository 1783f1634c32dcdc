"""Names of the tests whose lines were printed, kept over a restart."""

from __future__ import annotations

from pathlib import Path

__all__ = ["Told"]


class Told:
    """A name a line; one that a kill has cut short is told again."""

    def __init__(self, path: Path) -> None:
        self._path = path
        text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
        self._names = set(text.split("\n")[:-1])
        if text and not text.endswith("\n"):
            self._write("\n")

    def __contains__(self, name: str) -> bool:
        return name in self._names

    def add(self, name: str) -> None:
        """One more, for good."""
        self._names.add(name)
        self._write(f"{name}\n")

    def _write(self, text: str) -> None:
        with open(self._path, "a", encoding="utf-8", errors="replace") as file:
            file.write(text)
