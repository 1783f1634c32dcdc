"""Excel and Parquet, and columns of text that count rows or hold instants."""

import datetime

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import unsuitable

RNG = np.random.default_rng(6)
N, FS = 200, 256.0
TIME = np.arange(N) / FS
A, B = RNG.standard_normal((2, N))
H = RNG.standard_normal((2, N)) + 1j * RNG.standard_normal((2, N))


def recorded(read, tolerance=1e-12):
    assert read.fs_hz == FS
    np.testing.assert_allclose(read.responses, [A, B], rtol=0, atol=tolerance)


def workbook(path, *rows, title="Sheet"):
    book = pytest.importorskip("openpyxl").Workbook()
    book.active.title = title
    for row in rows:
        book.active.append(row)
    book.create_sheet("notes").append(["nothing here"])
    book.save(path)
    return path


def test_excel_of_a_record(tmp_path):
    rows = [[t, a, b] for t, a, b in zip(TIME, A, B, strict=True)]
    recorded(ar.read_excel(workbook(tmp_path / "a.xlsx", ["time [s]", "a", "b"], *rows)))
    head = [["Test of the frame"], ["Time", "a", "b"], ["ms", "m/s2", "m/s2"]]
    file = workbook(tmp_path / "b.xlsx", *head, *[[1e3 * t, a, b] for t, a, b in rows], title="run 1")
    recorded(ar.read_excel(file, sheet="run 1"))
    assert ar.read_excel(file).dofs == ("a", "b")
    unsuitable("no row of numbers .the sheets are 'run 1', 'notes'", ar.read_excel, file, sheet="notes")
    unsuitable("no sheet is named 'run 2'", ar.read_excel, file, sheet="run 2")


def test_excel_of_responses(tmp_path, own_process):
    freq = 0.5 * np.arange(N)
    parts = [[f, *np.ravel([[h.real, h.imag] for h in column])] for f, column in zip(freq, H.T, strict=True)]
    names = ["Frequency [Hz]", "re(a)", "im(a)", "re(b)", "im(b)"]
    read = ar.read_excel(workbook(tmp_path / "a.xlsx", names, *map(list, parts)))
    np.testing.assert_allclose(read.values, H)
    texts = ([f"{float(h.real)!r}{h.imag:+.17g}i" for h in column] for column in H.T)
    rows = [[f, *each] for f, each in zip(freq, texts, strict=True)]
    read = ar.read_excel(workbook(tmp_path / "b.xlsx", ["Frequency [Hz]", "a", "b"], *rows))
    np.testing.assert_allclose(read.values, H)


@pytest.mark.parametrize("begun", [datetime.time(12, 30, 0), datetime.datetime(2026, 5, 4, 23, 59, 50)])
def test_a_clock_and_instants_in_excel_are_the_time(tmp_path, begun):
    rows = [[begun.replace(second=begun.second + i), float(i)] for i in range(5)]
    assert ar.read_excel(workbook(tmp_path / "a.xlsx", ["when", "tip"], *rows)).fs_hz == 1.0
    beside = [[None, *row] for row in rows]  # the table begins in the second column
    made = ar.read_excel(workbook(tmp_path / "b.xlsx", [None, "when", "tip"], *beside))
    assert (made.fs_hz, made.dofs) == (1.0, ("tip",))


def test_parquet_of_pandas(tmp_path):
    pd = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    file = tmp_path / "a.parquet"
    pd.DataFrame({"time [s]": TIME, "a": A, "b": B}).to_parquet(file)
    recorded(ar.read_parquet(file))
    pd.DataFrame({"a": A, "b": B}).to_parquet(file)
    recorded(ar.read_parquet(file, fs_hz=FS))
    index = pd.to_datetime("2026-05-04") + pd.to_timedelta(TIME, unit="s")
    for name in (None, "when"):
        pd.DataFrame({"a": A, "b": B}, index=pd.DatetimeIndex(index, name=name)).to_parquet(file)
        recorded(ar.read_parquet(file))
    pd.DataFrame({"a": A, "b": B}, index=pd.Index(TIME, name="time")).to_parquet(file)
    recorded(ar.read_parquet(file))
    pd.DataFrame({"sent": index, "got": index, "a": A}).to_parquet(file)
    unsuitable("'sent', 'got' all hold instants", ar.read_parquet, file)


def test_units_of_a_field_of_parquet(tmp_path, own_process):
    pa = pytest.importorskip("pyarrow")
    import pyarrow.parquet as pq

    fields = [pa.field("time", pa.float64()), pa.field("a", pa.float64(), metadata={"unit": "g"})]
    pq.write_table(pa.table([TIME, A], schema=pa.schema(fields)), tmp_path / "a.parquet")
    np.testing.assert_allclose(ar.read_parquet(tmp_path / "a.parquet").responses[0], 9.80665 * A)


@pytest.mark.parametrize("kind", ["parquet", "xlsx"])
def test_cut_tables_are_refused(tmp_path, kind):
    if kind == "xlsx":
        file, read = workbook(tmp_path / "a.xlsx", ["time", "a"], [0.0, 1.0], [1.0, 2.0]), ar.read_excel
    else:
        pa = pytest.importorskip("pyarrow")
        import pyarrow.parquet as pq

        file, read = tmp_path / "a.parquet", ar.read_parquet
        pq.write_table(pa.table({"time": TIME, "a": A}), file)
    whole = file.read_bytes()
    for kept in (1, 100, len(whole) // 2, len(whole) - 1):
        file.write_bytes(whole[:kept])
        unsuitable("cannot be read|in which", read, file)


def text(path, head, rows, sign=","):
    path.write_text("\n".join([*head, *(sign.join(map(str, row)) for row in rows)]) + "\n")
    return path


def test_a_column_that_counts_rows_is_left_out(tmp_path):
    rows = [(i, t, a, b) for i, (t, a, b) in enumerate(zip(TIME, A, B, strict=True))]
    recorded(ar.read_csv(text(tmp_path / "a.csv", [",time,a,b"], rows)))
    file = text(tmp_path / "b.csv", ["index,a,b"], [(i, a, b) for i, _, a, b in rows])
    recorded(ar.read_csv(file, fs_hz=FS))
    assert ar.read_csv(file, first="time").fs_hz == 1.0


@pytest.mark.parametrize("form", ["{}", '"{}"', "{}Z", "{}+02:00"])
@pytest.mark.parametrize(("between", "sign", "point"), [("T", ",", "."), (" ", ",", "."), (" ", ";", ",")])
def test_instants_are_the_time(tmp_path, form, between, sign, point):
    begun = np.datetime64("2026-05-04T23:59:59.5", "us")
    rows = []
    for i, values in enumerate(zip(A.tolist(), B.tolist(), strict=True)):
        at = str(begun + np.timedelta64(3906250 * i, "ns").astype("timedelta64[us]")).replace("T", between)
        rows.append((form.format(at), *(repr(value).replace(".", point) for value in values)))
    recorded(ar.read_csv(text(tmp_path / "a.csv", [sign.join(["when", "a", "b"])], rows, sign)))
    if form == "{}" and between == "T":
        recorded(ar.read_csv(text(tmp_path / "b.csv", [], rows, sign)))


@pytest.mark.parametrize("form", ["{}{:+}j", "{}{:+}i", "{} + {}i", "({}{:+}j)"])
def test_complex_columns_of_every_spelling(tmp_path, form):
    values = np.abs(H.real) + 1j * np.abs(H.imag)
    texts = ([form.format(v.real, v.imag) for v in column] for column in values.T.tolist())
    rows = [(f, *column) for f, column in enumerate(texts, 1)]
    read = ar.read_csv(text(tmp_path / "a.csv", ["freq,a,b"], rows))
    np.testing.assert_allclose(read.values, values)
