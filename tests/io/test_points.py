"""Measured points find their nodes, and mistakes in them their names."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import unsuitable

RNG = np.random.default_rng(31)
#: 10,000 nodes of a box girder that is not symmetric, numbered from 1000.
PLACES = np.column_stack(
    [RNG.uniform(0, 20, 10_000), RNG.uniform(0, 3, 10_000) ** 1.2, RNG.uniform(0, 1.5, 10_000)]
)
NODES = {1000 + i: tuple(place) for i, place in enumerate(PLACES)}
CHOSEN = RNG.choice(10_000, 200, replace=False)
WAYS = ["+X", "-X", "+Y", "-Y", "+Z", "-Z"]
POINTS = {
    f"{1000 + i}{WAYS[n % 6]}": (*(PLACES[i] + RNG.uniform(-0.01, 0.01, 3)), WAYS[n % 6])
    for n, i in enumerate(CHOSEN)
}


def moved(change):
    return {name: (*change(np.array(row[:3])), row[3]) for name, row in POINTS.items()}


def test_two_hundred_sensors_on_ten_thousand_nodes():
    exact = {name: (*PLACES[int(name[:-2]) - 1000], row[3]) for name, row in POINTS.items()}
    matched = ar.match_points(exact, NODES)
    assert matched.dofs == {name: f"{name[:-2]}:{name[-1]}" for name in POINTS}
    assert all(
        matched.weights[dof][name] == (-1.0 if "-" in name else 1.0) for name, dof in matched.dofs.items()
    )
    grid = np.stack(np.meshgrid(np.arange(100), np.arange(20), np.arange(5)), axis=-1).reshape(-1, 3) * 0.2
    some = RNG.choice(len(grid), 200, replace=False)
    shaken = {f"s{i}": (*(grid[i] + RNG.uniform(-0.05, 0.05, 3)), "+Z") for i in some}
    assert ar.match_points(shaken, grid).dofs == {f"s{i}": f"{i}:Z" for i in some}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda x: 1e3 * x, "if they are in mm;"),
        (lambda x: x / 0.0254, "if they are in inches;"),
        (lambda x: 1e-3 * x, "in km, or the nodes in mm;"),
        (lambda x: x * [1, -1, 1], "if they have Y mirrored;"),
        (lambda x: x[[0, 2, 1]], "if they have axes XZY for XYZ;"),
        (lambda x: 1e3 * x[[2, 1, 0]] * [1, 1, -1], "in mm and have axes"),
    ],
)
def test_wrong_units_and_axes_are_named(change, said):
    unsuitable(said, ar.match_points, moved(change), NODES, tolerance_m=0.02)
    with pytest.warns(ar.AntiresWarning, match="away"):
        assert len(ar.match_points(moved(change), NODES, tolerance_m=0.02, check=False).unmatched) > 150


def test_swapped_channels_and_unmatched_points_are_named():
    points = dict(POINTS)
    a, b = (next(name for name in points if name.endswith(way)) for way in ("+X", "-Z"))
    points[a], points[b] = (*points[b][:3], "+X"), (*points[a][:3], "-Z")
    points["lost"] = (25.0, 0.0, 0.0, "+X")
    points["askew"] = (*PLACES[0], (1.0, 1.0, 0.0))
    said = "look exchanged.*'lost': nearest node .* m away.*lies between axes"
    with pytest.warns(ar.AntiresWarning, match=said):
        matched = ar.match_points(points, NODES, tolerance_m=0.02)
    assert f"{min(a, b)!r} and {max(a, b)!r} look exchanged" in matched.notes[0]
    assert set(matched.unmatched) == {"lost", "askew"}


def test_a_sensor_that_stands_askew_is_turned():
    turn = np.linalg.qr(RNG.standard_normal((3, 3)))[0]
    motion = RNG.standard_normal((3, 50))
    points = {f"ch{i}": (0.5, 0.0, 0.0, turn[i]) for i in range(3)}
    matched = ar.match_points(points, [[0, 0], [0.5, 0]])
    record = matched.apply(ar.Recording(turn @ motion, 100.0, dofs=list(points)))
    assert record.dofs == ("1:X", "1:Y", "1:Z")
    np.testing.assert_allclose(record.responses, motion, atol=1e-12)


def test_a_table_and_a_frame(tmp_path):
    bar = ar.Rectangle(width_m=0.04, height_m=0.008, youngs_modulus_pa=2.1e11, density_kg_per_m3=7850)
    frame = ar.FrameModel(
        [[0, 0], [0, 0.5], [0, 1.0]], [[0, 1, "bar"], [1, 2, "bar"]], {"bar": bar}, fixed=[0]
    )
    table = tmp_path / "points.csv"
    table.write_text("name,x [mm],y [mm],z [mm],direction\ntop,2,1001,0,u\nmid,0,499,0,-x\n")
    matched = ar.match_points(table, frame)
    assert matched.dofs == {"top": "2:X", "mid": "1:X"}
    assert [frame.dof(2, "u"), frame.dof(1, "u")] == [frame._dof("dof", dof) for dof in matched.dofs.values()]
    table.write_text("sensor,x\n")
    unsuitable("columns name, x, y, z, direction", ar.match_points, table, frame)


@pytest.mark.parametrize("number", [15, 2411])
@pytest.mark.parametrize("per_m", [1.0, 1000.0])
def test_nodes_of_a_universal_file(tmp_path, number, per_m):
    pytest.importorskip("pyuff")
    record = ar.Recording(RNG.standard_normal((3, 64)), 100.0, dofs=["1+Z", "2-Y", "9+X"])
    file = ar.write_uff(tmp_path / "a.unv", record)
    nodes = {1: (0.0, 0.0, 0.0), 2: (0.5, 0.0, 0.0), 9: (0.5, 0.25, 0.0)}
    form = "{:10d}         0         0         1{:13.5E}{:13.5E}{:13.5E}"
    if number == 2411:
        form = "{:10d}         1         1        11\n{:25.16E}{:25.16E}{:25.16E}"
    rows = "\n".join(form.format(node, *(per_m * x for x in xyz)) for node, xyz in nodes.items())
    rows = rows.replace("E", "D" if number == 2411 else "E")
    units = f"         1SI                          2\n{per_m:25.16E}{1.0:25.16E}{1.0:25.16E}\n{0.0:25.16E}"
    sets = "".join(f"    -1\n{kind:6d}\n{text}\n    -1\n" for kind, text in ((164, units), (number, rows)))
    file.write_bytes(sets.encode() + file.read_bytes())
    matched = ar.match_points(file, {70 + node: xyz for node, xyz in nodes.items()})
    assert matched.dofs == {"1+Z": "71:Z", "2-Y": "72:Y", "9+X": "79:X"}
    assert ar.match_points({"a": (0.5, 0.25, 0.0, "+X")}, file).dofs == {"a": "9:X"}
    turned = matched.apply(ar.read_uff(file))
    np.testing.assert_allclose(turned.responses[1], -record.responses[1], rtol=1e-6)
