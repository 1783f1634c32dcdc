"""
Updating the eight-mass chain
=============================

The tested chain differs from the model by up to 8 % in every mass and every spring. Fifteen unknowns, 28
identified antiresonances.
"""

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar
from antires_rs import figures as plotting

case = ar.cases.chain8(perturbation=0.08, rng=2)
record = case.experiment(noise=0.01, duration_s=128.0, rng=2)
zeros = ar.identify_antiresonances(record, excitation=0, band_hz=(3, 130))
result = ar.update(case.updating_problem(zeros), rng=0)
print(result)

# %%
# What the data do not determine: mass 0, where the force acts, enters no antiresonance, and scaling all
# masses and springs together changes none. So thirteen of the fifteen combinations are determined.
for note in result.notes:
    print("-", note)

# %%
# Every antiresonance before and after.
fig, ax = plt.subplots(figsize=(9, 4), layout="constrained")
plotting.plot_differences(result.table, ax=ax)

# %%
# Beside the truth, once the common scale is removed: the parameters agree, except mass 0, which is not
# determined.
truth = np.concatenate([case.truth()["mass_factor"], case.truth()["stiffness_factor"]])
seen = np.arange(15) != 0
scale = np.median(truth[seen] / result.x[seen])
fig, ax = plt.subplots(figsize=(9, 3.6), layout="constrained")
ax.plot(truth, "kD", mfc="none", ms=9, label="truth")
ax.plot(np.flatnonzero(seen), scale * result.x[seen], "o", label="found, common scale taken out")
ax.plot(0, scale * result.x[0], "x", ms=9, label="not seen by any antiresonance")
ax.set_xticks(range(15), [f"m{i}" for i in range(8)] + [f"k{i}" for i in range(7)])
ax.set_ylabel("Factor on the nominal value (-)")
ax.legend()

# %%
# The course of the search. The polish finds the minimum early; the rest is the agreement of the islands.
plotting.plot_convergence(result)
