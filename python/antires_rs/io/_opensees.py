"""Runs a user's OpenSeesPy script and writes the matrices of its model: ``python _opensees.py REQUEST OUT``.

A program of its own, as OpenSees has one model a process and may end it; it imports nothing of the package.
REQUEST is JSON: ``script``, ``function`` or null, ``factors`` on the default values of its arguments, and
``removed`` elements. Constraints between nodes are noted as the script states them and taken out of the
model, so that every free dof has a row; the caller puts them back as equations. ``GimmeMCK`` gives M and K as
they are in the state that the script leaves.
"""

from __future__ import annotations

import inspect
import json
import os
import sys
from typing import Any

import numpy as np

SIDES = ("stiffness", "mass")
#: Direction codes of the dofs of a node, by the dimensions of the model and the dofs of the node.
_CODES = {(1, 1): (1,), (2, 2): (1, 2), (2, 3): (1, 2, 6), (3, 3): (1, 2, 3), (3, 6): (1, 2, 3, 4, 5, 6)}


class Ties:
    """Equations between dofs of nodes, noted as ``ops`` makes its constraints."""

    def __init__(self, ops: Any) -> None:
        self.ops = ops
        self.rows: list[list[tuple[int, int, float]]] = []  # (node, dof from 1, coefficient) of each equation
        self.retained: set[tuple[int, int]] = set()
        self._make: dict[str, Any] = {}
        for name in ("equalDOF", "equalDOF_Mixed", "rigidLink", "rigidDiaphragm"):
            self._make[name] = getattr(ops, name)
            setattr(ops, name, getattr(self, f"_{name}"))

    def _add(self, node: int, dof: int, others: list[tuple[int, int, float]]) -> None:
        self.rows.append([(node, dof, 1.0), *((n, d, -value) for n, d, value in others if value)])
        self.retained |= {(n, d) for n, d, _ in others}

    def _equalDOF(self, master: int, slave: int, *dofs: int) -> Any:
        for dof in dofs:
            self._add(slave, dof, [(master, dof, 1.0)])
        return self._make["equalDOF"](master, slave, *dofs)

    def _equalDOF_Mixed(self, master: int, slave: int, count: int, *pairs: int) -> Any:
        for i in range(count):
            self._add(slave, pairs[2 * i + 1], [(master, pairs[2 * i], 1.0)])
        return self._make["equalDOF_Mixed"](master, slave, count, *pairs)

    def _rigidLink(self, kind: str, master: int, slave: int) -> Any:
        codes = codes_of(self.ops, slave)
        moves = codes if kind == "beam" else tuple(code for code in codes if code <= 3)
        self._rigid(master, slave, moves, turning=kind == "beam")
        return self._make["rigidLink"](kind, master, slave)

    def _rigidDiaphragm(self, normal: int, master: int, *slaves: int) -> Any:
        moves = tuple(sorted({1, 2, 3} - {normal})) + (normal + 3,)
        for slave in slaves:
            self._rigid(master, slave, moves, only=normal + 3)
        return self._make["rigidDiaphragm"](normal, master, *slaves)

    def _rigid(
        self, master: int, slave: int, moves: tuple[int, ...], turning: bool = True, only: int = 0
    ) -> None:
        """u_s = u_m + theta_m x (x_s - x_m), theta_s = theta_m; of the directions ``moves``."""
        codes = codes_of(self.ops, slave)
        arm = np.zeros(3)
        coordinates = np.ravel(np.subtract(self.ops.nodeCoord(slave), self.ops.nodeCoord(master)))
        arm[: coordinates.size] = coordinates
        # Translation i by rotation j: column j of the matrix that makes theta x arm.
        by = np.array([[0.0, arm[2], -arm[1]], [-arm[2], 0.0, arm[0]], [arm[1], -arm[0], 0.0]])
        for code in moves:
            others = [(master, codes.index(code) + 1, 1.0)]
            if code <= 3 and turning:
                turns = (c for c in codes if c > 3 and only in (0, c))
                others += [(master, codes.index(c) + 1, float(by[code - 1, c - 4])) for c in turns]
            self._add(slave, codes.index(code) + 1, others)


def codes_of(ops: Any, node: int) -> tuple[int, ...]:
    """Direction codes of the dofs of a node; 0 for what is no motion."""
    n_dof = listed(ops.getNDF(node))[0]
    return _CODES.get((listed(ops.getNDM())[0], n_dof), (0,) * n_dof)


def listed(answer: Any) -> list[int]:
    """Whole numbers that OpenSees gives as a list, or alone, or as None."""
    return [int(each) for each in np.ravel([] if answer is None else answer)]


def matrices(ops: Any, handler: str) -> list[Any]:
    """M and K of the model as it is."""
    ops.wipeAnalysis()
    ops.constraints(handler)
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.algorithm("Linear")
    ops.integrator("GimmeMCK", 1.0, 0.0, 0.0)
    ops.analysis("Transient", "-noWarnings")
    ops.analyze(1, 0.0)  # numbers the equations; a singular M is no matter
    made = []
    for m, k in ((1.0, 0.0), (0.0, 1.0)):
        ops.integrator("GimmeMCK", m, 0.0, k)
        values, n = np.array(ops.printA("-ret")), ops.systemSize()
        made.append(values.reshape(n, n))
    return made


def main(request: dict[str, Any], out: str) -> None:
    """Build the model and write it."""
    import openseespy.opensees as ops

    script, function = os.path.abspath(request["script"]), request["function"]
    sys.path.insert(0, os.path.dirname(script))
    sys.argv = [script]
    ties, defaults = Ties(ops), {}
    space: dict[str, Any] = {"__name__": "antires_model" if function else "__main__", "__file__": script}
    with open(script, encoding="utf-8") as opened:
        exec(compile(opened.read(), script, "exec"), space)
    if function:
        if not callable(space.get(function)):
            raise SystemExit(f"Unfit: the script has no function {function!r}")
        arguments = inspect.signature(space[function]).parameters.values()
        defaults = {p.name: p.default for p in arguments if isinstance(p.default, (int, float))}
        unknown = [name for name in request["factors"] if name not in defaults]
        if unknown:
            raise SystemExit(f"Unfit: {function} has no argument {unknown[0]!r} with a number as its default")
        space[function](**{name: defaults[name] * factor for name, factor in request["factors"].items()})
    there = sorted(listed(ops.getEleTags()))
    for tag in request["removed"]:
        if tag not in there:
            raise SystemExit(f"Unfit: the model has no element {tag}")
    elements = {tag: (str(np.ravel(ops.eleType(tag))[0]), listed(ops.eleNodes(tag))) for tag in there}
    for tag in request["removed"]:
        ops.remove("element", tag)
    reduced = matrices(ops, "Transformation") if ties.rows and not request["removed"] else []
    for node in sorted({row[0][0] for row in ties.rows}):
        ops.remove("mp", node)
    arrays = arrays_of(ties, matrices(ops, "Plain"), elements)
    for name, matrix in zip(("mass", "stiffness"), reduced, strict=False):
        arrays[f"reduced.{name}"] = np.sort(np.diag(matrix))
    about = {"kinds": list(dict.fromkeys(kind for kind, _ in elements.values())), "defaults": defaults}
    np.savez(out, **arrays, text=np.frombuffer(json.dumps(about).encode(), dtype=np.uint8))


def arrays_of(ties: Ties, found: list[Any], elements: dict[int, tuple[str, list[int]]]) -> dict[str, Any]:
    """Entries of M and K, names of the rows, equations and mesh."""
    ops, row_of = ties.ops, dict[tuple[int, int], int]()
    points = np.zeros((len(found[0]), 3), dtype=np.int64)  # node, direction code, dof of the node from 1
    nodes = sorted(listed(ops.getNodeTags()))
    for node in nodes:
        rows = zip(listed(ops.nodeDOFs(node)), codes_of(ops, node), strict=False)
        for i, (row, code) in enumerate(rows, 1):
            if row >= 0:
                row_of[node, i] = row
                points[row] = node, code, i
    tied = [[(row_of[n, d], value) for n, d, value in each if (n, d) in row_of] for each in ties.rows]
    flat = [(i, row, value) for i, each in enumerate(tied) for row, value in each]
    kept = sorted({row_of[point] for point in ties.retained if point in row_of})
    own = {row for each in tied for row, value in each[:1]}
    kinds = list(dict.fromkeys(kind for kind, _ in elements.values()))
    most = max((len(own) for _, own in elements.values()), default=1)
    padded = [[*own, *[-1] * (most - len(own))] for _, own in elements.values()]
    places = [[*map(float, np.ravel(ops.nodeCoord(node))), 0.0, 0.0][:3] for node in nodes]
    arrays: dict[str, Any] = {
        "points": points,
        "ties": np.array(flat, dtype=np.float64).reshape(-1, 3),
        "retained": np.array([row for row in kept if row not in own], dtype=np.int64),
        "nodes": np.array(nodes, dtype=np.int64),
        "coordinates": np.array(places).reshape(-1, 3),
        "elements": np.array(list(elements), dtype=np.int64),
        "connectivity": np.array(padded, dtype=np.int64).reshape(-1, most),
        "kind": np.array([kinds.index(kind) for kind, _ in elements.values()], dtype=np.int64),
    }
    for name, matrix in zip(("mass", "stiffness"), found, strict=True):
        at = np.nonzero(matrix)
        arrays |= {f"{name}.rows": at[0], f"{name}.columns": at[1], f"{name}.values": matrix[at]}
    return arrays


if __name__ == "__main__":
    try:
        main(json.loads(sys.argv[1]), sys.argv[2])
    except Exception as exc:  # the parent shows the last line
        print(f"{type(exc).__name__}: {str(exc).splitlines()[0] if str(exc) else ''}", file=sys.stderr)
        sys.exit(1)
