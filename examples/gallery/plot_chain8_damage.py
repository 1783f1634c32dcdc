"""
Damage of the eight-mass chain
==============================

The first case of the paper: eight masses in line, free at both ends, shaken at mass 1. Spring 5 has lost
55 % of its stiffness. Eight accelerometers are recorded; the force is not used.
"""

import matplotlib.pyplot as plt

import antires_rs as ar
from antires_rs import plotting

case = ar.cases.chain8()
record = case.experiment(level=1, noise=0.01, duration_s=128.0, rng=1)

# %%
# The record becomes antiresonances, response by response. ``H_11`` has seven, ``H_81`` none. Standard
# deviations come from the scatter of the segments.
zeros = ar.identify_antiresonances(record, excitation=0, band_hz=(3, 130))
print(zeros)

# %%
# The unknowns are one stiffness loss for each spring. The two penalties favour few damaged springs, so all
# but one come out as exactly zero.
damage = ar.assess_damage(case.model, zeros, rng=0)
print(damage.summary())

# %%
# Diamonds are the truth. The short lines across the bars are the smallest damage that would have been found:
# a smaller loss of that spring would come out as zero.
fig, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
damage.plot(ax=left, truth=case.truth(level=1)["severity"])
plotting.plot_differences(damage.table, ax=right, names=("undamaged model", "damage found"))
