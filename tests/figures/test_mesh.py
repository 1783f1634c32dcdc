"""Meshes: outer faces of every kind of element, groups and values, the picture, and the page in a browser."""

import gzip
import json
import re
from base64 import b64decode

import numpy as np
import pytest

import antires_rs as ar
from tests.support.browser import Watched, browser
from tests.support.meshed import meshed_chain
from tests.support.refusals import refused

pytest.importorskip("matplotlib", reason="pictures need matplotlib")

from antires_rs.figures.mesh import page_data, scene, seen

#: Corners of a brick; nodes of one or two elements by the code's name, and their outer faces and lines.
BRICKS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
KINDS = {
    "C3D8": ([[0, 1, 2, 3, 4, 5, 6, 7]], 6),
    "CHEXA": ([[0, 1, 2, 3, 4, 5, 6, 7]], 6),
    "C3D4": ([[0, 1, 2, 5], [0, 2, 7, 5]], 6),  # of eight faces two are one inside
    "wedge": ([[0, 1, 3, 4, 5, 7], [1, 2, 3, 5, 6, 7]], 8),
    "S4": ([[0, 1, 2, 3]], 1),
    "S3": ([[0, 1, 2], [0, 2, 3]], 2),
    "B31": ([[0, 1], [1, 2]], 2),
    "B32": ([[0, 1, 2]], 1),
}


def meshed(kind, cells, groups=()):
    numbers = np.arange(101, 109)  # as a code numbers them
    connectivity = np.array([[101 + node for node in cell] for cell in cells])
    tags, kinds = 7 + np.arange(len(cells)), np.zeros(len(cells), dtype=int)
    mesh = ar.Mesh(numbers, BRICKS.astype(float), tags, connectivity, (kind,), kinds)
    dofs = [f"{node}:{axis}" for node in (101, 107) for axis in "XYZ"]
    terms = {name: np.eye(6) for name, _ in groups}
    named = [(name, ((i, 1),), tags[own]) for i, (name, own) in enumerate(groups)]
    made = [ar.TermGroup(name, "density", 1.0, powers, (), own) for name, powers, own in named]
    return ar.MatrixModel(np.eye(6), np.eye(6), stiffness_terms=terms, groups=made, mesh=mesh, dofs=dofs)


@pytest.mark.parametrize("kind", KINDS)
def test_outer_faces_of_every_kind_and_the_ends_of_lines(kind):
    cells, count = KINDS[kind]
    found = scene(meshed(kind, cells), None)
    assert len(found.cells) == count
    line = found.cells[:, 1] == found.cells[:, 2]
    assert line.all() == kind.startswith("B3")
    if kind == "B32":
        assert found.cells[0, :2].tolist() == [0, 2]
    assert found.cells.min() >= 0


def test_a_damaged_group_has_faces_of_its_own_inside_the_others():
    cells, _ = KINDS["wedge"]
    model = meshed("wedge", cells, [("core", [0]), ("rest", [1])])
    assert len(scene(model, {"rest": 0.0}).cells) == 8
    found = scene(model, {"core": 20.0, "rest": 0.0}, label="Loss (%)")
    assert len(found.cells) == 9  # the one between both is seen from the core
    assert found.texts == ["core: 20 %", "rest: 0 %"]
    assert found.colours[0] == "#050B16"
    assert found.colours[1] == "#DADADA"


def test_arrows_motions_and_whole_numbers_of_a_page():
    model = meshed("C3D8", KINDS["C3D8"][0])
    shape = np.array([0.0, 0.0, 0.0, 3.0, 0.0, -4.0])  # node 107, of index 6
    found = scene(model, None, ["107:X"], "101:Z", shapes=[("mode 0", shape)])
    sensor, force = found.arrows
    assert np.allclose(sensor.heads, [[1, 1, 1]])
    assert np.allclose((sensor.heads - sensor.tails)[0, 1:], 0.0)
    assert (force.heads - force.tails)[0, 2] > (sensor.heads - sensor.tails)[0, 0] > 0.0
    moves = found.moves["mode 0"]
    assert np.allclose(moves[6], 0.08 * np.array([0.6, 0.0, -0.8]))
    assert not np.delete(moves, 6, axis=0).any()
    data = json.loads(page_data(found))
    cells = np.cumsum(np.reshape(data["cells"], (-1, 4)), axis=0)
    places = np.cumsum(np.reshape(data["points"], (-1, 3)), axis=0)
    assert cells.tolist() == found.cells.tolist()
    assert np.allclose(places / 4095, BRICKS, atol=1e-3)
    refused(r"shape: got 5 values", scene, model, None, shapes=[("", shape[:5])])
    refused("no mesh", ar.figures.plot_mesh, ar.MatrixModel(np.eye(2), np.eye(2)))


def test_matched_points_are_arrows_with_names_and_others_are_told_where_they_were_measured(tmp_path):
    model = meshed("C3D8", KINDS["C3D8"][0], [("core", [0]), ("rest", [])])
    given = {"tip": (1.0, 1.0, 1.0, "-X"), "hammer": (0.0, 0.0, 0.0, "Z"), "door": (9.0, 0.0, 0.5, "Z")}
    with pytest.warns(ar.AntiresWarning, match="'door': nearest node 10[12] is"):
        matched = ar.match_points(given, model, tolerance_m=0.1)
    found = scene(model, None, matched, "hammer")
    sensors, force = found.arrows
    assert sensors.heads.tolist() == [[1, 1, 1], [0, 0, 0]]
    ways = np.sign((sensors.heads - sensors.tails).round(9))
    assert ways.tolist() == [[-1, 0, 0], [0, 0, 1]]
    assert force.heads.tolist() == [[0, 0, 0]]
    assert [text for text, _ in found.named(found.points)] == ["tip", "hammer", "\u00d7 door"]
    assert found.words[2][1].tolist() == [9.0, 0.0, 0.5]
    reason = f"\u00d7 door: {matched.unmatched['door']}"
    ax = ar.figures.plot_mesh(model, sensors=matched, excitation="hammer")
    assert ax.get_xlabel() == f"isometric view\n{reason}"
    page = ar.figures.write_mesh(
        model, tmp_path / "mesh.html", sensors=matched, excitation="door"
    ).read_text()
    assert f"<figcaption>{reason}</figcaption>" in page
    assert len(scene(model, None, matched, "door").arrows) == 1  # the force is one of those without a dof


def test_several_forces_may_be_matched_points_and_nodes_of_another_model_are_refused():
    model = meshed("C3D8", KINDS["C3D8"][0], [("core", [0]), ("rest", [])])
    matched = ar.match_points({"tip": (1.0, 1.0, 1.0, "-X"), "hammer": (0.0, 0.0, 0.0, "Z")}, model)
    for forces in (["tip", "hammer"], ("101:Z", "107:X")):
        _, force = scene(model, None, matched, forces).arrows
        assert sorted(force.heads.tolist()) == [[0, 0, 0], [1, 1, 1]]
    other = ar.match_points({"tip": (1.0, 1.0, 1.0, "X")}, {7: (1.0, 1.0, 1.0)})
    refused("sensors: got points at 7; wanted points that were matched", scene, model, None, other)


@pytest.mark.parametrize("space", [False, True])
def test_frames_show_matched_points_by_their_names(space):
    nodes = [(0.0, y, 0.0)[: 2 + space] for y in (0.0, 1.0, 2.0)]
    bar = ar.Rectangle(0.01, 0.02, 2.1e11, 7800.0)
    model = ar.FrameModel(nodes, [(0, 1, "bar"), (1, 2, "bar")], {"bar": bar}, fixed=[0])
    given = {"tip": (0.0, 2.0, 0.0, "X"), "hammer": (0.0, 1.0, 0.0, "X"), "door": (5.0, 2.0, 0.0, "X")}
    with pytest.warns(ar.AntiresWarning, match="'door'"):
        matched = ar.match_points(given, model, tolerance_m=0.1)
    ax = model.plot(sensors=matched, excitation="hammer")
    assert ax.get_xlabel().split("\n")[1] == f"\u00d7 door: {matched.unmatched['door']}"
    assert {"tip", "hammer", "\u00d7 door"} <= {text.get_text() for text in ax.texts}
    assert {"accelerometer", "force"} <= {*ax.get_legend_handles_labels()[1]}


def test_a_picture_has_what_is_far_first_and_damage_last():
    (faces, *_) = seen(scene(meshed_chain(), {4: 55.0, 1: 0.0}, label="Loss (%)")).marks
    assert np.allclose(faces.colours[-1] * 255, [5, 11, 22])
    ax = meshed_chain().plot({"spring 4": 55.0}, sensors=["3:Z"], excitation=0, label="Loss (%)")
    assert [text.get_text() for text in ax.texts if text.get_text()] == ["spring 4: 55 %"]
    assert ax.get_legend_handles_labels()[1] == ["accelerometer", "force"]


def test_a_report_has_the_mesh_with_losses_and_probabilities_and_modes_beside(tmp_path):
    case, model = ar.cases.chain8(), meshed_chain()
    result = ar.assess_damage(model, case.exact(1), baseline=case.exact(0), rng=0)
    result.report(tmp_path / "report.html", modes=case.exact_modes(level=1))
    page = (tmp_path / "report.html").read_text()
    assert "Measured modes, which were not fitted" in page
    blocks = re.findall(r'class="packed">([^<]+)<', page)
    scenes = [json.loads(gzip.decompress(b64decode(block))) for block in blocks]
    (shown,) = [one for one in scenes if "scene" in one]
    assert shown["texts"][4].startswith("spring 4: 55.0 % (53.8")
    assert shown["texts"][4].endswith("probability above 99.9 %")
    assert list(shown["moves"])[0].startswith("mode 1, ")


def test_the_page_is_turned_read_and_moved_in_a_browser(tmp_path):
    model = meshed_chain()
    file = tmp_path / "mesh.html"
    looks = {"sensors": ["3:Z"], "excitation": "1:Z", "modes": model.modes()}
    ar.figures.write_mesh(model, file, {4: 55.0, 1: 0.0}, label="Loss (%)", **looks)
    with browser() as chromium:
        page = chromium.new_page(viewport={"width": 500, "height": 700})
        watched = Watched(page)
        page.goto(file.as_uri())
        page.wait_for_selector("#figure-model[data-ms]")
        canvas = page.locator("canvas")
        picture = "document.querySelector('canvas').toDataURL()"
        page.get_by_text(
            "Reset"
        ).click()  # Chromium 148 smooths a few pixels of the very first arrows otherwise
        first = page.evaluate(picture)
        box = canvas.bounding_box()
        middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0] + 60, middle[1] + 20, steps=3)
        page.mouse.up()
        page.wait_for_function(f"first => {picture} !== first", arg=first)
        page.get_by_text("Reset").click()
        page.wait_for_function(f"first => {picture} === first", arg=first)
        said = set()
        for share in np.linspace(0.05, 0.95, 60):
            for up in np.linspace(0.2, 0.8, 40):
                page.mouse.move(box["x"] + share * box["width"], box["y"] + up * box["height"])
            said.add(page.locator("#figure-model > div").last.text_content())
        page.select_option("select", index=1)
        page.wait_for_function(f"first => {picture} !== first", arg=first)
        assert watched.elsewhere == []
        assert watched.wrong == []


def test_dofs_that_are_not_there_are_named_as_they_were_given():
    model = meshed("S4", KINDS["S4"][0])
    for given, said in (({"sensors": ["109:Z"]}, r"sensors\[0\]"), ({"excitation": "109:Z"}, "excitation")):
        refused(said, ar.figures.plot_mesh, model, **given)
    arrows = [mark for mark in seen(scene(model, None, ["101:Z"], "107:X")).marks if hasattr(mark, "tails")]
    assert [mark.halo for mark in arrows] == [True, True]  # seen on dark faces
