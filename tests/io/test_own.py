"""Files of our own: options heeded or refused by name; a changed number is noticed, in values and text."""

import json

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app.reading import read_signal
from reference.io_signals import recording, response
from tests.support.refusals import refused, unsuitable

pytest.importorskip("h5py")

FORMATS = {k: (getattr(ar, f"write_{k}"), getattr(ar, f"read_{k}")) for k in ("npz", "hdf5", "mat", "csv")}
every_format = pytest.mark.parametrize("kind", FORMATS)


@pytest.fixture
def files(tmp_path, kind):
    write, read = FORMATS[kind]
    made = {"record": recording(n=40), "response": response(kind="transmissibility", std=True, n=40)}
    return {name: (write(tmp_path / name, signal), signal) for name, signal in made.items()}, read


@every_format
def test_channels_are_renamed_and_left_out(files, kind):
    (file, made), read = files[0]["record"], files[1]
    for dofs in (
        [4, None, "b"],
        {0: 4, "tip": None, "12+Z": "b"},
        lambda name: {0: 4, "tip": None, "12+Z": "b"}[name],
    ):
        got = read(file, dofs=dofs)
        assert got.dofs == (4, "b")
        np.testing.assert_array_equal(got.responses, made.responses[[0, 2]])
        np.testing.assert_array_equal(got.force, made.force)
    (file, made) = files[0]["response"]
    got = read(file, dofs={0: None, "tip": 2, "12+Z": 3}, reference=2)
    assert (got.dofs, got.reference, got.n_averages) == ((2, 3), 2, made.n_averages)
    for name in ("values", "coherence", "std"):
        np.testing.assert_array_equal(getattr(got, name), getattr(made, name)[1:])
    refused(r"^dofs: got no dof for \['12\+Z'\]; wanted a dof", read, file, dofs={0: 4, "tip": 2})
    refused("^dofs: got None for every channel; wanted at least one", read, file, dofs=lambda name: None)
    refused("^dofs: got no dof for the reference, 'tip'", read, file, dofs=[1, None, 2])


@every_format
def test_the_force_is_dropped(files, kind):
    (file, made), read = files[0]["record"], files[1]
    assert read(file, force=None).force is None
    np.testing.assert_array_equal(read(file, force="force").force, made.force)
    refused("^force: got 'tip' for .* a file of antires_rs", read, file, force="tip")
    refused("^force: got 'force' for .* of kind 'trans", read, files[0]["response"][0], force="force")


WRONG = [  #: Of a record, of responses; and the formats that have such an option.
    ({"unit": "g"}, {"unit": "g/N"}, "npz hdf5 mat csv"),
    ({"fs_hz": 100.0}, {"fs_hz": 512.0}, "npz hdf5 mat csv"),
    ({"kind": "frf"}, {"kind": "frf"}, "npz hdf5 mat csv"),
    ({"reference": 0}, {"reference": 0}, "npz hdf5 mat csv"),
    ({"first": "freq"}, {"df_hz": 1.0}, "csv"),
    ({"responses": ["responses[0]"]}, {"freq_hz": [1.0, 2.0]}, "npz"),
    ({"time": "force"}, {"freq": "std"}, "npz hdf5 mat"),
]


@every_format
def test_options_that_the_file_contradicts_are_refused(files, kind):
    for *options, kinds in WRONG:
        for which, option in zip(("record", "response"), options, strict=True) if kind in kinds else ():
            file, name = files[0][which][0], next(iter(option))
            said = f"^{name}: got .* a file of antires_rs .*; wanted it with files of other programs alone"
            refused(f"{said}. This file states it itself; leave it out", files[1], file, **option)
            with pytest.raises(ar.InvalidInputError, match=f"^{name}: got .*leave it out"):  # from a job
                read_signal(file, kind, option)


@every_format
def test_options_that_agree_are_taken(files, kind):
    of_record = {"unit": "m/s2", "fs_hz": 512}
    of_response = {"unit": "m", "kind": "transmissibility", "reference": "tip"}
    for which, options in (("record", of_record), ("response", of_response)):
        file, made = files[0][which]
        assert files[1](file, **options).dofs == made.dofs


@every_format
def test_a_job_names_channels_once(files, kind):
    """Names that trade places would come out wrong if they were given twice."""
    (file, made) = files[0]["record"]
    got = read_signal(file, kind, {"dofs": {"0": "tip", "tip": "12+Z", "12+Z": False}, "force": False})
    assert (got.dofs, got.force) == (("tip", "12+Z"), None)
    np.testing.assert_array_equal(got.responses, made.responses[:2])
    assert read_signal(file, kind, {"dofs": [False, 1, 2]}).dofs == (1, 2)


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
    unsuitable(said, ar.read_mat, file)


@pytest.mark.parametrize(("write", "read"), [(ar.write_npz, ar.read_npz), (ar.write_hdf5, ar.read_hdf5)])
def test_formats_with_checksums_notice_any_changed_byte(tmp_path, write, read):
    path = write(tmp_path / "a", recording(n=2000))
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x55
    path.write_bytes(data)
    unsuitable("cannot be read", read, path)


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
    unsuitable(said, ar.read_npz, tmp_path / "a.npz")
