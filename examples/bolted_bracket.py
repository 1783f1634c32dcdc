"""A bolted L-bracket from its CalculiX input to a damage report: which washer is loose?

An angle of steel stands on four washers. The input file is written here (in a workshop it comes from the
mesher), CalculiX gives the model with a group for each washer and each leg, and both records: one intact, one
with a washer that has lost 40 % of its stiffness. The bracket that is measured has a modulus 2 % higher and
washers up to 10 % off. Records are superpositions of the modes that CalculiX computes, with 0.5 % damping
and 1 % noise.

Run: ``python examples/bolted_bracket.py [FOLDER]``; needs CalculiX (``ccx`` on the path).
"""

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import records_of_codes as codes

import antires_rs as ar

WIDTH_M, LEG_M, THICKNESS_M, WASHER_M = 0.16, 0.12, 0.008, 0.003
WASHERS = CANDIDATES = ("W1", "W2", "W3", "W4")
SETS = ("FOOT", "WALL", *WASHERS)
AS_BUILT = {"FOOT": 1.02, "WALL": 1.02, "W1": 1.1, "W2": 0.95, "W3": 1.05, "W4": 0.9}
FORCE, BAND_HZ, CELLS = "top left", (80.0, 1700.0), 8  # along the width


def bracket(moduli: Mapping[str, float] | None = None) -> tuple[str, dict[str, tuple[int, int]]]:
    """The input file, and the sensors; ``moduli`` are factors by set."""
    nx, ny = CELLS, CELLS * 3 // 4
    x, along = np.linspace(0.0, WIDTH_M, nx + 1), np.linspace(0.0, LEG_M, ny + 1)
    numbers: dict[tuple[float, ...], int] = {}

    def node(*place: float) -> int:
        return numbers.setdefault(tuple(np.round(place, 9).tolist()), len(numbers) + 1)

    sets: dict[str, list[list[int]]] = {name: [] for name in SETS}

    def brick(name: str, xs: tuple[float, ...], ys: tuple[float, ...], zs: tuple[float, ...]) -> None:
        corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
        sets[name].append([node(xs[i], ys[j], z) for z in zs for i, j in corners])

    washers = {(1, ny - 2): "W1", (nx - 2, ny - 2): "W2", (1, 2): "W3", (nx - 2, 2): "W4"}
    low, high = WASHER_M, WASHER_M + THICKNESS_M
    for i in range(nx):
        xs = (x[i], x[i + 1])
        brick("FOOT", xs, (-THICKNESS_M, 0.0), (low, high))  # the corner
        for j in range(ny):
            ys, zs = (along[j], along[j + 1]), (high + along[j], high + along[j + 1])
            brick("FOOT", xs, ys, (low, high))
            brick("WALL", xs, (-THICKNESS_M, 0.0), zs)
            if (i, j) in washers:
                brick(washers[i, j], xs, ys, (0.0, low))
    ground = sorted(n for place, n in numbers.items() if place[2] == 0.0)
    lines = codes.calculix_mesh(numbers, sets, "C3D8I")
    for name in SETS:
        modulus = (2.1e11 if name in ("FOOT", "WALL") else 2.0e8) * (moduli or {}).get(name, 1.0)
        lines += [f"*MATERIAL, NAME=M{name}", "*ELASTIC", f"{modulus!r}, 0.3", "*DENSITY", "7850."]
        lines.append(f"*SOLID SECTION, ELSET={name}, MATERIAL=M{name}")
    lines += ["*NSET, NSET=GROUND", *(f"{n}," for n in ground), "*BOUNDARY", "GROUND, 1, 3"]
    top, middle = high + along[-1], high + along[ny // 2]
    at = {
        "top left": (x[0], -THICKNESS_M, top),
        "top right": (x[-1], -THICKNESS_M, top),
        "mid left": (x[0], -THICKNESS_M, middle),
        "mid right": (x[-1], -THICKNESS_M, middle),
        "foot left": (x[0], along[ny // 2], high),
        "foot right": (x[-1], along[ny // 2], high),
        "toe left": (x[0], along[-1], high),
        "toe right": (x[-1], along[-1], high),
    }
    sensors = {
        name: (node(*place), 3 if name.startswith(("foot", "toe")) else 2) for name, place in at.items()
    }
    return "\n".join(lines) + "\n", sensors


def model(folder: Path) -> tuple[ar.MatrixModel, dict[str, int]]:
    """The model with a group for each element set, and its dofs by sensor."""
    text, sensors = bracket()
    (folder / "bracket.inp").write_text(text)
    read = ar.read_model(folder / "bracket.inp", groups="elset", out=folder / "bracket.npz")
    return read, {name: read.dof(f"{node}:{'XYZ'[axis - 1]}") for name, (node, axis) in sensors.items()}


def record(folder: Path, damage: Mapping[str, float], seed: int) -> ar.Recording:
    """Of the bracket as it is, with factors on the moduli of loose washers."""
    moduli = {name: factor * damage.get(name, 1.0) for name, factor in AS_BUILT.items()}
    modes = codes.calculix_modes(*bracket(moduli), folder, 60)  # fewer would move the dips
    return codes.record_of(modes, FORCE, seed, 60.0, 2.8 * BAND_HZ[1])


def parameters() -> list[ar.Parameter]:
    """What is updated: each leg, and the washers as one."""
    legs = ar.stiffness_factor(["FOOT", "WALL"], bounds=(0.9, 1.1))
    return [*legs, ar.stiffness_factor(WASHERS, bounds=(0.7, 1.4), together=True)]


if __name__ == "__main__":
    where = Path(sys.argv[1] if len(sys.argv) > 1 else "bolted_bracket")
    codes.study(sys.modules[__name__], where, {"W2": 0.6})
