"""A bolted L-bracket from its CalculiX input to a damage report: which washer is loose?

An angle of steel stands on four washers. The input file is written here (in a workshop it comes from the
mesher), CalculiX gives the model with a group for each washer and each leg, and both records: one intact, one
with a washer that has lost 40 % of its stiffness. They are superpositions of the modes that CalculiX itself
computes, with 0.5 % damping and 1 % noise, so that nothing of the test comes from the model that is fitted.

Run: ``python examples/bolted_bracket.py [FOLDER]``; needs CalculiX (``ccx`` on the path).
"""

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np

import antires_rs as ar

WIDTH_M, LEG_M, THICKNESS_M, WASHER_M = 0.16, 0.12, 0.008, 0.003
SETS = ("FOOT", "WALL", "W1", "W2", "W3", "W4")


def bracket(cells: int = 8, moduli: Mapping[str, float] | None = None) -> tuple[str, dict[str, int]]:
    """The input file, and the nodes of the sensors; ``cells`` along the width, factors on moduli by set."""
    nx, ny = cells, cells * 3 // 4
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
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{n}, {', '.join(f'{c:.9g}' for c in place)}" for place, n in numbers.items()]
    element = 0
    for name, bricks in sets.items():
        lines.append(f"*ELEMENT, TYPE=C3D8I, ELSET={name}")
        for corners in bricks:
            element += 1
            lines.append(f"{element}, {', '.join(map(str, corners))}")
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
        "toe left": (x[0], along[-1], high),
        "toe right": (x[-1], along[-1], high),
    }
    return "\n".join(lines) + "\n", {name: node(*place) for name, place in at.items()}


def modes_of(text: str, nodes: Mapping[str, int], folder: Path, n_modes: int = 14) -> ar.ModalSet:
    """Modes that CalculiX finds, at the sensors, mass-normalised."""
    listed = "".join(f"{node},\n" for node in nodes.values())
    step = f"*STEP\n*FREQUENCY\n{n_modes}\n*NODE PRINT, NSET=SENSORS\nU\n*END STEP\n"
    (folder / "modes.inp").write_text(f"{text}*NSET, NSET=SENSORS\n{listed}{step}")
    subprocess.run(["ccx", "-i", "modes"], cwd=folder, check=True, capture_output=True)
    rows = [line.split() for line in (folder / "modes.dat").read_text().splitlines()]
    listed_hz = [row for row in rows if len(row) == 5 and row[0].isdigit()][:n_modes]
    moved = [row for row in rows if len(row) == 4 and row[0].isdigit()]
    shapes = np.zeros((n_modes, len(nodes)))
    for sensor, (name, node) in enumerate(nodes.items()):
        axis = 3 if name.startswith("toe") else 2
        shapes[:, sensor] = [float(row[axis]) for row in moved if int(row[0]) == node]
    return ar.ModalSet([float(row[3]) for row in listed_hz], shapes, dofs=list(nodes))


def record_of(modes: ar.ModalSet, force: str, seed: int, duration_s: float = 30.0) -> ar.Recording:
    """Accelerations under a random force at one sensor, by superposition of modes in the frequency domain."""
    rng = np.random.default_rng(seed)
    fs_hz = 2.56 * 1.2 * float(modes.freq_hz[7])
    n = int(duration_s * fs_hz)
    freq = np.fft.rfftfreq(n, 1.0 / fs_hz)
    omega, own = 2.0 * np.pi * freq, 2.0 * np.pi * modes.freq_hz
    at = modes.shapes[:, list(modes.dofs).index(force)]
    spectrum = np.fft.rfft(rng.standard_normal(n))
    responses = np.zeros((len(modes.dofs), freq.size), dtype=complex)
    for hz, shape, drive in zip(own, modes.shapes, at, strict=True):
        receptance = drive / (hz**2 - omega**2 + 2j * 0.005 * hz * omega)
        responses += np.outer(shape, -(omega**2) * receptance * spectrum)
    accelerations = np.fft.irfft(responses, n)
    noise = 0.01 * accelerations.std(axis=1, keepdims=True) * rng.standard_normal(accelerations.shape)
    return ar.Recording(accelerations + noise, fs_hz, dofs=list(modes.dofs))


def main(folder: Path, cells: int = 8, damage: Mapping[str, float] | None = None) -> ar.DamageResult:
    """Model, records, antiresonances, damage."""
    folder.mkdir(parents=True, exist_ok=True)
    text, nodes = bracket(cells)
    (folder / "bracket.inp").write_text(text)
    model = ar.read_model(folder / "bracket.inp", groups="elset", out=folder / "bracket.npz")
    print(model)
    sensor = {name: f"{node}:{'Z' if name.startswith('toe') else 'Y'}" for name, node in nodes.items()}
    dofs = {name: model.dof(sensor[name]) for name in nodes}
    force, found = "top left", {}
    states = {"intact": bracket(cells)[0], "now": bracket(cells, damage or {"W2": 0.6})[0]}
    for seed, (state, input_text) in enumerate(states.items()):
        modes = modes_of(input_text, nodes, folder)
        band = (0.5 * modes.freq_hz[0], 1.1 * modes.freq_hz[7])
        record = record_of(modes, force, seed)
        zeros = ar.identify_antiresonances(record, excitation=force, band_hz=band)
        found[state] = zeros.relabelled(dofs[force], dofs)
    return ar.assess_damage(model, found["now"], baseline=found["intact"], rng=0)


if __name__ == "__main__":
    result = main(Path(sys.argv[1] if len(sys.argv) > 1 else "bolted_bracket"))
    print(result)
    print(result.headline)
