"""Matrices of other programs become models; Matrix Market as SciPy reads it; the dof map names their rows."""

import gzip
import io

import numpy as np
import pytest
import scipy.sparse
from scipy.io import mmread, mmwrite
from scipy.sparse import coo_array

import antires_rs as ar
from antires_rs.io.matrix_files import read_matrix_market
from tests.support.paths import DOCS

CHAIN = ar.MassSpringChain([1.0, 2.0, 1.5], [500.0, 400.0], ground_first_n_per_m=100.0)
K, M = CHAIN.stiffness(), CHAIN.mass()
SPRING = np.array([[500.0, -500.0, 0.0], [-500.0, 500.0, 0.0], [0.0, 0.0, 0.0]])
MASS = np.diag([1.0, 0.0, 0.0])


def market(path, matrix, **options):
    mmwrite(str(path), matrix, **options)
    return path


def same(model):
    assert model.n_dof == 3
    for i in range(3):
        np.testing.assert_allclose(model.antiresonances(i, 0), CHAIN.antiresonances(i, 0), rtol=1e-9)
    problem = ar.UpdatingProblem(model, ar.stiffness_reduction(0), ar.AntiresonanceSet(0, {0: 3.0}))
    np.testing.assert_allclose(problem.model_at([0.5]).stiffness().toarray(), K - 0.5 * SPRING)


@pytest.mark.parametrize("symmetry", ["symmetric", "general"])
@pytest.mark.parametrize("sparse", [True, False])
def test_matrix_market(tmp_path, symmetry, sparse):
    form = scipy.sparse.coo_array if sparse else np.asarray
    names = [
        market(tmp_path / f"{i}.mtx", form(m), symmetry=symmetry, precision=17)
        for i, m in enumerate((K, M, SPRING, MASS))
    ]
    same(ar.read_matrices(*names[:2], stiffness_terms=[names[2]], mass_terms=[str(names[3])]))
    packed = tmp_path / "K.mtx.gz"
    packed.write_bytes(gzip.compress(names[0].read_bytes()))
    same(ar.read_matrices(packed, M, stiffness_terms=[SPRING]))


def test_sparse_archives(tmp_path):
    for name, matrix in (("K", K), ("S", SPRING)):
        scipy.sparse.save_npz(tmp_path / f"{name}.npz", scipy.sparse.csc_array(matrix))
    same(
        ar.read_matrices(tmp_path / "K.npz", scipy.sparse.csr_array(M), stiffness_terms=[tmp_path / "S.npz"])
    )
    np.savez(tmp_path / "other.npz", a=K)
    with pytest.raises(ar.UnsuitableDataError, match="wanted a file of scipy.sparse.save_npz"):
        ar.read_matrices(tmp_path / "other.npz", M)


def test_one_file_for_a_model(tmp_path):
    model = ar.MatrixModel(K, M, stiffness_terms=[SPRING], mass_terms=[MASS])
    back = ar.read_matrices(ar.write_matrices(tmp_path / "model.npz", model))
    same(back)
    assert repr(back) == repr(model)
    for mine, theirs in ((model.stiffness(), back.stiffness()), (model.mass(), back.mass())):
        np.testing.assert_array_equal(mine.toarray(), theirs.toarray())
    problem = ar.UpdatingProblem(model, ar.stiffness_reduction(0), ar.AntiresonanceSet(0, {0: 3.0}))
    with pytest.raises(ar.InvalidInputError, match="^model: got an updated model.*result.save"):
        ar.write_matrices(tmp_path / "x.npz", problem.model_at([0.5]))


@pytest.mark.parametrize(
    "text",
    [
        "# node direction\n12 +Z\n12 RX\n7 x\n",
        "12,3\n12,4\n7,1\n",
        "Matrix Eqn  Node  DOF\n 1 12 UZ\n 2 12 ROTX\n 3 7 UX\n",
    ],
)
def test_dof_map(tmp_path, text):
    path = tmp_path / "dofs.txt"
    path.write_text(text)
    assert ar.io.read_dof_map(path) == {(12, "+Z"): 0, (12, "+RX"): 1, (7, "+X"): 2}


def test_a_dof_map_names_the_channels_of_a_test(tmp_path):
    pytest.importorskip("pyuff")
    (tmp_path / "dofs.txt").write_text("1 UZ\n2 UZ\n3 UZ\n")
    made = ar.Recording(np.random.default_rng(0).standard_normal((2, 64)), 128.0, ["3+Z", "1-Z"])
    rec = ar.read_uff(ar.write_uff(tmp_path / "a.uff", made), dofs=ar.io.read_dof_map(tmp_path / "dofs.txt"))
    assert rec.dofs == (2, 0)
    np.testing.assert_array_equal(rec.responses, made.responses * [[1.0], [-1.0]])


def test_the_recipe_for_scikit_fem():
    """docs/recipes/scikit_fem.md: a cantilever of Hermite elements has Euler's frequencies."""
    pytest.importorskip("skfem", reason="scikit-fem is not installed")
    recipe = (DOCS / "recipes/scikit_fem.md").read_text()
    code = recipe.split("```python\n")[1].split("```")[0]
    names = {}
    exec(compile(code, "scikit_fem.md", "exec"), names)
    found = names["model"].modes(2).freq_hz
    exact = np.array([1.8751040687, 4.6940911330]) ** 2 / (2 * np.pi) * np.sqrt(names["EI"] / names["RHO_A"])
    np.testing.assert_allclose(found, exact, rtol=1e-4)


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
