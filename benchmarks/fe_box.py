"""A stiffened box of shells of CalculiX, on which nothing of the library was adjusted.

A steel cover with four walls, clamped at their feet, and three flat ribs inside its top. The model has S8R
elements of 50 mm; what is measured has them of 33 mm, a top 3 % stiffer, walls 3 % softer and ribs of 1.03,
0.97 and 1.02 times the modulus. Used by benchmarks/fe_cases.py.
"""

import records_of_codes as codes

import antires_rs as ar

SIZE_M, SHELL_M, RIB_M = (0.8, 0.5, 0.3), 0.004, 0.005
RIBS = {"RIB1": 0.2, "RIB2": 0.4, "RIB3": 0.6}
WALLS = ("FRONT", "BACK", "LEFT", "RIGHT")
CANDIDATES = [*WALLS, *RIBS]
AS_BUILT = {"TOP": 1.03, "RIB1": 1.03, "RIB2": 0.97, "RIB3": 1.02} | dict.fromkeys(WALLS, 0.97)
FORCE, BAND_HZ = "top 1", (100.0, 400.0)
#: Places in m, none on an edge, and the direction that is measured.
SENSORS_AT = {
    "top 1": (0.1, 0.2, 0.3, 3), "top 2": (0.3, 0.3, 0.3, 3), "top 3": (0.5, 0.2, 0.3, 3),
    "top 4": (0.7, 0.4, 0.3, 3), "top 5": (0.4, 0.1, 0.3, 3), "front 1": (0.3, 0.0, 0.2, 2),
    "front 2": (0.6, 0.0, 0.2, 2), "back 1": (0.2, 0.5, 0.2, 2), "back 2": (0.5, 0.5, 0.1, 2),
    "left": (0.0, 0.3, 0.2, 1), "right": (0.8, 0.2, 0.2, 1),
}  # fmt: skip


def box(moduli=None, cell_m=0.05):
    """The input file and the sensors; ``moduli`` are factors by set."""
    numbers = {}

    def node(*place):
        return numbers.setdefault(tuple(round(c, 6) for c in place), len(numbers) + 1)

    (lx, ly, lz), sets = SIZE_M, {}

    def panel(name, n_u, n_v, place):
        """Quadrilaterals of eight nodes where ``place`` of (u, v) puts them."""
        around = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)]
        cells = [(i, j) for i in range(n_u) for j in range(n_v)]
        sets[name] = [[node(*place((i + a) * cell_m, (j + b) * cell_m)) for a, b in around] for i, j in cells]

    n_x, n_y, n_z = (round(each / cell_m) for each in SIZE_M)
    panel("TOP", n_x, n_y, lambda u, v: (u, v, lz))
    panel("FRONT", n_x, n_z, lambda u, v: (u, 0.0, v))
    panel("BACK", n_x, n_z, lambda u, v: (u, ly, v))
    panel("LEFT", n_y, n_z, lambda u, v: (0.0, u, v))
    panel("RIGHT", n_y, n_z, lambda u, v: (lx, u, v))
    for name, x in RIBS.items():
        panel(name, n_y, round(0.1 / cell_m), lambda u, v, x=x: (x, u, lz - v))
    lines = codes.calculix_mesh(numbers, sets, "S8R")
    for name in sets:
        modulus = 2.1e11 * (moduli or {}).get(name, 1.0)
        lines += [f"*MATERIAL, NAME=M{name}", "*ELASTIC", f"{modulus!r}, 0.3", "*DENSITY", "7850."]
        thickness = RIB_M if name in RIBS else SHELL_M
        lines += [f"*SHELL SECTION, ELSET={name}, MATERIAL=M{name}", repr(thickness)]
    lines += ["*BOUNDARY", *(f"{n}, 1, 6" for place, n in numbers.items() if place[2] == 0.0)]
    return "\n".join(lines) + "\n", {name: (node(*at[:3]), at[3]) for name, at in SENSORS_AT.items()}


def model(folder):
    """The model with a group for each wall, the top and each rib, and its dofs by sensor."""
    text, sensors = box()
    (folder / "box.inp").write_text(text)
    read = ar.read_model(folder / "box.inp", groups="elset", out=folder / "box.npz")
    return read, {name: read.dof(f"{node}:{'XYZ'[axis - 1]}") for name, (node, axis) in sensors.items()}


def record(folder, damage, seed):
    """Of the box as it is, with factors on the moduli of what is damaged."""
    moduli = {name: factor * damage.get(name, 1.0) for name, factor in AS_BUILT.items()}
    modes = codes.calculix_modes(*box(moduli, 1.0 / 30.0), folder, 36)
    return codes.record_of(modes, FORCE, seed, 60.0, 2.8 * BAND_HZ[1])


def parameters():
    """What is updated: the top, the walls as one, the ribs as one."""
    kinds = (["TOP"], WALLS, list(RIBS))
    return [ar.stiffness_factor(kind, bounds=(0.8, 1.25), together=True) for kind in kinds]
