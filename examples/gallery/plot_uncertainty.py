"""
Standard deviations of antiresonances
=====================================

Every identified antiresonance has a standard deviation, estimated from the influence of each segment of the
record. Here eight records of the same structure are compared; each bar comes from its own record alone.
"""

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar

case = ar.cases.chain8()
truth = case.truth()["freq_hz"][5]
found = [
    ar.identify_antiresonances(
        case.experiment(noise=0.03, duration_s=60.0, rng=seed),
        excitation=0,
        band_hz=(3, 130),
        max_order=40,
        check="off",
    )
    for seed in range(8)
]

fig, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for ax, true in zip(axes, truth, strict=True):
    for seed, zeros in enumerate(found):
        values = zeros[5]
        if values.size and min(abs(values - true)) < 1.0:
            i = int(np.argmin(abs(values - true)))
            ax.errorbar(seed, values[i], yerr=1.645 * zeros.std_hz[5][i], fmt="o", color="C0", capsize=3)
    ax.axhline(true, color="k", lw=1)
    ax.set(xlabel="Record", ylabel="Antiresonance of $H_{50}$ (Hz)", title="90 % intervals and the truth")

# %%
# The updating can use them: with ``weights="std"`` uncertain antiresonances get less weight.
springs = ar.stiffness_factor(range(7), bounds=(0.9, 1.1))
problem = ar.UpdatingProblem(case.model, springs, found[0], weights="std")
for name, factor in zip(problem.names, ar.update(problem, rng=0).x, strict=True):
    print(f"{name:22s} {factor:.5f}   (true: 1)")
print(f"weights of the residuals from {problem.weights.min():.2f} to {problem.weights.max():.2f}")
