"""PyDynamic: least-squares IIR filter to each FRF or its reciprocal, whose poles are the antiresonances."""

from __future__ import annotations

import numpy as np

from .method import Method, responses_to_force
from .rule import Rule


def lsiir(source, highest, estimator, nperseg=1024, reciprocal=True):
    """Numerator and denominator of equal order, without stabilisation by a delay, which would move the roots.

    Fits to the reciprocal (``inv=True``) have no false values at any length; found of 252: segments of 2 s
    240, 4 s 233, 8 s 227. The zeros of fits to the FRF itself: 242 with 57 false, 242 with 20, 238 with none.
    """
    from PyDynamic.model_estimation.fit_filter import LSIIR

    freq, frfs = responses_to_force(source, nperseg)
    rate_hz = 2.0 * source.high_hz
    sweeps = []
    for frf in frfs:
        orders = []
        for order in range(2, highest + 1):
            b, a, *_ = LSIIR(
                frf, order, order, freq, rate_hz, tau=0, verbose=False, max_stab_iter=0, inv=reciprocal
            )
            z = np.roots(a if reciprocal else b).astype(complex)
            orders.append(np.log(z[z != 0.0]) * rate_hz)
        sweeps.append(orders)
    return sweeps


#: Found less false of 168: 163, by the common rule 156.
OWN = Rule(freq_tol=0.003, damping_tol=0.05, more_rows_than=4)

METHODS = (
    Method(
        "PyDynamic LSIIR",
        "PyDynamic",
        "FRF, H1",
        "of the reciprocal, orders 2-60, segments of 2 s",
        lsiir,
        OWN,
    ),
)
