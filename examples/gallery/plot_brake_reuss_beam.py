"""
One hammer impact on a bolted beam
==================================

The Brake-Reuss beam (M. Cenedese, BRBtesting, GPL-3.0; Jin et al., Mech. Syst. Signal Process. 166 (2022)
108402): two steel bars joined by three bolts, free-free, one impact; three accelerometers, and a force that
is not used. The impact is recognised from the energy profile of the record, which is transformed as one event
and not in segments.

The data are not part of this repository: ``ANTIRES_DATA`` names the folder that holds them.
"""

import os
from pathlib import Path

import matplotlib.pyplot as plt

import antires_rs as ar

path = Path(os.environ.get("ANTIRES_DATA", "../shared/data")) / "brake_reuss_beam" / "HammerImpact.mat"

if path.is_file():
    record = ar.read_mat(path)
    print(record)

    # The place of the impact has no channel, so it gets a name of its own.
    found = ar.identify_antiresonances(record, excitation="hammer", band_hz=(60.0, 1200.0))
    print(found)

    # Published for acc2: 78.9, 326.2, 568.0 and 776.0 Hz. The one near 1,158 Hz is not confirmed.
    fig, ax = plt.subplots(figsize=(10, 5), layout="constrained")
    found.plot("acc2", ax=ax)
    for name in record.dofs:
        print(name, *found.scores[name]["how"])
else:
    print("The record is not here: set ANTIRES_DATA to the folder that holds brake_reuss_beam/.")
