"""Look-alikes of files of other programs, each read at the first call or with the option its error names."""

import numpy as np
import pytest
from scipy.io import savemat

import antires_rs as ar
from tests.support.measured_data import DATA, needs_hits, needs_shake_table
from tests.support.refusals import refused, unsuitable

RNG = np.random.default_rng(31)
N, FS = 400, 50.0
ROWS = RNG.standard_normal((3, N))
TIME = np.arange(N) / FS
LINES = 200
FREQ = np.arange(1.0, LINES + 1.0)
H = (RNG.standard_normal(LINES) + 1j * RNG.standard_normal(LINES)) * 10.0 ** RNG.uniform(-3, 2, LINES)
LEVEL, DEG = 20 * np.log10(np.abs(H)), np.degrees(np.angle(H))


def lines(path, *text, rows=(), form="{!r}", between=",", end="", encoding="utf-8"):
    body = [between.join(form.format(float(x)) for x in row) + end for row in rows]
    path.write_text("\n".join([*text, *body]) + "\n", encoding=encoding)
    return path


def kyowa(path, unit, quoted=False):
    head = [
        *("ID No.,PCD-400A,,,", "Title,,,,", "Test Date,2026/04/09,15:46:59,,", "MEAS CHs,3,,,"),
        *(f"Sampling Rate(Hz),{FS:g},,,", f"Data Nos/CH,{N},,,", "CH Name,,,,", "CH No.,CH2,CH3,CH5,CH8"),
        *("Range,2000,1000,5000,5", "Calibration Coefficient,2.022,2.45,2.132,1000", "Offset,-1,-2,3,-12"),
        f"Unit,{unit},{unit},{unit},V",
    ]
    if quoted:
        named = [[cell for cell in line.split(",") if cell] for line in head]
        head = [",".join(f'"{cell}"' for cell in row) for row in named]
    scale = {"cm/s2": 100.0, "cm/s²": 100.0, "G": 1 / 9.80665}[unit]
    rows = np.column_stack([TIME, *(scale * ROWS), ROWS[0]])
    return lines(path, *head, rows=rows, encoding="latin-1")


@pytest.mark.parametrize(("unit", "quoted"), [("cm/s2", False), ("cm/s²", True), ("G", True)])
def test_kyowa(tmp_path, unit, quoted):
    file = kyowa(tmp_path / "a.csv", unit, quoted)
    unsuitable("'CH8' in V.*name the hammer by force=", ar.read_csv, file)
    read = ar.read_csv(file, force="CH8")
    assert (read.dofs, read.fs_hz) == (("CH2", "CH3", "CH5"), FS)
    np.testing.assert_allclose(read.responses, ROWS)
    assert ar.read_csv(file, responses=["CH3", "CH5"], force=None).dofs == ("CH3", "CH5")


@needs_hits
@pytest.mark.parametrize("name", ["imp_ham_set1_nomass", "imp_ham_set2_nomass", "imp_ham_set3_no_mass"])
def test_the_hits_of_a_kyowa_logger(name):
    read = ar.read_csv(DATA / "frame3_hits" / f"{name}.CSV", force="CH8")
    assert (read.dofs, read.fs_hz) == (("CH2", "CH3", "CH5", "CH6"), 50.0)
    assert 0.1 < np.abs(read.responses).max() < 10.0  # m/s2


def dot(path, left=slice(None), start=2**32 - 1_000_000, rows=ROWS, tag="Xsens DOT"):
    head = ["sep=,", f"DeviceTag:,{tag}", "FirmwareVersion:,3.0.0", "StartTime: ,2025-03-06_12:19:49_000 PST"]
    head += ["© Movella Technologies B. V. 2005-2025", ""]
    names = [f"{what}_{axis}" for what in ("Euler", "Acc", "Gyr") for axis in "XYZ"]
    clock = (start + 20_000 * np.arange(N)) % 2**32
    table = np.vstack([np.arange(N), clock, ROWS + 40.0, rows, 9 * ROWS])
    table[5:8, 0] = 0.0
    rows = [[f"{x:.0f}" if i < 2 else f"{x:.14f}" for i, x in enumerate(row)] for row in table.T[left]]
    body = [",".join(row) for row in (["PacketCounter", "SampleTimeFine", *names], *rows)]
    path.write_text("\n".join([*head, *body]) + "\n", "utf-8")
    return path


def test_movella_dot(tmp_path):
    file = dot(tmp_path / "a.csv")
    unsuitable("'Gyr_X' in deg/s.*Leave out those of other kinds by responses=", ar.read_csv, file)
    read = ar.read_csv(file, responses="Acc_*")
    assert (read.dofs, read.fs_hz) == (("Acc_X", "Acc_Y", "Acc_Z"), FS)
    np.testing.assert_allclose(read.responses, ROWS[:, 1:], atol=1e-9)  # without the row of zeros
    np.testing.assert_allclose(read.time_s, (2**32 - 1e6) * 1e-6 + TIME[1:])  # past the end of the counter


def test_sensors_that_each_wrote_a_file_are_joined(tmp_path):
    missed = [i for i in range(N) if i not in (100, 101, 250)]
    files = [dot(tmp_path / "base.csv"), dot(tmp_path / "roof.csv", missed, rows=np.cumsum(ROWS, axis=1))]
    unsuitable("such gaps.*Read it with align=True", ar.read_csv, files[1], responses="Acc_X")
    read = [ar.read_csv(file, responses="Acc_X", align=True) for file in files]
    joined = ar.align(read, dofs=["base", "roof"])
    assert (joined.dofs, joined.n_samples, joined.fs_hz) == (("base", "roof"), N - 1, FS)
    assert np.abs(joined.responses[1] - np.cumsum(ROWS[0])[1:]).max() < 4.0  # what is white cannot be made up
    np.testing.assert_allclose(joined.responses[0], ROWS[0, 1:], atol=1e-9)


@needs_shake_table
def test_the_sensors_of_a_shake_table():
    read = ar.read_csv(DATA / "shake_table" / "flexible_sine_1.5_ground_floor.csv", responses="Acc_X")
    assert read.fs_hz == pytest.approx(1e6 / 8333)


@pytest.mark.parametrize("blanks", ["", "\t", " \t "])
def test_pulse(tmp_path, blanks):
    text = f"Header Size: 17|Version: 22.0|Data Type: Complex|X-Axis size: {LINES}|X-Axis type: Linear"
    text += "|X-Axis unit: Hz|X-Axis first value: 1.0000000E+000|X-Axis delta: 1.0000000E+000"
    text += "|AmplitudeUnit: (m/s^2)/N|Title1: Frequency Response H1(Resp 4,Hammer) - Input"
    text += "|Ref_Signal: Hammer|Signal: Resp 4|TagsBegin:|Node\t12|TagsEnd"
    head = text.replace(": ", ":\t").split("|")
    rows = zip(np.arange(LINES) + 1, FREQ, H.real, H.imag, strict=True)
    file = lines(tmp_path / "a.txt", *(each + blanks for each in head), rows=rows, between="\t", end=blanks)
    read = ar.read_csv(file)
    assert read.dofs == ("Resp 4",)
    np.testing.assert_allclose(read.values[0], H, rtol=1e-12)
    np.testing.assert_allclose(read.freq_hz, FREQ)


@pytest.mark.parametrize("head", ["Frequency\tMagnitude\tPhase", "Frequency [Hz]\tMagnitude\tPhase"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_decibels_are_told_by_their_numbers_and_said(tmp_path, head, decimal):
    file = lines(tmp_path / "a.txt", head, rows=zip(FREQ, LEVEL, DEG, strict=True), between="\t")
    file.write_text(file.read_text().replace(".", decimal))
    with pytest.warns(ar.AntiresWarning, match="magnitudes in dB.*degrees.*pairs='db_deg'"):
        read = ar.read_csv(file)
    np.testing.assert_allclose(read.values[0], H, rtol=1e-9)
    above = lines(tmp_path / "b.txt", head, rows=zip(FREQ, np.abs(LEVEL), DEG, strict=True), between="\t")
    unsuitable("whether it is in dB.*Pass pairs=", ar.read_csv, above)


@pytest.mark.parametrize(
    "head", ["Frequency Real Imaginary", "Frequency\tReal\tImaginary", "Frequency (Hz),Real,Imag"]
)
def test_frequency_real_imaginary(tmp_path, head):
    between = next(sign for sign in "\t, " if sign in head.replace(" (Hz)", ""))
    file = lines(tmp_path / "a.txt", head, rows=zip(FREQ, H.real, H.imag, strict=True), between=between)
    np.testing.assert_allclose(ar.read_csv(file).values[0], H, rtol=1e-12)


@pytest.mark.parametrize("shape", [(), (0, 1)])
def test_a_frequency_column_in_a_matrix_is_no_response(tmp_path, shape):
    axis = 0.5 * np.arange(LINES)
    table = np.column_stack([axis, H, *([H[::-1]] * len(shape[1:]))])
    name = "MAT_001_FRF_Channel_8"
    for path, read in (("a.mat", ar.read_mat), ("a.npz", ar.read_npz)):
        file = tmp_path / path
        savemat(file, {name: table}) if path == "a.mat" else np.savez(file, **{name: table})
        for options in ({}, {"df_hz": 0.5}, {"freq_hz": axis}):
            found = read(file, **options)
            np.testing.assert_allclose(found.values, table[:, 1:].T)
            np.testing.assert_allclose(found.freq_hz, axis)
        refused("df_hz: got it for 'MAT_001.*first column holds frequencies", read, file, df_hz=0.25)
    text = tmp_path / "a.txt"
    np.savetxt(text, table)
    refused("df_hz: got it for a file whose first column ascends", ar.read_csv, text, df_hz=0.5)
    np.testing.assert_allclose(ar.read_csv(text).values, table[:, 1:].T)


def lvm(path, head, segment, rows, between, end=""):
    body = [between.join(row) for row in rows]
    path.write_text("\n".join([*(line + end for line in [*head, *segment]), *body]) + "\n")
    return path


@pytest.mark.parametrize(("between", "end"), [("\t", ""), (",", ""), (",", ",,")])
def test_lvm_whose_delta_is_rounded(tmp_path, between, end):
    fs = 5120.0
    head = ["LabVIEW Measurement", between.join(("Separator", "Comma" if between == "," else "Tab"))]
    head += [between.join(x) for x in (("X_Columns", "One"), ("Decimal_Separator", "."))]
    head.append("***End_of_Header***")
    segment = ["Channels" + between + "2" + between, "Delta_X" + between + between.join(["0.000195"] * 2)]
    segment += ["***End_of_Header***", between.join(["X_Value", "tip", "root", "Comment"])]
    rows = [[f"{i / fs:.10f}", f"{a:.6f}", f"{b:.6f}"] for i, (a, b) in enumerate(ROWS[:2].T)]
    read = ar.read_lvm(lvm(tmp_path / "a.lvm", head, segment, rows, between, end), unit="g")
    assert read.fs_hz == pytest.approx(fs, rel=1e-6)
    assert read.dofs == ("tip", "root")
    one = [head[0], between.join(["X_Columns", "One"]), head[1], between.join(["Delta_X", "0.000195"])]
    file = lvm(tmp_path / "b.lvm", one, ["***End_of_Header***", segment[-1]], rows, between, end)
    assert ar.read_lvm(file, unit="g").fs_hz == pytest.approx(fs, rel=1e-6)
    wrong = lvm(tmp_path / "c.lvm", head, [s.replace("0.000195", "0.000295") for s in segment], rows, between)
    unsuitable("one rate", ar.read_lvm, wrong, unit="g")


def test_lvm_without_a_header(tmp_path):
    times = ["0.000000E+0", "1.000000E-4", *(f"{i * 1e-4:.6f}" for i in range(2, N))]
    rows = [[t, f"{a:.6f}", f"{b:.6f}"] for t, a, b in zip(times, ROWS[0], ROWS[1], strict=True)]
    rows[0].append("first run")
    file = lvm(tmp_path / "a.lvm", [], [], rows, "\t")
    read = ar.read_lvm(file, unit="g")
    assert (read.fs_hz, read.n_channels) == (1e4, 2)
    np.testing.assert_allclose(read.responses, 9.80665 * ROWS[:2], atol=1e-5)


def test_text_without_a_header_over_whole_hertz(tmp_path):
    file = lines(tmp_path / "a.txt", rows=zip(np.arange(LINES), H.real, H.imag, strict=True), between=" ")
    unsuitable("counts the rows.*frequency in Hz, pass pairs='real_imag'", ar.read_csv, file)
    read = ar.read_csv(file, pairs="real_imag")
    np.testing.assert_allclose(read.values[0], H)
    np.testing.assert_allclose(read.freq_hz, np.arange(LINES))


def test_a_folder_of_sensors_names_what_joins_them(tmp_path):
    for name, fs in (("s1", 50.0), ("s2", 40.0)):
        lines(tmp_path / f"{name}.csv", "time [s],acc [g]", rows=zip(np.arange(N) / fs, ROWS[0], strict=True))
    unsuitable("a record over time.*join them by align", ar.read_frf_files, tmp_path)
    with pytest.warns(ar.AntiresWarning, match="begins at zero"):
        joined = ar.align([ar.read_csv(tmp_path / f"{n}.csv") for n in ("s1", "s2")], dofs=[1, 2])
    assert joined.fs_hz == 40.0
