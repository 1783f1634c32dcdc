"""Frames: dof numbering, supports, sections, pictures, and requests that cannot be."""

import re
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from tests.models.shared import rigid_force, same_matrices
from tests.support.refusals import refused
from tests.support.snapshots import refusal, replay
from tests.support.tolerances import RIGID_FORCE

STEEL = (2.1e11, 7850.0)
PIPE = ar.Tube(0.038, 0.0015, *STEEL)
BAR = ar.Rectangle(0.03, 0.01, *STEEL)
NODES = [(0.0, 0.0), (0.5, 0.0), (1.0, 0.1), (1.0, 0.6), (1.4, 0.3)]
ELEMENTS = [(0, 1), (1, 2), (2, 3), (2, 4)]
HANGERS = [(0, "v", 3e3), (4, "v", 3e3), (1, "u", 1e3)]
NUMBERED = ("number of an element", "number of a node")  #: What the legend says of the numbers in a picture.


def frame(nodes=NODES, elements=ELEMENTS, sections=PIPE, **options):
    return ar.FrameModel(nodes, elements, sections, **options)


def cantilever(n, columns=2):
    nodes = np.zeros((n + 1, columns))
    nodes[:, 0] = np.linspace(0.0, 1.0, n + 1)
    return frame(nodes, [(i, i + 1) for i in range(n)], fixed=[0])


def test_dofs_are_numbered_node_by_node_and_fixed_ones_left_out():
    model = frame(fixed=[(0, "v"), 3])
    assert model.n_dof == 15 - 4
    assert [model.dof_name(i) for i in range(4)] == ["node 0 u", "node 0 theta", "node 1 u", "node 1 v"]
    for dof in range(model.n_dof):
        _, node, direction = model.dof_name(dof).split()
        assert model.dof(int(node), direction) == dof
    assert model.fixed == [(0, "v"), (3, "u"), (3, "v"), (3, "theta")]
    space = cantilever(2, 3)
    assert [space.dof(1, name) for name in ("u", "v", "w", "rx", "ry", "rz")] == list(range(6))
    assert frame(fixed=[(0, ("u", "v"))]).n_dof == frame(fixed=[(0, "u"), (0, "v"), (0, "u")]).n_dof


def test_sections_by_name_by_index_and_one_each():
    elements = [(*pair, "bar" if i == 2 else "pipe") for i, pair in enumerate(ELEMENTS)]
    named = frame(elements=elements, sections={"pipe": PIPE, "bar": BAR})
    assert named.element_sections == ["pipe", "pipe", "bar", "pipe"]
    assert named.sections == {"pipe": PIPE, "bar": BAR}
    indexed = frame(elements=[(*pair, int(i == 2)) for i, pair in enumerate(ELEMENTS)], sections=[PIPE, BAR])
    each = frame(sections=[PIPE, PIPE, BAR, PIPE])
    assert each.element_sections == [0, 0, 1, 0]
    for other in (indexed, each):
        same_matrices(other, named, within=0.0)
    assert (named.section_label(1), each.section_label(1)) == ("bar", "section 1")


@pytest.mark.parametrize("columns", [2, 3])
def test_general_sections_are_those_of_a_tube(columns):
    area, inertia = np.pi * 0.0015 * 0.0365, np.pi / 64 * (0.038**4 - 0.035**4)
    nodes = np.column_stack([NODES, [0.0, 0.1, 0.3, 0.2, 0.0]])[:, :columns]
    general = ar.Section(area, inertia, *STEEL, torsion_m4=2 * inertia)
    same_matrices(frame(nodes), frame(nodes, sections=general), within=RIGID_FORCE)


def test_labels_are_those_of_arguments_and_name_springs_and_masses():
    model = frame(point_masses=[(2, 1.0)], ground_springs=[(0, "v", 1.0)], node_springs=[(0, 3, 10.0)])
    labels = ["element 0", "element 3", "ground spring 0 (node 0 v)", "node spring 0"]
    assert [model.element_label(i) for i in (0, 3, 4, 5)] == labels
    assert [model.mass_label(i) for i in (0, 4)] == ["element 0", "mass 0 (node 2)"]
    assert model.default_elements == [0, 1, 2, 3]
    assert repr(model) == "FrameModel(plane, 5 nodes, 4 elements, 15 dofs)"
    assert repr(cantilever(2, 3)) == "FrameModel(space, 3 nodes, 2 elements, 12 dofs)"


def test_a_spring_between_nodes_and_a_joint_leave_rigid_motions_free():
    joint = [ar.NodeSpring(4, 5, 1e5, direction) for direction in ("u", "v", "theta")]
    springs = [ar.NodeSpring(0, 3, 1e4), *joint]
    model = frame([*NODES, NODES[4], (1.8, 0.2)], [*ELEMENTS, (5, 6)], node_springs=springs)
    assert rigid_force(model) < RIGID_FORCE
    with pytest.warns(ar.AntiresWarning, match=r"2 parts that nothing joins.*\[3, 4\]"):
        frame([*NODES[:3], (3, 0), (4, 0)], [(0, 1), (1, 2), (3, 4)])


def test_ill_posed_frames():
    replay(Path(__file__).with_name("wrong_frames.txt"), lambda call: refusal(eval(call)))


def picture():
    return pytest.importorskip("matplotlib.figure").Figure().subplots()


def test_the_picture_has_every_element_numbered_and_what_it_carries():
    springs = {"ground_springs": [(0, "v", 1e3), (1, "theta", 9.0)], "node_springs": [(0, 3, 1e4)]}
    model = frame(point_masses=[(2, 1.0)], fixed=[(3, "u")], **springs)
    options = {"sensors": [model.dof(1, "v"), model.dof(4, "u")], "excitation": model.dof(2, "theta")}
    ax = model.plot(ax=picture(), **options)
    assert [t.get_text() for t in ax.texts if t.get_text()] == [*"0123", *"01234"]  # elements, nodes
    names = {text.get_text() for text in ax.get_legend().get_texts()}
    held = {"point mass", "spring to ground", "node spring", "partly fixed"}
    assert names == {*held, "accelerometer", "force", *NUMBERED}
    assert cantilever(3, 3).plot(ax=picture(), sensors=[2], excitation=8).get_ylabel() == ""


def test_tables_of_a_frame_name_its_dofs_and_damage_takes_few_lines():
    model = frame(ground_springs=HANGERS)
    force = model.dof(1, "v")
    sensors = [model.dof(node, name) for node, name in ((3, "u"), (4, "v"), (2, "v"), (0, "u"))]
    damaged = model.with_parameters(ar.stiffness_reduction([2]), [0.6])
    zeros = damaged.antiresonances(sensors, force, f_max_hz=1500.0)
    measured = ar.AntiresonanceSet(force, dict(zip(sensors, zeros, strict=True)))
    result = ar.assess_damage(model, measured, rng=0)
    text = result.summary()
    assert re.search(r"element 2 +60\.00 % \u00b1 \S+ %\nall others \(3\): exactly 0\n", text)
    assert "\n3 u, 1 v " in text
    assert result.table.dof_names[force] == "1 v"


def test_a_fixed_dof_is_said_to_be_fixed_by_whatever_name():
    beam = ar.FrameModel(
        [(0, 0), (1, 0), (2, 0)], [(0, 1), (1, 2)], ar.Tube(0.05, 0.002, 2e11, 7850.0), fixed=[0]
    )
    seen = ar.AntiresonanceSet("2 v", {"1 v": [40.0]})
    for name in ("0:v", "node 0 v", "0 uy"):
        refused(r"^response: got .*, which is fixed; wanted a free dof", beam.antiresonances, name, "1 v")
        refused(r"^excitation: got .*, which is fixed", beam.antiresonances, "1 v", name)
        refused(
            r"^excitation: got .*, which is fixed",
            ar.assess_damage,
            beam,
            seen.relabelled(name, {"1 v": "1 v"}),
        )
        refused(
            r"^measured dof: got .*, which is fixed",
            ar.assess_damage,
            beam,
            seen.relabelled("2 v", {"1 v": name}),
        )


def test_sections_that_were_merged_are_counted_and_named():
    bars = [ar.Rectangle(0.05, height, 2e11, 7850.0) for height in (0.01, 0.01, 0.012)]
    beam = ar.FrameModel([(k, 0) for k in range(4)], [(k, k + 1) for k in range(3)], bars, fixed=[0])
    factors = ar.youngs_modulus(range(3), bounds=(0.9, 1.1), relative=True)
    words = (
        "^sections: got 2; wanted a section of the model: 0, 1. 3 elements share these, .*stiffness_factor"
    )
    refused(words, beam.with_parameters, factors, [1.0, 1.0, 1.0])
