"""Models from runs of finite-element codes: terms, checks, what is kept; CalculiX and OpenSeesPy themselves."""

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app.main import main as antires
from antires_rs.io import calculix
from tests.support.refusals import refused

needs_calculix = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not on PATH")
needs_opensees = pytest.mark.skipif(
    importlib.util.find_spec("openseespy") is None, reason="openseespy is not installed"
)
SETS = 20  # random sets of values, each against a run of the code with them


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
    refused("the stiffness term 'rib'.*one of 'web'", model.element, "rib")
    refused("no straight line in its value", model.element, "skin")
    refused("a number: its terms have no names", ar.MassSpringChain([1.0, 2.0], [5.0]).element, "web")
    refused("an unknown group; wanted factors by group: 'web'", model.with_group_factors, {"rib": 2.0})
    refused(r"factors\['web'\]: got 0.0", model.with_group_factors, {"web": 0.0})
    assert model.with_group_factors({}) is model


def test_what_is_no_sum_of_terms_is_refused_with_what_is_left():
    def curved(angle=0.5):
        return np.array([[np.cosh(6.0 * angle)]]), np.eye(1)

    def product(e=2.0, t=3.0):
        return np.array([[e * t**3 + 1.0]]), np.eye(1)

    def still(e=2.0):
        return np.array([[1.0]]), np.eye(1)

    def growing(n=2.0):
        return np.eye(int(n)), np.eye(int(n))

    refused(
        r"groups\['angle'\].*no polynomial in its value: .* is left", ar.read_model, curved, groups="angle"
    )
    refused("do not add up", ar.read_model, product, groups=["e", "t"])
    refused("a value that changes neither", ar.read_model, still, groups=["e"])
    refused("dofs stay the same", ar.read_model, growing, groups=["n"])
    refused("an argument of the function", ar.read_model, still, groups=["x"])
    refused("groups: got none", ar.read_model, still, groups=[])
    refused("a list of such", ar.read_model, still, groups=3)
    refused("code='calculix' takes", ar.read_model, still, groups="e", code="calculix")
    refused(r"\.inp of CalculiX", ar.read_model, "model.bdf", groups="e")
    refused("how the code is run", ar.read_model, "model.bdf", groups="e", code="command")
    refused("in a folder that exists", ar.read_model, still, groups="e", out="model.mat")


# -- Any code by a command: here a program that writes Matrix Market files

PROGRAM = """
    import pathlib, sys, time

    lines = [line.split() for line in open(sys.argv[1])]
    given = dict(line for line in lines if len(line) == 2)
    folder = given.pop("log")
    values = {name: float(value) for name, value in given.items()}
    with open(folder + "/log.txt", "a") as log:
        log.write("run\\n")
    time.sleep(values.get("sleep", 0.0))
    if values["web"] > 1e3:
        sys.exit("web out of range")
    k = [values["web"] + 3.0 * values["skin"], -values["web"], values["web"] + 0.2 * values["skin"] ** 3]
    for name, (a, b, c) in {"K": k, "M": (1.0, 0.0, 2.0)}.items():
        head = "%%MatrixMarket matrix coordinate real symmetric\\n2 2 3\\n"
        pathlib.Path(name + ".mtx").write_text(f"{head}1 1 {a!r}\\n2 1 {b!r}\\n2 2 {c!r}\\n")
"""
GROUPS = {"web": 100.0, "skin": 4.0}


@pytest.fixture
def program(tmp_path):
    """Its input with places for values, and the command."""
    (tmp_path / "code.py").write_text(textwrap.dedent(PROGRAM))
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


def test_a_command_that_fails_is_told(program, tmp_path):
    source, command = program
    refused("without {rib}", ar.read_model, source, groups={"rib": 1.0}, command=command)
    refused(
        "the command left no file.*web out of range",
        ar.read_model,
        source,
        groups=GROUPS | {"web": 2e3},
        command=command,
    )
    refused(
        "which is not there. Correct command=",
        ar.read_model,
        source,
        groups=GROUPS,
        command="no_such_code {input}",
    )
    refused("a finite number", ar.read_model, source, groups={"web": "WEB"}, command=command)


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
    assert antires([*call, "web=100", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [(row["name"], row["linear"]) for row in data["groups"]] == [("web", True)]
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


# -- CalculiX: its input, without the code

INPUT = """\
*HEADING
A plate ** and what it is
*INCLUDE, INPUT=mesh.txt
*Elset, elset=Tip, generate
 3, 4, 1
*ELSET, ELSET=BOTH
Tip, 2
*MATERIAL, NAME=Steel
*ELASTIC
 2.1E+11, 0.3, 20.
 1.9E+11, 0.3, 200.
*DENSITY
7850.
*MATERIAL, NAME=PLY
*ELASTIC, TYPE=ENGINEERING CONSTANTS
1.e11, 2.e10, 3.e10, 0.3, 0.3, 0.3, 4.e9, 5.e9
6.e9, 20.
*SOLID SECTION, ELSET=EALL, MATERIAL=Steel
*SHELL SECTION, ELSET=SKIN, MATERIAL=PLY,
OFFSET=0.5
0.002
*STEP
*STATIC
*CLOAD
1, 3, -10.
*BOUNDARY
1, 1, 3
*NODE FILE
U
*END STEP
"""
MESH = """\
*NODE
1, 0., 0., 0.
2, 1., 0.
3, 1., 1., 0.
4, 0., 1., 0.
*ELEMENT, TYPE=C3D4, ELSET=EALL
1, 1, 2, 3, 4
2, 1, 2, 3,
4
3, 1, 2, 3, 4
4, 1, 2, 3, 4
*ELEMENT, TYPE=S4, ELSET=SKIN
9, 1, 2, 3, 4
"""


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
    assert (mesh.nodes.tolist(), mesh.elements.tolist(), mesh.kinds) == (
        [1, 2, 3, 4],
        [1, 2, 3, 4, 9],
        ("C3D4", "S4"),
    )
    np.testing.assert_array_equal(mesh.place(2), [1.0, 0.0, 0.0])
    refused("a node of the mesh", mesh.place, 7)
    assert deck.value("youngs_modulus", [1, 3]) == 2.1e11
    assert deck.value("youngs_modulus", [1, 9]) is None
    assert deck.value("thickness", [9]) == 0.002
    refused("thickness of a \\*SOLID SECTION", deck.value, "thickness", [1])
    refused("density of the material 'PLY'", deck.value, "density", [9])
    refused("one of EALL, SKIN, TIP, BOTH, STEEL", deck.elements_of, "WEB")
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
    cards = text.split("*")
    tip, skin = (
        next(c for c in cards if c.startswith(f"{s} SECTION") and m in c)
        for s, m in (("SOLID", "MATERIAL=ANT"), ("SHELL", ""))
    )
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
    plain = deck.text(groups, {})
    assert [line for line in plain.splitlines() if line[0] == "*"] == [
        line for line in text.splitlines() if line[0] == "*"
    ]
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
    assert calculix.errors_in("x *ERROR reading\n *MATERIAL: none") == "*ERROR reading"


def test_groups_of_calculix_share_no_elements(tmp_path, deck, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))  # no CalculiX
    plate = tmp_path / "plate.inp"
    refused("'Tip' and 'BOTH', which share 2", ar.read_model, plate, groups=["Tip", "BOTH"])
    refused("one of 'youngs_modulus', 'density', 'thickness'", ar.read_model, plate, groups="Tip:mass")
    refused("elements that have a section", ar.read_model, plate, groups={"a": [77]})
    with pytest.raises(ar.MissingDependencyError, match="apt install calculix-ccx"):
        ar.read_model(plate, groups="Tip")
