"""Six storeys from an OpenSeesPy script to a damage report: which columns have cracked?

Rigid floors, two rows of columns a storey. The building differs from the script in what is never known:
moduli of columns by 4 % and of beams by 5 %, floors by 3 %, and its columns are of two elements each. Both
records are superpositions of the modes that OpenSees computes for it, with 1 % damping and 1 % noise. The
model is updated with the first, the damage found with the second beside it.

Run: ``python examples/six_storey_frame.py [FOLDER]``; needs openseespy.
"""

import sys
from collections.abc import Mapping
from pathlib import Path

import records_of_codes as codes
import six_storeys_opensees as frame

import antires_rs as ar

COLUMNS = [f"{row}_{storey}" for row in ("west", "east") for storey in range(1, frame.STOREYS + 1)]
SENSORS = {
    f"{where} {floor}": (10 * floor + corner, axis)
    for floor in range(1, frame.STOREYS + 1)
    for where, corner, axis in (("south x", 1, 1), ("north x", 3, 1), ("west y", 1, 2))
}
FORCE, BAND_HZ = "south x 6", (0.4, 8.2)
CANDIDATES = COLUMNS
AS_BUILT = {"west": 1.04, "east": 0.96, "beams": 1.05, "floor_kg": 1.03}


def model(folder: Path) -> tuple[ar.MatrixModel, dict[str, int]]:
    """The model with a group for each row of columns, and its dofs by the names of the sensors."""
    source = f"{Path(frame.__file__)}:build"
    read = ar.read_model(source, groups=[*COLUMNS, "beams"], out=folder / "frame.npz")
    return read, {name: read.dof(f"{node}:{'XYZ'[axis - 1]}") for name, (node, axis) in SENSORS.items()}


def record(folder: Path, damage: Mapping[str, float], seed: int) -> ar.Recording:
    """Of the building as it is, with factors on the moduli of damaged columns."""
    values = {name: frame.E_PA * AS_BUILT[name[:4]] * damage.get(name, 1.0) for name in COLUMNS}
    values |= {"beams": 2.7e10 * AS_BUILT["beams"], "floor_kg": 2.2e4 * AS_BUILT["floor_kg"]}
    hz, shapes = frame.modes(24, SENSORS.values(), parts=2, **values)
    return codes.record_of(
        ar.ModalSet(hz, shapes, dofs=list(SENSORS)), FORCE, seed, 1800.0, 2.8 * BAND_HZ[1], damping=0.01
    )


def parameters() -> list[ar.Parameter]:
    """What is updated: each row of columns as one, and the beams."""
    rows = [[name for name in COLUMNS if name.startswith(row)] for row in ("west", "east")]
    return [ar.stiffness_factor(row, bounds=(0.8, 1.25), together=True) for row in (*rows, ["beams"])]


if __name__ == "__main__":
    where = Path(sys.argv[1] if len(sys.argv) > 1 else "six_storey_frame")
    codes.study(sys.modules[__name__], where, {"east_2": 0.7})
