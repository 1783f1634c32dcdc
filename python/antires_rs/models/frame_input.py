"""What the constructor of a frame was given, checked, as the recipe of one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..support.validation import FloatArray, integer, part, real_array, reject
from .frame_parts import fixed_dofs, ground_springs_of, iterable, node_springs_of, point_masses_of
from .recipes import FrameRecipe
from .sections import AnySection

__all__ = ["frame_recipe"]


def frame_recipe(
    nodes_m: Any,
    elements: Iterable[Any],
    sections: Any,
    point_masses: Iterable[Any],
    ground_springs: Iterable[Any],
    node_springs: Iterable[Any],
    fixed: Iterable[Any],
    orientation: Any,
) -> FrameRecipe:
    """The recipe of a frame, its arguments as of :class:`~antires_rs.FrameModel`."""
    wanted = "an array (n_nodes, 2) or (n_nodes, 3) of coordinates in m"
    nodes = real_array("nodes_m", nodes_m, ndim=2, wanted=wanted)
    if nodes.shape[1] not in (2, 3):
        reject(
            "nodes_m",
            f"an array of shape {nodes.shape}",
            wanted,
            "Give each node its coordinates in a row, in m.",
        )
    pairs = "pairs of nodes (first, second), or triples with a section"
    rows = [
        tuple(iterable(part("elements", i), row, pairs))
        for i, row in enumerate(iterable("elements", elements, pairs))
    ]
    if not rows:
        reject(
            "elements",
            "none",
            "at least one pair of nodes",
            "A frame is at least one beam between two nodes.",
        )
    names, listed, chosen = _sections_and_choice(sections, rows)
    ends = [[integer(part("elements", i), node, low=0) for node in row[:2]] for i, row in enumerate(rows)]
    in_space = nodes.shape[1] == 3
    return FrameRecipe(
        nodes_m=nodes,
        beams=tuple((a, b, section) for (a, b), section in zip(ends, chosen, strict=True)),
        section_names=names,
        sections=tuple(listed),
        fixed=tuple(fixed_dofs(fixed, in_space)),
        orientation=_orientation(orientation, len(rows), in_space),
        point_masses=point_masses_of(point_masses),
        ground_springs=ground_springs_of(ground_springs),
        node_springs=node_springs_of(node_springs),
    )


def _sections_and_choice(
    sections: Any, rows: list[tuple[Any, ...]]
) -> tuple[tuple[str | int, ...], list[AnySection], list[int]]:
    """Names and values of the sections, and the index of each beam's."""
    wanted = "a Tube, Rectangle or Section, or a sequence or mapping of them"
    named = isinstance(sections, Mapping)
    listed = (
        list(sections.values())
        if isinstance(sections, Mapping)
        else (
            [sections] if isinstance(sections, AnySection) else list(iterable("sections", sections, wanted))
        )
    )
    names: tuple[str | int, ...] = tuple(sections) if named else tuple(range(len(listed)))
    for name, section in zip(names, listed, strict=True):
        if not isinstance(section, AnySection):
            reject(
                part("sections", name),
                section,
                wanted,
                "Make it by Section.tube, Section.rectangle or Section(...).",
            )
        if named and not isinstance(name, str):
            reject("sections", f"the name {name!r}", "names that are text", "Put the name in quotes.")
    for i, row in enumerate(rows):
        if len(row) not in (2, 3):
            reject(
                part("elements", i),
                row,
                "two nodes, or two nodes and a section",
                "Write it as (0, 1) or (0, 1, 'pipe').",
            )
    referring = [len(row) == 3 for row in rows]
    if not any(referring):
        if len(listed) == 1:
            return names, listed, [0] * len(rows)
        if named or len(listed) != len(rows):
            reject(
                "elements",
                f"no section for any of {len(rows)} elements and {len(listed)} sections",
                "(node, node, section) for each element, or one section each",
                "Name a section as the third item of each element.",
            )
        # Equal sections are one, so that a parameter acts on all beams that have it.
        unique = list(dict.fromkeys(listed))
        return tuple(range(len(unique))), unique, [unique.index(section) for section in listed]
    if not all(referring):
        reject(
            part("elements", referring.index(False)),
            "no section",
            "a section for every element, or for none",
            "Name its section as the third item.",
        )
    chosen = []
    for i, row in enumerate(rows):
        if named and row[2] not in names:
            reject(
                part("elements", i),
                f"section {row[2]!r}",
                f"one of {', '.join(map(repr, names))}",
                "Correct the name, or add that section.",
            )
        chosen.append(
            names.index(row[2])
            if named
            else integer(part("elements", i), row[2], low=0, high=len(listed) - 1)
        )
    return names, listed, chosen


def _orientation(orientation: Any, n: int, in_space: bool) -> FloatArray | None:
    if orientation is None:
        return None
    wanted = f"one direction (3,), or an array ({n}, 3) with one for each element"
    if not in_space:
        reject(
            "orientation",
            "a direction for a plane frame",
            "None",
            "Leave it out: all beams of a plane frame bend in its plane.",
        )
    rows = np.atleast_2d(real_array("orientation", orientation, ndim=None, wanted=wanted))
    if rows.shape not in ((1, 3), (n, 3)):
        reject(
            "orientation",
            f"an array of shape {np.shape(orientation)}",
            wanted,
            "Give one direction for all elements, or one for each.",
        )
    return np.ascontiguousarray(np.broadcast_to(rows, (n, 3)))
