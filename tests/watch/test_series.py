"""The value: many tests in order, what is known of each, and what can be asked of all."""

import pickle

import numpy as np
import pytest

import antires_rs as ar

WARM = [20.0, 22.0, np.nan, 26.0]


def sets():
    """Four tests; the third failed, the last lost one of its antiresonances."""
    values = [[8.7, 23.9], [8.69, 23.88], None, [8.66]]
    return [None if f is None else ar.AntiresonanceSet("tip", {0: f, 1: [14.4]}) for f in values]


def series(**more):
    return ar.Series.from_sets(sets(), {"temperature_c": WARM}, list("abcd"), failed={2: "cut"}, **more)


def test_it_is_a_sequence_of_sets():
    made = series()
    assert len(made) == 4
    assert made[1] == sets()[1]
    assert made[-1] == made.sets[3] == sets()[3]
    assert made[2] is None
    assert list(made) == sets()
    assert (made.excitation, made.dofs) == ("tip", (0, 1))
    with pytest.raises(IndexError):
        made[4]


@pytest.mark.parametrize("at", [slice(1, 4), [1, 2, 3], np.array([False, True, True, True])])
def test_some_of_it_is_a_series(at):
    some = series()[at]
    assert some.names == ("b", "c", "d")
    assert some.failed == {1: "cut"}
    assert some[1] is None
    assert some[2] == sets()[3]
    np.testing.assert_array_equal(some.conditions["temperature_c"], WARM[1:])
    assert some[1:].failed == {0: "cut"}
    assert some[1:][1] == sets()[3]


def test_tracks_leave_out_what_failed_with_its_condition():
    followed = series().tracks("temperature_c")
    assert followed.conditions == (20.0, 22.0, 26.0)
    np.testing.assert_array_equal(followed.freq_hz[:, followed.of(0)[1]], [23.9, 23.88, np.nan])
    assert ar.track(series(), "names").conditions == ("a", "b", "d")
    assert ar.track(series()).conditions == (0, 1, 3)


def test_two_tests_are_compared():
    assert series().compare(0, 3).unmatched_a[0].tolist() == [23.9]
    with pytest.raises(ar.InvalidInputError, match="which failed: cut"):
        series().compare(0, 2)


def test_two_series_are_compared_by_their_averages():
    rng = np.random.default_rng(0)
    std = 0.01

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
    rows = series(times=["2026-01-01T00", "2026-01-01T01", "2026-01-01T02", "2026-01-01T03"]).to_dataframe()
    assert rows.columns[:5].tolist() == ["test", "name", "time", "temperature_c", "dof"]
    assert rows["test"].tolist() == [0, 0, 0, 1, 1, 1, 3, 3]
    assert rows["freq_hz"].tolist()[-2:] == [8.66, 14.4]


def test_printed():
    made = series(times=["2026-01-01T00", "2026-01-01T01", "NaT", "2026-01-01T03"])
    assert str(made).splitlines() == [
        "series of 4 tests, force at tip, 2 responses",
        "  identified     3, with 2 to 3 antiresonances",
        "  failed         1: cut",
        "  times          2026-01-01T00:00 to 2026-01-01T03:00, 1 not known",
        "  temperature_c  20 to 26, 1 not known",
    ]


def test_equal_means_bit_for_bit():
    assert series() == series()
    assert series() == pickle.loads(pickle.dumps(series()))
    assert series() != series()[:3]
    other = sets()
    other[0] = ar.AntiresonanceSet("tip", {0: [8.7, np.nextafter(23.9, 24)], 1: [14.4]})
    assert series() != ar.Series.from_sets(other, {"temperature_c": WARM}, list("abcd"), failed={2: "cut"})


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"sets": []}, "sets"),
        ({"sets": {}}, "sets"),
        ({"sets": [*sets(), ar.AntiresonanceSet(1, {0: 8.7})]}, r"sets\[4\]"),
        ({"sets": [1.0]}, r"sets\[0\]"),
        ({"names": list("abc")}, "names"),
        ({"names": list("abca")}, "'a' more than once"),
        ({"conditions": {"t": [1.0]}}, r"conditions\['t'\].*1 values"),
        ({"conditions": {"t": list("abcd")}}, r"conditions\['t'\]"),
        ({"conditions": [1.0]}, "conditions"),
        ({"times": ["yesterday"] * 4}, "times"),
        ({"times": ["2026-01-01"]}, "times"),
    ],
)
def test_wrong_input(wrong, named):
    with pytest.raises(ar.InvalidInputError, match=named):
        ar.Series.from_sets(**({"sets": sets()} | wrong))


def test_conditions_may_be_a_table_that_names_and_dates_the_tests():
    pd = pytest.importorskip("pandas")
    days = pd.date_range("2026-01-01", periods=4)
    table = pd.DataFrame({"temperature_c": WARM, "time": days})
    made = ar.Series.from_sets(sets(), table, list("abcd"), failed={2: "cut"})
    assert made == series(times=days.to_numpy())
    # Rows that are named belong to the tests of these names, in any order.
    named = table.assign(name=list("abcd"))[::-1]
    assert ar.Series.from_sets(sets(), named, list("abcd"), failed={2: "cut"}) == made
    assert ar.Series.from_sets(sets(), table.assign(name=list("abcd")), failed={2: "cut"}) == made
    assert ar.Series.from_sets(sets(), table.to_dict("records"), list("abcd"), failed={2: "cut"}) == made
    with pytest.raises(ar.InvalidInputError, match="3 rows"):
        ar.Series.from_sets(sets(), table[:3])
    with pytest.raises(ar.InvalidInputError, match="names of the sources"):
        ar.Series.from_sets(sets(), named, list("efgh"))


def test_wrong_questions():
    with pytest.raises(ar.InvalidInputError, match="temperature_c"):
        series().tracks("temperature")
    with pytest.raises(ar.InvalidInputError, match="conditions"):
        series().tracks([1, 2])
