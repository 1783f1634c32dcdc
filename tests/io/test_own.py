"""Options of the readers for files of our own: heeded, or refused by name."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app.reading import read_signal
from reference.io_signals import recording, response
from tests.support.campaign import some_of

pytest.importorskip("h5py")

FORMATS = {
    "npz": (ar.write_npz, ar.read_npz),
    "hdf5": (ar.write_hdf5, ar.read_hdf5),
    "mat": (ar.write_mat, ar.read_mat),
    "csv": (ar.write_csv, ar.read_csv),
}
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
    with pytest.raises(ar.InvalidInputError, match=r"^dofs: got no dof for \['12\+Z'\]; wanted a dof"):
        read(file, dofs={0: 4, "tip": 2})
    with pytest.raises(ar.InvalidInputError, match="^dofs: got None for every channel; wanted at least one"):
        read(file, dofs=lambda name: None)
    with pytest.raises(ar.InvalidInputError, match="^dofs: got no dof for the reference, 'tip'"):
        read(file, dofs=[1, None, 2])


@every_format
def test_the_force_is_dropped(files, kind):
    (file, made), read = files[0]["record"], files[1]
    assert read(file, force=None).force is None
    np.testing.assert_array_equal(read(file, force="force").force, made.force)
    with pytest.raises(ar.InvalidInputError, match="^force: got 'tip' for .* with a force; wanted 'auto'"):
        read(file, force="tip")
    with pytest.raises(ar.InvalidInputError, match="without a force; wanted 'auto' or None. The file states"):
        read(files[0]["response"][0], force="force")


WRONG = [
    ("record", {"unit": "g"}, "npz hdf5 mat csv"),
    ("response", {"unit": "g/N"}, "npz hdf5 mat csv"),
    ("record", {"fs_hz": 100.0}, "npz hdf5 mat csv"),
    ("response", {"fs_hz": 512.0}, "npz hdf5 mat csv"),
    ("record", {"kind": "frf"}, "npz hdf5 mat csv"),
    ("response", {"kind": "frf"}, "npz hdf5 mat csv"),
    ("record", {"reference": 0}, "npz hdf5 mat csv"),
    ("response", {"reference": 0}, "npz hdf5 mat csv"),
    ("record", {"first": "freq"}, "csv"),
    ("response", {"df_hz": 1.0}, "npz csv"),
    ("response", {"freq_hz": [1.0, 2.0]}, "npz csv"),
    ("record", {"time": "force"}, "npz hdf5 mat"),
    ("record", {"freq": "freq_hz"}, "npz hdf5 mat"),
    ("response", {"freq": "std"}, "npz hdf5 mat"),
    ("record", {"responses": ["responses[0]"]}, "npz hdf5 mat"),
]
#: A MAT file takes a process of its own; what is asked of its options is what is asked of all.
EACH = [(which, option, kind) for which, option, kinds in WRONG for kind in kinds.split()]


@pytest.mark.parametrize(
    ("which", "option", "kind"),
    some_of(EACH, [case for case in EACH if case[2] != "mat" or "unit" in case[1]]),
)
def test_options_that_the_file_contradicts_are_refused(files, which, option, kind):
    name = next(iter(option))
    with pytest.raises(
        ar.InvalidInputError,
        match=f"^{name}: got .* a file of antires_rs .*; wanted it with "
        "files of other programs alone. This file states it itself; leave it out.",
    ):
        files[1](files[0][which][0], **option)
    with pytest.raises(ar.InvalidInputError, match=f"^{name}: got .*leave it out"):  # from a job
        read_signal(files[0][which][0], kind, option)


@every_format
def test_options_that_agree_are_taken(files, kind):
    of_record = {"unit": "m/s2", "fs_hz": 512}
    of_response = {"unit": "m", "kind": "transmissibility", "reference": "tip"}
    if kind == "csv":
        of_record, of_response = of_record | {"first": "time"}, of_response | {"first": "freq"}
    else:
        of_record, of_response = of_record | {"responses": "responses"}, of_response | {"freq": "freq_hz"}
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
