"""Messages kept as text: ``ANTIRES_SNAPSHOTS=write pytest`` writes them anew, for the eye to compare."""

import os
from contextlib import contextmanager
from pathlib import Path

import pytest

import antires_rs as ar
from antires_rs.app import command, parser as usage


def compare(file, messages, between=": "):
    """Messages by what is wrong, a line each, against that file, which lies beside its test."""
    text = "".join(f"{case}{between}{message}\n" for case, message in messages.items())
    if os.environ.get("ANTIRES_SNAPSHOTS") == "write":
        file.write_text(text, encoding="utf-8")
    assert text.splitlines() == file.read_text(encoding="utf-8").splitlines()


def replay(file, said):
    """Each line of the file is a case and what ``said`` gives for it."""
    cases = [line.partition(" -> ")[0] for line in file.read_text(encoding="utf-8").splitlines()]
    assert len(set(cases)) == len(cases) > 9
    compare(file, {case: said(case) for case in cases}, " -> ")


def refusals(test, file, names):
    """Each line of the file beside the test is a call, made of ``names``, and what is said of it."""
    replay(Path(test).with_name(file), lambda call: refusal(eval(f"lambda: {call}", names)))


def refusal(call):
    """What is said of a call that is refused, in one line."""
    with pytest.raises(ar.InvalidInputError) as caught:
        call()
    error = caught.value
    assert all((error.argument, error.got, error.wanted))
    return " ".join(str(error).split())


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
