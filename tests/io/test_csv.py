"""Columns of text of other programs: delimiters, decimal signs, names, units, roles, gaps, cuts."""

import warnings

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app.reading import read_signal
from reference.io_signals import recording

TIME = np.arange(50) / 200.0
TIP, ROOT, PUSH = np.random.default_rng(0).standard_normal((3, 50))


def text(*columns, head="", between=",", comma=False, end="\n"):
    rows = [between.join(repr(float(v)) for v in row) for row in zip(*columns, strict=True)]
    body = "\n".join(rows)
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
    rec = ar.read_csv(
        saved(
            tmp_path / "a.csv",
            text(TIME, TIP, ROOT, PUSH, between=between, comma=comma, head=head.format(between)),
        )
    )
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


def test_rows_that_end_with_a_delimiter(tmp_path):
    whole = text(TIME, TIP, ROOT, head="time;tip;root\n", between=";").replace("\n", ";\n")
    assert ar.read_csv(saved(tmp_path / "a.csv", whole)).dofs == ("tip", "root")
    with pytest.raises(ar.UnsuitableDataError, match="row 50 is cut"):
        ar.read_csv(saved(tmp_path / "b.csv", whole[:-4]))


def test_dofs_and_roles_by_name(tmp_path):
    path = saved(tmp_path / "a.csv", text(TIME, TIP, ROOT, PUSH, head="time,tip,root,push\n"))
    assert ar.read_csv(path).dofs == ("tip", "root", "push")
    rec = ar.read_csv(path, force="push", dofs={"tip": 7, "root": None})
    assert rec.dofs == (7,)
    np.testing.assert_array_equal(rec.force, PUSH)
    assert ar.read_csv(path, force="push", dofs=str.upper).dofs == ("TIP", "ROOT")
    assert ar.read_csv(path, force="push", dofs=[3, 4], unit="mm/s2").responses[0, 0] == 1e-3 * TIP[0]
    with pytest.raises(ar.InvalidInputError, match="^force: got 'hammer'; wanted 'auto', None or a channel"):
        ar.read_csv(path, force="hammer")


def test_without_names(tmp_path):
    path = saved(tmp_path / "a.csv", text(TIME, TIP, ROOT))
    assert ar.read_csv(path, first="time").dofs == (0, 1)
    rec = ar.read_csv(path, first="channel", fs_hz=200.0)
    assert rec.dofs == (0, 1, 2)
    np.testing.assert_array_equal(rec.responses[0], TIME)
    with pytest.raises(ar.InvalidInputError, match="^fs_hz: got None"):
        ar.read_csv(path, first="channel")
    with pytest.raises(ar.InvalidInputError, match="^first: got 'x'"):
        ar.read_csv(path, first="x")


@pytest.mark.parametrize("letter", ["i", "j"])
def test_complex_numbers_over_frequency(tmp_path, letter):
    lines = [f"{f};{a:.17g}{b:+.17g}{letter}" for f, a, b in zip(TIME, TIP, ROOT, strict=True)]
    found = ar.read_csv(saved(tmp_path / "a.csv", "\n".join(lines) + "\n"), unit="g/N")
    assert (found.kind, found.dofs) == ("frf", (0,))
    np.testing.assert_allclose(found.values[0], 9.80665 * (TIP + 1j * ROOT), rtol=1e-15)


@pytest.mark.parametrize(
    "head", ["freq [Hz],re(tip),im(tip),tip2_re,tip2_im\n", "f,Re tip,Im tip,tip2 real,tip2 imag\n"]
)
def test_pairs_over_frequency(tmp_path, head):
    path = saved(tmp_path / "a.csv", text(TIME, TIP, ROOT, PUSH, TIP, head=head))
    found = ar.read_csv(path)
    assert found.dofs == ("tip", "tip2")
    np.testing.assert_array_equal(found.values, [TIP + 1j * ROOT, PUSH + 1j * TIP])


@pytest.mark.parametrize("step", ["1", "3", "60", "0.25"])
def test_instants_that_are_exact(tmp_path, step):
    rows = "".join(f"{i * float(step):g},1.5\n" for i in range(40))
    assert ar.read_csv(saved(tmp_path / "a.csv", "time,tip\n" + rows)).fs_hz == 1.0 / float(step)


@pytest.mark.parametrize("rate", [1000.0, 12800.0, 44100.0, 51200.0])
def test_the_rate_behind_rounded_instants(tmp_path, rate):
    rows = "".join(f"{i / rate:.6f},1.5\n" for i in range(2000))
    assert ar.read_csv(saved(tmp_path / "a.csv", "time,tip\n" + rows)).fs_hz == rate


def test_cuts(tmp_path):
    whole = text(TIME, TIP, ROOT, head="time,tip,root\n")
    lines = whole.splitlines(keepends=True)
    path = saved(tmp_path / "a.csv", "".join(lines[:49]) + lines[49][:9])
    with pytest.raises(ar.UnsuitableDataError, match="row 49 is cut, 48 are whole"):
        ar.read_csv(path)
    with pytest.warns(ar.AntiresWarning, match="incomplete: row 49 is cut, 48 are whole"):
        assert ar.read_csv(path, partial=True).n_samples == 48
    # All columns are there, but the last number may have lost digits.
    with pytest.warns(ar.AntiresWarning, match="no line end after its last row"):
        ar.read_csv(saved(tmp_path / "b.csv", whole[:-1]))


def test_rows_are_counted_against_our_header(tmp_path):
    path = ar.write_csv(tmp_path / "a.csv", recording())
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:-7]))
    with pytest.raises(ar.UnsuitableDataError, match="250 of 257 rows are there"):
        ar.read_csv(path)
    with pytest.warns(ar.AntiresWarning, match="incomplete: 250 of 257 rows"):
        assert ar.read_csv(path, partial=True).n_samples == 250
    path.write_text("".join([*lines, lines[-1]]))
    with pytest.raises(ar.UnsuitableDataError, match="258 of 257 rows"):
        ar.read_csv(path, partial=True)
    path.write_text("".join(lines).replace("csv 1\n", "csv 2\n"))
    with pytest.raises(ar.UnsuitableDataError, match="of version '2'.*Update antires_rs"):
        ar.read_csv(path)
    path.write_text("".join(lines).replace("# force: true\n", ""))
    with pytest.raises(ar.UnsuitableDataError, match="whose header is damaged"):
        ar.read_csv(path)


def test_units_that_are_written(tmp_path):
    with pytest.raises(ar.InvalidInputError, match="^unit: got 'g'; wanted an SI unit"):
        ar.write_csv(tmp_path / "a.csv", recording(), unit="g")
    with pytest.raises(ar.InvalidInputError, match="^delimiter: got '|'"):
        ar.write_csv(tmp_path / "a.csv", recording(), delimiter="|")
    assert 'unit: "m/s"' in ar.write_csv(tmp_path / "a.csv", recording(), unit="m/s").read_text()


@pytest.mark.parametrize(
    ("head", "unit_s"),
    [
        ("time [ms],tip [g]", 1e-3),
        ("t (msec),tip [g]", 1e-3),
        ("time [us],tip [g]", 1e-6),
        ("time [h],tip [g]", 3600.0),
        ("time,tip\nms,g", 1e-3),
    ],
)
def test_time_in_other_units_than_seconds(tmp_path, head, unit_s):
    record = ar.read_csv(saved(tmp_path / "a.csv", head + "\n0.0000000,1\n0.5,2\n1.0,3\n1.5,2\n"))
    assert record.fs_hz == pytest.approx(2.0 / unit_s, rel=1e-6)
    assert record.responses[0, 0] == 9.80665


def test_milliseconds_since_1970_are_no_seconds(tmp_path):
    rows = "".join(f"{1714820000000 + 10 * i},{i}\n" for i in range(20))
    assert ar.read_csv(saved(tmp_path / "a.csv", f"timestamp,tip [g]\n{rows}")).fs_hz == 100.0


@pytest.mark.parametrize(
    ("head", "unit_hz"),
    [
        ("freq [kHz],tip", 1000.0),
        ("omega [rad/s],tip", 0.5 / np.pi),
        ("f (rad/sec),tip", 0.5 / np.pi),
        ("f,tip\nkHz,furlong", 1000.0),
        ("f,tip\nHz,furlong", 1.0),
    ],
)
def test_frequencies_in_other_units_than_hertz(tmp_path, head, unit_hz):
    path = saved(tmp_path / "a.csv", head + "\n0.1,1+1j\n0.2,2+1j\n0.3,3-1j\n")
    np.testing.assert_allclose(
        ar.read_csv(path, unit="g/N").freq_hz, np.array([0.1, 0.2, 0.3]) * unit_hz, rtol=1e-15
    )


def test_a_unit_that_is_not_known_is_warned_of_over_frequency_too(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("freq,tip [furlong]\n1,1+1j\n2,2+1j\n3,3-1j\n")
    with pytest.warns(ar.AntiresWarning, match="'furlong', which is no unit known here"):
        assert ar.read_csv(file).values[0, 0] == 1 + 1j


def test_decimal_commas_that_only_the_first_rows_have(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("time;tip\n0;0,5\n1;0,25\n" + "".join(f"{i};0\n" for i in range(2, 12)))
    assert ar.read_csv(file).responses[0].tolist() == [0.5, 0.25] + [0.0] * 10


@pytest.mark.parametrize("bad", ["0.0,1.#QNAN", "0.0,---", "0.0,"])
def test_a_first_row_that_is_damaged_is_not_taken_for_names(tmp_path, bad):
    file = tmp_path / "run.csv"
    file.write_text(f"time,tip\n{bad}\n0.1,2\n0.2,3\n0.3,4\n")
    with pytest.raises(ar.UnsuitableDataError, match="not numeric throughout"):
        ar.read_csv(file, first="time")


def test_quotes_around_names_and_numbers(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text('"time [s]","tip, left [g]"\n"0","1.0"\n"0.5","2.0"\n"1","3"\n')
    record = ar.read_csv(file)
    assert (record.fs_hz, record.dofs) == (2.0, ("tip, left",))
    assert record.responses[0] == pytest.approx([9.80665, 19.6133, 29.41995], rel=1e-15)


def test_channels_that_are_left_out_need_not_fit_the_rest(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("time [s],tip [g],laser [mm]\n0,1,20\n0.5,2,20\n1,3,20\n")
    with pytest.raises(ar.UnsuitableDataError, match="several kinds.* Leave out those of other kinds"):
        ar.read_csv(file)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ar.read_csv(file, dofs={"tip": 4, "laser": None}).dofs == (4,)
        # As a job and the command line say it.
        assert read_signal(file, "csv", {"dofs": {"tip": 4, "laser": False}}).dofs == (4,)


def test_a_rate_that_the_column_of_time_confirms(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("time [s],tip [g]\n" + "".join(f"{i / 512:.9f},{i % 7}\n" for i in range(64)))
    assert ar.read_csv(file, fs_hz=512.0).fs_hz == 512.0
    # In milliseconds it is the same time.
    file.write_text("time [ms],tip [g]\n" + "".join(f"{1e3 * i / 512:.6f},{i % 7}\n" for i in range(64)))
    assert ar.read_csv(file, fs_hz=512.0).fs_hz == 512.0


@pytest.mark.parametrize("content", [b";\n0", b"a;\n0\n", b";\n0\n"])
def test_names_and_a_single_row_that_is_cut(tmp_path, content):
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    with pytest.raises(ar.UnsuitableDataError, match="row 1 is cut, 0 are whole"):
        ar.read_csv(path)


def test_a_unit_of_time_that_is_not_known_is_refused(tmp_path):
    with pytest.raises(ar.UnsuitableDataError, match=r"'time', is in 'ticks'"):
        ar.read_csv(saved(tmp_path / "a.csv", "time [ticks],tip [g]\n0,1\n1,2\n2,3\n"))


def test_unicode_text_of_excel(tmp_path):
    content = "time [s]\ttip [µm]\r\n0,0\t1,5\r\n0,1\t2,5\r\n0,2\t3,5\r\n"
    (tmp_path / "a.csv").write_bytes(content.encode("utf-16"))
    made = ar.read_csv(tmp_path / "a.csv")
    assert made.fs_hz == 10.0
    np.testing.assert_allclose(made.responses, [[1.5e-6, 2.5e-6, 3.5e-6]])


def test_rows_end_with_a_delimiter_and_the_names_do_not(tmp_path):
    path = saved(tmp_path / "a.csv", "time;tip\n0;1;\n0.1;2;\n0.2;3;\n")
    assert ar.read_csv(path).responses.tolist() == [[1.0, 2.0, 3.0]]
