"""
A frame with parameters that have units
=======================================

Wall thicknesses, moduli, masses, supports and angles of a frame of tubes; they may all be mixed in one
updating.
"""

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar
from antires_rs import figures as plotting


def frame(wall_m=0.0015, tip_kg=0.8, turned_deg=0.0):
    """A bent tube: one metre up, then half a metre aside, in ten elements; clamped below."""
    way = np.deg2rad(turned_deg)
    nodes = [(0.0, 0.2 * i) for i in range(6)]
    nodes += [(0.1 * i * np.cos(way), 1.0 + 0.1 * i * np.sin(way)) for i in range(1, 6)]
    sections = {"post": ar.Tube(0.03, wall_m, 2.1e11, 7850.0), "arm": ar.Tube(0.025, 0.0015, 2.1e11, 7850.0)}
    elements = [(i, i + 1, "post" if i < 5 else "arm") for i in range(10)]
    return ar.FrameModel(nodes, elements, sections, point_masses=[ar.PointMass(10, tip_kg)], fixed=[0])


model, tested = frame(), frame(wall_m=0.0018, tip_kg=0.9, turned_deg=3.0)
sensors = [model.dof(3, "u"), model.dof(5, "u"), model.dof(8, "v"), model.dof(10, "v")]
fig, ax = plt.subplots(figsize=(6, 5.5), layout="constrained")
plotting.plot_frame(model, ax=ax, sensors=sensors, excitation=sensors[3])

# %%
# Three parameters of different kinds, each with bounds in its own unit.
zeros = tested.antiresonances(sensors, sensors[3], f_max_hz=400.0)
measured = ar.AntiresonanceSet(sensors[3], dict(zip(sensors, zeros, strict=True)))
parameters = [
    ar.thickness("post", bounds=(0.001, 0.002)),
    ar.point_mass(0, bounds=(0.5, 1.2)),
    ar.angle([5], pivot=5, bounds_deg=(-8.0, 8.0)),
]
result = ar.update(ar.UpdatingProblem(model, parameters, measured), rng=0)
for name, value in zip(result.problem.names, result.x, strict=True):
    print(f"{name:24s} {value:.6g}")

# %%
print(result.table)
