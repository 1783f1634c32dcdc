"""The value: many tests in order, what is known of each, and what can be asked of all."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import refused
from tests.support.snapshots import refusal, replay

WARM = [20.0, 22.0, np.nan, 26.0]
TIMES = ["2026-01-01T00", "2026-01-01T01", None, "2026-01-01T03"]
DATED = {"temperature_c": WARM, "time": TIMES}


def sets():
    values = [[8.7, 23.9], [8.69, 23.88], None, [8.66]]
    return [None if f is None else ar.AntiresonanceSet("tip", {0: f, 1: [14.4]}) for f in values]


def series(table=None, **more):
    table = {"temperature_c": WARM} if table is None else table
    return ar.Series.from_sets(sets(), table, **({"names": list("abcd")} | more))


def test_it_is_a_sequence_of_sets():
    made = series()
    assert list(made) == sets()
    assert made[-1] == made.sets[3] == sets()[3]
    assert (len(made), made.excitation, made.dofs) == (4, "tip", (0, 1))
    assert made.conditions["temperature_c"].flags.writeable is False


@pytest.mark.parametrize("at", [slice(1, 4), [1, 2, 3], np.array([False, True, True, True])])
def test_some_of_it_is_a_series(at):
    some = series(DATED)[at]
    assert (some.names, some.failed) == (("b", "c", "d"), {1: "no set was given"})
    assert list(some) == sets()[1:]
    np.testing.assert_array_equal(some.conditions["temperature_c"], WARM[1:])
    assert some.times[0] == np.datetime64(TIMES[1])
    assert (some[1:].failed, some[1:][1]) == ({0: "no set was given"}, sets()[3])
    for none in ([], slice(4, 4), np.zeros(4, bool)):
        assert len(series()[none]) == 0
        assert "temperature_c" not in str(series()[none])


@pytest.mark.parametrize("at", [4, -5, [0, 4]])
def test_a_place_that_is_not_there(at):
    with pytest.raises(IndexError, match="of a series of 4"):
        series()[at]


def test_tracks_leave_out_what_failed_with_its_condition():
    followed = series().tracks("temperature_c")
    assert followed.conditions == (20.0, 22.0, 26.0)
    np.testing.assert_array_equal(followed.freq_hz[:, followed.of(0)[1]], [23.9, 23.88, np.nan])
    assert ar.track(series(), "names").conditions == ("a", "b", "d")
    assert ar.track(series(), [5, 6, 7, 8]).conditions == (5, 6, 8)
    assert ar.track(series()).conditions == (0, 1, 3)
    assert ar.track(series(DATED), "times").conditions[1] == "2026-01-01T01:00:00.000"
    assert series().compare(0, 3).unmatched_a[0].tolist() == [23.9]


def test_two_series_are_compared_by_their_averages():
    rng, std = np.random.default_rng(0), 0.01

    def tests(first, n):
        drawn = first + std * rng.standard_normal((n, 2))
        made = [ar.AntiresonanceSet(0, {0: f if i % 5 else [*f, 31.0], 1: []}) for i, f in enumerate(drawn)]
        return ar.Series.from_sets([*made, None])

    before, same, after = (tests(f, 40) for f in ([8.7, 23.9], [8.7, 23.9], [8.7, 23.88]))
    average = before.average()
    np.testing.assert_allclose(average[0], [8.7, 23.9], atol=4 * std / np.sqrt(40))
    np.testing.assert_allclose(average.std_hz[0], std / np.sqrt(40), rtol=0.4)
    assert not ar.compare(before, same).different
    assert ar.compare(before, after).changed.tolist() == [False, True]


def test_rows_for_pandas():
    pytest.importorskip("pandas")
    rows = series(DATED).to_dataframe()
    assert rows.columns[:5].tolist() == ["test", "name", "time", "temperature_c", "dof"]
    assert rows["test"].tolist() == [0, 0, 0, 1, 1, 1, 3, 3]
    assert rows["freq_hz"].tolist()[-2:] == [8.66, 14.4]


def test_printed():
    assert str(series(DATED)).splitlines() == [
        "series of 4 tests, force at tip, 2 responses",
        "  identified     3, with 2 to 3 antiresonances",
        "  failed         1: no set was given",
        "  times          2026-01-01T00:00 to 2026-01-01T03:00, 1 not known",
        "  temperature_c  20 to 26, 1 not known",
    ]
    reasons = ["x" * 100, "b", "b", "c", "d", "e"]
    bare = {"names": range(6), "times": None, "excitation": None, "dofs": ()}
    said = str(ar.Series([None] * 6, conditions={"t": [np.nan] * 6}, failed=dict(enumerate(reasons)), **bare))
    assert f"  failed      6: b (2 times); {'x' * 87}...; c; and 2 others, see .failed" in said.splitlines()
    assert "  t           not known" in said.splitlines()


def test_equal_means_bit_for_bit():
    assert series() == series() == pickle.loads(pickle.dumps(series()))
    assert series() != series()[:3]
    assert series() != series(DATED)
    other = sets()
    other[0] = ar.AntiresonanceSet("tip", {0: [8.7, np.nextafter(23.9, 24)], 1: [14.4]})
    assert series() != ar.Series.from_sets(other, {"temperature_c": WARM}, list("abcd"))


def made(**changed):
    return ar.Series.from_sets(**({"sets": sets()} | changed))


def test_wrong_input_and_questions():
    refused("size of axis is 4|dimension is 4", series().__getitem__, [True, False])
    replay(Path(__file__).with_name("wrong_sets.txt"), lambda call: refusal(lambda: eval(call)))


def test_conditions_may_be_a_table_that_names_and_dates_the_tests():
    pd = pytest.importorskip("pandas")
    days = pd.date_range("2026-01-01", periods=4)
    table = pd.DataFrame({"temperature_c": WARM, "time": days})
    named = table.assign(name=list("abcd"))
    # Rows that are named belong to the tests of these names, in any order.
    for given in (table, named[::-1]):
        assert series(given) == series({"temperature_c": WARM, "time": days.to_numpy()})
    assert series(named, names=None) == series(table)
    for given, names, said in ((table[:3], None, "3 rows"), (named, list("efgh"), "names of the sources")):
        refused(said, series, given, names=names)
