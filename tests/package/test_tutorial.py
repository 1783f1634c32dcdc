"""The tutorial on a measured frame prints what it says it prints."""

import contextlib
import io
import re
import warnings

import numpy as np
import pytest

import antires_rs as ar
from tests.support.measured_data import DATA, needs_southampton
from tests.support.paths import DOCS

#: Of a printed figure; the last digit shown is nearer than that.
AS_PRINTED = 5e-3
NUMBER = re.compile(r"-?\d+(?:,\d{3})*(?:\.\d+)?(?:e-?\d+)?")


def blocks():
    """(code, what it prints or None)."""
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    return re.findall(r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", text, re.DOTALL)


def numbers(text):
    return [float(number.replace(",", "")) for number in NUMBER.findall(text)]


@needs_southampton
def test_it_prints_what_the_page_shows(monkeypatch):
    monkeypatch.setenv("ANTIRES_DATA", str(DATA))
    names = {}
    shown = 0
    for code, wanted in blocks():
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed), warnings.catch_warnings():
            warnings.filterwarnings("ignore", ".*antires explain cut_line", ar.AntiresWarning)
            exec(compile(code, "tutorial.md", "exec"), names)
        if not wanted:
            continue
        shown += 1
        found = printed.getvalue()
        assert NUMBER.sub("#", found).split() == NUMBER.sub("#", wanted).split()
        np.testing.assert_allclose(numbers(found), numbers(wanted), rtol=AS_PRINTED, atol=AS_PRINTED)
    assert shown == 8
    assert names["damage"].damaged == [0]


@pytest.mark.parametrize("word", ["Cristallo", "BSD-3-Clause"])
def test_it_says_where_the_data_are_from(word):
    assert word in (DOCS / "tutorial.md").read_text(encoding="utf-8")
