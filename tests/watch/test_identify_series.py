"""Records to a series: sources of every kind, what fails, Ctrl-C, and that memory does not grow."""

import os
import signal
import tracemalloc

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.watch import sources as one_test
from reference.small_records import OPTIONS, dead, record
from tests.support.campaign import some_of


@pytest.fixture
def counted(monkeypatch):
    """Names of what is identified; only the first of each kind truly is."""
    real, seen, cache = one_test.identify_antiresonances, [], {}

    def identify(signal, **options):
        seen.append(signal)
        key = tuple((signal[0] if isinstance(signal, list) else signal).dofs)
        if key not in cache:
            cache[key] = real(signal, **options)
        return cache[key]

    monkeypatch.setattr(one_test, "identify_antiresonances", identify)
    return seen


def test_each_set_is_that_of_one_call_without_diagrams():
    records = [record(0), record(1)]
    series = ar.identify_series(records, **OPTIONS)
    for one, found in zip(records, series, strict=True):
        alone = ar.identify_antiresonances(one, **OPTIONS)
        assert found == alone
        assert found.sees == alone.sees
        assert found.channels == alone.channels
        assert found.scores.keys() == alone.scores.keys()
        assert found.data_check.findings == alone.data_check.findings
        assert not found.diagrams
        for dof, columns in alone.scores.items():
            for name, values in columns.items():
                np.testing.assert_array_equal(found.scores[dof][name], values)
                assert found.scores[dof][name].dtype.kind == values.dtype.kind


def folder(tmp_path):
    for i in (10, 2, 1):
        ar.write_npz(tmp_path / f"test_{i}.npz", record(i))
    (tmp_path / "notes.md").write_text("nothing of this is a measurement")
    return tmp_path


@pytest.mark.parametrize("how", ["folder", "pattern", "list", "generator", "mapping", "functions", "tuples"])
def test_sources_of_every_kind(tmp_path, counted, how):
    where = folder(tmp_path)
    files = [where / f"test_{i}.npz" for i in (1, 2, 10)]
    names = [file.name for file in files]
    given = {
        "folder": str(where),
        "pattern": where / "test_*.npz",
        "list": [str(files[0]), *files[1:]],
        "generator": iter(files),
        "mapping": dict(zip(names, (record(i) for i in (1, 2, 10)), strict=True)),
        "functions": [
            (name, lambda file=file: ar.read_npz(file)) for name, file in zip(names, files, strict=True)
        ],
        "tuples": [(name, [file, file]) for name, file in zip(names, files, strict=True)],
    }[how]
    series = ar.identify_series(given, **OPTIONS)
    assert series.names == tuple(names)
    assert not series.failed
    firsts = (
        [(one[0] if isinstance(one, list) else one).responses[0, 0] for one in counted]
        if how != "tuples"
        else []
    )
    assert firsts == [record(i).responses[0, 0] for i in (1, 2, 10)][: len(firsts)]


def test_what_fails_is_kept_with_its_reason(tmp_path):
    torn = tmp_path / "torn.npz"
    torn.write_bytes(b"PK\x03\x04 and nothing more")
    sources = [
        ("good", record()),
        torn,
        tmp_path / "absent.npz",
        tmp_path / "what.xyz",
        ("short", ar.Recording(np.random.default_rng(0).standard_normal((3, 40)), 32.0)),
        ("one", ar.Recording(record().responses[:1], 32.0)),
        ("broken", lambda: 1 / 0),
        ("last", record(1)),
    ]
    series = ar.identify_series(sources, **OPTIONS)
    assert sorted(series.failed) == [1, 2, 3, 4, 5, 6]
    for i, said in {
        2: "FileNotFoundError",
        3: "ending",
        5: "a single channel",
        6: "ZeroDivisionError",
    }.items():
        assert said in series.failed[i]
    assert [one is None for one in series] == [i in series.failed for i in range(8)]
    assert "failed      6" in str(series)


def test_a_dead_sensor_is_left_out_and_told():
    series = ar.identify_series([record(), dead(0, [1]), dead(0, [0, 1])], **OPTIONS)
    assert tuple(series[1]) == (0, 2)
    assert series[1].data_check.named("dead_channel")[0].where == (1,)
    assert series.dofs == (0, 1, 2)
    assert 2 in series.failed  # one is left, which makes no transmissibility
    followed = series.tracks()
    np.testing.assert_array_equal(np.isnan(followed.freq_hz), [[False] * 3, [False, False, True]])
    assert followed.events == ()


def test_findings_do_not_warn(recwarn):
    ar.identify_series([dead(0, [1])], **OPTIONS)
    assert not recwarn.list


@pytest.mark.parametrize("stored", [False, True])
def test_ctrl_c_hands_back_what_there_is(tmp_path, counted, stored):
    store = tmp_path / "a.parquet" if stored else None

    def sources():
        for i in range(6):
            if i == 4:
                signal.raise_signal(signal.SIGINT)
            yield record(i)

    series = ar.identify_series(sources(), **OPTIONS, store=store)
    assert series.interrupted
    assert 2 <= len(series) <= 4
    assert "interrupted" in str(series)
    if stored:
        assert ar.Series.load(store) == series
        done = ar.identify_series((record(i) for i in range(6)), **OPTIONS, store=store)
        assert len(done) == 6
        assert not done.interrupted
        assert len(counted) == 6
        assert os.listdir(tmp_path) == ["a.parquet"]


def test_memory_does_not_grow_with_the_records(tmp_path, monkeypatch):
    """The records are 180 kB each; what is kept of a test is 2 kB in memory, and 1 kB of one in a file."""
    found = ar.identify_antiresonances(record(), **OPTIONS)
    monkeypatch.setattr(one_test, "identify_antiresonances", lambda *_, **__: found)

    def peak(count, store):
        made = record()
        tracemalloc.start()
        series = ar.identify_series(
            ((f"{i}", ar.Recording(made.responses + i, 32.0)) for i in range(count)), **OPTIONS, store=store
        )
        held, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(series) == count
        return held, most

    peak(2, None)
    for store in (None, tmp_path / "a.parquet"):
        few, many = peak(10, store if store is None else tmp_path / "few.parquet"), peak(60, store)
        assert (many[1] - few[1]) / 50 < 5e3


@pytest.mark.parametrize("workers", some_of([1, 2, "threads"], kept=["threads"]))
def test_any_workers_give_the_same_bits(tmp_path, workers):
    where = folder(tmp_path)
    sources = [where / "test_1.npz", where / "absent.npz", dead(1, [1]), record(2)]
    alone = ar.identify_series(sources, **OPTIONS)
    assert alone.failed.keys() == {1}
    assert ar.identify_series(sources, **OPTIONS, workers=workers) == alone


def test_a_function_reads_files_of_any_kind(tmp_path):
    (tmp_path / "a.own").write_text("7")
    series = ar.identify_series(
        [tmp_path / "a.own"], **OPTIONS, reading=lambda path: record(int(path.read_text()))
    )
    assert series[0] == ar.identify_series([record(7)], **OPTIONS)[0]


WRONG = {
    "one record": ({"sources": record()}, ar.InvalidInputError, "sources"),
    "empty": ({"sources": []}, ar.InvalidInputError, "sources"),
    "empty generator": ({"sources": iter(())}, ar.InvalidInputError, "no source at all"),
    "empty folder": ({"sources": "."}, ar.InvalidInputError, "folder without measurements"),
    "a number": ({"sources": 3}, ar.InvalidInputError, "sources"),
    "numbers": ({"sources": [3]}, ar.InvalidInputError, r"sources\[0\]"),
    "twice": ({"sources": [("a", record()), ("a", record())]}, ar.InvalidInputError, "'a' more than once"),
    "preset": ({"preset": "strictest"}, ar.InvalidInputError, "preset"),
    "estimator": ({"estimator": "h3"}, ar.InvalidInputError, "estimator"),
    "band": ({"band_hz": (8, 1)}, ar.InvalidInputError, "band_hz"),
    "option": ({"maximum": 3}, TypeError, "maximum"),
    "store": ({"store": "year.h5"}, ar.InvalidInputError, r"\.parquet"),
    "store's folder": ({"store": "nowhere/year.parquet"}, ar.InvalidInputError, "folder that exists"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_calls(tmp_path, monkeypatch, wrong):
    monkeypatch.chdir(tmp_path)
    given, error, said = WRONG[wrong]
    with pytest.raises(error, match=said):
        ar.identify_series(**({"sources": [record()]} | OPTIONS | given))
