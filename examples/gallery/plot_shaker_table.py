"""
A frame on a shaker table
=========================

A flexible three-storey table-top frame (STAIRlab, mdof, BSD 2-clause), moved by the Northridge earthquake.
The driven dof is the ground: its motion is a channel, and no force is measured. Values of the ground are
natural frequencies of the frame that stands on it; those of a floor are natural frequencies of what lies
beyond that floor, if it were held.

The data are not part of this repository: ``ANTIRES_DATA`` names the folder that holds them.
"""

import os
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar

path = Path(os.environ.get("ANTIRES_DATA", "../shared/data")) / "shake_table" / "records.npz"

if path.is_file():
    with np.load(path) as file:
        motion = file["flexible_northridge"]
    record = ar.Recording(motion, fs_hz=120.0, dofs=["ground", "floor 1", "floor 2", "floor 3"])
    # The table moves sideways a little, and an earthquake is short: what the check says is printed here.
    with warnings.catch_warnings(action="ignore", category=ar.AntiresWarning):
        found = ar.identify_antiresonances(record, excitation="ground", band_hz=(2.0, 14.0))
    print(found.data_check, found, sep="\n")

    # An eye sees dips of the transmissibilities from the ground at 5.1 to 5.3 and 9.0 to 9.7 Hz. The top
    # floor has none: nothing lies beyond it.
    curves = ar.transmissibility(record, reference="ground", nperseg=1024)
    fig, ax = plt.subplots(figsize=(10, 5), layout="constrained")
    band = (curves.freq_hz > 2.0) & (curves.freq_hz < 14.0)
    for name, style in zip(record.dofs[1:], ("-", "--", ":"), strict=True):
        curve = np.abs(curves.values[curves.dofs.index(name)])
        ax.semilogy(curves.freq_hz[band], curve[band], style, color="black", label=name)
        ax.plot(found[name], np.interp(found[name], curves.freq_hz, curve), "o", color="black")
    for value in found["ground"]:
        ax.axvline(value, color="0.7", linewidth=1.0)
    ax.set(xlabel="Frequency (Hz)", ylabel="Motion over that of the ground (-)")
    ax.legend(title="dots: antiresonances; lines: of the ground")
else:
    print("The record is not here: set ANTIRES_DATA to the folder that holds shake_table/.")
