"""A structure in space: its mesh in colours of groups or of a value, sensors and force, a motion."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import Argument, reject
from ..io.points import MatchedPoints
from ..models.frame import FrameModel
from ..support.checks import FloatArray, IntArray, members, real_array
from ..support.directions import point_of
from ..support.files import write_atomically
from ..support.messages import some
from .canvas import draw, new_axes
from .marks import SCALE, Arrows, Axis, Faces, Mark, Panel, Scene, Words, xy
from .packing import asset, packed_text, policy, script
from .structure import ISOMETRIC, _value_by_element, forces_of, without_dof

if TYPE_CHECKING:
    from ..models.matrix_model import MatrixModel

__all__ = ["plot_mesh", "write_mesh"]

#: Solids by their numbers of nodes: faces as corners, a triangle with its last one twice.
_TETRAHEDRON = ((0, 1, 2, 2), (0, 1, 3, 3), (1, 2, 3, 3), (2, 0, 3, 3))
_PYRAMID = ((0, 1, 2, 3), (0, 1, 4, 4), (1, 2, 4, 4), (2, 3, 4, 4), (3, 0, 4, 4))
_WEDGE = ((0, 1, 2, 2), (3, 4, 5, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
_BRICK = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_SOLIDS = {4: _TETRAHEDRON, 10: _TETRAHEDRON, 5: _PYRAMID, 13: _PYRAMID, 6: _WEDGE, 15: _WEDGE}
_SOLIDS |= {8: _BRICK, 20: _BRICK, 27: _BRICK}
#: What codes call solids, and lines of three nodes; other elements of three nodes or more are surfaces.
_SOLID = re.compile(r"D?C3D|HEXA|TETRA|PENTA|PYRA|BRICK|WEDGE|SOLID|SSPBRICK", re.IGNORECASE)
_LINE = re.compile(r"B3|T3D|BEAM|BAR|ROD|TRUSS|LINE|SEG|SPRING|LINK", re.IGNORECASE)
LONG, MOVED = 0.12, 0.08  # length of an arrow, and the largest motion, as shares of the structure's size
MOST_MODES, _MOST_MOVES = 8, 400_000  # shapes in a page, and the nodes of all of them together
_MOST_OUTLINED = 6000  # cells of a picture; outlines of more would hide their colours
_LIGHT = np.array([-0.35, 0.62])  # from where it comes across and up, beside from the eye
_UNITS = 4095  # places of nodes in a page, from one end of the longest side to the other


def plot_mesh(
    model: MatrixModel | FrameModel,
    values: Any = None,
    ax: Any = None,
    *,
    sensors: Sequence[int | str] | MatchedPoints = (),
    excitation: int | str | None = None,
    shape: Any = None,
    label: str = "Value by group",
) -> Any:
    """Draw the mesh of a model, seen isometrically.

    :func:`~antires_rs.figures.write_mesh` makes a page where it can be turned.

    Parameters
    ----------
    model : MatrixModel with a mesh, or FrameModel in space
    values : mapping of int or str to float, or array_like, (n_terms,), optional
        Value of each stiffness term, by its number or name, for example ``DamageResult.severity``: light grey
        at 0, dark at the largest. By default the colours tell groups apart.
    sensors, excitation : sequence of int or str, or MatchedPoints, and int or str, optional
        Dofs of accelerometers and force: arrows along their directions, the force's heavier. Those of
        :func:`~antires_rs.match_points` have the names of the points, of which the force may be one; points
        without a dof are named where they were measured, and below the picture with the reason.
    shape : array_like, (n_dof,), optional
        A motion, such as ``model.modes(n_modes=3).shapes[2]``, drawn exaggerated.
    label : str
        Name of the values, with their unit.

    Raises
    ------
    InvalidInputError
        A model without a mesh.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> nodes = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> quad = np.array([[1, 2, 3, 4]])
    >>> mesh = ar.Mesh(np.arange(1, 5), nodes, np.array([1]), quad, ("S4",), np.array([0]))
    >>> model = ar.MatrixModel(np.eye(4), np.eye(4), dofs=[f"{n}:Z" for n in (1, 2, 3, 4)], mesh=mesh)
    >>> ar.figures.plot_mesh(model, sensors=["2:Z"]).get_xlabel()
    'isometric view'
    """
    moved = [] if shape is None else [("", shape)]
    shown = seen(scene(model, values, sensors, excitation, label, moved))
    told = without_dof(sensors)
    shown = replace(shown, x=replace(shown.x, label="\n".join([shown.x.label, *told])))
    return draw(shown, new_axes(ax, (9.0, 5.6)), drop_pt=24.0 + 14.0 * len(told))


def write_mesh(
    model: MatrixModel | FrameModel,
    path: str | os.PathLike[str],
    values: Any = None,
    *,
    sensors: Sequence[int | str] | MatchedPoints = (),
    excitation: int | str | None = None,
    modes: Any = None,
    label: str = "Value by group",
    title: str = "Model",
) -> Path:
    """Write a page with the mesh, to be turned in any browser: one file that asks nothing of any network.

    ``modes``, a :class:`~antires_rs.ModalSet` of all dofs of the model, are shown moving; the rest is as in
    :func:`plot_mesh`.

    Examples
    --------
    >>> import tempfile, pathlib, antires_rs as ar
    >>> tube = ar.Tube(0.05, 0.002, 2.1e11, 7850.0)
    >>> frame = ar.FrameModel([[0, 0, 0], [0, 0, 1], [1, 0, 1]], [[0, 1], [1, 2]], tube, fixed=[0])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     page = ar.figures.write_mesh(frame, pathlib.Path(folder) / "frame.html", modes=frame.modes(4))
    ...     page.stat().st_size < 50_000
    True
    """
    shapes = [] if modes is None else shapes_of(modes)
    told = "".join(f"<br>{escape(line)}" for line in without_dof(sensors))
    block = packed_text(page_data(scene(model, values, sensors, excitation, label, shapes)), 6)
    of = {"policy": policy(), "title": escape(title), "block": block, "script": script()}
    page = Template(asset("mesh.html")).substitute(of, told=told.removeprefix("<br>"))
    return write_atomically(path, page.encode("utf-8"))


def shapes_of(modes: Any) -> list[tuple[str, FloatArray]]:
    """The lowest modes that are no rigid bodies, named."""
    found = [(f"mode {r}, {f:.4g} Hz", np.real(modes.shapes[r])) for r, f in enumerate(modes.freq_hz) if f]
    return found[:MOST_MODES]


def has_mesh(model: Any) -> bool:
    """Whether a model is drawn in space: one with a mesh, or a frame in three dimensions."""
    if isinstance(model, FrameModel):
        return bool(model.nodes_m.shape[1] == 3)
    return getattr(model, "mesh", None) is not None


# -- From a model to what is drawn: places, faces, parts


def scene(
    model: Any,
    values: Any,
    sensors: Sequence[Any] | MatchedPoints = (),
    excitation: Any = None,
    label: str = "Value by group",
    shapes: Sequence[tuple[str, Any]] = (),
    says: Mapping[int, str] | None = None,
) -> Scene:
    """A model in space; ``says`` is what is told of a term when it is pointed at."""
    if not has_mesh(model):
        got = f"{model!r}, which has no mesh"
        reject("model", got, "a model of read_model, or a frame in space", "Give MatrixModel(..., mesh=...).")
    frame = isinstance(model, FrameModel)
    n_terms = len(model.elements) if frame else model._core.n_stiffness_terms
    if isinstance(values, Mapping):
        index = model._recipe.term_index
        values = {index("stiffness_factor", e) if isinstance(e, str) else e: v for e, v in values.items()}
    given = _value_by_element(values, n_terms)
    if frame:
        numbers, places = np.arange(len(model.nodes_m)), np.asarray(model.nodes_m)
        cells = np.column_stack([model.elements, model.elements[:, 1:], model.elements[:, 1:]])
        part, names = np.arange(n_terms), [model.element_label(e) for e in range(n_terms)]
        if given is None:
            names = [model.section_label(i) for i in range(len(model.sections))]
            part = np.array([model.section_index(name) for name in model.element_sections])
    else:
        mesh, groups = model.mesh, list(model.groups.values())
        numbers, places = mesh.nodes, np.asarray(mesh.coordinates, dtype=np.float64)
        names = [group.name for group in groups]
        of_term = {term: i for i, group in enumerate(groups) for term, _ in group.stiffness_powers}
        if given is not None:
            by_group = np.full(len(groups), np.nan)
            for term in np.flatnonzero(np.isfinite(given)).tolist():
                if term in of_term:
                    by_group[of_term[term]] = np.fmax(by_group[of_term[term]], given[term])
            given = by_group
        says = says and {of_term[term]: text for term, text in says.items() if term in of_term}
        cells, part = _cells(mesh, [group.elements for group in groups], given)
    if says is None and given is not None:
        unit = label.rpartition("(")[2].rstrip(")") if label.endswith(")") else ""
        says = {i: f"{given[i]:.3g} {unit}" for i in np.flatnonzero(np.isfinite(given)).tolist()}
    texts = [f"{name}: {(says or {}).get(i, '')}".rstrip(": ") for i, name in enumerate(names)]
    points = [point_of(model.dof_label(dof)) for dof in range(model.n_dof)]
    row = dict(zip(np.asarray(numbers).tolist(), range(len(numbers)), strict=True))
    moved = _moves(row, points, places)
    arrows, words = _arrows(model, sensors, excitation, points, row, places)
    moves = {name: moved(one) for name, one in shapes}
    return Scene(places, cells, part, texts, given, label, arrows, words, moves)


def _arrows(
    model: Any,
    sensors: Any,
    excitation: Any,
    points: Sequence[tuple[int, int] | None],
    row: Mapping[int, int],
    places: FloatArray,
) -> tuple[list[Arrows], list[tuple[str, FloatArray]]]:
    """Of sensors and force; and names with their places, of sensors that were matched by these."""
    size, measured = _size(places), list[int]()
    words: list[tuple[str, FloatArray]] = []
    ends: dict[str, list[tuple[FloatArray, FloatArray]]] = {"accelerometer": [], "force": []}
    forces = forces_of(sensors, excitation)
    if isinstance(sensors, MatchedPoints):
        if astray := sorted({*sensors.nodes.values()} - row.keys()):
            got, remedy = f"points at {some(astray)}", "Call ar.match_points(points, model) with it."
            reject("sensors", got, "points that were matched with nodes of this model", remedy)
        for name, (place, way) in sensors.points.items():
            if name in sensors.unmatched:
                words.append((f"\u00d7 {name}", place))
                continue
            head = places[row[sensors.nodes[name]]]
            ends["accelerometer"].append((head, way))
            upper = 0.0 if (ISOMETRIC @ way)[1] > 0.0 else 0.7 * LONG * size  # a name stands above its arrow
            words.append((str(name), head - upper * way))
    else:
        measured = [model._dof(Argument("sensors").item(i), dof) for i, dof in enumerate(sensors)]
    force = members(model._end("excitation", forces))
    for label, dofs in (("accelerometer", measured), ("force", force)):
        there = [point for point in (points[dof] for dof in dofs) if point is not None and point[0] in row]
        for node, code in there:  # a rotation is an arrow along its axis
            ends[label].append((places[row[node]], np.sign(code) * np.eye(3)[(abs(code) - 1) % 3]))
    arrows = []
    for label, colour, share in (("accelerometer", "vermillion", 0.7), ("force", "black", 1.2)):
        if ends[label]:
            heads, ways = (np.array(each) for each in zip(*ends[label], strict=True))
            tails = heads - share * LONG * size * ways
            arrows.append(Arrows(tails, heads, colour, 1.6 * share, label=label))
    return arrows, words


def _cells(mesh: Any, groups: list[IntArray], values: FloatArray | None) -> tuple[IntArray, IntArray]:
    """Outer faces and lines, (f, 4) rows of nodes, and the group of each, -1 for none.

    A triangle has its last node twice, a line three times. Groups with a value above zero have their own
    faces too, so that they are seen inside others.
    """
    at = np.argsort(mesh.nodes)
    rows = at[np.searchsorted(mesh.nodes, mesh.connectivity, sorter=at) % at.size]
    nodes = np.where(mesh.connectivity >= 0, rows, -1)
    group = np.full(len(mesh.elements), -1)
    order = np.argsort(mesh.elements)
    for i, own in enumerate(groups):
        found = order[np.searchsorted(mesh.elements, own, sorter=order) % max(order.size, 1)]
        group[found[mesh.elements[found] == own]] = i
    used = (nodes >= 0).sum(axis=1)
    cells, parts = [np.empty((0, 4), dtype=np.intp)], [np.empty(0, dtype=np.intp)]
    solids, owners = [np.empty((0, 4), dtype=np.intp)], [np.empty(0, dtype=np.intp)]
    for kind in range(len(mesh.kinds)):
        for n in np.unique(used[mesh.kind == kind]).tolist():
            own = np.flatnonzero((mesh.kind == kind) & (used == n))
            if _SOLID.search(mesh.kinds[kind]) and n in _SOLIDS:
                faces = np.array(_SOLIDS[n])
                solids.append(nodes[own][:, faces].reshape(-1, 4))
                owners.append(np.repeat(group[own], len(faces)))
                continue
            kind_name = mesh.kinds[kind]
            if n == 2 or (n == 3 and _LINE.search(kind_name)):  # the middle node stands between, or last
                corners = [0, n - 1 if kind_name.startswith("B3") else 1]
            else:
                corners = list(range(4 if n in (4, 8, 9) else min(n, 3)))
            cells.append(nodes[own][:, (corners + corners[-1:] * 4)[:4]])
            parts.append(group[own])
    faces, owner = np.concatenate(solids), np.concatenate(owners)
    outer = _once(faces, len(mesh.nodes))
    for i in [] if values is None else np.flatnonzero(np.nan_to_num(values) > 0.0).tolist():
        own = np.flatnonzero(owner == i)
        outer[own] |= _once(faces[own], len(mesh.nodes))
    cells.append(faces[outer])
    parts.append(owner[outer])
    return np.concatenate(cells), np.concatenate(parts)


def _once(faces: IntArray, n: int) -> Any:
    """Which faces belong to one element only; three nodes of a face tell it from all others."""
    # The fourth node of a quad is left out, and the double one of a triangle, so that both sides agree.
    low = np.sort(faces, axis=1)
    low = np.where((low[:, 2] == low[:, 1])[:, None], low[:, [0, 1, 3, 3]], low)
    keys = (low[:, 0].astype(np.int64) * n + low[:, 1]) * n + low[:, 2]
    _, inverse, counts = np.unique(keys, return_inverse=True, return_counts=True)
    return counts[inverse.ravel()] == 1


def _moves(row: dict[int, int], points: list[Any], places: FloatArray) -> Callable[[Any], FloatArray]:
    """From a motion of the dofs to translations of the nodes, (n, 3), the largest a small share of all."""
    known = [(dof, row[p[0]], p[1]) for dof, p in enumerate(points) if p and p[0] in row and abs(p[1]) <= 3]
    dofs, rows, codes = np.array(known, dtype=np.intp).reshape(-1, 3).T

    def moved(shape: Any) -> FloatArray:
        wanted = f"an array ({len(points)},), a motion of each dof"
        values, moves = real_array("shape", shape, ndim=1, wanted=wanted), np.zeros(places.shape)
        if values.size != len(points):
            reject("shape", f"{values.size} values", wanted, "As in model.modes(n_modes=3).shapes[2].")
        np.add.at(moves, (rows, np.abs(codes) - 1), np.sign(codes) * values[dofs])
        largest = float(np.linalg.norm(moves, axis=1).max(initial=0.0))
        return moves * (MOVED * _size(places) / largest) if largest else moves

    return moved


def _size(places: FloatArray) -> float:
    return float(np.ptp(places, axis=0).max()) or 1.0


# -- The same as a picture, and as data for a page


def seen(one: Scene) -> Panel:
    """The scene as a panel, seen isometrically, what is near over what is far."""
    places = one.points + next(iter(one.moves.values()), 0.0)
    eye = np.cross(*ISOMETRIC)
    flat = places @ ISOMETRIC.T
    given = np.full(len(one.texts), np.nan) if one.values is None else one.values
    values = np.append(given, np.nan)[one.part]
    # What is damaged is seen through what hides it.
    order = np.lexsort([(places @ eye)[one.cells].mean(axis=1), values > 0.0])
    cells, part = one.cells[order], one.part[order]
    line = cells[:, 1] == cells[:, 2]
    bare = part < 0 if one.values is None else np.isnan(values[order])
    colours = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in one.colours])[part] / 255.0
    # Lit as in the page, from the upper left.
    normal = np.cross(places[cells[:, 1]] - places[cells[:, 0]], places[cells[:, 2]] - places[cells[:, 0]])
    normal *= np.where(normal @ eye < 0.0, -1.0, 1.0)[:, None]
    lit = normal @ (0.7 * eye + _LIGHT @ ISOMETRIC) / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    light = np.where(line, np.where(bare, 0.47, 1.0), 0.74 + 0.26 * np.maximum(lit, 0.0))
    widths = np.where(line, np.where(bare, 1.0, 3.2), 0.25 if len(cells) < _MOST_OUTLINED else 0.0)
    marks: list[Mark] = [Faces(flat[cells], colours * light[:, None], widths, one.values, one.scale)]
    for each in one.arrows:
        tails, heads = each.tails @ ISOMETRIC.T, each.heads @ ISOMETRIC.T
        marks.append(replace(each, tails=tails, heads=heads, halo=True))
    if named := one.named(places):
        x, y = xy(np.array([place for _, place in named]) @ ISOMETRIC.T)
        marks.append(Words(x, y, [text for text, _ in named], away=6.0, halo=True))
    return Panel("model", Axis("isometric view", at=[]), Axis("", at=[]), marks, equal=True)


def page_data(one: Scene) -> str:
    """The scene as JSON for ``assets/scene.js``: whole numbers, rows as differences to those above."""
    used, cells = np.unique(one.cells, return_inverse=True)
    cells = cells.reshape(one.cells.shape)
    low = one.points[used].min(axis=0)
    scale = _UNITS / _size(one.points[used])

    def whole(values: Any) -> Any:
        return np.diff(np.rint(values).astype(np.int64), axis=0, prepend=0).ravel().tolist()

    def placed(values: Any) -> Any:
        return np.round(scale * (np.asarray(values) - low), 1).tolist()

    most = max(1, _MOST_MOVES // used.size)
    data = {
        "scene": 1,
        "points": whole(scale * (one.points[used] - low)),
        "cells": whole(cells),
        "parts": whole(one.part[:, None]),
        "texts": one.texts,
        "colours": one.colours,
        "bare": [] if one.values is None else np.isnan(one.values).tolist(),
        "hit": [] if one.values is None else (np.nan_to_num(one.values) > 0.0).tolist(),
        "scale": [] if one.values is None else [one.scale, *one.span, *SCALE],
        "named": [[text, *placed(place)] for text, place in one.named(one.points)],
        "arrows": [
            {"tails": placed(a.tails), "heads": placed(a.heads)}
            | {"colour": a.colour, "width": a.width, "label": a.label}
            for a in one.arrows
        ],
        "moves": {name: whole(scale * moves[used]) for name, moves in list(one.moves.items())[:most]},
    }
    return json.dumps(data, separators=(",", ":"))
