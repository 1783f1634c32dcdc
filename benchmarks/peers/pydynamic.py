"""PyDynamic: least-squares IIR filter to each FRF; the zeros of the filter are the antiresonances."""

from __future__ import annotations

import numpy as np

from .method import HIGH_HZ, LOW_HZ, Method, responses_to_force


def lsiir(record, highest, estimator, nperseg=4096, reciprocal=False):
    """Numerator and denominator of equal order, without stabilisation by a delay, which moves the zeros."""
    from PyDynamic.model_estimation.fit_filter import LSIIR
    freq, frfs = responses_to_force(record, nperseg, low_hz=LOW_HZ)
    rate_hz = 2.0 * HIGH_HZ
    sweeps = []
    for frf in frfs:
        orders = []
        for order in range(2, highest + 1):
            b, a, *_ = LSIIR(frf, order, order, freq, rate_hz, tau=0, verbose=False, max_stab_iter=0,
                             inv=reciprocal)
            z = np.roots(a if reciprocal else b).astype(complex)
            orders.append(np.log(z[z != 0.0]) * rate_hz)
        sweeps.append(orders)
    return sweeps


METHODS = (Method("PyDynamic LSIIR", "PyDynamic", "H_j", "", lsiir),)
