"""
Antiresonances beside resonances with shapes
============================================

The paper compares its objective with one of resonances and mode shapes (Eq. 18). Here both are used on the
same record, with the same search and penalties.
"""

import matplotlib.pyplot as plt

import antires_rs as ar

case = ar.cases.chain8()
record = case.experiment(level=1, noise=0.05, duration_s=128.0, rng=5)
zeros = ar.identify_antiresonances(record, excitation=0, band_hz=(3, 130))
modes = ar.identify_modes(record, band_hz=(3, 130))  # FRFs, since this record has its force
print(modes)

# %%
penalties = {"search": ar.SearchOptions(gamma1=0.1, gamma2=0.1)}
damages = {
    "antiresonances": ar.assess_damage(case.model, zeros, **penalties, rng=0),
    "resonances, shapes": ar.assess_damage(case.model, modes, **penalties, rng=0),
}
fig, axes = plt.subplots(2, 1, figsize=(9, 7), layout="constrained")
for ax, (name, damage) in zip(axes, damages.items(), strict=True):
    damage.plot(ax=ax, truth=case.truth(level=1)["severity"])
    ax.set_title(name)
    print(f"{name:20s} spring {damage.damaged[0]}: {100 * damage.severity[4]:.2f} % (true: 55 %)")

# %%
# The modes before and after, with the MAC of their shapes.
print(damages["resonances, shapes"].table)
