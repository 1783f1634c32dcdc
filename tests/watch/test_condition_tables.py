"""What was measured beside: tables of any kind, as loggers and spreadsheets write them."""

from pathlib import Path

import numpy as np
import pytest

from antires_rs.watch.conditions import condition_table, of_source
from tests.support.refusals import refused
from tests.support.snapshots import refusal, replay

NAN, INF = float("nan"), float("inf")
TEMPERATURES = [20.0, NAN, 24.5]


def read(given, tmp_path=None):
    if tmp_path is not None:
        file = tmp_path / "weather.csv"
        file.write_bytes(given if isinstance(given, bytes) else given.encode())
        given = file
    return condition_table(given)[0]


def column(table, name="temperature_c", names="012"):
    return [table.at(i, test)[0][name] for i, test in enumerate(names)]


def parquet(tmp_path):
    pytest.importorskip("pyarrow")
    frame = pytest.importorskip("pandas").DataFrame({"temperature_c": TEMPERATURES})
    frame.to_parquet(tmp_path / "weather.parquet")
    return read(tmp_path / "weather.parquet")


TABLES = {
    "mapping": lambda _: read({"temperature_c": TEMPERATURES}),
    "frame": lambda _: read(pytest.importorskip("pandas").DataFrame({"temperature_c": TEMPERATURES})),
    "csv": lambda path: read("temperature_c,x\n20,1\n,2\n24.5,3\n", path),
    "decimal comma": lambda path: read("temperature_c;x\n20;1\n;2\n24,5;3\n", path),
    "parquet": parquet,
}


@pytest.mark.parametrize("kind", TABLES)
def test_a_row_a_test_in_their_order(tmp_path, kind):
    table = TABLES[kind](tmp_path)
    np.testing.assert_array_equal(column(table), TEMPERATURES)
    table.over(3)
    for wrong in (lambda: table.at(3, "one more"), lambda: table.over(2), lambda: table.expect(4)):
        refused("conditions.*3 rows", wrong)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16"])
def test_any_encoding_of_a_spreadsheet(tmp_path, encoding):
    table = read("Temperatur °C;x\n20,5;1\n".encode(encoding), tmp_path)
    assert table.at(0, "a")[0] == {"Temperatur °C": 20.5, "x": 1.0}


@pytest.mark.parametrize("mark", ["NA", "n/a", "-", "---", "NaN", "null", "#N/A", ""])
def test_what_stands_for_a_value_that_is_not_known(tmp_path, mark):
    table = read(f"date,temperature_c\n2026-01-01T00:00,20\n,{mark}\n2026-01-01T02:00,24.5\n", tmp_path)
    np.testing.assert_array_equal(column(table), TEMPERATURES)
    assert np.isnat([table.at(i, "a")[1] for i in range(3)]).tolist() == [False, True, False]
    np.testing.assert_array_equal(column(read({"temperature_c": [20.0, mark, "24.5"]})), TEMPERATURES)
    assert np.isnan(of_source(0, {"temperature_c": mark})[0]["temperature_c"])


@pytest.mark.parametrize("written", ["b.uff", "b", "year/b.uff"])
def test_by_the_names_of_the_tests(written):
    table = read({"File": ["a.uff", written, "z.uff"], "temperature_c": [1.0, 2.0, 3.0]})
    table.expect(50)
    np.testing.assert_array_equal(column(table, names=["unknown.uff"]), [NAN])
    refused("tests named 'a.uff', .*names of the sources", table.over, 1)
    np.testing.assert_array_equal(column(table, names=["b.uff", "unknown.uff"]), [2.0, NAN])
    table.over(2)


def test_names_that_are_numbers(tmp_path):
    assert column(read(b"name,a\n01,5\n2,6\n", tmp_path), "a", ["01.npz", "2.npz"]) == [5.0, 6.0]
    for names in ([2, 0, 1], np.array([2, 0, 1])):
        assert column(read({"name": names, "a": [7.0, 5.0, 6.0]}), "a") == [5.0, 6.0, 7.0]
    # Tests counted from one are not those beside.
    refused("no row of test 0.*counted from 0", read({"name": [1, 2, 3], "a": [5.0, 6.0, 7.0]}).at, 0, "0")


def test_times():
    expected = np.array(["2026-01-31T14:00", "NaT", "2026-02-01T14:30"], "datetime64[ms]")
    for times in (["2026-01-31T14:00", "", "2026-02-01T15:30:00+01:00"], expected.astype("datetime64[ns]")):
        table = read({"date": times, "temperature_c": TEMPERATURES})
        np.testing.assert_array_equal([table.at(i, "")[1] for i in range(3)], expected)
    pd = pytest.importorskip("pandas")
    frame = pd.DataFrame({"t": TEMPERATURES}, index=pd.date_range("2026-01-01", periods=3, freq="h"))
    assert read(frame).at(1, "")[1] == np.datetime64("2026-01-01T01:00")


def test_wrong_tables(tmp_path):
    def said(given):
        wrong = eval(given)
        told = refusal(lambda: read(wrong, tmp_path if isinstance(wrong, bytes) else None))
        return told.replace(str(tmp_path), "FOLDER")

    replay(Path(__file__).with_name("wrong_tables.txt"), said)


@pytest.mark.parametrize("value", [INF, -INF, "warm"])
def test_conditions_of_a_source_are_numbers(value):
    refused(r"sources\[4\]\['a'\]: got .*; wanted a finite number", of_source, 4, {"a": value})
    assert of_source(4, {"a": 1, "time": "2026-01-31"}) == ({"a": 1.0}, np.datetime64("2026-01-31", "ms"))
