"""A series in a file: the same as in memory, resumed after anything, refused where it is another."""

import json
import os
import shutil
import sqlite3
import subprocess
import sys
import warnings
from contextlib import closing
from functools import partial

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.watch import sources as one_test, stored_tests
from antires_rs.watch.store import Store, part_path
from reference.small_records import OPTIONS, dead, record
from tests.support.campaign import some_of
from tests.support.paths import ROOT
from tests.support.refusals import refused
from tests.support.same_sets import assert_same_set

pyarrow = pytest.importorskip("pyarrow")

CONFIG = json.loads(json.dumps({"reading": {}} | OPTIONS))
FOUND = ar.AntiresonanceSet(0, {0: [2.0, 5.0], 1: []})
#: The third test lacks a sensor, the fourth fails.
SOURCES = [("a", record(0)), ("b", record(1)), ("c", dead(2)), ("d", dead(3, [0, 1])), ("e", record(4))]
TEMPERATURES = [20.0, 21.0, np.nan, 22.0, 23.5]


def identified(store=None, sources=SOURCES, **more):
    count = len(sources)
    times = [f"2026-01-01T0{i}:00" for i in range(count)]
    conditions = {"time": times, "temperature_c": TEMPERATURES[:count]}
    return ar.identify_series(sources, **(OPTIONS | {"conditions": conditions, "store": store} | more))


def ended(sources, by, then=lambda: None):
    yield from sources
    then()
    raise by


def stopped(store, then=lambda: None):
    with pytest.raises(RuntimeError):
        ar.identify_series(ended(SOURCES[:4], RuntimeError, then), **OPTIONS, store=store)


@pytest.fixture(scope="module", autouse=True)
def once():
    """What is stored is asked here; each record is identified once, or fails once."""
    found = {}

    def identified_once(signal, **options):
        key = one_test.fingerprint(signal), repr(sorted(options.items()))
        if key not in found:
            try:
                found[key] = ar.identify_antiresonances(signal, **options)
            except Exception as error:
                found[key] = error
        if isinstance(found[key], Exception):
            raise found[key]
        return found[key]

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
def calls(monkeypatch):
    real, made = one_test.identify_antiresonances, []

    def identify(signal, **options):
        made.append(signal)
        return real(signal, **options)

    monkeypatch.setattr(one_test, "identify_antiresonances", identify)
    return made


def assert_same(one, other):
    assert one == other
    assert one.dofs == other.dofs
    for a, b in zip(one, other, strict=True):
        if a is not None:
            assert_same_set(a, b)


@pytest.mark.parametrize("ending", ["parquet", "sqlite"])
def test_in_a_file_it_is_what_it_is_in_memory(tmp_path, in_memory, calls, ending):
    store, saved = tmp_path / f"year.{ending}", tmp_path / f"saved.{ending}"
    stopped(store)
    assert ar.Series.load(store).interrupted
    assert_same(identified(store), in_memory)
    assert_same(ar.Series.load(store), in_memory)
    assert os.listdir(tmp_path) == [store.name]
    if ending == "sqlite":
        with closing(sqlite3.connect(store)) as database, database:
            assert database.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
    calls.clear()
    assert_same(identified(store), in_memory)
    changed = {"temperature_c": [1.0, 2.0, 3.0, 4.0, 5.0]}
    assert identified(store, conditions=changed).times is None
    assert calls == []  # no record is needed again
    assert ar.Series.load(store).conditions["temperature_c"].tolist() == changed["temperature_c"]
    refused("no source 'c', 'd', 'e'", identified, store, SOURCES[:2])
    in_memory.save(saved)
    assert_same(ar.Series.load(saved), in_memory)
    refused("Series.save", identified, saved)


def test_sets_of_any_origin_are_kept(store):
    by_hand = ar.AntiresonanceSet("tip", {"tip": [8.7, 23.9], 1: []}, std_hz={"tip": [0.1, np.nan]})
    edited = by_hand.add("tip", 9.9, reason="seen in the curve").drop("tip", 8.7)
    series = ar.Series.from_sets([by_hand, None, edited], names=["x", "y", "z"])
    series.save(store)
    again = ar.Series.load(store)
    assert again == series
    assert (again[2].edits, again[2].original()) == (edited.edits, by_hand)
    assert again.failed == series.failed


def test_a_file_that_was_written_anew_is_not_read_for_the_old_one(store):
    ar.Series.from_sets([FOUND]).save(store)
    before = ar.Series.load(store)
    ar.Series.from_sets([FOUND, FOUND]).save(store)
    refused("written anew", before.__getitem__, 0)


def test_any_program_reads_the_tables(store, in_memory):
    pd = pytest.importorskip("pandas")
    older = int(pd.__version__.split(".")[0]) < 3  # these round, unless they are told not to
    text = partial(pd.read_csv, float_precision="round_trip") if older else pd.read_csv
    for ending, read in (("parquet", pd.read_parquet), ("csv", text)):
        in_memory.save(store.with_suffix(f".{ending}"))
        rows = read(store.with_suffix(f".{ending}"))
        tests = rows[rows["row"] == "test"]
        assert tests["name"].tolist() == list("abcde")
        assert tests["failed"].notna().tolist() == [False, False, False, True, False]
        found = rows[rows["row"] == "antiresonance"]
        assert found["freq_hz"].tolist() == in_memory.to_dataframe()["freq_hz"].tolist()
        assert set(found) >= {"dof", "damping_ratio", "std_hz", "temperature_c", "time", "score_how"}
    refused("cannot be read", ar.Series.load, store.with_suffix(".csv"))


def test_torn_anywhere_it_goes_on_to_the_same_file(store, whole, tmp_path):
    """What a kill or a power cut leaves: a database, and a log behind it that may end anywhere."""
    seen = tmp_path / "seen"
    seen.mkdir()
    stopped(store, then=lambda: [shutil.copy(file, seen) for file in tmp_path.glob("year.parquet.part*")])
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


def test_tables_have_the_same_bytes_in_whatever_order_tests_were_made(tmp_path):
    ar.identify_series([one for one in SOURCES if one[0] != "b"], **OPTIONS, store=tmp_path / "parts.sqlite")
    for how, workers in (("whole", "threads"), ("parts", None)):
        series = identified(tmp_path / f"{how}.sqlite", workers=workers)
        for ending in ("parquet", "csv"):
            series.save(tmp_path / f"{how}.{ending}")
    for ending in ("parquet", "csv"):
        whole, parts = (tmp_path / f"{how}.{ending}" for how in ("whole", "parts"))
        assert whole.read_bytes() == parts.read_bytes()


def test_a_changed_source_is_done_again_with_a_word(store):
    identified(store)
    changed = [SOURCES[0], ("b", record(7)), *SOURCES[2:]]
    with pytest.warns(ar.AntiresWarning, match="1 sources have changed.*'b'"):
        series = identified(store, changed)
    assert series[1] == ar.identify_antiresonances(record(7), **OPTIONS, check="off")
    alone = store.with_name("alone.parquet")
    identified(alone, changed)
    assert store.read_bytes() == alone.read_bytes()


@pytest.mark.parametrize("through", [True, False])
def test_other_options_are_refused_and_the_first_is_named(store, through):
    identified(store, SOURCES[:3]) if through else stopped(store)
    assert part_path(store).exists() is not through
    for changed in ({"band_hz": (0.8, 7.0), "excitation": 1, "max_order": 20}, {"max_order": 20}):
        refused(f"made with {next(iter(changed))} = .* in place of", identified, store, **changed)


@pytest.mark.parametrize("through", [True, False])
def test_options_by_which_every_test_failed_may_be_corrected(store, monkeypatch, through):
    def identify(signal, band_hz, **_):
        if band_hz[1] > 16.0:
            raise ValueError("band beyond the record")
        return FOUND

    monkeypatch.setattr(one_test, "identify_antiresonances", identify)

    def made(band_hz, count=3):
        sources = iter(SOURCES[:count]) if through else ended(SOURCES[:count], KeyboardInterrupt)
        return ar.identify_series(sources, **(OPTIONS | {"band_hz": band_hz}), store=store)

    assert list(made((3.0, 130.0)))[:2] == [None, None]
    assert made((0.8, 8.0), count=2)[0] == FOUND  # sources that gave nothing need not come again
    assert made((0.8, 8.0), count=2)[0] == FOUND
    refused("made with band_hz", made, (0.8, 7.0))


@pytest.mark.parametrize("then", ["finished", "begun anew", "grown"])
def test_a_stopped_series_never_has_the_sets_of_other_records(store, then):
    before = ar.identify_series(ended(SOURCES[:3], KeyboardInterrupt), **OPTIONS, store=store)
    first = before[0]
    if then == "finished":
        ar.identify_series(SOURCES[:3], **OPTIONS, store=store)
    else:
        if then == "begun anew":
            part_path(store).unlink()
        others = SOURCES[:3] if then == "grown" else [("a", record(7)), *SOURCES[1:3]]
        ar.identify_series(ended(others, KeyboardInterrupt), **OPTIONS, store=store)
    if then == "grown":
        assert before[0] == first
        return
    said = r"has ended or was begun anew.*Series\.load\(.*year\.parq"
    refused(said, before.__getitem__, 0)
    assert ar.Series.load(store)[0] is not None


def test_a_store_in_use_is_refused(store):
    elsewhere = Store(store, CONFIG)
    refused("another process writes", identified, store)
    elsewhere.close()


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [("a.parquet", b"PAR1 torn", "cannot be read"), ("a.parquet", None, "another kind")]
    + [("a.sqlite", b"SQLite format 3\0 torn", "cannot be read")],
)
def test_files_of_another_kind(tmp_path, name, content, said):
    import pyarrow.parquet

    if content is None:
        pyarrow.parquet.write_table(pyarrow.table({"a": [1]}), tmp_path / name)
    else:
        (tmp_path / name).write_bytes(content)
    refused(f"^path: got .*{said}", ar.Series.load, tmp_path / name)
    refused(f"^store: got .*{said}", identified, tmp_path / name)
    with pytest.raises(FileNotFoundError):
        ar.Series.load(tmp_path / "absent.parquet")


@pytest.mark.parametrize(("ending", "places"), [("sqlite", 200), ("parquet", 60)])
def test_a_flipped_bit_is_told_and_takes_nothing_else(tmp_path, monkeypatch, ending, places):
    monkeypatch.setattr(stored_tests, "in_a_child", lambda *_: None)  # a process for each place takes long
    sets = [ar.AntiresonanceSet(0, {0: [2.0 + i, 50.0], 1: [3.0]}) for i in range(30)]
    sets = [one.add(1, 9.0, reason=f"seen in curve {i}") for i, one in enumerate(sets)]
    temperature_c = 20.0 + np.arange(30.0) / 8.0
    series = ar.Series.from_sets(
        sets, names=[f"t{i}" for i in range(30)], conditions={"temperature_c": temperature_c}
    )
    file, torn = tmp_path / f"good.{ending}", tmp_path / f"torn.{ending}"
    series.save(file)
    rng, lost = np.random.default_rng(4), []

    def tests(series):
        values = zip(series, map(repr, series.conditions["temperature_c"]), strict=True)
        return dict(zip(series.names, ((one, str(one), more) for one, more in values), strict=True))

    whole = tests(series)
    for _ in range(places):
        data = bytearray(file.read_bytes())
        data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
        torn.write_bytes(data)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            try:
                there = tests(ar.Series.load(torn))
            except ar.AntiresError:
                continue
        lost.append(sum(there.get(name) != one for name, one in whole.items()))
        assert told or not lost[-1]
    assert np.mean(np.array(lost) <= 1) > 0.97  # a page of the database has several tests


def test_facts_of_a_series_that_were_changed_are_told(tmp_path):
    store = tmp_path / "year.sqlite"
    stopped(store)
    with closing(sqlite3.connect(store)) as database, database:
        changed = "UPDATE series SET value = replace(value, '16', '18') WHERE name = 'config'"
        assert database.execute(changed).rowcount == 1
        assert (
            '"max_order": 18'
            in database.execute("SELECT value FROM series WHERE name = 'config'").fetchone()[0]
        )
    with pytest.warns(ar.AntiresWarning, match="the facts about it"):
        ar.Series.load(store)
    refused("the facts about it", identified, store)


@pytest.mark.parametrize("column", ["temperature_c", "freq_hz"])  # read when opened, and when a set is asked
def test_every_flipped_bit_of_a_column_is_told(tmp_path, monkeypatch, column):
    from pyarrow import parquet

    monkeypatch.setattr(stored_tests, "in_a_child", lambda *_: None)
    sets = [ar.AntiresonanceSet(0, {0: [2.0 + 0.37 * i, 50.0 + 0.11 * i]}) for i in range(8)]
    series = ar.Series.from_sets(sets, conditions={"temperature_c": 20.0 + 0.731 * np.arange(8.0)})
    file, torn = tmp_path / "good.parquet", tmp_path / "torn.parquet"
    series.save(file)
    about = parquet.read_metadata(file)
    group = about.row_group(0)
    chunk = next(c for c in map(group.column, range(group.num_columns)) if c.path_in_schema == column)
    first = chunk.dictionary_page_offset or chunk.data_page_offset
    for place in range(first, first + chunk.total_compressed_size):
        data = bytearray(file.read_bytes())
        data[place] ^= 1
        torn.write_bytes(data)
        try:
            again = ar.Series.load(torn)
            assert (
                again.conditions["temperature_c"].tolist() == series.conditions["temperature_c"].tolist()
            ), place
            assert list(again) == sets, place
        except ar.AntiresError:
            continue


def test_a_store_of_the_version_before_goes_on(tmp_path, in_memory):
    store = tmp_path / "year.sqlite"
    stopped(store)
    with closing(sqlite3.connect(store)) as database, database:
        database.execute("ALTER TABLE tests DROP COLUMN checksum")
        database.execute("DELETE FROM series WHERE name = 'checksum'")
        database.execute("UPDATE series SET value = '2' WHERE name = 'version'")
    assert_same(identified(store), in_memory)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and SIGKILL")
@pytest.mark.parametrize("scenario", some_of(["longer series", "series"]))
def test_killed_before_any_change_on_the_disk(tmp_path, scenario):
    """It goes on to the same file, and leaves nothing; benchmarks/series_kills.py kills at random times."""
    command = [sys.executable, "-m", "tests.support.kill_points", tmp_path, scenario, "whole"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["points"] >= 6
    assert found["wrong"] == {}


def test_sets_of_several_forces_are_kept(store):
    one = ar.AntiresonanceSet([0, 4], {(1, 5): [36.2, 58.5], (0, 2): []}, channels=range(6))
    series = ar.Series.from_sets([one, one.add((0, 2), 7.0)], names=["x", "y"])
    series.save(store)
    again = ar.Series.load(store)
    assert again == series
    assert again.excitation == (0, 4)
    assert again.dofs == ((1, 5), (0, 2))
    assert list(again[0]) == [(1, 5), (0, 2)]
    assert again.tracks().to_dataframe()["dof"].tolist()[0] == "1, 5"
