"""Universal files: names, units, roles and kinds, in files of ours and of pyuff."""

import re

import numpy as np
import pytest

import antires_rs as ar
from reference.io_signals import differences, recording, response
from tests.support.uff_files import FORCE, LINES, NOISE, dataset, pyuff, written

# pyuff leaves files open that it writes in binary form.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.mark.parametrize("binary", [0, 1])
def test_a_record_of_another_program(tmp_path, binary):
    path = written(
        tmp_path / "a.uff",
        dataset(NOISE[0], node=12, binary=binary),
        dataset(NOISE[1], node=3, direction=-1, unit="g", binary=binary),
        dataset(NOISE[2], node=1, unit="N", data_type=FORCE, binary=binary),
    )
    rec = ar.read_uff(path)
    assert rec.dofs == ("12+Z", "3-X")
    # 1/512 s is written as 1.95313E-03.
    assert rec.fs_hz == 512.0
    limit = 0.0 if binary else 1e-11
    np.testing.assert_allclose(rec.responses[0], NOISE[0], rtol=limit)
    np.testing.assert_allclose(rec.responses[1], 9.80665 * NOISE[1], rtol=max(limit, 1e-15))
    np.testing.assert_allclose(rec.force, NOISE[2], rtol=limit)
    assert [line.split(",")[0].split() for line in ar.io.list_uff(path)] == [
        ["time", "12+Z"],
        ["time", "3-X"],
        ["time", "1+Z"],
    ]


@pytest.mark.parametrize(
    "rate", [1 / 3, 48.0, 100.0, 700.0, 1024.0, 2048.0, 12800.0, 25600.0, 44100.0, 51200.0, 65536.0]
)
def test_the_rate_behind_six_digits(tmp_path, rate):
    assert ar.read_uff(written(tmp_path / "a.uff", dataset(NOISE[0], step=1 / rate))).fs_hz == rate


@pytest.mark.parametrize("step", [0.0625, 0.3, 1 / 3, 1.0, 0.1220703125])
def test_the_frequencies_behind_six_digits(tmp_path, step):
    path = written(tmp_path / "a.uff", dataset(LINES[0], kind=4, reference=(1, 3), step=step, per="N"))
    # 0.1220703125 Hz is 1/8.192, which the six digits of 0.12207 still tell.
    np.testing.assert_allclose(ar.read_uff(path).freq_hz, np.arange(100) * step, rtol=1e-12)


def test_names_become_dofs_by_a_mapping(tmp_path):
    path = written(
        tmp_path / "a.uff",
        dataset(NOISE[0], node=12),
        dataset(NOISE[1], node=3, direction=-1),
        dataset(NOISE[2], node=3, direction=4),
    )
    rec = ar.read_uff(path, dofs={(12, "+Z"): 4, (3, "X"): 0, "3+RX": None})
    assert rec.dofs == (4, 0)
    np.testing.assert_array_equal(rec.responses[1], -NOISE[1])  # recorded against the axis
    assert ar.read_uff(path, dofs={(12, 3): 4, (3, "-X"): 0, (3, 4): 1}).dofs == (4, 0, 1)
    assert ar.read_uff(path, dofs=lambda node, way: f"{way}{node}").dofs == ("+Z12", "-X3", "+RX3")
    with pytest.raises(ar.InvalidInputError, match=r"^dofs: got no dof for 3-X; wanted a dof for every"):
        ar.read_uff(path, dofs={(12, "+Z"): 4})
    with pytest.raises(ar.InvalidInputError, match="^dofs: got '12Q'; wanted a node and a direction"):
        ar.read_uff(path, dofs={"12Q": 4})
    with pytest.raises(ar.InvalidInputError, match="^dofs: got list; wanted a mapping"):
        ar.read_uff(path, dofs=[1, 2, 3])


def test_names_are_written_by_a_mapping(tmp_path):
    made = recording(dofs=(0, 1), force=True)
    path = ar.write_uff(tmp_path / "a.uff", made, dofs={0: (12, "+Z"), 1: "7-RX"}, excitation=0)
    sets = pyuff.UFF(str(path)).read_sets()
    assert [(s["rsp_node"], s["rsp_dir"]) for s in sets] == [(12, 3), (7, -4), (12, 3)]
    assert [s["ordinate_spec_data_type"] for s in sets] == [12, 12, 13]
    assert ar.read_uff(path).dofs == (0, 1)
    assert ar.read_uff(path, dofs=lambda node, way: (node, way)).dofs == ((12, "+Z"), (7, "-RX"))
    with pytest.raises(ar.InvalidInputError, match="^dofs: got 1S for two dofs"):
        ar.write_uff(path, made, dofs={0: (1, 0), 1: (1, 0)})
    with pytest.raises(ar.InvalidInputError, match="^dofs: got no node and direction for 1"):
        ar.write_uff(path, made, dofs={0: (1, 0)})
    with pytest.raises(ar.InvalidInputError, match="^unit: got 'g'; wanted an SI unit"):
        ar.write_uff(path, made, unit="g")
    with pytest.raises(ar.InvalidInputError, match="^dofs: got 'x{100}'; wanted labels of at most 70"):
        ar.write_uff(path, recording(dofs=("x" * 100,)))


def test_pyuff_reads_what_we_write(tmp_path):
    made = response(kind="transmissibility")
    sets = pyuff.UFF(str(ar.write_uff(tmp_path / "a.uff", made))).read_sets()
    assert [s["func_type"] for s in sets] == [5, 5, 5, 6, 6, 6]
    for s, row in zip(sets, [*made.values, *made.coherence], strict=True):
        np.testing.assert_array_equal(s["data"], row)
        assert s["num_pts"] == made.n_freq
        assert s["n_bytes"] == row.nbytes


def test_forces_are_told_apart(tmp_path):
    path = written(
        tmp_path / "a.uff",
        dataset(NOISE[0]),
        dataset(NOISE[1], node=8, unit="kN", data_type=0),
        dataset(NOISE[2], node=9, unit="NONE", data_type=FORCE),
    )
    with pytest.raises(ar.InvalidInputError, match="^force: got 'auto' for a file with 2 force channels"):
        ar.read_uff(path)
    assert ar.read_uff(path, force=None).force is None
    np.testing.assert_allclose(ar.read_uff(path, force="8+Z").force, 1e3 * NOISE[1], rtol=1e-15)
    np.testing.assert_array_equal(ar.read_uff(path, force=(9, "Z")).force, NOISE[2])
    with pytest.raises(ar.InvalidInputError, match="^force: got '77Q'"):
        ar.read_uff(path, force="77Q")


def test_a_sensor_that_stayed_is_offered_for_a_hammer_that_roved(tmp_path):
    sets = [dataset(LINES[0], kind=4, node=7, reference=(k, 3), step=0.5) for k in (1, 2)]
    path = written(tmp_path / "a.uff", *sets)
    with pytest.raises(ar.UnsuitableDataError, match=r"If the hammer roved .* pass roving='7\+Z'"):
        ar.read_uff(path)
    assert ar.read_uff(path, roving="7+Z").dofs == ("1+Z", "2+Z")


def test_frfs_of_several_references(tmp_path):
    sets = [
        dataset(LINES[i], kind=4, node=i + 1, reference=(k, 3), step=0.5) for k in (1, 2) for i in range(2)
    ]
    sets += [dataset(np.full(100, 0.9), kind=6, node=i + 1, reference=(2, 3), step=0.5) for i in range(2)]
    path = written(tmp_path / "a.uff", *sets)
    with pytest.raises(ar.UnsuitableDataError, match=r"references 1\+Z, 2\+Z; wanted one. Choose it by "):
        ar.read_uff(path)
    found = ar.read_uff(path, reference="2+Z")
    assert (found.kind, found.dofs) == ("frf", ("1+Z", "2+Z"))
    assert found.coherence.min() == 0.9
    assert ar.read_uff(path, reference=(1, "Z")).coherence is None
    with pytest.raises(ar.UnsuitableDataError, match="wanted reference='9\\+Z'"):
        ar.read_uff(path, reference="9+Z")


def test_transmissibilities_get_the_row_of_their_reference(tmp_path):
    made = response(kind="transmissibility", dofs=("1+Z", "2+Z", "3+Z"), coherence=False, averages=None)
    data = ar.write_uff(tmp_path / "a.uff", made).read_bytes()
    # The same without our marks, and without the reference's own set.
    third = len(data) // 3
    path = tmp_path / "b.uff"
    path.write_bytes((data[:third] + data[2 * third :]).replace(b"antires_rs uff", b"another program"))
    found = ar.read_uff(path)
    assert (found.reference, found.dofs) == ("2+Z", ("1+Z", "3+Z", "2+Z"))
    np.testing.assert_array_equal(found.values[:2], made.values[[0, 2]])
    turned = ar.read_uff(path, dofs={"1-Z": 0, "2-Z": 1, "3+Z": 2})
    np.testing.assert_array_equal(turned.values[:2], [made.values[0], -made.values[2]])


@pytest.mark.parametrize(("unit", "kind"), [("N", "frf"), ("m/s^2", "transmissibility")])
def test_spectra_become_quotients(tmp_path, unit, kind):
    power = np.linspace(1.0, 2.0, 100)
    path = written(
        tmp_path / "a.uff",
        dataset(power, kind=2, node=5, reference=(5, 3), unit=unit, data_type=0),
        *(dataset(LINES[i] * power, kind=3, node=i + 1, reference=(5, 3)) for i in range(2)),
    )
    found = ar.read_uff(path)
    assert found.kind == kind
    np.testing.assert_allclose(found.values[:2], LINES[:2], rtol=1e-14)
    lone = written(tmp_path / "b.uff", dataset(LINES[0], kind=3, node=1, reference=(5, 3)))
    with pytest.raises(ar.UnsuitableDataError, match="0 auto spectra of the reference 5\\+Z"):
        ar.read_uff(lone)


def test_exact_numbers_of_ours_count_only_beside_their_header(tmp_path):
    """Someone who changes the step in the header, and not our line, is believed."""
    path = ar.write_uff(tmp_path / "a.uff", recording(), binary=False)
    step = f"{1 / 512:.5e}".encode()
    path.write_bytes(path.read_bytes().replace(step, b"3.90625e-03"))
    assert ar.read_uff(path).fs_hz == 256.0


def test_kinds_are_chosen_and_named(tmp_path):
    path = written(
        tmp_path / "a.uff",
        dataset(NOISE[0]),
        dataset(LINES[0], kind=4, reference=(1, 3)),
        {
            "type": 151,
            "model_name": "m",
            "description": "",
            "db_app": "",
            "date_db_created": "",
            "time_db_created": "",
            "version_db1": 0,
            "version_db2": 0,
            "file_type": 0,
            "date_db_saved": "",
            "time_db_saved": "",
            "program": "",
            "date_file_written": "",
            "time_file_written": "",
        },
    )
    with pytest.raises(ar.UnsuitableDataError, match="with time, frf; wanted one kind of function. Pass"):
        ar.read_uff(path)
    assert isinstance(ar.read_uff(path, kind="time"), ar.Recording)
    assert isinstance(ar.read_uff(path, kind="frf"), ar.FrequencyResponse)
    with pytest.raises(ar.UnsuitableDataError, match="wanted kind='spectra'"):
        ar.read_uff(path, kind="spectra")
    with pytest.raises(ar.InvalidInputError, match="^kind: got 'modes'"):
        ar.read_uff(path, kind="modes")
    alone = written(tmp_path / "b.uff", dataset(LINES[0], kind=0, reference=(1, 3)))
    with pytest.raises(ar.UnsuitableDataError, match="no function that can be read.*function type 0"):
        ar.read_uff(alone)


def test_uneven_time_is_measured(tmp_path):
    x = np.arange(400) / 100.0
    path = written(tmp_path / "a.uff", dataset(NOISE[0], x=x, even=0))
    assert ar.read_uff(path).fs_hz == 100.0
    x[200:] += 0.05
    gap = written(tmp_path / "b.uff", dataset(NOISE[0], x=x, even=0, binary=0))
    with pytest.raises(ar.UnsuitableDataError, match="1.99 s followed by 2.05 s after steps"):
        ar.read_uff(gap)


@pytest.mark.parametrize("binary", [True, False])
def test_points_are_counted_against_the_header(tmp_path, binary):
    path = ar.write_uff(tmp_path / "a.uff", recording(), binary=binary)
    data = path.read_bytes()
    path.write_bytes(data.replace(b"       257         1", b"       300         1", 1))
    with pytest.raises(ar.UnsuitableDataError, match="dataset 1 .58. is damaged: it has 257 points, not"):
        ar.read_uff(path)
    # A line of text, or a few bytes, out of the middle of the second set.
    middle = data.index(b"set 2 of 4") + 1500
    line = data[middle:].index(b"\n") + 1 if not binary else 0
    path.write_bytes(data[: middle + line] + data[middle + line + (16 if binary else 81) :])
    with pytest.raises(ar.UnsuitableDataError, match="dataset 2 .58. is damaged"):
        ar.read_uff(path)
    with pytest.warns(ar.AntiresWarning, match="dataset 2 .58. is damaged.*3 of 4 functions") as told:
        rec = ar.read_uff(path, partial=True)
    assert [w.filename for w in told] == [__file__]  # the user's line, not one of ours
    assert rec.dofs == (0, "12+Z")
    np.testing.assert_allclose(rec.responses, recording().responses[[0, 2]], rtol=5e-12)


def test_data_that_look_like_a_marker(tmp_path):
    """Eight bytes that read as a line '    -1' inside binary values do not end a set unnoticed."""
    rows = np.array(NOISE[:1])
    rows[0, 100] = np.frombuffer(b"\n    -1\n", dtype=np.float64)[0]
    path = ar.write_uff(tmp_path / "a.uff", ar.Recording(rows, 100.0))
    with pytest.raises(ar.UnsuitableDataError, match="whose dataset 1 has 100 points of the 400"):
        ar.read_uff(path)


def test_what_cannot_be_a_response_is_refused(tmp_path):
    frf = dataset(LINES[0], kind=4, reference=(1, 3), step=0.25, per="N")
    receptance = dataset(LINES[1], kind=4, node=2, reference=(1, 3), step=0.25, unit="mm", per="N")
    path = written(tmp_path / "a.uff", frf, receptance)
    with pytest.raises(ar.UnsuitableDataError, match="several kinds, 1.Z acceleration, 2.Z displacement"):
        ar.read_uff(path)
    assert ar.read_uff(path, dofs={(1, "+Z"): 0, (2, "+Z"): None}).dofs == (0,)
    path = written(tmp_path / "b.uff", dataset(NOISE[0, :100], kind=4, reference=(1, 3), step=0.25, per="N"))
    with pytest.raises(ar.UnsuitableDataError, match="whose frf of 1.Z is real; .* lost the phase"):
        ar.read_uff(path)


@pytest.mark.parametrize("kind", [1, 4])
def test_a_step_of_zero_is_refused(tmp_path, kind):
    path = written(
        tmp_path / "a.uff",
        dataset(LINES[0] if kind == 4 else NOISE[0], kind=kind, step=0.0, binary=0, reference=(1, 3)),
    )
    with pytest.raises(ar.UnsuitableDataError, match="dataset 1 has a step of 0; wanted a positive step"):
        ar.read_uff(path)


@pytest.mark.parametrize(
    ("response_way", "reference"), [(3, (0, 0)), (3, (1, -3)), (-3, (1, 3)), (-3, (1, -3))]
)
def test_coherences_of_other_points_are_named(tmp_path, response_way, reference):
    frfs = [dataset(LINES[i], kind=4, node=i + 1, reference=(1, 3), step=0.5) for i in range(2)]
    beside = [
        dataset(np.full(100, 0.9), kind=6, node=i + 1, direction=response_way, reference=reference, step=0.5)
        for i in range(2)
    ]
    way = "[+]" if response_way > 0 else "-"
    with pytest.warns(
        ar.AntiresWarning,
        match=f"coherences of other points than its functions, 1{way}Z / "
        f".*, 2{way}Z / .*; they are left out. Wanted .* the reference 1[+]Z",
    ) as told:
        assert ar.read_uff(written(tmp_path / "a.uff", *frfs, *beside)).coherence is None
    assert sum(issubclass(w.category, ar.AntiresWarning) for w in told) == 1


@pytest.mark.parametrize("letter", ["D", "d"])
def test_exponents_of_fortran(tmp_path, letter):
    for i, made in enumerate((recording(), response(even=False))):
        path = ar.write_uff(tmp_path / f"{i}.uff", made, binary=False)
        expected, text = ar.read_uff(path), path.read_bytes()
        exponent = re.compile(rb"(?<=[0-9])[eE](?=[+-][0-9])")
        path.write_bytes(
            b"".join(
                line if b"{" in line else exponent.sub(letter.encode(), line)
                for line in text.splitlines(keepends=True)
            )
        )
        assert path.read_bytes() != text
        assert set(differences(expected, ar.read_uff(path)).values()) == {0.0}
    path, whole = tmp_path / "0.uff", ar.read_uff(tmp_path / "0.uff")
    path.write_bytes(path.read_bytes()[:-400])
    with pytest.warns(ar.AntiresWarning, match="is incomplete.*3 of 4 functions are whole"):
        np.testing.assert_array_equal(ar.read_uff(path, partial=True).responses, whole.responses)
