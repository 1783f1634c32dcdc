"""What users get wrong: paths, options of the readers, questions; and what is left of a series that ended."""

import functools
import json
import re

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.watch import sources as one_test
from antires_rs.watch.identify_series import _plain, _progress
from reference.small_records import OPTIONS, record
from tests.watch.test_series import series

FOUND = ar.AntiresonanceSet(0, {0: [2.0, 5.0], 1: []})


@pytest.fixture
def quick(monkeypatch):
    """Each test has one antiresonance, by its record."""

    def identify(signal, **_):
        return ar.AntiresonanceSet(0, {0: [2.0 + abs(signal.responses[0, 0])], 1: []})

    monkeypatch.setattr(one_test, "identify_antiresonances", identify)


@pytest.fixture
def records(tmp_path):
    rng = np.random.default_rng(0)
    for day in ("monday", "tuesday"):
        (tmp_path / day).mkdir()
        for i in (1, 2):
            made = ar.Recording(rng.standard_normal((3, 50)), 32.0)
            ar.write_npz(tmp_path / day / f"test_{i}.npz", made)
    return tmp_path


def given(i):
    return ar.Recording(np.full((2, 50), float(i)) + np.arange(50), 32.0)


@pytest.mark.parametrize("path", ["mondya", "monday/test_3.npz", "sunday/*.npz"])
def test_a_path_that_does_not_exist_is_no_failed_test(records, path):
    pytest.importorskip("pyarrow")
    store = records / "year.parquet"
    with pytest.raises(ar.InvalidInputError, match="sources: got .*(does not exist|names no file)"):
        ar.identify_series(records / path, **OPTIONS, store=store)
    assert not list(records.glob("year*"))


@pytest.mark.parametrize(
    ("pattern", "names"),
    [
        ("monday/test_?.npz", ["test_1.npz", "test_2.npz"]),
        ("*/test_2.npz", ["monday/test_2.npz", "tuesday/test_2.npz"]),
        ("monday/test_[2-9].npz", ["test_2.npz"]),
    ],
)
def test_patterns_anywhere(records, quick, monkeypatch, pattern, names):
    monkeypatch.chdir(records)
    assert ar.identify_series(pattern, **OPTIONS).names == tuple(names)


@pytest.mark.parametrize(
    ("reading", "said"),
    [
        ({"foo": 1}, "reading: got 'foo', which read_npz does not take"),
        ({"delimiter": ";"}, "'delimiter', which read_npz does not take"),  # of another reader
        ({"format": "flac"}, r"reading\['format'\]: got 'flac'"),
        (3, "reading: got 3; wanted options"),
    ],
)
def test_wrong_options_of_the_readers_are_no_failed_tests(records, reading, said):
    for sources in (records / "monday", [records / "monday" / "test_1.npz"]):
        with pytest.raises(ar.InvalidInputError, match=said):
            ar.identify_series(sources, **OPTIONS, reading=reading)


def test_right_options_of_the_readers(records, quick):
    for reading in ({"dofs": [5, 6, 7]}, {"format": "npz"}, {"force": None, "fs_hz": None}):
        assert not ar.identify_series(records / "monday", **OPTIONS, reading=reading).failed


def own(path, unit="g"):
    return record()


class Own:
    def __call__(self, path):
        return record()


@pytest.mark.parametrize(
    ("reader", "text"), [(functools.partial(own, unit="g"), "own.*unit='g'"), (Own(), "Own"), (own, "own")]
)
def test_a_function_is_recorded_by_its_name(reader, text):
    """Not by an address, which is another one in the process that goes on."""
    written = json.dumps(reader, default=_plain)
    assert " at 0x" not in written
    assert re.search(text, written)


def test_a_function_that_is_no_map():
    wrong = pytest.raises(ar.InvalidInputError, match="workers: got .*len")
    with wrong, pytest.warns(FutureWarning, match="has no submit"):
        ar.identify_series([given(0)], **OPTIONS, workers=len)


def interrupted(store):
    def sources():
        yield from map(given, range(3))
        raise KeyboardInterrupt

    return ar.identify_series(sources(), **OPTIONS, store=store)


@pytest.mark.parametrize("then", ["finished", "begun anew"])
def test_a_stopped_series_says_that_it_is_another_one_now(tmp_path, quick, then):
    """Never the sets of other records, which are at the same places of the new journal."""
    pytest.importorskip("pyarrow")
    store = tmp_path / "year.parquet"
    stopped = interrupted(store)
    assert stopped[0][0].tolist() == [2.0]
    if then == "finished":
        ar.identify_series(list(map(given, range(3))), **OPTIONS, store=store)
    else:
        (tmp_path / "year.parquet.part").unlink()

        def others():
            yield from map(given, range(5, 8))
            raise KeyboardInterrupt

        ar.identify_series(others(), **OPTIONS, store=store)
    with pytest.raises(
        ar.InvalidInputError, match=r"has ended or was begun anew.*Series\.load\(.*year\.parq"
    ):
        stopped[0]
    assert ar.Series.load(store)[0] is not None


def test_a_stopped_series_stays_usable_while_its_journal_grows(tmp_path, quick):
    pytest.importorskip("pyarrow")
    stopped = interrupted(tmp_path / "year.parquet")
    interrupted(tmp_path / "year.parquet")
    assert stopped[1][0].tolist() == [3.0]


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
    assert len(kept) == (3 if ends == "generator" else 4)  # the next one is read while one is computed
    assert kept[0][0].tolist() == [2.0]


def test_the_store_is_named_and_the_difference_is_always_the_same(tmp_path, quick):
    pytest.importorskip("pyarrow")
    junk = tmp_path / "junk.parquet"
    junk.write_bytes(b"PAR1 torn")
    with pytest.raises(ar.InvalidInputError, match="^store: got .*cannot be read"):
        ar.identify_series([given(0)], **OPTIONS, store=junk)
    store = tmp_path / "year.parquet"
    ar.identify_series([given(0)], **OPTIONS, store=store)
    changed = OPTIONS | {"band_hz": (0.9, 7.0), "max_order": 20, "excitation": 1}
    for less in ((), ("band_hz",), ("band_hz", "excitation")):
        given_now = changed | {name: OPTIONS[name] for name in less}
        first = next(name for name in ("band_hz", "excitation", "max_order") if name not in less)
        with pytest.raises(ar.InvalidInputError, match=f"made with {first} = "):
            ar.identify_series([given(0)], **given_now, store=store)


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ("a", "series.*got a"),
        (1.5, "an index, a slice"),
        ([1.5], "an index, a slice"),
        ([True, False], "a mask of 2; wanted one of 4"),
        ([1, 1], "more than once"),
        ([1, -3], "more than once"),
        ([[1, 2]], "an index, a slice"),
    ],
)
def test_wrong_indices(at, said):
    with pytest.raises(ar.InvalidInputError, match=said):
        series()[at]


@pytest.mark.parametrize("at", [4, -5, [0, 4]])
def test_no_such_test(at):
    with pytest.raises(IndexError, match="of a series of 4"):
        series()[at]


@pytest.mark.parametrize("at", [[], slice(4, 4), np.zeros(4, bool)])
def test_none_of_the_tests(at):
    none = series()[at]
    assert len(none) == 0
    assert "temperature_c" not in str(none)


@pytest.mark.parametrize("failed", [{9: "x"}, {0: "x"}, {"a": "x"}, {True: "x"}, [1]])
def test_reasons_of_tests_that_did_not_fail(failed):
    with pytest.raises(ar.InvalidInputError, match="failed: got"):
        ar.Series.from_sets([FOUND, FOUND, None], failed=failed)


@pytest.mark.parametrize("through", [True, False], ids=["through", "stopped"])
def test_options_by_which_every_test_failed_may_be_corrected(tmp_path, monkeypatch, through):
    pytest.importorskip("pyarrow")

    def identify(signal, band_hz, **_):
        if band_hz[1] > 16.0:
            raise ValueError("band beyond the record")
        return FOUND

    monkeypatch.setattr(one_test, "identify_antiresonances", identify)
    store = tmp_path / "year.parquet"

    def sources(count):
        yield from map(given, range(count))
        if not through:
            raise KeyboardInterrupt

    def made(band_hz, count=3):
        return ar.identify_series(sources(count), **(OPTIONS | {"band_hz": band_hz}), store=store)

    assert list(made((3.0, 130.0)))[:2] == [None, None]
    corrected = made((0.8, 8.0), count=2)  # sources that gave nothing need not come again
    assert corrected[0] == FOUND
    assert made((0.8, 8.0), count=2)[0] == FOUND
    with pytest.raises(ar.InvalidInputError, match="made with band_hz"):
        made((0.8, 7.0))


def test_the_rest_time_is_at_the_pace_of_what_is_new():
    assert _progress(60, 100, 2, 30.0, 10) == "test 60 of 100, 2 failed, about 2 min left"
    assert _progress(100, 100, 0, 30.0, 10) == "test 100 of 100"


def test_a_column_that_is_left_out_is_told_to_the_caller(quick):
    with pytest.warns(ar.AntiresWarning, match="'remark' is left out") as told:
        ar.identify_series([given(0)], **OPTIONS, conditions={"remark": ["rain"]})
    assert told[0].filename == __file__
