"""Values that a job drops and adds by hand, under [data]."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..measured.antiresonance_set import AntiresonanceSet
from ..support.wording import EDIT_WANTED, edit_named
from .job import Job
from .lines import Path as Keys
from .values import shown

__all__ = ["KEYS", "edited"]

#: The keys, and what each does.
KEYS: dict[str, Callable[..., AntiresonanceSet]] = {
    "drop": AntiresonanceSet.drop,
    "add": AntiresonanceSet.add,
}


def edited(
    job: Job, place: Keys, table: dict[str, Any], found: AntiresonanceSet, find: Callable[[Keys, Any], Any]
) -> AntiresonanceSet:
    """The set with the edits of its [data], dropped values first; dofs as the model names them."""
    for key, change in KEYS.items():
        given = table.get(key, [])
        for i, text in enumerate([given] if isinstance(given, str) else given):
            at: Keys = (*place, key) if isinstance(given, str) else (*place, key, i)
            named = edit_named(text)
            if named is None:
                job.reject(at, shown(text), EDIT_WANTED, "Write the dof, =, the frequency, and why.")
            name, freq_hz, reason = named
            with job.blame(place, {"dof": at, "freq_hz": at}):
                dof = find(at, int(name) if name.isdecimal() else name)
                found = change(found, dof, freq_hz, reason=reason)
    return found
