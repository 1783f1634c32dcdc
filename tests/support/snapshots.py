"""Messages kept as text: ``ANTIRES_SNAPSHOTS=write pytest`` writes them anew, for the eye to compare."""

import os
from contextlib import contextmanager

from antires_rs.app import command, parser as usage


def compare(file, messages):
    """Messages by what is wrong, a line each, against that file, which lies beside its test."""
    text = "".join(f"{case}: {message}\n" for case, message in messages.items())
    if os.environ.get("ANTIRES_SNAPSHOTS") == "write":
        file.write_text(text, encoding="utf-8")
    assert text.splitlines() == file.read_text(encoding="utf-8").splitlines()


@contextmanager
def complaints(patch):
    """The errors that ``antires`` ends with, which it prints as ever."""
    errors = []
    say = usage.complain

    def complain(error, *program):
        errors.append(error)
        say(error, *program)

    for module in (command, usage):
        patch.setattr(module, "complain", complain)
    yield errors
