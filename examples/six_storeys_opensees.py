"""Six storeys of reinforced concrete on rigid ground, for OpenSeesPy: the script that an engineer has.

Columns of each storey in two rows, west and east; floors are rigid diaphragms, their mass off the middle.
"""

import openseespy.opensees as ops

CORNERS_M = ((0.0, 0.0), (6.0, 0.0), (6.0, 4.5), (0.0, 4.5))
HEIGHT_M, STOREYS, E_PA = 3.2, 6, 3.0e10


def build(
    west_1=E_PA, west_2=E_PA, west_3=E_PA, west_4=E_PA, west_5=E_PA, west_6=E_PA,
    east_1=E_PA, east_2=E_PA, east_3=E_PA, east_4=E_PA, east_5=E_PA, east_6=E_PA,
    beams=2.7e10, floor_kg=2.2e4, parts=1,
):  # fmt: skip
    """Young's moduli of the columns by row and storey and of the beams; ``parts`` elements a column."""
    west = (west_1, west_2, west_3, west_4, west_5, west_6)
    east = (east_1, east_2, east_3, east_4, east_5, east_6)
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    for nth in (1, 2, 3, 4):
        x, y = CORNERS_M[nth - 1]
        for floor in range(STOREYS + 1):
            ops.node(10 * floor + nth, x, y, HEIGHT_M * floor)
        ops.fix(nth, 1, 1, 1, 1, 1, 1)
    ops.geomTransf("Linear", 1, 1, 0, 0)
    ops.geomTransf("Linear", 2, 0, 0, 1)
    for floor in range(1, STOREYS + 1):
        for nth in (1, 2, 3, 4):
            x, y = CORNERS_M[nth - 1]
            e = (west if x == 0.0 else east)[floor - 1]
            width, depth = (0.35, 0.40) if x == 0.0 else (0.35, 0.30)
            area, inertias = width * depth, (width * depth**3 / 12, depth * width**3 / 12)
            column = (area, e, e / 2.4, 2.0e-3, *inertias, 1, "-mass", 2500.0 * area, "-cMass")
            ends = [
                10 * floor - 10 + nth,
                *(1000 * floor + 10 * nth + p for p in range(1, parts)),
                10 * floor + nth,
            ]
            for p in range(1, parts):
                ops.node(ends[p], x, y, HEIGHT_M * (floor - 1 + p / parts))
            for p in range(parts):
                ops.element("elasticBeamColumn", 1000 * p + 10 * floor + nth, *ends[p : p + 2], *column)
            beam = (0.12, beams, beams / 2.4, 1.5e-3, 1.6e-3, 9.0e-4, 2, "-mass", 300.0, "-cMass")
            ops.element(
                "elasticBeamColumn", 100 + 10 * floor + nth, 10 * floor + nth, 10 * floor + nth % 4 + 1, *beam
            )
        ops.node(100 + floor, 3.4, 2.0, HEIGHT_M * floor)
        ops.mass(100 + floor, floor_kg, floor_kg, 0.0, 0.0, 0.0, 5.0 * floor_kg)
        ops.fix(100 + floor, 0, 0, 1, 1, 1, 0)
        ops.rigidDiaphragm(3, 100 + floor, *(10 * floor + nth for nth in (1, 2, 3, 4)))


def modes(n_modes, sensors, **values):
    """Frequencies in Hz and mass-normalised shapes at (node, direction) that OpenSees finds."""
    build(**values)
    ops.constraints("Transformation")
    squared = ops.eigen("-genBandArpack", n_modes)
    shapes = [
        [ops.nodeEigenvector(node, nth, axis) for node, axis in sensors] for nth in range(1, n_modes + 1)
    ]
    return [value**0.5 / 6.283185307179586 for value in squared], shapes


if __name__ == "__main__":
    build()
