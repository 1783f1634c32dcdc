"""
Your own matrices
=================

A model from any finite-element code: K, M, and one stiffness matrix for each part that may change. Here a
clamped-free beam in twenty elements, assembled with numpy, whose element 6 has lost half its stiffness.
"""

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar

E_I, RHO_A, LENGTH, N = 12.0, 0.8, 1.0, 20
h = LENGTH / N
k_e = np.array(
    [
        [12, 6 * h, -12, 6 * h],
        [6 * h, 4 * h**2, -6 * h, 2 * h**2],
        [-12, -6 * h, 12, -6 * h],
        [6 * h, 2 * h**2, -6 * h, 4 * h**2],
    ]
)
m_e = np.array(
    [
        [156, 22 * h, 54, -13 * h],
        [22 * h, 4 * h**2, 13 * h, -3 * h**2],
        [54, 13 * h, 156, -22 * h],
        [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
    ]
)
k_e, m_e = E_I / h**3 * k_e, RHO_A * h / 420 * m_e
terms, mass = np.zeros((N, 2 * N + 2, 2 * N + 2)), np.zeros((2 * N + 2, 2 * N + 2))
for e in range(N):
    rows = slice(2 * e, 2 * e + 4)
    terms[e, rows, rows] = k_e
    mass[rows, rows] += m_e
free = slice(2, None)  # the clamped end is dofs 0 and 1
terms = terms[:, free, free]
model = ar.MatrixModel(terms.sum(axis=0), mass[free, free], stiffness_terms=terms)
print(model)

# %%
# Sensors at five places, force at the tip. The damaged beam stands for the measurement, to four digits as
# from a table.
sensors, tip = [7, 15, 23, 31, 38], 38
damaged = ar.MatrixModel(terms.sum(axis=0) - 0.5 * terms[6], mass[free, free])
zeros = damaged.antiresonances(sensors, tip, f_max_hz=150.0)
measured = ar.AntiresonanceSet(tip, {dof: np.round(f, 2) for dof, f in zip(sensors, zeros, strict=True)})
print(measured)

# %%
damage = ar.assess_damage(model, measured, rng=0)
fig, ax = plt.subplots(figsize=(9, 4), layout="constrained")
damage.plot(ax=ax, truth={6: 0.5})
