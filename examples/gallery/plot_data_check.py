"""
Two forces, and a force at the wrong place
==========================================

The method assumes one force at a known place. The data check tests this before anything is fitted.
"""

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar

case = ar.cases.chain8()
good = case.experiment(noise=0.01, duration_s=100.0, rng=0)
print(ar.check_data(good, excitation=0, band_hz=(3, 130)))

# %%
# The responses of a second, unrelated force at mass 6 are added: a machine running next door.
other = case.model.simulate(excitation=6, fs_hz=good.fs_hz, duration_s=100.0, damping_ratio=0.01, rng=1)
both = ar.Recording(np.array(good.responses) + 0.3 * np.array(other.responses), good.fs_hz)
checked = ar.check_data(both, excitation=0, band_hz=(3, 130))
print(checked)

# %%
# The second singular value shows it: under one force it is as small as noise and leakage make it (below);
# here it is not.
fig, axes = plt.subplots(2, 1, sharex=True, figsize=(9, 7), layout="constrained")
for ax, check, name in zip(
    axes,
    (ar.check_data(good, excitation=0, band_hz=(3, 130)), checked),
    ("one force", "two forces"),
    strict=True,
):
    check.plot(ax=ax)
    ax.set_title(name)

# %%
# The force was at mass 0, but the notes say mass 4.
for finding in ar.check_data(good, excitation=4, band_hz=(3, 130)).findings:
    print(finding)
