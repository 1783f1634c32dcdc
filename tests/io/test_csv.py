"""Columns of text of other programs: delimiters, decimal signs, names, units, roles, gaps, cuts."""

import warnings

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app.reading import read_signal
from reference.io_signals import recording
from tests.support.refusals import refused, unsuitable

TIME = np.arange(50) / 200.0
TIP, ROOT, PUSH = np.random.default_rng(0).standard_normal((3, 50))


def text(*columns, head="", between=",", comma=False, end="\n"):
    body = "\n".join([between.join(repr(float(v)) for v in row) for row in zip(*columns, strict=True)])
    return head + (body.replace(".", ",") if comma else body) + end


def saved(path, content):
    path.write_text(content, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("between", "comma"), [(",", False), (";", False), (";", True), ("\t", True), ("  ", False)]
)
@pytest.mark.parametrize(
    "head",
    [
        "time [s]{0}tip [g]{0}root [g]{0}push [N]\n",
        "# bench 3\nt{0}tip (g){0}root (g){0}push (N)\n",
        "time{0}tip{0}root{0}push\ns{0}g{0}g{0}N\n",
        '"time"{0}"tip"{0}"root"{0}"push"\n[s]{0}[g]{0}[g]{0}[N]\n',
    ],
)
def test_names_and_units_in_every_dress(tmp_path, between, comma, head):
    if between == "  ":
        head = head.replace(" [", "[").replace(" (", "(") if "bench" not in head else head.replace(" (", "(")
    content = text(TIME, TIP, ROOT, PUSH, between=between, comma=comma, head=head.format(between))
    rec = ar.read_csv(saved(tmp_path / "a.csv", content))
    assert (rec.fs_hz, rec.dofs) == (200.0, ("tip", "root"))
    np.testing.assert_allclose(rec.responses, 9.80665 * np.array([TIP, ROOT]), rtol=1e-15)
    np.testing.assert_array_equal(rec.force, PUSH)


def test_names_in_a_comment(tmp_path):
    """As numpy.savetxt writes them; a comment that does not fit is none."""
    path = tmp_path / "a.csv"
    table = np.column_stack([TIME, TIP, ROOT])
    np.savetxt(path, table, delimiter=",", header="made on a Monday\ntime,tip,root")
    assert ar.read_csv(path).dofs == ("tip", "root")
    np.savetxt(path, table, delimiter=",", header="time, tip and root")
    assert ar.read_csv(path, first="time").dofs == (0, 1)


def clock(n, step, head="time,tip", form="g", start=0.0):
    return head + "\n" + "".join(f"{start + i * step:{form}},{1.5 + i % 3}\n" for i in range(n))


IN_UNITS = {"time [ms]": 2e3, "t (msec)": 2e3, "time [us]": 2e6, "time [h]": 1.0 / 1800.0}


@pytest.mark.parametrize(
    ("content", "fs_hz"),
    [
        *((clock(40, step), 1.0 / step) for step in (1.0, 3.0, 60.0, 0.25)),
        *((clock(2000, 1.0 / fs, form=".6f"), fs) for fs in (1000.0, 12800.0, 44100.0, 51200.0)),
        (clock(20, 10, "timestamp,tip [g]", "d", 1714820000000), 100.0),  # milliseconds since 1970
        *((clock(4, 0.5, f"{head},tip [g]", ".7f"), pytest.approx(fs)) for head, fs in IN_UNITS.items()),
        (clock(4, 0.5, "time,tip\nms,g", ".7f"), pytest.approx(2e3)),
    ],
)
def test_the_rate_behind_instants(tmp_path, content, fs_hz):
    path = saved(tmp_path / "a.csv", content)
    assert ar.read_csv(path).fs_hz == fs_hz
    given = getattr(fs_hz, "expected", fs_hz)
    assert ar.read_csv(path, fs_hz=given).fs_hz == given  # which the instants confirm


@pytest.mark.parametrize(
    ("head", "unit_hz"),
    [
        *(("freq [kHz],tip", 1000.0), ("omega [rad/s],tip", 0.5 / np.pi), ("f (rad/sec),tip", 0.5 / np.pi)),
        *(("f,tip\nkHz,furlong", 1000.0), ("f,tip\nHz,furlong", 1.0)),
    ],
)
def test_frequencies_in_other_units_than_hertz(tmp_path, head, unit_hz):
    path = saved(tmp_path / "a.csv", head + "\n0.1,1+1j\n0.2,2+1j\n0.3,3-1j\n")
    found = ar.read_csv(path, unit="g/N").freq_hz
    np.testing.assert_allclose(found, np.array([0.1, 0.2, 0.3]) * unit_hz, rtol=1e-15)
    if "furlong" in head:
        with pytest.warns(ar.AntiresWarning, match="'furlong', which is no unit known here"):
            assert ar.read_csv(path).values[0, 0] == 1 + 1j


def test_rows_that_end_with_a_delimiter(tmp_path):
    whole = text(TIME, TIP, ROOT, head="time;tip;root\n", between=";").replace("\n", ";\n")
    assert ar.read_csv(saved(tmp_path / "a.csv", whole)).dofs == ("tip", "root")
    names_without = saved(tmp_path / "c.csv", whole.replace("root;", "root", 1))
    assert np.array_equal(ar.read_csv(names_without).responses, [TIP, ROOT])
    for content, row in ((whole[:-4], 50), (";\n0", 1), ("a;\n0\n", 1), (";\n0\n", 1)):
        cut = saved(tmp_path / "b.csv", content)
        unsuitable(f"row {row} is cut, {row - 1} are whole", ar.read_csv, cut)


def test_without_names(tmp_path):
    path = saved(tmp_path / "a.csv", text(TIME, TIP, ROOT))
    assert ar.read_csv(path, first="time").dofs == (0, 1)
    rec = ar.read_csv(path, first="channel", fs_hz=200.0)
    assert rec.dofs == (0, 1, 2)
    np.testing.assert_array_equal(rec.responses[0], TIME)
    refused("^fs_hz: got None", ar.read_csv, path, first="channel")
    refused("^first: got 'x'", ar.read_csv, path, first="x")


def test_cuts(tmp_path):
    whole = text(TIME, TIP, ROOT, head="time,tip,root\n")
    lines = whole.splitlines(keepends=True)
    path = saved(tmp_path / "a.csv", "".join(lines[:49]) + lines[49][:9])
    unsuitable("row 49 is cut, 48 are whole", ar.read_csv, path)
    with pytest.warns(ar.AntiresWarning, match="incomplete: row 49 is cut, 48 are whole"):
        assert ar.read_csv(path, partial=True).n_samples == 48
    # All columns are there, but the last number may have lost digits.
    with pytest.warns(ar.AntiresWarning, match="no line end after its last row"):
        ar.read_csv(saved(tmp_path / "b.csv", whole[:-1]))


def test_rows_are_counted_against_our_header(tmp_path):
    path = ar.write_csv(tmp_path / "a.csv", recording())
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:-7]))
    unsuitable("250 of 257 rows are there", ar.read_csv, path)
    with pytest.warns(ar.AntiresWarning, match="incomplete: 250 of 257 rows"):
        assert ar.read_csv(path, partial=True).n_samples == 250
    path.write_text("".join([*lines, lines[-1]]))
    unsuitable("258 of 257 rows", ar.read_csv, path, partial=True)
    path.write_text("".join(lines).replace("csv 1\n", "csv 2\n"))
    unsuitable("of version '2'.*Update antires_rs", ar.read_csv, path)
    path.write_text("".join(lines).replace("# force: true\n", ""))
    unsuitable("checksum", ar.read_csv, path)


def test_a_flipped_bit_changes_no_number_in_silence(tmp_path):
    signal, rng = recording(), np.random.default_rng(2)
    data, torn = ar.write_csv(tmp_path / "a.csv", signal).read_bytes(), tmp_path / "b.csv"
    for _ in range(150):
        changed = bytearray(data)
        changed[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
        torn.write_bytes(changed)
        try:
            found = ar.read_csv(torn)
        except ar.AntiresError:
            continue
        np.testing.assert_array_equal(found.responses, signal.responses)


def test_units_that_are_written(tmp_path):
    refused("^unit: got 'g'; wanted an SI unit", ar.write_csv, tmp_path / "a.csv", recording(), unit="g")
    odd = ar.Recording([TIP, ROOT], 200.0, dofs=["=cmd|' /C calc'!A0", "+Z"])
    file = ar.write_csv(tmp_path / "b.csv", odd)  # which a spreadsheet would carry out
    assert file.read_text().splitlines()[-51].startswith("time [s],'=cmd|' /C calc'!A0 [m/s2],+Z [")
    assert ar.read_csv(file).dofs == odd.dofs
    refused("^delimiter: got '|'", ar.write_csv, tmp_path / "a.csv", recording(), delimiter="|")
    assert 'unit: "m/s"' in ar.write_csv(tmp_path / "a.csv", recording(), unit="m/s").read_text()


def test_decimal_commas_that_only_the_first_rows_have(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("time;tip\n0;0,5\n1;0,25\n" + "".join(f"{i};0\n" for i in range(2, 12)))
    assert ar.read_csv(file).responses[0].tolist() == [0.5, 0.25] + [0.0] * 10


@pytest.mark.parametrize("head", ["time,tip,root\n", "time [s],tip [g],root [g]\n", "bench 3\n", ""])
@pytest.mark.parametrize(
    "columns", [(TIME, TIP, ROOT), (TIP, ROOT, PUSH), (TIP, np.round(TIME, 1), np.arange(50.0))]
)
@pytest.mark.parametrize("form", [".6f", "g", ".3e"])
def test_decimal_commas_between_commas(tmp_path, head, columns, form):
    """Where every number has decimals, and where zeros at its end are left out."""
    lines = (",".join(format(float(value), form) for value in row) for row in zip(*columns, strict=True))
    file = saved(tmp_path / "a.csv", head + "\n".join(lines).replace(".", ",") + "\n")
    for options in ({}, {"fs_hz": 200.0}, {"delimiter": ",", "decimal": ","}):
        told = "decimal commas cannot be told from the commas .* Export it again"
        unsuitable(told, ar.read_csv, file, **options)


def test_whole_numbers_between_commas_have_no_decimals(tmp_path):
    counts = np.random.default_rng(1).integers(-3000, 3000, (6, 50))
    for head in ("a,b,c,d,e,f\n", ""):
        lines = (",".join(map(str, row)) for row in counts.T)
        rec = ar.read_csv(saved(tmp_path / "a.csv", head + "\n".join(lines) + "\n"), fs_hz=100.0)
        np.testing.assert_array_equal(rec.responses, counts)


@pytest.mark.parametrize("head", ["tip,root\n", "time?,tip,root\n", ""])
def test_a_rate_is_asked_of_files_without_a_time_and_of_no_others(tmp_path, head):
    timed = head.count(",") == 2
    file = saved(tmp_path / "a.csv", text(*(TIME, TIP, ROOT) if timed else (TIP, ROOT), head=head))
    if timed:  # a column that ascends is no response
        for options in ({}, {"fs_hz": 500.0}):
            unsuitable("'time\\?', ascends but is neither called time", ar.read_csv, file, **options)
        coarse = saved(tmp_path / "b.csv", text(np.round(TIME, 2), TIP, ROOT, head=head))
        unsuitable("'time\\?', ascends", ar.read_csv, coarse, fs_hz=500.0)
    else:
        unsuitable(
            "without a column of time or frequency; wanted a sampling rate. Pass fs_hz=", ar.read_csv, file
        )
        np.testing.assert_array_equal(ar.read_csv(file, fs_hz=500.0).responses, [TIP, ROOT])


def test_quotes_around_names_and_numbers(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text('"time [s]","tip, left [g]"\n"0","1.0"\n"0.5","2.0"\n"1","3"\n')
    record = ar.read_csv(file)
    assert (record.fs_hz, record.dofs) == (2.0, ("tip, left",))
    assert record.responses[0] == pytest.approx([9.80665, 19.6133, 29.41995], rel=1e-15)


def test_channels_that_are_left_out_need_not_fit_the_rest(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("time [s],tip [g],laser [mm]\n0,1,20\n0.5,2,20\n1,3,20\n")
    unsuitable("several kinds.* Leave out those of other kinds", ar.read_csv, file)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ar.read_csv(file, dofs={"tip": 4, "laser": None}).dofs == (4,)
        assert read_signal(file, "csv", {"dofs": {"tip": 4, "laser": False}}).dofs == (4,)


def test_unicode_text_of_excel(tmp_path):
    content = "time [s]\ttip [µm]\r\n0,0\t1,5\r\n0,1\t2,5\r\n0,2\t3,5\r\n"
    (tmp_path / "a.csv").write_bytes(content.encode("utf-16"))
    made = ar.read_csv(tmp_path / "a.csv")
    assert made.fs_hz == 10.0
    np.testing.assert_allclose(made.responses, [[1.5e-6, 2.5e-6, 3.5e-6]])


@pytest.mark.parametrize(
    ("fs_hz", "first_s", "seconds"),
    [(1260.0, 0, 60), (512.0, 0, 100), (2048.0, 0, 20), (512.0, 0, 0.8), (1260.0, 9.9, 0.32), (200.0, 97, 4)],
)
def test_instants_of_six_digits_have_fewer_places_the_later_they_are(tmp_path, fs_hz, first_s, seconds):
    """Also where they get another digit within the last rows."""
    instants = first_s + np.arange(int(fs_hz * seconds)) / fs_hz
    columns = np.column_stack([instants, np.sin(instants)])
    np.savetxt(tmp_path / "a.csv", columns, "%.6g", ",", header="Time [s],a", comments="")
    assert ar.read_csv(tmp_path / "a.csv").fs_hz == fs_hz
    gap = np.delete(columns, 4 * len(columns) // 5, axis=0)
    np.savetxt(tmp_path / "a.csv", gap, "%.6g", ",", header="Time [s],a", comments="")
    with pytest.raises(ar.UnsuitableDataError, match="1 such gaps"):
        ar.read_csv(tmp_path / "a.csv")
