"""What a key and a section of a job file are: name, kind of value, and the sentence that explains it."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Key", "Section"]


@dataclass(frozen=True)
class Key:
    """One key.

    Attributes
    ----------
    name : str
    kind : str
        One of :data:`antires_rs.jobs.values.KINDS`.
    help : str
        A sentence: what belongs here.
    default : str
        As it would be written; '' where there is none.
    required : bool
    of : tuple of str
        Kinds of model or parameter, or formats, to which the key belongs; empty for all.
    """

    name: str
    kind: str
    help: str
    default: str = ""
    required: bool = False
    of: tuple[str, ...] = ()

    @property
    def explanation(self) -> str:
        """The sentence, and to what the key belongs."""
        if not self.of:
            return self.help
        first = self.help[0].lower() if self.help[1].islower() else self.help[0]
        return f"For {', '.join(self.of)}: {first}{self.help[1:]}"


@dataclass(frozen=True)
class Section:
    """One table of a job.

    Attributes
    ----------
    name : str
    help : str
    keys : tuple of Key
    several : {"no", "may", "must"}
        Whether it is an array of tables, [[name]].
    """

    name: str
    help: str
    keys: tuple[Key, ...]
    several: str = "no"

    def key(self, name: str) -> Key | None:
        """The key of that name."""
        return next((key for key in self.keys if key.name == name), None)
