"""MATLAB and universal files of ours have checksums: a changed number is noticed, in values and text."""

import json

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.exceptions import UnsuitableDataError

RECORD = ar.Recording(np.random.default_rng(2).standard_normal((2, 50)), 512.0, dofs=["a", "b"])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (np.float64(RECORD.responses[1, 7]).tobytes(), np.float64(1.25).tobytes(), "responses does not have"),
        (b'"fs_hz": 512.0', b'"fs_hz": 517.0', "text does not have"),
    ],
)
def test_a_changed_number_is_noticed(tmp_path, old, new, said):
    file = ar.write_mat(tmp_path / "a.mat", RECORD)
    whole = file.read_bytes()
    if whole.count(old) != 1:  # texts are stored with two bytes a letter
        old, new = (each.decode().encode("utf-16-le") for each in (old, new))
    assert whole.count(old) == 1
    file.write_bytes(whole.replace(old, new))
    with pytest.raises(UnsuitableDataError, match=said):
        ar.read_mat(file)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"version": 2}, "of version 2.*Update antires_rs"),
        ({"arrays": {"force": ["float64", 50]}}, "without force of its 1 arrays"),
        ({"arrays": {"responses": ["float64", 2, 49]}}, "whose responses has shape"),
        ({"kind": "frf"}, "text does not have its checksum"),
        ({"format": "other"}, "which holds 'other'"),
    ],
)
def test_another_text_is_refused(tmp_path, change, said):
    arrays = dict(np.load(ar.write_npz(tmp_path / "a.npz", RECORD)))
    text = json.dumps(json.loads(bytes(arrays["antires_rs"])) | change)
    np.savez(tmp_path / "a.npz", **arrays | {"antires_rs": np.frombuffer(text.encode(), dtype=np.uint8)})
    with pytest.raises(UnsuitableDataError, match=said):
        ar.read_npz(tmp_path / "a.npz")


@pytest.mark.parametrize("binary", [True, False])
def test_a_damaged_universal_file_is_noticed(tmp_path, binary):
    pytest.importorskip("pyuff")
    file = ar.write_uff(tmp_path / "a.uff", RECORD, binary=binary)
    whole, value = file.read_bytes(), RECORD.responses[1, 7]
    old = np.float64(value).tobytes() if binary else f"{value:.11e}".encode()
    new = old[:4] + bytes([old[4] ^ 1]) + old[5:]
    assert whole.count(old) == 1
    file.write_bytes(whole.replace(old, new))
    with pytest.raises(UnsuitableDataError, match="numbers do not have the checksum"):
        ar.read_uff(file)
    with pytest.warns(ar.AntiresWarning, match="numbers do not have the checksum"):
        assert ar.read_uff(file, partial=True).dofs == ("a",)


@pytest.mark.parametrize("how", ["no checksum", "line ends", "an edited header"])
def test_a_universal_file_that_was_edited_is_believed(tmp_path, how):
    pytest.importorskip("pyuff")
    file = ar.write_uff(tmp_path / "a.uff", RECORD, binary=False)
    whole = file.read_bytes()
    if how == "line ends":
        whole = whole.replace(b"\n", b"\r\n")
    else:
        whole = whole.replace(b'"dof": "b"', b'"dof": "c"')
    if how == "no checksum":
        whole = b"".join(
            b"NONE".ljust(80) + b"\n" if line.startswith(b"antires_rs crc32") else line
            for line in whole.splitlines(keepends=True)
        )
    file.write_bytes(whole)
    made = ar.read_uff(file)
    assert made.dofs == ("a", "b" if how == "line ends" else "c")
    np.testing.assert_allclose(made.responses, RECORD.responses, rtol=1e-11)


@pytest.mark.parametrize("binary", [True, False])
def test_another_program_reads_and_writes_our_universal_files(tmp_path, binary):
    pyuff = pytest.importorskip("pyuff")
    file = ar.write_uff(tmp_path / "a.uff", RECORD, binary=binary)
    sets = pyuff.UFF(str(file)).read_sets()
    np.testing.assert_allclose([s["data"] for s in sets], RECORD.responses, rtol=1e-11)
    assert all(s["id3"].startswith("antires_rs crc32") for s in sets)
    for s in sets:
        s |= {"data": 2.0 * s["data"], "binary": 0}  # the line of the checksum is kept
    other = tmp_path / "b.uff"
    pyuff.UFF(str(other)).write_sets(sets, mode="add")
    assert b"antires_rs crc32" in other.read_bytes()
    np.testing.assert_allclose(ar.read_uff(other).responses, 2.0 * RECORD.responses, rtol=1e-11)
