"""Every warning leads to what is said of it, and nothing is said of what the package never says."""

import ast
import inspect
import re
import warnings
from functools import cache
from pathlib import Path

import antires_rs as ar
from antires_rs.app.main import main
from antires_rs.identification import scores
from antires_rs.measured import response_table as doubts
from antires_rs.signals import channel_checks as channels, data_check as check, repeats
from antires_rs.support.messages import entries
from antires_rs.watch import charts

SOURCES = Path(ar.__file__).parent
#: Said in headlines, notes and tables of results.
OF_RESULTS = {"unexplained", "no_baseline", "one_of_several", "z", "chi_square"}
OF_RESULTS |= {name.lower() for name in charts.SHARES}  # said in lines with an alarm
FINDINGS = {*check.TESTS, check.SINGLE_HIT, check.MISSED_HIT, channels.HUM, channels.QUANTIZED}
FINDINGS |= {channels.DOUBLE, channels.DRIFTING, channels.LENGTH, channels.AVERAGES, repeats.DIFFER}


@cache
def warned():
    """(file:line, name) of every call of warn in the package; a name that is no text is None."""
    return [
        (
            f"{file.name}:{node.lineno}",
            first.value if isinstance(first := node.args[0], ast.Constant) else None,
        )
        for file in sorted(SOURCES.rglob("*/*.py"))
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "warn"
    ]


def words_of_doubts():
    said = {word for word, _ in (*doubts._TESTS, *doubts._OF_WINDOWS)} | {"added by hand"}
    said |= {*doubts._HOW.values(), *scores.MISLEADING.values()}
    return {word.replace(" ", "_") for word in said}


def test_every_warning_has_an_entry():
    found = warned()
    assert len(found) > 30
    assert [place for place, name in found if name is not None and name not in entries()] == []
    dynamic = {place.split(":")[0] for place, name in found if name is None}  # names of findings
    assert dynamic == {"force_places.py", "identify.py"}


def test_warnings_go_through_one_door():
    files = SOURCES.rglob("*.py")
    assert [f.name for f in files if "warnings.warn(" in f.read_text("utf-8")] == ["messages.py"]


def test_every_finding_and_doubt_has_an_entry():
    assert {name for name in FINDINGS | words_of_doubts() if name not in entries()} == set()
    assert set(re.findall(r"- ``(\w+)``", inspect.getdoc(check.check_data))) <= FINDINGS
    assert channels.DEAD in FINDINGS


def test_every_entry_belongs_to_something_and_says_what_to_do():
    said = {name for _, name in warned()} | FINDINGS | words_of_doubts() | OF_RESULTS
    assert set(entries()) - said == set()
    assert entries().keys() >= OF_RESULTS
    for name, text in entries().items():
        heads = re.findall(r"^- \*\*(.+?):\*\* \S", text, re.MULTILINE)
        assert heads == ["Seen", "Why", "What to do"], name


def test_the_command_and_the_function_say_the_same(capsys):
    assert main(["explain", "few orders", "one-force"]) == 0
    assert capsys.readouterr().out == ar.explain("few_orders", "one_force") + "\n"
    assert main(["explain"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(entries())
    assert main(["explain", "one_forse"]) == 2
    assert "perhaps one_force" in capsys.readouterr().err


def test_a_warning_stands_at_the_line_of_the_call_and_can_be_copied():
    import pickle

    with warnings.catch_warnings(record=True, action="always") as seen:
        ar.MatrixModel([[1.0, 0.0], [0.0, 2.0]], [[1.0, 0.0], [0.0, 1.0]]).antiresonances(0, 1)
    assert Path(seen[0].filename) == Path(__file__)
    copied = pickle.loads(pickle.dumps(seen[0].message))
    assert copied.about == ("not_connected",)
    assert str(copied) == str(seen[0].message)
    assert str(copied).endswith(" [antires explain not_connected]")
