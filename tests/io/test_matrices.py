"""Matrices of other programs become models: Matrix Market as SciPy reads it, DMIG, OP4, Abaqus, ANSYS."""

import gzip
import struct

import numpy as np
import pytest
import scipy.sparse
from scipy.io import hb_write, mmwrite

import antires_rs as ar
from tests.support.paths import DOCS
from tests.support.refusals import refused, unsuitable

CHAIN = ar.MassSpringChain([1.0, 2.0, 1.5], [500.0, 400.0], ground_first_n_per_m=100.0)
STIFFNESS, MASSES = CHAIN.stiffness(), CHAIN.mass()
SPRING = np.array([[500.0, -500.0, 0.0], [-500.0, 500.0, 0.0], [0.0, 0.0, 0.0]])
MASS = np.diag([1.0, 0.0, 0.0])


def market(path, matrix, **options):
    mmwrite(str(path), matrix, **options)
    return path


def same_chain(model):
    assert model.n_dof == 3
    for i in range(3):
        np.testing.assert_allclose(model.antiresonances(i, 0), CHAIN.antiresonances(i, 0), rtol=1e-9)
    problem = ar.UpdatingProblem(model, ar.stiffness_reduction(0), ar.AntiresonanceSet(0, {0: 3.0}))
    np.testing.assert_allclose(problem.model_at([0.5]).stiffness().toarray(), STIFFNESS - 0.5 * SPRING)


@pytest.mark.parametrize("symmetry", ["symmetric", "general"])
@pytest.mark.parametrize("sparse", [True, False])
def test_matrix_market(tmp_path, symmetry, sparse):
    form = scipy.sparse.coo_array if sparse else np.asarray
    names = [
        market(tmp_path / f"{i}.mtx", form(m), symmetry=symmetry, precision=17)
        for i, m in enumerate((STIFFNESS, MASSES, SPRING, MASS))
    ]
    same_chain(ar.read_matrices(*names[:2], stiffness_terms=[names[2]], mass_terms=[str(names[3])]))
    packed = tmp_path / "K.mtx.gz"
    packed.write_bytes(gzip.compress(names[0].read_bytes()))
    same_chain(ar.read_matrices(packed, MASSES, stiffness_terms=[SPRING]))


def test_sparse_archives(tmp_path):
    for name, matrix in (("K", STIFFNESS), ("S", SPRING)):
        scipy.sparse.save_npz(tmp_path / f"{name}.npz", scipy.sparse.csc_array(matrix))
    masses, terms = scipy.sparse.csr_array(MASSES), [tmp_path / "S.npz"]
    same_chain(ar.read_matrices(tmp_path / "K.npz", masses, stiffness_terms=terms))


def test_one_file_for_a_model(tmp_path):
    model = ar.MatrixModel(STIFFNESS, MASSES, stiffness_terms=[SPRING], mass_terms=[MASS])
    back = ar.read_matrices(ar.write_matrices(tmp_path / "model.npz", model))
    same_chain(back)
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
    (tmp_path / "dofs.txt").write_text("1 UZ\n2 UZ\n3 UZ\n")
    made = ar.Recording(np.random.default_rng(0).standard_normal((2, 64)), 128.0, ["3+Z", "1-Z"])
    rec = ar.read_uff(ar.write_uff(tmp_path / "a.uff", made), dofs=ar.io.read_dof_map(tmp_path / "dofs.txt"))
    assert rec.dofs == (2, 0)
    np.testing.assert_array_equal(rec.responses, made.responses * [[1.0], [-1.0]])


def test_the_recipe_for_scikit_fem():
    """docs/recipes/scikit_fem.md: a cantilever of Hermite elements has Euler's frequencies."""
    pytest.importorskip("skfem", reason="scikit-fem is not installed")
    code = (DOCS / "recipes/scikit_fem.md").read_text().split("```python\n")[1].split("```")[0]
    names = {}
    exec(compile(code, "scikit_fem.md", "exec"), names)
    found = names["model"].modes(2).freq_hz
    exact = np.array([1.8751040687, 4.6940911330]) ** 2 / (2 * np.pi) * np.sqrt(names["EI"] / names["RHO_A"])
    np.testing.assert_allclose(found, exact, rtol=1e-4)


POINTS = [(1, 1), (1, 2), (2, 1), (2, 2), (7, 3)]
K = np.diag([5.0, 4.0, 3.0, 2.0, 1.5e6])
for _i, _j, _value in ((0, 1, -1.0), (1, 2, -0.25), (2, 4, -1e-3)):
    K[_i, _j] = K[_j, _i] = _value
M = np.diag([1.0, 2.0, 3.0, 4.0, 5.0])


def entries(matrix):
    return [(i, j, matrix[i, j]) for j in range(5) for i in range(j, 5) if matrix[i, j]]


def dmig(matrix, name, wide):
    """Cards as pyNastran writes them: a column's point and one entry."""
    lines = ["$ a comment"]
    if wide:
        lines += [f"DMIG*   {name:>16}{0:16d}{6:16d}{2:16d}", f"*       {0:16d}{0:16d}{'':16}{0:16d}"]
    else:
        lines.append(f"DMIG    {name:>8}{0:8d}{6:8d}{1:8d}")
    for i, j, value in entries(matrix):
        (grid, c), (other, d) = POINTS[j], POINTS[i]
        if wide:
            real = f"{value:16.9E}".replace("E", "D")
            lines += [f"DMIG*   {name:>16}{grid:16d}{c:16d}", f"*       {other:16d}{d:16d}{real}"]
        else:
            short = f"{value:.1E}".replace("E", "").replace("+0", "+").replace("-0", "-")
            lines.append(f"DMIG    {name:>8}{grid:8d}{c:8d}{'':8}{other:8d}{d:8d}{short:>8}")
    return "\n".join(lines) + "\n"


def op4_strings(column, layout):
    """First row and values of each run that a column of OUTPUT4 has; and the row in its head."""
    rows = np.flatnonzero(column)
    dense = layout == "dense"
    runs = [rows[[0, -1]]] if dense else np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    return [(run[0], column[run[0] : run[-1] + 1]) for run in runs], rows[0] + 1 if dense else 0


def op4_text(matrix, name, layout):
    lines = [f"{5:8d}{(-5 if layout == 'big' else 5):8d}{6:8d}{2:8d}{name:<8}1P,3E23.16"]
    for j in range(5):
        strings, head = op4_strings(matrix[:, j], layout)
        words = sum(2 * values.size + (layout != "dense") for _, values in strings)
        lines.append(f"{j + 1:8d}{head:8d}{words:8d}")
        for first, values in strings:
            if layout == "big":
                lines.append(f"{2 * values.size + 1:8d}{first + 1:8d}")
            elif layout == "packed":
                lines.append(f"{first + 1 + 65536 * (2 * values.size + 1):8d}")
            text = [f"{v:23.16E}" for v in values]
            lines += ["".join(text[i : i + 3]) for i in range(0, len(text), 3)]
    return "\n".join([*lines, f"{6:8d}{1:8d}{1:8d}", f"{1.0:23.16E}"]) + "\n"


def op4_binary(matrix, name, layout, order, kind):
    def record(data):
        return struct.pack(f"{order}i", len(data)) + data + struct.pack(f"{order}i", len(data))

    words = {"f": 1, "d": 2}[kind]
    rows_stated = -5 if layout == "big" else 5
    out = record(struct.pack(f"{order}4i8s", 5, rows_stated, 6, words, name.ljust(8).encode()))
    for j in range(5):
        (strings, head), data = op4_strings(matrix[:, j], layout), b""
        for first, values in strings:
            length = words * values.size + 1
            lead = {"big": [length, first + 1], "packed": [first + 1 + 65536 * length]}.get(layout, [])
            data += struct.pack(f"{order}{len(lead)}i", *lead) + values.astype(f"{order}{kind}").tobytes()
        out += record(struct.pack(f"{order}3i", j + 1, head, len(data) // 4) + data)
    return out + record(struct.pack(f"{order}3i{words}i", 6, 1, words, *[0] * words))


def same(model, rtol=1e-12):
    np.testing.assert_allclose(model.stiffness().toarray(), K, rtol=rtol)
    np.testing.assert_allclose(model.mass().toarray(), M, rtol=rtol)


@pytest.mark.parametrize("layout", ["dense", "packed", "big"])
def test_op4_text(tmp_path, layout):
    file = tmp_path / "model.op4"
    file.write_text(op4_text(K, "KAA", layout) + op4_text(M, "MAA", layout))
    same(ar.read_matrices(file))
    file.write_text(file.read_text()[:-60])
    unsuitable("whole file of OUTPUT4", ar.read_matrices, file)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("kind", ["f", "d"])
@pytest.mark.parametrize("layout", ["dense", "packed", "big"])
def test_op4_binary(tmp_path, layout, order, kind):
    files = []
    for name, matrix in (("KAA", K), ("MAA", M)):
        files.append(tmp_path / f"{name}.op4")
        files[-1].write_bytes(op4_binary(matrix, name, layout, order, kind))
    same(ar.read_matrices(*files), rtol=1e-6 if kind == "f" else 1e-12)
    for cut in (5, 30, 61, len(files[0].read_bytes()) - 3):
        (tmp_path / "cut.op4").write_bytes(files[0].read_bytes()[:cut])
        unsuitable("cut.op4", ar.read_matrices, tmp_path / "cut.op4", M)


def test_complex_and_missing_matrices_are_told(tmp_path):
    file = tmp_path / "model.op4"
    file.write_text(op4_text(K, "KAA", "dense").replace("       2KAA", "       4KAA"))
    unsuitable("type 4; 1 and 2 are real", ar.read_matrices, file, M)
    file.write_text(op4_text(K, "KAA", "dense") + op4_text(K, "KGG", "dense"))
    refused("the matrices KAA, KGG", ar.read_matrices, file)


@pytest.mark.parametrize("wide", [True, False])
def test_dmig(tmp_path, wide):
    file = tmp_path / "model.pch"
    file.write_text(dmig(K, "KAAX", wide) + dmig(M, "MAAX", wide))
    same(ar.read_matrices(file), rtol=1e-9)
    names = {(node, ["S", "+X", "+Y", "+Z"][code]): row for row, (node, code) in enumerate(POINTS)}
    assert ar.io.read_dof_map(file) == names


def test_dmig_in_free_fields_and_two_entries_a_column(tmp_path):
    file = tmp_path / "k.bdf"
    file.write_text(
        "BEGIN BULK\nDMIG,K2,0,6,2\nGRID,1,,0.,0.,0.\n"
        "DMIG,K2,1,1,,1,1,5.0\n,2,3,-1.5+3\nDMIG,K2,2,3,,2,3,2.5D3\n"
    )
    model = ar.read_matrices(file, np.eye(2))
    np.testing.assert_allclose(model.stiffness().toarray(), [[5.0, -1500.0], [-1500.0, 2500.0]])


def test_mass_without_all_rows_goes_to_those_of_the_stiffness(tmp_path):
    translations = [0, 2]
    part = dmig(M, "MAAX", True).splitlines()
    cards = [line.split() for line in part]
    keep = [i for i, card in enumerate(cards) if card[0] == "DMIG*" and card[2:4] in (["1", "1"], ["2", "1"])]
    lines = part[:3] + [line for i in keep for line in part[i : i + 2]]
    (tmp_path / "k.pch").write_text(dmig(K, "KAAX", True))
    (tmp_path / "m.pch").write_text("\n".join(lines) + "\n")
    mass = ar.read_matrices(tmp_path / "k.pch", tmp_path / "m.pch").mass().toarray()
    np.testing.assert_allclose(np.diag(mass), [M[i, i] if i in translations else 0.0 for i in range(5)])
    other = [line.replace("*                      2", "*                      9") for line in lines]
    (tmp_path / "m.pch").write_text("\n".join(other) + "\n")
    refused(r"mass: got entries at node", ar.read_matrices, tmp_path / "k.pch", tmp_path / "m.pch")


def test_abaqus(tmp_path):
    text = "** written by Abaqus\n*MATRIX, NAME=K, TYPE=SYMMETRIC\n"
    for name, matrix in (("K", K), ("M", M)):
        at = {i: f"{node},{code}" for i, (node, code) in enumerate(POINTS)}
        rows = [f"{at[i]}, {at[j]}, {v:.16e}" for i, j, v in entries(matrix)]
        (tmp_path / f"{name}.mtx").write_text(text + "\n".join(rows) + "\n")
    same(ar.read_matrices(tmp_path / "K.mtx", tmp_path / "M.mtx"))
    assert ar.io.read_dof_map(tmp_path / "K.mtx")[7, "+Z"] == 4
    with (tmp_path / "K.mtx").open("a") as opened:
        opened.write("9,1, 9,1, 1.0e36\n9,1, 7,3, -5.0\n")
    said = r"1 dof\(s\) with a boundary condition.*\(9:1\); they are left out"
    with pytest.warns(ar.AntiresWarning, match=said):
        same(ar.read_matrices(tmp_path / "K.mtx", tmp_path / "M.mtx"))


def test_harwell_boeing(tmp_path):
    for name, matrix in (("K", K), ("M", M)):
        hb_write(str(tmp_path / f"{name}.rua"), scipy.sparse.csc_matrix(matrix))
    same(ar.read_matrices(tmp_path / "K.rua", tmp_path / "M.rua"))
    lower = scipy.sparse.csc_matrix(np.tril(K))
    head = ["a title".ljust(72) + "key", f"{6:14d}{1:14d}{1:14d}{4:14d}{0:14d}"]
    numbers = [f"{v:20.12E}".replace("E", "D") for v in lower.data]
    head += [f"RSA           {5:14d}{5:14d}{lower.nnz:14d}{0:14d}"]
    head += ["(6I8)".ljust(16) + "(10I8)".ljust(16) + "(1P,3D20.12)".ljust(20)]
    places = ["".join(f"{i + 1:8d}" for i in each) for each in (lower.indptr, lower.indices)]
    rows = ["".join(numbers[i : i + 3]) for i in range(0, len(numbers), 3)]
    (tmp_path / "k.rsa").write_text("\n".join([*head, *places, *rows, ""]))
    same(ar.read_matrices(tmp_path / "k.rsa", M))
    (tmp_path / "k.rsa").write_text((tmp_path / "k.rsa").read_text()[:-25])
    unsuitable("7 of 8 numbers", ar.read_matrices, tmp_path / "k.rsa", M)


def test_files_of_ansys_name_the_package_they_need(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "ansys", None)
    (tmp_path / "file.full").write_bytes(b"anything")
    with pytest.raises(ar.MissingDependencyError, match=r"antires-rs\[ansys\]"):
        ar.read_matrices(tmp_path / "file.full")


READER = """
import os, numpy as np
from scipy.sparse import csr_matrix

class Full:
    def load_km(self, as_sparse, sort):
        k = csr_matrix(np.array([[0.0, 0, 0], [0, 2, -1], [0, 0, 1]]))
        return np.array([[1, 0], [2, 0], [2, 2]]), k, csr_matrix(np.diag([0.0, 3, 4]))

def read_binary(path):
    if b"damaged" in open(path, "rb").read():
        os._exit(139)  # as a fault in compiled code ends a process
    return Full()
"""


def test_the_compiled_reader_of_ansys_runs_in_a_child(tmp_path, monkeypatch, own_process):
    """With a package of its name in its place, which ends the process as compiled code does."""
    sys = __import__("sys")
    for name in [each for each in sys.modules if each.split(".")[0] == "ansys"]:
        monkeypatch.delitem(sys.modules, name)
    (tmp_path / "ansys" / "mapdl" / "reader").mkdir(parents=True)
    for part in ("ansys", "ansys/mapdl"):
        (tmp_path / part / "__init__.py").write_text("")
    (tmp_path / "ansys/mapdl/reader/__init__.py").write_text(READER)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "file.full").write_bytes(b"anything")
    model = ar.read_matrices(tmp_path / "file.full")
    np.testing.assert_array_equal(model.stiffness().toarray(), [[2.0, -1.0], [-1.0, 1.0]])
    np.testing.assert_array_equal(model.mass().toarray(), np.diag([3.0, 4.0]))
    (tmp_path / "file.full").write_bytes(b"damaged")
    unsuitable("the reader ended with code 139", ar.read_matrices, tmp_path / "file.full")
    for name in [each for each in sys.modules if each.split(".")[0] == "ansys"]:
        del sys.modules[name]
