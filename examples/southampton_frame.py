"""Update a three-storey frame from its measured accelerances.

Data: the Southampton three-storey shear frame of the Digital Twin Operational Platform (Cristallo,
BSD-3-Clause), one column of FRFs for each floor that was shaken. The model is the nominal one of its
authors: 5.201 kg a storey, 52.5 kN/m between storeys (four legs 25 x 3 mm). They may change by 40 %.

What to expect. A chain of three lumped masses cannot fit these antiresonances below 1.1 %: that of H_01
is the top mass alone on its spring, and so is one of H_11, while the real frame shows them at 14.5 and
15.0 Hz. The sum of absolute residuals would fit one of the two exactly; least squares distributes the
error over both. H_02 has no antiresonance: force and response are at the two ends. Scaling all masses and
springs together changes no antiresonance, so the first mass is kept at 5.201 kg to set the scale.

H_ik = H_ki, so each pair is used once (response at or below the force): counted twice, a pair would
outweigh the driving points.

Run:  python examples/southampton_frame.py     (data in $ANTIRES_DATA or ../shared/data)
"""

import os
import warnings
from pathlib import Path

import antires_rs as ar

BAND_HZ = (5.0, 28.0)
FILES = ("Experimental.csv", "test_2.csv", "test_3.csv")
MASS_KG, STIFFNESS_N_PER_M = 5.201, 52.5e3


def data_folder() -> Path | None:
    """Folder of the measurement, or None."""
    root = Path(os.environ.get("ANTIRES_DATA", Path(__file__).parents[2] / "shared" / "data"))
    folder = root / "southampton_3storey"
    return folder if folder.is_dir() else None


def read_column(path: Path) -> ar.FrequencyResponse:
    """Accelerances of the three floors under a force at floor k: f; H_1k; H_2k; H_3k."""
    with warnings.catch_warnings():  # one of the files has no line end after its last row, which is whole
        warnings.simplefilter("ignore", ar.AntiresWarning)
        return ar.read_csv(path)


def identify(folder: Path) -> list[ar.AntiresonanceSet]:
    """Antiresonances of the three columns, by the same settings."""
    return [
        ar.identify_antiresonances(read_column(folder / name), excitation=floor, band_hz=BAND_HZ)
        for floor, name in enumerate(FILES)
    ]


def update(measured: list[ar.AntiresonanceSet]) -> ar.UpdateResult:
    """The nominal frame, its storeys and the two upper masses within 40 %."""
    model = ar.MassSpringChain([MASS_KG] * 3, [STIFFNESS_N_PER_M] * 2, ground_first_n_per_m=STIFFNESS_N_PER_M)
    ground = 2  # the storey under the first floor is the spring to ground: element n - 1
    parameters = ar.mass_factor([1, 2], bounds=(0.6, 1.4)) + ar.stiffness_factor(
        [ground, 0, 1], bounds=(0.6, 1.4)
    )
    once = [
        ar.AntiresonanceSet(zeros.excitation, {i: zeros[i] for i in zeros if i <= zeros.excitation})
        for zeros in measured
    ]
    return ar.update(ar.UpdatingProblem(model, parameters, once, misfit="squared"), rng=0)


def main() -> tuple[list[ar.AntiresonanceSet], ar.UpdateResult] | None:
    folder = data_folder()
    if folder is None:
        print("The Southampton data are not here: set ANTIRES_DATA to the folder that holds them.")
        return None
    measured = identify(folder)
    for zeros in measured:
        print(zeros, end="\n\n")
    result = update(measured)
    print(result.summary())
    return measured, result


if __name__ == "__main__":
    main()
