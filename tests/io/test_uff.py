"""Universal files of ours and of pyuff: names, units, roles, kinds; wrong_files.txt has what is refused."""

import re

import numpy as np
import pytest

import antires_rs as ar
from reference.io_signals import differences, recording, response
from tests.support.refusals import unsuitable
from tests.support.uff_files import FORCE, LINES, NOISE, dataset, pyuff, written

# pyuff leaves files open that it writes in binary form.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


def frf(values=LINES[0], **more):
    return dataset(values, **{"kind": 4, "reference": (1, 3), "step": 0.5, **more})


@pytest.mark.parametrize("binary", [0, 1])
def test_a_record_of_another_program(tmp_path, binary):
    path = written(
        tmp_path / "a.uff",
        dataset(NOISE[0], node=12, binary=binary),
        dataset(NOISE[1], node=3, direction=-1, unit="g", binary=binary),
        dataset(NOISE[2], node=1, unit="N", data_type=FORCE, binary=binary),
    )
    rec = ar.read_uff(path)
    assert (rec.dofs, rec.fs_hz) == (("12+Z", "3-X"), 512.0)  # 1/512 s is written as 1.95313E-03
    limit = 1e-15 if binary else 1e-11
    np.testing.assert_allclose(rec.responses, [NOISE[0], 9.80665 * NOISE[1]], rtol=limit)
    np.testing.assert_allclose(rec.force, NOISE[2], rtol=limit)
    assert [line.split(",")[0].split()[1] for line in ar.io.list_uff(path)] == ["12+Z", "3-X", "1+Z"]


@pytest.mark.parametrize("rate", [1 / 3, 48.0, 100.0, 700.0, 1024.0, 12800.0, 25600.0, 44100.0, 65536.0])
def test_the_rate_behind_six_digits(tmp_path, rate):
    path = written(tmp_path / "a.uff", dataset(NOISE[0], step=1 / rate), frf())
    path.write_bytes(b"    -1\n   151\na header\n    -1\n" + path.read_bytes())
    assert ar.read_uff(path, kind="time").fs_hz == rate
    assert isinstance(ar.read_uff(tmp_path / "a.uff", kind="frf"), ar.FrequencyResponse)
    milliseconds = dataset(NOISE[0], step=0.5) | {"abscissa_axis_units_lab": "ms"}
    assert ar.read_uff(written(tmp_path / "b.uff", milliseconds)).fs_hz == 2000.0


@pytest.mark.parametrize("step", [0.0625, 0.3, 1 / 3, 1.0, 0.1220703125])
@pytest.mark.parametrize(("label", "unit_hz"), [("Hz", 1.0), ("kHz", 1e3), ("RAD/SEC", 0.5 / np.pi)])
def test_the_frequencies_behind_six_digits(tmp_path, step, label, unit_hz):
    """0.1220703125 Hz is 1/8.192, which the six digits of 0.12207 still tell."""
    sets = frf(step=step / unit_hz) | {"abscissa_axis_units_lab": label}
    found = ar.read_uff(written(tmp_path / "a.uff", sets)).freq_hz
    np.testing.assert_allclose(found, np.arange(100) * step, rtol=1e-12)
    uneven = frf(even=0, binary=0, x=np.arange(100) ** 1.5 * step / unit_hz)
    found = ar.read_uff(written(tmp_path / "b.uff", uneven | {"abscissa_axis_units_lab": label})).freq_hz
    np.testing.assert_allclose(found, step * np.arange(100) ** 1.5, rtol=1e-5)


def test_names_become_dofs_by_a_mapping(tmp_path):
    places = zip(NOISE, (12, 3, 3), (3, -1, 4), strict=False)
    path = written(tmp_path / "a.uff", *(dataset(row, node=n, direction=d) for row, n, d in places))
    rec = ar.read_uff(path, dofs={(12, "+Z"): 4, (3, "X"): 0, "3+RX": None})
    assert rec.dofs == (4, 0)
    np.testing.assert_array_equal(rec.responses[1], -NOISE[1])  # recorded against the axis
    assert ar.read_uff(path, dofs={(12, 3): 4, (3, "-X"): 0, (3, 4): 1}).dofs == (4, 0, 1)
    assert ar.read_uff(path, dofs=lambda node, way: f"{way}{node}").dofs == ("+Z12", "-X3", "+RX3")


def test_dofs_of_ours_are_renamed_by_their_names(tmp_path):
    """Also where such a name reads as a node and a direction, which is not the point in the file."""
    path = ar.write_uff(tmp_path / "a.uff", recording(dofs=("node 2 u", "12+Z")))
    assert ar.read_uff(path, dofs={"node 2 u": 7, "12+Z": 3}).dofs == (7, 3)
    assert ar.read_uff(path, dofs={"node 2 u": None, (12, "+Z"): 3}).dofs == (3,)
    with pytest.raises(ar.InvalidInputError, match=r"no dof for 12\+Z"):
        ar.read_uff(path, dofs={"node 2 u": 7})


def test_names_are_written_by_a_mapping(tmp_path):
    made = recording(dofs=(0, 1), force=True)
    path = ar.write_uff(tmp_path / "a.uff", made, dofs={0: (12, "+Z"), 1: "7-RX"}, excitation=0)
    sets = pyuff.UFF(str(path)).read_sets()
    assert [(s["rsp_node"], s["rsp_dir"]) for s in sets] == [(12, 3), (7, -4), (12, 3)]
    assert [s["ordinate_spec_data_type"] for s in sets] == [12, 12, 13]
    assert ar.read_uff(path).dofs == (0, 1)
    assert ar.read_uff(path, dofs=lambda node, way: (node, way)).dofs == ((12, "+Z"), (7, "-RX"))


def test_forces_are_told_apart(tmp_path):
    first = dataset(NOISE[1], node=8, unit="kN", data_type=0)
    second = dataset(NOISE[2], node=9, unit="NONE", data_type=FORCE)
    path = written(tmp_path / "a.uff", dataset(NOISE[0]), first, second)
    assert ar.read_uff(path, force=None).force is None
    np.testing.assert_allclose(ar.read_uff(path, force="8+Z").force, 1e3 * NOISE[1], rtol=1e-15)
    np.testing.assert_array_equal(ar.read_uff(path, force=(9, "Z")).force, NOISE[2])


def test_frfs_of_several_references(tmp_path):
    sets = [frf(LINES[i], node=i + 1, reference=(k, 3)) for k in (1, 2) for i in range(2)]
    sets += [frf(np.full(100, 0.9), kind=6, node=i + 1, reference=(2, 3)) for i in range(2)]
    path = written(tmp_path / "a.uff", *sets)
    found = ar.read_uff(path, reference="2+Z")
    assert (found.kind, found.dofs, found.coherence.min()) == ("frf", ("1+Z", "2+Z"), 0.9)
    assert ar.read_uff(path, reference=(1, "Z")).coherence is None
    assert ar.read_uff(written(tmp_path / "b.uff", *sets[:4]), roving="1+Z").dofs == ("1+Z", "2+Z")


def test_transmissibilities_get_the_row_of_their_reference(tmp_path):
    made = response(kind="transmissibility", dofs=("1+Z", "2+Z", "3+Z"), coherence=False, averages=None)
    data = ar.write_uff(tmp_path / "a.uff", made).read_bytes()
    third = len(data) // 3  # The same without our marks, and without the reference's own set.
    path = tmp_path / "b.uff"
    path.write_bytes((data[:third] + data[2 * third :]).replace(b"antires_rs uff", b"another program"))
    found = ar.read_uff(path)
    assert (found.reference, found.dofs) == ("2+Z", ("1+Z", "3+Z", "2+Z"))
    np.testing.assert_array_equal(found.values[:2], made.values[[0, 2]])
    turned = ar.read_uff(path, dofs={"1-Z": 0, "2-Z": 1, "3+Z": 2})
    np.testing.assert_array_equal(turned.values[:2], [made.values[0], -made.values[2]])


@pytest.mark.parametrize(
    ("unit", "kind", "per", "factor"),
    [("N", "frf", "NONE", 1.0), ("m/s^2", "transmissibility", "NONE", 1.0), ("kN", "frf", "kN", 1e-3)],
)
def test_spectra_become_quotients(tmp_path, unit, kind, per, factor):
    power = np.linspace(1.0, 2.0, 100)
    crosses = (frf(LINES[i] * power, kind=3, node=i + 1, reference=(5, 3), per=per) for i in range(2))
    auto = frf(power, kind=2, node=5, reference=(5, 3), unit=unit, data_type=0)
    found = ar.read_uff(written(tmp_path / "a.uff", auto, *crosses))
    assert found.kind == kind
    np.testing.assert_allclose(found.values[:2], factor * LINES[:2], rtol=1e-14)


def test_exact_numbers_of_ours_count_only_beside_their_header(tmp_path):
    """Someone who changes the step in the header, and not our line, is believed."""
    path = ar.write_uff(tmp_path / "a.uff", recording(), binary=False)
    path.write_bytes(path.read_bytes().replace(f"{1 / 512:.5e}".encode(), b"3.90625e-03"))
    assert ar.read_uff(path).fs_hz == 256.0


@pytest.mark.parametrize("binary", [True, False])
def test_points_are_counted_against_the_header(tmp_path, binary):
    path = ar.write_uff(tmp_path / "a.uff", recording(), binary=binary)
    data = path.read_bytes()
    path.write_bytes(data.replace(b"       257         1", b"       300         1", 1))
    unsuitable("dataset 1 .58. is damaged: it has 257 points, not", ar.read_uff, path)
    # A line of text, or a few bytes, out of the middle of the second set.
    middle = data.index(b"set 2 of 4") + 1500
    line = data[middle:].index(b"\n") + 1 if not binary else 0
    path.write_bytes(data[: middle + line] + data[middle + line + (16 if binary else 81) :])
    unsuitable("dataset 2 .58. is damaged", ar.read_uff, path)
    with pytest.warns(ar.AntiresWarning, match="dataset 2 .58. is damaged.*3 of 4 functions") as told:
        rec = ar.read_uff(path, partial=True)
    assert [w.filename for w in told] == [__file__]  # the user's line, not one of ours
    assert rec.dofs == (0, "12+Z")
    np.testing.assert_allclose(rec.responses, recording().responses[[0, 2]], rtol=5e-12)


def test_data_that_look_like_a_marker(tmp_path):
    """Eight bytes that read as a line '    -1' inside binary values do not end a set."""
    rows = np.array(NOISE[:1])
    rows[0, 100] = np.frombuffer(b"\n    -1\n", dtype=np.float64)[0]
    path = ar.write_uff(tmp_path / "a.uff", ar.Recording(rows, 100.0))
    np.testing.assert_array_equal(ar.read_uff(path).responses, rows)


@pytest.mark.parametrize(
    ("response_way", "reference"), [(3, (0, 0)), (3, (1, -3)), (-3, (1, 3)), (-3, (1, -3))]
)
def test_coherences_of_other_points_are_named(tmp_path, response_way, reference):
    frfs = [frf(LINES[i], node=i + 1) for i in range(2)]
    way = {"direction": response_way, "reference": reference}
    beside = [frf(np.full(100, 0.9), kind=6, node=i + 1, **way) for i in range(2)]
    said = r"other points than its functions, 1[+-]Z / .*, 2[+-]Z / .*; .* Wanted .* the reference 1\+Z"
    with pytest.warns(ar.AntiresWarning, match=said) as told:
        assert ar.read_uff(written(tmp_path / "a.uff", *frfs, *beside)).coherence is None
    assert sum(issubclass(w.category, ar.AntiresWarning) for w in told) == 1


@pytest.mark.parametrize("letter", ["D", "d"])
@pytest.mark.parametrize("made", [recording(), response(even=False)])
def test_exponents_of_fortran(tmp_path, letter, made):
    path = ar.write_uff(tmp_path / "a.uff", made, binary=False)
    expected, text = ar.read_uff(path), path.read_bytes()
    exponent = re.compile(rb"(?<=[0-9])[eE](?=[+-][0-9])")
    lines = text.splitlines(keepends=True)
    path.write_bytes(b"".join(x if b"{" in x else exponent.sub(letter.encode(), x) for x in lines))
    assert path.read_bytes() != text
    assert set(differences(expected, ar.read_uff(path)).values()) == {0.0}


@pytest.mark.parametrize(
    ("unit", "per", "factor"),
    [
        *(("g", "N", 9.80665), ("m/s^2/N", "NONE", 1.0), ("mm/s^2", "kN", 1e-6), ("g/N", "N", 9.80665)),
        ("NONE", "NONE", 1.0),
    ],
)
def test_units_of_frfs(tmp_path, unit, per, factor):
    path = written(tmp_path / "a.uff", frf(unit=unit, per=per))
    np.testing.assert_allclose(ar.read_uff(path).values[0], factor * LINES[0], rtol=1e-15)
    np.testing.assert_allclose(ar.read_uff(path, unit="mm/s2/N").values[0], 1e-3 * LINES[0], rtol=1e-15)


def test_units_of_the_whole_file(tmp_path):
    """Dataset 164 holds for functions without a label: SI times its factors is the file's unit."""
    units = {"type": 164, "units_code": 5, "units_description": "mm (milli-newton)", "temp_mode": 1}
    units |= {"length": 1000.0, "force": 1000.0, "temp": 1.0, "temp_offset": 273.15}
    sets = [dataset(NOISE[0], unit="NONE"), dataset(NOISE[1], node=2, unit="g")]
    path = written(tmp_path / "a.uff", units, *sets, dataset(NOISE[2], unit="NONE", data_type=FORCE))
    rec = ar.read_uff(path)
    np.testing.assert_allclose(rec.responses, [1e-3 * NOISE[0], 9.80665 * NOISE[1]], rtol=1e-15)
    np.testing.assert_allclose(rec.force, 1e-3 * NOISE[2], rtol=1e-15)
    with pytest.warns(ar.AntiresWarning, match="says g, which was not used"):
        np.testing.assert_array_equal(ar.read_uff(path, unit="m/s2").responses, NOISE[:2])
    over_force = frf(unit="NONE") | {"orddenom_spec_data_type": FORCE}
    path = written(tmp_path / "b.uff", units | {"force": 1.0}, over_force)
    np.testing.assert_allclose(ar.read_uff(path).values[0], 1e-3 * LINES[0], rtol=1e-15)
    path = written(tmp_path / "c.uff", units | {"length": 0.0}, dataset(NOISE[0]))
    unsuitable("units .dataset 164. have the factors 0 and 1000", ar.read_uff, path)


#: As measurement programs write them: what pyuff's own files show, with numbers of ours.
SIX = np.array([0.4, -0.06 - 0.055j, 0.026 - 0.00023j, -0.3 + 0.317j, -1.8 + 1.55j, 3.75 + 2.93j])


def lines_of(kind, form, body, *, even=1, step=0.195313, unit="NONE", axis="Hz", over=18, points=6):
    """Lines of a dataset 58; ``form`` is the ordinate type, ``body`` the lines of numbers."""
    said = "    -1|    58|a test|NONE|23-Mar-17 19:02:23|Record 1 of Dataset no 58|H1 : #  2 / #  1"
    return [
        *said.split("|"),
        f"{kind:5d}         0    0         0 NONE               0   0 NONE               0   0",
        f"{form:10d}{points:10d}{even:10d} {0.0:.5e}  {step:.5e}  {0.0:.5e} ",
        f"{over:10d}    0    0    0 NONE                 {axis:<20}",
        f"{1:10d}    0    0    0 Frequency Function   {unit:<20}",
        "         0    0    0    0 NONE                 NONE                ",
        "         0    0    0    0 NONE                 NONE                ",
        *body,
        "    -1",
    ]


def rows_of(values, form):
    rows = np.asarray(values, dtype=complex).view(float).reshape(-1, 6)
    return ["".join(form.format(v) for v in row) for row in rows]


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_signs_at_the_beginning_of_fields_and_units_beyond_ascii(tmp_path, encoding):
    lines = lines_of(4, 5, rows_of(SIX, "{: .5e} "), unit="(1/N)*(m/s²)")
    (tmp_path / "a.uff").write_bytes("\n".join([*lines, ""]).encode(encoding))
    read = ar.read_uff(tmp_path / "a.uff")
    np.testing.assert_allclose(read.values[0], SIX, rtol=1e-5)
    assert read.freq_hz[1] == 0.1953125  # 100/512, of which six digits are written
    broken = [*lines[:-2], lines[-2][:-14], lines[-1]]
    (tmp_path / "b.uff").write_bytes("\n".join([*broken, ""]).encode(encoding))
    unsuitable("points, not the 6", ar.read_uff, tmp_path / "b.uff")


def test_power_spectra_alone_have_no_phase(tmp_path):
    row = " {:12.6E} {:12.6E} {:12.6E} {:12.6E} {:12.6E} {:12.6E}".format
    body = [row(i, 1e-6 * (i + 1), 0.0, i + 1, 2e-6, 0.0) for i in (0, 2, 4)]
    lines = lines_of(9, 5, body, even=0, step=0.0, unit="g²/Hz")
    (tmp_path / "a.uff").write_bytes("\n".join([*lines, ""]).encode())
    unsuitable(r"1 auto spectra, the first of 0S.*lost the phase", ar.read_uff, tmp_path / "a.uff")


def test_a_last_line_that_is_filled_with_blanks(tmp_path):
    values = [-3.81956, -3.56616, -2.98987, 1.0, 2.0, -3.0, -5.84096]
    body = ["".join(f" {v:12.5E}"[:13] for v in values[:6]), "".join(f" {v:12.5E}"[:13] for v in values[6:])]
    lines = lines_of(1, 2, body, step=5e-5, unit="m/s²", axis="s", over=17, points=7)
    (tmp_path / "a.uff").write_bytes("\n".join([*(line.ljust(80) for line in lines), ""]).encode())
    read = ar.read_uff(tmp_path / "a.uff")
    assert read.fs_hz == 20000.0
    np.testing.assert_allclose(read.responses[0], values)


@pytest.mark.parametrize("width", [13, 20])
def test_fields_to_the_left(tmp_path, width):
    """Blanks behind the last are cut off; a number that is lost is missed all the same."""
    body = [row.rstrip() for row in rows_of(SIX, f"{{:<{width}.5e}}")]
    if width == 20:
        body = ["".join(f"{v:<20.11e}" for v in row).rstrip() for row in SIX.view(float).reshape(-1, 4)]
    lines = lines_of(4, 5 if width == 13 else 6, body)
    (tmp_path / "a.uff").write_text("\n".join([*lines, ""]))
    np.testing.assert_allclose(ar.read_uff(tmp_path / "a.uff").values[0], SIX, rtol=1e-5)
    lines[-2] = lines[-2][: lines[-2].rindex(" ")].rstrip()
    (tmp_path / "a.uff").write_text("\n".join([*lines, ""]))
    unsuitable("points, not the 6", ar.read_uff, tmp_path / "a.uff")
