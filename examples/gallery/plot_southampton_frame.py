"""
A measured three-storey frame
=============================

The shear frame of the Digital Twin Operational Platform in Southampton (Cristallo, BSD-3-Clause):
accelerances of three floors, one column for each floor that was shaken. Two of its antiresonances contradict
a chain of three masses: that of H_01 would be the top mass alone on its spring, and so would one of H_11,
but they are measured at 14.5 and 15.0 Hz. So the fit ends near 1.4 %; least squares distributes the error.

The data are not part of this repository: ``ANTIRES_DATA`` names the folder that holds them.
"""

import os
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar

folder = Path(os.environ.get("ANTIRES_DATA", "../shared/data")) / "southampton_3storey"


def column(path, floor):
    """Antiresonances under a force at ``floor``; the columns of the file are f, H_1k, H_2k, H_3k."""
    with warnings.catch_warnings():  # one of the files has no line end after its last row, which is whole
        warnings.simplefilter("ignore", ar.AntiresWarning)
        response = ar.read_csv(path)
    found = ar.identify_antiresonances(response, excitation=floor, band_hz=(5.0, 32.0))
    return response, found


if folder.is_dir():
    files = ("Experimental.csv", "test_2.csv", "test_3.csv")
    measured = [column(folder / name, floor) for floor, name in enumerate(files)]
    fig, axes = plt.subplots(3, 1, sharex=True, figsize=(8, 8), layout="constrained")
    for k, (ax, (response, zeros)) in enumerate(zip(axes, measured, strict=True)):
        for dof, style in enumerate(("-", "--", ":")):
            size = abs(response.values[dof])
            (line,) = ax.semilogy(response.freq_hz, size, style, label=f"$H_{{{dof}{k}}}$")
            ax.plot(zeros[dof], np.interp(zeros[dof], response.freq_hz, size), "v", color=line.get_color())
        ax.set(xlim=(3, 35), ylabel="Accelerance (1/kg)")
        ax.legend(ncols=3)
    axes[-1].set_xlabel("Frequency (Hz)")

    # Each pair once (response at or below the force); the first mass sets the scale; the storey under the
    # first floor is element 2, the spring to ground.
    once = [ar.AntiresonanceSet(z.excitation, {i: z[i] for i in z if i <= z.excitation}) for _, z in measured]
    model = ar.MassSpringChain([5.201] * 3, [52.5e3] * 2, ground_first_n_per_m=52.5e3)
    bounds = (0.6, 1.4)
    parameters = ar.mass_factor([1, 2], bounds=bounds) + ar.stiffness_factor([2, 0, 1], bounds=bounds)
    result = ar.update(ar.UpdatingProblem(model, parameters, once, misfit="squared"), rng=0)
    print(result.summary())
else:
    print("The data of the frame are not here: set ANTIRES_DATA to the folder with southampton_3storey/.")
