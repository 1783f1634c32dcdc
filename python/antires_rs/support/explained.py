"""What is said of a symptom: its cause and what to do, from ``troubleshooting.md`` beside this file."""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache
from pathlib import Path

from .validation import reject

__all__ = ["explain"]

_FILE = Path(__file__).with_name("troubleshooting.md")


def explain(*names: str) -> str:
    """Tell what a warning, a finding or a doubt means: what is seen, why, and what to do.

    Parameters
    ----------
    *names : str
        As warnings end with, ``warning.about``; names of findings of a data check; doubts in a table of
        antiresonances, ``"few orders"``. Without a name: all names, each with what is seen.

    Returns
    -------
    str
        Plain text in Markdown.

    Raises
    ------
    InvalidInputError
        A name that is not known; the error tells those most like it.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.explain("dead_channel").splitlines()[0])
    ### dead_channel
    >>> "dead_channel" in ar.explain()
    True
    """
    known = entries()
    if not names:
        return "\n".join(f"{name}: {_seen(text)}" for name, text in known.items())
    return "\n\n".join(_entry(str(name), known) for name in names)


@cache
def entries() -> dict[str, str]:
    """Every entry by its name, in the order of the page."""
    blocks = _FILE.read_text(encoding="utf-8").split("\n### ")[1:]
    return {b.split("\n", 1)[0].strip(): "### " + b.split("\n## ", 1)[0].strip() for b in blocks}


def _entry(name: str, known: dict[str, str]) -> str:
    key = name.strip().lower().replace(" ", "_").replace("-", "_")
    if key not in known:
        near = get_close_matches(key, known, n=3, cutoff=0.6)
        reject(
            "names",
            repr(name),
            f"one of the names that warnings end with{', perhaps ' + ' or '.join(near) if near else ''}",
            "Ask without a name for all of them.",
        )
    return known[key]


def _seen(text: str) -> str:
    """What is seen, in a line."""
    return " ".join(text.split("**Seen:**", 1)[1].split("\n\n", 1)[0].split())
