"""Messages kept as text: ``ANTIRES_SNAPSHOTS=write pytest`` writes them anew, for the eye to compare."""

import os
import re


def compare(file, messages):
    """Messages by what is wrong, against that file, which lies beside its test."""
    text = "".join(f"# {case}\n{message}\n\n" for case, message in messages.items())
    if os.environ.get("ANTIRES_SNAPSHOTS") == "write":
        file.write_text(text, encoding="utf-8")
    assert text == file.read_text(encoding="utf-8")


def complete(message):
    """Whether a message says what was got, what is wanted, and then what to do."""
    return re.search(r": got .+; wanted .+?[.?] ['A-Z\[]", message, re.DOTALL) is not None
