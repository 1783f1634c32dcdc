"""
Two unknown forces: traffic at both ends of a bridge
====================================================

The ground shakes a footbridge through both of its bearings, by two motions that nobody measures. A ratio of
two sensors means nothing then; ratios of *minors*, determinants of pairs of sensors, do. Antiresonances of
order 2 update the model, and tell which part of the girder has been damaged since.
"""

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar
from antires_rs import figures as plotting

BAND_HZ = (2.0, 45.0)


def girder(bearing_n_per_m):
    """Eighteen metres of steel in twelve elements, on elastic bearings at its ends."""
    nodes, elements = [(1.5 * i, 0.0) for i in range(13)], [(i, i + 1) for i in range(12)]
    bearings = [ar.GroundSpring(end, "v", bearing_n_per_m) for end in (0, 12)]
    section = ar.Rectangle(0.25, 0.3, 2.1e11, 7850.0)
    return ar.FrameModel(nodes, elements, section, ground_springs=bearings, fixed=[(0, "u")])


model = girder(4e6)
sensors = [model.dof(node, "v") for node in (0, 2, 4, 7, 9, 12)]
ends = [sensors[0], sensors[-1]]


def record(structure, seed):
    """Fifteen minutes of six accelerometers; each bearing brings a force of its own."""
    how = {"fs_hz": 128.0, "duration_s": 900.0, "damping_ratio": 0.012, "responses": sensors}
    each = [structure.simulate(excitation=end, rng=10 * seed + end, **how).responses for end in ends]
    x = sum(each)
    noise = np.random.default_rng(seed).standard_normal(x.shape)
    return ar.Recording(x + 0.01 * x.std(axis=1, keepdims=True) * noise, 128.0, sensors)


# %%
# The bridge has stiffer bearings than its model, and no quarter of it is as stiff as drawn.
quarters = [ar.stiffness_factor(range(3 * i, 3 * i + 3), bounds=(0.7, 1.3), together=True) for i in range(4)]
bridge = girder(7e6).with_parameters(quarters, [0.95, 1.06, 0.92, 1.04])
intact = ar.identify_antiresonances(record(bridge, 1), excitation=ends, band_hz=BAND_HZ)
print(intact)

# %%
# Both places of the forces are named; the data check counts them. The rows deleted from the model take the
# bearings along: what those are like does not matter, so that the model may be wrong about them.
print(intact.data_check.n_forces, "forces")
result = ar.update(ar.UpdatingProblem(model, quarters, intact), rng=0)
print(result.table)

# %%
# A year later one element has lost a fifth of its stiffness. The same two places shake, with other spectra.
damaged = bridge.with_parameters(ar.stiffness_reduction(7), 0.2)
now = ar.identify_antiresonances(record(damaged, 2), excitation=ends, band_hz=BAND_HZ)
damage = ar.assess_damage(model, now, baseline=intact, elements=range(12))
print(damage.headline)

fig, ax = plt.subplots(figsize=(7, 3.5), layout="constrained")
plotting.plot_damage(damage, ax=ax)
