"""
What the data cannot tell
=========================

How small a damage of each spring of the chain would be found? It depends on the place of the force and on
the penalties.
"""

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar

chain = ar.cases.chain8().model


def visible(force, gamma):
    """Smallest visible loss of each spring, in %, from exact antiresonances of all eight responses."""
    zeros = ar.AntiresonanceSet(force, dict(enumerate(chain.antiresonances(range(8), force))))
    search = ar.IslandGA(max_evaluations=2000)
    price = ar.SearchOptions(gamma1=gamma, gamma2=gamma)
    damage = ar.assess_damage(chain, zeros, search=price, optimizer=search, rng=0)
    return 100 * np.array(list(damage.detectable.values()))


fig, axes = plt.subplots(1, 2, sharey=True, figsize=(10, 4), layout="constrained")
for ax, force in zip(axes, (0, 3), strict=True):
    for gamma, mark in ((0.1, "o-"), (0.02, "s--")):
        ax.plot(range(7), visible(force, gamma), mark, label=rf"$\gamma_1 = \gamma_2 = {gamma}$")
    ax.set(xlabel="Spring", title=f"force at mass {force}", ylim=(0, None))
axes[0].set_ylabel("Smallest visible loss (%)")
axes[0].legend()

# %%
# What a result states about its parameters: here four, of which mass 0 enters no antiresonance, since the
# force acts on it.
measured = ar.AntiresonanceSet(0, dict(enumerate(chain.antiresonances(range(8), 0))))
parameters = ar.mass_factor([0, 1], bounds=(0.9, 1.1)) + ar.stiffness_factor([0, 1], bounds=(0.9, 1.1))
result = ar.update(ar.UpdatingProblem(chain, parameters, measured), rng=0)
for note in result.notes:
    print("-", note)
