"""What was measured beside: tables of every kind, in order and by names."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.watch.conditions import condition_table

NAN = float("nan")
TEMPERATURES = [20.0, NAN, 24.5]


def frame(**more):
    return pytest.importorskip("pandas").DataFrame({"temperature_c": TEMPERATURES, **more})


def csv(tmp_path, text):
    file = tmp_path / "weather.csv"
    file.write_text(text)
    return file


TABLES = {
    "mapping": lambda _: {"temperature_c": TEMPERATURES},
    "array": lambda _: np.array([(20.0,), (NAN,), (24.5,)], dtype=[("temperature_c", float)]),
    "dicts": lambda _: [{"temperature_c": 20}, {}, {"temperature_c": 24.5}],
    "frame": lambda _: frame(),
    "csv": lambda tmp_path: csv(
        tmp_path, "temperature_c,\n20,\n,\n24.5,\n"[:0] or "temperature_c,x\n20,1\n,2\n24.5,3\n"
    ),
    "decimal comma": lambda tmp_path: csv(tmp_path, "temperature_c;x\n20;1\n;2\n24,5;3\n"),
    "parquet": lambda tmp_path: parquet(tmp_path),
}


def parquet(tmp_path):
    pytest.importorskip("pyarrow")
    file = tmp_path / "weather.parquet"
    frame().to_parquet(file)
    return file


@pytest.mark.parametrize("kind", TABLES)
def test_a_row_a_test_in_their_order(tmp_path, kind):
    table, _ = condition_table(TABLES[kind](tmp_path))
    got = [table.at(i, f"test {i}")[0]["temperature_c"] for i in range(3)]
    np.testing.assert_array_equal(got, TEMPERATURES)
    table.over(3)
    with pytest.raises(ar.InvalidInputError, match="conditions.*3 rows"):
        table.at(3, "one more")
    with pytest.raises(ar.InvalidInputError, match="3 rows"):
        table.over(2)
    with pytest.raises(ar.InvalidInputError, match="3 rows"):
        table.expect(4)


@pytest.mark.parametrize("written", ["b.uff", "b", "year/b.uff"])
def test_by_the_names_of_the_tests(written):
    table, _ = condition_table({"File": ["a.uff", written, "z.uff"], "temperature_c": [1.0, 2.0, 3.0]})
    table.expect(50)
    assert table.at(0, "b.uff")[0] == {"temperature_c": 2.0}
    assert np.isnan(table.at(1, "unknown.uff")[0]["temperature_c"])
    table.over(2)


def test_names_that_fit_no_source():
    table, _ = condition_table({"name": ["x", "y"], "temperature_c": [1.0, 2.0]})
    table.at(0, "a")
    with pytest.raises(ar.InvalidInputError, match="tests named 'x', 'y'"):
        table.over(1)


@pytest.mark.parametrize(
    "times",
    [
        ["2026-01-31T14:00", "", "2026-02-01T15:30:00+01:00"],
        np.array(["2026-01-31T14:00", "NaT", "2026-02-01T14:30"], dtype="datetime64[ns]"),
    ],
)
def test_times(times):
    table, _ = condition_table({"date": times, "temperature_c": TEMPERATURES})
    got = np.array([table.at(i, "")[1] for i in range(3)])
    np.testing.assert_array_equal(
        got, np.array(["2026-01-31T14:00", "NaT", "2026-02-01T14:30"], "datetime64[ms]")
    )


def test_a_frame_over_dates():
    pd = pytest.importorskip("pandas")
    table, _ = condition_table(frame().set_index(pd.date_range("2026-01-01", periods=3, freq="h")))
    assert table.at(1, "")[1] == np.datetime64("2026-01-01T01:00")


def test_texts_are_left_out_with_a_word():
    with pytest.warns(ar.AntiresWarning, match="'remark' is left out"):
        table, _ = condition_table({"temperature_c": TEMPERATURES, "remark": ["rain", "", "sun"]})
    assert list(table.columns) == ["temperature_c"]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (3.0, "a mapping of name to array"),
        ({"a": [1.0], "b": [1.0, 2.0]}, "one length"),
        ({"a": 3.0}, r"conditions\['a'\]"),
        ({3: [1.0]}, "a text as the name"),
        ({"freq_hz": [1.0]}, "no column of a series"),
        ({"name": ["a", "a"], "t": [1.0, 2.0]}, "'a' more than once"),
        ("weather.xlsx", r"\.csv"),
    ],
)
def test_wrong_tables(wrong, said):
    with pytest.raises(ar.InvalidInputError, match=said):
        condition_table(wrong)


def test_a_ragged_file(tmp_path):
    with pytest.raises(ar.InvalidInputError, match="row 3"):
        condition_table(csv(tmp_path, "a,b\n1,2\n3\n"))


def test_what_comes_with_a_source_stands_beside_the_table():
    sets = [ar.AntiresonanceSet(0, {0: 8.7})] * 2
    made = ar.Series.from_sets(sets, {"temperature_c": [1.0, 2.0]})
    assert made.conditions["temperature_c"].flags.writeable is False
