"""
Four estimators at an antiresonance
===================================

At an antiresonance of the reference its channel is mostly noise. H1 has that noise in the denominator and
flattens the peak; H2 has the noise of the response in the numerator and fills the dip. Averaging does not
help, since both are biases. The dominant eigenvector of all channels, ``rank1``, has neither bias.
"""

import matplotlib.pyplot as plt
import numpy as np

import antires_rs as ar

case = ar.cases.chain8()
record = case.experiment(noise=0.05, duration_s=400.0, rng=3)
estimates = {
    name: ar.transmissibility(record, 0, nperseg=4096, estimator=name) for name in ("h1", "h2", "hv", "rank1")
}

# %%
# Left the second antiresonance of the reference, mass 0; right the second of the response, mass 2.
fig, axes = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
for ax, dof in zip(axes, (0, 2), strict=True):
    zero = case.model.antiresonances(dof, 0)[1]
    freq = np.linspace(zero - 3.0, zero + 3.0, 800)
    response, reference = case.model.frf([2, 0], 0, freq, damping_ratio=0.01)
    ax.semilogy(freq, abs(response / reference), "k", lw=3, alpha=0.4, label="without noise")
    for (name, t), style in zip(estimates.items(), ("o-", "s--", "^:", "D-."), strict=True):
        near = (t.freq_hz > freq[0]) & (t.freq_hz < freq[-1])
        ax.semilogy(t.freq_hz[near], abs(t.values[2, near]), style, ms=3, lw=1, label=name)
    ax.set(xlabel="Frequency (Hz)", ylabel="abs($T_{31}$) (-)")
axes[0].legend()
