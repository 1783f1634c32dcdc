"""Files made by other programs' libraries: the table of docs/files.md, row by row."""

import csv

import numpy as np
import pytest
from scipy.io import savemat

import antires_rs as ar
from tests.support.refusals import refused, unsuitable

LINES, DF = 64, 0.5
FREQ = DF * np.arange(LINES)
RNG = np.random.default_rng(12)
H = RNG.standard_normal((3, LINES)) + 1j * RNG.standard_normal((3, LINES))
DOFS = (0, 4, "tip")


def same(read, tolerance=1e-12):
    assert read.kind == "frf"
    assert read.dofs == DOFS
    np.testing.assert_allclose(read.freq_hz, FREQ, rtol=0, atol=1e-9)
    np.testing.assert_allclose(read.values, H, rtol=0, atol=tolerance * np.abs(H).max())


def hdf5(path, **arrays):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file[name] = values


WITHOUT_AXIS = {
    "savez.npz": (lambda path: np.savez(path, data=H.T), ar.read_npz, 1e-15),
    "save.npy": (lambda path: np.save(path, H.T), ar.read_npz, 1e-15),
    "version 4.mat": (lambda path: savemat(path, {"MEscope1": H.T}, format="4"), ar.read_mat, 1e-15),
    "version 5.MAT": (lambda path: savemat(path, {"H": H.astype(np.complex64)}), ar.read_mat, 1e-6),
    "h5py.h5": (lambda path: hdf5(path, **{"run1/frf": H}), ar.read_hdf5, 1e-15),
    "savetxt.txt": (lambda path: np.savetxt(path, H.T, delimiter=";"), ar.read_csv, 1e-12),
    "blanks.txt": (lambda path: np.savetxt(path, H.T), ar.read_csv, 1e-12),
}


@pytest.mark.parametrize("name", WITHOUT_AXIS)
def test_responses_without_an_axis_get_it_by_an_option(tmp_path, name):
    save, read, tolerance = WITHOUT_AXIS[name]
    save(tmp_path / name)
    for options in ({"df_hz": DF}, {"freq_hz": FREQ}):
        same(read(tmp_path / name, dofs=DOFS, **options), tolerance)


def test_the_axis_that_is_given_names_the_axis_of_a_matrix(tmp_path):
    np.save(tmp_path / "a.npy", H[:, :2].T)  # more channels than lines
    assert ar.read_npz(tmp_path / "a.npy", freq_hz=[1.0, 2.0]).values.shape == (3, 2)
    file = columns(["Frequency", "re(a)", "im(a)"], (FREQ, *REAL_IMAG), tmp_path / "b.csv")
    refused("freq_hz: got it for a file with the column", ar.read_csv, file, freq_hz=FREQ)


def columns(header, parts, path, *, delimiter=",", decimal="."):
    with path.open("w", newline="", encoding="utf-8") as opened:
        out = csv.writer(opened, delimiter=delimiter)
        if header:
            out.writerow(header)
        for row in zip(*parts, strict=True):
            out.writerow([repr(float(x)).replace(".", decimal) for x in row])
    return path


REAL_IMAG = (H[0].real, H[0].imag)
LEVEL = 20 * np.log10(np.abs(H[0]))
SIZE, RAD, DEG = np.abs(H[0]), np.angle(H[0]), np.degrees(np.angle(H[0]))


@pytest.mark.parametrize(
    ("header", "parts", "dof"),
    [
        (["Frequency", "Real", "Imaginary"], REAL_IMAG, 0),
        (["Frequency (Hz)", "Real (m/s2/N)", "Imag (m/s2/N)"], REAL_IMAG, 0),
        (["Freq [Hz]", "Real part tip", "Imag part tip"], REAL_IMAG, "tip"),
        (["f", "tip_re", "tip_im"], REAL_IMAG, "tip"),
        (["freq [Hz]", "re(tip)", "im(tip)"], REAL_IMAG, "tip"),
        (["f", "tip real", "tip imag"], REAL_IMAG, "tip"),
        (["Frequency", "Magnitude [m/s2/N]", "Phase [deg]"], (SIZE, DEG), 0),
        (["Frequency", "Magnitude (dB)", "Phase (deg)"], (LEVEL, DEG), 0),
        (["Frequency", "Mag dB", "Phase rad"], (LEVEL, RAD), 0),
        (["Frequency", "Amplitude [lin]", "Angle [rad]"], (SIZE, RAD), 0),
    ],
)
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_columns_whose_header_tells(tmp_path, header, parts, dof, delimiter):
    decimal = "," if delimiter == ";" else "."
    file = columns(header, (FREQ, *parts), tmp_path / "a.csv", delimiter=delimiter, decimal=decimal)
    read = ar.read_csv(file)
    assert read.dofs == (dof,)
    np.testing.assert_allclose(read.values[0], H[0], rtol=1e-12)


@pytest.mark.parametrize("header", [None, ["x", "a", "b"], ["Frequency", "Magnitude", "Phase"]])
@pytest.mark.parametrize(
    ("pairs", "parts"),
    [
        *(("real_imag", REAL_IMAG), ("magnitude_deg", (SIZE, DEG)), ("magnitude_rad", (SIZE, RAD))),
        *(("db_deg", (LEVEL, DEG)), ("db_rad", (LEVEL, RAD))),
    ],
)
def test_what_an_option_says_of_columns(tmp_path, header, pairs, parts):
    file = columns(header, (FREQ, *parts), tmp_path / "a.csv")
    np.testing.assert_allclose(ar.read_csv(file, pairs=pairs).values[0], H[0], rtol=1e-12)
    if header and "Phase" in header and pairs == "db_deg":  # no size is negative, no phase in rad so large
        with pytest.warns(ar.AntiresWarning, match="read with magnitudes in dB.*phases in degrees.*db_deg"):
            np.testing.assert_allclose(ar.read_csv(file).values[0], H[0], rtol=1e-12)
    else:
        with pytest.raises(ar.AntiresError):
            ar.read_csv(file)
    if header is None:
        two = columns(None, parts, tmp_path / "b.csv")
        np.testing.assert_allclose(ar.read_csv(two, pairs=pairs, df_hz=DF).values[0], H[0], rtol=1e-12)


def folder_of(path, names, lines=None):
    for i, name in enumerate(names):
        n = LINES if lines is None else lines[i]
        columns(["Frequency [Hz]", "Real", "Imag"], (FREQ[:n], H[i, :n].real, H[i, :n].imag), path / name)
    return path


@pytest.mark.parametrize(
    ("names", "dofs"),
    [
        (["FRF_2.csv", "FRF_10.csv", "FRF_11.csv"], (2, 10, 11)),
        (["H_1_1.csv", "H_2_1.csv", "H_12_1.csv"], (1, 2, 12)),
        (["acc_tip.csv", "acc_top.csv", "acc_x2.csv"], ("tip", "top", "x2")),
    ],
)
def test_a_folder_of_files_is_one_response(tmp_path, names, dofs):
    read = ar.read_frf_files(folder_of(tmp_path, names))
    assert read.dofs == dofs
    np.testing.assert_allclose(read.values, H, rtol=1e-12)
    (tmp_path / "notes.log").write_text("nothing")
    turned = ar.read_frf_files([tmp_path / name for name in names[::-1]], dofs=DOFS)
    assert turned.dofs == DOFS
    np.testing.assert_allclose(turned.values, H[::-1], rtol=1e-12)
    some = ar.read_frf_files(tmp_path, dofs=lambda stem: stem if f"{stem}.csv" == names[0] else None)
    assert some.dofs == (names[0][:-4],)
    ratios = [tmp_path / f"T_{i}.npy" for i in range(3)]
    for path, h in zip(ratios, H, strict=True):
        np.save(path, h / H[1])
    ratio = ar.read_frf_files(ratios, df_hz=DF, kind="transmissibility", reference=1)
    assert (ratio.kind, ratio.reference, ratio.dofs) == ("transmissibility", 1, (0, 1, 2))


@pytest.mark.parametrize("odd", range(3))
def test_the_file_with_another_axis_is_named(tmp_path, odd):
    lines = [LINES - 1 if i == odd else LINES for i in range(3)]
    names = ["p1.csv", "p2.csv", "p3.csv"]
    with pytest.raises(ar.UnsuitableDataError, match="64 lines 0-31.5 Hz, as 2 of 3 files") as caught:
        ar.read_frf_files(folder_of(tmp_path, names, lines))
    assert names[odd] in str(caught.value.got)


def test_what_no_folder_of_frfs_is(tmp_path):
    folder_of(tmp_path, ["p1.csv", "p2.csv"])
    np.save(tmp_path / "p3.npy", H[0])
    refused(r"several formats \(2 csv, 1 npz\)", ar.read_frf_files, tmp_path)
    assert ar.read_frf_files(tmp_path, pattern="*.csv").dofs == (1, 2)
    np.savez(tmp_path / "p4.npz", frf=H)
    unsuitable("with 3 responses", ar.read_frf_files, [tmp_path / "p4.npz"], df_hz=DF)
    refused("none of which fits", ar.read_frf_files, tmp_path, pattern="*.uff")
    refused("files: got", ar.read_frf_files, [])


def uff_of_runs(path, runs, what=4):
    """As pyuff writes dataset 58 in text, each point once a run."""
    pytest.importorskip("pyuff")
    from tests.support.uff_files import dataset, written

    for run in range(1, runs + 1):
        for node in (1, 2):
            values = run * (H[node] if what == 4 else H[node].real)
            options = {"reference": (1, 3), "per": "N", "step": DF} if what == 4 else {}
            written(path, dataset(values, kind=what, node=node, binary=0, **options))
    return path


@pytest.mark.parametrize("what", [4, 1])
def test_pyuff_with_points_recorded_several_times(tmp_path, what):
    file = uff_of_runs(tmp_path / "runs.uff", 3, what)
    read = [ar.read_uff(file, run=run) for run in (1, 2, 3)]
    values = [r.values if what == 4 else r.responses for r in read]
    for i in (1, 2):
        np.testing.assert_allclose(values[i], (i + 1) * values[0], rtol=1e-4)
    assert [line[-5:] for line in ar.io.list_uff(file)] == [f"run {run}" for run in (1, 1, 2, 2, 3, 3)]
    for run in (0, 4, True, 1.5):
        refused("run: got", ar.read_uff, file, run=run)


def test_points_that_a_run_lacks_are_named(tmp_path):
    file = uff_of_runs(tmp_path / "a.uff", 2)
    text = file.read_text().split("    -1\n")
    file.write_text("    -1\n".join(text[:-2]))  # the second run of the second point
    with pytest.warns(ar.AntiresWarning, match=r"no run 2 of 2\+Z"):
        assert ar.read_uff(file, run=2).dofs == ("1+Z",)
    assert ar.read_uff(file, run=1).dofs == ("1+Z", "2+Z")
