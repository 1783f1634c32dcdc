"""Models from runs of finite-element codes: terms, checks, what is kept; CalculiX and OpenSees themselves."""

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app.main import main as antires
from antires_rs.damage.likelihood import factors_of
from antires_rs.io import calculix
from antires_rs.io.matrix_files import completed
from tests.support.paths import DOCS, EXAMPLES
from tests.support.refusals import refused
from tests.support.snapshots import refusal, replay

needs_calculix = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not on PATH")
needs_opensees = pytest.mark.skipif(
    importlib.util.find_spec("openseespy") is None, reason="openseespy is not installed"
)
SCALED = (ar.stiffness_factor(1, bounds=(0.5, 2.0)), 1.1), (ar.stiffness_reduction("web"), 1.0)
SETS = 20  # random sets of values, each against a run of the code with them


def program_text(name):
    """A program that a test runs."""
    return Path(__file__).with_name("programs").joinpath(f"{name}.txt").read_text()


def largest(one, other):
    """Largest difference of two matrices as a share of their entries, sqrt(K_ii K_jj)."""
    size = np.sqrt(np.abs(other.diagonal()))
    size = np.maximum(size, 1e-6 * size.max())
    return float((abs((one - other).toarray()) / np.outer(size, size)).max())


# -- Terms, by functions of Python


def strip(e_web=100.0, t_skin=2.0, rho=3.0):
    web = e_web * np.array([[1.0, -1.0], [-1.0, 1.0]])
    skin = np.array([[40.0 * t_skin + 5.0 * t_skin**3, 0.0], [0.0, 7.0 / t_skin]])
    return web + skin, rho * np.diag([1.0, 2.0]), ["1:X", "2:X"]


def test_terms_of_a_function_are_powers_of_its_values():
    model = ar.read_model(strip, groups={"web": "e_web", "skin": "t_skin", "mass": "rho"})
    web, skin = model.groups["web"], model.groups["skin"]
    assert (web.value, web.linear, web.stiffness_powers, web.mass_powers) == (100.0, True, ((0, 1),), ())
    assert sorted(power for _, power in skin.stiffness_powers) == [-1, 1, 3]
    assert (skin.linear, model.default_elements) == (False, [0])
    assert [model.element_label(i) for i in range(2)] == ["web", "skin^1"]
    assert model.mass_label(model.groups["mass"].mass_powers[0][0]) == "mass"
    rng = np.random.default_rng(0)
    for factors in rng.uniform(0.6, 1.4, (SETS, 3)):
        s = dict(zip(("web", "skin", "mass"), factors, strict=True))
        stiffness, mass, _ = strip(100.0 * s["web"], 2.0 * s["skin"], 3.0 * s["mass"])
        made = model.with_group_factors(s)
        np.testing.assert_allclose(made.stiffness().toarray(), stiffness, rtol=1e-9)
        np.testing.assert_allclose(made.mass().toarray(), mass, rtol=1e-12)


def test_parameters_and_candidates_go_by_the_name_of_a_group():
    model = ar.read_model(strip, groups={"web": "e_web", "skin": "t_skin", "mass": "rho"})
    parameters = [ar.stiffness_factor("web", bounds=(0.5, 1.5)), ar.mass_factor("mass", bounds=(0.5, 1.5))]
    measured = ar.AntiresonanceSet("1:X", {"1:X": model.antiresonances("1:X", "1:X")})
    problem = ar.UpdatingProblem(model, parameters, measured.relabelled(0, {"1:X": 0}))
    assert problem.names == ["stiffness of web", "mass"]
    assert problem.parameters[0].terms == (0,)
    assert model.element("web") == 0
    assert model.with_group_factors({}) is model


def test_terms_of_one_thickness_are_wrong_together_or_not_at_all():
    def hull(e=3.0, t=2.0):
        return np.diag([e, t + t**3]), np.array([[t + t**3, 0.4 * t**3], [0.4 * t**3, 2.0 * t]])

    model = ar.read_model(hull, groups=["e", "t"])
    assert [power for _, power in model.groups["t"].mass_powers] == [1, 3]
    assert [(p.quantity, p.terms) for p in factors_of(model)] == [("stiffness_factor", (0,))]


def test_a_thickness_is_one_parameter(tmp_path):
    """Of a value in K by -1, 1 and 3 and in M by 1, in its unit, beside a modulus; applied twice; kept."""
    pulled = 2.0 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1)
    ends, bent = np.diag([0.0, 0.0, 1.0, 1.0, 1.0, 0.0]), np.zeros((6, 6))
    bent[2:5, 2:5] = np.outer([1.0, -2.0, 1.0], [1.0, -2.0, 1.0])

    def plate(e_web=100.0, t_skin=2.0):
        stiffness = e_web * pulled + 3.0 * t_skin**3 * bent + 9.0 * t_skin * ends + 8.0 / t_skin * np.eye(6)
        return stiffness, np.eye(6) + 0.2 * t_skin * ends, [f"{n}:Z" for n in range(1, 7)]

    model = ar.read_model(plate, groups={"web": "e_web", "skin": "t_skin"})
    powers = model.groups["skin"].stiffness_powers
    assert sorted(power for _, power in powers) == [-1, 1, 3]
    truth = model.with_group_factors({"web": 0.93, "skin": 1.12})
    found = {dof: truth.antiresonances(dof, "1:Z") for dof in ("1:Z", "2:Z", "3:Z")}
    measured = ar.AntiresonanceSet("1:Z", found)
    chosen = [ar.youngs_modulus("web", bounds=(70.0, 130.0)), ar.thickness("skin", bounds=(1.6, 2.6))]
    problem = ar.UpdatingProblem(model, chosen, measured)
    assert problem.names == ["Young's modulus of web", "thickness of skin"]
    assert problem.nominal.tolist() == [100.0, 2.0]
    result = ar.update(problem, rng=0)
    np.testing.assert_allclose(result.x, [93.0, 2.24], rtol=1e-6)
    assert result.model.group_factors == pytest.approx({"web": 0.93, "skin": 1.12}, rel=1e-6)
    for name, (low, high) in result.interval.items():
        assert low < result.x[problem.names.index(name)] < high
    # Values replace those that an updating has left; factors are on them.
    again = ar.UpdatingProblem(result.model, chosen, measured)
    np.testing.assert_allclose(again.nominal, result.x)
    thin = result.model.with_parameters(ar.thickness("skin", bounds=(1.0, 2.0)), 1.5)
    half = thin.with_parameters(ar.thickness("skin", bounds=(0.4, 2.0), relative=True), 0.5)
    assert half.group_factors == pytest.approx({"web": 0.93, "skin": 0.375}, rel=1e-6)
    expected = model.with_group_factors(half.group_factors)
    np.testing.assert_allclose(half.stiffness().toarray(), expected.stiffness().toarray(), rtol=1e-12)
    result.save(tmp_path / "result.npz")
    kept = ar.UpdateResult.load(tmp_path / "result.npz")
    assert (kept.model.stiffness() != result.model.stiffness()).nnz == 0


def test_what_is_wrong_is_told(program, deck, tmp_path, monkeypatch):
    """Each line of the file is a call and what is said of it: what is no sum of terms, with what is left."""
    source, command = program
    plate, new, eye, read = tmp_path / "plate.inp", tmp_path / "new.dat", np.eye(1), ar.read_model
    still = lambda e=2.0: (np.eye(1), np.eye(1))  # noqa: E731
    model = read(strip, groups={"web": "e_web", "skin": "t_skin", "mass": "rho"})
    run = partial(read, source, command=command)
    made = run(groups=GROUPS)
    write = partial(ar.write_model, command=command)
    scaled, gone = (made.with_parameters(*given) for given in SCALED)
    places = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    mesh = partial(ar.Mesh, [1, 2], kinds=("B31",))
    here = globals() | locals()
    monkeypatch.setenv("PATH", str(tmp_path))  # no CalculiX

    def said(case):
        return refusal(lambda: eval(case, here)).replace(str(tmp_path), "FOLDER")

    replay(Path(__file__).with_name("wrong_models.txt"), said)


# -- Meshes of other programs, and models that another package of Python assembles


def test_a_mesh_of_another_program_is_the_picture_of_a_model(tmp_path):
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0]]
    cells = [("vertex", [[0]]), ("quad", [[0, 1, 2, 3]]), ("line", [[1, 4]])]
    meshio.Mesh(np.array(square), cells).write(tmp_path / "strip.vtu")
    mesh = ar.io.read_mesh(tmp_path / "strip.vtu")
    assert (mesh.kinds, mesh.connectivity.tolist()) == (("quad", "line"), [[1, 2, 3, 4], [2, 5, -1, -1]])
    assert mesh.place(5).tolist() == [2.0, 0.0, 0.0]
    model = ar.read_model(strip, groups=["e_web"], mesh=tmp_path / "strip.vtu")
    assert model.mesh == mesh
    other = ar.io.read_mesh(tmp_path / "strip.vtu", nodes=[7, 1, 3, 4, 5])
    refused("5 nodes without 2, which dofs have", ar.read_model, strip, groups=["e_web"], mesh=other)
    for wrong in ([1], 7, [1.5, 2, 3, 4, 5], ["a", "b", "c", "d", "e"], [[1], [2, 3], 4, 5, 6]):
        refused("a whole number for each of 5 nodes", ar.io.read_mesh, tmp_path / "strip.vtu", nodes=wrong)
    # Nastran's own numbers; a file of no kind, at which meshio would end the program.
    grids = "".join(
        f"GRID    {n:<16}{x:<8}{y:<8}0.0\n" for n, x, y in ((11, 0.0, 0.0), (15, 1.0, 0.0), (4, 1.0, 1.0))
    )
    (tmp_path / "t.bdf").write_text(
        f"BEGIN BULK\n{grids}CTRIA3  7       1       11      15      4\nENDDATA\n"
    )
    assert ar.io.read_mesh(tmp_path / "t.bdf").connectivity.tolist() == [[11, 15, 4]]
    (tmp_path / "a.vtk").write_text("nothing\n")
    refused(
        "mesh: got .*a.vtk', which no reader", ar.read_model, strip, groups=["e_web"], mesh=tmp_path / "a.vtk"
    )
    refused("which no reader of meshio takes", ar.io.read_mesh, tmp_path / "a.vtk")
    meshio.Mesh(np.array(square), cells[:1]).write(tmp_path / "points.vtu")
    refused("without elements", ar.io.read_mesh, tmp_path / "points.vtu")
    for node in (9, -1):  # neither is a node of the file
        cells = f"CELLS 1 3\n2 0 {node}\nCELL_TYPES 1\n3\n"
        (tmp_path / "a.vtk").write_text(
            "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 2 double\n0 0 0\n1 0 0\n"
            + cells
        )
        refused("with nodes of a line that it has not", ar.io.read_mesh, tmp_path / "a.vtk")
    faces = [[[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]]]
    solid = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    meshio.Mesh(solid, [("polyhedron4", faces)]).write(tmp_path / "solid.vtu")
    refused("with polyhedra", ar.io.read_mesh, tmp_path / "solid.vtu")
    (tmp_path / "bar.inp").write_text("*NODE\n5, 0.\n9, 2.\n")
    refused("numbers for an input of CalculiX", ar.io.read_mesh, tmp_path / "bar.inp", nodes=[1, 2])


def test_a_plate_of_scikit_fem_has_its_own_frequencies():
    """A membrane: -div(t grad u), clamped on one side; the frequencies by scikit-fem's own solver."""
    skfem = pytest.importorskip("skfem", reason="scikit-fem is not installed")
    grid = skfem.MeshQuad.init_tensor(np.linspace(0.0, 2.0, 9), np.linspace(0.0, 1.0, 5))
    basis = skfem.Basis(grid, skfem.ElementQuad1())
    here = np.where(grid.p[0, grid.t].mean(axis=0) < 1.0, 0.0, 1.0)[:, None] * np.ones((1, basis.X.shape[-1]))
    free = basis.complement_dofs(basis.get_dofs(lambda x: x[0] == 0.0))

    @skfem.BilinearForm
    def pull(u, v, w):
        return (w.left * (1.0 - w.here) + w.right * w.here) * (u.grad[0] * v.grad[0] + u.grad[1] * v.grad[1])

    @skfem.BilinearForm
    def weight(u, v, _):
        return u * v

    def build(left=3.0e4, right=3.0e4):
        of = {"here": here, "left": left + 0.0 * here, "right": right + 0.0 * here}
        both = pull.assemble(basis, **of), weight.assemble(basis)
        return *(each[free][:, free] for each in both), [f"{dof + 1}:Z" for dof in free]

    places = np.column_stack([grid.p.T, np.zeros(grid.nvertices)])
    cells, numbers = grid.t.T + 1, np.arange(1, grid.nvertices + 1)
    kind = np.zeros(len(cells), dtype=int)
    mesh = ar.Mesh(numbers, places, np.arange(len(cells)), cells, ("quad",), kind)
    model = ar.read_model(build, groups=["left", "right"], mesh=mesh)
    assert model.mesh.nodes.size == grid.nvertices
    stiffness, mass, _ = build(2.1e4, 3.9e4)
    own = skfem.solve(stiffness, mass, solver=skfem.solver_eigen_scipy_sym(k=5))[0]
    now = model.with_group_factors({"left": 0.7, "right": 1.3})
    np.testing.assert_allclose(now.modes(5).freq_hz, np.sqrt(own) / (2.0 * np.pi), rtol=1e-9)
    measured = ar.AntiresonanceSet(0, {dof: now.antiresonances(dof, 0, f_max_hz=200.0) for dof in (0, 5, 17)})
    bounds = {"bounds": (0.5, 1.5)}
    found = ar.update(
        ar.UpdatingProblem(model, ar.stiffness_factor(["left", "right"], **bounds), measured), rng=0
    )
    np.testing.assert_allclose(found.x[0] / found.x[1], 0.7 / 1.3, rtol=1e-4)


# -- Any code by a command: here a program that writes Matrix Market files

GROUPS = {"web": 100.0, "skin": 4.0}
PAINT = ar.TermGroup("paint", "density", 1200.0)


@pytest.fixture
def program(tmp_path):
    """Its input with places for values, and the command."""
    (tmp_path / "code.py").write_text(program_text("market"))
    source = tmp_path / "strip.dat"
    source.write_text("web {web}\nskin {skin:.5e}\nlog {folder}\n")
    return source, f"{sys.executable} {tmp_path / 'code.py'} {{input}}"


def runs_of(folder):
    log = folder / "log.txt"
    return len(log.read_text().splitlines()) if log.exists() else 0


def test_a_command_is_run_for_the_terms_once(program, tmp_path):
    source, command = program
    out = tmp_path / "strip.npz"
    model = ar.read_model(source, groups=GROUPS, command=command, out=out)
    assert model.groups["web"].linear
    assert sorted(power for _, power in model.groups["skin"].stiffness_powers) == [1, 3]
    changed = model.with_group_factors({"web": 1.3, "skin": 0.7}).stiffness().toarray()
    k = [130.0 + 3.0 * 2.8, -130.0, 130.0 + 0.2 * 2.8**3]
    np.testing.assert_allclose(changed, [[k[0], k[1]], [k[1], k[2]]], rtol=1e-9)
    assert runs_of(tmp_path) == 1 + 2 + 5 + 1
    again = ar.read_model(source, groups=GROUPS, command=command, out=out)
    assert runs_of(tmp_path) == 9  # nothing was run again
    assert again.description == model.description == ar.read_matrices(out).description
    kept = sorted((tmp_path / "strip.runs").iterdir())
    kept[3].write_bytes(kept[3].read_bytes()[:100])  # damaged: run again
    ar.read_model(source, groups=GROUPS, command=command, out=out)
    assert runs_of(tmp_path) == 10
    source.write_text(source.read_text() + "note 1\n")  # another input
    ar.read_model(source, groups=GROUPS, command=command, out=out, workers=1)
    assert runs_of(tmp_path) == 19


def test_an_input_of_few_columns_and_a_punch_file(tmp_path):
    (tmp_path / "code.py").write_text(program_text("punch"))
    source = tmp_path / "bar.bdf"
    source.write_text("MAT1*                  1{web:>16.9E}                             0.3\n*\n")
    command = f"{sys.executable} {tmp_path / 'code.py'} {{input}}"
    model = ar.read_model(source, groups={"web": 7.1e10 / 3.0}, command=command)
    assert (model.dof_label(1), model.groups["web"].linear) == ("2:Z", True)
    term = model.description.recipe.stiffness_terms[0].sparse(2).toarray()
    np.testing.assert_allclose(term, 7.1e10 / 3.0 * np.array([[2.0, -1.0], [-1.0, 1.0]]), rtol=1e-8)


def test_a_code_that_is_not_there_is_told(program, deck, tmp_path, monkeypatch):
    with pytest.raises(ar.MissingDependencyError, match="which is not there. Correct command="):
        ar.read_model(program[0], groups=GROUPS, command="no_such_code {input}")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ar.MissingDependencyError, match="apt install calculix-ccx"):
        ar.read_model(tmp_path / "plate.inp", groups="Tip")


@pytest.mark.skipif(os.name != "posix", reason="no SIGKILL")
def test_killed_in_the_middle_it_goes_on_to_the_same_file(program, tmp_path):
    source, command = program
    whole = ar.read_model(source, groups=GROUPS, command=command, out=tmp_path / "whole.npz")
    (tmp_path / "log.txt").unlink()
    source.write_text(source.read_text() + "sleep 0.4\n")
    out = tmp_path / "killed.npz"
    options = {"groups": GROUPS, "command": command, "out": str(out), "workers": 1}
    call = f"import antires_rs as ar; ar.read_model({str(source)!r}, **{options})"
    process = subprocess.Popen([sys.executable, "-c", call])
    for _ in range(600):
        if runs_of(tmp_path) > 3 or process.poll() is not None:
            break
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert not out.exists()
    done = len(list((tmp_path / "killed.runs").glob("*.npz")))
    assert 2 <= done <= 4
    before = runs_of(tmp_path)
    made = ar.read_model(source, groups=GROUPS, command=command, out=out)
    assert runs_of(tmp_path) - before == 9 - done
    assert made.description == whole.description
    assert not [each for each in (tmp_path / "killed.runs").iterdir() if each.is_dir()]


def test_the_command_line_makes_a_model_for_a_job(program, tmp_path, capsys):
    source, command = program
    out = tmp_path / "model.npz"
    call = ["model", str(source), "--command", command, "--out", str(out), "--groups"]
    assert antires([*call, "web=100", "skin=4"]) == 0
    told = capsys.readouterr().out
    assert "2 dofs" in told
    assert "skin  value 4: stiffness with powers 1, 3" in told
    assert antires([*call, "web=100", "skin=4", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [(row["name"], row["linear"]) for row in data["groups"]] == [("web", True), ("skin", False)]
    model = ar.read_matrices(out)
    now = model.with_parameters(ar.stiffness_reduction("web"), [0.3])
    zeros = {dof: now.antiresonances(dof, 0) for dof in (0, 1)}
    ar.AntiresonanceSet(0, {dof: hz for dof, hz in zeros.items() if len(hz)}).save(tmp_path / "now.json")
    (tmp_path / "job.toml").write_text(
        '[data]\nfile = "now.json"\n[model]\nkind = "matrices"\nfile = "model.npz"\n'
        '[damage]\nelements = ["web"]\n[output]\nfolder = "found"\nreport = false\npictures = false\n'
    )
    assert antires(["damage", str(tmp_path / "job.toml")]) == 0
    assert "web" in capsys.readouterr().out
    assert antires([*call, "rib=1"]) == 2
    assert "--groups" in capsys.readouterr().err
    (tmp_path / "empty.inp").write_text("*NODE\n")
    for mesh in ("no.inp", "empty.inp"):  # the mesh is at fault, not the source
        assert antires([*call, "web=100", "--mesh", str(tmp_path / mesh)]) in (1, 2)
        assert f"error: --mesh: got '{tmp_path / mesh}'" in capsys.readouterr().err


# -- Written back


def test_the_input_is_written_with_values_that_were_found(program, tmp_path):
    source, command = program
    model = ar.read_model(source, groups=GROUPS, command=command)
    factors = {"web": 0.9, "skin": 1.25}
    assert model.group_factors == {"web": 1.0, "skin": 1.0}
    now = model.with_group_factors({"web": 1.2, "skin": 1.25})
    now = now.with_parameters(ar.stiffness_reduction("web"), 0.25)
    assert now.group_factors == pytest.approx(factors, rel=1e-14)
    written = ar.write_model(tmp_path / "new.dat", source, now, command=command)
    web = 100.0 * now.group_factors["web"]
    assert written.read_text() == f"web {web!r}\nskin 5.00000e+00\nlog {tmp_path}\n"


def test_groups_without_terms_have_a_factor_too():
    model = ar.MatrixModel(np.eye(1), np.eye(1), groups=[PAINT])
    assert model.group_factors == {"paint": 1.0}


def test_a_colon_in_the_path_does_not_hide_the_source(tmp_path):
    folder = tmp_path / "a:b"
    folder.mkdir()
    source = folder / "bar.dat"
    source.write_text("modulus {web:.4e}")
    web = ar.TermGroup("web", "value", 2.1e11, ((0, 1),))
    model = ar.MatrixModel(np.eye(1), np.eye(1), stiffness_terms={"web": np.eye(1)}, groups=[web])
    refused("another file than the source", ar.write_model, source, source, model, command="code {input}")
    ar.write_model(folder / "new.dat", source, model, command="code {input}")
    ar.write_model(folder / "new.dat", source, model, command="code {input}")  # over the one before


def test_the_command_line_writes_the_input_of_a_result(program, tmp_path, capsys):
    source, command = program
    model = ar.read_model(source, groups=GROUPS, command=command)
    true = model.with_group_factors({"web": 0.8})
    zeros = ar.AntiresonanceSet(0, {0: true.antiresonances(0, 0)})
    parameters = ar.stiffness_factor(["web"], bounds=(0.5, 1.5))
    ar.update(ar.UpdatingProblem(model, parameters, zeros), rng=0).save(tmp_path / "result.npz")
    call = ["model", str(source), "--command", command, "--out", str(tmp_path / "new.dat")]
    assert antires([*call, "--result", str(tmp_path / "result.npz")]) == 0
    assert "web  0.8 times its value" in capsys.readouterr().out
    assert float((tmp_path / "new.dat").read_text().split()[1]) == pytest.approx(80.0, rel=1e-6)
    assert antires([*call[:-1], str(tmp_path / "more.dat"), "--result", str(tmp_path)]) == 0  # its folder
    capsys.readouterr()
    assert antires([*call[:-1], str(tmp_path / "next.dat"), "--result", str(tmp_path / "none.npz")]) == 2
    assert "--result: got " in capsys.readouterr().err
    assert antires([*call[:-1], str(tmp_path / "new.npz")]) == 2
    assert "--groups" in capsys.readouterr().err


# -- CalculiX: its input, without the code

INPUT, MESH = (Path(__file__).with_name(name).read_text() for name in ("plate.inp", "plate_mesh.txt"))


@pytest.fixture
def deck(tmp_path):
    (tmp_path / "plate.inp").write_text(INPUT)
    (tmp_path / "mesh.txt").write_text(MESH)
    return calculix.Deck(tmp_path / "plate.inp")


def test_the_input_of_calculix_is_read_with_what_it_includes(deck, tmp_path):
    assert deck.elements_of("both") == [3, 4, 2]
    assert deck.elements_of("steel") == [1, 2, 3, 4]
    assert (deck.names("elset"), deck.names("material")) == (["EALL", "SKIN"], ["Steel", "PLY"])
    mesh = deck.mesh()
    assert (mesh.nodes.tolist(), mesh.elements.tolist()) == ([1, 2, 3, 4], [1, 2, 3, 4, 9])
    assert mesh.kinds == ("C3D4", "S4")
    np.testing.assert_array_equal(mesh.place(2), [1.0, 0.0, 0.0])
    assert deck.value("youngs_modulus", [1, 3]) == 2.1e11
    assert deck.value("youngs_modulus", [1, 9]) is None
    assert deck.value("thickness", [9]) == 0.002
    for text, said in (
        (INPUT.replace("mesh.txt", "gone.txt"), "which includes"),
        (INPUT.replace("EALL", "NONE").replace("SKIN", "NONE"), "without a section that has elements"),
        (INPUT.replace(" 3, 4, 1", " 3, x"), r"\*ELSET card cannot be read"),
    ):
        (tmp_path / "wrong.inp").write_text(text)
        refused(said, calculix.Deck, tmp_path / "wrong.inp")


def test_values_are_scaled_in_pieces_that_do_not_depend_on_them(deck):
    groups = {"tip": ("youngs_modulus", [3, 4]), "skin": ("thickness", [9]), "ply": ("youngs_modulus", [9])}
    text = deck.text(groups, {"tip": 2.0, "skin": 1.5, "ply": 0.5})
    cards, sections = text.split("*"), (("SOLID", "MATERIAL=ANT"), ("SHELL", ""))
    tip, skin = (next(c for c in cards if c.startswith(f"{s} SECTION") and m in c) for s, m in sections)
    assert skin.endswith("0.003\n")
    assert "OFFSET=0.5" in skin
    elastic = [c.splitlines()[1:] for c in cards if c.startswith("ELASTIC")]
    assert ["420000000000.0, 0.3, 20.", "380000000000.0, 0.3, 200."] in elastic
    halved = [
        "50000000000.0, 10000000000.0, 15000000000.0, 0.3, 0.3, 0.3, 2000000000.0, 2500000000.0",
        "3000000000.0, 20.",
    ]
    assert halved in elastic
    name = tip.partition("ELSET=")[2].partition(",")[0]
    assert f"*ELSET, ELSET={name}\n3, 4\n" in text
    heads = [[line for line in of.splitlines() if line[0] == "*"] for of in (deck.text(groups, {}), text)]
    assert heads[0] == heads[1]
    step = text[text.index("*STEP") :]
    assert step.startswith("*STEP\n*BOUNDARY\n1, 1, 3\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n*CLOAD\n1,1,0.\n")
    assert "-10." not in text


def test_what_calculix_stores_is_named_by_node_layer_and_knot(tmp_path):
    (tmp_path / "m.dof").write_text("1.1\n1.3\n1.3\n9.2\n")
    (tmp_path / "m.sti").write_text("1 1 5.0e0\n1 2 -1.e0\n2 2 4.e0\n3 3 1.0e0\n4 4 1.0e0\n")
    (tmp_path / "m.mas").write_text("1 1 1.e0\n2 2 1.0e0\n3 3 1.e0\n4 4 1.e0\n")
    stiffness, mass, names = calculix.stored(tmp_path, "m", frozenset({1, 2}))
    assert names == ("1:X", "1:Z", "1:Z, layer 2", "knot 9 2")
    assert stiffness.toarray()[:2, :2].tolist() == [[5.0, -1.0], [-1.0, 4.0]]
    np.testing.assert_array_equal(mass.toarray(), np.eye(4))
    (tmp_path / "m.dof").write_text("1.1\n")
    with pytest.raises(ValueError, match="does not fit the 1 rows"):
        calculix.stored(tmp_path, "m", frozenset({1}))
    assert calculix.errors_in("x *ERROR reading\n *MATERIAL: none") == "*ERROR reading *MATERIAL: none"


def test_calculix_input_is_written_with_its_steps(deck, tmp_path):
    tip = ar.TermGroup("tip", "youngs_modulus", 2.1e11, ((0, 1),), (), np.array([3, 4]))
    skin = ar.TermGroup("skin", "thickness", 0.002, ((1, 1),), (), np.array([9]))
    terms = {"tip": np.eye(1), "skin": np.eye(1)}
    model = ar.MatrixModel(3.0 * np.eye(1), np.eye(1), stiffness_terms=terms, groups=[tip, skin])
    now = model.with_group_factors({"tip": 0.5})
    new = ar.write_model(tmp_path / "new.inp", tmp_path / "plate.inp", now)
    text = new.read_text()
    assert text.startswith("** Values of groups by antires_rs\n")  # so that the command may write it again
    assert "105000000000.0, 0.3, 20." in text
    assert all(each in text for each in ("*STATIC\n", "*CLOAD\n1, 3, -10.\n", "*NODE FILE\nU\n", "\n0.002\n"))
    again = calculix.Deck(new)
    assert [again.value("youngs_modulus", [e]) for e in (1, 3, 4)] == [2.1e11, 1.05e11, 1.05e11]
    (tmp_path / "plate.inp").write_text(INPUT.replace("2.1E+11", "2.0E+11"))
    refused("'tip'; wanted 210000000000.0, as", ar.write_model, new, tmp_path / "plate.inp", now)


# -- CalculiX itself: a plate of shells with a rib of solids' kind, and a block of solids


BRICK = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]  #: Corners.


def block(moduli=(2.1e11, 1.0e11), rho=7850.0, cells=(4, 2, 6)):
    """Hexahedra on a clamped foot, the upper half a set of its own; and an MPC that ties two corners."""
    nx, ny, nz = cells
    places = product(range(nz + 1), range(ny + 1), range(nx + 1))
    number = {place[::-1]: n for n, place in enumerate(places, 1)}
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{n}, {0.05 * i}, {0.04 * j}, {0.06 * k}" for (i, j, k), n in number.items()]
    element = 0
    for name, layers in (("LOW", range(nz // 2)), ("HIGH", range(nz // 2, nz))):
        lines.append(f"*ELEMENT, TYPE=C3D8I, ELSET={name}")
        for k, j, i in product(layers, range(ny), range(nx)):
            element += 1
            lines.append(", ".join(map(str, (element, *(number[i + a, j + b, k + c] for a, b, c in BRICK)))))
    lines += ["*ELSET, ELSET=EALL", "LOW, HIGH", "*ELSET, ELSET=TOP", f"{element - 3}, {element - 2}"]
    for name, modulus in zip(("LOW", "HIGH"), moduli, strict=True):
        lines += [f"*MATERIAL, NAME=M{name}", "*ELASTIC", f"{modulus:.10e}, 0.3", "*DENSITY", f"{rho:.10e}"]
        lines.append(f"*SOLID SECTION, ELSET={name}, MATERIAL=M{name}")
    one, other = number[0, 0, nz], number[nx, 0, nz]
    lines += ["*EQUATION", "2", f"{one},2,1.,{other},2,-1.", "*BOUNDARY"]
    lines += [f"{number[i, j, 0]}, 1, 3" for i in range(nx + 1) for j in range(ny + 1)]
    return "\n".join(lines) + "\n", number


def ribbed(thickness=0.02, nx=3, ny=2):
    """A clamped plate of shells with a rib across it."""
    lines, number, elements = ["*NODE, NSET=NALL"], {}, {"SKIN": [], "RIB": []}

    def node(i, j, k):
        if (i, j, k) not in number:
            number[i, j, k] = len(number) + 1
            lines.append(f"{number[i, j, k]}, {0.1 * i}, {0.1 * j}, {0.08 * k}")
        return number[i, j, k]

    around = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    for i, j in product(range(nx), range(ny)):
        elements["SKIN"].append([node(2 * i + a, 2 * j + b, 0) for a, b in around])
    elements["RIB"] = [[node(2 * i + a, ny, b) for a, b in around] for i in range(nx)]
    for name, rows in elements.items():
        lines.append(f"*ELEMENT, TYPE=S8R, ELSET={name}")
        first = 1 if name == "SKIN" else 1 + nx * ny
        lines += [", ".join(map(str, (nth, *row))) for nth, row in enumerate(rows, first)]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "2.1e11, 0.3", "*DENSITY", "7850."]
    for name, t in (("SKIN", thickness), ("RIB", 0.015)):
        lines += [f"*SHELL SECTION, ELSET={name}, MATERIAL=STEEL", f"{t:.10e}"]
    lines += ["*BOUNDARY", *(f"{n}, 1, 6" for (i, _, _), n in number.items() if i == 0)]
    return "\n".join(lines) + "\n", number


def calculix_hz(text, folder, supports="", n_modes=10):
    """Frequencies that CalculiX itself finds, with further supports."""
    step = f"*STEP\n*FREQUENCY\n{n_modes}\n*END STEP\n"
    (folder / "own.inp").write_text(text + supports + step)
    subprocess.run(["ccx", "-i", "own"], cwd=folder, check=True, capture_output=True)
    rows = [line.split() for line in (folder / "own.dat").read_text().splitlines()]
    return np.array([float(row[3]) for row in rows if len(row) == 5 and row[0].isdigit()])[:n_modes]


def calculix_matrices(text, folder):
    """Stiffness and mass of a run of CalculiX with this input, not by read_model."""
    (folder / "alone.inp").write_text(text + "*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n*END STEP\n")
    subprocess.run(["ccx", "-i", "alone"], cwd=folder, check=True, capture_output=True)
    n = len((folder / "alone.dof").read_text().split())
    parts = (np.loadtxt(folder / f"alone.{ending}") for ending in ("sti", "mas"))
    return [completed(p[:, 0] - 1, p[:, 1] - 1, p[:, 2], n).tocsr() for p in parts]


@needs_calculix
def test_terms_of_calculix_against_its_own_runs_with_other_moduli(tmp_path):
    text, _ = block()
    (tmp_path / "block.inp").write_text(text)
    groups = {"low": "LOW", "high": "HIGH", "all": "EALL:density"}
    model = ar.read_model(tmp_path / "block.inp", groups=groups, out=tmp_path / "block.npz")
    terms = model.description.recipe.stiffness_terms
    whole = sum(term.sparse(model.n_dof) for term in terms)  # all elements are in a group: nothing is left
    assert largest(whole, model.stiffness()) < 1e-12
    assert model.default_elements == [0, 1]
    rng = np.random.default_rng(1)
    worst = []
    for low, high, all_ in rng.uniform(0.5, 2.0, (SETS, 3)).round(4):
        stiffness, mass = calculix_matrices(block((low * 2.1e11, high * 1.0e11), all_ * 7850.0)[0], tmp_path)
        made = model.with_group_factors({"low": low, "high": high, "all": all_})
        worst.append((largest(made.stiffness(), stiffness), largest(made.mass(), mass)))
    assert np.max(worst) < 1e-9, np.max(worst, axis=0)
    # A part of a section, in a model of its own.
    top = ar.read_model(tmp_path / "block.inp", groups=["TOP"])
    changed = ar.read_model(tmp_path / "block.inp", groups=["TOP", "LOW"]).with_group_factors({"TOP": 0.5})
    assert largest(changed.stiffness(), top.with_group_factors({"TOP": 0.5}).stiffness()) < 1e-12
    assert 0 < top.groups["TOP"].elements.size < 3


@needs_calculix
def test_frequencies_and_dips_are_those_of_calculix(tmp_path):
    text, number = block()
    (tmp_path / "block.inp").write_text(text)
    model = ar.read_model(tmp_path / "block.inp", groups="elset")
    np.testing.assert_allclose(model.modes(10).freq_hz, calculix_hz(text, tmp_path), rtol=1e-6)
    rng = np.random.default_rng(2)
    free = [n for (i, j, k), n in number.items() if 0 < k < 6 and i + j > 0]
    for node in rng.choice(free, 10, replace=False):
        for axis in (1, 2):  # a dof that is held: its frequencies are the antiresonances of the driven point
            held = calculix_hz(text, tmp_path, f"{node}, {axis}, {axis}\n", 6)
            name = f"{node}:{axis}"
            dips = model.antiresonances(name, name, f_max_hz=held[-1] * 1.001, include_cancelled=True)
            np.testing.assert_allclose(dips, held, rtol=1e-6)


@needs_calculix
def test_thickness_of_shells_is_a_polynomial(tmp_path):
    text, number = ribbed()
    (tmp_path / "plate.inp").write_text(text)
    groups = {"skin": "SKIN:thickness", "rib": "RIB"}
    model = ar.read_model(tmp_path / "plate.inp", groups=groups)
    assert not model.groups["skin"].linear
    np.testing.assert_allclose(model.modes(5).freq_hz, calculix_hz(text, tmp_path, n_modes=5), rtol=1e-6)
    rng = np.random.default_rng(3)
    for factor in rng.uniform(0.6, 1.6, SETS).round(3):
        (tmp_path / "other.inp").write_text(ribbed(factor * 0.02)[0])
        own = ar.read_model(tmp_path / "other.inp", groups=["RIB"])
        made = model.with_group_factors({"skin": factor})
        assert largest(made.stiffness(), own.stiffness()) < 1e-6
        assert largest(made.mass(), own.mass()) < 1e-6
    node = number[6, 1, 0]  # the node itself, not a layer of the shell
    held = calculix_hz(text, tmp_path, f"{node}, 3, 3\n", 4)
    limits = {"f_max_hz": held[-1] * 1.001, "include_cancelled": True}
    np.testing.assert_allclose(model.antiresonances(*[f"{node}:Z"] * 2, **limits), held, rtol=1e-6)


@needs_calculix
def test_a_run_of_the_input_that_was_written_has_our_frequencies(tmp_path):
    for text, groups, factors in (
        (block()[0], {"low": "LOW", "rho": "EALL:density"}, {"low": 0.83, "rho": 1.07}),
        (block()[0], {"top": "TOP"}, {"top": 0.4}),
        (ribbed()[0], {"skin": "SKIN:thickness", "rib": "RIB"}, {"skin": 1.13, "rib": 0.7}),
    ):
        (tmp_path / "read.inp").write_text(text)
        now = ar.read_model(tmp_path / "read.inp", groups=groups).with_group_factors(factors)
        new = ar.write_model(tmp_path / "new.inp", tmp_path / "read.inp", now)
        own = calculix_hz(new.read_text(), tmp_path, n_modes=5)
        np.testing.assert_allclose(now.modes(5).freq_hz, own, rtol=1e-6)


def steady_state(text, folder, force, nodes, band_hz, n_modes, lines):
    """Frequencies, and undamped steady-state responses (x, y, z) of nodes, of CalculiX itself.

    It superposes modes, and finds a fifth of what a model has at most: blocks apart, far above, make all
    those of the structure the lowest fifth.
    """
    points, elements, held = [], [], []
    for nth in range(24):
        own = range(10_001 + 8 * nth, 10_009 + 8 * nth)
        points += [f"{n}, {9 + 3 * nth + x}, {y}, {z}" for n, (x, y, z) in zip(own, BRICK, strict=True)]
        elements.append(", ".join(map(str, (10_001 + nth, *own))))
        held += [f"{n}, 1, 3" for n in own[:4]]
    material = ["*MATERIAL, NAME=FAR", "*ELASTIC", "1e16, 0.", "*DENSITY", "1."]
    section = "*SOLID SECTION, ELSET=FAR, MATERIAL=FAR"
    cards = ["*NODE", *points, "*ELEMENT, TYPE=C3D8, ELSET=FAR", *elements, *material, section]
    cards += ["*BOUNDARY", *held, "*NSET, NSET=SENSORS", *(f"{n}," for n in nodes)]
    cards += ["*STEP", "*FREQUENCY, STORAGE=YES", f"{n_modes}", "*END STEP", "*STEP"]
    cards += ["*STEADY STATE DYNAMICS", f"{band_hz[0]}, {band_hz[1]}, {lines}, 1.", "*CLOAD"]
    cards.append(f"{force}, 1, 1.")
    cards += ["*NODE PRINT, NSET=SENSORS", "U", "*END STEP"]
    (folder / "steady.inp").write_text(text + "\n".join(cards) + "\n")
    subprocess.run(["ccx", "-i", "steady"], cwd=folder, check=True, capture_output=True)
    found, rows = {}, None
    for line in (folder / "steady.dat").read_text().splitlines():
        words = line.split()
        if words[:1] == ["displacements"]:
            hz = float(words[-1])
            rows = None if hz in found else found.setdefault(hz, [])  # then the imaginary parts
        elif len(words) == 4 and rows is not None and len(rows) < len(nodes):
            rows.append([float(word) for word in words[1:]])
    return np.array(list(found)), np.array(list(found.values()))


def same_dips(model, force, hz, curves):
    """Holds antiresonances to 1e-6 against the zeros of a code's responses by dof; their number."""
    own_hz = model.modes().freq_hz
    ratios = (hz[:, None] / own_hz[(own_hz > 0.0) & (own_hz < 1.2 * hz[-1])]) ** 2
    off = (np.abs(ratios - 1.0) > 1e-4).all(axis=1)  # a resonance itself is a line too
    hz, smooth = hz[off], np.prod(1.0 - ratios[off], axis=1)  # times a response: no poles in the band
    compared = 0
    for name, response in curves.items():
        curve, dips = response[off] * smooth, []
        for i in np.flatnonzero(curve[1:] * curve[:-1] < 0.0):
            at = slice(max(i - 3, 0), i + 5)
            fit = np.polynomial.Polynomial.fit(hz[at], curve[at], 5)
            roots = fit.roots()[np.isreal(fit.roots())].real
            dips += [root for root in roots if hz[i] <= root <= hz[i + 1]]
        dips = [dip for dip in dips if np.abs(dip / own_hz - 1.0).min() > 1e-6]  # modes without a part in it
        ours = model.antiresonances(name, force, f_max_hz=hz[-1])
        np.testing.assert_allclose(ours[ours > hz[0]], dips, rtol=1e-6, err_msg=name)
        compared += len(dips)
    return compared


@needs_calculix
def test_dips_of_the_steady_state_response_of_calculix(tmp_path):
    text, number = block(cells=(2, 1, 3))
    text = text.replace("C3D8I", "C3D8")
    (tmp_path / "block.inp").write_text(text)
    model = ar.read_model(tmp_path / "block.inp", groups="elset")
    force, tied = number[2, 1, 3], number[0, 0, 3]
    nodes = [n for (_, _, k), n in number.items() if k and n != tied]
    n_modes = sum(k > 0 for _, _, k in number) * 3 - 1
    hz, responses = steady_state(text, tmp_path, force, nodes, (400.0, 8000.0), n_modes, 800)
    chosen = np.random.default_rng(5).permutation(3 * len(nodes))[:20]
    curves = {f"{nodes[n // 3]}:{'XYZ'[n % 3]}": responses[:, n // 3, n % 3] for n in chosen}
    assert same_dips(model, f"{force}:X", hz, curves) > 40


@needs_calculix
def test_the_commands_of_the_page_go_from_the_input_to_the_report(tmp_path, monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    monkeypatch.chdir(tmp_path)
    plate = importlib.import_module("ribbed_plate")
    text, sensors = plate.plate()
    (tmp_path / "plate.inp").write_text(text)
    for seed, (name, damage) in enumerate({"intact": {}, "now": {"R2": 0.6}}.items()):
        record = plate.record(tmp_path, damage, seed)
        names = [f"{sensors[dof][0]}:Z" for dof in record.dofs]
        ar.write_csv(tmp_path / f"{name}.csv", ar.Recording(record.responses, record.fs_hz, dofs=names))
    page = (DOCS / "fe_codes.md").read_text().partition("## From the input to the report")[2]
    commands = page.partition("```console\n")[2].partition("```")[0].splitlines()
    assert len(commands) <= 4
    for line in commands:
        assert antires(line.removeprefix("$ antires ").split()) == 0
    assert "Damage: R2 has lost" in capsys.readouterr().out
    assert "R2" in (tmp_path / "job_results" / "report.html").read_text(encoding="utf-8")


# -- OpenSeesPy itself: a frame in space with rigid floors


@pytest.fixture
def frame(tmp_path):
    (tmp_path / "frame.py").write_text(program_text("frame"))
    (tmp_path / "own_hz.py").write_text(program_text("own_hz"))

    def own_hz(*several):
        call = [sys.executable, "own_hz.py", json.dumps(several)]
        subprocess.run(call, cwd=tmp_path, check=True, capture_output=True)
        return json.loads((tmp_path / "hz.json").read_text())

    return tmp_path / "frame.py", own_hz


@needs_opensees
def test_terms_of_opensees_against_its_own_runs(frame):
    script, own_hz = frame
    groups = {"columns": "e_columns", "beams": "e_beams", "rho": "rho"}
    model = ar.read_model(f"{script}:build", groups=groups)
    assert model.groups["columns"].value == 3.0e10
    assert all(group.linear for group in model.groups.values())
    rng = np.random.default_rng(4)
    sets = [dict(zip(groups, each, strict=True)) for each in rng.uniform(0.5, 2.0, (SETS, 3))]
    usual = {"e_columns": 3e10, "e_beams": 2.5e10, "rho": 225.0}
    nominal, *others = own_hz({}, *({own: usual[own] * s[k] for k, own in groups.items()} for s in sets))
    np.testing.assert_allclose(model.modes(9).freq_hz, nominal, rtol=1e-9)
    for s, own in zip(sets, others, strict=True):
        np.testing.assert_allclose(model.with_group_factors(s).modes(9).freq_hz, own, rtol=1e-8)
    # The driven point of the upper floor, held: its frequencies are the antiresonances.
    held = own_hz({"held": 1})[0][:6]
    dips = model.antiresonances("1003:X", "1003:X", f_max_hz=held[-1] * 1.001)
    assert all(np.min(np.abs(np.asarray(held) / hz - 1.0)) < 1e-6 for hz in dips)
    assert model.dof("2000:uz") >= 0  # a node on a rigid link may have a sensor


@needs_opensees
def test_elements_and_polynomials_of_opensees(frame):
    script, own_hz = frame
    elements = {f"story {k}": [10 * k + c for c in range(1, 5)] for k in (1, 2, 3)}
    model = ar.read_model(script, groups=elements)
    assert [model.element_label(i) for i in model.default_elements] == list(elements)
    assert model.groups["story 2"].mass_powers == ((1, 1),)
    three = model.with_parameters(ar.stiffness_factor(list(elements), bounds=(0.1, 2.0)), [1.3] * 3)
    np.testing.assert_allclose(three.modes(9).freq_hz, own_hz({"e_columns": 1.3 * 3.0e10})[0], rtol=1e-9)
    deep = ar.read_model(f"{script}:build", groups=["depth"])
    assert sorted(power for _, power in deep.groups["depth"].stiffness_powers) == [1, 3]
    for factor in (0.6, 0.85, 1.4):
        freq_hz = deep.with_group_factors({"depth": factor}).modes(9).freq_hz
        np.testing.assert_allclose(freq_hz, own_hz({"depth": 0.3 * factor})[0], rtol=1e-6)
    refused("the model has no element 77", ar.read_model, script, groups={"a": [77]})
    refused("has no argument 'e'", ar.read_model, f"{script}:build", groups="e")
    refused('Name the function: "frame.py:build"', ar.read_model, script, groups="depth")
    refused("no function 'made'", ar.read_model, f"{script}:made", groups="depth")


@needs_opensees
def test_a_script_of_opensees_is_written_with_other_defaults(frame, tmp_path):
    script, own_hz = frame
    groups = {"columns": "e_columns", "beams": "e_beams"}
    model = ar.read_model(f"{script}:build", groups={"columns": "e_columns"})
    now = model.with_parameters(ar.stiffness_factor("columns", bounds=(0.5, 1.5)), 0.87)
    (tmp_path / "new").mkdir()
    new = ar.write_model(tmp_path / "new" / "updated.py", f"{script}:build", now)
    again = ar.read_model(f"{new}:build", groups=groups)
    assert again.groups["columns"].value == 0.87 * 3.0e10
    own = own_hz({"e_columns": 0.87 * 3.0e10})[0]
    np.testing.assert_allclose(again.modes(9).freq_hz, own, rtol=1e-9)
    np.testing.assert_allclose(now.modes(9).freq_hz, own, rtol=1e-9)
    assert ar.read_model(new, groups={"storey": [11, 12]}).n_dof == again.n_dof
    # With the name of its source in another folder it is imported as well, and the source by it.
    same = ar.write_model(tmp_path / "new" / "frame.py", f"{script}:build", now)
    assert ar.read_model(f"{same}:build", groups=groups).groups["columns"].value == 0.87 * 3.0e10
    (same.parent / "own_hz.py").write_text((tmp_path / "own_hz.py").read_text())
    subprocess.run([sys.executable, "own_hz.py", "[{}]"], cwd=same.parent, check=True, capture_output=True)
    assert json.loads((same.parent / "hz.json").read_text()) == [own]
    elements = ar.read_model(script, groups={"storey": [11, 12]})
    halved = elements.with_group_factors({"storey": 0.5})
    refused("elements of 'storey'", ar.write_model, tmp_path / "a.py", f"{script}:build", halved)


@needs_opensees
def test_dips_of_the_steady_state_response_of_opensees(frame, tmp_path):
    """Static answers of OpenSees under K - omega^2 M, which it forms of its own elements."""
    script, _ = frame
    massless = script.with_name("massless.py")
    massless.write_text(script.read_text().replace("rho=225.0", "rho=0.0"))
    model = ar.read_model(f"{massless}:build", groups=["e_columns", "e_beams"])
    (tmp_path / "steady.py").write_text(program_text("steady"))
    nodes = [10 * k + c for k in (1, 2, 3) for c in (1, 2, 3, 4)]
    places = np.random.default_rng(6).permutation(6 * len(nodes))[:17]
    dofs = [(nodes[n // 6], int(n % 6) + 1) for n in places] + [(1001, 2), (1003, 6), (2000, 1)]
    hz = np.linspace(0.6, 1.05 * model.modes().freq_hz.max(), 500)
    request = json.dumps({"hz": hz.tolist(), "force": 1003, "dofs": dofs})
    call = [sys.executable, "steady.py", request]
    subprocess.run(call, cwd=tmp_path, check=True, capture_output=True)
    responses = np.array(json.loads((tmp_path / "steady.json").read_text()))
    names = [f"{node}:{('X', 'Y', 'Z', 'RX', 'RY', 'RZ')[axis - 1]}" for node, axis in dofs]
    assert same_dips(model, "1003:X", hz, dict(zip(names, responses.T, strict=True))) > 40
