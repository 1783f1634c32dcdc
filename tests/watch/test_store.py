"""A series in a file: the same as in memory, resumed after anything, refused where it is another."""

import json
import os
import shutil
import sqlite3
from zlib import crc32

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.watch import sources as one_test
from antires_rs.watch.store import Store, part_path
from reference.small_records import OPTIONS, dead, record
from tests.support.identified_once import identified_once

pyarrow = pytest.importorskip("pyarrow")

CONFIG = json.loads(json.dumps({"reading": {}} | OPTIONS))
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


def stopped(count=4):
    yield from sources(count)
    raise RuntimeError


def test_torn_anywhere_it_goes_on_to_the_same_file(store, whole, tmp_path):
    """What a kill or a power cut leaves: a database, and a log behind it that may end anywhere."""
    seen = tmp_path / "seen"

    def watched():
        yield from sources(4)
        seen.mkdir()
        for file in tmp_path.glob("year.parquet.part*"):
            shutil.copy(file, seen)
        raise RuntimeError

    with pytest.raises(RuntimeError):
        ar.identify_series(watched(), **OPTIONS, store=store)
    log = (seen / "year.parquet.part-wal").read_bytes()
    assert len(log) > 10_000
    for end in (0, 5, len(log) // 3, len(log) // 2, len(log) - 1, len(log)):
        for file in tmp_path.glob("year*"):
            file.unlink()
        shutil.copy(seen / "year.parquet.part", tmp_path)
        (tmp_path / "year.parquet.part-wal").write_bytes(log[:end])
        assert len(ar.Series.load(store)) >= 2 or end < len(log)
        identified(store)
        assert store.read_bytes() == whole, end
        assert not list(tmp_path.glob("*.part*"))


def test_a_database_is_a_store_of_its_own(tmp_path, in_memory, whole, count):
    store = tmp_path / "year.sqlite"
    with pytest.raises(RuntimeError):
        ar.identify_series(stopped(), **OPTIONS, store=store)
    assert ar.Series.load(store).interrupted
    identified(store)
    count.clear()
    assert_same(identified(store), in_memory)
    assert count == []
    series = ar.Series.load(store)
    assert_same(series, in_memory)
    assert os.listdir(tmp_path) == ["year.sqlite"]
    with sqlite3.connect(store) as database:
        assert database.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        assert [name for (name,) in database.execute("SELECT name FROM tests ORDER BY place")] == list(
            "abcde"
        )
    identified(store, conditions={"temperature_c": [1.0, 2.0, 3.0, 4.0, 5.0]})
    assert count == []
    assert ar.Series.load(store).conditions["temperature_c"].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    saved = tmp_path / "saved.sqlite"
    series.save(saved)
    assert_same(ar.Series.load(saved), in_memory)
    with pytest.raises(ar.InvalidInputError, match="Series.save"):
        identified(saved)
    with pytest.raises(ar.InvalidInputError, match="no source 'c', 'd', 'e'"):
        identified(store, 2)


def test_tables_have_the_same_bytes_in_whatever_order_tests_were_made(tmp_path, in_memory):
    """One store by two workers, one in two parts and with a source that came late to its place."""
    late = [one for one in sources() if one[0] != "b"]
    files = []
    for how, workers in (("whole", "threads"), ("parts", None)):
        store = tmp_path / f"{how}.sqlite"
        if how == "parts":
            ar.identify_series(late, **OPTIONS, store=store)
        series = identified(store, workers=workers)
        for ending in ("parquet", "csv"):
            series.save(tmp_path / f"{how}.{ending}")
        files.append([(tmp_path / f"{how}.{ending}").read_bytes() for ending in ("parquet", "csv")])
    assert files[0] == files[1]
    pd = pytest.importorskip("pandas")
    rows = pd.read_csv(tmp_path / "whole.csv")
    found = rows[rows["row"] == "antiresonance"]
    assert found["freq_hz"].tolist() == in_memory.to_dataframe()["freq_hz"].tolist()
    with pytest.raises(ar.InvalidInputError, match="cannot be read"):
        ar.Series.load(tmp_path / "whole.csv")


def test_a_journal_of_an_older_version_is_taken_up(store, whole, count):
    """Lines of a checksum and JSON, of which the last is torn."""
    with pytest.raises(RuntimeError):
        ar.identify_series(stopped(), **OPTIONS, store=store)
    kept = Store(store, CONFIG)
    lines = [{"format": "antires_rs.Series.journal", "version": 1, "config": CONFIG}]
    for row in kept._known.values():
        outcome = row.plain() if row.failed is None else row.failed
        beside = {"temperature_c": None}
        lines.append(
            {"name": row.name, "fingerprint": row.fingerprint, "conditions": beside, "time": None}
            | {"outcome": outcome}
        )
    kept.close()
    texts = [json.dumps(line).encode() for line in lines]
    journal = b"".join(b"%08x %s\n" % (crc32(text), text) for text in texts)[:-7]
    part_path(store).write_bytes(journal)
    so_far = ar.Series.load(store)
    assert (so_far.names, so_far.interrupted) == (("a", "b"), True)
    count.clear()
    identified(store)
    assert len(count) == 3
    assert store.read_bytes() == whole


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
        with pytest.raises(RuntimeError):
            ar.identify_series(stopped(3), **OPTIONS, store=store)
        assert part_path(store).exists()
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
    elsewhere = Store(store, CONFIG)
    with pytest.raises(ar.InvalidInputError, match="another process writes"):
        identified(store)
    elsewhere.close()


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
