"""
What a transmissibility shows
=============================

Under one force the responses share their resonances. In the quotient of two responses these cancel, and so
does the force. What remains are the antiresonances: those of the denominator are peaks, those of the
numerator dips.
"""

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar

case = ar.cases.chain8()
freq = np.linspace(3.0, 125.0, 4000)
h = case.model.frf([0, 3], 0, freq, damping_ratio=0.01)
fig, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(9, 6), layout="constrained")
for row, dof, style in zip(h, (0, 3), ("-", "--"), strict=True):
    above.semilogy(freq, abs(row), style, label=f"$H_{{{dof}0}}$")
above.set_ylabel("Accelerance (1/kg)")
above.legend()
below.semilogy(freq, abs(h[1] / h[0]), label="$T_{30} = H_{30} / H_{00}$")
for zero in case.model.antiresonances(0, 0):
    below.axvline(zero, color="0.7", lw=1, zorder=0)
below.set(xlabel="Frequency (Hz)", ylabel="Transmissibility (-)")
below.legend()

# %%
# One pair does not show all: near 58.5 Hz both responses have an antiresonance, and the quotient has no
# peak (third line). So all pairs are used together.
#
# In the measured quotients the peaks are the same for every numerator. Eq. 10 of the paper sums them up in
# one picture.
record = case.experiment(noise=0.01, duration_s=128.0, rng=0)
measured = ar.transmissibility(record, 0, nperseg=8192, estimator="rank1")
inside = (measured.freq_hz > 3) & (measured.freq_hz < 125)
fig, ax = plt.subplots(figsize=(9, 3.6), layout="constrained")
for row, dof in zip(measured.values[1:], measured.dofs[1:], strict=True):
    ax.semilogy(
        measured.freq_hz[inside],
        abs(row[inside]),
        lw=0.6,
        color="0.6",
        label="each $T_{p1}$" if dof == 1 else None,
    )
ax.semilogy(measured.freq_hz[inside], abs(ar.transmissibility_sum(measured)[inside]), label="sum, Eq. 10")
ax.set(xlabel="Frequency (Hz)", ylabel="Transmissibility (-)")
ax.legend(loc="lower left")
