"""
Updating the exhaust
====================

The second case of the paper, as a documented surrogate: a car's exhaust on soft cords. The tested structure
has a mesh four times finer and other wall thicknesses, moduli, masses and bends than the model. The wall
thickness also varies from piece to piece, so no choice of the 21 parameters fits it exactly.
"""

import matplotlib.pyplot as plt

import antires_rs as ar
from antires_rs import figures as plotting

case = ar.cases.exhaust()
fig, ax = plt.subplots(figsize=(10, 4), layout="constrained")
plotting.plot_frame(case.model, ax=ax, sensors=case.responses, excitation=case.excitation)

# %%
# Two minutes of a virtual test with 1 % sensor noise (the study in ``benchmarks/exhaust_study.py`` takes
# ten), and the antiresonances of all 16 accelerometers.
record = case.experiment(noise=0.01, duration_s=120.0, rng=1)
zeros = ar.identify_antiresonances(record, excitation=case.excitation, band_hz=case.updating_band_hz)
print(sum(len(zeros[dof]) for dof in zeros), "antiresonances")

# %%
# Twelve accelerometers are fitted. Four are kept out, to test whether the model predicts what it was not
# fitted to.
problem = case.updating_problem(zeros)
result = ar.update(problem, optimizer=ar.IslandGA(max_evaluations=20_000), rng=0)
print(result)

# %%
fig, ax = plt.subplots(figsize=(10, 4.2), layout="constrained")
plotting.plot_differences(result.table, ax=ax)

# %%
# What was held out: nearest antiresonance of the model before and after.
held_out = ar.AntiresonanceSet(case.excitation, {dof: zeros[dof] for dof in case.held_out})
for name, model in (("nominal", case.model), ("updated", result.model)):
    check = ar.UpdatingProblem(model, ar.stiffness_factor(0, bounds=(0.9, 1.1)), held_out)
    error = abs(100 * (check.paired_hz([1.0]) / check.measured_hz - 1))
    print(f"{name}: mean difference at the four others {error.mean():.2f} %, largest {error.max():.2f} %")
