"""Keys of [model] and [[parameters]]."""

from __future__ import annotations

from .key import Key, Section

__all__ = [
    "CHAIN",
    "ELEMENTS",
    "FRAME",
    "LUMPED",
    "MATRICES",
    "MODEL",
    "PARAMETERS",
    "RESULT",
    "SECTIONED",
    "SUPPORT",
]

CHAIN, FRAME, MATRICES, RESULT = ("chain", "frame", "matrices", "result")

MODEL = Section(
    "model",
    "The model. Masses, springs, nodes, elements and dofs count from 0.",
    (
        Key(
            "kind",
            "text",
            '"chain" (masses and springs in a row), "frame" (beams), "matrices" (K and M of '
            "any finite-element program), \"result\" (the updated model of 'antires update').",
            required=True,
        ),
        Key("masses_kg", "numbers", "Masses in kg, from the first to the last.", of=(CHAIN,)),
        Key(
            "springs_n_per_m",
            "numbers",
            "Stiffness in N/m of the springs between neighbours, one fewer than masses.",
            of=(CHAIN,),
        ),
        Key(
            "ground_first_n_per_m",
            "number",
            "Spring from the first mass to ground; 0 is a free end. With n "
            'masses it is element n - 1, which "all" leaves out.',
            "0",
            of=(CHAIN,),
        ),
        Key(
            "ground_last_n_per_m",
            "number",
            "Spring from the last mass to ground: element n, left out likewise.",
            "0",
            of=(CHAIN,),
        ),
        Key("nodes_m", "list", "Coordinates of the nodes in m, [x, y] or [x, y, z].", of=(FRAME,)),
        Key("elements", "list", '[node, node, "section"] of each beam.', of=(FRAME,)),
        Key(
            "sections",
            "table",
            'Name = { shape = "tube", outer_diameter_m, thickness_m, youngs_modulus_pa, '
            'density_kg_per_m3 }, "rectangle" with width_m, height_m, or "general" with area_m2, inertia_m4; '
            'shear_coefficient = "cowper" or a number makes Timoshenko beams.',
            of=(FRAME,),
        ),
        Key("point_masses", "list", "[node, kg] or [node, kg, inertia in kg m2] of each.", of=(FRAME,)),
        Key(
            "ground_springs",
            "list",
            '[node, "direction", N/m] of each; directions are u, v, theta in the '
            "plane, u, v, w, rx, ry, rz in space.",
            of=(FRAME,),
        ),
        Key(
            "node_springs",
            "list",
            '[node, node, N/m] or [node, node, N/m, "direction"] of each.',
            of=(FRAME,),
        ),
        Key("fixed", "list", 'Nodes, or [node, "direction"], that cannot move.', of=(FRAME,)),
        Key("orientation", "list", "Direction in which the height of the sections points.", of=(FRAME,)),
        Key(
            "file",
            "text",
            "The result.npz of 'antires update', or a file of write_matrices.",
            of=(MATRICES, RESULT),
        ),
        Key("stiffness", "text", "K, as Matrix Market (.mtx) or scipy.sparse (.npz).", of=(MATRICES,)),
        Key("mass", "text", "M, likewise.", of=(MATRICES,)),
        Key(
            "stiffness_terms",
            "texts",
            "The part of K that each element or group contributes.",
            of=(MATRICES,),
        ),
        Key("mass_terms", "texts", "The same for M.", of=(MATRICES,)),
        Key(
            "dof_map",
            "text",
            'Text file with node and direction of each row, so that channels such as "12+Z" find their dof.',
            of=(MATRICES,),
        ),
        Key("first_row", "whole", "Number of the first row in dof_map.", "1", of=(MATRICES,)),
    ),
)

ELEMENTS = ("stiffness_factor", "stiffness_reduction", "angle", "length")
SECTIONED = ("youngs_modulus", "density", "thickness", "diameter")
LUMPED, SUPPORT = ("point_mass", "inertia"), ("support_stiffness",)

PARAMETERS = Section(
    "parameters",
    "What may change in the model: one [[parameters]] for each kind and its bounds.",
    (
        Key(
            "kind",
            "text",
            "stiffness_factor, stiffness_reduction (of elements), mass_factor (of terms); for "
            "frames also youngs_modulus, density, thickness, diameter (of sections), point_mass, inertia (of "
            "masses), support_stiffness (of springs), angle (of elements about a pivot), length (of elements "
            "from a pivot), position (of nodes along a direction).",
            required=True,
        ),
        Key(
            "bounds",
            "pair",
            "Lower and upper bound: a factor, or a value in SI (degrees for an angle, m for a position).",
            required=True,
        ),
        Key("elements", "terms", '"all" or a list such as [0, 1, 2].', of=ELEMENTS),
        Key(
            "terms",
            "terms",
            '"all" or a list such as [0, 1, 2]; for a chain, the masses.',
            of=("mass_factor",),
        ),
        Key("sections", "terms", '"all" or a list of names.', of=SECTIONED),
        Key("masses", "terms", '"all" or positions in point_masses.', of=LUMPED),
        Key("springs", "terms", '"all" or positions in ground_springs.', of=SUPPORT),
        Key(
            "together",
            "switch",
            "Whether one parameter acts on all of them.",
            "false",
            of=(*ELEMENTS[:2], "mass_factor", *SECTIONED, *LUMPED, *SUPPORT, "position"),
        ),
        Key(
            "relative",
            "switch",
            "Whether bounds are factors on the model's value.",
            "false",
            of=(*SECTIONED, *LUMPED, *SUPPORT),
        ),
        Key("nodes", "terms", "A list of nodes.", of=("position",)),
        Key("direction", "numbers", "The direction in which the nodes move, (x, y, z).", of=("position",)),
        Key(
            "pivot", "whole", "The node about which the elements turn, or that stays.", of=("angle", "length")
        ),
        Key("axis", "numbers", "The axis, in space.", "[0, 0, 1]", of=("angle",)),
    ),
    "must",
)
