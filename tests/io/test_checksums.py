"""MATLAB files of ours have checksums: a changed number is noticed, in the values and in the text."""

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


def test_a_whole_one_is_read(tmp_path):
    assert np.array_equal(ar.read_mat(ar.write_mat(tmp_path / "a.mat", RECORD)).responses, RECORD.responses)
