"""A ribbed plate of shells from its CalculiX input to a damage report: which rib has cracked?

A steel deck on a clamped edge with four ribs. The plate that is measured, calculated by CalculiX too, differs
from the input: its ribs are up to 6 % softer or stiffer, its skin is 2 % thicker. The first record updates
thickness and ribs. Records are superpositions of modes, with 0.5 % damping and 1 % noise.

Run: ``python examples/ribbed_plate.py [FOLDER]``; needs CalculiX (``ccx`` on the path).
"""

import sys
from collections.abc import Mapping
from pathlib import Path

import records_of_codes as codes

import antires_rs as ar

LENGTH_M, WIDTH_M, HEIGHT_M = 0.9, 0.6, 0.05
SKIN_M, RIB_M = 0.005, 0.004
RIBS = ("R1", "R2", "R3", "R4")
#: Ribs 1 and 2 go along from the clamped edge, at these shares of the width; 3 and 4 across.
ALONG, ACROSS = {"R1": 1, "R2": 3}, {"R3": 2, "R4": 5}
FORCE, BAND_HZ = "tip left", (15.0, 330.0)
CANDIDATES = RIBS
AS_BUILT = {"R1": 1.05, "R2": 0.94, "R3": 0.97, "R4": 1.04}
SENSORS_AT = {
    "tip left": (6, 0), "tip mid": (6, 2), "tip right": (6, 5), "mid left": (3, 0), "mid": (3, 3),
    "mid right": (3, 5), "root": (1, 2), "rib 3": (2, 1), "rib 4": (5, 3),
}  # fmt: skip


def plate(
    skin_m: float = SKIN_M, moduli: Mapping[str, float] | None = None
) -> tuple[str, dict[str, tuple[int, int]]]:
    """The input file and the sensors; ``moduli`` are factors by set."""
    numbers: dict[tuple[float, ...], int] = {}

    def node(*place: float) -> int:
        return numbers.setdefault(tuple(round(c, 9) for c in place), len(numbers) + 1)

    dx, dy, dz = LENGTH_M / 6, WIDTH_M / 5, HEIGHT_M
    sets: dict[str, list[list[int]]] = {"SKIN": []}
    around = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)]
    for i in range(6):
        for j in range(5):
            sets["SKIN"].append([node((i + a) * dx, (j + b) * dy, 0.0) for a, b in around])
    for name, row in ALONG.items():
        y = row * dy
        sets[name] = [[node((i + a) * dx, y, -b * dz) for a, b in around] for i in range(6)]
    for name, column in ACROSS.items():
        x = column * dx
        sets[name] = [[node(x, (j + a) * dy, -b * dz) for a, b in around] for j in range(5)]
    lines = codes.calculix_mesh(numbers, sets, "S8R")
    for name in sets:
        modulus = 2.1e11 * (moduli or {}).get(name, 1.0)
        lines += [f"*MATERIAL, NAME=M{name}", "*ELASTIC", f"{modulus!r}, 0.3", "*DENSITY", "7850."]
        lines += [
            f"*SHELL SECTION, ELSET={name}, MATERIAL=M{name}",
            repr(skin_m if name == "SKIN" else RIB_M),
        ]
    lines += ["*BOUNDARY", *(f"{n}, 1, 6" for place, n in numbers.items() if place[0] == 0.0)]
    sensors = {name: (node(i * dx, j * dy, 0.0), 3) for name, (i, j) in SENSORS_AT.items()}
    return "\n".join(lines) + "\n", sensors


def model(folder: Path) -> tuple[ar.MatrixModel, dict[str, int]]:
    """The model with a group for each rib and the thickness of the skin, and its dofs by sensor."""
    text, sensors = plate()
    (folder / "plate.inp").write_text(text)
    groups = {name: name for name in RIBS} | {"skin": "SKIN:thickness"}
    read = ar.read_model(folder / "plate.inp", groups=groups, out=folder / "plate.npz")
    return read, {name: read.dof(f"{node}:Z") for name, (node, _) in sensors.items()}


def record(folder: Path, damage: Mapping[str, float], seed: int) -> ar.Recording:
    """Of the plate as it is, with factors on the moduli of cracked ribs."""
    moduli = {name: AS_BUILT[name] * damage.get(name, 1.0) for name in RIBS}
    modes = codes.calculix_modes(*plate(1.02 * SKIN_M, moduli), folder, 60)  # fewer would move the dips
    return codes.record_of(modes, FORCE, seed, 120.0, 2.8 * BAND_HZ[1])


def parameters() -> list[ar.Parameter]:
    """What is updated."""
    return [*ar.stiffness_factor(RIBS, bounds=(0.7, 1.3)), ar.thickness("skin", bounds=(0.0045, 0.0055))]


if __name__ == "__main__":
    where = Path(sys.argv[1] if len(sys.argv) > 1 else "ribbed_plate")
    codes.study(sys.modules[__name__], where, {"R2": 0.7})
