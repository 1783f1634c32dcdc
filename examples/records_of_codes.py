"""What the worked cases of finite-element codes share: records of the modes of a code, and the study.

Nothing of a record comes from the model that is fitted: frequencies and shapes are those that the code itself
computes for a structure which differs from the model in its moduli, its masses and sometimes its mesh.
"""

import subprocess
import time
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

import numpy as np

import antires_rs as ar

Sensors = Mapping[str, tuple[int, int]]  # node and direction from 1, by the name of the channel


def calculix_mesh(
    numbers: Mapping[tuple[float, ...], int], sets: Mapping[str, list[list[int]]], kind: str
) -> list[str]:
    """Cards of nodes, by their places, and of the elements of each set."""
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{n}, {', '.join(f'{c:.9g}' for c in place)}" for place, n in numbers.items()]
    element = 0
    for name, every in sets.items():
        lines.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        for nodes in every:
            element += 1
            lines.append(f"{element}, {', '.join(map(str, nodes))}")
    return lines


def calculix_modes(text: str, sensors: Sensors, folder: Path, n_modes: int) -> ar.ModalSet:
    """Modes that CalculiX finds, at the sensors, mass-normalised; ``text`` is an input file without steps."""
    listed = "".join(f"{node},\n" for node in sorted({node for node, _ in sensors.values()}))
    step = f"*STEP\n*FREQUENCY\n{n_modes}\n*NODE PRINT, NSET=SENSORS\nU\n*END STEP\n"
    (folder / "modes.inp").write_text(f"{text}*NSET, NSET=SENSORS\n{listed}{step}")
    subprocess.run(["ccx", "-i", "modes"], cwd=folder, check=True, capture_output=True)
    rows = [line.split() for line in (folder / "modes.dat").read_text().splitlines()]
    hz = [float(row[3]) for row in rows if len(row) == 5 and row[0].isdigit()][:n_modes]
    moved = [row for row in rows if len(row) == 4 and row[0].isdigit()]
    shapes = [[float(row[axis]) for row in moved if int(row[0]) == node] for node, axis in sensors.values()]
    return ar.ModalSet(hz, np.transpose(shapes), dofs=list(sensors))


def record_of(
    modes: ar.ModalSet, force: str, seed: int, duration_s: float, fs_hz: float, damping: float = 0.005
) -> ar.Recording:
    """Accelerations under a random force at one sensor: modes superposed, and 1 % noise."""
    rng = np.random.default_rng(seed)
    n = int(duration_s * fs_hz)
    omega, own = 2.0 * np.pi * np.fft.rfftfreq(n, 1.0 / fs_hz), 2.0 * np.pi * modes.freq_hz
    spectrum = -(omega**2) * np.fft.rfft(rng.standard_normal(n))
    responses = np.zeros((len(modes.dofs), omega.size), dtype=complex)
    for rad_s, shape, drive in zip(
        own, modes.shapes, modes.shapes[:, list(modes.dofs).index(force)], strict=True
    ):
        receptance = drive / (rad_s**2 - omega**2 + 2j * damping * rad_s * omega)
        responses += np.outer(shape, receptance * spectrum)
    accelerations = np.fft.irfft(responses, n)
    noise = 0.01 * accelerations.std(axis=1, keepdims=True) * rng.standard_normal(accelerations.shape)
    return ar.Recording(accelerations + noise, fs_hz, dofs=list(modes.dofs))


def identified(case: ModuleType, dofs: Mapping[str, int], record: ar.Recording) -> ar.AntiresonanceSet:
    """Antiresonances of a record, at the dofs of the model."""
    found = ar.identify_antiresonances(record, excitation=case.FORCE, band_hz=case.BAND_HZ)
    return found.relabelled(dofs[case.FORCE], dofs)


def prepared(
    case: ModuleType, folder: Path, seed: int = 0
) -> tuple[ar.UpdateResult, dict[str, int], ar.AntiresonanceSet]:
    """The model, updated with a record of the intact structure; its dofs; and what that record gave."""
    folder.mkdir(parents=True, exist_ok=True)
    model, dofs = case.model(folder)
    intact = identified(case, dofs, case.record(folder, {}, seed))
    return ar.update(ar.UpdatingProblem(model, case.parameters(), intact), rng=0), dofs, intact


def study(case: ModuleType, folder: Path, damage: Mapping[str, float]) -> ar.DamageResult:
    """One damage of a case, from the input of the code to the report."""
    begun = time.perf_counter()
    updated, dofs, intact = prepared(case, folder)
    print(updated)
    now = identified(case, dofs, case.record(folder, damage, 1))
    result = ar.assess_damage(updated.model, now, baseline=intact, elements=case.CANDIDATES)
    print(result.headline)
    result.report(folder / "report.html")
    print(f"{time.perf_counter() - begun:.0f} s from the input of the code to {folder / 'report.html'}")
    return result
