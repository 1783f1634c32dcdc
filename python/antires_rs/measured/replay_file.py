"""The file of a set with edits that wait beside it: readers of sets leave those aside."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from .antiresonance_set import AntiresonanceSet
from .edits import NAMED_WITHIN
from .replay import Asked, asked_of
from .set_file import damaged, edit_of

__all__ = ["asked_in", "to_json"]

#: Where they stand in the JSON of the set.
KEY = "waiting_edits"


def to_json(zeros: AntiresonanceSet, waiting: Sequence[Asked]) -> str:
    """The text of :meth:`AntiresonanceSet.save`, with what could not be done to this set beside it."""
    text = zeros.to_json()
    if not waiting:
        return text
    rows = [{**asdict(each.edit), "near": each.near, "within": each.within} for each in waiting]
    return json.dumps(json.loads(text) | {KEY: rows}, indent=1, allow_nan=False) + "\n"


def asked_in(path: str | os.PathLike[str]) -> tuple[AntiresonanceSet, tuple[Asked, ...]]:
    """The set of a file, and all edits that were asked for: those it has, then those that wait.

    Raises
    ------
    InvalidInputError, FileNotFoundError
        As :meth:`AntiresonanceSet.load`.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from antires_rs.measured.antiresonance_set import AntiresonanceSet
    >>> from antires_rs.measured.replay import asked_of
    >>> from antires_rs.measured.replay_file import asked_in, to_json
    >>> dropped = asked_of(AntiresonanceSet(0, {0: [8.7, 23.9]}).drop(0, 23.9, reason="hum"))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "zeros.json"
    ...     _ = file.write_text(to_json(AntiresonanceSet(0, {0: [8.7]}), dropped))
    ...     zeros, asked = asked_in(file)
    >>> zeros.edits, asked == dropped
    ((), True)
    """
    zeros = AntiresonanceSet.load(path)
    try:
        rows = json.loads(Path(path).read_text(encoding="utf-8")).get(KEY, ())
        return zeros, (*asked_of(zeros), *map(_asked, rows))
    except (KeyError, TypeError, ValueError, AttributeError) as exc:
        raise damaged(str(path), exc) from exc


def _asked(row: dict[str, Any]) -> Asked:
    near, within = row.pop("near"), row.pop("within")
    if not isinstance(near, int) or not isinstance(within, int | float) or not 0 <= within <= NAMED_WITHIN:
        raise ValueError(f"edit with near = {near!r}, within = {within!r}")
    return Asked(edit_of(row), near, within)
