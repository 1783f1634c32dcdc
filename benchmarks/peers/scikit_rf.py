"""scikit-rf: vector fitting of the transmissibilities as if they were scattering parameters."""

from __future__ import annotations

import numpy as np

from .method import Method, transmissibilities


def vector_fitting(source, highest, estimator, nperseg=2048, iterations=5, normed=True):
    """All T_pj of one j as entries of a three-port network, the two left over zero.

    Scaled to unit rms, because its weights depend on the level: one or two values more. Three relocations
    find one or two values fewer, ten no more.
    """
    import skrf
    from skrf.vectorFitting import VectorFitting

    freq, tables = transmissibilities(source, nperseg, estimator, from_zero=False)
    axis = skrf.Frequency.from_f(freq, unit="Hz")
    sweeps = []
    for values in tables:
        entries = np.zeros((9, freq.size), dtype=complex)
        rms = np.sqrt(np.mean(np.abs(values) ** 2, axis=1, keepdims=True))
        entries[: len(values)] = values / rms if normed else values
        network = skrf.Network(frequency=axis, s=entries.T.reshape(-1, 3, 3), z0=50.0)
        orders = []
        for pairs in range(1, highest // 2 + 1):
            fit = VectorFitting(network)
            fit.max_iterations = iterations
            fit.vector_fit(
                n_poles_real=0,
                n_poles_cmplx=pairs,
                fit_constant=True,
                fit_proportional=True,
                enforce_dc=False,
            )
            orders.append(fit.poles)
        sweeps.append(orders)
    return sweeps


METHODS = (
    Method(
        "scikit-rf vector fitting",
        "scikit-rf",
        "T",
        "1-30 pole pairs, 5 relocations each because more take minutes, segments of 4 s",
        vector_fitting,
        slow=True,
    ),
)
