"""Tables of conditions as loggers and spreadsheets write them."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.watch.conditions import condition_table, of_source

INF = float("inf")


def table_of(tmp_path, data):
    file = tmp_path / "weather.csv"
    file.write_bytes(data)
    return condition_table(file)[0]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
def test_any_encoding_of_a_spreadsheet(tmp_path, encoding):
    table = table_of(tmp_path, "Temperatur °C;x\n20,5;1\n".encode(encoding))
    assert table.at(0, "a")[0] == {"Temperatur °C": 20.5, "x": 1.0}


@pytest.mark.parametrize("mark", ["NA", "n/a", "-", "---", "NaN", "null", "#N/A", ""])
def test_what_stands_for_a_value_that_is_not_known(tmp_path, mark):
    text = f"date,temperature_c\n2026-01-01T00:00,20\n,{mark}\n2026-01-01T02:00,24.5\n"
    table = table_of(tmp_path, text.encode())
    got = [table.at(i, "a")[0]["temperature_c"] for i in range(3)]
    np.testing.assert_array_equal(got, [20.0, np.nan, 24.5])
    assert np.isnat([table.at(i, "a")[1] for i in range(3)]).tolist() == [False, True, False]
    given, _ = condition_table({"temperature_c": [20.0, mark, "24.5"]})
    np.testing.assert_array_equal(given.columns["temperature_c"], got)
    assert np.isnan(of_source(0, {"temperature_c": mark})[0]["temperature_c"])


def test_a_text_among_numbers_is_refused_at_its_row(tmp_path):
    with pytest.raises(ar.InvalidInputError, match=r"conditions\['temperature_c'\]\[1\]: got 'warm'"):
        table_of(tmp_path, b"temperature_c,x\n20,1\nwarm,2\n21,3\n")


def test_two_columns_of_one_name(tmp_path):
    with pytest.raises(ar.InvalidInputError, match="two columns 'a'"):
        table_of(tmp_path, b"a,b,a\n1,2,3\n")


def test_names_that_are_numbers(tmp_path):
    in_file = table_of(tmp_path, b"name,a\n01,5\n2,6\n")
    assert in_file.at(0, "01.npz")[0] == {"a": 5.0}
    assert in_file.at(1, "2.npz")[0] == {"a": 6.0}
    for names in ([2, 0, 1], np.array([2, 0, 1]), [2.0, 0.0, 1.0]):
        table, _ = condition_table({"name": names, "a": [7.0, 5.0, 6.0]})
        assert [table.at(i, str(i))[0]["a"] for i in range(3)] == [5.0, 6.0, 7.0]


def test_texts_name_the_tests_rather_than_numbers():
    with_both = {"record": [1, 2], "name": ["x", "y"], "a": [5.0, 6.0]}
    assert condition_table(with_both)[0].at(0, "y")[0] == {"record": 2.0, "a": 6.0}


def test_tests_counted_from_one_are_not_those_beside():
    table, _ = condition_table({"name": [1, 2, 3], "a": [5.0, 6.0, 7.0]})
    with pytest.raises(ar.InvalidInputError, match="no row of test 0.*counted from 0"):
        table.at(0, "0")


SETS = [ar.AntiresonanceSet(0, {0: 8.7})] * 3


@pytest.mark.parametrize("value", [INF, -INF])
def test_infinite_conditions_are_refused_where_they_are(value):
    said = r"conditions\['a'\]\[1\]: got -?inf; wanted a finite number, NaN"
    with pytest.raises(ar.InvalidInputError, match=said):
        ar.Series.from_sets(SETS, {"a": [1.0, value, 2.0]})
    with pytest.raises(ar.InvalidInputError, match=said):
        condition_table({"a": [1.0, value, 2.0]})
    with pytest.raises(ar.InvalidInputError, match=r"sources\[4\]\['a'\]: got '?-?inf"):
        of_source(4, {"a": value})


@pytest.mark.parametrize("name", ["dof", "name", "score_how", "freq_hz"])
def test_names_of_our_own_columns_are_refused(name):
    with pytest.raises(ar.InvalidInputError, match="no column of a series"):
        ar.Series.from_sets(SETS, {name: [1.0, 2.0, 3.0]})
