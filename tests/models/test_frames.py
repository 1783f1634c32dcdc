"""Frames: dof numbering, supports, sections, virtual tests, pictures, and requests that cannot be."""

import re

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import antires_rs as ar
from antires_rs import exceptions
from antires_rs.figures.marks import beside
from antires_rs.figures.updating import plot_differences
from tests.support.tolerances import AGAINST_SCIPY, BEAM_HZ, EIGH, RIGID_FORCE

STEEL = (2.1e11, 7850.0)
PIPE = ar.Tube(0.038, 0.0015, *STEEL)
BAR = ar.Rectangle(0.03, 0.01, *STEEL)
NODES = [(0.0, 0.0), (0.5, 0.0), (1.0, 0.1), (1.0, 0.6), (1.4, 0.3)]
ELEMENTS = [(0, 1), (1, 2), (2, 3), (2, 4)]
#: What the legend says of the numbers in a picture.
NUMBERED = ("number of an element", "number of a node")


def frame(**options):
    return ar.FrameModel(NODES, ELEMENTS, PIPE, **options)


def cantilever(n, columns=2, section=PIPE):
    nodes = np.zeros((n + 1, columns))
    nodes[:, 0] = np.linspace(0.0, 1.0, n + 1)
    return ar.FrameModel(nodes, [(i, i + 1) for i in range(n)], section, fixed=[0])


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


def test_matrices_are_sparse_symmetric_and_those_of_the_eigenproblem():
    model = frame(
        fixed=[0], point_masses=[ar.PointMass(3, 2.0, 0.01)], ground_springs=[ar.GroundSpring(4, "v", 5e4)]
    )
    stiffness, mass = model.stiffness(), model.mass()
    assert scipy.sparse.issparse(stiffness)
    assert (stiffness != stiffness.T).nnz == (mass != mass.T).nnz == 0
    omega2 = scipy.linalg.eigh(stiffness.toarray(), mass.toarray(), eigvals_only=True)
    found = (2 * np.pi * model.modes().freq_hz) ** 2
    np.testing.assert_allclose(found, omega2, atol=EIGH * omega2[-1])


@pytest.mark.parametrize("columns", [2, 3])
def test_a_cantilever_in_plane_and_space(columns):
    model = cantilever(20, columns)
    area = np.pi * 0.0015 * (0.038 - 0.0015)
    inertia = area * (0.038**2 + 0.035**2) / 16
    roots = np.array([1.875104068711961, 4.694091132974175])
    exact = roots**2 / (2 * np.pi) * np.sqrt(STEEL[0] * inertia / (STEEL[1] * area))
    found = model.modes().freq_hz
    found = found[:2] if columns == 2 else found[[0, 2]]  # both planes in space
    np.testing.assert_allclose(found, exact, rtol=5 * BEAM_HZ)


def test_modal_and_pencil_route_agree_with_scipy_on_a_frame():
    model = frame(ground_springs=[(0, "v", 3e3), (4, "v", 3e3), (1, "u", 1e3)])
    k, shaker = model.stiffness().toarray(), model.dof(1, "v")
    m = model.mass().toarray()
    for response in (shaker, model.dof(3, "u"), model.dof(4, "v")):
        rows, cols = np.delete(np.arange(len(k)), response), np.delete(np.arange(len(k)), shaker)
        roots = scipy.linalg.eig(k[np.ix_(rows, cols)], m[np.ix_(rows, cols)], right=False)
        real = np.sort(roots[(np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 0)].real)
        expected = np.sqrt(real) / (2 * np.pi)
        expected = expected[expected < 1500.0]
        for method in ("modal", "pencil"):
            found = model.antiresonances(response, shaker, f_max_hz=1500.0, method=method)
            np.testing.assert_allclose(found, expected, rtol=AGAINST_SCIPY)
    assert len(model.antiresonances([0, 1], shaker)) == 2


def test_a_frame_takes_part_in_virtual_tests():
    model = frame(ground_springs=[(0, "v", 3e3), (4, "v", 3e3), (1, "u", 1e3)])
    shaker, sensors = model.dof(1, "v"), [model.dof(n, "v") for n in (0, 2, 4)]
    record = model.simulate(
        excitation=shaker, responses=sensors, fs_hz=1024.0, duration_s=4.0, damping_ratio=0.01, rng=0
    )
    assert record.dofs == tuple(sensors)
    assert abs(model.frf(sensors, shaker, [10.0, 20.0], damping_ratio=0.01)).shape == (3, 2)


def test_sections_by_name_by_index_and_one_each():
    named = ar.FrameModel(
        NODES,
        [(*pair, "bar" if i == 2 else "pipe") for i, pair in enumerate(ELEMENTS)],
        {"pipe": PIPE, "bar": BAR},
    )
    assert named.element_sections == ["pipe", "pipe", "bar", "pipe"]
    assert named.sections == {"pipe": PIPE, "bar": BAR}
    indexed = ar.FrameModel(NODES, [(*pair, int(i == 2)) for i, pair in enumerate(ELEMENTS)], [PIPE, BAR])
    each = ar.FrameModel(NODES, ELEMENTS, [PIPE, PIPE, BAR, PIPE])
    assert each.element_sections == [0, 0, 1, 0]
    for other in (indexed, each):
        assert (other.stiffness() != named.stiffness()).nnz == 0
    assert named.section_label(1) == "bar"
    assert each.section_label(1) == "section 1"


def test_general_sections_are_those_of_a_tube():
    area, inertia = np.pi * 0.0015 * 0.0365, np.pi / 64 * (0.038**4 - 0.035**4)
    for columns in (2, 3):
        nodes = np.column_stack([NODES, [0.0, 0.1, 0.3, 0.2, 0.0]])[:, :columns]
        general = ar.Section(area, inertia, *STEEL, torsion_m4=2 * inertia)
        a, b = (ar.FrameModel(nodes, ELEMENTS, section) for section in (PIPE, general))
        for one, other in ((a.stiffness(), b.stiffness()), (a.mass(), b.mass())):
            assert abs(one - other).max() < RIGID_FORCE * abs(one).max()


def test_labels_count_from_one_and_name_springs_and_masses():
    model = frame(point_masses=[(2, 1.0)], ground_springs=[(0, "v", 1.0)], node_springs=[(0, 3, 10.0)])
    assert [model.element_label(i) for i in (0, 3, 4, 5)] == [
        "element 0",
        "element 3",
        "ground spring 0 (node 0 v)",
        "node spring 0",
    ]
    assert [model.mass_label(i) for i in (0, 4)] == ["element 0", "mass 0 (node 2)"]
    assert model.default_elements == [0, 1, 2, 3]
    assert repr(model) == "FrameModel(plane, 5 nodes, 4 elements, 15 dofs)"
    assert repr(cantilever(2, 3)) == "FrameModel(space, 3 nodes, 2 elements, 12 dofs)"


def test_a_spring_between_nodes_and_a_joint_leave_rigid_motions_free():
    nodes = [*NODES, NODES[4], (1.8, 0.2)]
    model = ar.FrameModel(
        nodes,
        [*ELEMENTS, (5, 6)],
        PIPE,
        node_springs=[ar.NodeSpring(0, 3, 1e4), *(ar.NodeSpring(4, 5, 1e5, d) for d in ("u", "v", "theta"))],
    )
    motions = np.zeros((model.n_dof, 3))
    for node, (x, y) in enumerate(nodes):
        motions[[model.dof(node, d) for d in ("u", "v", "theta")]] = [[1, 0, -y], [0, 1, x], [0, 0, 1]]
    force = np.abs(model.stiffness() @ motions).max()
    assert force < RIGID_FORCE * abs(model.stiffness()).max()


def test_a_frame_in_two_parts_warns_and_an_unconnected_response_has_no_antiresonance():
    with pytest.warns(ar.AntiresWarning, match=r"2 parts that nothing joins.*\[3, 4\]"):
        model = ar.FrameModel([*NODES[:3], (3, 0), (4, 0)], [(0, 1), (1, 2), (3, 4)], PIPE)
    with pytest.warns(ar.AntiresWarning, match="not connected"):
        assert model.antiresonances(model.dof(3, "v"), model.dof(0, "v")).size == 0


WRONG = {
    "element listed twice": ("elements[4]", lambda: ar.FrameModel(NODES, [*ELEMENTS, (1, 0)], PIPE)),
    "zero-length element": (
        "elements[0]",
        lambda: ar.FrameModel([(0, 0), (0, 0), (1, 0)], [(0, 1), (1, 2)], PIPE),
    ),
    "no element": ("elements", lambda: ar.FrameModel(NODES, [], PIPE)),
    "node outside": ("elements[0]", lambda: ar.FrameModel(NODES, [(0, 9)], PIPE)),
    "node a fraction": ("elements[0]", lambda: ar.FrameModel(NODES, [(0, 0.5)], PIPE)),
    "three nodes": ("elements[0]", lambda: ar.FrameModel(NODES, [(0, 1, 2, 3)], PIPE)),
    "loose node": ("nodes_m", lambda: ar.FrameModel([*NODES, (9, 9)], ELEMENTS, PIPE)),
    "one column": ("nodes_m", lambda: ar.FrameModel([[0.0], [1.0]], [(0, 1)], PIPE)),
    "NaN node": ("nodes_m", lambda: ar.FrameModel([(0, 0), (np.nan, 1)], [(0, 1)], PIPE)),
    "everything fixed": ("fixed", lambda: frame(fixed=range(5))),
    "fixed direction": ("fixed[0]", lambda: frame(fixed=[(0, "w")])),
    "fixed by a number": ("fixed[0]", lambda: frame(fixed=[(0, 1)])),
    "fixed text": ("fixed", lambda: frame(fixed="0")),
    "wall too thick": (
        "sections[0].thickness_m",
        lambda: ar.FrameModel(NODES, ELEMENTS, ar.Tube(0.03, 0.016, *STEEL)),
    ),
    "wall as text": (
        "sections['pipe'].thickness_m",
        lambda: ar.FrameModel(NODES, ELEMENTS, {"pipe": ar.Tube(0.03, "thin", *STEEL)}),
    ),
    "no section": ("elements", lambda: ar.FrameModel(NODES, ELEMENTS, [PIPE, BAR])),
    "unknown section": ("elements[0]", lambda: ar.FrameModel(NODES, [(0, 1, "rod")], {"pipe": PIPE})),
    "section not one": ("sections", lambda: ar.FrameModel(NODES, ELEMENTS, 3)),
    "no torsion in space": (
        "sections[0].torsion_m4",
        lambda: ar.FrameModel(np.eye(3)[:2], [(0, 1)], ar.Section(1e-4, 1e-8, *STEEL)),
    ),
    "orientation in the plane": ("orientation", lambda: frame(orientation=(0, 0, 1))),
    "orientation along": (
        "orientation[0]",
        lambda: ar.FrameModel(np.eye(3)[:2], [(0, 1)], PIPE, orientation=(1, -1, 0)),
    ),
    "negative mass": ("point_masses[0].mass_kg", lambda: frame(point_masses=[(0, -1.0)])),
    "mass nowhere": ("point_masses[0]", lambda: frame(point_masses=[(7, 1.0)])),
    "two inertias": ("point_masses[0].inertia_kg_m2", lambda: frame(point_masses=[(0, 1.0, (1.0, 2.0))])),
    "spring direction": ("ground_springs[0]", lambda: frame(ground_springs=[(0, "x", 1.0)])),
    "spring of nothing": ("ground_springs[0]", lambda: frame(ground_springs=[3])),
    "hidden support": ("node_springs[0]", lambda: frame(node_springs=[ar.NodeSpring(0, 3, 1.0, "v")])),
    "dof outside": ("node", lambda: frame().dof(9, "v")),
    "dof of no name": ("direction", lambda: frame().dof(0, "w")),
    "dof fixed": ("direction", lambda: frame(fixed=[0]).dof(0, "v")),
    "name of no dof": ("dof", lambda: frame().dof_name(15)),
    "values too few": ("values", lambda: frame().plot([1.0, 2.0])),
    "value of no element": ("values", lambda: frame().plot({9: 1.0})),
}


@pytest.mark.parametrize("name", WRONG)
def test_ill_posed_frames(name):
    argument, call = WRONG[name]
    with pytest.raises(exceptions.InvalidInputError, match=rf"^{re.escape(argument)}: got .*; wanted "):
        call()


def test_the_picture_has_every_element_numbered_and_what_it_carries():
    figure = pytest.importorskip("matplotlib.figure")
    model = frame(point_masses=[(2, 1.0)], ground_springs=[(0, "v", 1e3)], fixed=[(3, "u")])
    options = {"sensors": [model.dof(1, "v"), model.dof(4, "u")], "excitation": model.dof(2, "theta")}
    ax = model.plot(ax=figure.Figure().subplots(), **options)
    assert [t.get_text() for t in ax.texts if t.get_text()] == [*"0123", *"01234"]  # elements, nodes
    names = {text.get_text() for text in ax.get_legend().get_texts()}
    assert names == {"point mass", "spring to ground", "partly fixed", "accelerometer", "force", *NUMBERED}
    coloured = model.plot({2: 0.5, 1: 0.1}, ax=figure.Figure().subplots(), label="Stiffness loss")
    assert coloured.figure.axes[1].get_ylabel() == "Stiffness loss"
    shown = [c.get_array() for c in coloured.collections if c.get_array() is not None]
    np.testing.assert_array_equal(shown[0], [0.1, 0.5])
    assert cantilever(3, 3).plot(ax=figure.Figure().subplots(), sensors=[2], excitation=8).get_ylabel() == ""


def test_the_picture_has_springs_between_nodes_and_tells_kinds_of_support_apart():
    figure = pytest.importorskip("matplotlib.figure")
    model = frame(
        node_springs=[(0, 3, 1e4), (1, 4, 2e4)],
        ground_springs=[(4, "v", 1e3)],
        fixed=[0, (4, "u"), (3, "theta")],
    )
    ax = model.plot(ax=figure.Figure().subplots())
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["fixed", "partly fixed", "spring to ground", "node spring", *NUMBERED]
    strokes = [line for line in ax.lines if len(line.get_xdata()) == 1 and line.get_xdata()[0] == NODES[4][0]]
    # Across u; the triangle of the spring is drawn after it and smaller.
    assert [line.get_marker() for line in strokes] == [(2, 2, 0.0), "v"]
    assert strokes[0].get_markersize() > strokes[1].get_markersize()
    coils = [line for line in ax.lines if line.get_marker() == "D"]
    assert [tuple(line.get_xydata()[[0, -1]].ravel()) for line in coils] == [
        (*NODES[0], *NODES[3]),
        (*NODES[1], *NODES[4]),
    ]


def test_nothing_is_light_grey_and_the_scale_of_values_starts_at_nothing():
    figure = pytest.importorskip("matplotlib.figure")
    for values, limits in (
        ([0.2, 0.5, 0.0, 0.4], (0.0, 0.5)),
        ([2.0, 2.5, 2.2, 2.2], (0.0, 2.5)),
        ([0.0, 0.0, 0.0, 0.0], (0.0, 1.0)),
        ([-1.0, 0.0, 0.0, 0.0], (-1.0, 0.0)),
    ):
        ax = frame().plot(values, ax=figure.Figure().subplots())
        shown = next(c for c in ax.collections if c.get_array() is not None)
        assert shown.get_clim() == limits
    light = np.array([shown.cmap(x)[:3] for x in np.linspace(0.0, 1.0, 40)]) @ [0.299, 0.587, 0.114]
    assert light[[0, -1]] == pytest.approx([0.85, 0.04], abs=0.03)
    assert np.all(np.diff(light) < 0.0)


def test_numbers_keep_clear_of_arrows():
    element, lines = np.array([[[0.0, 0.0], [40.0, 0.0]], [[40.0, 0.0], [80.0, 0.0]]]), np.empty((0, 2, 2))
    np.testing.assert_array_equal(beside(element, lines), [[20.0, 7.0], [60.0, 7.0]])
    arrow = np.array([[[20.0, 20.0], [20.0, 0.0]]])
    np.testing.assert_array_equal(beside(element, arrow), [[20.0, -7.0], [60.0, 7.0]])


def test_springs_between_nodes_have_the_values_of_the_state():
    springs = [ar.NodeSpring(0, 3, 1e4), ar.NodeSpring(1, 4, 2e4)]
    model = frame(node_springs=springs, ground_springs=[(4, "v", 1e3)])
    assert model.node_springs == springs
    terms = [*ar.stiffness_reduction([0, 5]), ar.stiffness_factor(6, bounds=(0.5, 2.0))]
    values = ar.AntiresonanceSet(1, {4: [50.0]})
    once = ar.UpdatingProblem(model, terms, values).model_at([0.1, 0.25, 1.5])
    assert [s.stiffness_n_per_m for s in once.node_springs] == [7500.0, 30000.0]
    twice = ar.UpdatingProblem(once, ar.stiffness_reduction([6]), values).model_at([0.5])
    assert [s.stiffness_n_per_m for s in twice.node_springs] == [7500.0, 15000.0]
    # The same as a frame made with these springs.
    rest = frame(node_springs=twice.node_springs, ground_springs=[(4, "v", 1e3)])
    same = ar.UpdatingProblem(rest, ar.stiffness_reduction([0]), values).model_at([0.1])
    scale = abs(same.stiffness()).max()
    np.testing.assert_allclose(twice.stiffness().toarray(), same.stiffness().toarray(), atol=EIGH * scale)


def test_tables_of_a_frame_name_its_dofs_and_damage_takes_few_lines():
    model = frame(ground_springs=[(0, "v", 3e3), (4, "v", 3e3), (1, "u", 1e3)])
    force = model.dof(1, "v")
    sensors = [model.dof(node, name) for node, name in ((3, "u"), (4, "v"), (2, "v"), (0, "u"))]
    any_value = ar.AntiresonanceSet(force, {sensors[0]: [50.0]})
    problem = ar.UpdatingProblem(model, ar.stiffness_reduction([2]), any_value)
    zeros = problem.model_at([0.6]).antiresonances(sensors, force, f_max_hz=1500.0)
    measured = ar.AntiresonanceSet(force, dict(zip(sensors, zeros, strict=True)))
    result = ar.assess_damage(model, measured, rng=0)
    text = result.summary()
    assert re.search(r"element 2 +60\.00 % \u00b1 \S+ %\nall others \(3\): exactly 0\n", text)
    assert "\n3 u, 1 v " in text
    assert result.table.dof_names[force] == "1 v"
    figure = pytest.importorskip("matplotlib.figure", reason="pictures need matplotlib")
    drawn = plot_differences(result.table, ax=figure.Figure().subplots())
    assert {"3 u", "4 v"} <= {label.get_text() for label in drawn.texts}
