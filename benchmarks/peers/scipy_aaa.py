"""SciPy's AAA: adaptive barycentric interpolation of a single curve."""

from __future__ import annotations

import numpy as np

from .method import Method, transmissibilities
from .rule import Rule

SCALE_HZ = 100.0


def aaa(source, highest, estimator, nperseg=2048, step=2):
    """sum_p abs(T_pj)^2 as a real rational function of f^2; the number of terms is the order.

    Found less false of 252: 147 (107 with every number of terms: 127 false values); segments of 2 s 141. One
    call with a tolerance instead of the sweep finds 19 of 28 at best, with as many false ones.
    A pole pair of T at s and its mirror image at -conj(s) make a conjugate pair in (f / SCALE_HZ)^2.
    """
    from scipy.interpolate import AAA

    freq, tables = transmissibilities(source, nperseg, estimator, from_zero=False)
    sweeps = []
    for values in tables:
        x, y = (freq / SCALE_HZ) ** 2, np.sum(np.abs(values) ** 2, axis=0)
        orders = []
        for terms in range(2, highest + 1, step):
            poles = AAA(x, y, rtol=0.0, max_terms=terms + 1).poles()
            orders.append(2j * np.pi * SCALE_HZ * np.sqrt(poles[poles.imag > 0.0].astype(complex)))
        sweeps.append(orders)
    return sweeps


def aaa_complex(source, highest, estimator, nperseg=1024):
    """sum_p T_pj and its conjugate at -f; every second number of terms, for pairs."""
    from scipy.interpolate import AAA

    freq, tables = transmissibilities(source, nperseg, estimator, from_zero=False)
    s = 2j * np.pi * freq
    sweeps = []
    for values in tables:
        x, y = np.concatenate([s, -s]), values.sum(axis=0)
        y = np.concatenate([y, y.conj()])
        sweeps.append(
            [AAA(x, y, rtol=0.0, max_terms=terms + 1).poles() for terms in range(2, highest + 1, 2)]
        )
    return sweeps


#: Found less false of 168: 122 and 108, by the common rule 89 and 87.
OWN_COMPLEX = Rule(damping_tol=0.30, more_rows_than=15)
OWN_POWER = Rule(damping_tol=0.30, more_rows_than=15, max_damping=0.02)

METHODS = (
    Method(
        "SciPy AAA of sum T",
        "scipy",
        "T",
        "2-60 terms in steps of two, segments of 2 s",
        aaa_complex,
        OWN_COMPLEX,
    ),
    Method(
        "SciPy AAA of sum abs(T)^2",
        "scipy",
        "T",
        "2-60 terms in steps of two, segments of 4 s",
        aaa,
        OWN_POWER,
    ),
)
