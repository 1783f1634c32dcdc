"""Measured points on the nodes of a model: by coordinates and direction, from a table or a universal file."""

from __future__ import annotations

import csv
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations, permutations, product
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError, part, reject
from ..signals.recording import Recording
from ..support.checks import FloatArray, IntArray, finite_scalar, real_array
from ..support.directions import DIRECTIONS, NAMES, point_of
from ..support.messages import some, warn
from ..support.values import FrozenDict, ReadOnly
from .common import Signal, existing_file, unsuitable
from .own_format import relabelled
from .registry import format_by_ending
from .uff import functions_of, nodes_of
from .units import Unit

__all__ = ["MatchedPoints", "match_points"]

_AXES = "XYZ"
_MOST_DEG = 15.0  # so far a sensor may stand off its axis
_SCALES = {1e-3: "in mm", 1e-2: "in cm", 0.0254: "in inches", 0.3048: "in feet"}
_SCALES |= {1e3: "in km, or the nodes in mm"}
_ALL, _MORE = 0.9, 0.2  # share of points that a mistake has to explain, and how much more than none does


@dataclass(frozen=True, eq=False)
class MatchedPoints(ReadOnly):
    """Where measured points are on a model.

    Attributes
    ----------
    nodes : mapping
        Node of each point by its name; of its position, whatever its direction is.
    distance_m : mapping
        How far from it the point was given.
    weights : mapping
        By dof of the model, ``"1204:Z"``, the channels that make it: of a sensor along an axis itself, 1.0 or
        -1.0; of sensors that stand askew their part in it.
    unmatched : mapping
        Why a point has no dof, by its name.
    notes : tuple of str
        What looks exchanged or doubled.
    points : mapping
        Place (3,) in m, and direction (3,) of length 1, as each point was given.

    Examples
    --------
    >>> import antires_rs as ar
    >>> nodes = {7: (0.0, 0.0, 0.0), 9: (0.5, 0.0, 0.0)}
    >>> matched = ar.match_points({"tip": (0.501, 0.0, 0.0, "-Z"), "base": (0.0, 0.001, 0.0, "+X")}, nodes)
    >>> matched.dofs
    {'tip': '9:Z', 'base': '7:X'}
    >>> record = ar.Recording([[1.0, 2.0, 4.0], [0.0, 0.5, 0.0]], 8.0, dofs=["tip", "base"])
    >>> matched.apply(record).responses[0]
    array([-1., -2., -4.])
    """

    nodes: Mapping[Any, int]
    distance_m: Mapping[Any, float]
    weights: Mapping[str, Mapping[Any, float]]
    unmatched: Mapping[Any, str]
    notes: tuple[str, ...] = ()
    points: Mapping[Any, tuple[FloatArray, FloatArray]] = field(default_factory=dict, repr=False)

    @property
    def dofs(self) -> dict[Any, str]:
        """The dof of each channel that stands along an axis."""
        return {next(iter(of)): dof for dof, of in self.weights.items() if len(of) == 1}

    def apply(self, signal: Signal) -> Signal:
        """A recording at dofs of the model, turned into its axes; channels without a dof are left out."""
        if not isinstance(signal, Recording):  # FRFs: names alone, as long as nothing has to be turned
            return relabelled(signal, [self._plain(name) for name in signal.dofs])
        names = list(signal.dofs)
        there = {dof: of for dof, of in self.weights.items() if set(of) <= set(names)}
        if not there:
            wanted = f"some of {some(self.nodes)}"
            reject("signal", f"channels {some(names)}", wanted, "Name the channels alike.")
        row = dict(zip(names, signal.responses, strict=True))
        rows = [sum(w * row[name] for name, w in of.items()) for of in there.values()]
        return Recording(np.stack(rows), signal.fs_hz, list(there), signal.force, signal.time_s)

    def _plain(self, name: Any) -> str | None:
        dof = self.dofs.get(name)
        if dof is not None and self.weights[dof][name] < 0.0:
            got = f"FRFs of {name!r}, which points backwards"
            reject("signal", got, "a recording", "Turn its sign first.")
        return dof


def match_points(
    points: Any, nodes: Any, *, tolerance_m: float | None = None, check: bool = True
) -> MatchedPoints:
    """Find the node, and the direction, of every measured point.

    Parameters
    ----------
    points : mapping or path-like
        By name ``(x, y, z, direction)`` in m, the direction as ``"+X"``, ``"-z"``, ``"v"`` or a vector. Or a
        table (CSV) with the columns name, x, y, z, direction, whose headers may have a unit, ``x [mm]``. Or a
        universal file with functions and nodes (datasets 58, and 15, 781 or 2411), in m by its dataset 164.
    nodes : mapping, (n, 3) or (n, 2) array, path-like, or model
        Coordinates in m by number of the node, or of nodes 0, 1, ...; of a universal file; of a model.
    tolerance_m : float, optional
        Farthest node in m. Default: half of the usual distance of neighbouring nodes, at least 1 % of the
        structure.
    check : bool
        False takes the coordinates as they are, however few of them lie at a node.

    Returns
    -------
    MatchedPoints
        Its ``dofs`` are those of models and jobs.

    Raises
    ------
    UnsuitableDataError
        Points that lie at nodes only in another unit, with mirrored or exchanged axes, or shifted.
    InvalidInputError
        Values that are no coordinates or directions.

    Warns
    -----
    AntiresWarning
        Points without a dof, and names that look exchanged: each lies at the node of the other.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.match_points({"tip": (0.501, 0.0, 0.0, "-Z")}, [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)]).dofs
    {'tip': '1:Z'}
    """
    from scipy.spatial import cKDTree

    given = _points(points)
    numbers, places = _nodes(nodes)
    names = list(given)
    at = np.array([given[name][0] for name in names]).reshape(-1, 3)
    tree, extent = cKDTree(places), float(np.ptp(places, axis=0).max())
    near = np.asarray(tree.query(places, k=2)[0])[:, 1] if len(places) > 1 else np.zeros(1)
    usual = max(0.5 * float(np.median(near)), 0.01 * extent)
    reach = usual if tolerance_m is None else finite_scalar("tolerance_m", tolerance_m, low=0.0, unit="m")
    distance, nearest = map(np.asarray, tree.query(at))
    if check and np.mean(distance <= reach) < _ALL and len(at) > 2:
        _explain(at, places, tree, reach)
    inside = distance <= reach
    unmatched = {
        name: f"nearest node {numbers[nearest[i]]} is {distance[i]:.3g} m away"
        for i, name in enumerate(names)
        if not inside[i]
    }
    node = {name: int(numbers[nearest[i]]) for i, name in enumerate(names) if inside[i]}
    weights, notes = _directed({name: (node[name], given[name][1]) for name in node}, unmatched)
    notes += _exchanged(node, numbers)
    if unmatched or notes:
        why = [f"{name!r}: {reason}" for name, reason in unmatched.items()]
        warn("points_without_dof", f"points: {'; '.join([*notes, some(why, 6)] if why else notes)}.")
    far = {name: float(distance[i]) for i, name in enumerate(names)}
    made = {dof: FrozenDict(of) for dof, of in weights.items()}
    found = FrozenDict(node), FrozenDict(far), FrozenDict(made), FrozenDict(unmatched)
    return MatchedPoints(*found, tuple(notes), FrozenDict(given))


def _points(points: Any) -> dict[Any, tuple[FloatArray, FloatArray]]:
    """Place and direction of each point."""
    if isinstance(points, str | os.PathLike):
        file = existing_file(points)
        points = _of_universal(file) if format_by_ending(file.name) == "uff" else _of_table(file)
    if not isinstance(points, Mapping) or not points:
        wanted = "a mapping from names to (x, y, z, direction), or a file"
        reject("points", points, wanted, 'As in {"tip": (0.5, 0.0, 0.0, "+Z")}.')
    found = {}
    for name, row in points.items():
        here, wanted = part("points", name), "(x, y, z, direction), in m"
        if not isinstance(row, tuple | list) or len(row) != 4:
            reject(here, repr(row), wanted, 'As in (0.5, 0.0, 0.0, "+Z").')
        place = real_array(here, row[:3], ndim=1, wanted=wanted)
        way = row[3]
        if isinstance(way, str):
            code = NAMES.get(way.strip().upper(), 0)
            if not 1 <= abs(code) <= 3:
                reject(here, repr(way), "a direction such as '+X', '-z' or 'v'", "Or pass a vector.")
            way = np.sign(code) * np.eye(3)[abs(code) - 1]
        vector = real_array(here, way, ndim=1, wanted="a direction of three numbers")
        if vector.size != 3 or not vector.any():
            reject(here, way, "a direction of three numbers", "It points where the sensor is positive.")
        found[name] = place, vector / np.linalg.norm(vector)
    return found


def _of_universal(file: Path) -> dict[str, Any]:
    nodes = nodes_of(file)
    labels = {f.response: f.at for f in functions_of(file, False) if f.what != "coherence"}
    lost = [label for point, label in labels.items() if point[0] not in nodes or not 1 <= abs(point[1]) <= 3]
    if not nodes or len(lost) == len(labels):
        found = f"with {len(nodes)} nodes and {len(labels)} points"
        unsuitable(file, found, "nodes (15, 781, 2411) of its functions")
    if lost:
        warn("points_without_dof", f"path: {str(file)!r} has no node or direction of {some(lost, 6)}.")
    kept = {point: label for point, label in labels.items() if label not in lost}
    return {label: (*nodes[point[0]], DIRECTIONS[point[1]]) for point, label in kept.items()}


def _of_table(file: Path) -> dict[str, Any]:
    wanted = "columns name, x, y, z, direction"
    text = file.read_text(encoding="utf-8-sig", errors="replace")
    rows = list(csv.reader(text.splitlines(), delimiter=next((s for s in "\t;" if s in text), ",")))
    head = [cell.partition("[")[0].strip().lower() for cell in rows[0]] if rows else []
    if not {"name", "x", "y", "z", "direction"} <= set(head):
        unsuitable(file, f"with the columns {some(head, 8)}", wanted, "Name them in the first line.")
    at = [head.index(name) for name in ("name", "x", "y", "z", "direction")]
    units = [Unit.named(rows[0][i].partition("[")[2].strip("] ") or "m").factor for i in at[1:4]]
    try:
        cells = [[row[i].strip() for i in at] for row in rows[1:] if any(row)]
        return {r[0]: (*(f * float(x) for f, x in zip(units, r[1:4], strict=True)), r[4]) for r in cells}
    except (ValueError, IndexError) as exc:
        unsuitable(file, f"with a row that is no point ({exc})", wanted)


def _nodes(nodes: Any) -> tuple[IntArray, FloatArray]:
    """Numbers and places of the nodes."""
    if isinstance(nodes, str | os.PathLike):
        nodes = nodes_of(existing_file(nodes))
    nodes = getattr(nodes, "mesh", nodes)
    if isinstance(nodes, Mapping):
        numbers: Any = list(nodes)
        places: Any = list(nodes.values())
    else:
        places = getattr(nodes, "coordinates", getattr(nodes, "nodes_m", nodes))
        numbers = getattr(nodes, "nodes", None)
    wanted = "coordinates (n, 3) or (n, 2) in m, or a model that has them"
    found = real_array("nodes", places, ndim=2, wanted=wanted)
    if found.shape[1] not in (2, 3):
        reject("nodes", f"an array of shape {found.shape}", wanted, "One row a node.")
    flat = np.zeros((len(found), 3 - found.shape[1]))
    return np.arange(len(found)) if numbers is None else np.asarray(numbers), np.hstack([found, flat])


def _directed(
    points: dict[Any, tuple[int, FloatArray]], unmatched: dict[Any, str]
) -> tuple[dict[str, dict[Any, float]], list[str]]:
    """The channels of each dof; those that stand askew with others at their node are turned together."""
    weights: dict[str, dict[Any, float]] = {}
    askew: dict[int, list[Any]] = {}
    notes: list[str] = []
    for name, (node, way) in points.items():
        axis = int(np.abs(way).argmax())
        if abs(way[axis]) < np.cos(np.radians(_MOST_DEG)):
            askew.setdefault(node, []).append(name)
            continue
        dof = f"{node}:{_AXES[axis]}"
        if dof in weights:
            unmatched[name] = f"the same dof, {dof}, as {next(iter(weights[dof]))!r}"
            continue
        weights[dof] = {name: float(np.sign(way[axis]))}
    for node, names in askew.items():
        ways = np.array([points[name][1] for name in names])
        axes = np.flatnonzero(np.abs(ways).max(axis=0) > 1e-3)
        turned = len(axes) == len(names) and np.linalg.cond(ways[:, axes]) < 10.0
        dofs = [f"{node}:{_AXES[axis]}" for axis in axes]
        if turned and not set(dofs) & set(weights):
            for dof, row in zip(dofs, np.linalg.inv(ways[:, axes]).tolist(), strict=True):
                weights[dof] = dict(zip(names, row, strict=True))
        else:
            for name, way in zip(names, ways.round(2).tolist(), strict=True):
                unmatched[name] = f"its direction {way} lies between axes"
    return weights, notes


def _exchanged(node: dict[Any, int], numbers: IntArray) -> list[str]:
    """Names with a node in them that lie at the node of one another."""
    called = {name: point_of(name) for name in node if isinstance(name, str)}
    own = {name: point[0] for name, point in called.items() if point is not None and point[0] in numbers}
    if np.mean([node[name] == own[name] for name in own] or [False]) < 0.5:
        return []  # numbers of the measurement are not those of the model
    pairs = [(a, b) for a, b in combinations(sorted(own), 2) if own[a] != own[b]]
    exchanged = [(a, b) for a, b in pairs if (node[a], node[b]) == (own[b], own[a])]
    return [f"{a!r} and {b!r} look exchanged: each lies at the other's node" for a, b in exchanged]


def _explain(at: FloatArray, places: FloatArray, tree: Any, reach: float) -> None:
    """Raise with the mistake under which the points lie at nodes; nothing where none does."""

    def share(moved: FloatArray) -> float:
        distance, index = map(np.asarray, tree.query(moved))
        distinct = len(set(index[distance <= reach].tolist()))
        return min(float(np.mean(distance <= reach)), distinct / max(len(np.unique(at, axis=0)), 1))

    def words(order: tuple[int, ...], signs: tuple[int, ...]) -> str:
        axes = "".join(_AXES[i] for i in order)
        said = [f"axes {axes} for XYZ"] * (axes != _AXES)
        return " and ".join([*said, *(f"{_AXES[i]} mirrored" for i in range(3) if signs[i] < 0)])

    least = share(at) + _MORE
    turns = list(product(permutations(range(3)), product((1, -1), repeat=3)))
    turns.sort(key=lambda turn: (turn[0] != (0, 1, 2), -sum(turn[1])))
    for scale, (order, signs) in product((1.0, *_SCALES), turns):
        turned = scale * at[:, order] * signs
        middle = places.min(axis=0) + places.max(axis=0) - turned.min(axis=0) - turned.max(axis=0)
        for shift in (np.zeros(3), 0.5 * middle):
            if share(turned + shift) >= max(_ALL, least):
                mistakes = [f"are {_SCALES[scale]}"] if scale != 1.0 else []
                mistakes += [f"have {words(order, signs)}"] if words(order, signs) else []
                if np.abs(shift).max() > reach:
                    mistakes.append(f"are shifted by {np.round(-shift, 4).tolist()} m")
                got = f"{len(at)} points that lie at nodes if they {' and '.join(mistakes)}"
                wanted = "coordinates in m in the axes of the model"
                raise UnsuitableDataError("points", got, wanted, "Correct them, or pass check=False.")
