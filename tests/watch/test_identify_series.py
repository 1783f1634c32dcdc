"""Records to a series: sources of every kind, what fails, what users get wrong, Ctrl-C, and memory."""

import functools
import os
import signal
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.watch import sources as one_test
from reference.small_records import OPTIONS, dead, record
from tests.support.campaign import some_of
from tests.support.refusals import refused
from tests.support.same_sets import assert_same_set
from tests.support.snapshots import refusal, replay


@pytest.fixture
def quick(monkeypatch):
    def identify(source, **_):
        first = source[0] if isinstance(source, list) else source
        return ar.AntiresonanceSet(0, {0: [2.0 + abs(first.responses[0, 0])], 1: []})

    monkeypatch.setattr(one_test, "identify_antiresonances", identify)


def given(i):
    return ar.Recording(np.full((2, 50), float(i)) + np.arange(50), 32.0)


@pytest.fixture
def folder(tmp_path):
    for day in ("monday", "tuesday"):
        (tmp_path / day).mkdir()
        for i in (10, 2, 1):
            ar.write_npz(tmp_path / day / f"test_{i}.npz", record(i))
        (tmp_path / day / "notes.md").write_text("nothing of this is a measurement")
    return tmp_path


def test_each_set_is_that_of_one_call_without_diagrams():
    records = [record(0), record(1)]
    for one, found in zip(records, ar.identify_series(records, **OPTIONS), strict=True):
        assert_same_set(found, ar.identify_antiresonances(one, **OPTIONS))
        assert not found.diagrams


SOURCES = {
    "folder": lambda _, files: str(files[0].parent),
    "pattern": lambda _, files: files[0].parent / "test_*.npz",
    "list": lambda _, files: [str(files[0]), *files[1:]],
    "generator": lambda _, files: iter(files),
    "mapping": lambda names, files: dict(zip(names, map(ar.read_npz, files), strict=True)),
    "functions": lambda names, files: [
        (name, functools.partial(ar.read_npz, file)) for name, file in zip(names, files, strict=True)
    ],
    "repeats": lambda names, files: [(name, [file, file]) for name, file in zip(names, files, strict=True)],
}


@pytest.mark.parametrize("how", SOURCES)
def test_sources_of_every_kind(folder, quick, how):
    names = [f"test_{i}.npz" for i in (1, 2, 10)]
    series = ar.identify_series(SOURCES[how](names, [folder / "monday" / name for name in names]), **OPTIONS)
    assert series.names == tuple(names)
    expected = [2.0 + abs(record(i).responses[0, 0]) for i in (1, 2, 10)]
    assert [one[0].tolist() for one in series] == [[value] for value in expected]


def test_patterns_anywhere(folder, quick, monkeypatch):
    monkeypatch.chdir(folder)
    for pattern, names in {
        "monday/test_?.npz": ("test_1.npz", "test_2.npz"),
        "*/test_2.npz": ("monday/test_2.npz", "tuesday/test_2.npz"),
        "monday/test_[2-9].npz": ("test_2.npz",),
        "monday/test_1.npz": ("test_1.npz",),
    }.items():
        assert ar.identify_series(pattern, **OPTIONS).names == names


def test_conditions_come_with_a_source_or_beside(quick):
    own = {"temperature_c": 7.0, "time": "2026-01-31"}
    series = ar.identify_series(
        [given(0), ("1", given(1), own), ("x", given(2), {"wind": 3.0})],
        **OPTIONS,
        conditions={"temperature_c": [1, 2, 3]},
    )
    assert series.names == ("0", "1", "x")
    assert series.conditions["temperature_c"].tolist() == [1.0, 7.0, 3.0]
    np.testing.assert_array_equal(series.conditions["wind"], [np.nan, np.nan, 3.0])
    assert np.isnat(series.times).tolist() == [True, False, True]


def test_what_fails_is_kept_with_its_reason(tmp_path):
    torn = tmp_path / "torn.npz"
    torn.write_bytes(b"PK\x03\x04 and nothing more")
    short = ar.Recording(np.random.default_rng(0).standard_normal((3, 40)), 32.0)
    one = ar.Recording(record().responses[:1], 32.0)
    sources = [("good", record()), torn, tmp_path / "absent.npz", tmp_path / "what.xyz", ("short", short)]
    sources += [("one", one), ("broken", lambda: 1 / 0), ("last", record(1))]
    series = ar.identify_series(sources, **OPTIONS)
    assert [i for i, one in enumerate(series) if one is None] == list(series.failed) == [1, 2, 3, 4, 5, 6]
    said = {2: "FileNotFoundError", 3: "ending", 5: "a single channel", 6: "ZeroDivisionError"}
    assert all(text in series.failed[i] for i, text in said.items())
    assert "failed      6" in str(series)


def test_a_dead_sensor_is_left_out_and_told(recwarn):
    series = ar.identify_series([record(), dead(0, [1]), dead(0, [0, 1])], **OPTIONS)
    assert tuple(series[1]) == (0, 2)
    assert series[1].data_check.named("dead_channel")[0].where == (1,)
    assert not recwarn.list
    assert series.dofs == (0, 1, 2)
    assert 2 in series.failed  # one is left, which makes no transmissibility
    followed = series.tracks()
    np.testing.assert_array_equal(np.isnan(followed.freq_hz), [[False] * 3, [False, False, True]])
    assert followed.events == ()


@pytest.mark.parametrize("stored", [False, True])
def test_ctrl_c_hands_back_what_there_is(tmp_path, quick, stored):
    store = tmp_path / "a.parquet" if stored else None

    def sources():
        for i in range(6):
            if i == 4:
                signal.raise_signal(signal.SIGINT)
            yield given(i)

    series = ar.identify_series(sources(), **OPTIONS, store=store)
    assert series.interrupted
    assert 2 <= len(series) <= 4
    assert "interrupted" in str(series)
    if stored:
        assert ar.Series.load(store) == series
        done = ar.identify_series((given(i) for i in range(6)), **OPTIONS, store=store)
        assert (len(done), done.interrupted) == (6, False)
        assert os.listdir(tmp_path) == ["a.parquet"]


def test_memory_does_not_grow_with_the_records(tmp_path, monkeypatch):
    """The records are 180 kB each; what is kept of a test is 2 kB in memory, and 1 kB of one in a file."""
    found = ar.identify_antiresonances(record(), **OPTIONS)
    monkeypatch.setattr(one_test, "identify_antiresonances", lambda *_, **__: found)

    def peak(count, store):
        made = record()
        tracemalloc.start()
        sources = ((f"{i}", ar.Recording(made.responses + i, 32.0)) for i in range(count))
        series = ar.identify_series(sources, **OPTIONS, store=store)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(series) == count
        return most

    peak(2, None)
    for stores in ((None, None), (tmp_path / "few.parquet", tmp_path / "many.parquet")):
        few, many = map(peak, (10, 60), stores)
        assert (many - few) / 50 < 5e3


@pytest.mark.parametrize("workers", some_of([1, 2, "threads"], kept=["threads"]))
def test_any_workers_give_the_same_bits(folder, workers):
    sources = [folder / "monday" / "test_1.npz", folder / "absent.npz", dead(1, [1]), record(2)]
    alone = ar.identify_series(sources, **OPTIONS)
    assert alone.failed.keys() == {1}
    assert ar.identify_series(sources, **OPTIONS, workers=workers) == alone


def test_wrong_options_of_the_readers_are_no_failed_tests(folder):
    for reading, said in (
        ({"foo": 1}, "reading: got 'foo'; wanted options out of"),
        ({"delimiter": ";"}, "reading: got 'delimiter'"),  # of another reader
        ({"format": "flac"}, r"reading\['format'\]: got 'flac'"),
        (3, "reading: got 3; wanted options"),
    ):
        for sources in (folder / "monday", [folder / "monday" / "test_1.npz"]):
            refused(said, ar.identify_series, sources, **OPTIONS, reading=reading)


def test_readers_and_their_options(folder, quick):
    for reading in ({"dofs": [5, 6, 7]}, {"format": "npz"}, {"force": None, "fs_hz": None}):
        assert not ar.identify_series(folder / "monday", **OPTIONS, reading=reading).failed
    own = folder / "a.own"
    own.write_text("7")
    series = ar.identify_series([own], **OPTIONS, reading=lambda path: given(int(path.read_text())))
    assert series[0][0].tolist() == [9.0]


def own(path, unit):
    return given(0)


def test_a_function_is_recorded_by_its_name(tmp_path, quick):
    """Not by an address, which is another one in the process that goes on."""
    store, reader = tmp_path / "a.sqlite", functools.partial(own, unit="g")
    ar.identify_series([given(0)], **OPTIONS, store=store, reading=reader)
    with pytest.raises(ar.InvalidInputError, match="made with reading = .*own.*unit='g'") as error:
        ar.identify_series([given(0)], **OPTIONS, store=store)
    assert " at 0x" not in error.value.got


@pytest.mark.parametrize("ends", ["generator", "table"])
def test_an_exception_keeps_the_tests_so_far(quick, ends):
    def sources():
        yield from map(given, range(4))
        if ends == "generator":
            raise RuntimeError("the logger is gone")

    table = {"a": [1.0, 2.0, 3.0, 4.0] + [5.0] * (ends == "table")}
    with pytest.raises(RuntimeError if ends == "generator" else ar.InvalidInputError) as error:
        ar.identify_series(sources(), **OPTIONS, conditions=table)
    kept = error.value.series
    assert kept.interrupted
    assert len(kept) == 4
    assert kept[0][0].tolist() == [2.0]


def test_a_column_that_is_left_out_is_told_to_the_caller(quick):
    with pytest.warns(ar.AntiresWarning, match="'remark' is left out") as told:
        ar.identify_series([given(0)], **OPTIONS, conditions={"remark": ["rain"]})
    assert told[0].filename == __file__


def test_wrong_calls_are_no_failed_tests(tmp_path, monkeypatch):
    """Each line of the file is what is wrong in a call, and what is said of it."""
    pytest.importorskip("pyarrow")
    monkeypatch.chdir(tmp_path)
    usual = {"sources": [record()], "store": "year.parquet"} | OPTIONS
    with pytest.raises(TypeError, match="maximum"):
        ar.identify_series(**usual, maximum=3)
    file = Path(__file__).with_name("wrong_series.txt")
    replay(file, lambda wrong: refusal(lambda: ar.identify_series(**(usual | eval(wrong)))))
