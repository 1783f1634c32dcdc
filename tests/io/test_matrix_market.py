"""Matrix Market files are read here: as SciPy reads whole ones, and none ends the process."""

import io

import numpy as np
import pytest
from scipy.io import mmread, mmwrite
from scipy.sparse import coo_array

import antires_rs as ar
from antires_rs.io.matrix_files import read_matrix_market

RNG = np.random.default_rng(4)
DENSE = RNG.standard_normal((5, 5))
SYMMETRIC = DENSE + DENSE.T


@pytest.mark.parametrize(
    ("matrix", "symmetry"),
    [
        (DENSE, "general"),
        (SYMMETRIC, "symmetric"),
        (DENSE - DENSE.T, "skew-symmetric"),
        (SYMMETRIC + 1j * (DENSE - DENSE.T), "hermitian"),
        (DENSE + 1j * DENSE.T, "general"),
        ((10 * SYMMETRIC).astype(int), "symmetric"),
    ],
)
@pytest.mark.parametrize("sparse", [False, True])
def test_as_scipy_reads_it(tmp_path, matrix, symmetry, sparse):
    text = io.BytesIO()
    mmwrite(text, coo_array(matrix) if sparse else matrix, symmetry=symmetry, precision=17)
    file = tmp_path / "k.mtx"
    file.write_bytes(text.getvalue())
    found = read_matrix_market(file)["k"].matrix
    wanted = mmread(io.BytesIO(text.getvalue()))
    assert isinstance(found, np.ndarray) is not sparse
    assert np.array_equal(
        np.asarray(found.toarray() if sparse else found), wanted.toarray() if sparse else wanted
    )


def test_a_pattern(tmp_path):
    file = tmp_path / "k.mtx"
    file.write_text("%%MatrixMarket matrix coordinate pattern symmetric\n3 3 2\n1 1\n3 1\n")
    assert read_matrix_market(file)["k"].matrix.toarray().tolist() == [[1, 0, 1], [0, 0, 0], [1, 0, 0]]


HEAD = b"%%MatrixMarket matrix "


@pytest.mark.parametrize(
    "text",
    [
        HEAD + b"array real symmetric\n2 2\n1\0\n1\n1\n",
        HEAD + b"coordinate real\0 general\n2 2 1\n1 1 1\n",
        HEAD + b"coordinate real general\0\n2 2 1\n1 1 1\n",
        HEAD + b"coordinate real general\n2 2 1\n3 1 1\n",
        HEAD + b"coordinate real general\n2 2 1\n0 1 1\n",
        HEAD + b"coordinate real general\n2 2 1\n1.5 1 1\n",
        HEAD + b"coordinate real general\n" + 2 * b"99999999999999999999 " + b"1\n1 1 1\n",
        HEAD + b"array pattern general\n2 2\n1\n1\n1\n1\n",
        HEAD + b"coordinate quaternion general\n2 2 1\n1 1 1\n",
    ],
)
def test_what_is_damaged_is_refused(tmp_path, text):
    file = tmp_path / "k.mtx"
    file.write_bytes(text)
    with pytest.raises(ar.exceptions.UnsuitableDataError):
        read_matrix_market(file)
