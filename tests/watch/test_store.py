"""A series in a file: the same as in memory, resumed after anything, refused where it is another."""

import json
import os

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.watch import sources as one_test
from antires_rs.watch.store import Journal, journal_path
from reference.small_records import OPTIONS, dead, record
from tests.support.identified_once import identified_once

pyarrow = pytest.importorskip("pyarrow")

TIMES = [f"2026-01-01T0{i}:00" for i in range(5)]


def sources(count=5):
    """Five tests; the third lacks a sensor, the fourth fails."""
    made = [("a", record(0)), ("b", record(1)), ("c", dead(2)), ("d", dead(3, [0, 1])), ("e", record(4))]
    return made[:count]


def conditions(count=5):
    return {"time": TIMES[:count], "temperature_c": [20.0, 21.0, np.nan, 22.0, 23.5][:count]}


def identified(store=None, count=5, **more):
    return ar.identify_series(
        sources(count), **(OPTIONS | {"conditions": conditions(count), "store": store} | more)
    )


@pytest.fixture(scope="module", autouse=True)
def once():
    """What is stored is asked here; each record is identified once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(one_test, "identify_antiresonances", identified_once)
        yield


@pytest.fixture(scope="module")
def in_memory():
    return identified()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    store = tmp_path_factory.mktemp("whole") / "year.parquet"
    identified(store)
    return store.read_bytes()


@pytest.fixture
def store(tmp_path):
    return tmp_path / "year.parquet"


@pytest.fixture
def count(monkeypatch):
    """How many tests are identified."""
    real, calls = one_test.identify_antiresonances, []

    def identify(signal, **options):
        calls.append(signal)
        return real(signal, **options)

    monkeypatch.setattr(one_test, "identify_antiresonances", identify)
    return calls


def assert_same(one, other):
    """Beyond ``==``: scores, what was left out, findings."""
    assert one == other
    assert one.dofs == other.dofs
    for a, b in zip(one, other, strict=True):
        if a is None:
            continue
        assert (a.sees, a.channels, a.excitation) == (b.sees, b.channels, b.excitation)
        assert a.data_check.findings == b.data_check.findings
        assert dict(a.data_check.not_tested) == dict(b.data_check.not_tested)
        for tables, others in ((a.tables, b.tables), (a.left_out, b.left_out)):
            assert tables.keys() == others.keys()
            for dof, table in tables.items():
                assert table.same_as(others[dof])
                assert table.by_hand.tolist() == others[dof].by_hand.tolist()
                assert table.scores.keys() == others[dof].scores.keys()
                for name, values in table.scores.items():
                    np.testing.assert_array_equal(values, others[dof].scores[name])
                    assert values.dtype.kind == others[dof].scores[name].dtype.kind
        for dof, peaks in a.unexplained_hz.items():
            np.testing.assert_array_equal(peaks, b.unexplained_hz[dof])


def test_in_a_file_it_is_what_it_is_in_memory(store, in_memory):
    assert_same(identified(store), in_memory)
    assert_same(ar.Series.load(store), in_memory)
    assert os.listdir(store.parent) == ["year.parquet"]


def test_a_saved_series_is_the_same(store, in_memory):
    in_memory.save(store)
    assert_same(ar.Series.load(store), in_memory)
    with pytest.raises(ar.InvalidInputError, match="Series.save"):
        identified(store)


def test_sets_of_any_origin_are_kept(store):
    by_hand = ar.AntiresonanceSet("tip", {"tip": [8.7, 23.9], 1: []}, std_hz={"tip": [0.1, np.nan]})
    edited = by_hand.add("tip", 9.9, reason="seen in the curve").drop("tip", 8.7)
    series = ar.Series.from_sets([by_hand, None, edited], names=["x", "y", "z"])
    series.save(store)
    again = ar.Series.load(store)
    assert again == series
    assert again[2].edits == edited.edits
    assert again[2].original() == by_hand
    assert again.failed == series.failed


def test_any_program_reads_it(store, in_memory):
    pd = pytest.importorskip("pandas")
    identified(store)
    rows = pd.read_parquet(store)
    tests = rows[rows["row"] == "test"]
    assert tests["name"].tolist() == list("abcde")
    assert tests["failed"].notna().tolist() == [False, False, False, True, False]
    found = rows[rows["row"] == "antiresonance"]
    assert found["freq_hz"].tolist() == in_memory.to_dataframe()["freq_hz"].tolist()
    assert set(found.columns) >= {"dof", "damping_ratio", "std_hz", "temperature_c", "time", "score_how"}


def test_again_does_nothing(store, whole, count):
    identified(store)
    count.clear()
    identified(store)
    assert count == []
    assert store.read_bytes() == whole


def test_new_sources_are_taken_in(store, whole, count):
    identified(store, 2)
    count.clear()
    identified(store)
    assert len(count) == 3  # of which one fails
    assert store.read_bytes() == whole


def test_torn_anywhere_it_goes_on_to_the_same_file(store, whole):
    """The last line of the journal may end anywhere; here are the places that differ."""

    def stopped():
        yield from sources(4)
        raise RuntimeError

    with pytest.raises(RuntimeError):
        ar.identify_series(stopped(), **OPTIONS, store=store)
    part = journal_path(store)
    data = part.read_bytes()
    ends = np.flatnonzero(np.frombuffer(data, np.uint8) == ord("\n")) + 1
    assert len(ends) >= 4
    for end in (5, int(ends[0]) + 3, int(ends[1]), int(ends[-1]) - 1):
        part.write_bytes(data[:end])
        store.unlink(missing_ok=True)
        identified(store)
        assert store.read_bytes() == whole, end
        assert not part.exists()


def test_a_changed_source_is_done_again_with_a_word(store):
    identified(store)
    changed = sources()
    changed[1] = ("b", record(7))
    with pytest.warns(ar.AntiresWarning, match="1 sources have changed.*'b'"):
        series = ar.identify_series(changed, **OPTIONS, store=store, conditions=conditions())
    alone = store.with_name("alone.parquet")
    assert series[1] == ar.identify_antiresonances(record(7), **OPTIONS, check="off")
    ar.identify_series(changed, **OPTIONS, store=alone, conditions=conditions())
    assert store.read_bytes() == alone.read_bytes()


def test_other_conditions_need_no_record_again(store, count):
    identified(store)
    count.clear()
    series = identified(store, conditions={"temperature_c": [1.0, 2.0, 3.0, 4.0, 5.0]})
    assert count == []
    assert series.conditions["temperature_c"].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert series.times is None


@pytest.mark.parametrize("through", [True, False])
def test_other_options_are_refused(store, through):
    if through:
        identified(store)
    else:

        def stopped():
            yield from sources(3)
            raise RuntimeError

        with pytest.raises(RuntimeError):
            ar.identify_series(stopped(), **OPTIONS, store=store)
        assert journal_path(store).exists()
    with pytest.raises(ar.InvalidInputError, match="band_hz = .*8.0.* in place of .*7.0"):
        identified(store, band_hz=(0.8, 7.0))
    with pytest.raises(ar.InvalidInputError, match="max_order"):
        identified(store, max_order=20)


def test_sources_that_are_gone_are_refused(store, whole):
    identified(store)
    with pytest.raises(ar.InvalidInputError, match="no source 'c', 'd', 'e'"):
        identified(store, 2)
    assert store.read_bytes() == whole
    identified(store)
    assert store.read_bytes() == whole


def test_a_store_in_use_is_refused(store):
    fcntl = pytest.importorskip("fcntl")
    assert fcntl
    config = json.loads(json.dumps({"excitation": 0, "band_hz": (0.8, 8.0), "reading": {}, "max_order": 16}))
    open_elsewhere = Journal(journal_path(store), config)
    with pytest.raises(ar.InvalidInputError, match="another process writes"):
        identified(store)
    open_elsewhere.close()


@pytest.mark.parametrize(
    ("content", "said"), [(b"PAR1 torn", "cannot be read"), (None, "another kind")], ids=["torn", "foreign"]
)
def test_files_of_another_kind(store, content, said):
    if content is None:
        import pyarrow.parquet

        pyarrow.parquet.write_table(pyarrow.table({"a": [1]}), store)
    else:
        store.write_bytes(content)
    with pytest.raises(ar.InvalidInputError, match=said):
        ar.Series.load(store)
    with pytest.raises(FileNotFoundError):
        ar.Series.load(store.with_name("absent.parquet"))
